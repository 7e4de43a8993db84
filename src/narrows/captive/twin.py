"""Synthetic tests from a known truth: what a tank would have measured, to see what its tests can pin down."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from narrows.captive.tests import CaptiveTests
from narrows.errors import InputError
from narrows.model import Model, Source
from narrows.model_file import published
from narrows.motion import Motion

NOISE = {"X": 0.35, "Y": 0.5, "N": 0.65}
"""Standard deviation of the measured forces [N, N, N m]: middle of what FHR reports for harmonic tests."""


@dataclass(frozen=True)
class HarmonicRun:
    """A harmonic captive test at constant speed.

    Parameters
    ----------
    name : str
        Of the test.
    kind : str
        ``yaw``: along a sinusoidal path without drift; ``sway``: sideways without yaw.
    amplitude : float [m]
        Of y.
    period : float [s]
        Of one cycle.
    speed : float [m/s]
        Surge velocity.
    cycles : int
        How many.

    Raises
    ------
    InputError
        Where the kind is unknown, a number is not positive, or a yaw path is steeper than the speed allows.
    """

    name: str
    kind: str
    amplitude: float
    period: float
    speed: float = 1.0
    cycles: int = 6

    def __post_init__(self) -> None:
        if self.kind not in ("yaw", "sway"):
            raise InputError(f"run {self.name}: kind {self.kind!r} is unknown; choose yaw or sway")
        for name in ("amplitude", "period", "speed", "cycles"):
            if not getattr(self, name) > 0:
                raise InputError(f"run {self.name}: {name} = {getattr(self, name)} must be positive")
        if self.kind == "yaw" and self.amplitude * 2 * np.pi / self.period >= self.speed:
            raise InputError(f"run {self.name}: too steep for {self.speed} m/s; lengthen the period")


PAPER_RUNS = (
    HarmonicRun("A", "yaw", 0.907, 25.0),
    HarmonicRun("B", "yaw", 0.30, 12.0),
    HarmonicRun("C", "sway", 0.907, 25.0),
)
"""Kinds, number and largest offset as in the paper; it prints neither periods nor speeds, so those are ours."""


def twin(
    truth: Model | None = None,
    runs: tuple[HarmonicRun, ...] = PAPER_RUNS,
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
    runs : tuple of HarmonicRun
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
    if not runs or not min(run.cycles * run.period for run in runs) * rate >= 2:
        raise InputError("the runs hold fewer than two rows; give a run, or sample faster")
    truth = truth or published("mikkelsen2025_dtc")
    draw = np.random.default_rng(seed)
    parts = [_measured(truth, run, noise, correlation_time, rate, draw) for run in runs]
    lengths = [len(part["t"]) for part in parts]
    return CaptiveTests(
        columns={name: np.concatenate([part[name] for part in parts]) for name in parts[0]},
        names=tuple(run.name for run in runs),
        starts=np.concatenate([[0], np.cumsum(lengths)]),
        setting=truth.setting,
        source=Source(f"synthetic tests, seed {seed}, of: {truth.source.text}"),
    )


def _measured(
    truth: Model, run: HarmonicRun, noise: Mapping[str, float], correlation_time: float, rate: float,
    draw: np.random.Generator,
) -> dict[str, np.ndarray]:  # fmt: skip
    t = np.arange(round(run.cycles * run.period * rate)) / rate
    columns = _yaw(run, t) if run.kind == "yaw" else _sway(run, t)
    columns |= {"cos_psi": np.cos(columns["psi"]), "sin_psi": np.sin(columns["psi"])}
    motion = Motion(**{name: column for name, column in columns.items() if name not in ("t", "psi")})
    keep = np.exp(-1 / (rate * correlation_time)) if correlation_time > 0 else 0.0
    forces = {
        force: value + noise.get(force, 0.0) * _coloured(draw.standard_normal(len(t)), keep)
        for force, value in truth.forces(motion).items()
    }
    return columns | forces


def _yaw(run: HarmonicRun, t: np.ndarray) -> dict[str, np.ndarray]:
    """y = A sin wt along the ship's own path: sin psi = y'/U, so that v = 0 exactly."""
    w, a, speed = 2 * np.pi / run.period, run.amplitude, np.full(len(t), run.speed)
    slope, bend, jerk = (a * w**n / run.speed * _wave(w * t, n) for n in (1, 2, 3))
    cosine = np.sqrt(1 - slope**2)
    psi, r = np.arcsin(slope), bend / cosine
    rdot = jerk / cosine + slope * bend**2 / cosine**3
    x = np.concatenate([[0.0], np.cumsum(run.speed * (cosine[1:] + cosine[:-1]) / 2 * np.diff(t))])
    zero = np.zeros(len(t))
    return {
        "t": t, "x": x, "y": a * np.sin(w * t), "psi": psi, "u": speed, "v": zero, "r": r,
        "udot": zero, "vdot": zero, "rdot": rdot, "heave": zero,
    }  # fmt: skip


def _sway(run: HarmonicRun, t: np.ndarray) -> dict[str, np.ndarray]:
    w, a, zero = 2 * np.pi / run.period, run.amplitude, np.zeros(len(t))
    return {
        "t": t, "x": run.speed * t, "y": a * np.sin(w * t), "psi": zero, "u": np.full(len(t), run.speed),
        "v": a * w * np.cos(w * t), "r": zero, "udot": zero, "vdot": -a * w * w * np.sin(w * t),
        "rdot": zero, "heave": zero,
    }  # fmt: skip


def _wave(phase: np.ndarray, derivative: int) -> np.ndarray:
    """The n-th derivative of the sine."""
    return np.asarray(np.sin(phase + derivative * np.pi / 2))


def _coloured(white: np.ndarray, keep: float) -> np.ndarray:
    from scipy.signal import lfilter

    if keep == 0:
        return white
    gain = np.sqrt(1 - keep**2)
    # The first row is drawn from the same distribution as the others: it is white[0] itself.
    return np.asarray(lfilter([gain], [1, -keep], white, zi=[(1 - gain) * white[0]])[0])
