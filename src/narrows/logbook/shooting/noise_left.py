"""How noisy signals are, by what the model leaves of them, and how much of that is one and the same."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.search_state import Found
from narrows.logbook.shooting.window_equations import START_SPREAD, WindowEquations

# Correlation under which residuals are taken to have nothing to do with each other.
FORGOTTEN = 0.05

MOST_LAGS = 2000


@dataclass(frozen=True)
class NoiseLeft:
    """What is left of a signal."""

    # Standard deviation of a reading: 1.4826 times the median of sizes, which outliers do not move [unit of the
    # signal]
    size: float
    memory: float  # Readings for each independent one [1]
    beyond: float  # Share of readings beyond four of these standard deviations [1]

    @property
    def counted(self) -> float:
        """Standard deviation that readings are to be given for so many to tell what they tell."""
        return float(self.size * np.sqrt(self.memory))


def noise_left(grids: Iterable[RecordGrid], found: Found) -> dict[str, NoiseLeft]:
    """Return what is left of each signal over all records."""
    left: dict[str, list[np.ndarray]] = {}
    for grid, told in zip(grids, found.told, strict=False):  # Fewer were looked at where it was interrupted.
        for name, residual in (told.residuals or {}).items():
            left.setdefault(name, []).append(residual * np.sqrt(grid.readings[name].counted))
    return {name: _left(parts) for name, parts in left.items()}


def _left(parts: Sequence[np.ndarray]) -> NoiseLeft:
    whole = np.concatenate(parts)
    size = float(1.4826 * np.median(np.abs(whole))) or float(np.abs(whole).max(initial=0.0)) or 1e-12
    clipped = [np.clip(part, -4 * size, 4 * size) for part in parts]
    spread = float(np.sqrt(np.mean(np.concatenate(clipped) ** 2)))
    return NoiseLeft(spread, memory_of(clipped), float(np.mean(np.abs(whole) > 4 * size)))


def memory_of(parts: Sequence[np.ndarray]) -> float:
    """Return how many readings there are for each independent one [1]."""
    # parts (n,)
    # One and twice the sum of the autocorrelation, to where it is first forgotten.
    # Bayley and Hammersley (1946), The "effective" number of independent observations in an autocorrelated time
    # series.
    power = sum(float(part @ part) for part in parts)
    memory = 1.0
    for lag in range(1, MOST_LAGS):
        along = sum(float(part[lag:] @ part[:-lag]) for part in parts if len(part) > lag)
        if not power or along / power <= FORGOTTEN:
            break
        memory += 2 * along / power
    return memory


# Whether windows disagree by more than their noise: what each says of the coefficients, beside what it should. What a
# model gets wrong it gets wrong all through a window and in all signals at once, so that no signal by itself tells how
# much less its readings count.
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
