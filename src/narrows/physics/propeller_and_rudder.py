"""The propeller and the rudder of the MMG standard method.

Propeller: wake fraction, thrust and slipstream; thrust deduction is a coefficient. Rudder: its normal force is 1/2 rho
A U_R (u_R sin delta - v_R cos delta). The terms ``helm_*`` are the force of turning the rudder, added to a hull tested
with it amidships. The area is L T/100, and lift, wake, slipstream and the hull's share are in the coefficients, so
these hold for the propeller loading of the tests. The terms ``rudder_*`` are the whole method, in the slipstream of the
propeller.
"""

import math
from collections.abc import Callable, Mapping, Sequence
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


def _normal_flow(at: Any, cosine: Number, sine: Number) -> Number:
    """Return U_R (u sin delta - v_R cos delta) [m2/s2], with the flow straightened by hull and propeller."""
    across = at.flow_straightening * (at.r * at.length / 2 - at.v)
    return (at.u * at.u + across * across) ** 0.5 * (at.u * sine - across * cosine)


def _half_density_area(at: Any) -> Number:
    return 0.5 * at.density * 0.01 * at.length * at.draft  # The reference area is L T/100


def helm_surge(at: Any) -> Number:
    """Surge force [N] of the rudder per unit coefficient. Source: form of Yasukawa and Yoshimura (2015)."""
    return -_half_density_area(at) * _normal_flow(at, at.cos_rudder, at.sin_rudder) * at.sin_rudder


def helm_sway(at: Any) -> Number:
    """Sway force [N] of turning the rudder, per unit. Source: Yasukawa and Yoshimura (2015), less the one amidships."""
    turned = _normal_flow(at, at.cos_rudder, at.sin_rudder) * at.cos_rudder
    return -_half_density_area(at) * (turned - _normal_flow(at, 1.0, 0.0))


def helm_yaw(at: Any) -> Number:
    """Yaw moment [N m] of turning the rudder, per unit. Source: as for ``helm_sway``."""
    return -at.length * helm_sway(at)


def axial_velocity(at: Any) -> Number:
    """Velocity of the water along the rudder [m/s], in the propeller's slipstream over the share eta of its height.

    u_R = epsilon u_P (eta (1 + kappa ((1 + 8 K_T/(pi J^2))^(1/2) - 1))^2 + 1 - eta)^(1/2). Source: Yasukawa and
    Yoshimura (2015).
    """
    u_p = inflow(at)
    # A propeller with negative thrust slows its slipstream, to zero at most: the root of max(squared, 0).
    squared = u_p * u_p + 8 / math.pi * loading(at)
    # The outer abs: rounding of the sum may leave less than zero.
    slipstream = math.sqrt(0.5) * abs(squared + abs(squared)) ** 0.5
    inside = u_p + at.rudder_slipstream * (slipstream - u_p)
    mixed = at.rudder_in_slipstream * inside * inside + (1 - at.rudder_in_slipstream) * u_p * u_p
    return at.rudder_wake_ratio * mixed**0.5


def lateral_velocity(at: Any) -> Number:
    """Velocity of the water across the rudder [m/s], U gamma_R beta_R. Source: Yasukawa and Yoshimura (2015)."""
    whole, angle = speed(at.u, at.v), inflow_angle(at)
    middle = (at.rudder_straightening_starboard + at.rudder_straightening_port) / 2
    half = (at.rudder_straightening_starboard - at.rudder_straightening_port) / 2
    return whole * (middle * angle + half * abs(angle))


def inflow_angle(at: Any) -> Number:
    """Angle of the inflow to the rudder [rad], beta_R. Source: Yasukawa and Yoshimura (2015)."""
    return drift(at.u, at.v) - at.rudder_position * at.r * at.length / speed(at.u, at.v)


def normal_force(at: Any) -> Number:
    """Normal force of the rudder [N], F_N. Source: Yasukawa and Yoshimura (2015)."""
    forward, sideways = axial_velocity(at), lateral_velocity(at)
    return _lift(at, forward, sideways) * (forward * at.sin_rudder - sideways * at.cos_rudder)


def _lift(at: Any, forward: Number, sideways: Number) -> Number:
    """Return the normal force per velocity across the rudder [N s/m], 1/2 rho A_R f_alpha U_R."""
    return 0.5 * at.density * at.rudder_area * at.rudder_lift * (forward * forward + sideways * sideways) ** 0.5


def rudder_surge(at: Any) -> Number:
    """Surge force of the rudder per unit of 1 - t_R [N], -F_N sin delta. Source: Yasukawa and Yoshimura (2015)."""
    return -normal_force(at) * at.sin_rudder


def rudder_sway(at: Any) -> Number:
    """Sway force of the rudder per unit of 1 + a_H [N], -F_N cos delta. Source: Yasukawa and Yoshimura (2015)."""
    return -normal_force(at) * at.cos_rudder


def rudder_yaw(at: Any) -> Number:
    """Yaw moment of the rudder per unit of -(x_R' + a_H x_H') [N m]. Source: Yasukawa and Yoshimura (2015)."""
    return at.length * normal_force(at) * at.cos_rudder


def straightening_sway(at: Any) -> Number:
    """Sway force [N] of a flow straightening that differs by side, per unit of (1 + a_H) (gamma_R+ - gamma_R-)/2.

    Source: F_N of Yasukawa and Yoshimura (2015), whose gamma_R of the KVLCC2 is 0.640 to one side, 0.395 to the other.
    """
    lift = _lift(at, axial_velocity(at), lateral_velocity(at))
    return lift * speed(at.u, at.v) * abs(inflow_angle(at)) * at.cos_rudder * at.cos_rudder


def straightening_yaw(at: Any) -> Number:
    """Yaw moment of that force per unit [N m]. Source: as for ``straightening_sway``."""
    return -at.length * straightening_sway(at)


def even_rudder_sway(at: Any) -> Number:
    """Sway force [N] of a rudder that is stronger to one side, per unit: as of F_N, with sin^2 delta for sin delta.

    Source: the even power of the rudder angle, Y_deltadelta, of asymmetric polynomial models as in Abkowitz (1964).
    """
    forward = axial_velocity(at)
    lift = _lift(at, forward, lateral_velocity(at))
    return -lift * forward * at.sin_rudder * at.sin_rudder * at.cos_rudder


def even_rudder_yaw(at: Any) -> Number:
    """Yaw moment of that force per unit [N m]. Source: as for ``even_rudder_sway``, N_deltadelta."""
    return -at.length * even_rudder_sway(at)


# Shortest time constant [s]; shorter ones count as zero. It keeps quotients of two times finite if both are 0.
NO_TIME = 1e-12

Functions = Mapping[str, Callable[..., Any]]


def gear_motion(
    order: Number, position: Number, stages: Sequence[Number], gear: Mapping[str, Number], dt: Number,
    functions: Functions, put: Callable[[str, Any], Any] = lambda name, value: value,
) -> tuple[Any, list[Any]]:  # fmt: skip
    """Return the motion of an actuator in a step [rad], and the new stages of its dead time.

    Source: the exponential of a first-order lag; tanks in series for the dead time, Levenspiel (1999), Chemical
    Reaction Engineering, chapter 14.

    ``gear`` has ``dead_time``, ``lag`` [s], ``dead_band`` and ``rate``; ``functions`` are minimum, maximum, choice and
    exp for the type of number; ``put`` stores values that are used more than once.
    """
    # The dead time is a chain of equal first-order stages. A stage passes on a share of its input; if the step is
    # longer than its part of the dead time it passes on all of it, weighted between start and end of the step. So a
    # ramp is late by exactly the dead time for any step. A list of past orders would have a length that depends on it.
    least, greatest = functions["minimum"], functions["maximum"]
    passing = put("passing", len(stages) * dt)
    share = put("share", passing / greatest(greatest(gear["dead_time"], passing), NO_TIME))
    late = put("late", least(gear["dead_time"] / greatest(passing, NO_TIME), 1.0))
    delayed, after = order, []
    for number, stage in enumerate(stages):
        after.append(put(f"delayed_{number}_new", stage + share * (delayed - stage)))
        delayed = put(f"delayed_{number}_out", after[-1] + late * (stage - after[-1]))
    left = put("left", delayed - position)
    moved = put("moved", functions["choice"](abs(left) - gear["dead_band"], left, 0.0))
    followed = put("followed", 1.0 - functions["exp"](-dt / greatest(gear["lag"], NO_TIME)))
    furthest = put("reach", gear["rate"] * dt)
    return put("whole", least(greatest(moved * followed, -furthest), furthest)), after
