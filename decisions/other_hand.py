"""Transits of another kind than the package's own twins, for `transits.py`.

Gusts swing about a period (a second-order process). The pilot looks out of the window, acts three seconds late and
moves the rudder only by two degrees or more; the aim drifts across the canal. The draft is a few per cent off. The
compass shows whole degrees, the antenna stands elsewhere, the clock of the receiver gains, the log speaks every five
seconds and one fix in ten is lost.
"""

import math
from collections import deque
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

import narrows as nw
from narrows.logbook.steady_readings import steady_push
from narrows.logbook.transits import TransitPilot, TransitTwin, gust_push, wandering
from narrows.simulation.controllers import Order
from narrows.simulation.initial_state import self_propulsion

DEGREE = math.pi / 180
STEP = 0.5
DELAY, DEAD_BAND, TREND = 3.0, 2 * DEGREE, 4.0
PERIOD, DAMPING = 60.0, 0.3
DRAFT = 0.03
FORWARD, STARBOARD, CLOCK, LOG_PERIOD, LOST = 1.5, 1.5, 50e-6, 5, 0.1


@dataclass(frozen=True)
class LatePilot:
    """A proportional law on what was seen some seconds ago, with a dead band."""

    pilot: TransitPilot

    def begin(self) -> Order:
        """Return the orders of one voyage."""
        by_y, by_psi, by_v, by_r, by_rudder, by_integral = (float(gain) for gain in self.pilot.law.lines[0].gains)
        seen: deque = deque()
        kept = {"t": 0.0, "off": 0.0, "order": 0.0}

        def order(t: float, at: object) -> float:
            seen.append((t, copy(at)))
            while len(seen) > 1 and seen[1][0] <= t - DELAY:
                seen.popleft()
            then, was = seen[0]
            aim, rudder, psi, v, _ = self.pilot._held(then, was)
            kept["off"], kept["t"] = kept["off"] + (t - kept["t"]) * (was.y - aim), t
            pull = by_y * (was.y - aim) + by_psi * (was.psi - psi) + by_v * (was.v - v) + by_r * was.r
            wanted = rudder - (pull + by_integral * kept["off"]) / by_rudder
            if abs(wanted - kept["order"]) >= DEAD_BAND:
                kept["order"] = wanted
            return kept["order"]

        return order


@dataclass(frozen=True)
class OtherTransit(TransitTwin):
    """A transit by the late pilot, in gusts that swing."""

    def sailed(self, seed: int) -> nw.Voyage:
        """Simulate the transit."""
        draw, told = np.random.default_rng((seed, 23)), self.conditions
        times = np.arange(0.0, self.duration + 10.0, 10.0)
        trend = TREND * draw.uniform(-1, 1) * (2 * times / times[-1] - 1)
        aims = trend + wandering(told.wander, told.wander_time, 10.0, len(times), draw)[:, 0]
        hull = self.truth.configuration.ship
        draft = hull.draft * (1 + DRAFT * float(draw.standard_normal()))
        truth = replace(self.truth, configuration=replace(self.truth.configuration, ship=replace(hull, draft=draft)))
        started = {"y": float(aims[0]), "u": self.u, **self._swinging(draw)}
        if truth.terms.propelled:
            started["revolutions"] = self_propulsion(truth, self.u)
        helm = LatePilot(TransitPilot(truth, self.u, times, aims, self.waterway))
        voyage = nw.simulate(truth, duration=self.duration, dt=STEP, controller=helm, waterway=self.waterway, **started)
        if voyage.t[-1] < self.duration - 2 * STEP:
            raise nw.InputError("in these gusts the ship does not come through")
        return voyage

    def _swinging(self, draw: np.random.Generator) -> dict[str, list[tuple[float, float]]]:
        step, told = 2.0, self.conditions
        times = np.arange(0.0, self.duration, step)
        swing = 2 * math.pi / PERIOD
        root = np.roots([1.0, 2 * DAMPING * swing, swing**2])[0]
        first, second = 2 * np.exp(root * step).real, -(np.abs(np.exp(root * step)) ** 2)
        values = draw.standard_normal((len(times) + 200, 2))
        for i in range(2, len(values)):
            values[i] += first * values[i - 1] + second * values[i - 2]
        values = values[200:] / values[200:].std(axis=0)
        pushes = values @ gust_push(told, self.truth).T + draw.standard_normal(2) * steady_push(told, self.truth)
        return {
            axis: list(zip(times.tolist(), own.tolist(), strict=True)) for axis, own in zip("YN", pushes.T, strict=True)
        }


def misread(log: nw.ShipLog, seed: int) -> nw.ShipLog:
    """Return a log as poorer instruments write it."""
    draw, records = np.random.default_rng((seed, 29)), []
    for record in log:
        t = record["x"].t
        psi = record["psi"].at(t)
        kept = draw.random(len(t)) >= LOST
        moved = {
            "x": FORWARD * np.cos(psi) - STARBOARD * np.sin(psi),
            "y": FORWARD * np.sin(psi) + STARBOARD * np.cos(psi),
        }
        signals = {
            name: nw.Signal(t[kept] * (1 + CLOCK), (record[name].values + by)[kept]) for name, by in moved.items()
        }
        compass = record["psi"]
        signals["psi"] = nw.Signal(compass.t, np.round(compass.values / DEGREE) * DEGREE)
        if "u" in record:
            signals["u"] = nw.Signal(record["u"].t[::LOG_PERIOD], record["u"].values[::LOG_PERIOD])
        records.append(record.with_signals(**signals))
    return nw.ShipLog(tuple(records), log.waterway)
