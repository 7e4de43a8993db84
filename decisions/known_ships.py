"""Ships with known primes, and the errors of the formulas on them.

python decisions/known_ships.py [--write] writes ``empirical/calibration.json``.

Errors are those of logarithms for coefficients of known sign, and absolute ones for the others. The mean of the
formulas weighs each by its mean squared error. Variances of few ships are shrunk to that of the whole group, as Smyth
(2004) moderates variances of few replicates. Few ships give the tails of Student's t, and the standard deviation is
widened so that 95 % intervals of a normal distribution cover 95 %.

If a model includes the added mass in surge in the turning force, or the mass in everything, these are removed. If tests
had the rudder on, its share amidships is removed by its own printed slopes, a flow straightening of 0.4 and a lever of
0.8 L, usual for single-screw ships.
"""

import json
import math
import sys
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from narrows.empirical import formulas
from narrows.empirical.formulas import (
    COEFFICIENTS,
    FORMULAS,
    SIGNED,
    SURGE_SHARE,
    Calibration,
    Formula,
    FormulaErrors,
    Hull,
    depth_factor,
)

PRIOR_SHIPS = 3.0  # Weight of the priors of no bias and of the group variance [ships]
SHALLOWEST_AS_DEEP = 2.0  # h/T above which tests count as deep, after correction by the depth laws
LEAST_ERROR = 0.1  # Least error of a formula: limits its weight where few ships agree by chance

STRAIGHTENING, LEVER = 0.4, 0.8


@dataclass(frozen=True)
class KnownShip:
    name: str
    source: str
    hull: Hull
    primes: Mapping[float, Mapping[str, float]]  # Primes by h/T; infinite in deep water
    # Relative standard errors of the primes, if the tests gave them
    errors: Mapping[float, Mapping[str, float]] = field(default_factory=dict)

    def relative_error(self, name: str, ratio: float) -> float:
        return self.errors.get(ratio, {}).get(name, 0.0)


def _without_rudder(primes: Mapping[str, float], force: float, moment: float) -> dict[str, float]:
    """Remove the rudder amidships, by its force and moment per radian."""
    bare = dict(primes)
    for name, slope in (("Y", force), ("N", moment)):
        bare[f"{name}_v"] += STRAIGHTENING * slope
        bare[f"{name}_r"] -= STRAIGHTENING * LEVER * slope
    return bare


def _identified(masses: tuple[float, float, float], test: Mapping[str, Any]) -> dict[str, float]:
    """Primes of the package's fit with the terms ``crossflow``, which include mass, lever and inertia of the ship."""
    (mass, lever, inertia), drift, turning = masses, test["drift"], test["turning"]
    return {
        "X_my": test["sway"] - mass, "N_jz": test["yaw"] - inertia, "Y_v": -drift[0], "N_v": -drift[1],
        "Y_r": mass + SURGE_SHARE * mass - turning[0], "N_r": mass * lever - turning[1],
    }  # fmt: skip


def _ship(row: Mapping[str, Any]) -> KnownShip:
    """Read a section of the table: primes as printed, in deep water and of the package's fits at h/T."""
    hull, deep = row["hull"], row.get("deep", {})
    length, draft = hull["length"], hull["draft"]
    if row.get("over_length_squared"):
        deep = {name: value * length / draft for name, value in deep.items()}
    primes = {math.inf: deep} if deep else {}
    if "rudder" in row:
        primes[math.inf] = _without_rudder(primes[math.inf], *(slope * length / draft for slope in row["rudder"]))
    for test in row.get("shallow", ()):
        primes[test["ratio"]] = _identified(row["masses"], test)
    errors = {test["ratio"]: test["errors"] for test in row.get("shallow", ())}
    ratios = Hull(length / hull["beam"], hull["beam"] / draft, hull["block_coefficient"], hull.get("x_g", 0.0))
    return KnownShip(row["name"], row["source"], ratios, primes, errors)


ESSO_190 = Hull(304.8 / 47.17, 47.17 / 18.46, 0.83)


def _esso(ratio: float) -> dict[str, float]:
    """The tanker at h/T, whose forces are printed over the mass, with terms of T/(h - T)."""
    keel = 0.0 if math.isinf(ratio) else 1 / (ratio - 1)
    drift = -0.85 * (keel - 0.8) if keel >= 0.8 else 0.0
    surge = SURGE_SHARE * (1 + keel)
    primes = {
        "X_mx": surge, "X_my": 1.020 + 0.387 * keel,
        "Y_v": -1.205 + drift, "Y_r": 0.248 + 0.182 * keel + surge,
        "N_v": -0.451 - 0.241 * keel, "N_r": -0.231 - 0.047 * keel,
    }  # fmt: skip
    # Slopes of the rudder in the slipstream at the design speed, c^2/u^2 = 1.10.
    bare = _without_rudder(primes, 0.208 * 1.10, -0.098 * 1.10)
    return {name: value * ESSO_190.mass for name, value in bare.items()}


TANKER = KnownShip(
    "tanker of 190 000 dwt", "van Berlekom and Goddard (1972)", ESSO_190,
    {ratio: _esso(ratio) for ratio in (math.inf, 2.0, 1.5, 1.2)},
)  # fmt: skip

KVLCC2, S175, MARINER, ESSO_OSAKA, KCS = (
    _ship(row)
    for row in tomllib.loads(Path(__file__).with_name("known_ships.toml").read_text(encoding="utf-8"))["ships"]
)
KNOWN_SHIPS = (KVLCC2, S175, MARINER, TANKER, ESSO_OSAKA, KCS)


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
class KnownErrors:
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


def calibrated(ships: tuple[KnownShip, ...] = KNOWN_SHIPS) -> Calibration:
    known, rows = KnownErrors(ships), {}
    for name in COEFFICIENTS:
        errors, signed = known.errors[name], name in SIGNED
        degrees = PRIOR_SHIPS + len(errors.errors)
        variance = (errors.squares + PRIOR_SHIPS * known.group_variances[signed]) / degrees
        by_depth = known.depth_variances.get(name, 0.0)
        rows[name] = FormulaErrors(errors.weights.tolist(), errors.bias, variance, degrees, errors.scale, by_depth)
    return Calibration(rows, known.correlation)


def text() -> str:
    found = calibrated()
    rows = {name: row._asdict() for name, row in found.errors.items()}
    lines = [f"{json.dumps(name)}: {json.dumps(row)}" for name, row in rows.items()]
    matrix = ",\n".join(json.dumps(row) for row in found.correlation.tolist())
    return '{"errors": {\n' + ",\n".join(lines) + '\n}, "correlation": [\n' + matrix + "\n]}\n"


if __name__ == "__main__":
    if "--write" in sys.argv:
        Path(formulas.__file__).with_name("calibration.json").write_text(text(), encoding="utf-8")
    else:
        print(text())
