"""Sensitivity of a voyage to its start, coefficients and inputs: the exact tangent of every step."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, did_you_mean
from narrows.base.results import BaseResult
from narrows.codegen.cache import compiled_loops
from narrows.codegen.free_motion import COUNTED, INPUTS, LENGTH, stages_at
from narrows.codegen.system import COMPLEX_STEP
from narrows.model.model import Model
from narrows.ship.checks import check_angles
from narrows.simulation.initial_state import POSE, VoyageIntegrator, check_positions, initial_state
from narrows.simulation.inputs import START, STEADY, finite_numbers, segments_of
from narrows.simulation.ship import PARAMETER, SimulatedShip, Steering, steering_of
from narrows.simulation.voyage import Voyage, simulate

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False, eq=False)
class Sensitivities(BaseResult):
    """A voyage with the exact derivatives of its computed state.

    >>> nw.sensitivities(model, by=("y",), y=0.5, u=1.0, duration=1.0).voyage.grounded
    False
    """

    voyage: Voyage  #: The voyage
    by: tuple[str, ...]  #: Quantities of the differentiation
    #: (times, 6, by) Derivatives of x, y [m], psi [rad], u, v [m/s] and r [rad/s] per SI unit of each quantity
    slopes: np.ndarray
    values: Mapping[str, float]  #: Their values in the voyage
    model: Model  #: The ship

    @property
    def notes(self) -> tuple[str, ...]:
        """The voyage's notes."""
        return self.voyage.notes

    def of(self, state: str, by: str) -> np.ndarray:
        """Return the derivative of a ``state``, such as ``y``, by the quantity ``by``, (times,).

        Raises an InputError if it was not requested.
        """
        if state not in POSE or by not in self.by:
            raise InputError(f"there is no derivative of {state} by {by}; by: {', '.join(self.by)}")
        slope: np.ndarray = self.slopes[:, POSE.index(state), self.by.index(by)]
        return slope

    def summary(self) -> str:
        changes = [(0.01 * self.values[name] * float(self.of("y", name)[-1]), name) for name in self.by]
        largest = sorted(changes, key=lambda change: -abs(change[0]))[:3]
        most = [f"{name} {moved:+.3g} m" for moved, name in largest if moved]
        sentence = f"One percent more of each moves it by then to starboard by: {', '.join(most)}." if most else ""
        return "\n".join(filter(None, (self.voyage.summary(), sentence)))

    def to_dict(self) -> dict[str, Any]:
        end = dict(zip(POSE, self.slopes[-1], strict=True))
        slopes = {name: dict(zip(self.by, row.tolist(), strict=True)) for name, row in end.items()}
        return {"voyage": self.voyage.to_dict(), "at_end": slopes, "summary": self.summary(), "notes": list(self.notes)}

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the derivatives as a table, a row per time and quantity, over the SI unit of the quantity."""
        import pandas as pd

        rows = pd.MultiIndex.from_product([self.voyage.t, self.by], names=["t", "by"])
        columns = [f"d{name}" for name in POSE]
        return pd.DataFrame(self.slopes.transpose(0, 2, 1).reshape(-1, len(POSE)), rows, columns)


@accept_aliases
def sensitivities(
    model: Model, by: Sequence[str] = (), y: float = 0.0, u: float | None = None,
    duration: float | None = None, dt: float | None = None, **voyage: Any,
) -> Sensitivities:  # fmt: skip
    """Differentiate a voyage exactly by its start, coefficients, particulars and inputs.

    Every line of every step is differentiated, so that the derivatives are those of the computed voyage, to rounding. A
    control law in arithmetic is differentiated too. At a kink, as ``abs(v)`` at 0, it is the mean of both sides.

    Raises an InputError if the voyage is impossible, a name is unknown, or the controller is an object of Python.

    Parameters
    ----------
    model, by : Model, sequence of str, optional
        Names: x, y, psi, u, v, r at the start; rudder and other actuators there; external X, Y, N; current, in a
        waterway; coefficients; particulars; numbers of a control law. Default: all coefficients.
    y, u, duration, dt, **voyage
        As for ``simulate`` [m, m/s, s].

    Examples
    --------
    >>> slopes = nw.sensitivities(model, by=("y", "b_bank"), y=0.5, u=1.0, duration=1.0)
    >>> slopes.voyage.grounded
    False
    """
    names = tuple(by) or model.terms.names
    sailed = simulate(model, y, u, duration, dt, **voyage)
    integrator = TangentIntegrator.of(model, names, {"y": y, "u": float(sailed.u[0]), **voyage})
    return Sensitivities(sailed, names, integrator.slopes(sailed.t), integrator.values, model)


@dataclass(frozen=True)
class TangentIntegrator:
    ship: SimulatedShip  # The ship
    steering: Steering | None  # Controller
    integrator: VoyageIntegrator  # Inputs of the lines
    start: tuple[float, ...]  # Initial state
    numbers: Mapping[str, float]  # Pose, velocities and positions of actuators at the start
    schedules: Mapping[str, Any]  # External X, Y and N
    by: tuple[str, ...]  # Quantities of the differentiation

    @classmethod
    def of(cls, model: Model, by: Sequence[str], voyage: Mapping[str, Any]) -> "TangentIntegrator":
        rest = dict(voyage)
        options = {name: rest.pop(name) for name in ("surge", "surge_inertia", "coriolis", "contact") if name in rest}
        ship = SimulatedShip(model, **options)
        steering = steering_of(rest.pop("controller", None), ship.actuators, single=False)
        waterway = rest.pop("waterway", None)
        schedules = {name: rest.pop(name, 0.0) for name in INPUTS}
        check_positions({name: rest[name] for name in rest if name not in {*START, *STEADY}}, ship)
        numbers = {**START, "rudder": 0.0, **finite_numbers(**rest)}
        check_angles(numbers)
        pushed = any(name in by or np.any(schedule) for name, schedule in schedules.items())
        integrator, start = initial_state(ship, steering, numbers, waterway, pushed)
        tangent = cls(ship, steering, integrator, start, numbers, schedules, tuple(by))
        for name in by:
            if name not in tangent.values:
                known = list(tangent.values)
                raise InputError(f"a voyage has no {name!r} to differentiate by{did_you_mean(name, known)}")
        if len(set(by)) < len(by):
            raise InputError("a name to differentiate by stands twice; give each once")
        return tangent

    def with_coefficients(self, model: Model) -> "TangentIntegrator":
        """Return the same start and choices for a model that differs in its coefficients alone, without checks."""
        ship, channel = replace(self.ship, model=model), self.integrator.channel
        moved = replace(self, ship=ship)
        values = moved._ship_values
        inputs = {**self.integrator.inputs, **values, **self.integrator.system.constants(values), **channel.inputs}
        moved = replace(moved, integrator=replace(self.integrator, inputs=inputs))
        # The generated code depends on terms and choices.
        moved.__dict__.update({name: getattr(self, name) for name in ("_module", "_integrate")})
        return moved

    @cached_property
    def _ship_values(self) -> dict[str, Any]:
        return self.ship.values(**{name: value for name, value in self.numbers.items() if name not in START})

    @cached_property
    def values(self) -> dict[str, float]:
        """Quantities that allow differentiation, with their values."""
        configuration, parameters = self.ship.model.configuration.values(), self.integrator.system.parameters
        particulars = {name: self._ship_values[name] for name in parameters if name in configuration}
        law = self.steering.parameters if self.steering else {}
        return {
            **{name: self.numbers[name] for name in START},
            **{actuator.name: self._position(actuator.name) for actuator in self.ship.actuators},
            **{name: float(value) for name, value in particulars.items() if value is not None},
            **self.ship.model.coefficients,
            **{name: float(np.atleast_1d(np.asarray(self.schedules[name], float))[..., -1].mean()) for name in INPUTS},
            **({"current": float(self.integrator.inputs["current"])} if self.integrator.choices.waterway else {}),
            **{name.removeprefix(PARAMETER("")): float(np.ravel(value)[0]) for name, value in law.items()},
        }

    def _position(self, name: str) -> float:
        kept = self.integrator.choices.kept
        return self.start[kept.index(name)] if name in kept else float(self._ship_values.get(name) or 0.0)

    def _unit(self, name: str) -> np.ndarray:
        return np.array([float(name == other) for other in self.by])

    def start_slopes(self) -> np.ndarray:
        cosine, sine = math.cos(self.numbers["psi"]), math.sin(self.numbers["psi"])
        turned = {"cos_psi": -sine, "sin_psi": cosine, COUNTED: 1.0}
        slopes = {name: self._unit(name) for name in self.integrator.choices.kept}
        slopes |= {name: factor * self._unit("psi") for name, factor in turned.items()}
        slopes |= stages_at(self.ship.actuators, self._unit)
        if self.steering is not None:
            # The law's initial memory by a complex step, which is exact for sums and products.
            start: dict[str, Any] = dict.fromkeys((actuator.name for actuator in self.ship.actuators), 0.0)
            for name, value in zip(self.integrator.choices.kept, self.start, strict=True):
                start[name] = value + 1j * COMPLEX_STEP * slopes[name]
            memory = {name: np.imag(value) / COMPLEX_STEP for name, value in self.steering.memory(start).items()}
            slopes |= {name: np.broadcast_to(slope, len(self.by)) for name, slope in memory.items()}
        return np.array([slopes[name] for name in self.integrator.choices.kept])

    @cached_property
    def input_slopes(self) -> dict[str, np.ndarray]:
        """The derivatives of the moving inputs of the lines, by name, each (by,)."""
        parameters = {name: self._unit(name) for name in self.by}
        for actuator in self.ship.actuators:
            if actuator.angle and actuator.name not in self.integrator.choices.kept:
                angle = self._position(actuator.name)
                parameters[f"cos_{actuator.name}"] = -math.sin(angle) * self._unit(actuator.name)
                parameters[f"sin_{actuator.name}"] = math.cos(angle) * self._unit(actuator.name)
        constants = self.integrator.system.constants_slopes(self._ship_values, parameters)
        law = {PARAMETER(name): self._unit(name) for name in self.by}
        pushes = {INPUTS[name]: self._unit(name) for name in INPUTS}
        moving = {**constants, **parameters, **law, **pushes}
        return {name: np.asarray(slope) for name, slope in moving.items() if np.any(slope)}

    def slopes(self, times: np.ndarray) -> np.ndarray:
        """Return the derivatives of x, y, psi, u, v, r at the times of the voyage, (times, 6, by)."""
        pushed = dict(zip(INPUTS.values(), self._pushes(times).T, strict=True))
        whole, lengths = np.array([0, len(times) - 1]), np.diff(times)
        kept, slopes = self.segments(np.array([self.start]), self.start_slopes()[None], whole, pushed, lengths)
        names = self.integrator.choices.kept
        column = {name: slopes[:, i] for i, name in enumerate(names)}
        state = dict(zip(names, kept.T, strict=True))
        turned = state["cos_psi"][:, None] * column["sin_psi"] - state["sin_psi"][:, None] * column["cos_psi"]
        return np.stack([column["x"], column["y"], turned, *(column[name] for name in ("u", "v", "r"))], axis=1)

    def segments(
        self, starts: np.ndarray, start_slopes: np.ndarray, first: np.ndarray, orders: Mapping[str, np.ndarray],
        lengths: np.ndarray, **others: float,
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Integrate from several starts in one call; return states and derivatives at each sample of each."""
        # starts (segments, kept); start_slopes (segments, kept, by); first (segments + 1,); lengths (steps,) [s]
        moving, module = self.input_slopes, self._module
        inputs = {LENGTH: 0.0, **self.integrator.inputs, **others}
        values = np.array([float(inputs[name]) for name in module.INPUTS])
        along = [moving.get(name, np.zeros(len(self.by))) for name in module.INPUTS[: module.MOVING]]
        known = [name for name in module.INPUTS if name in orders]
        places = np.array([module.INPUTS.index(name) for name in known], np.int64)
        changing = np.array([orders[name] for name in known], float).reshape(len(known), len(lengths))
        count, by = len(lengths) + len(starts), len(self.by)
        states, slopes = np.empty((count, module.KEPT)), np.empty((count, module.KEPT, by))
        self._integrate(
            np.ascontiguousarray(starts, float), np.ascontiguousarray(start_slopes), np.asarray(first, np.int64),
            values, np.reshape(along, (module.MOVING, by)), places, np.ascontiguousarray(changing.T), lengths,
            self.integrator.channel.table, states, slopes,
        )  # fmt: skip
        return states, slopes

    @cached_property
    def _module(self) -> ModuleType:
        # All inputs that can have a derivative, whatever ``by`` is, so that few modules are ever made.
        law, scalar = self.steering.parameters if self.steering else {}, self.integrator.system.scalar
        can = {*scalar.CONSTANTS, *law, *INPUTS.values(), *self.ship.model.configuration.values(), "current"}
        return self.integrator.system.tangent(tuple(name for name in scalar.STEP_INPUTS if name in can))

    @cached_property
    def _integrate(self) -> Callable[..., None]:
        from narrows.codegen.addresses import entry
        from narrows.codegen.kernels import loops

        module = self._module
        sizes = entry(module, "step"), module.KEPT, module.MOVING, module.INPUTS.index(LENGTH)
        return partial(compiled_loops(loops).integrate, np.array(sizes))

    def _pushes(self, times: np.ndarray) -> np.ndarray:
        surge, sway, yaw = (self.schedules[name] for name in INPUTS)
        pieces = segments_of(surge, sway, yaw, float(times[-1]) or 1.0)
        begun = np.searchsorted([piece.start for piece in pieces], times[:-1] + 1e-9, side="right") - 1
        return np.array([pieces[i].forces for i in begun]).reshape(-1, len(INPUTS))
