"""Jacobian matrices of the motion: by state, by control, by coefficient."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from narrows.codegen.cache import compiled_loops
from narrows.codegen.free_motion import INPUTS, STATE, Actuated
from narrows.quantities.names import FORCES, Number

LINEARISED = ("x", "y", "psi", "u", "v", "r")  # State of a linearised model; the heading is one angle [rad] here


def controlled(actuators: Sequence[Actuated]) -> tuple[str, ...]:
    return (*INPUTS.values(), *(actuator.name for actuator in actuators))


def arguments(actuators: Sequence[Actuated], section: Sequence[str] = ()) -> tuple[str, ...]:
    return (*STATE, *INPUTS.values(), *(name for actuator in actuators for name in actuator.controls), *section)


@dataclass(frozen=True)
class Linearisation:
    """Derivatives of the motion of one ship, or of a fleet if the values were columns."""

    functions: Mapping[str, Any]  # The generated functions, for floats and columns
    constants: tuple[Number, ...]  # Constants of the ship
    names: tuple[str, ...]  # Coefficients, in the order of the columns of ``coefficients``
    actuators: tuple[Actuated, ...]  # Actuators of the model
    module: ModuleType  # The same functions for the compiler
    section: tuple[str, ...] = ()  # Water quantities that ``at`` gives, point by point

    @property
    def controlled(self) -> tuple[str, ...]:
        return controlled(self.actuators)

    def linear(self, at: Mapping[str, Number]) -> np.ndarray:
        """Differentiate the rates of x, y, psi, u, v, r by the same six and by ``controlled``: (..., 6, 6 + n)."""
        return self._matrix("linear", at, len(LINEARISED))

    def batch(self, points: int) -> Callable[[Mapping[str, Number]], np.ndarray]:
        """Return ``linear`` compiled for many points of one ship; each call overwrites its result."""
        from narrows.codegen.addresses import entry
        from narrows.codegen.kernels import loops

        linear, fill = entry(self.module, "linear"), compiled_loops(loops).at_points
        constants = np.array([float(np.ravel(value)[0]) for value in self.constants])
        values = np.zeros((points, len(arguments(self.actuators, self.section))))
        out = np.zeros((points, len(LINEARISED), len(LINEARISED) + len(self.controlled)))

        def derivatives(at: Mapping[str, Number]) -> np.ndarray:
            for column, value in enumerate(self._arguments(at)):
                values[:, column] = value
            fill(linear, values, constants, out.reshape(points, -1))
            return out

        return derivatives

    def coefficients(self, at: Mapping[str, Number]) -> np.ndarray:
        """Differentiate the same rates by every coefficient of the table: (..., 6, n)."""
        slopes = self._matrix("coefficients", at, len(FORCES))
        return np.concatenate([np.zeros_like(slopes), slopes], axis=-2)

    def _matrix(self, name: str, at: Mapping[str, Number], rows: int) -> np.ndarray:
        values = self._arguments(at)
        entries = self.functions[name](values, self.constants)
        shape = np.broadcast_shapes(*(np.shape(value) for value in (*values, *self.constants)))
        matrix = np.empty((*shape, len(entries)))
        for index, entry in enumerate(entries):
            matrix[..., index] = entry
        return matrix.reshape(*shape, rows, -1)

    def _arguments(self, at: Mapping[str, Number]) -> list[Number]:
        values, names = dict(at), arguments(self.actuators, self.section)
        for name in ("psi", *(actuator.name for actuator in self.actuators if actuator.angle)):
            if f"cos_{name}" not in values:
                position = values.get(name, 0.0)
                values |= {f"cos_{name}": np.cos(position), f"sin_{name}": np.sin(position)}
        return [values[name] if name in self.section else values.get(name, 0.0) for name in names]
