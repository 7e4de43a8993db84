"""Which parameters sit at their bounds, for stacks of small problems at once: a primal-dual active set."""

import numpy as np

# Smallest singular value, over the largest, that counts; sums of products keep about eight digits of it.
RANK_TOLERANCE = 1e-6
# Changes of the active set before a problem is given up.
ROUNDS = 25
# Added to the unit diagonal: keeps directions without data at rest, a tenth of what still counts as data.
RIDGE = 0.1 * RANK_TOLERANCE**2


def active_set(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Minimise 1/2 z'Hz - g'z over lower <= z <= upper for a stack: z (n, p), and the problems left open (k,)."""
    # h (n, p, p); g (n, p); lower, upper (p,)
    # Guess which parameters sit at a bound, solve the rest directly, put at their bound those that left it, free those
    # whose multiplier has the wrong sign, until nothing changes. A problem in which something still does is open.
    # Hintermueller, Ito, Kunisch (2002), The primal-dual active set strategy as a semismooth Newton method.
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
            break
    return z, left


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
