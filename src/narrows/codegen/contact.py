"""Where hull and bank meet: the room between them, and the side that is nearer, in lines."""

from collections.abc import Sequence

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Lines, greatest, least, real
from narrows.codegen.shapes import CORNERS, MIDSHIP, point_names


def reaches(lines: Lines, contact: str | int, cosine: Expr, sine: Expr) -> tuple[Expr, Expr]:
    """Write how far a hull reaches athwart the canal to starboard and to port of midship [m]."""
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
    """Write the room between a hull and the nearer bank, and how much more there is to port than to starboard [m]."""
    # walls [m]; reach [m]; y [m]
    starboard = lines.put("room_starboard", walls[0] - y - reach[0])
    port = lines.put("room_port", walls[1] + y - reach[1])
    return lines.put("room_bank", least(starboard, port)), lines.put("lean", port - starboard)
