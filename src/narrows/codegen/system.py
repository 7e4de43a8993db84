"""Entry of the engine: one table of terms under some choices, printed and compiled as each use needs."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from types import ModuleType, SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.errors import InputError
from narrows.codegen.cache import import_generated, lacks_compiler
from narrows.codegen.trace import Trace, trace_of_terms
from narrows.model.term import TermTable
from narrows.quantities.arithmetic import COLUMNS
from narrows.quantities.names import Number

if TYPE_CHECKING:
    from narrows.codegen.free_motion import Actuated, Choices, Surge
    from narrows.codegen.linearisation import Linearisation
    from narrows.codegen.step import Rates

# Values of the numbers that a caller may omit.
DEFAULTS = dict.fromkeys(("X_in", "Y_in", "N_in", "heave", "surge_inertia"), 0.0)
COMPLEX_STEP = 1e-30  # Far below the rounding of any number, so that a derivative by it has no error of its own
# Functions whose complex value is not the one that a complex step needs.
OF_COMPLEX: dict[str, Callable[..., Any]] = {
    "abs": lambda value: value * np.sign(np.real(value)),
    "angle": lambda c, s: np.arctan2(np.real(s), np.real(c)) + 1j * np.imag(s / c) / (1 + np.real(s / c) ** 2),
}


@dataclass(frozen=True)
class System:
    """Terms, pose, actuators, water section, control law and contact as one traced system."""

    # Coefficients, ship, canal and water are arguments: a new fit compiles nothing.

    table: TermTable  # The terms
    surge: "Surge"  # True if the surge velocity is constant
    coriolis: bool  # True if -m u r in sway and m v r in surge are added to the terms
    choices: "Choices"  # Choices of a step

    @cached_property
    def trace(self) -> Trace:
        return trace_of_terms(self.table)

    @cached_property
    def _forces(self) -> tuple[tuple[str, str], ...]:
        return tuple((term.name, force) for force, terms in self.table.forces.items() for term in terms)

    @cached_property
    def rates(self) -> "Rates":
        from narrows.codegen.free_motion import solve_motion
        from narrows.codegen.step import Rates

        motion = solve_motion(self.trace, self._forces, self.surge, self.coriolis)
        choices = self.choices
        return Rates(motion, choices.moving, choices.pushed != "never" or choices.across == "field")

    @property
    def parameters(self) -> tuple[str, ...]:
        return tuple(self.scalar.PARAMETERS)

    @cached_property
    def scalar(self) -> SimpleNamespace:
        return SimpleNamespace(**self._executed("plain", scalar_functions(self.choices.row)))

    @cached_property
    def columns(self) -> SimpleNamespace:
        return SimpleNamespace(**self._executed("plain", column_functions(self.choices.row)))

    @cached_property
    def key(self) -> tuple[object, ...]:
        one, law = self.choices, self.choices.law
        of_law = (law.trace.text, law.memory, law.ordered) if law else ()
        choices = (one.contact, one.waterway, one.pushed, one.bottom, one.across, of_law)
        return (self.trace.text, self._forces, self.surge, self.coriolis, *choices)

    def constants(self, values: Mapping[str, Number]) -> dict[str, Number]:
        numbers = _numbers(self.parameters, values)
        functions = self.scalar if all(type(number) is float for number in numbers) else self.columns
        return dict(zip(self.scalar.CONSTANTS, _evaluated(functions.constants, numbers), strict=True))

    def linearisation(
        self, values: Mapping[str, Number], actuators: Sequence["Actuated"], section: tuple[str, ...] = ()
    ) -> "Linearisation":
        from narrows.codegen.linearisation import Linearisation

        parts = self.table.names, tuple(actuators), section
        scope = _derivatives(self, *parts)
        constants = _evaluated(scope["constants"], _numbers(scope["PARAMETERS"], values))
        compiled = self._module("jacobian", *parts)
        return Linearisation(scope, constants, *parts[:2], compiled, section)

    def kernel(self, lanes: int) -> Any:
        """Return the kernel; without a compiler its loops are operations on so many lanes at once."""
        if not lacks_compiler():
            return self._module("kernel")
        functions = column_functions(self.choices.row) | {
            "range": lambda _: [np.arange(lanes)], "where": np.where, "any_false": lambda flags: not np.all(flags),
        }  # fmt: skip
        own = self._executed("kernel", functions)
        return SimpleNamespace(**own | {"LANES": lanes})

    def tangent(self, moving: tuple[str, ...]) -> ModuleType:
        return self._module("tangent", moving)

    def _module(self, name: str, *parts: Any) -> ModuleType:
        return import_generated(name, (*self.key, *parts), lambda: self._written(name, *parts))

    def _executed(self, name: str, functions: Mapping[str, Callable[..., Any]], *parts: Any) -> dict[str, Any]:
        """Execute a generated text with the elementary functions that it calls; return its definitions."""
        scope: dict[str, Any] = {}
        exec(self._module(name, *parts).CODE, scope)
        scope.update(functions)
        return scope

    def _written(self, name: str, *parts: Any) -> str:
        from narrows.codegen import kernel  # It needs SymPy, which a cached text does not

        text: str = getattr(kernel, f"{name}_text")(self.choices, self.rates, *parts)
        return text

    def constants_slopes(
        self, values: Mapping[str, Number], slopes: Mapping[str, np.ndarray]
    ) -> dict[str, np.ndarray | float]:
        """Differentiate the constants of a voyage along some directions, by a complex step."""
        known = DEFAULTS | dict(values)
        moved = {name: 1j * COMPLEX_STEP * slope for name, slope in slopes.items()}
        numbers = (float(np.ravel(known[name])[0]) + moved.get(name, 0.0) for name in self.parameters)
        results = self._complex.constants(*numbers)
        slopes_of = (np.imag(result) / COMPLEX_STEP for result in results)
        return dict(zip(self.scalar.CONSTANTS, slopes_of, strict=True))

    @cached_property
    def _complex(self) -> SimpleNamespace:
        return SimpleNamespace(**self._executed("plain", column_functions() | OF_COMPLEX))

    def __reduce__(self) -> tuple[Any, ...]:
        # Another process finds the generated modules, or makes its own.
        return System, (self.table, self.surge, self.coriolis, self.choices)


@lru_cache(maxsize=64)
def _derivatives(system: System, *parts: Any) -> Mapping[str, Any]:
    return system._executed("jacobian", column_functions(), *parts)


def _numbers(parameters: Sequence[str], values: Mapping[str, Number]) -> list[Number]:
    """Return parameters, those of one number as floats, or name the missing ones."""
    known = DEFAULTS | dict(values)
    for name in parameters:
        if known.get(name) is None:
            raise InputError(f"the equations of motion need {name}; give it in the ship or the model file")
    return [_single(known[name]) for name in parameters]


def _single(number: Number) -> Number:
    if type(number) is float:  # Asking an array for its size takes ten times as long.
        return number
    return float(np.ravel(number)[0]) if np.size(number) == 1 else number


def _evaluated(constants: Callable[..., tuple[Number, ...]], numbers: Sequence[Number]) -> tuple[Number, ...]:
    with np.errstate(all="ignore"):
        try:
            result = constants(*numbers)
        except (ZeroDivisionError, OverflowError):
            result = (math.nan,)
    if not all(math.isfinite(value) if type(value) is float else np.isfinite(value).all() for value in result):
        raise InputError(
            "the mass matrix cannot be inverted; check that the coefficients are finite and those of inertia "
            "not zero, and where surge is free give surge_inertia"
        )
    return result


# Elementary functions that printed lines call, for floats and for columns.
def scalar_functions(row: int) -> dict[str, Callable[..., Any]]:
    return {
        "minimum": lambda a, b: a if a < b else b,
        "maximum": lambda a, b: a if a > b else b,
        "choice": lambda test, over, under: over if test > 0 else under,
        "positive": lambda test: 1.0 if test > 0 else 0.0,
        "whole": lambda number: float(int(number)),
        "angle": lambda cosine, sine: math.atan2(sine, cosine),
        "sine": math.sin,
        "cosine": math.cos,
        "sqrt": lambda value: math.sqrt(value) if value >= 0 else math.nan,
        "exp": math.exp,
        "log": math.log,
        "power": lambda base, exponent: base**exponent if base >= 0 or exponent.is_integer() else math.nan,
        "entry": lambda table, column, cell: float(table[row * int(cell) + column]),
    }


def column_functions(row: int = 0) -> dict[str, Callable[..., Any]]:
    return COLUMNS | {
        "positive": lambda test: np.where(np.asarray(test) > 0, 1.0, 0.0),
        "whole": np.trunc,
        "sqrt": np.sqrt,
        "exp": np.exp,
        "log": np.log,
        "power": np.power,
        "entry": lambda table, column, cell: np.asarray(table)[row * np.nan_to_num(cell).astype(np.int64) + column],
    }
