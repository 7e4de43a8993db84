"""A predictive helm: at every turn it plans the rudder for the minutes ahead, and orders the plan's beginning."""

import math
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

from narrows.control.predictive.course_ahead import CourseAhead
from narrows.control.predictive.horizon import INTERVALS, Horizon, horizon_of
from narrows.control.predictive.line_frame import RUDDER
from narrows.control.predictive.linear_quadratic import weights_of
from narrows.control.predictive.planner import planner_of
from narrows.control.predictive.prediction_lanes import PredictionLanes
from narrows.control.predictive.push_estimate import LENGTHS
from narrows.control.predictive.voyage_orders import VoyageOrders
from narrows.control.predictive.water_ahead import water_ahead
from narrows.control.self_propulsion import self_propulsion
from narrows.control.steady_course import check_inside, check_rudder
from narrows.errors import InputError, needs
from narrows.model.model import Model
from narrows.results import Described
from narrows.simulation.inputs import check_waterway, finite_numbers
from narrows.simulation.ship import SimulatedShip

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

# Beams between hull and bank, at least, unless a margin is given.
MARGIN = 0.15


@dataclass(frozen=True, repr=False)
class PredictiveHelm(Described):
    """A helm that holds an offset by linear time-varying predictive control.

    At every turn it predicts the motion by the ship's own equations, takes their exact derivatives along the way, and
    solves a quadratic program for the rudder's rates ahead: within the limits of the gear, clear of both banks, to the
    steady course that bends and narrowings ask for. A force that the model does not explain is estimated, so that no
    steady error stays. Where the program has no answer in time, the best linear helm about the same course steers. It
    steers single voyages: ``simulate(model, ..., controller=helm)``.

    Parameters
    ----------
    model : Model
        With terms of a rudder; the covariance of its coefficients widens the margin to the banks.
    y : float [m]
        Offset to hold, to starboard of the line; where there is no room for it, the nearest to it that there is.
    u : float [m/s]
        Surge velocity that it is laid out for; while sailing it takes the one that it sees.
    waterway : Waterway, optional
        Where it sails instead of the model's own canal; beyond its ends it is taken to go on as it ends.
    margin : float [m], optional
        Between hull and bank, at least; 0.15 beams unless given.
    confidence : float [1]
        With which the hull is to be clear in spite of coefficients that are not known.
    horizon : float [s], optional
        How far plans reach; the time of 2.4 ship lengths unless given.
    intervals : int
        Of a plan, in each of which the rudder turns at one rate.
    period : float [s], optional
        Between plans; a fifth of an interval unless given.
    revolutions : float [1/s], optional
        Of a propeller; those that keep the speed unless given.
    seconds : float [s]
        That a plan's program may take; 0 for no limit.

    Raises
    ------
    InputError
        Where the model has no rudder, the hull is in a bank at the offset, a number is none, or DAQP is not installed
        (``pip install narrows[control]``).

    References
    ----------
    Diehl, Bock and Schloeder (2005), A real-time iteration scheme for nonlinear optimization in optimal feedback
    control, SIAM Journal on Control and Optimization 43(5), 1714-1736.
    """

    model: Model
    y: float = 0.0
    u: float = 1.0
    waterway: "Waterway | None" = None
    margin: float | None = None
    confidence: float = 0.95
    horizon: float | None = None
    intervals: int = INTERVALS
    period: float | None = None
    revolutions: float | None = None
    seconds: float = 0.0

    def __post_init__(self) -> None:
        check_rudder(self.model)
        check_waterway(self.waterway)
        given = {"margin": self.margin, "revolutions": self.revolutions}
        finite_numbers(
            y=self.y, u=self.u, confidence=self.confidence, seconds=self.seconds,
            **{name: value for name, value in given.items() if value is not None},
        )  # fmt: skip
        if not self.u > 0:
            raise InputError(f"u = {self.u:g} m/s: a rudder steers nothing without way; give a speed over 0")
        if not 0.5 <= self.confidence < 1:
            raise InputError(f"confidence = {self.confidence:g} must be a share from 0.5 to less than 1")
        if self.seconds < 0 or (self.margin is not None and self.margin < 0):
            raise InputError("a margin and the seconds of a plan are numbers from 0; give such")
        if self.revolutions is not None and not self.model.terms.propelled:
            raise InputError("revolutions change nothing here: this model has no terms of a propeller; leave them out")
        self._check_room()
        self._horizon()
        with needs("control", "a predictive helm"):
            if find_spec("daqp") is None:
                raise ImportError

    def _check_room(self) -> None:
        ship, canal = self.model.configuration.ship, self.model.configuration.canal
        if self.waterway is None:
            check_inside(self.y, canal.width, ship.beam)
        else:
            self.waterway.check_fits(ship)

    def _horizon(self) -> Horizon:
        passing = self.model.configuration.ship.length / self.u
        return horizon_of(passing, self.horizon, self.intervals, self.period)

    def summary(self) -> str:
        """Say what it holds, how far it looks ahead, and how often."""
        horizon = self._horizon()
        where = "" if self.waterway is None else f" of {self.waterway.name}"
        return (
            f"holds y = {self.y:g} m{where} at {self.u:g} m/s, plans {horizon.time:.3g} s ahead every "
            f"{horizon.period:.2g} s"
        )

    def begin(self) -> VoyageOrders:
        """Return what gives the orders of one voyage, with a memory of its own.

        Raises
        ------
        InputError
            Where no rudder holds the ship at the offset, or turns it at all.
        """
        ship, hull, horizon = SimulatedShip(self.model), self.model.configuration.ship, self._horizon()
        positions = self._positions()
        passing = hull.length / self.u
        weights = weights_of(hull.beam / 2, passing)
        margin = MARGIN * hull.beam if self.margin is None else self.margin
        water = water_ahead(self.model, self.waterway)
        course = CourseAhead(ship, water, self.y, self.u, margin, positions, weights, horizon.interval)
        if self.waterway is None:
            held = course.track.known[0, 0]
            self._check_held(float(course.track.states[0, 0, RUDDER]) if held else math.inf)
        margins = course.margins(horizon.intervals, self.confidence)
        planner = planner_of(ship, self.waterway, water, horizon, margins, weights, positions)
        observer = PredictionLanes(ship, self.waterway, 2, **positions)
        return VoyageOrders(planner, course, observer, LENGTHS * passing, self.seconds)

    def _positions(self) -> dict[str, float]:
        if not self.model.terms.propelled:
            return {}
        turns = self_propulsion(self.model, self.u) if self.revolutions is None else self.revolutions
        return {"revolutions": turns}

    def _check_held(self, rudder: float) -> None:
        limit = self.model.configuration.gear.limit
        if not abs(rudder) < limit:
            raise InputError(
                f"no rudder to {math.degrees(limit):g} degrees holds this ship {self.y:g} m off the middle at "
                f"{self.u:g} m/s; choose a place nearer to it"
            )
