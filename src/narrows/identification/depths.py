"""Test whether a coefficient of the bank is the same at every depth."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from narrows.identification.estimates import HALF, estimates
from narrows.identification.least_squares import Problem
from narrows.identification.motions import DistinctMotions, distinct_motions
from narrows.identification.normal_equations import NormalEquations
from narrows.identification.run_errors import RunErrors
from narrows.results.base_results import with_error
from narrows.ship.particulars import Configuration

# Significance level of the chi-square test of equal coefficients [1].
DIFFERENT = 0.05


@dataclass(frozen=True)
class DepthTest:
    """A coefficient at each depth by itself, and the test of whether it is one."""

    values: Mapping[float, float]  # Depth [m]: estimate from the tests at that depth alone, in the coefficient's unit
    std: Mapping[float, float]  # Depth [m]: its standard error, in the coefficient's unit
    chi2: float  # Sum of squared distances from their weighted mean, each over its standard error [1]
    p: float  # Probability of as much, were it one coefficient [1]

    @property
    def changes(self) -> bool:
        """True where the coefficient differs between depths by more than its errors allow."""
        return self.p < DIFFERENT

    def sentence(self, name: str) -> str:
        """One sentence of the result."""
        values = ", ".join(f"{with_error(value, self.std[h])} at {h:.4g} m" for h, value in self.values.items())
        word = "it changes with the depth" if self.changes else "no change with the depth is seen"
        return f"{name} by each depth alone is {values}: {word} (p = {self.p:.2g})."


def depth_tests(
    equations: NormalEquations, motions: DistinctMotions, problem: Problem, errors: RunErrors,
    configuration: Configuration,
) -> dict[str, DepthTest]:  # fmt: skip
    """Compare the bank's coefficients by the tests at each depth; empty where there is one depth."""
    bank = [i for i, term in enumerate(problem.terms.terms) if term.from_bank]
    depth, group = motions.features["depth"], motions.level("depth")
    if group.max() == 0 or not bank:
        return {}
    by_depth = {}
    for number in range(int(group.max()) + 1):
        names = {name for i in np.flatnonzero(group == number) for name in motions.members[i]}
        part = _of_tests(equations, names)
        by_depth[round(float(depth[group == number].mean()), 9)] = estimates(
            part, distinct_motions(part), problem, errors, configuration
        )
    tests = {}
    for i in bank:
        values = {h: float(by_depth[h].free_values[i]) for h in sorted(by_depth)}
        std = {h: float(by_depth[h].free_half[i]) / HALF for h in values}
        tests[problem.terms.names[i]] = _compared(values, std)
    return tests


def _of_tests(equations: NormalEquations, names: set[str]) -> NormalEquations:
    keep = np.array([name in names for name in equations.tests])
    return replace(
        equations,
        sums=equations.sums[keep],
        tests=tuple(name for name in equations.tests if name in names),
        moved={name: moments[keep] for name, moments in equations.moved.items()},
        weights=None if equations.weights is None else equations.weights[keep],
    )


def _compared(values: dict[float, float], std: dict[float, float]) -> DepthTest:
    from scipy.special import chdtrc

    value, error = np.array(list(values.values())), np.array(list(std.values()))
    mean = (value / error**2).sum() / (1 / error**2).sum()
    chi2 = float((((value - mean) / error) ** 2).sum())
    return DepthTest(values, std, chi2, float(chdtrc(len(value) - 1, chi2)))
