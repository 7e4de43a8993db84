"""What a GeoJSON file of a waterway has: its lines with their roles and properties, or one sentence why not."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from narrows.errors import InputError, shown
from narrows.files import reading
from narrows.ship.cross_section import Point

KNOWN_CRS = ("CRS84", "4326")


class Feature(NamedTuple):
    """A feature of a collection."""

    properties: Mapping[str, Any]  # As given
    geometry: Mapping[str, Any]  # As given

    @property
    def role(self) -> str | None:
        """What it says that it is."""
        role = self.properties.get("role")
        return role if isinstance(role, str) else None


def read_features(path: Path) -> list[Feature]:
    """Return the features of a collection in WGS84."""
    with reading(path, "JSON"):
        document = json.loads(path.read_text(encoding="utf-8"))
        crs = json.dumps(document.get("crs")) if isinstance(document, Mapping) and document.get("crs") else ""
    if not isinstance(document, Mapping) or document.get("type") != "FeatureCollection":
        raise InputError(f"{path}: is not a GeoJSON FeatureCollection; give one with three LineStrings")
    if crs and not any(known in crs for known in KNOWN_CRS):
        raise InputError(f"{path}: its coordinates are in {crs[:80]}; convert them to WGS84 (CRS84)")
    features = document.get("features")
    if not isinstance(features, list) or not all(isinstance(feature, Mapping) for feature in features):
        raise InputError(f"{path}: its features are no list of GeoJSON features; give three LineStrings")
    return [
        Feature(*(_object(feature, name, f"{path}: feature {number}") for name in ("properties", "geometry")))
        for number, feature in enumerate(features)
    ]


def coordinates(feature: Feature, name: str) -> np.ndarray:
    """Return the points of a LineString, (n, 2): longitude and latitude [deg]."""
    if feature.geometry.get("type") != "LineString":
        raise InputError(f"{name} is a {shown(feature.geometry.get('type'))}; make it a LineString")
    points = pairs(feature.geometry.get("coordinates"))
    if points is None:
        raise InputError(f"{name} has a coordinate that is not two numbers; mend it")
    if len(points) < 2:
        raise InputError(f"{name} has fewer than two points; add some")
    wrong = ~((np.abs(points[:, 0]) <= 180) & (np.abs(points[:, 1]) <= 90))
    if wrong.any():
        first = points[int(wrong.argmax())]
        hint = "; latitude seems to come first" if abs(first[0]) <= 90 < abs(first[1]) <= 180 else ""
        raise InputError(f"{name} has the point {first[0]:g}, {first[1]:g}, which is no longitude and latitude{hint}")
    return points


def profile_of(feature: Feature, side: str) -> tuple[Point, ...]:
    """Return the profile of a bank, empty where it has none: pairs of distance and height [m]."""
    value = feature.properties.get("profile")
    if value is None:
        return ()
    points = pairs(value, exactly=True)
    if points is None:
        raise InputError(f"the profile of the {side} bank is not pairs of distance and height; mend it")
    if not len(points):
        raise InputError(f"the profile of the {side} bank is empty; give it two points or more, or leave it out")
    return tuple((float(out), float(up)) for out, up in points)


def depths_of(feature: Feature, count: int) -> np.ndarray | None:
    """Return the depths of a centreline, (1,) or (count,) [m]: NaN where there is none, None without any."""
    depth = feature.properties.get("depth")
    if depth is None:
        return None
    values = [np.nan if value is None else number(value) for value in (depth if isinstance(depth, list) else [depth])]
    if any(value is None for value in values):
        raise InputError(f"the depth of the centreline, {shown(depth)}, is not a number or one for each point; mend it")
    if len(values) not in (1, count):
        raise InputError(f"the centreline has {count} points and {len(values)} depths; give one for each")
    return np.array(values, float)


def depths_along(feature: Feature) -> tuple[np.ndarray, np.ndarray] | None:
    """Return places along a centreline and the depth at each [m], None without any."""
    value = feature.properties.get("depths")
    if value is None:
        return None
    points = pairs(value, exactly=True)
    if points is None or not len(points):
        raise InputError(f"the depths of the centreline, {shown(value)}, are not pairs of place and depth; mend them")
    if not (np.diff(points[:, 0]) > 0).all():
        raise InputError("the depths of the centreline do not rise along it; give their places in order, none twice")
    return points[:, 0], points[:, 1]


def pairs(items: Any, exactly: bool = False) -> np.ndarray | None:
    """Return lists of two numbers, or of more that are left out, as an array (n, 2); None where they are not."""
    if not isinstance(items, list) or not all(isinstance(item, list) and len(item) >= 2 for item in items):
        return None
    if exactly and any(len(item) > 2 for item in items):
        return None
    values = [[number(item[0]), number(item[1])] for item in items]
    return None if any(None in item for item in values) else np.array(values, float).reshape(-1, 2)


def number(value: Any) -> float | None:
    """Return a number as a float, None where it is none or too large for one."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        return float(value)
    except OverflowError:
        return None


def _object(feature: Mapping[str, Any], name: str, owner: str) -> Mapping[str, Any]:
    value = feature.get(name)
    if value is not None and not isinstance(value, Mapping):
        raise InputError(f"{owner}: its {name} are {shown(value)}, no object; mend them")
    return value or {}
