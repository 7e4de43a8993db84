"""Shallow-water corrections: limits, there and back, and the measured depths of the KCS."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from strategies import numbers

import narrows as nw
from narrows.model.derived_models import factor_at
from narrows.model.term import DepthLaw


def at(model: nw.Model, depth: float | None) -> nw.Model:
    return replace(
        model, configuration=replace(model.configuration, canal=replace(model.configuration.canal, depth=depth))
    )


LAWS = {term.name: term.depth_law for term in (*nw.MIXED.terms, *nw.CROSSFLOW.terms) if term.depth_law}


def test_kijimas_factors_go_with_drift_and_turning() -> None:
    assert set(LAWS) == {"b_v", "b_uv", "c_v", "c_uv", "c_r", "c_ur"}
    assert {name for name, law in LAWS.items() if not law.verified} == {"c_v", "c_uv"}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_deep_water_changes_nothing_and_shallow_water_everything(law: DepthLaw, dtc: nw.Model) -> None:
    draft = dtc.configuration.ship.draft
    factors = [factor_at(law, dtc.configuration, ratio * draft) for ratio in (1e6, 10, 3, 2, 1.5, 1.2)]
    assert factors[0] == pytest.approx(1.0, abs=1e-5)
    assert np.all(np.diff(factors[2:]) > 0)
    assert factors[-1] > 1.5


def test_by_hand(dtc: nw.Model) -> None:
    ship = dtc.configuration.ship
    power = 0.40 * ship.block_coefficient * ship.beam / ship.draft
    assert factor_at(LAWS["b_v"], dtc.configuration, 2 * ship.draft) == pytest.approx(2**power - 0.5, rel=1e-12)


@given(there=numbers(0.2, 3.0), back=numbers(0.2, 3.0))
def test_there_and_back(dtc: nw.Model, there: float, back: float) -> None:
    model = at(dtc, back)
    again = nw.at_depth(nw.at_depth(model, there).model, back).model
    for name, value in model.coefficients.items():
        assert again.coefficients[name] == pytest.approx(value, rel=1e-10)
    assert again.configuration == model.configuration


def test_what_is_left_is_said(dtc: nw.Model) -> None:
    moved = nw.at_depth(dtc, 0.3)
    assert set(moved.factors) == {"b_v", "c_v", "c_r"}
    assert "b_bank" in moved.notes[0]
    assert any("not verified" in said for said in moved.notes)
    assert any("count as deep" in said for said in moved.notes)
    assert moved.model.coefficients["b_bank"] == dtc.coefficients["b_bank"]
    with pytest.raises(nw.InputError, match="no water under"):
        nw.at_depth(dtc, 0.1)


def test_derivatives_of_the_mmg_method_grow_as_those_of_the_paper(dtc: nw.Model) -> None:
    """One law a phenomenon: the drift's and the turning's own, whatever table a coefficient stands in."""
    kvlcc2 = nw.published("yasukawa2015_kvlcc2")
    ship = kvlcc2.configuration.ship
    moved = nw.at_depth(kvlcc2, 1.5 * ship.draft)
    assert set(moved.factors) == {"Y_v", "N_v", "N_r"}
    power = 0.40 * ship.block_coefficient * ship.beam / ship.draft
    assert moved.factors["Y_v"] == pytest.approx(3**power - 2 / 3, rel=1e-9)
    assert moved.factors["N_r"] == pytest.approx(3 ** (1.5 - 14.28 * ship.draft / ship.length) - 2 / 3, rel=1e-9)
    assert "Y_r, Y_vvv" in moved.notes[0]
    assert any("exponent for N_v is from memory" in note for note in moved.notes)


def test_from_the_deepest_kcs_tests_to_half_the_clearance(kcs_tests: dict[int, nw.CaptiveTests]) -> None:
    """The force of drift is within the interval of what was measured there, its moment 8 % below; c_ur is far off."""
    deep, there = (nw.identify(kcs_tests[c], nw.CROSSFLOW) for c in (100, 50))
    moved = nw.at_depth(deep.model, 0.3075).model
    low, high = there.intervals["b_uv"]
    assert low < moved.coefficients["b_uv"] < high
    assert moved.coefficients["c_uv"] == pytest.approx(there.coefficients["c_uv"], rel=0.1)
    own = there.coefficients["b_uv"]
    assert abs(moved.coefficients["b_uv"] - own) < abs(deep.coefficients["b_uv"] - own)
