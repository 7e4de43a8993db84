"""Banks by their own lines: where the normals of a centreline meet them first, beside Shapely's rays."""

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from strategies import numbers

import narrows as nw
from narrows.waterway import Centreline
from narrows.waterway.banks import bank_from_points
from nightly import draws

SIGN = {"starboard": 1, "port": -1}


def meander(amplitude: float = 150.0, points: int = 60) -> Centreline:
    """20 km northward, a kilometre or more in its bends."""
    t = np.linspace(0, 20_000, points)
    return Centreline(np.stack([amplitude * np.sin(t / 400 / np.pi), t], axis=1))


@given(pieces=st.integers(1, 300), side=st.sampled_from(sorted(SIGN)), back=st.booleans())
def test_a_straight_bank_beside_a_meander_by_hand(pieces: int, side: str, back: bool) -> None:
    """By two points or by any number, in either direction: what is left of 200 m to the side, along the normal."""
    line, sign = meander(40.0), SIGN[side]
    points = np.stack([np.full(pieces + 1, sign * 200.0), np.linspace(-100, 20_100, pieces + 1)], axis=1)
    bank = bank_from_points(side, points[::-1] if back else points, line)
    s = np.linspace(0, line.length, 1001)
    (east, _), heading = line.at(s).T, line.heading(s)
    np.testing.assert_allclose(bank.at(s), (200 - sign * east) / np.cos(heading), rtol=1e-10)


def first_met(line: Centreline, s: float, sign: int, points: np.ndarray) -> float:
    shapely = pytest.importorskip("shapely")
    ray = shapely.LineString(line.at([s, s], [0.0, sign * 1e5]))
    return float(shapely.Point(line.at(s)).distance(ray.intersection(shapely.LineString(points))))


@given(seed=st.integers(0, 10**6), side=st.sampled_from(sorted(SIGN)))
@settings(max_examples=draws(30))
def test_any_bank_is_where_a_ray_meets_it_first(seed: int, side: str) -> None:
    draw, sign = np.random.default_rng(seed), SIGN[side]
    line = meander(draw.uniform(0, 60), int(draw.integers(20, 80)))
    s = np.sort(draw.uniform(0, line.length, int(draw.integers(2, 80))))
    s[[0, -1]] = -150, line.length + 150
    points = line.at(s, sign * draw.uniform(50, 300, len(s)))
    try:
        bank = bank_from_points(side, points, line)
    except nw.InputError:
        reject()  # its chords cross the line, or its ends have changed places with others
    for place in draw.uniform(bank.s[0], bank.s[-1], 40):
        assert float(bank.at(place)) == pytest.approx(first_met(line, place, sign, points), rel=1e-7)


@given(scale=numbers(1e-3, 10), shift=numbers(-1e6, 1e6), n=numbers(20, 200))
def test_a_bank_is_as_far_off_anywhere_and_at_any_size(scale: float, shift: float, n: float) -> None:
    """A bank drawn through points on the normals is as far off there, at model scale and in coordinates of a grid."""
    line = Centreline(scale * (meander(40.0, 30).points + shift))
    s = np.linspace(0, line.length, 200)
    bank = bank_from_points("port", line.at(s, -scale * n * (1.2 + np.sin(np.arange(200)))), line)
    np.testing.assert_allclose(bank.at(s)[1:-1], (scale * n * (1.2 + np.sin(np.arange(200))))[1:-1], rtol=1e-5)


def test_a_bank_that_crosses_itself_is_met_first_to_the_samples_of_the_line() -> None:
    line = Centreline(np.array([[0.0, 0.0], [0.0, 1000.0]]))
    loop = np.array([(50, -10), (50, 400), (90, 600), (30, 600), (70, 400), (70, 1010)], float)
    bank, s = bank_from_points("starboard", loop, line), np.array([100.0, 430.0, 470.0, 530.0, 570.0, 900.0])
    np.testing.assert_allclose(bank.at(s), [first_met(line, place, 1, loop) for place in s])


def test_a_niche_is_hidden_behind_its_entrance() -> None:
    """A basin wider than its mouth: what is met first is the quay beside the mouth, and its far wall through it."""
    line = Centreline(np.array([[0.0, 0.0], [0.0, 1000.0]]))
    mouth = [
        (50, -10),
        (50, 450),
        (80, 450),
        (80, 300),
        (150, 300),
        (150, 700),
        (80, 700),
        (80, 550),
        (50, 550),
        (50, 1010),
    ]
    bank = bank_from_points("starboard", np.array(mouth, float), line)
    np.testing.assert_allclose(
        bank.at([10.0, 320.0, 449.0, 451.0, 549.0, 551.0, 990.0]), [50, 50, 50, 150, 150, 50, 50]
    )


STRAIGHT = np.array([[0.0, 0.0], [0.0, 1000.0]])


@pytest.mark.parametrize(
    ("line", "points", "said"),
    [
        (STRAIGHT, [[50, -10], [-50, 1010]], r"starboard bank crosses the centreline at 5\d\d m"),
        (STRAIGHT, [[50, -10], [50, 300], [-1, 301], [50, 302], [50, 1010]], r"crosses the centreline at 301 m"),
        (STRAIGHT, [[50, 100], [50, 1010]], "no starboard bank at 0 m along a centreline of 1000 m; draw it"),
        (STRAIGHT, [[50, 1100], [50, 1200]], "no starboard bank at 0 m along a centreline"),
        (STRAIGHT, [[50, 500]], "needs two points or more"),
        (STRAIGHT, [[50, 500], [50, 500]], "needs two points or more"),
        (STRAIGHT, [[50, 500], [50, float("nan")]], "needs two points or more"),
        (STRAIGHT, [50, 500], "needs two points or more"),
    ],
)
def test_banks_that_cannot_be_are_named_with_their_place(line: np.ndarray, points: list, said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        bank_from_points("starboard", np.array(points, float), Centreline(line))
