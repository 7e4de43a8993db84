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
from narrows.warning.forecasting.forecast import Tracks
from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
from narrows.warning.monitoring.bridge_status import BridgeStatus, alert_to_dict
from narrows.warning.settings import MOST_CLIENTS, SEND_INTERVAL, SEND_TIMEOUT
from narrows.waterway.waterway import Waterway

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


def refusal(sentence: str) -> dict[str, Any]:
    return {"kind": "refused", "sentence": sentence}


def ending(sentence: str) -> dict[str, Any]:
    return {"kind": "ended", "sentence": sentence}


def packed(message: Mapping[str, Any]) -> str:
    return json.dumps(plain(message), separators=(",", ":"), allow_nan=False)


# The page draws the ship, the banks about it, and its forecast tracks, in metres east and north.
# Length of bank drawn astern and ahead of the ship, and distance between points [m].
ASTERN, AHEAD, EVERY = 800.0, 2400.0, 20.0
SIDES = (-1, 1)
# Columns of (north, east [m], heading [rad]) for a point, and for a pose.
POINT, POSE = slice(2), slice(3)


def scene(monitored: BridgeMonitor, status: BridgeStatus) -> dict[str, Any] | None:
    """Return what the page draws, points as [north, east] [m]; None until the position is known."""
    if not status.estimate.ready:
        return None
    way, ship, now = monitored.waterway, monitored.model.configuration.ship, status.estimate.values
    pose, along = np.array([now["x"], now["y"], now["psi"]]), min(max(now["x"], 0.0), way.line.length)
    fan, middle = _drawable(status), np.array([along, float(way.keel_section(along, ship.draft).middle), 0.0])
    own = {"pose": pose[None], "middle": middle[None]}
    lines = {**own, **_banks(way, along, None), **_banks(way, along, ship.draft), **(_tracks(pose, fan) if fan else {})}
    drawn = _on_map(way, lines)
    return {
        "ship": {"pose": _rounded(drawn["pose"], POSE)[0], "length": ship.length, "beam": ship.beam},
        "middle": _rounded(drawn["middle"], POSE)[0],
        **{name: [_rounded(drawn[f"{name} {side}"], POINT) for side in SIDES] for name in ("banks", "limits")},
        "fan": _fan(drawn, fan) if fan else None,
    }


def _drawable(status: BridgeStatus) -> Tracks | None:
    """Tracks of what can be drawn: a ship that diverges has no place."""
    tracks = status.forecast.tracks if status.forecast else None
    if tracks is None or not np.isfinite([tracks.as_is, tracks.escape]).all():
        return None
    return tracks._replace(fan=tracks.fan[np.isfinite(tracks.fan).all(axis=(1, 2))])


def _banks(way: Waterway, along: float, draft: float | None) -> dict[str, np.ndarray]:
    first, last = max(along - ASTERN, 0.0), min(along + AHEAD, way.line.length)
    s = np.linspace(first, last, max(2, round((last - first) / EVERY) + 1))
    name, here = ("banks", way.section(s)) if draft is None else ("limits", way.keel_section(s, draft))
    off = {side: here.middle + side * here.width / 2 for side in SIDES}
    return {f"{name} {side}": np.stack([s, off[side], np.zeros_like(s)], axis=1) for side in SIDES}


def _tracks(pose: np.ndarray, tracks: Tracks) -> dict[str, np.ndarray]:
    members = np.insert(tracks.fan, 0, pose, axis=1)
    return {"members": members.reshape(-1, 3), "likely": tracks.as_is, "escape": tracks.escape}


def _on_map(way: Waterway, lines: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """All at once: north, east [m], heading [rad] of each."""
    places, headings = way.to_map(*np.concatenate(list(lines.values())).T)
    drawn = np.concatenate([places[:, ::-1], headings[:, None]], axis=1)
    stops = np.cumsum([len(line) for line in lines.values()])[:-1]
    return dict(zip(lines, np.split(drawn, stops), strict=True))


def _fan(drawn: Mapping[str, np.ndarray], tracks: Tracks) -> dict[str, Any]:
    members = drawn["members"].reshape(len(tracks.fan), -1, 3)
    return {
        "times": tracks.times.tolist(),
        "members": [_rounded(member, POINT) for member in members],
        **{name: _rounded(drawn[name], POSE) for name in ("likely", "escape")},
    }


def _rounded(line: np.ndarray, part: slice) -> list[list[float]]:
    """Round to a decimetre and to a ten-thousandth of a radian."""
    return (np.round(line * [10.0, 10.0, 1e4]) / [10.0, 10.0, 1e4])[:, part].tolist()  # type: ignore[no-any-return]


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
