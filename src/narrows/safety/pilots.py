"""Pilots of the envelope, by name, and Monte Carlo trials of ships that they hold at every offset and speed."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import xarray as xr

from narrows.base.errors import InputError, check_count
from narrows.base.progress import bar
from narrows.base.results import BaseSummary
from narrows.codegen.free_motion import AFTER
from narrows.control.regulator import DEFAULT_WEIGHTS, FEEDBACK, HeldLine, Regulator, RegulatorWeights, stacked_gains
from narrows.control.settings import LEAD_TIME
from narrows.control.steady_course import solve_courses, with_propulsion
from narrows.model.model import Model
from narrows.quantities.arithmetic import choice, clip, maximum
from narrows.quantities.names import DEGREE
from narrows.safety.request import STRAIGHT, Bend, Disturbance, Walls
from narrows.safety.settings import BACK_LENGTHS, MOST_TRIALS, STEPS_A_LENGTH, TRIAL_BLOCK, TRIAL_LENGTHS
from narrows.simulation.controllers import ORDER_TOLERANCE, ControlLaw, Named
from narrows.simulation.grid import Grid, grid_of
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.outcome import Code
from narrows.simulation.ship import MEMORY, PARAMETER, SimulatedShip, bend_channel, steering_of

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


# Names of the columns: disturbances, numbers of the pilot, gains of one with the true coefficients.
OFF, BY, KNOWING = "off_{}".format, "pilot_{}".format, "knowing_{}".format
Columns = Mapping[str, Any]


def trials(
    model: Model, y: np.ndarray, u: np.ndarray, heave: np.ndarray, disturbance: Disturbance, samples: int, seed: int,
    walls: Walls = (math.inf, math.inf), pilot: Pilot = PILOTS["regulator"], knowing: bool = True,
    bend: Bend = STRAIGHT, workers: int | None = None, progress: bool = False,
) -> xr.Dataset:  # fmt: skip
    """Hold a ship at offsets and speeds against disturbances, with coefficients drawn from their covariance."""
    # y (offsets,) [m]; u (speeds,) [m/s]; heave (speeds,) [m]; walls [m]. Every sample starts from the steady course of
    # its own coefficients, plus a disturbance. A ship is held if it touches no bank, stays within 85 degrees of the
    # canal, and is back within half a beam of its line for the last three ship lengths of the trial. A propeller keeps
    # the revolutions of its speed straight ahead, and the speed follows. There are two pilots: one designed for the
    # best estimate of the coefficients, with its first tuning, and one with the drawn coefficients.
    check_count("samples", samples, 1)
    check_count("seed", seed)
    if (points := samples * len(y) * len(u)) > MOST_TRIALS:
        raise InputError(f"{points} points are more than {MOST_TRIALS}; take fewer samples, offsets or speeds")
    thrown = disturbance.drawn(samples, seed)
    along = xr.DataArray(np.zeros(samples), dims="sample")
    steady = {"y": y, "u": u, "heave": xr.DataArray(heave, dims="u"), "x": along}
    drawn = samples if model.covariance is not None else 0
    ship, grid = SimulatedShip(model), grid_of(model, with_propulsion(model, steady), drawn, seed)
    # Disturbances change side with the offset, so that a symmetric canal gets a symmetric result.
    side = xr.DataArray(np.where(np.asarray(y) < 0, -1.0, 1.0), dims="y")
    wind = side * disturbance.steady * thrown.pop("side")
    if disturbance.steady:
        grid = Grid({**grid.values, "Y": wind, "N": disturbance.gust_lever * wind}, grid.sizes)
    extra = {OFF(name): side * column for name, column in thrown.items()}
    courses = BestEstimateCourses(ship, np.asarray(y), np.asarray(u), np.asarray(heave), bend)
    extra |= {BY(name): table for name, table in _numbers(pilot, courses, disturbance, wind).items()}
    extra |= _knowing(ship, grid, bend, workers) if knowing else {}
    sailing = replace(ship, surge="free") if model.terms.propelled else ship
    trial = _Trial(sailing, pilot, disturbance.gust_time, walls, bend, workers)
    whole = Grid({**grid.values, **extra}, grid.sizes)
    kept = {name: np.empty(tuple(grid.sizes.values())) for name in ("rudder", "held", "known")}
    with bar(whole.vessels, progress) as advance:
        for block in whole.blocks(TRIAL_BLOCK):
            values, shape = whole.flat(block)
            for name, column in trial.sailed(values, math.prod(shape)).items():
                kept[name][whole.region(block)] = column.reshape(shape)
            advance(math.prod(shape))
    data = {name: (list(grid.sizes), column) for name, column in kept.items()}
    tried = xr.Dataset(data, coords={"y": y, "u": u}).transpose("y", "u", "sample")
    return tried.assign(held=tried["held"] > 0, known=tried["known"] > 0)


def _numbers(
    pilot: Pilot, courses: BestEstimateCourses, disturbance: Disturbance, wind: xr.DataArray
) -> dict[str, xr.DataArray]:
    """Numbers of the pilot at offsets and speeds; in a steady wind those of the side that it blows from."""

    def of(force: float) -> xr.Dataset:
        there = replace(courses, wind=(force, disturbance.gust_lever * force))
        return xr.Dataset({name: (("y", "u"), table) for name, table in pilot.numbers(there, pilot.tunings[0]).items()})

    numbers = of(disturbance.steady)
    if disturbance.steady:
        numbers = xr.where(wind > 0, numbers, of(-disturbance.steady))
    return {str(name): column for name, column in numbers.items()}


def _knowing(ship: SimulatedShip, grid: Grid, bend: Bend, workers: int | None) -> dict[str, xr.DataArray]:
    """Gains of a regulator for each offset and sample, designed for the middle speed."""
    at = grid.sizes["u"] // 2
    values = {name: value.isel(u=at, drop=True) if "u" in value.dims else value for name, value in grid.values.items()}
    one = Grid(values, {name: size for name, size in grid.sizes.items() if name != "u"})
    gains = np.empty((*one.sizes.values(), len(FEEDBACK)))
    for block in one.blocks(TRIAL_BLOCK):
        columns, shape = one.flat(block)
        course = limited_course(ship, columns, math.prod(shape), bend, workers)
        gains[one.region(block)] = stacked_gains(ship, columns, course, RegulatorWeights(bank=1.0)).reshape(*shape, -1)
    parts = {KNOWING(name): xr.DataArray(gains[..., i], dims=list(one.sizes)) for i, name in enumerate(FEEDBACK)}
    return {**parts, KNOWING("made_for"): xr.DataArray(float(values["u"]))}


@dataclass(frozen=True)
class _Trial:
    ship: SimulatedShip
    pilot: Pilot
    gust_time: float
    walls: Walls
    bend: Bend
    workers: int | None

    def sailed(self, values: Columns, count: int) -> dict[str, np.ndarray]:
        course = {n: v for n, v in values.items() if not n.startswith((OFF(""), BY(""), KNOWING("")))}
        v, rudder = solve_courses(self.ship, {**course, **self.bend.values(course["y"])}, count, self.workers)
        found = np.abs(rudder) <= self.ship.model.configuration.gear.limit  # false if there is none
        held = {"y": course["y"], "u": np.broadcast_to(course["u"], count), "v": np.where(found, v, 0.0)}
        held |= {"rudder": np.where(found, rudder, 0.0), "psi": -np.arctan(held["v"] / held["u"])}
        pace = np.hypot(held["u"], held["v"]) + self.bend.current
        held |= {"r": self.bend.path_curvature(held["y"]) * pace}
        numbers = {n.removeprefix(BY("")): np.broadcast_to(c, count) for n, c in values.items() if n.startswith(BY(""))}
        start = {**course, **{name: held[name] for name in ("v", "r", "rudder")}}
        start |= {"y": course["y"] + values[OFF("y")], "psi": held["psi"] + values[OFF("psi")]}
        sail = partial(self._held, start, held, {name: values[OFF(name)] for name in ("Y", "N")})
        one = sail(self.pilot.law(self.ship, numbers, held), found)
        known = one
        if KNOWING("y") in values:
            gains = [np.broadcast_to(values[KNOWING(name)], count) for name in FEEDBACK]
            made = found & np.isfinite(gains).all(axis=0) & ~one
            # The law takes the course at its design speed, and the sway velocity scales with the speed.
            made_for = float(np.ravel(values[KNOWING("made_for")])[0])
            at_that_speed = {**held, "v": held["v"] * made_for / held["u"]}
            gains = [np.where(made, gain, 1.0) for gain in gains]
            law = regulator_of(self.ship, gains, at_that_speed, np.full(count, made_for))
            known = one | sail(law, made)
        return {"rudder": rudder, "held": one, "known": known}

    def _held(
        self, start: Columns, course: Columns, push: Columns, law: ControlLaw, sailed: np.ndarray
    ) -> np.ndarray:  # fmt: skip
        """Return whether each is held; excluded trials take no steps and are not held."""
        ship, walls, line = self.ship, self.walls, course["y"]
        hull = ship.model.configuration.ship
        pace = hull.length / (STEPS_A_LENGTH * np.asarray(course["u"]))
        gusty = self.gust_time if np.any(push["Y"]) else 0.0
        wind = {name: np.asarray(start[name]) for name in push}
        gust: dict[str, Any] = {AFTER(name): force for name, force in wind.items()}
        gust |= {"X": 0.0, "push_end": gusty, **{name: wind[name] + force for name, force in push.items()}}
        steps = np.where(sailed, np.ceil(gusty / pace) + TRIAL_LENGTHS * STEPS_A_LENGTH, 0)
        recorder = DeviationRecorder(law, line, (steps - BACK_LENGTHS * STEPS_A_LENGTH) * pace)
        steering = steering_of(recorder, ship.actuators)
        half = np.asarray(start["width"]) / 2
        inputs = {
            **start, **(gust if gusty else {}),
            **{PARAMETER(name): value for name, value in recorder.parameters().items()},
            "wall_port": np.minimum(walls[0], half), "wall_starboard": np.minimum(walls[1], half),
        }  # fmt: skip
        duration, channel = steps * pace, None
        if self.bend:  # It is longer at either end than any ship sails.
            room = 1 - np.abs(self.bend.curvature * np.asarray(line))
            way = duration * (np.hypot(course["u"], course["v"]) + abs(self.bend.current)) / room
            length = 2 * REACH * hull.length + MARGIN * float(np.max(way))
            channel = bend_channel(ship.model, ship.shape, walls, self.bend.curvature, self.bend.current, length)
        run = KernelRun(ship, duration, pace, steering=steering, bend=channel)
        inputs |= {"x": REACH * hull.length} if run.bend else {}
        prepared = run.prepared(inputs, sailed.size, self.workers)
        prepared()
        ended = run.ended(prepared, inputs)
        late = np.maximum(ended[f"{MEMORY('farthest')}_end"], np.abs(ended["y_end"] - line))
        return np.asarray(sailed & (ended["outcome"] == Code.AFLOAT) & (late <= hull.beam / 2))


# Ship lengths of a bend before and after the trial, and its length over that of the ship's way [1].
REACH, MARGIN = 5.0, 1.5


@dataclass(frozen=True)
class DeviationRecorder:
    """Any control law that records the late deviation of the ship from its line."""

    law: ControlLaw  # Control law
    y: Any  # The line [m]
    late_from: Any  # Start of the record [s]

    def parameters(self) -> Mapping[str, Any]:
        return {**self.law.parameters(), "judged_y": self.y, "late_from": self.late_from}

    def memory(self, start: Named) -> Named:
        return {**self.law.memory(start), "farthest": 0.0}

    def orders(self, at: Any) -> tuple[Named, Named]:
        orders, memory = self.law.orders(at)
        counted = choice(at.t + at.dt / 2 - at.late_from, abs(at.y - at.judged_y), 0.0)
        return orders, {**memory, "farthest": maximum(at.farthest, counted)}
