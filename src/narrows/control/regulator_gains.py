"""Gains of linear-quadratic regulators from their weights, for one course or for many."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import inf, radians
from typing import Any

import numpy as np

from narrows.aliases import accept_aliases
from narrows.codegen.linearisation import LINEARISED
from narrows.control.linear_system import LinearSystem
from narrows.control.settings import LEAST_DECAY
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.simulation.ship import SimulatedShip

FEEDBACK = ("y", "psi", "v", "r", "rudder", "integral")
# Weights of these states, scaled [1].
SCALED_WEIGHTS = np.diag([1.0, 1.0, 0.0, 0.0, 1.0, 1.0])


@dataclass(frozen=True)
class RegulatorWeights:
    """Weights of a regulator by Bryson's rule, and its use of the bank force.

    The defaults were tuned by simulated voyages of the KCS at full size (``python decisions/regulator_weights.py``);
    ``design`` tunes them for another ship.
    """

    # Each of the first three is the deviation that costs as much as each of the others.
    offset: float = 1.0  # Deviation from the line [half beams]
    heading_deg: float = 2.3  # Deviation from the course [deg]
    rudder_deg: float = 14.0  # Deviation from the rudder angle of the course [deg]
    stroke_time: float = 0.095  # Time in which that rudder is put over [ship lengths]; limited by the gear
    integral_time: float = 1.7  # Duration of the offset [ship lengths]
    # Share of the model's slope of the bank force by offset, the least certain slope [1]: 0 assumes a constant force.
    # If the share leaves the model's ship unstable, the whole slope is used.
    bank: float = 0.5
    unwinding_time: float = 0.26  # Time in which the integral is reduced if the gear cannot follow [ship lengths]

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not (0 <= value <= 1 if entry.name == "bank" else 0 < value < inf):
                span = "0 to 1" if entry.name == "bank" else "a number over 0"
                raise InputError(f"weights of a regulator: {entry.name} = {value} is none; give {span}")


DEFAULT_WEIGHTS = RegulatorWeights()


def gains_of(
    ship: SimulatedShip, motion: np.ndarray, push: np.ndarray, speed: np.ndarray, weights: RegulatorWeights
) -> np.ndarray:
    """Gains of the states ``FEEDBACK``, (n, 6), of systems (n, 6, 6) driven by the rudder rate; NaN for none."""
    # Each state is scaled to its weight, and time to ship lengths: the entries are of order 1.
    hull, gear, one = ship.model.configuration.ship, ship.model.configuration.gear, np.ones(len(speed))
    time, off, rudder = hull.length / speed, weights.offset * hull.beam / 2, radians(weights.rudder_deg)
    size = np.stack(
        [off * one, radians(weights.heading_deg) * one, speed, speed / hull.length, rudder * one,
         off * weights.integral_time * time], axis=1,
    )  # fmt: skip
    rate = np.minimum(rudder / (weights.stroke_time * time), gear.rate)
    scaled = time[:, None, None] * motion * size[:, None, :] / size[:, :, None]
    drive = (time * rate)[:, None] * push / size
    reduced = scaled.copy()
    reduced[:, :4, 0] *= weights.bank
    gains = best_gains(reduced, drive, SCALED_WEIGHTS)
    lost = ~stabilised(scaled, drive, gains)
    gains[lost] = best_gains(scaled[lost], drive[lost], SCALED_WEIGHTS)
    return np.asarray(gains * rate[:, None] / size)


def stacked_gains(
    ship: SimulatedShip, values: Mapping[str, Any], course: Mapping[str, Any], weights: RegulatorWeights
) -> np.ndarray:
    """Return the gains of a regulator for each of many courses, (n, 6)."""
    linear = ship.linearisation({**ship.values(), **values})
    matrix = linear.linear({**course, "psi": -np.arctan(course["v"] / course["u"])})
    states, speed = [LINEARISED.index(name) for name in FEEDBACK[:4]], np.asarray(course["u"], float)
    rows = np.broadcast_to(matrix, (len(speed), *matrix.shape[-2:]))[:, states]
    rudder = len(LINEARISED) + linear.controlled.index("rudder")
    return gains_of(ship, *rate_driven(rows[:, :, states], rows[:, :, rudder]), speed, weights)


def regulator_gains(model: Model, linear: LinearSystem, weights: RegulatorWeights = DEFAULT_WEIGHTS) -> tuple[Any, ...]:
    """Return the gains of a regulator on one course, [rad/(s m), 1/s, rad/m, 1, 1/s, rad/(s2 m)]."""
    motion, push = rate_driven(linear.A[None], linear.B[None, :, linear.controls.index("rudder")])
    gains = gains_of(SimulatedShip(model), motion, push, np.array([float(linear.course["u"])]), weights)[0]
    if not np.isfinite(gains).all():
        where = f"at y = {float(linear.course['y']):g} m and {float(linear.course['u']):g} m/s"
        raise InputError(f"no regulator holds this ship {where}: its rudder has no effect there")
    return tuple(gains.tolist())


def rate_driven(A: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return systems of ``FEEDBACK`` driven by the rudder's rate, (n, 6, 6) and (n, 6), from those of y, psi, v, r."""
    driven, push = np.zeros((len(A), len(FEEDBACK), len(FEEDBACK))), np.zeros((len(A), len(FEEDBACK)))
    driven[:, :4, :4], driven[:, :4, 4] = A, b
    driven[:, 5, 0], push[:, 4] = 1.0, 1.0
    return driven, push


def stabilised(motion: np.ndarray, push: np.ndarray, gains: np.ndarray) -> np.ndarray:
    """Return which of many systems the gains stabilise (n,); false if a gain is NaN."""
    known = np.isfinite(gains).all(axis=1) & np.isfinite(motion).all(axis=(1, 2))
    poles = np.linalg.eigvals(np.where(known[:, None, None], motion - push[:, :, None] * gains[:, None, :], 0.0))
    return np.asarray(known & (poles.real.max(axis=1) < -LEAST_DECAY * np.abs(poles).max(axis=1)))


def best_gains(motion: np.ndarray, push: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the optimal gains of many systems with one input each, (n, k); NaN if nothing stabilises a system."""
    gains = np.full(push.shape, np.nan)
    known = np.isfinite(motion).all(axis=(1, 2)) & np.isfinite(push).all(axis=1)
    motion, push = motion[known], push[known]
    cost = riccati_solutions(motion, push[:, :, None] * push[:, None, :], weights)
    found = np.einsum("ni,nij->nj", push, cost)
    gains[known] = np.where(stabilised(motion, push, found)[:, None], found, np.nan)
    return gains


def riccati_solutions(motion: np.ndarray, effect: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the solutions of many continuous-time Riccati equations from A, B R^-1 B' and Q."""
    # By the stable half of the eigenvectors of the Hamiltonian matrix. Without a stabilising solution the result is
    # another matrix. Arnold and Laub (1984), Generalized eigenproblem algorithms, Proceedings of the IEEE 72(12).
    size = motion.shape[-1]
    costs = np.broadcast_to(weights, motion.shape)
    values, vectors = np.linalg.eig(np.block([[motion, -effect], [-costs, -motion.swapaxes(1, 2)]]))
    order = np.argsort(values.real, axis=1)[:, None, :size]
    stable = np.take_along_axis(vectors, order, axis=2)
    return np.asarray((stable[:, size:] @ np.linalg.pinv(stable[:, :size])).real)


@accept_aliases
def lqr(linear: Any, Q: Any, R: Any, *controls: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the gains that minimise the integral of x'Qx + u'Ru, as python-control's ``lqr`` does.

    This is the textbook regulator; ``regulator`` makes a whole helm with gear, integral and tuned weights.

    Parameters
    ----------
    linear : LinearSystem or Model
        Linear system about one course, for a model the one of ``linearize()``.
    Q, R : arrays
        Weights of ``linear.states`` and of the controls: matrices, their diagonals, or a number for each.
    *controls : str
        Controls to use, such as ``"rudder"``; those of ``linear.controls`` unless given.

    Returns
    -------
    tuple of arrays
        Gains K (controls, states) of u = -K x, the solution of the Riccati equation (states, states), and the poles of
        the closed loop [1/s].

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods.
    """
    system: LinearSystem = linear if isinstance(linear, LinearSystem) else linear.linearize()
    A, B = system.matrices(*controls)
    weights = []
    for name, given, names in (("Q", Q, system.states), ("R", R, controls or system.controls)):
        matrix = np.asarray(given, float)
        matrix = matrix if matrix.ndim > 1 else np.diag(matrix if matrix.ndim else np.full(len(names), given))
        if matrix.shape != (len(names), len(names)):
            raise InputError(f"{name} has the shape {matrix.shape}; give a row and a column for {', '.join(names)}")
        weights.append(matrix)
    from_cost = np.linalg.pinv(weights[1]) @ B.T
    (riccati,) = riccati_solutions(A[None], (B @ from_cost)[None], weights[0])
    gains = from_cost @ riccati
    poles = np.linalg.eigvals(A - B @ gains)
    if not poles.real.max() < -LEAST_DECAY * np.abs(poles).max():
        raise InputError("no gains hold this ship with these weights; give R over 0, and Q over 0 for y")
    return gains, riccati, poles
