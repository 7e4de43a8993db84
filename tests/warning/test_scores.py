"""Scores of warnings: spells of alerts beside the level that says them, predictors beside geometry."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from transit import ship

from narrows.warning.alerts.alert import BankLevel, Priority, Thresholds
from narrows.warning.forecasting.forecast import BankForecast, Escape, LikelyRun
from narrows.warning.forecasting.forecaster import BridgePredictor
from narrows.warning.monitoring.bridge_status import clearances
from narrows.warning.transit_scores import PREDICTORS, ScoredTransit, TransitScorer, alert_spells, score_transits

HALF, SPEED = 150.0, 4.5
STILL = dict.fromkeys(("x", "y", "psi", "u", "v", "r"), 0.0)


def told(left: float, curved: float = math.inf) -> BankForecast:
    escape, likely = Escape("then steady", -0.6, 0.6, 20.0), LikelyRun(math.inf, "", left)
    return BankForecast(0.0, likely, left, 0.0, 1.0, 1.0, 0.0, 50.0, escape, curved, 0.0, 0.0, 0.6)


@pytest.mark.parametrize("every", [1.0, 2.0])
def test_an_alert_stands_where_the_level_says_it(every: float) -> None:
    """Of urgencies that wander about the threshold: the same seconds as of the level of the monitor."""
    walk = np.cumsum(np.random.default_rng(3).normal(0.0, 0.15, 400))
    t, urgency = every * np.arange(400.0), 1.0 + np.abs(walk) % 1.0 - 0.6
    level = BankLevel(Thresholds(60.0, 1e-6, 1e-6))
    said = [level.update(now, told(60.0 / u)) > Priority.NONE for now, u in zip(t, urgency, strict=True)]
    stands = [any(start <= now < end for start, end in alert_spells(t, urgency)) for now in t]
    assert stands == said


def beside(y: float, psi: float, r: float = 0.0, v: float = 0.0, bend: float = 0.0) -> BridgePredictor:
    columns = (np.array([number]) for number in (y, psi, SPEED, v, r))
    return BridgePredictor(ship().configuration.ship, HALF, *columns, bend)


def test_straight_on_is_a_straight_line() -> None:
    one = beside(40.0, 0.2)
    way = float(one.now[0])
    assert one.curved_contact(120.0)[0] == pytest.approx(way / (SPEED * math.sin(0.2)), abs=2.0)
    assert beside(0.0, 0.0).curved_contact(120.0)[0] == math.inf
    away = beside(40.0, 0.0, bend=1 / 2000.0)  # A bend to starboard leaves a straight track to port.
    assert away.curved_contact(240.0)[0] == pytest.approx(math.sqrt(2 * 150.0 * 2000.0) / SPEED, rel=0.2)


def test_the_curved_track_is_a_circle() -> None:
    r = 0.004
    one = beside(0.0, 0.0, r=r)
    t = float(one.curved_contact(240.0)[0])
    y = SPEED / r * (1 - math.cos(r * t))
    assert float(one.clearance(np.array([y]), np.array([r * t]))[0]) == pytest.approx(0.0, abs=3.0)
    assert beside(0.0, 0.0, r=SPEED / 2000.0, bend=1 / 2000.0).curved_contact(120.0)[0] == math.inf


def transit(name: str, urgent: list[tuple[int, int]], clearance: float) -> ScoredTransit:
    """400 s with an urgency of 1 in some of them for all predictors, a clearance that falls at 360 s, a last chance."""
    t = np.arange(400.0)
    urgencies = np.zeros((400, len(PREDICTORS)))
    for start, end in urgent:
        urgencies[start:end] = 1.0
    return ScoredTransit(name, t, urgencies, np.where(t >= 360.0, clearance, 50.0), 350.0 - t)


def test_scores_are_those_counted_by_hand() -> None:
    """An alert stands after 2 s; so 18 s before the last chance goes, or 8 s, which is less than the 10 s needed."""
    silent = ScoredTransit(
        "silent", np.arange(3.0), np.full((3, len(PREDICTORS)), math.nan), np.full(3, 50.0), np.ones(3)
    )
    scores = score_transits([
        transit("early", [(330, 400)], 4.9), transit("late", [(340, 400)], 4.9), transit("long before", [(5, 20)], 4.9),
        transit("in vain", [(5, 20), (100, 120)], 20.1), transit("spike", [(5, 7)], 30.0), silent,
    ])  # fmt: skip
    assert (scores.contacts, scores.clear, scores.unknown) == (3, 2, ("silent",))
    assert scores.hours == pytest.approx((3 * 360 + 2 * 399) / 3600)
    assert scores.left == {name: (left,) * 5 for name, left in (("early", 18.0), ("late", 8.0), ("long before", 0.0))}
    for row in scores.rows:
        assert (row.in_time, row.left) == (1, 8.0)
        assert row.false == pytest.approx(300.0 / scores.hours)


def test_predictors_count_in_their_own_thresholds() -> None:
    """Distance 20 m, curved track 40 s, and the levels 90, 60 and 30 s."""
    ready = SimpleNamespace(ready=True)
    scorer = TransitScorer("one", Thresholds())
    scorer.add(SimpleNamespace(t=7.0, clearance=50.0, estimate=ready, forecast=told(20.0, 25.0)))
    scorer.add(SimpleNamespace(t=9.0, clearance=10.0, estimate=SimpleNamespace(ready=False), forecast=None))
    scored = scorer.transit()
    expected = [20 / 50, 40 / 25, 90 / 20, 60 / 20, 30 / 20]
    np.testing.assert_allclose(scored.urgencies, [expected, [math.nan] * 5])
    np.testing.assert_array_equal(scored.last_chance, [20.0, math.nan])
    assert (scored.contact(5.0), scored.contact(50.1)) == (math.inf, 0.0)


def test_clearances_count_from_the_corners_of_the_hull() -> None:
    """Banks 50 m to either side of 2 m to starboard, a hull of 30 m beam 12 m off the line: 45 m and 25 m."""
    asked = []

    def room(x: float, draft: float) -> SimpleNamespace:
        asked.append((x, draft))
        return SimpleNamespace(middle=2.0, width=100.0)

    way = SimpleNamespace(keel_section=room, line=SimpleNamespace(length=1000.0))
    hull = SimpleNamespace(length=200.0, beam=30.0, draft=11.0)
    for x in (-5.0, 400.0, 1007.0):
        now = SimpleNamespace(ready=True, values={**STILL, "x": x, "y": 12.0})
        assert clearances(hull, way, now)[:2] == pytest.approx((45.0, 25.0))
    assert asked[::3] == [(0.0, 11.0), (400.0, 11.0), (1000.0, 11.0)]
    turned = SimpleNamespace(ready=True, values={**STILL, "y": 2.0, "psi": math.radians(-30.0)})
    reach = 100.0 * 0.5 + 15.0 * math.sqrt(0.75)
    assert clearances(hull, way, turned)[:2] == pytest.approx((50.0 - reach, 50.0 - reach))
    assert clearances(hull, way, SimpleNamespace(ready=False))[:2] == (math.inf, math.inf)
