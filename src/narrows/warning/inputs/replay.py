"""A recording replayed in the order of its times, at the requested speed."""

import heapq
import math
import time
from collections.abc import Iterable, Iterator
from itertools import count
from pathlib import Path

from narrows.readers.nmea.nmea_decoder import Entry, Recording
from narrows.warning.inputs.bridge_readings import Tick
from narrows.warning.settings import LATE, LONGEST_SILENCE, PERIOD


class Replay:
    def __init__(self, path: Path, speed: float = math.inf, mmsi: int | None = None) -> None:
        self.recording, self.speed = Recording(path, mmsi), speed

    def ticks(self) -> Iterator[Tick]:
        """Yield the messages second by second; times count from 1970 if the recording has dates."""
        for tick in paced(by_second(in_order(self._entries())), self.speed):
            yield tick._replace(faults=dict(self.recording.faults))

    def _entries(self) -> Iterator[Entry]:
        for entry in self.recording.entries():
            yield entry._replace(t=entry.t + (self.recording.clock.begin or 0.0))


def in_order(entries: Iterable[Entry], late: float = LATE) -> Iterator[Entry]:
    waiting: list[tuple[float, str, int, Entry]] = []
    numbers, newest, last = count(), -math.inf, -math.inf
    recent: set[tuple[float, str, str]] = set()

    def ready(before: float) -> Iterator[Entry]:
        nonlocal last, recent
        while waiting and waiting[0][0] <= before:
            entry = heapq.heappop(waiting)[-1]
            if entry.t > last:
                recent, last = set(), entry.t
            key = (entry.t, entry.message.source, repr(entry.message))
            if key not in recent:
                recent.add(key)
                yield entry

    for entry in entries:
        if entry.t >= last:
            heapq.heappush(waiting, (entry.t, entry.message.source, next(numbers), entry))
        newest = max(newest, entry.t)
        yield from ready(newest - late)
    yield from ready(math.inf)


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
