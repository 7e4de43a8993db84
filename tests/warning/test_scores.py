"""Scores of warnings: spells of alerts beside the level that says them, predictors beside geometry."""

import math
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from transit import ship

from narrows.warning.alerts.alert import BankLevel, Priority, Thresholds
from narrows.warning.forecasting.forecast import (
    AS_IS,
    PILOT_NOW,
    BankForecast,
    CaseForecast,
    LikelyRun,
    urgency_of,
)
from narrows.warning.forecasting.forecaster import BridgePredictor
from narrows.warning.monitoring.bridge_status import clearances
from narrows.warning.transit_scores import (
    ScoredTransit,
    TransitScorer,
    highest_held,
    lead_times,
    score_transits,
    standing_since,
)

HALF, SPEED = 150.0, 4.5


def told(urgency: float) -> BankForecast:
    cases = {name: CaseForecast(name, urgency, 0.0, math.inf, "") for name in (AS_IS, PILOT_NOW)}
    return BankForecast(0.0, cases, LikelyRun(math.inf, "", math.inf, False), math.inf, 0.0, 0.0, 0.6)


def test_the_docs_say_the_usual_thresholds() -> None:
    page = (Path(__file__).parent.parent.parent / "docs" / "warning.md").read_text(encoding="utf-8")
    usual = Thresholds()
    told = dict(re.findall(r"^\| (\w+) \| urgency ([0-9.]+): ", page, re.MULTILINE))
    assert told == {name: f"{getattr(usual, name)}" for name in ("caution", "warning", "alarm")}


@pytest.mark.parametrize("every", [1.0, 2.0])
def test_an_alert_stands_where_the_level_says_it(every: float) -> None:
    """Of urgencies that wander about the threshold: the same seconds as of the level of the monitor."""
    walk = np.cumsum(np.random.default_rng(3).normal(0.0, 0.15, (400, 5)), axis=0)
    t, urgency = every * np.arange(400.0), 1.0 + np.abs(walk) % 1.0 - 0.6
    since = standing_since(t, urgency)
    for ship_number in range(5):
        level = BankLevel(Thresholds(1.0, math.inf, math.inf))
        said = [level.update(now, told(float(u))) for now, u in zip(t, urgency[:, ship_number], strict=True)]
        np.testing.assert_array_equal(np.isfinite(since[:, ship_number]), np.array(said) == Priority.CAUTION)
        raised = highest_held(t, urgency[:, [ship_number]], np.array([math.inf])) >= 1.0
        assert raised == (Priority.CAUTION in said)


def test_a_lead_counts_from_the_alert_that_stands_at_the_contact() -> None:
    t = np.arange(100.0)
    urgency = np.zeros((100, 3))
    urgency[10:30, 0], urgency[60:, 0] = 2.0, 2.0  # An alert that went, and another.
    urgency[10:30, 1] = 2.0  # One that went before.
    urgency[40:, 2], urgency[55:60, 2] = 2.0, 0.0  # One that fell silent for less than it is kept.
    leads = lead_times(t, standing_since(t, urgency), np.array([90.0, 90.0, 90.0]))
    np.testing.assert_allclose(leads, [90.0 - 62.0, 0.0, 90.0 - 42.0])


def beside(y: float, psi: float, r: float = 0.0, v: float = 0.0, bend: float = 0.0) -> BridgePredictor:
    columns = (np.array([number]) for number in (y, psi, SPEED, v, r))
    return BridgePredictor(ship().configuration.ship, HALF, *columns, bend)


def test_straight_on_is_a_straight_line() -> None:
    one = beside(40.0, 0.2)
    way = float(one.now[0])
    assert one.straight_contact(120.0)[0] == pytest.approx(way / (SPEED * math.sin(0.2)), abs=2.0)
    assert beside(0.0, 0.0).straight_contact(120.0)[0] == math.inf
    away = beside(40.0, 0.0, bend=1 / 2000.0)  # A bend to starboard leaves a straight track to port.
    assert away.straight_contact(240.0)[0] == pytest.approx(math.sqrt(2 * 150.0 * 2000.0) / SPEED, rel=0.2)


def test_the_curved_track_is_a_circle() -> None:
    r = 0.004
    one = beside(0.0, 0.0, r=r)
    t = float(one.curved_contact(240.0)[0])
    y = SPEED / r * (1 - math.cos(r * t))
    assert float(one.clearance(np.array([y]), np.array([r * t]))[0]) == pytest.approx(0.0, abs=3.0)
    assert one.straight_contact(240.0)[0] == math.inf
    assert beside(0.0, 0.0, r=SPEED / 2000.0, bend=1 / 2000.0).curved_contact(120.0)[0] == math.inf


def test_urgency_is_a_chance_and_times_to_contact() -> None:
    """10 s are as urgent as a certain contact with a pilot; times below 1 s are no more urgent than that."""
    assert urgency_of(0.2, 20.0, math.inf) == pytest.approx(0.7)
    assert urgency_of(0.0, 40.0, 10.0) == pytest.approx(1.25)
    assert urgency_of(0.0, 0.5, math.inf) == pytest.approx(10.0)


def transit(name: str, urgent: list[tuple[int, int]], clearance: float) -> ScoredTransit:
    """100 s with an urgency of 1 in some of them for all predictors, and a clearance that falls from 60 s on."""
    t = np.arange(100.0)
    urgencies = np.zeros((100, 7))
    for start, end in urgent:
        urgencies[start:end] = 1.0
    return ScoredTransit(name, t, urgencies, np.where(t >= 60.0, clearance, 50.0))


def test_scores_are_those_counted_by_hand() -> None:
    """An alert stands after 2 s, so 48 s before the contact at 60 s, or 9 s, which is less than the 20 s needed."""
    silent = ScoredTransit("silent", np.arange(3.0), np.full((3, 7), math.nan), np.full(3, 50.0))
    scores = score_transits([
        transit("early", [(10, 100)], 4.9), transit("late", [(49, 100)], 4.9), transit("near", [(5, 20)], 5.1),
        transit("near and calm", [], 20.0), transit("in vain", [(5, 20)], 20.1), transit("spike", [(5, 7)], 30.0),
        transit("calm", [], 30.0), silent,
    ])  # fmt: skip
    assert (scores.contacts, scores.near, scores.quiet, scores.unknown) == (2, 2, 3, ("silent",))
    assert scores.leads == {"early": (48.0,) * 7, "late": (9.0,) * 7}
    for row in scores.rows:
        assert (row.missed, row.lead, row.false, row.near) == (1, 28.5, 1, 1)


def test_predictors_count_in_their_own_thresholds() -> None:
    """Distance 25 m, curved track 50 s, one run 60 s, chance 0.85, and the levels 0.38, 0.69 and 0.91."""
    forecast = replace(told(0.17), likely=LikelyRun(40.0, "port", math.inf, False), curved=25.0)
    status = SimpleNamespace(t=7.0, clearance=50.0, estimate=SimpleNamespace(ready=True), forecast=forecast)
    scorer = TransitScorer("one", Thresholds())
    scorer.add(status)
    scorer.add(SimpleNamespace(t=9.0, clearance=10.0, estimate=SimpleNamespace(ready=False), forecast=None))
    scored = scorer.transit()
    urgency = 0.17 + 10 / 40 + 10 / 25
    expected = [25 / 50, 50 / 25, 60 / 40, 0.17 / 0.85, urgency / 0.38, urgency / 0.69, urgency / 0.91]
    np.testing.assert_allclose(scored.urgencies, [expected, [math.nan] * 7])
    np.testing.assert_array_equal(scored.t, [0.0, 2.0])
    np.testing.assert_array_equal(scored.clearance, [50.0, math.nan])
    assert (scored.least, scored.struck(5.0), scored.struck(50.1)) == (50.0, math.inf, 0.0)


def test_clearances_count_from_the_corners_of_the_hull() -> None:
    """Banks 50 m to either side of 2 m to starboard, a hull of 30 m beam 12 m off the line: 45 m and 25 m."""
    asked = []

    def room(x: float, draft: float) -> SimpleNamespace:
        asked.append((x, draft))
        return SimpleNamespace(middle=2.0, width=100.0)

    way = SimpleNamespace(room=room, line=SimpleNamespace(length=1000.0))
    hull = SimpleNamespace(length=200.0, beam=30.0, draft=11.0)
    for x in (-5.0, 400.0, 1007.0):
        now = SimpleNamespace(ready=True, values={"x": x, "y": 12.0, "psi": 0.0})
        assert clearances(hull, way, now) == pytest.approx((45.0, 25.0))
    assert asked == [(0.0, 11.0), (400.0, 11.0), (1000.0, 11.0)]
    turned = SimpleNamespace(ready=True, values={"x": 0.0, "y": 2.0, "psi": math.radians(-30.0)})
    reach = 100.0 * 0.5 + 15.0 * math.sqrt(0.75)
    assert clearances(hull, way, turned) == pytest.approx((50.0 - reach, 50.0 - reach))
    assert clearances(hull, way, SimpleNamespace(ready=False)) == (math.inf, math.inf)
