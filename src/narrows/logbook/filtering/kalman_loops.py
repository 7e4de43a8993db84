"""Kalman filter and smoother of a record, linear about a reference path, and Nomoto's model: loops for a compiler."""

import numpy as np

# A state is x, y, psi, u, v, r off the reference path, then first-order Gauss-Markov processes: disturbances and sensor
# errors. Most slopes are 0.


def filter_readings(
    covariance: np.ndarray, slopes: np.ndarray, misses: np.ndarray, kept: np.ndarray, fresh: np.ndarray,
    walk: np.ndarray, first: np.ndarray, rows: np.ndarray, residual: np.ndarray, variance: np.ndarray,
    innovation: np.ndarray, spread: np.ndarray, gains: np.ndarray, means: np.ndarray, covariances: np.ndarray,
) -> None:  # fmt: skip
    """Write innovations, their variances and gains; predicted means and covariances too where there is room."""
    # covariance (d, d); slopes (n, 6, d); misses, walk (n, 6); kept (m,); fresh (m, m); first (n + 1,); rows (N, d);
    # residual, variance, innovation, spread (N,); gains (N, d); means (n, d) or (0, d); covariances likewise
    # Scalar updates one after the other: Anderson and Moore (1979), Optimal Filtering, section 6.4.
    # Number by number, here and below: Numba takes seconds to compile an array that is set, added or multiplied whole.
    size = len(covariance)
    z, cov, moved = np.zeros(size), covariance.copy(), np.empty((6, size))
    for k in range(len(slopes)):
        for p in range(size if len(means) else 0):
            means[k, p] = z[p]
            for q in range(size):
                covariances[k, p, q] = cov[p, q]
        for i in range(first[k], first[k + 1]):
            update(z, cov, rows[i], residual[i], variance[i], innovation, spread, gains, i)
        predict(z, cov, moved, slopes[k], misses[k], kept, fresh, walk[k])


def update(
    z: np.ndarray, cov: np.ndarray, row: np.ndarray, residual: float, variance: float, innovation: np.ndarray,
    spread: np.ndarray, gains: np.ndarray, i: int,
) -> None:  # fmt: skip
    e, s, gain = residual, variance, gains[i]
    for p in range(len(z)):
        gain[p] = 0.0
    for q in range(len(z)):
        if row[q] != 0.0:
            e -= row[q] * z[q]
            for p in range(len(z)):
                gain[p] += row[q] * cov[q, p]
    for p in range(len(z)):
        s += row[p] * gain[p]
    for p in range(len(z)):
        share = gain[p] / s
        z[p] += share * e
        for q in range(len(z)):
            cov[p, q] -= share * gain[q]
    for p in range(len(z)):
        gain[p] /= s
    innovation[i], spread[i] = e, s


def predict(
    z: np.ndarray, cov: np.ndarray, moved: np.ndarray, here: np.ndarray, miss: np.ndarray, kept: np.ndarray,
    fresh: np.ndarray, walk: np.ndarray,
) -> None:  # fmt: skip
    size, after = len(z), miss.copy()
    for i in range(6):
        for q in range(size):
            moved[i, q] = 0.0
        for j in range(size):
            if here[i, j] != 0.0:
                after[i] += here[i, j] * z[j]
                for q in range(size):
                    moved[i, q] += here[i, j] * cov[j, q]
    for i in range(6):
        z[i] = after[i]
        for j in range(i + 1):
            total = 0.0
            for q in range(size):
                total += moved[i, q] * here[j, q]
            cov[i, j] = cov[j, i] = total
        cov[i, i] += walk[i]
    for p in range(6, size):
        z[p] *= kept[p - 6]
        for i in range(6):
            cov[i, p] = cov[p, i] = moved[i, p] * kept[p - 6]
        for q in range(6, size):
            cov[p, q] = cov[p, q] * kept[p - 6] * kept[q - 6] + fresh[p - 6, q - 6]


def smooth(
    slopes: np.ndarray, kept: np.ndarray, first: np.ndarray, rows: np.ndarray, innovation: np.ndarray,
    spread: np.ndarray, gains: np.ndarray, means: np.ndarray, covariances: np.ndarray,
) -> None:  # fmt: skip
    """Write smoothed means in the place of the predicted ones."""
    # The modified Bryson-Frazier smoother, which inverts nothing: Bierman (1973), Automatica 9.
    size = means.shape[1]
    adjoint, before = np.zeros(size), np.zeros(size)
    for k in range(len(slopes) - 1, -1, -1):
        for j in range(size):
            before[j] = kept[j - 6] * adjoint[j] if j >= 6 else 0.0
        for i in range(6):
            for j in range(size):
                before[j] += adjoint[i] * slopes[k, i, j]
        for j in range(size):
            adjoint[j] = before[j]
        for i in range(first[k + 1] - 1, first[k] - 1, -1):
            left = innovation[i] / spread[i]
            for j in range(size):
                left -= gains[i, j] * adjoint[j]
            for j in range(size):
                adjoint[j] += rows[i, j] * left
        for q in range(size):  # The matrix is symmetric
            for p in range(size):
                means[k, p] += covariances[k, q, p] * adjoint[q]


def nomoto_headings(numbers: np.ndarray, psi: float, r: float, step: float, rudder: np.ndarray) -> np.ndarray:
    """Return headings (n,) [rad] of ``rdot = a rudder + b + c r + d |r| r + e r^3`` (Euler's method)."""
    a, b, c, d, e = numbers
    path = np.full(len(rudder), 1e3)
    for k in range(len(rudder)):
        path[k] = psi
        psi += step * r
        r += step * (a * rudder[k] + b + (c + d * abs(r) + e * r * r) * r)
        if not abs(r) < 1.0:  # [rad/s]: it runs away
            break
    return path
