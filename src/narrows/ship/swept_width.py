"""How much room a hull takes across its way."""

import numpy as np

from narrows.ship.particulars import Ship


def half_swept(ship: Ship, heading: np.ndarray | float) -> np.ndarray:
    """Return how far to either side of midship the corners of a hull are [m]."""
    # heading [rad]
    return np.asarray(ship.length / 2 * np.abs(np.sin(heading)) + ship.beam / 2 * np.cos(heading))
