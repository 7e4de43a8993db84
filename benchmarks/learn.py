"""A step with its slopes in 26 directions beside CasADi, and a fit of zigzags of KVLCC2 beside equation error.

    python benchmarks/learn.py [ZIGZAGS] [--small]

CasADi has the hull's polynomials alone, fewer terms than ours, as one function that it maps over the steps. Equation
error smooths velocities, takes their slopes and regresses the forces: one linear fit, no motion is sailed. Goals: 6 us
a step, 2 s a fit of 12 zigzags, in process time.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from common import installed, interleaved, show, sizes

import narrows as nw
from narrows.logbook.filtering.log_problem import RecordedMotion

sys.path.append(str(Path(__file__).parents[1] / "decisions"))
from kvlcc2_log import smoothed

MODEL = nw.published("yasukawa2015_kvlcc2")
APPROACH, DURATION, STEP = 1.179, 150.0, 0.25
STEPS, SPREAD = 1000, 0.2
FREE = ("R_0", "X_thrust", "Y_v", "Y_r", "Y_vvv", "Y_vvr", "Y_vrr", "Y_rudder", "N_v", "N_r", "N_vvv", "N_vvr", "N_vrr",
        "N_rrr", "N_rudder", "X_rudder")  # fmt: skip


def zigzags(count: int) -> list[nw.ShipRecord]:
    """Twins of zigzags to 5 to 35 degrees, measured twenty times a second."""
    records, noise = [], np.random.default_rng(0)
    for number in range(count):
        turn = np.radians(5 + 30 * (number % 6) / 5) * (-1) ** number
        voyage = nw.simulate(
            MODEL, u=APPROACH, duration=DURATION, dt=0.05, contact="none", surge="free",
            controller=nw.Zigzag(turn, abs(turn)),
        )  # fmt: skip
        spread = {"x": 0.005, "y": 0.005, "psi": 2e-3, "r": 1e-3, "rudder": 0.0}
        told = {name: voyage[name] + size * noise.standard_normal(len(voyage)) for name, size in spread.items()}
        told["revolutions"] = np.full(len(voyage), MODEL.configuration.propeller.revolutions)
        signals = {name: nw.Signal(voyage.t, values) for name, values in told.items()}
        records.append(nw.ShipRecord(f"zigzag {number}", signals))
    return records


def stepped() -> tuple[int, Callable[[], object]]:
    """A voyage of some steps in windows of 100, with slopes by start, pushes, the rudder's zero and 16 coefficients."""
    motion = RecordedMotion(MODEL, {"rudder": 0.0}, FREE, {"u": APPROACH, "surge": "free", "contact": "none"})
    times = STEP * np.arange(STEPS + 1)
    first = np.arange(0, STEPS + 1, 100)
    starts = np.tile([0.0, 0.0, 0.0, 1.1, 0.0, 0.0], (10, 1))
    rudder = {"rudder": 0.2 * np.sin(times / 5)}
    return len(motion.directions), lambda: motion.sailed(starts, np.zeros((10, 3)), first, times, rudder)


def main(count: int, rounds: int) -> None:
    """Measure and print."""
    directions, sail = stepped()
    works = {f"a step, {directions} directions": sail}
    if installed("casadi"):
        works["a step of polynomials alone in CasADi"] = by_casadi()
    cost = interleaved(works, rounds)
    show("slopes of a recorded voyage", [(name, seconds / STEPS, "") for name, seconds in cost.items()], "us", 1e6)
    records = zigzags(count)
    cost = interleaved({
        f"fit of {count} zigzags": lambda: nw.learn(MODEL, records, sensors="basin", spread=SPREAD),
        "equation error, smoothed over 2 s": lambda: smoothed(MODEL, records, 2.0, SPREAD),
    }, rounds)  # fmt: skip
    show("learning from records", [(name, seconds, "process time") for name, seconds in cost.items()], "s", 1)


def by_casadi() -> Callable[[], object]:
    """The same directions, in one call for all steps."""
    import casadi

    z, slopes, theta, rudder = (casadi.SX.sym(*of) for of in (("z", 6), ("slopes", 6, 26), ("theta", 20), ("rudder",)))

    def rate(at: Any) -> Any:
        u, v, r = at[3], at[4], at[5]
        shape = casadi.vertcat(v, r, v**3, v**2 * r, v * r**2, r**3, rudder)
        sway, yaw = casadi.dot(theta[:7], shape), casadi.dot(theta[7:14], shape)
        surge = theta[14] * (APPROACH**2 - u**2) + theta[15] * v * r
        cosine, sine = casadi.cos(at[2]), casadi.sin(at[2])
        return casadi.vertcat(u * cosine - v * sine, u * sine + v * cosine, r, surge, sway, yaw)

    a = rate(z)
    b = rate(z + STEP / 2 * a)
    c = rate(z + STEP / 2 * b)
    after = z + STEP / 6 * (a + 2 * b + 2 * c + rate(z + STEP * c))
    moved = casadi.jacobian(after, z) @ slopes
    moved[:, 6:] += casadi.jacobian(after, theta)
    both, step = casadi.vertcat(z, casadi.vec(slopes)), casadi.vertcat(after, casadi.vec(moved))
    march = casadi.Function("step", [both, theta, rudder], [step]).mapaccum("march", STEPS)
    start = np.concatenate([[0.0, 0.0, 0.0, 1.1, 0.0, 0.0], np.eye(6, 26).ravel(order="F")])
    values, rudders = np.full((20, STEPS), -0.05), 0.2 * np.sin(np.arange(STEPS) * STEP / 5)[None]
    return lambda: march(start, values, rudders)


if __name__ == "__main__":
    size, small = sizes(__doc__, usual=12, small=2)
    main(size, rounds=1 if small else 5)
