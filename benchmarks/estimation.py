"""The estimator: process time of an update, beside filterpy's unscented filter over the same steps of the same ship.

    python benchmarks/estimation.py [UPDATES] [--small]

Five sensors once a second: fixes, heading, rate of turn, log and rudder, twelve states. filterpy's filter moves its
sigma points one by one by the package's plain step, and takes the fixes, heading, rate and log as one linear
measurement; it carries no coefficients, gates nothing and watches no drift. The figures of merit on twins are in
docs/estimation.md.
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from common import installed, show, sizes

import narrows as nw
from narrows.estimation import Estimator, Gnss, Gyro, Log, RateOfTurn, RudderIndicator

SENSORS = (Gnss(), Gyro(math.radians(0.2)), RateOfTurn(math.radians(0.03)), Log(), RudderIndicator())
SPEED, WIDTH = 4.5, 300.0


def ship() -> nw.Model:
    """The published hull at 230 m with a rudder, its coefficients known to 10 %."""
    hull = nw.published("mikkelsen2025_dtc")
    lift = {f"{axis}_u{motion}": hull.coefficients[f"{axis}_{motion}"] for axis in "bc" for motion in "vr"}
    known = {**dict.fromkeys(nw.STEERED.names, 0.0), **hull.coefficients, **lift}
    known |= {"a_helm": 5.0, "b_helm": 6.0, "c_helm": 2.9}
    values = {name: known[name] for name in nw.STEERED.names}
    configuration = replace(hull.configuration, ship=replace(hull.configuration.ship, flow_straightening=0.5))
    model = nw.Model(configuration, nw.STEERED, values)
    full = nw.scale_model(model, 230.0, 1025.0, width=WIDTH).model
    return replace(full, covariance=np.diag((0.1 * np.array(list(full.coefficients.values()))) ** 2))


def told(updates: int) -> Iterator[tuple[float, dict[str, object]]]:
    """Readings of a ship in the middle of the canal, where rudder and drift are zero."""
    random = np.random.default_rng(0)
    for t in range(updates):
        noise = random.standard_normal(6).tolist()
        fix = (SPEED * t + 1.5 * noise[0], 1.5 * noise[1])
        angles = {"gyro": 3.5e-3 * noise[2], "rate_of_turn": 5e-4 * noise[3], "rudder": 2e-3 * noise[5]}
        yield float(t), {"gnss": fix, "log": SPEED + 0.05 * noise[4], **angles}


def ours(model: nw.Model, way: str, updates: int) -> float:
    """Median process time of an update [s]."""
    one = Estimator(model, SENSORS, coefficients=way)
    return median(one.update, told(updates))


def median(update: Callable[..., object], rows: Iterator[tuple[float, dict[str, object]]]) -> float:
    """Median process time of an update [s]; a tenth of them warms up."""
    times = []
    for t, readings in rows:
        start = time.process_time()
        update(t, readings)
        times.append(time.process_time() - start)
    return float(np.median(times[len(times) // 10 + 1 :]))


def peer(model: nw.Model, updates: int) -> float:
    """filterpy's filter of the same states."""
    from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

    from narrows.simulation.initial_state import initial_state

    made = Estimator(model, SENSORS, coefficients="certain").filter
    start = {"x": 0.0, "y": 0.0, "psi": 0.0, "u": SPEED, "v": 0.0, "r": 0.0, "rudder": 0.0}
    integrator = initial_state(made.ship, None, start, None, False)[0]
    seen = np.zeros((5, len(made.states)))
    for number, name in enumerate(("x", "y", "psi", "r", "u")):
        seen[number, made.states.places[name]] = 1.0

    def moved(state: np.ndarray, dt: float) -> np.ndarray:
        x, y, psi, u, v, r, *others = state.tolist()
        ended = integrator.stepped((x, y, np.cos(psi), np.sin(psi), u, v, r), dt)[0]
        return np.array([*ended[:2], np.arctan2(ended[3], ended[2]), *ended[4:7], *others])

    size = len(made.states)
    filter = UnscentedKalmanFilter(
        size, 5, 1.0, lambda state: seen @ state, moved, MerweScaledSigmaPoints(size, 0.5, 2.0, 12.0 - size)
    )
    filter.x = made.states.vector({"u": SPEED})
    filter.P, filter.Q = 1e-2 * np.eye(size), 1e-6 * np.eye(size)
    filter.R = np.diag([1.5, 1.5, 3.5e-3, 5e-4, 0.05]) ** 2

    def update(t: float, readings: dict[str, object]) -> None:
        filter.predict()
        filter.update(np.array([*readings["gnss"], *(readings[name] for name in ("gyro", "rate_of_turn", "log"))]))

    return median(update, told(updates))


def smoothing(model: nw.Model, rows: int) -> float:
    """Process time of the smoother a row [s]."""
    table = [{"t": t, **readings} for t, readings in told(rows)]
    columns = {name: np.array([row[name] for row in table]) for name in ("t", "gyro", "rate_of_turn", "log", "rudder")}
    fixes = np.array([row["gnss"] for row in table])
    one = Estimator(model, SENSORS)
    start = time.process_time()
    one.smooth({**columns, "gnss_x": fixes[:, 0], "gnss_y": fixes[:, 1]})
    return (time.process_time() - start) / rows


def main() -> None:
    """Time them."""
    updates, _ = sizes(__doc__, 3000, 60)
    model = ship()
    rows = [
        ("an update, coefficients certain", ours(model, "certain", updates), "12 states, 25 points"),
        ("the same, estimated", ours(model, "estimated", updates // 3), "corrected too"),
        ("the smoother, a row", smoothing(model, max(updates // 10, 20)), "forward and back, coefficients too"),
    ]
    if installed("filterpy"):
        rows.append(("filterpy, certain", peer(model, updates // 3), "points one by one"))
    show(f"Estimation, {updates} updates", rows, "us", 1e6)


if __name__ == "__main__":
    main()
