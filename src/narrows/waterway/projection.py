"""Longitude and latitude to metres about an origin of their own, and back."""

from functools import lru_cache
from typing import Any

import numpy as np

from narrows.errors import InputError

# Latitude [deg] beyond which the mean of longitudes is no place near the line.
NORTHMOST = 89.0


def origin_of(points: np.ndarray) -> np.ndarray:
    """Return the middle of a line, (2,): longitude and latitude [deg], across the antimeridian too."""
    # points (n, 2) [deg]
    if np.abs(points[:, 1]).max() > NORTHMOST:
        raise InputError("the centreline comes within a degree of a pole, where there is no east; draw it elsewhere")
    longitude = np.unwrap(points[:, 0], period=360).mean()
    return np.array([(longitude + 180) % 360 - 180, points[:, 1].mean()])


def projected(points: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Project longitude and latitude to metres east and north of an origin, true to scale near it."""
    # points (n, 2) [deg]; origin (2,) [deg]
    east, north = _projection(*origin.tolist()).transform(points[:, 0], points[:, 1])
    return np.stack([east, north], axis=1)


def unprojected(points: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Return longitude and latitude of metres east and north of an origin, longitude from -180 to 180."""
    # points (n, 2) [m]; origin (2,) [deg]
    longitude, latitude = _projection(*origin.tolist()).transform(points[:, 0], points[:, 1], direction="INVERSE")
    return np.stack([longitude, latitude], axis=1)


@lru_cache(maxsize=8)  # A transformer takes longer to make than thousands of points to bring over.
def _projection(longitude: float, latitude: float) -> Any:
    from pyproj import Transformer

    local = f"+proj=tmerc +lon_0={longitude} +lat_0={latitude} +k=1 +datum=WGS84 +units=m"
    return Transformer.from_crs("OGC:CRS84", local, always_xy=True)
