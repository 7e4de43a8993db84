"""Waterways from GeoJSON in WGS84: a centreline, two bank lines, depths along the centreline."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from narrows.errors import InputError
from narrows.waterway.banks import bank_from_points
from narrows.waterway.centreline import Centreline
from narrows.waterway.waterway import Waterway

ROLES = ("centreline", "starboard", "port")
KNOWN_CRS = ("CRS84", "4326")


def read_waterway(path: str | Path) -> Waterway:
    """Read a waterway.

    A FeatureCollection of three LineStrings, each with a property ``role``: ``centreline``, ``starboard`` and ``port``
    as one sails along the centreline. The centreline may have ``depth``: one number [m], or one for each of its points.

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
        banks = {side: bank_from_points(side, metres[side], line) for side in ROLES[1:]}
        depths = _depths(collection, line, metres["centreline"])
        return Waterway(line, banks["starboard"], banks["port"], depths, name=Path(path).stem)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


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


def _depths(
    collection: Mapping[str, Any], line: Centreline, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    features = collection["features"]
    own = next(f for f in features if (f.get("properties") or {}).get("role") == "centreline")
    given = own["properties"].get("depth")
    if given is None:
        return None
    values = np.array([np.nan if value is None else float(value) for value in np.atleast_1d(np.array(given, object))])
    if values.size == 1:
        return np.array([0.0, line.length]), np.repeat(values, 2)
    if len(values) != len(points):
        raise InputError(f"the centreline has {len(points)} points and {len(values)} depths; give one for each")
    return line.place(points)[0], values
