"""What varies over an ensemble keeps the rules of ship files; tied coefficients vary together."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import narrows as nw
from narrows.ship.checks import POSITIVE, RULES

DTC, KVLCC2 = nw.published("mikkelsen2025_dtc"), nw.published("yasukawa2015_kvlcc2")
# Its thrust astern is left out: without it revolutions astern are wrong.
AHEAD = replace(KVLCC2.configuration.propeller, astern_0=0.0, astern_1=0.0, astern_2=0.0)
KVLCC2 = replace(KVLCC2, configuration=KVLCC2.configuration.with_parts([AHEAD]))
SHIPS = xr.DataArray([1.0, 1.0, 1.0, 1.0], dims="ship", coords={"ship": ["a", "b", "c", "d"]})


def column(good: float, bad: float) -> xr.DataArray:
    """The third ship's value is bad."""
    return SHIPS.copy(data=[good, good, bad, bad])


def sentence(act) -> str:
    with pytest.raises(nw.InputError) as error:
        act()
    return str(error.value)


WRONG = {
    "beam": [-0.5, 0.0, np.nan, np.inf, 1e30, 1e-30, 7.0, 8.0],
    "density": [-1000.0, 0.0],
    "depth": [0.1, 0.163, -1.0],
    "draft": [-0.1],
    "length": [-1.0, 1e308],
    "block_coefficient": [1.01, 0.0],
    "width": [0.5, -7.0],
    "mass": [-1.0],
    "inertia": [0.0],
}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in WRONG.items() for value in values])
def test_columns_keep_the_rules_of_numbers_and_say_so_alike(name: str, value: float) -> None:
    """One rule, two doors: a ship file and an ensemble refuse the same value in the same words, with its place."""
    plain = {**DTC.configuration.values(), "depth": 0.3, name: value}

    def configured() -> nw.Configuration:
        names = ("length", "beam", "draft", "block_coefficient", "mass", "inertia")
        ship = nw.Ship(**{own: plain[own] for own in names if own in plain})
        return nw.Configuration(ship, nw.Canal(plain["width"], plain["depth"]), nw.Water(plain["density"]))

    good = DTC.configuration.values().get(name, 0.3 if name == "depth" else 1.0)
    said = sentence(lambda: nw.ensemble(DTC, **{"y": 0.1, name: column(good, value)}))
    assert said == f"{sentence(configured)} (the first is at ship = c)"
    assert sentence(lambda: nw.ensemble(DTC, **{name: value})) == sentence(configured)


@pytest.mark.parametrize(
    ("name", "value"),
    [("propeller_diameter", -1.0), ("propeller_wake", 1.0), ("rudder_area", 0.0), ("revolutions", -1.0)],
)
def test_actuators_too(name: str, value: float) -> None:
    good = KVLCC2.configuration.values()[name]
    part = nw.Rudder if name.startswith("rudder") else nw.Propeller
    own = KVLCC2.configuration.rudder if part is nw.Rudder else KVLCC2.configuration.propeller
    key = name.removeprefix("rudder_").removeprefix("propeller_")
    said = sentence(lambda: nw.ensemble(KVLCC2, contact="none", **{name: column(good, value)}))
    assert said == f"{sentence(lambda: part(**{**vars(own), key: value}))} (the first is at ship = c)"


def test_two_that_vary_apart_are_placed_by_both() -> None:
    said = sentence(lambda: nw.ensemble(DTC, beam=[0.5, 2.0], width=[3.0, 1.0]))
    assert said.startswith("[ship] beam = 2.0 m does not fit in [canal] width = 1.0 m")
    assert sentence(lambda: nw.ensemble(DTC, draft=SHIPS.copy(data=[0.1, 0.2, 0.3, 0.4]), depth=[0.5, 0.25])).endswith(
        "(the first is at ship = c)"
    )


def test_every_rule_asks_for_what_has_a_place() -> None:
    known = {*nw.published("yasukawa2015_kvlcc2").configuration.values(), "limit_deg", "rate_deg"} | {
        "dead_time", "lag", "dead_band_deg", "pumps", "mass", "inertia", "flow_straightening", "depth",
    }  # fmt: skip
    assert {name for rule in RULES for name in rule.asks} <= known
    assert set(POSITIVE) <= known


@pytest.mark.parametrize(
    ("vary", "said"),
    [
        ({"b_v": [100.0, -1.0]}, "coefficient b_v = -1.0 is below the 0 that its term allows"),
        ({"b_v": [100.0, np.nan]}, "b_v = nan is not a finite number"),
        ({"b_rdot": [1.0, 2.0], "c_vdot": [1.0, 2.0]}, "b_rdot and c_vdot are one coefficient"),
        ({"b_rdot": 1.0, "c_vdot": 2.0}, "b_rdot and c_vdot are one coefficient"),
        ({"b_rdot": column(1.0, 2.0), "c_vdot": column(1.0, 3.0)}, "b_rdot and c_vdot are one coefficient"),
        ({"y": []}, "y is empty"),
        ({"y": 1j}, "not a finite number"),
        ({"y": [0.1, 1j]}, "not a finite number"),
        ({"y": SHIPS.astype(complex)}, "not a finite number"),
        ({"y": "0.5"}, "not a finite number"),
        ({"y": ["a"]}, "not a finite number"),
        ({"y": True}, "not a finite number"),
        ({"y": None}, "not a finite number"),
        ({"y": 10**400}, "not a finite number"),
        ({"y": [0.0, 10**5000]}, "not a finite number"),
        ({"y": np.array(["2020-01-01"], "M8[ns]")}, "not a finite number"),
        ({"y": [[1.0, 2.0], [3.0]]}, "not a finite number"),
        ({"y": [[1.0]]}, "2 dimensions"),
        ({"y": {}}, "not a finite number"),
        ({"y": SHIPS, "u": SHIPS[:2]}, "length and labels"),
        ({"y": SHIPS, "u": SHIPS.assign_coords(ship=[1, 2, 3, 4])}, "length and labels"),
        ({"y": xr.DataArray([0.1], dims="time")}, "a dimension 'time', which cannot be one"),
        ({"y": xr.DataArray([0.1], dims=[3])}, "a dimension 3, which cannot be one"),
        ({"samples": 1.5}, "give a whole number from 0"),
        ({"samples": True}, "give a whole number from 0"),
        ({"seed": -1}, "give a whole number from 0"),
        ({"samples": 10**12}, "from 0 to 10000000"),
    ],
)
def test_what_cannot_vary_is_said(vary: dict, said: str) -> None:
    assert said in sentence(lambda: nw.ensemble(DTC, **vary))


@pytest.mark.parametrize(
    ("u", "said"), [([], "u is empty"), ([[4.0]], "u has 2 dimensions"), (["a"], "is not a finite number")]
)
def test_speeds_that_no_default_helm_is_for_are_said(u: list, said: str) -> None:
    assert said in sentence(lambda: nw.ensemble(nw.published("estimated_kcs"), u=u, hold=0.0))


def test_a_tie_varies_together() -> None:
    """Either of the two, or both the same: one ensemble, and not the one where the other stays behind."""
    value = column(DTC.coefficients["b_rdot"], 0.5 * abs(DTC.coefficients["b_rdot"]) + 1.0)
    one, other, both = (
        nw.ensemble(DTC, y=1.0, duration=20.0, **vary)
        for vary in ({"b_rdot": value}, {"c_vdot": value}, {"b_rdot": value, "c_vdot": value})
    )
    xr.testing.assert_identical(one, other)
    xr.testing.assert_identical(one, both)
    alone = [
        nw.simulate(DTC.with_coefficients(b_rdot=float(own), c_vdot=float(own)), 1.0, duration=20.0) for own in value
    ]
    np.testing.assert_allclose(one["time"], [voyage.outcome.time for voyage in alone], rtol=1e-9)


@pytest.mark.parametrize("name", ["x", "Y", "heave", "a_u"])
def test_what_changes_nothing_may_vary_alone(name: str) -> None:
    """A coefficient of the surge where the speed is held enters no equation; there are two voyages all the same."""
    two = nw.ensemble(DTC, duration=1.0, **{name: xr.DataArray([0.1, 0.2], dims="a")})
    assert two["outcome"].dims == ("a",)


def test_ties_lead_on() -> None:
    """m in surge, sway and yaw is one mass, by two ties."""
    mass = KVLCC2.coefficients["X_mass"] * np.array([1.0, 1.3])
    found = [
        nw.ensemble(KVLCC2, u=5.0, rudder=0.3, contact="none", duration=50.0, surge="free", **{name: mass})
        for name in ("X_mass", "Y_mass", "N_mass")
    ]
    for other in found[1:]:
        np.testing.assert_array_equal(found[0]["psi_end"], other["psi_end"])
    assert found[0]["psi_end"][0] != found[0]["psi_end"][1]


def test_samples_of_a_tie_give_way_to_what_is_given(twin_fit: nw.Fit) -> None:
    one = nw.ensemble(twin_fit.model, y=1.0, samples=8, duration=10.0, b_rdot=3.0)
    two = nw.ensemble(twin_fit.model, y=1.0, samples=8, duration=10.0, c_vdot=3.0)
    xr.testing.assert_identical(one, two)
