"""Thousands of small constrained fits at once: the same active-set conditions as ``solve``, on stacked arrays."""

import numpy as np

from narrows.identification.regression.active_set import RIDGE as RIDGE
from narrows.identification.regression.active_set import active_set
from narrows.identification.regression.solve import solve

CHUNK = 4096


def solve_many(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Minimise 1/2 z'Hz - g'z over lower <= z <= upper for every problem of a stack, (n, p)."""
    # h (n, p, p); g (n, p); lower, upper (p,)
    # By the active set of ``solve``; the few that it leaves open are solved one by one.
    h = np.broadcast_to(h, (len(g), *h.shape[-2:]))
    parts = [slice(i, i + CHUNK) for i in range(0, len(g), CHUNK)]
    return np.concatenate([_chunk(h[part], g[part], lower, upper) for part in parts]) if parts else np.empty_like(g)


def _chunk(h: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    z, left = active_set(h, g, lower, upper)
    for i in left:
        z[i] = solve(h[i], g[i], lower, upper).z
    return z
