"""Synthetic tests from a known truth: what a tank would have measured, to see what its tests can pin down."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from narrows.captive.runs import HarmonicRun, Run
from narrows.captive.tests import CaptiveTests
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.model.model_file import published
from narrows.model.source import Source
from narrows.ship.motion import Motion

# Standard deviation of the measured forces [N, N, N m]: middle of what FHR reports for harmonic tests.
NOISE = {"X": 0.35, "Y": 0.5, "N": 0.65}


# Kinds, number and largest offset as in the paper; it prints neither periods nor speeds, so those are ours.
PAPER_RUNS = (
    HarmonicRun("A", "yaw", 0.907, 25.0),
    HarmonicRun("B", "yaw", 0.30, 12.0),
    HarmonicRun("C", "sway", 0.907, 25.0),
)


def twin(
    truth: Model | None = None,
    runs: Sequence[Run] = PAPER_RUNS,
    noise: Mapping[str, float] = NOISE,
    correlation_time: float = 0.0,
    rate: float = 20.0,
    seed: int = 0,
) -> CaptiveTests:
    """Run synthetic captive tests on a known model.

    Parameters
    ----------
    truth : Model, optional
        The published DTC model unless given.
    runs : sequence of HarmonicRun or StraightRun
        The tests.
    noise : mapping of str to float [N, N, N m]
        Standard deviation of each force; 0 where it is not given.
    correlation_time : float [s]
        Of the noise, which is a first-order autoregression; 0 for white noise.
    rate : float [Hz]
        Of sampling.
    seed : int
        Of the noise.

    Returns
    -------
    CaptiveTests
        With the truth's forces and the noise on them.

    Raises
    ------
    InputError
        Where there are no runs, or they are sampled too slowly.
    """
    if not runs or not min(run.duration for run in runs) * rate >= 2:
        raise InputError("the runs hold fewer than two rows; give a run, or sample faster")
    truth = truth or published("mikkelsen2025_dtc")
    draw = np.random.default_rng(seed)
    parts = [_measured(truth, run, noise, correlation_time, rate, draw) for run in runs]
    lengths = [len(part["t"]) for part in parts]
    return CaptiveTests(
        columns={name: np.concatenate([part[name] for part in parts]) for name in parts[0]},
        names=tuple(run.name for run in runs),
        starts=np.concatenate([[0], np.cumsum(lengths)]),
        configuration=truth.configuration,
        source=Source(f"synthetic tests, seed {seed}, of: {truth.source.text}"),
    )


def motion_of(columns: Mapping[str, np.ndarray]) -> Motion:
    """Return the motion in the columns of a run."""
    known = {name: column for name, column in columns.items() if name not in ("t", "psi")}
    return Motion(**known, cos_psi=np.cos(columns["psi"]), sin_psi=np.sin(columns["psi"]))


def _measured(
    truth: Model, run: Run, noise: Mapping[str, float], correlation_time: float, rate: float,
    draw: np.random.Generator,
) -> dict[str, np.ndarray]:  # fmt: skip
    columns = run.columns(rate)
    motion, rows = motion_of(columns), len(columns["t"])
    keep = np.exp(-1 / (rate * correlation_time)) if correlation_time > 0 else 0.0
    forces = {
        force: value + noise.get(force, 0.0) * _coloured(draw.standard_normal(rows), keep)
        for force, value in _at_depth(truth, run.depth).forces(motion).items()
    }
    depth = run.depth or truth.configuration.canal.depth
    return columns | motion.values() | forces | ({"depth": np.full(rows, depth)} if depth else {})


def _at_depth(truth: Model, depth: float | None) -> Model:
    if depth is None:
        return truth
    return replace(
        truth, configuration=replace(truth.configuration, canal=replace(truth.configuration.canal, depth=depth))
    )


def _coloured(white: np.ndarray, keep: float) -> np.ndarray:
    from scipy.signal import lfilter

    if keep == 0:
        return white
    gain = np.sqrt(1 - keep**2)
    # The first row is drawn from the same distribution as the others: it is white[0] itself.
    return np.asarray(lfilter([gain], [1, -keep], white, zi=[(1 - gain) * white[0]])[0])
