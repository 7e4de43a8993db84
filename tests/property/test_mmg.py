"""The MMG standard method's parts: limits, symmetry, scale."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from strategies import numbers

import narrows as nw
from narrows.physics import hull
from narrows.physics import propeller_and_rudder as mmg
from narrows.quantities.names import name_of

KVLCC2 = nw.published("yasukawa2015_kvlcc2")
VALUES = {**KVLCC2.configuration.values(), "u": 1.0, "v": 0.0, "r": 0.0, "cos_rudder": 1.0, "sin_rudder": 0.0}


def value(function, **changed: float) -> float:
    return float(function(SimpleNamespace(**VALUES | changed)))


@given(degrees=numbers(-45, 45))
def test_drift_errs_as_little_as_it_says(degrees: float) -> None:
    angle = np.radians(degrees)
    error = abs(hull.drift(np.cos(angle), -np.sin(angle)) - angle)
    assert error < (4e-6 if abs(degrees) <= 30 else 2e-4)


@given(u=numbers(0.2, 2.0), n=numbers(1.0, 15.0))
def test_thrust_is_the_open_water_curve(u: float, n: float) -> None:
    screw = KVLCC2.configuration.propeller
    j = u * (1 - screw.wake) / (n * screw.diameter)
    k_t = screw.thrust_0 + screw.thrust_1 * j + screw.thrust_2 * j * j
    expected = 1000.0 * n * n * screw.diameter**4 * k_t
    assert value(mmg.thrust, u=u, revolutions=n) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_propeller_that_stands_drags() -> None:
    assert value(mmg.thrust, revolutions=0.0) < 0


@given(v=numbers(-0.3, 0.3), r=numbers(-0.15, 0.15))
def test_the_wake_thins_as_she_turns(v: float, r: float) -> None:
    straight = value(mmg.inflow)
    assert straight == pytest.approx(1 - VALUES["propeller_wake"])
    assert value(mmg.inflow, v=v, r=r) >= straight - 1e-12


@given(v=numbers(-0.3, 0.3), r=numbers(-0.15, 0.15), angle=numbers(-0.6, 0.6))
def test_mirrored_where_propeller_and_rudder_are_alike_on_both_sides(v: float, r: float, angle: float) -> None:
    alike = {"propeller_wake_port": 1.6, "rudder_straightening_port": 0.640}
    for function, sign in ((mmg.rudder_surge, 1), (mmg.rudder_sway, -1), (mmg.rudder_yaw, -1)):
        own, other = (
            value(function, v=s * v, r=s * r, sin_rudder=s * np.sin(angle), cos_rudder=np.cos(angle), **alike)
            for s in (1, -1)
        )
        assert own == pytest.approx(sign * other, rel=1e-9, abs=1e-9)


@given(angle=numbers(0.02, 0.6))
def test_a_rudder_to_starboard_turns_her_to_starboard_and_holds_her_back(angle: float) -> None:
    turned = {"sin_rudder": np.sin(angle), "cos_rudder": np.cos(angle)}
    assert value(mmg.rudder_yaw, **turned) > 0 > value(mmg.rudder_sway, **turned)
    assert value(mmg.rudder_surge, **turned) < 0


@given(slow=numbers(1.4, 15.0), more=numbers(0.01, 5.0))
def test_more_revolutions_never_slow_the_slipstream(slow: float, more: float) -> None:
    """From where the thrust itself rises, dragging too; without thrust the inflow stays as it is."""
    flows = [value(mmg.axial_velocity, revolutions=n) for n in (slow, slow + more)]
    assert flows[0] <= flows[1] + 1e-12
    screw = KVLCC2.configuration.propeller
    idle = np.roots([screw.thrust_2, screw.thrust_1, screw.thrust_0]).max()  # J of no thrust
    n = value(mmg.inflow) / (idle * screw.diameter)
    assert value(mmg.axial_velocity, revolutions=n) == pytest.approx(1.09 * value(mmg.inflow), rel=1e-9)


def test_every_term_has_a_name_in_print() -> None:
    names = [name_of(term.regressor) for term in nw.MMG.terms]
    assert all(names)
    assert name_of(nw.MMG["X_rudder"].regressor) == "rudder_surge"
    assert name_of(nw.MMG["Y_vvr"].regressor) == "hull_v2_r1"


def test_angles_that_the_gear_does_not_reach_are_refused() -> None:
    for asked in ({"turn_deg": 60.0}, {"turn_deg": 0.0}, {"turn_deg": np.radians(0.6)}, {"zigzags": ((60.0, 10.0),)}):
        with pytest.raises(nw.InputError, match="the gear's 35"):
            nw.sail_trials(KVLCC2, 1.179, **asked)
    with pytest.raises(nw.InputError, match="must be a finite number"):
        nw.sail_trials(KVLCC2, 1.179, turn_deg=np.nan)


def test_trials_in_radians_are_named_in_degrees() -> None:
    found = nw.sail_trials(KVLCC2, 1.179, turn_deg=np.radians(35), zigzags=())
    assert [*found.turning] == ["+35", "-35"]
    assert "the rudder of 0.610865 was read in radians, 35 degrees" in found.notes
    with pytest.raises(nw.InputError, match="give its angle"):
        nw.ConstantRudder(np.nan)


def test_the_slipstream_makes_the_rudder_stronger() -> None:
    turned = {"sin_rudder": 0.3, "cos_rudder": 0.954}
    assert value(mmg.rudder_yaw, revolutions=15.0, **turned) > value(mmg.rudder_yaw, revolutions=8.0, **turned)


@given(power=numbers(0.5, 3.0))
def test_hull_forces_go_with_the_square_of_the_speed(power: float) -> None:
    for term in (nw.MMG[name] for name in ("R_0", "X_vvvv", "Y_v", "Y_vvr", "N_rrr")):
        slow, fast = (float(term.column({**VALUES, "u": k * 1.0, "v": k * 0.2, "r": k * 0.1})) for k in (1.0, power))
        assert fast == pytest.approx(power**2 * slow, rel=1e-9)


def test_a_rigid_body_is_newtons() -> None:
    """Forces on the rig are those that a point mass at x_G needs, by finite differences of its velocity."""
    mass, x_g, inertia = 3.0, 0.4, 2.0
    u, v, r, udot, vdot, rdot = 1.2, 0.3, -0.2, 0.05, -0.07, 0.11
    ax = udot - v * r - x_g * r * r
    ay = vdot + u * r + x_g * rdot
    assert hull.rigid_surge(udot, v, r, mass, x_g) == pytest.approx(-mass * ax)
    assert hull.rigid_sway(vdot, rdot, u, r, mass, x_g) == pytest.approx(-mass * ay)
    about_midship = -(inertia - mass * x_g**2) * rdot - mass * x_g * ay
    assert hull.rigid_yaw(vdot, rdot, u, r, mass, x_g, inertia) == pytest.approx(about_midship)


def test_a_geosim_by_froude_turns_the_same_circle() -> None:
    full = nw.scale_model(KVLCC2, 320.0, 1025.0).model
    ratio = 320.0 / 7.0
    small, large = (
        nw.sail_trials(model, 1.179 * k**0.5, zigzags=(), dt=0.05 * k**0.5).to_dict()["turning"]["+35"]
        for model, k in ((KVLCC2, 1.0), (full, ratio))
    )
    assert large == pytest.approx(small, rel=1e-9)


def test_machinery_goes_through_files(tmp_path) -> None:
    nw.save_model(KVLCC2, tmp_path / "m.toml")
    assert nw.load_model(tmp_path / "m.toml").configuration == KVLCC2.configuration


@pytest.mark.parametrize(
    ("changed", "said"),
    [({"wake": 1.2}, "no fraction"), ({"diameter": 0.0}, "must be positive"), ({"thrust_0": float("nan")}, "finite")],
)
def test_a_propeller_that_cannot_be_is_named(changed: dict, said: str) -> None:
    with pytest.raises(nw.InputError, match=rf"\[propeller\].*{said}"):
        replace(KVLCC2.configuration.propeller, **changed)


def test_the_command_prints_trials(cli, tmp_path) -> None:
    tracks = tmp_path / "t.svg"
    code, out, _ = cli("trials", "yasukawa2015_kvlcc2", "--speed", "1.179m/s", "--zigzags", "20/20", "--plot", tracks)
    assert code == 0
    assert "tactical diameter/L" in out
    assert tracks.stat().st_size > 5_000
    code, _, error = cli("trials", "yasukawa2015_kvlcc2", "--speed", "1.179", "--zigzags", "ten")
    assert code == 2
    assert "such as 10/10,20/20" in error


def test_without_banks_a_canal_model_turns_in_open_water(dtc: nw.Model) -> None:
    """Nothing of the bank is left, and the rest is the same."""
    own = dtc.in_open_water()
    assert not {"b_bank", "c_bank"} & set(own.terms.names)
    motion = nw.Motion.at(0.1, y=1.0, u=1.0, v=0.1, r=0.05)
    bank = dtc.bank_forces(motion)
    for force, found in own.forces(motion).items():
        assert found == pytest.approx(dtc.forces(motion)[force] - bank[force])
    assert own.in_open_water() is own
    with pytest.raises(nw.InputError, match="have a bank"):
        nw.simulate(dtc, contact="none")
