"""The orders of one voyage: what is seen made whole, the push estimated, a plan, and a helm for where there is none."""

import math
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np

from narrows.control.predictive.course_ahead import CourseAhead
from narrows.control.predictive.line_frame import FORCED, RUDDER
from narrows.control.predictive.planner import Planner, Reference, RudderPlan
from narrows.control.predictive.prediction_lanes import PredictionLanes
from narrows.control.predictive.push_estimate import Push, no_push, updated_push
from narrows.control.predictive.water_ahead import share_of
from narrows.simulation.controllers import VoyageState

# Of sequential quadratic programming, for a first plan.
FIRST_ROUNDS = 6
# Of the period, by which a plan may come early: times of steps are sums.
EARLY = 1e-6
# Of the rudder's limit, that holding an offset may take; where it takes more, the helm comes nearer the middle...
RESERVE = 0.7
# ... and goes back no faster than all the way in so many of the times in which the push is estimated.
RETURNING = 20.0


class Seen(NamedTuple):
    """A ship as the helm takes it to be."""

    t: float  # When [s]
    x: float  # Along the line [m]
    speed: float  # Surge velocity [m/s]
    state: np.ndarray  # (5,) y [m], psi [rad], v [m/s], r [rad/s], rudder [rad]


@dataclass
class VoyageOrders:
    """A function of time and state that gives rudder orders, with a memory."""

    # It keeps the ``push`` that it estimates, the ``plan``, the ``way`` that it has come from the offset, 0, to the
    # middle, 1, and how many orders it gave ``without_plan``.

    planner: Planner  # Makes plans
    course: CourseAhead  # That is to be held
    observer: PredictionLanes  # Says what was to be expected
    push_time: float  # In which the estimate of the push comes two thirds of the way [s]
    seconds: float = 0.0  # That a plan may take; 0 for no limit [s]
    push: Push = field(init=False)
    plan: RudderPlan | None = field(init=False, default=None)
    way: float = field(init=False, default=0.0)
    without_plan: int = field(init=False, default=0)
    _seen: Seen | None = field(init=False, default=None)
    _order: float = field(init=False, default=math.nan)

    def __post_init__(self) -> None:
        self.push = no_push(self.course.spread)

    def __call__(self, t: float, state: VoyageState) -> float:
        """Return the rudder order [rad], a finite number within its limit whatever is seen."""
        # t [s]
        if self._seen is None or t < self._seen.t:
            self._begin_anew()
        elif not t - self._seen.t >= self.planner.horizon.period * (1 - EARLY):
            return self._order  # a time that is no number among them
        with np.errstate(all="ignore"):  # of a state that is none of a ship, whose plan has no numbers
            return self._ordered(t if math.isfinite(t) else 0.0, state)

    def _ordered(self, t: float, state: VoyageState) -> float:
        """Look, estimate, plan, and order."""
        elapsed = t - self._seen.t if self._seen else 0.0
        expected = self._expected(state, elapsed)
        seen = _made_whole(t, state, expected)
        if self._seen is not None and np.isfinite([state.v, state.r]).all():
            self._estimate(seen, expected, elapsed)
        self._seen, rate = seen, self._rate(seen, elapsed)
        limit, fastest = self.planner.limits
        reach = max(elapsed, self.planner.horizon.period)
        order = seen.state[RUDDER] + min(max(rate, -fastest), fastest) * reach
        self._order = float(min(max(order, -limit), limit))
        return self._order

    def _begin_anew(self) -> None:
        self.plan, self._seen, self.push, self.way = None, None, no_push(self.course.spread), 0.0

    def _expected(self, state: VoyageState, elapsed: float) -> Seen:
        """What was to be expected now: the course to begin with, then the last state sailed on."""
        last = self._seen
        if last is None:
            begun = state.x if math.isfinite(state.x) else 0.0
            return Seen(0.0, begun, self.course.speed, self.course.track.at(np.array([begun]), self.push)[0])
        there = state.rudder if math.isfinite(state.rudder) else self._order
        rate = (there - last.state[RUDDER]) / elapsed
        x, both = np.full(2, last.x), np.tile(last.state, (2, 1))  # two lanes, each with its own rate
        pushes, _ = self.push.at(self._share(x, last.state[0]))
        x, after = self.observer(x, both, last.speed, np.full(2, rate), pushes, elapsed)
        after[0, RUDDER] = there
        return Seen(last.t + elapsed, float(x[0]), last.speed, after[0])

    def _estimate(self, seen: Seen, expected: Seen, elapsed: float) -> None:
        force_of = self.course.track.force_of[0, self.course.track.nearest(seen.x)]
        missing = force_of @ (seen.state - expected.state)[FORCED] / elapsed
        share = self._share(np.array([seen.x]), seen.state[0])
        self.push = updated_push(self.push, missing, float(share[0]), elapsed, self.push_time)

    def _share(self, x: np.ndarray, y: float) -> np.ndarray:
        return share_of(np.full(len(x), y), self.course.water.at(x))

    def _rate(self, seen: Seen, elapsed: float) -> float:
        """The rate of the rudder from now on, by a plan or by the best linear helm."""
        track, most = self.course.at_speed(seen.speed), RESERVE * self.planner.limits[0]
        nearer = elapsed / (RETURNING * self.push_time)
        self.way = max(track.held(seen.x, self.push, most), self.way - nearer)
        gains, beyond = self.course.regulated(seen.x, self.way)
        reference = partial(track.at, push=self.push, way=self.way)
        plan, rounds = self._to_begin_with(seen, elapsed, reference)
        for _ in range(rounds):
            better = self.planner.better(plan, seen.speed, self.push, reference, beyond, self.seconds)
            if better is None:
                self.plan, self.without_plan = None, self.without_plan + 1
                return float(np.nan_to_num(-gains @ (seen.state - reference(np.array([seen.x]))[0])))
            plan = better
        self.plan = plan
        return float(plan.rates[0])

    def _to_begin_with(self, seen: Seen, elapsed: float, reference: Reference) -> tuple[RudderPlan, int]:
        """The last plan as it is now, or a first one; how often it is to be bettered."""
        if self.plan is None:
            return self.planner.first(seen.x, seen.state, seen.speed, reference), FIRST_ROUNDS
        return self.plan.from_here(seen.x, seen.state, elapsed / self.planner.horizon.interval), 1


def _made_whole(t: float, state: VoyageState, expected: Seen) -> Seen:
    """What is seen, and what was expected where that is no number."""
    told = np.array([state.y, state.psi, state.v, state.r, state.rudder], float)
    whole = np.where(np.isfinite(told), told, expected.state)
    x = state.x if math.isfinite(state.x) else expected.x
    speed = state.u if math.isfinite(state.u) else expected.speed
    return Seen(t, x, speed, whole)
