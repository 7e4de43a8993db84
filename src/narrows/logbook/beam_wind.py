"""A beam wind on a ship of which only the length is known: force and moment of one standard deviation."""

from narrows.safety.disturbance import wind_force

WINDAGE, LEVER = 0.1, 0.1
"""Lateral area over the square of the length, of a loaded container ship about, and where the wind's force acts, over
the length: used where none is given (ours)."""


def beam_wind(length: float, speed: float, windage: float | None, lever: float | None) -> tuple[float, float]:
    """Return sway force [N] and yaw moment [N m] of a beam wind (ours).

    Parameters
    ----------
    length : float [m]
        Of the ship.
    speed : float [m/s]
        Of the wind.
    windage : float [m2], optional
        Lateral area above the water; a tenth of the square of the length unless given.
    lever : float [m], optional
        Of the force, off midship; a tenth of the length unless given.

    Raises
    ------
    InputError
        Where a number is negative or not finite.
    """
    force = wind_force(speed, WINDAGE * length**2 if windage is None else windage)
    return force, force * (LEVER * length if lever is None else lever)
