"""The projection of maps is the transverse Mercator projection of the WGS84 ellipsoid, as PROJ computes it."""

import numpy as np
import pytest
from hypothesis import example, given
from pyproj import Transformer
from strategies import numbers

from narrows.waterway.map_lines import projected, unprojected

QUARTER_MERIDIAN = 10_001_965.7293
"""From the equator to the pole of WGS84 [m]."""
SAME_PLACE = 2e-7
"""PROJ rounds the meridian to 15 digits, which is 5e-8 m."""
LATITUDES = numbers(-89, 89).map(lambda degrees: round(degrees, 9))
"""PROJ takes an origin 1e-11 degrees off the equator for one on it."""


def proj(origin: np.ndarray) -> Transformer:
    longitude, latitude = origin
    local = f"+proj=tmerc +lon_0={longitude} +lat_0={latitude} +k=1 +datum=WGS84 +units=m"
    return Transformer.from_crs("OGC:CRS84", local, always_xy=True)


def test_the_pole_is_a_quarter_meridian_from_the_equator() -> None:
    (place,) = projected(np.array([[7.0, 90.0]]), np.array([7.0, 0.0]))
    np.testing.assert_allclose(place, [0.0, QUARTER_MERIDIAN], atol=1e-4)


@given(longitude=numbers(-180, 180), latitude=LATITUDES, east=numbers(-50, 50), north=numbers(-50, 50))
@example(longitude=180.0, latitude=52.0, east=0.1, north=0.0)
@example(longitude=7.0, latitude=0.0, east=90.5, north=0.0)
def test_places_are_those_of_proj(longitude: float, latitude: float, east: float, north: float) -> None:
    origin = np.array([longitude, latitude])
    degrees = np.array([[longitude + east, np.clip(latitude + north, -89.9, 89.9)]])
    expected = np.stack(proj(origin).transform(*degrees.T), axis=1)
    np.testing.assert_allclose(projected(degrees, origin), expected, atol=SAME_PLACE)
    if np.isfinite(expected).all():
        back = unprojected(expected, origin)
        assert np.all(np.abs(back) <= [180.0, 90.0])
        np.testing.assert_allclose((back - degrees + 180) % 360 - 180, 0.0, atol=1e-9)


@pytest.mark.parametrize("place", [(np.nan, 0.0), (7.0, np.nan), (7.0, 91.0), (np.inf, 0.0), (97.0, 0.0)])
def test_no_place_on_earth_is_no_finite_number(place: tuple[float, float]) -> None:
    here = np.array([7.0, 0.0])
    assert not np.isfinite(projected(np.array([place]), here)).all()
    assert not np.isfinite(unprojected(np.array([[1e8, 0.0]]), here)).all()


def test_a_fix_that_is_missing_hides_no_other() -> None:
    fixes = np.array([[7.0, 52.0], [np.nan, np.nan], [7.01, 52.0]])
    places = projected(fixes, np.array([7.0, 52.0]))
    np.testing.assert_array_equal(np.isnan(places[:, 0]), [False, True, False])
