"""Samples of a model's coefficients from their covariance: tied ones together, correlated ones together, in bounds."""

import numpy as np
import xarray as xr

from narrows.errors import InputError, check_count
from narrows.model.model import Model

# Over the coefficients, to bring samples back to their bounds.
PASSES = 3
MOST_SAMPLES = 10_000_000


def check_samples(samples: object, seed: object) -> None:
    """Raise where a number of samples or a seed is none."""
    check_count("samples", samples, most=MOST_SAMPLES)
    check_count("seed", seed)


def sampled(model: Model, samples: int, seed: int) -> dict[str, xr.DataArray]:
    """Draw coefficients from their covariance."""
    if model.covariance is None:
        raise InputError("this model has no covariance to draw coefficients from; identify it from tests, or samples=0")
    names = model.terms.names
    mean = np.array([model.coefficients[name] for name in names])
    drawn = mean + _correlated(model.covariance, samples, seed)
    low, high = np.array([term.bound for term in model.terms.terms]).T
    columns = _within(drawn, model.covariance, low, high).T
    coordinate = {"sample": np.arange(samples)}
    return {name: xr.DataArray(c, dims=["sample"], coords=coordinate) for name, c in zip(names, columns, strict=True)}


def _correlated(covariance: np.ndarray, samples: int, seed: int) -> np.ndarray:
    """Draw normal errors, by the correlations: coefficients of a ship differ in size by many powers of ten."""
    size = np.sqrt(np.diag(covariance))
    scale = np.where(size > 0, size, 1.0)
    share, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    normal = np.random.default_rng(seed).standard_normal((samples, len(size)))
    # By the symmetric root, which no rounding of another processor turns into other axes.
    return np.asarray(((normal @ axes) * np.sqrt(np.maximum(share, 0.0))) @ axes.T * size)


def _within(sample: np.ndarray, covariance: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Bring samples back to their bounds; what is correlated with a coefficient that moves, moves along."""
    for _ in range(PASSES):
        for k in np.flatnonzero(np.diag(covariance) > 0):
            shift = np.clip(sample[:, k], low[k], high[k]) - sample[:, k]
            if shift.any():
                sample = sample + shift[:, None] * covariance[k] / covariance[k, k]
    return np.asarray(np.clip(sample, low, high))
