"""Logs for tests: a ship in a bend as its sensors would record it, and sentences of NMEA 0183."""

from collections.abc import Mapping
from functools import reduce
from operator import xor
from pathlib import Path

import numpy as np
import pandas as pd

import narrows as nw
from narrows.waterway import Bank, Centreline

Told = Mapping[str, np.ndarray]


def bent_waterway(radius: float = 3000.0, length: float = 4000.0) -> nw.Waterway:
    """A bend to starboard of constant radius, 300 m wide, at 5 E, 52 N."""
    turned = np.linspace(0.0, length / radius, 60)
    points = radius * np.stack([1 - np.cos(turned), np.sin(turned)], axis=1)
    ends, half = np.array([0.0, length]), np.full(2, 150.0)
    return nw.Waterway(
        Centreline(points), Bank("starboard", ends, half), Bank("port", ends, half), (ends, np.full(2, 16.0)),
        name="bend", origin=(5.0, 52.0),
    )  # fmt: skip


def motion(t: np.ndarray) -> dict[str, np.ndarray]:
    """A smooth way along a waterway: place, heading to it, and where the rudder was."""
    return {
        "x": 300.0 + 4.0 * t, "y": 12.0 * np.sin(t / 60.0), "psi": 0.05 * np.sin(t / 45.0 + 0.3),
        "rudder": 0.1 * np.sin(t / 30.0),
    }  # fmt: skip


def antenna_on_earth(waterway: nw.Waterway, told: Told, antenna: tuple[float, float]) -> pd.DataFrame:
    """Longitude and latitude of an antenna, and the heading from north [deg], of a ship along a waterway."""
    from narrows.waterway.projection import unprojected

    positions, heading = waterway.to_map(told["x"], told["y"], told["psi"])
    ahead = np.stack([np.sin(heading), np.cos(heading)], axis=1)
    starboard = np.stack([ahead[:, 1], -ahead[:, 0]], axis=1)
    degrees = unprojected(positions + antenna[0] * ahead + antenna[1] * starboard, np.array(waterway.origin))
    return pd.DataFrame({"lon": degrees[:, 0], "lat": degrees[:, 1], "HDG [deg]": np.degrees(heading) % 360})


def sentence(body: str) -> str:
    """A sentence with its checksum."""
    return f"${body}*{reduce(xor, body.encode(), 0):02X}"


def angle(degrees: float, sides: str) -> str:
    """A latitude or longitude as sentences write it, to a hundredth of a millimetre."""
    whole, minutes = divmod(abs(degrees) * 60, 60)
    width = 2 if sides == "NS" else 3
    return f"{int(whole):0{width}d}{minutes:011.8f},{sides[int(degrees < 0)]}"


def clock(seconds: float) -> str:
    """Of the day, as sentences write it."""
    return f"{int(seconds // 3600):02d}{int(seconds % 3600 // 60):02d}{seconds % 60:05.2f}"


def write_recording(path: Path, lines: list[str]) -> Path:
    path.write_bytes("".join(f"{line}\r\n" for line in lines).encode("ascii"))
    return path
