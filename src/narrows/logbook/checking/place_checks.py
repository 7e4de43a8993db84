"""The ship's place: inside its banks, and its antenna where it is said to be."""

from collections.abc import Iterator

import numpy as np

from narrows.logbook.checking.examined import Examined
from narrows.logbook.checking.finding import Finding

# Of the times at which a hull may reach into a bank, by the noise of its position.
ASHORE = 0.002


def check_place(at: Examined) -> Iterator[Finding]:
    """Yield where the hull would lie in a bank."""
    motion, ship = at.motion, at.model.configuration.ship
    if not {"x", "y", "psi"} <= motion.columns.keys() or not (at.waterway or at.model.feels_bank):
        return
    reach = ship.length / 2 * np.abs(np.sin(motion["psi"])) + ship.beam / 2 * np.abs(np.cos(motion["psi"]))
    starboard, port = _room(at)
    beyond = np.fmax(motion["y"] + reach - starboard, reach - motion["y"] - port)
    share = float(np.nanmean(beyond > 0))
    if not share > ASHORE:
        return
    worst = int(np.nanargmax(beyond))
    mirrored = np.fmax(reach - motion["y"] - starboard, motion["y"] + reach - port)
    turned = float(np.nanmean(mirrored > 0)) <= ASHORE
    yield at.finding(
        "banks", f"the hull reaches {beyond[worst]:.3g} m into a bank at t = {motion.t[worst]:.6g} s, y = "
        f"{motion['y'][worst]:.4g} m, and {share:.1%} of the time into one",
        'y counts to port: [positive] y = "port"' if turned else "check the waterway, the datum of the position, the "
        "antenna's place, and whether x and y are along and across it",
        {"beyond": beyond[worst], "share": share, "at": motion.t[worst]},
    )  # fmt: skip


def _room(at: Examined) -> tuple[np.ndarray, np.ndarray]:
    """How far the banks are to starboard and to port of the line, where the ship is [m]."""
    if at.waterway is None:
        half = np.full(len(at.motion.t), at.model.configuration.canal.width / 2)
        return half, half
    here = at.waterway.room(np.nan_to_num(at.motion["x"]), at.model.configuration.ship.draft)
    return here.width / 2 + here.middle, here.width / 2 - here.middle
