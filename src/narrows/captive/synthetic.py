"""Synthetic tests from a known truth, to find out which coefficients a test programme determines."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, shown
from narrows.captive.settings import FORCE_NOISE
from narrows.captive.tests import CaptiveTests
from narrows.empirical.fleet import published
from narrows.model.model import Model
from narrows.model.sections import Source
from narrows.quantities.names import Number
from narrows.ship.motion import Motion

Columns = dict[str, np.ndarray]
COLUMNS = ("t", "x", "y", "psi", "u", "v", "r", "udot", "vdot", "rdot", "heave")


class TowedRun:
    name: str
    speed: float
    duration: float

    def columns(self, rate: float) -> Columns:
        """Return time, motion and accelerations at each sample, by the sampling ``rate`` [Hz]."""
        t = np.arange(round(self.duration * rate)) / rate
        motion = {"t": t, **self._motion(t)}
        return {name: motion.get(name, 0.0) + np.zeros(len(t)) for name in COLUMNS}

    def _motion(self, t: np.ndarray) -> dict[str, Number]:
        raise NotImplementedError

    def _check_positive(self, *names: str) -> None:
        for name in names:
            if not getattr(self, name) > 0:
                raise InputError(f"run {self.name}: {name} = {getattr(self, name)} must be positive")


@accept_aliases
@dataclass(frozen=True)
class HarmonicRun(TowedRun):
    """A harmonic captive test at constant speed.

    Raises an InputError if the kind is unknown, a number is not positive, or a yaw path is steeper than the speed
    allows.

    >>> nw.HarmonicRun("A", "yaw", 0.4, 12.0, 1.0, 1).period
    12.0
    """

    name: str  #: Name of the test
    kind: str  #: ``yaw``: along a sinusoidal path without drift; ``sway``: sideways without yaw
    amplitude: float  #: Amplitude of y [m]
    period: float  #: Duration of one cycle [s]
    speed: float = 1.0  #: Surge velocity [m/s]
    cycles: int = 6  #: Number of cycles
    offset: float = 0.0  #: Offset of the path's mean line to starboard of the centreline [m]
    depth: float | None = None  #: Depth of the water [m]; the canal's own unless given

    def __post_init__(self) -> None:
        if self.kind not in ("yaw", "sway"):
            raise InputError(f"run {self.name}: kind {self.kind!r} is unknown; choose yaw or sway")
        self._check_positive("amplitude", "period", "speed", "cycles")
        if self.kind == "yaw" and self.amplitude * 2 * np.pi / self.period >= self.speed:
            raise InputError(f"run {self.name}: too steep for {self.speed} m/s; lengthen the period")

    @property
    def duration(self) -> float:  # type: ignore[override]
        """Duration [s]."""
        return self.cycles * self.period

    def _motion(self, t: np.ndarray) -> dict[str, Number]:
        w, a, speed = 2 * np.pi / self.period, self.amplitude, self.speed
        y = self.offset + a * np.sin(w * t)
        if self.kind == "sway":
            return {"x": speed * t, "y": y, "u": speed, "v": a * w * np.cos(w * t), "vdot": -a * w * w * np.sin(w * t)}
        # y = A sin wt along the ship's own path: sin psi = y'/U, so that v = 0 exactly. Derivatives of the sine: each
        # leads the one before by a quarter of a period.
        slope, bend, jerk = (a * w**n / speed * np.sin(w * t + n * np.pi / 2) for n in (1, 2, 3))
        cosine = np.sqrt(1 - slope**2)
        x = np.concatenate([[0.0], np.cumsum(speed * (cosine[1:] + cosine[:-1]) / 2 * np.diff(t))])
        rdot = jerk / cosine + slope * bend**2 / cosine**3
        return {"x": x, "y": y, "psi": np.arcsin(slope), "u": speed, "r": bend / cosine, "rdot": rdot}


@accept_aliases
@dataclass(frozen=True)
class StraightRun(TowedRun):
    """A straight captive test at constant speed, parallel to the banks.

    Raises an InputError if speed or duration are not positive, or it is towed sideways.

    >>> nw.StraightRun("A", 0.5).offset
    0.5
    """

    name: str  #: Name of the test
    offset: float  #: Offset to starboard of the centreline [m]
    speed: float = 1.0  #: Speed along the canal [m/s]
    duration: float = 40.0  #: Duration [s]
    #: Angle from the path to the bow [rad], positive to starboard; equal to the heading, as the path is along the canal
    drift: float = 0.0
    depth: float | None = None  #: Depth of the water [m]; the canal's own unless given

    def __post_init__(self) -> None:
        self._check_positive("speed", "duration")
        if not abs(self.drift) < np.pi / 2:
            raise InputError(f"run {self.name}: drift = {self.drift} is not an angle below pi/2; give it in radians")

    def _motion(self, t: np.ndarray) -> dict[str, Number]:
        u, v = self.speed * np.cos(self.drift), -self.speed * np.sin(self.drift)
        return {"x": self.speed * t, "y": self.offset, "psi": self.drift, "u": u, "v": v}


# A run for twins and designs.
Run = HarmonicRun | StraightRun

# Kinds, number and largest offset as in the paper; it prints neither periods nor speeds, so those are assumptions.
PAPER_RUNS = (
    HarmonicRun("A", "yaw", 0.907, 25.0),
    HarmonicRun("B", "yaw", 0.30, 12.0),
    HarmonicRun("C", "sway", 0.907, 25.0),
)


@accept_aliases
def twin(
    truth: Model | None = None,
    runs: Sequence[Run] = PAPER_RUNS,
    noise: Mapping[str, float] = FORCE_NOISE,
    correlation_time: float = 0.0,
    rate: float = 20.0,
    seed: int = 0,
) -> CaptiveTests:
    """Run synthetic captive tests on a known model: its forces with added noise.

    Raises an InputError if there are no runs, or they are sampled too slowly.

    Parameters
    ----------
    truth : Model, optional
        The published DTC model unless given.
    runs : sequence of HarmonicRun or StraightRun
        The tests.
    noise : mapping of str to float [N, N, N m]
        Standard deviation of each force; default 0.
    correlation_time : float [s]
        Correlation time of the noise, a first-order autoregression; 0 for white noise.
    rate : float [Hz]
        Sampling rate.
    seed : int
        Seed of the noise.

    Examples
    --------
    >>> twin = nw.twin(model, noise={}, rate=2.0)
    >>> twin.rows > 100
    True
    """
    if not runs or not min(run.duration for run in runs) * rate >= 2:
        raise InputError("the runs hold fewer than two rows; give a run, or sample faster")
    truth = truth or published("mikkelsen2025_dtc")
    if not isinstance(truth, Model):
        raise InputError(f"truth = {shown(truth)} is no model; give the ship first, and runs by name: runs=[...]")
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


def _measured(
    truth: Model, run: Run, noise: Mapping[str, float], correlation_time: float, rate: float,
    draw: np.random.Generator,
) -> dict[str, np.ndarray]:  # fmt: skip
    columns = run.columns(rate)
    motion, rows = Motion.at(**{name: column for name, column in columns.items() if name != "t"}), len(columns["t"])
    keep = np.exp(-1 / (rate * correlation_time)) if correlation_time > 0 else 0.0
    at_depth = truth if run.depth is None else truth.with_canal(depth=run.depth)
    forces = {
        force: value + noise.get(force, 0.0) * _coloured(draw.standard_normal(rows), keep)
        for force, value in at_depth.forces(motion).items()
    }
    depth = run.depth or truth.configuration.canal.depth
    return columns | motion.values() | forces | ({"depth": np.full(rows, depth)} if depth else {})


def _coloured(white: np.ndarray, keep: float) -> np.ndarray:
    # The first row has the same distribution as the others: it is white[0] itself.
    gain = np.sqrt(1 - keep**2)
    return np.array(list(accumulate(white[1:].tolist(), lambda last, new: keep * last + gain * new, initial=white[0])))
