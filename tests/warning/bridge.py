"""A bridge for tests: a ship along a bend, and the sentences that tell of it."""

from pathlib import Path

import numpy as np
import pyais

import narrows as nw
from logs import angle, antenna_on_earth, bent_waterway, clock, motion, sentence, write_recording

WAY = bent_waterway()
KNOT = 1852 / 3600
STAMP = 1_777_680_000


def told_at(t: float, **changed: float) -> list[str]:
    """What is told in a second: position, heading, rate of turn, log, rudder."""
    told = {name: np.array([value]) for name, value in {**motion(np.array(t)), **changed}.items()}
    earth = antenna_on_earth(WAY, told, (0.0, 0.0))
    place = f"{angle(earth['lat'][0], 'NS')},{angle(earth['lon'][0], 'EW')}"
    return [
        sentence(f"GPGGA,{clock(t % 86400)},{place},1,08,0.9,5.4,M,46.9,M,,"),
        sentence(f"HEHDT,{earth['HDG [deg]'][0]:.4f},T"),
        sentence("TIROT,-6.0,A"),
        sentence("VDVBW,7.5,-0.2,A,7.9,-0.1,A,,V,,V"),
        sentence(f"GPVTG,{earth['HDG [deg]'][0]:.2f},T,,M,7.9,N,14.6,K,A"),
        sentence(f"IIRSA,{np.degrees(told['rudder'][0]):.5f},A,,V"),
    ]


def stamped(seconds: int, start: int = 0) -> list[str]:
    """A recording whose logger wrote the time before every line."""
    return [f"\\c:{STAMP + t}*00\\{line}" for t in range(start, start + seconds) for line in told_at(float(t))]


def ais(kind: str, mmsi: int, **told: float | str) -> list[str]:
    """A message as pyais encodes it."""
    usual = {"type": 1, "lon": 5.0, "lat": 52.0, "speed": 7.4, "course": 10.0, "heading": 12, "turn": 20.0}
    return [
        str(line) for line in pyais.encode_dict({**usual, "mmsi": mmsi, **told}, talker_id="AI", sentence_type=kind)
    ]


def recorded(path: Path, lines: list[str]) -> Path:
    return write_recording(path, lines)


def nowhere() -> nw.Waterway:
    """A canal that does not know where on earth it is."""
    return nw.straight_waterway(nw.Canal(300.0, 16.0), 5000.0)
