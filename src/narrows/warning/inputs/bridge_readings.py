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

NOT_HERE = "that tell of a place off the waterway"
WATER_LOG, GROUND_LOG = "log", "ground_log"
Reading = float | tuple[float, float]


class Messages(NamedTuple):
    t: float  # Until when [s]
    readings: dict[str, Reading]  # Readings of the last second, by the names of sensors and actuators
    ages: dict[str, float]  # By what was ever told: how long ago [s]
    faults: dict[str, int]  # Messages that were left out so far
    draft: float | None  # As the ship reports it [m]
    depth: float | None = None  # [m] of the water by the echo sounder: clearance under the keel plus draft


class Tick(NamedTuple):
    """All that was told until a time, since the one before."""

    t: float  # Until when [s]
    entries: Sequence[Entry]  # Messages, in order
    faults: dict[str, int]  # Messages that were left out so far, by what is wrong with them
    commands: Sequence[bytes] = ()  # Sentences by which the bridge answers alerts (ACN)


class BridgeReadings:
    """Brings what is told to a waterway."""

    def __init__(self, waterway: Waterway, draft: float | None = None) -> None:
        if waterway.origin is None:
            raise InputError(
                f"{waterway.name} does not know where on earth it is, and a bridge tells longitude and latitude; give "
                "its origin, or read it from GeoJSON"
            )
        self.waterway, self.choice = waterway, SourceSelection()
        self._origin, self._along, self._s = np.array(waterway.origin), math.nan, 0.0
        self._last: dict[str, float] = {}
        self._draft: float | None = None
        self._usual_draft = draft
        self._off = 0

    def heard(self, tick: Tick) -> Messages:
        told = self._latest(tick.entries)
        depth = self._depth(told.pop(WATER_DEPTH, {}))
        readings = self._place(told.pop("position", {}))
        readings |= self._directions(told) | self._others(told)
        faults = {**tick.faults, **({NOT_HERE: self._off} if self._off else {})}
        return Messages(
            tick.t, readings, {name: tick.t - t for name, t in self._last.items()}, faults, self._draft, depth
        )

    def _latest(self, entries: Sequence[Entry]) -> dict[str, Values]:
        """The last that was told of each thing by the one who is believed."""
        told: dict[str, Values] = {}
        for entry in entries:
            for about, values in entry.told.values.items():
                if not values or not self.choice.tells(about, entry.told.source, entry.t):
                    continue
                told[about] = {**told.get(about, {}), **values}
                self._last[about] = max(entry.t, self._last.get(about, -math.inf))
        self._draft = told.pop(PARTICULARS, {}).get("draft", self._draft)
        return told

    def _depth(self, told: Values) -> float | None:
        draft = self._draft or self._usual_draft
        if "under_keel_clearance" in told and draft is not None:
            return told["under_keel_clearance"] + draft
        return told.get("depth")

    def _place(self, told: Values) -> dict[str, Reading]:
        if not told:
            return {}
        where = projected(np.array([[told["longitude"], told["latitude"]]]), self._origin)
        s, n, along = (float(number[0]) for number in self.waterway.line.placed(where))
        length, reach = self.waterway.line.length, float(self.waterway.section(s).width) + WATERWAY_REACH
        if not (-WATERWAY_REACH < s < length + WATERWAY_REACH and abs(n) < reach):
            self._off += 1
            return {}
        self._along, self._s = along, s
        return {"gnss": (s, n)}

    def _directions(self, told: dict[str, Values]) -> dict[str, Reading]:
        """Heading and course from the line, where it is known how the line lies."""
        if not math.isfinite(self._along):
            return {}
        readings: dict[str, Reading] = {}
        if heading := told.get("heading"):
            readings["gyro"] = math.remainder(heading["heading"] - self._along, 2 * math.pi)
        ground = told.get("speed over ground", {})
        if len(ground) == 2:
            course = math.remainder(ground["course_over_ground"] - self._along, 2 * math.pi)
            readings["course"] = (course, ground["speed_over_ground"])
        return readings

    def _others(self, told: dict[str, Values]) -> dict[str, Reading]:
        columns = {"yaw rate": ("r", "rate_of_turn"), "rudder": ("rudder",) * 2, "revolutions": ("revolutions",) * 2}
        readings: dict[str, Reading] = {
            name: told[about][column] for about, (column, name) in columns.items() if column in told.get(about, {})
        }
        water, ground = told.get("speed through the water", {}), told.get("speed over ground", {})
        if "u" in water:
            readings[WATER_LOG] = water["u"]
        elif "speed through the water" not in self._last and "speed_over_ground" in ground:
            readings[GROUND_LOG] = ground["speed_over_ground"] - float(self.waterway.current_at(self._s))
        return readings


class SelectedSource(NamedTuple):
    rank: int  # Rank of the source, the best 0
    source: str  # Who
    t: float  # When it was heard last [s]


class SourceSelection:
    def __init__(self) -> None:
        self.chosen: dict[str, SelectedSource] = {}

    def tells(self, about: str, source: str, t: float) -> bool:
        # The type of its sentence ranks a source; last comes what arrives by other ways.
        types, kind = SOURCES.get(about, ()), source.split()[0][-3:]
        now, rank = self.chosen.get(about), types.index(kind) if kind in types else len(types)
        if now and source != now.source and rank >= now.rank and t - now.t <= SOURCE_SILENCE:
            return False
        self.chosen[about] = SelectedSource(rank, source, t)
        return True
