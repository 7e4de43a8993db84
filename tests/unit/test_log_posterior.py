"""What is known after a log: a sum of squares as expected of one ship, and wider errors where it is larger."""

from dataclasses import replace

import numpy as np
import pytest
from narrows.logbook.shooting.log_problem import CoefficientPrior
from narrows.logbook.shooting.search_state import Found, RecordTold

import narrows as nw
from engine_models import steered
from narrows.logbook.learning.log_posterior import log_posterior
from narrows.logbook.learning.log_prior import coefficient_prior

FREE = frozenset(("b_bank", "c_bank", "b_uv"))


def ship() -> tuple[nw.Model, np.ndarray]:
    model = steered().with_coefficients(b_bank=0.3, c_bank=0.04)
    names = ("b_bank", "c_bank", "b_uv", "b_vdot")
    sizes = np.array([0.3 * abs(model[name]) if name in names else 0.0 for name in model.terms.names])
    mixed = 0.3 + 0.7 * np.eye(len(sizes))
    return model, mixed * np.outer(sizes, sizes)


def sure(prior: CoefficientPrior) -> np.ndarray:
    """No doubt of gusts."""
    return np.zeros((len(prior.names), 0))


def found(prior: CoefficientPrior, scaled: np.ndarray, information: np.ndarray) -> Found:
    told = RecordTold(information, np.zeros(len(scaled)), 0.0, None)
    return Found(scaled, (told,), 0.0)


@pytest.mark.parametrize("free", [None, FREE], ids=["all free", "inertia held"])
def test_a_log_of_the_same_ship_moves_as_far_as_expected(free: frozenset[str] | None) -> None:
    """Draws of the ship and of what its log tells, of the equations themselves."""
    model, covariance = ship()
    prior = coefficient_prior(model, covariance, "held", free)
    draw, count = np.random.default_rng(1), len(prior.names)
    root = draw.normal(size=(count, count))
    information = 20 * root @ root.T
    moves, squares = prior.moves, []
    for _ in range(400):
        truth = np.linalg.cholesky(np.linalg.inv(prior.precision)) @ draw.normal(size=count)
        pull = information @ truth + np.linalg.cholesky(information) @ draw.normal(size=count)
        scaled = np.zeros(count)
        scaled[moves] = np.linalg.solve((information + prior.precision)[np.ix_(moves, moves)], pull[moves])
        after = log_posterior(model, covariance, prior, found(prior, scaled, information), sure(prior))
        squares.append(after.disagreement / after.freedom)
    assert np.mean(squares) == pytest.approx(1.0, abs=0.1)


def test_a_log_that_disagrees_is_taken_for_less_sure() -> None:
    model, covariance = ship()
    prior = coefficient_prior(model, covariance, "held")
    count = len(prior.names)
    near, far = (
        log_posterior(model, covariance, prior, found(prior, np.full(count, size), 50 * np.eye(count)), sure(prior))
        for size in (0.5, 5.0)
    )
    assert near.widened == 1.0
    assert far.widened == pytest.approx(np.sqrt(far.disagreement / far.freedom))
    assert far.probability < 1e-3 < near.probability
    place = model.terms.names.index("c_bank")
    before, one, other = (matrix[place, place] for matrix in (covariance, near.covariance, far.covariance))
    assert one < other < before


def test_how_wide_windows_are_left_is_not_believed_to_the_end() -> None:
    """By half of what it moves the coefficients: with more records alike this is what stays."""
    model, covariance = ship()
    prior = coefficient_prior(model, covariance, "held")
    count = len(prior.names)
    slope, information = np.linspace(-1.0, 1.0, count), 50 * np.eye(count)
    without, *more = (
        log_posterior(
            model, covariance, prior, replace(found(prior, np.zeros(count), n * information), slope=own), sure(prior)
        )
        for n, own in ((1, 0.0), (1, slope), (400, 400 * slope))
    )
    by_it = 0.5 * (without.scaled * prior.moves) @ (slope * prior.moves)
    np.testing.assert_allclose(more[0].scaled, without.scaled + np.outer(by_it, by_it))
    assert not without.alike.any()
    assert (more[1].alike[prior.moves] >= more[0].alike[prior.moves]).all()
    assert np.diag(more[1].scaled).max() > 0.9 * by_it.max() ** 2


def test_what_gusts_may_be_is_in_the_intervals() -> None:
    """Of every coefficient, by how far it goes with them."""
    model, covariance = ship()
    prior = coefficient_prior(model, covariance, "held")
    count = len(prior.names)
    told, doubt = found(prior, np.zeros(count), 50 * np.eye(count)), np.linspace(0.0, 1.0, 2 * count).reshape(count, 2)
    without, other = (log_posterior(model, covariance, prior, told, own) for own in (sure(prior), doubt))
    np.testing.assert_allclose(other.scaled, without.scaled + doubt @ doubt.T)
    assert not other.alike.any()


def test_who_has_a_log_knows_no_less_than_who_has_none() -> None:
    """However far the width of the windows may have led it: only where it led does the doubt of it end at the prior."""
    model, covariance = ship()
    prior = coefficient_prior(model, covariance, "held")
    count = len(prior.names)
    slope = np.where(np.array(prior.names) == "c_bank", 1e4, 0.0)
    told = replace(found(prior, np.zeros(count), 50 * np.eye(count)), slope=slope)
    after = log_posterior(model, covariance, prior, told, sure(prior))
    before = np.linalg.inv(prior.precision)
    assert np.all(np.diag(after.scaled) <= np.diag(before) + 1e-12)
    place = prior.names.index("c_bank")
    assert after.scaled[place, place] == pytest.approx(before[place, place])
    assert np.linalg.eigvalsh(after.scaled).min() > 0
