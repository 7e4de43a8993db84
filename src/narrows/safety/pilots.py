"""Pilots of the envelope, by name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from narrows.base.errors import InputError
from narrows.base.results import BaseSummary
from narrows.control.regulator import DEFAULT_WEIGHTS, FEEDBACK, HeldLine, Regulator, RegulatorWeights, stacked_gains
from narrows.control.settings import LEAD_TIME
from narrows.control.steady_course import solve_courses, with_propulsion
from narrows.quantities.arithmetic import choice, clip
from narrows.quantities.names import DEGREE
from narrows.safety.request import STRAIGHT, Bend
from narrows.simulation.controllers import ORDER_TOLERANCE, ControlLaw, Named
from narrows.simulation.grid import Grid, grid_of
from narrows.simulation.ship import SimulatedShip

# Numbers of a pilot by name: arrays (offsets, speeds), or columns of them.
Numbers = dict[str, np.ndarray]

# Gains of manual steering: rudder [rad] per half beam of offset, heading [rad], yaw rate over speed by length [rad].
MANUAL_GAINS = (0.56, 8.0, 7.7)
# Time after which the trim of a constant offset equals the immediate order [ship lengths].
TRIM_TIME = 10.0

# Steady course of each trial: y [m], u [m/s], the drawn ship's rudder and psi [rad] and v [m/s], and the yaw rate r
# [rad/s] of its bend; arrays (n,).
Course = Mapping[str, Any]


@dataclass(frozen=True)
class BestEstimateCourses:
    ship: SimulatedShip  # Ship with the best estimate of the coefficients
    offsets: np.ndarray  # (offsets,) Offsets to starboard of the middle [m]
    speeds: np.ndarray  # (speeds,) Speeds through the water [m/s]
    heave: np.ndarray  # (speeds,) Midship sinkage [m]
    bend: Bend = STRAIGHT
    wind: tuple[float, float] = (0.0, 0.0)  # Sway force [N] and yaw moment [N m]

    @cached_property
    def places(self) -> np.ndarray:
        """The offsets, with the middle as the last [m]."""
        return np.append(self.offsets, 0.0)

    @cached_property
    def values(self) -> dict[str, Any]:
        """Numbers of the ship; those that vary are columns (places x speeds,), place by place."""
        offset = xr.DataArray(self.places, dims="place")
        asked = {"y": offset, "u": self.speeds, "heave": xr.DataArray(self.heave, dims="u")}
        grid = grid_of(self.ship.model, with_propulsion(self.ship.model, asked), 0, 0)
        return Grid(grid.values, {"place": len(self.places), "u": len(self.speeds)}).flat(slice(None))[0]

    @cached_property
    def course(self) -> Numbers:
        """y [m], u, v [m/s], rudder [rad], and other moving quantities; NaN if no rudder angle holds the ship."""
        values = {**self.values, "Y": self.wind[0], "N": self.wind[1]}
        return limited_course(self.ship, values, len(self.places) * len(self.speeds), self.bend, 1)

    def held(self) -> Numbers:
        """Return rudder, psi [rad] and v [m/s] at offsets and speeds, (offsets, speeds)."""
        rudder, u, v = (self.course[name] for name in ("rudder", "u", "v"))
        course = np.stack([rudder, -np.arctan(v / u), v], axis=-1)
        return dict(zip(("rudder", "psi", "v"), np.moveaxis(self.filled(course), -1, 0), strict=True))

    def filled(self, columns: np.ndarray) -> np.ndarray:
        """Return columns at offsets and speeds, (offsets, speeds, n); NaN is replaced by the nearest place's value."""
        # columns (places x speeds, n)
        table = columns.reshape(len(self.places), len(self.speeds), -1)
        known = np.isfinite(table).all(axis=-1)
        held = np.flatnonzero(known.any(axis=0))
        if not held.size or (len(held) < len(self.speeds) and not any(self.wind)):
            raise InputError("no pilot holds this ship on the centreline: its rudder has no effect")
        # In wind, a speed without any course takes that of the nearest speed with one.
        nearest_speed = held[np.abs(self.speeds[:, None] - self.speeds[held]).argmin(axis=1)]
        table, known = table[:, nearest_speed], known[:, nearest_speed]
        far = np.abs(self.places[:, None] - self.offsets[None, :])[:, :, None]
        nearest = np.where(known[:, None, :], far, np.inf).argmin(axis=0)
        return np.asarray(table[nearest, np.arange(len(self.speeds))])


def limited_course(ship: SimulatedShip, values: Course, count: int, bend: Bend, workers: int | None) -> Numbers:
    """Return y [m], u, v [m/s], rudder [rad], other moving quantities; NaN if no rudder within its limit holds it."""
    v, rudder = solve_courses(ship, {**values, **bend.values(values["y"])}, count, workers)
    within = np.abs(rudder) <= ship.model.configuration.gear.limit
    course = {name: values[name] for name in ("y", *(a.name for a in ship.actuators)) if name in values}
    course |= {"u": np.broadcast_to(values["u"], count), "v": np.where(within, v, np.nan)}
    return course | {"rudder": np.where(within, rudder, np.nan)}


@dataclass(frozen=True)
class Pilot:
    """A pilot designed for the best estimate of the coefficients, the same for all samples."""

    words: str  # Description for the result's sentence
    tunings: tuple[Any, ...]  # Tunings that trials may choose from; the default first
    # Returns its numbers at offsets and speeds, from the best-estimate courses and a tuning
    numbers: Callable[[BestEstimateCourses, Any], Numbers]
    # Returns the law of many trials, from the ship, its numbers in each, and the course of each
    law: Callable[[SimulatedShip, Numbers, Course], ControlLaw]


def _regulator_numbers(courses: BestEstimateCourses, tuning: RegulatorWeights) -> Numbers:
    """Gains, and rudder, heading and drift of the best-estimate course."""
    gains = courses.filled(stacked_gains(courses.ship, courses.values, courses.course, tuning))
    return {**{f"by_{name}": gains[..., i] for i, name in enumerate(FEEDBACK)}, **courses.held()}


def _regulator(ship: SimulatedShip, numbers: Numbers, course: Course) -> ControlLaw:
    """The regulator; from the drawn ship it uses only y and u."""
    return regulator_of(ship, [numbers[f"by_{name}"] for name in FEEDBACK], {**numbers, "y": course["y"]}, course["u"])


def _helmsman_numbers(courses: BestEstimateCourses, share: float) -> Numbers:
    """A share of the manual gains, and rudder and heading of the best-estimate course."""
    hull, held = courses.ship.model.configuration.ship, courses.held()
    time = hull.length / np.broadcast_to(courses.speeds, held["rudder"].shape)
    by_y, by_psi, by_r = (share * gain for gain in MANUAL_GAINS)
    constant = {"by_y": by_y / (hull.beam / 2), "by_psi": by_psi}
    gains = {**{name: np.full(time.shape, gain) for name, gain in constant.items()}, "by_r": by_r * time}
    return {**gains, "by_trim": gains["by_y"] / (TRIM_TIME * time), "rudder": held["rudder"], "psi": held["psi"]}


def _helmsman(ship: SimulatedShip, numbers: Numbers, course: Course) -> ControlLaw:
    """The helmsman; from the drawn ship it uses only y."""
    gains = numbers["by_y"], numbers["by_psi"], numbers["by_r"]
    rudder = numbers["rudder"] + numbers["by_r"] * course["r"]
    return Helmsman(course["y"], gains, numbers["by_trim"], rudder, numbers["psi"])


# Regulators that rely on the best-estimate bank force, in addition to the default one.
TIGHTER = tuple(RegulatorWeights(offset, bank=1.0) for offset in (1 / 4, 1 / 8, 1 / 16))
DELAY = 3.0  # Time between observations of a helmsman, and from an order to its execution [s]
CAP_DEG = 20.0  # Largest rudder that a helmsman orders [deg]
# Pilots by name, the default first.
PILOTS = {
    "regulator": Pilot(
        "a regulator designed for the best estimate of the coefficients, with the tuning that holds most cases",
        (DEFAULT_WEIGHTS, *TIGHTER), _regulator_numbers, _regulator,
    ),
    "human": Pilot(
        f"a helmsman: a look every {DELAY:g} s, an order in whole degrees, executed {DELAY:g} s later, at most "
        f"{CAP_DEG:g} degrees",
        (1.0, 0.5, 0.25, 0.125), _helmsman_numbers, _helmsman,
    ),
}  # fmt: skip


def regulator_of(ship: SimulatedShip, gains: list[Any], held: Mapping[str, Any], made_for: Any) -> Regulator:
    # gains (n,); held [m]; made_for (n,) [m/s]
    time = ship.model.configuration.ship.length / np.asarray(made_for)
    line = HeldLine(held["y"], tuple(gains), held["rudder"], held["psi"], held["v"])
    return Regulator((line,), made_for, LEAD_TIME * time, DEFAULT_WEIGHTS.unwinding_time * time)


BITS = (32, 16, 8, 4, 2, 1)  # Powers of two that make up whole degrees, to 63


@dataclass(frozen=True, repr=False)
class Helmsman(BaseSummary):
    """A helmsman: an observation every few seconds, an order in whole degrees, executed at the next, up to a limit."""

    # The order is proportional to the deviations, about a trim that slowly integrates the offset.

    y: Any  # Offset to hold [m]
    gains: tuple[Any, Any, Any]  # Rudder per deviation of offset, heading and yaw rate [rad/m, 1, s]
    trim: Any = 0.0  # Rate of the trim per offset [rad/(m s)]
    rudder: Any = 0.0  # Assumed steady rudder there [rad]
    psi: Any = 0.0  # Assumed steady heading there [rad]
    delay: float = DELAY  # Time between observations, and from an order to its execution [s]
    cap_deg: float = CAP_DEG  # Largest ordered rudder, to 63 [deg]

    def summary(self) -> str:
        return f"y = {self.y}, a look every {self.delay:g} s, whole degrees to {self.cap_deg:g}"

    def parameters(self) -> Mapping[str, Any]:
        held = {"held_y": self.y, "held_psi": self.psi, "held_rudder": self.rudder, "by_trim": self.trim}
        gains = dict(zip(("by_y", "by_psi", "by_r"), self.gains, strict=True))
        return {**held, **gains, "delay": self.delay, "cap": self.cap_deg * DEGREE}

    def memory(self, start: Named) -> Named:
        """Return the trim, the time of the next observation, the last order, and the executed one."""
        return {"trimmed": 0.0, "next_look": 0.0, "given": start["rudder"], "executed": start["rudder"]}

    def orders(self, at: Any) -> tuple[Named, Named]:
        off = at.y - at.held_y
        wanted = at.held_rudder + at.trimmed - (at.by_y * off + at.by_psi * (at.psi - at.held_psi) + at.by_r * at.r)
        looks = at.t + ORDER_TOLERANCE * at.dt - at.next_look
        executed = choice(looks, at.given, at.executed)
        memory = {
            "trimmed": at.trimmed - choice(at.cap - abs(wanted), at.dt * at.by_trim * off, 0.0),
            "next_look": choice(looks, at.t + at.delay, at.next_look),
            "given": choice(looks, whole_degrees(clip(wanted, at.cap)), at.given),
            "executed": executed,
        }
        return {"rudder": executed}, memory


def whole_degrees(angle: Any) -> Any:
    """Return an angle [rad] rounded to whole degrees, halves away from zero, by arithmetic that every engine has."""
    wanted, degrees = abs(angle) / DEGREE + 0.5, 0.0
    for bit in BITS:  # Binary digits of the integer part; 1e-12 deg is the rounding of the division
        degrees = degrees + choice(wanted - degrees - bit + 1e-12, bit, 0.0)
    return choice(angle, degrees, -degrees) * DEGREE
