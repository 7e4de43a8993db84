"""Linear-quadratic gains of many systems at once: the Riccati equation solved by doubling."""

import numpy as np

from narrows.control.settings import LEAST_DECAY


def holding(motion: np.ndarray, push: np.ndarray, gains: np.ndarray) -> np.ndarray:
    """Return which of many systems gains hold (n,); false where a gain is NaN."""
    known = np.isfinite(gains).all(axis=1) & np.isfinite(motion).all(axis=(1, 2))
    poles = np.linalg.eigvals(np.where(known[:, None, None], motion - push[:, :, None] * gains[:, None, :], 0.0))
    return np.asarray(known & (poles.real.max(axis=1) < -LEAST_DECAY * np.abs(poles).max(axis=1)))


def best_gains(motion: np.ndarray, push: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the gains that cost least of many systems with one input each, (n, k); NaN where nothing stabilises it."""
    # The cost is the square of the input and those of the states by their weights; the equation is solved by doubling.
    # Chu, Fan and Lin (2005), A structure-preserving doubling algorithm for continuous-time algebraic Riccati
    # equations, Linear Algebra and its Applications 396.
    gains = np.full(push.shape, np.nan)
    known = np.flatnonzero(np.isfinite(motion).all(axis=(1, 2)) & np.isfinite(push).all(axis=1))
    if not known.size:
        return gains
    with np.errstate(all="ignore"):
        cost = _doubled(motion[known], push[known], weights)
        found = np.einsum("ni,nij->nj", push[known], cost)
    usable = np.isfinite(found).all(axis=1)
    known, found = known[usable], found[usable]
    poles = np.linalg.eigvals(motion[known] - push[known, :, None] * found[:, None, :])
    holds = poles.real.max(axis=1) < -LEAST_DECAY * np.abs(poles).max(axis=1)
    gains[known[holds]] = found[holds]
    return gains


def _doubled(motion: np.ndarray, push: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The stabilising solution; infinite or not a number where there is none."""
    size, effect = motion.shape[-1], push[:, :, None] * push[:, None, :]
    shift = 1.1 * np.maximum(np.abs(motion).sum(axis=2).max(axis=1), 1.0)[:, None, None]
    moved = motion - shift * np.eye(size)
    driven = _solved(moved, effect)
    inverse = _solved(moved.swapaxes(1, 2) + weights @ driven, np.broadcast_to(np.eye(size), moved.shape))
    step = np.eye(size) + 2 * shift * inverse.swapaxes(1, 2)
    reach = 2 * shift * driven @ inverse
    cost = 2 * shift * inverse @ weights @ _solved(moved, np.broadcast_to(np.eye(size), moved.shape))
    for _ in range(40):  # Each round doubles the time that is looked ahead.
        both = _solved(np.eye(size) + reach @ cost, np.concatenate([step, reach], axis=2))
        back, change = step.swapaxes(1, 2), step.swapaxes(1, 2) @ cost @ both[..., :size]
        reach = reach + step @ both[..., size:] @ back
        step, cost = step @ both[..., :size], cost + change
        if not (np.abs(change).max(axis=(1, 2)) > 1e-14 * np.abs(cost).max(axis=(1, 2))).any():
            break
    return np.asarray(cost)


def _solved(matrices: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solutions of many systems; not a number where any is singular to the last bit."""
    try:
        return np.linalg.solve(matrices, right)
    except np.linalg.LinAlgError:
        solutions = np.full(right.shape, np.nan)
        for index, (matrix, side) in enumerate(zip(matrices, right, strict=True)):
            if np.isfinite(matrix).all() and np.linalg.matrix_rank(matrix) == len(matrix):
                solutions[index] = np.linalg.solve(matrix, side)
        return solutions
