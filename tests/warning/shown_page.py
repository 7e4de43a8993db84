"""A page to look at without an engine: a ship that is said to be somewhere, and updates that come until stopped."""

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from threading import Event, Thread
from types import SimpleNamespace
from typing import Any

import numpy as np
from transit import canal

import narrows as nw
from narrows.estimation.states import Estimate, Gaussian, StateNames
from narrows.warning.alerts.alert import BANKS, AlertDesk, Condition, Priority, Situation
from narrows.warning.forecasting.forecaster import BankForecast, Escape, LikelyRun, Tracks
from narrows.warning.monitoring.watched_transit import BridgeStatus, clearances
from narrows.warning.page.bridge_page import BridgePage

BANK = BANKS["starboard"]
ALARM = {BANK: Condition(Priority.ALARM, "14 s to act: bank to starboard. Hard to port, then steady")}
HANDSHAKE = (
    "GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}Upgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
FAN_MEMBERS = 32
STATES = ("x", "y", "psi", "u", "v", "r")
SHIP = nw.Ship(name="A ship", length=230.0, beam=32.2, draft=10.8, block_coefficient=0.65)
NOW = {"x": 3200.0, "y": 60.0, "psi": 0.05, "u": 4.2, "v": 0.0, "r": 0.001}


def estimate(t: float, now: Mapping[str, float] | None = NOW) -> Estimate:
    normal = Gaussian(np.array([now[name] for name in STATES]), np.eye(len(STATES))) if now else None
    return Estimate(t, StateNames(STATES), normal, now is not None, {})


def forecast(
    contact: float = math.inf, last_chance: float = math.inf, unattended: float = 0.4, wrong_order: float = 50.0
) -> BankForecast:
    side = "starboard" if math.isfinite(contact) else ""
    escape = Escape("then steady parallel to the bank", math.radians(-35), math.radians(35), 21.0)
    likely = LikelyRun(contact, side, last_chance)
    chances = (0.0, 1.0, unattended, 0.3) if math.isfinite(contact) else (0.0, 0.0, unattended, 0.0)
    return BankForecast(
        0.0, likely, last_chance, *chances, wrong_order, escape, 0.1, -0.3, math.radians(35), tracks()
    )  # fmt: skip


def tracks() -> Tracks:
    """Straight on, a little apart."""
    times, now = np.arange(5.0, 121.0, 5.0), NOW
    off = np.linspace(-0.3, 0.3, FAN_MEMBERS)[:, None]
    x, ones = now["x"] + now["u"] * times, np.ones(len(times))
    fan = np.stack([x * np.ones_like(off), now["y"] + off * times, now["psi"] + 0 * off * times], axis=-1)
    likely = np.stack([x, now["y"] * ones, now["psi"] * ones], axis=-1)
    return Tracks(times, fan, likely, likely.copy())


class Watched:
    """What a monitor is to its page."""

    def __init__(self) -> None:
        self.model, self.waterway = SimpleNamespace(configuration=SimpleNamespace(ship=SHIP)), canal()
        self.desk, self.t = AlertDesk(), 0.0

    def status(
        self, told: BankForecast | None = None, now: Mapping[str, float] | None = NOW,
        conditions: Mapping[Situation, Condition] | None = None,
    ) -> BridgeStatus:  # fmt: skip
        """A second later."""
        self.t += 1.0
        changed, known = self.desk.update(self.t, conditions or {}), estimate(self.t, now)
        room = clearances(SHIP, self.waterway, known)
        why = "" if told else "Sensors have been silent for too long."
        return BridgeStatus(self.t, known, told, self.desk.alerts, tuple(changed), room, {}, why)


class Pulse:
    """Tells the page the same again and again, as a monitor does, until it is stopped."""

    def __init__(self, page: BridgePage, monitored: Watched) -> None:
        self.page, self.monitored, self.address = page, monitored, ""
        self.status, self.beats = monitored.status(forecast()), True
        self._stop = Event()

    def run(self) -> None:
        while not self._stop.wait(0.1):
            if self.beats:
                self.page.publish(self.monitored, self.status, time.time())

    @contextmanager
    def running(self) -> Iterator["Pulse"]:
        thread = Thread(target=self.run, daemon=True)
        thread.start()
        yield self
        self._stop.set()
        thread.join()


def asked(page: BridgePage, monitored: Watched) -> list[Any]:
    """Do what was asked for on the page, as the next update of a monitor does; the alerts that changed."""
    commands = page.requests.commands(monitored.desk, monitored.t)
    return [monitored.desk.command(monitored.t, *command) for command in commands]


def soon(ask: Callable[[], Any]) -> Any:
    """What is true before long."""
    deadline = time.monotonic() + 5.0
    while not (answer := ask()) and time.monotonic() < deadline:
        time.sleep(0.005)
    return answer
