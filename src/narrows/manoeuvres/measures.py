"""What trials are read for: a turning circle's advance and diameter, a zigzag's overshoots."""

from dataclasses import dataclass

import numpy as np

from narrows.errors import InputError
from narrows.simulation.controllers import Zigzag
from narrows.simulation.voyage import Voyage

QUARTER, HALF = np.pi / 2, np.pi


@dataclass(frozen=True)
class Turning:
    """A turning circle, from where the rudder was ordered.

    Parameters
    ----------
    advance : float [m]
        Along the first course when the heading has changed by 90 degrees.
    transfer : float [m]
        Across it, then.
    tactical_diameter : float [m]
        Across it when the heading has changed by 180 degrees.
    """

    advance: float
    transfer: float
    tactical_diameter: float


def turning_circle(voyage: Voyage) -> Turning:
    """Read a turning circle from a voyage that starts with the order, x along the first course.

    Parameters
    ----------
    voyage : Voyage
        In open water, under a held rudder.

    Returns
    -------
    Turning
        To either side, positive.

    Raises
    ------
    InputError
        Where the ship has not turned by 180 degrees.

    References
    ----------
    IMO (2002), resolution MSC.137(76), Standards for ship manoeuvrability.
    """
    turned = np.abs(voyage.psi - voyage.psi[0])
    if turned.max() < HALF:
        raise InputError(
            f"the ship turned by {np.degrees(turned.max()):.0f} degrees of the 180 asked for; sail on for longer"
        )
    x, y = (column - column[0] for column in (voyage.x, voyage.y))
    first = slice(0, int(np.argmax(turned >= HALF)) + 1)
    along, across = (np.interp((QUARTER, HALF), turned[first], np.abs(column[first])) for column in (x, y))
    return Turning(float(along[0]), float(across[0]), float(across[1]))


def overshoots(voyage: Voyage, zigzag: Zigzag) -> tuple[float, ...]:
    """Return how far the heading went on after each order that reversed the rudder [rad].

    Parameters
    ----------
    voyage : Voyage
        In open water, under the zigzag.
    zigzag : Zigzag
        Its order.

    Raises
    ------
    InputError
        Where the voyage ends before the first overshoot does.

    References
    ----------
    IMO (2002), resolution MSC.137(76), Standards for ship manoeuvrability.
    """
    heading = np.sign(zigzag.rudder) * (voyage.psi - voyage.psi[0])
    angles, side, row = [], 1.0, 0
    while True:
        over = np.flatnonzero(side * heading[row:] >= zigzag.heading)
        if not over.size:
            break
        row += int(over[0])
        back = np.flatnonzero(side * heading[row:] < zigzag.heading)
        if not back.size:
            break
        angles.append(float((side * heading[row : row + int(back[0])]).max() - zigzag.heading))
        row += int(back[0])
        side = -side
    if not angles:
        raise InputError("the voyage ends before the heading comes back once; sail on for longer")
    return tuple(angles)
