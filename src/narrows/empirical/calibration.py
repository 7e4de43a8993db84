"""Calibrate estimates on tested ships: hydrodynamic derivatives (primes) by formulas.

The errors of the formulas on known ships, and the constants here, are computed by ``decisions/known_ships.py``.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.stats import norm, t

from narrows.empirical.formulas import FORMULAS, Hull, depth_factor
from narrows.ship.particulars import Canal, Ship

# Coefficients of known sign: their errors are factors.
SIGNED = ("X_mx", "X_my", "N_jz", "Y_v", "Y_r", "N_v", "N_r", "Y_vvv", "Y_vrr", "N_vvr", "N_rrr")
COEFFICIENTS = tuple(dict.fromkeys(formula.coefficient for formula in FORMULAS))


@dataclass(frozen=True)
class Uncertain:
    value: float
    std: float


def tail_factor(degrees: float) -> float:
    """Return the 97.5 % quantile of Student's t over that of the normal distribution."""
    return float(t.ppf(0.975, degrees) / norm.ppf(0.975))


@dataclass(frozen=True)
class FormulaErrors:
    """Errors of the formulas of one coefficient on the known ships: of logarithms for one of known sign."""

    weights: Sequence[float]  # Weights of the formulas in their mean
    bias: float
    variance: float  # About the bias, over the square of the scale
    degrees: float  # Degrees of freedom of that variance
    scale: float  # 1 for logarithms; the usual size of the coefficient for absolute errors
    by_depth: float  # Variance of the logarithm per T/(h - T), in addition to the depth laws


@dataclass(frozen=True)
class Calibration:
    errors: Mapping[str, FormulaErrors]  # By coefficient
    correlation: np.ndarray  # Correlation matrix of the errors of the signed coefficients

    def estimate(self, name: str, hull: Hull, depth_to_draft: float = math.inf) -> Uncertain:
        """Return a prime of a hull at a depth, with its standard deviation."""
        errors, signed, weights = self.errors[name], name in SIGNED, np.array(self.errors[name].weights)
        values = np.array([float(formula.law(hull)) for formula in FORMULAS if formula.coefficient == name])
        numbers = np.log(np.abs(values)) if signed else values
        mean = float(numbers @ weights)
        size = 1.0 if signed else max(errors.scale, abs(mean))
        variance = errors.variance * size**2 * (1 + 1 / errors.degrees)
        # The formulas' disagreement on this hull is added.
        variance += float(weights @ (numbers - mean) ** 2)
        widened = math.sqrt(variance) * tail_factor(errors.degrees)
        if not signed:
            return Uncertain(mean + errors.bias, widened)
        if math.isfinite(depth_to_draft):
            widened = math.hypot(widened, math.sqrt(errors.by_depth / (depth_to_draft - 1)))
        value = math.copysign(math.exp(mean + errors.bias), values[0]) * depth_factor(name, hull, depth_to_draft)
        return Uncertain(value, widened * abs(value))


def read_calibration() -> Calibration:
    tables = json.loads(Path(__file__).with_name("calibration.json").read_text(encoding="utf-8"))
    errors = {name: FormulaErrors(**row) for name, row in tables["errors"].items()}
    return Calibration(errors, np.array(tables["correlation"]))


# Form of the bank force of the evidence; suction and cushion of a ship without bank tests; the widths and the least
# clearance of the evidence over the beam: by ``decisions/bank_evidence.py``.
FORM = "distance"
BANK_PRIOR = {"Y_bank": Uncertain(0.0986855111, 0.289029546), "N_bank": Uncertain(0.140856833, 0.126160067)}
EVIDENCE_WIDTHS, LEAST_CLEARANCE = (8.0, 12.2), 0.2


def tested_places(ship: Ship, canal: Canal) -> dict[str, tuple[float, float]]:
    """Return the ranges of W/B [1] and of the offset in a canal [m] that the evidence covers."""
    farthest = max(canal.width / 2 - (0.5 + LEAST_CLEARANCE) * ship.beam, 0.0)
    return {"width_to_beam": EVIDENCE_WIDTHS, "abs_y": (0.0, farthest)}
