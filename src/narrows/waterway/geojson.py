"""Waterways from GeoJSON in WGS84: a centreline, two bank lines, depths along the centreline."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from narrows.errors import InputError
from narrows.files import write_whole
from narrows.ship.cross_section import Point, equivalent_wall
from narrows.waterway.banks import FAR, Bank, bank_from_points
from narrows.waterway.centreline import Centreline
from narrows.waterway.waterway import Waterway

ROLES = ("centreline", "starboard", "port")
CHORD = 0.001
"""Between the bank of a bend and the line that is written for it [m]."""
KNOWN_CRS = ("CRS84", "4326")


def read_waterway(path: str | Path) -> Waterway:
    """Read a waterway.

    A FeatureCollection of three LineStrings, each with a property ``role``: ``centreline``, ``starboard`` and ``port``
    as one sails along the centreline. The centreline may have ``depth``: one number [m], or one for each of its points.
    A bank that is no wall has ``profile``: points [distance beyond its line, height above the bottom], outward [m].

    Parameters
    ----------
    path : str or Path
        GeoJSON, longitude before latitude.

    Raises
    ------
    InputError
        Where the file is no such collection, a role is missing, coordinates are not longitude and latitude, or the
        geometry is impossible: in one sentence with the place.
    """
    collection = _loaded(Path(path))
    lines = _lines(collection, str(path))
    origin = np.mean(lines["centreline"], axis=0)
    metres = {role: projected(points, origin) for role, points in lines.items()}
    try:
        line = Centreline(metres["centreline"])
        banks = {s: bank_from_points(s, metres[s], line, _profile(collection, s)) for s in ROLES[1:]}
        depths = _depths(collection, line, metres["centreline"])
        at = (float(origin[0]), float(origin[1]))
        return Waterway(line, banks["starboard"], banks["port"], depths, name=Path(path).stem, origin=at)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def write_waterway(waterway: Waterway, path: str | Path) -> None:
    """Write a waterway as GeoJSON that ``read_waterway`` reads.

    Parameters
    ----------
    waterway : Waterway
        One that knows where on earth it is.
    path : str or Path
        Where to.

    Raises
    ------
    InputError
        Where it does not know its origin, or the file cannot be written.
    """
    if waterway.origin is None:
        raise InputError(f"{waterway.name}: nothing says where on earth it is; give its origin, longitude and latitude")
    line, origin = waterway.line, np.array(waterway.origin)
    levels = waterway.depth(line.stations) - waterway.level
    depth = {} if waterway.depths is None else {"depth": levels.tolist()}
    features = [_feature("centreline", np.asarray(line.points), origin, depth)]
    for bank, sign in ((waterway.starboard, 1), (waterway.port, -1)):
        shape = {"profile": [list(point) for point in bank.profile]} if bank.profile else {}
        features.append(_feature(bank.side, _drawn(bank, sign, line), origin, shape))
    write_whole(path, json.dumps({"type": "FeatureCollection", "features": features}, indent=1))


def _drawn(bank: Bank, sign: int, line: Centreline) -> np.ndarray:
    """Points of a bank on the map: its own, or near enough to each other that chords keep to a bend."""
    if bank.drawn is not None:
        return np.asarray(bank.drawn.points)
    sharpest = np.abs(line.curvature(line.fine)).max()
    count = int(np.ceil(line.length * np.sqrt(sharpest / (8 * CHORD)))) + 1
    s = np.union1d(np.clip(bank.s, 0, line.length), np.linspace(0, line.length, count + 1))
    return line.at(s, sign * bank.at(s))


def _feature(role: str, points: np.ndarray, origin: np.ndarray, more: Mapping[str, Any]) -> dict[str, Any]:
    coordinates = unprojected(points, origin).round(9).tolist()
    geometry = {"type": "LineString", "coordinates": coordinates}
    return {"type": "Feature", "properties": {"role": role, **more}, "geometry": geometry}


def projected(points: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Project longitude and latitude to metres east and north of an origin, true to scale near it (ours).

    Parameters
    ----------
    points : array (n, 2) [deg]
        Longitude and latitude, WGS84.
    origin : array (2,) [deg]
        Likewise.
    """
    east, north = _projection(origin).transform(points[:, 0], points[:, 1])
    return np.stack([east, north], axis=1)


def unprojected(points: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Return longitude and latitude of metres east and north of an origin (ours).

    Parameters
    ----------
    points : array (n, 2) [m]
        East and north.
    origin : array (2,) [deg]
        Longitude and latitude, WGS84.
    """
    longitude, latitude = _projection(origin).transform(points[:, 0], points[:, 1], direction="INVERSE")
    return np.stack([longitude, latitude], axis=1)


def _projection(origin: np.ndarray) -> Any:
    try:
        from pyproj import Transformer
    except ImportError:
        raise InputError("maps need pyproj: install narrows with its extra, pip install 'narrows[canals]'") from None
    local = f"+proj=tmerc +lon_0={origin[0]} +lat_0={origin[1]} +k=1 +datum=WGS84 +units=m"
    return Transformer.from_crs("OGC:CRS84", local, always_xy=True)


def _loaded(path: Path) -> Mapping[str, Any]:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the path") from None
    except ValueError as error:
        raise InputError(f"{path}: is not JSON ({error}); mend it there") from None
    if not isinstance(found, Mapping) or found.get("type") != "FeatureCollection":
        raise InputError(f"{path}: is not a GeoJSON FeatureCollection; give one with three LineStrings")
    crs = str(found.get("crs", {}))
    if found.get("crs") and not any(known in crs for known in KNOWN_CRS):
        raise InputError(f"{path}: its coordinates are in {crs}; convert them to WGS84 (CRS84)")
    features = found.get("features")
    if not isinstance(features, list) or not all(isinstance(feature, Mapping) for feature in features):
        raise InputError(f"{path}: its features are no list of GeoJSON features; give three LineStrings")
    return found


def _lines(collection: Mapping[str, Any], place: str) -> dict[str, np.ndarray]:
    lines = {}
    for feature in collection.get("features", []):
        role = (feature.get("properties") or {}).get("role")
        geometry = feature.get("geometry") or {}
        if role not in ROLES:
            continue
        if geometry.get("type") != "LineString":
            raise InputError(f"{place}: the {role} is a {geometry.get('type')}; make it a LineString")
        if role in lines:
            raise InputError(f"{place}: there are two lines with the role {role}; leave one")
        lines[role] = _coordinates(geometry.get("coordinates"), f"{place}: the {role}")
    for role in ROLES:
        if role not in lines:
            raise InputError(f"{place}: no LineString has the property role = {role}; add it")
    return lines


def _coordinates(given: Any, place: str) -> np.ndarray:
    try:
        points = np.array([[float(pair[0]), float(pair[1])] for pair in given])
    except (TypeError, ValueError, IndexError):
        raise InputError(f"{place} has a coordinate that is not two numbers; mend it") from None
    if len(points) < 2:
        raise InputError(f"{place} has fewer than two points; add some")
    wrong = ~((np.abs(points[:, 0]) <= 180) & (np.abs(points[:, 1]) <= 90))
    if wrong.any():
        first = points[int(wrong.argmax())]
        hint = "; latitude seems to come first" if abs(first[0]) <= 90 < abs(first[1]) <= 180 else ""
        raise InputError(f"{place} has the point {first[0]:g}, {first[1]:g}, which is no longitude and latitude{hint}")
    return points


def read_line(path: str | Path) -> np.ndarray:
    """Read a centreline: the LineString with the role ``centreline``, or the only one: (n, 2) [deg].

    Parameters
    ----------
    path : str or Path
        GeoJSON, longitude before latitude.

    Raises
    ------
    InputError
        Where there is none, or more than one.
    """
    collection = _loaded(Path(path))
    lines = [f for f in collection.get("features", []) if (f.get("geometry") or {}).get("type") == "LineString"]
    own = [f for f in lines if (f.get("properties") or {}).get("role") == "centreline"] or lines
    if len(own) != 1:
        raise InputError(f"{path}: has {len(own)} lines that may be the centreline; leave one, or give it its role")
    return _coordinates(own[0]["geometry"].get("coordinates"), f"{path}: the centreline")


def _properties(collection: Mapping[str, Any], role: str) -> Mapping[str, Any]:
    own = (feature.get("properties") or {} for feature in collection["features"])
    return next(properties for properties in own if properties.get("role") == role)


def _profile(collection: Mapping[str, Any], side: str) -> tuple[Point, ...]:
    given = _properties(collection, side).get("profile")
    if given is None:
        return ()
    try:
        profile = tuple((float(out), float(up)) for out, up in given)
    except (TypeError, ValueError):
        raise InputError(f"the profile of the {side} bank is not pairs of distance and height; mend it") from None
    equivalent_wall([(FAR + out, up) for out, up in profile], 1.0)
    return profile


def _depths(
    collection: Mapping[str, Any], line: Centreline, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    given = _properties(collection, "centreline").get("depth")
    if given is None:
        return None
    listed = given if isinstance(given, list) else [given]
    if not all(value is None or (isinstance(value, int | float) and not isinstance(value, bool)) for value in listed):
        raise InputError(f"the depth of the centreline, {given!r}, is not a number or one for each point; mend it")
    values = np.array([np.nan if value is None else float(value) for value in listed])
    if values.size == 1:
        return np.array([0.0, line.length]), np.repeat(values, 2)
    if len(values) != len(points):
        raise InputError(f"the centreline has {len(points)} points and {len(values)} depths; give one for each")
    return line.stations, values
