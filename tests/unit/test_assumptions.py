"""Assumptions about values that a file does not give are told: density, verdicts, covariance, order of coordinates."""

import copy
import json
import re
import zipfile
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import pytest

import narrows as nw
from narrows.control import closed_loop, regulator
from narrows.export.passport import passport
from narrows.logbook.learning.learn_log import _assumptions
from narrows.quantities.names import KNOT
from narrows.report.printed_tables import print_waterway
from narrows.waterway.geojson import read_line, waterway_from_line, write_waterway
from tables import DTC_SHIP, frame_of, short_twin

DTC = nw.published("mikkelsen2025_dtc")
HULL = DTC_SHIP.replace("[water]\ndensity = 1000.0\n", "")


def ship_file(folder: Path, water: str) -> Path:
    (folder / "ship.toml").write_text(f"{HULL}\n{water}")
    return folder / "ship.toml"


@pytest.mark.parametrize(("water", "told"), [("", True), ("[water]\ndensity = 1000.0\n", False)])
def test_a_missing_density_is_told_with_what_is_assumed(water: str, told: bool, tmp_path: Path) -> None:
    ship = ship_file(tmp_path, water)
    doors = [nw.read_ship(ship).notes, nw.read_captive(frame_of(short_twin()), ship).notes]
    doors.append((fit := nw.identify(frame_of(short_twin()), ship=ship)).notes)
    nw.save_model(fit.model, tmp_path / "model.toml")
    doors.append(nw.load_model(tmp_path / "model.toml").notes)
    for notes in doors:
        assert any("density is not given: 1000 kg/m3" in note for note in notes) == told


def test_a_larger_ship_in_the_same_water_is_told() -> None:
    same, sea = nw.scale_model(DTC, 355.0), nw.scale_model(DTC, 355.0, density=1025.0)
    assert any("keeps its density of 1000 kg/m3" in note for note in same.notes)
    assert not any("keeps its density" in note for note in sea.notes)


KNOWN = nw.published("estimated_kcs").to_dict()
NO_RANGE = "gives no tested range of [^.]*"
UNKNOWN = {
    "verdicts": "the model has no verdict", "covariance": "the model has no covariance",
    "data_range.speed": f"{NO_RANGE}speed", "data_range.abs_y": f"{NO_RANGE}offset",
    "data_range.depth_to_draft": f"{NO_RANGE}depth", "data_range.width_to_beam": f"{NO_RANGE}width",
    "water.density": "density is not given: 1000 kg/m3", "canal.depth": "depth of the canal is not known",
    "propeller.wake_rate": "wake_rate is not given",
}  # fmt: skip
DOORS = {
    "voyage": lambda model: nw.simulate(model, y=5.0, u=4.0, duration=1.0).notes,
    "fleet": lambda model: nw.ensemble(model, y=[5.0], u=4.0, duration=1.0, samples=0).attrs["notes"].split("\n"),
    "linear": lambda model: model.linearize(u=4.0).notes,
    "bank force": lambda model: nw.bank_force(model, 4.0, 5.0, 0.0).notes,
    "scale": lambda model: nw.scale_model(model, 115.0).notes,
    "stability": lambda model: nw.stability(model, y=[5.0], u=[4.0]).attrs["notes"].split("\n"),
    "steady course": lambda model: [nw.steady_course(model, u=4.0, y=5.0).notes],
    "C file": lambda model: tuple(passport(model)),
    "closed loop": lambda model: closed_loop(model, regulator(model, 5.0, 4.0)).simulate(1.0).notes,
    "envelope": lambda model: (*(found := nw.safe_envelope(model, [0.0], [4.0], samples=4)).notes, found.summary()),
}  # fmt: skip
WITH_BOTTOM = ("voyage", "fleet", "envelope")  # Doors that count squat and the bottom


@cache
def told_of_known(door: str) -> str:
    return " ".join(DOORS[door](nw.Model.from_dict(KNOWN)))


@pytest.mark.parametrize("key", UNKNOWN)
def test_every_door_tells_what_the_file_does_not_give(key: str) -> None:
    unknown = without(key)
    for door, notes in DOORS.items():
        assert not re.search(UNKNOWN[key], told_of_known(door)), door
        told = re.search(UNKNOWN[key], " ".join(notes(unknown)))
        assert told or (key == "canal.depth" and door not in WITH_BOTTOM), door
    if not key.startswith(("verdicts", "covariance", "water", "propeller")):
        assert not nw.safe_envelope(unknown, [0.0], [4.0], samples=4).safe().any()


def without(*keys: str) -> nw.Model:
    tables = copy.deepcopy(KNOWN)
    for section, _, name in (key.partition(".") for key in keys):
        del (tables[section] if name else tables)[name or section]
    return nw.Model.from_dict(tables)


def bank_force_file(model: nw.Model, file: Path) -> str:
    nw.export.write(model, file, "bank-force")
    return zipfile.ZipFile(file).read("modelDescription.xml").decode() if file.suffix == ".fmu" else file.read_text()


@pytest.mark.parametrize("suffix", [".m", ".h", ".cs", ".mjs", ".fmu"])
def test_every_language_of_the_bank_force_tells_it_too(suffix: str, tmp_path: Path) -> None:
    file = tmp_path / f"bank{suffix}"
    known = bank_force_file(nw.Model.from_dict(KNOWN), file)
    for key in set(UNKNOWN) - {"canal.depth"}:
        assert not re.search(UNKNOWN[key], known), key
        assert re.search(UNKNOWN[key], bank_force_file(without(key), file)), key


def test_an_fmu_of_the_bank_force_tells_what_several_keys_left_out(tmp_path: Path) -> None:
    """Each FMU is compiled: of two, the ranges of the data are told together and are not looked at here."""
    keys = ("verdicts", "water.density", "propeller.wake_rate")
    models = nw.Model.from_dict(KNOWN), without(*keys)
    known, unknown = (bank_force_file(model, tmp_path / "bank.fmu") for model in models)
    for key in keys:
        assert not re.search(UNKNOWN[key], known), key
        assert re.search(UNKNOWN[key], unknown), key


DOORS_OF_LOGS = {
    "plan of steady legs": lambda model: nw.plan_steady(model, [10.0], [4.0], legs=2).notes,
    "forecast of information": lambda model: nw.predict_information(model, transits=1, u=4.0).notes,
}


@pytest.mark.parametrize("door", DOORS_OF_LOGS)
def test_plans_of_what_to_learn_tell_it_too(door: str) -> None:
    keys = set(UNKNOWN) - {"covariance", "canal.depth"}
    known, unknown = (" ".join(DOORS_OF_LOGS[door](model)) for model in (nw.Model.from_dict(KNOWN), without(*keys)))
    for key in keys:
        assert not re.search(UNKNOWN[key], known), key
        assert re.search(UNKNOWN[key], unknown), key
    with pytest.raises(nw.InputError, match="no covariance"):
        DOORS_OF_LOGS[door](without("covariance"))


def test_an_unknown_depth_leaves_the_speeds_of_legs_to_the_tests() -> None:
    plan = nw.plan_steady(without("canal.depth"), [10.0], legs=2)
    fastest = KNOWN["data_range"]["speed"][1]
    assert plan.legs
    assert all(0 < KNOT * leg["speed"] <= fastest for leg in plan.legs)
    assert re.search(UNKNOWN["canal.depth"], " ".join(plan.notes))


def test_a_log_learned_at_an_unknown_depth_says_so() -> None:
    def told(model: nw.Model) -> str:
        motion = SimpleNamespace(model=model, choices={})
        return " ".join(_assumptions(SimpleNamespace(motion=motion, model=SimpleNamespace(processes=())), ()))

    assert "a depth of 16.2 m" in told(nw.Model.from_dict(KNOWN))
    assert "a depth that is not known" in told(without("canal.depth"))
    assert re.search(UNKNOWN["water.density"], told(without("water.density")))


def test_trials_name_an_estimate_and_what_they_do_not_know() -> None:
    assert any("estimated from main dimensions" in note for note in nw.turning_circle(without("verdicts")).notes)
    for key in ("data_range.speed", "data_range.depth_to_draft", "water.density", "propeller.wake_rate"):
        assert re.search(UNKNOWN[key], " ".join(nw.turning_circle(without(key)).notes)), key
    slow = nw.Model.from_dict({**KNOWN, "data_range": {**KNOWN["data_range"], "speed": [0.0, 3.0]}})
    assert any("Beyond the data: surge velocity" in note for note in nw.turning_circle(slow, speed=4.0).notes)


def test_an_assumed_wake_is_still_assumed_in_the_file_that_is_saved(tmp_path: Path) -> None:
    nw.save_model(without("propeller.wake_rate"), tmp_path / "model.toml")
    assert any("wake_rate is not given" in note for note in nw.load_model(tmp_path / "model.toml").notes)


def test_a_map_with_latitude_first_is_seen_by_the_place_that_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = [[32.30 + 0.001 * k, 30.60 + 0.002 * k] for k in range(4)]
    places = {}
    for order in (1, -1):
        shape = {"type": "LineString", "coordinates": [point[::order] for point in line]}
        (tmp_path / "line.json").write_text(json.dumps({"type": "Feature", "properties": {}, "geometry": shape}))
        canal = waterway_from_line(read_line(tmp_path / "line.json"), 300.0, 16.0)
        write_waterway(canal, tmp_path / "canal.geojson")
        read = nw.read_waterway(tmp_path / "canal.geojson")
        print_waterway(read)
        assert capsys.readouterr().out.split("\n", 1)[0].startswith(f"canal: {read.place}: if that is the wrong place")
        voyage = nw.simulate(nw.scale_model(DTC, 230.0).model, u=4.0, waterway=read, duration=1.0)
        places[order] = (read.place, read.summary(), " ".join(voyage.notes))
    assert all("about 30.60 N, 32.30 E" in told for told in places[1])
    assert all("about 32.30 N, 30.60 E" in told for told in places[-1])
