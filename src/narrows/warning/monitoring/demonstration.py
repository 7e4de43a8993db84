"""A demonstration: a transit with a mistake at the helm beside a bank, so that anyone sees a monitor at work."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from narrows.identification.fitting import bundled_ship
from narrows.model.model import Model
from narrows.model.tables import table_named
from narrows.quantities.names import KNOT
from narrows.readers.nmea import Entry, NmeaDecoder, checksum, sentences, with_checksum
from narrows.simulation.controllers import ORDER_TOLERANCE, VoyageState
from narrows.simulation.voyage import Voyage, simulate
from narrows.warning.inputs.bridge_readings import Tick
from narrows.waterway import Bank, Centreline
from narrows.waterway.map_lines import unprojected
from narrows.waterway.waterway import Waterway

# Length of the ship, width and depth of the canal [m]; speed [m/s]; offset held [m]: as the tests, scaled.
LENGTH, WIDTH, DEPTH, SPEED, LINE = 230.0, 368.0, 16.2, 4.2, 30.0
# Radius and start of the bend, and distance between the points of the line [m].
RADIUS, BEND, STEP = 5000.0, 2500.0, 20.0
# Length of the transit [s]; the rudder on the wrong side, and hard over to the other side too late: pairs [s], [deg].
DURATION, RUDDER = 330.0, ((40.0, 27.0), (120.0, -35.0))
TERMS, ORIGIN = "speed+helm", (9.5, 54.2)
BEGAN = datetime(2026, 5, 2, 8, tzinfo=UTC).timestamp()


@dataclass(frozen=True)
class Demonstration:
    model: Model  # The ship
    waterway: Waterway  # The canal, with its place on earth
    voyage: Voyage  # Voyage in steps of a second, along the canal

    def seconds(self) -> Iterator[tuple[float, list[str]]]:
        random, voyage = np.random.default_rng(seed=0), self.voyage
        for row, t in enumerate(voyage.t):
            now = {name: float(voyage[name][row]) for name in ("x", "y", "psi", "r", "u", "rudder")}
            v = float(voyage.v[row])
            now |= {"course": now["psi"] + math.atan2(v, now["u"]), "speed": math.hypot(now["u"], v)}
            measured = {name: value + NOISE[name] * random.standard_normal() for name, value in now.items()}
            yield BEGAN + float(t), bridge_sentences(self.waterway, measured, BEGAN + float(t))

    def recording(self) -> bytes:
        """Return what a logger would have written, its times before the sentences."""
        lines = []
        for t, texts in self.seconds():
            body = f"c:{t:.0f}"  # The block before a sentence with the logger's time (IEC 61162-450)
            lines += [f"\\{body}*{checksum(body.encode()):02X}\\{line}" for line in texts]
        return "".join(lines).encode("ascii")

    def ticks(self) -> Iterator[Tick]:
        decoder = NmeaDecoder()
        for t, texts in self.seconds():
            lines = [line.encode("ascii") for line in texts]
            decoded = [decoder.decode(one) for one in sentences(lines, decoder.faults)]
            yield Tick(t, [Entry(t, one) for one in decoded if one is not None], dict(decoder.faults))


def demonstration() -> Demonstration:
    """Return the demonstration: a 230 m container ship in a canal 368 m wide."""
    model, way = bundled_ship(LENGTH, WIDTH, DEPTH, table_named(TERMS)), demonstrated_canal()
    voyage = simulate(model, x=300.0, y=LINE, u=SPEED, controller=_order, waterway=way, duration=DURATION, dt=1.0)
    return Demonstration(model, way, voyage)


def _order(t: float, state: VoyageState) -> float:
    return math.radians([0.0, *(angle for begin, angle in RUDDER if t + ORDER_TOLERANCE >= begin)][-1])


def demonstrated_canal() -> Waterway:
    s = np.arange(0.0, 6001.0, STEP)
    heading = np.concatenate([[0.0], np.cumsum(np.where(s[1:] > BEND, STEP / RADIUS, 0.0))])
    line = Centreline(np.cumsum(STEP * np.stack([np.sin(heading), np.cos(heading)], axis=1), axis=0))
    ends, half = np.array([0.0, line.length]), np.full(2, WIDTH / 2)
    banks = Bank("starboard", ends, half), Bank("port", ends, half)
    return Waterway(line, *banks, (ends, np.full(2, DEPTH)), name="the canal of the demonstration", origin=ORIGIN)


# Standard deviations of the sensors, in SI.
NOISE = {
    "x": 1.0, "y": 1.0, "psi": math.radians(0.2), "r": math.radians(0.03), "u": 0.05, "course": 0.01, "speed": 0.05,
    "rudder": math.radians(0.2),
}  # fmt: skip


# Sentences of a simulated bridge, as a recording of it has them.
def bridge_sentences(waterway: Waterway, at: Mapping[str, float], since_1970: float) -> list[str]:
    """Return the sentences of one second: position, course, heading, rate of turn, log, rudder."""
    east_north, heading = waterway.to_map(at["x"], at["y"], at["psi"])
    longitude, latitude = unprojected(np.reshape(east_north, (1, 2)), np.array(waterway.origin))[0]
    course = math.degrees(float(heading) - at["psi"] + at["course"]) % 360.0
    clock = datetime.fromtimestamp(since_1970, UTC)
    place = f"{_minutes(latitude, 'NS', 2)},{_minutes(longitude, 'EW', 3)}"
    bodies = (
        f"GPZDA,{clock:%H%M%S}.{clock.microsecond // 10_000:02d},{clock:%d,%m,%Y},00,00",
        f"GPGGA,{clock:%H%M%S}.{clock.microsecond // 10_000:02d},{place},1,12,0.8,20.0,M,45.0,M,,",
        f"GPVTG,{course:.2f},T,,M,{at['speed'] / KNOT:.3f},N,{3.6 * at['speed']:.3f},K,A",
        f"HEHDT,{math.degrees(heading) % 360.0:.2f},T", f"TIROT,{60 * math.degrees(at['r']):.2f},A",
        f"VDVBW,{at['u'] / KNOT:.3f},,A,,,V,,V,,V", f"IIRSA,{math.degrees(at['rudder']):.2f},A,,V",
    )  # fmt: skip
    return [with_checksum(body) for body in bodies]


def _minutes(degrees: float, sides: str, width: int) -> str:
    """A latitude or longitude as sentences write it, to two millimetres."""
    whole, minutes = divmod(abs(degrees) * 60.0, 60.0)
    return f"{int(whole):0{width}d}{minutes:09.6f},{sides[int(degrees < 0)]}"
