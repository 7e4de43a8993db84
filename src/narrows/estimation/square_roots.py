"""Square-root sigma-point filter: functions that Numba compiles.

``rows`` are the transposed root of the covariance of a transformed distribution: one row for each independent error.
"""

import math

import numpy as np


def sigma_points(mean: np.ndarray, root: np.ndarray, distance: float, pairs: int) -> np.ndarray:
    """Return the points, (1 + 2 pairs, n): the mean, then one point on either side of it along each column."""
    # mean (n,); root (n, k), further pairs are at the mean
    # Number by number, here and below: Numba takes seconds to compile an array that is set, added or multiplied whole.
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
    pairs, half, size = len(values) // 2, 0.5 / distance, values.shape[1]
    mean, rows = np.empty(size), np.empty((2 * pairs + len(noise), size))
    for i in range(size):
        total = 0.0
        for k in range(pairs):
            ahead, back = values[1 + k, i], values[1 + pairs + k, i]
            rows[k, i], rows[pairs + k, i] = (ahead - back) * half, ahead + back - 2.0 * values[0, i]
            total += rows[pairs + k, i]
        for k in range(pairs):
            rows[pairs + k, i] = (rows[pairs + k, i] + bend * total) * half
        for k in range(len(noise)):
            rows[2 * pairs + k, i] = noise[k, i]
        mean[i] = values[0, i] + weight * total
    return mean, rows


def triangular_root(rows: np.ndarray) -> np.ndarray:
    """Return the lower triangular root of the sum of outer products of rows (j, n); NaN if there is none."""
    size, finite = rows.shape[1], True
    for i in range(len(rows)):
        for j in range(size):
            finite = finite and abs(rows[i, j]) < np.inf
    if not finite:
        return np.full((size, size), np.nan)
    factor, root = np.linalg.qr(rows)[1], np.zeros((size, size))
    for i in range(len(factor)):
        for j in range(i, size):
            root[j, i] = factor[i, j]
    return root


def cholesky(covariance: np.ndarray) -> np.ndarray:
    """Return the lower triangular root; NaN if there is none."""
    root = np.zeros_like(covariance)
    for i in range(len(root)):
        for j in range(i + 1):
            rest = covariance[i, j]
            for k in range(j):
                rest -= root[i, k] * root[j, k]
            root[i, j] = np.sqrt(rest) if i == j else rest / root[j, j]
    return root


def covariance_of(rows: np.ndarray) -> np.ndarray:
    """Return the sum of outer products of rows (j, n)."""
    found = np.zeros((rows.shape[1], rows.shape[1]))
    for row in rows:
        for i in range(len(row)):
            for j in range(len(row)):
                found[i, j] += row[i] * row[j]
    return found


def root_of(covariance: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Return the lower triangular root of the covariance of some components."""
    part = np.empty((len(chosen), len(chosen)))
    for i in range(len(chosen)):
        for j in range(len(chosen)):
            part[i, j] = covariance[chosen[i], chosen[j]]
    return cholesky(part)


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
    covariance, tests, first = covariance_of(rows), np.empty((3, len(ends))), 0
    kept, whitened, likelihood = np.ones(len(innovation), np.bool_), np.empty(len(innovation)), 0.0
    agree, at_gates = gate(covariance, innovation, ends, gates, sources, gross, tests, kept)
    for i in range(len(innovation)):
        whitened[i] = innovation[i] / np.sqrt(covariance[i, i]) if kept[i] else 0.0  # Gross errors are left to the gate
    drift = drift_statistics(sums, memories, places, whitened, most)
    for sensor in range(len(ends)):
        tests[2, sensor] = drift[first]
        for i in range(first, ends[sensor]):
            tests[2, sensor] = max(tests[2, sensor], drift[i])
        first = ends[sensor]
    factor = cholesky(covariance)
    for i in range(len(factor)):
        likelihood -= np.log(factor[i, i])
    if not agree:
        likelihood -= 0.5 * at_gates
    used = np.flatnonzero(kept | agree)
    stacked = np.empty((len(rows) + 1, len(used)))
    for i in range(len(used)):
        for k in range(len(rows)):
            stacked[k, i] = rows[k, used[i]]
        stacked[len(rows), i] = innovation[used[i]]
    white = whiten(stacked, root_of(covariance, used))
    for i in range(len(used)):
        likelihood -= 0.5 * white[len(rows), i] ** 2
    moved, after = joseph(mean, root, white)
    return moved, triangular_root(after), tests, agree, likelihood


def gate(
    covariance: np.ndarray, innovation: np.ndarray, ends: np.ndarray, gates: np.ndarray, sources: np.ndarray,
    gross: float, tests: np.ndarray, kept: np.ndarray,
) -> tuple[bool, float]:  # fmt: skip
    """Write the tests of each sensor, and which components pass; return whether the others are used, and their gates.

    Sensors of several sources agree against the prediction: the model is wrong, and they are used.
    """
    first, modest, at_gates, lowest, highest = 0, True, 0.0, np.inf, -np.inf
    for sensor in range(len(ends)):
        squared = normalised_square(covariance, innovation, first, ends[sensor])
        passes = squared <= gates[sensor]
        tests[0, sensor], tests[1, sensor] = squared, not passes
        for i in range(first, ends[sensor]):
            kept[i] = passes
        if not passes:
            modest, at_gates = modest and squared <= gross, at_gates + gates[sensor]
            lowest, highest = min(lowest, sources[sensor]), max(highest, sources[sensor])
        first = ends[sensor]
    return modest and highest > lowest, at_gates


def joseph(mean: np.ndarray, root: np.ndarray, white: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean and the rows after an update, of whitened rows and, last, whitened innovations.

    Joseph's form is a sum of squares: it stays a covariance for any gain.
    """
    rows, used, size = len(white) - 1, white.shape[1], len(root)
    moved, after, gain = mean.copy(), np.zeros((rows, size)), np.zeros((used, size))
    for k in range(root.shape[1]):
        for j in range(size):
            after[k, j] = root[j, k]
            for i in range(used):
                gain[i, j] += white[k, i] * root[j, k]
    for i in range(used):
        for j in range(size):
            moved[j] += white[rows, i] * gain[i, j]
        for k in range(rows):
            for j in range(size):
                after[k, j] -= white[k, i] * gain[i, j]
    return moved, after


def normalised_square(covariance: np.ndarray, innovation: np.ndarray, first: int, end: int) -> float:
    """Return the normalised innovation squared of the components from ``first`` to before ``end``."""
    chosen, total = np.arange(first, end), 0.0
    values = np.empty((1, len(chosen)))
    for i in range(len(chosen)):
        values[0, i] = innovation[chosen[i]]
    white = whiten(values, root_of(covariance, chosen))
    for i in range(len(chosen)):
        total += white[0, i] ** 2
    return total


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
