"""Coefficients from steady legs: the balance of sway and yaw, linear in the coefficients, between readings with errors.

The legs' true offsets, speeds and angles are unknown too. With a row's reading ``m = l + zeros + e`` and the balance
``f(l, coefficients) + wind + rest = 0``, the balance is written out about the best l so far and its error is that of
the readings through its slopes (Gauss and Helmert's form of least squares); the best l is found anew until nothing
moves.
"""

from dataclasses import dataclass

import numpy as np

from narrows.logbook.gaussian_update import NormalPrior, Posterior, updated
from narrows.logbook.steady_legs.leg_readings import LegReadings
from narrows.logbook.steady_legs.steady_balance import SteadyBalance, felt_on
from narrows.logbook.steady_legs.steady_conditions import UNKNOWN, SteadyConditions
from narrows.logbook.steady_legs.steady_readings import SteadyReadings
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
