"""The parts of a safe envelope by hand: areas, edges, causes; nothing is sailed here."""

import math
from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import narrows as nw
from narrows.safety import headline
from narrows.safety.envelope_along import _row
from narrows.safety.headline import cause, crossing, largest_block, runs
from narrows.safety.request import wind_force
from narrows.safety.result import IN_KNOTS, SafeEnvelope, beyond_tests, data_coverage, exceeded_rules


def test_the_first_run_ends_before_the_first_gap() -> None:
    for given, ends in (("0011010", (2, 3)), ("1110", (0, 2)), ("0111", (1, 3)), ("0001", (3, 3)), ("000", None)):
        assert next(iter(runs(np.array([sign == "1" for sign in given]))), None) == ends


def test_the_largest_rectangle_is_that_of_all_rectangles() -> None:
    """On an uneven grid: a cell is as wide as half of what lies between its neighbours; at an end, as it is far."""
    grid = xr.Dataset(coords={"y": [-3.0, 0.0, 1.0, 5.0], "u": [1.0, 2.0, 4.0]})
    wide, high = np.array([3.0, 2.0, 2.5, 4.0]), np.array([1.0, 1.5, 2.0])
    draw = np.random.default_rng(0)
    for _ in range(30):
        safe = draw.random((4, 3)) < 0.7
        blocks = [
            np.s_[first:last, low:high_end]
            for first, last in combinations(range(5), 2)
            for low, high_end in combinations(range(4), 2)
        ]
        largest = max(wide[rows].sum() * high[columns].sum() for rows, columns in blocks if safe[rows, columns].all())
        rows, columns = largest_block(grid, safe)
        assert wide[rows].sum() * high[columns].sum() == pytest.approx(largest)
        assert safe[rows, columns].all()
    assert largest_block(grid, np.zeros((4, 3), bool)) is None


def test_a_share_crosses_its_least_straight_between_two_places() -> None:
    """From 1.0 at 10 m to 0.8 at 14 m: 0.95 lies a quarter of the way out."""
    y, share = np.array([10.0, 14.0, 20.0]), np.array([1.0, 0.8, 0.96])
    assert crossing(y, share, 0, 1, 0.95) == pytest.approx(11.0)
    assert crossing(y, share, 0, 2, 0.95) == 10.0


AROUND = {"clear": True, "held": 0.5, "known": 0.5, "certain": 0.5, "rudder_likely": 0.1, "clearance": 1.0}


@pytest.mark.parametrize(
    ("here", "name"),
    [
        ({"clear": False, "clearance": math.nan}, "CHOKED"),
        ({"clear": False}, "AGROUND"), ({"held": 0.95}, "TESTS"), ({"known": 0.95}, "PILOT"),
        ({"certain": 0.95}, "KNOWLEDGE"), ({"rudder_likely": math.nan}, "NONE"),
        ({"rudder_likely": -0.31}, "RUDDER"), ({"rudder_likely": 0.3}, "UPSET"),
    ],
)  # fmt: skip
def test_the_cause_is_the_first_that_is_short_of_its_share(here: dict, name: str) -> None:
    assert cause({**AROUND, **here}, 0.95, 0.3) == getattr(headline, name)


def test_speeds_on_a_bridge_are_in_knots() -> None:
    assert IN_KNOTS["speed"].scale == pytest.approx(3600 / 1852)


def test_the_wind_pushes_with_the_square_of_its_speed() -> None:
    """1.225 kg/m3 is the density of the standard atmosphere at sea level (ISO 2533)."""
    assert wind_force(10.0, 100.0, 0.8) == pytest.approx(0.5 * 1.225 * 0.8 * 100.0 * 10.0**2)
    assert wind_force(10.0, 100.0) == wind_force(10.0, 100.0, 1.0)


def test_the_limit_in_speed_is_that_of_the_first_place_that_is_not_safe() -> None:
    """Faster, the middle is still safe; to the sides the coefficients are too uncertain for one pilot."""
    y, u = np.array([-10.0, 0.0, 10.0]), np.array([2.0, 3.0, 4.0])
    held = np.array([[0.97, 0.97, 0.8], [0.99, 0.99, 0.97], [0.97, 0.97, 0.8]])
    shares = {"held": held, "held_low": held, "held_high": held, "known": held, "certain": np.ones((3, 3))}
    likely = {"clear": np.ones((3, 3), bool), "tested": np.ones((3, 3), bool), "clearance": np.ones((3, 3)),
              "rudder_likely": np.zeros((3, 3))}  # fmt: skip
    told = {name: (("y", "u"), values) for name, values in (shares | likely).items()}
    attrs = {"untested": "", "samples": 100, "reserve": 0.3, "rudder_limit": 0.6}
    answer, limits = headline.headline(xr.Dataset(told, {"y": y, "u": u}, attrs), 0.95)
    said = " ".join([*answer, *limits])
    assert "within 10.0 m of the middle" in said
    assert "to the sides is the range that was tried; in speed, the uncertainty of the coefficients" in said


@pytest.mark.parametrize(
    ("offsets", "words"),
    [
        ((-8.0, 8.0), " within 8.0 m of the middle"), ((0.0, 0.0), " in the middle"),
        ((-8.0, 3.0), ", from 8.0 m to port to 3.0 m to starboard of the middle"),
        ((-8.0, -3.0), ", 3.0 to 8.0 m to port of the middle"), ((5.0, 5.0), ", 5.0 m to starboard of the middle"),
    ],
)  # fmt: skip
def test_offsets_are_told_from_the_middle(offsets: tuple[float, float], words: str) -> None:
    grid = xr.Dataset(coords={"u": np.array([2.0, 4.0]) * 1852 / 3600})
    assert headline.place_in_words(grid, slice(0, 2), offsets) == f"up to 4.0 knots (slowest tried 2.0){words}"
    assert headline.place_in_words(grid, slice(1, 2), offsets) == f"at 4.0 knots{words}"


KNOT = 1852 / 3600
Y, U = np.array([-20.0, -10.0, 0.0, 10.0, 20.0]), KNOT * np.array([2.0, 4.0, 6.0, 8.0])
SAFE = np.ones((5, 4))


def asked(held: np.ndarray, **changed: Any) -> xr.Dataset:
    """Shares of the cases by hand; all else allows every place, with 40 degrees of rudder and a reserve of a half."""
    shares = {"held": held, "held_low": held, "held_high": held, "known": held, "certain": 0.0 * held}
    others = {"clear": held >= 0, "tested": held >= 0, "clearance": held + 1.0, "rudder_likely": 0.0 * held}
    tables = {name: (("y", "u"), np.asarray(table)) for name, table in {**shares, **others, **changed}.items()}
    return xr.Dataset(tables, {"y": Y, "u": U}, {"untested": "", "samples": 80, "reserve": 0.5, "rudder_limit": 0.7})


def said(held: np.ndarray, **changed: Any) -> str:
    answer, limits = headline.headline(asked(held, **changed), 0.95)
    return " ".join([*answer, *limits])


def at(value: float, *places: tuple[Any, Any], base: np.ndarray = SAFE) -> np.ndarray:
    table = np.array(base, float)
    for place in places:
        table[place] = value
    return table


SIDES = at(0.75, ([0, 4], slice(None)))  # 0.95 lies a fifth of the way from 10 to 20 m
TRIED, LENGTHS = "the range that was tried", headline.AT_LENGTH
EVERYWHERE = "up to 8.0 knots (slowest tried 2.0) within 20.0 m of the middle"
TABLE: dict[str, tuple[dict[str, Any], str]] = {
    "everywhere": (
        {"held": SAFE},
        f"Safe {EVERYWHERE}, with 95 % probability. The limit to the sides is {TRIED}; in speed, {TRIED}.",
    ),
    "to both sides": (
        {"held": SIDES},
        "Safe up to 8.0 knots (slowest tried 2.0) within 12.0 m of the middle, with 95 % probability. The limit to the "
        f"sides is {LENGTHS['the disturbance']}; in speed, {TRIED}.",
    ),
    "one speed holds least": (  # 0.65 at 20 m: a seventh of the way
        {"held": at(0.65, (4, 1), base=at(0.85, (4, slice(None))))},
        "Safe up to 8.0 knots (slowest tried 2.0), from 20.0 m to port to 11.4 m to starboard of the middle, with 95 % "
        f"probability. The limit to the sides is {LENGTHS['the disturbance']}; in speed, {TRIED}.",
    ),
    "too fast": (
        {"held": at(0.5, (slice(None), 3)), "rudder_likely": 0.36 * SAFE},
        "Safe up to 6.0 knots (slowest tried 2.0) within 20.0 m of the middle, with 95 % probability. The limit to the "
        f"sides is {TRIED}; in speed, {LENGTHS['the rudder']}.",
    ),
    "too fast, with half of the rudder": (
        {"held": at(0.5, (slice(None), 3)), "rudder_likely": -0.34 * SAFE},
        "Safe up to 6.0 knots (slowest tried 2.0) within 20.0 m of the middle, with 95 % probability. The limit to the "
        f"sides is {TRIED}; in speed, {LENGTHS['the disturbance']}.",
    ),
    "too slow": (
        {"held": at(0.5, (slice(None), 0))},
        f"Safe from 4.0 to 8.0 knots within 20.0 m of the middle, with 95 % probability. The limit to the sides is "
        f"{TRIED}; in speed, {TRIED}.",
    ),
    "aground": (
        {"held": SAFE, "clear": at(0.0, (slice(None), 2)) > 0},
        "Safe up to 4.0 knots (slowest tried 2.0) within 20.0 m of the middle, with 95 % probability. The limit to the "
        f"sides is {TRIED}; in speed, "
        f"{LENGTHS['the keel']}.",
    ),
    "by the model alone": (
        {"held": SAFE, "tested": at(0.0, (0, slice(None)), (slice(None), 3)) > 0},
        "Safe up to 6.0 knots (slowest tried 2.0), from 10.0 m to port to 20.0 m to starboard of the middle, with 95 % "
        f"probability. The limit to the sides is {LENGTHS['the tests end']}; in speed, {LENGTHS['the tests end']}. By "
        f"the model also {EVERYWHERE}, but there the tests end.",
    ),
    "outside the tests alone": (
        {"held": SAFE, "tested": SAFE < 0},
        f"Nowhere safe within the tests; by the model {EVERYWHERE}. The limit is {LENGTHS['the tests end']}.",
    ),
    "never clear": (
        {"held": SAFE, "clear": SAFE < 0, "clearance": at(math.nan, (2, 0))},
        "No offset and speed is safe with 95 % probability. The limit is the choking of the canal.",
    ),
    "seldom": (
        {"held": at(0.6, (slice(1, 3), slice(1, 3)), base=0.3 * SAFE)},
        "No offset and speed is safe with 95 % probability: at best 60 % of the cases are held, at -10.0 m and 4.0 "
        "knots; more likely held than not from 4.0 to 6.0 knots, from 13.3 m to port to 3.3 m to starboard of the "
        "middle.",
    ),
    "a better pilot": (
        {"held": SIDES, "known": SAFE},
        "Safe up to 8.0 knots (slowest tried 2.0) within 12.0 m of the middle, with 95 % probability. The limit to the "
        f"sides is {LENGTHS['the pilot']}; in speed, {TRIED}. A pilot with the true coefficients would control the "
        f"ship {EVERYWHERE}.",
    ),
    "a better pilot between the places": (
        {"held": at(0.9, (4, 0), base=SIDES), "known": at(0.9, (4, slice(None)), base=SAFE)},
        "A pilot with the true coefficients would control the ship up to 8.0 knots (slowest tried 2.0), from 20.0 m to "
        "port to 15.0 m to starboard of the middle.",
    ),
    "no pilot": (
        {"held": 0.4 * SAFE, "known": 0.5 * SAFE, "certain": SAFE},
        "at best 40 % of the cases are held, at -20.0 m and 2.0 knots. A pilot with the true coefficients would not "
        f"control the ship either. The limit is {LENGTHS['uncertain coefficients']}.",
    ),
    "few cases": (
        {"held": SAFE, "held_low": SIDES},
        "Certain with 80 cases: up to 8.0 knots (slowest tried 2.0) within 10.0 m of the middle.",
    ),
    "too few cases": (
        {"held": SAFE, "held_low": 0.5 * SAFE},
        "With 80 cases this is uncertain everywhere; more samples (--samples, in Python samples=) make it certain.",
    ),
}


@pytest.mark.parametrize("case", TABLE)
def test_sentences_are_those_of_tables_by_hand(case: str) -> None:
    told, words = TABLE[case]
    assert words in said(**told)


def enveloped(held: np.ndarray, rudder: np.ndarray, **changed: Any) -> SafeEnvelope:
    """The canal's keel walls lie 30 m to port and 40 m to starboard: its middle 5 m to starboard."""
    attrs = {"wall_port": 30.0, "wall_starboard": 40.0}
    angles = {"rudder": rudder, "rudder_95": np.abs(rudder), **changed}
    return SafeEnvelope(
        asked(held, **angles).assign_attrs(attrs).assign(clear=("u", np.arange(4) < 3), clearance=("u", np.ones(4)))
    )


def test_the_largest_offset_is_one_whose_other_side_was_computed_too() -> None:
    whole = enveloped(SAFE, np.zeros((5, 4)))
    np.testing.assert_allclose(whole.largest_offset(), [20.0, 20.0, 20.0, math.nan])
    assert float(whole.largest_offset(5.0 * KNOT)) == 20.0
    to_starboard = SafeEnvelope(whole.data.isel(y=slice(1, None)))  # From 10 m to port to 20 m to starboard
    np.testing.assert_allclose(to_starboard.largest_offset(), [10.0, 10.0, 10.0, math.nan])


def test_rows_of_offsets_and_speeds_are_read_from_the_grid() -> None:
    """Safe at 4 and 6 knots, at the edges at 4 alone; at 10 m a better pilot holds it at 2 knots too."""
    held = at(0.5, (slice(None), 0), ([0, 4], 2))
    held[4] = 0.3  # at +20 m nowhere, and at +10 m at 2 knots more likely than not
    held[3, 0], held[3, 1] = 0.6, 0.9
    known = at(0.96, (3, slice(0, 3)), base=held)
    rudder = np.arange(20.0).reshape(5, 4) / 40
    found = enveloped(held, rudder, known=known)
    nowhere = math.nan
    np.testing.assert_allclose(found.highest_speed() / KNOT, [4, 6, 6, 6, nowhere])
    np.testing.assert_allclose(found.lowest_speed() / KNOT, [4, 4, 4, 6, nowhere])
    assert float(found.highest_speed(-15.0)) / KNOT == pytest.approx(5.0)
    rows = found.offset_rows()
    assert [row["offset"] for row in rows] == Y.tolist()
    # The rudder at the highest safe speed: columns 1, 2, 2, 2; at +20 m nothing is likely: that of the lowest.
    np.testing.assert_allclose([row["rudder"] for row in rows], np.degrees(rudder[range(5), [1, 2, 2, 2, 0]]))
    np.testing.assert_allclose([row["rudder_95"] for row in rows], [row["rudder"] for row in rows])
    np.testing.assert_allclose([row["held"] for row in rows], [1, 1, 1, 1, 0.3])
    np.testing.assert_allclose([row["highest_speed"] for row in rows], [4, 6, 6, 6, nowhere])
    np.testing.assert_allclose([row["lowest_speed"] for row in rows], [4, 4, 4, 6, nowhere])
    np.testing.assert_allclose([row["highest_speed_median"] for row in rows], [6, 6, 6, 6, nowhere])
    np.testing.assert_allclose([row["highest_speed_known"] for row in rows], [4, 6, 6, 6, nowhere])
    # Above the safe speeds: at -20 m a steady rudder over half of 0.7 rad; 8 knots is not clear; below all, at +20 m.
    assert found.limited_by() == ["the disturbance", "the keel", "the keel", "the keel", "the disturbance"]
    likely = enveloped(held, rudder, rudder_likely=0.36 * SAFE, certain=at(1.0, (4, 0), base=0 * SAFE))
    assert likely.limited_by() == ["the rudder", "the keel", "the keel", "the keel", "uncertain coefficients"]
    speeds = found.speed_rows()
    np.testing.assert_allclose([row["speed"] for row in speeds], [2, 4, 6, 8])
    assert [row["keel_clear"] for row in speeds] == [True, True, True, False]


RULES = SimpleNamespace(
    rows=lambda: [
        {"rule": "A", "width": 60.0, "port": -12.0, "starboard": 15.0, "slowest": 0.0, "fastest": 5.0, **NO_LIMITS},
        {"rule": "A", "width": 50.0, "port": -9.0, "starboard": 15.0, "slowest": 5.0, "fastest": None, **NO_LIMITS},
        {"rule": "B", "width": 90.0, "port": None, "starboard": None, "slowest": 0.0, "fastest": 3.9, **NO_LIMITS},
        {"rule": "C", "width": None, "rudder": 5.0, "speed_limit": None, "standing": "checked in the source"},
        {"rule": "D", "width": None, "rudder": None, "speed_limit": 5.9, "standing": "checked in the source"},
        {"rule": "E", "width": None, "rudder": None, "speed_limit": 6.1, "standing": "checked in the source"},
    ]
)
NO_LIMITS = {"rudder": None, "speed_limit": None, "standing": "checked in the source"}


def test_rules_are_exceeded_where_the_envelope_is_safe_beyond_them() -> None:
    """Safe up to 6 knots; at 2 knots to 10 m on either side, at 4 and 6 to 20 m to port."""
    held = at(0.0, ([0, 4], 0), (slice(3, 5), slice(1, 3)))
    rudder = np.radians([7.0, 3.0, 0.0, -3.0, -8.0])[:, None] * SAFE
    data = enveloped(held, rudder).data
    (bolder,) = exceeded_rules(data, RULES, 0.95)
    # A: by 8 m at 4 knots, by 11 m at 6 knots; B: at 2 knots to 10 m on either side, where it leaves nothing.
    assert bolder.startswith("The envelope exceeds A, B, C, D: ")
    assert exceeded_rules(enveloped(0.9 * SAFE, rudder).data, RULES, 0.95) == []
    narrow = enveloped(at(0.0, ([0, 1, 3, 4], slice(None)), (slice(None), [1, 2, 3])), rudder).data
    (only,) = exceeded_rules(narrow, RULES, 0.95)
    assert only.startswith("The envelope exceeds B: ")


def test_tests_cover_what_is_nearer_to_the_middle_and_between_their_speeds() -> None:
    model = nw.published("estimated_kcs")
    tested = replace(
        model.data_range, speed=(2.0, 4.0), abs_y=(20.0, 50.0), depth_to_draft=(1, 9), width_to_beam=(1, 99)
    )
    known = replace(model, data_range=tested)
    found = data_coverage(known, np.array([-51.0, -50.0, 0.0, 50.0, 51.0]), np.array([1.9, 2.0, 4.0, 4.1]))
    rows, columns = np.array([0, 1, 1, 1, 0]), np.array([0, 1, 1, 0])
    np.testing.assert_array_equal(found, np.outer(rows, columns) > 0)
    for name in ("abs_y", "speed", "width_to_beam", "depth_to_draft"):
        less = replace(known, data_range=replace(tested, **{name: None}))
        assert not data_coverage(less, np.zeros(1), np.array([3.0])).any()
    dry = replace(known.configuration, canal=replace(known.configuration.canal, depth=None))
    assert not data_coverage(replace(known, configuration=dry), np.zeros(1), np.array([3.0])).any()
    assert [note.split()[3] for note in beyond_tests(known, np.array([-51.0, 0.0]), np.array([3.0]))] == ["offset"]
    assert beyond_tests(known, np.array([-49.0, 0.0]), np.array([3.0])) == ()


def test_a_row_along_a_waterway_has_the_highest_speed_and_the_widest_offsets() -> None:
    """Ranges up to 8 knots at two offsets, from 4 knots at one of them; at 6 knots it is widest, 0.95 crossed."""
    held = at(0.5, ([0, 4], slice(None)), (1, 0), (2, 3), (3, [0, 3]))
    held[0, 2] = 0.75  # a fifth of the way from -10 to -20 m
    found = SafeEnvelope(asked(held).assign_attrs(wall_port=30.0, wall_starboard=40.0))
    row = _row(100.0, 120.0, 7.0, found)
    assert (row["distance"], row["computed_at"], row["port_bank"], row["starboard_bank"]) == (100.0, 120.0, -23.0, 47.0)
    expected = {"lowest_speed": 4.0, "highest_speed": 8.0, "at_speed": 6.0, "port": 7.0 - 12.0, "starboard": 7.0 + 11.0}
    for suffix in ("", "_by_model"):
        assert {name: row[f"{name}{suffix}"] for name in expected} == pytest.approx(expected)
    assert row["limited_by"] == "the disturbance"  # in the middle, above 6 knots
    untested = _row(0.0, 0.0, 0.0, SafeEnvelope(found.data.assign(tested=(("y", "u"), held < 0))))
    assert all(math.isnan(untested[name]) for name in expected)
    assert untested["highest_speed_by_model"] == pytest.approx(8.0)
