"""Models on other tests, and tables of terms side by side: every number against its definition."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import narrows as nw
from narrows.captive.measured import measured_files
from tables import frame_of, many_runs, short_twin, written


@pytest.fixture(scope="module")
def found() -> nw.Explanation:
    return nw.explain(nw.published("mikkelsen2025_dtc"), short_twin(3, many_runs(12)), ("speed", "paper+distance"))


def test_the_models_errors_are_its_own(found: nw.Explanation) -> None:
    tests = found.fit.tests
    motion = nw.Motion(**{name: tests.columns[name] for name in nw.Motion().values()})
    for force, told in found.model.forces(motion).items():
        error = tests.columns[force] - told
        by_test = [np.mean(part**2) for part in np.split(error, tests.starts[1:-1])]
        assert found.scores[force].rmse == pytest.approx(np.sqrt(np.mean(by_test)), rel=1e-6)
        first = slice(int(tests.starts[0]), int(tests.starts[1]))
        assert found.by_test["T00"][force].rmse == pytest.approx(np.sqrt(np.mean(error[first] ** 2)), rel=1e-5)


def test_a_true_model_agrees_with_its_tests(found: nw.Explanation) -> None:
    far = [abs(own) for own in found.z_scores.values() if np.isfinite(own)]
    assert max(far) < 4.5
    assert np.sqrt(np.mean(np.square(far))) < 2
    assert not found.fitted_on_these


def test_the_summary_names_a_model_of_another_ship(found: nw.Explanation) -> None:
    large = nw.scale_model(found.model, 355.0).model
    said = replace(found, model=large).summary()
    assert f"The model is of {large.ship.in_words}, these tests are of {found.model.ship.in_words}" in said
    assert "The model is of" not in found.summary()


def test_a_wrong_model_does_not(found: nw.Explanation) -> None:
    wrong = nw.explain(found.model.with_coefficients(b_bank=1.5), found.fit.tests, ("speed",))
    assert wrong.z_scores["b_bank"] > 5
    assert any("More than 3 standard errors" in said and "b_bank" in said for said in wrong.summary().splitlines())


def test_tables_are_compared_by_what_was_left_out(found: nw.Explanation) -> None:
    assert list(found.comparison.fits) == ["paper", "speed", "paper+distance"]
    rows = {(row["table"], row["force"]): row for row in found.comparison.rows()}
    for (name, force), row in rows.items():
        fit = nw.identify(found.fit.tests, found.comparison.fits[name].terms)
        assert row["rmse_left_out"] == fit.left_out[force].rmse
    assert found.comparison.best("Y") == "paper"  # the truth's own terms


def test_a_speed_left_out_is_that_of_a_refit(found: nw.Explanation) -> None:
    fit, error = found.fit, []
    groups = {round(float(fit.tests.test(name)["u"].mean()), 1) for name in fit.tests.names}
    speed_of = {name: round(float(fit.tests.test(name)["u"].mean()), 1) for name in fit.tests.names}
    for group in groups:
        inside = [speed_of[name] == group for name in fit.tests.names]
        refit = nw.identify(fit.tests.where([not own for own in inside]))
        out = fit.tests.where(inside)
        motion = nw.Motion(**{name: out.columns[name] for name in nw.Motion().values()})
        left = out.columns["N"] - refit.model.with_coefficients(**refit.least_squares).forces(motion)["N"]
        error += [np.mean(part**2) for part in np.split(left, out.starts[1:-1])]
    assert fit.left_out_speeds["N"].rmse == pytest.approx(np.sqrt(np.mean(error)), rel=1e-5)


def test_tables_that_cannot_be_fitted_say_why() -> None:
    found = nw.compare(short_twin(), ["paper", "paper+tuck"])
    assert list(found.fits) == ["paper"]
    assert "depth" in found.left_out["paper+tuck"]
    with pytest.raises(nw.InputError, match="none of the tables"):
        nw.compare(short_twin(), ["paper+tuck"])


def two_depths(tests: nw.CaptiveTests) -> list[nw.CaptiveTests]:
    parts = tests.by_condition()
    return [parts["C0101A02"], parts["C0101A03"]]


def saved_without_intervals(fit: nw.Fit, path: Path) -> None:
    """Intervals take a second."""
    known = fit.least_squares, None, fit.data_range, fit.tests.source
    nw.Model(fit.tests.configuration, fit.terms, *known).save(path)


def test_depths_together_need_terms_that_know_them() -> None:
    tests = nw.measured_tests("kcs")
    names = [name for parts in two_depths(tests) for name in parts.names[::2]]
    tests = tests.where([name in names for name in tests.names])  # Every other test of two conditions
    with pytest.raises(nw.InputError, match="need the depth"):
        nw.identify(tests)
    assert nw.identify(tests, nw.with_bank(nw.CROSSFLOW, "delta_depth")).scores["Y"].r2 > 0.5


@pytest.mark.slow
def test_explain_on_the_command_line(cli, ship_file, tmp_path) -> None:
    table = written(frame_of(short_twin()), tmp_path / "t.csv")
    model = tmp_path / "m.toml"
    saved_without_intervals(nw.identify(table, ship=ship_file), model)
    code, out, err = cli("explain", model, table, "--compare", "speed", "--report", tmp_path / "e.html")
    assert (code, err) == (0, "")
    assert "The model was fitted on this table." in out
    page = (tmp_path / "e.html").read_text()
    assert "<script" not in page
    assert page.count("<figure") == 6


def test_explain_tells_the_bank_in_json(cli, tmp_path) -> None:
    table = written(frame_of(short_twin(3, many_runs(12))), tmp_path / "t.csv")
    code, out, _ = cli("explain", "mikkelsen2025_dtc", table, "--compare", "speed", "--json")
    told = json.loads(out)
    assert code == 0
    assert not told["fitted_on_this_table"]
    assert set(told["tables"][0]) >= {"table", "force", "rmse_left_out", "rmse_other_speeds", "bank"}
    # Harmonic runs of a hull that does not change with speed or period tell the bank.
    assert told["these_tests"]["coefficients"]["b_bank"]["verdict"] == "identified"
    assert {"kkt", "influence"} <= set(told["these_tests"])


def test_explain_asks_for_a_condition_and_tells_the_depth(cli, tmp_path, kcs_fits: dict[int, nw.Fit]) -> None:
    table, ship = measured_files("kcs")
    model = tmp_path / "m.toml"
    saved_without_intervals(kcs_fits[50], model)
    code, _, err = cli("explain", model, table, "--ship", ship)
    assert code == 2
    assert "choose one with --condition C0101A01" in err
    code, out, _ = cli(
        "explain", model, table, "--ship", ship, "--condition", "C0101A03", "--compare", "paper", "--json"
    )
    assert code == 0
    told = json.loads(out)
    assert not told["fitted_on_this_table"]
    assert any("h/T" in said for said in told["notes"])
    assert not any("yaw rate" in said for said in told["notes"])
