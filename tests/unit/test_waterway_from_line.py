"""A waterway of one width and depth along a line: the four numbers that a canal authority has at hand."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import narrows as nw
from narrows.waterway.centreline import chords, line_with_room
from narrows.waterway.map_lines import projected, unprojected

# A meridian in the Suez Canal: 0.05 degrees of latitude are 5540 m on WGS84 there.
LINE = {"type": "LineString", "coordinates": [[32.58, 30.00], [32.58, 30.05]]}
FEATURE = {"type": "Feature", "properties": {}, "geometry": LINE}
COLLECTION = {"type": "FeatureCollection", "features": [FEATURE]}


@pytest.mark.parametrize("document", [LINE, FEATURE, COLLECTION])
def test_a_line_with_a_width_and_a_depth_is_a_waterway(document: dict, tmp_path: Path, cli) -> None:
    line, out = tmp_path / "line.geojson", tmp_path / "canal.geojson"
    line.write_text(json.dumps(document))
    code, text, err = cli("waterway", "--line", line, "--width", "300", "--depth", "16", "-o", out)
    assert (code, err) == (0, "")
    assert "narrowest 300 m" in text
    section = (read := nw.read_waterway(out)).section(1000.0)
    assert read.line.length == pytest.approx(5543, abs=2)
    assert float(section.width) == pytest.approx(300, abs=0.01)
    assert float(section.middle) == pytest.approx(0, abs=0.01)
    assert float(section.depth) == pytest.approx(16)


@pytest.mark.parametrize("mirror", ["roles", "axes"])
def test_swapped_banks_and_swapped_axes_are_told_from_a_bank_that_crosses(mirror: str, tmp_path: Path) -> None:
    sides = {"centreline": 32.58, "starboard": 32.5816, "port": 32.5784}
    lines = {role: [[east, 30.00], [east, 30.05]] for role, east in sides.items()}
    if mirror == "roles":
        lines["starboard"], lines["port"] = lines["port"], lines["starboard"]
    else:
        lines = {role: [point[::-1] for point in points] for role, points in lines.items()}
    features = [
        {"type": "Feature", "properties": {"role": role}, "geometry": {"type": "LineString", "coordinates": points}}
        for role, points in lines.items()
    ]
    path = tmp_path / "swapped.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    with pytest.raises(nw.InputError, match=r"exchange their roles.*longitude before latitude"):
        nw.read_waterway(path)


S = np.linspace(0, 6000, 61)
AXIS = np.stack([0.8 * S, 0.6 * S + 300 * np.sin(S / 1500)], axis=1)
AHEAD = np.gradient(AXIS, axis=0) / np.linalg.norm(np.gradient(AXIS, axis=0), axis=1)[:, None]
ACROSS = np.stack([AHEAD[:, 1], -AHEAD[:, 0]], axis=1)
BENDING = {"centreline": AXIS, "starboard": AXIS + 75 * ACROSS, "port": AXIS - 75 * ACROSS}
"""Lines of a canal 150 m wide that bends [m]."""


def degrees(points: np.ndarray) -> list:
    return unprojected(points, np.array([9.2, 54.1])).tolist()


def saved(path: Path, *shapes: tuple[str, object, dict]) -> Path:
    features = [
        {"type": "Feature", "properties": about, "geometry": {"type": kind, "coordinates": points}}
        for kind, points, about in shapes
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def test_longitudes_may_count_to_360(tmp_path: Path) -> None:
    shapes = [("LineString", [[x + 340, y] for x, y in degrees(p)], {"role": r}) for r, p in BENDING.items()]
    assert nw.read_waterway(saved(tmp_path / "west.geojson", *shapes)).place == "about 54.12 N, 10.76 W"


@pytest.mark.parametrize(
    ("words", "remedy"),
    [
        ((), "--line axis.geojson --width 300 --depth 16"),
        (("--line", "line.geojson", "--width", "300"), "--depth 16"),
        (("--line", "line.geojson", "--width", "-3", "--depth", "16"), "give metres over 0"),
        (("canal.geojson", "--width", "300"), "at most one of FILE, --width"),
        (
            ("--line", "line.geojson", "--width", "300", "--depth", "16", "--reach", "9"),
            "at most one of --reach, --width",
        ),
        (("canal.geojson", "--reach", "9"), "--reach goes with --line"),
    ],
)
def test_what_is_missing_is_named_with_the_command(words: tuple, remedy: str, tmp_path, cli, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("line.geojson").write_text(json.dumps(LINE))
    code, out, err = cli("waterway", *words)
    assert (code, out) == (2, "")
    assert remedy in err


def test_places_of_a_long_waterway_are_printed_in_metres(tmp_path: Path, cli) -> None:
    line = saved(tmp_path / "long.geojson", ("LineString", [[4.3, 51.3], [4.5, 51.3], [4.7, 51.302]], {}))
    _, out, _ = cli("waterway", "--line", line, "--width", 300, "--depth", 16)
    assert "27899.5" in out
    assert "27900 m long" in out


@pytest.mark.parametrize("name", ["canal.geojson", "my lines/axis.geojson"])
def test_the_named_command_keeps_the_line_that_it_reads(name: str, tmp_path: Path, monkeypatch, cli) -> None:
    monkeypatch.chdir(tmp_path)
    Path(name).parent.mkdir(exist_ok=True)
    Path(name).write_text(json.dumps(LINE))
    _, _, err = cli("waterway", name)
    code, _, _ = cli(*shlex.split(err[err.index("narrows waterway") :])[1:])
    assert (code, json.loads(Path(name).read_text())) == (0, LINE)


def test_a_track_of_a_ship_is_smoothed_until_its_bends_have_room(tmp_path: Path, cli) -> None:
    """Positions scattered by 2 m about an arc of 3000 m radius, a third of them repeated."""
    turn, scatter = np.linspace(0.0, 1.0, 300), np.random.default_rng(5).normal(0.0, 2.0, (300, 2))
    arc = 3000.0 * np.stack([np.sin(turn), 1 - np.cos(turn)], axis=1)
    origin = np.array([32.58, 30.0])
    sailed = unprojected(np.repeat(arc + scatter, np.where(np.arange(300) % 3, 1, 2), axis=0), origin)
    shapes = {
        "line": [("LineString", sailed.tolist(), {})],
        "points": [("Point", point, {"time": second}) for second, point in enumerate(sailed.tolist())],
    }
    for name, features in shapes.items():
        track, out = saved(tmp_path / f"{name}.geojson", *features), tmp_path / f"{name}_canal.geojson"
        code, told, err = cli("waterway", "--line", track, "--width", 160, "--depth", 13, "-o", out)
        assert (code, err) == (0, "")
        assert "the line is smoothed, by up to" in told
        line = (read := nw.read_waterway(out)).line
        found = unprojected(line.at(np.linspace(0, line.length, 500)), np.array(read.origin))
        away = np.hypot(*(projected(found, origin) - np.array([0.0, 3000.0])).T) - 3000.0
        assert np.abs(away).max() < 3 * 2.0
        assert line.length == pytest.approx(3000.0, rel=0.01)
        assert np.abs(line.curvature(line.fine)).max() < 1 / 160


def test_scatter_of_close_fixes_does_not_lengthen_a_track(tmp_path: Path) -> None:
    """20 000 fixes, 0.4 m apart, with a scatter of a metre: the chords between them are 4.5 times the way."""
    along, scatter = np.linspace(0.0, 8000.0, 20_001), np.random.default_rng(4).normal(0.0, 1.0, (20_001, 2))
    bend = np.stack([6000 * (1 - np.cos(along / 6000)), 6000 * np.sin(along / 6000)], axis=1)
    drawn = line_with_room(bend + scatter, 80.0)
    assert drawn.length == pytest.approx(8000, abs=5)
    np.testing.assert_allclose(drawn.curvature(drawn.length * np.linspace(0.1, 0.9, 9)), 1 / 6000, rtol=0.1)
    assert np.abs(drawn.locate(bend)[1]).max() < 4.0


@pytest.mark.parametrize(("across", "along"), [(1, 1), (1, 2)])  # A ring, and an eight
def test_a_line_that_comes_back_to_itself_is_refused_with_the_place_to_end_it(across: int, along: int) -> None:
    turn = np.linspace(0.3, 0.3 + 2 * np.pi, 200)
    points = np.stack([1500 * np.sin(across * turn), 1500 * np.cos(along * turn + (along - 1) * np.pi / 2)], axis=1)
    with pytest.raises(nw.InputError, match="comes back to itself") as refusal:
        line_with_room(points, 80.0)
    end = float(re.search(r"end it at (\d+) m", str(refusal.value))[1])
    assert line_with_room(points[chords(points) < end], 80.0).length > 0.4 * chords(points)[-1]


def test_a_line_that_leaves_room_is_not_moved(tmp_path: Path, cli) -> None:
    axis = saved(tmp_path / "axis.geojson", ("LineString", degrees(AXIS), {}))
    _, told, _ = cli("waterway", "--line", axis, "--width", 160, "--depth", 13)
    assert "smoothed" not in told


def test_a_straight_waterway_of_plain_numbers_is_refused_with_the_call() -> None:
    with pytest.raises(nw.InputError, match=r"give nw.Canal\(width, depth\) in metres"):
        nw.straight_waterway(300.0, 5000.0)
