"""Square-root sigma-point filter: loops that Numba compiles."""

import math

import numpy as np


def sigma_points(mean: np.ndarray, root: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Return the points, (1 + 2 k, n): the mean, then one point on either side of it along each column."""
    # mean (n,); root (n, k); distance (k,)
    size, pairs = root.shape
    points = np.empty((1 + 2 * pairs, size))
    for i in range(size):
        points[0, i] = mean[i]
        for j in range(pairs):
            step = root[i, j] * distance[j]
            points[1 + j, i] = mean[i] + step
            points[1 + pairs + j, i] = mean[i] - step
    return points


def transform(
    values: np.ndarray, distance: np.ndarray, weight: float, bend: float, considered: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mean (m,), slopes (k, m) and nonlinear parts (k - considered, m) of values at sigma points."""
    # values (1 + 2 k, m)
    pairs, size = len(distance), values.shape[1]
    mean, slopes, bends = values[0].copy(), np.empty((pairs, size)), np.empty((pairs - considered, size))
    total = np.zeros(size)
    for j in range(pairs):
        for i in range(size):
            slopes[j, i] = (values[1 + j, i] - values[1 + pairs + j, i]) * (0.5 / distance[j])
        if j >= considered:
            for i in range(size):
                bends[j - considered, i] = values[1 + j, i] + values[1 + pairs + j, i] - 2.0 * values[0, i]
                total[i] += bends[j - considered, i]
    for i in range(size):
        mean[i] += weight * total[i]
    for j in range(considered, pairs):
        for i in range(size):
            bends[j - considered, i] = (bends[j - considered, i] + bend * total[i]) * (0.5 / distance[j])
    return mean, slopes, bends


def innovation_covariance(slopes: np.ndarray, bends: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """Return the covariance of the innovation, (m, m)."""
    size = len(sigma)
    covariance = np.empty((size, size))
    for i in range(size):
        for j in range(i + 1):
            total = sigma[i] * sigma[i] if i == j else 0.0
            for k in range(len(slopes)):
                total += slopes[k, i] * slopes[k, j]
            for k in range(len(bends)):
                total += bends[k, i] * bends[k, j]
            covariance[i, j] = covariance[j, i] = total
    return covariance


def update(
    mean: np.ndarray, root: np.ndarray, slopes: np.ndarray, bends: np.ndarray, innovation: np.ndarray,
    covariance: np.ndarray, sigma: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return the mean after a measurement, and rows with the sum of outer products of its covariance."""
    # Joseph's form is a sum of squares: it stays a covariance for any gain.
    size, pairs, numbers = len(mean), root.shape[1], len(sigma)
    gain, column, lower, mean = np.empty((numbers, size)), np.empty(numbers), cholesky(covariance), mean.copy()
    for i in range(size):
        for a in range(numbers):
            column[a] = 0.0
            for k in range(pairs):
                column[a] += root[i, k] * slopes[k, a]
        solve(lower, column)
        for a in range(numbers):
            gain[a, i] = column[a]
            mean[i] += column[a] * innovation[a]
    rows = np.zeros((pairs + numbers + len(bends), size))
    for k in range(pairs):
        for i in range(size):
            rows[k, i] = root[i, k]
        for a in range(numbers):
            for i in range(size):
                rows[k, i] -= gain[a, i] * slopes[k, a]
    for a in range(numbers):
        for i in range(size):
            rows[pairs + a, i] = gain[a, i] * sigma[a]
        for k in range(len(bends)):
            for i in range(size):
                rows[pairs + numbers + k, i] += bends[k, a] * gain[a, i]
    return mean, rows


def cholesky(covariance: np.ndarray) -> np.ndarray:
    """Return the lower triangular root of a covariance."""
    size = len(covariance)
    lower = np.zeros((size, size))
    for i in range(size):
        for j in range(i + 1):
            total = covariance[i, j]
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            lower[i, j] = math.sqrt(total) if i == j else total / lower[j, j]
    return lower


def solve(lower: np.ndarray, column: np.ndarray) -> None:
    """Solve L L^T x = column in its place."""
    size = len(column)
    for i in range(size):
        for k in range(i):
            column[i] -= lower[i, k] * column[k]
        column[i] /= lower[i, i]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            column[i] -= lower[k, i] * column[k]
        column[i] /= lower[i, i]


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
