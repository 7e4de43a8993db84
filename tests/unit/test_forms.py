"""Forms of the bank term: limits that tie them together, symmetries, and the tables that take them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import narrows as nw
from narrows.model.tables import BASES, table_named
from narrows.model.term import without
from narrows.physics import clearance
from narrows.physics.squat_and_depth import return_flow
from narrows.ship.particulars import equivalent_wall

PLACE = {"cos_psi": 1.0, "width": 7.0, "beam": 0.572, "draft": 0.163, "depth": 0.4, "u": 1.0}
OFFSETS = st.floats(-2.8, 2.8)


def parameter(function, **changed: float) -> float:
    from inspect import signature

    return function(**{name: {**PLACE, **changed}[name] for name in signature(function).parameters})


def test_delta_is_twice_the_bank_distance_far_from_the_banks() -> None:
    """They part by 3 B/W of themselves, to first order."""
    for width in (70.0, 700.0, 7000.0):
        ratio = parameter(clearance.delta, y=1.0, width=width) / parameter(clearance.bank_distance, y=1.0, width=width)
        assert ratio / 2 - 1 == pytest.approx(3 * 0.572 / width, rel=3 / width)


@pytest.mark.parametrize(("y", "apart"), [(1.0, 0.24), (2.0, 0.33)])
def test_delta_and_twice_the_bank_distance_part_near_the_bank(y: float, apart: float) -> None:
    bridged = 2 * parameter(clearance.bank_distance, y=y) / parameter(clearance.delta, y=y)
    assert 1 - bridged == pytest.approx(apart, abs=0.01)


def test_the_bank_distance_is_that_of_its_definition() -> None:
    a, p = 3.5 - 1.2, 3.5 + 1.2
    assert parameter(clearance.bank_distance, y=1.2) == pytest.approx(0.572 / 2 * (1 / a - 1 / p), rel=1e-14)


@given(y=OFFSETS)
def test_the_keel_gap_closes_to_the_papers(y: float) -> None:
    assert parameter(clearance.keel_gap_delta, y=y, depth=0.163) == pytest.approx(parameter(clearance.delta, y=y))
    assert abs(parameter(clearance.keel_gap_delta, y=y)) <= abs(parameter(clearance.delta, y=y))


def test_tucks_form_is_the_bank_distance_at_low_speed_and_grows_to_the_critical() -> None:
    plain = parameter(clearance.bank_distance, y=1.0)
    growth = [parameter(clearance.critical_bank_distance, y=1.0, u=u) / plain for u in (1e-6, 1.0, 1.5, 1.9)]
    assert growth[0] == pytest.approx(1)
    assert np.all(np.diff(growth) > 0)
    assert growth[1] == pytest.approx(1 / np.sqrt(1 - 1 / (9.81 * 0.4)), rel=1e-12)


@given(y=OFFSETS, u=st.floats(0.1, 1.2))
def test_return_flow_takes_the_waters_speed_past_the_ship_instead_of_the_ships(y: float, u: float) -> None:
    """Schijf (1949): the ratio of both speeds, squared; in a canal 70 km wide, only the ship's own speed is left."""
    past = 1 + return_flow(u, beam=0.572, draft=0.163, width=7.0, depth=0.4) / u
    plain = parameter(clearance.bank_distance, y=y)
    assert parameter(clearance.fast_bank_distance, y=y, u=u) == pytest.approx(plain * past**2, rel=1e-12)
    wide = {"y": 1.0, "u": u, "width": 7e4}
    assert parameter(clearance.fast_bank_distance, **wide) == pytest.approx(
        parameter(clearance.bank_distance, **wide), rel=1e-4
    )


def test_return_flow_nearly_doubles_the_squared_speed_in_suez_at_13_knots_and_a_half() -> None:
    """Continuity and energy solved by bisection: 2.78 m/s for a ship of 58.8 x 16 m in 205 x 24 m."""
    section = {"beam": 58.8, "draft": 16.0, "width": 205.0, "depth": 24.0}
    speed, low, high = 13.5 * 0.514444, 0.0, 2.8
    for _ in range(60):
        back = (low + high) / 2
        sinkage = back * (2 * speed + back) / (2 * 9.81)
        room = 205.0 * (24.0 - sinkage) - 0.98 * 58.8 * 16.0
        low, high = (back, high) if (speed + back) * room < speed * 205.0 * 24.0 else (low, back)
    grown = parameter(clearance.fast_bank_distance, y=1.0, u=speed, **section)
    assert grown / parameter(clearance.bank_distance, y=1.0, **section) == pytest.approx(
        (1 + back / speed) ** 2, rel=1e-6
    )
    assert back == pytest.approx(2.78, abs=0.01)


@pytest.mark.parametrize("form", nw.FORMS)
def test_the_bank_turns_the_leading_end_away_astern_as_ahead(form: str, dtc: nw.Model) -> None:
    """Mirror symmetry of bow and stern: the same force, the opposite moment."""
    table = nw.TermTable(form, (), nw.FORMS[form].sway, nw.FORMS[form].yaw)
    model = nw.Model(replace(dtc.configuration, canal=nw.Canal(7.0, 0.4)), table, dict.fromkeys(table.names, 0.1))
    ahead, astern = (model.forces(nw.Motion.at(y=1.0, u=u)) for u in (0.8, -0.8))
    assert ahead["N"] < 0 < ahead["Y"]
    assert (astern["Y"], astern["N"]) == (ahead["Y"], -ahead["N"])


NAMES = [
    base + form + helm
    for base in BASES
    for form in ("", *(f"+{form}" for form in nw.FORMS), "+open_water")
    for helm in ("", "+helm", "+asymmetry")
    if not (helm == "+helm" and any(term.kind is nw.TermKind.RUDDER for term in BASES[base].terms))
]


@pytest.mark.parametrize("name", [*NAMES, "tapered", "paper+helm+tuck"])
def test_named_tables_go_into_model_files_and_back(name: str, dtc: nw.Model, tmp_path) -> None:
    table = table_named(name)
    kvlcc2 = nw.published("yasukawa2015_kvlcc2").configuration
    ship = replace(dtc.configuration.ship, mass=245.0, inertia=243.0, x_g=-0.04, flow_straightening=0.5)
    configuration = nw.Configuration(ship, nw.Canal(7.0, 0.4), propeller=kvlcc2.propeller, rudder=kvlcc2.rudder)
    model = nw.Model(configuration, table, {own: 0.1 + i for i, own in enumerate(table.names)})
    nw.save_model(model, tmp_path / "m.toml")
    again = nw.load_model(tmp_path / "m.toml")
    assert again.terms == table
    motion = nw.Motion.at(y=1.0, psi=0.1, u=1.0, v=0.1, r=0.02)
    assert again.forces(motion) == model.forces(motion)
    assert table.has_bank == ("open_water" not in name and name not in ("mmg", "mmg+asymmetry"))


def test_a_model_that_feels_no_bank_says_so(dtc: nw.Model, short: nw.CaptiveTests) -> None:
    assert dtc.has_bank
    assert dtc.bank_note == ""
    silent = dtc.with_coefficients(b_bank=0.0, c_bank=0.0)
    assert "bank coefficients are 0" in silent.bank_note
    assert not silent.has_bank
    assert "'paper+open_water' have no bank force" in dtc.in_open_water().bank_note
    assert "'mmg' have no bank force" in nw.published("yasukawa2015_kvlcc2").bank_note
    assert table_named("paper+open_water").bank_note in nw.identify(short, table_named("paper+open_water")).notes
    assert not any("have no bank force" in note for note in nw.identify(short).notes)


def steered(dtc: nw.Model) -> nw.Model:
    """The published ship with a rudder and its gear, in a canal of known depth."""
    hull = replace(dtc.configuration.ship, flow_straightening=0.5)
    canal = replace(dtc.configuration.canal, depth=0.4)
    configuration = replace(dtc.configuration, ship=hull, canal=canal, steering=nw.SteeringGear(35.0, 20.0))
    helm = {"a_helm": 5.0, "b_helm": 6.0, "c_helm": 2.9}
    return nw.Model(configuration, table_named("paper+helm"), {**dtc.coefficients, **helm})


DOORS = {
    "simulate": lambda model, _: nw.simulate(model, duration=1.0).notes,
    "ensemble": lambda model, _: nw.ensemble(model, duration=1.0).attrs["notes"],
    "steady course": lambda model, _: nw.steady_course(model, y=0.1, u=0.8).attrs["notes"],
    "stability": lambda model, _: nw.stability(model, u=0.8).attrs["notes"],
    "scale": lambda model, _: nw.scale_model(model, 355.0, width=500.0).notes,
    "envelope": lambda model, _: nw.safe_envelope(model, np.array([0.0]), np.array([0.6]), samples=2).notes,
    "map": lambda model, cli: cli("map", model, "--y", "0,0.1", "--duration", 1, "--json")[1],
    "scale by name": lambda model, cli: cli("scale", model, "--length", 355, "--width", 500, "--json")[1],
}
"""Whoever asks about a canal."""


@pytest.mark.parametrize("door", DOORS)
def test_every_door_says_that_a_model_feels_no_bank(door: str, dtc: nw.Model, cli, tmp_path: Path) -> None:
    model = steered(dtc)
    for said, own in ((True, model.with_coefficients(b_bank=0.0, c_bank=0.0)), (False, model)):
        own.save(tmp_path / "m.toml")
        notes = DOORS[door](tmp_path / "m.toml" if "map" in door or "name" in door else own, cli)
        assert ("bank coefficients are 0" in str(notes)) is said


def test_bank_terms_are_called_as_the_tables_others() -> None:
    assert {"Y_bank", "N_bank"} < set(table_named("mmg+delta").names)
    assert {"Y_bank_depth", "N_bank_depth"} < set(table_named("mmg+delta_depth").names)
    assert without(table_named("mmg+delta"), "mmg", lambda term: term.from_bank) == nw.MMG
    assert nw.with_bank(nw.TAPERED, "tuck") == table_named("paper+tuck")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("paper+tcuk", "did you mean 'tuck'"),
        ("papr", "did you mean 'paper'"),
        ("tapered+tuck", "'tapered\\+tuck' have two forms"),
        ("paper+delta+open_water", "two forms"),
        ("mmg+helm", "'mmg' have a rudder"),
        ("steered+tuck+helm", "have a rudder"),
        ("paper+helm+helm", "have a rudder"),
    ],
)
def test_unknown_tables_are_refused(name: str, said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        table_named(name)


def test_a_form_of_ones_own() -> None:
    def gap(y, width):
        return y / width

    mine = nw.BankForm("gap", {"bank": gap}, "mine", "anywhere", "ours")
    table = nw.with_bank(nw.PAPER, mine)
    assert table.name == "paper+gap"
    assert table["b_bank"].inputs == ("y", "width", "u", "heave", "length", "draft", "block_coefficient", "density")
    assert nw.with_bank(table, "delta") == nw.with_bank(nw.PAPER, "delta")
    with pytest.raises(nw.InputError, match="did you mean 'distance'"):
        nw.with_bank(nw.PAPER, "distanc")


@given(toe=st.floats(0.1, 5), run=st.floats(0, 10), depth=st.floats(0.1, 1.0))
def test_an_equivalent_wall_leaves_the_same_section(toe: float, run: float, depth: float) -> None:
    """Against the area under the water by fine trapezia."""
    profile = ((toe, 0.0), (toe + run, 1.0))
    y = np.linspace(0, toe + run, 200_001)
    height = np.interp(y, [0, toe, toe + run], [0, 0, 1.0]) if run else np.zeros_like(y)
    area = np.trapezoid(np.maximum(depth - height, 0), y)
    assert equivalent_wall(profile, depth) == pytest.approx(area / depth, rel=1e-5)


def test_equivalent_walls_by_hand() -> None:
    assert equivalent_wall(((2.83, 0.0), (2.83, 0.5)), 0.2) == 2.83
    assert equivalent_wall(((0.53, 0.0), (3.03, 0.5)), 0.2) == pytest.approx(0.53 + 5 * 0.2 / 2)
    platform = ((0.53, 0.0), (1.13, 0.12), (3.5, 0.12))
    assert equivalent_wall(platform, 0.24) == pytest.approx(3.5 - (0.6 * 0.06 + 2.37 * 0.12) / 0.24)
    drawn_down = ((1.0, 0.4), (2.0, 0.0), (3.0, 0.0))
    assert equivalent_wall(drawn_down, 0.2) == pytest.approx(3.0 - (0.5 + 0.5 * 0.5))


@pytest.mark.parametrize(
    ("profile", "depth", "said"),
    [
        (((1.0, 0.0), (0.5, 1.0)), 0.2, "turns back"),
        (((0.0, 1.0), (1.0, 1.0)), 0.2, "leaves no water"),
        (((1.0, 0.0), (2.0, 1.0)), 0.0, "no water"),
    ],
)
def test_walls_that_are_none_are_refused(profile, depth: float, said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        equivalent_wall(profile, depth)
