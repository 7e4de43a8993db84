"""The fit to the later half of each run: forces that settle, and gauges that drift within a run, make it another."""

from narrows.identification.motions import DistinctMotions
from narrows.identification.regression.problem import Problem
from narrows.identification.uncertainty.error_model import covariance
from narrows.identification.uncertainty.linear_estimator import SecondEstimate, compared_with, estimator
from narrows.identification.uncertainty.second_level import in_halves
from narrows.identification.uncertainty.unbounded_fit import ErrorModel


def of_later_half(problem: Problem, motions: DistinctMotions, model: ErrorModel) -> SecondEstimate:
    """Compare the fit with that to the later half of each run."""
    # Both halves have a run's gain and zero, so that these do not part the two fits; a form error of each half does.
    level = in_halves(model.level, motions, problem).less(model.theta, model.held)
    later = level.d.copy()
    later[:, : model.level.d.shape[1]] = 0.0
    fitted = level.d @ model.theta
    v, shown = (covariance(level, fitted, model.errors, factor) for factor in (model.factor, model.factor_shown))
    return compared_with(level.d @ model.best.inverse.T, estimator(later), level.y, v, shown)
