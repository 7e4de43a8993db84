"""Bank coefficients of a ship without bank tests: published evidence in a table, and a random-effects model over ships.

All rows are coefficients of ``distance``, the form of Ch'ng (1993) and Vantorre et al. (2003): along KVLCC2's wall its
coefficient is the same at three clearances, where that of the paper's delta changes fourfold.
"""

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from scipy.optimize import minimize
from scipy.stats import norm, t

from narrows.empirical.calibration import LeftOut, Spread
from narrows.ship.particulars import Canal, Ship

FORM = "distance"


@dataclass(frozen=True)
class BankEvidence:
    ship: str
    source: str
    depth_to_draft: float | None  # None: not printed
    width_to_beam: float
    clearance_to_beam: float  # Smallest clearance between hull and bank over the beam [1]
    suction: float  # b_bank
    suction_error: float  # Standard error
    cushion: float | None  # c_bank; None: not printed
    cushion_error: float = 0.0


# The paper of the DTC prints 1.07 and 0.13 of delta; its row holds these times delta/y_B at the largest offset of its
# motions (0.907 m). It prints no errors: theirs are the medians of the KCS tests at three depths, at one speed.
_ROWS = csv.reader(Path(__file__).with_name("bank_evidence.csv").read_text(encoding="utf-8").splitlines()[1:])
BANK_EVIDENCE = tuple(
    BankEvidence(ship, source, *(float(cell) if cell else None for cell in cells))  # type: ignore[arg-type]
    for ship, source, *cells in _ROWS
)


@dataclass(frozen=True)
class RandomEffects:
    """Mean of a coefficient over ships, and its standard deviations."""

    mean: float
    mean_error: float
    between: float  # Between ships
    within: float  # Within a ship: depth, distance, bank and propeller, which the form does not describe
    degrees: int

    @property
    def spread(self) -> Spread:
        """The coefficient of a further ship, widened so that 95 % intervals of a normal distribution cover 95 %."""
        std = math.hypot(self.mean_error, self.between, self.within)
        return Spread(self.mean, std * float(t.ppf(0.975, self.degrees) / norm.ppf(0.975)))


def random_effects(values: Sequence[float], errors: Sequence[float], ships: Sequence[str]) -> RandomEffects:
    """Fit a mean, ships and rows within ships by restricted maximum likelihood (Patterson and Thompson 1971)."""
    y, known, groups = np.array(values), np.array(errors), np.array(ships)
    same = np.equal.outer(groups, groups)

    def covariance(log_stds: np.ndarray) -> np.ndarray:
        between, within = np.exp(2 * log_stds)
        return np.asarray(np.diag(known**2 + within) + between * same)

    def mean_of(precision: np.ndarray) -> tuple[float, float]:
        return float(precision.sum(axis=0) @ y / precision.sum()), float(precision.sum() ** -0.5)

    def deviance(log_stds: np.ndarray) -> float:
        matrix = covariance(log_stds)
        precision = np.linalg.inv(matrix)
        residuals = y - mean_of(precision)[0]
        found = np.linalg.slogdet(matrix)[1] + math.log(precision.sum()) + residuals @ precision @ residuals
        return float(found)

    start = math.log(float(y.std()) + 1e-6) - np.array([1.0, 1.0])
    log_stds = minimize(deviance, start, method="Nelder-Mead", bounds=[(-8.0, 3.0)] * 2).x
    mean, error = mean_of(np.linalg.inv(covariance(log_stds)))
    between, within = np.exp(log_stds)
    return RandomEffects(mean, error, float(between), float(within), len(y) - 1)


def bank_effects(rows: Sequence[BankEvidence] = BANK_EVIDENCE) -> dict[str, RandomEffects]:
    """Return the random effects of suction and cushion, ``Y_bank`` and ``N_bank``."""
    columns = {
        "Y_bank": [(row.suction, row.suction_error, row.ship) for row in rows],
        "N_bank": [(row.cushion, row.cushion_error, row.ship) for row in rows if row.cushion is not None],
    }
    return {name: random_effects(*zip(*column, strict=True)) for name, column in columns.items()}


@cache
def bank_prior() -> dict[str, Spread]:
    """Return suction and cushion of a ship without bank tests, ``Y_bank`` and ``N_bank``."""
    return {name: effects.spread for name, effects in bank_effects().items()}


def left_out_banks() -> list[LeftOut]:
    """Predict each row of the evidence from the other ships."""
    found = []
    for row in BANK_EVIDENCE:
        others = bank_effects([other for other in BANK_EVIDENCE if other.ship != row.ship])
        known = {"Y_bank": (row.suction, row.suction_error), "N_bank": (row.cushion, row.cushion_error)}
        found += [
            LeftOut(row.ship, row.depth_to_draft or math.nan, name, value, error, others[name].spread)
            for name, (value, error) in known.items()
            if value is not None
        ]
    return found


def tested_places(ship: Ship, canal: Canal) -> dict[str, tuple[float, float]]:
    """Return the ranges of the evidence, of W/B [1] and of the offset in a canal [m]."""
    widths = [row.width_to_beam for row in BANK_EVIDENCE]
    nearest = min(row.clearance_to_beam for row in BANK_EVIDENCE)
    farthest = max(canal.width / 2 - (0.5 + nearest) * ship.beam, 0.0)
    return {"width_to_beam": (min(widths), max(widths)), "abs_y": (0.0, farthest)}
