"""Loops over the windows of a record, which are many and small: what a library would be called for a thousand times."""

import math

import numpy as np


def add_readings(
    hessian: np.ndarray, gradient: np.ndarray, along: np.ndarray, row: np.ndarray, share: np.ndarray,
    window: np.ndarray, states: np.ndarray, by_state: np.ndarray, places: np.ndarray, by_error: np.ndarray,
    weight: np.ndarray, residual: np.ndarray,
) -> None:  # fmt: skip
    """Add a signal's readings to the squares and products of their windows (ours).

    Parameters
    ----------
    hessian : array (windows, d, d)
        Squares of slopes, added to.
    gradient : array (windows, d)
        Products of slopes and residuals, added to.
    along : array (rows, 6, d)
        Slopes of the states at the nodes.
    row : array (n,) of int
        The node before each reading.
    share : array (n,) [1]
        Of the step that is over.
    window : array (n,) of int
        In which each lies.
    states : array (s,) of int
        That the signal depends on.
    by_state : array (s, n)
        Its slopes by these.
    places : array (e,) of int
        Of unknowns that it depends on as they are.
    by_error : array (e, n)
        Its slopes by these.
    weight : array (n,)
        Over which noise.
    residual : array (n,)
        Read less predicted.
    """
    line = np.empty(along.shape[2])
    for i in range(len(row)):
        line[:] = 0.0
        near, far = along[row[i]], along[row[i] + 1]
        for k in range(len(states)):
            slope = by_state[k, i] * weight[i]
            after = slope * share[i]
            before, start, end = slope - after, near[states[k]], far[states[k]]
            for p in range(len(line)):
                line[p] += before * start[p] + after * end[p]
        for k in range(len(places)):
            line[places[k]] += by_error[k, i] * weight[i]
        left, squares, products = residual[i] * weight[i], hessian[window[i]], gradient[window[i]]
        for p in range(len(line)):
            value, target = line[p], squares[p]
            if value != 0.0:
                products[p] += value * left
                for q in range(len(line)):
                    target[q] += value * line[q]


def weigh_links(
    weight: np.ndarray, ends: np.ndarray, kept: np.ndarray, gap: np.ndarray, weighed: np.ndarray, squares: np.ndarray,
    pull: np.ndarray, pulled: np.ndarray,
) -> None:  # fmt: skip
    """Weigh what windows miss the ends of those before them by (ours).

    What a window should begin with goes with the unknowns before it by S, its first six rows by ``ends``, the others
    each by what is kept of the same number of the chain.

    Parameters
    ----------
    weight : array (links, m, m)
        Of each link, W.
    ends : array (links, 6, d)
        Slopes of the ends.
    kept : array (m - 6,) [1]
        Of the chain.
    gap : array (links, m)
        What is missed.
    weighed : array (links, m, d)
        Filled with W S.
    squares : array (links, d, d)
        Filled with S' W S.
    pull : array (links, m)
        Filled with W times what is missed.
    pulled : array (links, d)
        Filled with S' of that.
    """
    count, size, wide = weighed.shape
    for k in range(count):
        for i in range(size):
            line = weighed[k, i]
            line[:] = 0.0
            pull[k, i] = 0.0
            for p in range(size):
                pull[k, i] += weight[k, i, p] * gap[k, p]
            for p in range(6):
                end = ends[k, p]
                for q in range(wide):
                    line[q] += weight[k, i, p] * end[q]
            for p in range(6, size):
                line[p] += weight[k, i, p] * kept[p - 6]
        squares[k] = 0.0
        pulled[k] = 0.0
        for i in range(6):
            line = weighed[k, i]
            for p in range(wide):
                pulled[k, p] += ends[k, i, p] * pull[k, i]
                target = squares[k, p]
                for q in range(wide):
                    target[q] += ends[k, i, p] * line[q]
        for i in range(6, size):
            pulled[k, i] += kept[i - 6] * pull[k, i]
            for q in range(wide):
                squares[k, i, q] += kept[i - 6] * weighed[k, i, q]


def eliminate(
    diagonal: np.ndarray, below: np.ndarray, factor: np.ndarray, across: np.ndarray, sides: np.ndarray
) -> float:
    """Solve half of a chain of windows, by blocks (Cholesky), and return the logarithm of its determinant.

    Parameters
    ----------
    diagonal : array (windows, m, m)
        Of each window with itself.
    below : array (windows - 1, m, m)
        Of each window with the one before; (0, m, m) where windows stand alone.
    factor : array (windows, m, m)
        Filled with the lower factors.
    across : array (windows, m, m)
        Filled with the factors of each window with the one before.
    sides : array (windows, m, s)
        Right-hand sides, half solved in place.

    Returns
    -------
    float
        Not a number where the matrix is not positive definite.
    """
    determinant = 0.0
    for k in range(len(diagonal)):
        factor[k] = diagonal[k]
        if k > 0 and len(below):
            link(below[k - 1], factor[k - 1], across[k], factor[k])
            take(across[k], sides[k - 1], sides[k])
        half = lower(factor[k], sides[k])
        if not half < math.inf:
            return math.nan
        determinant += 2 * half
    return determinant


def link(below: np.ndarray, before: np.ndarray, across: np.ndarray, here: np.ndarray) -> None:
    """Take out of a window what is the one before it (ours).

    Parameters
    ----------
    below : array (m, m)
        Of the window with the one before.
    before : array (m, m)
        Lower factor of the one before.
    across : array (m, m)
        Filled with the factor of both.
    here : array (m, m)
        Of the window with itself, changed on and below its diagonal.
    """
    size = len(here)
    for i in range(size):
        for j in range(size):
            value = below[i, j]
            for p in range(j):
                value -= across[i, p] * before[j, p]
            across[i, j] = value / before[j, j]
    for i in range(size):
        for j in range(i + 1):
            value = 0.0
            for p in range(size):
                value += across[i, p] * across[j, p]
            here[i, j] -= value


def take(matrix: np.ndarray, source: np.ndarray, target: np.ndarray) -> None:
    """Take a matrix times some sides from others (ours).

    Parameters
    ----------
    matrix : array (m, m)
        The matrix.
    source : array (m, s)
        Sides.
    target : array (m, s)
        Changed.
    """
    for i in range(len(matrix)):
        for p in range(len(matrix)):
            for j in range(source.shape[1]):
                target[i, j] -= matrix[i, p] * source[p, j]


def lower(matrix: np.ndarray, sides: np.ndarray) -> float:
    """Put the lower Cholesky factor of a matrix in its place, solve sides by it, and return log of its determinant.

    Parameters
    ----------
    matrix : array (m, m)
        Changed on and below the diagonal.
    sides : array (m, s)
        Solved in place.

    Returns
    -------
    float
        Infinite where the matrix is not positive definite.
    """
    determinant = 0.0
    for i in range(len(matrix)):
        for j in range(i):
            value = matrix[i, j]
            for p in range(j):
                value -= matrix[i, p] * matrix[j, p]
            matrix[i, j] = value / matrix[j, j]
        square = matrix[i, i]
        for p in range(i):
            square -= matrix[i, p] * matrix[i, p]
        if not square > 0.0:
            return math.inf
        root = math.sqrt(square)
        matrix[i, i] = root
        determinant += math.log(root)
        for p in range(i):
            for j in range(sides.shape[1]):
                sides[i, j] -= matrix[i, p] * sides[p, j]
        for j in range(sides.shape[1]):
            sides[i, j] /= root
    return determinant


def substitute_back(factor: np.ndarray, across: np.ndarray, linked: bool, sides: np.ndarray) -> None:
    """Solve the other half of a chain of windows (ours).

    Parameters
    ----------
    factor, across : array (windows, m, m)
        As ``eliminate`` left them.
    linked : bool
        Whether windows have anything to do with each other.
    sides : array (windows, m, s)
        Half solved; solved in place.
    """
    count, size, width = sides.shape
    for k in range(count - 1, -1, -1):
        if linked and k < count - 1:
            for p in range(size):
                for i in range(size):
                    for j in range(width):
                        sides[k, i, j] -= across[k + 1, p, i] * sides[k + 1, p, j]
        for i in range(size - 1, -1, -1):
            for p in range(i + 1, size):
                for j in range(width):
                    sides[k, i, j] -= factor[k, p, i] * sides[k, p, j]
            for j in range(width):
                sides[k, i, j] /= factor[k, i, i]
