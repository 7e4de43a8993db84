"""What a record taught of a coefficient: what it says by itself is Bayes taken back; a verdict asks for that too."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from narrows.logbook.learned_coefficients import LEARNED, PRIOR, SHARPENED, LearnedCoefficient

WIDE = 1.959964  # standard deviations that hold 95 % of a normal distribution

number, size = st.floats(-3.0, 3.0), st.floats(0.1, 3.0)


def after(prior: float, prior_std: float, read: float, read_std: float, from_bank: bool = True) -> LearnedCoefficient:
    """A reading put together with what was known."""
    weights = prior_std**-2.0, read_std**-2.0
    std = sum(weights) ** -0.5
    value = (weights[0] * prior + weights[1] * read) * std**2
    return LearnedCoefficient("c_bank", "1", prior, prior_std, value, std, from_bank)


@given(number, size, number, size)
def test_what_the_record_says_by_itself_is_the_reading(prior: float, prior_std: float, read: float, std: float) -> None:
    low, high = after(prior, prior_std, read, std).likelihood_interval
    assert low == pytest.approx(read - WIDE * std, abs=1e-9)
    assert high == pytest.approx(read + WIDE * std, abs=1e-9)


def test_what_only_the_prior_keeps_off_zero_is_unresolved() -> None:
    """A reading 1.9 standard errors from 0, drawn farther off by a prior beyond it."""
    found = after(0.5, 0.25, 0.19, 0.1)
    assert found.status == LEARNED
    assert found.interval[0] > 0
    assert found.verdict == "learned, unresolved"
    assert found.sentence().endswith("unresolved, for by the record alone it is -0.006 to 0.386")


def test_what_both_keep_off_zero_is_learned_and_what_neither_does_is_not() -> None:
    assert after(0.5, 0.25, 0.3, 0.1).verdict == LEARNED
    assert after(0.0, 1.0, 0.1, 0.1).sentence().endswith("unresolved, for 0 is among it")


def test_a_coefficient_of_no_bank_may_be_zero() -> None:
    assert after(0.0, 1.0, 0.0, 0.1, from_bank=False).verdict == LEARNED


def test_what_was_known_well_before_is_not_unresolved_by_a_record_that_tells_little() -> None:
    assert after(1.0, 0.1, 0.2, 0.3).verdict == PRIOR
    assert after(1.0, 0.1, 0.1, 0.12).verdict == SHARPENED


@pytest.mark.parametrize(("prior_std", "std"), [(0.0, 0.0), (0.1, 0.1), (0.1, 0.2)])
def test_a_record_that_tells_nothing_leaves_all_open(prior_std: float, std: float) -> None:
    told = LearnedCoefficient("c_bank", "1", 1.0, prior_std, 1.0, std, True)
    assert told.likelihood_interval == (-math.inf, math.inf)
    assert told.verdict == PRIOR


@pytest.mark.parametrize(
    ("ratio", "status"), [(0.49, LEARNED), (0.51, SHARPENED), (0.89, SHARPENED), (0.91, PRIOR), (1.2, PRIOR)]
)
def test_a_verdict_is_by_the_share_of_the_standard_error_that_is_left(ratio: float, status: str) -> None:
    """Half of it is three quarters of the information, nine tenths a fifth: 1 - 0.25 and 1 - 0.81."""
    found = LearnedCoefficient("b_v", "1", 9.0, 0.5, 9.0, 0.5 * ratio, False)
    assert (found.status, found.std_ratio) == (status, pytest.approx(ratio))
    assert found.interval == pytest.approx((9.0 - WIDE * 0.5 * ratio, 9.0 + WIDE * 0.5 * ratio))


@pytest.mark.parametrize(("value", "unresolved"), [(0.19, True), (0.2, False), (-0.19, True), (-0.2, False)])
def test_an_interval_that_holds_zero_is_unresolved(value: float, unresolved: bool) -> None:
    """1.96 standard errors of 0.1."""
    found = LearnedCoefficient("c_bank", "1", value, 0.18, value, 0.1, True)
    assert found.unresolved is unresolved
    assert found.verdict == ("sharpened, unresolved" if unresolved else "sharpened")


def test_what_was_held_is_as_it_was() -> None:
    held = LearnedCoefficient("b_v", "1", 2.0, 0.0, 2.0, 0.0, False)
    assert (held.std_ratio, held.interval, held.status) == (1.0, (2.0, 2.0), PRIOR)
