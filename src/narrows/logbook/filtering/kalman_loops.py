"""Kalman filter and smoother of a record, linear about a reference path: loops for a compiler."""

import math

import numpy as np

# A state is x, y, psi, u, v, r off the reference path, then first-order Gauss-Markov processes: disturbances and sensor
# errors. Step k has a kind, which chooses how much of a process is kept and how much is new.


def filter_readings(
    mean: np.ndarray, covariance: np.ndarray, slopes: np.ndarray, misses: np.ndarray, drives: np.ndarray,
    kind: np.ndarray, kept: np.ndarray, fresh: np.ndarray, walk: np.ndarray, first: np.ndarray, rows: np.ndarray,
    residual: np.ndarray, variance: np.ndarray, innovation: np.ndarray, spread: np.ndarray, gains: np.ndarray,
    means: np.ndarray, covariances: np.ndarray,
) -> None:  # fmt: skip
    """Write innovations, their variances and gains; predicted means and covariances too where there is room."""
    # mean (d,); covariance (d, d); slopes (n, 6, 6 + inputs); misses (n, 6); drives (m,) input of each process or -1;
    # kind (n,); kept (kinds, m); fresh (kinds, m, m); walk (kinds, 6); first (n + 1,); rows (N, d); residual, variance,
    # innovation, spread (N,); gains (N, d); means (n, d) or (0, d); covariances likewise
    # Scalar updates one after the other: Anderson and Moore (1979), Optimal Filtering, section 6.4.
    size, count = len(mean), len(drives)
    z, cov, moved, after = mean.copy(), covariance.copy(), np.empty((6, size)), np.empty(6)
    for k in range(len(kind)):
        if len(means):
            means[k] = z
            covariances[k] = cov
        for i in range(first[k], first[k + 1]):
            update(z, cov, rows[i], residual[i], variance[i], innovation, spread, gains, i)
        here, a = slopes[k], kind[k]
        for i in range(6):
            value = misses[k, i]
            for j in range(6):
                value += here[i, j] * z[j]
            for q in range(size):
                total = 0.0
                for j in range(6):
                    total += here[i, j] * cov[j, q]
                moved[i, q] = total
            for p in range(count):
                if drives[p] >= 0:
                    slope = here[i, 6 + drives[p]]
                    value += slope * z[6 + p]
                    for q in range(size):
                        moved[i, q] += slope * cov[6 + p, q]
            after[i] = value
        for i in range(6):
            z[i] = after[i]
            for j in range(i + 1):
                total = 0.0
                for q in range(6):
                    total += moved[i, q] * here[j, q]
                for p in range(count):
                    if drives[p] >= 0:
                        total += moved[i, 6 + p] * here[j, 6 + drives[p]]
                cov[i, j] = total
                cov[j, i] = total
            cov[i, i] += walk[a, i]
        for p in range(count):
            z[6 + p] *= kept[a, p]
            for i in range(6):
                cov[i, 6 + p] = moved[i, 6 + p] * kept[a, p]
                cov[6 + p, i] = cov[i, 6 + p]
            for q in range(count):
                cov[6 + p, 6 + q] = cov[6 + p, 6 + q] * kept[a, p] * kept[a, q] + fresh[a, p, q]


def update(
    z: np.ndarray, cov: np.ndarray, row: np.ndarray, residual: float, variance: float, innovation: np.ndarray,
    spread: np.ndarray, gains: np.ndarray, i: int,
) -> None:  # fmt: skip
    """Take a reading into mean and covariance."""
    size = len(z)
    e, s = residual, variance
    gain = gains[i]
    for p in range(size):
        total = 0.0
        for q in range(size):
            total += row[q] * cov[q, p]
        gain[p] = total
    for p in range(size):
        e -= row[p] * z[p]
        s += row[p] * gain[p]
    for p in range(size):
        z[p] += gain[p] * e / s
        for q in range(size):
            cov[p, q] -= gain[p] * gain[q] / s
    for p in range(size):
        gain[p] /= s
    innovation[i], spread[i] = e, s


def smooth(
    slopes: np.ndarray, drives: np.ndarray, kind: np.ndarray, kept: np.ndarray, first: np.ndarray, rows: np.ndarray,
    innovation: np.ndarray, spread: np.ndarray, gains: np.ndarray, means: np.ndarray, covariances: np.ndarray,
) -> None:  # fmt: skip
    """Write smoothed means in the place of the predicted ones."""
    # The modified Bryson-Frazier smoother, which inverts nothing: Bierman (1973), Automatica 9.
    size, count = means.shape[1], len(drives)
    adjoint, before = np.zeros(size), np.zeros(size)
    for k in range(len(kind) - 1, -1, -1):
        here, a = slopes[k], kind[k]
        for j in range(6):
            before[j] = 0.0
            for i in range(6):
                before[j] += here[i, j] * adjoint[i]
        for p in range(count):
            before[6 + p] = kept[a, p] * adjoint[6 + p]
            if drives[p] >= 0:
                for i in range(6):
                    before[6 + p] += here[i, 6 + drives[p]] * adjoint[i]
        for p in range(size):
            adjoint[p] = before[p]
        for i in range(first[k + 1] - 1, first[k] - 1, -1):
            weight = innovation[i] / spread[i]
            for p in range(size):
                weight -= gains[i, p] * adjoint[p]
            for p in range(size):
                adjoint[p] += rows[i, p] * weight
        for p in range(size):
            for q in range(size):
                means[k, p] += covariances[k, p, q] * adjoint[q]
        if not math.isfinite(means[k, 0]):
            return
