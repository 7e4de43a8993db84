"""The rudder: its normal force is 1/2 rho A U_R (u_R sin delta - v_R cos delta), as in the MMG standard method.

The terms ``helm_*`` are the force of turning the rudder, added to a hull tested with it amidships. The area is L T/100,
and lift, wake, slipstream and the hull's share are in the coefficients, so these hold for the propeller loading of the
tests. The terms ``rudder_*`` are the whole method, in the slipstream of the propeller.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from narrows.physics.hull import drift, speed
from narrows.physics.propeller import inflow, loading
from narrows.quantities.names import Number


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
