"""The errors of runs: covariance of the second level, what repeats say of it, and the test of fit against it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from narrows.identification.motions import DistinctMotions
from narrows.identification.regression.normal_equations import ONE, NormalEquations
from narrows.identification.uncertainty.run_errors import RunErrors
from narrows.identification.uncertainty.second_level import SecondLevel, roots

# Mean over root mean square of a motion's force beyond which its gain and its zero are one.
CONSTANT = 0.98
# Error of a run that repeats may show.
LARGEST = 0.99
# Of the largest eigenvalue, columns scaled to one: under it a direction of the second level holds rounding.
EXACT = 1e-9


@dataclass(frozen=True)
class LackOfFit:
    """How the scatter about a fit compares with what the error model allows, for one force."""

    chi2: float  # Sum of squared residuals of the generalised fit, each over its assumed variance [1]
    freedom: float  # Its degrees of freedom [1]
    # Probability of as much, were the terms right and the errors as assumed; NaN where nothing is left over [1]
    p: float

    @property
    def scatter(self) -> float:
        """The variance that the data show over the assumed one."""
        return self.chi2 / max(self.freedom, 1.0)


def covariance(level: SecondLevel, fitted: np.ndarray, errors: RunErrors, factor: np.ndarray) -> np.ndarray:
    """Return the covariance of each block, (blocks, q, q); ones on the diagonal of empty rows."""
    # fitted (blocks, q); factor (forces,)
    # Birge (1932), The calculation of errors by the method of least squares: the factor.
    zero = level.one * level.level[:, None]
    between = errors.gain**2 * _outer(fitted) + errors.zero**2 * _outer(zero)
    within = (level.noise + errors.form**2 * level.form)[:, None] * level.live
    v = between / level.repeats[:, None, None] + within[:, :, None] * np.eye(level.y.shape[1])
    v *= factor[level.force][:, None, None]
    return np.asarray(v + np.where(level.live, 0.0, 1.0)[:, :, None] * np.eye(level.y.shape[1]))


def _outer(rows: np.ndarray) -> np.ndarray:
    return np.asarray(rows[:, :, None] * rows[:, None, :])


def whitened(v: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the columns (blocks, q, p) with the errors of unit variance and independent."""
    # v (blocks, q, q); columns (blocks, q, p)
    return np.asarray(np.linalg.solve(np.linalg.cholesky(v), columns))


def pseudo_inverse(h: np.ndarray, empty: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return the inverse of symmetric matrices (..., p, p) over what has data, and which parameters that determines."""
    # h (..., p, p)
    size = np.sqrt(np.maximum(np.diagonal(h, axis1=-2, axis2=-1), 0.0))
    full = size**2 > empty
    size = np.where(full, size, 1.0)
    outer = size[..., :, None] * size[..., None, :]
    h = h * (full[..., :, None] & full[..., None, :])
    values, vectors = np.linalg.eigh(h / outer)
    kept = values > EXACT * np.maximum(values[..., -1:], 1e-300)
    inverse = np.where(kept, 1 / np.where(kept, values, 1.0), 0.0)
    known = (vectors**2 * kept[..., None, :]).sum(axis=-1) > 1 - 1e-5
    product = (vectors * inverse[..., None, :]) @ np.swapaxes(vectors, -1, -2)
    return product / outer, known & full


def lack_of_fit(level: SecondLevel, v: np.ndarray) -> tuple[LackOfFit, ...]:
    """Test the fit of the terms against the scatter that the error model allows, force by force."""
    # v (blocks, q, q)
    from scipy.special import chdtrc

    white = whitened(v, np.concatenate([level.d, level.y[..., None]], axis=2))
    d, y = white[..., :-1], white[..., -1]
    flat = d.reshape(-1, d.shape[2])
    inverse, _ = pseudo_inverse(flat.T @ flat)
    left = y - d @ (inverse @ (flat.T @ y.ravel()))
    used = ((d @ inverse) * d).sum(axis=(1, 2))
    tested = []
    for force in range(level.forces):
        inside = level.force == force
        chi2, freedom = float((left[inside] ** 2).sum()), float(level.live[inside].sum() - used[inside].sum())
        known = freedom > 0.5 and bool(level.noise_known[force])
        tested.append(LackOfFit(chi2, max(freedom, 0.0), float(chdtrc(freedom, chi2)) if known else float("nan")))
    return tuple(tested)


@dataclass(frozen=True)
class Repeatability:
    """What repeats of motions say of one force."""

    # A motion counts by its force over that of the table: one without force tells nothing of a gain.

    gain: float  # Standard deviation of the gain from run to run [1]
    zero: float  # Standard deviation of the zero, over the force's root mean square [1]
    gain_freedom: float  # Repeats beyond the first run of each motion that tell of each [1]
    zero_freedom: float  # Repeats beyond the first run of each motion that tell of each [1]


def repeatability(equations: NormalEquations, motions: DistinctMotions, force: str, names: list[str]) -> Repeatability:
    """Compare the runs of each motion: a gain and a zero of each against the fit to all of them."""
    columns = [*names, ONE, force]
    tests = dict(zip(equations.names, equations.pick(equations.by_test(), columns), strict=True))
    total = equations.pick(equations.total, columns)
    square = max(float(total[-1, -1] / total[-2, -2]), 1e-300)
    spreads, weights = np.zeros(2), np.zeros(2)
    for members in motions.members:
        if len(members) > 1:
            runs, more = np.stack([tests[name] for name in members]), len(members) - 1
            seen, told = _gains_and_zeros(runs, square)
            spreads += told * seen.var(axis=0, ddof=1) * more
            weights += told * more
    spread = np.sqrt(spreads / np.where(weights > 0, weights, 1.0))
    return Repeatability(float(spread[0]), float(spread[1]), float(weights[0]), float(weights[1]))


def _gains_and_zeros(runs: np.ndarray, square: float) -> tuple[np.ndarray, np.ndarray]:
    """Of each run of one motion, (runs, 2), zeros over the force's root mean square; and how much they tell of each."""
    whole = runs.sum(axis=0)
    _, inverse, _ = roots(whole[None, :-1, :-1])
    fit = inverse[0].T @ inverse[0] @ whole[:-1, -1]
    squares = np.einsum("k,rkl,l->r", fit, runs[:, :-1, :-1], fit)
    share = min(float(squares.sum() / whole[-2, -2] / square), 1.0)
    if not share > 0 or abs(fit @ whole[:-1, -2]) > CONSTANT * np.sqrt(squares.sum() * whole[-2, -2]):
        zeros = runs[:, -2, -1] / runs[:, -2, -2] / np.sqrt(square)
        mean = zeros.mean()
        gains = zeros / mean if share > 0 and mean else np.ones(len(runs))
        return np.stack([gains, zeros], axis=1), np.array([share, 1 - share])
    seen = []
    for run in runs:
        cross = fit @ run[:-1, -2]
        products = np.array([[fit @ run[:-1, :-1] @ fit, cross], [cross, run[-2, -2]]])
        seen.append(np.linalg.lstsq(products, np.array([fit @ run[:-1, -1], run[-2, -1]]), rcond=1e-12)[0])
    return np.array(seen) / [1.0, np.sqrt(square)], np.array([share, 1.0])


def corrected(errors: RunErrors, repeats: Mapping[str, Repeatability]) -> RunErrors:
    """Weigh the prior of gain and zero against what repeats show; the form error, which none shows, stays."""
    seen = [one for force, one in repeats.items() if force != "X"] or list(repeats.values())
    if errors.none:
        return errors

    def mixed(prior: float, shown: list[float], freedom: list[float]) -> float:
        weight = np.array(freedom) / (errors.repeats_worth + np.array(freedom))
        variance = np.mean((1 - weight) * prior**2 + weight * np.square(shown))
        return float(min(np.sqrt(variance), LARGEST))

    gain = mixed(errors.gain, [one.gain for one in seen], [one.gain_freedom for one in seen])
    zero = mixed(errors.zero, [one.zero for one in seen], [one.zero_freedom for one in seen])
    return replace(errors, gain=gain, zero=zero)
