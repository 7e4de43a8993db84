"""Influence of each distinct motion: the jackknife, one motion and its repeats left out at a time."""

from dataclasses import dataclass

import numpy as np

from narrows.errors import InputError, did_you_mean
from narrows.identification.estimates import CoefficientEstimates
from narrows.identification.left_out import information_gone
from narrows.identification.motions import DistinctMotions
from narrows.identification.regression.problem import Problem
from narrows.identification.regression.solve import solve_many


@dataclass(frozen=True)
class Influence:
    """Influence of each distinct motion on each coefficient."""

    tests: tuple[str, ...]  # The motions, each called by its first test and the number of its repeats
    names: tuple[str, ...]  # The coefficients
    # (tests, n) Share of what is known of a coefficient that is gone without the test: 1 less the ratio of the
    # variance with all tests to the variance without this one [1]
    information: np.ndarray
    moved: np.ndarray  # (tests, n) Change of the constrained estimate by the test, in the coefficient's unit

    def most_informing(self, name: str) -> tuple[str, float]:
        """Return the test that a coefficient would miss most, and the share of what is known that goes with it [1]."""
        column = self.information[:, self._place(name)]
        return self.tests[int(column.argmax())], float(column.max())

    def most_moving(self, name: str) -> tuple[str, float]:
        """Return the test that moves a coefficient most, and how far, in the coefficient's unit."""
        column = self.moved[:, self._place(name)]
        most = int(np.abs(column).argmax())
        return self.tests[most], float(column[most])

    def of(self, name: str) -> dict[str, str | float]:
        """Give the test that a coefficient would miss most and the one that moves it most."""
        (informing, share), (moving, by) = self.most_informing(name), self.most_moving(name)
        return {"most_informing": informing, "share": share, "most_moving": moving, "moved_by": by}

    def _place(self, name: str) -> int:
        if name not in self.names:
            raise InputError(f"unknown coefficient {name!r}{did_you_mean(name, self.names)}")
        return self.names.index(name)


def influence(problem: Problem, motions: DistinctMotions, found: CoefficientEstimates) -> Influence:
    """Leave out each distinct motion in turn."""
    h, g = problem.normal(np.concatenate([motions.sums.sum(axis=0)[None], motions.without]))
    z = solve_many(h, g, problem.lower, problem.upper)
    gone = np.zeros((len(motions), len(problem.scale)))
    for part in found.forces:
        gone[:, part.slots] = information_gone(part, motions)
    slots = [problem.slot[name] for name in problem.terms.names]
    return Influence(motions.labels, problem.terms.names, gone[:, slots], problem.coefficients(z[0] - z[1:]))
