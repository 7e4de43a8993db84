"""Calibrate estimates on tested ships: hydrodynamic derivatives (primes) by formulas.

Errors are those of logarithms for coefficients of known sign, and absolute ones for the others. The mean of the
formulas weighs each by its mean squared error. Variances of few ships are shrunk to that of the whole group, as Smyth
(2004) moderates variances of few replicates. Few ships give the tails of Student's t, and the standard deviation is
widened so that 95 % intervals of a normal distribution cover 95 %.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import norm, t

from narrows.empirical.formulas import FORMULAS, KNOWN_SHIPS, Formula, Hull, KnownShip, depth_factor
from narrows.ship.particulars import Canal, Ship

# Coefficients of known sign: their errors are factors.
SIGNED = ("X_mx", "X_my", "N_jz", "Y_v", "Y_r", "N_v", "N_r", "Y_vvv", "Y_vrr", "N_vvr", "N_rrr")
COEFFICIENTS = tuple(dict.fromkeys(formula.coefficient for formula in FORMULAS))

PRIOR_SHIPS = 3.0  # Weight of the priors of no bias and of the group variance [ships]
SHALLOWEST_AS_DEEP = 2.0  # h/T above which tests count as deep, after correction by the depth laws
LEAST_ERROR = 0.1  # Least error of a formula: limits its weight where few ships agree by chance


@dataclass(frozen=True)
class Uncertain:
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


def tail_factor(degrees: float) -> float:
    """Return the 97.5 % quantile of Student's t over that of the normal distribution."""
    return float(t.ppf(0.975, degrees) / norm.ppf(0.975))


@dataclass(frozen=True)
class Calibration:
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
        typical = float(np.median(known)) if known else 0.0  # Few large ones must not affect all
        return {
            name: (sum(group) + PRIOR_SHIPS * typical) / (len(group) + PRIOR_SHIPS) for name, group in squares.items()
        }

    @cached_property
    def correlation(self) -> np.ndarray:
        """Correlation matrix of the errors of the signed coefficients, shrunk towards zero."""
        table = np.zeros((len(self.ships), len(SIGNED)))
        for column, name in enumerate(SIGNED):
            errors = self.errors[name]
            rows = [place for place, ship in enumerate(self.ships) if _deep_prime(ship, name) is not None]
            table[rows, column] = (errors.combined - errors.bias) / math.sqrt(self.group_variances[True])
        products = table.T @ table + PRIOR_SHIPS * np.eye(len(SIGNED))
        size = np.sqrt(np.diag(products))
        return np.asarray(products / np.outer(size, size))

    def estimate(self, name: str, hull: Hull, depth_to_draft: float = math.inf) -> Uncertain:
        """Return a prime of a hull at a depth, with its standard deviation."""
        errors, signed = self.errors[name], name in SIGNED
        values = np.array([float(formula.law(hull)) for formula in errors.formulas])
        numbers = np.log(np.abs(values)) if signed else values
        mean = float(numbers @ errors.weights)
        count = len(errors.errors)
        degrees = PRIOR_SHIPS + count
        size = 1.0 if signed else max(errors.scale, abs(mean))
        moderated = (errors.squares + PRIOR_SHIPS * self.group_variances[signed]) / degrees
        variance = moderated * size**2 * (1 + 1 / degrees)
        # The formulas' disagreement on this hull is added.
        variance += float(errors.weights @ (numbers - mean) ** 2)
        widened = math.sqrt(variance) * tail_factor(degrees)
        if not signed:
            return Uncertain(mean + errors.bias, widened)
        if math.isfinite(depth_to_draft):
            widened = math.hypot(widened, math.sqrt(self.depth_variances[name] / (depth_to_draft - 1)))
        value = math.copysign(math.exp(mean + errors.bias), values[0]) * depth_factor(name, hull, depth_to_draft)
        return Uncertain(value, widened * abs(value))

    def _errors(self, name: str) -> _Errors:
        formulas = tuple(formula for formula in FORMULAS if formula.coefficient == name)
        known = [(ship.hull, value) for ship in self.ships if (value := _deep_prime(ship, name)) is not None]
        truths = np.array([value for _, value in known])
        laws = np.array([[float(formula.law(hull)) for formula in formulas] for hull, _ in known])
        laws = laws.reshape(len(known), len(formulas))
        if name in SIGNED:
            return _Errors(formulas, 1.0, np.log(truths[:, None] / laws))
        scale = float(np.sqrt(np.mean(np.concatenate([truths**2, laws.ravel() ** 2])))) if known else 0.0
        return _Errors(formulas, scale or 1.0, truths[:, None] - laws)


def _deep_prime(ship: KnownShip, name: str) -> float | None:
    """Return the prime corrected to deep water, from the deepest tests; None if these are too shallow or lack it."""
    ratio = max(ship.primes)
    if ratio < SHALLOWEST_AS_DEEP or name not in ship.primes[ratio]:
        return None
    return ship.primes[ratio][name] / depth_factor(name, ship.hull, ratio)


# Form of the bank force of the evidence; suction and cushion of a ship without bank tests; the widths and the least
# clearance of the evidence over the beam: by ``decisions/bank_evidence.py``.
FORM = "distance"
BANK_PRIOR = {"Y_bank": Uncertain(0.0992668324, 0.288899080), "N_bank": Uncertain(0.140437350, 0.126274138)}
EVIDENCE_WIDTHS, LEAST_CLEARANCE = (8.0, 12.2), 0.2


def tested_places(ship: Ship, canal: Canal) -> dict[str, tuple[float, float]]:
    """Return the ranges of W/B [1] and of the offset in a canal [m] that the evidence covers."""
    farthest = max(canal.width / 2 - (0.5 + LEAST_CLEARANCE) * ship.beam, 0.0)
    return {"width_to_beam": EVIDENCE_WIDTHS, "abs_y": (0.0, farthest)}
