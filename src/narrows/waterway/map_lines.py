"""Lines of a map as people have them: projected, of other programs, roles in other words, two banks alone."""

import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from narrows.base.errors import InputError, needs
from narrows.waterway.centreline import Centreline, along_chords, chords

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


@np.errstate(all="ignore")  # no place on earth
def _forward(latitude: np.ndarray, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Northing from the equator and easting from the meridian [m]; infinite where undefined, NaN stays NaN."""
    tangent = _conformal(np.tan(latitude))
    north, east = np.arctan2(tangent, np.cos(turn)), np.arcsinh(np.sin(turn) / np.hypot(tangent, np.cos(turn)))
    zeta, beyond = north + 1j * east, (np.abs(east) > WIDEST) | (np.abs(latitude) > np.pi / 2)
    place = _RADIUS * (zeta + _waves(zeta, _ALPHA))
    return np.where(beyond, np.inf, place.real), np.where(beyond, np.inf, place.imag)


@np.errstate(all="ignore")
def _inverse(north: np.ndarray, east: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Latitude and longitude from the meridian [rad]; infinite where undefined, NaN stays NaN."""
    zeta, beyond = (north + 1j * east) / _RADIUS, np.abs(east) > WIDEST * _RADIUS
    sphere = zeta - _waves(zeta, _BETA)
    wanted = np.sin(sphere.real) / np.hypot(np.sinh(sphere.imag), np.cos(sphere.real))
    tangent = wanted / (1 - _E2)
    for _ in range(3):  # Newton's method; Karney finds that two steps reach the last digit.
        miss = wanted - _conformal(tangent)
        slope = np.hypot(1, _conformal(tangent)) * np.hypot(1, tangent) * (1 - _E2)
        tangent = tangent + miss * (1 + (1 - _E2) * tangent**2) / slope
    turn = np.arctan2(np.sinh(sphere.imag), np.cos(sphere.real))
    return np.where(beyond, np.inf, np.arctan(tangent)), np.where(beyond, np.inf, turn)


def _conformal(tangent: np.ndarray) -> np.ndarray:
    """Tangent of the conformal latitude from that of the latitude (eq. 7 to 9)."""
    secant = np.hypot(1, tangent)
    stretch = np.sinh(_E * np.arctanh(_E * tangent / secant))
    return np.asarray(tangent * np.hypot(1, stretch) - stretch * secant)


ROLES = ("centreline", "starboard", "port")
# Properties that may name a line's role, and roles without "bank" and "line".
SAID_IN = ("role", "side", "bank", "name", "type", "title", "label")
WORDS = {
    "centreline": ("centre", "center", "axis", "middle", "fairway", "centreline", "centerline"),
    "starboard": ("starboard", "right"), "port": ("port", "left"),
}  # fmt: skip
# Files that GDAL reads besides GeoJSON.
OTHERS = (".kml", ".shp", ".gpkg", ".gml", ".fgb", ".gpx")
# Coordinate systems in degrees that equal WGS84 within a metre, and first codes of UTM zones: WGS84 north and south,
# ETRS89.
IN_DEGREES = ("CRS84", "4326", "4258")
UTM = {326: False, 327: True, 258: False}
# Iterations of a line between banks towards the middle, and its points per width of the waterway [1].
ROUNDS, POINTS_A_WIDTH = 20, 1.0
# Distance between the ends of two pieces of a line [deg]: a metre.
TOUCHING = 1e-5


class Feature(NamedTuple):
    properties: Mapping[str, Any]  # As given; in a waterway with keys in lower case
    geometry: Mapping[str, Any]  # As given

    @property
    def role(self) -> str | None:
        """Return the role of a line in a waterway, from any property that names it."""
        said = {key: value for key, value in self.properties.items() if isinstance(value, str)}
        for key in SAID_IN:
            words = re.sub(r"\b(bank|line)\b|[_-]", " ", said.get(key, "").lower()).split()
            found = next((role for role, meant in WORDS.items() if " ".join(words) in meant), None)
            if found:
                return found
        return None


# Properties, and a Shapely geometry of one piece.
Shape = tuple[Mapping[str, Any], Any]


def gdal(path: Path, what: str) -> Any:
    """Return the library that reads maps and charts, if it and the file exist."""
    with needs("charts", what):
        import pyogrio
        import pyogrio.errors
        import shapely  # noqa: F401
    if not path.is_file():
        raise InputError(f"{path}: cannot be read (no such file); check the path")
    return pyogrio


def read_layer(pyogrio: Any, path: Path, layer: str, **options: Any) -> tuple[str, list[Shape]]:
    """Return the coordinate system of a layer, and its shapes, each of one piece, with their properties."""
    import shapely

    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Attributes .* ignored", RuntimeWarning)
        meta, _, shapes, columns = pyogrio.raw.read(path, layer=layer, **options)
    fields = [dict(zip(map(str, meta["fields"]), row, strict=True)) for row in zip(*columns, strict=True)]
    parts, whose = shapely.get_parts(shapely.from_wkb(shapes), return_index=True)
    pieces = zip(parts, whose.tolist(), strict=True)
    return str(meta["crs"] or "CRS84"), [(fields[i] if fields else {}, part) for part, i in pieces if not part.is_empty]


def read_other(path: Path) -> list[Feature]:
    """Read the lines and areas of a file that GDAL supports, in degrees."""
    pyogrio, features = gdal(path, f"a {path.suffix} file"), []
    import shapely

    try:
        for layer in pyogrio.list_layers(path)[:, 0]:
            crs, parts = read_layer(pyogrio, path, str(layer))
            turned = into_degrees(crs, str(path)) if parts else dict
            features += [Feature(own, turned(shapely.geometry.mapping(part))) for own, part in parts]
    except pyogrio.errors.DataSourceError as error:
        raise InputError(f"{path}: cannot be read as a map ({str(error).split(';')[0]}); save it as GeoJSON") from None
    return features


def joined(features: list[Feature]) -> list[Feature]:
    """Return features whose lines of one role are put together where their ends touch."""
    whole: list[Feature] = []
    for feature in features:
        piece = feature
        while other := next((one for one in whole if _one_line(one, piece)), None):
            whole.remove(other)
            piece = Feature(other.properties, {"type": "LineString", "coordinates": _one_line(other, piece)})
        whole.append(piece)
    return whole


def _one_line(first: Feature, second: Feature) -> list[Any]:
    """Points of two lines of one role of which the ends touch, else none."""
    lines = [one.geometry.get("coordinates") for one in (first, second) if one.geometry.get("type") == "LineString"]
    if len(lines) < 2 or first.role != second.role or not all(isinstance(line, list) and line for line in lines):
        return []
    a, b = (list(line or ()) for line in lines)
    for one, other in ((a, b), (b, a), (a, b[::-1]), (a[::-1], b)):
        with suppress(TypeError, IndexError):
            if max(abs(one[-1][axis] - other[0][axis]) for axis in (0, 1)) < TOUCHING:
                return one + other[1:]
    return []


def into_degrees(crs: str, path: str) -> Callable[[Mapping[str, Any]], dict[str, Any]]:
    """Return a function that converts degrees or UTM to longitude and latitude."""
    code = re.search(r"EPSG\D{0,4}(\d{4,5})", crs)
    zone = divmod(int(code[1]), 100) if code else (0, 0)
    plain = any(known in crs for known in IN_DEGREES)
    if not plain and not (zone[0] in UTM and 1 <= zone[1] <= 60):
        raise InputError(f"{path}: its coordinates are in {crs[:80]}; convert them to WGS84 (EPSG:4326) or UTM")

    def turned(point: Any) -> list[float]:
        return list(point) if plain else from_utm(point[0], point[1], zone[1], UTM[zone[0]]).tolist()

    def lists(items: Any) -> Any:
        if isinstance(items, list | tuple) and items and isinstance(items[0], int | float):
            return turned(items)
        return [lists(item) for item in items] if isinstance(items, list | tuple) else items

    return lambda geometry: {**geometry, "coordinates": lists(geometry.get("coordinates"))}


def roles_by_place(lines: Sequence[np.ndarray]) -> tuple[str, ...] | None:
    """Return the roles of two or three lines [m] by their position, None if it is ambiguous.

    The middle one of three lines is the centreline; the direction is that of the centreline, or of the first of
    two banks.
    """
    if len(lines) == 2:
        # The other bank lies to one side of the first.
        side = _side(lines[0], lines[1])
        return None if not side else ("port", "starboard") if side > 0 else ("starboard", "port")
    for middle in range(len(lines)) if len(lines) == 3 else ():
        sides = {other: _side(lines[middle], lines[other]) for other in range(3) if other != middle}
        if sorted(sides.values()) == [-1.0, 1.0]:
            return tuple({0.0: "centreline", 1.0: "starboard", -1.0: "port"}[sides.get(n, 0.0)] for n in range(3))
    return None


def _side(line: np.ndarray, other: np.ndarray) -> float:
    """Return 1 if all of another line is to starboard, -1 if to port, 0 if on both sides."""
    sides = np.sign(Centreline(line).locate(other)[1])
    return float(sides[0]) if (sides == sides[0]).all() else 0.0


def check_sides(lines: Mapping[str, np.ndarray]) -> None:
    """Raise if both banks lie on the wrong side: their roles are exchanged, or the whole map is mirrored."""
    line = Centreline(lines["centreline"])
    if np.median(line.locate(lines["starboard"])[1]) < 0 < np.median(line.locate(lines["port"])[1]):
        raise InputError(
            "each bank lies on the side of the other as one sails along the centreline; exchange their roles, turn the "
            "centreline round, or, where the file has latitude first, put longitude before latitude"
        )


def middle_line(starboard: np.ndarray, port: np.ndarray) -> np.ndarray:
    """Return points midway between two banks, in the direction that has the given one to starboard, (n, 2) [m]."""
    if np.linalg.norm(starboard[0] - port[0]) > np.linalg.norm(starboard[0] - port[-1]):
        port = port[::-1]
    reach = min(chords(bank)[-1] for bank in (starboard, port))
    width = float(np.median([np.linalg.norm(_nearest(port, point[None])[0] - point) for point in starboard]))
    share = np.linspace(0, 1, max(2, int(POINTS_A_WIDTH * reach / max(width, 1e-9)) + 1))
    points = (along_chords(starboard, share) + along_chords(port, share)) / 2
    for _ in range(ROUNDS if len(points) > 2 else 0):
        midway = (_nearest(starboard, points) + _nearest(port, points)) / 2
        points = np.concatenate([points[:1], midway[1:-1], points[-1:]])
        points = along_chords(points, share)
    ahead, across = points[-1] - points[0], starboard.mean(axis=0) - port.mean(axis=0)
    return np.asarray(points if ahead[1] * across[0] - ahead[0] * across[1] > 0 else points[::-1])


def _nearest(bank: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The nearest places on a polyline to points, (n, 2)."""
    start, way = bank[:-1], np.diff(bank, axis=0)
    apart = points[:, None] - start
    share = np.clip((apart * way).sum(axis=2) / np.maximum((way**2).sum(axis=1), 1e-300), 0, 1)
    places = start + share[..., None] * way
    best = np.linalg.norm(points[:, None] - places, axis=2).argmin(axis=1)
    return np.asarray(places[np.arange(len(points)), best])
