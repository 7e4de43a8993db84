"""The paper's pressure difference and bank forces, against its printed formulas and numbers worked out from them."""

import math

import numpy as np
import pytest

import narrows as nw
from narrows.physics.clearance import cushion, delta, suction, taper, tapered_delta

W, B = 7.0, 0.572
"""The tank and the beam of the paper's experiments [m]."""


def literal_delta(y: float, psi: float) -> float:
    """Eq. (Delta_1) with eq. (clearance_w_heading), as printed."""
    y_s = (W / 2 - y) / math.cos(abs(psi)) - B / 2
    y_p = (W / 2 + y) / math.cos(abs(psi)) - B / 2
    return (y_s + B / 2) ** 2 / y_s**2 - (y_p + B / 2) ** 2 / y_p**2


@pytest.mark.parametrize(
    ("y", "degrees", "expected"),
    [(0.9068, 0, 0.119661), (1, 0, 0.134699), (2, 0, 0.413956), (1, 20, 0.124340), (2, 45, 0.258142)],
)
def test_delta_values(y: float, degrees: float, expected: float) -> None:
    value = delta(y, math.cos(math.radians(degrees)), W, B)
    assert value == pytest.approx(expected, abs=5e-7)
    assert value == pytest.approx(literal_delta(y, math.radians(degrees)), rel=1e-12)


@pytest.mark.parametrize("psi", np.radians([0, 5, -15, 60, 89]))
@pytest.mark.parametrize("y", [-3.1, -1.0, 1e-6, 0.3, 2.5, 3.2])
def test_closed_form_is_the_printed_formula(y: float, psi: float) -> None:
    # The printed difference of two numbers near 1 loses what delta is smaller than 1.
    assert delta(y, math.cos(psi), W, B) == pytest.approx(literal_delta(y, psi), rel=1e-11, abs=1e-14)


def test_slope_at_the_centreline() -> None:
    slope = 8 * B * W / (W - B) ** 3
    assert slope == pytest.approx(0.120603, abs=5e-7)
    assert delta(1e-6, 1.0, W, B) / 1e-6 == pytest.approx(slope, rel=1e-9)


def test_delta_grows_without_bound_at_the_bank() -> None:
    edge = (W - B) / 2
    assert delta(edge - 1e-3, 1.0, W, B) > 1e4
    assert delta(edge - 1e-6, 1.0, W, B) > 1e10


def test_delta_is_that_of_the_printed_clearances() -> None:
    c = math.cos(math.radians(20))
    starboard, port = 2.5 / c - B / 2, 4.5 / c - B / 2
    printed = ((starboard + B / 2) / starboard) ** 2 - ((port + B / 2) / port) ** 2
    assert delta(1.0, c, W, B) == pytest.approx(printed, rel=1e-12)


@pytest.mark.parametrize(("y", "apart"), [(1.0, 0.245), (2.0, 0.330)])
def test_bridging_identity(y: float, apart: float) -> None:
    """B (1/a - 1/p), twice the parameter of Ch'ng and Vantorre, is what delta is to first order in the beam.

    It is 24 % (0.245) and 33 % short of delta, in parts of delta, one and two metres off the centreline.
    """
    a, p = W / 2 - y, W / 2 + y
    assert 1 - B * (1 / a - 1 / p) / delta(y, 1.0, W, B) == pytest.approx(apart, abs=5e-4)


def test_bridging_identity_holds_for_a_slender_ship() -> None:
    thin = 1e-6
    assert delta(1.0, 1.0, W, thin) == pytest.approx(thin * (1 / 2.5 - 1 / 4.5), rel=1e-5)


def test_bank_forces(dtc: nw.Model) -> None:
    ship = dtc.configuration.ship
    half = 0.5 * ship.block_coefficient * 1000 * ship.length * ship.draft
    assert half == pytest.approx(214.624, abs=5e-4)
    bank = dtc.bank_forces(nw.Motion(y=0.9068, u=1.0))
    assert bank["X"] == 0.0
    assert bank["Y"] == pytest.approx(27.48, abs=5e-3)
    assert bank["N"] == pytest.approx(-13.30, abs=5e-3)


def test_sinkage_adds_to_the_side() -> None:
    particulars = (3.984, 0.163, 0.661, 1000.0)
    level, sunk = (suction(0.1, 1.0, z, *particulars) for z in (0.0, 0.0163))
    assert sunk / level == pytest.approx(1.1, rel=1e-12)


@pytest.mark.parametrize("y", [-3.0, -2.5, -1.0, 0.0, 0.9068, 2.4, 2.6, 3.2])
def test_taper_is_the_red_curve_in_the_papers_tank(y: float) -> None:
    red = 0.5 - 0.5 * math.tanh(5 * (abs(y) - 2.5))
    assert taper(y, W) == pytest.approx(red, rel=1e-9, abs=1e-15)
    place, rest = (y, 1.0, W, B), (1.0, 0.0, 3.984, 0.163, 0.661, 1000.0)
    values = dict(zip(("y", "cos_psi", "width", "beam"), place, strict=True))
    values |= dict(zip(("u", "heave", "length", "draft", "block_coefficient", "density"), rest, strict=True))
    for name, law in (("b_bank", suction), ("c_bank", cushion)):
        expected = red * law(delta(*place), *rest)
        assert law(tapered_delta(*place), *rest) == pytest.approx(expected, rel=1e-9, abs=1e-12)
        assert nw.TAPERED[name].column(values) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_taper_falls_at_the_same_relative_place_in_another_canal() -> None:
    assert taper(250.0, 700.0) == pytest.approx(0.5, rel=1e-12)
    assert taper(270.0, 700.0) == pytest.approx(taper(2.7, W), rel=1e-9)
