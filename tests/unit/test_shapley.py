"""Shapley shares against the definition, over all subsets of terms."""

from itertools import combinations
from math import factorial

import numpy as np

import narrows as nw
from tables import short_twin


def test_shares_are_those_of_the_game_of_fixed_coefficients() -> None:
    tests = short_twin()
    fit = nw.identify(tests, balance="rows")
    for force, terms in fit.terms.forces.items():
        known = {**tests.configuration.values(), **tests.columns}
        parts = [fit.coefficients[term.name] * term.column(known) * np.ones(tests.rows) for term in terms]

        def value(subset: tuple[int, ...], force: str = force, parts: list[np.ndarray] = parts) -> float:
            return -float(np.mean((tests[force] - sum((parts[i] for i in subset), np.zeros(tests.rows))) ** 2))

        phi, players = np.zeros(len(parts)), len(parts)
        for j in range(players):
            for size in range(players):
                weight = factorial(size) * factorial(players - size - 1) / factorial(players)
                others = combinations([i for i in range(players) if i != j], size)
                phi[j] += weight * sum(value((*some, j)) - value(some) for some in others)
        shares = np.array(list(fit.shapley()[force].values()))
        np.testing.assert_allclose(shares, phi / np.abs(phi).sum(), atol=1e-9)
