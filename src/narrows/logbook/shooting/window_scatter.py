"""Whether windows disagree by more than their noise: what each says of the coefficients, beside what it should.

What a model gets wrong it gets wrong all through a window and in all signals at once, so that no signal by itself tells
how much less its readings count.
"""

from collections.abc import Iterable

import numpy as np

from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.window_equations import START_SPREAD, WindowEquations

# Information of a combination of coefficients, over that of the prior, from which windows are asked about it.
TELLS = 1.0
# Windows at least for each combination that they are asked about.
EACH = 4


def overdispersion(problem: LogProblem, windows: Iterable[WindowEquations]) -> float:
    """Return how much larger the squares of windows' pulls are than their noise alone would make them [1]."""
    # At the best coefficients the pulls of windows on them add up to that of the prior; how they scatter is the part
    # of the noise that does not average within a window. One where there are too few windows to say.
    # White (1982), Maximum likelihood estimation of misspecified models, Econometrica 50, for the two matrices;
    # McCullagh and Nelder (1989), Generalized Linear Models, section 9.2, for one factor.
    parts = [_of_record(problem, found) for found in windows]
    if not parts:
        return 1.0
    scatter, information, count = (sum(column) for column in zip(*parts, strict=True))
    sizes, axes = np.linalg.eigh(information)
    told = np.flatnonzero(sizes > TELLS)[::-1][: count // EACH]
    if not told.size:
        return 1.0
    ratios = np.einsum("ij,ik,kj->j", axes, scatter, axes)[told] / sizes[told]
    return float(ratios.mean() * count / (count - told.size))


def _of_record(problem: LogProblem, found: WindowEquations) -> tuple[np.ndarray, np.ndarray, int]:
    """Squares of pulls, information, and the number of windows, their starts at their best."""
    border = problem.local + len(problem.zeros)
    own = found.hessian[:, :6, :6] + np.diag(START_SPREAD**-2.0)
    with_start = found.hessian[:, :6, border:]
    by_start = np.linalg.solve(own, with_start)
    turned = np.swapaxes(by_start, 1, 2)
    information = found.hessian[:, border:, border:] - turned @ with_start
    pulls = found.gradient[:, border:] - np.einsum("kai,ki->ka", turned, found.gradient[:, :6])
    return pulls.T @ pulls, information.sum(axis=0), len(pulls)
