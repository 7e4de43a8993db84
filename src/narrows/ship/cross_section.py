"""Banks that are no walls: slopes and platforms, and the wall that leaves the water the same section."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from narrows.errors import InputError
from narrows.ship.particulars import Ship

Point = tuple[float, float]


def equivalent_wall(profile: Sequence[Point], depth: float) -> float:
    """Return how far from the origin a vertical wall leaves the same cross-section of water [m].

    The water between the origin and the last point is as wide as it is; what the bank takes from its section is taken
    from its width.

    Parameters
    ----------
    profile : sequence of (m, m)
        Points of the bank: distance from the origin and height above the bottom, outward from the toe. The last
        point stands for a wall or for where the slope leaves the water.
    depth : float [m]
        Of the water.

    Raises
    ------
    InputError
        Where the points do not go outward, or the bank leaves no water.
    """
    if not depth > 0:
        raise InputError(f"a depth of {depth} m is no water; give it in metres")
    if len(profile) < 2 or any(height < 0 for _, height in profile):
        raise InputError(f"the bank {list(profile)} needs two points or more, none below the bottom; mend it")
    if any(after[0] < before[0] for before, after in pairwise(profile)):
        raise InputError(f"the bank {list(profile)} turns back; give its points outward from the toe")
    taken = sum(_below(before, after, depth) for before, after in pairwise(profile))
    wall = profile[-1][0] - taken / depth
    if not wall > 0:
        raise InputError(f"the bank {list(profile)} leaves no water {depth} m deep; check both")
    return wall


def keel_wall(profile: Sequence[Point], clearance: float) -> float:
    """Return how far from the origin a keel meets a bank [m]: where the bank is as high as the water under it."""
    # profile (m, m); clearance [m]
    for (start, low), (stop, high) in pairwise(profile):
        if high >= clearance:
            return start if low >= clearance else start + (stop - start) * (clearance - low) / (high - low)
    return profile[-1][0]


def _below(before: Point, after: Point, depth: float) -> float:
    """Area of a straight piece of bank below the water level [m2]."""
    (start, low), (stop, high) = before, after
    if max(low, high) <= depth or high == low:
        return (stop - start) * min((low + high) / 2, depth)
    if min(low, high) >= depth:
        return (stop - start) * depth
    crossing = start + (stop - start) * (depth - low) / (high - low)
    wet = crossing - start if low < high else stop - crossing
    return wet * (min(low, high) + depth) / 2 + (stop - start - wet) * depth


# How much room a hull takes across its way.
def half_swept(ship: Ship, heading: np.ndarray | float) -> np.ndarray:
    """Return how far to either side of midship the corners of a hull are [m]."""
    return np.asarray(ship.length / 2 * np.abs(np.sin(heading)) + ship.beam / 2 * np.cos(heading))
