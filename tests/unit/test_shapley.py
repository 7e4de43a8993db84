"""Shapley shares against brute force over all subsets and orders, and against the shap package."""

from itertools import combinations, permutations
from math import factorial

import numpy as np
import pytest

from narrows.identification.shapley import lmg_shares, mean_abs_shares, mse_shares, shapley_values

PLAYERS, ROWS = 5, 60


@pytest.fixture(scope="module")
def case() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    draw = np.random.default_rng(4)
    columns = draw.normal(size=(ROWS, PLAYERS)) @ draw.normal(size=(PLAYERS, PLAYERS))
    values = draw.normal(size=PLAYERS)
    return columns, columns @ values + draw.normal(size=ROWS), values


def over_subsets(value) -> np.ndarray:
    """The definition, subset by subset."""
    phi = np.zeros(PLAYERS)
    for j in range(PLAYERS):
        others = [i for i in range(PLAYERS) if i != j]
        for size in range(PLAYERS):
            weight = factorial(size) * factorial(PLAYERS - size - 1) / factorial(PLAYERS)
            phi[j] += weight * sum(value((*s, j)) - value(s) for s in combinations(others, size))
    return phi


def over_orders(value) -> np.ndarray:
    """The definition, order by order."""
    phi = np.zeros(PLAYERS)
    for order in permutations(range(PLAYERS)):
        for place, j in enumerate(order):
            phi[j] += value(order[: place + 1]) - value(order[:place])
    return phi / factorial(PLAYERS)


def normalised(phi: np.ndarray) -> np.ndarray:
    return phi / np.abs(phi).sum()


def test_mse_is_the_game_of_fixed_coefficients(case) -> None:
    columns, target, values = case

    def value(subset) -> float:
        chosen = list(subset)
        return -float(np.mean((target - columns[:, chosen] @ values[chosen]) ** 2))

    shares = mse_shares(columns.T @ columns, columns.T @ target, values)
    np.testing.assert_allclose(shares, normalised(over_subsets(value)), atol=1e-12)
    np.testing.assert_allclose(shares, normalised(over_orders(value)), atol=1e-12)


def test_lmg_is_r2_refitted_over_orders(case) -> None:
    columns, target, _ = case

    def value(subset) -> float:
        chosen = columns[:, list(subset)]
        left = target - chosen @ np.linalg.lstsq(chosen, target, rcond=None)[0] if subset else target
        return 1 - float(left @ left) / float(target @ target)

    shares = lmg_shares(columns.T @ columns, columns.T @ target)
    np.testing.assert_allclose(shares, normalised(over_subsets(value)), atol=1e-10)
    np.testing.assert_allclose(shares, normalised(over_orders(value)), atol=1e-10)


def test_lmg_shares_an_empty_column_nothing(case) -> None:
    columns, target, _ = case
    wide = np.column_stack([columns, np.zeros(ROWS)])
    shares = lmg_shares(wide.T @ wide, wide.T @ target)
    assert shares[-1] == 0
    np.testing.assert_allclose(shares[:-1], lmg_shares(columns.T @ columns, columns.T @ target), atol=1e-12)


def test_mean_abs_is_the_mean_size_of_each_rows_game(case) -> None:
    columns, _, values = case
    mean = columns.mean(axis=0)
    per_row = []
    for row in columns[:8]:

        def value(subset, row=row) -> float:
            mixed = mean.copy()
            mixed[list(subset)] = row[list(subset)]
            return float(mixed @ values)

        per_row.append(over_subsets(value))
    np.testing.assert_allclose(per_row, values * (columns[:8] - mean), atol=1e-12)
    deviations = np.abs(columns - mean).mean(axis=0)
    expected = normalised(np.abs(values * (columns - mean)).mean(axis=0))
    np.testing.assert_allclose(mean_abs_shares(deviations, values), expected, atol=1e-14)


@pytest.mark.filterwarnings("ignore")
def test_mean_abs_agrees_with_the_shap_package(case) -> None:
    import shap

    columns, _, values = case
    masker = shap.maskers.Independent(columns, max_samples=ROWS)
    explained = shap.LinearExplainer((values, 0.0), masker).shap_values(columns)
    deviations = np.abs(columns - columns.mean(axis=0)).mean(axis=0)
    np.testing.assert_allclose(
        mean_abs_shares(deviations, values), normalised(np.abs(explained).mean(axis=0)), atol=1e-10
    )


def test_a_glove_game() -> None:
    """One left glove and two right ones: 2/3, 1/6, 1/6."""
    phi = shapley_values(np.array([float(bool(s & 1 and s & 6)) for s in range(8)]))
    np.testing.assert_allclose(phi, [2 / 3, 1 / 6, 1 / 6])


def test_lmg_of_collinear_columns_shares_what_one_of_them_explains(case) -> None:
    columns, target, _ = case
    twice = np.column_stack([columns, 2 * columns[:, 0]])
    shares = lmg_shares(twice.T @ twice, twice.T @ target)
    assert shares[0] == pytest.approx(shares[-1], rel=1e-9)


def test_nineteen_terms_take_no_minutes() -> None:
    draw = np.random.default_rng(7)
    columns = draw.normal(size=(40, 19))
    shares = lmg_shares(columns.T @ columns, columns.T @ columns.sum(axis=1))
    assert shares.sum() == pytest.approx(1)
