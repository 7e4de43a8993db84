"""Plans of the rudder: predicted by lanes of the kernel, improved by a step of sequential quadratic programming."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from narrows.base.errors import InputError, check_count, needs
from narrows.codegen.cache import compiled_loops
from narrows.codegen.linearisation import LINEARISED
from narrows.control import settings
from narrows.control.predictive import plan_loops
from narrows.control.predictive.course_ahead import HELD, MOTION, MOVED, RUDDER, WaterAhead, Weights, over_interval
from narrows.control.steady_course import along_line
from narrows.simulation.kernel_run import ShipLanes
from narrows.simulation.ship import SimulatedShip

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


def predict(
    lanes: ShipLanes, x: np.ndarray, states: np.ndarray, speed: float, rates: np.ndarray, push: np.ndarray,
    time: float, positions: Mapping[str, float],
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return states after a time, one per lane: x (lanes,) [m] and y, psi, v, r, rudder (lanes, 5)."""
    # rates (lanes,) [rad/s]; push (lanes, 2) [N, N m]. A lane that meets a bank stays there.
    points = np.empty((len(x), len(MOTION)))
    points[:, 0], points[:, 1:3], points[:, 3], points[:, 4:] = x, states[:, :2], speed, states[:, 2:4]
    start = np.empty((len(x), len(lanes.actuators)))
    for number, name in enumerate(lanes.actuators):
        start[:, number] = states[:, RUDDER] if name == "rudder" else positions[name]
    end = start.copy()
    end[:, lanes.actuators.index("rudder")] += rates * time
    after = lanes.advance(points, time, start, end, None, push, settings.STEPS)
    reached = np.empty_like(states)
    reached[:, :2], reached[:, 2:4], reached[:, RUDDER] = after[:, 1:3], after[:, 4:], states[:, RUDDER] + rates * time
    return after[:, 0], reached


# Steady states as the reference of a plan, (places, 5), at places along the line.
Reference = Callable[[np.ndarray], np.ndarray]

# DAQP's infinite bound.
WITHOUT_BOUND = 1e20


@dataclass(frozen=True)
class RudderPlan:
    """A plan: nodes at the start and after each interval, and the rudder rates between them."""

    x: np.ndarray  # (intervals + 1,) Along the line [m]
    states: np.ndarray  # (intervals + 1, 5) y [m], psi [rad], v [m/s], r [rad/s], rudder [rad]
    rates: np.ndarray  # (intervals,) Rate of the rudder [rad/s]

    def from_here(self, x: float, state: np.ndarray, share: float = 0.0) -> "RudderPlan":
        """Return the plan a share of an interval later, with places along the line relative to the ship."""
        nodes = np.column_stack([self.x, self.states, np.append(self.rates, 0.0)])
        table = compiled_loops(plan_loops).interpolate(nodes, 1.0, np.arange(len(nodes)) + share)
        places, states, rates = table[:, 0].copy(), table[:, 1:-1].copy(), table[:-1, -1].copy()
        places, states[0] = x + np.maximum(places - places[0], 0.0), state
        count = min(int(np.ceil(share)), len(rates))
        if count:  # The last place is repeated, and the ship goes on at its speed
            places[-count:] = places[-count - 1] + (self.x[-1] - self.x[-2]) * np.arange(1, count + 1)
        return RudderPlan(places, states, rates)


class QuadraticProgram(NamedTuple):
    """Minimise z' H z / 2 + f' z within bounds; z holds the changes of the rates and the lack of clearance."""

    H: np.ndarray  # (n, n) Positive definite
    f: np.ndarray  # (n,) Linear cost
    rows: np.ndarray  # (m, n) Rows of the constraints
    lower: np.ndarray  # (n + m,) Lower bounds of z, then of the rows
    upper: np.ndarray  # (n + m,) Upper bounds, likewise


@dataclass(frozen=True)
class Horizon:
    intervals: int  # Number of intervals
    interval: float  # Length of each [s]

    @property
    def period(self) -> float:
        """Time between plans [s]."""
        return self.interval / settings.PLANS_AN_INTERVAL

    @property
    def time(self) -> float:
        return self.intervals * self.interval


class Planner:
    def __init__(
        self, ship: SimulatedShip, waterway: "Waterway | None", water: WaterAhead, horizon: Horizon,
        margins: np.ndarray, weights: Weights, positions: Mapping[str, float],
    ) -> None:  # fmt: skip
        # margins (intervals,): distance between hull and bank after each interval [m]; positions of other actuators
        self.water, self.horizon, self.margins = water, horizon, margins
        self.weights, self.positions = weights, positions
        # One lane per interval
        self.lanes = ShipLanes(ship, MOTION, horizon.intervals, waterway, pushed=True, endless=True)
        linear = ship.system().linearisation(ship.values(**positions), ship.actuators, water.section)
        self.jacobians = linear.batch(horizon.intervals)  # One point per interval
        hull, gear = ship.model.configuration.ship, ship.model.configuration.gear
        self.hull = hull.length / 2, hull.beam / 2  # [m]
        self.limits = gear.limit, gear.rate  # [rad, rad/s]

    def first(self, x: float, state: np.ndarray, speed: float, reference: Reference) -> RudderPlan:
        """Return a starting plan: on the steady course, the rudder still."""
        horizon = self.horizon
        current = self.water.at(np.array([x]))["current"]
        places = x + (speed + current) * horizon.interval * np.arange(horizon.intervals + 1)
        states = reference(places)
        states[:, RUDDER], states[0] = state[RUDDER], state
        return RudderPlan(places, states, np.zeros(horizon.intervals))

    def improve(
        self, plan: RudderPlan, speed: float, push: np.ndarray, reference: Reference, beyond: np.ndarray
    ) -> RudderPlan | None:  # fmt: skip
        """Return the plan after a step of sequential quadratic programming; None if the program has no solution."""
        interval, nodes = self.horizon.interval, plan.states.copy()
        nodes[1:] = self._within_domain(self.water.at(plan.x[1:]), nodes[1:], speed)
        plan, pushes = replace(plan, states=nodes), np.tile(push, (self.horizon.intervals, 1))
        states, rates, at = plan.states[:-1], plan.rates, self.positions
        end, reached = predict(self.lanes, plan.x[:-1], states, speed, rates, pushes, interval, at)
        A, integral = over_interval(self._slopes(plan, end, reached, speed), interval)
        e, G = compiled_loops(plan_loops).condensed(A, integral[..., RUDDER], reached - plan.states[1:])
        x = np.append(plan.x[0], plan.x[0] + np.cumsum(end - plan.x[:-1]))
        program = self._program(replace(plan, x=x), e, G, reference(x)[1:], beyond)
        z = solve_program(program)
        if z is None:
            return None
        states = plan.states.copy()
        states[1:] += e + G @ z[:-1]
        return RudderPlan(x, states, plan.rates + z[:-1])

    def _within_domain(self, there: Mapping[str, np.ndarray], states: np.ndarray, speed: float) -> np.ndarray:
        """Limit states to the model's domain: clear of the banks, not across the canal, finite rates."""
        (half_length, half_beam), limited = self.hull, states.copy()
        middle = (there["keel_starboard"] - there["keel_port"]) / 2
        limited[:, 1] = psi = np.clip(states[:, 1], -settings.MOST_HEADING, settings.MOST_HEADING)
        reach = half_length * np.abs(np.sin(psi)) + (1 + settings.LEAST_CLEARANCE) * half_beam
        room = np.maximum((there["keel_starboard"] + there["keel_port"]) / 2 - reach, 0.0)
        limited[:, 0] = middle + np.clip(states[:, 0] - middle, -room, room)
        most = np.array([settings.MOST_DRIFT * speed, settings.MOST_TURN * speed / half_length])
        limited[:, 2:4] = np.clip(states[:, 2:4], -most, most)
        return limited

    def _slopes(self, plan: RudderPlan, end: np.ndarray, reached: np.ndarray, speed: float) -> np.ndarray:
        """Derivatives of the rates by the state in the middle of each interval."""
        x = (plan.x[:-1] + end) / 2
        there = self.water.at(x)
        middle = self._within_domain(there, (plan.states[:-1] + reached) / 2, speed)
        y, psi, v, r, rudder = middle.T
        at = {"psi": psi, "u": speed, "v": v, "r": r, "rudder": rudder, **self.positions}
        section = {name: there[name] for name in self.water.section}
        jacobians = self.jacobians({**at, **section, "y": y - there["middle"]})
        line = {name: there[name] for name in ("curvature", "current")}
        linear = along_line(jacobians, {**at, **line, "y": y})
        slopes = np.zeros((len(x), len(HELD), len(HELD)))
        slopes[:, : len(MOVED)] = linear[:, MOVED][:, :, [*MOVED, len(LINEARISED) + 3]]
        return slopes

    def _program(
        self, plan: RudderPlan, e: np.ndarray, G: np.ndarray, reference: np.ndarray, beyond: np.ndarray
    ) -> QuadraticProgram:  # fmt: skip
        nodes, x, loops = plan.states[1:], plan.x[1:], compiled_loops(plan_loops)
        cost = tracking_cost(nodes + e - reference, G, plan.rates, self.weights.states, self.weights.rate, beyond)
        off, by_heading, ahead = loops.corner_offsets(nodes, *self.hull, self.water.at(x)["curvature"])
        there = self.water.at((x + ahead).ravel())
        walls = [there[name].reshape(ahead.shape) - self.margins for name in ("keel_starboard", "keel_port")]
        clearance = loops.clearance_rows(off, by_heading, e, G, *walls, settings.FREE_CLEARANCE * self.hull[1])
        # The rudder after each interval, and how changes of the rates move it.
        rudders = nodes[:, RUDDER] + e[:, RUDDER], G[:, RUDDER]
        return program_of(cost, plan.rates, rudders, clearance, self.limits, self.hull[1])


def tracking_cost(
    off: np.ndarray, G: np.ndarray, rates: np.ndarray, weights: np.ndarray, by_rate: float, beyond: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return H and f of the cost of deviations from the reference and of turning the rudder."""
    weighted, rows = weights.reshape(-1, 1) * G, (-1, len(rates))
    weighted[-1] = beyond @ G[-1]
    H = by_rate * np.eye(len(rates)) + G.reshape(rows).T @ weighted.reshape(rows)
    return H, by_rate * rates + off.ravel() @ weighted.reshape(rows)


def program_of(
    cost: tuple[np.ndarray, np.ndarray], rates: np.ndarray, rudders: tuple[np.ndarray, np.ndarray],
    clearance: tuple[np.ndarray, np.ndarray], limits: tuple[float, float], half_beam: float,
) -> QuadraticProgram:  # fmt: skip
    """Combine cost and constraints; clearance may fall short at a cost."""
    n = len(rates)
    H, f = np.diag(np.full(n + 1, settings.SHORT_SQUARED)), np.full(n + 1, settings.SHORT)
    H[:n, :n], f[:n] = cost
    (angle, by_rate), (rows, bounds), (most, fastest) = rudders, clearance, limits
    A = np.zeros((n + len(rows), n + 1))
    A[:n, :n], A[n:, :n], A[n:, n] = by_rate, rows, -half_beam
    lower = np.concatenate([-fastest - rates, [0.0], -most - angle, np.full(len(rows), -WITHOUT_BOUND)])
    upper = np.concatenate([fastest - rates, [WITHOUT_BOUND], most - angle, bounds])
    return QuadraticProgram(H, f, A, lower, upper)


def solve_program(program: QuadraticProgram) -> np.ndarray | None:
    """Solve by DAQP: z, or None if it finds no solution."""
    # Arnstrom, Bemporad and Axehill (2022), A dual active-set solver for embedded quadratic programming using
    # recursive LDL^T updates, IEEE Transactions on Automatic Control 67(8), 4362-4369.
    with needs("control", "a predictive helm"):
        import daqp
    if not math.isfinite(program.H.sum() + program.f.sum() + program.rows.sum() + program.upper.sum()):
        return None
    H, f, rows, lower, upper = program
    z, _, flag, _ = daqp.solve(H, f, rows, upper, lower, None, iter_limit=settings.MOST_ITERATIONS)
    return z if flag > 0 and np.isfinite(z).all() else None


def horizon_of(passing: float, horizon: float | None, intervals: int) -> Horizon:
    check_count("intervals", intervals, 2, settings.MOST_INTERVALS)
    if horizon is not None and not 0 < horizon < np.inf:
        raise InputError(f"horizon = {horizon} must be a positive time in seconds")
    return Horizon(intervals, (settings.HORIZON_LENGTHS * passing if horizon is None else horizon) / intervals)
