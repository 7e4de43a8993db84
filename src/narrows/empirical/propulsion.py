"""Propeller, rudder and resistance from main dimensions: interaction by formulas, sizes by type of ship."""

import math
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.empirical.formulas import Hull
from narrows.model.water import wetted_surface
from narrows.quantities.names import GRAVITY
from narrows.ship.actuators import Propeller, Rudder
from narrows.ship.particulars import Ship, Water

VISCOSITY = 1.19e-6  # Kinematic viscosity of sea water at 15 degrees [m2/s]
LARGEST_FROUDE = 0.35  # Beyond it wave resistance dominates, which is not estimated


@dataclass(frozen=True)
class ShipType:
    words: str
    block_coefficient: float
    length_to_beam: float
    beam_to_draft: float
    froude: float  # Service speed over (g L)^(1/2)
    propeller: float  # Propeller diameter over draft
    rudder_area: float  # Rudder area over length times draft
    thrust: tuple[float, float, float]  # K_T = k_0 + k_1 J + k_2 J^2


# K_T of KVLCC2 for full ships, of S-175 for slender ones; sizes of KVLCC2, KCS, DTC and S-175.
FULL, SLENDER = (0.2931, -0.2753, -0.1385), (0.527, -0.455, 0.0)
ASPECT_RATIO = 1.8  # Height squared over area of a rudder

SHIP_TYPES = MappingProxyType({
    "container": ShipType("container ship", 0.65, 7.0, 3.3, 0.20, 0.62, 0.018, SLENDER),
    "tanker": ShipType("tanker", 0.82, 5.6, 2.7, 0.142, 0.48, 0.0168, FULL),
    "bulk": ShipType("bulk carrier", 0.83, 6.2, 2.6, 0.15, 0.50, 0.0165, FULL),
    "general": ShipType("general cargo ship", 0.70, 6.5, 2.6, 0.19, 0.60, 0.018, SLENDER),
    "inland": ShipType("inland motor ship", 0.88, 9.6, 3.5, 0.13, 0.55, 0.030, FULL),
    "convoy": ShipType("pushed convoy", 0.92, 8.3, 6.5, 0.10, 0.55, 0.045, FULL),
})  # fmt: skip


def service_speed(ship: Ship, kind: ShipType) -> float:
    """Return the design speed of the propeller [m/s]."""
    return kind.froude * math.sqrt(GRAVITY * ship.length)


def resistance_prime(ship: Ship, speed: float) -> float:
    """Return R_0' over 1/2 rho L T: ITTC-57 with Watanabe's form factor, Mumford's wetted surface, an allowance."""
    if not 0 < speed <= LARGEST_FROUDE * math.sqrt(GRAVITY * ship.length):
        most = LARGEST_FROUDE * math.sqrt(GRAVITY * ship.length)
        raise InputError(f"a speed of {speed:.4g} m/s is none of this ship; give one over 0 and up to {most:.3g} m/s")
    ratio, draft = ship.length / ship.beam, ship.beam / ship.draft
    friction = 0.075 / (math.log10(speed * ship.length / VISCOSITY) - 2) ** 2
    form = -0.095 + 25.6 * ship.block_coefficient / (ratio**2 * math.sqrt(draft))
    # The correlation allowance and the residual resistance are 0.0004 over the wetted surface.
    return ((1 + form) * friction + 0.0004) * wetted_surface(ship) / (ship.length * ship.draft)


def thrust_deduction(hull: Hull) -> float:
    """Return t_P: Harvald's line for single-screw ships."""
    return 0.25 * wake(hull) + 0.14


def wake(hull: Hull) -> float:
    """Return w_P0: Taylor's 0.5 C_B - 0.05."""
    return 0.5 * float(hull.block_coefficient) - 0.05


def rudder_force_increase(hull: Hull) -> float:
    """Return a_H: geometric mean of Yoshimura and Masumoto (2012) and Quadvlieg (2013)."""
    return math.sqrt(3.6 * float(hull.fullness) * max(0.627 * float(hull.block_coefficient) - 0.153, 0.05))


RUDDER_SURGE = 0.61  # 1 - t_R, Yoshimura and Masumoto (2012); KVLCC2 has 0.613
RUDDER_PLACE, INCREASE_PLACE = 0.5, 0.45  # -x_R', -x_H' [1]; x_H' of Aoki et al. (2006)


def estimated_rudder(ship: Ship, hull: Hull, kind: ShipType, propeller: Propeller) -> Rudder:
    """Return a rudder of usual size, in the slipstream by Yoshimura and Masumoto (2012)."""
    area = kind.rudder_area * ship.length * ship.draft
    ratio = 2.26 - 1.82 * (1 - propeller.wake)
    straightening = 2.06 * float(hull.fullness) + 0.14
    return Rudder(
        area=area,
        lift=6.13 * ASPECT_RATIO / (ASPECT_RATIO + 2.25),
        wake_ratio=ratio,
        slipstream=0.55 / ratio,
        in_slipstream=min(propeller.diameter / math.sqrt(ASPECT_RATIO * area), 1.0),
        position=-0.9,  # l_R', Yoshimura and Masumoto (2012)
        straightening_starboard=straightening,
        straightening_port=straightening,
    )


def estimated_propeller(ship: Ship, hull: Hull, kind: ShipType, water: Water, speed: float) -> Propeller:
    """Return a propeller of usual size, with revolutions whose thrust balances the resistance at a speed."""
    thinned = 1 / (1 - wake(hull))
    # C_1 = 1.6 matches Hirano's (1980) exp(-4 beta_P^2) at a drift of 0.4 rad at the propeller, as in a turn.
    shaped = Propeller(
        kind.propeller * ship.draft, 0.0, wake(hull), *kind.thrust,
        wake_rate=1.6, wake_starboard=thinned, wake_port=thinned,
    )  # fmt: skip
    return with_astern_thrust(replace(shaped, revolutions=balanced_revolutions(ship, hull, shaped, speed)))


# Thrust of the Wageningen B4-70 series at the pitch ratios 0.6, 0.8, 1 and 1.2: K_T ahead without advance, and a_0, a_1
# and a_2 of K_T astern for k_2 = 0. SQUARE fits J^2 by the same functions (``decisions/propeller_series.py``).
SERIES = np.array([
    [0.2421, 0.3461, 0.4499, 0.5193], [0.959, 0.924, 0.962, 1.036], [-0.488, -0.504, -0.650, -0.772],
    [-1.633, -1.706, -1.906, -2.131],
])  # fmt: skip
SQUARE = (-2.386, 0.865, 3.525)


@accept_aliases
def with_astern_thrust(propeller: Propeller) -> Propeller:
    """Return a propeller with the thrust astern of the Wageningen B4-70 series, at the pitch of its thrust ahead.

    The pitch ratio is that at which the series has the same K_T without advance; beyond 0.6 and 1.2 the nearest counts.
    For advances J from -1.5 to 0 the fit is within 0.06 of the series' K_T.

    Source: Roddy, Hess and Faller (2006), Neural network predictions of the 4-quadrant Wageningen propeller series,
    NSWCCD-50-TR-2006/004.

    Parameters
    ----------
    propeller : Propeller
        A propeller whose thrust ahead is known.

    Examples
    --------
    >>> nw.with_astern_thrust(nw.Propeller(9.86, 1.78, 0.35, 0.2931, -0.2753, -0.1385)).astern_0
    0.6114
    """
    fits = (np.interp(propeller.thrust_0, SERIES[0], column) for column in SERIES[1:])
    found = (round(float(fit) - propeller.thrust_2 * part, 4) for fit, part in zip(fits, SQUARE, strict=True))
    return replace(propeller, **dict(zip(("astern_0", "astern_1", "astern_2"), found, strict=True)))


def balanced_revolutions(ship: Ship, hull: Hull, propeller: Propeller, speed: float) -> float:
    needed = resistance_prime(ship, speed) * 0.5 * ship.length * ship.draft * speed**2 / (1 - thrust_deduction(hull))
    inflow, size = speed * (1 - propeller.wake), propeller.diameter
    # thrust/rho = D^4 k_0 n^2 + D^3 k_1 u n + D^2 k_2 u^2
    square, linear = size**4 * propeller.thrust_0, size**3 * propeller.thrust_1 * inflow
    rest = size**2 * propeller.thrust_2 * inflow**2 - needed
    return (-linear + math.sqrt(linear**2 - 4 * square * rest)) / (2 * square)
