"""Force on the rig that accelerates the hull and its added water, per unit of each coefficient."""

from narrows.quantities.names import Number


def surge_inertia(udot: Number) -> Number:
    """Regressor of the mass in surge [m/s2]. Source: Mikkelsen et al. (2025), eq. (mass_inertia_x)."""
    return -udot


def sway_inertia(vdot: Number) -> Number:
    """Regressor [m/s2] of the mass in sway. Source: Mikkelsen et al. (2025), eqs. (mass_inertia_y, mass_inertia_z)."""
    return -vdot


def yaw_inertia(rdot: Number) -> Number:
    """Regressor of the inertia in yaw [rad/s2], Y = -b_rdot rdot and N = -c_rdot rdot.

    The paper once prints + for the latter; its regression matrix and the physics have -.

    Source: Mikkelsen et al. (2025), eqs. (mass_inertia_y, mass_inertia_z).
    """
    return -rdot
