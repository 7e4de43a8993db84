"""Lines of a user's map: files of other programs, UTM, other words for roles, two banks alone."""

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from narrows.errors import InputError, needs
from narrows.waterway.centreline import Centreline, along_chords, chords
from narrows.waterway.projection import from_utm

ROLES = ("centreline", "starboard", "port")
# Properties that may name a line's role, and roles without "bank" and "line".
SAID_IN = ("role", "side", "bank", "name", "type", "title", "label")
WORDS = {
    "centreline": ("centre", "center", "axis", "middle", "fairway", "centreline", "centerline"),
    "starboard": ("starboard", "right"), "port": ("port", "left"),
}  # fmt: skip
# Files that GDAL reads besides GeoJSON.
OTHERS = (".kml", ".shp", ".gpkg", ".gml", ".fgb")
# Coordinate systems in degrees that equal WGS84 within a metre, and first codes of UTM zones: WGS84 north and south,
# ETRS89.
IN_DEGREES = ("CRS84", "4326", "4258")
UTM = {326: False, 327: True, 258: False}
# Iterations of a line between banks towards the middle, and its points per width of the waterway [1].
ROUNDS, POINTS_A_WIDTH = 20, 1.0


class Feature(NamedTuple):
    properties: Mapping[str, Any]  # As given
    geometry: Mapping[str, Any]  # As given

    @property
    def role(self) -> str | None:
        """Return the role of a line in a waterway, from any property that names it."""
        said = {str(key).lower(): value for key, value in self.properties.items() if isinstance(value, str)}
        for key in SAID_IN:
            words = re.sub(r"\b(bank|line)\b|[_-]", " ", said.get(key, "").lower()).split()
            found = next((role for role, meant in WORDS.items() if " ".join(words) in meant), None)
            if found:
                return found
        return None


def gdal(path: Path, what: str) -> Any:
    """Return the library that reads maps and charts, if it and the file exist."""
    with needs("charts", what):
        import pyogrio
        import pyogrio.errors
        import shapely  # noqa: F401
    if not path.is_file():
        raise InputError(f"{path}: cannot be read (no such file); check the path")
    return pyogrio


def read_other(path: Path) -> list[Feature]:
    """Read the lines and areas of a file that GDAL supports, in degrees."""
    pyogrio, features = gdal(path, f"a {path.suffix} file"), []
    import shapely

    try:
        for layer in pyogrio.list_layers(path)[:, 0]:
            meta, _, shapes, columns = pyogrio.raw.read(path, layer=str(layer))
            values = [dict(zip(meta["fields"], row, strict=True)) for row in zip(*columns, strict=True)]
            parts, whose = shapely.get_parts(shapely.from_wkb(shapes), return_index=True)
            if not len(parts):
                continue
            turned = into_degrees(str(meta["crs"] or "CRS84"), str(path))
            for part, number in zip(parts, whose.tolist(), strict=True):
                geometry = turned(shapely.geometry.mapping(part))
                features.append(Feature(values[number] if values else {}, geometry))
    except pyogrio.errors.DataSourceError as error:
        raise InputError(f"{path}: cannot be read as a map ({str(error).split(';')[0]}); save it as GeoJSON") from None
    return features


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

    Of three, the one between the others is the centreline; the direction is that of the centreline, or of the first of
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
