"""Scale and dimension: round trips, invariance of the bank's coefficients, and voyages that are one at every scale."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from strategies import STATES, numbers

import narrows as nw
from narrows.model.derived_models import SYSTEMS, name_at_scale, units_of
from narrows.model.tables import table_named
from narrows.model.water import ittc57

TABLES = (
    "paper",
    "tapered",
    "mixed",
    "crossflow+distance",
    "speed+keel_gap",
    "paper+delta_depth",
    "paper+distance_depth",
)
FORCE = {"X": (1, 1, -2), "Y": (1, 1, -2), "N": (1, 2, -2)}


def model_of(dtc: nw.Model, table: str) -> nw.Model:
    terms = table_named(table)
    configuration = replace(dtc.configuration, canal=nw.Canal(7.0, 0.4))
    return nw.Model(
        configuration, terms, {n: 0.3 + 0.1 * i for i, n in enumerate(terms.names)}, np.eye(len(terms.names))
    )


@pytest.mark.parametrize("system", SYSTEMS)
@given(speed=numbers(0.05, 20), length=numbers(0.5, 400))
def test_bank_coefficients_are_numbers_in_every_system_and_at_every_scale(
    dtc: nw.Model, system: str, speed: float, length: float
) -> None:
    """The paper's proof: b_bank and c_bank have no dimension."""
    for model in (dtc, nw.scale_model(dtc, length, density=1025.0).model):
        bare = nw.nondimensional(model, system, speed)
        for name in ("b_bank", "c_bank"):
            assert bare[name] == model.coefficients[name] == dtc.coefficients[name]


@pytest.mark.parametrize("table", TABLES)
@given(mass=numbers(0.1, 10), length=numbers(0.1, 10), time=numbers(0.1, 10), state=STATES)
def test_a_term_has_the_dimension_that_it_says(
    dtc: nw.Model, table: str, mass: float, length: float, time: float, state: dict[str, float]
) -> None:
    """In other units of mass, length and time, coefficient times regressor is the same force."""
    from narrows.model.derived_models import Units

    units = Units(mass, length, time)
    exponents = {
        "y": (0, 1, 0), "heave": (0, 1, 0), "u": (0, 1, -1), "v": (0, 1, -1), "r": (0, 0, -1), "udot": (0, 1, -2),
        "vdot": (0, 1, -2), "rdot": (0, 0, -2), "length": (0, 1, 0), "beam": (0, 1, 0), "draft": (0, 1, 0),
        "width": (0, 1, 0), "depth": (0, 1, 0), "density": (1, -3, 0),
    }  # fmt: skip
    model = model_of(dtc, table)
    values = model.configuration.values() | nw.Motion.at(**state).values()
    other = {n: v / units.factor(nw.Dimension(*exponents.get(n, (0, 0, 0)))) for n, v in values.items() if n != "name"}
    for force, terms in model.terms.forces.items():
        for term in terms:
            here, there = term.column(values), term.column(other) * units.factor(nw.Dimension(*FORCE[force]))
            assert there / units.factor(term.dimension) == pytest.approx(here, rel=1e-9, abs=1e-12)


@given(length=numbers(0.5, 400), density=numbers(990, 1030))
def test_scaling_there_and_back(dtc: nw.Model, length: float, density: float) -> None:
    model = replace(
        model_of(dtc, "crossflow"), data_range=nw.DataRange((0.3, 1.2), (0.0, 0.9), (0.0, 0.4), (0.0, 0.1), (2.0, 2.0))
    )
    there = nw.scale_model(model, length, density).model
    back = nw.scale_model(there, model.configuration.ship.length, model.configuration.water.density).model
    for name, value in model.coefficients.items():
        assert back.coefficients[name] == pytest.approx(value, rel=1e-12)
    np.testing.assert_allclose(back.covariance, model.covariance, rtol=1e-12)
    for name in ("speed", "abs_y", "abs_psi", "abs_r", "depth_to_draft"):
        assert getattr(back.data_range, name) == pytest.approx(getattr(model.data_range, name), rel=1e-12)
    was = {n: v for n, v in model.configuration.values().items() if n != "name"}
    assert {n: back.configuration.values()[n] for n in was} == {
        n: v if isinstance(v, str) else pytest.approx(v, rel=1e-12) for n, v in was.items()
    }


@pytest.mark.parametrize(
    ("name", "ratio", "scaled"),
    [
        ("KCS 1:52.667", 230 / 4.3671, "KCS at full scale"), ("KCS at full scale", 0.5, "KCS 1:2"),
        ("KCS 1:52.667", 400 / 4.3671, "KCS 1:0.57501"), ("KCS 1:0.57501", 0.57501, "KCS at full scale"),
        ("KVLCC2", 45.7, "KVLCC2"), ("8000 TEU container carrier", 2.0, "8000 TEU container carrier"),
    ],
)  # fmt: skip
def test_the_scale_in_a_name_is_that_of_the_ship(name: str, ratio: float, scaled: str) -> None:
    assert name_at_scale(name, ratio) == scaled


def test_a_model_at_full_scale_says_so(dtc: nw.Model, tmp_path: Path) -> None:
    full = nw.scale_model(dtc, 355.0)
    full.model.save(tmp_path / "full.toml")
    assert "DTC at full scale" in repr(full.model)
    assert nw.load_model(tmp_path / "full.toml").ship.name == "DTC at full scale"


@given(state=STATES, length=numbers(1, 400))
def test_a_voyage_at_another_scale_is_the_same_voyage(dtc: nw.Model, state: dict[str, float], length: float) -> None:
    """Accelerations do not scale, forces go with the cube of the length."""
    scaled = nw.scale_model(dtc, length)
    ratio = scaled.ratio
    power = {"y": 1, "u": 0.5, "v": 0.5, "r": -0.5, "udot": 0, "vdot": 0, "rdot": -1, "heave": 1, "psi": 0}
    small = dtc.forces(nw.Motion.at(**state))
    large = scaled.model.forces(nw.Motion.at(**{n: v * ratio ** power[n] for n, v in state.items()}))
    values = dtc.configuration.values() | nw.Motion.at(**state).values()
    for force, exponent in (("X", 3), ("Y", 3), ("N", 4)):
        size = sum(abs(dtc.coefficients[term.name] * term.column(values)) for term in dtc.terms.forces[force])
        assert large[force] / ratio**exponent == pytest.approx(small[force], abs=1e-11 * size + 1e-300)


def test_a_grounding_at_full_scale_is_that_of_the_model(dtc: nw.Model) -> None:
    full = nw.scale_model(dtc, 355.0, density=1025.0)
    small = nw.simulate(dtc, y=0.5, u=1.0).outcome
    large = nw.simulate(
        full.model, y=0.5 * full.ratio, u=full.speed(1.0), duration=600.0, dt=0.02 * full.ratio**0.5
    ).outcome
    assert large.side == small.side == "port"
    assert large.time == pytest.approx(small.time * full.ratio**0.5, rel=1e-6)
    assert large.distance == pytest.approx(small.distance * full.ratio, rel=1e-6)


def test_prime_units_are_those_of_the_book(dtc: nw.Model) -> None:
    configuration, speed = dtc.configuration, 0.9
    length, draft, rho = configuration.ship.length, configuration.ship.draft, configuration.water.density
    force = nw.Dimension(1, 1, -2)
    assert units_of(configuration, "prime1", speed).factor(force) == pytest.approx(rho / 2 * length**2 * speed**2)
    assert units_of(configuration, "prime2", speed).factor(force) == pytest.approx(rho / 2 * length * draft * speed**2)
    assert nw.nondimensional(dtc, "prime2", speed)["b_v"] == pytest.approx(100 / (rho / 2 * length * draft * speed))
    displaced = rho * 0.661 * length * 0.572 * draft
    assert nw.nondimensional(dtc, "bis")["b_vdot"] == pytest.approx(733 / displaced)


def test_the_line_of_the_ittc() -> None:
    assert ittc57(1e7) == pytest.approx(0.075 / 25)
    assert ittc57(1e9) == pytest.approx(0.075 / 49)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"depth": 24.0}, "Beyond the data: h/T 1.65; they covered 2.45."),
        ({"width": 205.0}, "Beyond the data: W/B 4.02; they covered 12.2."),
        ({}, "does not follow Froude's law"),
        ({}, "depends on the Reynolds number"),
        ({}, "hold parts proportional to the speed of the tests, 0.5 to 1"),
        ({}, "Beyond 9.44 m/s its depth Froude number"),
    ],
)
def test_what_does_not_scale_is_said(dtc: nw.Model, changed: dict[str, float], said: str) -> None:
    depth = 0.4
    model = replace(
        dtc,
        configuration=replace(dtc.configuration, canal=nw.Canal(7.0, depth)),
        data_range=nw.DataRange(speed=(0.5, 1.0), depth_to_draft=(depth / 0.163, depth / 0.163)),
    )
    assert any(said in warning for warning in nw.scale_model(model, 355.0, **changed).notes)


def test_an_estimate_at_another_depth_names_the_command_that_estimates_it_anew(tmp_path, cli) -> None:
    kcs = nw.published("estimated_kcs")
    assert not any("estimate it anew" in note for note in nw.scale_model(kcs, 300.0).notes)
    (note,) = (note for note in nw.scale_model(kcs, 300.0, depth=30.0).notes if "estimate it anew" in note)
    words = note.partition("narrows ")[2].removesuffix("ship.toml.").split()
    assert cli(*words, tmp_path / "ship.toml")[0] == 0
    anew = nw.load_model(tmp_path / "ship.toml")
    assert anew.configuration.canal.depth == 30.0
    assert anew.coefficients["Y_v"] != pytest.approx(kcs.coefficients["Y_v"], rel=0.05)


@pytest.mark.parametrize(
    ("act", "said"),
    [
        (lambda m: nw.scale_model(m, -1.0), "must be over 0 and under"),
        (lambda m: nw.scale_model(m, 355.0, width=40.0), "does not fit"),
        (lambda m: nw.nondimensional(m, "prime3"), "choose prime1"),
        (lambda m: nw.nondimensional(m, "prime2"), "give a positive one"),
    ],
)
def test_scaling_refuses(dtc: nw.Model, act, said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        act(dtc)


def test_scale_on_the_command_line(cli, tmp_path) -> None:
    import json

    code, out, err = cli("scale", "mikkelsen2025_dtc", "--length", 355, "--density", 1025, "-o", tmp_path / "full.toml")
    assert (code, err) == (0, "")
    assert "Lengths times 89.11" in out
    assert nw.load_model(tmp_path / "full.toml").configuration.ship.length == 355
    code, out, _ = cli("scale", "mikkelsen2025_dtc", "--length", 355, "--json")
    told = json.loads(out)
    assert told["coefficients"]["b_bank"] == {"old": 1.07, "new": 1.07, "unit": "1"}
    assert told["speed_ratio"] == pytest.approx(89.1064**0.5, rel=1e-5)
