"""A waterway from a chart: the first lines that the normals of a centreline meet, and the depths along it."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from narrows.base.errors import InputError
from narrows.waterway.banks import SIGNS, Bank, Normals, bank_from_points, seen_pieces
from narrows.waterway.centreline import Centreline
from narrows.waterway.map_lines import gdal, origin_of, projected, read_layer
from narrows.waterway.waterway import Waterway

# Distance greater than any waterway's width [m].
MOST = 1e5
# Search distance for a bank [m].
REACH = 1000.0
# Width of the transition from one area's depth to the next, on the deeper side [m].
SHELF = 0.01


@dataclass(frozen=True)
class Chart:
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
    starboard, port = (_bank(side, line, points, gaps, reach) for side in SIGNS)
    areas = [(shapely.transform(area, partial(projected, origin=origin)), least) for area, least in chart.areas]
    depths = _depths(areas, line)
    return Waterway(line, starboard, port, depths, name=chart.name, origin=(float(origin[0]), float(origin[1])))


def _bank(side: str, line: Centreline, points: np.ndarray, gaps: np.ndarray, reach: float) -> Bank:
    """The outline of the banks visible along the normals to one side: one straight piece between two corners."""
    normals = Normals(line, points, SIGNS[side], gaps)
    corners, pieces = seen_pieces(normals, side, reach)
    seen = [line.at(s, normals.sign * normals.met(s, pieces)) for s in (corners[:-1], corners[1:])]
    return bank_from_points(side, np.stack(seen, axis=1).reshape(-1, 2), line)


def _depths(areas: list[tuple[Any, float]], line: Centreline) -> tuple[np.ndarray, np.ndarray]:
    """Places where the line passes from area to area, and the depth there; the shallower area includes the edge."""
    import shapely

    track = shapely.LineString(line.at(line.fine))
    met = [shapely.intersection(track, area.boundary) for area, _ in areas]
    edges, _ = line.locate(shapely.get_coordinates(met))
    edges = np.unique(np.clip([0.0, line.length, *edges], 0, line.length))
    edges = edges[np.append(True, np.diff(edges) > 2 * SHELF)]
    depth = _least(areas, line.at((edges[1:] + edges[:-1]) / 2))
    other = np.append(True, np.diff(depth) != 0)
    edges, depth = np.append(edges[:-1][other], edges[-1]), depth[other]
    deeper = np.diff(depth) > 0
    first = edges[:-1] + SHELF * np.append(False, deeper)
    last = edges[1:] - SHELF * np.append(np.diff(depth) < 0, False)
    return np.stack([first, last], axis=1).ravel(), np.repeat(depth, 2)


def _least(areas: list[tuple[Any, float]], places: np.ndarray) -> np.ndarray:
    """Least depth at places, NaN if there is none: the waterway's error names the gap."""
    import shapely

    points, depth = shapely.points(places), np.full(len(places), np.nan)
    for area, least in areas:
        inside = shapely.contains(area, points)
        depth[inside] = np.fmin(depth[inside], least)
    return depth


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
