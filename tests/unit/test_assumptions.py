"""Assumptions about values that a file does not give are told: density, verdicts, covariance, order of coordinates."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

import narrows as nw
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


def test_every_door_tells_that_a_file_has_no_verdicts_and_no_covariance() -> None:
    known = replace(
        DTC, verdicts=dict.fromkeys(DTC.terms.names, "identified"), covariance=nw.identify(short_twin()).covariance
    )
    doors = {
        "voyage": lambda model: nw.simulate(model, y=0.5, u=1.0, duration=1.0).notes,
        "fleet": lambda model: tuple(nw.ensemble(model, y=[0.5], u=1.0, duration=1.0).attrs["notes"].splitlines()),
        "linear": lambda model: model.linearize(u=1.0).notes,
        "bank force": lambda model: nw.bank_force(model, 1.0, 0.5, 0.0).notes,
        "scale": lambda model: nw.scale_model(model, 355.0).notes,
        "model": lambda model: model.notes,
    }
    for name, notes in doors.items():
        assert any("the model has no verdict and no covariance" in note for note in notes(DTC)), name
        assert not any("is not known: the model has no" in note for note in notes(known)), name


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
