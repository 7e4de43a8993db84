"""Many states of one ship, advanced at once by the compiled kernel: arrays are allocated once."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.errors import InputError
from narrows.codegen.cache import compiled_loops
from narrows.codegen.choices import COLUMNS, ROW, SHARED
from narrows.codegen.free_motion import INPUTS as FORCES
from narrows.codegen.system import DEFAULTS
from narrows.quantities.names import Number
from narrows.simulation import lane_loops
from narrows.simulation.controllers import WithoutMemory
from narrows.simulation.inputs import INPUTS, START
from narrows.simulation.kernel_run import PUSH_END, KernelRun, PreparedRun
from narrows.simulation.ship import PARAMETER, SimulatedShip, steering_of
from narrows.waterway.centreline import check_along_only

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

RUDDER = "rudder"
# Place along a waterway that no lane reaches [m].
ENDLESS = 1e12


class ActuatorRates(WithoutMemory):
    """A law of prescribed rates of actuators."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)

    def parameters(self) -> dict[str, float]:
        return {f"turning_{name}": 0.0 for name in self.names}

    def orders(self, at: Any) -> tuple[dict[str, Number], dict[str, Number]]:
        return {name: getattr(at, name) + getattr(at, f"turning_{name}") * at.dt for name in self.names}, {}


class ShipLanes:
    """States of one ship, one per lane, each with its own forces, bank strength and coefficients."""

    def __init__(
        self, ship: SimulatedShip, states: Sequence[str], lanes: int, waterway: "Waterway | None" = None,
        coefficients: np.ndarray | None = None, *, pushed: bool = False, endless: bool = False,
    ) -> None:  # fmt: skip
        if waterway is not None:
            check_along_only(waterway, "an estimate or a plan")
        # states: x, y, psi, u, v, r, then any of bank, current, current_across and rudder_bias. coefficients (lanes,
        # coefficients), the model's unless given. endless: beyond its ends the waterway has its last sections.
        self.ship, self.lanes, self.waterway, self.coefficients = ship, lanes, waterway, coefficients
        self.places = {name: place for place, name in enumerate(states)}
        self.actuators = tuple(actuator.name for actuator in ship.actuators)
        self.silent = {term.name: 0.0 for term in ship.model.terms.terms if term.from_bank}
        law = ActuatorRates(self.actuators)
        placed = [replace(one, late=False) for one in ship.actuators]  # Positions are given instead of orders
        steering = steering_of(law, placed) if self.actuators else None
        self._run = KernelRun(ship, 1.0, 1.0, steering=steering, waterway=waterway)
        # With an end of the push, forces are inputs of their own that each call may change.
        self._forces = {**dict.fromkeys(INPUTS, np.zeros(lanes)), PUSH_END: np.inf} if pushed else dict(INPUTS)
        self.prepared = self._laid_out(1.0)
        kernel = self.prepared.kernel
        kept = [kernel.KEPT_NAMES.index(name) for name in self.actuators]
        self._inputs = {name: place for place, name in enumerate(kernel.VESSEL_INPUTS)}
        rates = [self._inputs[PARAMETER(f"turning_{name}")] for name in self.actuators]
        rudder = self.actuators.index(RUDDER) if RUDDER in self.actuators else -1
        self._movers = np.array(kept, int), np.array(rates, int), rudder
        own = "bank", "current", "current_across", "rudder_bias"
        self._columns_of_states = np.array([self.places.get(name, -1) for name in own])
        self._pushes = [self._inputs[name] for name in (FORCES["Y"], FORCES["N"])] if pushed else []
        self._system = self._run.system(self._values(1.0))
        self._ship_values: dict[str, Any] = {**DEFAULTS, **ship.values()}
        self._constants = [self._inputs.get(name) for name in self._system.scalar.CONSTANTS]
        self._base, self._slope = self._by_bank()
        self._none = np.zeros_like(self._base)
        self._water = self.prepared.channel.table.reshape(-1, ROW) if waterway else None
        self._endless, self._lasting = endless, (0.0, 0)
        if endless:
            self.prepared.shared[SHARED.index("x_last")] = ENDLESS

    def _values(self, bank: float) -> dict[str, Any]:
        model = self.ship.model
        numbers = {name: np.full(self.lanes, value) for name, value in model.coefficients.items()}
        if self.coefficients is not None:
            numbers = dict(zip(model.terms.names, self.coefficients.T, strict=True))
        numbers |= {name: bank * numbers[name] for name in self.silent}
        # An actuator is at its indicated position: no limit and no rate apply.
        limits = {f"{name}_{of}": 1e9 for name in self.actuators for of in ("limit", "rate")}
        law = {PARAMETER(f"turning_{name}"): np.zeros(self.lanes) for name in self.actuators}
        return {**dict.fromkeys(START, 0.0), **self._forces, "u": 1.0, **numbers, **limits, **law}

    def _laid_out(self, bank: float) -> PreparedRun:
        return self._run.prepared(self._values(bank), self.lanes, workers=1)

    def _by_bank(self) -> tuple[np.ndarray, np.ndarray]:
        """Inputs of each lane without a bank, and the addition of a bank of strength 1."""
        full = self.prepared.vessel_inputs.copy()
        if "bank" not in self.places or not self.silent:
            return full, np.zeros_like(full)
        none, double = self._laid_out(0.0).vessel_inputs, self._laid_out(2.0).vessel_inputs
        # If a lane's inputs are affine in the strength, they are this sum.
        if not (np.abs(double - 2 * full + none) <= 1e-9 * (np.abs(full) + np.abs(none))).all():
            raise InputError("the bank's terms of this model hold accelerations, so its strength cannot be estimated")
        return none, full - none

    def bend(self, x: float) -> float:
        return self._column("curvature", x)

    def _known_current(self, x: float) -> float:
        return self._column("flow", x) * (self.waterway.reference_current if self.waterway else 0.0)

    def _column(self, name: str, x: float) -> float:
        if self._water is None or self.waterway is None:
            return 0.0
        cells = len(self._water)
        place = min(max(x / self.waterway.line.length * cells, 0.0), cells - 1e-9)
        first, rise = self._water[int(place), 2 * COLUMNS.index(name) :][:2]
        return float(first + (place - int(place)) * rise)

    def advance(
        self, points: np.ndarray, duration: float, start: np.ndarray, end: np.ndarray,
        columns: np.ndarray | None = None, pushes: np.ndarray | None = None, steps: int = 1,
    ) -> np.ndarray:  # fmt: skip
        """Advance states (lanes, states), with actuators from start to end (actuators,) or (lanes, actuators)."""
        # columns: inputs of the lanes, (lanes, inputs); pushes: sway force and yaw moment, (lanes, 2) [N, N m].
        # The current's difference from the waterway's moves the ship half before and half after the step.
        run, loops, places = self.prepared, compiled_loops(lane_loops), self._columns_of_states
        x, (base, slope) = float(points[0, 0]), (self._base, self._slope) if columns is None else (columns, self._none)
        known = self._known_current(x)
        least = 1e-3 if self._endless else -math.inf  # A lane at the very start of a waterway would be at its end
        after = loops.depart(
            points, places, run.start, run.vessel_inputs, base, slope, *self._movers, np.atleast_2d(start),
            np.atleast_2d(end), duration, self.bend(x), known, least,
        )  # fmt: skip
        if self._lasting != (duration, steps):
            run.times[:], self._lasting = (duration / steps, steps, 0.0), (duration, steps)
        if pushes is not None:
            run.vessel_inputs[:, self._pushes] = pushes
        run()
        x, before = float(after[0, 0] + run.end[0, 0] - run.start[0, 0]), known
        known = self._known_current(x)
        loops.arrive(after, places, run.start, run.end, 0.5 * duration, self.bend(x), known, known - before)
        return np.asarray(after)

    @property
    def aground(self) -> np.ndarray:
        """Lanes that met a bank, an end of the waterway or the limit of heading in the last step."""
        return np.asarray(self.prepared.codes[:, 0] != 0)

    def columns_of(self, coefficients: np.ndarray, bank: np.ndarray) -> np.ndarray:
        numbers = dict(zip(self.ship.model.terms.names, coefficients.T, strict=True))
        numbers |= {name: bank * numbers[name] for name in self.silent}
        known = self._ship_values | numbers
        with np.errstate(all="ignore"):
            constants = self._system.columns.constants(*map(known.__getitem__, self._system.parameters))
        columns = self._base.copy()
        for place, constant in zip(self._constants, constants, strict=True):
            if place is not None:
                columns[:, place] = constant
        if not np.isfinite(columns).all():
            self._system.constants(known)  # Raises an error with the reason
        return columns
