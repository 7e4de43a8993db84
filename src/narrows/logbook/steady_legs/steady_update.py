"""Coefficients from steady legs: the balance of sway and yaw, linear in the coefficients, between readings with errors.

The legs' true offsets, speeds and angles are unknown too. With a row's reading ``m = l + zeros + e`` and the balance
``f(l, coefficients) + wind + rest = 0``, the balance is written out about the best l so far and its error is that of
the readings through its slopes (Gauss and Helmert's form of least squares); the best l is found anew until nothing
moves.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.codegen.linearisation import LINEARISED
from narrows.control.steady_course import self_propulsion
from narrows.logbook.learned_coefficient import Blocks, NormalPrior, Posterior, updated
from narrows.logbook.settings import UPDATE_ROUNDS, UPDATE_SETTLED
from narrows.logbook.steady_legs.steady_readings import UNKNOWN, SteadyConditions, SteadyReadings
from narrows.model.model import Model
from narrows.quantities.names import Number
from narrows.safety.request import keel_at
from narrows.ship.motion import Motion
from narrows.simulation.ship import SimulatedShip


@dataclass(frozen=True)
class SteadyUpdate:
    posterior: Posterior  # Posterior of the coefficients, then of ``UNKNOWN``
    latent: np.ndarray  # (legs, 4) Where the ship truly was, most likely: ``LATENT``
    settled: bool  # Whether the rounds came to rest
    counted: int  # Number of independent balances and readings: degrees of freedom of the sum of squares


def steady_prior(model: Model, conditions: SteadyConditions) -> NormalPrior:
    coefficients = np.array([model.coefficients[name] for name in model.terms.names])
    tests, shared = NormalPrior.of(coefficients, np.asarray(model.covariance)), conditions.shared(model)
    root = np.zeros((len(coefficients) + len(UNKNOWN), tests.root.shape[1] + len(UNKNOWN)))
    root[: len(coefficients), : tests.root.shape[1]] = tests.root
    root[len(coefficients) :, tests.root.shape[1] :] = np.diag(shared)
    return NormalPrior(np.concatenate([coefficients, np.zeros(len(UNKNOWN))]), root)


@dataclass(frozen=True)
class SteadyBalance:
    model: Model  # With terms of a rudder
    felt: Mapping[str, np.ndarray]  # (legs,) Heave [m], and revolutions [1/s] where the terms ask for them

    @cached_property
    def _ship(self) -> SimulatedShip:
        return SimulatedShip(self.model)

    @cached_property
    def _particulars(self) -> dict[str, Number]:
        return {**self._ship.values(), **self.felt}

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
        at = {"y": y, "u": u, "v": -u * np.tan(psi), "psi": psi, "rudder": rudder, **self.felt}
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
        values = {**self._particulars, **Motion.at(psi, y=y, u=u, v=-u * np.tan(psi)).values(), **self.felt}
        for actuator in self.model.terms.actuators:
            if actuator.name == "rudder":
                values |= actuator.placed(rudder)
        return values


@dataclass(frozen=True)
class SteadyProblem:
    prior: NormalPrior  # Prior of the coefficients and ``UNKNOWN``
    balance: SteadyBalance  # Steady balance of the model on the legs
    bounds: np.ndarray  # (n, 2) Bounds of the unknowns
    left_over: np.ndarray  # (5,) What is left on each leg, of ``SteadyConditions.left_over``

    @classmethod
    def of(cls, model: Model, readings: SteadyReadings, conditions: SteadyConditions) -> "SteadyProblem":
        balance = SteadyBalance(model, felt_on(model, readings.values["u"], readings.values))
        bounds = np.array([*(term.bound for term in model.terms.terms), *[(-np.inf, np.inf)] * len(UNKNOWN)])
        return cls(steady_prior(model, conditions), balance, bounds, conditions.left_over(model))

    def update(self, readings: SteadyReadings) -> SteadyUpdate:
        read, size, rounds, settled = LegReadings.of(readings), np.linalg.norm(self.prior.root, axis=1), 0, False
        latent, unknowns = read.first(), self.prior.mean
        while not settled and rounds < UPDATE_ROUNDS:
            blocks, through = read.blocks(self.balance, latent, unknowns, self.left_over)
            posterior = updated(self.prior, blocks, self.bounds)
            nearer = read.corrected(blocks, through, posterior.mean)
            moved = np.abs(posterior.mean - unknowns) <= UPDATE_SETTLED * size
            settled = bool(moved.all() and np.allclose(nearer, latent, rtol=UPDATE_SETTLED, atol=UPDATE_SETTLED))
            latent, unknowns, rounds = nearer, posterior.mean, rounds + 1
        return SteadyUpdate(posterior, latent, settled, len(readings) * read.balances)


# Which of ``UNKNOWN`` adds to a reading.
ZEROS = {"rudder": 2, "drift": 3, "heading": 4, "y": 5}


@dataclass(frozen=True)
class LegReadings:
    value: np.ndarray  # (legs, 4 or 5) Read, and standard deviations
    size: np.ndarray  # (legs, 4 or 5) Read, and standard deviations
    zeros: tuple[int | None, ...]  # Which of ``UNKNOWN`` adds to each column

    @classmethod
    def of(cls, readings: SteadyReadings) -> "LegReadings":
        names = ("y", "u", "rudder", *readings.directions)
        value, size = (np.stack([part[name] for name in names], axis=1) for part in (readings.values, readings.errors))
        return cls(value, size, tuple(ZEROS.get(name) for name in names))

    @property
    def balances(self) -> int:
        """Number of balances of a leg: sway and yaw, and one for equal directions."""
        return int(self.value.shape[1]) - len(LATENT) + len(BALANCED)

    def first(self) -> np.ndarray:
        return self.value[:, : len(LATENT)]

    def blocks(
        self, balance: SteadyBalance, latent: np.ndarray, unknowns: np.ndarray, left_over: np.ndarray
    ) -> tuple[Blocks, np.ndarray]:
        """Return the balances written out about places, and their slopes by what was read."""
        # latent (legs, 4); unknowns (n,); left_over (5,)
        count, forces = len(unknowns) - len(UNKNOWN), slice(len(BALANCED))
        slopes, by_turning, mass = balance.slopes(latent, unknowns[:count])
        through = np.zeros((len(self.value), self.balances, self.value.shape[1]))
        through[:, forces, : len(LATENT)] = slopes
        if self.balances > len(BALANCED):
            through[:, -1, -2:] = -1.0, 1.0
        design = np.zeros((len(self.value), self.balances, len(unknowns)))
        design[:, forces, :count] = balance.columns(latent)
        design[:, forces, count : count + len(BALANCED)] = np.eye(len(BALANCED))
        for column, zero in enumerate(self.zeros):
            if zero is not None:
                design[:, :, count + zero] -= through[:, :, column]
        covariance = np.einsum("lqi,li,lri->lqr", through, self.size**2, through)
        covariance[:, forces, forces] += _left_over(by_turning, mass, left_over)
        value = -np.einsum("lqi,li->lq", through, self.value - self._read_at(latent))
        return Blocks(value, design, covariance), through

    def corrected(self, blocks: Blocks, through: np.ndarray, unknowns: np.ndarray) -> np.ndarray:
        """Return where the ship was most likely: the readings less zeros and their share of what is out of balance."""
        # through (legs, balances, columns); unknowns (n,)
        rest = blocks.value - blocks.design @ unknowns
        errors = -(self.size**2) * np.einsum(
            "lqi,lq->li", through, np.linalg.solve(blocks.covariance, rest[..., None])[..., 0]
        )
        shared = unknowns[len(unknowns) - len(UNKNOWN) :]
        zeros = np.array([0.0 if zero is None else shared[zero] for zero in self.zeros])
        return np.asarray((self.value - zeros - errors)[:, : len(LATENT)])

    def _read_at(self, latent: np.ndarray) -> np.ndarray:
        """Return the readings without errors: the direction as often as it is read."""
        again = latent[:, len(LATENT) - 1 :].repeat(self.value.shape[1] - len(LATENT), axis=1)
        return np.concatenate([latent, again], axis=1)


def _left_over(by_turning: np.ndarray, mass: np.ndarray, left_over: np.ndarray) -> np.ndarray:
    """Covariance of what wind and a rest of motion leave out of balance, (legs, 2, 2)."""
    wind, turning, accelerations = left_over[:2], left_over[2], left_over[3:]
    moved, turned = mass * accelerations, turning * by_turning
    return np.asarray(np.diag(wind**2) + turned[:, :, None] * turned[:, None] + moved @ np.swapaxes(moved, 1, 2))


# What a leg is, truly: what its readings are readings of.
LATENT = ("y", "u", "rudder", "psi")
# Forces that a steady leg has in balance, and the velocity whose rate each makes.
BALANCED = {"Y": "v", "N": "r"}


def felt_on(model: Model, speeds: np.ndarray, told: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return what goes with the speed of legs: heave [m], and revolutions [1/s] where the terms ask for them."""
    # speeds (legs,) [m/s]
    each, place = np.unique(speeds, return_inverse=True)
    felt = {"heave": told["heave"] if "heave" in told else keel_at(model, each).midship[place]}
    if model.terms.propelled:
        turns = told.get("revolutions")
        if turns is None:
            turns = np.array([self_propulsion(model, speed) for speed in each.tolist()])[place]
        felt["revolutions"] = turns
    return felt
