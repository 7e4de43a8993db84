"""What a forecast makes of its futures, against loops over plain definitions, and numbers of an escape by hand."""

import math
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import expon
from transit import estimate, estimator, ship

from narrows.estimation.states import StateNames
from narrows.warning.forecasting.forecaster import Forecaster, crossing, escapes, judged
from narrows.warning.forecasting.helmsman import KICK, STEADY, Case, FutureLanes, Helmsmen, Outcomes, Ships

TAKEOVERS = [0, 5, 10, 15, 20, 25, 30, 40, 50, 60, 90, 120]  # [s]
CHANCES = [*range(0, 61, 2), *range(70, 121, 10)]
WRONG = range(0, 61, 5)
SHIPS, MEMBERS, ESCAPING = 3, 40, 30


def drawn_outcomes() -> list[Outcomes]:
    """Contacts that become more likely from takeover to takeover, of three ships in unequal danger."""
    rng = np.random.default_rng(8)

    def outcomes(shares: np.ndarray) -> Outcomes:
        met = rng.random(shares.shape) < shares
        return Outcomes(np.where(met, 40.0, np.inf), rng.choice([-1, 1], shares.shape, p=[0.3, 0.7]))

    danger = np.array([0.1, 0.6, 1.0])
    members = outcomes(np.stack([np.repeat(danger, MEMBERS), np.repeat(danger / 2, MEMBERS)]))
    late = np.concatenate([np.array(TAKEOVERS) / 150, np.array(TAKEOVERS) / 100])
    escaping = outcomes(
        np.clip(late[:, None] * np.repeat(danger, ESCAPING) + (np.repeat(danger, ESCAPING) == 1) * 0.1, 0, 1)
    )
    own = np.concatenate(
        [[1.0], np.array(CHANCES) / 100 - 0.2, np.array(CHANCES) / 100 - 0.1, [t / 100 for t in (*WRONG, *WRONG)]]
    )
    return [members, escaping, outcomes(np.clip(own[:, None] * danger, 0, 1))]


def last_chance(times: list[int], shares: list[float], limit: float) -> float:
    """Where shares that never fall come over a limit, on a straight line from the time before."""
    risen = [max(shares[: k + 1]) for k in range(len(shares))]
    for k, share in enumerate(risen):
        if share > limit:
            before = risen[k - 1]
            return -1.0 if k == 0 else times[k - 1] + (limit - before) / (share - before) * (times[k] - times[k - 1])
    return math.inf


def test_shares_and_chances_are_those_of_loops_over_all_futures() -> None:
    members, escaping, likely = outcomes = drawn_outcomes()
    unattended = np.array([0.02, 0.5, 0.9])
    found = judged(outcomes, SHIPS, 2, unattended)
    for k in range(SHIPS):
        own = range(k * ESCAPING, (k + 1) * ESCAPING)
        shares = [
            [np.mean([escaping.contact[m * 12 + t, i] < math.inf for i in own]) for t in range(12)] for m in range(2)
        ]
        risen = np.array([[max(one[: t + 1]) for t in range(12)] for one in shares])
        np.testing.assert_allclose(found.failing[k], risen)
        best = risen.min(axis=0)
        assert found.last_chance[k] == pytest.approx(last_chance(TAKEOVERS, best.tolist(), 0.05))
        assert found.best[k] == (0 if risen[0, :2].sum() <= risen[1, :2].sum() else 1)

        single = np.isfinite(likely.contact[1:75, k]).reshape(2, 37)
        assert found.likely_chance[k] == pytest.approx(last_chance(CHANCES, single.min(axis=0).tolist(), 0.5))
        either = np.isfinite(likely.contact[75:, k]).reshape(2, 13).max(axis=0)
        assert found.wrong_order[k] == pytest.approx(last_chance(list(WRONG), either.tolist(), 0.5))
        assert found.contact[k] == likely.contact[0, k]

        mine = range(k * MEMBERS, (k + 1) * MEMBERS)
        as_is, steered = (np.mean([members.contact[case, i] < math.inf for i in mine]) for case in (0, 1))
        assert (found.as_is[k], found.helmsman[k]) == (pytest.approx(as_is), pytest.approx(steered))
        # Somebody returns after an exponential time of one minute on average, and takes over at the nearest takeover.
        ends = [0.0, *((a + b) / 2 for a, b in pairwise(TAKEOVERS)), math.inf]
        weights = np.diff(expon(scale=60.0).cdf(ends))
        nobody = unattended[k] * float(weights @ best) + (1 - unattended[k]) * steered
        assert found.nobody[k] == pytest.approx(nobody)
        if math.isfinite(likely.contact[0, k]):
            assert found.side[k] == likely.side[0, k]
        else:
            assert found.side[k] == sum(escaping.side[23, i] for i in own if escaping.contact[23, i] < math.inf)
    assert np.isinf(found.contact).any()
    assert np.isfinite(found.contact).any()


def test_a_share_that_stays_at_its_limit_is_not_over_it() -> None:
    times, shares = np.array([0.0, 10.0, 30.0]), np.array([[0.05, 0.05, 0.05], [0.0, 0.1, 0.1], [0.02, 0.04, 0.08]])
    np.testing.assert_allclose(crossing(times, shares, 0.05), [math.inf, 5.0, 15.0])


def test_the_futures_of_an_escape_last_100_s_from_each_takeover() -> None:
    cases = escapes((STEADY, KICK), np.array([0.0, 15.0]))
    assert cases == [
        Case(100.0, 0.0, STEADY),
        Case(115.0, 15.0, STEADY),
        Case(100.0, 0.0, KICK),
        Case(115.0, 15.0, KICK),
    ]
    assert KICK.kick == 1.5


@pytest.fixture(scope="module")
def one() -> Forecaster:
    return Forecaster(estimator(), 5.0, members=3, escaping=5)


def test_samples_are_mirrored_so_their_number_is_even(one: Forecaster) -> None:
    assert (len(one.members), len(one.escaping)) == (4, 6)
    normals = one.members
    np.testing.assert_array_equal(normals[:2], -normals[2:])
    assert not np.allclose(one.escaping[:2], normals[:2])


def test_wrong_orders_are_hard_over_to_either_side(one: Forecaster) -> None:
    limit = ship().configuration.gear.limit
    expected = [Case(t + 100.0, float(t), STEADY, order) for order in (-limit, limit) for t in WRONG]
    assert one.wrong_orders == expected


def test_the_first_order_of_an_escape_by_hand(one: Forecaster) -> None:
    """Line at 5 m, length 230 m: heading to the line at most 0.05, 3 times what is off it, 3 lengths times the turn."""
    still = {"x": 800.0, "y": 5.0, "psi": 0.0, "u": 4.0, "r": 0.0, "current_across": 0.0}
    assert one.order(still) == pytest.approx(0.0, abs=1e-12)
    assert one.order({**still, "y": 28.0}) == pytest.approx(-3 * 23 / 690)
    assert one.order({**still, "y": 100.0}) == pytest.approx(-3 * 0.05)
    assert one.order({**still, "y": -100.0}) == pytest.approx(3 * 0.05)
    assert one.order({**still, "psi": 0.02, "current_across": 0.08}) == pytest.approx(-3 * 0.04)
    assert one.order({**still, "r": 0.0004}) == pytest.approx(-690 * 0.0004 / 4)
    # In the bend, of radius 5 000 m to starboard, a ship that follows it turns by 4 / 5 000.
    assert one.order({**still, "x": 4500.0, "r": 4 / 5000}) == pytest.approx(0.0, abs=1e-3)
    assert one.order({**still, "psi": 1.0}) == -ship().configuration.gear.limit
    assert one.order({**still, "u": 0.05, "r": 1e-5}) == pytest.approx(-690 * 1e-5 / 0.1)


def test_the_least_water_of_a_track_is_that_beside_its_corners() -> None:
    """150 m to a bank, less the offset, and half of length x sin + beam x cos."""
    one, half, beam = Forecaster(estimator(), members=2, escaping=2), 150.0, ship().configuration.ship.beam
    track = np.array([[500.0, 10.0, 0.0], [600.0, -40.0, 0.1], [700.0, 20.0, -0.05]])
    expected = half - 40.0 - (230.0 * math.sin(0.1) + beam * math.cos(0.1)) / 2
    assert one._least_water(track) == pytest.approx(expected, rel=1e-6)
    assert one._least_water(np.array([[500.0, half - 10.0, 0.0]])) == 0.0
    assert one._least_water(np.array([[500.0, math.nan, 0.0]])) == 0.0


def test_coefficients_are_drawn_within_their_bounds_and_the_likely_ship_has_their_mean() -> None:
    """Samples have the bank as strong as they have it, their own rudder, and the law of their helmsman."""
    one, now = Forecaster(estimator(), members=400, escaping=2), estimate(60.0, 0.02)
    names, states = ship().terms.names, one.filter.states.names
    middle = np.array([ship().coefficients[name] for name in names])
    size, (low, high) = len(states), np.array([term.bound for term in ship().terms.terms]).T
    mean, root = now.joint.mean[None], now.joint.root[None]

    def expected(points: np.ndarray) -> dict[str, np.ndarray]:
        along = middle + points[:, size:] @ one.filter.root.T
        drawn = np.clip(along, np.minimum(low, middle), np.maximum(high, middle))
        bank = points[:, states.index("bank")]
        return {n: c * (bank if ship().terms[n].from_bank else 1.0) for n, c in zip(names, drawn.T, strict=True)}

    rudder, law = np.array([0.1, 0.2]), {"since": np.array([9.0, 8.0])}
    likely = one.sampled(mean, root, one.likely, rudder[:1], {"since": np.array([9.0])})
    for name, column in expected(mean).items():
        np.testing.assert_allclose(likely.coefficients[name], column, rtol=1e-12)
    np.testing.assert_array_equal(np.stack([*likely.columns.values()]).ravel(), mean[0, :size])
    both = one.sampled(np.repeat(mean, 2, 0), np.repeat(root, 2, 0), one.members, rudder, law)
    points = mean[0] + one.members[:, : root.shape[2]] @ root[0].T
    for name, column in expected(points).items():
        np.testing.assert_allclose(both.coefficients[name], np.tile(column, 2), rtol=1e-9, atol=1e-12)
    for index, name in enumerate(states):
        np.testing.assert_allclose(both.columns[name], np.tile(points[:, index], 2), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(both.rudder, np.repeat(rudder, 400) + both.columns["rudder_bias"])
    np.testing.assert_array_equal(both.helmsman["since"], np.repeat([9.0, 8.0], 400))


def test_the_current_of_a_lane_is_that_where_the_flow_is_1() -> None:
    """Half the flow here: a current of 0.3 m/s is 0.6 m/s there; where the tide turns the waterway's own counts."""
    water = SimpleNamespace(reference_current=0.2, flow=lambda x: np.array([0.5, -0.5, 0.05, 0.1]))
    here = {"x": np.zeros(4), "current": np.full(4, 0.3), "current_across": np.full(4, 0.07)}

    def currents(columns: dict[str, np.ndarray]) -> dict[str, object]:
        return FutureLanes._currents(SimpleNamespace(waterway=water), columns)  # type: ignore[arg-type]

    found = currents(here)
    np.testing.assert_allclose(found["current"], [0.6, -0.6, 0.2, 3.0])
    np.testing.assert_array_equal(found["current_across"], np.full(4, 0.07))
    assert currents({"x": np.zeros(4)}) == {"current_across": 0.0, "current": 0.2}


def test_each_future_has_the_numbers_of_its_law() -> None:
    lanes = SimpleNamespace(ship=SimpleNamespace(model=ship()), line=5.0, _driven=True)
    columns = {"u": np.array([4.0, 0.05]), "current_across": np.array([0.2, 0.0])}
    law = {"since": np.array([9.0, 50.0]), "most": np.full(2, 0.3), "by_r": np.ones(2)}
    ships = Ships(columns, np.array([0.1, 0.2]), {}, law)

    def numbers(case: Case) -> dict[str, object]:
        return FutureLanes._law(lanes, case, ships, 2.0)  # type: ignore[arg-type]

    helmsman = numbers(Case(120.0, 20.0))
    assert helmsman["since"].tolist() == [20.0, 50.0]
    assert (helmsman["approach"], helmsman["crab"], helmsman["turns"], helmsman["kicked"]) == (10.0, 0.0, 2.0, 2.0)
    assert helmsman["ordered"] is ships.rudder
    escape = numbers(Case(120.0, 20.0, KICK, -0.5))
    assert (escape["since"], escape["ordered"], escape["turns"], escape["kicked"]) == (20.0, -0.5, 2.0, 3.0)
    np.testing.assert_allclose(escape["by_r"], [3 * 230.0 / 4.0, 3 * 230.0 / 0.1])
    np.testing.assert_allclose(escape["crab"], [0.05, 0.0])
    assert Case(120.0).since > 1e6


def test_the_rudder_of_a_forecast_has_its_bias_and_leaves_a_margin() -> None:
    now = estimate(60.0, 0.02)
    told = Forecaster(estimator(), members=20, escaping=20)(now, {"rudder": 0.03}, Helmsmen(1, 230.0))
    assert told.rudder == pytest.approx(0.03 + now.values["rudder_bias"])
    assert told.rudder_margin == pytest.approx(ship().configuration.gear.limit - abs(told.rudder_needed))
    assert told.unattended == 0.02
    assert told.tracks.times.tolist() == list(range(5, 121, 5))


def test_a_bank_and_a_rudder_that_are_not_estimated_are_as_the_model_has_them() -> None:
    known = SimpleNamespace(
        model=ship(), states=StateNames(("x", "y", "psi", "u", "v", "r")), root=np.zeros((len(ship().terms.names), 0))
    )
    one, none = SimpleNamespace(filter=known), np.zeros((1, 1))
    ships = Forecaster.sampled(one, np.ones((1, 6)), np.zeros((1, 6, 1)), none, np.array([0.1]), {})  # type: ignore[arg-type]
    assert ships.rudder.tolist() == [0.1]
    assert {name: float(value[0]) for name, value in ships.coefficients.items()} == dict(ship().coefficients)
