"""A waterway out of a chart: what the normals of a centreline meet first on either side, and the depths along it."""

from typing import Any

import numpy as np

from narrows.errors import InputError
from narrows.waterway.banks import Bank, bank_from_points
from narrows.waterway.centreline import Centreline
from narrows.waterway.chart import Chart
from narrows.waterway.normals import Normals
from narrows.waterway.projection import origin_of, projected
from narrows.waterway.waterway import Waterway

# Longer [m] than any waterway's width.
MOST = 1e5
# How far off a bank is looked for [m].
REACH = 1000.0
# Over which [m] the depth goes from one area's to the next, on the deeper side.
SHELF = 0.01


def waterway_from_chart(chart: Chart, centreline: np.ndarray, reach: float = REACH) -> Waterway:
    """Measure a waterway in a chart along a centreline."""
    # centreline (n, 2) [deg]; reach [m]
    # On either side the bank is what the normals of the line meet first, by exact intersection with the chart's lines.
    # The depth is the least of the shallowest area that the line is in. Banks are vertical walls where a chart draws
    # them.
    if not 0 < reach < MOST:
        raise InputError(f"a reach of {reach} m is none; give a length over 0")
    if not chart.banks:
        raise InputError(f"{chart.name}: the chart has no banks; is it the right cell?")
    origin = origin_of(centreline)
    line = Centreline(projected(centreline, origin))
    points, gaps = _shores([projected(bank, origin) for bank in chart.banks], line, reach)
    starboard, port = (_bank(side, line, points, gaps, reach, chart.name) for side in ("starboard", "port"))
    depths = _depths([(_moved(area, origin), least) for area, least in chart.areas], line)
    return Waterway(line, starboard, port, depths, name=chart.name, origin=(float(origin[0]), float(origin[1])))


def _shores(banks: list[np.ndarray], line: Centreline, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """The banks within reach, cut where they cross, end to end; and which pieces between points are none of a bank."""
    import shapely

    near = shapely.buffer(shapely.LineString(line.at(line.fine)), 1.1 * reach)
    shores = shapely.intersection(shapely.union_all([shapely.LineString(bank) for bank in banks]), near)
    lines = [np.array(part.coords) for part in shapely.get_parts(shores) if part.geom_type == "LineString"]
    ends = np.cumsum([len(points) for points in lines])
    return np.concatenate([*lines, np.empty((0, 2))]), ends[:-1] - 1


def _bank(side: str, line: Centreline, points: np.ndarray, gaps: np.ndarray, reach: float, name: str) -> Bank:
    """The outline of the banks that the normals to one side see: between two corners they see one straight piece."""
    sign = 1 if side == "starboard" else -1
    normals = Normals(line, points, sign, gaps)
    corners = normals.corners() if len(points) > 1 else np.array([0.0, line.length])
    distance, piece = normals.first((corners[1:] + corners[:-1]) / 2)
    missing = ~(distance < reach)
    if missing.any():
        along = float(corners[int(missing.argmax())])
        raise InputError(
            f"{name}: no {side} bank within {reach:g} m at {along:.0f} m along the centreline; draw it where the chart "
            "has both banks, or look farther"
        )
    seen = [line.at(s, sign * normals.met(s, piece)) for s in (corners[:-1], corners[1:])]
    return bank_from_points(side, np.stack(seen, axis=1).reshape(-1, 2), line)


def _depths(areas: list[tuple[Any, float]], line: Centreline) -> tuple[np.ndarray, np.ndarray]:
    """Places where the line passes from area to area, and the depth there; the shallower reaches to the very edge."""
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
    """Least depth at places, NaN where there is none: a waterway names the hole."""
    import shapely

    points, depth = shapely.points(places), np.full(len(places), np.nan)
    for area, least in areas:
        inside = shapely.contains(area, points)
        depth[inside] = np.fmin(depth[inside], least)
    return depth


def _moved(area: Any, origin: np.ndarray) -> Any:
    import shapely

    return shapely.transform(area, lambda ring: projected(ring, origin))
