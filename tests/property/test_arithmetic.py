"""One function body serves floats, columns, exact numbers and symbols."""

import math
from collections.abc import Callable
from inspect import isfunction

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from strategies import STATES

import narrows as nw
from arithmetic import check_arithmetic, values_at
from narrows.physics import clearance, hull
from narrows.quantities.names import argument_names, name_of

PHYSICS = [
    function
    for room in (clearance, hull)
    for function in vars(room).values()
    if isfunction(function)
    and getattr(function, "__module__", "") == room.__name__
    and {"pressure", "mass", "shear"}.isdisjoint(
        argument_names(function)
    )  # Of another function or a given mass, which tables hold; of the gradient of a current, which steps hold.
    and function not in (hull.half_drift, hull.drift)  # Not defined at rest
]
PHYSICS += dict.fromkeys(
    term.regressor for table in (nw.MIXED, nw.CROSSFLOW) for term in table.terms if not term.from_bank
)
FORCES = ("X", "Y", "N")


@pytest.mark.parametrize("function", PHYSICS, ids=name_of)
@given(state=STATES)
@settings(max_examples=10)
def test_floats_columns_and_exact_numbers_agree(
    function: Callable[..., float], dtc: nw.Model, state: dict[str, float]
) -> None:
    check_arithmetic(function, values_at(dtc, state))


@given(state=STATES)
def test_a_column_gives_what_its_rows_give(dtc: nw.Model, state: dict[str, float]) -> None:
    states = [state, {name: -value for name, value in state.items()}, dict.fromkeys(state, 0.01)]
    motions = [nw.Motion.at(**own) for own in states]
    column = nw.Motion(**{name: np.array([m.values()[name] for m in motions]) for name in motions[0].values()})
    together = dtc.forces(column)
    for force in FORCES:
        apart = [dtc.forces(motion)[force] for motion in motions]
        np.testing.assert_array_equal(np.broadcast_to(together[force], 3), apart)


def test_symbols_go_through_the_whole_model(dtc: nw.Model) -> None:
    """The trace that code generation rests on; its slope at the centreline is the paper's 8 B W/(W - B)^3."""
    y = sympy.Symbol("y", real=True)
    force = dtc.forces(nw.Motion(y=y, u=1.0))["Y"]
    slope = float(sympy.diff(force, y).subs(y, 0))
    assert slope == pytest.approx(1.07 * 214.62405 * 8 * 0.572 * 7 / (7 - 0.572) ** 3, rel=1e-6)


def test_motion_of_a_heading() -> None:
    motion = nw.Motion.at(psi=0.3, y=1.0)
    assert (motion.cos_psi, motion.sin_psi, motion.y) == (math.cos(0.3), math.sin(0.3), 1.0)
    assert list(motion.values()) == ["x", "y", "cos_psi", "sin_psi", "u", "v", "r", "udot", "vdot", "rdot", "heave"]
