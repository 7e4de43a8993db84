"""The water for the engine: a straight canal, a waterway as a table, open water."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from narrows.base.errors import InputError
from narrows.codegen.choices import AFLOAT_SPEED, COLUMNS, FIELD, Across
from narrows.codegen.free_motion import OPEN, Outline
from narrows.codegen.kernels import event
from narrows.model.model import Model
from narrows.model.water import speeds_afloat
from narrows.physics.squat_and_depth import BOUNDLESS
from narrows.quantities.names import Number
from narrows.ship.particulars import Ship
from narrows.simulation.outcome import Code
from narrows.simulation.settings import HEADING_LIMIT, RATE_LIMIT, SPEED_LIMIT

if TYPE_CHECKING:
    from narrows.waterway.centreline import Centreline
    from narrows.waterway.table import LeastWalls, WaterwayTable
    from narrows.waterway.waterway import Waterway


@dataclass(frozen=True)
class Channel:
    inputs: Mapping[str, Number]  # Inputs by the names of the lines
    # A straight canal has no table.
    table: np.ndarray = field(default_factory=partial(np.zeros, 16))  # Table of a waterway, one row per cell
    track: np.ndarray = field(default_factory=partial(np.zeros, 27))  # Nodes of line and banks, for the exact clearance
    outline: np.ndarray = field(
        default_factory=partial(np.zeros, 6)
    )  # Points of the hull, forward and starboard alternating [m]
    start: float = -math.inf  # Start of the line; infinite in a straight canal [m]
    length: float = math.inf  # Length of the line; infinite in a straight canal [m]
    # (vessels or nodes,) True if too little water ends a voyage by choking of the section
    chokes: np.ndarray = field(default_factory=lambda: np.zeros(1, bool))

    def section(self, x: Any) -> dict[str, Any]:
        """Return width and depth of a waterway at places along it [m]; nothing of a straight canal."""
        if not math.isfinite(self.length):
            return {}
        cells = self.table.reshape(int(self.inputs["last_cell"]) + 1, -1)
        place = np.maximum(np.nan_to_num(np.asarray(x, float)) * self.inputs["cells_a_metre"], 0.0)
        cell = np.minimum(place, len(cells) - 1).astype(int)
        part = np.minimum(place - cell, 1.0)
        starboard, port, depth = (cells[cell, 2 * i] + part * cells[cell, 2 * i + 1] for i in range(3))
        return {"width": starboard + port, "depth": depth}

    def codes(self, ends: Any, x: Any) -> np.ndarray:
        ends = np.asarray(ends)
        choked = self.chokes
        if math.isfinite(self.length):
            node = np.rint(np.asarray(x) * self.inputs["cells_a_metre"])
            choked = choked[np.clip(np.nan_to_num(node), 0, len(choked) - 1).astype(int)]
        return np.where(ends == event.SHALLOW, np.where(choked, Code.CHOKED, Code.TOUCHED), ends)


def limits_of(contact: str | Outline | int) -> dict[str, float]:
    # In open water no heading counts as across: no cosine is below -2.
    least = -2.0 if contact == OPEN else math.cos(HEADING_LIMIT)
    return {"least_cos": least, "most_speed": SPEED_LIMIT, "most_rate": RATE_LIMIT}


def straight_channel(values: Mapping[str, Number], contact: str | Outline, bottom: bool = False) -> Channel:
    half = values["width"] / 2
    walls = {name: values.get(name, half) for name in ("wall_starboard", "wall_port")}
    inputs = {**hull_inputs(values, contact), **walls, **limits_of(contact)}
    if not bottom:
        return Channel(inputs)
    fastest, chokes = _afloat(values if contact != OPEN else {**values, "width": math.inf})
    return Channel({**inputs, AFLOAT_SPEED: fastest}, chokes=chokes)


def _afloat(values: Mapping[str, Number]) -> tuple[Any, np.ndarray]:
    """Return the speed through the water at which a voyage ends, and whether by choking the section."""
    if values.get("depth") is None:
        return BOUNDLESS, np.zeros(1, bool)
    with np.errstate(all="ignore"):
        touching, choking = speeds_afloat(values)
    fastest = np.minimum(touching, choking)
    # An unknown depth ends no voyage.
    known = np.where(np.isnan(fastest), BOUNDLESS, fastest)
    return known if known.ndim else float(known), np.atleast_1d(choking < touching)


def across_of(waterway: "Waterway | None") -> Across:
    """Return where a waterway has a current across, or a shear."""
    return "field" if waterway is not None and waterway.has_current_field else "none"


def along_waterway(waterway: "Waterway", model: Model, contact: str | Outline, bottom: bool = False) -> Channel:
    from narrows.waterway.table import STEPS_A_BEAM

    ship = model.configuration.ship
    waterway.check_fits(ship)
    outline = points_of(ship, contact)
    table, cells = _tabulated(waterway, ship.draft, waterway.step or ship.beam / STEPS_A_BEAM, tuple(outline))
    depth = table.depth
    if np.isnan(depth).all():
        cells, depth = cells.copy(), np.full(len(depth), model.configuration.canal.depth or math.nan)
        cells[:, 2 * COLUMNS.index("depth")] = depth[:-1]
        cells[:, 2 * COLUMNS.index("depth") + 1] = 0.0
    chokes = np.zeros(len(table.s), bool)
    if bottom:
        fastest, chokes = _afloat({**vars(ship), "width": table.starboard + table.port, "depth": depth})
        cells = np.column_stack([cells, fastest[:-1], np.diff(fastest)])
    return _from_cells(table, cells, outline, model, contact, waterway.reference_current, chokes)


def _from_cells(
    table: "WaterwayTable", cells: np.ndarray, outline: Any, model: Model, contact: str | Outline, current: float,
    chokes: np.ndarray,
) -> Channel:  # fmt: skip
    inputs = {
        "x_first": 0.0, "x_last": float(table.s[-1]), "cells_a_metre": 1 / table.step,
        "last_cell": float(len(cells) - 1), "current": current,
        **hull_inputs(model.configuration.values(), contact), **limits_of(contact),
    }  # fmt: skip
    return Channel(inputs, cells.ravel(), table.track, np.array(outline).ravel(), 0.0, float(table.s[-1]), chokes)


# Cached tables for as long as their centreline exists, since successive voyages use the same.
_TABLES: "WeakKeyDictionary[Centreline, dict[Any, tuple[WaterwayTable, np.ndarray]]]" = WeakKeyDictionary()


def _tabulated(
    waterway: "Waterway", draft: float, step: float, outline: tuple[tuple[float, float], ...]
) -> "tuple[WaterwayTable, np.ndarray]":
    from narrows.waterway.table import least_walls, tabulate

    known = _TABLES.setdefault(waterway.line, {})
    parts = waterway.starboard, waterway.port, waterway.depths
    field = (np.asarray(one, float).tobytes() for one in (waterway.current_across, waterway.current_shear))
    key = (draft, step, outline, waterway.level, waterway.current_pairs, *field, *map(id, parts))
    if key not in known:
        table = tabulate(waterway, draft, step)
        near = least_walls(table, np.array(outline))
        columns = (*COLUMNS, *FIELD * waterway.has_current_field)
        cells = _cells(table, near, columns)
        # The cache holds the waterway's parts, so that their memory addresses are not reused.
        known[key] = (table, cells)
        known[key, "parts"] = parts  # type: ignore[assignment]
    return known[key]


def _cells(table: "WaterwayTable", near: "LeastWalls", names: tuple[str, ...] = COLUMNS) -> np.ndarray:
    columns = {**vars(table), "near_starboard": near[0], "near_port": near[1]}
    cells = np.empty((len(table.s) - 1, 2 * len(names)))
    for index, name in enumerate(names):
        cells[:, 2 * index], cells[:, 2 * index + 1] = columns[name][:-1], np.diff(columns[name])
    return cells


def bend_channel(
    model: Model, contact: str | Outline, walls: tuple[float, float], curvature: float, current: float, length: float
) -> Channel:
    """Return the model's canal in a bend of constant curvature and a given length [m]."""
    # walls: where a keel meets the banks, to port and to starboard of the middle [m]; curvature to starboard [1/m]
    from narrows.waterway.table import STEPS_A_BEAM, WaterwayTable, least_walls

    ship, canal = model.configuration.ship, model.configuration.canal
    s = np.linspace(0.0, length, int(np.ceil(length * STEPS_A_BEAM / ship.beam)) + 1)
    half = canal.width / 2
    port, starboard = (min(wall, half) for wall in walls)
    columns = (half, half, starboard, port, canal.depth or math.nan, curvature, 1.0)
    table = WaterwayTable(s, *(np.full(len(s), column) for column in columns))
    outline = np.array(points_of(ship, contact))
    cells = _cells(table, least_walls(table, outline))
    return _from_cells(table, cells, outline, model, contact, current, np.zeros(1, bool))


def hull_inputs(values: Mapping[str, Number], contact: str | Outline) -> dict[str, Number]:
    inputs = {"half_length": values["length"] / 2, "half_beam": values["beam"] / 2}
    if isinstance(contact, str):
        return inputs
    points = {f"outline_forward_{i}": forward for i, (forward, _) in enumerate(contact)}
    return inputs | points | {f"outline_starboard_{i}": starboard for i, (_, starboard) in enumerate(contact)}


def points_of(ship: Ship, contact: str | Outline) -> list[tuple[float, float]]:
    a, b = ship.length / 2, ship.beam / 2
    if isinstance(contact, str):
        return [(a, b), (-a, b), (-a, -b), (a, -b)]
    from scipy.spatial import ConvexHull

    points = np.array(contact)
    return [(float(forward), float(starboard)) for forward, starboard in points[ConvexHull(points).vertices]]


def check_outline(ship: Ship, contact: str | Outline, has_bank: bool) -> None:
    """Raise if an outline lies inside the beam, where the suction becomes infinite before the hull touches."""
    if isinstance(contact, str):
        return
    from scipy.spatial import QhullError

    try:
        points = np.array(points_of(ship, contact))
    except QhullError:
        raise InputError("contact: an outline's points lie on one line; give the outline of a hull") from None
    reach = points[:, 1].max(), -points[:, 1].min()
    if has_bank and min(reach) < ship.beam / 2 * (1 - 1e-9):
        raise InputError(
            f"contact: the outline reaches {min(reach):.4g} m from the centreline and the beam is {ship.beam:.4g} m: "
            "the bank's suction is infinite before it touches; make it as wide as the beam"
        )
