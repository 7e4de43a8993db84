"""Every form of the bank term of ``FORMS``: odd, towards the near bank, finite in the canal, and arithmetic alone."""

from collections.abc import Callable
from dataclasses import replace
from inspect import signature

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import narrows as nw
from arithmetic import check_arithmetic, values_at
from limits import within
from narrows.model.tables import NEW, PUBLISHED, REFITTED
from narrows.quantities.names import REGRESSOR_INPUTS, dimension_of
from narrows.simulation.ship import SimulatedShip

every_form = pytest.mark.parametrize("form", nw.FORMS.values(), ids=lambda form: form.name)
WIDTH, BEAM = 7.0, 0.572
"""Of the paper's tank and ship [m]."""


def parameter(function: Callable[..., float], dtc: nw.Model, **state: float) -> float:
    values = values_at(dtc, {"u": 1.0, **state})
    return function(**{name: values[name] for name in signature(function).parameters})


@every_form
@given(y=st.floats(-2.8, 2.8))
def test_it_is_odd_and_leans_to_the_near_bank(form: nw.BankForm, dtc: nw.Model, y: float) -> None:
    for function in form.parameters.values():
        own, mirrored = parameter(function, dtc, y=y), parameter(function, dtc, y=-y)
        assert own == -mirrored
        assert own * y >= 0


@every_form
def test_it_is_finite_until_the_hull_meets_the_bank(form: nw.BankForm, dtc: nw.Model) -> None:
    for function in form.parameters.values():
        found = [parameter(function, dtc, y=float(y)) for y in np.linspace(0.0, (WIDTH - BEAM) / 2 - 1e-3, 200)]
        assert np.isfinite(found).all()
        assert found[0] == 0
        assert found[-1] > found[50] > 0


@every_form
def test_it_scales_by_froudes_law(form: nw.BankForm, dtc: nw.Model) -> None:
    """A coefficient is a number: the force of a ship 25 times as large is 25^3 times as large, the moment 25^4."""
    units = {name: dimension_of(own.unit) for name, own in REGRESSOR_INPUTS.items()}
    small = {name: value for name, value in values_at(dtc, {"y": 1.0, "psi": 0.1, "u": 0.8}).items() if name in units}
    large = {name: value * 25.0**unit.length * 5.0**unit.time * 25.0 ** (3 * unit.mass)
             for name, value in small.items() for unit in [units[name]]}  # fmt: skip
    for terms, power in ((form.sway, 3), (form.yaw, 4)):
        for term in terms:
            one, other = (term.regressor(*(at[name] for name in term.inputs)) for at in (small, large))
            assert other == pytest.approx(25.0**power * one)


@every_form
@given(y=st.floats(-2.5, 2.5), psi=st.floats(-1.5, 1.5), u=st.floats(-2.0, 2.0))
@example(y=1e-5, psi=0.1, u=1.0)  # Near the line that a difference must not lose
@settings(max_examples=10)
def test_floats_columns_and_exact_numbers_agree(
    form: nw.BankForm, dtc: nw.Model, y: float, psi: float, u: float
) -> None:
    for term in (*form.sway, *form.yaw):
        check_arithmetic(term.regressor, values_at(dtc, {"y": y, "psi": psi, "u": u}))


@every_form
def test_a_ship_sails_under_it(form: nw.BankForm, dtc: nw.Model) -> None:
    """Its lines are traced and printed, in some seconds."""
    table = nw.with_bank(nw.PAPER, form)
    canal = nw.Canal(WIDTH, 0.4)
    bank = {term.name: 0.1 for term in table.terms if term.from_bank}
    known = {**dtc.coefficients, **bank}
    model = nw.Model(replace(dtc.configuration, canal=canal), table, {name: known[name] for name in table.names})
    with within(60, f"the step under {form.name}"):
        assert SimulatedShip(model).system().scalar.step
    assert nw.simulate(model, y=0.3, u=0.8, duration=2.0).outcome.kind == "afloat"


@every_form
def test_it_says_where_it_is_from_and_where_it_holds(form: nw.BankForm) -> None:
    assert form.source
    assert form.validity
    assert form.status in (PUBLISHED, REFITTED, NEW)
    assert nw.with_bank(nw.PAPER, form.name).name == f"paper+{form.name}"


def test_a_name_that_a_table_cannot_carry_is_refused() -> None:
    own = nw.FORMS["delta"]
    assert replace(own, name="keel-gap2").name == "keel-gap2"
    for name in ("squared+gap", "squared gap", "", "at@speed", "helm", "open_water"):
        with pytest.raises(nw.InputError, match="cannot be called"):
            replace(own, name=name)
    with pytest.raises(nw.InputError, match="form own: b_vv is a coefficient of paper already; rename yours"):
        nw.with_bank(nw.PAPER, replace(own, name="own", parameters={"vv": own.parameters["bank"]}))
    with pytest.raises(nw.InputError, match="there is a form 'delta' of the bank term already; rename yours"):
        nw.with_bank(nw.PAPER, replace(nw.FORMS["tuck"], name="delta"))
