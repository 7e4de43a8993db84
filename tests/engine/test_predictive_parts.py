"""The parts of a predictive helm, each beside another way to the same: recursions, differences, maps, SciPy."""

from collections.abc import Iterator
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from arguments import by_depth
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad_vec
from scipy.linalg import expm
from scipy.optimize import minimize

import narrows as nw
from narrows.codegen.cache import compiled_loops
from narrows.codegen.linearisation import LINEARISED
from narrows.control.predictive import plan_loops
from narrows.control.predictive.course_ahead import (
    HELD,
    Weights,
    margins_of,
    over_interval,
    regulator_of,
    water_ahead,
)
from narrows.control.predictive.planner import (
    QuadraticProgram,
    horizon_of,
    program_of,
    solve_program,
    tracking_cost,
)
from narrows.control.predictive.predictive_helm import update_push
from narrows.control.regulator import DEFAULT_WEIGHTS, RegulatorWeights
from narrows.control.steady_course import LocalMotion, LocalWater, along_line
from narrows.simulation.ship import SimulatedShip
from narrows.waterway import Bank, Centreline, Waterway
from nightly import draws

# Of a hull, ahead and to starboard, in halves of the length and of the beam.
CORNERS = ((1, 1), (-1, 1), (1, -1), (-1, -1))

LOOPS = compiled_loops(plan_loops)
random = np.random.default_rng(0).standard_normal


def test_condensed_states_are_those_of_the_recursion() -> None:
    A, B, defects = random((7, 3, 3)), random((7, 3)), random((7, 3))
    e, G = LOOPS.condensed(A, B, defects)
    change, off = random(7), np.zeros(3)
    for k in range(7):
        off = A[k] @ off + B[k] * change[k] + defects[k]
        np.testing.assert_allclose(e[k] + G[k] @ change, off, atol=1e-10)


def test_what_acts_over_an_interval_is_the_matrix_exponential_and_its_integral() -> None:
    slopes = 0.2 * random((4, 5, 5))
    exponentials, integrals = over_interval(slopes, 0.7)
    for A, exponential, integral in zip(slopes, exponentials, integrals, strict=True):
        np.testing.assert_allclose(exponential, expm(0.7 * A), atol=2e-5)
        np.testing.assert_allclose(integral, quad_vec(lambda t, A=A: expm(t * A), 0.0, 0.7)[0], atol=2e-5)


def test_slopes_beside_a_bending_line_are_those_of_differences() -> None:
    """In a bend and a current, in a section of another width and depth than the model's own canal."""
    ship, curvature, current = SimulatedShip(by_depth()), 0.02, -0.3
    section = {"width": 6.0, "depth": 0.4}
    motion = LocalMotion(ship, LocalWater(6.0, section, 0.0, curvature, current), {**ship.values(), **section})
    at = {"y": 0.7, "psi": 0.05, "u": 1.1, "v": 0.03, "r": 0.02, "rudder": 0.1}
    linear = ship.system().linearisation(ship.values(), ship.actuators, ("width", "depth"))
    batch = linear.batch(1)
    columns = {name: np.array([value]) for name, value in {**at, "curvature": curvature, "current": current}.items()}
    matrix = batch({**at, **section})
    np.testing.assert_allclose(matrix[0], linear.linear({**at, **section}), rtol=1e-12, atol=1e-12)
    of = [LINEARISED.index(name) for name in HELD[:4]]
    by = [*of, len(LINEARISED) + linear.controlled.index("rudder")]
    found = along_line(matrix, columns)[0][np.ix_(of, by)]
    water = {"curvature": curvature, "current": current}

    def rates(name: str, step: float) -> np.ndarray:
        moved = motion.rates({**at, **water, name: at[name] + step})
        return np.array([float(moved[own]) for own in HELD[:4]])

    for column, name in enumerate(HELD):
        slope = (rates(name, 1e-6) - rates(name, -1e-6)) / 2e-6
        np.testing.assert_allclose(found[:, column], slope, rtol=1e-6, atol=1e-8)


def test_a_section_that_points_give_is_the_section_that_a_model_is_given() -> None:
    ship = SimulatedShip(by_depth())
    by_point = ship.system().linearisation(ship.values(), ship.actuators, ("width", "depth"))
    at = {"y": 0.5, "psi": 0.02, "u": 1.0, "v": 0.02, "r": 0.01, "rudder": 0.05}
    for width, depth in ((7.0, 0.3), (5.0, 0.5)):
        usual = ship.linearisation({**ship.values(), "width": width, "depth": depth})
        np.testing.assert_allclose(
            by_point.linear({**at, "width": width, "depth": depth}), usual.linear(at), rtol=1e-12
        )
        np.testing.assert_allclose(
            by_point.coefficients({**at, "width": width, "depth": depth}),
            usual.coefficients(at),
            rtol=1e-12,
            atol=1e-15,
        )


def bend(radius: float) -> Waterway:
    turned = np.linspace(0.0, 0.8, 2001)
    points = radius * np.stack([1 - np.cos(turned), np.sin(turned)], axis=1)
    ends = np.array([0.0, 0.8 * radius])
    return Waterway(Centreline(points), Bank("starboard", ends, np.full(2, 20.0)), Bank("port", ends, np.full(2, 20.0)))


@settings(max_examples=draws(10))
@given(st.floats(-8.0, 8.0), st.floats(-0.2, 0.2))
def test_corners_beside_a_bend_are_where_the_map_has_them(y: float, psi: float) -> None:
    radius, half_length, half_beam = 250.0, 10.0, 1.5
    way = MAPPED
    (middle,), along = way.to_map(np.array([100.0]), np.array([y]))
    heading = float(along[0]) + psi
    ahead, aside = np.array([np.sin(heading), np.cos(heading)]), np.array([np.cos(heading), -np.sin(heading)])
    state = np.array([[y, psi, 0.0, 0.0, 0.0]])
    off, by_heading, _ = LOOPS.corner_offsets(state, half_length, half_beam, np.array([1 / radius]))
    for number, (forward, side) in enumerate(CORNERS):
        corner = middle + forward * half_length * ahead + side * half_beam * aside
        _, there, _ = way.to_channel(corner[None], 0.0)
        assert off[number, 0] == pytest.approx(float(there[0]), abs=0.02)
    turned = state + np.array([0.0, 1e-6, 0.0, 0.0, 0.0])
    slope = (LOOPS.corner_offsets(turned, half_length, half_beam, np.array([1 / radius]))[0] - off) / 1e-6
    np.testing.assert_allclose(by_heading, slope, rtol=1e-3, atol=1e-3)


MAPPED = bend(250.0)


def test_clearance_rows_hold_as_the_corners_are_clear() -> None:
    states, e, G = 0.1 * random((6, 5)), np.zeros((6, 5)), 0.01 * random((6, 5, 6))
    hull, curvature, room = (10.0, 1.5), np.full(6, 0.001), (np.full((4, 6), 4.0), np.full((4, 6), 3.0))
    corners = LOOPS.corner_offsets(states, *hull, curvature)[:2]
    rows, bounds = LOOPS.clearance_rows(*corners, e, G, *room, np.inf)
    change = 0.01 * random(6)
    after, _, _ = LOOPS.corner_offsets(states + G @ change, *hull, curvature)
    sides = np.array(CORNERS)[:, 1:]
    clear = np.where(sides > 0, room[0], room[1]) - sides * after
    np.testing.assert_allclose(bounds - rows @ change, clear.ravel(), atol=1e-4)
    few, nearest = LOOPS.clearance_rows(*corners, e, G, *room, 2.0)
    assert len(few) == (bounds <= 2.0).sum() == len(nearest)


def test_the_cost_of_a_plan_is_the_sum_over_its_states() -> None:
    weights, beyond = Weights.of(DEFAULT_WEIGHTS, 2.0, 5.0), np.eye(5) + 0.3
    off, G, rates, change = random((4, 5)), random((4, 5, 4)), random(4), random(4)
    G *= np.tri(4)[:, None, :]  # a rate changes later states alone

    def cost(z: np.ndarray) -> float:
        states = off + G @ z
        within = sum(state @ np.diag(weights.states) @ state for state in states[:-1])
        return float(within + states[-1] @ beyond @ states[-1] + weights.rate * (rates + z) @ (rates + z)) / 2

    H, f = tracking_cost(off, G, rates, weights.states, weights.rate, beyond)
    assert change @ H @ change / 2 + f @ change == pytest.approx(cost(change) - cost(np.zeros(4)), rel=1e-10)


def programs() -> Iterator[QuadraticProgram]:
    for seed in range(3):
        draw = np.random.default_rng(seed).standard_normal
        root, n = draw((6, 4)), 4
        cost = root.T @ root + 0.1 * np.eye(n), 3 * draw(n)
        rudders, clearance = (0.1 * draw(n), draw((n, n))), (draw((5, n)), draw(5) - 1.0)
        yield program_of(cost, 0.1 * draw(n), rudders, clearance, (1.0, 0.4), 2.0)


def test_daqp_agrees_with_scipy() -> None:
    pytest.importorskip("daqp")
    for program in programs():
        n = len(program.f)
        everything = np.concatenate([np.eye(n), program.rows])
        clipped = np.minimum(program.upper, 1e3), np.maximum(program.lower, -1e3)
        limits = [
            {"type": "ineq", "fun": lambda z, E=everything, top=clipped[0]: top - E @ z},
            {"type": "ineq", "fun": lambda z, E=everything, low=clipped[1]: E @ z - low},
        ]
        start = np.append(np.zeros(n - 1), 10.0)
        cost = partial(cost_of, program)
        best = minimize(
            cost, start, jac=lambda z, p=program: p.H @ z + p.f, constraints=limits, method="SLSQP",
            options={"ftol": 1e-12, "maxiter": 500},
        )  # fmt: skip
        z = solve_program(program)
        assert z is not None
        assert (everything @ z <= program.upper + 1e-6).all()
        assert (everything @ z >= program.lower - 1e-6).all()
        assert cost(z) == pytest.approx(cost(best.x), rel=1e-6)
        np.testing.assert_allclose(z, best.x, atol=1e-3)


def cost_of(program: QuadraticProgram, z: np.ndarray) -> float:
    return float(z @ program.H @ z / 2 + program.f @ z)


def test_a_program_without_numbers_or_without_an_answer_has_none() -> None:
    pytest.importorskip("daqp")
    program = next(programs())
    assert solve_program(program._replace(f=np.full_like(program.f, np.nan))) is None
    beyond = program.upper.copy()
    beyond[len(program.f)] = -50.0  # a rudder that no rate brings within its limit
    assert solve_program(program._replace(upper=beyond, lower=np.minimum(program.lower, beyond))) is None


def test_weights_are_those_of_brysons_rule() -> None:
    """Two half beams of 2 m, 5 degrees, 10 degrees of rudder; those degrees in a tenth of the 5 s of a length."""
    chosen = RegulatorWeights(offset=2.0, heading_deg=5.0, rudder_deg=10.0, stroke_time=0.1)
    weights = Weights.of(chosen, 2.0, 5.0)
    np.testing.assert_allclose(weights.states, [1 / 16, (180 / (5 * np.pi)) ** 2, 0.0, 0.0, (180 / (10 * np.pi)) ** 2])
    assert weights.rate == pytest.approx((0.1 * 5.0 * 180 / (10 * np.pi)) ** 2)


def test_gains_are_those_of_value_iteration() -> None:
    A, weights = np.eye(5) + 0.05 * random((5, 5)), Weights.of(DEFAULT_WEIGHTS, 1.0, 10.0)
    A[4] = np.eye(5)[4]
    B = np.append(0.05 * random(4), 0.5)
    gains, cost = regulator_of(A, B, weights)
    now, Q = np.diag(weights.states), np.diag(weights.states)
    for _ in range(20000):
        row = B @ now @ A / (weights.rate + B @ now @ B)
        now = Q + A.T @ now @ (A - np.outer(B, row))
    np.testing.assert_allclose(cost, now, rtol=1e-6, atol=1e-8 * np.abs(now).max())
    np.testing.assert_allclose(gains, row, rtol=1e-6, atol=1e-8)


def test_a_rudder_that_drives_nothing_has_no_gains() -> None:
    A = np.diag([1.1, 1.0, 1.0, 1.0, 1.0])
    with pytest.raises(nw.InputError, match="has no effect"):
        regulator_of(A, np.array([0.0, 0, 0, 0, 1.0]), Weights.of(DEFAULT_WEIGHTS, 1.0, 10.0))


def test_a_steady_push_is_found_two_thirds_of_it_in_a_time_constant() -> None:
    truth, push = np.array([3.0, -2.0]), np.zeros(2)
    for second in range(1, 151):
        push = update_push(push, truth - push, 1.0, 15.0)
        if second == 15:
            np.testing.assert_allclose(push, (1.0 - np.exp(-1.0)) * truth)
    np.testing.assert_allclose(push, truth, rtol=1e-3)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_what_is_no_number_tells_nothing_of_a_push(wrong: float) -> None:
    push = np.array([1.0, 2.0])
    assert update_push(push, np.array([wrong, 1.0]), 1.0, 15.0) is push


def test_nodes_later_are_nodes_between() -> None:
    nodes = np.arange(5.0)[:, None] * [1.0, -2.0]

    def later(nodes: np.ndarray, share: float) -> np.ndarray:
        return np.asarray(LOOPS.interpolate(nodes, 1.0, np.arange(len(nodes)) + share))

    np.testing.assert_allclose(later(nodes, 0.0), nodes)
    np.testing.assert_allclose(later(nodes, 1.25)[:, 0], [1.25, 2.25, 3.25, 4.0, 4.0])
    np.testing.assert_allclose(later(nodes, 77.0)[:, 1], -8.0)


def test_a_horizon_is_as_long_as_the_ship_is_slow() -> None:
    usual = horizon_of(50.0, None, 30)
    assert usual.time == pytest.approx(120.0)
    assert (usual.interval, usual.period) == pytest.approx((4.0, 0.8))
    assert horizon_of(50.0, 60.0, 20).interval == pytest.approx(3.0)


def test_the_water_ahead_is_the_waterway_and_goes_on_beyond_its_ends() -> None:
    way, model = MAPPED, nw.Model(by_depth().configuration, by_depth().terms, by_depth().coefficients)
    water = water_ahead(model, way)
    s = np.linspace(0.0, way.line.length, 17)
    there, section = water.at(s), way.section(s)
    np.testing.assert_allclose(there["width"], section.width, rtol=1e-6)
    np.testing.assert_allclose(there["curvature"], section.curvature, atol=1e-5)
    np.testing.assert_allclose(there["depth"], model.configuration.canal.depth)
    beyond = water.at(np.array([-50.0, way.line.length + 500.0]))
    np.testing.assert_allclose(beyond["width"], there["width"][[0, -1]])
    own = water_ahead(model, None).at(np.array([3.0, 1e6]))
    np.testing.assert_allclose(own["keel_starboard"], model.configuration.canal.width / 2)


def test_margins_grow_by_what_the_push_at_the_start_leaves_unexplained() -> None:
    """By hand: a sway acceleration that differs by 2 from the first is 2 m after two intervals, of 0.1 uncertainty."""
    ship = SimpleNamespace(length=6.0)
    model = SimpleNamespace(covariance=np.array([[0.01]]), configuration=SimpleNamespace(ship=ship))
    A = np.eye(5)
    A[0, 2] = A[1, 3] = 1.0  # offset by sway, heading by yaw
    motion, no_helm = (A, np.eye(5)), np.zeros(5)

    def margins(sway: list[float], yaw: list[float]) -> np.ndarray:
        slopes = np.zeros((4, 6, 1))
        slopes[:, 4, 0], slopes[:, 5, 0] = sway, yaw
        return margins_of(model, motion, slopes, no_helm, 0.5, 0.975)

    two_sided = 1.959964  # standard deviations of a normal distribution below which 97.5 % lie
    np.testing.assert_allclose(margins([7.0] * 4, [-3.0] * 4), 0.5)
    np.testing.assert_allclose(margins([7.0, 9.0, 9.0, 9.0], [0.0] * 4), [0.5, 0.5, 0.5 + two_sided * 0.1 * 2.0], 1e-6)
    # A heading off by 2 brings a corner half a length, 3 m, times as far off the line.
    np.testing.assert_allclose(margins([0.0] * 4, [1.0, 3.0, 3.0, 3.0]), [0.5, 0.5, 0.5 + two_sided * 0.1 * 6.0], 1e-6)
    model.covariance = None
    np.testing.assert_array_equal(margins([7.0, 9.0, 9.0, 9.0], [0.0] * 4), 0.5)
