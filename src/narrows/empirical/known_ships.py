"""Ships with known derivatives, for calibrating the formulas: primes over 1/2 rho L d, about midship.

Derivatives printed over 1/2 rho L^2 are multiplied by L/T. If a model includes the added mass in surge in the turning
force, or the mass in everything, these are removed. If tests had the rudder on, its share amidships is removed by its
own printed slopes, a flow straightening of 0.4 and a lever of 0.8 L, usual for single-screw ships.
"""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from narrows.empirical.formulas import SURGE_SHARE, Hull

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
        """Relative standard error of a prime [1]."""
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
    _ship(row) for row in tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))["ships"]
)
KNOWN_SHIPS = (KVLCC2, S175, MARINER, TANKER, ESSO_OSAKA, KCS)
