"""Scores of warnings: spells of alerts beside the level that says them, predictors beside geometry."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from transit import canal, ship

from narrows.warning.alerts.alert import BankLevel, Priority, level_of
from narrows.warning.forecasting.forecaster import BankForecast, Escape, LikelyRun
from narrows.warning.monitoring.watched_transit import WatchedTransit, alert_spells, clearances, score_transits

HALF, SPEED = 150.0, 4.5
STILL = dict.fromkeys(("x", "y", "psi", "u", "v", "r"), 0.0)


def told(left: float) -> BankForecast:
    escape, likely = Escape("then steady", -0.6, 0.6, 20.0), LikelyRun(math.inf, "", left)
    return BankForecast(0.0, likely, left, 0.0, 1.0, 1.0, 0.0, 50.0, escape, 0.0, 0.0, 0.6)


@pytest.mark.parametrize("every", [1.0, 2.0])
def test_an_alert_stands_where_the_level_says_it(every: float) -> None:
    """Of urgencies that wander about the threshold: the same seconds as of the level of the monitor."""
    walk = np.cumsum(np.random.default_rng(3).normal(0.0, 0.15, 400))
    t, urgency = every * np.arange(400.0), 1.0 + np.abs(walk) % 1.0 - 0.6
    level, said = BankLevel(), []
    for now, u in zip(t, urgency, strict=True):
        wanted, eased = (min(level_of(told(90.0 / u), ease), Priority.CAUTION) for ease in (1.0, 0.7))
        said.append(level.update(now, wanted, eased) > Priority.NONE)
    stands = [any(start <= now < end for start, end in alert_spells(t, urgency)) for now in t]
    assert stands == said


def transit(left: dict[tuple[int, int], float], clearance: dict[tuple[int, int], float]) -> WatchedTransit:
    """400 s: 50 m of water and no last chance but for these seconds; nobody acts."""
    t = np.arange(400.0)
    columns = {"t": t, "clearance": np.full(400, 50.0), "last_chance": np.full(400, math.inf), "nobody": np.ones(400)}
    for name, changes in (("last_chance", left), ("clearance", clearance)):
        for (start, end), value in changes.items():
            columns[name][start:end] = value
    return WatchedTransit(ship().configuration.ship, canal(), columns, (), {})


def test_scores_are_those_counted_by_hand() -> None:
    """An alert stands after 2 s: 18 s before the last chance goes, or 8 s, which is less than the 10 s needed."""
    early, late = (
        {(start, 400): (left - np.arange(400.0 - start)).clip(min=0.0)} for start, left in ((330, 20.0), (340, 10.0))
    )
    near = {(352, 360): 10.0, (360, 400): 4.9}
    silent = transit({}, {})
    silent.columns["nobody"][:] = silent.columns["last_chance"][:] = math.nan
    scores = score_transits({
        "early": transit(early, near), "late": transit(late, near), "long before": transit({(5, 20): 20.0}, near),
        "in vain": transit({(5, 20): 20.0, (100, 120): 80.0}, {(200, 220): 15.0}), "spike": transit({(5, 7): 1.0}, {}),
        "silent": silent,
    })  # fmt: skip
    assert (scores.contacts, scores.clear, scores.unknown) == (3, 2, ("silent",))
    assert scores.hours == pytest.approx((3 * 360 + 2 * 399) / 3600)
    assert scores.left == {
        "early": (0.0, 18.0, 18.0, 18.0), "late": (0.0, 8.0, 8.0, 8.0), "long before": (300.0, 0.0, 0.0, 0.0),
    }  # fmt: skip
    assert scores.table["in_time"].tolist() == [1, 1, 1, 1]
    assert (scores.table["false"] * scores.hours / 100.0).tolist() == pytest.approx([1.0, 3.0, 2.0, 2.0])


def test_clearances_count_from_the_corners_of_the_hull() -> None:
    """Banks 50 m to either side of 2 m to starboard, a hull of 30 m beam 12 m off the line: 45 m and 25 m."""
    asked = []

    def room(x: float, draft: float) -> SimpleNamespace:
        asked.append((x, draft))
        return SimpleNamespace(middle=2.0, width=100.0)

    way = SimpleNamespace(section=room, line=SimpleNamespace(length=1000.0))
    hull = SimpleNamespace(length=200.0, beam=30.0, draft=11.0)
    for x in (-5.0, 400.0, 1007.0):
        now = SimpleNamespace(ready=True, values={**STILL, "x": x, "y": 12.0})
        assert clearances(hull, way, now)[:2] == pytest.approx((45.0, 25.0))
    assert asked[::3] == [(0.0, 11.0), (400.0, 11.0), (1000.0, 11.0)]
    turned = SimpleNamespace(ready=True, values={**STILL, "y": 2.0, "psi": math.radians(-30.0)})
    reach = 100.0 * 0.5 + 15.0 * math.sqrt(0.75)
    assert clearances(hull, way, turned)[:2] == pytest.approx((50.0 - reach, 50.0 - reach))
    assert clearances(hull, way, SimpleNamespace(ready=False))[:2] == (math.inf, math.inf)
