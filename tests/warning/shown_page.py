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
from narrows.estimation.estimate import Estimate
from narrows.estimation.states import StateNames
from narrows.estimation.unscented import Gaussian
from narrows.warning.alerts.alert import BANKS, AlertDesk, Condition, Priority, Situation
from narrows.warning.forecasting.forecast import CASES, BankForecast, CaseForecast, LikelyRun
from narrows.warning.forecasting.future_lanes import FAN_MEMBERS, TIMES, PredictedFan
from narrows.warning.monitoring.bridge_status import BridgeStatus, clearances
from narrows.warning.page.bridge_page import BridgePage

BANK = BANKS["starboard"]
ALARM = {BANK: Condition(Priority.ALARM, "Bank to starboard in 60 s: last chance in 14 s")}
HANDSHAKE = (
    "GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}Upgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
STATES = ("x", "y", "psi", "u", "v", "r")
SHIP = nw.Ship(name="A ship", length=230.0, beam=32.2, draft=10.8, block_coefficient=0.65)
NOW = {"x": 3200.0, "y": 60.0, "psi": 0.05, "u": 4.2, "v": 0.0, "r": 0.001}


def estimate(t: float, now: Mapping[str, float] | None = NOW) -> Estimate:
    normal = Gaussian(np.array([now[name] for name in STATES]), np.eye(len(STATES))) if now else None
    return Estimate(t, StateNames(STATES), normal, now is not None, {})


def forecast(contact: float = math.inf, last_chance: float = math.inf) -> BankForecast:
    side, share = ("starboard", 0.4) if math.isfinite(contact) else ("", 0.0)
    cases = {case.name: CaseForecast(case.name, share, share / 2, contact, side) for case in CASES}
    return BankForecast(0.0, cases, LikelyRun(contact, side, last_chance, False), contact, 0.1, -0.3, math.radians(35))


def fan(status: BridgeStatus) -> PredictedFan:
    """Straight on, a little apart."""
    times, now = np.array(TIMES), status.estimate.values
    off = np.linspace(-0.3, 0.3, FAN_MEMBERS)[:, None]
    x, ones = now["x"] + now["u"] * times, np.ones(len(times))
    tracks = np.stack([x * np.ones_like(off), now["y"] + off * times, now["psi"] + 0 * off * times], axis=-1)
    likely = np.stack([x, now["y"] * ones, now["psi"] * ones], axis=-1)
    return PredictedFan(times, tracks, likely, likely)


class Watched:
    """What a monitor is to its page."""

    def __init__(self) -> None:
        self.model, self.waterway = SimpleNamespace(configuration=SimpleNamespace(ship=SHIP)), canal()
        self.desk, self.t, self.fan = AlertDesk(), 0.0, fan

    def status(
        self, told: BankForecast | None = None, now: Mapping[str, float] | None = NOW,
        conditions: Mapping[Situation, Condition] | None = None,
    ) -> BridgeStatus:  # fmt: skip
        """A second later."""
        self.t += 1.0
        changed, known = self.desk.update(self.t, conditions or {}), estimate(self.t, now)
        room = clearances(SHIP, self.waterway, known)
        why = "" if told else "Too little has been told for too long."
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
                self.page.tell(self.monitored, self.status, time.time())

    @contextmanager
    def running(self) -> Iterator["Pulse"]:
        thread = Thread(target=self.run, daemon=True)
        thread.start()
        yield self
        self._stop.set()
        thread.join()


def asked(page: BridgePage, monitored: Watched) -> list[Any]:
    """Do what was asked for on the page, as the next update of a monitor does; the alerts that changed."""
    from narrows.warning.alerts.alert_sentences import command_of

    commands = [command_of(text) for text in page.requests.sentences(monitored.desk, monitored.t)]
    return [monitored.desk.command(monitored.t, *command) for command in commands]


def soon(ask: Callable[[], Any]) -> Any:
    """What is true before long."""
    deadline = time.monotonic() + 5.0
    while not (answer := ask()) and time.monotonic() < deadline:
        time.sleep(0.005)
    return answer
