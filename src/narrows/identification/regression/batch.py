"""Thousands of small constrained fits at once: the same active-set conditions as ``solve``, on stacked arrays."""

import numpy as np

from narrows.identification.regression.solve import RANK_TOLERANCE, solve

ROUNDS = 25
"""Changes of the active set before a problem is handed to the exact solver one by one."""
RIDGE = 0.1 * RANK_TOLERANCE**2
"""Added to the unit diagonal: keeps directions without data at rest, a tenth of what still counts as data."""
CHUNK = 4096


def solve_many(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Minimise 1/2 z'Hz - g'z over lower <= z <= upper for every problem of a stack, (n, p).

    A primal-dual active set: guess which parameters sit at a bound, solve the rest directly, put at their bound
    those that left it, free those whose multiplier has the wrong sign, until nothing changes.

    Parameters
    ----------
    h : array (n, p, p) or (p, p)
        Scaled near a unit diagonal; one matrix may serve all.
    g : array (n, p)
        Right-hand sides.
    lower, upper : array (p,)
        Bounds, the same for all.

    References
    ----------
    Hintermueller, Ito, Kunisch (2002), The primal-dual active set strategy as a semismooth Newton method.
    """
    h = np.broadcast_to(h, (len(g), *h.shape[-2:]))
    parts = [slice(i, i + CHUNK) for i in range(0, len(g), CHUNK)]
    return np.concatenate([_chunk(h[part], g[part], lower, upper) for part in parts]) if parts else np.empty_like(g)


def _chunk(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    held = np.zeros(g.shape, np.int8)  # -1 at the lower bound, +1 at the upper
    z = np.empty_like(g)
    left = np.arange(len(g))
    for _ in range(ROUNDS):
        best = _with_held(h[left], g[left], held[left], lower, upper)
        z[left] = best
        push = g[left] - np.einsum("nij,nj->ni", h[left], best)
        after = _held(best, push, held[left], lower, upper)
        changed = (after != held[left]).any(axis=1)
        held[left] = after
        left = left[changed]
        if not left.size:
            return z
    for i in left:
        z[i] = solve(h[i], g[i], lower, upper).z
    return z


def _held(z: np.ndarray, push: np.ndarray, held: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Which parameters are beyond a bound, or at one and pushed beyond by the data."""
    below = np.where(held == -1, push < 0, z < lower)
    above = np.where(held == 1, push > 0, z > upper)
    return above.astype(np.int8) - (below & ~above).astype(np.int8)


def _with_held(h: np.ndarray, g: np.ndarray, held: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Solve with some parameters held at their bounds."""
    free = held == 0
    fixed = np.where(held < 0, lower, np.where(held > 0, upper, 0.0))
    right = np.where(free, g - np.einsum("nij,nj->ni", h, fixed), 0.0)
    matrix = h * (free[:, :, None] & free[:, None, :])
    diagonal = np.arange(h.shape[-1])
    matrix[:, diagonal, diagonal] = np.where(free, matrix[:, diagonal, diagonal] + RIDGE, 1.0)
    return fixed + np.linalg.solve(matrix, right[..., None])[..., 0]
