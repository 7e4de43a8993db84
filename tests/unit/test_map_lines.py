"""Waterways as people have them, against the canal that they were drawn from."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import narrows as nw
from narrows.waterway import Centreline
from narrows.waterway.map_lines import unprojected

ORIGIN = np.array([7.6, 52.0])
NORTH = np.linspace(0.0, 4000.0, 41)
AXIS = Centreline(np.stack([400 * np.sin(NORTH / 1200), NORTH], axis=1))
PLACES = np.linspace(0.0, AXIS.length, 81)
STARBOARD, PORT = AXIS.at(PLACES, 80.0), AXIS.at(PLACES, -70.0)
SHORT = AXIS.at(np.linspace(0.05, 0.95, 60) * AXIS.length, 80.0)

Points = Callable[[np.ndarray], Any]


def degrees(points: np.ndarray) -> Any:
    return unprojected(points, ORIGIN).tolist()


def metres(points: np.ndarray) -> Any:
    return (points + np.array([5e5, 5.7e6])).tolist()


def feature(points: np.ndarray, written: Points = degrees, kind: str = "LineString", **properties: str) -> dict:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": written(points)}}


def placemark(points: np.ndarray, name: str) -> str:
    text = " ".join(f"{east},{north},0" for east, north in degrees(points))
    return f"<Placemark><name>{name}</name><LineString><coordinates>{text}</coordinates></LineString></Placemark>"


IN_UTM = {"crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32632"}}}
MIDDLE = feature(AXIS.points, name="axis")
MAPS = {
    "left and right": [MIDDLE, feature(PORT, name="left bank"), feature(STARBOARD, name="Right Bank")],
    "right drawn backwards": [MIDDLE, feature(STARBOARD[::-1], side="right"), feature(PORT, side="left")],
    "with heights": [MIDDLE, feature(PORT, lambda points: [[*one, 3.0] for one in degrees(points)], name="left"),
                     feature(STARBOARD, name="right")],
    "a line as several": [MIDDLE, feature(PORT, name="left"), {
        "type": "Feature", "properties": {"name": "right"}, "geometry": {
            "type": "MultiLineString", "coordinates": [degrees(STARBOARD)]}}],
    "points twice": [MIDDLE, feature(np.repeat(PORT, 2, axis=0), name="left"),
                     feature(np.repeat(STARBOARD, 2, axis=0), name="right")],
    "buoys and nothing": [
        MIDDLE, feature(PORT, name="left"), feature(STARBOARD, name="right"),
        {"type": "Feature", "properties": {}, "geometry": None},
        {"type": "Feature", "properties": {}, "geometry": {"type": "Point", "coordinates": [7.6, 52.0]}}],
    "a bank 5 % short at either end": [feature(AXIS.points, role="axis"), feature(SHORT, role="right"),
                                       feature(PORT, role="left")],
}  # fmt: skip


def check(waterway: nw.Waterway) -> None:
    """As wide as the canal, and bent as it is."""
    middle = waterway.section(waterway.line.length / 2)
    assert waterway.line.length == pytest.approx(AXIS.length, rel=0.01)
    assert float(middle.width) == pytest.approx(150.0, abs=0.5)
    assert float(middle.depth) == pytest.approx(16.0)
    place, _ = waterway.to_map(waterway.line.length / 2, float(middle.middle), 0.0)
    assert np.abs(AXIS.locate(_about(place, waterway))[1] - 5.0) < 1.0  # the middle is 5 m to starboard of that line
    ahead = waterway.line.heading(waterway.line.length / 2)
    assert float(ahead) == pytest.approx(float(AXIS.heading(AXIS.length / 2)), abs=0.02)


def _about(place: np.ndarray, waterway: nw.Waterway) -> np.ndarray:
    from narrows.waterway.map_lines import projected

    return projected(unprojected(np.atleast_2d(place), np.array(waterway.origin)), ORIGIN)[0]


@pytest.mark.parametrize("name", MAPS)
def test_lines_are_told_by_word(name: str, tmp_path: Path, cli) -> None:
    path, out = tmp_path / "map.geojson", tmp_path / "canal.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": MAPS[name]}), encoding="utf-8-sig")
    code, text, err = cli("waterway", path, "--depth", "16", "-o", out)
    assert (code, err) == (0, "")
    check(nw.read_waterway(out))
    assert ("beyond, its distance is assumed constant" in " ".join(text.split())) == ("short" in name)


def test_utm_is_answered_with_the_command_that_converts_it(tmp_path: Path) -> None:
    path = tmp_path / "utm.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [feature(PORT, metres)], **IN_UTM}))
    with pytest.raises(nw.InputError, match=r"32632.*ogr2ogr -t_srs EPSG:4326 wgs84.geojson utm.geojson"):
        nw.read_waterway(path)


def test_kml_is_read(tmp_path: Path, cli) -> None:
    pytest.importorskip("pyogrio")
    path, out = tmp_path / "banks.kml", tmp_path / "canal.geojson"
    lines = placemark(AXIS.points, "Centreline") + placemark(PORT, "left") + placemark(STARBOARD, "right")
    path.write_text(f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document>{lines}</Document></kml>')
    assert cli("waterway", path, "--depth", "16", "-o", out)[0] == 0
    check(nw.read_waterway(out))


COMMANDS = {
    "one line": ([feature(AXIS.points)], "--width 300 --depth 16"),
}  # fmt: skip


@pytest.mark.parametrize("name", COMMANDS)
def test_a_map_without_banks_is_answered_with_the_command_that_reads_it(
    name: str, tmp_path: Path, cli, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    features, words = COMMANDS[name]
    Path("map.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    code, _, err = cli("waterway", "map.geojson")
    assert (code, words in err) == (2, True)
    command = err.strip().partition(": narrows waterway ")[2]
    assert cli("waterway", *command.split())[0] == 0
    assert nw.read_waterway("canal.geojson").line.length == pytest.approx(AXIS.length, rel=0.05)


@pytest.mark.parametrize(
    ("features", "told"),
    [
        ([feature(PORT, metres, name="left"), feature(STARBOARD, metres, name="right"),
          feature(AXIS.points, metres, name="axis")], "Save the map in WGS84"),
        ([feature(AXIS.points, role="axis"), feature(AXIS.at(PLACES[20:], 80.0), role="right"),
          feature(PORT, role="left")], "draw it along the whole of it"),
        ([feature(PORT, name="left"), feature(STARBOARD, name="right")], "the property role = centreline; add it"),
    ],
    ids=["metres", "a short bank", "two banks alone"],
)  # fmt: skip
def test_what_cannot_be_read_is_told_with_the_remedy(features: list, told: str, tmp_path: Path) -> None:
    path = tmp_path / "map.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    with pytest.raises(nw.InputError, match=told):
        nw.read_waterway(path)
