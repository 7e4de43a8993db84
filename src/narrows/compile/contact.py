"""Where hull and bank meet: the room between them, and the bank that is nearer."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

from narrows.compile.trace import Expr, symbol
from narrows.errors import InputError, did_you_mean

Outline = tuple[tuple[float, float], ...]
"""Points (forward, starboard) of a hull [m] from midship; the hull is as wide as their convex hull."""
SHAPES = ("corners", "midship")
FEWEST_POINTS = 3


@dataclass(frozen=True)
class Contact:
    """The room between hull and bank.

    Parameters
    ----------
    gap : expression [m]
        Positive while the hull is clear of both banks.
    lean : expression [m]
        Positive where starboard is the nearer bank, negative where port is.
    parameters : tuple of symbol
        The particulars and outline points that they ask for.
    """

    gap: Expr
    lean: Expr
    parameters: tuple[Expr, ...]


def checked_shape(shape: Any) -> str | Outline:
    """Return the name or the outline of a hull's shape (ours).

    Parameters
    ----------
    shape : str or sequence of pairs of float [m]
        ``corners``, ``midship``, or points (forward, starboard) of an outline.

    Raises
    ------
    InputError
        Where it is neither.
    """
    if isinstance(shape, str):
        if shape not in SHAPES:
            raise InputError(f"contact {shape!r} is unknown{did_you_mean(shape, SHAPES)}, or points of an outline")
        return shape
    try:
        points = tuple((float(forward), float(starboard)) for forward, starboard in shape)
    except (TypeError, ValueError):
        raise InputError("contact: an outline is a list of points (forward, starboard), in metres") from None
    if len(points) < FEWEST_POINTS:
        raise InputError(f"contact: an outline needs {FEWEST_POINTS} points or more; this one has {len(points)}")
    return points


def contact_of(shape: str | int) -> Contact:
    """Write a hull's contact in symbols.

    Parameters
    ----------
    shape : str or int
        ``corners`` of the rectangle around the hull; ``midship``, the paper's clearance; or the number of points
        of an outline.
    """
    width, length, beam = (symbol(name) for name in ("width", "length", "beam"))
    y, c, s = (symbol(name) for name in ("y", "cos_psi", "sin_psi"))
    if shape == "midship":
        return Contact(width / 2 - abs(y) - beam / 2 * c, y, (width, beam))
    if shape == "corners":
        return Contact(width / 2 - abs(y) - length / 2 * abs(s) - beam / 2 * c, y, (width, length, beam))
    points = [tuple(symbol(name) for name in pair) for pair in point_names(int(shape))]
    reaches = [y + (forward * s + starboard * c) for forward, starboard in points]
    corners = tuple(name for pair in points for name in pair)
    furthest = _each(reaches, "larger") + _each(reaches, "smaller")
    return Contact(width / 2 - _each([abs(reach) for reach in reaches], "larger"), furthest, (width, *corners))


def point_names(count: int) -> list[tuple[str, str]]:
    """Name the coordinates of an outline's points (ours).

    Parameters
    ----------
    count : int
        How many points.
    """
    return [(f"forward_{number}", f"starboard_{number}") for number in range(count)]


def _each(values: Sequence[Expr], function: str) -> Expr:
    import sympy

    return reduce(sympy.Function(function, real=True), values)
