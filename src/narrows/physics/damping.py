"""Damping, linear and quadratic in each velocity, per unit of each coefficient."""

from narrows.quantities.names import Number


def linear_surge(u: Number) -> Number:
    """Regressor [m/s] of linear surge damping, -u. Source: Mikkelsen et al. (2025), Damping Force and Moment."""
    return -u


def quadratic_surge(u: Number) -> Number:
    """Regressor [m2/s2] of quadratic surge damping, -abs(u) u.

    Source: Mikkelsen et al. (2025), Damping Force and Moment.
    """
    return -abs(u) * u


def linear_sway(v: Number) -> Number:
    """Regressor [m/s] of linear sway damping, -v. Source: Mikkelsen et al. (2025), Damping Force and Moment."""
    return -v


def quadratic_sway(v: Number) -> Number:
    """Regressor [m2/s2] of quadratic sway damping, -abs(v) v.

    Source: Mikkelsen et al. (2025), Damping Force and Moment.
    """
    return -abs(v) * v


def linear_yaw(r: Number) -> Number:
    """Regressor [rad/s] of linear yaw damping, -r. Source: Mikkelsen et al. (2025), Damping Force and Moment."""
    return -r


def quadratic_yaw(r: Number) -> Number:
    """Regressor [rad2/s2] of quadratic yaw damping, -abs(r) r.

    Source: Mikkelsen et al. (2025), Damping Force and Moment.
    """
    return -abs(r) * r


def sway_lift(u: Number, v: Number) -> Number:
    """Regressor [m2/s2] of the hull's lift from drift and of the Munk moment, -u v.

    Source: Fossen (2011), section 6.5.
    """
    return -u * v


def yaw_lift(u: Number, r: Number) -> Number:
    """Regressor [m rad/s2] of lift from turning and of the centripetal force, -u r.

    Source: Fossen (2011), section 6.5.
    """
    return -u * r


def yaw_in_crossflow(v: Number, r: Number) -> Number:
    """Regressor [m rad/s2] of crossflow drag, -abs(v) r. Source: Fossen (2011), section 6.5."""
    return -abs(v) * r


def sway_in_crossflow(v: Number, r: Number) -> Number:
    """Regressor [m rad/s2] of crossflow drag, -abs(r) v. Source: Fossen (2011), section 6.5."""
    return -abs(r) * v


def sway_squared(v: Number) -> Number:
    """Regressor [m2/s2] of the surge force of drift, -v v. Source: the usual 3-DOF models."""
    return -v * v


def sway_yaw(v: Number, r: Number) -> Number:
    """Regressor [m rad/s2] of the surge force of drift and turning together, -v r. Source: the usual 3-DOF models."""
    return -v * r


def yaw_squared(r: Number) -> Number:
    """Regressor [rad2/s2] of the surge force of turning, -r r. Source: the usual 3-DOF models."""
    return -r * r
