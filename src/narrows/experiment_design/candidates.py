"""Candidate runs: harmonic sway and yaw, on the centreline and off it, and straight runs."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from narrows.captive.synthetic import HarmonicRun, Run, StraightRun
from narrows.errors import InputError
from narrows.ship.particulars import Configuration, Ship, half_swept

# Default speeds over the root of g L: slow ships, as in canals.
FROUDE = (0.08, 0.12, 0.16)
# Offsets and amplitudes as shares of the distance between hull and wall.
OFFSETS, AMPLITUDES = (0.0, 0.35, 0.7), (0.3, 0.6, 1.0)
CYCLES = (2, 3, 5)
STRAIGHT_DRIFTS = (0.0, 6.0)
# Starboard and port: each run off the centreline may be mirrored.
SIDES = (1, -1)
SAMPLES = 100
# Default share of the distance that the clearance leaves.
UNASKED = 0.75
# Steady motion of a run over the ship's length; and a limit above any tank's data, in SI.
RUN_LENGTHS, MOST = 10.0, 1e5
# Largest speed over the root of g L of a ship in a canal; largest number of samples in a run.
MOST_FROUDE, MOST_SAMPLES = 0.4, 100_000


@dataclass(frozen=True)
class Tank:
    """Limits of a towing tank.

    Parameters
    ----------
    run_length : float [m], optional
        Steady motion in one run; ten ship lengths unless given.
    clearance : float [1]
        Least distance from the hull's side to a wall, over the beam: closer to it, every form of the bank term is
        uncertain.
    heading : float [deg]
        Largest heading in a yaw test, and drift angle in a sway test.
    speeds : sequence of float [m/s]
        Speeds of runs; three slow ones by the ship's length unless given.
    depths : sequence of float [m]
        Depths of runs; the canal's own unless given.
    reach : float, optional
        Largest offset of midship from the centreline [m]; default: three quarters of the limit by the clearance, since
        every form of the bank errs most close to a wall.

    Raises
    ------
    InputError
        If a number is not positive.

    Examples
    --------
    >>> nw.Tank(speeds=(0.6, 0.8)).speeds
    (0.6, 0.8)
    """

    run_length: float | None = None
    clearance: float = 1.5
    heading: float = 25.0
    speeds: Sequence[float] = ()
    depths: Sequence[float] = ()
    reach: float | None = None

    def __post_init__(self) -> None:
        numbers = {"run_length": self.run_length, "clearance": self.clearance, "heading": self.heading}
        for name, values in {**numbers, "speeds": self.speeds, "depths": self.depths, "reach": self.reach}.items():
            for value in () if values is None else np.ravel(values):
                if not 0 < value < MOST:
                    raise InputError(f"tank: {name} = {value} must be positive, and of a tank's size")

    def length_for(self, configuration: Configuration) -> float:
        """Return the length of steady motion in a run [m].

        Parameters
        ----------
        configuration : Configuration
            Configuration with the ship's length.
        """
        return RUN_LENGTHS * configuration.ship.length if self.run_length is None else self.run_length


def candidates(configuration: Configuration, tank: Tank) -> list[Run]:
    """List the runs that fit between the walls and into the length of a tank."""
    ship, length = configuration.ship, tank.length_for(configuration)
    clear = configuration.canal.width / 2 - ship.beam * (0.5 + tank.clearance)
    room = UNASKED * clear if tank.reach is None else min(clear, tank.reach)
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
    for speed, depth in product(tank.speeds or [round(f * wave, 3) for f in FROUDE], tank.depths or (None,)):
        runs += [*_straight(room, length, speed, depth), *_harmonic(room, length, tank.heading, speed, depth)]
    limit = configuration.canal.width / 2 - tank.clearance * ship.beam + 1e-9
    return [run for run in runs if _reach(run, ship) <= limit]


def _straight(room: float, length: float, speed: float, depth: float | None) -> Iterator[Run]:
    for share, side, drift in product((0.0, 0.25, 0.5, 0.75, 1.0), SIDES, STRAIGHT_DRIFTS):
        offset, drift = side * round(share * room, 3), side * drift + 0.0  # Never -0
        if (share or drift) and (share or side > 0):
            name = f"straight y={offset:g} drift={drift:g} u={speed:g}{_at(depth)}"
            yield StraightRun(name, offset, speed, length / speed, float(np.radians(drift)), depth)


def _harmonic(room: float, length: float, heading: float, speed: float, depth: float | None) -> Iterator[Run]:
    for kind, offset_share, side, share, cycles in product(("yaw", "sway"), OFFSETS, SIDES, AMPLITUDES, CYCLES):
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
    """Largest distance of the hull's corners from the centreline."""
    columns = run.columns(SAMPLES / run.duration)
    return float((np.abs(columns["y"]) + half_swept(ship, columns["psi"])).max())
