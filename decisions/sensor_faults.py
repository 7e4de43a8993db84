"""Estimates under faults of one sensor, and voyages steered by estimates: two tables that are printed only.

Eight true twins sail six minutes; faults begin at once or after a minute. Errors count from the second minute on, and
include dead reckoning without fixes. The voyages hold 50 m for ten minutes, in calm water and under two sets of pushes,
with the weights of heading and stroke that the table names.

python decisions/sensor_faults.py
"""

import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from estimation import SENSORS, U, Y, model
from pages import markdown

import narrows as nw
from narrows.control import RegulatorWeights
from narrows.estimation import CourseOverGround, Estimator, GaussMarkov, Gnss, Gyro, Log, RateOfTurn, RudderIndicator
from narrows.estimation.consistency import sail_twins

sys.path.append(str(Path(__file__).parent.parent / "benchmarks"))
from scenes.five_scenes import scenes
from scenes.helms import track_pilot

TWINS, DURATION, BEGUN, COUNTED = 8, 360.0, 60.0, 120.0
SEEDS = 1, 2, 3
Readings = dict[str, Any]


def aside(readings: Readings, across: float) -> Readings:
    """Readings with the fixes moved to starboard."""
    return {**readings, "gnss": readings["gnss"] + np.array([0.0, across])}


FAULTS: dict[str, Callable[[float, Readings], Readings]] = {
    "none": lambda t, readings: readings,
    "log stuck at 0 after a minute": lambda t, readings: {**readings, **({"log": 0.0} if t >= BEGUN else {})},
    "log stuck at 0 from the start": lambda t, readings: {**readings, "log": 0.0},
    "first reading of the log 0": lambda t, readings: {**readings, **({"log": 0.0} if t < 1.0 else {})},
    "first fix 40 m off": lambda t, readings: aside(readings, 40.0 * (t < 1.0)),
    "first five fixes 40 m off": lambda t, readings: aside(readings, 40.0 * (t < 5.0)),
    "fixes creep by 0.5 m/s after a minute": lambda t, readings: aside(readings, 0.5 * max(t - BEGUN, 0.0)),
}


def faults() -> str:
    """Largest errors of the states, and when the sensor was named."""
    one, pilot = Estimator(model(), SENSORS), track_pilot(model(), Y, U)
    start = (0.0, Y, U, float(pilot.psi))
    truth = sail_twins(one.filter, pilot, start, TWINS, DURATION, False, math.radians(3.0), 5)
    rows = []
    for name, fault in FAULTS.items():
        off, named = np.zeros((TWINS, 3)), []
        for twin in np.flatnonzero(~truth.aground):
            one.forget()
            for number, t in enumerate(truth.t.tolist()):
                readings = {sensor: column[number, twin] for sensor, column in truth.readings.items()}
                now = one.update(t, {**fault(t, readings), "rudder": truth.indicated[number, twin, 0]})
                if now.faults and len(named) <= twin:
                    named += [math.inf] * (int(twin) - len(named)) + [t]
                if now.ready and t >= COUNTED:
                    errors = [
                        abs(now[state] - truth.states[number, twin, k])
                        for state, k in zip("xyu", (0, 1, 3), strict=True)
                    ]
                    off[twin] = np.maximum(off[twin], errors)
        worst = [f"{np.median(column):.1f}, {column.max():.1f}" for column in off.T]
        rows.append((name, *worst, f"{min(named):.0f} to {max(named):.0f}" if named else "not"))
    return markdown(("fault", "x, median and worst [m]", "y [m]", "u [m/s]", "named at [s]"), rows)


def steered() -> str:
    """Largest offset and rudder travel under true states and under estimates, for two sets of weights."""
    rows, scene = [], scenes(model())
    others = CourseOverGround(), Gyro(), RateOfTurn(), Log(), RudderIndicator()
    receivers = {"white fixes": Gnss(1.5, coloured=None), "slow errors": Gnss(0.5, coloured=GaussMarkov(1.5, 60.0))}
    pushed = {"calm": {}, **{name: scene[name].forces() for name in ("bank", "gust")}}
    for weights in (RegulatorWeights(), RegulatorWeights(heading_deg=5.0, stroke_time=0.3)):
        law = nw.control.regulator(model(), 50.0, U, weights=weights)
        of = f"{weights.heading_deg:g} deg, {weights.stroke_time:g}"
        for name, forces in pushed.items():
            for seen, sensors in {"true states": (), **{k: (own, *others) for k, own in receivers.items()}}.items():
                loop = nw.control.closed_loop(model(), law, sensors=sensors)
                voyages = [loop.simulate(600.0, seed, **forces) for seed in SEEDS[: len(SEEDS) if sensors else 1]]
                off = max(float(np.abs(voyage.y - 50.0).max()) for voyage in voyages)
                travel = np.mean([np.degrees(np.abs(np.diff(voyage.rudder)).sum()) for voyage in voyages])
                rows.append((of, name, seen, f"{off:.1f}", f"{travel:.0f}"))
    return markdown(("weights", "scene", "seen", "largest offset [m]", "rudder travel [deg]"), rows)


if __name__ == "__main__":
    print(faults(), steered(), sep="\n\n")
