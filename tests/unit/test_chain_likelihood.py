"""How sure gusts are, and how the coefficients follow them: by a likelihood that is known, and by the search itself."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from narrows.logbook.shooting import log_search, record_search
from narrows.logbook.shooting.chain_likelihood import SLOPE_STEP, SPREAD_OF_STRENGTH, GustJudge, gust_doubt
from narrows.logbook.shooting.log_search import evaluated
from narrows.logbook.shooting.search_state import samples_of
from test_log_search import Searched, done

__all__ = ["done"]


@dataclass(frozen=True)
class Known:
    """A normal likelihood of three numbers, which two coefficients follow straight."""

    precision: np.ndarray
    follows: np.ndarray

    @property
    def start(self) -> np.ndarray:
        return np.array([0.3, -1.0, 2.0])

    def unlikely(self, numbers: np.ndarray, copies: float) -> float:
        off = numbers - self.start
        return 7.0 + 0.5 * copies * float(off @ self.precision @ off)

    def followed(self, numbers: np.ndarray, copies: float) -> np.ndarray:
        return np.asarray(self.follows @ (numbers - self.start)) / copies**0.5


@pytest.mark.parametrize("copies", [1.0, 4.0])
def test_doubt_is_the_covariance_of_what_follows(copies: float) -> None:
    root = np.array([[2.0, 0.0, 0.0], [0.5, 1.5, 0.0], [-0.3, 0.4, 1.2]])
    judge: Any = Known(root @ root.T, np.array([[1.0, -2.0, 0.5], [0.2, 0.0, 3.0]]))
    doubt, known = gust_doubt(judge, copies), judge.follows @ np.linalg.inv(judge.precision) @ judge.follows.T
    np.testing.assert_allclose(doubt @ doubt.T, known / copies**2)


@pytest.mark.slow
def test_what_a_ship_does_that_passes_says_nothing_of_how_strong_gusts_are(done: Searched) -> None:
    """Of a record that is a meeting all through, strength is told by what was known before alone."""
    refined = done.refined
    samples = [
        sample._replace(grid=replace(sample.grid, meetings=np.ones(len(sample.grid), bool)))
        for sample in samples_of(done.source, refined.found, refined.states)
    ]
    judge = GustJudge(refined.problem, refined.found, samples, refined.usual)
    start, stronger = judge.start, judge.start + np.array([0.4, -0.3, 0.0, 0.0])
    usual = np.log(refined.usual.std[judge.places])
    known = [np.sum(((numbers[:2] - usual) / SPREAD_OF_STRENGTH) ** 2) / 2 for numbers in (start, stronger)]
    assert judge.unlikely(stronger) - judge.unlikely(start) == pytest.approx(known[1] - known[0], abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("place", range(4), ids=["sway", "yaw", "memory", "correlation"])
def test_coefficients_follow_gusts_as_the_equations_there_say(
    done: Searched, place: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A step by the equations with the other gusts, looked at anew, records where they are."""
    monkeypatch.setattr(record_search, "SETTLED", np.inf)
    problem, states = done.refined.problem, done.refined.states
    prior, moves = problem.prior, problem.prior.moves
    here = log_search._sloped(problem, done.at(done.refined.found.scaled), done.source, states)
    judge = GustJudge(problem, here, samples_of(done.source, here, states), done.refined.usual)
    beside = judge.start + SLOPE_STEP * np.eye(len(judge.start))[place]
    other = replace(problem, chain=judge.chain(beside))
    there = evaluated(other, here.scaled, done.source, states, range(9))
    assert there is not None
    there = log_search._sloped(other, there, done.source, states)
    matrix, pull = there.information + prior.precision, there.pull - prior.precision @ here.scaled
    step = np.linalg.solve(matrix[np.ix_(moves, moves)], pull[moves])
    np.testing.assert_allclose(judge.followed(beside)[moves], step, rtol=1e-6, atol=1e-9)
