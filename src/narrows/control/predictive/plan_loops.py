"""Loops over the intervals of a plan, number by number: Numba takes ten times as long to compile arrays."""

import math

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
        for row in range(size):
            G[k, row, k] = B[k, row]
            for place in range(size if k else 0):
                e[k, row] += A[k, row, place] * e[k - 1, place]
                for rate in range(k):
                    G[k, row, rate] += A[k, row, place] * G[k - 1, place, rate]
    return e, G


def corner_offsets(
    states: np.ndarray, half_length: float, half_beam: float, curvature: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the corners' offsets, their derivatives by the heading, and their distance ahead, (4, nodes) each."""
    shape = (4, len(states))  # The first two corners are to starboard
    off, by_heading, ahead = np.empty(shape), np.empty(shape), np.empty(shape)
    for node in range(len(states)):
        sine, cosine = math.sin(states[node, 1]), math.cos(states[node, 1])
        for corner in range(4):
            forward = half_length if corner % 2 == 0 else -half_length
            aside = half_beam if corner < 2 else -half_beam
            across, far = forward * sine + aside * cosine, forward * cosine - aside * sine
            # In a bend the line curves away ahead and astern by half its curvature times the distance squared.
            off[corner, node] = states[node, 0] + across - curvature[node] * far * far / 2
            by_heading[corner, node] = far * (1.0 + curvature[node] * across)
            ahead[corner, node] = far
    return off, by_heading, ahead


def clearance_rows(
    off: np.ndarray, lever: np.ndarray, e: np.ndarray, G: np.ndarray, starboard: np.ndarray, port: np.ndarray,
    spare: float,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return rows and bounds: rows @ change of the rates <= bounds keeps every corner off the banks."""
    # corners and clearance at the banks (4, nodes) [m]; e (nodes, 5); G (nodes, 5, rates)
    count, rows, bounds = 0, np.empty((off.size, G.shape[2])), np.empty(off.size)
    for corner in range(4):
        side, wall = (1.0, starboard) if corner < 2 else (-1.0, port)
        for node in range(len(e)):
            reach = side * (off[corner, node] + e[node, 0] + lever[corner, node] * e[node, 1])
            bound = wall[corner, node] - reach
            if not bound > spare:  # Keeps NaN, so that the program refuses it
                for rate in range(G.shape[2]):
                    rows[count, rate] = side * (G[node, 0, rate] + lever[corner, node] * G[node, 1, rate])
                bounds[count] = bound
                count += 1
    return rows[:count], bounds[:count]
