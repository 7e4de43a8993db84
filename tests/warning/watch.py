"""A monitor that hears a ship in a straight canal, second by second, and what may befall what it hears."""

import math
from collections.abc import Callable, Iterator
from functools import cache

from transit import canal, ship

from narrows.readers.nmea import Entry, NmeaDecoder, sentences
from narrows.warning.forecasting.forecaster import BankForecast, Forecaster
from narrows.warning.forecasting.helmsman import Helmsmen
from narrows.warning.inputs.bridge_readings import Tick
from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
from narrows.warning.monitoring.demonstration import bridge_sentences
from narrows.warning.monitoring.watched_transit import BridgeStatus

SPEED, BEGAN = 4.2, 1_777_680_000.0
Lines = list[str]
Fault = Callable[[int, Lines], Lines]


@cache
def forecaster() -> Forecaster:
    return Forecaster(monitor(shared=False).estimator, members=20, escaping=20)


def monitor(shared: bool = True, **options: object) -> BridgeMonitor:
    one = BridgeMonitor(ship(), canal(), members=20, **options)
    if shared:
        one.forecaster = forecaster()
    return one


def indicated(t: float, y: float = 0.0, psi: float = 0.0, rudder: float = 0.0) -> dict[str, float]:
    still = {"r": 0.0, "u": SPEED, "course": psi, "speed": SPEED, "rudder": rudder}
    return {**still, "x": 600.0 + SPEED * t, "y": y + SPEED * math.sin(psi) * t, "psi": psi}


def ticks(seconds: int, fault: Fault | None = None, **where: float) -> Iterator[Tick]:
    decoder = NmeaDecoder()
    for t in range(seconds):
        lines = bridge_sentences(canal(), indicated(float(t), **where), BEGAN + t)
        lines = fault(t, lines) if fault else lines
        told = [decoder.decode(one) for one in sentences([line.encode() for line in lines], decoder.faults)]
        yield Tick(BEGAN + t, [Entry(BEGAN + t, one) for one in told if one], dict(decoder.faults))


@cache
def calm_forecast() -> BankForecast:
    return forecaster()(monitored(ticks(5))[-1].estimate, {"rudder": 0.0}, Helmsmen(1, 230.0))


def calm(estimate: object, positions: object, helmsman: object) -> BankForecast:
    return calm_forecast()


def monitored(told: Iterator[Tick], one: BridgeMonitor | None = None) -> list[BridgeStatus]:
    one = one or monitor()
    return [one.update(tick, tick.t) for tick in told]


def without(*kinds: str, start: int = 0, stop: int = 10**9) -> Fault:
    return lambda t, lines: [
        line for line in lines if not (start <= t < stop and any(kind in line[:8] for kind in kinds))
    ]
