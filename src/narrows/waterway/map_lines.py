"""Lines of maps and charts as people have them: projected, of other programs, roles in other words, in chart cells."""

import json
import re
import warnings
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from narrows.base.errors import InputError, needs
from narrows.waterway.banks import SIGNS, Normals, bank_from_points, seen_pieces
from narrows.waterway.centreline import Centreline
from narrows.waterway.waterway import Waterway

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


# Transverse Mercator by Krueger's series to the sixth order of the third flattening n, after C. F. F. Karney,
# Transverse Mercator with an accuracy of a few nanometers, J. Geodesy 85 (2011), eq. 7 to 11 and 35;
# its inverse by fixed points, each round of which gains 2.8 digits near the meridian and 2.2 of the latitude.
_N = FLATTENING / (2 - FLATTENING)
_E = (FLATTENING * (2 - FLATTENING)) ** 0.5
SERIES_ROUNDS, LATITUDE_ROUNDS = 12, 8
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


def _waves(zeta: np.ndarray) -> np.ndarray:
    return np.asarray(np.sin(2 * np.multiply.outer(zeta, np.arange(1, 7))) @ _ALPHA)


def _foot(origin: np.ndarray) -> float:
    """Northing of the origin from the equator [m]."""
    return float(_forward(np.radians(origin[1:]), np.zeros(1))[0][0])


@np.errstate(all="ignore")  # no place on earth
def _forward(latitude: np.ndarray, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Northing from the equator and easting from the meridian [m]; infinite where undefined, NaN stays NaN."""
    # Tangent of the conformal latitude (eq. 7 to 9)
    tangent = np.sinh(np.arcsinh(np.tan(latitude)) - _E * np.arctanh(_E * np.sin(latitude)))
    north, east = np.arctan2(tangent, np.cos(turn)), np.arcsinh(np.sin(turn) / np.hypot(tangent, np.cos(turn)))
    zeta, beyond = north + 1j * east, (np.abs(east) > WIDEST) | (np.abs(latitude) > np.pi / 2)
    place = _RADIUS * (zeta + _waves(zeta))
    return np.where(beyond, np.inf, place.real), np.where(beyond, np.inf, place.imag)


@np.errstate(all="ignore")
def unprojected(points: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Return longitude and latitude [deg] of metres east and north of an origin, longitude from -180 to 180."""
    # points (n, 2) [m]; origin (2,) [deg]
    zeta = sphere = (points[:, 1] + _foot(origin) + 1j * points[:, 0]) / _RADIUS
    for _ in range(SERIES_ROUNDS):
        sphere = zeta - _waves(sphere)
    conformal = isometric = np.arcsinh(np.sin(sphere.real) / np.hypot(np.sinh(sphere.imag), np.cos(sphere.real)))
    for _ in range(LATITUDE_ROUNDS):
        isometric = conformal + _E * np.arctanh(_E * np.tanh(isometric))
    turn = np.degrees(np.arctan2(np.sinh(sphere.imag), np.cos(sphere.real)))
    place = np.stack([(origin[0] + turn + 180) % 360 - 180, np.degrees(np.arctan(np.sinh(isometric)))], axis=1)
    return np.where(np.abs(points[:, :1]) > WIDEST * _RADIUS, [np.nan, np.inf], place)


ROLES = ("centreline", "starboard", "port")
# Properties that may name a line's role, and roles without "bank" and "line".
SAID_IN = ("role", "side", "bank", "name", "type", "title", "label")
WORDS = {
    "centreline": ("centre", "center", "axis", "middle", "fairway", "centreline", "centerline"),
    "starboard": ("starboard", "right"), "port": ("port", "left"),
}  # fmt: skip
# Files that GDAL reads besides GeoJSON.
OTHERS = (".kml", ".shp", ".gpkg", ".gml", ".fgb", ".gpx")
# Coordinate systems in degrees that equal WGS84 within a metre.
IN_DEGREES = ("CRS84", "4326", "4258")


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
            if parts:
                check_degrees(crs, path)
            # Through JSON: Shapely's tuples become lists.
            features += [Feature(own, json.loads(shapely.to_geojson(part))) for own, part in parts]
    except pyogrio.errors.DataSourceError as error:
        raise InputError(f"{path}: cannot be read as a map ({str(error).split(';')[0]}); save it as GeoJSON") from None
    return features


def check_degrees(crs: str, path: Path) -> None:
    if not any(known in crs for known in IN_DEGREES):
        raise InputError(
            f"{path}: its coordinates are in {crs[:80]}; save the map in WGS84 (ogr2ogr -t_srs EPSG:4326 wgs84.geojson "
            f"{path.name})"
        )


def check_sides(line: Centreline, lines: Mapping[str, np.ndarray]) -> None:
    """Raise if both banks lie on the wrong side: their roles are exchanged, or the whole map is mirrored."""
    if np.median(line.locate(lines["starboard"])[1]) < 0 < np.median(line.locate(lines["port"])[1]):
        raise InputError(
            "each bank lies on the side of the other as one sails along the centreline; exchange their roles, turn the "
            "centreline round, or, where the file has latitude first, put longitude before latitude"
        )


# A waterway from a chart: the first lines that the normals of a centreline meet, and the depths along it.
# Distance greater than any waterway's width [m].
MOST = 1e5
# Search distance for a bank [m].
REACH = 1000.0
# Width of the transition from one area's depth to the next, on the deeper side [m].
SHELF = 0.01


class Chart(NamedTuple):
    banks: tuple[np.ndarray, ...]  # (n, 2) Lines, longitude and latitude [deg]
    # Areas with their holes, as Shapely geometries in longitude and latitude [deg], and the least depth in each [m]
    areas: tuple[tuple[Any, float], ...]
    name: str  # Name of the cell


def waterway_from_chart(chart: Chart, centreline: np.ndarray, reach: float = REACH) -> Waterway:
    # centreline (n, 2) [deg]; reach [m]. On either side the bank is the first of the chart's lines that the normals
    # meet, by exact intersection. The depth is the least of the shallowest area that contains the line. Banks are
    # vertical walls at the chart's lines.
    import shapely

    if not 0 < reach < MOST:
        raise InputError(f"reach = {reach} m must be over 0 and under {MOST:g} m")
    if not chart.banks:
        raise InputError(f"{chart.name}: the chart has no banks; is it the right cell?")
    origin = origin_of(centreline)
    line = Centreline(projected(centreline, origin))
    # The banks within reach, split where they cross, end to end; the gaps are pieces between points of no bank.
    near = shapely.buffer(shapely.LineString(line.at(line.fine)), 1.1 * reach)
    drawn = shapely.union_all([shapely.LineString(projected(bank, origin)) for bank in chart.banks])
    parts = shapely.get_parts(shapely.intersection(drawn, near))
    shores = [np.array(part.coords) for part in parts if part.geom_type == "LineString"]
    points, gaps = np.concatenate([*shores, np.empty((0, 2))]), np.cumsum([len(shore) for shore in shores])[:-1] - 1
    banks = []
    for side, sign in SIGNS.items():  # The outline seen along the normals: one straight piece between two corners
        normals = Normals(line, points, sign, gaps)
        corners, pieces = seen_pieces(normals, side, reach)
        seen = [line.at(s, sign * normals.met(s, pieces)) for s in (corners[:-1], corners[1:])]
        banks.append(bank_from_points(side, np.stack(seen, axis=1).reshape(-1, 2), line))
    areas = [(shapely.transform(area, partial(projected, origin=origin)), least) for area, least in chart.areas]
    depths = _depths(areas, line)
    return Waterway(line, banks[0], banks[1], depths, name=chart.name, origin=(float(origin[0]), float(origin[1])))


def _depths(areas: list[tuple[Any, float]], line: Centreline) -> tuple[np.ndarray, np.ndarray]:
    """Places where the line passes from area to area, and the depth there; the shallower area includes the edge."""
    import shapely

    track = shapely.LineString(line.at(line.fine))
    met = [shapely.intersection(track, area.boundary) for area, _ in areas]
    edges, _ = line.locate(shapely.get_coordinates(met))
    edges = np.unique(np.clip([0.0, line.length, *edges], 0, line.length))
    edges = edges[np.append(True, np.diff(edges) > 2 * SHELF)]
    # The least depth at each place, NaN if there is none: the waterway's error names the gap.
    points, depth = shapely.points(line.at((edges[1:] + edges[:-1]) / 2)), np.full(len(edges) - 1, np.nan)
    for area, least in areas:
        inside = shapely.contains(area, points)
        depth[inside] = np.fmin(depth[inside], least)
    other = np.append(True, np.diff(depth) != 0)
    edges, depth = np.append(edges[:-1][other], edges[-1]), depth[other]
    deeper = np.diff(depth) > 0
    first = edges[:-1] + SHELF * np.append(False, deeper)
    last = edges[1:] - SHELF * np.append(np.diff(depth) < 0, False)
    return np.stack([first, last], axis=1).ravel(), np.repeat(depth, 2)


# Electronic charts, S-57 and inland: the lines of banks and the areas of depth in a cell. Object classes that bound the
# water: coastline, shoreline construction, banks of canals and rivers.
BANKS = ("COALNE", "SLCONS", "canbnk", "rivbnk", "CANBNK", "RIVBNK")
# Object classes of a range of depths: depth areas, at sea and inland, and dredged areas.
DEPTH_AREAS = ("DEPARE", "depare", "DRGARE")
OPTIONS = {"SPLIT_MULTIPOINT": "ON", "ADD_SOUNDG_DEPTH": "ON", "UPDATES": "APPLY"}
# Code for depths in metres.
METRES = 1
# Layers of a cell that was read without the catalogue of object classes.
BARE = {"Point", "Line", "Area"}


def read_chart(path: str | Path) -> Chart:
    """Read the banks and depths of a cell of an electronic chart; updates in the same folder are applied."""
    path = Path(path)
    pyogrio = gdal(path, "an electronic chart")
    try:
        names = {str(name) for name in pyogrio.list_layers(path)[:, 0]}
        driver = pyogrio.read_info(path, layer=sorted(names)[0])["driver"]
        if driver != "S57" or names >= BARE:
            raise InputError(f"{path}: is not a cell of an electronic chart (S-57); give the .000 file")
        _, _, _, codes = pyogrio.raw.read(path, layer="DSID", columns=["DSPM_DUNI"], read_geometry=False, **OPTIONS)
        for unit in np.ravel(codes).tolist()[:1]:
            if unit != METRES:
                raise InputError(f"{path}: its depths are not in metres (unit {unit}); convert the cell")
        banks, areas = list[np.ndarray](), list[tuple[Any, float]]()
        for layer in (one for one in BANKS if one in names):
            _, shapes = read_layer(pyogrio, path, layer, columns=[], **OPTIONS)
            for _, shape in shapes:
                rings = (shape.exterior, *shape.interiors) if shape.geom_type == "Polygon" else (shape,)
                banks += [np.array(line.coords)[:, :2] for line in rings if line.geom_type != "Point"]
        for layer in (one for one in DEPTH_AREAS if one in names):
            _, shapes = read_layer(pyogrio, path, layer, columns=["DRVAL1"], **OPTIONS)
            areas += [(area, float(own.get("DRVAL1", np.nan))) for own, area in shapes if area.geom_type == "Polygon"]
    except pyogrio.errors.DataSourceError as error:
        raise InputError(f"{path}: is not a cell of an electronic chart ({str(error).split(';')[0]})") from None
    return Chart(tuple(banks), tuple(areas), path.stem)
