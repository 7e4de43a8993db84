"""Froude scaling: bank coefficients are pure numbers, and every other coefficient scales as its dimension says."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from strategies import STATES, numbers

import narrows as nw

EXPONENTS = {"y": 1, "u": 0.5, "v": 0.5, "r": -0.5, "udot": 0, "vdot": 0, "rdot": -1, "heave": 1, "psi": 0}
"""Of the length scale, where Froude's number and the water stay."""
SCALES = numbers(0.02, 120.0)


def geosim(model: nw.Model, scale: float) -> nw.Model:
    """The same ship and canal larger, with the same coefficients."""
    ship = replace(
        model.configuration.ship,
        **{name: scale * getattr(model.configuration.ship, name) for name in ("length", "beam", "draft")},
    )
    return replace(model, configuration=nw.Configuration(ship, nw.Canal(scale * model.configuration.canal.width)))


def scaled(state: dict[str, float], scale: float) -> nw.Motion:
    return nw.Motion.at(**{name: value * scale ** EXPONENTS[name] for name, value in state.items()})


@pytest.mark.parametrize("terms", [nw.PAPER, nw.TAPERED], ids=lambda table: table.name)
@given(state=STATES, scale=SCALES)
def test_bank_coefficients_hold_at_every_scale(
    terms: nw.TermTable, dtc: nw.Model, state: dict[str, float], scale: float
) -> None:
    model = nw.Model(dtc.configuration, terms, dtc.coefficients)
    small = model.bank_forces(nw.Motion.at(**state))
    large = geosim(model, scale).bank_forces(scaled(state, scale))
    assert large["Y"] == pytest.approx(scale**3 * small["Y"], rel=1e-9)
    assert large["N"] == pytest.approx(scale**4 * small["N"], rel=1e-9)


@given(state=STATES, scale=SCALES)
def test_every_coefficient_scales_as_its_dimension_says(dtc: nw.Model, state: dict[str, float], scale: float) -> None:
    """Mass goes with the third power of length, time with its root."""
    larger = {
        term.name: dtc.coefficients[term.name]
        * scale ** (3 * term.dimension.mass + term.dimension.length + term.dimension.time / 2)
        for term in dtc.terms.terms
    }
    small = dtc.forces(nw.Motion.at(**state))
    large = replace(geosim(dtc, scale), coefficients=larger).forces(scaled(state, scale))
    parts = {force: sum(map(abs, own)) for force, own in contributions(dtc, state).items()}
    for force, power in (("X", 3), ("Y", 3), ("N", 4)):
        assert large[force] == pytest.approx(scale**power * small[force], abs=1e-12 * scale**power * parts[force])


def contributions(model: nw.Model, state: dict[str, float]) -> dict[str, list[float]]:
    values = model.configuration.values() | nw.Motion.at(**state).values()
    return {
        force: [model.coefficients[term.name] * term.column(values) for term in terms] + [math.ulp(1.0)]
        for force, terms in model.terms.forces.items()
    }


@pytest.mark.parametrize("name", nw.PAPER.names)
def test_unit_of_each_coefficient_makes_a_force(name: str) -> None:
    """Coefficient times regressor is a force in X and Y, a moment in N."""
    from narrows.quantities.names import FORCES, REGRESSOR_INPUTS

    pint = pytest.importorskip("pint")
    units = pint.UnitRegistry()

    def quantity(unit: str, value: float = 1.5) -> object:
        spelled = {"1": "dimensionless", "m/s2": "m/s**2", "rad/s2": "1/s**2", "rad/s": "1/s", "kg m2": "kg*m**2"}
        return value * units(spelled.get(unit, unit.replace("m3", "m**3")))

    term = nw.PAPER[name]
    values = {word: quantity(REGRESSOR_INPUTS[word].unit) for word in term.inputs}
    if "width" in values:
        values |= {"width": quantity("m", 7.0), "beam": quantity("m", 0.5), "y": quantity("m", 1.0)}
    mass, length, time = term.dimension
    product = term.column(values) * (units("kg") ** mass * units("m") ** length * units("s") ** time)
    force = next(force for force, terms in nw.PAPER.forces.items() if term in terms)
    product.to(FORCES[force].unit.replace("N m", "N*m"))
