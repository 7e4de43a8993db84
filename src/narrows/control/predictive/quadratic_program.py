"""A plan as a quadratic program in the changes of the rudder's rates, and DAQP, which solves it."""

from dataclasses import dataclass

import numpy as np

from narrows.control.predictive.line_frame import RUDDER
from narrows.control.predictive.linear_quadratic import Weights
from narrows.errors import needs

# Costs of a clearance that is short by half a beam: by the length, and by its square.
SHORT, SHORT_SQUARED = 50.0, 10.0
MOST_ITERATIONS = 500
WITHOUT_BOUND = 1e20


@dataclass(frozen=True)
class QuadraticProgram:
    """Minimise z' H z / 2 + f' z where bounds hold; z are the changes of the rates, and the shortness of clearance."""

    H: np.ndarray  # (n, n) Positive definite
    f: np.ndarray  # (n,) Of the cost
    rows: np.ndarray  # (m, n) Of the constraints
    lower: np.ndarray  # (n + m,) Of z, then of the rows
    upper: np.ndarray  # (n + m,) Of z, then of the rows


def tracking_cost(
    off: np.ndarray, G: np.ndarray, rates: np.ndarray, weights: Weights, beyond: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return H and f of what it costs to be off the reference and to turn the rudder."""
    # off (intervals, 5); G (intervals, 5, intervals); rates (intervals,) [rad/s]; beyond (5, 5)
    felt = np.flatnonzero(weights.states)
    root = np.sqrt(weights.states[felt])
    moved = (G[:-1, felt] * root[:, None]).reshape(-1, len(rates))
    wrong = (off[:-1, felt] * root).ravel()
    last = beyond @ G[-1]
    H = moved.T @ moved + G[-1].T @ last
    H.flat[:: len(rates) + 1] += weights.rate
    return H, moved.T @ wrong + last.T @ off[-1] + weights.rate * rates


def program_of(
    cost: tuple[np.ndarray, np.ndarray], rates: np.ndarray, rudders: tuple[np.ndarray, np.ndarray],
    clearance: tuple[np.ndarray, np.ndarray], limits: tuple[float, float], half_beam: float,
) -> QuadraticProgram:  # fmt: skip
    """Put cost and constraints together; clearance may fall short, for a price."""
    # rates (intervals,) [rad/s]; rudders (intervals,); limits [rad, rad/s]; half_beam [m]
    n = len(rates)
    H, f = np.zeros((n + 1, n + 1)), np.full(n + 1, SHORT)
    H[:n, :n], f[:n] = cost
    H[n, n] = SHORT_SQUARED
    (angle, by_rate), (rows, bounds), (most, fastest) = rudders, clearance, limits
    A = np.zeros((n + len(rows), n + 1))
    A[:n, :n], A[n:, :n], A[n:, n] = by_rate, rows, -half_beam
    lower = np.concatenate([-fastest - rates, [0.0], -most - angle, np.full(len(rows), -WITHOUT_BOUND)])
    upper = np.concatenate([fastest - rates, [WITHOUT_BOUND], most - angle, bounds])
    return QuadraticProgram(H, f, A, lower, upper)


def solution(program: QuadraticProgram, seconds: float = 0.0) -> np.ndarray | None:
    """Solve by DAQP: z, or None where it finds no answer, in time."""
    # seconds [s]
    # Arnstrom, Bemporad and Axehill (2022), A dual active-set solver for embedded quadratic programming using
    # recursive LDL^T updates, IEEE Transactions on Automatic Control 67(8), 4362-4369.
    with needs("control", "a predictive helm"):
        import daqp
    if not all(map(np.isfinite, (program.H.sum(), program.f.sum(), program.rows.sum(), program.upper.sum()))):
        return None
    z, _, flag, _ = daqp.solve(
        program.H, program.f, program.rows, program.upper, program.lower, None,
        iter_limit=MOST_ITERATIONS, time_limit=seconds,
    )  # fmt: skip
    return z if flag > 0 and np.isfinite(z).all() else None


def rudder_rows(states: np.ndarray, e: np.ndarray, G: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rudder after each interval, and how changes of the rates move it."""
    # states (intervals, 5)
    return states[:, RUDDER] + e[:, RUDDER], G[:, RUDDER]
