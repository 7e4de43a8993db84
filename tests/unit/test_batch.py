"""Many constrained fits at once against the exact solver one by one, and against SciPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from narrows.identification.least_squares import solve, solve_many


def problems(seed: int, size: int = 6, count: int = 40) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    draw = np.random.default_rng(seed)
    columns = draw.normal(size=(count, 30, size)) @ (np.eye(size) + 0.9 * draw.normal(size=(size, size)))
    columns /= np.linalg.norm(columns, axis=1, keepdims=True)
    h = np.einsum("nri,nrj->nij", columns, columns)
    g = np.einsum("nri,nr->ni", columns, draw.normal(size=(count, 30)))
    lower = np.where(draw.random(size) < 0.6, 0.0, -np.inf)
    upper = np.where(draw.random(size) < 0.3, 0.05, np.inf)
    return h, g, lower, upper


@given(seed=st.integers(0, 10_000))
def test_as_the_exact_solver(seed: int) -> None:
    h, g, lower, upper = problems(seed)
    found = solve_many(h, g, lower, upper)
    exact = np.array([solve(own, right, lower, upper).z for own, right in zip(h, g, strict=True)])
    np.testing.assert_allclose(found, exact, rtol=1e-6, atol=1e-8)
    assert (found >= lower - 1e-12).all()
    assert (found <= upper + 1e-12).all()


def test_as_scipy() -> None:
    h, g, lower, upper = problems(1)
    factor = np.linalg.cholesky(h[0]).T
    target = np.linalg.solve(factor.T, g[0])
    scipy = lsq_linear(factor, target, (lower, upper), method="bvls", tol=1e-14).x
    np.testing.assert_allclose(solve_many(h[:1], g[:1], lower, upper)[0], scipy, atol=1e-9)


def test_one_matrix_serves_all() -> None:
    h, g, lower, upper = problems(2)
    repeated = np.broadcast_to(h[0], h.shape)
    np.testing.assert_array_equal(solve_many(h[0], g, lower, upper), solve_many(repeated, g, lower, upper))


def test_a_direction_without_data_stays_at_rest() -> None:
    h, g, _, upper = problems(3)
    h[:, 2, :] = h[:, :, 2] = 0.0
    g[:, 2] = 0.0
    found = solve_many(h, g, np.full(6, -np.inf), upper)
    assert not found[:, 2].any()
    each = [solve(own, right, np.full(6, -np.inf), upper) for own, right in zip(h, g, strict=True)]
    np.testing.assert_allclose(found, [one.z for one in each], rtol=1e-6, atol=1e-8)
    assert not any(one.at_bound[2] for one in each)


def test_a_direction_with_hardly_any_data_is_damped_as_by_tikhonov() -> None:
    """Of an eigenvalue d, the share d / (d + 1e-13) of the solution is left (Tikhonov and Arsenin, 1977)."""
    data = np.array([0.0, 1e-15, 1e-13, 4e-13, 1e-8])
    h, g = np.stack([np.ones_like(data), data], axis=1)[:, None] * np.eye(2), np.stack([np.ones_like(data), data], 1)
    found = solve_many(h, g, np.full(2, -np.inf), np.full(2, np.inf))
    np.testing.assert_allclose(found[:, 0], 1.0, rtol=1e-12)
    np.testing.assert_allclose(found[:, 1], [0.0, 1 / 101, 0.5, 0.8, 1.0], rtol=1e-4)


def test_more_problems_than_are_solved_at_once() -> None:
    """z = g within the bounds, of 5 000 problems with a unit matrix."""
    g = np.random.default_rng(0).normal(size=(5000, 2))
    np.testing.assert_allclose(solve_many(np.eye(2), g, np.full(2, -0.5), np.full(2, 1.0)), np.clip(g, -0.5, 1.0))


def test_what_cycles_goes_to_the_exact_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("narrows.identification.least_squares.MOST_ROUNDS", 1)
    h, g, lower, upper = problems(4)
    exact = np.array([solve(own, right, lower, upper).z for own, right in zip(h, g, strict=True)])
    np.testing.assert_allclose(solve_many(h, g, lower, upper), exact, rtol=1e-6, atol=1e-8)


def test_no_problems_no_solutions() -> None:
    assert solve_many(np.eye(3), np.empty((0, 3)), np.zeros(3), np.ones(3)).shape == (0, 3)
