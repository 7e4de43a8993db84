"""Ships with known derivatives, for calibrating the formulas: primes over 1/2 rho L d, about midship.

Derivatives printed over 1/2 rho L^2 are multiplied by L/T. If a model includes the added mass in surge in the turning
force, or the mass in everything, these are removed. If tests had the rudder on, its share amidships is removed by its
own printed slopes, a flow straightening of 0.4 and a lever of 0.8 L, usual for single-screw ships.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

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


def _over_draft(length: float, draft: float, printed: Mapping[str, float]) -> dict[str, float]:
    """Convert primes over 1/2 rho L^2 to primes over 1/2 rho L d."""
    return {name: value * length / draft for name, value in printed.items()}


def _without_rudder(primes: Mapping[str, float], force: float, moment: float) -> dict[str, float]:
    """Remove the rudder amidships, by its force and moment per radian."""
    bare = dict(primes)
    for name, slope in (("Y", force), ("N", moment)):
        bare[f"{name}_v"] += STRAIGHTENING * slope
        bare[f"{name}_r"] -= STRAIGHTENING * LEVER * slope
    return bare


def _identified(
    ship: tuple[float, float, float], sway: float, yaw: float, drift: tuple[float, float], turning: tuple[float, float]
) -> dict[str, float]:
    """Primes of the package's fit with the terms ``crossflow``, which include mass, lever and inertia of the ship."""
    mass, lever, inertia = ship
    surge = SURGE_SHARE * mass
    return {
        "X_my": sway - mass, "N_jz": yaw - inertia, "Y_v": -drift[0], "N_v": -drift[1],
        "Y_r": mass + surge - turning[0], "N_r": mass * lever - turning[1],
    }  # fmt: skip


# m', x_G' and I_z' of the tests in shallow water.
_KVLCC2 = (0.2935, 0.0340, 0.01808)

KVLCC2 = KnownShip(
    "KVLCC2",
    "Yasukawa and Yoshimura (2015); tests of Flanders Hydraulics, SIMMAN 2014, as identified here, in shallow water",
    Hull(7 / 1.27, 1.27 / 0.46, 0.81, 0.25 / 7),
    {
        math.inf: {
            "X_mx": 0.022, "X_my": 0.223, "N_jz": 0.011,
            "Y_v": -0.315, "Y_r": 0.083, "N_v": -0.137, "N_r": -0.049,
            "X_vv": -0.040, "X_vr": 0.002, "X_rr": 0.011, "X_vvvv": 0.771,
            "Y_vvv": -1.607, "Y_vvr": 0.379, "Y_vrr": -0.391, "Y_rrr": 0.008,
            "N_vvv": -0.030, "N_vvr": -0.294, "N_vrr": 0.055, "N_rrr": -0.013,
        },
        1.8: _identified(_KVLCC2, 0.6263, 0.0306, (0.3603, 0.2384), (0.2190, 0.0729)),
        1.5: _identified(_KVLCC2, 0.6690, 0.0327, (0.4511, 0.3219), (0.2449, 0.0772)),
        1.2: _identified(_KVLCC2, 0.8119, 0.0423, (0.8776, 0.4922), (0.2150, 0.1116)),
    },
    {
        1.8: {"X_my": 0.06, "N_jz": 0.06, "Y_v": 0.07, "N_v": 0.04, "Y_r": 0.18, "N_r": 0.08},
        1.5: {"X_my": 0.08, "N_jz": 0.05, "Y_v": 0.09, "N_v": 0.03, "Y_r": 0.46, "N_r": 0.12},
        1.2: {"X_my": 0.14, "N_jz": 0.06, "Y_v": 0.18, "N_v": 0.06, "Y_r": 0.49, "N_r": 0.10},
    },
)  # fmt: skip

S175 = KnownShip(
    "S-175", "Son and Nomoto (1982)", Hull(175 / 25.4, 25.4 / 8.5, 21222 / (175 * 25.4 * 8.5)),
    {
        math.inf: _over_draft(175.0, 8.5, {
            "X_mx": 0.000238, "X_my": 0.007049, "N_jz": 0.000419,
            "Y_v": -0.0116, "Y_r": 0.00242, "N_v": -0.0038545, "N_r": -0.00222,
            "X_vv": -0.00386, "X_vr": -0.00311, "X_rr": 0.00020,
            "Y_vvv": -0.109, "Y_vvr": 0.0214, "Y_vrr": -0.0405, "Y_rrr": 0.00177,
            "N_vvv": 0.001492, "N_vvr": -0.0424, "N_vrr": 0.00156, "N_rrr": -0.00229,
        })
    },
)  # fmt: skip

# The printed Y_r and N_r are less m' and m' x_G' (0.00798, -0.023), X_vr is more by m'. Y_vvr and N_vvr are left out:
# the polynomial has no terms in v r r, whose effect they contain.
_MARINER = _over_draft(160.93, 7.47, {
    "X_mx": 0.00042, "X_my": 0.00748, "N_jz": 0.000438,
    "Y_v": -0.0116, "Y_r": -0.00499 + 0.00798 + 0.00042, "N_v": -0.00264, "N_r": -0.00166 - 0.00798 * 0.023,
    "X_vv": -0.00899, "X_vr": -0.00748, "X_rr": 0.00018 + 0.00798 * 0.023,
    "Y_vvv": -0.08078, "N_vvv": 0.01636,
})  # fmt: skip

MARINER = KnownShip(
    "Mariner", "Chislett and Stroem-Tejsen (1965)", Hull(160.93 / 23.17, 23.17 / 7.47, 0.597, -0.023),
    {math.inf: _without_rudder(_MARINER, 0.00278 * 160.93 / 7.47, -0.00139 * 160.93 / 7.47)},
)  # fmt: skip

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

ESSO_OSAKA = KnownShip(
    "Esso Osaka", "3 m model of Osaka University, Miyauchi et al. (2022)",
    Hull(3 / 0.48925, 0.48925 / 0.20114, 0.831, 0.031),
    {math.inf: {"X_mx": 0.0467, "X_my": 0.2579}},
)  # fmt: skip

_KCS = (0.1823, -0.0139, 0.01195)

KCS = KnownShip(
    "KCS", "tests of Flanders Hydraulics, SIMMAN 2014, as identified here",
    Hull(4.3671 / 0.6114, 0.6114 / 0.2051, 0.651, _KCS[1]),
    {
        2.0: _identified(_KCS, 0.4097, 0.0210, (0.2208, 0.1340), (0.1311, 0.0576)),
        1.5: _identified(_KCS, 0.4957, 0.0236, (0.3353, 0.2073), (0.1482, 0.0708)),
        1.2: _identified(_KCS, 0.6166, 0.0320, (1.2901, 0.4074), (0.1591, 0.1538)),
    },
    {
        2.0: {"X_my": 0.15, "N_jz": 0.06, "Y_v": 0.32, "N_v": 0.18, "Y_r": 0.42, "N_r": 0.10},
        1.5: {"X_my": 0.16, "N_jz": 0.08, "Y_v": 0.23, "N_v": 0.16, "Y_r": 0.66, "N_r": 0.11},
        1.2: {"X_my": 0.24, "N_jz": 0.12, "Y_v": 0.31, "N_v": 0.31, "Y_r": 2.05, "N_r": 0.16},
    },
)  # fmt: skip

KNOWN_SHIPS = (KVLCC2, S175, MARINER, TANKER, ESSO_OSAKA, KCS)
