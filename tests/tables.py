"""Tables of captive tests on disk, for tests that read them."""

from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

import narrows as nw

DTC_SHIP = """
[ship]
name = "DTC 1:89.11"
length = 3.984
beam = 0.572
draft = 0.163
block_coefficient = 0.661

[water]
density = 1000.0

[canal]
width = 7.0
"""
"""A ship file, as a user writes it."""

SHORT_RUNS = (
    nw.HarmonicRun("slow yaw", "yaw", 0.9, 25.0, 0.8, 1),
    nw.HarmonicRun("yaw", "yaw", 0.4, 12.0, 1.0, 2),
    nw.HarmonicRun("sway", "sway", 0.9, 25.0, 1.0, 1),
    nw.HarmonicRun("fast sway", "sway", 0.5, 15.0, 1.2, 1),
)
"""Tests of two kinds and three speeds, few rows."""


@cache
def short_twin(seed: int = 0, runs: tuple[nw.HarmonicRun, ...] = SHORT_RUNS) -> nw.CaptiveTests:
    """Return some 500 rows of the published model with noise."""
    return nw.twin(runs=runs, rate=5.0, seed=seed)


def many_runs(count: int = 12) -> tuple[nw.HarmonicRun, ...]:
    """Return enough runs for standard errors to be clustered by test."""
    kinds = ("yaw", "sway")
    return tuple(
        nw.HarmonicRun(f"T{i:02d}", kinds[i % 2], 0.3 + 0.05 * i, 15.0 + i, (0.7, 1.0, 1.1)[i % 3], 1)
        for i in range(count)
    )


def frame_of(tests: nw.CaptiveTests) -> pd.DataFrame:
    """Return tests in the documented columns, SI and radians."""
    columns = {name: column for name, column in tests.columns.items() if name not in ("cos_psi", "sin_psi")}
    return pd.DataFrame({"test": np.repeat(tests.names, np.diff(tests.starts)), **columns})


def written(frame: pd.DataFrame, path: Path) -> Path:
    """Write a frame as CSV or Parquet by the suffix; numbers keep every bit."""
    if path.suffix == ".csv":
        frame.to_csv(path, index=False)
    else:
        frame.to_parquet(path, index=False)
    return path
