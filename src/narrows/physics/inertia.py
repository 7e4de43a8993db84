"""Inertia of the hull and its added masses, as forces on a towing rig."""

import math

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


# Added mass and inertia of a hull in deep water, by regression over ships.
def clarke_sway(length: float, beam: float, draft: float, block_coefficient: float, density: float) -> float:
    """Added mass in sway in deep water [kg]. Source: Clarke, Gedling and Hine (1983)."""
    slender = 1 + 0.16 * block_coefficient * beam / draft - 5.1 * (beam / length) ** 2
    return math.pi * (draft / length) ** 2 * slender * density * length**3 / 2


def clarke_yaw(length: float, beam: float, draft: float, block_coefficient: float, density: float) -> float:
    """Added moment of inertia in yaw about midship in deep water [kg m2]. Source: Clarke, Gedling and Hine (1983)."""
    slender = 1 / 12 + 0.017 * block_coefficient * beam / draft - 0.33 * beam / length
    return math.pi * (draft / length) ** 2 * slender * density * length**5 / 2
