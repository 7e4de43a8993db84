"""The five-minute experiment: a ship held to one side, then to the other, and the steady rudder and drift read."""

from typing import Any

from narrows.control.steady_course import check_inside, check_rudder
from narrows.errors import InputError
from narrows.logbook.learned_coefficient import learned_coefficients
from narrows.logbook.learned_model import learned_model
from narrows.logbook.steady_legs.steady_fit import SteadyFit, shared_of, steady_checks
from narrows.logbook.steady_legs.steady_readings import ReadingErrors, SteadyConditions, steady_readings
from narrows.logbook.steady_legs.steady_update import SteadyProblem
from narrows.model.model import Model

NO_COVARIANCE = (
    "this model has no covariance of its coefficients, so nothing says what a record may change; identify it from "
    "tests, or state one"
)


def learn_steady(
    model: Model, observations: Any, *, errors: ReadingErrors | None = None, conditions: SteadyConditions | None = None
) -> SteadyFit:  # fmt: skip
    """Learn from a ship that was held off the middle: the steady rudder and drift, to both sides.

    The covariance of the model's coefficients is the prior, all of it, and the balance of sway and yaw on each leg
    updates it: exactly, for it is linear in the coefficients, and anew until nothing moves where errors of offset,
    speed and angles make it otherwise. No pilot enters. Wind and the zeros of the instruments are unknown and the same
    on all legs; the slope over both sides cancels them.

    Parameters
    ----------
    model : Model
        Of the ship at its own size in the canal of the legs, with the terms of a rudder and a covariance.
    observations : DataFrame, mapping of str to array, str or Path
        A row a leg: y [m], u [m/s], rudder, drift or heading, and their errors ``y_error`` and so on where they are
        known; SI and radians unless a header says otherwise (``rudder [deg]``).
    errors : ReadingErrors, optional
        Where the rows do not say.
    conditions : SteadyConditions, optional
        How large wind and zeros may be, and what is left of motion on a leg.

    Returns
    -------
    SteadyFit
        The model after, what was learned of each coefficient, and whether legs and model agree.

    Raises
    ------
    InputError
        Where the model has no rudder or no covariance, or the rows are no legs of this ship in this canal.
    """
    check_rudder(model)
    check_covariance(model)
    readings, conditions = steady_readings(observations, errors), conditions or SteadyConditions()
    canal, ship = model.configuration.canal, model.configuration.ship
    check_inside(readings.values["y"], canal.width, ship.beam)
    problem = SteadyProblem.of(model, readings, conditions)
    found = problem.update(readings)
    checks = steady_checks(model, readings, found, problem.update)
    mean, covariance = found.posterior.mean, found.posterior.covariance
    count = len(model.terms.names)
    learned = learned_coefficients(model, mean[:count], covariance[:count, :count])
    after = learned_model(
        model, learned, covariance[:count, :count], f"learned from {readings.summary()} ({readings.source})",
        _ends(abs(readings.values["y"])), _ends(readings.values["u"]), checks.contradicted,
    )  # fmt: skip
    shared = shared_of(mean, covariance)
    return SteadyFit(after, model, readings, conditions, learned, shared, found.latent, checks)


def check_covariance(model: Model) -> None:
    """Raise where nothing says how far a model's coefficients are known."""
    if model.covariance is None:
        raise InputError(NO_COVARIANCE)


def _ends(column: Any) -> tuple[float, float]:
    return float(column.min()), float(column.max())
