"""Square roots of covariances: a covariance that is kept as its root stays symmetric and positive.

A root L of a covariance P is any matrix with L L^T = P.

References
----------
van der Merwe and Wan (2001), The square-root unscented Kalman filter for state and parameter estimation.
"""

from functools import lru_cache

import numpy as np
from scipy.linalg import lapack


@lru_cache(maxsize=64)
def _upper(size: int) -> np.ndarray:
    return np.triu(np.ones((size, size)))


def triangular_root(rows: np.ndarray) -> np.ndarray:
    """Return the lower triangular root of the sum of outer products of rows, (n, n), by QR."""
    # rows (k, n)
    count, size = rows.shape
    if count < size:
        rows = np.vstack([rows, np.zeros((size - count, size))])
    factored = lapack.dgeqrf(rows)[0]
    return np.asarray((factored[:size] * _upper(size)).T)


def downdated_root(root: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Return the lower triangular root of L L^T - c c^T; where that is no covariance, L itself, which is too wide."""
    # root (n, n); column (n,)
    inside, failed = lapack.dtrtrs(root, column, lower=1)
    left = 1.0 - float(inside @ inside)
    if failed or not left > 0.0:
        return root
    return np.asarray(root @ np.linalg.cholesky(np.eye(len(root)) - np.outer(inside, inside)))
