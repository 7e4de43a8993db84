"""The sentences by which a bridge tells of its ship: what a simulated one says, and a recording of it holds."""

import math
from collections.abc import Mapping
from datetime import UTC, datetime

import numpy as np

from narrows.quantities.constants import KNOT
from narrows.readers.nmea.nmea_lines import with_checksum
from narrows.waterway.projection import unprojected
from narrows.waterway.waterway import Waterway


def bridge_sentences(waterway: Waterway, at: Mapping[str, float], since_1970: float) -> list[str]:
    """Return what is told in a second: position, course, heading, rate of turn, log, rudder."""
    # at [m]; since_1970 [s]
    east_north, heading = waterway.to_map(at["x"], at["y"], at["psi"])
    longitude, latitude = unprojected(np.reshape(east_north, (1, 2)), np.array(waterway.origin))[0]
    line = float(heading) - at["psi"]
    clock = datetime.fromtimestamp(since_1970, UTC)
    place = f"{_minutes(latitude, 'NS', 2)},{_minutes(longitude, 'EW', 3)}"
    bodies = (
        f"GPZDA,{clock:%H%M%S}.{clock.microsecond // 10_000:02d},{clock:%d,%m,%Y},00,00",
        f"GPGGA,{clock:%H%M%S}.{clock.microsecond // 10_000:02d},{place},1,12,0.8,20.0,M,45.0,M,,",
        f"GPVTG,{_degrees(line + at['course']):.2f},T,,M,{at['speed'] / KNOT:.3f},N,{3.6 * at['speed']:.3f},K,A",
        f"HEHDT,{_degrees(float(heading)):.2f},T", f"TIROT,{60 * math.degrees(at['r']):.2f},A",
        f"VDVBW,{at['u'] / KNOT:.3f},,A,,,V,,V,,V", f"IIRSA,{math.degrees(at['rudder']):.2f},A,,V",
    )  # fmt: skip
    return [with_checksum(body) for body in bodies]


def _degrees(angle: float) -> float:
    return math.degrees(angle) % 360.0


def _minutes(degrees: float, sides: str, width: int) -> str:
    """A latitude or longitude as sentences write it, to two millimetres."""
    whole, minutes = divmod(abs(degrees) * 60.0, 60.0)
    return f"{int(whole):0{width}d}{minutes:09.6f},{sides[int(degrees < 0)]}"
