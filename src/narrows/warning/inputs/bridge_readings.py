"""Convert the messages of one second to readings of the estimator: along the waterway, from its line, in SI."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from narrows.errors import InputError
from narrows.readers.nmea.nmea_decoder import Entry
from narrows.readers.nmea.nmea_sentences import PARTICULARS, SOURCES, WATER_DEPTH, Values
from narrows.warning.settings import SOURCE_SILENCE, WATERWAY_REACH
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
    draft: float | None  # As the ship reports it [m]
    depth: float | None = None  # [m] of the water by the echo sounder: clearance under the keel plus draft


class Tick(NamedTuple):
    """Messages received since the previous tick."""

    t: float  # Until when [s]
    entries: Sequence[Entry]  # Messages, in order
    faults: dict[str, int]  # Messages that were left out so far, by what is wrong with them
    commands: Sequence[bytes] = ()  # Sentences by which the bridge answers alerts (ACN)


class BridgeReadings:
    """Converts messages to readings along a waterway."""

    def __init__(self, waterway: Waterway, draft: float | None = None) -> None:
        if waterway.origin is None:
            raise InputError(
                f"{waterway.name} has no place on earth, and a bridge reports longitude and latitude; give "
                "its origin, or read it from GeoJSON"
            )
        self.waterway = waterway
        self._chosen: dict[str, tuple[str, int, float]] = {}  # Source, its rank, and the time of its last message [s]
        self._origin, self._along, self._s = np.array(waterway.origin), math.nan, 0.0
        self._last: dict[str, float] = {}
        self._draft: float | None = None
        self._usual_draft = draft
        self._off = 0

    def convert(self, tick: Tick) -> Messages:
        values = self._latest(tick.entries)
        for what in NEEDED:
            self._last.setdefault(what, tick.t)
        depth = self._depth(values.pop(WATER_DEPTH, {}))
        readings = self._place(values.pop("position", {}))
        readings |= self._directions(values) | self._others(values)
        faults = {**tick.faults, **({NOT_HERE: self._off} if self._off else {})}
        return Messages(
            tick.t, readings, {name: tick.t - t for name, t in self._last.items()}, faults, self._draft, depth
        )

    def _latest(self, entries: Sequence[Entry]) -> dict[str, Values]:
        """Last values of each group, from its selected source."""
        values: dict[str, Values] = {}
        for entry in entries:
            for about, columns in entry.message.values.items():
                if not columns or not self._accepts(about, entry.message.source, entry.t):
                    continue
                values[about] = {**values.get(about, {}), **columns}
                self._last[about] = max(entry.t, self._last.get(about, -math.inf))
        self._draft = values.pop(PARTICULARS, {}).get("draft", self._draft)
        return values

    def _depth(self, values: Values) -> float | None:
        draft = self._draft or self._usual_draft
        if "under_keel_clearance" in values and draft is not None:
            return values["under_keel_clearance"] + draft
        return values.get("depth")

    def _place(self, values: Values) -> dict[str, Reading]:
        if not values:
            return {}
        where = projected(np.array([[values["longitude"], values["latitude"]]]), self._origin)
        s, n, along = (float(number[0]) for number in self.waterway.line.placed(where))
        length, reach = self.waterway.line.length, float(self.waterway.section(s).width) + WATERWAY_REACH
        if not (-WATERWAY_REACH < s < length + WATERWAY_REACH and abs(n) < reach):
            self._off += 1
            return {}
        self._along, self._s = along, s
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
