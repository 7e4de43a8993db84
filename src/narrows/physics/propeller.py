"""The propeller of the MMG standard method: what flows to it behind a turning hull, its thrust, its race."""

import math

from narrows.physics.hull import drift, speed
from narrows.quantities.names import Number, Values, asking

NOTHING = 1e-9
"""An angle [rad] too small to have a side."""
INFLOW = (
    "u", "v", "r", "length", "propeller_wake", "propeller_position", "propeller_wake_rate",
    "propeller_wake_starboard", "propeller_wake_port",
)  # fmt: skip
LOADING = (
    *INFLOW, "revolutions", "propeller_diameter", "propeller_thrust_0", "propeller_thrust_1", "propeller_thrust_2",
)  # fmt: skip


@asking(*INFLOW)
def inflow(at: Values) -> Number:
    """Velocity of the water along the propeller [m/s], u (1 - w_P), the wake thinner the more she turns.

    (1 - w_P)/(1 - w_P0) = 1 + (1 - exp(-C_1 |beta_P|)) (C_2 - 1), C_2 by the side of beta_P = beta - x_P' r'.

    Source: Yasukawa and Yoshimura (2015), the MMG standard method.
    """
    angle = drift(at.u, at.v) - at.propeller_position * at.r * at.length / speed(at.u, at.v)
    turned = 1 - math.e ** (-at.propeller_wake_rate * abs(angle))
    middle = (at.propeller_wake_starboard + at.propeller_wake_port) / 2
    half = (at.propeller_wake_starboard - at.propeller_wake_port) / 2
    share = middle + half * angle / (abs(angle) + NOTHING)
    return at.u * (1 - at.propeller_wake) * (1 + turned * (share - 1))


@asking(*LOADING)
def loading(at: Values) -> Number:
    """Thrust over density and the square of the diameter [m2/s2], K_T n^2 D^2 with K_T = k_0 + k_1 J + k_2 J^2.

    Written without J, which has no end where the propeller stands.

    Source: Yasukawa and Yoshimura (2015), the MMG standard method.
    """
    tip, coming = at.revolutions * at.propeller_diameter, inflow(at)
    return at.propeller_thrust_0 * tip * tip + coming * (at.propeller_thrust_1 * tip + at.propeller_thrust_2 * coming)


@asking(*LOADING, "density")
def thrust(at: Values) -> Number:
    """Surge force of the propeller per unit of 1 - t_P [N], rho n^2 D^4 K_T.

    Source: Yasukawa and Yoshimura (2015), the MMG standard method.
    """
    return at.density * at.propeller_diameter * at.propeller_diameter * loading(at)
