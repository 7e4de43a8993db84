"""Plans of the predictive helm by hand: steady tracks, nodes, programs, orders; and beside voyages where it sails."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from plans import SPEED, orders, ship

import narrows as nw
from narrows.codegen.cache import compiled_loops
from narrows.control import settings
from narrows.control.predictive import plan_loops
from narrows.control.predictive.course_ahead import (
    COLUMNS,
    HELD,
    CourseAhead,
    SteadyTrack,
    WaterAhead,
    steady_track,
    water_ahead,
)
from narrows.control.predictive.planner import Horizon, Planner, RudderPlan, predict, program_of
from narrows.control.predictive.predictive_helm import Seen, VoyageOrders, update_push
from narrows.ship.actuators import SteeringGear
from narrows.simulation.controllers import VoyageState
from narrows.simulation.ship import SimulatedShip

pytest.importorskip("daqp")
RUDDER = HELD.index("rudder")
NO_PUSH = np.zeros(2)


def track(known: int = 0) -> SteadyTrack:
    """Three places 10 m apart; from the offset to the middle, nine ways, 0.8 rad of rudder go to 0, and 16 m too.

    A moment of 1 N m takes 0.01 rad more, a force of 1 N 0.002 rad and 0.1 m/s of sway; of the second place twice that.
    """
    states, by_push = np.zeros((9, 3, 5)), np.zeros((9, 3, 5, 2))
    states[..., RUDDER] = np.linspace(0.8, 0.0, 9)[:, None]
    states[..., 0] = np.linspace(16.0, 0.0, 9)[:, None] + np.array([0.0, 1.0, 5.0])
    by_push[..., RUDDER, :], by_push[..., HELD.index("v"), 0] = [0.002, 0.01], 0.1
    by_push[:, 1] *= 2.0
    there = np.arange(9)[:, None] >= known * np.ones(3)
    return SteadyTrack(np.array([0.0, 10.0, 20.0]), states, by_push, by_push, states, there, 0.75)


def test_a_line_is_held_as_far_out_as_the_rudder_allows() -> None:
    made = track()
    assert [made.nearest(x) for x in (-50.0, 4.0, 14.0, 16.0, 99.0)] == [0, 0, 1, 2, 2]
    assert made.held(0.0, NO_PUSH, 0.8) == 0.0
    assert made.held(0.0, NO_PUSH, 0.65) == pytest.approx(1.5 / 8)  # between 0.7 and 0.6 rad
    assert made.held(0.0, np.array([0.0, -20.0]), 0.65) == 0.0  # 0.2 rad less
    assert made.held(9.0, np.array([0.0, 5.0]), 0.65) == pytest.approx(2.5 / 8)  # twice 0.05 rad more
    assert made.held(0.0, np.array([25.0, 5.0]), 0.65) == pytest.approx(2.5 / 8)
    assert made.held(0.0, np.array([0.0, -30.0]), -0.01) == pytest.approx(5 / 8)  # never: the least, at 0.5 rad
    # Without steady courses farther out than the fourth way, that one, which takes 0.5 rad.
    assert track(3).held(0.0, NO_PUSH, 0.65) == pytest.approx(3 / 8)
    assert track(9).held(0.0, NO_PUSH, 0.65) == 0.0


def test_steady_states_lie_between_places_and_ways_and_move_with_a_push() -> None:
    made = track()
    there = made.at(np.array([5.0, 15.0, 99.0]), NO_PUSH, 3.25 / 8)
    np.testing.assert_allclose(there[:, 0], [9.5 + 0.5, 9.5 + 3.0, 9.5 + 5.0])
    np.testing.assert_allclose(there[:, RUDDER], 0.475)
    np.testing.assert_allclose(made.at(np.zeros(1), NO_PUSH, 1.0)[0], 0.0)
    np.testing.assert_allclose(made.at(np.zeros(1), NO_PUSH)[0], [16.0, 0.0, 0.0, 0.0, 0.75])  # the rudder's limit
    pushed = made.at(np.array([12.0, 15.0]), np.array([2.0, -10.0]), 0.5)  # by the place nearest to the first, 10 m
    np.testing.assert_allclose(pushed[:, HELD.index("v")], 2 * 0.2)
    np.testing.assert_allclose(pushed[:, RUDDER], 0.4 + 2 * (0.004 - 0.1))
    assert made.at(np.zeros(1), np.array([0.0, -999.0]))[0, RUDDER] == -0.75


def test_an_external_force_is_found_exponentially() -> None:
    """A residual of (3, -2): 63 % in the time constant, in one step or in two; nothing from what is no number."""
    truth = np.array([3.0, -2.0])
    one = update_push(NO_PUSH, truth, 4.0, 4.0)
    np.testing.assert_allclose(one, (1 - math.exp(-1.0)) * truth)
    half = update_push(NO_PUSH, truth, 1.0, 4.0)
    np.testing.assert_allclose(update_push(half, truth - half, 3.0, 4.0), one)
    for wrong in (math.nan, math.inf):
        assert update_push(half, np.array([wrong, 0.0]), 1.0, 4.0) is half


@pytest.mark.parametrize("loops", [compiled_loops(plan_loops), plan_loops], ids=["compiled", "plain"])
def test_tables_and_programs_are_those_of_numpy(loops: Any) -> None:
    draw = np.random.default_rng(3).standard_normal
    table, x = draw((6, 2)), np.array([-1.0, 0.0, 0.2, 2.4, 2.5, 99.0, math.nan])
    expected = np.stack([np.interp(x, 0.5 * np.arange(6), column) for column in table.T], axis=1)
    np.testing.assert_allclose(loops.interpolate(table, 0.5, x), expected)
    A, B, defects, change = draw((4, 3, 3)), draw((4, 3)), draw((4, 3)), draw(4)
    e, G = loops.condensed(A, B, defects)
    off = np.zeros(3)
    for k in range(4):
        off = A[k] @ off + B[k] * change[k] + defects[k]
        np.testing.assert_allclose(e[k] + G[k] @ change, off)
    rows, bounds = loops.clearance_rows(
        np.array([[1.0], [2.0], [-1.0], [-3.0]]), np.array([[10.0], [-10.0], [10.0], [-10.0]]), np.array([[0.1, 0.02]]),
        np.array([[[5.0], [0.3]]]), np.full((4, 1), 4.0), np.full((4, 1), 6.0), 4.0,
    )  # fmt: skip
    # By hand: the first corner at 1 + 0.1 + 0.2 m leaves 2.7 m, the others 2.1 m, to port 5.3 m and 2.9 m.
    np.testing.assert_allclose(bounds, [2.7, 2.1, 2.9])
    np.testing.assert_allclose(rows[:, 0], [5.0 + 3.0, 5.0 - 3.0, -(5.0 - 3.0)])


def test_a_plan_goes_on_from_where_the_ship_is() -> None:
    """Four intervals of 10 m, a heading of k, rates of k + 1; the ship is 3 m on where the plan had another place."""
    states = np.arange(5.0)[:, None] * [0.0, 1.0, 0.0, 0.0, 0.0]
    plan = RudderPlan(10.0 * np.arange(5), states, np.arange(1.0, 5.0))
    now = np.array([9.0, 9.0, 9.0, 9.0, 9.0])
    same = plan.from_here(3.0, now)
    np.testing.assert_allclose(same.x, [3.0, 13.0, 23.0, 33.0, 43.0])
    np.testing.assert_array_equal(same.rates, plan.rates)
    np.testing.assert_array_equal(same.states, [now, *states[1:]])
    quarter = plan.from_here(3.0, now, 0.25)
    np.testing.assert_allclose(quarter.x, [3.0, 13.0, 23.0, 33.0, 43.0])
    np.testing.assert_allclose(quarter.rates, [1.25, 2.25, 3.25, 3.0])
    np.testing.assert_allclose(quarter.states[1:, 1], [1.25, 2.25, 3.25, 4.0])
    later = plan.from_here(3.0, now, 1.5)
    np.testing.assert_allclose(later.x, [3.0, 13.0, 23.0, 33.0, 43.0])
    np.testing.assert_allclose(later.rates, [2.5, 3.5, 2.0, 0.0])
    end = plan.from_here(3.0, now, 3.5)
    np.testing.assert_allclose(end.x, [3.0, 13.0, 23.0, 33.0, 43.0])
    np.testing.assert_allclose(end.rates, [2.0, 0.0, 0.0, 0.0])


def test_states_of_a_plan_stay_in_the_domain_of_the_model() -> None:
    """Banks 20 m to starboard and 10 m to port; a hull of 20 m by 4 m, a tenth of the beam off the banks at least."""
    planner: Any = SimpleNamespace(hull=(10.0, 2.0))
    there = {"keel_starboard": np.full(5, 20.0), "keel_port": np.full(5, 10.0)}
    states = np.array([
        [4.0, 0.1, 0.5, 0.1, 9.0], [99.0, 0.0, 9.0, 9.0, 0.0], [-99.0, 0.0, -9.0, -9.0, 0.0],
        [99.0, 2.0, 0.0, 0.0, 0.0], [-99.0, -0.2, 0.0, 0.0, 0.0],
    ])  # fmt: skip
    found = Planner._within_domain(planner, there, states, 3.0)
    np.testing.assert_array_equal(found[0], states[0])
    np.testing.assert_allclose(found[1], [20.0 - 2.4, 0.0, 1.5, 0.3, 0.0])
    np.testing.assert_allclose(found[2], [-10.0 + 2.4, 0.0, -1.5, -0.3, 0.0])
    turned = math.radians(25.0)
    np.testing.assert_allclose(found[3, :2], [20.0 - 2.4 - 10.0 * math.sin(turned), turned])
    np.testing.assert_allclose(found[4, :2], [-10.0 + 2.4 + 10.0 * math.sin(0.2), -0.2])
    narrow = Planner._within_domain(planner, {name: column / 10 for name, column in there.items()}, states, 3.0)
    np.testing.assert_allclose(narrow[:, 0], 0.5)  # in the middle where there is no room


def test_a_first_plan_is_the_steady_course_with_the_rudder_still() -> None:
    water = SimpleNamespace(at=lambda x: {"current": np.array([0.5])})
    planner: Any = SimpleNamespace(horizon=Horizon(3, 2.0), water=water)
    now = np.array([1.0, 2.0, 3.0, 4.0, 0.2])
    plan = Planner.first(planner, 7.0, now, 1.5, lambda x: np.tile(x[:, None], (1, 5)))
    np.testing.assert_allclose(plan.x, [7.0, 11.0, 15.0, 19.0])
    np.testing.assert_array_equal(plan.states[0], now)
    np.testing.assert_allclose(plan.states[1:, :4], np.tile(plan.x[1:, None], (1, 4)))
    np.testing.assert_allclose(plan.states[1:, RUDDER], 0.2)
    np.testing.assert_array_equal(plan.rates, np.zeros(3))
    assert (Horizon(30, 2.0).time, Horizon(30, 2.0).period) == (60.0, 0.4)


def test_an_interval_of_a_plan_is_a_voyage_under_its_push() -> None:
    planner, model = orders().planner, ship()
    interval, count = planner.horizon.interval, planner.horizon.intervals
    state = np.array([0.4, 0.03, 0.02, 0.01, 0.1])
    rates, push = np.zeros(count), np.zeros((count, 2))
    rates[2], push[1] = 0.2, [3.0, -4.0]
    places, after = predict(
        planner.lanes, np.full(count, 5.0), np.tile(state, (count, 1)), SPEED, rates, push, interval, {}
    )
    start = {"x": 5.0, "u": SPEED, **dict(zip(HELD, state.tolist(), strict=True))}
    for lane, forces in ((0, {}), (1, {"Y": 3.0, "N": -4.0})):
        end = nw.simulate(model, **start, **forces, duration=interval, dt=interval / settings.STEPS).outcome.state
        np.testing.assert_allclose(
            [places[lane], *after[lane, :4]], [end[name] for name in ("x", *HELD[:4])], rtol=1e-9
        )
    assert after[2, RUDDER] == pytest.approx(0.1 + 0.2 * interval)
    assert (after[0, RUDDER], after[1, RUDDER]) == (0.1, 0.1)
    assert after[2, 3] != after[0, 3]


def test_bounds_of_a_program_by_hand() -> None:
    cost = np.array([[2.0, 0.5], [0.5, 3.0]]), np.array([7.0, 8.0])
    rudders = np.array([0.3, -0.1]), np.array([[1.0, 0.0], [1.0, 1.0]])
    program = program_of(
        cost, np.array([0.1, -0.2]), rudders, (np.array([[2.0, 3.0]]), np.array([0.7])), (0.6, 0.5), 2.0
    )
    # A half beam too near costs 50, and 10 times its square over 2.
    np.testing.assert_allclose(program.H, [[2.0, 0.5, 0.0], [0.5, 3.0, 0.0], [0.0, 0.0, 10.0]])
    np.testing.assert_allclose(program.f, [7.0, 8.0, 50.0])
    np.testing.assert_allclose(program.rows, [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [2.0, 3.0, -2.0]])
    np.testing.assert_allclose(program.lower, [-0.6, -0.3, 0.0, -0.9, -0.5, -1e20])
    np.testing.assert_allclose(program.upper, [0.4, 0.7, 1e20, 0.3, 0.7, 0.7])


def test_a_course_keeps_the_hull_off_both_banks_and_leads_to_the_middle() -> None:
    """A canal's wall less half a beam and the margin; eight equal steps; two places on a canal of its own."""
    model = ship()
    water, hull = water_ahead(model, None), model.configuration.ship
    most = model.configuration.canal.width / 2 - hull.beam / 2 - 1.5
    for y, held in ((99.0, most), (-99.0, -most), (0.4, 0.4)):
        made = steady_track(SimulatedShip(model), water, y, SPEED, 1.5, {})
        np.testing.assert_allclose(made.states[:, 0, 0], np.linspace(held, 0.0, 9), atol=1e-12)
        assert made.places.tolist() == [0.0, 1.0]
        assert made.limit == model.configuration.gear.limit
    course = nw.steady_course(model, y=0.4, u=SPEED)
    np.testing.assert_allclose(made.states[0, 0, [1, 2, 4]], [float(course[name]) for name in ("psi", "v", "rudder")])
    way = nw.straight_waterway(model.configuration.canal, 10.1 * hull.length)
    along = steady_track(SimulatedShip(model), water_ahead(model, way), 0.4, SPEED, 1.5, {})
    assert len(along.places) == 20  # two a length
    assert along.places[-1] == pytest.approx(10.1 * hull.length)
    # A force and a moment move the steady course by their derivatives.
    pushed = nw.steady_course(model, y=0.4, u=SPEED, Y=1e-3, N=-2e-3)
    moved = made.by_push[0, 0] @ np.array([1e-3, -2e-3])
    change = [float(pushed[name] - course[name]) for name in ("psi", "v", "rudder")]
    np.testing.assert_allclose(moved[[1, 2, 4]], change, rtol=1e-3)
    np.testing.assert_allclose(moved[[0, 3]], 0.0)


@pytest.mark.parametrize(("radius", "y", "held"), [(8.3, -0.4, 5), (8.5, -0.4, 8), (10.0, 1.5, -6)])
def test_without_a_steady_course_a_way_has_that_of_the_next_one_inward(radius: float, y: float, held: int) -> None:
    """Bends to starboard, in which the rudder holds the ship on the outermost 5 and 8 of nine ways, or the inner 6."""
    model = ship()
    straight = np.array([7.0, 0.0, np.nan, 0.0, 3.5, 3.5, 0.0])
    bend = np.where(np.arange(7) == COLUMNS.index("curvature"), 1.0 / radius, straight)
    water = WaterAhead(np.stack([straight, bend]), model.configuration.ship.length, section=())
    made = steady_track(SimulatedShip(model), water, y, SPEED, 0.5, {})
    there = np.isin(np.arange(9), np.arange(9)[:held] if held > 0 else np.arange(9)[held:])
    np.testing.assert_array_equal(made.known.T, [[True] * 9, there])
    np.testing.assert_allclose(made.states[..., 0], np.linspace(y, 0.0, 9)[:, None] * np.ones(2), atol=1e-12)
    assert (made.states[there, 1, 1:] != 0.0).all()
    inward = made.states[held, 1, 1:] if held < 0 else 0.0  # From the middle itself there is no way inward
    np.testing.assert_array_equal(made.states[~there, 1, 1:] - inward, 0.0)


def test_a_course_is_found_again_at_another_speed() -> None:
    """By more than a fiftieth; where none is found, the one before stays."""
    course = orders().course
    begun: CourseAhead = SimpleNamespace(track="track", speed=2.0, _start=lambda u: started.append(u))  # type: ignore[assignment]
    started: list[float] = []
    for u in (2.039, 1.961, 2.041, 1.959, 0.0, -3.0):
        assert CourseAhead.at_speed(begun, u) == "track"
    assert started == [2.041, 1.959]
    gains, _ = course.regulated(0.0, 0.0)
    assert course.regulated(0.3, 0.05)[0] is gains  # the nearest place, and the nearest way of nine
    assert course.regulated(0.3, 0.07)[0] is not gains


# Orders


def voyage_orders(**told: Any) -> tuple[VoyageOrders, list[Any]]:
    calls: list[Any] = []
    reference = track()

    def improve(plan: Any, speed: float, push: Any, ahead: Any, beyond: Any) -> Any:
        calls.append((plan, speed, beyond))
        return told.get("better", SimpleNamespace(rates=np.array([0.04, 9.0]), from_here=plan.from_here))

    plan = SimpleNamespace(from_here=lambda x, state, share: calls.append(share) or plan)
    planner: Any = SimpleNamespace(
        limits=(0.5, 0.1), horizon=Horizon(30, 2.0), first=lambda *asked: plan, improve=improve, positions={}
    )
    course: Any = SimpleNamespace(
        at_speed=lambda u: reference, regulated=lambda x, way: (np.array([0.01, 0.0, 0.0, 0.0, 0.2]), "beyond"),
        speed=3.0, track=reference,
    )  # fmt: skip
    made = VoyageOrders(planner, course, SimpleNamespace(), 4.0, SteeringGear())
    made.push = NO_PUSH
    return made, calls


def test_a_helm_comes_back_slowly_and_improves_its_plan_once() -> None:
    """Of 0.5 rad, 0.7 may hold the ship: at 0.35 rad, 4.5 of 8 ways in; back by 8 s of 20 times 4 s."""
    made, calls = voyage_orders()
    seen = Seen(0.0, 0.0, 3.0, np.array([7.0, 0.0, 0.0, 0.0, 0.1]))
    assert made._rate(seen, 0.0) == 0.04
    assert made.way == pytest.approx(4.5 / 8)
    assert len(calls) == 6  # rounds of a first plan
    assert calls[0][1:] == (3.0, "beyond")
    calls.clear()
    made.way = 0.9
    made._rate(seen, 8.0)
    assert made.way == pytest.approx(0.9 - 8.0 / 80.0)
    assert calls[0] == 4.0  # intervals of 2 s since
    assert len(calls) == 2
    lost, _ = voyage_orders(better=None)
    # The best linear helm: 0.01 per metre, 0.2 per rudder angle, about 7 m and 0.35 rad.
    assert lost._rate(seen._replace(state=np.array([9.0, 0.0, 0.0, 0.0, 0.1])), 0.0) == pytest.approx(-0.02 + 0.05)
    assert (lost.without_plan, lost.plan) == (1, None)


def test_an_order_is_a_period_of_its_rate_within_the_gear(monkeypatch: pytest.MonkeyPatch) -> None:
    """Periods of 0.4 s, 0.1 rad/s and 0.5 rad at most; a longer time since the last order takes more."""
    rates = {0.0: 0.05, 0.4: 9.0, 2.4: -9.0}
    made, _ = voyage_orders()
    monkeypatch.setattr(VoyageOrders, "_rate", lambda self, seen, elapsed: rates[seen.t])
    still = lambda self, state, elapsed: self._seen or Seen(0.0, 0.0, 3.0, np.zeros(5))  # noqa: E731
    monkeypatch.setattr(VoyageOrders, "_expected", still)
    at = VoyageState(0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.1)
    made.course.track = replace(track(), force_of=np.zeros((9, 3, 2, 2)))
    assert made(0.0, at) == pytest.approx(0.1 + 0.4 * 0.05)
    assert made(0.3, at) == pytest.approx(0.12)  # between plans
    assert made(0.4, at) == pytest.approx(0.12 + 0.4 * 0.1)
    assert made(2.4, at) == pytest.approx(0.16 - 2.0 * 0.1)
    near = VoyageState(0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.49)
    other, _ = voyage_orders()
    rates[0.0] = 9.0
    assert other(0.0, near) == 0.5
    rates[0.0] = -9.0
    assert voyage_orders()[0](0.0, VoyageState(0.0, 0.0, 0.0, 3.0, 0.0, 0.0, -0.49)) == -0.5
