"""The parts of a safe envelope by hand: areas, edges, causes; nothing is sailed here."""

import math
from itertools import combinations

import numpy as np
import pytest
import xarray as xr

from narrows.safety import headline
from narrows.safety.headline import cause, crossing, largest_block, runs
from narrows.safety.request import wind_force
from narrows.safety.result import IN_KNOTS


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
        ({"clear": False, "driven": False}, "ENGINE"), ({"clear": False, "clearance": math.nan}, "CHOKED"),
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
