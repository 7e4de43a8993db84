"""What transits will tell: what fits to them would find, by the same equations."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import narrows as nw
from engine_models import steered
from narrows.logbook.learned_coefficients import expected_std
from narrows.logbook.learning.log_setup import LogSetup, log_problem
from narrows.logbook.ship_log import GRADES
from narrows.logbook.transits import TransitTwin, expected_information, gust_push, recorded
from pictures import assert_readable

BREEZE = nw.TransitConditions(wind=0.5, gust=0.2, gust_time=2.0, wander=0.05, wander_time=15.0, gust_correlation=0.4)
SPEED = 0.7
OWN = nw.SensorGrade(
    "own", "a tank's",
    {
        "y": nw.SignalGrade(0.01, wander=0.01, memory=5.0, zero=0.01),
        "psi": nw.SignalGrade(0.002, wander=0.001, memory=20.0, zero=0.005),
        "r": nw.SignalGrade(0.002),
        "u": nw.SignalGrade(0.01),
        "rudder": nw.SignalGrade(0.005, zero=0.01),
    },
)  # fmt: skip


AT_SEA = nw.SensorGrade("at sea", "", {**GRADES["vdr"].signals, "y": nw.SignalGrade(50.0)})


@cache
def ship() -> nw.Model:
    model = steered().with_coefficients(b_bank=0.3, c_bank=0.04)
    values = np.array([model.coefficients[name] for name in model.terms.names])
    doubted = {"b_uv", "b_ur", "c_uv", "c_ur", "b_helm", "c_helm"}  # A fit takes a slope by each one that has a spread
    shares = np.array([1.0 if term.from_bank else 0.05 * (term.name in doubted) for term in model.terms.terms])
    known = replace(model, covariance=np.diag((shares * values) ** 2), data_range=nw.DataRange(speed=(0.5, 1.0)))
    return replace(known, configuration=replace(known.configuration, canal=nw.Canal(7.0, 0.4)))


@cache
def predicted(**told) -> nw.InformationForecast:
    told = {"u": SPEED, "duration": 60.0, "conditions": BREEZE, **told}
    return nw.predict_information(ship(), None, OWN, **told)


def posed(*seeds: int) -> LogSetup:
    """Transits of the ship, as a fit is given them."""
    plan = TransitTwin(ship(), SPEED, 60.0, BREEZE)
    records = [recorded(f"{number}", plan.sailed(seed), OWN, seed, current=0.0) for number, seed in enumerate(seeds)]
    return log_problem(ship(), nw.ShipLog(tuple(records)), OWN, gusts=True)


def expected(log: LogSetup, copies: int = 1) -> dict[str, float]:
    """Standard errors by the expected information."""
    push = gust_push(BREEZE, ship())
    return expected_std(log.problem, copies * expected_information(log, push @ push.T, BREEZE.gust_time))


@pytest.mark.parametrize("seeds", [(1,), (1, 2, 3)], ids=len)
def test_what_is_predicted_of_transits_is_what_fits_to_them_find(seeds: tuple[int, ...]) -> None:
    """Fits do not know the ship nor the gusts: their standard errors are those that are predicted, to a third."""
    ratios = []
    for seed in seeds:
        log = posed(seed)
        fit = nw.learn(ship(), log.log, sensors=OWN, gusts=True)
        ratios.append([expected(log)[name] / fit.std[name] for name in ("b_bank", "c_bank")])
    assert np.median(ratios, axis=0) == pytest.approx([1.0, 1.0], abs=0.33)


def test_where_a_ship_is_along_her_canal_need_not_be_read() -> None:
    """A log without x teaches as one with it: the chain of places that nothing holds is no singular matrix."""
    with_x = nw.SensorGrade("with x", "a tank's", {**OWN.signals, "x": nw.SignalGrade(0.01)})
    voyage = TransitTwin(ship(), SPEED, 60.0, BREEZE).sailed(1)
    fits = [nw.learn(ship(), recorded("a", voyage, grade, 1), sensors=grade, gusts=True) for grade in (OWN, with_x)]
    for name in ("b_bank", "c_bank"):
        assert fits[0].std[name] == pytest.approx(fits[1].std[name], rel=0.1)


def test_one_transit_many_times_over_tells_as_much_as_so_many() -> None:
    one, three = expected(posed(4), 3), expected(posed(4, 4, 4))
    assert one == pytest.approx(three, rel=1e-6)


def test_more_transits_tell_more() -> None:
    found = predicted()
    for name in found.targets:
        first, later, last = found.std[name]
        assert found.prior_std[name] > first > later > last
    assert found.summary().startswith("Standard errors after 1 and ")
    assert f"c_bank from {found.prior_std['c_bank']:.2g} to {found.std['c_bank'][0]:.2g}, " in found.summary()
    assert "on simulated twins only" in found.summary()
    rows = found.to_dict()["after"]
    assert [row["transits"] for row in rows] == list(found.transits)
    assert [row["std c_bank"] for row in rows] == list(found.std["c_bank"])
    assert any("each transit has its own wind and zeros" in note for note in found.notes)
    assert_readable(found.plot())


def test_better_sensors_tell_more() -> None:
    worse = {name: replace(grade, noise=3 * grade.noise, zero=3 * grade.zero) for name, grade in OWN.signals.items()}
    told = {"u": SPEED, "duration": 60.0, "conditions": BREEZE}
    blunt = nw.predict_information(ship(), None, nw.SensorGrade("blunt", "worse", worse), **told)
    for name in blunt.targets:
        assert blunt.std[name][0] > predicted().std[name][0]


def test_gusts_that_come_and_go_hide_the_bank() -> None:
    calm = predicted(conditions=replace(BREEZE, gust=0.01))
    # The voyage itself is stirred by gusts; what they hide is more than what they stir.
    assert calm.std["b_bank"][0] < predicted().std["b_bank"][0]


def test_a_straight_waterway_is_its_canal() -> None:
    way = nw.straight_waterway(ship().configuration.canal, 60.0)
    told = {"duration": 20.0}
    along = nw.predict_information(ship(), way, OWN, u=SPEED, conditions=BREEZE, **told)
    assert along.std["c_bank"] == pytest.approx(predicted(**told).std["c_bank"], rel=1e-3)


def test_sensors_of_a_ship_are_too_coarse_for_a_model() -> None:
    """Places to a metre in a canal of seven, in a sentence."""
    with pytest.raises(nw.InputError, match="too coarse to locate a ship of this size"):
        nw.predict_information(ship(), None, AT_SEA, (1,), u=SPEED, duration=20.0, conditions=BREEZE)


def test_one_number_of_transits_may_be_asked() -> None:
    told: dict = {"u": SPEED, "duration": 20.0, "conditions": BREEZE}
    one, many = (
        nw.predict_information(ship(), None, OWN, 5, **told),
        nw.predict_information(ship(), None, OWN, (20, 5), **told),
    )
    assert one.std["c_bank"] == many.std["c_bank"][1:]


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({"sensors": "radar"}, "sensors = 'radar' is unknown"),
        ({"sensors": "ais"}, "record the rudder"),
        ({"transits": (0,)}, "whole number from 1"),
        ({"transits": ()}, "transits is empty"),
        ({"transits": "1, 5"}, "whole number from 1"),
        ({"u": -1.0}, "no speed ahead"),
        ({"u": 0.7, "duration": 0.0}, "a transit of 0 s"),
        ({"targets": ("d_bank",)}, "unknown coefficient 'd_bank'"),
    ],
)
def test_what_cannot_be_predicted_is_refused_in_a_sentence(told: dict, said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        nw.predict_information(ship(), **told)
    assert "vdr" in GRADES
