"""Square-root sigma-point filter: functions that Numba compiles."""

import math

import numpy as np


def sigma_points(mean: np.ndarray, root: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Return the points, (1 + 2 k, n): the mean, then one point on either side of it along each column."""
    # mean (n,); root (n, k); distance (k,)
    step = (root * distance).T
    return np.concatenate((mean.reshape(1, -1), mean + step, mean - step))


def transform(
    values: np.ndarray, distance: np.ndarray, weight: float, bend: float, considered: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mean (m,), slopes (k, m) and nonlinear parts (k - considered, m) of values at sigma points."""
    # values (1 + 2 k, m)
    ahead, back, half = values[1 : 1 + len(distance)], values[1 + len(distance) :], (0.5 / distance).reshape(-1, 1)
    bends = (ahead + back - 2.0 * values[0])[considered:]
    total = bends.sum(axis=0)
    return values[0] + weight * total, (ahead - back) * half, (bends + bend * total) * half[considered:]


def innovation_covariance(slopes: np.ndarray, bends: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """Return the covariance of the innovation, (m, m)."""
    return np.asarray(np.diag(sigma * sigma) + slopes.T @ slopes + bends.T @ bends)


def update(
    mean: np.ndarray, root: np.ndarray, slopes: np.ndarray, bends: np.ndarray, innovation: np.ndarray,
    covariance: np.ndarray, sigma: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return the mean after a measurement, and rows with the sum of outer products of its covariance."""
    # Joseph's form is a sum of squares: it stays a covariance for any gain.
    gain = np.full((len(sigma), len(mean)), np.nan)
    if np.isfinite(covariance).all():  # Otherwise the estimate begins anew
        gain = np.ascontiguousarray(np.linalg.solve(covariance, (root @ slopes).T))
    return mean + innovation @ gain, np.concatenate((root.T - slopes @ gain, gain * sigma.reshape(-1, 1), bends @ gain))


def drift_statistics(
    sums: np.ndarray, common: np.ndarray, memories: np.ndarray, places: np.ndarray, whitened: np.ndarray,
    shared: np.ndarray, most: float,
) -> np.ndarray:  # fmt: skip
    """Add whitened innovations to fading sums; return the distance of the sums from zero [standard deviations]."""
    # sums (2, memories, size), the sums and their variances; common (memories, considered, size); whitened (numbers,)
    # Errors of considered coefficients, shared (considered, numbers), are common to all readings: they add up like a
    # bias and do not indicate a drift.
    found = np.zeros(len(places))
    for i in range(len(places)):
        place, explained = places[i], 0.0
        for j in range(len(shared)):
            explained += shared[j, i] * shared[j, i]
        for m in range(len(memories)):
            left = 1.0 - 1.0 / memories[m]
            sums[0, m, place] = left * sums[0, m, place] + min(max(whitened[i], -most), most)
            sums[1, m, place] = left * left * sums[1, m, place] + 1.0 - min(explained, 1.0)
            variance = sums[1, m, place]
            for j in range(len(shared)):
                common[m, j, place] = left * common[m, j, place] + shared[j, i]
                variance += common[m, j, place] * common[m, j, place]
            found[i] = max(found[i], abs(sums[0, m, place]) / math.sqrt(variance))
    return found
