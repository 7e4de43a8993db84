"""Banks that are no walls, waterways to files and back, and out of electronic charts."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from strategies import numbers

import narrows as nw
from narrows.ship.particulars import keel_wall
from narrows.waterway import Bank, Centreline, Waterway
from narrows.waterway.geojson import read_line
from narrows.waterway.map_lines import read_chart, unprojected, waterway_from_chart
from s57 import CANAL_BANK, COASTLINE, DEPTH_AREA, INLAND_DEPTH_AREA, SHORE_AREA, Cell

DTC = nw.published("mikkelsen2025_dtc")
LINE = Centreline(np.array([[0.0, 0.0], [0.0, 500.0]]))
ENDS = np.array([0.0, 500.0])
SLOPE = ((0.0, 0.0), (0.6, 0.3))
STEP = ((0.0, 0.0), (0.0, 0.1), (0.5, 0.1), (0.5, 0.3))
ORIGIN = np.array([7.6, 52.0])


def canal(profile=(), depth: float = 0.3, **more) -> Waterway:
    banks = [Bank(side, ENDS, np.full(2, 3.2), profile) for side in ("starboard", "port")]
    return Waterway(LINE, *banks, (ENDS, np.full(2, depth)), **more)


@given(depth=numbers(0.16, 0.3), run=numbers(0.05, 1.0))
def test_a_slope_stands_for_the_wall_of_its_section(depth: float, run: float) -> None:
    """By hand: the wall is half the wet run beyond the toe."""
    here = canal(((0.0, 0.0), (run, 0.3)), depth).section(250.0)
    # What is above the water is not wet, but the bank ends at the top of the profile.
    wet = run * depth / 0.3
    area = 3.2 * depth + wet * depth / 2
    assert float(here.width) / 2 == pytest.approx(area / depth, rel=1e-9)


@given(clearance=numbers(0.0, 0.29))
def test_a_keel_meets_a_slope_where_it_is_as_high(clearance: float) -> None:
    assert keel_wall([(2.0 + out, up) for out, up in SLOPE], clearance) == pytest.approx(2.0 + 2 * clearance)
    assert keel_wall([(out, up) for out, up in STEP], 0.05) == 0.0
    assert keel_wall([(out, up) for out, up in STEP], 0.2) == 0.5


def test_she_grounds_where_her_keel_meets_the_slope() -> None:
    """A deep hull stops short of the wall that its forces feel; a step under its keel stops nothing."""
    sloped, stepped = canal(SLOPE), canal(STEP)
    keel = 3.2 + 0.6 * (0.3 - DTC.configuration.ship.draft) / 0.3
    for way, room in ((sloped, keel), (stepped, None)):
        voyage = nw.simulate(DTC, y=0.6, u=1.0, waterway=way)
        assert voyage.outcome.kind == "grounded"
        ship, psi = DTC.configuration.ship, abs(voyage.psi[-1])
        reach = abs(voyage.y[-1]) + ship.length / 2 * np.sin(psi) + ship.beam / 2 * np.cos(psi)
        wall = float(way.section(0.0).width) / 2
        assert reach == pytest.approx(min(room or wall, wall), abs=1e-6)


def test_vertical_walls_are_the_profile_that_rises_at_once() -> None:
    upright = canal(((0.0, 0.0), (0.0, 0.4)))
    voyages = [nw.simulate(DTC, y=0.5, waterway=way) for way in (canal(), upright)]
    np.testing.assert_array_equal(voyages[0].y, voyages[1].y)


def test_the_level_moves_the_wall_of_a_slope() -> None:
    way = canal(SLOPE)
    low, high = (float(way.with_water(level=level).section(0.0).width) for level in (-0.1, 0.0))
    assert low < high


def test_a_slope_needs_a_depth() -> None:
    banks = [Bank(side, ENDS, np.full(2, 3.2), SLOPE) for side in ("starboard", "port")]
    with pytest.raises(nw.InputError, match="a bank with a profile needs depths"):
        Waterway(LINE, *banks)


def test_a_waterway_goes_to_a_file_and_back(tmp_path: Path) -> None:
    t = np.linspace(0, 500, 21)
    line = Centreline(np.stack([20 * np.sin(t / 80), t], axis=1))
    s = np.linspace(0, line.length, 401)  # chords between near points keep to the curve
    banks = (
        Bank("starboard", s, 40 + 5 * np.cos(s / 90), ((0.0, 0.0), (12.0, 8.0))),
        Bank("port", s, np.full(401, 35.0)),
    )
    own = Waterway(line, *banks, (s, 8 + s / 1000), origin=(7.6, 52.0))
    nw.write_waterway(own, tmp_path / "canal.geojson")
    back = nw.read_waterway(tmp_path / "canal.geojson")
    assert back.starboard.profile == banks[0].profile
    assert back.line.length == pytest.approx(own.line.length, rel=1e-6)
    for name in ("width", "middle", "depth"):
        found, expected = (getattr(way.section(np.linspace(5, 495, 50)), name) for way in (back, own))
        np.testing.assert_allclose(found, expected, atol=1e-3, err_msg=name)
    with pytest.raises(nw.InputError, match="its place on earth is unknown"):
        nw.write_waterway(canal(), tmp_path / "other.geojson")


@pytest.mark.parametrize(
    ("profile", "said"),
    [([[0, 0], [-5, 3]], "turns back"), ("steep", "each distance and height"), ([[0, 0]], "two points or more")],
)
def test_profiles_that_cannot_be_are_named(tmp_path: Path, profile: object, said: str) -> None:
    nw.write_waterway(canal(SLOPE, origin=(7.6, 52.0)), tmp_path / "canal.geojson")
    found = json.loads((tmp_path / "canal.geojson").read_text())
    found["features"][1]["properties"]["profile"] = profile
    (tmp_path / "canal.geojson").write_text(json.dumps(found))
    with pytest.raises(nw.InputError, match=said):
        nw.read_waterway(tmp_path / "canal.geojson")


def at(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Metres east and north as longitude and latitude."""
    return [tuple(point) for point in unprojected(np.array(points, float), ORIGIN).tolist()]


def cell(tmp_path: Path, port: float = -45.0, hole: bool = False, unit: int = 1) -> Path:
    """An inland cell: a canal northward, 30 m to starboard and 45 m to port, 4 m deep, then 3.5."""
    made = Cell("1W7TEST1.000", unit)
    made.line(CANAL_BANK, at([(30, -100), (30, 600)]))
    made.line(COASTLINE, at([(port, -100), (port, 600)]))
    made.line(CANAL_BANK, at([(80, -100), (80, 600)]))
    made.area(INLAND_DEPTH_AREA, at([(-50, -50), (50, -50), (50, 310), (-50, 310), (-50, -50)]), "4.0", "5.0")
    if not hole:
        made.area(DEPTH_AREA, at([(-50, 290), (50, 290), (50, 600), (-50, 600), (-50, 290)]), "3.5", "4.0")
    return made.save(tmp_path / "1W7TEST1.000")


AXIS = np.array(at([(0, 0), (0, 250), (0, 500)]))


class TestChart:
    pytest.importorskip("pyogrio")

    def test_a_canal_is_measured(self, tmp_path: Path) -> None:
        way = waterway_from_chart(read_chart(cell(tmp_path)), AXIS)
        assert way.line.length == pytest.approx(500.0, abs=0.05)
        here = way.section(np.array([100.0, 250.0, 450.0]))
        np.testing.assert_allclose(here.width, 75.0, atol=0.05)
        np.testing.assert_allclose(here.middle, -7.5, atol=0.05)
        np.testing.assert_array_equal(here.depth, [4.0, 4.0, 3.5])

    def test_the_command_writes_a_canal_to_sail_in(self, tmp_path: Path, cli) -> None:
        axis = {"type": "LineString", "coordinates": AXIS.tolist()}
        lines = {"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}, "geometry": axis}]}
        (tmp_path / "axis.geojson").write_text(json.dumps(lines))
        np.testing.assert_allclose(read_line(tmp_path / "axis.geojson"), AXIS)
        out = tmp_path / "canal.geojson"
        code, said, _ = cli("waterway", cell(tmp_path), "--line", tmp_path / "axis.geojson", "-o", out)
        assert code == 0
        assert "narrowest 75 m" in said
        assert "shallowest 3.5 m" in said
        code, said, _ = cli("waterway", out, "--json")
        assert json.loads(said)["narrowest"]["width"] == pytest.approx(75.0, abs=0.1)
        code, said, _ = cli("simulate", "mikkelsen2025_dtc", "--waterway", out, "--duration", 20, "--current", 0.2)
        assert code == 0
        assert "afloat" in said

    def test_a_bank_that_is_not_there_is_named_with_its_place(self, tmp_path: Path) -> None:
        with pytest.raises(nw.InputError, match="no port bank within 40 m at 0 m"):
            waterway_from_chart(read_chart(cell(tmp_path)), AXIS, reach=40.0)

    def test_a_hole_in_the_depths_is_named_with_its_place(self, tmp_path: Path) -> None:
        with pytest.raises(nw.InputError, match=r"no depth of water at 31\d m"):
            waterway_from_chart(read_chart(cell(tmp_path, hole=True)), AXIS)

    def test_a_basin_in_the_land_and_a_deep_in_the_shallows(self, tmp_path: Path) -> None:
        """Rings within an area bound it too: the near one is the bank, a hole is not as shallow as the rest."""
        made = Cell("1W7TEST2.000")
        basin = [(-40, -80), (35, -80), (35, 580), (-40, 580), (-40, -80)]
        made.area(SHORE_AREA, at([(-300, -300), (300, -300), (300, 900), (-300, 900), (-300, -300)]), hole=at(basin))
        deep = [(-20, -70), (20, -70), (20, 570), (-20, 570), (-20, -70)]
        made.area(DEPTH_AREA, at(basin), "2.0", "4.0", hole=at(deep))
        made.area(DEPTH_AREA, at(deep), "12.0", "14.0")
        way = waterway_from_chart(read_chart(made.save(tmp_path / "1W7TEST2.000")), AXIS)
        assert float(way.section(250.0).width) == pytest.approx(75.0, abs=0.05)
        assert float(way.section(250.0).depth) == 12.0

    def test_banks_and_depths_are_the_charts_own_points(self, tmp_path: Path) -> None:
        """A pier as narrow as a hand, two banks that cross and an edge of depth: no station misses them."""
        made = Cell("1W7TEST3.000")
        made.line(CANAL_BANK, at([(30, -100), (30, 237.0), (10, 237.0), (10, 237.1), (30, 237.1), (30, 600)]))
        made.line(CANAL_BANK, at([(-40, -100), (-50, 600)]))
        made.line(COASTLINE, at([(-50, -100), (-40, 600)]))
        made.area(DEPTH_AREA, at([(-60, -150), (60, -150), (60, 123.4), (-60, 123.4), (-60, -150)]), "4.0", "5.0")
        made.area(DEPTH_AREA, at([(-60, 123.4), (60, 123.4), (60, 650), (-60, 650), (-60, 123.4)]), "3.5", "4.0")
        way = waterway_from_chart(read_chart(made.save(tmp_path / "1W7TEST3.000")), AXIS)
        s = np.array([236.9, 237.05, 237.2])
        np.testing.assert_allclose(way.starboard.at(s), [30, 10, 30], atol=0.03)
        # The nearer of two lines that cross in the middle of the canal, 250 m along it.
        np.testing.assert_allclose(way.port.at([50.0, 250.0, 450.0]), [42.14, 45.0, 42.14], atol=0.05)
        np.testing.assert_array_equal(way.depth([123.3, 123.5]), [4.0, 3.5])
        nw.write_waterway(way, tmp_path / "canal.geojson")
        again = nw.read_waterway(tmp_path / "canal.geojson")
        np.testing.assert_allclose(again.starboard.at(s), way.starboard.at(s), atol=1e-4)
        np.testing.assert_array_equal(again.depth([123.3, 123.5]), [4.0, 3.5])

    @pytest.mark.parametrize("reach", [float("nan"), -100.0])
    def test_lengths_that_are_none_are_refused(self, tmp_path: Path, reach: float) -> None:
        with pytest.raises(nw.InputError, match="must be over 0 and under"):
            waterway_from_chart(read_chart(cell(tmp_path)), AXIS, reach)

    def test_what_is_no_chart_is_refused(self, tmp_path: Path, cli) -> None:
        (tmp_path / "bad.000").write_bytes(b"no chart at all")
        for path in (tmp_path / "bad.000", tmp_path / "absent.000"):
            with pytest.raises(nw.InputError, match=r"is not a cell|no such file"):
                read_chart(path)
        with pytest.raises(nw.InputError, match="not in metres"):
            read_chart(cell(tmp_path, unit=2))
        code, _, error = cli("waterway", tmp_path / "bad.000")
        assert (code, error.count("\n")) == (2, 1)
        assert "--line" in error

    def test_without_the_extra_it_says_which(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setitem(sys.modules, "pyogrio", None)
        with pytest.raises(nw.InputError, match=r"-m pip install 'pyogrio\S+"):
            read_chart(cell(tmp_path))


def test_a_current_without_a_waterway_is_refused(cli) -> None:
    code, _, error = cli("simulate", "mikkelsen2025_dtc", "--current", 0.5)
    assert code == 2
    assert "--current goes with --waterway; add it" in error


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"features": None}, "not a GeoJSON FeatureCollection"),
        ({"features": ["a"]}, "not a GeoJSON FeatureCollection"),
        ({"depth": "deep"}, "is not a number; for several"),
        ({"depth": True}, "is not a number; for several"),
        ({"depth": {"a": 1}}, "is not a number; for several"),
    ],
)
def test_files_that_cannot_be_are_named(tmp_path: Path, change: dict, said: str) -> None:
    nw.write_waterway(canal(SLOPE, origin=(7.6, 52.0)), tmp_path / "canal.geojson")
    found = json.loads((tmp_path / "canal.geojson").read_text())
    if "depth" in change:
        found["features"][0]["properties"] |= change
    else:
        found |= change
    (tmp_path / "canal.geojson").write_text(json.dumps(found))
    with pytest.raises(nw.InputError, match=said):
        nw.read_waterway(tmp_path / "canal.geojson")


def test_a_voyage_starts_on_the_waterway() -> None:
    for x in (-1.0, 500.0):
        with pytest.raises(nw.InputError, match="start on it"):
            nw.simulate(DTC, x=x, waterway=canal())


def test_water_that_is_none_is_named() -> None:
    with pytest.raises(nw.InputError, match="is invalid; give one speed in m/s"):
        canal().with_water(current=float("nan"))
    with pytest.raises(nw.InputError, match="raise the level of -1 m"):
        canal().with_water(level=-1.0)


def test_a_waterway_that_is_shut_is_named(cli, tmp_path: Path) -> None:
    nw.write_waterway(canal(SLOPE, origin=(7.6, 52.0)), tmp_path / "canal.geojson")
    code, _, error = cli("waterway", tmp_path / "canal.geojson", "--draft", 0.4)
    assert code == 2
    assert "no room for a draft of 0.4 m at 0 m" in error
    assert cli("waterway", tmp_path / "canal.geojson", "--draft", "nan")[0] == 2
    assert cli("waterway", tmp_path / "canal.geojson", "--reach", 50)[0] == 2
