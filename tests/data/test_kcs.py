"""The KCS tests: what an independent extraction of the same rows gave."""

import pytest

import narrows as nw
from narrows.identification.normal_equations import score

GUIDE = {
    100: {"b_vdot": 730, "c_rdot": 785, "Y": 0.98, "N": 0.96},
    50: {"b_vdot": 888, "c_rdot": 884, "Y": 0.97, "N": 0.95},
    20: {"b_vdot": 1123, "c_rdot": 1202, "Y": 0.94, "N": 0.95},
}


@pytest.mark.parametrize("clearance", GUIDE)
def test_masses_and_fit(kcs_fits: dict[int, nw.Fit], clearance: int) -> None:
    """The extraction is by least squares; the mixed model's intervals hold its masses."""
    fit, guide = kcs_fits[clearance], GUIDE[clearance]
    values = fit.least_squares
    fitted = score(fit.normal_equations, fit.normal_equations.total, fit.terms, values)
    for name in ("b_vdot", "c_rdot"):
        assert values[name] == pytest.approx(guide[name], rel=0.01)
        low, high = fit.intervals[name]
        assert low < guide[name] < high
    for force in ("Y", "N"):
        assert fitted[force].r2 == pytest.approx(guide[force], abs=0.01)
        assert fit.left_out[force].r2 < fitted[force].r2


@pytest.mark.parametrize("clearance", GUIDE)
def test_the_bank_is_not_identified(kcs_fits: dict[int, nw.Fit], clearance: int) -> None:
    fit = kcs_fits[clearance]
    assert 0.12 < fit.least_squares["b_bank"] < 0.24
    assert -0.06 < fit.least_squares["c_bank"] < 0
    for name in ("b_bank", "c_bank"):
        assert fit.verdicts[name].status != "identified"
        low, high = fit.intervals[name]
        assert low < 0 < high


@pytest.mark.parametrize(("clearance", "vif"), [(100, 329), (50, 220), (20, 220)])
def test_at_top_speed_the_banks_column_is_the_yaw_rates(kcs_fits: dict[int, nw.Fit], clearance: int, vif: int) -> None:
    top = max(kcs_fits[clearance].diagnostics.by_speed)
    assert kcs_fits[clearance].diagnostics.by_speed[top]["Y"].vif["b_bank"] == pytest.approx(vif, rel=0.01)


def test_depths_and_rows(kcs_tests: dict[int, nw.CaptiveTests]) -> None:
    assert {c: (t.rows, len(t.names), t.configuration.canal.depth) for c, t in kcs_tests.items()} == {
        100: (600, 25, 0.41),
        50: (480, 20, 0.3075),
        20: (480, 20, 0.246),
    }


@pytest.mark.parametrize("record", ["C1", "C2", "C3"])
def test_surge_inertia_of_the_dtc_from_raw_records(shared_data, dtc: nw.Model, record: str) -> None:
    """300 to 309 kg by an independent reckoning, from ramps whose accelerations are not in the file."""
    tests = nw.read_captive(shared_data / "dtc_mashcon2019" / f"{record}.dat", dtc.configuration)
    fit = nw.identify(tests)
    assert fit.coefficients["a_udot"] == pytest.approx(305, abs=5)
    assert any("low-passed" in note for note in tests.notes)


def test_lataire_table_reads_nine_of_ten() -> None:
    tests = nw.measured_tests("lataire2009")
    assert tests.names == tuple("ABCDFGHIJ")
    assert any("sailed backwards" in note for note in tests.notes)
    h = tests.test("H")
    assert h["draft"][0] == pytest.approx(0.1485, abs=1e-4)
    assert h["heave"][0] == pytest.approx((2.781 + 4.999) / 2e3, abs=1e-6)
    assert h["N"][0] == pytest.approx(-6.959)
