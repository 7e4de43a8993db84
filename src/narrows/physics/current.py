"""A current that changes across a canal or along it: motion over the ground, and what its gradient does to a hull."""

from typing import NamedTuple

from narrows.quantities.names import Number


class CurrentGradient(NamedTuple):
    """Effects of a current that is not the same at bow and stern, or not the same everywhere."""

    turn: Number  # Rate at which the water turns along the hull [1/s]: the hull forces depend on the yaw rate less this
    ahead: Number  # Acceleration that the change of the water takes from a mass, ahead [m/s2]
    starboard: Number  # The same to starboard [m/s2]


def current_gradient(
    cos_psi: Number, sin_psi: Number, u: Number, v: Number, across_slope: Number, shear: Number
) -> CurrentGradient:
    """Return what a gradient of the current does to a hull.

    ``across_slope`` [1/s] is the rise of the current across along the way, ``shear`` [1/s] that of the current along to
    starboard. Source: Thomasson and Woolsey (2013), Vehicle motion in currents, IEEE Journal of Oceanic Engineering,
    for the inertia in a flow with gradients; Fossen (2011), Handbook of marine craft hydrodynamics and motion control,
    for a uniform current, which leaves the equations of the velocity through the water as they are.
    """
    # The gradient G of the current acts on the velocity w through the water. A floating ship displaces its own mass of
    # water, so m (d/dt of the current that it meets) less the pressure of the accelerating water leaves m G w. The hull
    # forces, Coriolis forces among them, take the yaw rate less turn; the rigid body turns by the whole of it.
    along, off = shear * (u * sin_psi + v * cos_psi), across_slope * (u * cos_psi - v * sin_psi)
    turn = across_slope * cos_psi * cos_psi - shear * sin_psi * sin_psi
    return CurrentGradient(
        turn, along * cos_psi + off * sin_psi - turn * v, off * cos_psi - along * sin_psi + turn * u
    )  # fmt: skip
