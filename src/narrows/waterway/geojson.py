"""Waterways from GeoJSON in WGS84 and back: a centreline, two bank lines, depths along the centreline."""

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from shlex import quote
from typing import Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, shown
from narrows.base.files import form_of, reading, write_whole
from narrows.waterway import map_lines
from narrows.waterway.banks import Bank, bank_from_points
from narrows.waterway.centreline import FARTHEST, Centreline, line_with_room
from narrows.waterway.map_lines import ROLES, Feature, origin_of, projected
from narrows.waterway.waterway import Waterway

# Largest distance between the bank of a bend and the line written for it [m].
CHORD = 0.001
CURRENT = ("current", "current_across", "current_shear")


@accept_aliases
def read_waterway(path: str | Path, width: float | None = None, depth: float | None = None) -> Waterway:
    """Read a waterway, or make one of constant width and depth along a line.

    A FeatureCollection of three LineStrings, each with a property ``role``: ``centreline``, ``starboard`` and ``port``,
    looking along the centreline. The centreline may have ``depth``, a number [m], or ``depths``: pairs [distance along
    it, depth], rising [m]. It may have ``current``: its speed at the beginning [m/s], or pairs [distance along it,
    speed]; and likewise ``current_across``, to starboard [m/s], and ``current_shear``, the rise of the speed to
    starboard [1/s]. A sloped bank has ``profile``: points [distance beyond its line, height above the bottom], outward
    [m].

    Raises an InputError if the file is no such collection, a role is missing, coordinates are not longitude and
    latitude, or the geometry is impossible; the sentence names the place.

    Parameters
    ----------
    path : str or Path
        GeoJSON, longitude before latitude; or KML, a shapefile, GeoPackage or GML with the extra ``charts``.
    width, depth : float [m], optional
        With a width, of a file with the centreline alone; a depth is that of a file without one.
    """
    if width is not None:
        if depth is None:
            raise InputError(f"a canal of one width along {path} needs a depth; give depth=... [m]")
        return waterway_from_line(read_line(path), width, depth, Path(path).stem)
    way = _read(path)
    if depth is None:
        return way
    if way.depths is not None:
        raise InputError(f"{way.name} has depths of its own; leave the depth out")
    return replace(way, depths=(np.array([0.0, way.line.length]), np.full(2, depth)))


def _read(path: str | Path) -> Waterway:
    features = _lines(read_features(Path(path)), str(path))
    points = {role: coordinates(one, f"{path}: the {role}") for role, one in features.items()}
    try:
        origin = origin_of(points["centreline"])
        lines = {role: projected(line, origin) for role, line in points.items()}
        line, own = Centreline(lines["centreline"]), features["centreline"].properties
        map_lines.check_sides(line, lines)
        starboard, port = (bank_from_points(side, lines[side], line, _profile(features[side])) for side in ROLES[1:])
        way = Waterway(line, starboard, port, _depths(own, line), name=Path(path).stem, origin=tuple(origin.tolist()))
        return way.with_water(**{name: own.get(name) for name in CURRENT})
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def read_line(path: str | Path) -> np.ndarray:
    """Read a centreline, (n, 2) [deg]: the LineString with the role ``centreline``, or the only one."""
    lines = [feature for feature in read_features(Path(path)) if feature.geometry.get("type") == "LineString"]
    centrelines = [feature for feature in lines if feature.role == "centreline"] or lines
    if len(centrelines) != 1:
        raise InputError(
            f"{path}: has {len(centrelines)} lines that may be the centreline; leave one, or give it its role"
        )
    return coordinates(centrelines[0], f"{path}: the centreline")


def waterway_from_line(points: np.ndarray, width: float, depth: float, name: str = "canal") -> Waterway:
    """Return the waterway of constant width and depth along a centreline or a ship's track, with vertical banks."""
    # points (n, 2), longitude and latitude [deg]; width, depth [m]
    if not 0 < width < FARTHEST:
        raise InputError(f"a width of {width:g} m is none of a waterway; give metres over 0")
    origin = origin_of(points)
    line = line_with_room(projected(points, origin), width / 2)
    return Waterway(line, name=name, origin=tuple(origin.tolist()), width=width, depth=depth)


def farthest(waterway: Waterway, points: np.ndarray) -> float:
    """Return the largest distance of points, longitude and latitude [deg], from the line of a waterway [m]."""
    return float(np.abs(waterway.line.locate(projected(points, np.array(waterway.origin)))[1]).max())


@accept_aliases
def write_waterway(waterway: Waterway, path: str | Path) -> None:
    """Write a waterway as GeoJSON that ``read_waterway`` reads.

    Raises an InputError if its origin is unknown, or the file cannot be written.

    Parameters
    ----------
    waterway : Waterway
        A waterway with a place on earth.
    path : str or Path
        Output file.
    """
    form_of(path, (".geojson", ".json"))
    if waterway.origin is None:
        raise InputError(f"{waterway.name}: its place on earth is unknown; give its origin, longitude and latitude")
    line, origin = waterway.line, np.array(waterway.origin)
    depth = {} if waterway.depths is None else {"depths": np.stack(waterway.depths, axis=1).tolist()}
    flow = {name: np.asarray(own).tolist() for name in CURRENT if np.any(own := getattr(waterway, name))}
    features = [_feature("centreline", line.points, origin, {**depth, **flow})]
    for bank, sign in ((waterway.starboard, 1), (waterway.port, -1)):
        shape = {"profile": [list(point) for point in bank.profile]} if bank.profile else {}
        features.append(_feature(bank.side, _drawn(bank, sign, line), origin, shape))
    write_whole(path, json.dumps({"type": "FeatureCollection", "features": features}, indent=1))


def _drawn(bank: Bank, sign: int, line: Centreline) -> np.ndarray:
    """Points of a bank on the map: its own, or points close enough for the chords of a bend."""
    if bank.drawn is not None:
        return bank.drawn.points
    sharpest = np.abs(line.curvature(line.fine)).max()
    count = int(np.ceil(line.length * np.sqrt(sharpest / (8 * CHORD)))) + 1
    s = np.union1d(np.clip(bank.s, 0, line.length), np.linspace(0, line.length, count + 1))
    return line.at(s, sign * bank.at(s))


def _feature(role: str, points: np.ndarray, origin: np.ndarray, more: Mapping[str, Any]) -> dict[str, Any]:
    coordinates = map_lines.unprojected(points, origin).round(9).tolist()
    geometry = {"type": "LineString", "coordinates": coordinates}
    return {"type": "Feature", "properties": {"role": role, **more}, "geometry": geometry}


def _lines(features: list[Feature], file: str) -> dict[str, Feature]:
    """The lines of a waterway by role."""
    roles = [feature.role for feature in features if feature.role]
    for role in ROLES:
        if roles.count(role) > 1:
            raise InputError(f"{file}: there are two lines with the role {role}; leave one, or join its pieces")
    written = "waterway.geojson" if Path(file).name == "canal.geojson" else "canal.geojson"
    if [one.geometry.get("type") for one in features] == ["LineString"] and set(roles) <= {"centreline"}:
        raise InputError(
            f"{file}: has one line; with your width and depth it is a waterway: "
            f"narrows waterway --line {quote(file)} --width 300 --depth 16 -o {written}"
        )
    if not features:
        raise InputError(f"{file}: has no line; draw a centreline (then --line, --width and --depth) and two banks")
    for role in ROLES:
        if role not in roles:
            raise InputError(f"{file}: no LineString has the property role = {role}; add it")
    return {feature.role: feature for feature in features if feature.role}


def _profile(feature: Feature) -> Any:
    value: Any = feature.properties.get("profile")
    if value is None:
        return ()
    return tuple(map(tuple, value)) if value and pairs(value) is not None else value


def _depths(own: Mapping[str, Any], line: Centreline) -> tuple[np.ndarray, np.ndarray] | None:
    """Places along a centreline and the depth at each [m]."""
    depth, along, table = own.get("depth"), own.get("depths"), None
    if depth is not None and metres(depth) is None:
        raise InputError(f"the depth of the centreline, {shown(depth)}, is not a number; for several use depths")
    if along is not None:
        table = pairs(along, exactly=True)
        if table is None or not len(table):
            raise InputError(f"depths = {shown(along)} of the centreline are not pairs of place and depth; mend them")
        if not (np.diff(table[:, 0]) > 0).all():
            raise InputError("the depths of the centreline do not rise along it; give places in order, none twice")
    if depth is None:
        return None if table is None else (table[:, 0], table[:, 1])
    if table is not None:
        raise InputError("the centreline has both depth and depths; leave one")
    return np.array([0.0, line.length]), np.full(2, metres(depth))


# Contents of a waterway's GeoJSON file: its lines with their roles and properties, or one sentence of error.
def read_features(path: Path) -> list[Feature]:
    """Return the lines of a map, or the line through the points of one without."""
    if path.suffix.lower() in map_lines.OTHERS:
        return [part for one in map_lines.read_other(path) for part in _parts(one)]
    if path.suffix.lower() == ".csv":
        raise InputError(f"{path}: is a table, not a map; save its points as a line in GeoJSON or KML")
    with reading(path, "JSON"):
        document = json.loads(path.read_text(encoding="utf-8-sig"))
    kind, found = document.get("type") if isinstance(document, Mapping) else None, []
    alone = [document if kind == "Feature" else {"geometry": document}]
    features = alone if kind in ("Feature", "LineString") else document.get("features") if kind else None
    if not isinstance(features, list) or not all(isinstance(feature, Mapping) for feature in features):
        raise InputError(f"{path}: is not a GeoJSON FeatureCollection; give one with three LineStrings")
    for number, feature in enumerate(features):
        for name in ("properties", "geometry"):
            if (value := feature.get(name)) is not None and not isinstance(value, Mapping):
                raise InputError(f"{path}: feature {number}: its {name} are {shown(value)}, no object; mend them")
        found.append(Feature(feature.get("properties") or {}, feature.get("geometry") or {}))
    if found and document.get("crs"):
        map_lines.check_degrees(json.dumps(document["crs"]), path)
    track = [one.geometry.get("coordinates") for one in found if one.geometry.get("type") == "Point"]
    whole = [Feature({}, {"type": "LineString", "coordinates": track})] * (len(track) == len(found) > 1)
    return whole or [part for one in found for part in _parts(one)]


def _parts(feature: Feature) -> list[Feature]:
    """The lines of a feature of several; nothing of one without a shape, or of points such as buoys."""
    feature = feature._replace(properties={str(key).lower(): value for key, value in feature.properties.items()})
    kind, shapes = feature.geometry.get("type"), feature.geometry.get("coordinates")
    if kind == "MultiLineString" and isinstance(shapes, list):
        return [Feature(feature.properties, {"type": "LineString", "coordinates": shape}) for shape in shapes]
    return [] if kind in (None, "Point", "MultiPoint") else [feature]


def coordinates(feature: Feature, name: str) -> np.ndarray:
    """Return the points of a LineString, (n, 2): longitude and latitude [deg]."""
    if feature.geometry.get("type") != "LineString":
        raise InputError(f"{name} is a {shown(feature.geometry.get('type'))}; make it a LineString")
    points = pairs(feature.geometry.get("coordinates"))
    if points is None:
        raise InputError(f"{name} has a coordinate that is not two numbers; mend it")
    points = points[np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))] if len(points) else points
    if len(points) < 2:
        raise InputError(f"{name} has fewer than two points; add some")
    wrong = ~((-180 <= points[:, 0]) & (points[:, 0] <= 360) & (np.abs(points[:, 1]) <= 90))
    if wrong.any():
        first = points[int(wrong.argmax())]
        hint = "; latitude seems to come first" if abs(first[0]) <= 90 < abs(first[1]) <= 180 else ""
        hint = "; are these metres? Save the map in WGS84 (EPSG:4326)" if np.abs(first).max() > 1000 else hint
        raise InputError(f"{name} has the point {first[0]:g}, {first[1]:g}, which is no longitude and latitude{hint}")
    return points


def pairs(items: Any, exactly: bool = False) -> np.ndarray | None:
    """Return lists of two or more numbers as an array (n, 2); None if they are not."""
    most = 2 if exactly else np.inf
    if not isinstance(items, list) or not all(isinstance(item, list) and 2 <= len(item) <= most for item in items):
        return None
    values = [[number(item[0]), number(item[1])] for item in items]
    return None if any(None in item for item in values) else np.array(values, float).reshape(-1, 2)


def number(value: Any) -> float | None:
    """Return a number as a float, None if it is invalid or too large."""
    with suppress(OverflowError):
        return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
    return None


def metres(value: Any) -> float | None:
    """Return a size [m], as "16 m" too; None if it is none."""
    with suppress(ValueError):
        return number(float(value.strip().removesuffix("m")) if isinstance(value, str) else value)
    return None
