"""Monte Carlo trials: ships that a pilot holds at every offset and speed."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from narrows.base.errors import InputError, check_count
from narrows.base.progress import bar
from narrows.codegen.free_motion import AFTER
from narrows.control.regulator import FEEDBACK, RegulatorWeights, stacked_gains
from narrows.control.steady_course import solve_courses, with_propulsion
from narrows.model.model import Model
from narrows.quantities.arithmetic import choice, maximum
from narrows.safety.pilots import PILOTS, BestEstimateCourses, Pilot, limited_course, regulator_of
from narrows.safety.request import STRAIGHT, Bend, Disturbance, Walls
from narrows.safety.settings import BACK_LENGTHS, MOST_TRIALS, STEPS_A_LENGTH, TRIAL_BLOCK, TRIAL_LENGTHS
from narrows.simulation.controllers import ControlLaw, Named
from narrows.simulation.grid import Grid, grid_of
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.outcome import Code
from narrows.simulation.ship import MEMORY, PARAMETER, SimulatedShip, bend_channel, steering_of

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
