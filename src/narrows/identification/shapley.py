"""Shapley shares of the terms of a force, exact, under three value functions (the paper names none)."""

from collections.abc import Callable, Mapping
from itertools import combinations
from math import factorial
from typing import Literal, get_args

import numpy as np

from narrows.errors import InputError
from narrows.identification.regression.normal_equations import NormalEquations
from narrows.terms.term import TermTable

Kind = Literal["mse", "mean_abs", "lmg"]
KINDS: tuple[Kind, ...] = get_args(Kind)


def mse_shares(gram: np.ndarray, cross: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Share of each term when the value of a set of terms is minus its mean squared error, (n,).

    The coefficients stay as they are. The game is quadratic, so that the shares have a closed form:
    phi_j = theta_j (2 x_j'y - x_j'X theta) / rows, here up to the rows, which normalising removes.

    Parameters
    ----------
    gram : array (n, n)
        Sums of products of the columns.
    cross : array (n,)
        Sums of products of the columns and the force.
    values : array (n,)
        Coefficients.
    """
    return _normalised(values * (2 * cross - gram @ values))


def mean_abs_shares(deviations: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Share of each term by the mean size of its contribution, mean ``|theta_j (x_j - mean x_j)|``, (n,).

    For a linear model these are the means of the sizes of the exact per-row Shapley values; never negative.

    Parameters
    ----------
    deviations : array (n,)
        Mean absolute deviation of each column from its mean.
    values : array (n,)
        Coefficients.
    """
    return _normalised(np.abs(values) * deviations)


def lmg_shares(gram: np.ndarray, cross: np.ndarray) -> np.ndarray:
    """Share of each term in R2 when every subset of terms is fitted anew, averaged over all orders, (n,).

    Parameters
    ----------
    gram : array (n, n)
        Sums of products of the columns.
    cross : array (n,)
        Sums of products of the columns and the force.

    References
    ----------
    Lindeman, Merenda, Gold (1980); no bounds are imposed on the subsets' fits.
    """
    return _normalised(shapley_values(len(cross), lambda subset: _explained(gram, cross, subset)))


def shapley_values(players: int, value: Callable[[tuple[int, ...]], float]) -> np.ndarray:
    """Return the exact Shapley values of a game, from the value of every subset once, (players,).

    Parameters
    ----------
    players : int
        How many, about 15 at most.
    value : callable
        Value of a tuple of players.
    """
    subsets = [s for size in range(players + 1) for s in combinations(range(players), size)]
    worth = {subset: value(subset) for subset in subsets}
    phi = np.zeros(players)
    for subset in subsets:
        weight = factorial(len(subset)) * factorial(players - len(subset) - 1) if len(subset) < players else 0
        for j in set(range(players)) - set(subset):
            phi[j] += weight * (worth[tuple(sorted((*subset, j)))] - worth[subset])
    return phi / factorial(players)


def _explained(gram: np.ndarray, cross: np.ndarray, subset: tuple[int, ...]) -> float:
    index = [j for j in subset if gram[j, j] > 0]
    if not index:
        return 0.0
    norm = np.sqrt(np.diag(gram)[index])
    scaled = gram[np.ix_(index, index)] / np.outer(norm, norm)
    target = cross[index] / norm
    return float(target @ np.linalg.lstsq(scaled, target, rcond=1e-12)[0])


def _normalised(phi: np.ndarray) -> np.ndarray:
    total = float(np.abs(phi).sum())
    return phi / total if total > 0 else phi


def shares(
    kind: str,
    equations: NormalEquations,
    terms: TermTable,
    coefficients: Mapping[str, float],
    deviations: Callable[[], Mapping[str, float]],
) -> dict[str, dict[str, float]]:
    """Share out each force among its terms: force -> coefficient -> share (ours).

    Parameters
    ----------
    kind : str
        ``mse``, ``mean_abs`` or ``lmg``.
    equations : NormalEquations
        Sums over the rows.
    terms : TermTable
        The terms.
    coefficients : mapping of str to float
        Their values.
    deviations : callable
        Gives the mean absolute deviation of each column, which sums of products cannot.

    Raises
    ------
    InputError
        Where the kind is none of these.
    """
    if kind not in KINDS:
        raise InputError(f"Shapley kind {kind!r} is unknown; choose {', '.join(KINDS)}")
    shared, total = {}, equations.total
    for force, part in terms.forces.items():
        names = [term.name for term in part]
        values = np.array([coefficients[name] for name in names])
        if not names:
            continue
        gram, cross = equations.pick(total, names), equations.pick(total, names, [force])[:, 0]
        if kind == "mse":
            share = mse_shares(gram, cross, values)
        elif kind == "lmg":
            share = lmg_shares(gram, cross)
        else:
            share = mean_abs_shares(np.array([deviations()[name] for name in names]), values)
        shared[force] = dict(zip(names, share.tolist(), strict=True))
    return shared
