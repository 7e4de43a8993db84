"""Candidate runs: harmonic sway and yaw, on the centreline and off it, and straight runs."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from narrows.captive.synthetic import HarmonicRun, Run, StraightRun
from narrows.errors import InputError
from narrows.ship.particulars import Configuration, half_swept

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
        length = 1.0 if self.run_length is None else self.run_length
        named = {"run_length": length, "clearance": self.clearance, "heading": self.heading}
        for name, value in (
            *named.items(),
            *(("speeds", u) for u in self.speeds),
            *(("depths", h) for h in self.depths),
            ("reach", 1.0 if self.reach is None else self.reach),
        ):
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
    if _room(configuration, tank) <= 0:
        raise InputError("no run fits between the walls of this tank; check the ship file, or ask for less clearance")
    for depth in tank.depths:
        if depth <= configuration.ship.draft:
            raise InputError(
                f"a depth of {depth} m leaves no water under a draft of {configuration.ship.draft} m; raise it"
            )
    for speed in tank.speeds:
        if (
            speed > MOST_FROUDE * (9.81 * configuration.ship.length) ** 0.5
            or tank.length_for(configuration) / speed > MOST_SAMPLES
        ):
            raise InputError(
                f"{speed:g} m/s is no speed for a ship {configuration.ship.length:g} m long in a tank; check it"
            )
    speeds = tank.speeds or [round(f * float(np.sqrt(9.81 * configuration.ship.length)), 3) for f in FROUDE]
    return [
        run
        for speed, depth in product(speeds, tank.depths or (None,))
        for run in (*_straight(configuration, tank, speed, depth), *_harmonic(configuration, tank, speed, depth))
        if _fits(run, configuration, tank)
    ]


def _room(configuration: Configuration, tank: Tank) -> float:
    clear = configuration.canal.width / 2 - configuration.ship.beam * (0.5 + tank.clearance)
    return UNASKED * clear if tank.reach is None else min(clear, tank.reach)


def _straight(configuration: Configuration, tank: Tank, speed: float, depth: float | None) -> Iterator[Run]:
    shares = (0.0, 0.25, 0.5, 0.75, 1.0)
    for share, side, drift in product(shares, SIDES, STRAIGHT_DRIFTS):
        offset, drift = side * round(share * _room(configuration, tank), 3), side * drift + 0.0  # Never -0
        if (share or drift) and (share or side > 0):
            name = f"straight y={offset:g} drift={drift:g} u={speed:g}{_at(depth)}"
            yield StraightRun(
                name, offset, speed, tank.length_for(configuration) / speed, float(np.radians(drift)), depth
            )


def _harmonic(configuration: Configuration, tank: Tank, speed: float, depth: float | None) -> Iterator[Run]:
    for kind, offset_share, side, share, cycles in product(("yaw", "sway"), OFFSETS, SIDES, AMPLITUDES, CYCLES):
        room = _room(configuration, tank)
        offset = side * round(offset_share * room, 3)
        if not offset and side < 0:
            continue
        amplitude = round(share * (room - abs(offset)), 3)
        period = round(tank.length_for(configuration) / speed / cycles, 2)
        # Path angle at the centre crossing: a yaw run moves along its heading (sine), a sway run drifts (tangent).
        steep = np.sin if kind == "yaw" else np.tan
        if not 0 < amplitude * 2 * np.pi / period < speed * steep(np.radians(tank.heading)):
            continue
        name = f"{kind} A={amplitude:g} y={offset:g} T={period:g} u={speed:g}{_at(depth)}"
        yield HarmonicRun(name, kind, amplitude, period, speed, cycles, offset, depth)


def _at(depth: float | None) -> str:
    return "" if depth is None else f" h={depth:g}"


def _fits(run: Run, configuration: Configuration, tank: Tank) -> bool:
    """Return whether the corners of the hull stay clear of the walls."""
    columns = run.columns(SAMPLES / run.duration)
    ship = configuration.ship
    reach = np.abs(columns["y"]) + half_swept(ship, columns["psi"])
    return bool((reach <= configuration.canal.width / 2 - tank.clearance * ship.beam + 1e-9).all())
