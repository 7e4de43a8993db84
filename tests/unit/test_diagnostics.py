"""Diagnostics against NumPy on the columns themselves."""

import numpy as np
import pytest

import narrows as nw


@pytest.fixture(scope="module")
def columns(kcs_tests: dict[int, nw.CaptiveTests]) -> np.ndarray:
    tests = kcs_tests[100]
    values = {**tests.configuration.values(), **tests.columns}
    return np.column_stack([term.column(values) for term in nw.PAPER.sway])


def test_vif_is_that_of_each_column_on_the_others(kcs_fits: dict[int, nw.Fit], columns: np.ndarray) -> None:
    found = kcs_fits[100].diagnostics.overall["Y"]
    for j, name in enumerate(found.names):
        others = np.delete(columns, j, axis=1)
        residual = columns[:, j] - others @ np.linalg.lstsq(others, columns[:, j], rcond=None)[0]
        assert found.vif[name] == pytest.approx((columns[:, j] @ columns[:, j]) / (residual @ residual), rel=1e-6)


def test_rank_and_condition_are_those_of_the_scaled_columns(kcs_fits: dict[int, nw.Fit], columns: np.ndarray) -> None:
    found = kcs_fits[100].diagnostics.overall["Y"]
    scaled = columns / np.linalg.norm(columns, axis=0)
    assert found.rank == np.linalg.matrix_rank(scaled) == 7
    assert found.condition == pytest.approx(np.linalg.cond(scaled), rel=1e-8)


def test_correlation_is_pearsons(kcs_fits: dict[int, nw.Fit], columns: np.ndarray) -> None:
    np.testing.assert_allclose(kcs_fits[100].diagnostics.overall["Y"].correlation, np.corrcoef(columns.T), atol=1e-10)


def test_a_single_harmonic_yaw_test_does_not_separate_bank_and_yaw_rate(kcs_fits: dict[int, nw.Fit]) -> None:
    """y = -(U/w^2) r: full rank over all tests, almost one column within each."""
    fit = kcs_fits[100]
    assert fit.diagnostics.overall["Y"].rank == 7
    equations = fit.normal_equations
    sums = equations.by_test(equations.sums)
    yaw = [own for test, own in zip(equations.names, sums, strict=True) if "_G" in test]
    assert len(yaw) == 23
    for own in yaw:
        (bank, cross), (_, rate) = equations.pick(own, ["b_bank", "b_r"])
        assert abs(cross) > 0.99 * np.sqrt(bank * rate)


def test_an_empty_column_and_a_dependent_pair_are_told_apart(twin_fit: nw.Fit) -> None:
    found = twin_fit.diagnostics.overall["X"]
    assert found.empty == ("a_udot",)
    assert np.isnan(found.vif["a_udot"])
    assert np.isinf(found.vif["a_u"])
    assert np.isinf(found.vif["a_uu"])
    assert found.missing.shape == (1, 3)


def test_by_speed_groups_tests_of_one_speed(kcs_fits: dict[int, nw.Fit]) -> None:
    assert [round(speed, 1) for speed in kcs_fits[100].diagnostics.by_speed] == [0.2, 0.5, 0.6]
