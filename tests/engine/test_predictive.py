"""The predictive helm: beside the linear-quadratic regulator, under pushes, in bends; and what must never happen."""

import json
import math
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import mmg, paper
from hypothesis import given, settings
from hypothesis import strategies as st
from plans import HOLD, SPEED, converged, helm, orders, ship
from scipy.linalg import expm, solve_discrete_are

import narrows as nw
from narrows.control import PredictiveHelm, RegulatorWeights
from narrows.control.predictive import planner as planner_module
from narrows.control.predictive import predictive_helm as helm_module
from narrows.control.predictive.course_ahead import HELD
from narrows.control.predictive.predictive_helm import VoyageOrders
from narrows.simulation.controllers import VoyageState
from narrows.waterway import Bank, Centreline, Waterway
from narrows.waterway.waterway import straight_waterway
from nightly import draws

NAMES = ("x", "y", "psi", "u", "v", "r", "rudder")
pytest.importorskip("daqp")


def anew() -> VoyageOrders:
    """What was laid out once, without a memory."""
    return replace(orders())


def seen(
    y: float, psi: float = 0.0, v: float = 0.0, r: float = 0.0, rudder: float = 0.0, x: float = 0.0
) -> VoyageState:
    return VoyageState(x, y, psi, SPEED, v, r, rudder)


@cache
def channel(radius: float = 60.0, length: float = 60.0, turned: float = 20.0) -> Waterway:
    """A canal that is straight, bends to starboard for a while, and is straight again."""
    s = np.linspace(0.0, length, 601)
    bend = np.where((s > 15.0) & (s < 15.0 + turned), 1.0 / radius, 0.0)
    step = s[1]
    heading = np.concatenate([[0.0], np.cumsum((bend[1:] + bend[:-1]) / 2 * step)])
    between = (heading[1:] + heading[:-1]) / 2
    points = np.cumsum(step * np.stack([np.sin(between), np.cos(between)], axis=1), axis=0)
    line = Centreline(np.concatenate([[[0.0, 0.0]], points]))
    ends, half = np.array([0.0, line.length]), np.full(2, 3.5)
    return Waterway(line, Bank("starboard", ends, half), Bank("port", ends, half), (ends, np.full(2, 0.5)), name="bend")


def test_a_small_error_is_steered_as_the_linear_quadratic_regulator_steers_it() -> None:
    """Its Riccati equation solved by SciPy from slopes by central differences of the rates."""
    begun = orders()
    steady = begun.course.track.states[0, 0]

    def rates(state: np.ndarray) -> np.ndarray:
        y, psi, v, r, rudder = state
        all_six = nw.derivative(ship(), {"y": y, "psi": psi, "u": SPEED, "v": v, "r": r}, rudder=rudder)
        return np.append(all_six[[1, 2, 4, 5]], 0.0)

    step = 1e-5 * np.eye(5)
    slopes = np.stack([(rates(steady + off) - rates(steady - off)) / 2e-5 for off in step], axis=1)
    assert np.abs(rates(steady)).max() < 1e-9
    driven = np.zeros((6, 6))
    driven[:5, :5], driven[4, 5] = slopes, 1.0
    interval = expm(driven * begun.planner.horizon.interval)
    A, B, weights = interval[:5, :5], interval[:5, 5:], begun.planner.weights
    cost = solve_discrete_are(A, B, np.diag(weights.states), np.array([[weights.rate]]))
    gains = (B.T @ cost @ A / (weights.rate + B.T @ cost @ B))[0]
    for off in np.diag([0.003, 0.002, 0.002, 0.001, 0.004]):
        plan = converged(steady + off)
        assert plan.rates[0] == pytest.approx(-gains @ off, rel=0.01, abs=1e-6)


def flown(duration: float = 60.0, dt: float = 0.1, controller: Any = None, **told: Any) -> nw.Voyage:
    told = {"y": HOLD, "u": SPEED, "duration": duration, "dt": dt, **told}
    return nw.simulate(ship(), **told, controller=helm() if controller is None else controller)


def off_at_the_end(voyage: nw.Voyage, y: float = HOLD) -> float:
    assert voyage.outcome.kind in ("afloat", "left the waterway"), voyage.outcome.sentence
    return float(np.abs(voyage.y[-100:] - y).max())


def test_a_state_is_predicted_until_the_gear_follows_as_the_engine_moves_it() -> None:
    """A servo of 1 s, three intervals of a plan, that follows the last order: to 1 % of what changes meanwhile."""
    slow = nw.SteeringGear(35.0, 20.0, lag=1.0)
    made = replace(ship(), configuration=replace(ship().configuration, steering=slow))
    begun = PredictiveHelm(made, HOLD, SPEED).begin()
    begun.push, begun._order, begun._stages = np.zeros(2), 0.2, [0.2] * 4
    now = {"y": 0.2, "psi": 0.01, "v": 0.02, "r": 0.01}
    found = begun._at_actuation(helm_module.Seen(0.0, 3.0, SPEED, np.array([*now.values(), 0.0])))
    end = nw.simulate(made, x=3.0, u=SPEED, **now, duration=1.0, dt=0.005, controller=nw.ConstantRudder(0.2))
    after = np.array([end[name][-1] for name in now])
    assert (np.abs(found.state[:4] - after) < 0.01 * np.abs(after - list(now.values()))).all()
    assert (found.t, found.x, found.state[4]) == pytest.approx((1.0, end["x"][-1], 0.2), rel=1e-6)


def test_it_comes_back_to_its_offset_within_the_limits_of_the_gear() -> None:
    voyage, gear = flown(y=1.6), ship().configuration.gear
    assert off_at_the_end(voyage) < 0.01
    assert np.abs(voyage.rudder).max() <= gear.limit * (1 + 1e-9)
    assert np.abs(np.diff(voyage.rudder) / np.diff(voyage.t)).max() <= gear.rate * (1 + 1e-6)


def test_a_steady_push_that_it_does_not_know_leaves_no_offset() -> None:
    pushed, held = flown(40.0, N=-4.0, Y=3.0), flown(10.0)
    assert abs(pushed.rudder[-1] - held.rudder[-1]) > 0.02  # it takes a rudder
    assert off_at_the_end(pushed) < 0.02 * ship().configuration.ship.beam


def test_banks_of_another_strength_leave_no_offset() -> None:
    truth = ship().with_coefficients(b_bank=0.2, c_bank=0.03)
    voyage = nw.simulate(truth, y=HOLD, u=SPEED, duration=50.0, dt=0.1, controller=helm())
    assert off_at_the_end(voyage) < 0.02 * ship().configuration.ship.beam


def test_it_keeps_farther_from_the_bank_where_the_coefficients_are_known_less() -> None:
    margins = [replace(ship(), covariance=scale * ship().covariance) for scale in (1.0, 9.0)]
    known, less = (PredictiveHelm(model, HOLD, SPEED).begin().planner.margins for model in margins)
    surely = PredictiveHelm(replace(ship(), covariance=None), HOLD, SPEED).begin().planner.margins
    least = helm_module.MARGIN * ship().configuration.ship.beam
    np.testing.assert_allclose(surely, least)
    np.testing.assert_allclose(less - least, 3 * (known - least), rtol=1e-9)
    assert (known[1:] > least).all()


@pytest.mark.slow
def test_it_begins_to_turn_before_the_bend_and_holds_its_line_through_it() -> None:
    way = channel()
    voyage = nw.simulate(
        ship(), y=0.0, u=SPEED, duration=40.0, dt=0.1, waterway=way, controller=helm(0.0, waterway=way)
    )
    blind = nw.simulate(ship(), y=0.0, u=SPEED, duration=40.0, dt=0.1, waterway=way, controller=helm(0.0))
    before = (voyage.x > 12.0) & (voyage.x < 15.0)
    assert np.abs(voyage.rudder[before]).max() > 10 * np.abs(blind.rudder[before]).max()
    assert np.abs(voyage.y).max() < 0.25 * ship().configuration.ship.beam < np.abs(blind.y).max()


@pytest.mark.slow
def test_a_straight_waterway_is_the_canal_that_it_is() -> None:
    way = straight_waterway(ship().configuration.canal, 200.0)
    canal, water = flown(20.0, y=1.2), flown(20.0, y=1.2, waterway=way, controller=helm(waterway=way))
    np.testing.assert_allclose(water.y, canal.y, atol=2e-3)
    np.testing.assert_allclose(water.rudder, canal.rudder, atol=2e-3)


@pytest.mark.slow
def test_it_steers_to_the_very_end_of_a_waterway() -> None:
    way = channel()
    voyage = nw.simulate(
        ship(), x=45.0, y=0.3, u=SPEED, duration=60.0, dt=0.1, waterway=way, controller=helm(0.0, waterway=way)
    )
    assert voyage.outcome.kind == "left the waterway"
    assert np.isfinite(voyage.rudder).all()
    assert abs(voyage.y[-1]) < 0.1


def test_it_comes_nearer_to_the_middle_where_its_rudder_is_not_enough() -> None:
    """No more than 0.7 of the rudder's limit is to hold the offset."""
    most = 0.7 * ship().configuration.gear.limit
    assert abs(float(nw.steady_course(ship(), y=1.9, u=SPEED).rudder)) > 1.1 * most
    voyage = flown(60.0, y=1.9, controller=helm(1.9))
    assert voyage.outcome.kind == "afloat", voyage.outcome.sentence
    assert np.abs(voyage.rudder[-100:]).max() == pytest.approx(most, rel=0.03)
    assert 1.5 < voyage.y[-1] < 1.85


# Symmetry


@settings(max_examples=draws(8))
@given(st.floats(-1.0, 1.0), st.floats(-0.1, 0.1), st.floats(-0.05, 0.05), st.floats(-0.03, 0.03), st.floats(-0.3, 0.3))
def test_the_mirrored_ship_gets_the_mirrored_order(y: float, psi: float, v: float, r: float, rudder: float) -> None:
    mirror = replace(_mirror())
    order = anew()(0.0, seen(HOLD + y, psi, v, r, rudder))
    other = mirror(0.0, seen(-HOLD - y, -psi, -v, -r, -rudder))
    assert other == pytest.approx(-order, abs=1e-6)


@cache
def _mirror() -> VoyageOrders:
    return helm(-HOLD).begin()


# What must never happen


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_taken_to_be_as_was_expected(name: str, wrong: float) -> None:
    order, usual = anew(), anew()
    state = seen(1.0, 0.02)
    for number in range(40):
        t = 0.2 * number
        spoiled = state._replace(**{name: wrong}) if number in (0, 7, 20, 21, 22) else state
        told, told_usual = order(t, spoiled), usual(t, state)
        assert math.isfinite(told)
        assert abs(told) <= order.planner.limits[0]
        if 7 <= number <= 8 and name not in ("x", "rudder"):
            assert told == pytest.approx(told_usual, abs=0.15)


def test_nothing_but_what_is_no_number_still_gives_an_order() -> None:
    order = anew()
    for t in (math.nan, 0.0, math.nan, 0.3, 0.1, math.inf, 0.6, -1.0, 2.0):
        assert math.isfinite(order(t, VoyageState(*[math.nan] * 7)))


@settings(max_examples=25)
@given(st.lists(st.floats(-1e6, 1e6), min_size=7, max_size=7), st.floats(0.0, 1e3))
def test_whatever_is_seen_the_order_is_a_number_within_the_limit(numbers: list[float], t: float) -> None:
    order = anew()
    for time in (t, t + 0.1, t + 50.0):
        told = order(time, VoyageState(*numbers))
        assert math.isfinite(told)
        assert abs(told) <= order.planner.limits[0]


def test_time_that_runs_backwards_begins_anew() -> None:
    order = anew()
    first = order(5.0, seen(1.2))
    for t in (5.2, 5.4, 5.6):
        order(t, seen(1.0, 0.05, 0.01))
    assert order(2.0, seen(1.2)) == pytest.approx(first, abs=1e-12)
    assert (order.push == 0).all()


def test_between_plans_the_order_stands() -> None:
    order = anew()
    first = order(0.0, seen(1.2))
    assert order(0.2 * order.planner.horizon.period, seen(0.2)) == first
    assert order(1.01 * order.planner.horizon.period, seen(0.2)) != first


@pytest.mark.parametrize("fails", ["always", "in turn"])
def test_the_linear_quadratic_regulator_steers_where_a_program_has_no_answer(
    fails: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    answered, asked = planner_module.solve_program, iter(range(10**9))

    def solve_program(program: Any) -> Any:
        return None if fails == "always" or next(asked) % 2 else answered(program)

    monkeypatch.setattr(planner_module, "solve_program", solve_program)
    order = helm().begin()

    class Known:
        def begin(self) -> VoyageOrders:
            return order

    assert off_at_the_end(flown(40.0, y=1.3, controller=Known())) < 0.05
    assert order.without_plan > 10


def test_a_corner_in_the_bank_has_a_program_with_an_answer() -> None:
    """Clearance falls short for a price, so that no state is without a plan."""
    order = anew()
    for y in (2.9, 3.2, 4.5):
        order(100.0 * y, seen(y, 0.1))
        assert order.without_plan == 0


# What is refused


def test_what_it_cannot_do_is_one_sentence_with_a_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    for told, word in (
        ({"y": 3.3}, "in the bank"), ({"u": 0.0}, "without way"), ({"u": math.nan}, "finite"),
        ({"margin": -1.0}, "reach into the bank"), ({"confidence": 1.0}, "share"), ({"horizon": 0.0}, "positive"),
        ({"intervals": 1}, "intervals"), ({"revolutions": 3.0}, "propeller"),
        ({"waterway": "canal"}, "no such file"),
    ):  # fmt: skip
        with pytest.raises(nw.InputError, match=word):
            PredictiveHelm(ship(), **{"y": HOLD, "u": SPEED, **told})
    with pytest.raises(nw.InputError, match="no terms of a rudder"):
        PredictiveHelm(paper(), HOLD, SPEED)
    with pytest.raises(nw.InputError, match="holds this ship"):
        PredictiveHelm(ship(), 3.1, SPEED).begin()
    monkeypatch.setitem(sys.modules, "daqp", None)
    with pytest.raises(nw.InputError, match=r"a predictive helm needs control.*pip install"):
        helm()


def test_an_offset_that_takes_more_rudder_than_the_gear_turns_is_refused() -> None:
    """Of 25 degrees: 22 at 2.0 m and 32 at 2.2 m; at 2.3 m no angle holds it. A little nearer, 25 are enough."""
    rudders = nw.steady_course(ship(), y=[2.0, 2.2, 2.3], u=SPEED)["rudder"].to_numpy()
    np.testing.assert_allclose(np.degrees(rudders), [22.2, 31.7, math.nan], atol=0.05)
    assert ship().configuration.gear.limit_deg == 25.0
    PredictiveHelm(ship(), 2.0, SPEED).begin()
    for y in (2.2, 2.3):
        with pytest.raises(nw.InputError, match=f"no rudder up to 25 degrees holds this ship at y = {y} m"):
            PredictiveHelm(ship(), y, SPEED).begin()


def test_a_rudder_that_turns_nothing_is_refused() -> None:
    with pytest.raises(nw.InputError, match=r"holds this ship|has no effect"):
        PredictiveHelm(ship().with_coefficients(c_helm=0.0, b_helm=0.0), 0.0, SPEED).begin()


# Every field counts


@pytest.mark.slow
@pytest.mark.parametrize(
    "other",
    [
        {"y": 0.3}, {"u": 1.2}, {"margin": 2.0}, {"confidence": 0.999}, {"horizon": 4.0}, {"intervals": 20},
        {"weights": RegulatorWeights(heading_deg=5.0)},
    ],
    ids=str,
)  # fmt: skip
def test_another_value_of_a_field_is_another_voyage(other: dict[str, Any]) -> None:
    told = {"y": HOLD, "u": SPEED, "margin": 2.4}
    usual, changed = (PredictiveHelm(ship(), **fields) for fields in (told, {**told, **other}))
    one, another = (flown(6.0, y=1.0, psi=0.02, controller=controller) for controller in (usual, changed))
    assert np.abs(one.rudder - another.rudder).max() > 1e-4


@pytest.mark.slow
def test_a_propeller_that_turns_faster_asks_for_less_rudder() -> None:
    model = mmg()
    speed, length = 1.179, model.configuration.ship.length
    slow, fast = (
        PredictiveHelm(model, 0.05 * length, speed, revolutions=n)
        .begin()
        .course.track.states[0, 0, HELD.index("rudder")]
        for n in (8.0, 14.0)
    )
    assert abs(fast) < abs(slow)


def test_it_says_what_it_holds() -> None:
    assert repr(helm()) == f"<PredictiveHelm: {helm().summary()}>"
    assert "holds y = 0.6 m at 1 m/s, plans 9.56 s ahead every 0.064 s" in helm().summary()


def test_the_command_line_steers_with_it(tmp_path: Path) -> None:
    from click.testing import CliRunner

    from narrows.cli import app

    path = tmp_path / "ship.toml"
    nw.save_model(ship(), path)
    told = ["simulate", str(path), "--y", "1.2", "--speed", "1m/s", "--duration", "4", "--dt", "0.1", "--hold", "0.6"]
    ends = {}
    for name in ("predictive", "regulator"):
        result = CliRunner().invoke(app, [*told, "--controller", name, "--json"])
        assert result.exit_code == 0, result.output
        ends[name] = json.loads(result.output)
    assert ends["predictive"] != ends["regulator"]


def test_a_gap_of_ten_minutes_and_readings_that_are_none_get_an_order() -> None:
    order = anew()
    for t in (0.0, 0.5, 600.0, 600.5):
        assert math.isfinite(order(t, seen(HOLD + 0.02)))
    assert math.isfinite(order(601.0, seen(HOLD + 0.02)._replace(y=None, r=None)))
    assert math.isfinite(order(None, seen(HOLD)))
