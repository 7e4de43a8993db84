"""What pairs of steady legs would tell, one to either side, before any is held."""

from dataclasses import dataclass

import numpy as np

from narrows.logbook.steady_legs.leg_readings import LegReadings
from narrows.logbook.steady_legs.steady_balance import SteadyBalance, felt_on
from narrows.logbook.steady_legs.steady_candidates import Candidates
from narrows.logbook.steady_legs.steady_conditions import SteadyConditions
from narrows.logbook.steady_legs.steady_readings import ReadingErrors, SteadyReadings
from narrows.logbook.steady_legs.steady_update import steady_prior
from narrows.model.model import Model


@dataclass(frozen=True)
class PairDesign:
    """Legs as readings with independent errors of size one, of independent unknowns of size one."""

    root: np.ndarray  # (n, rank) Of the covariance of the unknowns before: ``root`` times the independent ones
    rows: np.ndarray  # (pairs, 2, 2, rank) Of sway and yaw on the leg to starboard and on that to port

    def chosen(self, wanted: list[int], pairs: int) -> list[int]:
        """Return pairs that leave least of wanted variances: greedily the best next one, then each exchanged."""
        best: list[int] = []
        for _ in range(pairs if len(self.rows) else 0):
            best.append(self._next(best, wanted))
        for place in range(len(best)):
            best[place] = self._next(best[:place] + best[place + 1 :], wanted)
        return best

    def roots_after(self, order: list[int]) -> np.ndarray:
        """Return roots of the covariance before the first leg and after each, (legs + 1, n, rank)."""
        legs = self.rows[order].reshape(-1, 2, self.rows.shape[-1])
        inners = [self._inner(legs[:count]) for count in range(len(legs) + 1)]
        return np.array([np.linalg.solve(inner, self.root.T).T for inner in inners])

    def _inner(self, legs: np.ndarray) -> np.ndarray:
        """A root of the information about the independent unknowns."""
        rows = legs.reshape(-1, self.rows.shape[-1])
        return np.linalg.cholesky(np.eye(rows.shape[1]) + rows.T @ rows)

    def _next(self, held: list[int], wanted: list[int]) -> int:
        inner = self._inner(self.rows[held])
        now = np.linalg.solve(inner, self.root[wanted].T)
        seen = np.linalg.solve(inner, self.rows.reshape(len(self.rows), -1, self.rows.shape[-1]).swapaxes(1, 2))
        more = np.eye(seen.shape[2]) + seen.swapaxes(1, 2) @ seen
        gain = np.linalg.solve(np.linalg.cholesky(more), seen.swapaxes(1, 2) @ now)
        before = np.sum(self.root[wanted] ** 2, axis=1)
        left = np.sum(now**2, axis=0) - np.sum(gain**2, axis=1)
        return int((left / np.where(before > 0, before, np.inf)).sum(axis=1).argmin())


def pair_design(
    model: Model, found: Candidates, allowed: np.ndarray, errors: ReadingErrors, conditions: SteadyConditions
) -> PairDesign:
    """Return what pairs of legs would tell."""
    # allowed (pairs,)
    prior = steady_prior(model, conditions)
    if not allowed.size:
        return PairDesign(prior.root, np.zeros((0, 2, 2, prior.root.shape[1])))
    values = {name: np.concatenate([column[allowed], sign * column[allowed]])
              for name, column, sign in (("y", found.offsets, -1), ("u", found.speeds, 1),
                                         ("rudder", found.rudder, -1), ("drift", found.psi, -1))}  # fmt: skip
    size = {name: np.full(2 * len(allowed), errors.of(name)) for name in values}
    read = LegReadings.of(SteadyReadings(tuple(map(str, range(2 * len(allowed)))), values, size))
    balance = SteadyBalance(model, felt_on(model, values["u"], {}))
    blocks, _ = read.blocks(balance, read.first(), prior.mean, conditions.left_over(model))
    rows = blocks.whitened()[1] @ prior.root
    return PairDesign(prior.root, np.stack([rows[: len(allowed)], rows[len(allowed) :]], axis=1))
