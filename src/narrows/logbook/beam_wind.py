"""A beam wind on a ship of which only the length is known: force and moment of one standard deviation."""

from narrows.logbook.settings import WIND_LEVER, WINDAGE
from narrows.safety.request import wind_force


def beam_wind(length: float, speed: float, windage: float | None, lever: float | None) -> tuple[float, float]:
    """Return sway force [N] and yaw moment [N m] of a beam wind."""
    force = wind_force(speed, WINDAGE * length**2 if windage is None else windage)
    return force, force * (WIND_LEVER * length if lever is None else lever)
