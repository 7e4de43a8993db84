"""Gates: which measurements are too far from what was expected to be believed."""

from functools import lru_cache

import numpy as np


@lru_cache(maxsize=64)
def gate(probability: float, size: int) -> float:
    """Return the normalised innovation squared that a sound measurement exceeds with a probability [1]."""
    from scipy.stats import chi2

    return float(chi2.isf(probability, size)) if probability > 0.0 else float("inf")


def normalised_square(innovation: np.ndarray, covariance: np.ndarray) -> float:
    """Return the innovation squared over its covariance [1]: chi-squared where the filter is consistent."""
    # innovation (m,); covariance (m, m)
    if len(innovation) == 1:
        return float(innovation[0] * innovation[0] / covariance[0, 0])
    if len(innovation) == 2:
        ((a, b), (_, d)), (e, f) = covariance.tolist(), innovation.tolist()
        return float((d * e * e - 2.0 * b * e * f + a * f * f) / (a * d - b * b))
    return float(innovation @ np.linalg.solve(covariance, innovation))
