"""A compiled model: constants, right-hand side, derivatives, and a kernel that sails fleets."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from types import ModuleType
from typing import Any

import numpy as np

from narrows.compile.cache import generated
from narrows.compile.contact import Outline, contact_of, point_names
from narrows.compile.emit import Inputs, emit, plain_text
from narrows.compile.fleet import Fleet, Limits, limits_of, sail, settle, task_of
from narrows.compile.helmed import PILOT, Helmed, helmed_text, sail_helmed
from narrows.compile.jacobian import Linearisation, jacobian_text
from narrows.compile.kernel import Precision, kernel_text
from narrows.compile.record import Record, record
from narrows.compile.trace import ARGUMENTS, INPUTS, STATE, SURGE_INERTIA, Surge, trace
from narrows.errors import InputError
from narrows.quantities.names import Number
from narrows.ship.actuators import RUDDER
from narrows.terms.term import TermTable

DEFAULTS = dict.fromkeys((*INPUTS.values(), "heave", SURGE_INERTIA), 0.0) | RUDDER.at_rest()


@dataclass(frozen=True)
class Program:
    """The equations of motion of a table of terms, compiled as far as each use needs.

    Coefficients, ship, canal and water are arguments: a new fit compiles nothing. ``compiled`` makes one.

    Parameters
    ----------
    table : TermTable
        The terms.
    surge : {"held", "free"}
        Whether the surge velocity is constant.
    coriolis : bool
        Whether -m u r in sway and m v r in surge are added to the terms.
    shape : str or tuple of points
        What of the hull meets a bank.
    """

    table: TermTable
    surge: Surge
    coriolis: bool
    shape: str | Outline

    @cached_property
    def record(self) -> Record:
        """What the regressors do."""
        return record(self.table)

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of the values that ``constants`` asks for."""
        return tuple(self._plain.PARAMETERS)

    def constants(self, values: Mapping[str, Number]) -> tuple[Number, ...]:
        """Evaluate what stays the same through a voyage.

        Parameters
        ----------
        values : mapping of str to number
            Coefficients and particulars by name, each in its SI unit, as columns for a fleet; more is welcome.
            ``heave`` [m] and ``surge_inertia`` [kg] are zero if absent.

        Raises
        ------
        InputError
            Where a value is missing, or no mass resists an acceleration.
        """
        return self._constants(self._plain, values)

    @property
    def rhs(self) -> Callable[..., tuple[Number, ...]]:
        """The derivatives in time of ``STATE``: a function of the seven, ``ARGUMENTS`` and the constants.

        Plain Python, for floats or columns; no compiler is imported.
        """
        return self._plain.rhs  # type: ignore[no-any-return]

    @property
    def gap(self) -> Callable[..., Number]:
        """The room between hull and bank [m]: a function of y, cos_psi, sin_psi and the constants."""
        return self._plain.gap  # type: ignore[no-any-return]

    @property
    def lean(self) -> Callable[..., Number]:
        """Positive where the starboard bank is nearer: a function of y, cos_psi, sin_psi and the constants."""
        return self._plain.lean  # type: ignore[no-any-return]

    def jacobian(self, values: Mapping[str, Number]) -> Linearisation:
        """Make the exact derivatives of the motion.

        Parameters
        ----------
        values : mapping of str to number
            As for ``constants``.
        """
        module = self._module("jacobian", "arguments", self._jacobian_text)
        return Linearisation(module, self._constants(module, values), self.table.names)

    def fleet(
        self, values: Mapping[str, Number], *, y: Number, u: Number, psi: Number = 0.0, v: Number = 0.0,
        r: Number = 0.0, x: Number = 0.0, dt: Number, duration: float, precision: Precision = "float64",
        workers: int | None = None, limits: Limits | None = None,
    ) -> Fleet:  # fmt: skip
        """Sail many vessels until a hull meets a bank or time is up, by the classical Runge-Kutta step.

        A contact is located within the step, to 1e-9 m of gap in double precision. What passes between two ends
        of a step, a bank brushed and left, is not seen.

        Parameters
        ----------
        values : mapping of str to number
            As for ``constants``, and constant forces from outside: ``X_in`` [N], ``Y_in`` [N], ``N_in`` [N m].
            A column has one value for each vessel.
        y : number [m]
            At the start, to starboard of the centreline.
        u, v : number [m/s]
            Surge and sway velocity at the start.
        psi : number [rad]
            Heading at the start.
        r : number [rad/s]
            Yaw rate at the start.
        x : number [m]
            Along the canal at the start.
        dt : number [s]
            Time step.
        duration : float [s]
            Longest voyage.
        precision : {"float64", "float32"}
            Of a lane; single precision is for maps, not for numbers.
        workers : int, optional
            Threads; a core each if absent. The results do not depend on it.
        limits : Limits, optional
            What else ends a voyage.

        Raises
        ------
        InputError
            Where a value is missing, a number is not finite, or no mass resists an acceleration.
        """
        limits = limits or Limits()
        columns = self._columns(values)
        vessels = max(map(len, columns.values()), default=1)
        start = {"x": x, "y": y, "psi": psi, "u": u, "v": v, "r": r}
        task = task_of(start, dt, duration, vessels, precision)
        settle(task, self.constants(values), self.gap, self.lean, limits)
        pushed: Inputs = "constants" if any(name in values for name in INPUTS.values()) else "none"
        kernel = self.kernel(bool(columns), precision, pushed)

        def constants(rows: slice) -> np.ndarray:
            part = {name: column[rows] for name, column in columns.items()}
            # What varies need not enter any of them, as a surge force where the speed is held.
            each = np.empty(rows.stop - rows.start if columns else ())
            own = np.broadcast_arrays(each, *self._constants(kernel, {**values, **part}))
            return np.stack(own[1:], axis=-1).astype(precision)

        shared = None if columns else constants(slice(None))
        give = constants if shared is None else lambda _: shared
        return sail(task, kernel, give, limits_of(limits, values["width"], precision), workers)

    def helmed(
        self, values: Mapping[str, Number], pilot: Mapping[str, Number], *, y: Number, u: Number, psi: Number = 0.0,
        v: Number = 0.0, r: Number = 0.0, dt: Number, steps: Number, workers: int | None = None,
        limits: Limits | None = None,
    ) -> Helmed:  # fmt: skip
        """Sail many vessels under autopilots, each with her own gains, gear and push from outside.

        Parameters
        ----------
        values : mapping of str to number
            As for ``constants``.
        pilot : mapping of str to number
            By the names of ``PILOT``, SI and rad.
        y : number [m]
            At the start, to starboard of the centreline.
        u, v : number [m/s]
            Surge and sway velocity at the start.
        psi : number [rad]
            Heading at the start.
        r : number [rad/s]
            Yaw rate at the start.
        dt : number [s]
            Time step; the helm gets an order each.
        steps : number
            Most of them.
        workers : int, optional
            Threads; a core each if absent. The results do not depend on it.
        limits : Limits, optional
            What else ends a voyage.

        Raises
        ------
        InputError
            Where a value is missing.
        """
        pose = {"x": 0.0, "y": y, "cos_psi": np.cos(psi), "sin_psi": np.sin(psi), "u": u, "v": v, "r": r}
        given = [pose[name] for name in STATE] + [pilot[name] for name in PILOT] + [dt, steps]
        columns = self._columns(values)
        table = np.array(np.broadcast_arrays(*given, *columns.values())[: len(given)], float).reshape(len(given), -1).T
        kernel = self._module(
            "helmed", "arguments", lambda: helmed_text(self._emitted("arguments"), version("narrows"))
        )

        def constants(rows: slice) -> np.ndarray:
            part = {name: column[rows] for name, column in columns.items()}
            own = np.broadcast_arrays(np.empty(rows.stop - rows.start), *self._constants(kernel, {**values, **part}))
            return np.stack(own[1:], axis=-1)

        start, pilots, (pace, most) = table[:, :7], table[:, 7:-2], table[:, -2:].T
        ends = limits_of(limits or Limits(), values["width"], "float64")
        start, steps, pace, pilots = map(np.ascontiguousarray, (start, most, pace, pilots))
        return sail_helmed(kernel, constants, start, steps, pace, pilots, ends, workers)

    def kernel(self, varying: bool, precision: Precision, inputs: Inputs) -> ModuleType:
        """Return the module that sails a fleet; its ``fleet`` compiles when first called.

        Parameters
        ----------
        varying : bool
            Whether constants differ from vessel to vessel.
        precision : {"float64", "float32"}
            Of a lane.
        inputs : {"constants", "none"}
            Whether forces from outside push.
        """

        def text() -> str:
            return kernel_text(self._emitted(inputs), varying, precision, version("narrows"))

        return self._module("kernel", inputs, text, varying, precision)

    @cached_property
    def _plain(self) -> ModuleType:
        return self._module("plain", "arguments", lambda: plain_text(self._emitted("arguments"), version("narrows")))

    def _jacobian_text(self) -> str:
        return jacobian_text(self._emitted("arguments"), self.table.names, version("narrows"))

    def _module(self, name: str, inputs: Inputs, text: Callable[[], str], *more: object) -> ModuleType:
        parts = (self.record.text, self.surge, self.coriolis, self._shape_key, inputs, *more)
        return generated(name, parts, text)

    def _emitted(self, inputs: Inputs) -> Any:
        return emit(trace(self.record, self.surge, self.coriolis), contact_of(self._shape_key), inputs)

    @property
    def _shape_key(self) -> str | int:
        return self.shape if isinstance(self.shape, str) else len(self.shape)

    def _points(self) -> dict[str, float]:
        if isinstance(self.shape, str):
            return {}
        names = point_names(len(self.shape))
        return {n: p for pair, point in zip(names, self.shape, strict=True) for n, p in zip(pair, point, strict=True)}

    def _columns(self, values: Mapping[str, Number]) -> dict[str, np.ndarray]:
        """The values that differ from vessel to vessel."""
        wanted = {*self.parameters, *ARGUMENTS}
        return {name: np.ravel(value) for name, value in values.items() if name in wanted and np.size(value) > 1}

    def _constants(self, module: ModuleType, values: Mapping[str, Number]) -> tuple[Number, ...]:
        given = DEFAULTS | dict(values) | self._points()
        for name in module.PARAMETERS:
            if given.get(name) is None:
                raise InputError(f"the equations of motion need {name}; give it in the ship or the model file")
        numbers = (given[name] for name in module.PARAMETERS)
        with np.errstate(all="ignore"):
            try:
                result = module.constants(*(float(np.ravel(n)[0]) if np.size(n) == 1 else n for n in numbers))
            except ZeroDivisionError:
                result = (math.nan,)
        if not all(np.isfinite(value).all() for value in result):
            raise InputError(
                "the mass matrix cannot be inverted; check that the coefficients are finite and those of inertia "
                "not zero, and where surge is free give surge_inertia"
            )
        return tuple(result)

    def __reduce__(self) -> tuple[Any, ...]:
        # another process finds the generated modules, or makes its own
        return Program, (self.table, self.surge, self.coriolis, self.shape)
