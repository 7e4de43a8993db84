"""Coefficients from steady legs: the balance of sway and yaw, linear in the coefficients, between readings with errors.

The legs' true offsets, speeds and angles are unknown too. With a row's reading ``m = l + zeros + e`` and the balance
``f(l, coefficients) + wind + rest = 0``, the balance is written out about the best l so far and its error is that of
the readings through its slopes (Gauss and Helmert's form of least squares); the best l is found anew until nothing
moves.
"""

from dataclasses import dataclass

import numpy as np

from narrows.logbook.learned_model import Blocks, NormalPrior, Posterior, updated
from narrows.logbook.steady_legs.steady_balance import BALANCED, LATENT, SteadyBalance, felt_on
from narrows.logbook.steady_legs.steady_readings import UNKNOWN, SteadyConditions, SteadyReadings
from narrows.model.model import Model

# Of standard deviations, by which the last round may still move anything.
ROUNDS, SETTLED = 50, 1e-6


@dataclass(frozen=True)
class SteadyUpdate:
    """What the legs tell."""

    posterior: Posterior  # Of the coefficients, then of ``UNKNOWN``
    latent: np.ndarray  # (legs, 4) Where the ship truly was, most likely: ``LATENT``
    settled: bool  # Whether the rounds came to rest
    counted: int  # Of independent balances and readings: degrees of freedom of the sum of squares


def steady_prior(model: Model, conditions: SteadyConditions) -> NormalPrior:
    """Return what is known before: the model's coefficients with all of their covariance, and what legs share."""
    coefficients = np.array([model.coefficients[name] for name in model.terms.names])
    tests, shared = NormalPrior.of(coefficients, np.asarray(model.covariance)), conditions.shared(model)
    root = np.zeros((len(coefficients) + len(UNKNOWN), tests.root.shape[1] + len(UNKNOWN)))
    root[: len(coefficients), : tests.root.shape[1]] = tests.root
    root[len(coefficients) :, tests.root.shape[1] :] = np.diag(shared)
    return NormalPrior(np.concatenate([coefficients, np.zeros(len(UNKNOWN))]), root)


@dataclass(frozen=True)
class SteadyProblem:
    """What legs are to update."""

    prior: NormalPrior  # Of the coefficients and ``UNKNOWN``
    balance: SteadyBalance  # Of the model on the legs
    bounds: np.ndarray  # (n, 2) Of the unknowns
    left_over: np.ndarray  # (5,) What is left on each leg, of ``SteadyConditions.left_over``

    @classmethod
    def of(cls, model: Model, readings: SteadyReadings, conditions: SteadyConditions) -> "SteadyProblem":
        """Return the problem of a model and legs."""
        balance = SteadyBalance(model, felt_on(model, readings.values["u"], readings.values))
        bounds = np.array([*(term.bound for term in model.terms.terms), *[(-np.inf, np.inf)] * len(UNKNOWN)])
        return cls(steady_prior(model, conditions), balance, bounds, conditions.left_over(model))

    def update(self, readings: SteadyReadings) -> SteadyUpdate:
        """Return what readings on these legs tell."""
        read, size, rounds, settled = LegReadings.of(readings), np.linalg.norm(self.prior.root, axis=1), 0, False
        latent, unknowns = read.first(), self.prior.mean
        while not settled and rounds < ROUNDS:
            blocks, through = read.blocks(self.balance, latent, unknowns, self.left_over)
            posterior = updated(self.prior, blocks, self.bounds)
            nearer = read.corrected(blocks, through, posterior.mean)
            moved = np.abs(posterior.mean - unknowns) <= SETTLED * size
            settled = bool(moved.all() and np.allclose(nearer, latent, rtol=SETTLED, atol=SETTLED))
            latent, unknowns, rounds = nearer, posterior.mean, rounds + 1
        return SteadyUpdate(posterior, latent, settled, len(readings) * read.balances)


# Legs as linear readings: the balances about where the ship was, and what errors of readings do to them.
# Which of ``UNKNOWN`` adds to a reading.
ZEROS = {"rudder": 2, "drift": 3, "heading": 4, "y": 5}


@dataclass(frozen=True)
class LegReadings:
    """Readings as columns: y, u, rudder, direction, and a second direction or none."""

    value: np.ndarray  # (legs, 4 or 5) Read, and standard deviations
    size: np.ndarray  # (legs, 4 or 5) Read, and standard deviations
    zeros: tuple[int | None, ...]  # Which of ``UNKNOWN`` adds to each column

    @classmethod
    def of(cls, readings: SteadyReadings) -> "LegReadings":
        """Return the columns of readings."""
        names = ("y", "u", "rudder", *readings.directions)
        value, size = (np.stack([part[name] for name in names], axis=1) for part in (readings.values, readings.errors))
        return cls(value, size, tuple(ZEROS.get(name) for name in names))

    @property
    def balances(self) -> int:
        """Of a leg: sway and yaw, and of two directions that they are one."""
        return int(self.value.shape[1]) - len(LATENT) + len(BALANCED)

    def first(self) -> np.ndarray:
        """Return where the ship was by the readings."""
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
        """What would be read without errors: the direction as often as it is read."""
        again = latent[:, len(LATENT) - 1 :].repeat(self.value.shape[1] - len(LATENT), axis=1)
        return np.concatenate([latent, again], axis=1)


def _left_over(by_turning: np.ndarray, mass: np.ndarray, left_over: np.ndarray) -> np.ndarray:
    """Covariance of what wind and a rest of motion leave out of balance, (legs, 2, 2)."""
    wind, turning, accelerations = left_over[:2], left_over[2], left_over[3:]
    moved, turned = mass * accelerations, turning * by_turning
    return np.asarray(np.diag(wind**2) + turned[:, :, None] * turned[:, None] + moved @ np.swapaxes(moved, 1, 2))
