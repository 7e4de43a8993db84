"""Forecasts of a warning: process time of one, beside one run of the model and a predictor curved by the rate of turn.

    python benchmarks/warning.py [FORECASTS] [--small]

A thousand samples with the rudder as it is and with the helmsman, for 120 s, 128 that escape at each of twelve times,
37 escapes of the most likely run, and the tracks that are drawn: two calls of prepared runs. The curved
predictor is what bridges have today: the present rate of turn and speed go on, the hull's corners held to the banks.
"""

import math
import time
from collections.abc import Callable

import numpy as np
from common import show, sizes
from envelope import full_scale
from scenes.five_scenes import bend

import narrows as nw
from narrows.estimation import Estimate, Estimator, Gnss, Gyro, Log, RateOfTurn, RudderIndicator
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.ship import SimulatedShip
from narrows.warning.forecasting.forecaster import Forecaster
from narrows.warning.forecasting.helmsman import Helmsmen

SENSORS = (Gnss(), Gyro(math.radians(0.2)), RateOfTurn(math.radians(0.03)), Log(), RudderIndicator())
SPEED, OFFSET, HEADING = 4.5, 20.0, 0.02


def known(estimator: Estimator) -> Estimate:
    """A ship off the middle, on its way a little across."""
    told, still = None, {"gyro": HEADING, "rate_of_turn": 0.0, "log": SPEED, "rudder": 0.0}
    for t in range(20):
        told = estimator.update(float(t), {**still, "gnss": (300.0 + SPEED * t, OFFSET + SPEED * HEADING * t)})
    return told


def median(work: Callable[[], object], count: int) -> float:
    """Median process time [s]; the first warms up."""
    times = []
    for _ in range(count + 1):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return float(np.median(times[1:]))


def forecasting(model: nw.Model, waterway: nw.Waterway, members: int, count: int) -> float:
    """A forecast [s]."""
    estimator = Estimator(model, SENSORS, waterway=waterway)
    estimate, one = known(estimator), Forecaster(estimator, members=members)
    helmsman = Helmsmen(1, model.configuration.ship.length)
    return median(lambda: one(estimate, {"rudder": 0.0}, helmsman), count)


def single_run(model: nw.Model, count: int) -> float:
    """One run of the model, as the rudder is, for 120 s [s]."""
    run = KernelRun(SimulatedShip(model), 120.0, 2.5)
    start = {"x": 0.0, "y": OFFSET, "psi": HEADING, "u": SPEED, "v": 0.0, "r": 0.0, "X": 0.0, "Y": 0.0, "N": 0.0}
    return median(run.prepared(start, 1, workers=1), count)


def curved(model: nw.Model, count: int) -> float:
    """The predictor curved by the rate of turn [s]."""
    ship, half = model.configuration.ship, model.configuration.canal.width / 2
    t = np.arange(0.0, 121.0, 2.5)

    def predict() -> float:
        psi = HEADING + 1e-4 * t
        y = OFFSET + np.concatenate([[0.0], np.cumsum(2.5 * SPEED * np.sin(psi[1:]))])
        met = np.abs(y) + ship.length / 2 * np.abs(np.sin(psi)) + ship.beam / 2 * np.cos(psi) >= half
        return float(t[met.argmax()]) if met.any() else np.inf

    return median(predict, count)


def main() -> None:
    """Time them."""
    count, small = sizes(__doc__, 60, 3)
    model, members = full_scale(), 20 if small else 1000
    bent = forecasting(model, bend(model), members, count)
    rows = [
        ("one run of the model", single_run(model, count), "as the rudder is, 120 s"),
        ("curved predictor", curved(model, count), "NumPy"),
        ("forecast in a bend", bent, f"{members} members, banks: polygons"),
    ]
    if not small:
        straight = forecasting(model, nw.straight_waterway(model.canal, 5000.0), members, count)
        rows.append(("forecast, straight canal", straight, f"{members} members"))
    show(f"Forecasts, {count} of them", rows, "ms", 1e3)


if __name__ == "__main__":
    main()
