"""Square-root sigma-point filter: functions that Numba compiles.

``rows`` are the transposed root of the covariance of a transformed distribution: one row for each independent error.
"""

import math

import numpy as np


def sigma_points(mean: np.ndarray, root: np.ndarray, distance: float, pairs: int) -> np.ndarray:
    """Return the points, (1 + 2 pairs, n): the mean, then one point on either side of it along each column."""
    # mean (n,); root (n, k), further pairs are at the mean
    # Number by number, here and below: Numba takes seconds to compile a slice that is set and a sum along an axis.
    points = np.empty((1 + 2 * pairs, len(mean)))
    for i in range(len(mean)):
        points[:, i] = mean[i]
        for k in range(root.shape[1]):
            points[1 + k, i] += distance * root[i, k]
            points[1 + pairs + k, i] -= distance * root[i, k]
    return points


def transform(
    values: np.ndarray, noise: np.ndarray, distance: float, weight: float, bend: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return mean (m,) and rows (2 k + j, m) of values (1 + 2 k, m) at sigma points with added noise (j, m).

    The rows are the slopes, the nonlinear parts and the noise.
    """
    pairs, half = len(values) // 2, 0.5 / distance
    ahead, back = values[1 : 1 + pairs], values[1 + pairs :]
    bends = ahead + back - 2.0 * values[0]
    total = np.zeros(values.shape[1])
    for bent in bends:
        total += bent
    rows = np.concatenate(((ahead - back) * half, (bends + bend * total) * half, noise))
    return values[0] + weight * total, rows


def triangular_root(rows: np.ndarray) -> np.ndarray:
    """Return the lower triangular root of the sum of outer products of rows (j, n); NaN if there is none."""
    root = np.full((rows.shape[1], rows.shape[1]), np.nan)
    if np.isfinite(rows).all():
        factor = np.linalg.qr(rows)[1]
        root[:] = 0.0
        for i in range(len(factor)):
            for j in range(i, len(root)):
                root[j, i] = factor[i, j]
    return root


def cholesky(covariance: np.ndarray) -> np.ndarray:
    """Return the lower triangular root; NaN if there is none."""
    root = np.zeros_like(covariance)
    for i in range(len(root)):
        for j in range(i + 1):
            rest = covariance[i, j] - (root[i, :j] * root[j, :j]).sum()
            root[i, j] = np.sqrt(rest) if i == j else rest / root[j, j]
    return root


def whiten(values: np.ndarray, root: np.ndarray) -> np.ndarray:
    """Return values (n, m) over a triangular root (m, m): their components in independent standard deviations."""
    white = np.empty_like(values)
    for i in range(len(root)):
        for k in range(len(values)):
            explained = 0.0
            for j in range(i):
                explained += white[k, j] * root[i, j]
            white[k, i] = (values[k, i] - explained) / root[i, i]
    return white


def update(
    mean: np.ndarray, root: np.ndarray, rows: np.ndarray, innovation: np.ndarray, ends: np.ndarray, gates: np.ndarray,
    sources: np.ndarray, places: np.ndarray, sums: np.ndarray, memories: np.ndarray, most: float, gross: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, bool, float]:  # fmt: skip
    """Return mean and root after the readings that pass their gates, with tests of all readings.

    These are of each sensor the normalised innovation squared, whether it exceeds the gate, and the drift statistic,
    (3, sensors); whether readings over their gates are used; and the log-likelihood, in which refused readings count as
    at their gate.
    """
    # rows (j, m): slopes along the columns of the root, nonlinear parts, white noise; end of the components, gate and
    # source of each sensor (sensors,); sums, memories, most: see ``drift_statistics``.
    size, first, covariance = root.shape[1], 0, rows.T @ rows
    factor, spread = cholesky(covariance), np.sqrt(np.diag(covariance))
    whitened, kept, tests = innovation / spread, np.ones(len(innovation), np.bool_), np.empty((3, len(ends)))
    for sensor in range(len(ends)):
        part = slice(first, ends[sensor])
        squared = (whiten(innovation[part].reshape(1, -1), cholesky(covariance[part, part])) ** 2).sum()
        first, kept[part], tests[0, sensor] = ends[sensor], squared <= gates[sensor], squared
    whitened[~kept] = 0.0  # Gross errors are left to the gate
    drift = drift_statistics(sums, memories, places, whitened, most)
    first = 0
    for sensor in range(len(ends)):
        tests[1, sensor], tests[2, sensor] = not kept[first], drift[first : ends[sensor]].max()
        first = ends[sensor]
    odd, likelihood = tests[1] > 0.0, -np.log(np.diag(factor)).sum()
    # Sensors of several sources agree against the prediction: the model is wrong, and they are used.
    agree = odd.any() and sources[odd].max() > sources[odd].min() and (tests[0][odd] <= gross).all()
    stacked = np.concatenate((rows, innovation.reshape(1, -1)))
    if odd.any() and not agree:
        stacked, likelihood = stacked[:, kept], likelihood - 0.5 * gates[odd].sum()
        factor = cholesky(stacked[:-1].T @ stacked[:-1])
    # Joseph's form is a sum of squares: it stays a covariance for any gain.
    white = whiten(stacked, factor)
    gain = white[:size].T @ root.T
    after = -(white[:-1] @ gain)
    for i in range(size):
        for j in range(len(root)):
            after[i, j] += root[j, i]
    likelihood -= 0.5 * (white[-1] ** 2).sum()
    return mean + white[-1] @ gain, triangular_root(after), tests, agree, likelihood


def drift_statistics(
    sums: np.ndarray, memories: np.ndarray, places: np.ndarray, whitened: np.ndarray, most: float
) -> np.ndarray:
    """Add whitened innovations to fading sums; return the distance of the sums from zero [standard deviations]."""
    # sums (2, memories, size): the sums and their variances; whitened (numbers,)
    found = np.zeros(len(places))
    for i in range(len(places)):
        for m in range(len(memories)):
            left, place = 1.0 - 1.0 / memories[m], places[i]
            sums[0, m, place] = left * sums[0, m, place] + min(max(whitened[i], -most), most)
            sums[1, m, place] = left * left * sums[1, m, place] + 1.0
            found[i] = max(found[i], abs(sums[0, m, place]) / math.sqrt(sums[1, m, place]))
    return found
