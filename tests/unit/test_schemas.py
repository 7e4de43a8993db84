"""What every verb prints with ``--json`` is what its schema says, no more and no less."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import narrows as nw
from narrows.base.files import plain, to_json
from narrows.captive.measured import measured_files
from narrows.cli import app
from narrows.identification.fitting import bundled_ship
from narrows.model.tables import table_named
from narrows.warning.monitoring.demonstration import bridge_sentences
from tables import DTC_SHIP, frame_of, short_twin, written

pytest.importorskip("jsonschema", reason="of the group test")
from jsonschema import Draft202012Validator
from referencing import Registry, Resource

FOLDER = Path(nw.__file__).parent / "schemas"
SCHEMAS = {path.stem: json.loads(path.read_text()) for path in FOLDER.glob("*.json")}
KNOWN = Registry().with_resources([(f"{verb}.json", Resource.from_contents(own)) for verb, own in SCHEMAS.items()])


VERBS = {name for name, verb in app.commands.items() if any(one.name == "json" for one in verb.params)}


def errors(verb: str, value: Any) -> list[str]:
    """What a schema has against a value."""
    found = Draft202012Validator(SCHEMAS[verb], registry=KNOWN).iter_errors(value)
    return [f"{error.json_path}: {error.message[:300]}" for error in found]


def test_every_verb_has_a_schema() -> None:
    assert set(SCHEMAS) == VERBS
    for verb, schema in SCHEMAS.items():
        Draft202012Validator.check_schema(schema)
        assert schema["title"] == f"What narrows {verb} --json prints"


@pytest.mark.parametrize("verb", sorted({"identify", "explain", "simulate", "waterway"}))
def test_a_schema_refuses_what_it_does_not_know(verb: str) -> None:
    assert errors(verb, {"surprise": 1})
    assert errors(verb, [])


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A model with a rudder at full size, a table of tests, and a waterway."""
    folder = tmp_path_factory.mktemp("schemas")
    table, ship = measured_files("kcs")
    # This fit is kept for other tests.
    nw.save_model(bundled_ship(230.0, 300.0, 16.2, table_named("speed+helm")), folder / "full.toml")
    canal = replace(nw.straight_waterway(nw.Canal(300.0, 16.2), 4000.0), origin=(7.6, 52.0))
    nw.write_waterway(canal, folder / "canal.geojson")
    (folder / "held.csv").write_text(HELD)
    (folder / "dtc.toml").write_text(DTC_SHIP)
    still = {"y": 3.0, "psi": 0.0, "r": 0.0, "u": 4.0, "course": 0.0, "speed": 4.0, "rudder": 0.0}
    told = [line for t in range(6) for line in bridge_sentences(canal, {**still, "x": 900.0 + 4.0 * t}, 1.7e9 + t)]
    (folder / "bridge.nmea").write_text("".join(told))
    return {
        "table": Path(table), "ship": Path(ship), "full": folder / "full.toml",
        "canal": folder / "canal.geojson", "legs": folder / "held.csv", "told": folder / "bridge.nmea",
        "out": folder / "out", "twin": written(frame_of(short_twin()), folder / "twin.csv"), "dtc": folder / "dtc.toml",
    }  # fmt: skip


HELD = "y,u [kn],rudder [deg],drift [deg]\n40,8,4.0,0.9\n-40,8,-3.0,-0.9\n"
WORDS = {
    "demo": "--out {out}",
    "identify": "{twin} --ship {dtc}",
    "explain": "mikkelsen2025_dtc {twin} --ship {dtc} --compare speed,paper+distance_depth",
    "plan": "{dtc} --runs 2 --targets b_bank,a_udot --speed 0.7",
    "export": "c mikkelsen2025_dtc -o {out}.h",
    "scale": "mikkelsen2025_dtc --length 355",
    "estimate": "--length 230 --type container --width 250",
    "ships": "",
    "simulate": "mikkelsen2025_dtc --y 0.5",
    "map": "mikkelsen2025_dtc --y -1,0,1 --speed 0.8,1",
    "envelope": "{full} --y 0,30 --speed 8kn --samples 5",
    "learn": "{full} --steady {legs}",
    "monitor": "{full} --waterway {canal} --replay {told} --page --port 0 --pace 1000",
    "trials": "yasukawa2015_kvlcc2 --speed 1.179 --zigzags 10/10",
    "compare": "{twin} --ship {dtc} --terms paper,crossflow",
    "linearize": "estimated_kcs --y 20 --speed 4",
    "squat": "estimated_kcs --speed 6kn,8kn",
    "waterway": "{canal} --draft 10",
    "reproduce": "--out {out}",
}
# The canal of the envelope was not tested, so nothing is safe in it.
SAYS_NO, SLOW = {"plan", "envelope"}, {"demo", "envelope", "learn", "map", "monitor", "reproduce"}


@pytest.mark.parametrize(
    "verb", [pytest.param(verb, marks=[pytest.mark.slow] * (verb in SLOW)) for verb in sorted(VERBS)]
)
def test_a_verb_prints_what_its_schema_says(verb: str, cli, files: dict[str, Path]) -> None:
    code, out, err = cli(verb, *WORDS[verb].format(**files).split(), "--json")
    assert code == (verb in SAYS_NO), err
    shown = json.loads(out)
    assert errors(verb, shown) == []
    parts = shown.get("conditions", {"": shown}).values()
    assert all(isinstance(part["notes"], list) for part in parts)
    if verb not in ("identify", "demo"):
        assert shown["summary"]


@pytest.mark.slow
def test_scores_of_recordings_are_what_the_schema_says(cli, files: dict[str, Path]) -> None:
    words = "monitor {full} --waterway {canal} --score {told} --score {told} --json".format(**files)
    code, out, err = cli(*words.split())
    assert code == 0, err
    assert errors("monitor", json.loads(out)) == []
    assert json.loads(out)["clear"] == 1


def test_json_has_no_nan_and_no_infinity() -> None:
    value = {
        "a": np.array([1.0, np.nan, -np.inf]),
        "b": (math.inf, np.float32(2), np.int64(3), np.bool_(True)),
        "c": None,
    }
    assert plain(value) == {"a": [1.0, None, None], "b": [None, 2.0, 3, True], "c": None}
    assert json.loads(to_json(value)) == plain(value)
    with pytest.raises(TypeError, match="object has no place in JSON"):
        plain(object())
