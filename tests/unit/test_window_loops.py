"""Loops over windows, held to whole matrices of NumPy; as they stand and compiled."""

from types import ModuleType

import numpy as np
import pytest
from narrows.logbook.shooting import window_loops

from narrows.codegen.cache import compiled_loops

COMPILED = compiled_loops(window_loops)
WINDOWS, LOCAL, WIDE, NODES, READ = 5, 8, 12, 3, 17


@pytest.fixture(params=[window_loops, COMPILED], ids=["in Python", "compiled"])
def loops(request: pytest.FixtureRequest) -> ModuleType:
    return request.param


def test_loops_are_compiled() -> None:
    assert COMPILED is not window_loops
    assert COMPILED is compiled_loops(window_loops)


def test_readings_are_added_as_squares_of_their_rows(loops: ModuleType) -> None:
    draw = np.random.default_rng(1)
    along = draw.normal(size=(WINDOWS * NODES, 6, WIDE))
    window = np.sort(draw.integers(0, WINDOWS, READ))
    row = window * NODES + draw.integers(0, NODES - 1, READ)
    share, weight, residual = draw.uniform(size=READ), draw.uniform(0.5, 2.0, READ), draw.normal(size=READ)
    states, places = np.array([1, 4]), np.array([7, 9, 11])
    by_state, by_error = draw.normal(size=(2, READ)), draw.normal(size=(3, READ))
    begun = draw.normal(size=(WINDOWS, WIDE, WIDE)), draw.normal(size=(WINDOWS, WIDE))
    hessian, gradient = (part.copy() for part in begun)
    told = row, share, window, states, by_state, places, by_error, weight, residual
    loops.add_readings(hessian, gradient, along, *told)
    between = (1 - share)[:, None, None] * along[row] + share[:, None, None] * along[row + 1]
    rows = np.einsum("si,isp->ip", by_state, between[:, states])
    rows[:, places] += by_error.T
    rows *= weight[:, None]
    for k in range(WINDOWS):
        here = rows[window == k]
        np.testing.assert_allclose(hessian[k], begun[0][k] + here.T @ here, rtol=1e-12, atol=1e-12)
        left = (residual * weight)[window == k]
        np.testing.assert_allclose(gradient[k], begun[1][k] + here.T @ left, rtol=1e-12, atol=1e-12)


def test_links_are_weighed_as_by_whole_matrices(loops: ModuleType) -> None:
    draw, count = np.random.default_rng(2), WINDOWS - 1
    roots = draw.normal(size=(count, LOCAL, LOCAL))
    weight, ends = roots @ np.swapaxes(roots, 1, 2), draw.normal(size=(WINDOWS, 6, WIDE))
    kept, gap = draw.uniform(size=LOCAL - 6), draw.normal(size=(count, LOCAL))
    filled = [np.empty(shape) for shape in ((count, LOCAL, WIDE), (count, WIDE, WIDE), (count, LOCAL), (count, WIDE))]
    loops.weigh_links(weight, ends, kept, gap, *filled)
    slopes = np.zeros((count, LOCAL, WIDE))
    slopes[:, :6] = ends[:-1]
    slopes[:, range(6, LOCAL), range(6, LOCAL)] = kept
    turned, pull = np.swapaxes(slopes, 1, 2), np.einsum("kij,kj->ki", weight, gap)
    wanted = weight @ slopes, turned @ weight @ slopes, pull, np.einsum("kai,ki->ka", turned, pull)
    for own, other in zip(filled, wanted, strict=True):
        np.testing.assert_allclose(own, other, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("linked", [True, False])
def test_a_chain_is_solved_as_the_whole_matrix(loops: ModuleType, linked: bool) -> None:
    draw, sides_count = np.random.default_rng(3), 4
    roots = draw.normal(size=(WINDOWS, LOCAL, LOCAL))
    diagonal = roots @ np.swapaxes(roots, 1, 2) + 20 * np.eye(LOCAL)
    below = draw.normal(size=(WINDOWS - 1 if linked else 0, LOCAL, LOCAL))
    whole = np.zeros((WINDOWS, LOCAL, WINDOWS, LOCAL))
    for k in range(WINDOWS):
        whole[k, :, k] = diagonal[k]
    for k in range(len(below)):
        whole[k + 1, :, k], whole[k, :, k + 1] = below[k], below[k].T
    matrix = whole.reshape(WINDOWS * LOCAL, -1)
    sides = draw.normal(size=(WINDOWS, LOCAL, sides_count))
    solved, (factor, across) = sides.copy(), np.empty((2, WINDOWS, LOCAL, LOCAL))
    determinant = loops.eliminate(diagonal, below, factor, across, solved)
    assert determinant == pytest.approx(np.linalg.slogdet(matrix)[1], rel=1e-12)
    flat, half = sides.reshape(len(matrix), -1), solved.reshape(len(matrix), -1)
    np.testing.assert_allclose(half.T @ half, flat.T @ np.linalg.solve(matrix, flat), rtol=1e-10, atol=1e-12)
    loops.substitute_back(factor, across, linked, solved)
    np.testing.assert_allclose(solved.reshape(len(matrix), -1), np.linalg.solve(matrix, flat), rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("spoilt", [-1.0, np.nan])
def test_what_is_not_positive_definite_is_no_number(loops: ModuleType, spoilt: float) -> None:
    diagonal, below = np.stack([np.eye(LOCAL)] * WINDOWS), np.zeros((WINDOWS - 1, LOCAL, LOCAL))
    diagonal[2, 3, 3] = spoilt
    factor, across = np.empty((2, WINDOWS, LOCAL, LOCAL))
    assert np.isnan(loops.eliminate(diagonal, below, factor, across, np.ones((WINDOWS, LOCAL, 1))))
