"""A table of captive tests from disk to checked columns, as CSV and as Parquet, and on to a fit.

    python benchmarks/tables.py [ROWS] [--small]

The peer is pandas alone, which reads the same file and checks nothing.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
from common import median_seconds, show, sizes

import narrows as nw
from narrows.identification.fitting import identify

TESTS = 40


def table(rows: int) -> tuple[pd.DataFrame, nw.Configuration]:
    """Harmonic runs of the published model, with noise, in the documented columns."""
    kinds = ("yaw", "sway")
    runs = tuple(
        nw.HarmonicRun(f"T{i:02d}", kinds[i % 2], 0.3 + 0.01 * i, 25.0, (0.7, 1.0)[i % 3 > 0], 1) for i in range(TESTS)
    )
    tests = nw.twin(runs=runs, rate=rows / (TESTS * 25.0))
    columns = {name: column for name, column in tests.columns.items() if name not in ("cos_psi", "sin_psi")}
    return pd.DataFrame({"test": np.repeat(tests.names, np.diff(tests.starts)), **columns}), tests.configuration


def main(rows: int, runs: int) -> None:
    """Measure and print."""
    frame, ship = table(rows)
    with tempfile.TemporaryDirectory() as folder:
        paths = {suffix: Path(folder, f"t{suffix}") for suffix in (".csv", ".parquet")}
        frame.to_csv(paths[".csv"], index=False)
        frame.to_parquet(paths[".parquet"], index=False)
        read: dict[str, Callable[[Path], pd.DataFrame]] = {".csv": pd.read_csv, ".parquet": pd.read_parquet}
        measured = []
        for suffix, path in paths.items():
            work: list[tuple[str, Callable[[], object]]] = [
                (f"read_captive {suffix}", lambda path=path: nw.read_captive(path, ship)),
                (f"read_captive and identify {suffix}", lambda path=path: identify(nw.read_captive(path, ship))),
                (f"pandas alone {suffix}", lambda path=path, suffix=suffix: read[suffix](path)),
            ]
            measured += [(name, median_seconds(act, runs), "") for name, act in work]
    show(f"tables of {len(frame):.2g} rows and {len(frame.columns)} columns", measured, "s", 1)


if __name__ == "__main__":
    size, small = sizes(__doc__, usual=1e6, small=2000)
    main(size, runs=1 if small else 3)
