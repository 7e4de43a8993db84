"""Loops over the intervals of a plan, which Numba compiles."""

import numpy as np


def interpolate(table: np.ndarray, step: float, x: np.ndarray) -> np.ndarray:
    """Return values at x of columns, linear between equal steps from 0 on, constant beyond the ends."""
    last, values = len(table) - 1, np.empty((len(x), table.shape[1]))
    for row in range(len(x)):
        position = min(max(x[row] / step, 0.0), 1.0 * last) if x[row] == x[row] else x[row]  # NaN stays NaN
        cell = min(int(position), last - 1) if position > 0.0 else 0
        for column in range(table.shape[1]):
            rise = table[cell + 1, column] - table[cell, column]
            values[row, column] = table[cell, column] + (position - cell) * rise
    return values


def condensed(A: np.ndarray, B: np.ndarray, defects: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return e and G; states after each interval deviate from their nodes by e + G @ change of the rates."""
    # The recursion off_(k+1) = A_k off_k + B_k change_k + defect_k, so that the rates alone remain in the program.
    intervals, size = B.shape
    e, G = defects.copy(), np.zeros((intervals, size, intervals))
    for k in range(intervals):
        if k:
            e[k] += A[k] @ e[k - 1]
            G[k] = A[k] @ G[k - 1]
        G[k, :, k] = B[k]
    return e, G


def tracking_cost(
    off: np.ndarray, G: np.ndarray, rates: np.ndarray, weights: np.ndarray, by_rate: float, beyond: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return H and f of the cost of deviations from the reference and of turning the rudder."""
    weighted, rows = weights.reshape(-1, 1) * G, (-1, len(rates))
    weighted[-1] = beyond @ G[-1]
    H = by_rate * np.eye(len(rates)) + G.reshape(rows).T @ weighted.reshape(rows)
    return H, by_rate * rates + off.ravel() @ weighted.reshape(rows)


def corner_offsets(
    states: np.ndarray, half_length: float, half_beam: float, curvature: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the corners' offsets, their derivatives by the heading, and their distance ahead, (4, nodes) each."""
    # In a bend the line curves away ahead and astern by half its curvature times the distance squared.
    sine, cosine = np.sin(states[:, 1]), np.cos(states[:, 1])
    forward = half_length * np.array([[1.0], [-1.0], [1.0], [-1.0]])
    aside = half_beam * np.array([[1.0], [1.0], [-1.0], [-1.0]])
    ahead, across = forward * cosine - aside * sine, forward * sine + aside * cosine
    return states[:, 0] + across - curvature * ahead**2 / 2, ahead * (1.0 + curvature * across), ahead


def clearance_rows(
    off: np.ndarray, lever: np.ndarray, e: np.ndarray, G: np.ndarray, starboard: np.ndarray, port: np.ndarray,
    spare: float,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return rows and bounds: rows @ change of the rates <= bounds keeps every corner off the banks."""
    # corners and clearance at the banks (4, nodes) [m]; e (nodes, 5); G (nodes, 5, rates)
    node, side = np.arange(off.size) % len(e), np.repeat(np.array([1.0, 1.0, -1.0, -1.0]), len(e))
    reach = side * (off.ravel() + e[node, 0] + lever.ravel() * e[node, 1])
    bounds = np.where(side > 0, starboard.ravel(), port.ravel()) - reach
    near = np.flatnonzero(~(bounds > spare))  # Keeps NaN, so that the program refuses it
    across, turned = G[:, 0][node[near]], G[:, 1][node[near]]
    return side[near].reshape(-1, 1) * (across + lever.ravel()[near].reshape(-1, 1) * turned), bounds[near]
