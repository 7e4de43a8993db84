"""Predict forces on rows of a table, with residuals and errors, and exact Shapley values of the terms."""

from collections.abc import Callable, Mapping
from math import factorial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

import narrows
from narrows.base.errors import check_choice
from narrows.base.results import BaseResult, Named
from narrows.captive.columns import check_given
from narrows.captive.read import Tests, as_tests
from narrows.identification.normal_equations import ONE, NormalEquations, Score, accumulate, score
from narrows.model.term import TermTable
from narrows.ship.ship_file import ShipSource

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class Prediction(BaseResult):
    """Predicted forces of rows, those of the fit or others."""

    def predict(self: Any, tests: Any = None, ship: ShipSource | None = None) -> "pd.DataFrame":
        """Estimate surge force [N], sway force [N] and yaw moment [N m] at each row."""
        return _rows(self, _or_own(self, tests, ship), measured=False)

    @property
    def residuals(self: Any) -> "pd.DataFrame":
        """Measured less estimated surge force [N], sway force [N] and yaw moment [N m], at each row of the fit."""
        return _rows(self, self.tests, measured=True)

    def plot_residuals(self: Any, ax: "Axes | None" = None, force: str | None = None) -> "Figure":
        """Draw the residuals of each force over its estimates, a colour for each test.

        With Axes ``ax``, one ``force`` is drawn there, ``X``, ``Y`` or ``N``; the first unless given. Raises an
        InputError where the fit has no such force.
        """
        return narrows.report.residuals_figure(self, ax, force)

    def score(self: Any, tests: Any = None, ship: ShipSource | None = None) -> dict[str, Score]:
        """Return R2 and RMSE of each force on other tests than those of the fit."""
        read = _or_own(self, tests, ship)
        equations, _ = accumulate(read, self.terms, balance=self.normal_equations.balance)
        return score(equations, equations.total, self.terms, self.coefficients)

    def report(self: Any, path: str | Path, title: str = "narrows") -> None:
        """Write one HTML page with everything that is known of it, its answer first."""
        narrows.report.write_report({"": self}, path, title)

    @property
    def condition_number(self: Any) -> dict[str, float]:
        """Condition number of each force's columns, each scaled to unit length [1]."""
        return Named({force: part.condition for force, part in self.diagnostics.overall.items()})

    @property
    def rsquared(self: Any) -> dict[str, float]:
        """R2 of each force on the rows of the fit [1]."""
        return {force: fitted.r2 for force, fitted in self.scores.items()}

    @property
    def rmse(self: Any) -> dict[str, float]:
        """Root mean squared error of each force on the rows of the fit [N, N, N m]."""
        return {force: fitted.rmse for force, fitted in self.scores.items()}

    @property
    def nobs(self: Any) -> int:
        """Number of rows of the fit."""
        equations: NormalEquations = self.normal_equations
        return round(float(equations.pick(equations.total, [ONE])[0, 0]))


def _or_own(fit: Any, tests: Any, ship: Any) -> Any:
    return fit.tests if tests is None else as_tests(tests, ship, fit.tests.configuration)


def _rows(fit: Any, tests: Tests, measured: bool) -> "pd.DataFrame":
    """Forces of each row as estimated, or what was measured beyond that."""
    import pandas as pd

    frames = []
    for block in tests.blocks(1):
        check_given(fit.terms.inputs, block.values, block.headers, fit.terms.actuators)
        names = np.repeat([span.test for span in block.spans], [span.stop - span.start for span in block.spans])
        rows = {"test": names} | {name: block.values[name] for name in ("t",) if name in block.values}
        for force, terms in fit.terms.forces.items():
            if terms:
                parts = (fit.coefficients[term.name] * term.column(block.values) for term in terms)
                estimated = np.broadcast_to(sum(parts, np.zeros(block.rows)), block.rows)
                rows[force] = block.values[force] - estimated if measured else estimated
        frames.append(pd.DataFrame(rows))
    frame = pd.concat(frames)
    return frame.set_index([name for name in ("test", "t") if name in frame])


Kind = Literal["mse", "mean_abs", "lmg"]
KINDS: tuple[Kind, ...] = get_args(Kind)
# Share of a column's sum of squares: a column with less left beside others adds no information.
COLLINEAR = 1e-12


def mse_shares(gram: np.ndarray, cross: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Share of each term when the value of a set of terms is minus its mean squared error, (n,)."""
    # The coefficients stay as they are. The game is quadratic, so that the shares have a closed form: phi_j = theta_j
    # (2 x_j'y - x_j'X theta) / rows, here up to the rows, which normalising removes.
    return _normalised(values * (2 * cross - gram @ values))


def mean_abs_shares(deviations: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Share of each term by the mean size of its contribution, mean ``|theta_j (x_j - mean x_j)|``, (n,)."""
    # For a linear model these are the means of the sizes of the exact per-row Shapley values; never negative.
    return _normalised(np.abs(values) * deviations)


def lmg_shares(gram: np.ndarray, cross: np.ndarray) -> np.ndarray:
    """Share of each term in R2 when every subset of terms is fitted anew, averaged over all orders, (n,)."""
    # Lindeman, Merenda, Gold (1980); no bounds are imposed on the subsets' fits.
    return _normalised(shapley_values(_explained(gram, cross)))


def shapley_values(worth: np.ndarray) -> np.ndarray:
    """Return the exact Shapley values (players,) of a game from the value of every subset (2**players,)."""
    players = len(worth).bit_length() - 1
    others = np.bitwise_count(np.arange(len(worth) // 2))
    orders = np.array([factorial(size) * factorial(players - size - 1) / factorial(players) for size in range(players)])
    weights, phi = orders[others], np.zeros(players)
    for j in range(players):
        pairs = worth.reshape(-1, 2, 2**j)
        phi[j] = weights @ (pairs[:, 1] - pairs[:, 0]).ravel()
    return phi


def _explained(gram: np.ndarray, cross: np.ndarray) -> np.ndarray:
    """Sum of squares that a fit of every subset of columns explains, (2**n,), numbered as in ``shapley_values``."""
    # Column by column every subset so far is kept as it is and with the column eliminated, as sums of products of what
    # the columns still to come, and the force, have left beside it.
    size = np.sqrt(np.diag(gram))
    scale = np.append(np.divide(1.0, size, out=np.zeros_like(size), where=size > 0), 1.0)
    left = (np.block([[gram, cross[:, None]], [cross, np.zeros(1)]]) * np.outer(scale, scale))[None]
    for _ in size:
        pivot, row = left[:, 0, 0], left[:, 0, 1:]
        inverse = np.divide(1.0, pivot, out=np.zeros_like(pivot), where=pivot > COLLINEAR)
        rest = left[:, 1:, 1:]
        left = np.concatenate([rest, rest - inverse[:, None, None] * row[:, :, None] * row[:, None, :]])
    return np.asarray(-left[:, 0, 0])


def _normalised(phi: np.ndarray) -> np.ndarray:
    total = float(np.abs(phi).sum())
    return phi / total if total > 0 else phi


def shares(
    kind: str, equations: NormalEquations, terms: TermTable, coefficients: Mapping[str, float],
    deviations: Callable[[], Mapping[str, float]],
) -> dict[str, dict[str, float]]:  # fmt: skip
    check_choice("kind", kind, KINDS)
    shared = {}
    for force, part in terms.forces.items():
        names = [term.name for term in part]
        if not names:
            continue
        values = np.array([coefficients[name] for name in names])
        gram = equations.pick(equations.total, names)
        cross = equations.pick(equations.total, names, [force])[:, 0]
        if kind == "mse":
            share = mse_shares(gram, cross, values)
        elif kind == "lmg":
            share = lmg_shares(gram, cross)
        else:
            share = mean_abs_shares(np.array([deviations()[name] for name in names]), values)
        shared[force] = dict(zip(names, share.tolist(), strict=True))
    return shared
