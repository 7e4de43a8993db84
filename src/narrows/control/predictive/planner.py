"""Plans of the rudder: from the last plan to the next by a step of sequential quadratic programming."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from narrows.codegen.linearisation import LINEARISED, JacobianBatch
from narrows.control.predictive.clearance_rows import clearance_rows, corner_offsets
from narrows.control.predictive.condensing import condensed
from narrows.control.predictive.horizon import Horizon, later
from narrows.control.predictive.line_frame import FORCED, MOVED, RUDDER, line_slopes, over_interval
from narrows.control.predictive.linear_quadratic import Weights
from narrows.control.predictive.prediction_lanes import PredictionLanes
from narrows.control.predictive.push_estimate import Push
from narrows.control.predictive.quadratic_program import (
    QuadraticProgram,
    program_of,
    rudder_rows,
    solution,
    tracking_cost,
)
from narrows.control.predictive.water_ahead import SECTION, WaterAhead, share_of
from narrows.simulation.ship import SimulatedShip

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

# The steady states that a plan is drawn to, (places, 5), at places along the line.
Reference = Callable[[np.ndarray], np.ndarray]
MOST_HEADING = np.radians(25.0)
# Heading off [rad], room to a bank in half beams, sway velocity over speed and yaw rate by half length over speed,
# beyond which no plan is linearised.
LEAST_ROOM, MOST_DRIFT, MOST_TURN = 0.2, 0.5, 1.0
# Half beams of room beyond the margin from which a corner needs no row: from one plan to the next none is used up.
SPARE = 4.0


@dataclass(frozen=True)
class RudderPlan:
    """A plan: nodes at the start and after each interval, and the rates between them."""

    x: np.ndarray  # (intervals + 1,) Along the line [m]
    states: np.ndarray  # (intervals + 1, 5) y [m], psi [rad], v [m/s], r [rad/s], rudder [rad]
    rates: np.ndarray  # (intervals,) Of the rudder [rad/s]

    def from_here(self, x: float, state: np.ndarray, share: float = 0.0) -> "RudderPlan":
        """Return the plan a share of an interval later, its places along the line counted from where the ship is."""
        # x [m]; state (5,)
        places, states = later(self.x, share), later(self.states, share)
        pace = self.x[-1] - self.x[-2]
        places[1:] = x + np.maximum(places[1:] - places[0], 0.0)
        count = min(int(np.ceil(share)), len(self.rates))
        if count:  # the last node stays where it is, so that a ship goes on at its pace
            places[-count:] = places[-count - 1] + pace * np.arange(1, count + 1)
        places[0], states[0] = x, state
        rates = later(np.append(self.rates, 0.0), share)[:-1]
        return RudderPlan(places, states, rates)


@dataclass(frozen=True)
class Planner:
    """What makes plans of one ship."""

    horizon: Horizon  # How far ahead
    lanes: PredictionLanes  # One an interval
    jacobians: JacobianBatch  # Likewise
    water: WaterAhead  # Where it sails
    margins: np.ndarray  # (intervals,) Between hull and bank after each interval [m]
    hull: tuple[float, float]  # Half length and half beam [m]
    limits: tuple[float, float]  # Of the rudder's angle and rate [rad, rad/s]
    weights: Weights  # What is costly
    positions: Mapping[str, float]  # Of other actuators

    def first(self, x: float, state: np.ndarray, speed: float, reference: Reference) -> RudderPlan:
        """Return a plan to begin with: on the steady course, the rudder still."""
        # x [m]; state (5,); speed [m/s]
        horizon = self.horizon
        places = x + (speed + self.water.current) * horizon.interval * np.arange(horizon.intervals + 1)
        states = reference(places)
        states[:, RUDDER], states[0] = state[RUDDER], state
        return RudderPlan(places, states, np.zeros(horizon.intervals))

    def better(
        self, plan: RudderPlan, speed: float, push: Push, reference: Reference, beyond: np.ndarray, seconds: float = 0.0
    ) -> RudderPlan | None:  # fmt: skip
        """Return the plan after a step of sequential quadratic programming; None where the program has no answer."""
        # speed [m/s]; beyond (5, 5); seconds [s]
        interval, nodes = self.horizon.interval, plan.states.copy()
        nodes[1:] = self._within_reason(plan.x[1:], nodes[1:], speed)
        plan = RudderPlan(plan.x, nodes, plan.rates)
        there = self.water.at(plan.x[:-1])
        pushes, by_share = push.at(share_of(plan.states[:-1, 0], there))
        end, reached = self.lanes(plan.x[:-1], plan.states[:-1], speed, plan.rates, pushes, interval)
        slopes, by_force = self._slopes(plan, end, reached, speed)
        A, integral = over_interval(slopes, interval)
        # The push of an interval is that of the place where it begins.
        by_place = by_force @ (by_share * (2.0 / there["width"])[:, None])[:, :, None]
        A[:, :, 0] += (integral[:, :, FORCED] @ by_place)[:, :, 0]
        e, G = condensed(A, integral[..., RUDDER], reached - plan.states[1:], np.zeros(reached.shape[1]))
        x = np.append(plan.x[0], plan.x[0] + np.cumsum(end - plan.x[:-1]))
        program = self._program(RudderPlan(x, plan.states, plan.rates), e, G, reference(x)[1:], beyond)
        z = solution(program, seconds)
        if z is None:
            return None
        change = z[:-1]
        states = plan.states.copy()
        states[1:] += e + G @ change
        return RudderPlan(x, states, plan.rates + change)

    def _within_reason(self, x: np.ndarray, states: np.ndarray, speed: float) -> np.ndarray:
        """States where the ship's forces mean something: clear of the banks, not across the canal, not tumbling."""
        there, (half_length, half_beam) = self.water.at(x), self.hull
        psi = np.minimum(np.maximum(states[:, 1], -MOST_HEADING), MOST_HEADING)
        reach = half_length * np.abs(np.sin(psi)) + (1 + LEAST_ROOM) * half_beam
        middle = (there["keel_starboard"] - there["keel_port"]) / 2
        room = np.maximum((there["keel_starboard"] + there["keel_port"]) / 2 - reach, 0.0)
        sway, turn = MOST_DRIFT * speed, MOST_TURN * speed / half_length
        most = np.stack([room, np.full_like(room, sway), np.full_like(room, turn)], axis=1)
        off = states[:, [0, 2, 3]]
        off[:, 0] -= middle
        off = np.minimum(np.maximum(off, -most), most)
        return np.stack([off[:, 0] + middle, psi, off[:, 1], off[:, 2], states[:, 4]], axis=1)

    def _slopes(
        self, plan: RudderPlan, end: np.ndarray, reached: np.ndarray, speed: float
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Derivatives in the middle of each interval: of all rates by the state, of the forced ones by a push."""
        x = (plan.x[:-1] + end) / 2
        middle = self._within_reason(x, (plan.states[:-1] + reached) / 2, speed)
        there = self.water.at(x)
        y, psi, v, r, rudder = middle.T
        at = {"psi": psi, "u": speed, "v": v, "r": r, "rudder": rudder, **self.positions}
        section = {} if self.water.straight else {name: there[name] for name in SECTION}
        points = self.jacobians.points({**at, **section, "y": y - there["middle"]})
        linear, column = self.jacobians(points), len(LINEARISED) + 3
        slopes = line_slopes(linear, column, {**at, "y": y, "curvature": there["curvature"]}, self.water.current)
        return slopes, linear[:, MOVED[2:], len(LINEARISED) + 1 : len(LINEARISED) + 3]

    def _program(
        self, plan: RudderPlan, e: np.ndarray, G: np.ndarray, reference: np.ndarray, beyond: np.ndarray
    ) -> QuadraticProgram:  # fmt: skip
        nodes, x = plan.states[1:], plan.x[1:]
        cost = tracking_cost(nodes + e - reference, G, plan.rates, self.weights, beyond)
        off, by_heading, ahead = corner_offsets(nodes, *self.hull, self.water.at(x)["curvature"])
        clearance = clearance_rows((off, by_heading), e, G, self._room(x + ahead), SPARE * self.hull[1])
        return program_of(cost, plan.rates, rudder_rows(nodes, e, G), clearance, self.limits, self.hull[1])

    def _room(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far off the banks are beside each corner, less the margin."""
        there = self.water.at(x.ravel())
        starboard, port = (there[name].reshape(x.shape) - self.margins for name in ("keel_starboard", "keel_port"))
        return starboard, port


def planner_of(
    ship: SimulatedShip, waterway: "Waterway | None", water: WaterAhead, horizon: Horizon, margins: np.ndarray,
    weights: Weights, positions: Mapping[str, float],
) -> Planner:  # fmt: skip
    """Lay out what makes plans."""
    # margins (intervals,) [m]
    configuration = ship.model.configuration
    section = () if water.straight else SECTION
    linear = ship.system().linearisation(ship.values(**positions), ship.actuators, section)
    hull, gear = configuration.ship, configuration.gear
    return Planner(
        horizon, PredictionLanes(ship, waterway, horizon.intervals, **positions), linear.batch(horizon.intervals),
        water, margins, (hull.length / 2, hull.beam / 2), (gear.limit, gear.rate), weights, positions,
    )  # fmt: skip
