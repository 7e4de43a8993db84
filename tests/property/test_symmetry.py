"""What mirroring the canal, and turning the ship across it, must do."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import HEADINGS, RIGHT_ANGLE, STATES, numbers

import narrows as nw
from narrows.physics.clearance import delta, taper

CANALS = st.tuples(numbers(2.0, 300.0), numbers(0.05, 0.6)).map(lambda pair: (pair[0], pair[0] * pair[1]))
"""Widths and beams [m]."""
MIRRORED = ("y", "psi", "v", "r", "vdot", "rdot")


@given(y=numbers(-0.19, 0.19), psi=HEADINGS, canal=CANALS)
def test_delta_is_odd_in_y_to_the_last_bit(y: float, psi: float, canal: tuple[float, float]) -> None:
    width, beam = canal
    c = math.cos(psi)
    assert delta(-y * width, c, width, beam) == -delta(y * width, c, width, beam)


@given(y=numbers(-0.19, 0.19), psi=HEADINGS, canal=CANALS)
def test_delta_is_even_in_heading(y: float, psi: float, canal: tuple[float, float]) -> None:
    width, beam = canal
    left, right = (nw.Motion.at(psi=angle).cos_psi for angle in (-psi, psi))
    assert delta(y * width, left, width, beam) == delta(y * width, right, width, beam)


@given(y=numbers(-0.19, 0.19), canal=CANALS)
def test_delta_is_nothing_across_the_canal(y: float, canal: tuple[float, float]) -> None:
    width, beam = canal
    assert delta(y * width, 0.0, width, beam) == 0.0
    almost = math.cos(RIGHT_ANGLE - 1e-9)
    assert abs(delta(y * width, almost, width, beam)) < 1e-7


@given(y=numbers(1e-3, 0.19), psi=numbers(0.0, 1.4), canal=CANALS)
def test_delta_pulls_to_the_near_bank_and_more_so_nearer(y: float, psi: float, canal: tuple[float, float]) -> None:
    width, beam = canal
    c = math.cos(psi)
    assert 0 < delta(y * width, c, width, beam) < delta(1.01 * y * width, c, width, beam)


@given(y=numbers(-0.49, 0.49), width=numbers(2.0, 300.0))
def test_taper_is_a_share_and_even(y: float, width: float) -> None:
    assert 0 <= taper(y * width, width) <= 1
    assert taper(y * width, width) == taper(-y * width, width)


@pytest.mark.parametrize("terms", [nw.PAPER, nw.TAPERED], ids=lambda table: table.name)
@given(state=STATES)
def test_mirrored_motion_mirrors_the_forces(terms: nw.TermTable, dtc: nw.Model, state: dict[str, float]) -> None:
    model = nw.Model(dtc.configuration, terms, dtc.coefficients)
    other = {name: -value if name in MIRRORED else value for name, value in state.items()}
    here, there = model.forces(nw.Motion.at(**state)), model.forces(nw.Motion.at(**other))
    assert there["X"] == here["X"]
    assert there["Y"] == -here["Y"]
    assert there["N"] == -here["N"]
