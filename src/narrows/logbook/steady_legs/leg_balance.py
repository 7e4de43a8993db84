"""Coefficients from steady legs: the balance of sway and yaw, linear in the coefficients, between readings with errors.

The legs' true offsets, speeds and angles are unknown too. With a leg's readings ``m = l + zeros + e`` and the balance
``f(l, coefficients) + wind + rest = 0``, the balance is linear about the best l so far, and its error is that of the
readings through its slopes (Gauss-Helmert least squares). Each leg then has a score and an information matrix, as a
record of a log has, and the search and the posterior are those of logs.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from narrows.codegen.linearisation import LINEARISED
from narrows.errors import InputError
from narrows.logbook.filtering.log_problem import CoefficientPrior, Unknowns
from narrows.logbook.filtering.search import bounded_step
from narrows.logbook.learning.log_posterior import coefficient_prior
from narrows.logbook.settings import UPDATE_ROUNDS, UPDATE_SETTLED
from narrows.logbook.steady_legs.steady_readings import UNKNOWN, SteadyConditions, SteadyReadings
from narrows.model.model import Model
from narrows.safety.request import keel_at
from narrows.ship.motion import Motion
from narrows.simulation.self_propulsion import self_propulsion
from narrows.simulation.ship import SimulatedShip

LATENT = ("y", "u", "rudder", "psi")  # True state of a leg, of which its readings are readings
# Forces in balance on a steady leg, and the velocity whose rate each makes.
BALANCED = {"Y": "v", "N": "r"}
FORCES = slice(len(BALANCED))
UNLIKE = (
    "errors of these readings are beyond all measure, or differ by too many powers of ten; check each, and its unit"
)


class LegFit(NamedTuple):
    unknowns: np.ndarray  # (P,) Scaled coefficients, then ``UNKNOWN`` over their standard deviations
    information: np.ndarray  # (P, P)
    latent: np.ndarray  # (legs, 4) Most likely ``LATENT``
    chi_square: float  # Chi-square of the readings under the prior [1]
    left_out: np.ndarray  # (legs,) The part of it that is gone without each leg [1]
    counted: int  # Degrees of freedom
    converged: bool


class LegReadings(NamedTuple):
    value: np.ndarray  # (legs, 4 or 5) ``LATENT`` as read, the direction as often as it is read
    size: np.ndarray  # (legs, 4 or 5) Standard deviations
    zeros: np.ndarray  # (4 or 5, 6) 1 where one of ``UNKNOWN`` adds to a reading
    balance: "SteadyBalance"


@dataclass(frozen=True)
class LegProblem(Unknowns):
    """Unknowns of steady legs: coefficients, then common errors over their standard deviations."""

    prior: CoefficientPrior  # Prior of a model with terms of a rudder
    common: np.ndarray  # (6,) Standard deviations of ``UNKNOWN``
    left_over: np.ndarray  # (5,) ``SteadyConditions.left_over``

    @classmethod
    def of(cls, model: Model, conditions: SteadyConditions) -> "LegProblem":
        return cls(coefficient_prior(model, "held"), conditions.shared(model), conditions.left_over(model))

    @property
    def spreads(self) -> np.ndarray:
        return np.ones(len(UNKNOWN))

    @cached_property
    def scale(self) -> np.ndarray:
        """Change of every coefficient by the scaled ones, (n, p)."""
        names = self.prior.model.terms.names
        matrix = np.zeros((len(names), self.count))
        for place, group in enumerate(self.prior.groups):
            matrix[[names.index(name) for name in group], place] = self.prior.scale[place]
        return matrix

    def fit(self, readings: SteadyReadings) -> LegFit:
        legs, unknowns, converged = self._read(readings), np.zeros(len(self.precision)), False
        latent = legs.value[:, : len(LATENT)]
        for _ in range(UPDATE_ROUNDS):
            value, design, through = self._linear(legs, latent, unknowns)
            score = np.einsum("lqi,lq->i", design, value - design @ unknowns)
            information = np.einsum("lqi,lqj->ij", design, design)
            step, _ = bounded_step(self, unknowns, score, information)
            unknowns = unknowns + step
            rest = value - design @ unknowns
            # The readings less zeros and their share of the rest of the balance
            errors = legs.zeros @ (self.common * unknowns[self.count :])
            errors = errors - legs.size**2 * np.einsum("lqi,lq->li", through, rest)
            nearer = (legs.value - errors)[:, : len(LATENT)]
            near = np.allclose(nearer, latent, rtol=UPDATE_SETTLED, atol=UPDATE_SETTLED)
            latent, converged = nearer, bool(near and (np.abs(step) <= UPDATE_SETTLED).all())
            if converged:
                break
        chi_square = float(np.sum(rest**2) + unknowns @ self.precision @ unknowns)
        # The residual of a left-out leg is that of the fit over the part of its own error that no fit takes up.
        share = np.eye(rest.shape[1]) - design @ self.covariance(information) @ design.swapaxes(1, 2)
        left_out = np.einsum("lq,lq->l", rest, np.linalg.solve(share, rest[..., None])[..., 0])
        return LegFit(unknowns, information, latent, chi_square, left_out, rest.size, converged)

    def informations(self, readings: SteadyReadings) -> np.ndarray:
        """Return the information of each leg that is read exactly as here, (legs, P, P)."""
        legs = self._read(readings)
        design = self._linear(legs, legs.value[:, : len(LATENT)], np.zeros(len(self.precision)))[1]
        return np.asarray(design.swapaxes(1, 2) @ design)

    def _read(self, readings: SteadyReadings) -> LegReadings:
        names = ("y", "u", "rudder", *readings.directions)
        value, size = (np.stack([part[name] for name in names], axis=1) for part in (readings.values, readings.errors))
        zeros = np.array([[f"{name}_zero" == unknown for unknown in UNKNOWN] for name in names], float)
        model = self.prior.model
        given = sinkage_and_revolutions(model, readings.values["u"], readings.values)
        return LegReadings(value, size, zeros, SteadyBalance(model, given))

    def _linear(
        self, legs: LegReadings, latent: np.ndarray, unknowns: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return balances (legs, q) about states with independent errors of size one, and their slopes by unknowns
        (legs, q, P) and readings: value = design @ unknowns + error.
        """
        model = self.prior.model
        mean = np.array([model.coefficients[name] for name in model.terms.names])
        slopes, by_turning, mass = legs.balance.slopes(latent, mean + self.scale @ unknowns[: self.count])
        columns, again = legs.balance.columns(latent), legs.value.shape[1] - len(LATENT)
        through = np.zeros((len(latent), len(BALANCED) + again, legs.value.shape[1]))
        through[:, FORCES, : len(LATENT)] = slopes
        through[:, len(BALANCED) :, -2:] = -1.0, 1.0  # Two readings of the direction are equal.
        common = -through @ legs.zeros
        common[:, FORCES, FORCES] += np.eye(len(BALANCED))  # Slopes by the wind
        design = np.zeros((*through.shape[:2], len(unknowns)))
        design[:, FORCES, : self.count] = columns @ self.scale
        design[:, :, self.count :] = common * self.common
        covariance = np.einsum("lqi,li,lri->lqr", through, legs.size**2, through)
        # What wind and a rest of motion leave out of balance
        moved, turned = mass * self.left_over[3:], self.left_over[2] * by_turning
        covariance[:, FORCES, FORCES] += np.diag(self.left_over[:2] ** 2) + moved @ np.swapaxes(moved, 1, 2)
        covariance[:, FORCES, FORCES] += turned[:, :, None] * turned[:, None]
        off = legs.value - np.concatenate([latent, latent[:, -1:].repeat(again, axis=1)], axis=1)
        value = -np.einsum("lqi,li->lq", through, off)
        value[:, FORCES] -= columns @ mean
        try:
            root = np.linalg.cholesky(covariance)
        except np.linalg.LinAlgError:
            raise InputError(UNLIKE) from None
        white = [np.linalg.solve(root, own) for own in (value[..., None], design, through)]
        return white[0][..., 0], white[1], white[2]


@dataclass(frozen=True)
class SteadyBalance:
    """Sway force and yaw moment along a straight course: the sway velocity goes with heading and speed."""

    model: Model  # With terms of a rudder
    given: Mapping[str, np.ndarray]  # (legs,) Heave [m], and revolutions [1/s] if the terms need them

    @cached_property
    def _ship(self) -> SimulatedShip:
        return SimulatedShip(self.model)

    def columns(self, latent: np.ndarray) -> np.ndarray:
        """Return what multiplies each coefficient in sway force and yaw moment, (legs, 2, coefficients)."""
        (y, u, rudder, psi), terms = latent.T, self.model.terms
        values = {**self._ship.values(), **Motion.at(psi, y=y, u=u, v=-u * np.tan(psi)).values(), **self.given}
        values |= next(actuator for actuator in terms.actuators if actuator.name == "rudder").placed(rudder)
        columns = np.zeros((len(latent), len(BALANCED), len(terms.names)))
        for row, force in enumerate(BALANCED):
            for term in terms.forces[force]:
                columns[:, row, terms.names.index(term.name)] = term.column(values)
        return columns

    def slopes(self, latent: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return slopes by ``LATENT`` (legs, 2, 4) and by the yaw rate (legs, 2), and the mass (legs, 2, 2)."""
        named = dict(zip(self.model.terms.names, coefficients.tolist(), strict=True))
        linear = self._ship.linearisation({**self._ship.values(), **self.given, **named})
        y, u, rudder, psi = latent.T
        at = {"y": y, "u": u, "v": -u * np.tan(psi), "psi": psi, "rudder": rudder, **self.given}
        # The rates are the forces over the mass, which no place changes.
        rates = linear.linear(at)[:, [LINEARISED.index(velocity) for velocity in BALANCED.values()]]
        names = (*LINEARISED, *linear.controlled)
        mass = np.linalg.inv(rates[:, :, [names.index("Y_in"), names.index("N_in")]])
        by = dict(zip(names, np.moveaxis(mass @ rates, 2, 0), strict=True))
        by_u = by["u"] - by["v"] * np.tan(psi)[:, None]
        by_psi = by["psi"] - by["v"] * (u / np.cos(psi) ** 2)[:, None]
        return np.stack([by["y"], by_u, by["rudder"], by_psi], axis=-1), by["r"], mass


def sinkage_and_revolutions(model: Model, speeds: np.ndarray, read: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return heave [m], and revolutions [1/s] if the terms need them, by the speed of legs (legs,) [m/s]."""
    each, place = np.unique(speeds, return_inverse=True)
    given = {"heave": read["heave"] if "heave" in read else keel_at(model, each).midship[place]}
    if model.terms.propelled:
        given["revolutions"] = (
            read["revolutions"] if "revolutions" in read
            else np.array([self_propulsion(model, speed) for speed in each.tolist()])[place]
        )  # fmt: skip
    return given
