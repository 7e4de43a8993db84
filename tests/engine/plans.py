"""A predictive helm laid out once, for tests that ask its plans; the same problem for IPOPT."""

from functools import cache
from typing import Any

import numpy as np
from arguments import uncertain

import narrows as nw
from narrows.control import PredictiveHelm
from narrows.control.predictive.planner import RudderPlan
from narrows.control.predictive.predictive_helm import VoyageOrders
from narrows.simulation.kernel_run import ActuatorRates
from narrows.simulation.ship import SimulatedShip, steering_of

SPEED, HOLD = 1.0, 0.6
STEPS = 4
"""Of Runge and Kutta's method in an interval, for IPOPT."""


@cache
def ship() -> nw.Model:
    """A steered ship that is unstable of its course, by weak banks, with a covariance."""
    return uncertain().with_coefficients(b_bank=0.1, c_bank=0.02)


def helm(y: float = HOLD, **told: Any) -> PredictiveHelm:
    return PredictiveHelm(ship(), y, SPEED, **told)


@cache
def orders() -> VoyageOrders:
    return helm().begin()


def converged(state: np.ndarray, rounds: int = 12) -> RudderPlan:
    """A plan from a state after as many steps of sequential quadratic programming."""
    begun = orders()
    track, planner = begun.course.track, begun.planner
    push, (_, beyond) = np.zeros(2), begun.course.regulated(0.0, 0.0)

    def reference(x: np.ndarray) -> np.ndarray:
        return track.at(x, push)

    plan = planner.first(0.0, state, SPEED, reference)
    for _ in range(rounds):
        plan = planner.improve(plan, SPEED, push, reference, beyond)
        assert plan is not None
    return plan


def right_hand_side(casadi: Any, z: Any, rate: Any) -> Any:
    """The printed rates of y, psi, v, r, rudder, which take CasADi's symbols as they are."""
    if hasattr(casadi.GlobalOptions, "setNumpyMode"):
        casadi.GlobalOptions.setNumpyMode(1)  # NumPy's functions give symbols of symbols, without a word
    simulated = SimulatedShip(ship())
    law = steering_of(ActuatorRates(("rudder",)), simulated.actuators).law
    system = simulated.system(law=law)
    y, psi, v, r, rudder = casadi.vertsplit(z)
    values = simulated.values()
    values |= system.constants(values)
    values |= {"cos_rudder": casadi.cos(rudder), "sin_rudder": casadi.sin(rudder)}
    inputs = (values[name] for name in system.columns.RATES_INPUTS)
    found = system.columns.rates(0.0, y, casadi.cos(psi), casadi.sin(psi), SPEED, v, r, *inputs)
    return casadi.vertcat(found[1], r, found[5], found[6], rate)


def after_interval(casadi: Any, time: float) -> Any:
    z, rate = casadi.SX.sym("z", 5), casadi.SX.sym("rate")
    right = casadi.Function("right", [z, rate], [right_hand_side(casadi, z, rate)])
    end, h = z, time / STEPS
    for _ in range(STEPS):
        a = right(end, rate)
        b = right(end + h / 2 * a, rate)
        c = right(end + h / 2 * b, rate)
        end = end + h / 6 * (a + 2 * b + 2 * c + right(end + h * c, rate))
    return casadi.Function("after", [z, rate], [end])


def ipopt_rates(casadi: Any, start: np.ndarray) -> np.ndarray:
    """The same cost and limits by multiple shooting and an interior-point method."""
    begun = orders()
    planner, count = begun.planner, begun.planner.horizon.intervals
    _, beyond = begun.course.regulated(0.0, 0.0)
    steady, weights = begun.course.track.states[0, 0], planner.weights
    after = after_interval(casadi, planner.horizon.interval)
    Z, W, short = casadi.MX.sym("Z", 5, count + 1), casadi.MX.sym("W", count), casadi.MX.sym("short")
    cost, held, walls = 50.0 * short + 5.0 * short**2, [Z[:, 0] - casadi.DM(start)], []
    for k in range(count):
        off = Z[:, k + 1] - casadi.DM(steady)
        weight = casadi.DM(beyond if k == count - 1 else np.diag(weights.states))
        cost += (off.T @ weight @ off + weights.rate * W[k] ** 2) / 2
        held.append(Z[:, k + 1] - after(Z[:, k], W[k]))
        walls += [reach + planner.margins[k] - short * planner.hull[1] for reach in corners(casadi, Z[:, k + 1])]
    most, fastest = planner.limits
    upper = np.concatenate([np.tile([np.inf] * 4 + [most], count + 1), np.full(count, fastest), [np.inf]])
    program = {"x": casadi.vertcat(casadi.vec(Z), W, short), "f": cost, "g": casadi.vertcat(*held, *walls)}
    quiet = {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-10}
    solver = casadi.nlpsol("plan", "ipopt", program, quiet)
    answer = solver(
        x0=np.concatenate([np.tile(steady, count + 1), np.zeros(count + 1)]), lbx=np.append(-upper[:-1], 0.0),
        ubx=upper, lbg=np.concatenate([np.zeros(5 * (count + 1)), np.full(len(walls), -np.inf)]), ubg=0.0,
    )  # fmt: skip
    assert solver.stats()["success"]
    return np.array(answer["x"]).ravel()[5 * (count + 1) : -1]


def corners(casadi: Any, z: Any) -> list[Any]:
    """How far corners of the hull are beyond either bank."""
    (half_length, half_beam), room = orders().planner.hull, ship().configuration.canal.width / 2
    sine, cosine = casadi.sin(z[1]), casadi.cos(z[1])
    return [
        side * z[0] + side * forward * half_length * sine + half_beam * cosine - room
        for forward in (1, -1)
        for side in (1, -1)
    ]
