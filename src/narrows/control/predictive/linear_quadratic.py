"""The linear-quadratic regulator of the rudder's rate: the cost beyond a plan's end, and the helm where no plan is."""

from dataclasses import dataclass

import numpy as np

from narrows.control.predictive.settings import RUDDER_LENGTHS, RUDDER_RATE_WEIGHT
from narrows.control.settings import OFF_HEADING, OFF_RUDDER
from narrows.errors import InputError

IN_VAIN = "no helm holds this ship: its rudder turns nothing"


@dataclass(frozen=True)
class Weights:
    states: np.ndarray  # (5,) Of y, psi, v, r, rudder off their reference, squared
    rate: float  # Of the rudder's rate, squared [s2/rad2]


def weights_of(half_beam: float, passing: float) -> Weights:
    # Bryson and Ho (1975), Applied optimal control, section 5.2.
    states = np.array([half_beam**-2, OFF_HEADING**-2, 0.0, 0.0, OFF_RUDDER**-2])
    return Weights(states, RUDDER_RATE_WEIGHT * (OFF_RUDDER / (RUDDER_LENGTHS * passing)) ** -2)


def regulator_of(A: np.ndarray, B: np.ndarray, weights: Weights) -> tuple[np.ndarray, np.ndarray]:
    """Return the gains of the best linear helm (5,) and what a state off costs for ever, (5, 5)."""
    from scipy.linalg import LinAlgError, solve_discrete_are

    column = B[:, None]
    try:
        cost = solve_discrete_are(A, column, np.diag(weights.states), np.array([[weights.rate]]))
    except (LinAlgError, ValueError):
        raise InputError(IN_VAIN) from None
    gains = np.asarray(B @ cost @ A / (weights.rate + B @ cost @ B))
    if not np.abs(np.linalg.eigvals(A - column * gains)).max() < 1.0:
        raise InputError(IN_VAIN)
    return gains, np.asarray((cost + cost.T) / 2)
