"""Damping, linear and quadratic in each velocity, per unit of each coefficient."""

from narrows.vocabulary import Number, documented


@documented
def linear_surge(u: Number) -> Number:
    """Regressor [m/s] of damping linear in the surge velocity, -u.

    Source: Mikkelsen et al. (2025), section Damping Force and Moment.
    """
    return -u


@documented
def quadratic_surge(u: Number) -> Number:
    """Regressor [m2/s2] of damping quadratic in the surge velocity, -abs(u) u.

    Source: Mikkelsen et al. (2025), section Damping Force and Moment.
    """
    return -abs(u) * u


@documented
def linear_sway(v: Number) -> Number:
    """Regressor [m/s] of damping linear in the sway velocity, -v.

    Source: Mikkelsen et al. (2025), section Damping Force and Moment.
    """
    return -v


@documented
def quadratic_sway(v: Number) -> Number:
    """Regressor [m2/s2] of damping quadratic in the sway velocity, -abs(v) v.

    Source: Mikkelsen et al. (2025), section Damping Force and Moment.
    """
    return -abs(v) * v


@documented
def linear_yaw(r: Number) -> Number:
    """Regressor [rad/s] of damping linear in the yaw velocity, -r.

    Source: Mikkelsen et al. (2025), section Damping Force and Moment.
    """
    return -r


@documented
def quadratic_yaw(r: Number) -> Number:
    """Regressor [rad2/s2] of damping quadratic in the yaw velocity, -abs(r) r.

    Source: Mikkelsen et al. (2025), section Damping Force and Moment.
    """
    return -abs(r) * r
