"""What is known after a log: disagreement as expected of one ship, wider errors where scores of records scatter."""

from dataclasses import replace

import numpy as np
import pytest

import narrows as nw
from engine_models import steered
from narrows.logbook.filtering.log_problem import CoefficientPrior, LogProblem, StochasticModel
from narrows.logbook.learned_coefficients import LogPosterior, averaged, coefficient_prior, log_posterior
from narrows.logbook.learning.learn_log import rudder_matters

FREE = ("b_bank", "c_bank", "b_uv")


def ship() -> nw.Model:
    model = steered().with_coefficients(b_bank=0.3, c_bank=0.04)
    names = ("b_bank", "c_bank", "b_uv", "b_vdot")
    sizes = np.array([0.3 * abs(model[name]) if name in names else 0.0 for name in model.terms.names])
    mixed = 0.3 + 0.7 * np.eye(len(sizes))
    return replace(model, covariance=mixed * np.outer(sizes, sizes))


def after(
    prior: CoefficientPrior, scaled: np.ndarray, information: np.ndarray, scores: np.ndarray | None = None
) -> LogPosterior:
    problem = LogProblem(None, prior, None, StochasticModel((), {}))  # type: ignore[arg-type]
    return log_posterior(problem, scaled, information, scores)


def scaled(prior: CoefficientPrior, told: LogPosterior) -> np.ndarray:
    """Covariance of the estimated coefficients, in units of their standard deviations before."""
    places = [prior.model.terms.names.index(name) for name in prior.names]
    return told.covariance[np.ix_(places, places)] / np.outer(prior.scale, prior.scale)


@pytest.mark.parametrize("free", [(), FREE], ids=["all free", "inertia held"])
def test_a_log_of_the_same_ship_moves_and_errs_as_expected(free: tuple[str, ...]) -> None:
    """Draws of the ship and of its log by the linear equations; errors of held coefficients are part of the errors."""
    model = ship()
    prior = coefficient_prior(model, "held", free)
    draw, count = np.random.default_rng(1), len(prior.names)
    root = draw.normal(size=(count, count))
    information, squares, errors = 20 * root @ root.T, [], []
    places = [model.terms.names.index(name) for name in prior.names]
    for _ in range(400):
        truth = np.linalg.cholesky(np.linalg.inv(prior.precision)) @ draw.normal(size=count)
        pull = information @ truth + np.linalg.cholesky(information) @ draw.normal(size=count)
        told = after(prior, np.linalg.solve(information + prior.precision, pull), information)
        squares.append(told.disagreement / told.freedom)
        errors.append(told.values[places] - prior.mean - prior.scale * truth)
    assert np.mean(squares) == pytest.approx(1.0, abs=0.1)
    size = np.sqrt(np.diag(told.covariance)[places])
    correlation = told.covariance[np.ix_(places, places)] / np.outer(size, size)
    np.testing.assert_allclose(np.cov(np.transpose(errors / size)), correlation, atol=0.2)


def test_a_log_that_disagrees_is_unlikely() -> None:
    model = ship()
    prior = coefficient_prior(model, "held")
    count = len(prior.names)
    near, far = (after(prior, np.full(count, size), 50 * np.eye(count)) for size in (0.5, 5.0))
    assert far.probability < 1e-3 < near.probability
    place = model.terms.names.index("c_bank")
    assert near.covariance[place, place] < model.covariance[place, place]


@pytest.mark.parametrize("count", [5, 40])
def test_scores_that_scatter_more_than_expected_widen_the_answer(count: int) -> None:
    """As White's sandwich where there are many; as far as expected, they change it by chance alone."""
    model = ship()
    prior = coefficient_prior(model, "held")
    size, draw = len(prior.names), np.random.default_rng(2)
    expected = 50.0 * np.eye(size)
    once = draw.normal(size=(count, size)) * np.sqrt(50.0)
    answers = [scaled(prior, after(prior, np.zeros(size), count * expected, share * once)) for share in (0.0, 1.0, 3.0)]
    alone, usual, wide = (np.trace(answer) for answer in answers)
    assert alone <= usual < wide
    inverse = np.linalg.inv(count * expected + prior.precision)
    np.testing.assert_allclose(answers[0], inverse, atol=1e-10)
    centred = 3 * (once - once.mean(axis=0))
    sandwich = inverse @ (prior.precision + centred.T @ centred * count / (count - 1)) @ inverse
    assert (wide - alone) / (np.trace(sandwich) - alone) == pytest.approx(count / (count + 10), rel=0.25)


def test_one_record_has_no_scatter() -> None:
    model = ship()
    prior = coefficient_prior(model, "held")
    size = len(prior.names)
    told = after(prior, np.zeros(size), 50 * np.eye(size), np.full((1, size), 9.0))
    np.testing.assert_allclose(scaled(prior, told), np.linalg.inv(50 * np.eye(size) + prior.precision), atol=1e-10)


def test_the_average_of_two_models_has_the_moments_of_their_mixture() -> None:
    """Draws of either with the same probability."""
    model = ship()
    prior = coefficient_prior(model, "held")
    size = len(prior.groups)
    one, other = (after(prior, np.full(size, at), many * np.eye(size)) for at, many in ((0.2, 30.0), (-0.5, 80.0)))
    draw, both = np.random.default_rng(0), averaged(one, other)
    drawn = np.concatenate([
        draw.multivariate_normal(own.values, own.covariance, 200_000, method="eigh") for own in (one, other)
    ])  # fmt: skip
    place = model.terms.names.index("b_bank")
    assert both.values[place] == pytest.approx(drawn[:, place].mean(), rel=2e-3)
    assert both.covariance[place, place] == pytest.approx(drawn[:, place].var(), rel=1e-2)
    far = after(prior, np.full(size, 5.0), 50.0 * np.eye(size))
    assert averaged(far, one).probability == averaged(one, far).probability == one.probability


def test_a_pilot_who_sees_more_than_the_log_is_told_from_a_standard_error() -> None:
    model = ship()
    prior = coefficient_prior(model, "held")
    size = len(prior.groups)
    given, near, far = (after(prior, np.full(size, at), 30.0 * np.eye(size)) for at in (0.2, 0.25, -0.5))
    assert rudder_matters(model, given, near) == ()
    told = rudder_matters(model, given, far)
    assert [sentence.split()[0] for sentence in told] == ["b_bank", "c_bank"]
    assert f"{far.values[model.terms.names.index('b_bank')]:.3g} with a pilot's law" in told[0]
