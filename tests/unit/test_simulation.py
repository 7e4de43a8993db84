"""Voyages against DOP853, against their mirror, against the order of the method; and how they end."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import narrows as nw
from direct_equation import accelerations
from dop853 import integrated
from narrows.base.files import save_dataset
from narrows.simulation import settings
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.ship import SimulatedShip

AWAY = st.one_of(st.floats(0.3, 2.2), st.floats(-2.2, -0.3), st.floats(2.45, 2.6))
"""Starts away from the switch between the banks."""


@given(y=AWAY, psi=st.floats(-0.03, 0.03), u=st.floats(0.6, 1.4))
def test_rk4_agrees_with_dop853(y: float, psi: float, u: float) -> None:
    """Time, side and place of the grounding to 1e-6."""
    model = nw.published("mikkelsen2025_dtc")
    one = nw.simulate(model, y, u, psi=psi, dt=0.01, duration=90.0).outcome
    other = integrated(model, 90.0, y=y, u=u, psi=psi)
    assert (one.kind == "grounded", one.side) == (other.side is not None, other.side)
    assert one.time == pytest.approx(other.t[-1], abs=1e-6)
    assert one.distance == pytest.approx(other.x[-1], abs=1e-6)


@given(y=AWAY, psi=st.floats(-0.2, 0.2), v=st.floats(-0.05, 0.05), r=st.floats(-0.05, 0.05))
def test_mirrored_starts_give_mirrored_voyages(y: float, psi: float, v: float, r: float) -> None:
    model = nw.published("mikkelsen2025_dtc")
    one = nw.simulate(model, y, psi=psi, v=v, r=r, duration=20.0)
    other = nw.simulate(model, -y, psi=-psi, v=-v, r=-r, duration=20.0)
    for name, sign in {"t": 1, "x": 1, "y": -1, "psi": -1, "u": 1, "v": -1, "r": -1}.items():
        np.testing.assert_array_equal(getattr(one, name), sign * getattr(other, name))


def test_rk4_is_of_order_four(dtc: nw.Model) -> None:
    """Before v or r change sign, so that abs() has no kink on the way."""
    start = {"y": 0.5, "v": 0.05, "r": -0.02, "duration": 2.0}
    fine = integrated(dtc, **start)
    assert (fine.v > 0).all()
    assert (fine.r < 0).all()
    errors = [abs(nw.simulate(dtc, **start, dt=dt).y[-1] - fine.y[-1]) for dt in (0.5, 0.25)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)


def test_right_hand_side_is_the_terms_own(dtc: nw.Model) -> None:
    """The compiled equation against the uncompiled terms, to 1e-12."""
    system, values = (ship := SimulatedShip(dtc)).system(pushed="always"), {"X_in": 0.0, "Y_in": 3.0, "N_in": -2.0}
    draw = np.random.default_rng(0)
    y, psi, v, r = draw.uniform(-1, 1, (4, 200)) * [[2.5], [1.2], [0.3], [0.2]]
    motion = nw.Motion(y=y, cos_psi=np.cos(psi), sin_psi=np.sin(psi), u=np.full(200, 0.9), v=v, r=r)
    expected = accelerations(dtc, motion, (0.0, 3.0, -2.0))
    numbers = system.constants({**ship.values(), **values})
    state = (np.zeros(200), y, np.cos(psi), np.sin(psi), motion.u, v, r)
    found = system.columns.rates(*state, *(numbers[name] for name in system.columns.RATES_INPUTS))
    for own, value in zip(expected, found[4:], strict=True):
        np.testing.assert_allclose(np.broadcast_to(value, 200), own, rtol=1e-12, atol=1e-12)


def test_a_fleet_is_its_voyages(dtc: nw.Model) -> None:
    y = np.array([-2.5, -1.0, 0.4, 1.7, 2.3, 2.5])
    ends = nw.ensemble(dtc, y=y)
    for i, start in enumerate(y):
        outcome = nw.simulate(dtc, start).outcome
        assert ends["time"][i] == pytest.approx(outcome.time, abs=1e-8)
        assert ends["distance"][i] == pytest.approx(outcome.distance, abs=1e-8)
        assert ends["psi_end"][i] == pytest.approx(outcome.state["psi"], abs=1e-8)
        assert int(ends["side"][i]) == {"starboard": 1, "port": -1}[outcome.side]


def test_contact_is_met_to_a_micrometre(dtc: nw.Model) -> None:
    for y in (0.5, 1.5, 2.5):
        end = nw.simulate(dtc, y).outcome.state
        reach = abs(end["y"]) + 3.984 / 2 * abs(np.sin(end["psi"])) + 0.572 / 2 * np.cos(end["psi"])
        assert reach == pytest.approx(3.5, abs=1e-6)


def test_an_outline_of_the_rectangle_is_the_rectangle(dtc: nw.Model) -> None:
    length, beam = dtc.configuration.ship.length, dtc.configuration.ship.beam
    outline = [(f * length / 2, a * beam / 2) for f in (-1, 1) for a in (-1, 1)]
    one, other = nw.simulate(dtc, 1.0), nw.simulate(dtc, 1.0, contact=outline)
    assert other.outcome.time == pytest.approx(one.outcome.time, abs=1e-9)
    assert other.outcome.side == one.outcome.side


def test_a_pointed_bow_touches_later(dtc: nw.Model) -> None:
    pointed = [(-1.99, -0.286), (-1.99, 0.286), (1.2, 0.286), (1.99, 0.0), (1.2, -0.286)]
    outcomes = [nw.simulate(dtc, 2.45, contact=shape).outcome for shape in ("corners", pointed)]
    assert [o.side for o in outcomes] == ["starboard", "starboard"]
    assert outcomes[1].time >= outcomes[0].time


def test_outcomes_are_values(dtc: nw.Model) -> None:
    assert nw.simulate(dtc, 0.0, duration=5.0).outcome.kind == "afloat"
    across = nw.simulate(dtc, 0.3, contact="midship").outcome
    assert across.kind == "left validity"
    wild = dtc.with_coefficients(b_rr=-1e6, c_rr=-1e6)
    assert nw.simulate(wild, 0.5, r=1.0, dt=0.5).outcome.kind == "diverged"
    assert "outside the data" in nw.simulate(dtc, 0.5).outcome.sentence


def test_the_speed_is_free_only_with_an_inertia(dtc: nw.Model) -> None:
    with pytest.raises(nw.InputError, match="no mass in surge"):
        nw.simulate(dtc, surge="free")
    slowing = nw.simulate(dtc, 0.0, surge="free", surge_inertia=300.0, duration=10.0)
    np.testing.assert_allclose(slowing.u, 1 / (1 + 12.6 / 300 * slowing.t), rtol=1e-8)


def test_scheduled_inputs_hold_from_their_times(dtc: nw.Model) -> None:
    pushed = nw.simulate(dtc, 0.0, N=[(0.0, 0.0), (1.0, 5.0)], duration=2.0)
    assert not pushed.r[pushed.t <= 1.0].any()
    assert pushed.r[-1] > 0
    fine = integrated(dtc, 2.0, forces=lambda t: (0.0, 0.0, 5.0 * (t > 1.0)), jumps=[1.0])
    assert pushed.r[-1] == pytest.approx(fine.r[-1], rel=1e-7)


def test_a_users_own_term_sails(dtc: nw.Model) -> None:
    def drag(u, v):
        return -abs(u) * v

    table = nw.PAPER.with_terms("own", sway=[nw.Term("b_uv", "b_{uv}", drag, nw.Dimension(1, -1))])
    model = nw.Model(dtc.configuration, table, {**dtc.coefficients, "b_uv": 50.0})
    same = nw.Model(dtc.configuration, nw.PAPER, {**dtc.coefficients, "b_v": 150.0})
    assert nw.simulate(model, 1.0).outcome.time == pytest.approx(nw.simulate(same, 1.0).outcome.time, abs=1e-9)


def test_the_answer_does_not_depend_on_cores(dtc: nw.Model) -> None:
    y = np.linspace(-2.5, 2.5, 3000)
    one, two = (nw.ensemble(dtc, y=y, workers=workers, duration=20.0) for workers in (1, 2))
    assert one.identical(two)


def test_labels_go_in_and_come_out(dtc: nw.Model) -> None:
    import xarray as xr

    sample = xr.DataArray([0.9, 1.0, 1.1], dims=["ship"])
    ends = nw.ensemble(dtc, y=[0.5, 1.0], u=sample, c_bank=xr.DataArray([0.1, 0.13, 0.2], dims=["ship"]), duration=20.0)
    assert dict(ends.sizes) == {"y": 2, "ship": 3}
    alone = nw.simulate(dtc.with_coefficients(c_bank=0.2), 1.0, 1.1, duration=20.0).outcome
    assert float(ends["time"].sel(y=1.0)[2]) == pytest.approx(alone.time, abs=1e-8)
    assert ends["time"].attrs["units"] == "s"


def test_coefficients_are_drawn_from_the_fit(twin_fit: nw.Fit) -> None:
    one = nw.ensemble(twin_fit.model, y=1.0, samples=64, seed=3, duration=20.0)
    two = nw.ensemble(twin_fit.model, y=1.0, samples=64, seed=3, duration=20.0)
    assert one.identical(two)
    assert 0 < float(one["time"].std()) < 1.0
    chance = nw.grounding_probability(one, 1e3)
    assert float(chance) == 1.0
    assert float(nw.grounding_probability(one, 0.1)) == 0.0


def test_starts_on_the_bank_end_there_and_others_go_on(dtc: nw.Model) -> None:
    ends = nw.ensemble(dtc, y=[1.0, 3.4])
    assert ends["time"].to_numpy()[1] == 0.0
    assert ends["side"].to_numpy().tolist() == [-1, 1]


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ({"y": [0.1, np.nan]}, "y"),
        ({"y": []}, "y is empty"),
        ({"yy": 1.0}, "cannot vary 'yy'"),
        ({"samples": 5}, "no covariance"),
        ({"contact": "bow"}, "contact = 'bow'"),
    ],
)
def test_bad_ensembles_are_refused_before_anything_runs(dtc: nw.Model, vary: dict, words: str) -> None:
    with pytest.raises(nw.InputError, match=words):
        nw.ensemble(dtc, **vary)


def test_an_interrupt_keeps_what_is_done(dtc: nw.Model, monkeypatch: pytest.MonkeyPatch) -> None:
    done = []
    real = KernelRun.run

    def run(self, values, vessels, workers=None):
        done.append(vessels)
        if len(done) == 2:
            raise KeyboardInterrupt
        return real(self, values, vessels, workers)

    monkeypatch.setattr(settings, "BLOCK_VESSELS", 10)
    monkeypatch.setattr(KernelRun, "run", run)
    ends = nw.ensemble(dtc, y=np.linspace(0.1, 2.5, 40))
    assert ends.attrs["complete"] == 0
    assert (ends["outcome"].to_numpy()[:10] >= 0).all()
    assert (ends["outcome"].to_numpy()[10:] == -1).all()
    assert len(done) == 2  # No sample is sailed again for the notes.


def test_files_hold_units(dtc: nw.Model, tmp_path) -> None:
    import xarray as xr

    nw.simulate(dtc, 0.5).save(tmp_path / "v.nc")
    with xr.open_dataset(tmp_path / "v.nc", engine="scipy") as voyage:
        assert voyage["y"].attrs["units"] == "m"
        assert voyage.attrs["outcome"] == "grounded"
    save_dataset(nw.ensemble(dtc, y=[0.5, 1.0]), tmp_path / "e.nc")
    with xr.open_dataset(tmp_path / "e.nc", engine="scipy") as ends:
        assert ends["distance"].attrs["units"] == "m"


def test_eigenvalues_are_those_of_differences(dtc: nw.Model) -> None:
    def rates(z: np.ndarray) -> np.ndarray:
        y, psi, v, r = z
        motion = nw.Motion.at(psi=psi, y=y, u=1.0, v=v, r=r)
        _, vdot, rdot = accelerations(dtc, motion)
        return np.array([np.sin(psi) + v * np.cos(psi), r, vdot, rdot])

    at = np.array([0.7, 0.1, 0.05, -0.03])
    jacobian = np.array([(rates(at + d) - rates(at - d)) / 2e-6 for d in 1e-6 * np.eye(4)]).T
    expected = np.linalg.eigvals(jacobian)
    found = nw.stability(dtc, y=0.7, psi=0.1, v=0.05, r=-0.03).eigenvalue.values.ravel()
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(expected), atol=1e-6)
    fleet = nw.stability(dtc, y=[0.0, 1.0], u=[0.5, 1.0, 1.5])
    assert fleet["growth"].shape == (2, 3)


@pytest.mark.parametrize("dt", [1.5, 2.0, 3.0])
def test_a_step_too_long_is_told_by_about_how_much(dtc: nw.Model, dt: float) -> None:
    """Against the same voyage in fine steps."""
    fine = nw.simulate(dtc, y=0.2, duration=12.0, dt=0.01)
    coarse = nw.simulate(dtc, y=0.2, duration=12.0, dt=dt)
    true = np.hypot(coarse.x[-1] - fine.x[-1], coarse.y[-1] - fine.y[-1])
    found = [re.search(r"off by some ([\d.e+-]+) m", note) for note in coarse.outcome.notes]
    told = [float(one[1]) for one in found if one]
    assert len(told) == (true > 0.02 * dtc.configuration.ship.beam)
    for error in told:
        assert true / 5 < error < 5 * true


def test_a_step_that_is_short_enough_is_silent(dtc: nw.Model) -> None:
    assert not any("too long" in note for note in nw.simulate(dtc, y=0.5).outcome.notes)
    assert "too long" in nw.simulate(dtc, y=0.2, duration=15.0, dt=5.0).outcome.sentence


def test_a_speed_that_no_displacement_ship_reaches_has_a_note(dtc: nw.Model) -> None:
    doubt = "8 m/s is a Froude number of 1.3, and displacement ships do not reach 0.6"
    assert any(note.startswith(doubt) for note in nw.simulate(dtc, y=0.5, u=8.0).notes)
    assert not any("Froude" in note for note in nw.simulate(dtc, y=0.5, u=1.0).notes)


def test_every_door_takes_the_same_defaults_for_a_full_size_ship(tmp_path: Path, cli) -> None:
    """350 m beside a bank: command line, one voyage and a fleet sail at one speed, for one time, to one end."""
    full = nw.scale_model(nw.published("mikkelsen2025_dtc"), 350.0, 1025.0).model
    nw.save_model(full, tmp_path / "full.toml")
    code, out, _ = cli("simulate", str(tmp_path / "full.toml"), "--y", "40", "--json")
    told, voyage = json.loads(out), nw.simulate(full, 40.0)
    fleet = nw.ensemble(full, y=[40.0]).isel(y=0)
    assert code == 0
    assert told["outcome"] == voyage.outcome.kind
    assert told["time"] == pytest.approx(voyage.duration, rel=1e-12)
    assert float(fleet["time"]) == pytest.approx(voyage.duration, rel=1e-9)
    assert float(fleet["u_end"]) == voyage.u[0]
    straight = nw.simulate(full)
    assert straight.outcome.lengths == pytest.approx(15.0, rel=0.05)
    assert f"{straight.outcome.lengths:.1f} ship lengths" in straight.summary()
