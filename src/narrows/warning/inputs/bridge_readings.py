"""Convert messages to readings of the estimator, along the waterway and in SI; replay a recording second by second."""

import heapq
import math
import time
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, count
from pathlib import Path
from typing import NamedTuple

import numpy as np

from narrows.base.errors import InputError
from narrows.readers.nmea import SOURCES, WATER_DEPTH, Entry, Recording, Values
from narrows.warning.alerts.alert import AlertCommand
from narrows.warning.settings import LATE, LONGEST_SILENCE, PERIOD, SOURCE_SILENCE, WATERWAY_REACH
from narrows.waterway.map_lines import projected
from narrows.waterway.waterway import Waterway

NOT_HERE = "that give a place off the waterway"
WATER_LOG, GROUND_LOG = "log", "ground_log"
# Groups that a forecast needs.
NEEDED = ("position", "heading", "rudder")
Reading = float | tuple[float, float]


class Messages(NamedTuple):
    t: float  # Until when [s]
    readings: dict[str, Reading]  # Readings of the last second, by the names of sensors and actuators
    # Age of the last message of each group [s]; of a needed one since the first tick, where there was none
    ages: dict[str, float]
    faults: dict[str, int]  # Messages that were left out so far
    depth: float | None = None  # Depth of the water by the echo sounder: clearance under the keel plus draft [m]


class Tick(NamedTuple):
    """Messages received since the previous tick."""

    t: float  # Until when [s]
    entries: Sequence[Entry]  # Messages, in order
    faults: dict[str, int]  # Messages that were left out so far, by what is wrong with them
    commands: Sequence[AlertCommand] = ()  # By which the bridge answers alerts (ACN)


class BridgeReadings:
    def __init__(self, waterway: Waterway, draft: float) -> None:
        if waterway.origin is None:
            raise InputError(
                f"{waterway.name} has no place on earth, and a bridge reports longitude and latitude; give "
                "its origin, or read it from GeoJSON"
            )
        self.waterway, self._origin, self._draft = waterway, np.array(waterway.origin), draft
        self._chosen: dict[str, tuple[str, int, float]] = {}  # Source, its rank, and the time of its last message [s]
        self._along, self._s, self._off = math.nan, 0.0, 0
        self._last: dict[str, float] = {}

    def convert(self, tick: Tick) -> Messages:
        values = self._latest(tick.entries)
        for what in NEEDED:
            self._last.setdefault(what, tick.t)
        water = values.pop(WATER_DEPTH, {})
        depth = water.get("depth", water.get("under_keel_clearance", math.nan) + self._draft) if water else None
        readings = self._place(values.pop("position", {})) | self._directions(values) | self._others(values)
        faults = {**tick.faults, **({NOT_HERE: self._off} if self._off else {})}
        ages = {name: tick.t - t for name, t in self._last.items()}
        return Messages(tick.t, readings, ages, faults, depth)

    def _latest(self, entries: Sequence[Entry]) -> dict[str, Values]:
        values: dict[str, Values] = {}
        for entry in entries:
            for about, columns in entry.message.values.items():
                if columns and self._accepts(about, entry.message.source, entry.t):
                    values[about] = {**values.get(about, {}), **columns}
                    self._last[about] = max(entry.t, self._last.get(about, -math.inf))
        return values

    def _place(self, values: Values) -> dict[str, Reading]:
        if not values:
            return {}
        where = projected(np.array([[values["longitude"], values["latitude"]]]), self._origin)
        s, n = (float(number[0]) for number in self.waterway.line.locate(where))
        length, here = self.waterway.line.length, self.waterway.section(s)
        beyond = abs(n - float(here.middle)) - float(here.width) / 2
        if not (-WATERWAY_REACH < s < length + WATERWAY_REACH and beyond < WATERWAY_REACH):
            self._off += 1
            return {}
        self._along, self._s = float(self.waterway.line.heading(s)), s
        return {"gnss": (s, n)}

    def _directions(self, values: dict[str, Values]) -> dict[str, Reading]:
        """Heading and course from the line, where it is known how the line lies."""
        if not math.isfinite(self._along):
            return {}
        readings: dict[str, Reading] = {}
        if heading := values.get("heading"):
            readings["gyro"] = math.remainder(heading["heading"] - self._along, 2 * math.pi)
        ground = values.get("speed over ground", {})
        if len(ground) == 2:
            course = math.remainder(ground["course_over_ground"] - self._along, 2 * math.pi)
            readings["course"] = (course, ground["speed_over_ground"])
        return readings

    def _others(self, values: dict[str, Values]) -> dict[str, Reading]:
        columns = {"yaw rate": ("r", "rate_of_turn"), "rudder": ("rudder",) * 2, "revolutions": ("revolutions",) * 2}
        readings: dict[str, Reading] = {
            name: values[about][column] for about, (column, name) in columns.items() if column in values.get(about, {})
        }
        water, ground = values.get("speed through the water", {}), values.get("speed over ground", {})
        if "u" in water:
            readings[WATER_LOG] = water["u"]
        elif "speed through the water" not in self._last and "speed_over_ground" in ground:
            readings[GROUND_LOG] = ground["speed_over_ground"] - float(self.waterway.current_at(self._s))
        return readings

    def _accepts(self, about: str, source: str, t: float) -> bool:
        # The type of its sentence ranks a source; last comes what arrives by other ways.
        types, kind = SOURCES.get(about, ()), source.split()[0][-3:]
        rank = types.index(kind) if kind in types else len(types)
        chosen, best, last = self._chosen.get(about, (source, rank, t))
        if source != chosen and rank >= best and t - last <= SOURCE_SILENCE:
            return False
        self._chosen[about] = source, rank, t
        return True


def replay(path: Path, speed: float = math.inf, mmsi: int | None = None) -> Iterator[Tick]:
    """Return the messages of a recording second by second; times count from 1970 if it has dates."""
    recording = Recording(path, mmsi)
    entries = (entry._replace(t=entry.t + (recording.clock.begin or 0.0)) for entry in recording.entries())
    return (tick._replace(faults=dict(recording.decoder.faults)) for tick in paced(by_second(in_order(entries)), speed))


def in_order(entries: Iterable[Entry]) -> Iterator[Entry]:
    """Yield entries by time, each once; what is later than ``LATE`` is left out."""
    waiting, numbers, recent = list[tuple[float, str, int, Entry]](), count(), set[str]()
    newest = last = -math.inf
    for entry in chain(entries, (None,)):
        if entry and entry.t >= last:
            heapq.heappush(waiting, (entry.t, entry.message.source, next(numbers), entry))
        newest = max(newest, entry.t) if entry else math.inf
        while waiting and waiting[0][0] <= newest - LATE:
            first = heapq.heappop(waiting)[-1]
            recent = recent if first.t == last else set()
            last = first.t
            if repr(first.message) not in recent:
                recent.add(repr(first.message))
                yield first


def by_second(entries: Iterable[Entry]) -> Iterator[Tick]:
    until, messages = -math.inf, list[Entry]()
    for entry in entries:
        second = math.ceil(entry.t / PERIOD) * PERIOD
        if second > until and math.isfinite(until):
            yield Tick(until, messages, {})
            messages = []
            while second - until > PERIOD and second - until <= LONGEST_SILENCE:
                until += PERIOD
                yield Tick(until, (), {})
        until = max(until, second)
        messages.append(entry)
    if messages:
        yield Tick(until, messages, {})


def paced(ticks: Iterable[Tick], speed: float) -> Iterator[Tick]:
    began: tuple[float, float] | None = None
    for tick in ticks:
        began = began or (time.monotonic(), tick.t)
        if math.isfinite(speed):
            time.sleep(max(0.0, began[0] + (tick.t - began[1]) / speed - time.monotonic()))
        yield tick
