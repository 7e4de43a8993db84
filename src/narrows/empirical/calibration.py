"""Estimates of primes from formulas, with their errors on known ships: weighted mean, bias, moderated variance.

Errors are those of logarithms for coefficients of known sign, and absolute ones for the others. The mean of the
formulas weighs each by its mean squared error. Variances of few ships are shrunk to that of the whole group, as Smyth
(2004) moderates variances of few replicates. Few ships give the tails of Student's t, and the standard deviation is
widened so that 95 % intervals of a normal distribution cover 95 %.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import norm, t

from narrows.empirical.formulas import FORMULAS, Formula, Hull, depth_factor
from narrows.empirical.known_ships import KNOWN_SHIPS, KnownShip

# Coefficients of known sign: their errors are factors.
SIGNED = ("X_mx", "X_my", "N_jz", "Y_v", "Y_r", "N_v", "N_r", "Y_vvv", "Y_vrr", "N_vvr", "N_rrr")
COEFFICIENTS = tuple(dict.fromkeys(formula.coefficient for formula in FORMULAS))

PRIOR_SHIPS = 3.0  # Weight of the priors of no bias and of the group variance [ships]
SHALLOWEST_AS_DEEP = 2.0  # h/T above which tests count as deep, after correction by the depth laws
LEAST_ERROR = 0.1  # Least error of a formula: limits its weight where few ships agree by chance


@dataclass(frozen=True)
class Spread:
    """A prime of a ship, and its standard deviation."""

    value: float
    std: float


@dataclass(frozen=True)
class _Errors:
    """Errors of the formulas of one coefficient on the known ships."""

    formulas: tuple[Formula, ...]
    scale: float  # 1 for logarithms; the usual size of the coefficient for absolute errors
    errors: np.ndarray  # (ships, formulas)

    @cached_property
    def weights(self) -> np.ndarray:
        squares = (self.errors**2).mean(axis=0) if len(self.errors) else np.zeros(len(self.formulas))
        weights = 1 / (squares + (LEAST_ERROR * self.scale) ** 2)
        return np.asarray(weights / weights.sum())

    @property
    def combined(self) -> np.ndarray:
        return np.asarray(self.errors @ self.weights)

    @property
    def bias(self) -> float:
        return float(self.combined.sum() / (len(self.errors) + PRIOR_SHIPS))

    @property
    def squares(self) -> float:
        """Sum of squares about the bias, relative to the scale."""
        return float((((self.combined - self.bias) / self.scale) ** 2).sum())


@dataclass(frozen=True)
class Calibration:
    """Errors of the formulas on known ships."""

    ships: tuple[KnownShip, ...] = KNOWN_SHIPS

    @cached_property
    def errors(self) -> dict[str, _Errors]:
        return {name: self._errors(name) for name in COEFFICIENTS}

    @cached_property
    def group_variances(self) -> dict[bool, float]:
        """Variance of the scaled errors, of the signed coefficients and of the others."""
        found = {}
        for signed in (True, False):
            group = [errors for name, errors in self.errors.items() if (name in SIGNED) == signed]
            counted = sum(len(errors.errors) for errors in group)
            found[signed] = sum(errors.squares for errors in group) / max(counted, 1)
        return found

    @cached_property
    def depth_variances(self) -> dict[str, float]:
        """Variance of the logarithm of each signed coefficient per T/(h - T), in addition to the depth laws."""
        squares: dict[str, list[float]] = {name: [] for name in SIGNED}
        for ship in self.ships:
            deepest = max(ship.primes)
            for ratio, primes in ship.primes.items():
                for name in set(primes) & set(SIGNED) if ratio < deepest else ():
                    noise = ship.relative_error(name, ratio) ** 2 + ship.relative_error(name, deepest) ** 2
                    law = depth_factor(name, ship.hull, ratio) / depth_factor(name, ship.hull, deepest)
                    square = math.log(primes[name] / ship.primes[deepest][name] / law) ** 2 - noise
                    squares[name].append(max(square, 0.0) * (ratio - 1))
        known = [square for group in squares.values() for square in group]
        typical = float(np.median(known)) if known else 0.0  # Few large ones must not affect all coefficients
        return {
            name: (sum(group) + PRIOR_SHIPS * typical) / (len(group) + PRIOR_SHIPS) for name, group in squares.items()
        }

    @cached_property
    def correlation(self) -> np.ndarray:
        """Correlation of the errors of the signed coefficients, shrunk towards zero."""
        table = np.zeros((len(self.ships), len(SIGNED)))
        for column, name in enumerate(SIGNED):
            errors = self.errors[name]
            rows = [place for place, ship in enumerate(self.ships) if _deep(ship, name) is not None]
            table[rows, column] = (errors.combined - errors.bias) / math.sqrt(self.group_variances[True])
        products = table.T @ table + PRIOR_SHIPS * np.eye(len(SIGNED))
        size = np.sqrt(np.diag(products))
        return np.asarray(products / np.outer(size, size))

    def estimate(self, name: str, hull: Hull, depth_to_draft: float = math.inf) -> Spread:
        """Return a prime of a hull at a depth, with its standard deviation."""
        errors, signed = self.errors[name], name in SIGNED
        values = np.array([float(formula.law(hull)) for formula in errors.formulas])
        numbers = np.log(np.abs(values)) if signed else values
        mean = float(numbers @ errors.weights)
        count = len(errors.errors)
        degrees = PRIOR_SHIPS + count
        size = max(errors.scale, abs(mean)) if not signed else 1.0
        moderated = (errors.squares + PRIOR_SHIPS * self.group_variances[signed]) / degrees
        variance = moderated * size**2 * (1 + 1 / (count + PRIOR_SHIPS))
        # The formulas' disagreement on this hull is added.
        variance += float(errors.weights @ (numbers - mean) ** 2)
        widened = math.sqrt(variance) * float(t.ppf(0.975, degrees) / norm.ppf(0.975))
        if not signed:
            return Spread(mean + errors.bias, widened)
        if math.isfinite(depth_to_draft):
            widened = math.hypot(widened, math.sqrt(self.depth_variances[name] / (depth_to_draft - 1)))
        value = math.copysign(math.exp(mean + errors.bias), values[0]) * depth_factor(name, hull, depth_to_draft)
        return Spread(value, widened * abs(value))

    def _errors(self, name: str) -> _Errors:
        formulas = tuple(formula for formula in FORMULAS if formula.coefficient == name)
        known = [(ship.hull, value) for ship in self.ships if (value := _deep(ship, name)) is not None]
        truths = np.array([value for _, value in known])
        laws = np.array([[float(formula.law(hull)) for formula in formulas] for hull, _ in known])
        laws = laws.reshape(len(known), len(formulas))
        if name in SIGNED:
            return _Errors(formulas, 1.0, np.log(truths[:, None] / laws))
        scale = float(np.sqrt(np.mean(np.concatenate([truths**2, laws.ravel() ** 2])))) if known else 0.0
        return _Errors(formulas, scale or 1.0, truths[:, None] - laws)


def _deep(ship: KnownShip, name: str) -> float | None:
    """The prime in deep water, or that of the deepest tests that count as deep."""
    ratio = max(ship.primes)
    if ratio < SHALLOWEST_AS_DEEP or name not in ship.primes[ratio]:
        return None
    return ship.primes[ratio][name] / depth_factor(name, ship.hull, ratio)


@dataclass(frozen=True)
class LeftOut:
    """A known prime of a ship, and its estimate by the other ships."""

    ship: str
    depth_to_draft: float
    coefficient: str
    known: float
    known_error: float  # Standard error of the known prime
    estimate: Spread

    @property
    def held(self) -> bool:
        """Return whether the 95 % interval contains the prime, with the error of the tests."""
        std = math.hypot(self.estimate.std, self.known_error)
        return abs(self.known - self.estimate.value) <= float(norm.ppf(0.975)) * std


def left_out(ships: Sequence[KnownShip] = KNOWN_SHIPS) -> list[LeftOut]:
    """Estimate each known ship from the others."""
    rows = []
    for ship in ships:
        others = Calibration(tuple(other for other in ships if other is not ship))
        for ratio, primes in ship.primes.items():
            for name, known in primes.items():
                error = ship.relative_error(name, ratio) * abs(known)
                rows.append(LeftOut(ship.name, ratio, name, known, error, others.estimate(name, ship.hull, ratio)))
    return rows
