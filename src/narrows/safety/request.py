"""Inputs of a safe envelope: ship, offsets, speeds, disturbances, reserves."""

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.results import Aliased
from narrows.model.model import Model
from narrows.model.water import choke_speed, squat
from narrows.quantities.names import AIR_DENSITY, Number
from narrows.safety.settings import FASTEST, KEEL_SHARE, OFFSETS, RESERVE, SLOWEST, SPEEDS
from narrows.simulation.grid import labelled

# Positions where a keel meets the banks [m]: to port and to starboard of the middle.
Walls = tuple[float, float]


@accept_aliases
@dataclass(frozen=True)
class Disturbance(Aliased):
    """Disturbances of a ship on its course, and the steady wind on that course.

    Raises an InputError if a number is negative (except the lever), or not finite.

    Examples
    --------
    >>> nw.Disturbance(gust=300.0).gust
    300.0
    """

    heading_deg: float = 2.0  #: Heading deviation at the start [deg]: standard deviation of normal samples
    offset: float = 0.0  #: Offset from the line at the start [m]: likewise a standard deviation
    gust: float = 0.0  #: Sway force from the start on [N], to starboard or to port with equal probability
    gust_lever: float = 0.0  #: Lever of that force [m], forward of midship
    gust_time: float = 60.0  #: Its duration [s]
    wind: float | None = None  #: Wind behind the forces [m/s], for the description only
    #: Sway force of a steady wind [N], with the same lever and from the same side as the gust, which adds to it
    steady: float = 0.0

    def __post_init__(self) -> None:
        for name in ("heading_deg", "offset", "gust", "gust_time", "steady"):
            if not 0 <= getattr(self, name) < math.inf:
                raise InputError(f"a disturbance's {name} = {getattr(self, name)} must be a number from 0")
        if not math.isfinite(self.gust_lever):
            raise InputError("a gust's lever must be a finite number of metres")

    @property
    def words(self) -> str:
        parts = [f"heading off by {self.heading_deg:g} deg"] if self.heading_deg else []
        parts += [f"offset by {self.offset:g} m"] if self.offset else []
        begin = f" at the start {' and '.join(parts)} (standard deviation)" if parts else " nothing off at the start"
        if not self.gust and not self.steady:
            return f"no wind;{begin}"
        force = f"{self.gust / 1e3:.4g} kN" if self.wind is None or self.steady else f"{self.wind:.3g} m/s"
        gust = f"a gust of {force} on the beam for {self.gust_time:g} s" if self.gust else ""
        force = f"{self.steady / 1e3:.4g} kN" if self.wind is None else f"{self.wind:.3g} m/s"
        steady = f"a steady wind of {force} on the beam" if self.steady else ""
        return f"{' and on top '.join(filter(None, (steady, gust)))}, from either side;{begin}"

    def drawn(self, samples: int, seed: int) -> dict[str, xr.DataArray]:
        """Draw ``samples`` by a ``seed``, along a dimension: psi [rad], y [m], Y [N], N [N m], the wind's side."""
        heading, offset, side = np.random.default_rng((seed, 1)).standard_normal((3, samples))
        gust = np.sign(side)
        psi, force = math.radians(self.heading_deg) * heading, self.gust * gust
        columns = {"psi": psi, "y": self.offset * offset, "Y": force, "N": self.gust_lever * force, "side": gust}
        return {name: xr.DataArray(column, dims="sample") for name, column in columns.items()}


# Curvature under which a bend is straight in words [1/m].
LEAST_CURVATURE = 1e-5


@dataclass(frozen=True)
class Bend:
    """A bend of the canal whose curvature does not change, and the water that flows along it."""

    curvature: float = 0.0  # Curvature of the middle, to starboard [1/m]
    current: float = 0.0  # Along it, with the ship [m/s]

    def path_curvature(self, y: Number) -> Number:
        """Return the curvature of a path at an offset from the middle [1/m]."""
        return self.curvature / (1 - self.curvature * y)

    def values(self, y: Number) -> dict[str, Number]:
        """Return the conditions of a steady turn at an offset [m], for ``solve_courses``."""
        return {"path_curvature": self.path_curvature(y), "current": self.current}

    @property
    def words(self) -> str:
        """Words for the description; empty for a straight canal without current."""
        turn = f"a bend of {1 / abs(self.curvature):.4g} m radius to " if abs(self.curvature) > LEAST_CURVATURE else ""
        turn += ("starboard" if self.curvature > 0 else "port") if turn else ""
        flow = f"a current of {self.current:+.3g} m/s" if self.current else ""
        return " and ".join(filter(None, (turn, flow)))

    def __bool__(self) -> bool:
        return bool(self.curvature or self.current)


STRAIGHT = Bend()


@dataclass(frozen=True)
class EnvelopeRequest:
    model: Model  # Model of the ship in its canal
    offsets: np.ndarray  # (offsets,) Offsets to starboard of the middle [m]
    speeds: np.ndarray  # (speeds,) Speeds through the water [m/s]
    clearance: float  # Least clearance under the keel [m]
    walls: Walls  # Positions where the keel meets the banks, to port and to starboard of the middle [m]
    disturbance: Disturbance  # Initial deviations and gusts
    reserve: float = RESERVE  # Share of the rudder left on the steady course [1]
    bank: str = "steep"  # Kind of bank, for outside rules
    pilot: str = "regulator"  # Name of the tested pilot
    bend: Bend = STRAIGHT

    def __post_init__(self) -> None:
        if not 0 <= self.reserve < 1 or not 0 <= self.clearance < math.inf:
            given = f"a reserve of {self.reserve} of the rudder and {self.clearance} m under the keel"
            raise InputError(f"{given}: give a share from 0 to less than 1, and metres from 0")
        for name in ("offsets", "speeds"):
            column = getattr(self, name)
            if not column.size or not np.isfinite(column).all() or (np.diff(column) <= 0).any():
                raise InputError(f"the {name} must be finite and rise; give them in order, none twice")
        slowest, half, (port, starboard) = self.speeds[0], self.model.configuration.ship.beam / 2, self.walls
        if slowest <= 0:
            raise InputError(f"a speed of {slowest:g} m/s steers nothing; give speeds over 0")
        if not (half - port < self.offsets[0] and self.offsets[-1] < starboard - half):
            clear = f"{half - port:.4g} and {starboard - half:.4g} m"
            given = f"offsets from {self.offsets[0]:g} to {self.offsets[-1]:g} m"
            raise InputError(f"{given} have the hull in a bank; stay between {clear}")
        curvature, current = self.bend.curvature, self.bend.current
        if not abs(curvature) * max(self.walls) < 1:
            raise InputError(f"a curvature of {curvature} 1/m bends inside its own bank; give that of the middle")
        if not abs(current) < slowest:
            way = f"no way over the ground at {slowest:g} m/s"
            raise InputError(f"a current of {current} m/s leaves {way}; give faster speeds")

    @property
    def rudder_limit(self) -> float:
        """Largest rudder [rad] of a steady course that leaves the reserve."""
        return (1 - self.reserve) * self.model.configuration.gear.limit


def envelope_request(
    model: Model, y: np.ndarray | None, u: np.ndarray | None, *, keel: float | None = None, walls: Walls | None = None,
    **asked: Any,
) -> EnvelopeRequest:  # fmt: skip
    """Return the request, with defaults for the ship and its canal."""
    # y (offsets,) [m]; u (speeds,) [m/s]; keel [m]; walls [m]
    ship, canal = model.configuration.ship, model.configuration.canal
    room = walls or (canal.width / 2, canal.width / 2)
    offsets = default_offsets(model, room) if y is None else labelled("y", y).to_numpy().reshape(-1)
    speeds = default_speeds(model) if u is None else labelled("u", u).to_numpy().reshape(-1)
    least = KEEL_SHARE * ship.draft if keel is None else keel
    return EnvelopeRequest(model, offsets, speeds, clearance=least, walls=room, **asked)


def default_offsets(model: Model, room: Walls, count: int = OFFSETS) -> np.ndarray:
    """Return offsets [m] whose steps grow linearly from the middle to the banks, and those where the tests end."""
    port, starboard = (wall - model.configuration.ship.beam for wall in room)
    if port + starboard <= 0:
        raise InputError("the canal is less than two beams wide: there is no offset to look at; check its width")
    covered = model.data_range.abs_y
    ends = [] if covered is None else [end for end in (-covered[1], covered[1]) if -port < end < starboard]
    middle, half, steps = (starboard - port) / 2, (starboard + port) / 2, np.linspace(-1, 1, count)
    return np.union1d(middle + half * steps * np.abs(steps), ends)


def default_speeds(model: Model, count: int = SPEEDS) -> np.ndarray:
    if model.configuration.canal.depth is None:
        raise InputError("without a depth speeds have no limit: give the depth (--depth) or the speeds (--speed)")
    asked = np.linspace(SLOWEST, FASTEST, count) * choke_speed(model.configuration)
    covered = model.data_range.speed or ()
    return np.union1d(asked, [end for end in covered if asked[0] < end < asked[-1]])


@dataclass(frozen=True)
class Keel:
    midship: np.ndarray  # (speeds,) Sinkage midship; 0 without a depth or in a choked canal [m]
    clearance: np.ndarray  # (speeds,) Least clearance under the hull; NaN without a depth or in a choked canal [m]
    choke: float  # Choking speed; infinite if the depth is unknown [m/s]
    notes: tuple[str, ...]  # Uses of the formulas outside their ranges


def keel_at(model: Model, speeds: np.ndarray) -> Keel:
    configuration = model.configuration
    if configuration.canal.depth is None:
        unknown = np.full(len(speeds), np.nan)
        return Keel(np.zeros(len(speeds)), unknown, np.inf, ("the depth is not given: no squat, no choking",))
    choke, room = choke_speed(configuration), configuration.canal.depth - configuration.ship.draft
    midship, clearance = np.zeros(len(speeds)), np.full(len(speeds), np.nan)
    notes = dict[str, None]()  # Without the numbers of a speed
    for index, speed in enumerate(speeds.tolist()):
        if speed < choke:
            ends = [squat(configuration, speed, gives) for gives in ("bow", "largest")]
            middle = squat(configuration, speed)
            midship[index], clearance[index] = middle.sinkage, room - max(end.sinkage for end in ends)
            for estimate in (middle, *ends):
                words = (re.sub(r"\S+ is outside", "is outside", note) for note in estimate.notes)
                notes |= dict.fromkeys(f"squat by {estimate.formula}: {note}" for note in words)
    return Keel(midship, clearance, choke, tuple(notes))


@accept_aliases
def wind_force(speed: float, area: float, coefficient: float = 1.0) -> float:
    """Return the sway force of a beam wind [N], C 1/2 rho A V^2 (the drag law).

    Raises an InputError if a number is negative or not finite.

    Parameters
    ----------
    speed, area, coefficient : float [m/s, m2, 1]
        Wind speed, lateral area above the water and its drag coefficient.

    Examples
    --------
    >>> round(nw.wind_force(speed=10.0, area=5.0, coefficient=1.0))
    306
    """
    if not all(0 <= number < math.inf for number in (speed, area, coefficient)):
        raise InputError("a wind's speed, area and coefficient are numbers from 0; check them")
    return 0.5 * AIR_DENSITY * coefficient * area * speed * speed
