"""A ship whose sides differ: Y_0' and N_0' by hand, as a rudder that is off, and in a file and a voyage."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import narrows as nw
from narrows.model.tables import table_named


def kvlcc2(sway: float = 0.0, yaw: float = 0.0) -> nw.Model:
    plain = nw.published("yasukawa2015_kvlcc2")
    numbers = {**plain.coefficients, "Y_0": sway, "N_0": yaw}
    table = table_named("mmg+asymmetry")
    return replace(plain, terms=table, coefficients={name: numbers.get(name, 0.0) for name in table.names})


def test_force_and_moment_are_those_of_the_primes_by_hand() -> None:
    """1/2 rho L d U^2 Y_0' and 1/2 rho L^2 d U^2 N_0', with 1000 kg/m3, 7 m, 0.46 m and U^2 = 1.3."""
    motion = nw.Motion.at(u=1.1, v=0.3)
    even, odd = kvlcc2().forces(motion), kvlcc2(0.002, 0.001).forces(motion)
    assert float(odd["Y"] - even["Y"]) == pytest.approx(0.5 * 1000 * 7.0 * 0.46 * 1.3 * 0.002, rel=1e-9)
    assert float(odd["N"] - even["N"]) == pytest.approx(0.5 * 1000 * 7.0**2 * 0.46 * 1.3 * 0.001, rel=1e-9)


def test_a_moment_to_starboard_turns_the_voyage_to_starboard_and_survives_a_file(tmp_path: Path) -> None:
    model = kvlcc2(yaw=0.001)
    model.save(tmp_path / "ship.toml")
    again = nw.load_model(tmp_path / "ship.toml")
    free = {"u": 1.2, "duration": 40.0, "contact": "none", "surge": "free"}
    turned = [float(nw.simulate(ship, **free).psi[-1]) for ship in (kvlcc2(), model, again)]
    assert turned[1] > turned[0] + np.radians(1.0)
    assert turned[2] == turned[1]


@pytest.mark.parametrize("name", ["steered+keel_gap+asymmetry", "paper+helm+asymmetry", "mmg+asymmetry+delta"])
def test_an_asymmetry_goes_with_any_table_and_another_bank_keeps_it(name: str) -> None:
    table = table_named(name)
    sway, yaw = (f"{letter}_0" for letter in table.letters[1:])
    assert {sway, yaw} <= set(table.names)
    assert {sway, yaw} <= set(nw.with_bank(table, "tuck").names)
    assert table_named(nw.with_bank(table, "tuck").name).names == nw.with_bank(table, "tuck").names


def test_a_straightening_by_side_is_that_of_the_ships_numbers() -> None:
    """gamma_R of 0.01 more to starboard and 0.01 less to port, by differences of the rudder's force."""
    model, motion = kvlcc2(), nw.Motion.at(u=1.1, v=-0.15, r=0.04)
    configuration, rudder = model.configuration, model.configuration.rudder
    wide, narrow = (
        replace(model, configuration=configuration.with_parts([
            replace(rudder, straightening_starboard=0.64 + g, straightening_port=0.395 - g)
        ])) for g in (1e-4, -1e-4)
    )  # fmt: skip
    slopes = {
        name: float(wide.forces(motion, rudder=0.2)[name] - narrow.forces(motion, rudder=0.2)[name]) / 2e-4
        for name in "YN"
    }
    for force in "YN":
        one = model.with_coefficients(**{f"{force}_straightening": model[f"{force}_rudder"]})
        more = one.forces(motion, rudder=0.2)[force] - model.forces(motion, rudder=0.2)[force]
        # The flow across the rudder adds a little to the dynamic pressure, of which the term is free.
        assert float(more) == pytest.approx(slopes[force], rel=0.15)


def test_an_even_rudder_force_is_the_same_to_either_side() -> None:
    """On a straight course sin^2 delta for sin delta: the rudder's own force times the sine of its angle."""
    model = kvlcc2()
    for force in "YN":
        odd = model.with_coefficients(**{f"{force}_rudder_even": model[f"{force}_rudder"]})
        for rudder in (0.5, -0.5):
            at = {"u": 1.2, "rudder": rudder}
            own = model.forces(**at)[force] - model.forces(u=1.2)[force]
            more = odd.forces(**at)[force] - model.forces(**at)[force]
            assert float(more) == pytest.approx(float(own) * np.sin(rudder), rel=1e-9)


@pytest.mark.parametrize("name", ["steered", "paper+helm", "crossflow"])
def test_a_rudder_outside_a_slipstream_has_no_asymmetry_of_its_own(name: str) -> None:
    assert len(table_named(f"{name}+asymmetry").names) == len(table_named(name).names) + 2


def test_two_asymmetries_are_refused() -> None:
    with pytest.raises(nw.InputError, match="have an asymmetry"):
        table_named("mmg+asymmetry+asymmetry")
