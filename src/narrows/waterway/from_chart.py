"""A waterway out of a chart: rays square to a centreline, to the nearest bank on either side."""

import numpy as np

from narrows.errors import InputError
from narrows.waterway.banks import Bank
from narrows.waterway.centreline import Centreline
from narrows.waterway.chart import Chart
from narrows.waterway.projection import origin_of, projected
from narrows.waterway.waterway import Waterway

STATIONS = 400
MOST = 1e5
"""Longer [m] than any waterway's width or spacing."""
REACH = 1000.0
"""How far off a bank is looked for [m]."""


def waterway_from_chart(
    chart: Chart, centreline: np.ndarray, spacing: float | None = None, reach: float = REACH
) -> Waterway:
    """Measure a waterway in a chart along a centreline (ours).

    At each station the nearest bank square to the line is taken on either side, and the least depth of the shallowest
    area that the line is in. Banks are vertical walls where a chart draws them.

    Parameters
    ----------
    chart : Chart
        Banks and depths.
    centreline : array (n, 2) [deg]
        Longitude and latitude.
    spacing : float [m], optional
        Between stations; a four-hundredth of the line unless given.
    reach : float [m]
        How far off a bank is looked for.

    Raises
    ------
    InputError
        Where a length is not positive, a bank or the depth is missing at a place, or the geometry is impossible.
    """
    import shapely

    if not (0 < reach < MOST and (spacing is None or 0 < spacing < MOST)):
        raise InputError(f"a reach of {reach} m and a spacing of {spacing} m: give lengths over 0")
    origin = origin_of(centreline)
    line = Centreline(projected(centreline, origin))
    count = STATIONS if spacing is None else max(2, round(line.length / spacing))
    s = np.linspace(0, line.length, count + 1)
    if not chart.banks:
        raise InputError(f"{chart.name}: the chart has no banks; is it the right cell?")
    shores = shapely.union_all([shapely.LineString(projected(bank, origin)) for bank in chart.banks])
    banks = {side: _bank(side, line, s, shores, reach, chart.name) for side in ("starboard", "port")}
    depths = (s, _depth(chart, line.at(s), origin))
    return Waterway(
        line, banks["starboard"], banks["port"], depths, name=chart.name, origin=(float(origin[0]), float(origin[1]))
    )


def _bank(side: str, line: Centreline, s: np.ndarray, shores: object, reach: float, name: str) -> Bank:
    import shapely

    middle, far = line.at(s), line.at(s, reach if side == "starboard" else -reach)
    met = shapely.intersection(shapely.linestrings(np.stack([middle, far], axis=1)), shores)
    distance = shapely.distance(shapely.points(middle), met)
    missing = ~np.isfinite(distance)
    if missing.any():
        place = float(s[int(missing.argmax())])
        raise InputError(
            f"{name}: no {side} bank within {reach:g} m at {place:.0f} m along the centreline; draw it where the chart "
            "has both banks, or look farther"
        )
    return Bank(side, s, distance)


def _depth(chart: Chart, places: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Least depth at places, NaN where there is none: a waterway names the hole."""
    import shapely

    points, depth = shapely.points(places), np.full(len(places), np.nan)
    for area, least in chart.areas:
        inside = shapely.contains(shapely.transform(area, lambda ring: projected(ring, origin)), points)
        depth[inside] = np.fmin(depth[inside], least)
    return depth
