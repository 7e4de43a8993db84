"""Waterways from GeoJSON in WGS84 and back: a centreline, two bank lines, depths along the centreline."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from narrows.errors import InputError
from narrows.files import form_of, write_whole
from narrows.waterway.banks import Bank, bank_from_points
from narrows.waterway.centreline import Centreline
from narrows.waterway.features import Feature, coordinates, depths_along, depths_of, profile_of, read_features
from narrows.waterway.projection import origin_of, projected, unprojected
from narrows.waterway.waterway import Waterway

ROLES = ("centreline", "starboard", "port")
# Between the bank of a bend and the line that is written for it [m].
CHORD = 0.001


def read_waterway(path: str | Path) -> Waterway:
    """Read a waterway.

    A FeatureCollection of three LineStrings, each with a property ``role``: ``centreline``, ``starboard`` and ``port``
    as one sails along the centreline. The centreline may have ``depth``: one number [m], or one for each of its points;
    or ``depths``: pairs [distance along it, depth], rising [m].
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
    features = _roles(read_features(Path(path)), str(path))
    points = {role: coordinates(feature, f"{path}: the {role}") for role, feature in features.items()}
    try:
        origin = origin_of(points["centreline"])
        metres = {role: projected(coordinates_of, origin) for role, coordinates_of in points.items()}
        line = Centreline(metres["centreline"])
        banks = {s: bank_from_points(s, metres[s], line, profile_of(features[s], s)) for s in ROLES[1:]}
        depths = _depths(features["centreline"], line)
        at = (float(origin[0]), float(origin[1]))
        return Waterway(line, banks["starboard"], banks["port"], depths, name=Path(path).stem, origin=at)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def read_line(path: str | Path) -> np.ndarray:
    """Read a centreline: the LineString with the role ``centreline``, or the only one: (n, 2) [deg]."""
    lines = [feature for feature in read_features(Path(path)) if feature.geometry.get("type") == "LineString"]
    centrelines = [feature for feature in lines if feature.role == "centreline"] or lines
    if len(centrelines) != 1:
        raise InputError(
            f"{path}: has {len(centrelines)} lines that may be the centreline; leave one, or give it its role"
        )
    return coordinates(centrelines[0], f"{path}: the centreline")


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
    form_of(path, (".geojson", ".json"))
    if waterway.origin is None:
        raise InputError(f"{waterway.name}: nothing says where on earth it is; give its origin, longitude and latitude")
    line, origin = waterway.line, np.array(waterway.origin)
    depth = {} if waterway.depths is None else {"depths": np.stack(waterway.depths, axis=1).tolist()}
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


def _roles(features: list[Feature], file: str) -> dict[str, Feature]:
    by_role: dict[str, Feature] = {}
    for feature in features:
        if feature.role in ROLES and feature.role in by_role:
            raise InputError(f"{file}: there are two lines with the role {feature.role}; leave one")
        if feature.role is not None:
            by_role[feature.role] = feature
    for role in ROLES:
        if role not in by_role:
            raise InputError(f"{file}: no LineString has the property role = {role}; add it")
    return {role: by_role[role] for role in ROLES}


def _depths(feature: Feature, line: Centreline) -> tuple[np.ndarray, np.ndarray] | None:
    values = depths_of(feature, len(line.points))
    along = depths_along(feature)
    if along is not None and values is not None:
        raise InputError("the centreline has both depth and depths; leave one")
    if along is not None:
        return along
    if values is None:
        return None
    if values.size == 1:
        return np.array([0.0, line.length]), np.repeat(values, 2)
    return line.stations, values
