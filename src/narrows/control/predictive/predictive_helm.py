"""Model predictive controller: plans the rudder for the minutes ahead and orders the first move."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, needs
from narrows.base.results import BaseSummary
from narrows.codegen.free_motion import STAGES
from narrows.control.predictive.course_ahead import FORCED, MOTION, RUDDER, CourseAhead, Weights, water_ahead
from narrows.control.predictive.planner import Horizon, Planner, RudderPlan, horizon_of, predict
from narrows.control.regulator import DEFAULT_WEIGHTS, RegulatorWeights
from narrows.control.settings import FIRST_ROUNDS, INTERVALS, MARGIN, PUSH_LENGTHS, RESERVE, RETURNING, TIME_TOLERANCE
from narrows.control.steady_course import check_holds, check_inside, check_rudder
from narrows.model.model import Model
from narrows.physics.propeller_and_rudder import gear_motion
from narrows.ship.actuators import SteeringGear
from narrows.simulation.controllers import VoyageState
from narrows.simulation.initial_state import self_propulsion
from narrows.simulation.inputs import check_waterway, finite_numbers
from narrows.simulation.kernel_run import ShipLanes
from narrows.simulation.ship import SimulatedShip

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


# Functions of a gear, for floats.
SCALARS: dict[str, Callable[..., Any]] = {
    "minimum": min, "maximum": max, "exp": math.exp, "choice": lambda test, over, under: over if test > 0 else under,
}  # fmt: skip


class Seen(NamedTuple):
    t: float  # Time [s]
    x: float  # Place along the line [m]
    speed: float  # Surge velocity [m/s]
    state: np.ndarray  # (5,) y [m], psi [rad], v [m/s], r [rad/s], rudder [rad]


@dataclass
class VoyageOrders:
    """A function of time and state that gives rudder orders, with a memory."""

    planner: Planner  # Makes plans
    course: CourseAhead  # The course to hold
    observer: ShipLanes  # Predicts the state for comparison
    push_time: float  # Time constant of the force estimate [s]
    gear: SteeringGear  # Gear that follows the orders
    push: np.ndarray = field(init=False)  # (2,) Estimated external force and moment [N, N m]
    plan: RudderPlan | None = field(init=False, default=None)
    way: float = field(init=False, default=0.0)  # From the offset, 0, to the middle, 1
    without_plan: int = field(init=False, default=0)  # Number of orders by the best linear helm
    _seen: Seen | None = field(init=False, default=None)
    _order: float = field(init=False, default=math.nan)
    _stages: list[float] = field(init=False, default_factory=list)  # Orders on their way to the rudder [rad]

    def __call__(self, t: float, state: VoyageState) -> float:
        """Return the rudder order [rad], a finite number within its limit for any input."""
        t, *numbers = (math.nan if number is None else number for number in (t, *state))
        state = VoyageState(*numbers)
        if self._seen is None or t < self._seen.t or t - self._seen.t > self.planner.horizon.time:
            self.plan, self._seen, self.push, self.way = None, None, np.zeros(2), 0.0
            self._order = math.nan
        elif not t - self._seen.t >= self.planner.horizon.period * (1 - TIME_TOLERANCE):
            return self._order  # also if the time is NaN
        with np.errstate(all="ignore"):  # an unphysical state has no plan
            return self._ordered(t if math.isfinite(t) else 0.0, state)

    def _ordered(self, t: float, state: VoyageState) -> float:
        elapsed = t - self._seen.t if self._seen else 0.0
        expected = self._expected(state, elapsed)
        # A gap in the readings is filled by what is expected.
        sensed = np.array([state.x, state.u, state.y, state.psi, state.v, state.r, state.rudder], float)
        whole = np.where(np.isfinite(sensed), sensed, [expected.x, expected.speed, *expected.state])
        seen = Seen(t, float(whole[0]), float(whole[1]), whole[2:])
        if self._seen is not None and np.isfinite([state.v, state.r]).all():
            force_of = self.course.track.force_of[0, self.course.track.nearest(seen.x)]
            missing = force_of @ (seen.state - expected.state)[FORCED] / elapsed
            self.push = update_push(self.push, missing, elapsed, self.push_time)
        if not math.isfinite(self._order):
            self._order = float(seen.state[RUDDER])
            self._stages = [self._order] * STAGES
        elif self.gear.delay:
            self._stages = self._turned(float(seen.state[RUDDER]), self._stages, elapsed)[1]
        self._seen, actuated = seen, self._at_actuation(seen)
        rate = self._rate(actuated, elapsed)
        limit, fastest = self.planner.limits
        reach = max(elapsed, self.planner.horizon.period)
        order = actuated.state[RUDDER] + min(max(rate, -fastest), fastest) * reach
        self._order = float(min(max(order, -limit), limit))
        return self._order

    def _at_actuation(self, seen: Seen) -> Seen:
        """Predict the state at the time when the steering gear starts to follow the next order."""
        # The rudder is then at the last order, not at the indicated angle, which lags it.
        stages, delay = self._stages, self.gear.delay
        parts = math.ceil(2 * delay / self.planner.horizon.interval)
        for _ in range(parts):
            turned, stages = self._turned(float(seen.state[RUDDER]), stages, delay / parts)
            seen = self._predicted(seen, turned, delay / parts)
        return seen._replace(state=np.append(seen.state[:RUDDER], self._order))

    def _turned(self, rudder: float, stages: list[float], time: float) -> tuple[float, list[float]]:
        """Return how far the last orders turn the rudder in a time [rad], and the orders still on their way."""
        gear = {of.removeprefix("rudder_"): value for of, value in self.gear.values().items()}
        return gear_motion(self._order, rudder, stages, gear, time, SCALARS)

    def _expected(self, state: VoyageState, elapsed: float) -> Seen:
        """Return the expected state now: the course at first, then a prediction from the last state."""
        last = self._seen
        if last is None:
            begun = state.x if math.isfinite(state.x) else 0.0
            return Seen(0.0, begun, self.course.speed, self.course.track.at(np.array([begun]), self.push)[0])
        there = state.rudder if math.isfinite(state.rudder) else self._order
        return self._predicted(last, there - last.state[RUDDER], elapsed)

    def _predicted(self, seen: Seen, turned: float, time: float) -> Seen:
        x, states = np.full(2, seen.x), np.tile(seen.state, (2, 1))  # One lane alone would share its inputs
        rates, push, positions = np.full(2, turned / time), np.tile(self.push, (2, 1)), self.planner.positions
        places, after = predict(self.observer, x, states, seen.speed, rates, push, time, positions)
        return Seen(seen.t + time, float(places[0]), seen.speed, after[0])

    def _rate(self, seen: Seen, elapsed: float) -> float:
        """Return the rate of the rudder from now on, by a plan or by the best linear helm."""
        track, most = self.course.at_speed(seen.speed), RESERVE * self.planner.limits[0]
        nearer = elapsed / (RETURNING * self.push_time)
        self.way = max(track.held(seen.x, self.push, most), self.way - nearer)
        gains, beyond = self.course.regulated(seen.x, self.way)
        reference = partial(track.at, push=self.push, way=self.way)
        if self.plan is None:
            plan, rounds = self.planner.first(seen.x, seen.state, seen.speed, reference), FIRST_ROUNDS
        else:
            plan, rounds = self.plan.from_here(seen.x, seen.state, elapsed / self.planner.horizon.interval), 1
        for _ in range(rounds):
            better = self.planner.improve(plan, seen.speed, self.push, reference, beyond)
            if better is None:
                self.plan, self.without_plan = None, self.without_plan + 1
                return float(np.nan_to_num(-gains @ (seen.state - reference(np.array([seen.x]))[0])))
            plan = better
        self.plan = plan
        return float(plan.rates[0])


def update_push(push: np.ndarray, residual: np.ndarray, elapsed: float, time: float) -> np.ndarray:
    """Return the estimate of an external force and moment (2,) [N, N m] after another residual: a low-pass filter."""
    # Muske and Badgwell (2002), Disturbance modeling for offset-free linear model predictive control, Journal of
    # Process Control 12(5), 617-632: the Kalman filter of a random walk has a constant gain.
    return push - math.expm1(-elapsed / time) * residual if np.isfinite(residual).all() else push


@accept_aliases
@dataclass(frozen=True, repr=False)
class PredictiveHelm(BaseSummary):
    """A helm that holds an offset by linear time-varying predictive control.

    At every step it predicts the motion by the ship's own equations, takes their exact derivatives, and solves a
    quadratic program for the rudder rates ahead: within the limits of the gear, clear of both banks, towards the steady
    course for bends and narrowings. It estimates an unexplained force, so that no steady error stays. If the program
    has no solution, the best linear helm about the same course steers. It is for single voyages: ``simulate(model, ...,
    controller=helm)``.

    Source: Diehl, Bock and Schloeder (2005), A real-time iteration scheme for nonlinear optimization in optimal
    feedback control, SIAM Journal on Control and Optimization 43(5), 1714-1736.
    """

    model: Model  # Has terms of a rudder; the covariance of its coefficients widens the margin to the banks
    y: float = 0.0  # Offset to hold, to starboard of the line [m]; without clearance there, the nearest possible
    u: float = 1.0  # Design surge velocity [m/s]; during a voyage it uses the measured one
    # Waterway instead of the model's own canal; beyond its ends the section is assumed constant
    waterway: "Waterway | None" = None
    margin: float | None = None  # Least distance between hull and bank [m]; 0.15 beams unless given
    confidence: float = 0.95  # Probability that the hull stays clear, given uncertain coefficients [1]
    horizon: float | None = None  # Length of plans [s]; the time of 2.4 ship lengths unless given
    intervals: int = INTERVALS  # Number of intervals of a plan, each with one rudder rate
    revolutions: float | None = None  # Propeller revolutions [1/s]; those that keep the speed unless given
    weights: RegulatorWeights = DEFAULT_WEIGHTS  # Weights of offset, heading, rudder and stroke time in a plan

    def __post_init__(self) -> None:
        check_rudder(self.model)
        check_waterway(self.waterway)
        given = {name: getattr(self, name) for name in ("y", "u", "confidence", "margin", "revolutions")}
        finite_numbers(**{name: value for name, value in given.items() if value is not None})
        if not self.u > 0:
            raise InputError(f"u = {self.u:g} m/s: a rudder steers nothing without way; give a speed over 0")
        if not 0.5 <= self.confidence < 1:
            raise InputError(f"confidence = {self.confidence:g} must be a share from 0.5 to less than 1")
        if self.margin is not None and self.margin < 0:
            raise InputError(f"margin = {self.margin:g} m: plans with it reach into the bank; give a distance from 0")
        if self.revolutions is not None and not self.model.terms.propelled:
            raise InputError("revolutions change nothing here: this model has no terms of a propeller; leave them out")
        ship, canal = self.model.configuration.ship, self.model.configuration.canal
        if self.waterway is None:
            check_inside(self.y, canal.width, ship.beam)
        else:
            self.waterway.check_fits(ship)
        self._horizon()
        with needs("control", "a predictive helm"):
            import daqp  # noqa: F401

    def _horizon(self) -> Horizon:
        passing = self.model.configuration.ship.length / self.u
        return horizon_of(passing, self.horizon, self.intervals)

    def summary(self) -> str:
        horizon, where = self._horizon(), "" if self.waterway is None else f" of {self.waterway.name}"
        plans = f"plans {horizon.time:.3g} s ahead every {horizon.period:.2g} s"
        return f"holds y = {self.y:g} m{where} at {self.u:g} m/s, {plans}"

    def begin(self) -> VoyageOrders:
        """Return the orders of one voyage, with a memory of their own."""
        ship, hull, horizon = SimulatedShip(self.model), self.model.configuration.ship, self._horizon()
        positions, passing = {}, hull.length / self.u
        if self.model.terms.propelled:
            turns = self_propulsion(self.model, self.u) if self.revolutions is None else self.revolutions
            positions["revolutions"] = turns
        weights = Weights.of(self.weights, hull.beam / 2, passing)
        margin = MARGIN * hull.beam if self.margin is None else self.margin
        water = water_ahead(self.model, self.waterway)
        course = CourseAhead(ship, water, self.y, self.u, margin, positions, weights, horizon.interval)
        if self.waterway is None:
            track, place = course.track, course.narrowest
            held = track.states[0, place, RUDDER] if track.known[0, place] else math.nan
            check_holds(self.model, held, self.y, self.u)
        margins = course.margins(horizon.intervals, self.confidence)
        planner = Planner(ship, self.waterway, water, horizon, margins, weights, positions)
        observer = ShipLanes(ship, MOTION, 2, self.waterway, pushed=True, endless=True)
        gear = self.model.configuration.gear
        return VoyageOrders(planner, course, observer, PUSH_LENGTHS * passing, gear)
