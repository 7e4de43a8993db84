"""The ship between measurements: many states advanced at once, as lanes of the compiled kernel."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.codegen.choices import COLUMNS, ROW
from narrows.codegen.run import PreparedRun
from narrows.errors import InputError
from narrows.estimation.states import StateNames
from narrows.quantities.names import Number
from narrows.simulation.inputs import INPUTS, START
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import PARAMETER, steering_of

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

RUDDER = "rudder"


@dataclass(frozen=True)
class PrescribedActuators:
    """A law of prescribed actuator positions."""

    names: tuple[str, ...]  # Names of the actuators

    def parameters(self) -> dict[str, float]:
        return {f"next_{name}": 0.0 for name in self.names}

    def memory(self, start: Any) -> dict[str, Number]:
        return {}

    def orders(self, at: Any) -> tuple[dict[str, Number], dict[str, Number]]:
        return {name: getattr(at, f"next_{name}") for name in self.names}, {}


@dataclass
class ShipLanes:
    """States of one ship, one per lane, each with its own bank strength and coefficients."""

    ship: SimulatedShip  # The ship
    states: StateNames  # States in a lane's row
    lanes: int  # Number of lanes
    waterway: "Waterway | None" = None  # Waterway instead of the model's own canal
    coefficients: np.ndarray | None = None  # (lanes, coefficients) Coefficients of each lane; the model's unless given
    prepared: PreparedRun = field(init=False)

    def __post_init__(self) -> None:
        terms = self.ship.model.terms
        self.actuators = tuple(actuator.name for actuator in self.ship.actuators)
        self.silent = {term.name: 0.0 for term in terms.terms if term.from_bank}
        steering = (
            steering_of(PrescribedActuators(self.actuators), self.ship.placed_actuators) if self.actuators else None
        )
        self._run = KernelRun(self.ship, 1.0, 1.0, steering=steering, waterway=self.waterway)
        self.prepared = self._laid_out(1.0)
        kernel = self.prepared.kernel
        self._kept = {name: place for place, name in enumerate(kernel.KEPT_NAMES)}
        self._inputs = {name: place for place, name in enumerate(kernel.VESSEL_INPUTS)}
        self._told = [self._inputs[PARAMETER(f"next_{name}")] for name in self.actuators]
        self._system, self._ship_values = self._run._system(self._values(1.0)), self.ship.values()
        self._base, self._slope = self._by_bank()
        self._water = self.prepared.water.table.reshape(-1, ROW) if self.waterway else None
        self._velocities = slice(self.states.places["u"], self.states.places["r"] + 1)

    def _values(self, bank: float) -> dict[str, Any]:
        model = self.ship.model
        numbers = {name: np.full(self.lanes, value) for name, value in model.coefficients.items()}
        if self.coefficients is not None:
            numbers = dict(zip(model.terms.names, self.coefficients.T, strict=True))
        numbers |= {name: bank * numbers[name] for name in self.silent}
        # An actuator is at its indicated position: no limit and no rate apply.
        limits = {f"{name}_{of}": 1e9 for name in self.actuators for of in ("limit", "rate")}
        law = {PARAMETER(f"next_{name}"): np.zeros(self.lanes) for name in self.actuators}
        start: dict[str, Any] = dict.fromkeys((*START, *INPUTS), 0.0)
        return {**start, "u": 1.0, **numbers, **limits, **law}

    def _laid_out(self, bank: float) -> PreparedRun:
        return self._run.prepared(self._values(bank), self.lanes, workers=1)

    def _by_bank(self) -> tuple[np.ndarray, np.ndarray]:
        """Inputs of each lane without a bank, and the addition of a bank of strength 1."""
        full = self.prepared.vessel_inputs.copy()
        if not self.silent:
            return full, np.zeros_like(full)
        none, double = self._laid_out(0.0).vessel_inputs, self._laid_out(2.0).vessel_inputs
        # If a lane's inputs are affine in the strength, they are this sum.
        if not (np.abs(double - 2 * full + none) <= 1e-9 * (np.abs(full) + np.abs(none))).all():
            raise InputError("the bank's terms of this model hold accelerations, so its strength cannot be estimated")
        return none, full - none

    def bend(self, x: float) -> float:
        """Return the curvature of the line at a place [1/m]."""
        return self._column("curvature", x)

    def _known_current(self, x: float) -> float:
        """Return the waterway's own current at a place [m/s]."""
        return self._column("flow", x) * (self.waterway.reference_current if self.waterway else 0.0)

    def _column(self, name: str, x: float) -> float:
        if self._water is None or self.waterway is None:
            return 0.0
        cells = len(self._water)
        place = min(max(x / self.waterway.line.length * cells, 0.0), cells - 1e-9)
        first, rise = self._water[int(place), 2 * COLUMNS.index(name) :][:2]
        return float(first + (place - int(place)) * rise)

    def advance(
        self, points: np.ndarray, duration: float, start: np.ndarray, end: np.ndarray, columns: np.ndarray | None = None
    ) -> np.ndarray:
        """Advance states (lanes, states), with actuators from start to end (actuators,) and inputs (lanes, inputs)."""
        # The current's difference from the waterway's moves the ship half before and half after the step.
        after = points.copy()
        self._drift(after, duration / 2)
        self._load(after, duration, start, end, columns)
        self.prepared()
        self._unload(after)
        if "current" in self.states.places:
            changed = self._known_current(float(after[0, 0])) - self._known_current(float(points[0, 0]))
            after[:, self.states.places["current"]] += changed
        self._drift(after, duration / 2)
        return after

    def _drift(self, points: np.ndarray, duration: float) -> None:
        places = self.states.places
        if "current" in places and self._water is None:
            points[:, 0] += duration * points[:, places["current"]]
        elif "current" in places:
            x = float(points[0, 0])
            bend = self.bend(x)
            gone = duration * (points[:, places["current"]] - self._known_current(x)) / (1.0 - bend * points[:, 1])
            points[:, 2] -= bend * gone
            points[:, 0] += gone
        if "current_across" in places:
            points[:, 1] += duration * points[:, places["current_across"]]

    def _load(
        self, points: np.ndarray, duration: float, start: np.ndarray, end: np.ndarray, columns: np.ndarray | None
    ) -> None:
        rows, kept, places = self.prepared.start, self._kept, self.states.places
        rows[:, :2] = points[:, :2]
        np.cos(points[:, 2], out=rows[:, 2])
        np.sin(points[:, 2], out=rows[:, 3])
        rows[:, 4:7] = points[:, self._velocities]
        self.prepared.times[:] = (duration, 1.0, 0.0)
        inputs = self.prepared.vessel_inputs
        if columns is not None:
            inputs[:] = columns
        elif "bank" in places:
            np.multiply(points[:, places["bank"], None], self._slope, out=inputs)
            inputs += self._base
        for number, name in enumerate(self.actuators):
            bias = points[:, places["rudder_bias"]] if name == RUDDER and "rudder_bias" in places else 0.0
            rows[:, kept[name]] = start[..., number] + bias
            inputs[:, self._told[number]] = end[..., number] + bias

    def _unload(self, after: np.ndarray) -> None:
        """Write the lanes' states; the heading by its change, so that whole turns are kept."""
        rows, ended = self.prepared.start, self.prepared.end
        cosine, sine = rows[:, 2], rows[:, 3]
        turned = np.arctan2(ended[:, 3] * cosine - ended[:, 2] * sine, ended[:, 2] * cosine + ended[:, 3] * sine)
        after[:, :2] = ended[:, :2]
        after[:, 2] += turned
        after[:, self._velocities] = ended[:, 4:7]

    @property
    def aground(self) -> np.ndarray:
        """Lanes that met a bank, an end of the waterway or the limit of heading in the last step."""
        return np.asarray(self.prepared.codes[:, 0] != 0)

    def columns_of(self, coefficients: np.ndarray, bank: np.ndarray) -> np.ndarray:
        """Return the inputs of lanes of other coefficients, (lanes, inputs)."""
        model = self.ship.model
        numbers = dict(zip(model.terms.names, coefficients.T, strict=True))
        numbers |= {name: bank * numbers[name] for name in self.silent}
        constants = self._system.constants({**self._ship_values, **numbers})
        columns = self._base.copy()
        for name, place in self._inputs.items():
            if name in constants:
                columns[:, place] = constants[name]
        return columns


def directions(covariance: np.ndarray | None) -> np.ndarray:
    """Return a root of the coefficients' covariance, (coefficients, k), without certain directions."""
    if covariance is None:
        return np.zeros((0, 0))
    size = np.sqrt(np.diag(covariance))
    scale = np.where(size > 0.0, size, 1.0)
    share, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    counts = share > 1e-9 * max(float(share.max()), 0.0)
    return np.asarray(scale[:, None] * axes[:, counts] * np.sqrt(share[counts]))


def lanes_of_directions(middle: np.ndarray, root: np.ndarray, distance: np.ndarray, others: int) -> np.ndarray:
    """Return coefficients for the lanes of sigma points, (1 + 2 (k + others), coefficients)."""
    steps = np.concatenate([root.T * distance[:, None], np.zeros((others, len(middle)))])
    return np.concatenate([middle[None], middle + steps, middle - steps])
