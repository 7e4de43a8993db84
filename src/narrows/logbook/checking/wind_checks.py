"""The wind: steady on the map, whatever the ship does; else its sign, its axes or the ship's own wind are wrong."""

from collections.abc import Iterator

import numpy as np

from narrows.logbook.checking.agreement import SURE, Estimates, least_squares
from narrows.logbook.checking.examined import Examined
from narrows.logbook.checking.finding import Finding

# Of the ship's velocity that a wind over ground must not hold.
HALF = 0.5
# By which factor a wind must be steadier when it is told from the bow.
BETTER = 3.0
# Of how many times the ship's velocity it holds.
CAUSES = {
    1.0: "it is the wind as felt on board: call it apparent_wind_speed and apparent_wind_angle",
    -2.0: "its angle says where the wind goes, not where it comes from: add half a turn",
    -1.0: "the ship's own wind was taken off twice",
}


def check_wind(at: Examined) -> Iterator[Finding]:
    """Yield where the wind goes with the ship."""
    motion = at.motion
    if not {"wind_speed", "wind_direction", "psi"} <= motion.columns.keys() or not np.isfinite(motion.position).any():
        return
    wind = motion["wind_speed"] * np.exp(1j * (motion["wind_direction"] + motion.axis))
    ship = np.gradient(motion.position, motion.dt)
    told, by_bow = (_held(at, column, ship) for column in (wind, wind * np.exp(1j * motion["psi"])))
    if told is None or by_bow is None:
        return
    (share, unsteady), (_, unsteady_by_bow) = told, by_bow
    if unsteady > BETTER * unsteady_by_bow:
        yield at.finding(
            "wind",
            f"the wind varies by {unsteady:.3g} m/s on the map, by {unsteady_by_bow:.2g} m/s if told from the bow",
            "its direction is told from the bow: add the heading", {"unsteady": unsteady, "by_bow": unsteady_by_bow},
        )  # fmt: skip
        return
    held, error = share.values[0], share.errors[0]
    if abs(held) > HALF + SURE * error:
        nearest = min(CAUSES, key=lambda cause: abs(cause - held))
        yield at.finding(
            "wind", f"the wind holds {held:.2f} +- {1.96 * error:.2f} times the ship's own velocity", CAUSES[nearest],
            {"share": held, "error": error},
        )  # fmt: skip


def _held(at: Examined, wind: np.ndarray, ship: np.ndarray) -> tuple[Estimates, float] | None:
    """How much of the ship's velocity a wind holds, and how far it varies but for that [m/s]."""
    windows = at.motion.windows(1.0)
    lasting = (windows[1] - windows[0]) * at.motion.dt
    means = [at.motion.integrals(column, windows) / lasting for column in (wind, ship)]
    one = np.ones(len(lasting))
    blowing, moving, east = (np.concatenate([part.real, part.imag]) for part in (*means, 1j * one))
    found = least_squares(blowing, [moving, 1 - east, east])
    if found is None:
        return None
    left = blowing - np.stack([moving, 1 - east, east], axis=1) @ found.values
    return found, float(np.sqrt(2 * np.nanmean(left**2)))
