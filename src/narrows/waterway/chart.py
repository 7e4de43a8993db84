"""Electronic charts, S-57 and inland: the lines of banks and the areas of depth in a cell."""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from narrows.errors import InputError, needs

# Object classes that bound the water: coastline, shoreline construction, banks of canals and rivers.
BANKS = ("COALNE", "SLCONS", "canbnk", "rivbnk", "CANBNK", "RIVBNK")
# Object classes of a range of depths: depth areas, at sea and inland, and dredged areas.
DEPTH_AREAS = ("DEPARE", "depare", "DRGARE")
OPTIONS = {"SPLIT_MULTIPOINT": "ON", "ADD_SOUNDG_DEPTH": "ON", "UPDATES": "APPLY"}
# The code of depths in metres.
METRES = 1
# Layers of a cell read without the catalogue of object classes.
BARE = {"Point", "Line", "Area"}


@dataclass(frozen=True)
class Chart:
    """What a cell says of banks and depths, in WGS84."""

    banks: tuple[np.ndarray, ...]  # (n, 2) Lines, longitude and latitude [deg]
    # Areas with their holes, as Shapely has them, and the least depth in each [deg]
    areas: tuple[tuple[Any, float], ...]
    name: str  # Of the cell


def read_chart(path: str | Path) -> Chart:
    """Read the banks and depths of a cell of an electronic chart; updates beside it are applied."""
    pyogrio, path = _library(), Path(path)
    if not path.is_file():
        raise InputError(f"{path}: cannot be read (no such file); check the path")
    try:
        names = {str(name) for name in pyogrio.list_layers(path)[:, 0]}
        driver = pyogrio.read_info(path, layer=sorted(names)[0])["driver"]
        if driver != "S57" or names >= BARE:
            raise InputError(f"{path}: is not a cell of an electronic chart (S-57); give the .000 file")
        _check_metres(pyogrio, path)
        banks = [line for layer in BANKS if layer in names for line in _lines(pyogrio, path, layer)]
        areas = [area for layer in DEPTH_AREAS if layer in names for area in _areas(pyogrio, path, layer)]
    except pyogrio.errors.DataSourceError as error:
        raise InputError(f"{path}: is not a cell of an electronic chart ({str(error).split(';')[0]})") from None
    return Chart(tuple(banks), tuple(areas), path.stem)


def _library() -> Any:
    with needs("charts", "an electronic chart"):
        import pyogrio
        import pyogrio.errors
        import shapely  # noqa: F401
    return pyogrio


def _check_metres(pyogrio: Any, path: Path) -> None:
    fields = _read(pyogrio, path, "DSID", ("DSPM_DUNI",))[1]
    unit = fields["DSPM_DUNI"]
    if len(unit) and unit[0] != METRES:
        raise InputError(f"{path}: its depths are not in metres (unit {unit[0]}); convert the cell")


def _read(pyogrio: Any, path: Path, layer: str, columns: Sequence[str]) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
    """Geometries as WKB, and columns by name: the file has its own order, and leaves out what it does not have."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Attributes .* ignored", RuntimeWarning)
        meta, _, shapes, values = pyogrio.raw.read(
            path, layer=layer, columns=list(columns), read_geometry=layer != "DSID", **OPTIONS
        )
    return shapes, {str(name): value for name, value in zip(meta["fields"], values, strict=True)}


def _parts(shapes: np.ndarray, kind: str) -> Iterator[tuple[int, Any]]:
    import shapely

    parts, whose = shapely.get_parts(shapely.from_wkb(shapes), return_index=True)
    for part, number in zip(parts, whose.tolist(), strict=True):
        if part.geom_type == kind and not part.is_empty:
            yield number, part


def _lines(pyogrio: Any, path: Path, layer: str) -> Iterator[np.ndarray]:
    shapes, _ = _read(pyogrio, path, layer, ())
    for _, line in _parts(shapes, "LineString"):
        yield np.array(line.coords)[:, :2]
    for _, area in _parts(shapes, "Polygon"):
        for ring in (area.exterior, *area.interiors):
            yield np.array(ring.coords)[:, :2]


def _areas(pyogrio: Any, path: Path, layer: str) -> Iterator[tuple[Any, float]]:
    shapes, columns = _read(pyogrio, path, layer, ("DRVAL1",))
    least = columns.get("DRVAL1", np.full(len(shapes), np.nan))
    for number, area in _parts(shapes, "Polygon"):
        yield area, float(least[number])
