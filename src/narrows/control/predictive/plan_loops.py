"""Loops over the intervals of a plan, which Numba compiles."""

import math

import numpy as np


def interpolate(table: np.ndarray, first: float, step: float, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return values and slopes at x of columns, linear between equal steps from the first, constant beyond the ends."""
    last = len(table) - 1
    values, slopes = np.empty((len(x), table.shape[1])), np.empty((len(x), table.shape[1]))
    for row in range(len(x)):
        position = (x[row] - first) / step
        inside = 0.0 < position < last
        if not inside:  # NaN stays NaN
            position = 0.0 if position <= 0.0 else 1.0 * last if position >= last else position
        cell = min(int(position), last - 1) if position > 0.0 else 0
        for column in range(table.shape[1]):
            rise = table[cell + 1, column] - table[cell, column]
            values[row, column] = table[cell, column] + (position - cell) * rise
            slopes[row, column] = rise / step if inside else 0.0
    return values, slopes


def condensed(A: np.ndarray, B: np.ndarray, defects: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return e and G; states after each interval deviate from their nodes by e + G @ change of the rates."""
    # The recursion off_(k+1) = A_k off_k + B_k change_k + defect_k, so that the rates alone remain in the program.
    intervals, size = B.shape
    e, G = defects.copy(), np.zeros((intervals, size, intervals))
    for k in range(intervals):
        for row in range(size):
            G[k, row, k] = B[k, row]
            for j in range(size if k else 0):
                e[k, row] += A[k, row, j] * e[k - 1, j]
                for column in range(k):
                    G[k, row, column] += A[k, row, j] * G[k - 1, j, column]
    return e, G


def tracking_cost(
    off: np.ndarray, G: np.ndarray, rates: np.ndarray, weights: np.ndarray, by_rate: float, beyond: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return H and f of the cost of deviations from the reference and of turning the rudder."""
    # A rate changes the states after it alone: G[k, :, i] = 0 for i > k.
    intervals, size = off.shape
    H, f = by_rate * np.eye(intervals), by_rate * rates
    for k in range(intervals):
        for row in range(size):
            for other in range(size):
                weight = beyond[row, other] if k == intervals - 1 else weights[row] if row == other else 0.0
                for i in range(k + 1 if weight else 0):
                    f[i] += weight * G[k, row, i] * off[k, other]
                    for j in range(k + 1):
                        H[i, j] += weight * G[k, row, i] * G[k, other, j]
    return H, f


def corner_offsets(
    states: np.ndarray, half_length: float, half_beam: float, curvature: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the corners' offsets, their derivatives by the heading, and their distance ahead, (4, nodes) each."""
    # In a bend the line curves away ahead and astern by half its curvature times the distance squared.
    off, lever, ahead = np.empty((4, len(states))), np.empty((4, len(states))), np.empty((4, len(states)))
    for node in range(len(states)):
        sine, cosine = math.sin(states[node, 1]), math.cos(states[node, 1])
        for corner in range(4):
            forward = -half_length if corner % 2 else half_length
            aside = -half_beam if corner > 1 else half_beam
            ahead[corner, node] = forward * cosine - aside * sine
            across = forward * sine + aside * cosine
            off[corner, node] = states[node, 0] + across - curvature[node] * ahead[corner, node] ** 2 / 2
            lever[corner, node] = ahead[corner, node] * (1.0 + curvature[node] * across)
    return off, lever, ahead


def clearance_rows(
    off: np.ndarray, lever: np.ndarray, e: np.ndarray, G: np.ndarray, starboard: np.ndarray, port: np.ndarray,
    spare: float,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return rows and bounds: rows @ change of the rates <= bounds keeps every corner off the banks."""
    # corners and clearance at the banks (4, nodes) [m]; e (nodes, 5); G (nodes, 5, rates)
    rows, bounds, count = np.empty((4 * len(e), G.shape[2])), np.empty(4 * len(e)), 0
    for corner in range(4):
        side, clearance = (-1.0, port) if corner > 1 else (1.0, starboard)
        for node in range(len(e)):
            reach = side * (off[corner, node] + e[node, 0] + lever[corner, node] * e[node, 1])
            bound = clearance[corner, node] - reach
            if not bound > spare:  # Keeps NaN, so that the program refuses it
                bounds[count] = bound
                for column in range(G.shape[2]):
                    rows[count, column] = side * (G[node, 0, column] + lever[corner, node] * G[node, 1, column])
                count += 1
    return rows[:count], bounds[:count]
