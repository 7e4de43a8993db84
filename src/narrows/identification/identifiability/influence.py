"""Which test tells of which coefficient, and which one moves it: the fit with each test left out."""

from dataclasses import dataclass

import numpy as np

from narrows.errors import InputError, did_you_mean
from narrows.identification.regression.batch import RIDGE, solve_many
from narrows.identification.regression.normal_equations import NormalEquations
from narrows.identification.regression.problem import Problem


@dataclass(frozen=True)
class Influence:
    """What each test does to each coefficient.

    Parameters
    ----------
    tests : tuple of str
        The tests.
    names : tuple of str
        The coefficients.
    information : array (tests, n) [1]
        Share of what is known of a coefficient that is gone without the test: 1 less the ratio of the variance with
        all tests to the variance without this one.
    moved : array (tests, n)
        How far the test moves the constrained estimate, in the coefficient's unit.
    """

    tests: tuple[str, ...]
    names: tuple[str, ...]
    information: np.ndarray
    moved: np.ndarray

    def most_informing(self, name: str) -> tuple[str, float]:
        """Return the test that a coefficient would miss most, and the share of what is known that goes with it [1].

        Parameters
        ----------
        name : str
            A coefficient.
        """
        column = self.information[:, self._place(name)]
        return self.tests[int(column.argmax())], float(column.max())

    def most_moving(self, name: str) -> tuple[str, float]:
        """Return the test that moves a coefficient most, and how far, in the coefficient's unit.

        Parameters
        ----------
        name : str
            A coefficient.
        """
        column = self.moved[:, self._place(name)]
        most = int(np.abs(column).argmax())
        return self.tests[most], float(column[most])

    def of(self, name: str) -> dict[str, str | float]:
        """Give the test that a coefficient would miss most and the one that moves it most.

        Parameters
        ----------
        name : str
            A coefficient.
        """
        (informing, share), (moving, by) = self.most_informing(name), self.most_moving(name)
        return {"most_informing": informing, "share": share, "most_moving": moving, "moved_by": by}

    def _place(self, name: str) -> int:
        if name not in self.names:
            raise InputError(f"unknown coefficient {name!r}{did_you_mean(name, self.names)}")
        return self.names.index(name)


def influence(problem: Problem, equations: NormalEquations) -> Influence:
    """Leave out each test in turn (ours).

    Parameters
    ----------
    problem : Problem
        The joint problem.
    equations : NormalEquations
        The sums.
    """
    tests = equations.by_test()
    total = tests.sum(axis=0)
    h, g = problem.normal(np.concatenate([total[None], total - tests]))
    z = solve_many(h, g, problem.lower, problem.upper)
    variance = np.diagonal(np.linalg.inv(h + RIDGE * np.eye(h.shape[-1])), axis1=1, axis2=2)
    slots = [problem.slot[name] for name in problem.terms.names]
    known = np.where(np.diag(h[0]) > 0, 1 - variance[0] / variance[1:], 0.0)
    moved = problem.coefficients(z[0] - z[1:])
    return Influence(equations.names, problem.terms.names, np.clip(known, 0.0, 1.0)[:, slots], moved)
