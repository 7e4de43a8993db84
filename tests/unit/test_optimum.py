"""The optimum of problems harder than the usual: upper bounds, dependent columns, no freedom at all."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import lsq_linear

import narrows as nw
from narrows.identification.least_squares import kkt_residuals, solve
from narrows.model.term import without


def problem(seed: int, rank: int, size: int = 5) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A consistent scaled problem of some rank, with a mix of bounds."""
    draw = np.random.default_rng(seed)
    matrix = draw.normal(size=(30, rank)) @ draw.normal(size=(rank, size))
    matrix /= np.linalg.norm(matrix, axis=0)
    lower = draw.choice([-np.inf, 0.0, -0.3], size)
    upper = draw.choice([np.inf, 0.5, 2.0], size)
    return matrix, draw.normal(size=30), lower, upper


def worth(matrix: np.ndarray, right: np.ndarray, z: np.ndarray) -> float:
    return float(((right - matrix @ z) ** 2).sum())


def best_of_all_faces(matrix: np.ndarray, right: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> float:
    """The least squared error over every choice of parameters at their lower bound, at their upper, or free."""
    best = np.inf
    for face in product("lfu", repeat=len(lower)):
        z = np.select([np.array(face) == "l", np.array(face) == "u"], [lower, upper], 0.0)
        free = np.array(face) == "f"
        if not np.isfinite(z).all():
            continue
        if free.any():
            z[free] = np.linalg.lstsq(matrix[:, free], right - matrix[:, ~free] @ z[~free], rcond=None)[0]
        if (z >= lower - 1e-9).all() and (z <= upper + 1e-9).all():
            best = min(best, worth(matrix, right, z))
    return best


@pytest.mark.parametrize("rank", [5, 3])
@pytest.mark.parametrize("seed", range(12))
def test_no_face_of_the_box_is_better(seed: int, rank: int) -> None:
    matrix, right, lower, upper = problem(seed, rank)
    solution = solve(matrix.T @ matrix, matrix.T @ right, lower, upper)
    assert (solution.z >= lower).all()
    assert (solution.z <= upper).all()
    # Where columns are dependent a face's point of smallest norm may leave the box though another would not.
    assert worth(matrix, right, solution.z) <= best_of_all_faces(matrix, right, lower, upper) * (1 + 1e-9)
    assert solution.kkt.satisfied


def test_a_step_that_ends_a_rounding_short_of_a_bound_is_at_it() -> None:
    """Of many problems with dependent columns some do; which of them differs by processor."""
    for seed in range(20, 220):
        matrix, right, lower, upper = problem(seed, 3)
        assert solve(matrix.T @ matrix, matrix.T @ right, lower, upper).kkt.satisfied, seed


@pytest.mark.parametrize("seed", range(12))
def test_agrees_with_scipys_other_method(seed: int) -> None:
    """The trust-region method knows nothing of active sets."""
    matrix, right, lower, upper = problem(seed + 100, 5)
    other = lsq_linear(matrix, right, (lower, upper), method="trf", tol=1e-13, lsq_solver="exact").x
    found = solve(matrix.T @ matrix, matrix.T @ right, lower, upper).z
    assert worth(matrix, right, found) <= worth(matrix, right, other) * (1 + 1e-12)
    np.testing.assert_allclose(found, other, atol=1e-5)


def test_no_data_at_all_stays_at_zero_or_at_the_nearest_bound() -> None:
    lower, upper = np.array([-np.inf, 0.0, 1.0, -3.0]), np.array([np.inf, np.inf, 2.0, -1.0])
    solution = solve(np.zeros((4, 4)), np.zeros(4), lower, upper)
    np.testing.assert_array_equal(solution.z, [0.0, 0.0, 1.0, -1.0])


def test_everything_at_a_bound() -> None:
    h, g = np.eye(3), np.full(3, -1.0)
    solution = solve(h, g, np.zeros(3), np.full(3, np.inf))
    np.testing.assert_array_equal(solution.z, 0.0)
    assert solution.at_bound.all()
    assert solution.kkt.satisfied


@pytest.mark.parametrize("move", [1e-6, -1e-6])
@pytest.mark.parametrize("i", range(5))
def test_a_point_off_the_optimum_is_told_from_it(i: int, move: float) -> None:
    matrix, right, lower, upper = problem(3, 5)
    h, g = matrix.T @ matrix, matrix.T @ right
    z = solve(h, g, lower, upper).z
    assert kkt_residuals(h, g, z, lower, upper).satisfied
    z[i] += move
    assert not kkt_residuals(h, g, z, lower, upper).satisfied


def test_a_bound_with_the_wrong_sign_of_multiplier_is_told() -> None:
    """Inside the bounds and stationary in what is free, yet not optimal: the held one wants to leave."""
    h, g, lower, upper = np.eye(2), np.array([1.0, 1.0]), np.zeros(2), np.full(2, np.inf)
    found = kkt_residuals(h, g, np.array([1.0, 0.0]), lower, upper)
    assert (found.stationarity, found.infeasibility) == (0.0, 0.0)
    assert found.multiplier == pytest.approx(1.0)
    assert not found.satisfied


@pytest.mark.parametrize(("low", "high"), [(5.0, 1.0), (np.inf, np.inf)])
def test_bounds_without_room_are_refused(short: nw.CaptiveTests, low: float, high: float) -> None:
    own = nw.Term("b_v", "b_v", nw.PAPER["b_v"].regressor, nw.PAPER["b_v"].dimension, (low, high))
    with pytest.raises(nw.InputError, match=f"bounds {low:g} to {high:g} leave b_v no room"):
        nw.identify(short, nw.PAPER.with_terms("narrow", sway=[own]))


def test_a_fixed_coefficient_stays(short: nw.CaptiveTests) -> None:
    """The others are those of a fit to the forces less that of the fixed one."""
    fit = nw.identify(short, fixed={"b_v": 5.0})
    assert fit["b_v"] == 5.0
    assert fit.std["b_v"] == 0.0
    assert fit.intervals["b_v"] == (5.0, 5.0)
    less = replace(short, columns={**short.columns, "Y": short["Y"] - 5.0 * nw.PAPER["b_v"].column(short.columns)})
    rest = nw.identify(less, without(nw.PAPER, "rest", lambda term: term.name == "b_v"))
    values = fit.least_squares
    assert [values[name] for name in rest.terms.names] == pytest.approx(
        [*rest.least_squares.values()], rel=1e-6, abs=1e-6
    )


def test_all_coefficients_of_a_force_may_be_fixed(short: nw.CaptiveTests) -> None:
    fixed = {term.name: 1.0 for term in nw.PAPER.surge}
    fit = nw.identify(short, fixed=fixed)
    assert {name: fit[name] for name in fixed} == fixed
    assert {fit.std[name] for name in fixed} == {0.0}


@pytest.mark.parametrize(("name", "place"), [("b_rdot", "sway"), ("c_vdot", "yaw")])
def test_ties_join_bounds(name: str, place: str, short: nw.CaptiveTests) -> None:
    """Of two tied coefficients the tighter bound holds for both, whichever has it."""
    own = nw.Term(name, name, nw.PAPER[name].regressor, nw.PAPER[name].dimension, (-10.0, 10.0))
    fit = nw.identify(short, nw.PAPER.with_terms("bounded", **{place: [own]}))
    assert fit.coefficients["b_rdot"] == fit.coefficients["c_vdot"] == -10.0
    assert {"b_rdot", "c_vdot"} <= set(fit.at_bound)


@pytest.mark.parametrize("side", [-1, 1])
def test_at_a_bound_that_the_data_reject_the_posterior_is_truncated(short: nw.CaptiveTests, side: int) -> None:
    free = nw.identify(short)
    value, std = free.coefficients["b_v"], free.std["b_v"]
    bound = value - 4 * side * std
    room = (bound - 1e4, bound) if side > 0 else (bound, bound + 1e4)
    own = nw.Term("b_v", "b_v", nw.PAPER["b_v"].regressor, nw.PAPER["b_v"].dimension, room)
    fit = nw.identify(short, nw.PAPER.with_terms("bounded", sway=[own]))
    assert fit.verdicts["b_v"].status == "at bound"
    assert fit.std["b_v"] == pytest.approx(std * stats.truncnorm(4, np.inf).std(), rel=0.1)
    near, far = sorted(fit.intervals["b_v"], key=lambda end: abs(end - bound))
    assert near == fit.coefficients["b_v"] == pytest.approx(bound)
    assert 0.2 * std < side * (near - far) < std


def test_a_chain_of_ties_is_one_parameter(short: nw.CaptiveTests) -> None:
    chained = nw.TermTable(
        "chained", nw.PAPER.surge, nw.PAPER.sway, nw.PAPER.yaw, (("b_rdot", "c_vdot"), ("c_vdot", "b_rr"))
    )
    values = nw.identify(short, chained).coefficients
    assert values["b_rdot"] == values["c_vdot"] == values["b_rr"]
    assert nw.identify(short, chained).solution.kkt.satisfied
