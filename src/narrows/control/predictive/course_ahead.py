"""The way ahead: water, unexplained force, steady course, and the linear-quadratic regulator about it, by place."""

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from statistics import NormalDist
from typing import TYPE_CHECKING

import numpy as np

from narrows.base.errors import InputError
from narrows.codegen.cache import compiled_loops
from narrows.codegen.linearisation import LINEARISED
from narrows.control.predictive import plan_loops
from narrows.control.regulator import RegulatorWeights
from narrows.control.settings import MOST_PLACES, OTHER_SPEED, PLACES_A_LENGTH, WAYS
from narrows.control.steady_course import MOVED as RATES
from narrows.control.steady_course import LocalWater, steady_courses
from narrows.model.model import Model
from narrows.simulation.ship import SimulatedShip
from narrows.waterway.centreline import check_along_only

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


# State of a plan; the speed is constant, and the rudder's rate is the input.
MOTION = ("x", "y", "psi", "u", "v", "r")
HELD = ("y", "psi", "v", "r", "rudder")
MOVED = [LINEARISED.index(name) for name in HELD[:4]]
RUDDER = HELD.index("rudder")
FORCED = slice(HELD.index("v"), HELD.index("r") + 1)  # States that forces accelerate
# Section of the water in plans.
COLUMNS = ("width", "middle", "depth", "curvature", "keel_starboard", "keel_port", "current")


def over_interval(slopes: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the effect over a time of a state, exp(A t), and of constant rates: (points, 5, 5) each."""
    # Series to the fifth power: an interval is short compared with the growth of the motion.
    step, unit = slopes * time, np.eye(slopes.shape[-1])
    square = step @ step
    integral = unit + step / 2 + square / 6 + square @ (step / 24 + square / 120)
    return unit + step @ integral, time * integral


@dataclass(frozen=True)
class WaterAhead:
    """Equal cells along the line, linear between their nodes; beyond the ends the section stays constant."""

    nodes: np.ndarray  # (nodes, 7) ``COLUMNS`` at the ends of cells [m, m, m, 1/m, m, m, m/s]
    step: float  # Length of a cell [m]
    section: tuple[str, ...] = ("width", "depth")  # Inputs of the terms; none for the model's own canal

    def at(self, x: np.ndarray) -> dict[str, np.ndarray]:
        rows = compiled_loops(plan_loops).interpolate(self.nodes, self.step, x)
        return dict(zip(COLUMNS, rows.T, strict=True))


def water_ahead(model: Model, waterway: "Waterway | None") -> WaterAhead:
    ship, canal = model.configuration.ship, model.configuration.canal
    own_depth = np.nan if canal.depth is None else canal.depth
    if waterway is None:
        values = model.configuration.values()
        walls = [float(values.get(name, canal.width / 2)) for name in ("wall_starboard", "wall_port")]
        row = np.array([canal.width, 0.0, own_depth, 0.0, *walls, 0.0])
        return WaterAhead(np.stack([row, row]), 1.0, section=())
    from narrows.waterway.waterway import tabulate

    waterway.check_fits(ship)
    check_along_only(waterway, "a plan")
    table = tabulate(waterway, ship.draft, waterway.step or ship.beam)
    depth = np.full_like(table.s, own_depth) if np.isnan(table.depth).all() else table.depth
    width, middle = table.starboard + table.port, (table.starboard - table.port) / 2
    current = waterway.reference_current * table.flow
    columns = [width, middle, depth, table.curvature, table.keel_starboard, table.keel_port, current]
    return WaterAhead(np.stack(columns, axis=1), table.step)


# Gains of the best linear helm (5,), and the infinite-horizon cost matrix of a deviation, (5, 5).
Regulated = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class SteadyTrack:
    """Steady courses at places along a line, from the offset to the middle."""

    places: np.ndarray  # (n,) Along the line [m]
    states: np.ndarray  # (ways, n, 5) y [m], psi [rad], v [m/s], r [rad/s], rudder [rad]
    by_push: np.ndarray  # (ways, n, 5, 2) Their change per sway force [N] and yaw moment [N m]
    force_of: np.ndarray  # (ways, n, 2, 2) Force and moment per acceleration in sway and yaw
    slopes: np.ndarray  # (ways, n, 5, 5) Derivatives of the rates of the state by the state
    # (ways, n) True if there is a steady course; otherwise the next one nearer to the middle is used
    known: np.ndarray
    limit: float  # Limit of the rudder [rad]

    def nearest(self, x: float) -> int:
        return round(min(max(0.0, x / float(self.places[1])), len(self.places) - 1))

    def held(self, x: float, push: np.ndarray, most: float) -> float:
        """Return the share of the way to the middle, 0 to 1, at which the rudder angle ``most`` holds the ship."""
        place = self.nearest(x)
        asked = np.abs(self.states[:, place, RUDDER] + self.by_push[:, place, RUDDER] @ push)
        asked[~self.known[:, place]] = np.inf
        enough = asked <= most
        first = int(enough.argmax() if enough.any() else asked.argmin())
        if first == 0 or not enough[first]:
            return first / (WAYS - 1)
        more, less = asked[first - 1], asked[first]
        part = (more - most) / (more - less) if np.isfinite(more) else 1.0
        return (first - 1 + float(part)) / (WAYS - 1)

    def at(self, x: np.ndarray, push: np.ndarray, way: float = 0.0) -> np.ndarray:
        """Return the steady states at places under an external force and moment, (places, 5)."""
        row = min(int(way * (WAYS - 1)), WAYS - 2)
        part = way * (WAYS - 1) - row
        states = self.states[row] + part * (self.states[row + 1] - self.states[row])
        nearest = round(way * (WAYS - 1)), self.nearest(float(x[0]))
        there: np.ndarray = compiled_loops(plan_loops).interpolate(states, self.places[1], x)
        there += self.by_push[nearest] @ push
        there[:, RUDDER] = np.clip(there[:, RUDDER], -self.limit, self.limit)
        return there


@dataclass(frozen=True)
class Weights:
    states: np.ndarray  # (5,) Squared deviations of y, psi, v, r, rudder
    rate: float  # Squared rate of the rudder [s2/rad2]

    @classmethod
    def of(cls, weights: RegulatorWeights, half_beam: float, passing: float) -> "Weights":
        # Bryson and Ho (1975), Applied optimal control, section 5.2.
        rudder = math.radians(weights.rudder_deg)
        sizes = np.array([weights.offset * half_beam, math.radians(weights.heading_deg), math.inf, math.inf, rudder])
        return cls(sizes**-2, (weights.stroke_time * passing / rudder) ** 2)


class CourseAhead:
    """The steady course along a line, recomputed if the speed has changed."""

    def __init__(
        self, ship: SimulatedShip, water: WaterAhead, y: float, u: float, margin: float,
        positions: Mapping[str, float], weights: Weights, interval: float,
    ) -> None:  # fmt: skip
        self.ship, self.water, self.y, self.margin = ship, water, y, margin
        self.positions, self.weights, self.interval = dict(positions), weights, interval
        self._start(u)
        self._usual = self._regulated(self.narrowest)

    def _start(self, u: float) -> None:
        self.track = steady_track(self.ship, self.water, self.y, u, self.margin, self.positions)
        self.speed, self._known = u, dict[tuple[int, int], Regulated]()

    @property
    def narrowest(self) -> int:
        there, off = self.water.at(self.track.places), self.track.states[0, :, 0]
        return int(np.minimum(there["keel_starboard"] - off, there["keel_port"] + off).argmin())

    def at_speed(self, u: float) -> SteadyTrack:
        """Return the course at a speed; if none is found, the previous one."""
        if u > 0 and abs(u - self.speed) > OTHER_SPEED * self.speed:
            with suppress(InputError):
                self._start(u)
        return self.track

    def regulated(self, x: float, way: float) -> Regulated:
        """Return the best linear helm about the course at a place; if none stabilises it, that of the narrowest one."""
        place = self.track.nearest(x), round(way * (WAYS - 1))
        if place not in self._known:
            try:
                self._known[place] = self._regulated(*place)
            except InputError:
                self._known[place] = self._usual
        return self._known[place]

    def _regulated(self, place: int, way: int = 0) -> Regulated:
        (A,), (integral,) = over_interval(self.track.slopes[way, place : place + 1], self.interval)
        return regulator_of(A, integral[:, RUDDER], self.weights)

    def margins(self, intervals: int, confidence: float) -> np.ndarray:
        """Return the margins of clearance after each interval of a plan [m], from the place of least clearance."""
        place, (gains, _) = self.narrowest, self._usual
        steady = self.track.states[0, place]
        (A,), (integral,) = over_interval(self.track.slopes[0, place : place + 1], self.interval)
        off = np.zeros(len(steady))
        off[0] = np.copysign(self.ship.model.configuration.ship.beam / 2, steady[0])
        states = [steady + off]
        for _ in range(intervals):
            off = (A - np.outer(integral[:, RUDDER], gains)) @ off
            states.append(steady + off)
        there = self.water.at(self.track.places[place : place + 1])
        section = {name: float(there[name][0]) for name in self.water.section}
        linear = self.ship.linearisation({**self.ship.values(**self.positions), **section})
        at = {**dict(zip(HELD, np.array(states).T, strict=True)), "u": self.speed, **self.positions}
        by_coefficient = linear.coefficients({**at, "y": at["y"] - there["middle"][0]})
        return margins_of(self.ship.model, (A, integral), by_coefficient, gains, self.margin, confidence)


def steady_track(
    ship: SimulatedShip, water: WaterAhead, y: float, u: float, margin: float, positions: Mapping[str, float]
) -> SteadyTrack:
    """Find the steady courses along a line, at the offset and nearer to the middle, where less rudder is needed."""
    length = ship.model.configuration.ship.length
    whole = water.step * (len(water.nodes) - 1)
    count = int(min(max(PLACES_A_LENGTH * whole / length, 2), MOST_PLACES))
    places = np.linspace(0.0, whole, count)
    there = water.at(places)
    # The offset, or the nearest one with clearance on both sides; the middle if there is none.
    reach = ship.model.configuration.ship.beam / 2 + margin
    starboard, port = there["keel_starboard"] - reach, -(there["keel_port"] - reach)
    offset = np.where(starboard > port, np.clip(y, port, starboard), (starboard + port) / 2)
    middle = (there["keel_starboard"] - there["keel_port"]) / 2
    y_held = (offset + np.linspace(0.0, 1.0, WAYS)[:, None] * (middle - offset)).ravel()
    everywhere = {name: np.tile(column, WAYS) for name, column in there.items()}
    line = {name: everywhere[name] for name in ("width", "middle", "curvature", "current")}
    place = LocalWater(sections={name: everywhere[name] for name in water.section}, **line)
    motion, course = steady_courses(ship, place, y_held, np.full(len(y_held), u), positions)
    states = np.stack([course[name] for name in HELD], axis=1).reshape(WAYS, count, -1)
    known = np.isfinite(states[..., RUDDER])
    if not known.any():
        raise InputError(f"no rudder holds this ship {y:g} m off the line at {u:g} m/s; choose a place nearer to it")
    # If there is no course, use drift and rudder of the next one nearer to the middle, or zero.
    states[-1, ~known[-1], 1:] = 0.0
    for way in range(WAYS - 2, -1, -1):
        states[way, ~known[way], 1:] = states[way + 1, ~known[way], 1:]
    by = motion.slopes({**course, **dict(zip(HELD, states.reshape(-1, len(HELD)).T, strict=True))})
    # Accelerations that vanish on a steady course, by choice of psi, v and the rudder.
    balanced = [RATES.index(name) for name in ("y", "v", "r")]
    asked = ("psi", "v", "rudder"), ("Y", "N")
    by_choice, by_force = (np.stack([by[n][:, balanced] for n in names], axis=-1) for names in asked)
    by_push = np.zeros((len(y_held), len(HELD), 2))
    by_push[:, [HELD.index("psi"), HELD.index("v"), RUDDER]] = -np.linalg.solve(by_choice, by_force)
    slopes = np.zeros((len(y_held), len(HELD), len(HELD)))
    rows = [RATES.index(name) for name in HELD[:RUDDER]]
    slopes[:, :RUDDER] = np.stack([by[name][:, rows] for name in HELD], axis=-1)
    parts = (by_push, np.linalg.inv(by_force[:, 1:]), slopes)
    by_push, force_of, slopes = (part.reshape(WAYS, count, *part.shape[1:]) for part in parts)
    limit = ship.model.configuration.gear.limit
    return SteadyTrack(places, states, by_push, force_of, slopes, known, limit)


def margins_of(
    model: Model, motion: tuple[np.ndarray, np.ndarray], slopes_by_coefficient: np.ndarray, gains: np.ndarray,
    margin: float, confidence: float,
) -> np.ndarray:  # fmt: skip
    # While the ship returns from half a beam off under the best linear helm, its forces are uncertain; the estimated
    # external force already contains their initial part, which is subtracted. motion: two matrices (5, 5);
    # slopes_by_coefficient (intervals + 1, 6, coefficients).
    (A, integral), count = motion, len(slopes_by_coefficient) - 1
    if model.covariance is None:
        return np.full(count, margin)
    closed = A - np.outer(integral[:, RUDDER], gains)
    sway_and_yaw = slopes_by_coefficient[:, 4:]
    astray = np.zeros((len(A), sway_and_yaw.shape[-1]))
    spread = np.zeros(count)
    lever = model.configuration.ship.length / 2
    ends = np.array([[1.0, lever, 0, 0, 0], [1.0, -lever, 0, 0, 0]])
    for k in range(count):
        astray = closed @ astray + integral[:, FORCED] @ (sway_and_yaw[k] - sway_and_yaw[0])
        corners = ends @ astray
        spread[k] = np.sqrt(np.maximum(np.einsum("ip,pq,iq->i", corners, model.covariance, corners), 0.0)).max()
    return margin + NormalDist().inv_cdf(confidence) * spread


def regulator_of(A: np.ndarray, B: np.ndarray, weights: Weights) -> tuple[np.ndarray, np.ndarray]:
    from scipy.linalg import solve_discrete_are

    try:
        cost = solve_discrete_are(A, B[:, None], np.diag(weights.states), [[weights.rate]])
    except (np.linalg.LinAlgError, ValueError):
        raise InputError("no helm holds this ship: its rudder has no effect") from None
    return np.asarray(B @ cost @ A / (weights.rate + B @ cost @ B)), np.asarray(cost)
