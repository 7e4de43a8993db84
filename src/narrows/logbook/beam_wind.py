"""A beam wind on a ship of which only the length is known: force and moment of one standard deviation."""

from narrows.safety.disturbance import wind_force

# Lateral area over the square of the length, of a loaded container ship about, and where the wind's force acts, over
# the length: used where none is given.
WINDAGE, LEVER = 0.1, 0.1


def beam_wind(length: float, speed: float, windage: float | None, lever: float | None) -> tuple[float, float]:
    """Return sway force [N] and yaw moment [N m] of a beam wind."""
    # length [m]; speed [m/s]; windage [m2]; lever [m]
    force = wind_force(speed, WINDAGE * length**2 if windage is None else windage)
    return force, force * (LEVER * length if lever is None else lever)
