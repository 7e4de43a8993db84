"""Longitude and latitude to metres about a local origin, and back."""

import numpy as np

from narrows.errors import InputError

# Latitude [deg] beyond which the mean of longitudes is meaningless.
NORTHMOST = 89.0
# Semi-major axis [m] and flattening of the WGS84 ellipsoid.
EQUATOR_RADIUS, FLATTENING = 6378137.0, 1 / 298.257223563
# Easting, in rectifying radii, beyond which the series is not used: 150 degrees off the meridian at the equator (PROJ).
WIDEST = 2.623395162778


def origin_of(points: np.ndarray) -> np.ndarray:
    """Return the middle of a line, (2,): longitude and latitude [deg], across the antimeridian too."""
    # points (n, 2) [deg]
    if np.abs(points[:, 1]).max() > NORTHMOST:
        raise InputError("the centreline comes within a degree of a pole, where there is no east; draw it elsewhere")
    longitude = np.unwrap(points[:, 0], period=360).mean()
    return np.array([(longitude + 180) % 360 - 180, points[:, 1].mean()])


def projected(points: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Project longitude and latitude to metres east and north of an origin, with true scale near it."""
    # points (n, 2) [deg], WGS84; origin (2,) [deg]
    with np.errstate(invalid="ignore"):  # infinite degrees
        turn = np.radians((points[:, 0] - origin[0] + 180) % 360 - 180)
    north, east = _forward(np.radians(points[:, 1]), turn)
    return np.stack([east, north - _foot(origin)], axis=1)


def unprojected(points: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Return longitude and latitude [deg] of metres east and north of an origin, longitude from -180 to 180."""
    # points (n, 2) [m]; origin (2,) [deg]
    latitude, turn = _inverse(points[:, 1] + _foot(origin), points[:, 0])
    with np.errstate(invalid="ignore"):  # no place on earth
        return np.stack([(origin[0] + np.degrees(turn) + 180) % 360 - 180, np.degrees(latitude)], axis=1)


def from_utm(east: float, north: float, zone: int, south: bool) -> np.ndarray:
    """Return longitude and latitude [deg] of a place in a zone of UTM [m]. Source: EPSG guidance note 7-2."""
    latitude, turn = _inverse(np.array([(north - 1e7 * south) / 0.9996]), np.array([(east - 5e5) / 0.9996]))
    return np.array([6.0 * zone - 183.0 + np.degrees(turn[0]), np.degrees(latitude[0])])


# Transverse Mercator by Krueger's series to the sixth order of the third flattening n, after C. F. F. Karney,
# Transverse Mercator with an accuracy of a few nanometers, J. Geodesy 85 (2011), eq. 7 to 26, 35 and 36.
_N = FLATTENING / (2 - FLATTENING)
_E2 = FLATTENING * (2 - FLATTENING)
_E = _E2**0.5
_RADIUS = EQUATOR_RADIUS / (1 + _N) * (1 + _N**2 / 4 + _N**4 / 64 + _N**6 / 256)
_POWERS = _N ** np.arange(1, 7)
# Row j has the coefficients of n to n^6 in the term sin(2 j zeta), j from 1.
_ALPHA = _POWERS @ np.array([
    [1/2, -2/3, 5/16, 41/180, -127/288, 7891/37800],
    [0, 13/48, -3/5, 557/1440, 281/630, -1983433/1935360],
    [0, 0, 61/240, -103/140, 15061/26880, 167603/181440],
    [0, 0, 0, 49561/161280, -179/168, 6601661/7257600],
    [0, 0, 0, 0, 34729/80640, -3418889/1995840],
    [0, 0, 0, 0, 0, 212378941/319334400],
]).T  # fmt: skip
_BETA = _POWERS @ np.array([
    [1/2, -2/3, 37/96, -1/360, -81/512, 96199/604800],
    [0, 1/48, 1/15, -437/1440, 46/105, -1118711/3870720],
    [0, 0, 17/480, -37/840, -209/4480, 5569/90720],
    [0, 0, 0, 4397/161280, -11/504, -830251/7257600],
    [0, 0, 0, 0, 4583/161280, -108847/3991680],
    [0, 0, 0, 0, 0, 20648693/638668800],
]).T  # fmt: skip


def _waves(zeta: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return np.asarray(np.sin(2 * np.multiply.outer(zeta, np.arange(1, 7))) @ weights)


def _foot(origin: np.ndarray) -> float:
    """Northing of the origin from the equator [m]."""
    return float(_forward(np.radians(origin[1:]), np.zeros(1))[0][0])


def _forward(latitude: np.ndarray, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Northing from the equator and easting from the meridian [m]; infinite where undefined, NaN stays NaN."""
    tangent = _conformal(np.tan(latitude))
    north, east = np.arctan2(tangent, np.cos(turn)), np.arcsinh(np.sin(turn) / np.hypot(tangent, np.cos(turn)))
    zeta, beyond = _zeta(north, east, (np.abs(east) > WIDEST) | (np.abs(latitude) > np.pi / 2))
    place = _RADIUS * (zeta + _waves(zeta, _ALPHA))
    return np.where(beyond, np.inf, place.real), np.where(beyond, np.inf, place.imag)


def _inverse(north: np.ndarray, east: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Latitude and longitude from the meridian [rad]; infinite where undefined, NaN stays NaN."""
    zeta, beyond = _zeta(north / _RADIUS, east / _RADIUS, np.abs(east) > WIDEST * _RADIUS)
    sphere = zeta - _waves(zeta, _BETA)
    wanted = np.sin(sphere.real) / np.hypot(np.sinh(sphere.imag), np.cos(sphere.real))
    tangent = wanted / (1 - _E2)
    for _ in range(3):  # Newton's method; Karney finds that two steps reach the last digit.
        miss = wanted - _conformal(tangent)
        slope = np.hypot(1, _conformal(tangent)) * np.hypot(1, tangent) * (1 - _E2)
        tangent = tangent + miss * (1 + (1 - _E2) * tangent**2) / slope
    turn = np.arctan2(np.sinh(sphere.imag), np.cos(sphere.real))
    return np.where(beyond, np.inf, np.arctan(tangent)), np.where(beyond, np.inf, turn)


def _zeta(north: np.ndarray, east: np.ndarray, beyond: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Northing + i easting in rectifying radii, 0 beyond the range of the series; and a mask of those."""
    zeta = np.empty(len(north), complex)
    zeta.real, zeta.imag = np.where(beyond, 0, north), np.where(beyond, 0, east)
    return zeta, beyond


def _conformal(tangent: np.ndarray) -> np.ndarray:
    """Tangent of the conformal latitude from that of the latitude (eq. 7 to 9)."""
    secant = np.hypot(1, tangent)
    stretch = np.sinh(_E * np.arctanh(_E * tangent / secant))
    return np.asarray(tangent * np.hypot(1, stretch) - stretch * secant)
