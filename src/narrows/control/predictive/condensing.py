"""A plan's states as an affine function of the rudder's rates alone: what is left of the dynamics in the program."""

import numpy as np


def condensed(
    A: np.ndarray, B: np.ndarray, defects: np.ndarray, start: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return e and G, by which states after each interval are off their nodes: e + G @ change of the rates."""
    # A (intervals, n, n); B (intervals, n); defects (intervals, n); start (n,)
    # Of off_(k+1) = A_k off_k + B_k change_k + defect_k.
    intervals, n = B.shape
    step = np.zeros((intervals, n + 1, n + 1))
    step[:, :n, :n], step[:, :n, n], step[:, n, n] = A, defects, 1.0
    both = np.zeros((intervals + 1, n + 1, intervals + 1))
    both[0, :n, -1], both[0, n, -1] = start, 1.0
    for k in range(intervals):
        np.dot(step[k], both[k], out=both[k + 1])
        both[k + 1, :n, k] = B[k]
    return both[1:, :n, -1], both[1:, :n, :-1]
