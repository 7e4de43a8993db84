"""A step with its slopes in 26 directions, and a fit of zigzags of KVLCC2, beside the same windows in CasADi.

    python benchmarks/learning.py [ZIGZAGS] [--small]

The peer is CasADi's symbolic expressions of the same terms: one Runge-Kutta step and its Jacobian, and the chain rule.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from common import installed, interleaved, show, sizes

import narrows as nw
from narrows.logbook.shooting.recorded_motion import RecordedMotion

MODEL = nw.published("yasukawa2015_kvlcc2")
APPROACH, DURATION, STEP = 1.179, 150.0, 0.25
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
        signals = {name: nw.Signal(voyage.t, values) for name, values in told.items()}
        records.append(nw.ShipRecord(f"zigzag {number}", signals))
    return records


def stepped() -> tuple[int, Callable[[], object]]:
    """A voyage of 1000 steps in windows of 100, with slopes by start, pushes, the rudder's zero and 16 coefficients."""
    motion = RecordedMotion(MODEL, {"rudder": 0.0}, FREE, {"u": APPROACH, "surge": "free", "contact": "none"})
    times = STEP * np.arange(1001)
    first = np.arange(0, 1001, 100)
    starts = np.tile([0.0, 0.0, 0.0, 1.1, 0.0, 0.0], (10, 1))
    rudder = {"rudder": 0.2 * np.sin(times / 5)}
    return len(motion.directions), lambda: motion.sailed(starts, np.zeros((10, 3)), first, times, rudder, np.zeros(10))


def main(count: int, rounds: int) -> None:
    """Measure and print."""
    directions, sail = stepped()
    records = zigzags(count)
    works = {
        "1000 steps with slopes": sail,
        f"fit of {count} zigzags": lambda: nw.learn(MODEL, records, sensors="basin", spread=0.2),
    }
    if installed("casadi"):
        works["1000 steps in CasADi"] = by_casadi()
    cost = interleaved(works, rounds)
    rows = [(name, seconds, "process time") for name, seconds in cost.items()]
    rows.append((f"a step, {directions} directions", cost["1000 steps with slopes"] / 1000, "process time"))
    show("learning from records", rows, "ms", 1e3)


def by_casadi() -> Callable[[], object]:
    """The hull's polynomials alone by CasADi: fewer terms than ours, the same directions."""
    import casadi

    z, theta, rudder = casadi.SX.sym("z", 6), casadi.SX.sym("theta", 20), casadi.SX.sym("rudder")

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
    inputs = casadi.vertcat(z, theta)
    step = casadi.Function("step", [z, theta, rudder], [after, casadi.jacobian(after, inputs)])
    values, rudders = np.full(20, -0.05), 0.2 * np.sin(np.arange(1000) * STEP / 5)

    def sailed() -> None:
        state, slopes = np.array([0.0, 0.0, 0.0, 1.1, 0.0, 0.0]), np.eye(6, 26)
        for number in range(1000):
            if number % 100 == 0:
                state, slopes = np.array([0.0, 0.0, 0.0, 1.1, 0.0, 0.0]), np.eye(6, 26)
            ended, jacobian = step(state, values, rudders[number])
            state, jacobian = np.array(ended).ravel(), np.array(jacobian)
            slopes = jacobian[:, :6] @ slopes
            slopes[:, 6:] += jacobian[:, 6:]

    return sailed


if __name__ == "__main__":
    size, small = sizes(__doc__, usual=12, small=2)
    main(size, rounds=1 if small else 5)
