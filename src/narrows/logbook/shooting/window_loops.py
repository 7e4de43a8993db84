"""Loops over the windows of a record, which are many and small: what a library would be called for a thousand times."""

import math

import numpy as np


def add_readings(
    hessian: np.ndarray, gradient: np.ndarray, along: np.ndarray, row: np.ndarray, share: np.ndarray,
    window: np.ndarray, states: np.ndarray, by_state: np.ndarray, places: np.ndarray, by_error: np.ndarray,
    weight: np.ndarray, residual: np.ndarray,
) -> None:  # fmt: skip
    """Add a signal's readings to the squares and products of their windows."""
    # hessian (windows, d, d); gradient (windows, d); along (rows, 6, d); row (n,); share (n,); window (n,); states
    # (s,); by_state (s, n); places (e,); by_error (e, n); weight (n,); residual (n,)
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
    """Weigh what windows miss the ends of those before them by."""
    # weight (links, m, m); ends (links, 6, d); kept (m - 6,); gap (links, m); weighed (links, m, d); squares (links,
    # d, d); pull (links, m); pulled (links, d)
    # What a window should begin with goes with the unknowns before it by S, its first six rows by ``ends``, the others
    # each by what is kept of the same number of the chain.
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
    """Solve half of a chain of windows, by blocks (Cholesky), and return the logarithm of its determinant."""
    # diagonal (windows, m, m); below (windows - 1, m, m); factor (windows, m, m); across (windows, m, m); sides
    # (windows, m, s)
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
    """Take out of a window what is the one before it."""
    # below (m, m); before (m, m); across (m, m); here (m, m)
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
    """Take a matrix times some sides from others."""
    # matrix (m, m); source (m, s); target (m, s)
    for i in range(len(matrix)):
        for p in range(len(matrix)):
            for j in range(source.shape[1]):
                target[i, j] -= matrix[i, p] * source[p, j]


def lower(matrix: np.ndarray, sides: np.ndarray) -> float:
    """Put the lower Cholesky factor of a matrix in its place, solve sides by it, and return log of its determinant."""
    # matrix (m, m); sides (m, s)
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
    """Solve the other half of a chain of windows."""
    # factor, across (windows, m, m); sides (windows, m, s)
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
