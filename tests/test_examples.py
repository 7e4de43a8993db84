"""Every example runs, and every benchmark in small; the files that explain themselves leave no key out."""

import dataclasses
import inspect
import json
import os
import re
import runpy
import subprocess
import sys
import tomllib
from dataclasses import fields
from pathlib import Path

import pytest
from matplotlib.figure import Figure

import narrows as nw
import narrows.captive.check
import narrows.waterway.geojson
from narrows.ship.ship_file import NEEDED, actuator_sections

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
BENCHMARKS = sorted(path for path in (ROOT / "benchmarks").glob("*.py") if path.stem != "common")


@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    kept = runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out.strip()
    assert isinstance(kept["picture"], Figure)  # the thumbnail of the gallery
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 40


@pytest.mark.slow
@pytest.mark.parametrize("path", BENCHMARKS, ids=lambda path: path.stem)
def test_benchmark_runs(path: Path, tmp_path: Path) -> None:
    source = os.pathsep.join(filter(None, [str(ROOT / "src"), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, path, "--small"], cwd=tmp_path, env={**os.environ, "PYTHONPATH": source},
        capture_output=True, text=True, encoding="utf-8",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "ratio" in done.stdout


def test_the_ship_file_has_every_key_with_a_comment() -> None:
    path = ROOT / "examples" / "ship.toml"
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    known = {**NEEDED, **actuator_sections()}
    assert set(tables) == {*known, "depths"}
    for section, part in known.items():
        assert set(tables[section]) == {field.name for field in fields(part)}
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if "=" in line.split("#")[0]]
    assert [line for line in lines if not re.search(r"#\s*\S", line)] == []
    ship = nw.read_ship(path)
    assert ship.values()["rudder_area"] == nw.published("yasukawa2015_kvlcc2").configuration.values()["rudder_area"]
    assert narrows.captive.check.check_mass(ship, str(path)) == ()


def test_the_ship_file_serves(tmp_path: Path) -> None:
    configuration = nw.read_ship(ROOT / "examples" / "ship.toml")
    assert nw.plan_tests(configuration, 2).determined
    turned = nw.sail_trials(
        dataclasses.replace(nw.published("yasukawa2015_kvlcc2"), configuration=configuration), 1.179
    )
    assert turned.summary()


def test_the_waterway_file_has_every_key_with_a_comment() -> None:
    path = ROOT / "examples" / "waterway.geojson"
    features = json.loads(path.read_text(encoding="utf-8"))["features"]
    keys = {key for feature in features for key in feature["properties"]}
    asked = set(re.findall(r'(?:properties|own)\.get\("(\w+)"\)', inspect.getsource(narrows.waterway.geojson)))
    asked |= {"role", *narrows.waterway.geojson.CURRENT}  # "role" is one of several words for it.
    # Of depth and depths a file has one.
    assert asked - {"depth"} == keys - {"about"}
    for feature in features:
        about = feature["properties"]["about"]
        assert set(about) == {*feature["properties"], "coordinates"} - {"about"}
    assert "depth:" in features[0]["properties"]["about"]["depths"]


def test_the_waterway_file_serves() -> None:
    way = nw.read_waterway(ROOT / "examples" / "waterway.geojson")
    assert way.line.length == pytest.approx(300, rel=0.01)
    assert way.starboard.profile
    assert not way.port.profile
    full = nw.scale_model(nw.published("mikkelsen2025_dtc"), 100.0, depth=12.0).model
    voyage = nw.simulate(full, 0.0, 3.0, waterway=way, duration=5.0, dt=0.1)
    assert voyage.dataset()["latitude"][-1] > 54.0
