"""Exact Shapley values of the terms of a fit."""

from math import factorial
from typing import Any, Literal, get_args

import numpy as np

from narrows.base.errors import check_choice
from narrows.identification.normal_equations import ONE, DesignMatrix

Kind = Literal["mse", "mean_abs", "lmg"]
KINDS: tuple[Kind, ...] = get_args(Kind)
# Share of a column's sum of squares: a column with less left beside others adds no information.
COLLINEAR = 1e-12


def shares(fit: Any, kind: Kind) -> dict[str, dict[str, float]]:
    check_choice("kind", kind, KINDS)
    equations, shared = fit.normal_equations, {}
    deviations = mean_deviations(fit) if kind == "mean_abs" else {}
    for force, part in fit.terms.forces.items():
        if names := [term.name for term in part]:
            values = np.array([fit.coefficients[name] for name in names])
            gram = equations.pick(equations.total, names)
            cross = equations.pick(equations.total, names, [force])[:, 0]
            if kind == "mse":
                share = mse_shares(gram, cross, values)
            elif kind == "lmg":
                share = lmg_shares(gram, cross)
            else:
                share = mean_abs_shares(np.array([deviations[name] for name in names]), values)
            shared[force] = dict(zip(names, share.tolist(), strict=True))
    return shared


def mean_deviations(fit: Any) -> dict[str, float]:
    """Mean absolute deviation of each column, by one more pass over the rows."""
    matrix, total = DesignMatrix(fit.terms, effects=False), fit.normal_equations.unweighted.sum(axis=0)
    one = matrix.columns[ONE]
    mean = total[: one + 1, one, None] / total[one, one]
    sums = sum(np.abs(matrix.evaluate(block) - mean).sum(axis=1) for block in fit.tests.blocks(1)) / total[one, one]
    return {name: float(sums[matrix.columns[name]]) for name in fit.terms.names}


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
