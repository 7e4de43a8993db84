"""Signals of a table's rows by hand: midship by an antenna's place, velocities by fixed axes, times that are late."""

import math

import numpy as np
import pytest

import narrows as nw
from narrows.logbook.reading.log_rows import RawRecord, log_mapping

T = np.array([0.0, 1.0, 2.0, 3.0])
PSI = np.array([0.0, 0.3, math.pi / 2, 2.0])


def record(
    mapping: dict[str, object] | None = None, waterway: nw.Waterway | None = None, **columns: np.ndarray
) -> nw.ShipRecord:
    return RawRecord("A", T, columns, log_mapping(mapping), waterway, "a table").record()


ANTENNA = {"antenna": {"forward": 30.0, "starboard": -4.0}}


@pytest.mark.parametrize("names", [("x", "y"), ("north", "east")])
def test_a_place_of_the_antenna_becomes_that_of_midship(names: tuple[str, str]) -> None:
    """Midship is 30 m astern of the antenna and 4 m to starboard of it, by the heading of each row."""
    x, y = np.array([100.0, 110.0, 120.0, 130.0]), np.array([5.0, 6.0, 7.0, 8.0])
    told = record(ANTENNA, **dict(zip(names, (x, y), strict=True)), psi=PSI)
    np.testing.assert_allclose(told["x"].values, x - 30.0 * np.cos(PSI) - 4.0 * np.sin(PSI))
    np.testing.assert_allclose(told["y"].values, y - 30.0 * np.sin(PSI) + 4.0 * np.cos(PSI))
    assert told.antenna == (0.0, 0.0)
    without = record(ANTENNA, x=x, y=y)
    np.testing.assert_array_equal(without["x"].values, x)
    assert without.antenna == (30.0, -4.0)


@pytest.mark.parametrize("names", [("x_rate", "y_rate"), ("north_rate", "east_rate")])
def test_velocities_in_fixed_axes_become_those_of_midship_along_and_across(names: tuple[str, str]) -> None:
    """A point 30 m forward and 4 m to port of a ship that turns moves across by 30 r and along by 4 r besides."""
    north, east, r = np.array([4.0, 4.0, 1.0, -1.0]), np.array([0.5, 2.0, 3.0, 4.0]), np.full(4, 0.01)
    along, across = north * np.cos(PSI) + east * np.sin(PSI), east * np.cos(PSI) - north * np.sin(PSI)
    rates = dict(zip(names, (north, east), strict=True))
    still = record(None, **rates, psi=PSI, r=r)
    np.testing.assert_allclose([still["u_ground"].values, still["v_ground"].values], [along, across], atol=1e-12)
    moved = record(ANTENNA, **rates, psi=PSI, r=r)
    np.testing.assert_allclose(moved["u_ground"].values, along - 4.0 * 0.01)
    np.testing.assert_allclose(moved["v_ground"].values, across - 30.0 * 0.01)
    unknown = record(ANTENNA, **rates, psi=PSI)
    np.testing.assert_allclose(unknown["u_ground"].values, along)
    with pytest.raises(nw.InputError, match="need the heading"):
        record(None, **rates)


def test_a_late_column_is_of_an_earlier_time() -> None:
    told = record({"late": {"r": 0.4}}, r=np.arange(4.0), psi=PSI)
    np.testing.assert_allclose(told["r"].t, T - 0.4)
    np.testing.assert_allclose(told["psi"].t, T)


def test_values_of_one_time_are_one_by_their_mean_and_nothing_is_between() -> None:
    raw = RawRecord(
        "A", np.array([0.0, 0.0, 0.0, 2.0]), {"u": np.array([1.0, 3.0, np.nan, 7.0])}, log_mapping(None), None, ""
    )
    told = raw.record()["u"]
    assert (told.t.tolist(), told.values.tolist()) == ([0.0, 2.0], [2.0, 7.0])


def test_directions_are_without_jumps_and_begin_within_half_a_turn_of_the_axis() -> None:
    """Headings of 350, 355, 5 and 15 degrees from north are -10, -5, 5 and 15; a course of three turns is none."""
    told = record(
        None, heading=np.radians([350.0, 355.0, 5.0, 15.0]), course=np.radians([1081.0, 1082.0, 1083.0, 1084.0])
    )
    np.testing.assert_allclose(np.degrees(told["psi"].values), [-10.0, -5.0, 5.0, 15.0], atol=1e-9)
    np.testing.assert_allclose(np.degrees(told["course"].values), [1.0, 2.0, 3.0, 4.0], atol=1e-9)


def test_directions_along_a_waterway_are_from_its_line() -> None:
    """A straight canal whose line lies at 30 degrees from north: headings and rates from the map lose them."""
    line = math.radians(30.0)
    s = np.array([0.0, 500.0, 1000.0])
    ends, half = np.array([0.0, 1000.0]), np.full(2, 50.0)
    way = nw.Waterway(
        nw.waterway.Centreline(np.stack([s * math.sin(line), s * math.cos(line)], axis=1)),
        nw.waterway.Bank("starboard", ends, half), nw.waterway.Bank("port", ends, half), (ends, np.full(2, 9.0)),
        name="canal",
    )  # fmt: skip
    x, y, heading = np.array([100.0, 104.0, 108.0, 112.0]), np.full(4, 6.0), line + np.array([0.0, 0.02, 0.04, 0.06])
    east, north = x * math.sin(line) + y * math.cos(line), x * math.cos(line) - y * math.sin(line)
    rates = {"north_rate": np.full(4, 4.0 * math.cos(line)), "east_rate": np.full(4, 4.0 * math.sin(line))}
    told = record(None, way, east=east, north=north, heading=heading, **rates)
    np.testing.assert_allclose(told["x"].values, x, atol=1e-6)
    np.testing.assert_allclose(told["y"].values, y, atol=1e-6)
    np.testing.assert_allclose(told["psi"].values, heading - line, atol=1e-9)
    np.testing.assert_allclose(told["u_ground"].values, 4.0 * np.cos(heading - line), atol=1e-9)
    np.testing.assert_allclose(told["v_ground"].values, -4.0 * np.sin(heading - line), atol=1e-9)
    with pytest.raises(nw.InputError, match="only where the position is known"):
        record(None, way, heading=heading)
