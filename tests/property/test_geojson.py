"""GeoJSON of any kind is a waterway or one sentence; waterways across the antimeridian."""

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from strategies import numbers

import narrows as nw
from narrows.waterway.geojson import read_line
from narrows.waterway.map_lines import Chart, unprojected, waterway_from_chart
from nightly import draws

NORTH = np.linspace(-1000, 1000, 5)
PROFILE = [[0.0, 0.0], [30.0, 20.0]]


def collection(longitude: float = 32.5, latitude: float = 30.0) -> dict[str, Any]:
    """A canal northward, 100 m to starboard and 90 m to port, with all that a file can say."""

    def feature(role: str, east: float, **more: Any) -> dict[str, Any]:
        points = unprojected(np.stack([np.full(5, east), NORTH], axis=1), np.array([longitude, latitude]))
        geometry = {"type": "LineString", "coordinates": points.tolist()}
        return {"type": "Feature", "properties": {"role": role, **more}, "geometry": geometry}

    features = [
        feature("centreline", 0.0, depth=20.0),
        feature("starboard", 100.0, profile=PROFILE),
        feature("port", -90.0),
    ]
    return {"type": "FeatureCollection", "features": features}


def places(value: Any, before: tuple = ()) -> list[tuple]:
    """Ways to every value of a document, the document's own first."""
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [before, *(place for key, own in inside for place in places(own, (*before, key)))]


WHOLE = collection()
PLACES = places(WHOLE)
NUMBERS = (10**400, -(10**4299), 1e308, -1e308, 5e-324, float("nan"), float("inf"), 1e8, 90, 180)
OTHERS = ("12", "LineString", "port", [], {}, [[]], [1, 2], [[1, 2]], [[0, 0], [0, 0]], [{}], {"role": []})
ODD = st.one_of(
    st.none(), st.booleans(), st.text(max_size=5), st.integers(), st.floats(), st.sampled_from(NUMBERS + OTHERS)
)
ANYTHING = st.recursive(
    ODD, lambda own: st.lists(own, max_size=4) | st.dictionaries(st.text(max_size=4), own, max_size=3), max_leaves=6
)


def changed(place: tuple, value: Any) -> Any:
    if not place:
        return value
    document = copy.deepcopy(WHOLE)
    inside = document
    for key in place[:-1]:
        inside = inside[key]
    inside[place[-1]] = value
    return document


def read(path: Path, text: str) -> None:
    """A waterway that can be asked, or one sentence."""
    path.write_text(text, encoding="utf-8")
    for reader in (nw.read_waterway, read_line):
        said = ""
        try:
            found = reader(path)
        except nw.InputError as error:
            found, said = None, str(error)
        assert len(said) < 500
        assert "\n" not in said
        if isinstance(found, nw.Waterway):
            here = found.section(np.linspace(0, found.line.length, 7), 10.0)
            assert np.isfinite([here.width, here.middle, here.curvature]).all()


@given(place=st.sampled_from(PLACES), value=ANYTHING)
@settings(max_examples=draws(80), suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_value_in_any_place_is_read_or_refused(tmp_path: Path, place: tuple, value: Any) -> None:
    read(tmp_path / "canal.geojson", json.dumps(changed(place, value)))


@given(place=st.sampled_from(PLACES[1:]))
@settings(max_examples=len(PLACES), suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_what_is_left_out_is_filled_in_or_refused(tmp_path: Path, place: tuple) -> None:
    document = copy.deepcopy(WHOLE)
    inside = document
    for key in place[:-1]:
        inside = inside[key]
    del inside[place[-1]]
    read(tmp_path / "canal.geojson", json.dumps(document))


ODD_TEXTS = {
    "100 000 brackets": "[" * 100_000,
    "100 000 brackets, closed": "[" * 100_000 + "]" * 100_000,
    "a deep coordinate": json.dumps(WHOLE).replace("32.5", "[" * 5000 + "1" + "]" * 5000, 1),
    "a deep crs": json.dumps(WHOLE)[:-1] + ', "crs": ' + "[" * 900 + "1" + "]" * 900 + "}",
    "an integer of 5000 digits": json.dumps(WHOLE).replace("20.0", "9" * 5000, 1),
    "nothing": "",
    "half": json.dumps(WHOLE)[:300],
    "zeros": "\0" * 100,
}


@pytest.mark.parametrize("name", ODD_TEXTS)
def test_texts_that_are_no_geojson_are_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "canal.geojson").write_text(ODD_TEXTS[name])
    for reader in (nw.read_waterway, read_line):
        with pytest.raises(nw.InputError, match=r"canal\.geojson: "):
            reader(tmp_path / "canal.geojson")


@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        (("features", 1, "properties"), [1], "feature 1: its properties are"),
        (("features", 0, "properties", "depths"), [[0, 4], [9, "x"]], "are not pairs of place and depth"),
        (("features", 0, "properties", "depths"), [[9, 4], [0, 5]], "do not rise along it"),
        (("features", 2, "geometry"), "line", "feature 2: its geometry are 'line'"),
        (
            ("features", 2, "geometry", "coordinates", 3),
            ["7", "52"],
            "the port has a coordinate that is not two numbers",
        ),
        (
            ("features", 2, "geometry", "coordinates", 3),
            [10**400, 1],
            "the port has a coordinate that is not two numbers",
        ),
        (("features", 2, "geometry", "coordinates", 3), [True, 1], "the port has a coordinate that is not two numbers"),
        (("features", 1, "properties", "profile", 1), [30.0, 1e308], "starboard bank has the point 30, 1e"),
        (("features", 1, "properties", "profile"), [], "starboard bank \\[\\] needs two points"),
        (("features", 1, "properties", "profile", 1), [30.0, -1.0], "none below the bottom"),
        (("features", 0, "properties", "depth"), 1e308, "is deeper than any sea"),
        (("features", 0, "properties", "depth"), [20.0, [[]]], "is not a number; for several"),
        (("features", 0, "geometry", "type"), "Polygon", "the centreline is a 'Polygon'; make it a LineString"),
    ],
)
def test_what_is_wrong_is_named_with_its_place(tmp_path: Path, place: tuple, value: Any, said: str) -> None:
    (tmp_path / "canal.geojson").write_text(json.dumps(changed(place, value)))
    with pytest.raises(nw.InputError, match=said):
        nw.read_waterway(tmp_path / "canal.geojson")


@given(longitude=st.sampled_from((180.0, -180.0, 179.9999, -179.9995)), latitude=numbers(-88, 88))
@settings(max_examples=draws(10), suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_waterway_across_the_antimeridian(tmp_path: Path, longitude: float, latitude: float) -> None:
    """As long and as wide as anywhere else, and written between -180 and 180 degrees."""
    path = tmp_path / "canal.geojson"
    document = collection(longitude, latitude)
    slanted = unprojected(np.stack([NORTH / 20, NORTH], axis=1), np.array([longitude, latitude]))
    document["features"][0]["geometry"]["coordinates"] = slanted.tolist()
    path.write_text(json.dumps(document))
    way = nw.read_waterway(path)
    assert way.line.length == pytest.approx(2000 * np.hypot(1, 1 / 20), abs=1e-4)
    assert float(way.line.heading(1000.0)) == pytest.approx(np.arctan(1 / 20), abs=1e-4)
    assert float(way.starboard.at(1000.0)) == pytest.approx(100 * np.hypot(1, 1 / 20), abs=0.1)
    nw.write_waterway(way, path)
    written = np.concatenate([own["geometry"]["coordinates"] for own in json.loads(path.read_text())["features"]])
    assert np.abs(written[:, 0]).max() <= 180
    again = nw.read_waterway(path)
    np.testing.assert_allclose(again.section(NORTH + 1000).width, way.section(NORTH + 1000).width, atol=1e-3)


def test_a_chart_across_the_antimeridian() -> None:
    pytest.importorskip("shapely")
    import shapely

    def line(east: float) -> np.ndarray:
        return unprojected(np.stack([np.full(5, east) + NORTH / 20, NORTH], axis=1), np.array([180.0, 52.0]))

    area = shapely.Polygon(np.concatenate([line(-80.0), line(80.0)[::-1]]))
    assert np.ptp(line(0.0)[:, 0]) > 359
    chart = Chart((line(50.0), line(-40.0)), ((area, 9.0),), "antimeridian")
    way = waterway_from_chart(chart, line(0.0)[1:4])
    np.testing.assert_allclose(way.section(np.linspace(0, 1000, 5)).width, 90 * np.cos(np.arctan(1 / 20)), atol=0.01)
    assert abs(way.origin[0]) > 179.9


@pytest.mark.parametrize("latitude", [89.5, -89.99])
def test_near_a_pole_there_is_no_east(tmp_path: Path, latitude: float) -> None:
    (tmp_path / "canal.geojson").write_text(json.dumps(collection(10.0, latitude)))
    with pytest.raises(nw.InputError, match="within a degree of a pole"):
        nw.read_waterway(tmp_path / "canal.geojson")
