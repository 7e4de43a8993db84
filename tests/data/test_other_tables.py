"""Tables of other ships, by the documented columns and by known layouts, and raw records of the paper's hull."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.captive.measured import measured_files
from tables import frame_of, many_runs, written

TANKER = """
[ship]
name = "a tanker"
length = 6.4
beam = 1.16
draft = 0.416
block_coefficient = 0.81

[canal]
width = 10.0
depth = 0.6

[water]
density = 1025.0
"""
TRUTH = {
    "a_udot": 0.0, "a_u": 0.0, "a_uu": 40.0,
    "b_vdot": 4000.0, "b_rdot": 150.0, "b_v": 900.0, "b_r": 400.0, "b_vv": 9000.0, "b_rr": 500.0, "b_bank": 0.6,
    "c_vdot": 150.0, "c_rdot": 9000.0, "c_v": 2500.0, "c_r": 1500.0, "c_vv": 800.0, "c_rr": 9000.0, "c_bank": 0.09,
}  # fmt: skip


@pytest.fixture(scope="module")
def tanker(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, nw.CaptiveTests]:
    ship = tmp_path_factory.mktemp("tanker") / "tanker.toml"
    ship.write_text(TANKER)
    truth = nw.Model(nw.read_ship(ship), nw.PAPER, TRUTH)
    return ship, nw.twin(truth, many_runs(), noise={"X": 0.5, "Y": 2.0, "N": 3.0}, rate=10.0)


def assert_truth(shown: dict) -> None:
    for name, value in TRUTH.items():
        own = shown["coefficients"][name]
        if own["determined"] and own["verdict"] != "at its bound":
            assert own["value"] == pytest.approx(value, abs=5 * own["std"])
            assert own["std"] > 0
    assert shown["coefficients"]["b_bank"]["value"] == pytest.approx(0.6, rel=0.02)
    assert shown["coefficients"]["c_bank"]["value"] == pytest.approx(0.09, rel=0.02)
    assert shown["coefficients"]["a_udot"]["determined"] is False
    assert min(shown["fit"][force]["r2"] for force in "YN") > 0.95


def test_documented_columns(tanker: tuple[Path, nw.CaptiveTests], tmp_path: Path, cli) -> None:
    ship, tests = tanker
    for suffix in (".csv", ".parquet"):
        path = written(frame_of(tests), tmp_path / f"tanker{suffix}")
        code, out, err = cli("identify", path, "--ship", ship, "-o", tmp_path / "tanker.model.toml", "--json")
        assert (code, err) == (0, "")
        assert_truth(json.loads(out))
    model = nw.load_model(tmp_path / "tanker.model.toml")
    assert model.configuration == tests.configuration
    assert model.data_range.depth_to_draft == pytest.approx((0.6 / 0.416,) * 2)


def test_headers_with_units_and_columns_nobody_asked_for(
    tanker: tuple[Path, nw.CaptiveTests], tmp_path: Path, cli
) -> None:
    ship, tests = tanker
    frame = frame_of(tests)
    frame = frame.assign(psi=np.degrees(frame.psi), r=np.degrees(frame.r), u=frame.u / 0.514444444444, N=frame.N / 1e3)
    frame = frame.rename(columns={"psi": "psi [deg]", "r": "r_degps", "u": "u [kn]", "N": "N [kNm]"})
    frame = frame.assign(operator="J. Doe", torque=np.nan).drop(columns=["heave", "x"])
    code, out, _ = cli("identify", written(frame, tmp_path / "t.csv"), "--ship", ship, "--json")
    assert code == 0
    assert_truth(json.loads(out))
    assert "column 'heave' is absent: taken as 0" in json.loads(out)["notes"]


def test_fhr_layout(tanker: tuple[Path, nw.CaptiveTests], tmp_path: Path, cli) -> None:
    ship, tests = tanker
    frame = frame_of(tests)
    kind = ["PMMY2" if run.kind == "sway" else "PMMPSI2" for run in many_runs()]
    spelled = pd.DataFrame(
        {
            "ship": "tanker", "env": "T01", "test": frame.test, "rud_given_deg": 0.0,
            "type": frame.test.map(dict(zip(tests.names, kind, strict=True))),
            "x_m": frame.x, "y_m": frame.y, "psi_deg": np.degrees(frame.psi), "u_mps": frame.u, "v_mps": frame.v,
            "r_degps": np.degrees(frame.r), "udot_mps2": frame.udot, "vdot_mps2": frame.vdot,
            "rdot_degps2": np.degrees(frame.rdot), "X_N": frame.X, "Y_N": frame.Y, "N_Nm": frame.N,
            "sinkage_mm": frame.heave * 1e3,
        }
    )  # fmt: skip
    drifting = spelled.iloc[:9].assign(type="STATX0", psi_deg=95.0, Y_N=1e6)
    steered = spelled.iloc[:9].assign(type="MULTI0", rud_given_deg=20.0, Y_N=1e6)
    path = written(pd.concat([spelled, drifting, steered]), tmp_path / "t.csv")
    code, out, _ = cli("identify", path, "--ship", ship, "--json")
    assert code == 0
    shown = json.loads(out)
    assert_truth(shown)
    assert f"{len(spelled)} of {len(spelled) + 18} rows read" in shown["notes"][0]


def test_kcs_through_the_command_line(kcs_fits: dict[int, nw.Fit], cli) -> None:
    table, ship = measured_files("kcs")
    code, out, err = cli("identify", table, "--ship", ship, "--json")
    assert (code, err) == (0, "")
    conditions = json.loads(out)["conditions"]
    for clearance, label in ((100, "C0101A01"), (50, "C0101A02"), (20, "C0101A03")):
        fit, shown = kcs_fits[clearance], conditions[label]
        assert {name: own["value"] for name, own in shown["coefficients"].items()} == dict(fit.coefficients)
        assert shown["coefficients"]["a_udot"]["verdict"] == "not excited"
        assert shown["coefficients"]["a_udot"]["determined"] is False
        assert shown["coefficients"]["b_bank"]["verdict"] != "identified"
        assert set(shown["coefficients"]["b_bank"]) >= {"value", "std", "ci95", "unit", "determined"}
        assert set(shown["fit"]["Y"]) >= {"r2", "rmse", "r2_left_out"}
        assert set(shown["diagnostics"]["Y"]) >= {"rank", "columns", "condition", "vif"}
        assert set(shown["shapley"]) == {"X", "Y", "N"}
        top = max(shown["by_speed"], key=lambda own: own["speed"])
        assert 219 <= top["diagnostics"]["Y"]["vif"]["b_bank"] <= 329
        assert top["diagnostics"]["Y"]["rank"] == 7


@pytest.mark.parametrize("clearance", [100, 50, 20])
def test_kcs_surge_inertia_is_not_excited(kcs_fits: dict[int, nw.Fit], clearance: int) -> None:
    fit = kcs_fits[clearance]
    assert fit.verdicts["a_udot"].sentence("a_udot") == "a_udot is not identifiable: udot is 0 in every test."
    assert np.isnan(fit.std["a_udot"])
    assert fit.diagnostics.overall["X"].empty == ("a_udot",)


@pytest.mark.parametrize("clearance", [100, 50, 20])
def test_kcs_left_out_tests_are_still_explained(kcs_fits: dict[int, nw.Fit], clearance: int) -> None:
    fit = kcs_fits[clearance]
    assert len(fit.motions) == 12
    for force in "YN":
        # The estimate is a posterior mean: by rows alone it may fit a little worse than the refits without a motion.
        assert 0.8 < fit.left_out[force].r2 < fit.scores[force].r2 + 0.01


def test_kcs_bank_goes_to_a_term_in_u_r(kcs_tests: dict[int, nw.CaptiveTests], kcs_fits: dict[int, nw.Fit]) -> None:
    """A u r regressor takes most of b_bank away: what the tests hold of the bank is little."""

    def turning_ahead(u: float, r: float) -> float:
        return -u * r

    term = nw.Term("b_ur", "b_{ur}", turning_ahead, nw.Dimension(mass=1))
    fit = nw.identify(kcs_tests[100], nw.PAPER.with_terms("with u r", sway=[term]))
    assert abs(fit.coefficients["b_bank"]) < 0.5 * kcs_fits[100].coefficients["b_bank"]


def test_kcs_yaw_runs_hold_y_and_r_on_one_line(kcs_tests: dict[int, nw.CaptiveTests]) -> None:
    """corr(y, r) = -1.000 in runs without drift, which is why bank and yaw rate are one column."""
    tests = kcs_tests[100]
    found = [
        np.corrcoef(own["y"], own["r"])[0, 1]
        for own in map(tests.test, tests.names)
        if np.ptp(own["r"]) > 0.01 and np.abs(own["v"]).max() < 1e-3
    ]
    assert len(found) >= 10
    assert max(found) < -0.999


@pytest.mark.parametrize("record", ["C1", "C2", "C3"])
def test_dtc_records_hold_surge_and_nothing_else(shared_data: Path, dtc: nw.Model, record: str) -> None:
    """Mass with added mass of the paper's hull from the ramps: 300 to 310 kg, on the one test that each record is."""
    tests = nw.read_captive(shared_data / "dtc_mashcon2019" / f"{record}.dat", dtc.configuration)
    fit = nw.identify(tests)
    assert 300 < fit.coefficients["a_udot"] < 310
    assert fit.verdicts["a_udot"].determined
    (low, high), (within_low, within_high) = (
        each.intervals["a_udot"] for each in (fit, nw.identify(tests, errors=nw.RunErrors(0, 0, 0)))
    )
    assert 270 < within_low < within_high < 330
    assert low < within_low < within_high < high


def test_tidy_copies_are_the_bundled_tables(shared_data: Path) -> None:
    for folder, tidy, name in (
        ("kcs_pmm_shallow", "kcs_pmm_tidy.csv", "kcs"), ("bank_lataire2009", "subset2_tidy.csv", "lataire2009"),
    ):  # fmt: skip
        ours, theirs = (pd.read_csv(p) for p in (measured_files(name)[0], shared_data / folder / tidy))
        pd.testing.assert_frame_equal(ours, theirs)
