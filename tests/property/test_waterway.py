"""Waterways: round trips, a circle by hand, the straight canal as the simplest case, and geometry that cannot be."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from strategies import numbers

import narrows as nw
from narrows.waterway import Bank, Centreline, Waterway
from narrows.waterway.map_lines import projected, unprojected

DTC = nw.published("mikkelsen2025_dtc")


def winding(amplitude: float = 600.0) -> Centreline:
    t = np.linspace(0, 20_000, 60)
    return Centreline(np.stack([amplitude * np.sin(t / 2500), t], axis=1))


def circle(radius: float, to_starboard: bool = True) -> Centreline:
    """A quarter of a circle, northward at first."""
    angle = np.linspace(0, np.pi / 2, 200)
    east = radius * (1 - np.cos(angle)) * (1 if to_starboard else -1)
    return Centreline(np.stack([east, radius * np.sin(angle)], axis=1))


def waterway(line: Centreline, half: float = 100.0, **more) -> Waterway:
    s = np.array([0.0, line.length])
    return Waterway(line, Bank("starboard", s, np.full(2, half)), Bank("port", s, np.full(2, half)), **more)


@given(seed=st.integers(0, 1000))
def test_poses_go_to_the_waterway_and_back(seed: int) -> None:
    draw, way = np.random.default_rng(seed), waterway(winding())
    s, n = draw.uniform(0, way.line.length, 200), draw.uniform(-100, 100, 200)
    psi = draw.uniform(-1, 1, 200)
    positions, heading = way.to_map(s, n, psi)
    again = way.to_channel(positions, heading)
    for own, found in zip((s, n, psi), again, strict=True):
        np.testing.assert_allclose(found, own, atol=1e-7)
    np.testing.assert_allclose(way.to_map(*again)[0], positions, atol=1e-7)


@given(radius=numbers(300, 5000), share=numbers(0.05, 0.95), n=numbers(-100, 100))
def test_a_circle_by_hand(radius: float, share: float, n: float) -> None:
    line = circle(radius)
    assert line.length == pytest.approx(radius * np.pi / 2, rel=1e-6)
    s, angle = share * line.length, share * np.pi / 2
    assert float(line.curvature(s)) == pytest.approx(1 / radius, rel=2e-3)
    assert float(line.heading(s)) == pytest.approx(angle, abs=1e-4)
    inner = radius - n
    expected = [radius - inner * np.cos(angle), inner * np.sin(angle)]
    np.testing.assert_allclose(line.at(s, n), expected, atol=1e-4 * radius)
    assert float(circle(radius, to_starboard=False).curvature(s)) == pytest.approx(-1 / radius, rel=2e-3)


@given(radius=numbers(300, 5000), sign=st.sampled_from((-1, 1)), count=st.integers(7, 60), angle=numbers(0.3, 1.7))
def test_a_bend_keeps_its_curvature_to_its_ends(radius: float, sign: int, count: int, angle: float) -> None:
    """A circle by its points, to the errors that the docstring states."""
    turned = np.linspace(0, angle, count)
    line = Centreline(radius * np.stack([sign * (1 - np.cos(turned)), np.sin(turned)], axis=1))
    s, apart = np.linspace(0, line.length, 500), angle / (count - 1)
    off = np.abs(sign * radius * line.curvature(s) - 1)
    inside = (s > 2 * apart * radius) & (s < line.length - 2 * apart * radius)
    assert off.max() < 0.71 * apart**2
    assert off[inside].max() < 0.14 * apart**2
    np.testing.assert_allclose(line.heading(s), sign * s / radius, atol=0.2 * apart**3)
    assert line.length == pytest.approx(radius * angle, rel=0.01 * apart**4)


def arc_between_straights(radius: float, turn: float, spacing: float, scatter: float = 0.0) -> Centreline:
    """A straight line, an arc and a straight line, at points so far apart, which scatter."""
    lead, arc = 1500.0, radius * turn
    s = np.arange(0.0, 2 * lead + arc, spacing)
    angle = np.clip((s - lead) / radius, 0, turn)
    after = np.maximum(s - lead - arc, 0.0)
    east = radius * (1 - np.cos(angle)) + after * np.sin(turn)
    north = np.minimum(s, lead) + radius * np.sin(angle) + after * np.cos(turn)
    points = np.stack([east, north], axis=1)
    return Centreline(points + scatter * np.random.default_rng(int(radius + spacing)).standard_normal(points.shape))


@pytest.mark.parametrize("radius", [500.0, 1500.0, 3000.0])
@pytest.mark.parametrize("spacing", [25.0, 50.0, 100.0, 200.0])
def test_the_sharpest_bend_is_that_of_the_arc(radius: float, spacing: float) -> None:
    """An arc as long as two widths or more: the spline's own curvature is up to a fifth too large there."""
    way = waterway(arc_between_straights(radius, 1.0, spacing), half=120.0)
    found, at, over = way.sharpest_bend
    assert found == pytest.approx(radius, rel=0.04)
    assert over == pytest.approx(480, rel=1e-6)
    assert 1500 < at < 1500 + radius
    assert f"sharpest bend of {found:.3g} m radius over 480 m" in way.summary()
    scattered = waterway(arc_between_straights(radius, 1.0, spacing, spacing / 400), half=120.0)
    assert scattered.sharpest_bend[0] == pytest.approx(radius, rel=0.10)


def test_a_line_shorter_than_two_widths_is_one_bend() -> None:
    found, at, over = waterway(circle(100.0), half=80.0).sharpest_bend
    assert (found, at, over) == pytest.approx((100.0, 50 * np.pi / 2, 100 * np.pi / 2), rel=1e-3)
    assert waterway(Centreline(np.array([[0.0, 0.0], [3000.0, 1000.0]]))).sharpest_bend is None


def clothoid(count: int, length: float, sharpest: float) -> np.ndarray:
    """Points of a line whose curvature grows evenly from nothing, by Gauss and Legendre between them."""
    s = np.linspace(0, length, count)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    between = (s[1:] + s[:-1])[:, None] / 2 + np.diff(s)[:, None] / 2 * nodes
    heading = sharpest * between**2 / (2 * length)
    steps = [np.diff(s) / 2 * (f(heading) @ weights) for f in (np.sin, np.cos)]
    return np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=1).T])


@given(sharpest=numbers(-1 / 1150, 1 / 1150), count=st.integers(10, 40))
def test_a_clothoid_keeps_its_curvature_to_its_ends(sharpest: float, count: int) -> None:
    """Two lengths of a ship of 230 m into a bend of five, by points every 12 to 50 m."""
    line = Centreline(clothoid(count, 460.0, sharpest))
    s = np.linspace(0, 460.0, 300)
    np.testing.assert_allclose(line.curvature(s), sharpest * s / 460, atol=1e-3 / 1150)
    np.testing.assert_allclose(line.heading(s), sharpest * s**2 / 920, atol=1e-5)
    assert line.length == pytest.approx(460.0, abs=1e-4)


def test_few_points_make_a_line() -> None:
    """Two a straight one, three a parabola through them."""
    straight = Centreline(np.array([[0.0, 0.0], [300.0, 400.0]]))
    np.testing.assert_array_equal(straight.curvature(np.linspace(-10, 510, 14)), 0.0)
    assert straight.length == pytest.approx(500.0, rel=1e-15)
    points = np.array([[0.0, 0.0], [10.0, 100.0], [40.0, 195.0]])
    bent = Centreline(points)
    np.testing.assert_allclose(bent.at(bent.locate(points)[0]), points, atol=1e-9)
    np.testing.assert_allclose(bent.curvature(np.linspace(0, bent.length, 5)), 1 / 500, rtol=0.05)


@given(out=numbers(0, 400), n=numbers(-90, 90), first=st.booleans())
def test_a_bend_goes_straight_on_beyond_its_ends(out: float, n: float, first: bool) -> None:
    line = circle(1000.0)
    end, sign = (0.0, -1.0) if first else (line.length, 1.0)
    along = np.array([np.sin(line.heading(end)), np.cos(line.heading(end))])
    there = line.at(end) + sign * out * along + n * np.array([along[1], -along[0]])
    np.testing.assert_allclose(line.at(end + sign * out, n), there, atol=1e-7)
    np.testing.assert_allclose(line.locate(there), (end + sign * out, n), atol=1e-7)


@pytest.mark.parametrize(
    "points",
    [[["a", 1], [2, 3]], [[0, 0], [1, 10**400]], [[0.0, 0.0], [1e308, 0.0]], [[0, 0], [float("nan"), 1]], [1, 2], None],
)
def test_a_line_of_anything_else_is_refused(points: object) -> None:
    with pytest.raises(nw.InputError, match="centreline"):
        Centreline(points)


@given(heading=numbers(-3, 3), s=numbers(-50, 550), n=numbers(-90, 90))
def test_a_straight_line_goes_on_beyond_its_ends(heading: float, s: float, n: float) -> None:
    way = nw.straight_waterway(nw.Canal(200.0), 500.0, heading)
    along, across = np.array([np.sin(heading), np.cos(heading)]), np.array([np.cos(heading), -np.sin(heading)])
    found = way.to_channel(s * along + n * across, heading)
    assert tuple(map(float, found)) == pytest.approx((s, n, 0.0), abs=1e-9)


@pytest.mark.parametrize(("y", "psi", "heading"), [(0.5, 0.0, 0.7), (2.4, 0.05, -2.0), (-1.0, -0.1, 0.0)])
def test_the_straight_canal_is_its_simplest_case(y: float, psi: float, heading: float) -> None:
    way = nw.straight_waterway(DTC.configuration.canal, 500.0, heading)
    plain = nw.simulate(DTC, y=y, psi=psi)
    along = nw.simulate(DTC, y=y, psi=psi, waterway=way)
    assert plain.outcome.side == along.outcome.side
    for name in ("t", "x", "y", "psi", "u", "v", "r"):
        np.testing.assert_allclose(getattr(along, name), getattr(plain, name), atol=1e-9)


def inert() -> nw.Model:
    """A hull that only mass resists: it sails straight on."""
    return DTC.with_coefficients(
        b_v=0.0, b_r=0.0, b_vv=0.0, b_rr=0.0, b_bank=0.0, c_v=0.0, c_r=0.0, c_vv=0.0, c_rr=0.0, c_bank=0.0
    )


def test_a_ship_without_forces_sails_straight_across_the_map() -> None:
    """Through a bend of the waterway, until its outer bank stops it."""
    way = waterway(circle(400.0), 30.0)
    voyage = nw.simulate(inert(), y=0.0, u=1.0, duration=400.0, dt=0.5, waterway=way)
    positions, heading = way.to_map(voyage.x, voyage.y, voyage.psi)
    first = float(way.line.heading(0.0))
    expected = voyage.t[:, None] * [np.sin(first), np.cos(first)]
    np.testing.assert_allclose(positions, expected, atol=1e-3, err_msg="to a millimetre")
    np.testing.assert_allclose(heading, first, atol=1e-5)
    assert (voyage.outcome.kind, voyage.outcome.side) == ("grounded", "port")


def test_a_current_carries_her_along() -> None:
    way = nw.straight_waterway(nw.Canal(7.0), 500.0)
    still, carried = (nw.simulate(DTC, y=0.5, u=1.0, waterway=own) for own in (way, way.with_water(current=0.5)))
    assert carried.outcome.time == pytest.approx(still.outcome.time, rel=1e-9)
    assert carried.outcome.distance - still.outcome.distance == pytest.approx(0.5 * still.outcome.time, rel=1e-9)


def narrowing(**water: Any) -> Waterway:
    """From 300 m wide to 120 m, and from 16 m deep to 10 m."""
    s, line = np.array([0.0, 1000.0, 3000.0]), Centreline(np.array([[0.0, 0.0], [0.0, 3000.0]]))
    banks = [Bank(side, s, np.array([150.0, 60.0, 60.0])) for side in ("starboard", "port")]
    return Waterway(line, *banks, (s, np.array([16.0, 16.0, 10.0])), origin=(5.0, 52.0), **water)


def test_a_current_passes_the_same_discharge_through_every_section() -> None:
    way = narrowing(current=0.4)
    s = np.linspace(0.0, 3000.0, 31)
    here = way.section(s)
    np.testing.assert_allclose(way.current_at(s) * here.width * here.depth, 0.4 * 300 * 16, rtol=1e-12)
    assert way.current_at(1000.0) == pytest.approx(1.0)
    assert "current 0.4 to 1.6 m/s" in way.summary()
    lower = way.with_water(level=-2.0)  # which keeps the current
    assert lower.current_at(3000.0) == pytest.approx(0.4 * 300 * 14 / (120 * 8))


@pytest.mark.parametrize("current", [0.4, -0.4, [(0.0, 0.2), (1500.0, -0.3), (3000.0, 1.0)]])
def test_a_ship_is_carried_by_the_current_of_its_place(current: Any, tmp_path: Path) -> None:
    """A ship without forces, by another integrator; law, fleet and file have the same current."""
    way = narrowing(current=current)
    nw.write_waterway(way, tmp_path / "way.geojson")
    s = np.linspace(0.0, 3000.0, 7)
    np.testing.assert_allclose(nw.read_waterway(tmp_path / "way.geojson").current_at(s), way.current_at(s), rtol=1e-6)
    expected = solve_ivp(lambda t, x: 2.0 + way.current_at(x), (0.0, 900.0), [100.0], rtol=1e-10, atol=1e-8).y[0, -1]
    told = {"y": 0.0, "x": 100.0, "u": 2.0, "duration": 900.0, "dt": 5.0, "waterway": way}
    assert nw.simulate(inert(), **told).x[-1] == pytest.approx(expected, abs=0.02)
    assert 100.0 + nw.ensemble(inert(), **told)["distance"].item() == pytest.approx(expected, abs=0.02)


def test_the_voyage_ends_where_the_waterway_ends() -> None:
    voyage = nw.simulate(DTC, y=0.0, u=1.0, duration=60.0, waterway=nw.straight_waterway(nw.Canal(7.0), 20.0))
    assert (voyage.outcome.kind, voyage.outcome.side) == ("left the waterway", "end")
    assert voyage.x[-1] == pytest.approx(20.0, abs=1e-6)
    # A vertical wall 3.5 m off, and half the beam of 0.572 m: on the centreline nothing moves the ship to a side.
    assert voyage.outcome.clearance == pytest.approx(3.5 - 0.286, abs=1e-3)
    assert voyage.outcome.largest_rudder is None
    assert voyage.outcome.ending.startswith("Reached the end of the waterway after 2")
    assert voyage.outcome.ending.endswith("along the canal, least clearance 3.21 m.")


def test_a_voyage_that_is_steered_to_the_end_of_a_waterway_gives_its_largest_rudder() -> None:
    way, ship = nw.straight_waterway(nw.Canal(100.0, 20.0), 30.0), nw.published("yasukawa2015_kvlcc2")
    sailed = nw.simulate(ship, u=1.0, duration=60.0, waterway=way, controller=lambda t, state: 0.1)
    assert sailed.outcome.largest_rudder == np.abs(sailed.rudder).max() == pytest.approx(0.1)
    assert sailed.outcome.ending.endswith(" m, largest rudder 5.7 deg.")


def test_an_asymmetric_section_is_seen_from_its_middle() -> None:
    s = np.array([0.0, 500.0])
    line = Centreline(np.array([[0.0, 0.0], [0.0, 500.0]]))
    way = Waterway(line, Bank("starboard", s, np.full(2, 3.0)), Bank("port", s, np.full(2, 4.0)))
    shifted = nw.simulate(DTC, y=0.0, u=1.0, waterway=way)
    plain = nw.simulate(DTC, y=0.5, u=1.0)
    np.testing.assert_allclose(shifted.y, plain.y - 0.5, atol=1e-9)
    assert shifted.outcome.time == pytest.approx(plain.outcome.time, abs=1e-9)


def test_a_canal_that_widens_lets_her_off() -> None:
    s = np.array([0.0, 500.0])
    line = Centreline(np.array([[0.0, 0.0], [0.0, 500.0]]))

    def way(end: float) -> Waterway:
        return Waterway(line, *(Bank(side, s, np.array([3.5, end])) for side in ("starboard", "port")))

    times = [nw.simulate(DTC, y=0.5, u=1.0, waterway=way(end)).outcome.time for end in (3.4, 3.5, 7.0, 20.0)]
    assert np.all(np.diff(times) > 0)


def feature(role: str, points: np.ndarray, **more) -> dict:
    return {"type": "Feature", "properties": {"role": role, **more},
            "geometry": {"type": "LineString", "coordinates": np.round(points, 9).tolist()}}  # fmt: skip


def collection(**changed) -> dict:
    """A canal near 32.5 E, 30 N, north to south, 200 m wide, 2 km long."""
    origin = np.array([32.5, 30.0])
    y = np.linspace(1000, -1000, 21)
    lines = {"centreline": 0.0, "starboard": -110.0, "port": 90.0}
    features = {
        role: feature(
            role, unprojected(np.stack([np.full(21, x), y], axis=1), origin), **({"depth": 24.0} if not x else {})
        )
        for role, x in lines.items()
    }
    return {"type": "FeatureCollection", "features": list((features | changed).values())}


def saved(tmp_path: Path, what: object) -> Path:
    path = tmp_path / "canal.geojson"
    path.write_text(what if isinstance(what, str) else json.dumps(what))
    return path


def test_a_canal_from_longitude_and_latitude(tmp_path: Path) -> None:
    way = nw.read_waterway(saved(tmp_path, collection()))
    assert way.line.length == pytest.approx(2000.0, abs=0.01)
    here = way.section(1000.0)
    assert float(here.width) == pytest.approx(200.0, abs=1e-3)
    assert float(here.middle) == pytest.approx(10.0, abs=1e-3)
    assert float(here.depth) == 24.0
    assert way.with_water(level=-1.0).canal(500.0).depth == 23.0


def test_a_map_of_voyages_in_a_waterway(tmp_path: Path, cli) -> None:
    """By name and by function; starts along it vary too."""
    path = tmp_path / "canal.geojson"
    straight = nw.straight_waterway(nw.Canal(7.0, 0.3), 60.0)
    nw.write_waterway(replace(straight, origin=(7.6, 52.0)), path)
    words = ("map", "mikkelsen2025_dtc", "--y=-0.6,0.6", "--duration", 60, "--dt", 0.1, "--json")
    code, out, _ = cli(*words, "--waterway", path, "--x", "0,50", "--current", "0.2m/s", "-o", tmp_path / "map.nc")
    assert code == 0
    shown = json.loads(out)
    assert shown["voyages"] == 4
    assert shown["outcomes"]["passed"] == 2  # Those that begin 10 m before its end.
    way = nw.read_waterway(path).with_water(0.2)
    ends = nw.ensemble(nw.published("mikkelsen2025_dtc"), duration=60.0, dt=0.1, y=[-0.6, 0.6], x=[0.0, 50.0],
                       waterway=way)  # fmt: skip
    with xr.open_dataset(tmp_path / "map.nc", engine="scipy") as written:
        np.testing.assert_array_equal(written["distance"].transpose(*ends["distance"].dims), ends["distance"])
    one = ("simulate", "mikkelsen2025_dtc", "--duration", 30, "--waterway", path, "--json")
    speeds = [[0.0, 0.2], [40.0, 0.4]]
    told = [cli(*one, "--current", ",".join(f"{place}:{speed}m/s" for place, speed in speeds))[1]]
    nw.write_waterway(way.with_water(speeds), path)
    assert [*told, cli(*one, "--current", "0.2m/s")[1]] != [cli(*one)[1]] * 2
    assert told == [cli(*one)[1]]
    for wrong in (("--width", "6", "--waterway", path), ("--current", "1m/s"), ("--waterway", path, "--x", "61")):
        code, _, error = cli(*words, *wrong)
        assert (code, error.count("\n")) == (2, 1)


@given(east=numbers(-5000, 5000), north=numbers(-5000, 5000))
def test_the_projection_goes_both_ways(east: float, north: float) -> None:
    origin, points = np.array([32.5, 30.0]), np.array([[east, north]])
    np.testing.assert_allclose(projected(unprojected(points, origin), origin), points, atol=1e-5)


LINE = np.stack([np.full(21, 32.5), np.linspace(30.009, 29.991, 21)], axis=1)
BESIDE = np.stack([np.full(21, 32.501), LINE[:, 1]], axis=1)
SLANTING = np.stack([np.linspace(32.501, 32.499, 21), LINE[:, 1]], axis=1)


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ("{", "is not JSON"),
        ({"type": "Topology"}, "FeatureCollection"),
        ({"type": "Feature"}, "has no line"),
        (collection(port=feature("prt", LINE)), "role = port"),
        (collection(port=feature("centreline", LINE)), "two lines with the role centreline"),
        (collection(port=feature("port", LINE * [1, 4])), "no longitude and latitude"),
        (collection(port=feature("port", LINE[:1])), "fewer than two points"),
        (
            collection(port=feature("port", SLANTING)),
            "port bank crosses",
        ),
        (collection(port=feature("port", BESIDE[5:15])), "draw it along the whole"),
        ({**collection(), "crs": {"properties": {"name": "EPSG:22992"}}}, "save the map in WGS84"),
    ],
)
def test_bad_geometry_is_named_with_its_place(tmp_path: Path, what: object, said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        nw.read_waterway(saved(tmp_path, what))


def test_latitude_first_is_noticed(tmp_path: Path) -> None:
    swapped = collection(port=feature("port", np.array([[51.2, 104.3], [51.3, 104.4]])))
    with pytest.raises(nw.InputError, match="latitude seems to come first"):
        nw.read_waterway(saved(tmp_path, swapped))


def test_a_bend_inside_its_own_bank_is_refused() -> None:
    with pytest.raises(nw.InputError, match="bends with a radius of"):
        waterway(circle(80.0), 100.0)


def test_a_ship_that_does_not_fit_is_told_where() -> None:
    s = np.array([0.0, 300.0, 500.0])
    line = Centreline(np.array([[0.0, 0.0], [0.0, 500.0]]))
    banks = [Bank(side, s, np.array([3.5, 0.2, 3.5])) for side in ("starboard", "port")]
    with pytest.raises(nw.InputError, match=r"0.40\d* m wide at 300 m along it, where .* needs more than 0.572 m"):
        nw.simulate(DTC, waterway=Waterway(line, *banks))
    with pytest.raises(nw.InputError, match="m deep at 0 m"):
        nw.simulate(DTC, waterway=nw.straight_waterway(nw.Canal(7.0, 0.1), 500.0))


@pytest.mark.parametrize(
    "wrong", [np.array([0.5, 1.0]), (0.5, 1.0), "1", [[0, 1], [0, 2]], [[0, "1"]], [[0], 1], np.nan]
)
def test_a_current_is_one_number_or_pairs(wrong: Any) -> None:
    straight = nw.straight_waterway(nw.Canal(100.0, 10.0), 1000.0)
    with pytest.raises(nw.InputError, match="one speed in m/s, or"):
        straight.with_water(current=wrong)
    with pytest.raises(nw.InputError, match="one number"):
        straight.with_water(level=wrong)


def test_a_line_with_a_width_and_a_depth_is_a_waterway() -> None:
    points = [(0.0, 0.0), (0.0, 1000.0), (300.0, 2000.0)]
    even = nw.Waterway(points, width=200.0, depth=12.0)
    assert (even.section(700.0).width, even.section(700.0).depth) == (200.0, 12.0)
    uneven = nw.Waterway(points, width=[200.0, 260.0, 220.0], depth=[12.0, 15.0, 14.0])
    places = uneven.line.locate(np.array(points))[0]
    np.testing.assert_allclose(uneven.section(places).width, [200.0, 260.0, 220.0])
    np.testing.assert_allclose(uneven.section(places).depth, [12.0, 15.0, 14.0])
    assert uneven.section(places.mean()).middle == 0
    with pytest.raises(nw.InputError, match="2 sizes for 3 points"):
        nw.Waterway(points, width=[200.0, 260.0])
    with pytest.raises(nw.InputError, match="a line alone is no waterway; give its width"):
        nw.Waterway(points)


@pytest.mark.parametrize("psi", [0.0, 0.3, -0.3])
def test_the_clearance_of_a_voyage_is_that_of_the_corners_of_its_hull(psi: float) -> None:
    model = nw.published("estimated_kcs")
    told = {"y": 30.0, "u": 4.0, "psi": psi, "duration": 60.0, "contact": "corners"}
    voyage = nw.simulate(model, **told)
    length, beam = model.ship.length, model.ship.beam
    half = length / 2 * np.abs(np.sin(voyage.psi)) + beam / 2 * np.cos(voyage.psi)
    np.testing.assert_allclose(voyage.clearance, 150.0 - np.abs(voyage.y) - half, atol=1e-9)


def test_the_least_clearance_of_a_voyage_in_a_bend_is_that_of_its_outcome() -> None:
    angle = np.linspace(0.0, 0.4, 60)
    bend = nw.Waterway(3000.0 * np.stack([1 - np.cos(angle), np.sin(angle)], axis=1), width=300.0, depth=16.2)
    voyage = nw.simulate(nw.published("estimated_kcs"), y=40.0, u=4.0, x=200.0, hold=0.0, waterway=bend, dt=0.5)
    assert voyage.outcome.kind == "left the waterway"
    assert voyage.clearance.min() == pytest.approx(voyage.outcome.clearance, abs=230.0**2 / 8 / 2850)  # sagitta
