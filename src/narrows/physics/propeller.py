"""The propeller of the MMG standard method: wake fraction, thrust and slipstream. Thrust deduction is a coefficient."""

import math
from typing import Any

from narrows.physics.hull import drift, speed
from narrows.quantities.arithmetic import maximum, minimum
from narrows.quantities.names import Number

# Sway force of the Esso Osaka's propeller astern over 1/2 rho L d (n D)^2 [1]: without advance, and its slopes by the
# advance -u/(n D) between the two ADVANCES and beyond them.
WITHOUT_ADVANCE, BETWEEN, BEYOND = -5.58e-4, -7.99e-3, 5.87e-3
ADVANCES = 0.06, 0.35
NOTHING = 1e-9  # An angle [rad] that counts as zero, without a side


# Functions of one argument ``at`` take the quantities as its attributes: a force needs up to 28 of them.


def inflow(at: Any) -> Number:
    """Velocity of the water along the propeller [m/s], u (1 - w_P); the wake decreases in a turn.

    ``(1 - w_P)/(1 - w_P0) = 1 + (1 - exp(-C_1 |beta_P|)) (C_2 - 1)``, C_2 by the side of beta_P = beta - x_P' r'.
    Source: Yasukawa and Yoshimura (2015).
    """
    turned = 1 - math.e ** (-at.propeller_wake_rate * abs(angle_to_propeller(at)))
    return at.u * (1 - at.propeller_wake) * (1 + turned * (wake_share(at) - 1))


def angle_to_propeller(at: Any) -> Number:
    """Angle of the inflow to the propeller [rad], beta_P. Source: Yasukawa and Yoshimura (2015)."""
    return drift(at.u, at.v) - at.propeller_position * at.r * at.length / speed(at.u, at.v)


def wake_share(at: Any) -> Number:
    """Wake ratio of a hard turn to straight running [1], C_2 by the side. Source: Yasukawa and Yoshimura (2015)."""
    angle = angle_to_propeller(at)
    middle = (at.propeller_wake_starboard + at.propeller_wake_port) / 2
    half = (at.propeller_wake_starboard - at.propeller_wake_port) / 2
    return middle + half * angle / (abs(angle) + NOTHING)


def loading(at: Any) -> Number:
    """Thrust over density and the square of the diameter [m2/s2], K_T n^2 D^2, with J = u_P / (n D).

    Ahead K_T = k_0 + k_1 J + k_2 J^2, astern K_T = a_0 + a_1 J + a_2 (J^2 + 0.49)^(1/2) + k_2 J^2; with all a = 0 the
    propeller counts as stopped. Source: Yasukawa and Yoshimura (2015); astern a fit to Roddy, Hess and Faller (2006).
    """
    # Written without J, which is infinite at a stopped propeller.
    tip, coming = (at.revolutions + abs(at.revolutions)) / 2 * at.propeller_diameter, inflow(at)
    back = tip - at.revolutions * at.propeller_diameter
    # From an advance of 0.7 the thrust astern rises: there the flow through the propeller turns round.
    turning = (coming * coming + 0.7 * 0.7 * back * back) ** 0.5
    astern = at.propeller_astern_0 * back - at.propeller_astern_1 * coming + at.propeller_astern_2 * turning
    ahead = at.propeller_thrust_0 * tip * tip + coming * (at.propeller_thrust_1 * tip + at.propeller_thrust_2 * coming)
    return ahead + back * astern


def thrust(at: Any) -> Number:
    """Surge force of the propeller per unit of 1 - t_P [N], rho n^2 D^4 K_T. Source: Yasukawa and Yoshimura (2015)."""
    return at.density * at.propeller_diameter * at.propeller_diameter * loading(at)


def transverse_thrust(at: Any) -> Number:
    """Sway force of a right-handed propeller that turns astern [N], as that of the Esso Osaka: to port.

    Source: A_1 to A_5 of the MMG model of a 3 m model of that tanker at Osaka University; two programs agree.
    """
    # Written without the advance, which is infinite at a stopped propeller.
    tip = (abs(at.revolutions) - at.revolutions) / 2 * at.propeller_diameter
    slow, fast = (advance * tip for advance in ADVANCES)
    between = minimum(maximum(at.u, slow), fast) - slow
    force = tip * (WITHOUT_ADVANCE * tip + BETWEEN * between + BEYOND * maximum(at.u - fast, 0.0))
    return 0.5 * at.density * at.length * at.draft * force


def transverse_thrust_yaw(at: Any) -> Number:
    """Yaw moment of that force [N m], bow to starboard. Source: as for ``transverse_thrust``, B_1 to B_5 within 1 %."""
    return -0.4 * at.length * transverse_thrust(at)  # Its lever is 0.4 L behind midship
