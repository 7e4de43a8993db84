"""The published coefficients, and the side taken where the paper contradicts itself."""

import tomllib
from importlib.resources import files

import pytest

import narrows as nw

PRINTED = {
    "a_udot": 0, "a_u": 0, "a_uu": 12.6,
    "b_vdot": 733, "b_rdot": -56.1, "b_v": 100, "b_r": 118, "b_vv": 3298, "b_rr": -161, "b_bank": 1.07,
    "c_vdot": -56.1, "c_rdot": 712, "c_v": 414, "c_r": 84.9, "c_vv": 589, "c_rr": 3346, "c_bank": 0.13,
}  # fmt: skip
"""The optimal regressors of section Results, in the paper's order."""


def test_coefficients_as_printed(dtc: nw.Model) -> None:
    assert dict(dtc.coefficients) == PRINTED
    assert dtc.terms.names == tuple(PRINTED)


def test_the_papers_ship_and_tank(dtc: nw.Model) -> None:
    ship, canal, water = dtc.configuration.ship, dtc.configuration.canal, dtc.configuration.water
    assert (ship.length, ship.beam, ship.draft, ship.block_coefficient) == (3.984, 0.572, 0.163, 0.661)
    assert (canal.width, canal.depth, water.density) == (7.0, None, 1000.0)


def test_file_says_where_it_is_from_and_what_it_covers(dtc: nw.Model) -> None:
    assert "Mikkelsen" in dtc.source.text
    assert "2025" in dtc.source.text
    assert dtc.data_range.abs_y == (0.0, 0.9068)


def test_file_lists_its_terms() -> None:
    text = (files("narrows") / "model" / "published" / "mikkelsen2025_dtc.toml").read_text()
    tables = tomllib.loads(text)["terms"]
    assert {force: tuple(tables[force]) for force in "XYN"} == {
        force: tuple(term.name for term in terms) for force, terms in nw.PAPER.forces.items()
    }


def test_suction_to_the_near_bank_and_bow_away_from_it(dtc: nw.Model) -> None:
    """N_bank is printed with both signs; with c_bank > 0 the minus turns the bow away."""
    starboard = dtc.bank_forces(nw.Motion(y=1.0, u=1.0))
    assert starboard["Y"] > 0 > starboard["N"]
    port = dtc.bank_forces(nw.Motion(y=-1.0, u=1.0))
    assert port["Y"] < 0 < port["N"]


@pytest.mark.parametrize(
    ("motion", "force", "expected"),
    [
        ({"udot": 1.0}, "X", 0.0),
        ({"vdot": 1.0}, "Y", -733.0),
        ({"rdot": 1.0}, "Y", 56.1),
        ({"vdot": 1.0}, "N", 56.1),
        ({"rdot": 1.0}, "N", -712.0),  # printed with + once
        ({"u": 2.0}, "X", -12.6 * 4),
        ({"u": -2.0}, "X", 12.6 * 4),
        ({"v": -0.1}, "Y", 100 * 0.1 + 3298 * 0.01),
        ({"r": 0.1}, "Y", -118 * 0.1 + 161 * 0.01),
        ({"v": 0.1}, "N", -414 * 0.1 - 589 * 0.01),
        ({"r": -0.1}, "N", 84.9 * 0.1 + 3346 * 0.01),
    ],
)
def test_sign_of_each_term(dtc: nw.Model, motion: dict[str, float], force: str, expected: float) -> None:
    assert dtc.forces(nw.Motion(**motion))[force] == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_masses_and_damping_are_not_negative_and_the_rest_is_free() -> None:
    """The problem as printed leaves the masses out; b_rdot >= 0 is stated and broken by the result."""
    bounded = {term.name for term in nw.PAPER.terms if term.bound == nw.NONNEGATIVE}
    assert bounded == {"a_udot", "a_u", "a_uu", "b_vdot", "b_v", "b_vv", "c_rdot", "c_r", "c_rr"}
    assert all(term.bound == nw.FREE for term in nw.PAPER.terms if term.name not in bounded)


def test_one_tie() -> None:
    assert nw.PAPER.ties == (("b_rdot", "c_vdot"),)


def test_open_water_hull_is_course_unstable(dtc: nw.Model) -> None:
    """b_v c_r - b_r c_v < 0."""
    c = dtc.coefficients
    assert c["b_v"] * c["c_r"] - c["b_r"] * c["c_v"] < 0


@pytest.mark.parametrize("y", [0.5, 2.5])
def test_tapered_table_multiplies_the_bank_alone(dtc: nw.Model, y: float) -> None:
    from dataclasses import replace

    from narrows.physics.clearance import taper

    motion = nw.Motion.at(psi=0.1, y=y, u=1.0, v=0.05, r=0.02)
    plain, tapered = dtc, replace(dtc, terms=nw.TAPERED)
    for force in "YN":
        bank = plain.bank_forces(motion)[force]
        assert tapered.bank_forces(motion)[force] == pytest.approx(taper(y, 7.0) * bank, rel=1e-12)
        rest = plain.forces(motion)[force] - bank
        assert tapered.forces(motion)[force] - tapered.bank_forces(motion)[force] == pytest.approx(rest, rel=1e-9)
    assert tapered.forces(motion)["X"] == plain.forces(motion)["X"]
