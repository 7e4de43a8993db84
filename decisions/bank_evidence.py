"""The bank's coefficients of tested ships, their distribution over ships, and estimates of ships left out.

python decisions/bank_evidence.py prints the constants of ``empirical/formulas.py``.

The bank has a random-effects model over ships. Its rows are coefficients of ``distance``, the form of Ch'ng (1993) and
Vantorre et al. (2003): along KVLCC2's wall its coefficient is the same at three clearances, where that of the paper's
delta changes fourfold.
"""

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from known_ships import KNOWN_SHIPS, KnownShip, calibrated
from scipy.optimize import minimize
from scipy.stats import norm

from narrows.empirical.formulas import Uncertain, tail_factor


@dataclass(frozen=True)
class LeftOut:
    """A known prime of a ship, and its estimate by the other ships."""

    ship: str
    depth_to_draft: float
    coefficient: str
    known: float
    known_error: float  # Standard error of the known prime
    estimate: Uncertain

    @property
    def held(self) -> bool:
        """Return whether the 95 % interval contains the prime, with the error of the tests."""
        std = math.hypot(self.estimate.std, self.known_error)
        return abs(self.known - self.estimate.value) <= float(norm.ppf(0.975)) * std


def left_out(ships: Sequence[KnownShip] = KNOWN_SHIPS) -> list[LeftOut]:
    """Estimate each known ship from the others."""
    rows = []
    for ship in ships:
        others = calibrated(tuple(other for other in ships if other is not ship))
        for ratio, primes in ship.primes.items():
            for name, known in primes.items():
                error = ship.relative_error(name, ratio) * abs(known)
                rows.append(LeftOut(ship.name, ratio, name, known, error, others.estimate(name, ship.hull, ratio)))
    return rows


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
    degrees: int  # Degrees of freedom

    @property
    def spread(self) -> Uncertain:
        """The coefficient of a further ship, widened so that 95 % intervals of a normal distribution cover 95 %."""
        std = math.hypot(self.mean_error, self.between, self.within)
        return Uncertain(self.mean, std * tail_factor(self.degrees))


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
        log_determinants = np.linalg.slogdet(matrix)[1] + math.log(precision.sum())
        return float(log_determinants + residuals @ precision @ residuals)

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


if __name__ == "__main__":
    for name, effects in bank_effects().items():
        print(f"{name}: {effects.spread}")
    widths = [row.width_to_beam for row in BANK_EVIDENCE]
    print(f"W/B {min(widths)} to {max(widths)}, clearance from {min(row.clearance_to_beam for row in BANK_EVIDENCE)} B")
