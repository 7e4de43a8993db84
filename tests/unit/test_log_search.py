"""The search over the records of a log: each piece by differences of what it is the slope of."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from narrows.logbook.learning.refined_search import Refined
from narrows.logbook.shooting import log_search, record_search
from narrows.logbook.shooting.log_search import evaluated, searched
from narrows.logbook.shooting.search_state import Found
from test_learn_transits import ship, twin

import narrows as nw
from narrows.logbook.learning import learn_log, refined_search
from narrows.logbook.learning.posed_log import GridSource

pytestmark = pytest.mark.slow
SHORT = 300.0


class Searched(NamedTuple):
    """A search that is done, with its records."""

    refined: Refined
    source: GridSource

    def at(self, scaled: np.ndarray, found: Found | None = None) -> Found:
        """The records at their best for other coefficients, led there where it is told from where."""
        states = self.refined.states
        if found is not None:
            step = scaled - found.scaled
            states = tuple(replace(s, own=t.own_after(step)) for s, t in zip(states, found.told, strict=True))
        best = evaluated(self.refined.problem, scaled, self.source, states, range(9))
        assert best is not None
        return best


@pytest.fixture(scope="module")
def done() -> Searched:
    kept: list[Searched] = []
    usual = learn_log.refined_search

    def watched(problem: Any, source: GridSource) -> Refined:
        kept.append(Searched(usual(problem, source), source))
        return kept[-1].refined

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(learn_log, "refined_search", watched)
        nw.learn(ship(), [record.between(0.0, SHORT) for record in twin()[1]])
    return kept[0]


def test_records_that_follow_the_coefficients_begin_nearly_at_their_best(
    done: Searched, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To the first order: half the step leaves a quarter of the share that they miss."""
    found = done.at(done.refined.found.scaled)

    def missed(step: float) -> float:
        """Share of the cost of staying that is left after following."""
        beside = found.scaled + step * done.refined.problem.prior.moves
        best = done.at(beside, found)
        with monkeypatch.context() as patched:
            patched.setattr(record_search, "SETTLED", np.inf)
            stayed, led = (sum(told.best.band.cost for told in done.at(beside, start).told) for start in (None, found))
        least = sum(told.best.band.cost for told in best.told)
        return (led - least) / (stayed - least)

    assert missed(0.025) < 0.05
    assert missed(0.05) / missed(0.025) == pytest.approx(4, rel=0.1)


def test_the_pull_is_the_slope_of_the_likelihood(done: Searched) -> None:
    """Half of it, downhill, by central differences; how wide windows are left included."""
    problem, scaled = done.refined.problem, done.refined.found.scaled
    found = log_search._sloped(problem, done.at(scaled), done.source, done.refined.states)
    downhill = found.pull - problem.prior.precision @ scaled
    for place in np.flatnonzero(problem.prior.moves)[:4]:
        beside = 0.02 * (np.arange(len(scaled)) == place)
        up, down = (done.at(scaled + sign * beside).cost for sign in (1, -1))
        assert downhill[place] == pytest.approx((down - up) / 0.08, abs=0.05)


def test_the_slope_of_the_determinant_counts_that_starts_and_pushes_follow_the_coefficients(done: Searched) -> None:
    problem, scaled = done.refined.problem, done.refined.found.scaled
    found = log_search._sloped(problem, done.at(scaled), done.source, done.refined.states)
    for place in np.flatnonzero(problem.prior.moves):
        beside = 0.02 * (np.arange(len(scaled)) == place)
        up, down = (sum(told.wide for told in done.at(scaled + sign * beside).told) for sign in (1, -1))
        assert found.slope[place] == pytest.approx((up - down) / 0.08, rel=0.1, abs=0.05)  # type: ignore[index]


def test_a_slope_that_is_carried_on_foretells_the_step_behind_it(done: Searched) -> None:
    """As of a parabola: the mean of the slopes at both ends is what was gone."""
    problem, scaled = done.refined.problem, done.refined.found.scaled
    before = log_search._sloped(problem, done.at(scaled), done.source, done.refined.states)
    step = 0.1 * problem.prior.moves
    after = log_search._carried(problem, before, done.at(scaled + step))
    gone = sum(new.wide - old.wide for new, old in zip(after.told, before.told, strict=True)) / 2
    assert (before.slope + after.slope) @ step / 2 == pytest.approx(gone)


def stopped(*_: object) -> None:
    raise KeyboardInterrupt


def test_interrupted_where_slopes_are_taken_a_search_keeps_what_is_done(
    done: Searched, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log_search, "determinant_slope", stopped)
    refined = done.refined
    found = searched(refined.problem, refined.found.scaled, done.source, refined.states, range(9))
    assert found is not None
    assert found.interrupted
    assert len(found.told) == 2


def learned(monkeypatch: pytest.MonkeyPatch) -> nw.LogFit:
    """By the first record, and then by both."""
    monkeypatch.setattr(refined_search, "MANY", 1)
    monkeypatch.setattr(refined_search, "FEW", 1)
    return nw.learn(ship(), [record.between(0.0, SHORT) for record in twin()[1]])


def test_a_log_that_begins_with_its_first_records_ends_where_all_of_them_do(
    done: Searched, monkeypatch: pytest.MonkeyPatch
) -> None:
    fit, scaled, prior = learned(monkeypatch), done.refined.found.scaled, done.refined.problem.prior
    values = np.array([fit.model[name] for name in prior.names])
    off = (values - prior.mean - prior.scale * scaled) / np.array([fit.std[name] for name in prior.names])
    assert fit.settled
    assert np.abs(off).max() < 0.1


@pytest.mark.parametrize(("piece", "kept"), [("_reestimated", 1), ("gust_doubt", 2)], ids=["first records", "doubt"])
def test_interrupted_in_its_rounds_a_search_keeps_what_is_done(
    piece: str, kept: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the first records tell; or all of them, where only the gusts were to be doubted."""
    monkeypatch.setattr(refined_search, piece, stopped)
    fit = learned(monkeypatch)
    assert any(f"{kept} of 2 records were looked at" in note for note in fit.notes)
    assert len(fit.records) == kept
