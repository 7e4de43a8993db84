"""What of a hull meets a bank: the corners of its rectangle, its side at midship, an outline, or nothing."""

from typing import Any

from narrows.errors import InputError, did_you_mean

# Points (forward, starboard) of a hull [m] from midship; the hull is as wide as their convex hull.
Outline = tuple[tuple[float, float], ...]
CORNERS, MIDSHIP, OPEN = "corners", "midship", "none"
SHAPES = (CORNERS, MIDSHIP, OPEN)
FEWEST_POINTS = 3


def checked_shape(shape: Any) -> str | Outline:
    """Return the name or the outline of a hull's shape."""
    # shape [m]
    if isinstance(shape, str):
        if shape not in SHAPES:
            raise InputError(f"contact {shape!r} is unknown{did_you_mean(shape, SHAPES)}, or points of an outline")
        return shape
    try:
        points = tuple((float(forward), float(starboard)) for forward, starboard in shape)
    except (TypeError, ValueError, OverflowError):
        raise InputError("contact: an outline is a list of points (forward, starboard), in metres") from None
    if len(points) < FEWEST_POINTS:
        raise InputError(f"contact: an outline needs {FEWEST_POINTS} points or more; this one has {len(points)}")
    if not all(abs(number) < 1e6 for point in points for number in point):
        raise InputError("contact: an outline's points are finite numbers of metres; mend them")
    return points


def point_names(count: int) -> list[tuple[str, str]]:
    """Name the coordinates of an outline's points."""
    return [(f"outline_forward_{number}", f"outline_starboard_{number}") for number in range(count)]
