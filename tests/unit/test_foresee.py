"""What transits will tell: the system is that of exact tangents, what it leaves open that of the joint distribution."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import narrows as nw
from engine_models import steered
from narrows.logbook import GRADES
from narrows.logbook.gaussian_update import NormalPrior
from narrows.logbook.transits.planned_transit import Excursion, PlannedTransit
from narrows.logbook.transits.transit_filter import FELT, START, TransitSystem, Unknowns
from pictures import assert_readable

BREEZE = nw.TransitConditions(wind=0.5, gust=0.2, gust_time=2.0, wander=0.05, wander_time=15.0, gust_correlation=0.4)
SPEED = 0.7
OWN = nw.SensorGrade(
    "own", "a tank's",
    {
        "y": nw.SignalGrade(0.01, wander=0.01, memory=5.0, zero=0.01),
        "psi": nw.SignalGrade(0.002, wander=0.001, memory=20.0, zero=0.005),
        "r": nw.SignalGrade(0.002),
        "rudder": nw.SignalGrade(0.005, zero=0.01),
    },
)  # fmt: skip


@cache
def ship() -> nw.Model:
    model = steered().with_coefficients(b_bank=0.3, c_bank=0.04)
    values = np.array([model.coefficients[name] for name in model.terms.names])
    shares = np.array([1.0 if term.from_bank else 0.05 for term in model.terms.terms])
    known = replace(model, covariance=np.diag((shares * values) ** 2), data_range=nw.DataRange(speed=(0.5, 1.0)))
    return replace(known, configuration=replace(known.configuration, canal=nw.Canal(7.0, 0.4)))


@cache
def foreseen(**told) -> nw.Foresight:
    told = {"u": SPEED, "duration": 60.0, "within": 0.3, "conditions": BREEZE, **told}
    return nw.foresee(ship(), None, OWN, **told)


def test_the_system_is_that_of_the_engine() -> None:
    """Products of its steps are the differences of voyages that the engine sails, up to the length of a step."""
    start = {"y": 0.5, "psi": 0.05, "v": 0.02, "r": 0.01, "Y": 2.0, "N": 1.0, "rudder": 0.1}

    def sailed(model: nw.Model = ship(), **changed: float) -> nw.Voyage:
        return nw.simulate(model, u=SPEED, duration=3.0, dt=0.05, **{**start, **changed})

    voyage = sailed()
    at = {name: getattr(voyage, name) for name in ("y", "psi", "u", "v", "r", "rudder")}
    system = TransitSystem.along(ship(), {}, at, 0.05)
    names = ("c_bank", "c_helm")
    slopes = np.concatenate([np.eye(4), np.zeros((4, 5))], axis=1)
    for step in range(len(system.transition)):
        slopes = system.transition[step] @ slopes
        slopes[:, 4:7] += system.driven[step]
        slopes[:, 7:] += system.by_coefficients[step][:, [ship().terms.names.index(name) for name in names]]

    def ends(sail) -> np.ndarray:
        high, low = sail(1e-5), sail(-1e-5)
        return np.array([(getattr(high, name)[-1] - getattr(low, name)[-1]) / 2e-5 for name in FELT])

    exact = [ends(lambda step, name=name: sailed(**{name: start[name] + step})) for name in start]
    exact += [
        ends(lambda step, name=name: sailed(ship().with_coefficients(**{name: ship()[name] + step}))) for name in names
    ]
    np.testing.assert_allclose(slopes.T, exact, rtol=1e-3, atol=1e-4 * np.abs(exact).max())


def test_what_is_left_open_is_what_the_joint_distribution_leaves() -> None:
    """All readings of a short transit at once, every push and noise an unknown of its own."""
    plan = PlannedTransit(ship(), SPEED, 6.0, BREEZE)
    system = plan.system(plan.sailed(Excursion("routine"), 3))
    prior = NormalPrior.of(np.zeros(len(ship().terms.names)), ship().covariance)
    unknowns = Unknowns(BREEZE.gust_push(ship()), BREEZE.steady_push(ship()), BREEZE.gust_time, OWN, prior)
    told = unknowns.information(system)
    np.testing.assert_allclose(told, by_joint_distribution(system, unknowns), rtol=1e-5, atol=1e-6 * np.abs(told).max())


def by_joint_distribution(system: TransitSystem, unknowns: Unknowns) -> np.ndarray:
    """Covariance of all readings of a transit given the coefficients, and their slopes by these."""
    steps, rank, grades = len(system.transition), unknowns.prior.root.shape[1], OWN.signals
    width = 4 + 2 * steps + 2 + 1 + steps + rank
    state = np.zeros((4, width))
    state[:, :4] = np.diag(START)
    wind, zero, reading, coefficients = 4 + 2 * steps, 6 + 2 * steps, 7 + 2 * steps, width - rank
    kept = np.exp(-system.step / unknowns.gust_time)
    gust = np.zeros((2, width))
    rows = []
    for k in range(steps):
        new = np.zeros((2, width))
        new[[0, 1], [4 + 2 * k, 5 + 2 * k]] = 1.0
        gust = new if k == 0 else kept * gust + np.sqrt(1 - kept**2) * new
        rows.append(state[[FELT.index(name) for name in ("y", "psi", "r")]])
        moved = system.transition[k] @ state + system.driven[k][:, :2] @ unknowns.gust @ gust
        moved[:, wind : wind + 2] += system.driven[k][:, :2] * unknowns.wind
        moved[:, zero] += system.driven[k][:, 2] * grades["rudder"].zero
        moved[:, reading + k] += system.driven[k][:, 2] * grades["rudder"].noise / np.sqrt(system.step)
        moved[:, coefficients:] += system.by_coefficients[k] @ unknowns.prior.root
        state = moved
    seen = np.concatenate(rows)
    apart = np.abs(np.subtract.outer(np.arange(steps), np.arange(steps))) * system.step
    noise = np.zeros((3 * steps, 3 * steps))
    for row, name in enumerate(("y", "psi", "r")):
        grade = grades[name]
        one = (
            grade.wander**2 * np.exp(-apart / grade.memory)
            + grade.zero**2
            + np.eye(steps) * grade.noise**2 / system.step
        )
        noise[row::3, row::3] = one
    others, slopes = seen[:, :coefficients], seen[:, coefficients:]
    return slopes.T @ np.linalg.solve(noise + others @ others.T, slopes)


def test_more_transits_tell_more_and_excursions_more_than_routine() -> None:
    found = foreseen()
    for kind in found.kinds:
        for name in found.targets:
            assert found.prior_std[name] > kind.std[name][0] > kind.std[name][1] > kind.std[name][2]
    assert found.best.excursion.offset == pytest.approx(0.3)
    assert "Most is gained by 0.3 m aside" in found.summary()
    assert "on twins only" in found.summary()
    assert_readable(found.plot())


def test_better_sensors_tell_more() -> None:
    worse = {name: replace(grade, noise=3 * grade.noise, zero=3 * grade.zero) for name, grade in OWN.signals.items()}
    told = {"u": SPEED, "duration": 60.0, "within": 0.0, "conditions": BREEZE}
    blunt = nw.foresee(ship(), None, nw.SensorGrade("blunt", "worse", worse), **told)
    for name in blunt.targets:
        assert blunt.kinds[0].std[name][0] > foreseen().kinds[0].std[name][0]


def test_gusts_that_come_and_go_hide_the_bank() -> None:
    calm = foreseen(conditions=replace(BREEZE, gust=0.01), within=0.0)
    # The voyage itself is stirred by gusts; what they hide is more than what they stir.
    assert calm.kinds[0].std["b_bank"][0] < foreseen(within=0.0).kinds[0].std["b_bank"][0]


def test_a_straight_waterway_is_its_canal() -> None:
    way = nw.straight_waterway(ship().configuration.canal, 60.0)
    told = {"duration": 40.0, "within": 0.0}
    along = nw.foresee(ship(), way, OWN, u=SPEED, conditions=BREEZE, **told)
    assert along.kinds[0].std["c_bank"] == pytest.approx(foreseen(**told).kinds[0].std["c_bank"], rel=1e-3)


def test_without_the_rudder_nothing_is_foretold() -> None:
    found = nw.foresee(ship(), sensors="ais", u=SPEED)
    assert found.kinds == ()
    assert "record the rudder" in found.summary()
    assert found.best is None


def test_where_the_envelope_is_safe_nowhere_no_excursion_is_looked_at() -> None:
    unknown = replace(ship(), covariance=10000 * ship().covariance)
    found = nw.foresee(unknown, None, OWN, (1,), u=SPEED, duration=20.0, conditions=BREEZE)
    assert len(found.kinds) == 1
    assert found.safe_offset == 0
    assert "hold steady legs first" in found.summary()


def test_an_excursion_goes_no_farther_than_it_may_and_comes_back() -> None:
    times, wander = np.arange(0.0, 2400.0, 20.0), 30.0 * np.sin(np.arange(120))
    aims = Excursion("aside", 12.0, (1, -1), 480.0, 60.0).aims(times, np.zeros(120))
    assert (aims.max(), aims.min()) == (12.0, -12.0)
    assert aims[0] == aims[-1] == 0.0
    assert np.sum(aims == 12.0) * 20.0 == pytest.approx(480.0, abs=40.0)
    assert np.abs(Excursion("aside", 12.0, (1, -1), 480.0, 60.0).aims(times, wander)).max() <= 12.0


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({"sensors": "radar"}, "sensors = 'radar' is unknown"),
        ({"transits": (0,)}, "whole number from 1"),
        ({"u": -1.0}, "no speed ahead"),
        ({"u": 0.7, "duration": 0.0}, "a transit of 0 s"),
        ({"targets": ("d_bank",)}, "no coefficient 'd_bank'"),
    ],
)
def test_what_cannot_be_foretold_is_refused_in_a_sentence(told: dict, said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        nw.foresee(ship(), **told)
    assert "vdr" in GRADES
