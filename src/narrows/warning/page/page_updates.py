"""Messages of the page: what is known, as JSON; its schema is `messages.json` beside this file."""

import asyncio
import json
import math
import time
from collections import deque
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

import numpy as np

from narrows.results import plain
from narrows.warning.alerts.alert import Command
from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
from narrows.warning.monitoring.watched_transit import BridgeStatus, alert_to_dict
from narrows.warning.settings import MOST_CLIENTS, SEND_INTERVAL, SEND_TIMEOUT
from narrows.waterway.waterway import Section

# Commands of the page, by the word in its messages.
COMMANDS = {"acknowledge": Command.ACKNOWLEDGE, "silence": Command.SILENCE}


def update_of(monitored: BridgeMonitor, status: BridgeStatus, since_1970: float) -> dict[str, Any]:
    names = {"ship": monitored.model.configuration.ship.name or "A ship", "waterway": monitored.waterway.name}
    alerts = [
        {
            **alert_to_dict(alert), "sounds": alert.sounds,
            "may": [name for name, command in COMMANDS.items() if alert.commanded(command, status.t) is not None],
        }
        for alert in status.alerts
    ]  # fmt: skip
    parts = {"alerts": alerts, "scene": scene(monitored, status)}
    return {"kind": "update", "at": since_1970, **names, **status.to_dict(), **parts}


def packed(message: Mapping[str, Any]) -> str:
    return json.dumps(plain(message), separators=(",", ":"), allow_nan=False)


# The page draws the ship, the banks about it, and its forecast tracks, in metres east and north.
# Length of bank drawn astern and ahead of the ship, and distance between points [m].
ASTERN, AHEAD, EVERY = 800.0, 2400.0, 20.0
# Digits that are sent: a decimetre north and east, a ten-thousandth of a radian.
DIGITS = np.array([10.0, 10.0, 1e4])


def scene(monitored: BridgeMonitor, status: BridgeStatus) -> dict[str, Any] | None:
    """Return what the page draws, points as [north, east] [m], poses with a heading [rad]; None without a position."""
    if not status.estimate.ready:
        return None
    way, ship, now = monitored.waterway, monitored.model.configuration.ship, status.estimate.values
    pose, along = [now[name] for name in ("x", "y", "psi")], min(max(now["x"], 0.0), way.line.length)
    first, last = max(along - ASTERN, 0.0), min(along + AHEAD, way.line.length)
    s = np.linspace(first, last, max(2, round((last - first) / EVERY) + 1))

    def drawn(place: Any, offset: Any, psi: Any = 0.0) -> Any:
        positions, headings = way.to_map(place, offset, psi)
        poses = np.concatenate([positions[..., ::-1], headings[..., None]], axis=-1)
        return np.round(poses * DIGITS) / DIGITS

    def sides(here: Section) -> list[Any]:
        return [drawn(s, here.middle + side * here.width / 2)[:, :2].tolist() for side in (-1, 1)]

    fan, tracks = None, status.forecast.tracks if status.forecast else None
    if tracks is not None and np.isfinite([tracks.as_is, tracks.escape]).all():
        whole = tracks.fan[np.isfinite(tracks.fan).all(axis=(1, 2))]  # A ship that diverges has no place.
        fan = {
            "times": tracks.times.tolist(),
            "members": drawn(*np.moveaxis(np.insert(whole, 0, pose, axis=1), -1, 0))[..., :2].tolist(),
            "likely": drawn(*tracks.as_is.T).tolist(), "escape": drawn(*tracks.escape.T).tolist(),
        }  # fmt: skip
    return {
        "ship": {"pose": drawn(*pose).tolist(), "length": ship.length, "beam": ship.beam},
        "middle": drawn(along, way.keel_section(along, ship.draft).middle).tolist(),
        "banks": sides(way.section(s)), "limits": sides(way.keel_section(s, ship.draft)), "fan": fan,
    }  # fmt: skip


Send = Callable[[str], Awaitable[None]]


class Clients:
    """Who look on: each receives the newest message, at its own pace, and answers to it alone."""

    def __init__(self, lasts: float = math.inf) -> None:
        self.lasts, self.newest, self.number, self.count = lasts, "", 0, 0
        self._at = -math.inf

    def __len__(self) -> int:
        return self.count

    @property
    def full(self) -> bool:
        return self.count >= MOST_CLIENTS

    def publish(self, message: str) -> None:
        """Leave the newest message, in any thread, without waiting for anything."""
        self.newest, self.number, self._at = message, self.number + 1, time.monotonic()

    async def serve(self, answers: deque[str], send: Send) -> None:
        """Send answers and the newest message as they come; looking for them needs no wake-up from other threads."""
        sent = 0
        self.count += 1
        try:
            while True:
                while answers:
                    await asyncio.wait_for(send(answers.popleft()), SEND_TIMEOUT)
                if sent != self.number and time.monotonic() - self._at <= self.lasts:
                    sent = self.number
                    await asyncio.wait_for(send(self.newest), SEND_TIMEOUT)
                await asyncio.sleep(SEND_INTERVAL)
        finally:
            self.count -= 1
