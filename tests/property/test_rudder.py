"""The rudder: signs, limits, symmetry, and its coefficients from twins and from the measured tests."""

import json
import re
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from strategies import numbers

import narrows as nw
from dop853 import integrated
from narrows.captive.measured import measured_files
from narrows.physics import propeller_and_rudder as mmg

TURNED = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"
STATE = {"u": 1.0, "v": 0.0, "r": 0.0, "length": 4.0, "draft": 0.2, "flow_straightening": 0.5, "density": 1000.0}
HELM = {"surge": mmg.helm_surge, "sway": mmg.helm_sway, "yaw": mmg.helm_yaw}


def value(function, angle: float, **changed: float) -> float:
    return function(SimpleNamespace(**STATE | {"cos_rudder": np.cos(angle), "sin_rudder": np.sin(angle)} | changed))


def test_to_starboard_is_positive() -> None:
    """A rudder to starboard pushes the stern to port, turns the bow to starboard, and holds it back."""
    assert value(mmg.helm_yaw, 0.2) > 0
    assert value(mmg.helm_sway, 0.2) < 0
    assert value(mmg.helm_surge, 0.2) < 0


@pytest.mark.parametrize("name", ["sway", "yaw"])
@given(v=numbers(-0.3, 0.3), r=numbers(-0.1, 0.1))
def test_amidships_adds_nothing(name: str, v: float, r: float) -> None:
    assert value(HELM[name], 0.0, v=v, r=r) == 0.0


@given(angle=numbers(-0.6, 0.6), v=numbers(-0.3, 0.3), r=numbers(-0.1, 0.1))
def test_mirrored(angle: float, v: float, r: float) -> None:
    for name, sign in (("surge", 1), ("sway", -1), ("yaw", -1)):
        own, mirrored = value(HELM[name], angle, v=v, r=r), value(HELM[name], -angle, v=-v, r=-r)
        assert own == pytest.approx(sign * mirrored, rel=1e-12, abs=1e-12)


@given(angle=numbers(0.01, 0.6))
def test_straight_ahead_it_is_the_normal_force(angle: float) -> None:
    pressure = 0.5 * 1000.0 * 0.01 * 4.0 * 0.2
    assert value(mmg.helm_sway, angle) == pytest.approx(-pressure * np.sin(angle) * np.cos(angle), rel=1e-12)
    assert value(mmg.helm_yaw, angle) == pytest.approx(4.0 * pressure * np.sin(angle) * np.cos(angle), rel=1e-12)
    assert value(mmg.helm_surge, angle) == pytest.approx(-pressure * np.sin(angle) ** 2, rel=1e-12)


def test_where_the_flow_follows_the_rudder_there_is_no_normal_force() -> None:
    """Drift to port at half straightening: the flow comes at the rudder's own angle."""
    angle = np.arctan(0.5 * 0.2)
    assert value(mmg.helm_surge, angle, v=-0.2) == pytest.approx(0.0, abs=1e-12)


def steered_ship() -> nw.Model:
    """The published hull with a rudder of known coefficients."""
    dtc = nw.published("mikkelsen2025_dtc")
    values = {n: dtc.coefficients.get(n, 0.0) for n in nw.STEERED.names}
    values |= {"b_uv": 100.0, "b_ur": 118.0, "c_uv": 414.0, "c_ur": 284.9, "a_helm": 5.0, "b_helm": 6.0, "c_helm": 2.9}
    configuration = replace(dtc.configuration, ship=replace(dtc.configuration.ship, flow_straightening=0.5))
    return nw.Model(configuration, nw.STEERED, values)


def test_coefficients_come_back_from_a_twin() -> None:
    truth = steered_ship()
    kinds = [(kind, amplitude) for kind in ("yaw", "sway") for amplitude in (0.4, 0.7)] * 4
    runs = [nw.HarmonicRun(f"{i}", kind, size, 20.0, 1.0, 1) for i, (kind, size) in enumerate(kinds)]
    tests = nw.twin(truth, runs, rate=5.0)
    draw = np.random.default_rng(3)
    angle = np.repeat(draw.uniform(-0.5, 0.5, len(tests.names)), np.diff(tests.starts))
    motion = nw.Motion(**{name: tests.columns[name] for name in nw.Motion().values()})
    noisy = {f: own + draw.normal(0, 0.3, tests.rows) for f, own in truth.forces(motion, rudder=angle).items()}
    turned = {"rudder": angle, "cos_rudder": np.cos(angle), "sin_rudder": np.sin(angle)}
    fit = nw.identify(replace(tests, columns={**tests.columns, **noisy, **turned}), nw.STEERED)
    for name in ("a_helm", "b_helm", "c_helm"):
        low, high = fit.intervals[name]
        assert low < truth.coefficients[name] < high
        assert fit.verdicts[name].status == "identified" or name == "a_helm"


def test_voyages_turn_with_the_rudder_and_mirror() -> None:
    ship = steered_ship()
    wide = replace(ship, configuration=replace(ship.configuration, canal=nw.Canal(700.0)))
    port, starboard = (nw.simulate(wide, rudder=angle, duration=20.0) for angle in (-0.1, 0.1))
    assert starboard.psi[-1] > 0.05
    np.testing.assert_array_equal(port.psi, -starboard.psi)
    fleet = nw.ensemble(wide, rudder=[-0.1, 0.0, 0.1], duration=20.0, dt=0.02)
    np.testing.assert_allclose(fleet.psi_end, [port.psi[-1], 0.0, starboard.psi[-1]], atol=1e-9)
    exact = integrated(wide, 20.0, rudder=0.1)
    assert starboard.psi[-1] == pytest.approx(exact.psi[-1], rel=1e-6)


@cache
def measured(condition: str) -> nw.Fit:
    tests = nw.read_captive(*measured_files("kcs"), TURNED)
    return nw.identify_conditions(tests, condition, terms=nw.STEERED)[condition]


def test_the_measured_rudder_sits_at_the_stern_by_least_squares_too() -> None:
    """Before the scatter from test to test is estimated, which takes most of the time of a fit."""
    found = measured("C0101A03").least_squares
    assert found["b_helm"] > 0
    assert 0.3 < found["c_helm"] / found["b_helm"] < 0.6


@pytest.mark.parametrize("condition", ["C0101A01", "C0101A02", "C0101A03"])
def test_the_measured_rudder_sits_at_the_stern(condition: str) -> None:
    fit = measured(condition)
    for name in ("a_helm", "b_helm", "c_helm"):
        assert fit.verdicts[name].determined
        assert fit.intervals[name][0] > 0 or name == "a_helm"
    assert 0.3 < fit.coefficients["c_helm"] / fit.coefficients["b_helm"] < 0.6


def test_a_rudder_without_particulars_is_asked_for(tmp_path, cli) -> None:
    table, ship = measured_files("kcs")
    bare = tmp_path / "bare.toml"
    bare.write_text(ship.read_text().replace("flow_straightening", "# flow_straightening"))
    code, _, err = cli("identify", table, "--ship", bare, "--terms", "steered", "--where", TURNED, "--json")
    assert code == 2
    assert "add flow_straightening to section [ship] of the ship file: flow across the rudder" in err
    assert not table.with_name("columns.toml").exists(), "its columns are not at fault"


def test_what_the_mmg_terms_lack_is_asked_for_by_section(tmp_path, cli) -> None:
    table, ship = measured_files("kcs")
    where = ("--where", TURNED, "--condition", "C0101A02")
    code, _, err = cli("identify", table, "--ship", ship, "--terms", "mmg", *where, "--json")
    assert code == 2
    assert re.search(r"add \w+( \[\w+\])? to section \[(propeller|rudder)\] of the ship file: ", err)


def test_simulate_with_a_rudder_on_the_command_line(tmp_path, cli) -> None:
    nw.save_model(steered_ship(), tmp_path / "m.toml")
    outs = [
        json.loads(cli("simulate", tmp_path / "m.toml", "--rudder-deg", angle, "--duration", 5, "--json")[1])
        for angle in (-5, 5)
    ]
    assert outs[0]["state"]["psi"] == -outs[1]["state"]["psi"] < 0
