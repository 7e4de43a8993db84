"""Room between hull and banks beside Shapely's polygons, and bounds that are never late."""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from strategies import numbers

import narrows as nw
from narrows.waterway import Bank, Centreline, Waterway
from narrows.waterway import bank_clearance as clearance_text
from narrows.waterway.bank_clearance import PORT_BANK, ROW, STARBOARD_BANK, exact_clearance, line_pose
from narrows.waterway.waterway import WaterwayTable, least_walls, tabulate
from nightly import draws

STEPS_A_BEAM = 4  # the step that the docs recommend: a quarter of the beam

shapely = pytest.importorskip("shapely")

LENGTH, BEAM = 230.0, 32.2
RECTANGLE = np.array([[1, -1], [1, 1], [-1, 1], [-1, -1]]) / 2 * [LENGTH, BEAM]
SHIP = np.array(
    [[115, 0], [95, 14], [60, 16.1], [-90, 16.1], [-115, 9], [-115, -9], [-90, -16.1], [60, -16.1], [95, -14]]
)
OUTLINES = {"rectangle": RECTANGLE, "ship": SHIP}
TURN = 1 / (5 * LENGTH)
REACH = 4 * LENGTH
"""What of the banks can matter, either way [m]."""


def ramp(s: np.ndarray, start: float, stop: float) -> np.ndarray:
    return np.clip((s - start) / (stop - start), 0, 1)


def table_of(s: np.ndarray, starboard: np.ndarray, port: np.ndarray, bend: np.ndarray) -> WaterwayTable:
    return WaterwayTable(s, starboard, port, starboard, port, np.full(len(s), np.nan), bend, np.ones(len(s)))


class Pose(NamedTuple):
    """Midship along the line and off it [m], heading to it [rad]."""

    s: float
    n: float
    psi: float


@st.composite
def bank(draw: st.DrawFn, s: np.ndarray) -> np.ndarray:
    """A wall with slopes up to 1:10 and sudden steps of up to 40 m."""
    wall = np.full(len(s), draw(numbers(60.0, 150.0)))
    for _ in range(draw(st.integers(0, 2))):
        start, change = draw(numbers(0.0, 8 * LENGTH)), draw(numbers(-40.0, 40.0))
        wall += change * ramp(s, start, start + draw(st.sampled_from((1.0, 10.0))) * abs(change) + 1e-3)
    return np.maximum(wall, 20.0)


@st.composite
def tables(draw: st.DrawFn) -> WaterwayTable:
    """Bends both ways of R = 5 L or more, at once or by a clothoid, in cells of 5 to 40 m."""
    s = np.linspace(0.0, 8 * LENGTH, draw(st.integers(50, 360)))
    bend = np.zeros(len(s))
    start, sign = 0.0, draw(st.sampled_from((-1.0, 1.0)))
    for turn in draw(st.lists(numbers(0.0, 1.0), max_size=3)):
        start += draw(numbers(0.0, 2 * LENGTH))
        ease = draw(st.sampled_from((1e-3, 2 * LENGTH)))
        stop = start + ease + draw(numbers(0.0, 3 * LENGTH))
        bend += sign * turn * TURN * (ramp(s, start, start + ease) - ramp(s, stop, stop + ease))
        start, sign = stop + ease, -sign
    return table_of(s, draw(bank(s)), draw(bank(s)), np.clip(bend, -TURN, TURN))


poses = st.builds(Pose, numbers(0.0, 8 * LENGTH), numbers(-100.0, 100.0), numbers(-0.8, 0.8))


def directions(table: WaterwayTable, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors forward and to starboard of the line, on the table's map."""
    *_, c, si, _ = line_pose(table.track, table.step, pose.s)
    return np.array([c, si]), np.array([-si, c])


def hull(table: WaterwayTable, pose: Pose, outline: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points of a hull, and unit vector athwart."""
    ahead, across = directions(table, pose)
    forward = np.cos(pose.psi) * ahead + np.sin(pose.psi) * across
    athwart = np.cos(pose.psi) * across - np.sin(pose.psi) * ahead
    x, y, *_ = line_pose(table.track, table.step, pose.s)
    return [x, y] + pose.n * across + outline @ np.stack([forward, athwart]), athwart


def bank_beside(table: WaterwayTable, pose: Pose, column: int):
    near = np.abs(np.pad(table.s, 1, mode="reflect", reflect_type="odd") - pose.s) <= REACH
    return shapely.LineString(table.track.reshape(-1, ROW)[near, column : column + 2])


def moved(points: np.ndarray, way: np.ndarray, far: float):
    """What a hull sweeps when it moves from where it is; only where it comes to if it has to move back."""
    swept = [points, points + far * way] if far > 0 else [points + far * way]
    return shapely.MultiPoint(np.concatenate(swept)).convex_hull


def rooms(table: WaterwayTable, pose: Pose, outline: np.ndarray) -> dict[int, float]:
    least, lean = exact_clearance(
        table.track.tolist(), table.step, pose.s, pose.n, np.cos(pose.psi), np.sin(pose.psi), outline.ravel().tolist()
    )
    return {STARBOARD_BANK: least + max(-lean, 0.0), PORT_BANK: least + max(lean, 0.0)}


def check_clearance(table: WaterwayTable, pose: Pose, outline: np.ndarray) -> None:
    """So far a hull can move athwart, and no farther."""
    points, athwart = hull(table, pose, outline)
    for (column, room), sign in zip(rooms(table, pose, outline).items(), (1, -1), strict=True):
        wall = bank_beside(table, pose, column)
        assert not moved(points, sign * athwart, room - 1e-9).intersects(wall)
        assert moved(points, sign * athwart, room + 1e-9).intersects(wall)


def check_bound(table: WaterwayTable, pose: Pose, outline: np.ndarray, least: np.ndarray) -> None:
    """So far a hull can move square to the line, or farther."""
    points, _ = hull(table, pose, outline)
    across, out = directions(table, pose)[1], outline @ [np.sin(pose.psi), np.cos(pose.psi)]
    for column, walls, sign in zip((STARBOARD_BANK, PORT_BANK), least, (1, -1), strict=True):
        clear = np.interp(pose.s, table.s, walls) - sign * pose.n - (sign * out).max()
        assert not moved(points, sign * across, clear - 1e-9).intersects(bank_beside(table, pose, column))


@given(table=tables(), pose=poses, outline=st.sampled_from(sorted(OUTLINES)))
@settings(max_examples=draws(50))
def test_the_room_is_how_far_a_hull_can_move_athwart(table: WaterwayTable, pose: Pose, outline: str) -> None:
    check_clearance(table, pose, OUTLINES[outline])


@given(table=tables(), pose=poses, outline=st.sampled_from(sorted(OUTLINES)))
@settings(max_examples=draws(50))
def test_the_bound_is_never_late(table: WaterwayTable, pose: Pose, outline: str) -> None:
    check_bound(table, pose, OUTLINES[outline], least_walls(table, OUTLINES[outline]))


DIAGONAL = float(np.arctan2(BEAM, LENGTH))
"""The heading at which a corner is as far ahead as it can be."""
SCENES = {
    "sudden step": (0.0, lambda s: 120 - 40 * ramp(s, 900, 901) + 30 * ramp(s, 1200, 1201)),
    "narrowing 1:10": (0.0, lambda s: 120 - 40 * (ramp(s, 700, 1100) - ramp(s, 1200, 1600))),
    "bend": (TURN, lambda s: np.full_like(s, 110.0)),
    "bend to port, narrowing": (-TURN, lambda s: 120 - 40 * (ramp(s, 700, 1100) - ramp(s, 1200, 1600))),
    "arc at once": (None, lambda s: np.full_like(s, 110.0)),
}


@pytest.mark.parametrize("name", SCENES)
def test_room_and_bound_place_by_place(name: str) -> None:
    bend, wall = SCENES[name]
    s = np.linspace(0, 8 * LENGTH, 151)
    ease = ramp(s, 800, 1260) if bend else ramp(s, 900, 900.1)
    table = table_of(s, wall(s), wall(s[::-1])[::-1], ease * (TURN if bend is None else bend))
    least = least_walls(table, RECTANGLE)
    for place in np.arange(680.0, 1400.0, 14.3):
        for psi in (-0.6, -DIAGONAL, -0.02, 0.0, DIAGONAL, 0.5):
            check_clearance(table, Pose(place, 0.0, psi), RECTANGLE)
            check_bound(table, Pose(place, 0.0, psi), RECTANGLE, least)


def test_the_bound_of_straight_walls_is_the_wall() -> None:
    s = np.linspace(0.0, 1000.0, 51)
    table = table_of(s, np.full(51, 80.0), np.full(51, 60.0), np.zeros(51))
    np.testing.assert_allclose(least_walls(table, RECTANGLE), np.repeat([[80.0], [60.0]], 51, axis=1), rtol=1e-12)


@given(table=tables(), pose=poses, outline=st.sampled_from(sorted(OUTLINES)))
def test_a_mirrored_waterway_has_the_same_room_to_the_bit(table: WaterwayTable, pose: Pose, outline: str) -> None:
    mirrored = table_of(table.s, table.port, table.starboard, -table.curvature)
    here, there = (
        rooms(own, Pose(pose.s, sign * pose.n, sign * pose.psi), OUTLINES[outline] * [1, sign])
        for own, sign in ((table, 1), (mirrored, -1))
    )
    assert (here[STARBOARD_BANK], here[PORT_BANK]) == (there[PORT_BANK], there[STARBOARD_BANK])
    bounds, across = (least_walls(own, OUTLINES[outline]) for own in (table, mirrored))
    np.testing.assert_array_equal(bounds, across[::-1])


@given(table=tables(), share=numbers(0.0, 1.0))
def test_the_line_goes_on_from_cell_to_cell(table: WaterwayTable, share: float) -> None:
    """From the end of one cell and from the beginning of the next it is at one place, with one heading."""
    node = int(share * (len(table.s) - 2)) + 1
    near, past = (line_pose(table.track, table.step, node * table.step + d) for d in (-1e-9, 1e-9))
    np.testing.assert_allclose(near[:4], past[:4], atol=3e-9)
    np.testing.assert_allclose(past[:2], table.track.reshape(-1, ROW)[node + 1, :2], atol=3e-9)


SMOOTH = {
    "clothoid": lambda s: TURN * ramp(s, 600, 1060),
    "clothoid to port": lambda s: -TURN * ramp(s, 600, 1060),
    "arc at once": lambda s: np.where(s > 903.7, TURN, 0.0),
    "straight": lambda s: 0.0 * s,
}


@pytest.mark.parametrize("bend", SMOOTH)
def test_the_recommended_step_keeps_contact_within_a_hundredth_of_the_beam(bend: str) -> None:
    """Beside the same waterway in cells of a quarter of a metre: bends, and slopes of 1:10 that begin between nodes."""

    def table(step: float) -> WaterwayTable:
        s = np.linspace(0, 2000.0, int(2000 / step) + 1)
        wall = 120 - 40 * (ramp(s, 701.3, 1101.3) - ramp(s, 1303.3, 1703.3))
        return table_of(s, wall, np.full(len(s), 90.0), SMOOTH[bend](s))

    def room(track: list[float], step: float, pose: Pose) -> float:
        return exact_clearance(track, step, *pose[:2], np.cos(pose[2]), np.sin(pose[2]), hull)[0]

    hull, draw = RECTANGLE.ravel().tolist(), np.random.default_rng(3)
    fine, coarse = ((own.track.tolist(), own.step) for own in map(table, (0.25, BEAM / STEPS_A_BEAM)))
    for _ in range(40):
        s, psi, bank = draw.uniform(500, 1500), draw.choice([0, 0.02, -0.02, 0.1, -0.1]), draw.choice([-140, 140])
        touch = brentq(lambda n: room(*fine, Pose(s, n, psi)), 0.0, bank)  # noqa: B023
        assert abs(room(*coarse, Pose(s, touch, psi))) < 0.01 * BEAM


def compiled_clearance():
    """The same text, compiled."""
    import numba

    text = re.sub(r"^def ", "@numba.njit\ndef ", Path(clearance_text.__file__).read_text(), flags=re.MULTILINE)
    scope = {"numba": numba}
    exec(text, scope)
    return scope["exact_clearance"]


def test_compiled_it_says_the_same() -> None:
    compiled, draw = compiled_clearance(), np.random.default_rng(0)
    s = np.linspace(0.0, 8 * LENGTH, 184)
    table = table_of(s, 80 - 30 * ramp(s, 700, 1000), np.full(184, 90.0), TURN * ramp(s, 400, 860))
    for _ in range(200):
        at = (draw.uniform(0, s[-1]), draw.uniform(-60, 60))
        psi = draw.uniform(-0.8, 0.8)
        arguments = (table.track, table.step, *at, np.cos(psi), np.sin(psi), SHIP.ravel())
        np.testing.assert_allclose(compiled(*arguments), exact_clearance(*arguments), rtol=1e-12, atol=1e-10)


def test_no_number_has_no_room() -> None:
    table = tabulate(nw.straight_waterway(nw.Canal(200.0), 500.0), 5.0, 10.0)
    for bad in (float("nan"), float("inf")):
        assert np.isnan(exact_clearance(table.track, table.step, bad, 0.0, 1.0, 0.0, RECTANGLE.ravel())).all()


def sloped() -> Waterway:
    t = np.linspace(0, 5000, 21)
    line = Centreline(np.stack([300 * np.sin(t / 800), t], axis=1))
    s = np.linspace(0, line.length, 30)
    slope = ((0.0, 0.0), (60.0, 20.0))
    return Waterway(
        line, Bank("starboard", s, 90 + 20 * np.cos(s), slope), Bank("port", s, np.full(30, 70.0)), (s, 15 + s / 2000)
    )


def test_a_table_has_the_waterways_columns() -> None:
    way = sloped()
    table = tabulate(way, 10.0, 20.0)
    assert 19.5 < table.step <= 20.0
    assert table.s[-1] == way.line.length
    here, keel = way.section(table.s), way.section(table.s, 10.0)
    for name, width, middle in (("", here.width, here.middle), ("keel_", keel.width, keel.middle)):
        np.testing.assert_allclose(getattr(table, f"{name}starboard"), width / 2 + middle, atol=1e-9)
        np.testing.assert_allclose(getattr(table, f"{name}port"), width / 2 - middle, atol=1e-9)
    assert (table.keel_starboard < table.starboard).any()
    np.testing.assert_array_equal(table.depth, here.depth)
    np.testing.assert_array_equal(table.curvature, here.curvature)


def test_a_tables_map_is_the_waterways() -> None:
    """Distances between places a ship's length apart, across the line too."""
    way = sloped()
    table = tabulate(way, 10.0, 8.0)
    near, far = np.arange(0, len(table.s) - 29), np.arange(29, len(table.s))
    nodes = table.track.reshape(-1, ROW)
    on_table = np.linalg.norm(nodes[far + 1, 5:7] - nodes[near + 1, 7:9], axis=1)
    starboard, port = way.line.at(table.s, table.keel_starboard), way.line.at(table.s, -table.keel_port)
    np.testing.assert_allclose(on_table, np.linalg.norm(starboard[far] - port[near], axis=1), atol=0.01)


@pytest.mark.parametrize(("draft", "step"), [(0.0, 5.0), (5.0, 0.0), (5.0, 1e-9), (float("nan"), 5.0), (5.0, -1.0)])
def test_a_table_that_cannot_be_is_refused(draft: float, step: float) -> None:
    with pytest.raises(nw.InputError, match=r"give lengths over 0|give a longer step"):
        tabulate(nw.straight_waterway(nw.Canal(200.0), 500.0), draft, step)
