"""The command line: exit codes, one line on stderr, JSON in the documented shape, files whole or not at all."""

import json
import math
import subprocess
import sys
from pathlib import Path

import click
import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.cli.app import GROUPS, app
from narrows.cli.options import speed
from tables import frame_of, many_runs, short_twin, written

SCRIPT = Path(sys.executable).parent / "narrows"


@pytest.fixture
def good(table: pd.DataFrame, tmp_path: Path) -> Path:
    return written(table, tmp_path / "good.csv")


def test_tables_of_verbs_are_printed(cli, good: Path, ship_file: Path) -> None:
    """What is in JSON stands in the terminal too."""
    model = nw.published("estimated_kcs")
    verbs = "ships", "squat estimated_kcs --speed 3:5:2", "linearize estimated_kcs --speed 4"
    printed = {verb: cli(*verb.split()) for verb in verbs}
    assert {code for code, _, _ in printed.values()} == {0}
    ships, squat, linear = (" ".join(out.split()) for _, out, _ in printed.values())
    assert all(name in ships for name in ("estimated_kcs", "yasukawa2015_kvlcc2"))
    for u, sinkage in zip((3.0, 5.0), nw.squat(model, [3.0, 5.0]).to_dataframe()["sinkage"], strict=True):
        assert f"{u:.2f} {u * 3600 / 1852:.1f} {sinkage:.2f}" in squat
    assert f"{nw.control.linearize(model, u=4.0).modes()['growth'].iloc[0]:.4g}" in linear
    code, out, _ = cli("--verbose", "identify", good, "--ship", ship_file)
    assert code == 0
    words = " ".join(out.split())
    assert "Not determined by these tests" in words
    shares = nw.identify(nw.read_captive(good, ship_file)).shapley()
    assert all(f"{name} {share:+.3f}" in words for part in shares.values() for name, share in part.items())


def assert_is_model_of(fit: nw.Fit, file: Path) -> None:
    model = nw.load_model(file)
    assert dict(model.coefficients) == dict(fit.coefficients)
    np.testing.assert_array_equal(model.covariance, fit.covariance)
    assert model.source == fit.tests.source
    assert model.source.table == "good.csv"


def test_json_is_the_documented_shape_and_the_model_file_is_the_fit(
    good: Path, ship_file: Path, tmp_path: Path, cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    reported = list[tuple]()
    monkeypatch.setattr(nw.report, "write_report", lambda *told: reported.append(told))
    page = tmp_path / "m.html"
    code, out, err = cli("identify", good, "--ship", ship_file, "-o", tmp_path / "m.toml", "--json", "--report", page)
    assert code == 0, err
    shown = json.loads(out)
    fit = nw.identify(nw.read_captive(good, ship_file))
    ((of_page, path, title, answers),) = reported
    assert [own.coefficients for own in of_page.values()] == [fit.coefficients]
    assert (Path(path), title) == (page, "good")
    assert [own.to_dict() for own in answers.values()] == [shown["answer"]]
    assert_is_model_of(fit, tmp_path / "m.toml")
    assert list(shown["coefficients"]) == list(nw.PAPER.names)
    for name, own in shown["coefficients"].items():
        assert {"value", "std", "ci95", "unit", "determined"} <= own.keys()
        assert own["value"] == fit.coefficients[name]
        assert own["unit"] == nw.PAPER[name].dimension.unit
        assert own["determined"] is fit.verdicts[name].determined
        assert (own["std"] is None) == (not own["determined"])
        expected = [end if math.isfinite(end) else None for end in fit.intervals[name]]
        assert own["ci95"] == expected
    assert shown["coefficients"]["a_udot"]["determined"] is False
    for force in "XYN":
        assert {"r2", "rmse", "r2_left_out"} <= shown["fit"][force].keys()
        assert shown["fit"][force]["r2"] == fit.scores[force].r2
        assert shown["fit"][force]["r2_left_out"] == fit.left_out[force].r2
        found = shown["diagnostics"][force]
        assert {"rank", "columns", "condition", "vif"} <= found.keys()
        assert found["columns"] == len(nw.PAPER.forces[force])
        assert list(found["vif"]) == [term.name for term in nw.PAPER.forces[force]]
        assert shown["shapley"][force] == fit.shapley()[force]


def test_several_conditions_give_several_models(short: nw.CaptiveTests, ship_file: Path, tmp_path: Path, cli) -> None:
    frame = frame_of(short)
    frame["condition"] = np.where(frame.test.isin(short.names[:2]), "deep", "shallow")
    path = written(frame, tmp_path / "two.csv")
    code, out, _ = cli("identify", path, "--ship", ship_file, "-o", tmp_path / "m.toml", "--json")
    assert code == 0
    shown = json.loads(out)
    assert list(shown) == ["conditions"]
    assert list(shown["conditions"]) == ["deep", "shallow"]
    assert sorted(own.name for own in tmp_path.glob("m*")) == ["m-deep.toml", "m-shallow.toml"]
    alone = json.loads(cli("identify", path, "--ship", ship_file, "--condition", "deep", "--json")[1])
    assert alone["coefficients"] == shown["conditions"]["deep"]["coefficients"]


def test_options_reach_the_fit(ship_file: Path, tmp_path: Path, cli) -> None:
    path = written(frame_of(short_twin(4, many_runs(6))), tmp_path / "t.parquet")
    tests = nw.read_captive(path, ship_file)
    words = ("--balance", "rows", "--terms", "tapered")
    shown = json.loads(cli("identify", path, "--ship", ship_file, "--json", *words)[1])
    found = {
        (balance, terms): nw.identify(tests, balance=balance, terms=terms)
        for balance in ("tests", "rows") for terms in ("paper", "tapered")
    }  # fmt: skip
    assert shown["coefficients"]["b_bank"]["value"] == found["rows", "tapered"].coefficients["b_bank"]
    assert len({fit.least_squares["b_bank"] for fit in found.values()}) == 4
    fast = json.loads(cli("identify", path, "--ship", ship_file, "--where", "u > 0.9", "--json")[1])
    assert {own["most_informing"] for own in fast["influence"].values()} <= {
        name for name in tests.names if tests.test(name)["u"][0] > 0.9
    }
    streamed = json.loads(cli("identify", path, "--ship", ship_file, "--stream", "--json")[1])
    assert streamed["coefficients"]["b_bank"]["value"] == pytest.approx(
        found["tests", "paper"].coefficients["b_bank"], rel=1e-9
    )


def test_unsolved_problem_leaves_with_one(good: Path, ship_file: Path, cli, monkeypatch) -> None:
    """The command ran, and says that its answer is not the optimum."""
    monkeypatch.setattr("narrows.identification.least_squares.KKT_TOLERANCE", -1.0)
    code, out, _ = cli("identify", good, "--ship", ship_file, "--json")
    assert code == 1
    assert json.loads(out)["kkt"]["satisfied"] is False


def test_bad_input_leaves_an_older_model_as_it_was(table: pd.DataFrame, ship_file: Path, tmp_path: Path, cli) -> None:
    model = tmp_path / "m.toml"
    model.write_text("an older model")
    bad = written(table.drop(columns="v"), tmp_path / "bad.csv")
    code, out, err = cli("identify", bad, "--ship", ship_file, "-o", model, "--json")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("narrows: ")
    assert model.read_text() == "an older model"
    assert sorted(own.name for own in tmp_path.iterdir()) == ["bad.csv", "m.toml", "ship.toml"]


def test_debug_shows_the_traceback(ship_file: Path, tmp_path: Path, monkeypatch) -> None:
    from narrows.cli import main

    monkeypatch.setattr(
        "sys.argv", ["narrows", "identify", str(tmp_path / "no.csv"), "--ship", str(ship_file), "--debug"]
    )
    with pytest.raises(nw.InputError, match="there is no such file"):
        main()


HELP = [[], ["--help"], ["-h"], ["help"], ["identify", "--help"], ["demo", "-h"], ["help", "map"]]


@pytest.mark.parametrize("words", HELP)
def test_help(words: list[str], cli) -> None:
    code, out, err = cli(*words)
    assert (code, err) == (0, "")
    assert out.startswith("Usage: ")
    if len(words) > 1:
        assert "Example: narrows" in out


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["identify"], "see narrows identify --help. Example: narrows identify"),
        (["identify", "t.csv", "--ship", "s.toml", "--bogus"], "No such option '--bogus'"),
        (["identify", "t.xlsx", "--ship", "s.toml", "--sheet", "A"], "first with many numbers is read: put it first"),
        (["simulate", "mikkelsen2025_dtc", "--knots"], "write the unit behind the number, as --speed 8kn"),
        (["identfy"], "did you mean 'identify'"),
        (["fit"], "Missing argument"),
        (["plot"], "write narrows simulate --plot"),
        (["xyzzy"], "verbs: "),
        (["identify", "t.csv", "--ship", "s.toml", "--seed", "x"], "--seed"),
        (
            ["identify", "t.csv", "--ship", "s.toml", "--stream", "--report", "r.html"],
            "at most one of --stream, --report",
        ),
    ],
)
def test_usage_errors_are_one_line(words: list[str], sentence: str, cli) -> None:
    code, out, err = cli(*words)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert sentence in err


def test_every_verb_stands_in_one_group() -> None:
    listed = [verb for verbs in GROUPS.values() for verb in verbs]
    assert set(app.commands) <= set(listed)
    assert len(listed) == len(set(listed))


@pytest.mark.parametrize("text", ["8kn", "8 kn", "8kt", "8 kts", "8knots", "8 Knots", "14.816 km/h", "14.816kmh"])
def test_speeds_in_the_units_that_people_write(text: str) -> None:
    assert speed("--speed", text) == pytest.approx(8 * 1852 / 3600)


@pytest.mark.parametrize(
    ("words", "size"),
    [
        ("--duration 90s", 90.0), ("--duration 1.5min", 90.0), ("--duration .025h", 90.0), ("--duration 9e1", 90.0),
        ("--y -5m", -5.0), ("--psi-deg 10deg", 10.0), ("--psi-deg 1rad", 180 / math.pi), ("--r-deg 2deg/s", 2.0),
        ("--surge-inertia 1e6kg", 1e6),
    ],
)  # fmt: skip
def test_a_number_may_have_the_unit_of_its_help(words: str, size: float) -> None:
    option, text = words.split()
    parameter = next(own for own in app.commands["simulate"].params if option in own.opts)
    assert parameter.type.convert(text, parameter, None) == pytest.approx(size, rel=1e-15)


@pytest.mark.parametrize(
    "words",
    [
        "simulate --y 5s", "simulate --duration 5m", "simulate --revolutions 2m", "simulate --r-deg 2deg",
        "plan --clearance 10m", "envelope --gusts 2m", "estimate --block 1m", "learn --spread 1s",
    ],
)  # fmt: skip
def test_a_number_with_another_unit_is_refused(words: str) -> None:
    verb, option, text = words.split()
    parameter = next(own for own in app.commands[verb].params if option in own.opts)
    with pytest.raises(click.BadParameter, match=f"'{text}' is not a valid float"):
        parameter.type.convert(text, parameter, None)


def test_the_installed_command(good: Path, ship_file: Path, tmp_path: Path) -> None:
    """As a user runs it: nothing on stderr where all is well, one line where it is not, no traceback."""

    def run(*words: object) -> subprocess.CompletedProcess[str]:
        return subprocess.run([SCRIPT, *map(str, words)], capture_output=True, text=True, timeout=120)

    done = run("identify", good, "--ship", ship_file, "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["kkt"]["satisfied"] is True
    done = run("identify", tmp_path / "no.csv", "--ship", ship_file)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"narrows: {tmp_path / 'no.csv'}: there is no such file; check the path\n"


def test_the_package_is_a_command_too() -> None:
    done = subprocess.run([sys.executable, "-m", "narrows", "ships", "--json"], capture_output=True, check=True)
    assert json.loads(done.stdout)
