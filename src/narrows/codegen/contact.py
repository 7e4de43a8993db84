"""Where hull and bank meet: the room between them, and the side that is nearer, in lines."""

from collections.abc import Sequence
from typing import Any

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Lines, greatest, least, real
from narrows.errors import InputError, did_you_mean

Outline = tuple[tuple[float, float], ...]
"""Points (forward, starboard) of a hull [m] from midship; the hull is as wide as their convex hull."""
CORNERS, MIDSHIP, OPEN = "corners", "midship", "none"
SHAPES = (CORNERS, MIDSHIP, OPEN)
FEWEST_POINTS = 3


def checked_shape(shape: Any) -> str | Outline:
    """Return the name or the outline of a hull's shape (ours).

    Parameters
    ----------
    shape : str or sequence of pairs of float [m]
        ``corners``, ``midship``, ``none``, or points (forward, starboard) of an outline.

    Raises
    ------
    InputError
        Where it is none of these.
    """
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
    """Name the coordinates of an outline's points (ours).

    Parameters
    ----------
    count : int
        How many points.
    """
    return [(f"forward_{number}", f"starboard_{number}") for number in range(count)]


def reaches(lines: Lines, contact: str | int, cosine: Expr, sine: Expr) -> tuple[Expr, Expr]:
    """Write how far a hull reaches athwart the canal to starboard and to port of midship [m].

    Parameters
    ----------
    lines : Lines
        The program.
    contact : str or int
        ``corners`` of the rectangle around the hull; its side at ``midship``; or the number of points of an outline.
    cosine, sine : expression [1]
        Of the heading.
    """
    half_beam = real("half_beam")
    if contact == MIDSHIP:
        return (lines.put("reach", half_beam * cosine),) * 2
    if contact == CORNERS:
        return (lines.put("reach", real("half_length") * abs(sine) + half_beam * cosine),) * 2
    out = [
        lines.put(f"point_{number}", real(forward) * sine + real(starboard) * cosine)
        for number, (forward, starboard) in enumerate(point_names(int(contact)))
    ]
    return lines.put("reach_starboard", greatest(*out)), lines.put("reach_port", -least(*out))


def bank_room(lines: Lines, walls: Sequence[Expr], reach: Sequence[Expr], y: Expr) -> tuple[Expr, Expr]:
    """Write the room between a hull and the nearer bank, and how much more there is to port than to starboard [m].

    Parameters
    ----------
    lines : Lines
        The program.
    walls : pair of expression [m]
        How far the banks are off the line, to starboard and to port.
    reach : pair of expression [m]
        Of the hull from midship.
    y : expression [m]
        Midship to starboard of the line.
    """
    starboard = lines.put("room_starboard", walls[0] - y - reach[0])
    port = lines.put("room_port", walls[1] + y - reach[1])
    return lines.put("room_bank", least(starboard, port)), lines.put("lean", port - starboard)
