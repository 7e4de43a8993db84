"""A waterway of one width and depth along a line: the four numbers that a canal authority has at hand."""

import json
from pathlib import Path

import pytest

import narrows as nw

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
    assert "narrowest 300.0 m" in text
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


@pytest.mark.parametrize(
    ("words", "remedy"),
    [
        ((), "--line axis.geojson --width 300 --depth 16"),
        (("--line", "line.geojson", "--width", "300"), "--depth 16"),
        (("--line", "line.geojson", "--width", "-3", "--depth", "16"), "give metres over 0"),
        (("canal.geojson", "--width", "300"), "leave it out"),
    ],
)
def test_what_is_missing_is_named_with_the_command(words: tuple, remedy: str, tmp_path, cli, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("line.geojson").write_text(json.dumps(LINE))
    code, out, err = cli("waterway", *words)
    assert (code, out) == (2, "")
    assert remedy in err
