"""Runs of a towing tank, and synthetic tests of them from a known truth."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, product
from typing import Any

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
from narrows.ship.particulars import Configuration, Ship, half_swept

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
    noise: Mapping[str, float] | float = FORCE_NOISE,
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
    noise : mapping of str to float [N, N, N m], or float [1]
        Standard deviation of each force; 0 of one that is not named. A number is a share of the force's root mean
        square in the run.
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
    keep = np.exp(-1 / (rate * correlation_time)) if correlation_time > 0 else 0.0
    parts = []
    for run in runs:
        columns = run.columns(rate)
        motion = Motion.at(**{name: column for name, column in columns.items() if name != "t"})
        at_depth, rows = truth if run.depth is None else truth.with_canal(depth=run.depth), len(columns["t"])
        forces = {
            force: value + _size_of(noise, force, value) * _coloured(draw.standard_normal(rows), keep)
            for force, value in at_depth.forces(motion).items()
        }
        depth = at_depth.configuration.canal.depth
        parts.append(columns | motion.values() | forces | ({"depth": np.full(rows, depth)} if depth else {}))
    lengths = [len(part["t"]) for part in parts]
    return CaptiveTests(
        columns={name: np.concatenate([part[name] for part in parts]) for name in parts[0]},
        names=tuple(run.name for run in runs),
        starts=np.concatenate([[0], np.cumsum(lengths)]),
        configuration=truth.configuration,
        source=Source(f"synthetic tests, seed {seed}, of: {truth.source.text}"),
    )


def _size_of(noise: Mapping[str, float] | float, force: str, values: Any) -> float:
    if isinstance(noise, Mapping):
        return noise.get(force, 0.0)
    return noise * float(np.sqrt(np.mean(np.square(values))))


def _coloured(white: np.ndarray, keep: float) -> np.ndarray:
    # The first row has the same distribution as the others: it is white[0] itself.
    gain = np.sqrt(1 - keep**2)
    return np.array(list(accumulate(white[1:].tolist(), lambda last, new: keep * last + gain * new, initial=white[0])))


# Offsets and amplitudes as shares of the distance between hull and wall.
OFFSETS, AMPLITUDES = (0.0, 0.35, 0.7), (0.3, 0.6, 1.0)
# Starboard and port: each run off the centreline may be mirrored.
SIDES = (1, -1)
# Steady motion of a run over the ship's length; and a limit above any tank's data, in SI.
RUN_LENGTHS, MOST = 10.0, 1e5
# Largest speed over the root of g L of a ship in a canal; largest number of samples in a run.
MOST_FROUDE, MOST_SAMPLES = 0.4, 100_000


@accept_aliases
@dataclass(frozen=True)
class Tank:
    """Limits of a towing tank.

    Raises an InputError if a number is not positive.

    >>> nw.Tank(speeds=(0.6, 0.8)).speeds
    (0.6, 0.8)
    """

    run_length: float | None = None  #: Steady motion in one run [m]; ten ship lengths unless given
    #: Least distance from the hull's side to a wall [1], over the beam: closer to it, every form of the bank term is
    #: uncertain
    clearance: float = 1.5
    heading: float = 25.0  #: Largest heading in a yaw test [deg], and drift angle in a sway test
    speeds: Sequence[float] = ()  #: Speeds of runs [m/s]; three slow ones by the ship's length unless given
    depths: Sequence[float] = ()  #: Depths of runs [m]; the canal's own unless given
    #: Largest offset of midship from the centreline [m]; default: three quarters of the limit by the clearance, since
    #: every form of the bank errs most close to a wall
    reach: float | None = None

    def __post_init__(self) -> None:
        for name, values in vars(self).items():
            for value in () if values is None else np.ravel(values):
                if not 0 < value < MOST:
                    raise InputError(f"tank: {name} = {value} must be positive, and of a tank's size")

    def length_for(self, configuration: Configuration) -> float:
        """Return the length of steady motion in a run [m], for the ship of a ``configuration``."""
        return RUN_LENGTHS * configuration.ship.length if self.run_length is None else self.run_length


def candidates(configuration: Configuration, tank: Tank) -> list[Run]:
    """List the runs that fit between the walls and into the length of a tank."""
    ship, length = configuration.ship, tank.length_for(configuration)
    clear = configuration.canal.width / 2 - ship.beam * (0.5 + tank.clearance)
    room = 0.75 * clear if tank.reach is None else min(clear, tank.reach)
    if room <= 0:
        raise InputError("no run fits between the walls of this tank; check the ship file, or ask for less clearance")
    dry = [depth for depth in tank.depths if depth <= ship.draft]
    if dry:
        raise InputError(f"a depth of {dry[0]} m leaves no water under a draft of {ship.draft} m; raise it")
    wave = (9.81 * ship.length) ** 0.5
    for speed in tank.speeds:
        if speed > MOST_FROUDE * wave or length / speed > MOST_SAMPLES:
            raise InputError(f"{speed:g} m/s is no speed for a ship {ship.length:g} m long in a tank; check it")
    runs = []
    slow = [round(froude * wave, 3) for froude in (0.08, 0.12, 0.16)]  # As in canals
    for speed, depth in product(tank.speeds or slow, tank.depths or (None,)):
        runs += [*_straight(room, length, speed, depth), *_harmonic(room, length, tank.heading, speed, depth)]
    limit = configuration.canal.width / 2 - tank.clearance * ship.beam + 1e-9
    return [run for run in runs if _reach(run, ship) <= limit]


def _straight(room: float, length: float, speed: float, depth: float | None) -> Iterator[Run]:
    for share, side, drift in product((0.0, 0.25, 0.5, 0.75, 1.0), SIDES, (0.0, 6.0)):
        offset, drift = side * round(share * room, 3), side * drift + 0.0  # Never -0
        if (share or drift) and (share or side > 0):
            name = f"straight y={offset:g} drift={drift:g} u={speed:g}{_at(depth)}"
            yield StraightRun(name, offset, speed, length / speed, float(np.radians(drift)), depth)


def _harmonic(room: float, length: float, heading: float, speed: float, depth: float | None) -> Iterator[Run]:
    for kind, offset_share, side, share, cycles in product(("yaw", "sway"), OFFSETS, SIDES, AMPLITUDES, (2, 3, 5)):
        offset = side * round(offset_share * room, 3)
        amplitude, period = round(share * (room - abs(offset)), 3), round(length / speed / cycles, 2)
        # Path angle at the centre crossing: a yaw run moves along its heading (sine), a sway run drifts (tangent).
        steepest = speed * (np.sin if kind == "yaw" else np.tan)(np.radians(heading))
        if (offset or side > 0) and 0 < amplitude * 2 * np.pi / period < steepest:
            name = f"{kind} A={amplitude:g} y={offset:g} T={period:g} u={speed:g}{_at(depth)}"
            yield HarmonicRun(name, kind, amplitude, period, speed, cycles, offset, depth)


def _at(depth: float | None) -> str:
    return "" if depth is None else f" h={depth:g}"


def _reach(run: Run, ship: Ship) -> float:
    columns = run.columns(100 / run.duration)
    return float((np.abs(columns["y"]) + half_swept(ship, columns["psi"])).max())
