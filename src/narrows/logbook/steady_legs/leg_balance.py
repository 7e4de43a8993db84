"""Coefficients from steady legs: the balance of sway and yaw, linear in the coefficients, between readings with errors.

The legs' true offsets, speeds and angles are unknown too. With a leg's readings ``m = l + zeros + e`` and the balance
``f(l, coefficients) + wind + rest = 0``, the balance is linear about the best l so far, and its error is that of the
readings through its slopes (Gauss-Helmert least squares). Each leg then has a score and an information matrix, as a
record of a log has, and the search and the posterior are those of logs.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.codegen.linearisation import LINEARISED
from narrows.errors import InputError
from narrows.logbook.filtering.log_problem import CoefficientPrior, Unknowns
from narrows.logbook.filtering.search import bounded_step
from narrows.logbook.learning.log_posterior import posterior_covariance
from narrows.logbook.learning.log_prior import coefficient_prior
from narrows.logbook.settings import UPDATE_ROUNDS, UPDATE_SETTLED
from narrows.logbook.steady_legs.steady_readings import UNKNOWN, SteadyConditions, SteadyReadings
from narrows.model.model import Model
from narrows.quantities.names import Number
from narrows.safety.request import keel_at
from narrows.ship.motion import Motion
from narrows.simulation.self_propulsion import self_propulsion
from narrows.simulation.ship import SimulatedShip

# True state of a leg, of which its readings are readings.
LATENT = ("y", "u", "rudder", "psi")
# Forces in balance on a steady leg, and the velocity whose rate each makes.
BALANCED = {"Y": "v", "N": "r"}
# Which of ``UNKNOWN`` adds to a reading.
ZEROS = {"rudder": 2, "drift": 3, "heading": 4, "y": 5}
UNLIKE = (
    "errors of these readings are beyond all measure, or differ by too many powers of ten; check each, and its unit"
)


@dataclass(frozen=True)
class LegFit:
    """Most likely coefficients and common errors, and how far each leg agrees."""

    unknowns: np.ndarray  # (P,) Scaled coefficients, then ``UNKNOWN`` over their standard deviations
    information: np.ndarray  # (P, P)
    latent: np.ndarray  # (legs, 4) Most likely ``LATENT``
    chi_square: float  # Chi-square of the readings under the prior [1]
    left_out: np.ndarray  # (legs,) The part of it that is gone without each leg [1]
    counted: int  # Degrees of freedom
    converged: bool


@dataclass(frozen=True)
class LegProblem(Unknowns):
    """Unknowns of steady legs: coefficients, then common errors over their standard deviations."""

    model: Model  # With terms of a rudder
    prior: CoefficientPrior
    common: np.ndarray  # (6,) Standard deviations of ``UNKNOWN``
    left_over: np.ndarray  # (5,) ``SteadyConditions.left_over``

    @classmethod
    def of(cls, model: Model, conditions: SteadyConditions) -> "LegProblem":
        """Return the unknowns of a model with its covariance."""
        prior = coefficient_prior(model, np.asarray(model.covariance), "held")
        return cls(model, prior, conditions.shared(model), conditions.left_over(model))

    @property
    def spreads(self) -> np.ndarray:
        """Prior standard deviations of the common errors, over themselves."""
        return np.ones(len(UNKNOWN))

    @cached_property
    def scale(self) -> np.ndarray:
        """Change of coefficients and common errors, each in its own unit, by the unknowns, (n + 6, P)."""
        names = self.model.terms.names
        matrix = np.zeros((len(names) + len(UNKNOWN), self.count + len(UNKNOWN)))
        for place, group in enumerate(self.prior.groups):
            matrix[[names.index(name) for name in group], place] = self.prior.scale[place]
        matrix[len(names) :, self.count :] = np.diag(self.common)
        return matrix

    def values(self, unknowns: np.ndarray) -> np.ndarray:
        """Return coefficients and common errors, each in its own unit, (n + 6,)."""
        mean = [self.model.coefficients[name] for name in self.model.terms.names]
        return np.asarray(np.append(mean, np.zeros(len(UNKNOWN))) + self.scale @ unknowns)

    def fit(self, readings: SteadyReadings) -> LegFit:
        """Search the most likely coefficients, common errors and true states of the legs."""
        legs = LegReadings.of(self, readings)
        latent, unknowns, converged = legs.first, np.zeros(len(self.precision)), False
        for _ in range(UPDATE_ROUNDS):
            about = legs.linear(latent, self.values(unknowns), self.left_over)
            value, design = about.whitened(self)
            rest = value - design @ unknowns
            information = np.einsum("lqi,lqj->ij", design, design)
            step, _ = bounded_step(self, unknowns, np.einsum("lqi,lq->i", design, rest), information)
            unknowns = unknowns + step
            nearer = legs.corrected(about, self.values(unknowns))
            near = np.allclose(nearer, latent, rtol=UPDATE_SETTLED, atol=UPDATE_SETTLED)
            latent, converged = nearer, bool(near and (np.abs(step) <= UPDATE_SETTLED).all())
            if converged:
                break
        rest = value - design @ unknowns
        chi_square = float(np.sum(rest**2) + unknowns @ self.precision @ unknowns)
        # The residual of a left-out leg is that of the fit over the part of its own error that no fit takes up.
        share = np.eye(legs.balances) - design @ posterior_covariance(self, information) @ design.swapaxes(1, 2)
        left_out = np.einsum("lq,lq->l", rest, np.linalg.solve(share, rest[..., None])[..., 0])
        return LegFit(unknowns, information, latent, chi_square, left_out, len(readings) * legs.balances, converged)

    def informations(self, readings: SteadyReadings) -> np.ndarray:
        """Return the information of each leg that is read exactly as here, (legs, P, P)."""
        legs = LegReadings.of(self, readings)
        about = legs.linear(legs.first, self.values(np.zeros(len(self.precision))), self.left_over)
        design = about.whitened(self)[1]
        return np.asarray(design.swapaxes(1, 2) @ design)


@dataclass(frozen=True)
class LinearLegs:
    """The balance about states of the legs: value = design @ (coefficients, common errors) + error."""

    value: np.ndarray  # (legs, q)
    design: np.ndarray  # (legs, q, n + 6)
    covariance: np.ndarray  # (legs, q, q) Covariance of the error
    through: np.ndarray  # (legs, q, readings) Slopes by the readings

    def whitened(self, problem: LegProblem) -> tuple[np.ndarray, np.ndarray]:
        """Return values and design by the unknowns, with independent errors of size one."""
        try:
            root = np.linalg.cholesky(self.covariance)
        except np.linalg.LinAlgError:
            raise InputError(UNLIKE) from None
        mean = problem.values(np.zeros(problem.scale.shape[1]))
        value = np.linalg.solve(root, (self.value - self.design @ mean)[..., None])[..., 0]
        return value, np.linalg.solve(root, self.design @ problem.scale)


@dataclass(frozen=True)
class LegReadings:
    """Readings of legs with their errors."""

    balance: "SteadyBalance"
    value: np.ndarray  # (legs, 4 or 5) Readings
    size: np.ndarray  # (legs, 4 or 5) Standard deviations
    zeros: tuple[int | None, ...]  # Which of ``UNKNOWN`` adds to each column

    @classmethod
    def of(cls, problem: LegProblem, readings: SteadyReadings) -> "LegReadings":
        """Return the readings as columns."""
        names = ("y", "u", "rudder", *readings.directions)
        value, size = (np.stack([part[name] for name in names], axis=1) for part in (readings.values, readings.errors))
        given = sinkage_and_revolutions(problem.model, readings.values["u"], readings.values)
        return cls(SteadyBalance(problem.model, given), value, size, tuple(ZEROS.get(name) for name in names))

    @property
    def balances(self) -> int:
        """Number of balances of a leg: sway and yaw, and one for equal directions."""
        return int(self.value.shape[1]) - len(LATENT) + len(BALANCED)

    @property
    def first(self) -> np.ndarray:
        """The readings as states."""
        return self.value[:, : len(LATENT)]

    def linear(self, latent: np.ndarray, values: np.ndarray, left_over: np.ndarray) -> LinearLegs:
        """Return the balances about states (legs, 4), at coefficients and common errors (n + 6,)."""
        count, forces = len(values) - len(UNKNOWN), slice(len(BALANCED))
        slopes, by_turning, mass = self.balance.slopes(latent, values[:count])
        through = np.zeros((len(self.value), self.balances, self.value.shape[1]))
        through[:, forces, : len(LATENT)] = slopes
        if self.balances > len(BALANCED):
            through[:, -1, -2:] = -1.0, 1.0
        design = np.zeros((len(self.value), self.balances, len(values)))
        design[:, forces, :count] = self.balance.columns(latent)
        design[:, forces, count : count + len(BALANCED)] = np.eye(len(BALANCED))
        for column, zero in enumerate(self.zeros):
            if zero is not None:
                design[:, :, count + zero] -= through[:, :, column]
        covariance = np.einsum("lqi,li,lri->lqr", through, self.size**2, through)
        # What wind and a rest of motion leave out of balance
        moved, turned = mass * left_over[3:], left_over[2] * by_turning
        covariance[:, forces, forces] += np.diag(left_over[:2] ** 2) + moved @ np.swapaxes(moved, 1, 2)
        covariance[:, forces, forces] += turned[:, :, None] * turned[:, None]
        # Readings without errors: the direction as often as it is read
        again = latent[:, len(LATENT) - 1 :].repeat(self.value.shape[1] - len(LATENT), axis=1)
        off = self.value - np.concatenate([latent, again], axis=1)
        return LinearLegs(-np.einsum("lqi,li->lq", through, off), design, covariance, through)

    def corrected(self, about: LinearLegs, values: np.ndarray) -> np.ndarray:
        """Return the most likely states: the readings less zeros and their share of the rest of the balance."""
        rest = about.value - about.design @ values
        weighed = np.linalg.solve(about.covariance, rest[..., None])[..., 0]
        errors = -(self.size**2) * np.einsum("lqi,lq->li", about.through, weighed)
        common = values[len(values) - len(UNKNOWN) :]
        zeros = np.array([0.0 if zero is None else common[zero] for zero in self.zeros])
        return np.asarray((self.value - zeros - errors)[:, : len(LATENT)])


@dataclass(frozen=True)
class SteadyBalance:
    model: Model  # With terms of a rudder
    given: Mapping[str, np.ndarray]  # (legs,) Heave [m], and revolutions [1/s] if the terms need them

    @cached_property
    def _ship(self) -> SimulatedShip:
        return SimulatedShip(self.model)

    @cached_property
    def _particulars(self) -> dict[str, Number]:
        return {**self._ship.values(), **self.given}

    def columns(self, latent: np.ndarray) -> np.ndarray:
        """Return what multiplies each coefficient in sway force and yaw moment, (legs, 2, coefficients)."""
        names = self.model.terms.names
        values, columns = self._values(latent), np.zeros((len(latent), len(BALANCED), len(names)))
        for row, force in enumerate(BALANCED):
            for term in self.model.terms.forces[force]:
                columns[:, row, names.index(term.name)] = term.column(values)
        return columns

    def slopes(self, latent: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return slopes by ``LATENT`` (legs, 2, 4) and by the yaw rate (legs, 2), and the mass (legs, 2, 2)."""
        # latent (legs, 4); coefficients (coefficients,)
        # Along a straight course: the sway velocity goes with heading and speed.
        named = dict(zip(self.model.terms.names, coefficients.tolist(), strict=True))
        linear = self._ship.linearisation({**self._particulars, **named})
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

    def _values(self, latent: np.ndarray) -> dict[str, Number]:
        y, u, rudder, psi = latent.T
        values = {**self._particulars, **Motion.at(psi, y=y, u=u, v=-u * np.tan(psi)).values(), **self.given}
        for actuator in self.model.terms.actuators:
            if actuator.name == "rudder":
                values |= actuator.placed(rudder)
        return values


def sinkage_and_revolutions(model: Model, speeds: np.ndarray, read: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return heave [m], and revolutions [1/s] if the terms need them, by the speed of legs."""
    # speeds (legs,) [m/s]
    each, place = np.unique(speeds, return_inverse=True)
    given = {"heave": read["heave"] if "heave" in read else keel_at(model, each).midship[place]}
    if model.terms.propelled:
        turns = read.get("revolutions")
        if turns is None:
            turns = np.array([self_propulsion(model, speed) for speed in each.tolist()])[place]
        given["revolutions"] = turns
    return given
