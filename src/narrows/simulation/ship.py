"""A model, its water and its control law as a traced system with its inputs, for voyages, fleets and the envelope."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from narrows.base.errors import InputError, check_choice
from narrows.codegen import free_motion
from narrows.codegen.free_motion import INPUTS, OPEN, STATE, Across, Actuated, Choices, Law, Outline, Pushed, Surge
from narrows.codegen.kernels import event
from narrows.codegen.linearisation import Linearisation
from narrows.codegen.system import System
from narrows.codegen.trace import trace_of
from narrows.model.model import Model
from narrows.model.term import TermTable
from narrows.model.water import speeds_afloat
from narrows.physics.squat_and_depth import BOUNDLESS
from narrows.quantities.arithmetic import angle
from narrows.quantities.names import FORCES, Number
from narrows.ship.checks import check_ahead
from narrows.ship.particulars import Ship
from narrows.simulation.controllers import ControlLaw, Controller, ExternalOrder, Named, Order
from narrows.simulation.inputs import START, Contact, check_flag, check_options
from narrows.simulation.outcome import Code
from narrows.simulation.settings import HEADING_LIMIT, RATE_LIMIT, SPEED_LIMIT
from narrows.waterway.centreline import Centreline
from narrows.waterway.waterway import STEPS_A_BEAM, Waterway, WaterwayTable, least_walls, tabulate


@dataclass(frozen=True)
class Channel:
    inputs: Mapping[str, Number]  # Inputs by the names of the lines
    # A straight canal has no table.
    table: np.ndarray = field(default_factory=partial(np.zeros, 16))  # Table of a waterway, one row per cell
    track: np.ndarray = field(default_factory=partial(np.zeros, 27))  # Nodes of line and banks, for the exact clearance
    outline: np.ndarray = field(default_factory=partial(np.zeros, 6))  # Points of the hull: forward, starboard, ... [m]
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


def straight_channel(values: Mapping[str, Number], contact: str | Outline, bottom: bool = False) -> Channel:
    half = values["width"] / 2
    walls = {name: values.get(name, half) for name in ("wall_starboard", "wall_port")}
    inputs = {**hull_inputs(values, contact), **walls}
    if not bottom:
        return Channel(inputs)
    fastest, chokes = _afloat(values if contact != OPEN else {**values, "width": math.inf})
    return Channel({**inputs, free_motion.AFLOAT_SPEED: fastest}, chokes=chokes)


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


def along_waterway(waterway: Waterway, model: Model, contact: str | Outline, bottom: bool = False) -> Channel:
    ship = model.configuration.ship
    waterway.check_fits(ship)
    outline = points_of(ship, contact)
    table, cells = _tabulated(waterway, ship.draft, waterway.step or ship.beam / STEPS_A_BEAM, tuple(outline))
    depth = table.depth
    if np.isnan(depth).all():
        cells, depth = cells.copy(), np.full(len(depth), model.configuration.canal.depth or math.nan)
        cells[:, 2 * free_motion.COLUMNS.index("depth")] = depth[:-1]
        cells[:, 2 * free_motion.COLUMNS.index("depth") + 1] = 0.0
    chokes = np.zeros(len(table.s), bool)
    if bottom:
        fastest, chokes = _afloat({**vars(ship), "width": table.starboard + table.port, "depth": depth})
        cells = np.column_stack([cells, fastest[:-1], np.diff(fastest)])
    return _from_cells(table, cells, outline, model, contact, waterway.reference_current, chokes)


def _from_cells(
    table: WaterwayTable, cells: np.ndarray, outline: Any, model: Model, contact: str | Outline, current: float,
    chokes: np.ndarray,
) -> Channel:  # fmt: skip
    inputs = {
        "x_first": 0.0, "x_last": float(table.s[-1]), "cells_a_metre": 1 / table.step,
        "last_cell": float(len(cells) - 1), "current": current,
        **hull_inputs(model.configuration.values(), contact),
    }  # fmt: skip
    return Channel(inputs, cells.ravel(), table.track, np.array(outline).ravel(), 0.0, float(table.s[-1]), chokes)


# Cached tables for as long as their centreline exists, since successive voyages use the same.
_TABLES: WeakKeyDictionary[Centreline, dict[Any, tuple[WaterwayTable, np.ndarray, Any]]] = WeakKeyDictionary()


def _tabulated(
    waterway: Waterway, draft: float, step: float, outline: tuple[tuple[float, float], ...]
) -> tuple[WaterwayTable, np.ndarray]:
    known = _TABLES.setdefault(waterway.line, {})
    parts = waterway.starboard, waterway.port, waterway.depths
    field = (np.asarray(one, float).tobytes() for one in (waterway.current_across, waterway.current_shear))
    key = (draft, step, outline, waterway.level, waterway.current_pairs, *field, *map(id, parts))
    if key not in known:
        table = tabulate(waterway, draft, step)
        near = least_walls(table, np.array(outline))
        columns = (*free_motion.COLUMNS, *free_motion.FIELD * waterway.has_current_field)
        # The cache holds the waterway's parts, so that their memory addresses are not reused.
        known[key] = table, _cells(table, near, columns), parts
    return known[key][:2]


def _cells(table: WaterwayTable, near: np.ndarray, names: tuple[str, ...] = free_motion.COLUMNS) -> np.ndarray:
    columns = {**vars(table), "near_starboard": near[0], "near_port": near[1]}
    return np.column_stack([part for name in names for part in (columns[name][:-1], np.diff(columns[name]))])


def bend_channel(
    model: Model, contact: str | Outline, walls: tuple[float, float], curvature: float, current: float, length: float
) -> Channel:
    """Return the model's canal in a bend of constant curvature and a given length [m]."""
    # walls: where a keel meets the banks, to port and to starboard of the middle [m]; curvature to starboard [1/m]
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
    # In open water no heading counts as across: no cosine is below -2.
    least = -2.0 if contact == OPEN else math.cos(HEADING_LIMIT)
    inputs = {
        "half_length": values["length"] / 2, "half_beam": values["beam"] / 2, "least_cos": least,
        "most_speed": SPEED_LIMIT, "most_rate": RATE_LIMIT,
    }  # fmt: skip
    if isinstance(contact, str):
        return inputs
    points = {f"outline_forward_{i}": forward for i, (forward, _) in enumerate(contact)}
    return inputs | points | {f"outline_starboard_{i}": starboard for i, (_, starboard) in enumerate(contact)}


def points_of(ship: Ship, contact: str | Outline) -> list[tuple[float, float]]:
    a, b = ship.length / 2, ship.beam / 2
    if isinstance(contact, str):
        return [(a, b), (-a, b), (-a, -b), (a, -b)]
    from scipy.spatial import ConvexHull, QhullError

    points = np.array(contact)
    try:
        corners = points[ConvexHull(points).vertices]
    except QhullError:
        raise InputError("contact: an outline's points lie on one line; give the outline of a hull") from None
    return [(float(forward), float(starboard)) for forward, starboard in corners]


def check_outline(ship: Ship, contact: Outline, has_bank: bool) -> None:
    """Raise if an outline lies inside the beam, where the suction becomes infinite before the hull touches."""
    points = np.array(points_of(ship, contact))
    reach = points[:, 1].max(), -points[:, 1].min()
    if has_bank and min(reach) < ship.beam / 2 * (1 - 1e-9):
        why = "the bank's suction is infinite before it touches; make it as wide as the beam"
        raise InputError(f"contact: the outline reaches {min(reach):.4g} m, the beam is {ship.beam:.4g} m: {why}")


# Points of the waterline: (forward of midship, to starboard) [m].
Points = Sequence[Sequence[float]]


@dataclass(frozen=True)
class SimulatedShip:
    model: Model  # The ship in its canal
    surge: Surge = "held"  # ``held``: constant speed; ``free``: it is integrated
    surge_inertia: float | None = None  # Mass in surge with its added mass, for ``free`` [kg]
    coriolis: bool = False  # Add the rigid body's Coriolis force; damping fitted at one speed already contains it
    # ``corners`` of the hull's rectangle, ``midship`` as in the paper, or an outline of (forward, starboard);
    # ``none`` in open water [m]
    contact: Contact | Points = "corners"
    bottom: bool = False  # True if bottom contact or a choked section ends a voyage

    def __post_init__(self) -> None:
        check_options(self.surge, self.surge_inertia, self.coriolis, self.contact)
        check_flag("bottom", self.bottom)
        if self.shape == OPEN and self.model.terms.has_bank:
            raise InputError("contact 'none' is open water, and these terms have a bank; choose 'corners'")
        if self.model.terms.propelled and self.model.configuration.propeller is None:
            raise InputError("this model's terms need a propeller; give [propeller] in its file")
        if self.surge == "free" and not self.values()["surge_inertia"] + self.model.surge_inertia > 0:
            remedy = "give surge_inertia in kg, mass and added mass together, or hold the speed"
            raise InputError(f"this model has no mass in surge (its tests held the speed): {remedy}")

    @cached_property
    def shape(self) -> str | Outline:
        if isinstance(self.contact, str):
            return self.contact
        outline = tuple((float(forward), float(starboard)) for forward, starboard in self.contact)
        ship, has_bank = self.model.configuration.ship, self.model.terms.has_bank
        check_outline(ship, outline, has_bank)
        # The suction of a bank becomes infinite when a side meets it at midship: contact must not come later.
        return (*outline, (0.0, ship.beam / 2), (0.0, -ship.beam / 2)) if has_bank else outline

    @cached_property
    def actuators(self) -> tuple[Actuated, ...]:
        gear = self.model.configuration.gear
        late = bool(gear.dead_time or gear.lag or gear.dead_band_deg)
        return tuple(Actuated(one.name, one.angle, late and one.name == "rudder") for one in self.model.terms.actuators)

    def system(
        self, waterway: bool = False, law: Law | None = None, pushed: Pushed = "never", across: Across = "none"
    ) -> System:
        contact = self.shape if isinstance(self.shape, str) else len(self.shape)
        chosen = Choices(contact, waterway, law, pushed, self.bottom, across)
        return _system(self.model.terms, self.surge, self.coriolis, chosen)

    def values(self, **positions: Number) -> dict[str, Number]:
        """Return every particular and coefficient by name, with the limits of the gear."""
        check_ahead(positions.get("revolutions"), self.model.configuration.propeller)
        # The equations add this to the table's own mass in surge; the user gives the sum.
        added = 0.0 if self.surge_inertia is None else self.surge_inertia - self.model.surge_inertia
        rest = {name: at for actuator in self.model.terms.actuators for name, at in actuator.at_rest().items()}
        ship = {**rest, **self.model.configuration.values(), **self.model.coefficients}
        for actuator in self.model.terms.actuators:
            if actuator.name in positions:
                ship |= {actuator.name: positions[actuator.name], **actuator.placed(positions[actuator.name])}
        return {**ship, "heave": 0.0, "surge_inertia": added}

    def rates(self, values: Mapping[str, Number], at: Mapping[str, Any]) -> dict[str, Any]:
        """Return the rates of x, y, psi, u, v, r at a state, positions of actuators and external forces."""
        system, x, y, psi, u, v, r = self.system(pushed="always"), *(at[name] for name in START)
        values = {**values, **{INPUTS[force]: at.get(force, 0.0) for force in FORCES}}
        for actuator in self.model.terms.actuators:
            values |= actuator.placed(at[actuator.name]) if actuator.name in at else {}
        values |= system.constants(values)
        inputs = (values[name] for name in system.columns.RATES_INPUTS)
        found = system.columns.rates(x, y, np.cos(psi), np.sin(psi), u, v, r, *inputs)
        return dict(zip(STATE, found, strict=True)) | {"psi": r}

    def channel(self, waterway: Waterway | None, values: Mapping[str, Number]) -> Channel:
        if waterway is None:
            return straight_channel(values, self.shape, self.bottom)
        return along_waterway(waterway, self.model, self.shape, self.bottom)

    def linearisation(self, values: Mapping[str, Number]) -> Linearisation:
        return self.system().linearisation(values, self.actuators)


@lru_cache(maxsize=64)
def _system(terms: TermTable, surge: Any, coriolis: bool, chosen: Choices) -> System:
    return System(terms, surge, coriolis, chosen)


CURRENT, WATER_PREFIX = "current", "water_"
# Names in the lines of a law's numbers and its memory.
PARAMETER, MEMORY = "law_{}".format, "memory_{}".format


@dataclass(frozen=True)
class Steering:
    law: Law  # The traced law for the engine's steps
    parameters: Mapping[str, Any]  # Numbers by the names of the lines
    controller: ControlLaw  # The original controller
    asked: Controller | Order | None = None  # An object or function of Python that gives the orders, if it is no law

    def memory(self, start: Named) -> dict[str, Number]:
        return {MEMORY(name): value for name, value in self.controller.memory(start).items()}


def steering_of(controller: Any, actuators: Sequence[Actuated], single: bool = True) -> Steering | None:
    """Trace a controller; an object or function of Python is one of single voyages in Python."""
    law, asked = controller, None
    if controller is None:
        return None
    if not isinstance(controller, ControlLaw):
        law, asked = ExternalOrder(), controller
        if not isinstance(controller, Controller) and (not callable(controller) or isinstance(controller, type)):
            what = f"a {type(controller).__name__} is no controller: it has neither `orders` (a law) nor `begin`"
            remedy = "nw.control.regulator(model, y, u) is one"
            raise InputError(f"{what}, and is no function of time and state; {remedy}")
        if not single:
            law = "a law in arithmetic (with `parameters`, `memory` and `orders`), such as a regulator"
            raise InputError(f"a {type(controller).__name__} steers in nw.simulate alone; write it as {law}")
    parameters = dict(law.parameters())
    memory = tuple(law.memory(dict.fromkeys((*STATE, *(actuator.name for actuator in actuators)), 0.0)))
    traced = _law(law, tuple(parameters), memory, tuple(actuators))
    return Steering(traced, {PARAMETER(name): value for name, value in parameters.items()}, law, asked)


def _law(
    controller: ControlLaw, parameters: Sequence[str], kept: Sequence[str], actuators: tuple[Actuated, ...]
) -> Law:
    what, known = f"the controller {type(controller).__name__}", [actuator.name for actuator in actuators]
    gear = [f"{actuator.name}{of}" for actuator in actuators for of in ("", "_limit", "_rate")]
    quantities = {name: name for name in (*STATE, free_motion.TIME, CURRENT, *gear)} | {"dt": free_motion.LENGTH}
    ours = {name: PARAMETER(name) for name in parameters} | {name: MEMORY(name) for name in kept}
    for name in ours:
        if name in quantities or name in ("psi", "water") or (name in parameters and name in kept):
            raise InputError(f"{what} has a number called {name!r}, which means something else already; rename it")

    def results(at: Any) -> dict[str, Number]:
        at.psi, at.water = angle(at.cos_psi, at.sin_psi), water
        orders, memory = controller.orders(at)
        for name in orders:
            if name not in known:
                has = f"it has {', '.join(known)}; add them" if known else "nw.borrow_rudder adds a rudder"
                raise InputError(f"{what} gives orders to {name}, for which this model has no terms: {has}")
        if set(memory) != set(kept):
            raise InputError(f"{what} keeps {sorted(memory)}, not {sorted(kept)}; return the same memory each step")
        return {**orders, **{MEMORY(name): value for name, value in memory.items()}}

    trace = trace_of(results, {**quantities, **ours}, what)
    ordered = tuple(one for one in actuators if one.name in trace.results)
    return Law(trace, tuple(MEMORY(name) for name in kept), ordered)


def water(name: str, x: Any) -> Any:
    # name [1/m]; x [m]
    check_choice("the observed section", name, [known.removeprefix(WATER_PREFIX) for known in free_motion.WATER])
    return x.apply_function(f"{WATER_PREFIX}{name}", (x,))
