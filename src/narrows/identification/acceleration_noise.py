"""Bias of the estimates by noise in the accelerations (errors in variables), where its size is unknown."""

import numpy as np

from narrows.captive.accelerations import RATES
from narrows.captive.tests import CaptiveTests, Tests
from narrows.identification.least_squares import Problem, Solution
from narrows.identification.normal_equations import NormalEquations

# Share of the size of the accelerations that is taken for noise.
SHARE = 0.1


def noise_bias(
    problem: Problem, solution: Solution, equations: NormalEquations, share: float = SHARE
) -> dict[str, float]:
    """Return how far white noise in the accelerations draws each coefficient from its value, to first order."""
    # The noise adds to the diagonal of H alone, and the solution moves by -H^-1 D z: attenuation, and what others take
    # over. Coefficients at a bound stay there.
    # Fuller (1987), Measurement Error Models, section 2.2.
    h, _ = problem.normal(equations.total)
    plain, _ = problem.normal(equations.unweighted.sum(axis=0))
    noisy = np.zeros(len(h))
    for term in problem.terms.terms:
        if term.inputs in [(rate,) for rate in RATES.values()]:
            noisy[problem.slot[term.name]] = share**2
    free = ~solution.at_bound
    moved = np.zeros(len(h))
    pull = noisy * np.diag(plain) * solution.z
    moved[free] = -np.linalg.pinv(h[np.ix_(free, free)], rcond=1e-12, hermitian=True) @ pull[free]
    return problem.named(moved)


def noise_sentence(tests: Tests, bias: dict[str, float], values: dict[str, float]) -> str:
    """Return the effect of noise in accelerations that no check covers; empty where time checks them."""
    if isinstance(tests, CaptiveTests) and "t" in tests.columns:
        return ""
    shifts = {
        name: bias[name] / values[name] for name in bias if values[name] and abs(bias[name] / values[name]) > 1e-3
    }
    if not shifts:
        return ""
    changes = ", ".join(
        f"{name} by {shift:+.1%}" for name, shift in sorted(shifts.items(), key=lambda pair: -abs(pair[1]))[:4]
    )
    return f"Without times in memory the noise in the accelerations is unknown; a tenth would change {changes}."
