"""Run a function once on placeholders and record its operations, one a line, without SymPy.

Equal operations share a line, so the text is canonical: it identifies a model or a control law in the cache, and a
second run finds the compiled form without SymPy. Replaying it with floats, columns or symbols repeats the function.
"""

import math
import operator
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, partialmethod
from numbers import Integral, Real
from types import SimpleNamespace
from typing import Any, NoReturn

from narrows.base.errors import InputError
from narrows.model.term import TermTable, uncompiled
from narrows.quantities.arithmetic import COLUMNS
from narrows.quantities.names import Number

# ``("input", name)``, ``("number", text)``, or an operation and the line numbers of its operands.
Line = tuple[str, ...]

OPERATORS: dict[str, Callable[..., Number]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "**": operator.pow,
    "negative": operator.neg,
    "abs": abs,
}
REFUSED = {
    "compares": "__lt__ __le__ __gt__ __ge__ __eq__ __ne__",
    "branches on a value": "__bool__",
    "turns a value into a plain number": "__float__ __int__ __complex__ __index__ __round__ __trunc__",
    "rounds": "__floor__ __ceil__ __floordiv__ __rfloordiv__ __mod__ __rmod__ __divmod__ __rdivmod__",
    "treats a value as an array": "__len__ __iter__ __getitem__ __array__ __matmul__ __rmatmul__",
}


class NotArithmeticError(Exception):
    """A regressor did something that cannot be recorded."""


class Recorded:
    __array_ufunc__ = None  # NumPy scalars then defer to this class; NumPy functions fail
    __hash__ = object.__hash__

    def __init__(self, notes: "Notes", line: int) -> None:
        self.notes, self.line = notes, line

    def __pos__(self) -> "Recorded":
        return self

    def apply_function(self, name: str, values: Iterable[Any]) -> "Recorded":
        return self.notes.operation(name, *values)


def _refuse(_: Recorded, deed: str, *__: Any) -> NoReturn:
    raise NotArithmeticError(f"it {deed}")


for _sign, _name in {"+": "add", "-": "sub", "*": "mul", "/": "truediv", "**": "pow"}.items():
    setattr(Recorded, f"__{_name}__", lambda self, other, *, sign=_sign: self.notes.operation(sign, self, other))
    setattr(Recorded, f"__r{_name}__", lambda self, other, *, sign=_sign: self.notes.operation(sign, other, self))
for _sign, _name in {"negative": "neg", "abs": "abs"}.items():
    setattr(Recorded, f"__{_name}__", lambda self, *, sign=_sign: self.notes.operation(sign, self))
for _deed, _names in REFUSED.items():
    for _name in _names.split():
        setattr(Recorded, _name, partialmethod(_refuse, _deed))


class Notes:
    """The lines written so far; an operation on the same lines is written once."""

    def __init__(self) -> None:
        self.lines: dict[Line, int] = {}

    def note(self, line: Line) -> Recorded:
        return Recorded(self, self.lines.setdefault(line, len(self.lines)))

    def operation(self, sign: str, *operands: Any) -> Recorded:
        return self.note((sign, *(str(self.of(operand).line) for operand in operands)))

    def of(self, value: Any) -> Recorded:
        """Return the placeholder of a value, which may be a plain number."""
        if isinstance(value, Recorded):
            return value
        if not isinstance(value, Real):
            raise NotArithmeticError(f"it works with a {type(value).__name__}")
        number = int(value) if isinstance(value, Integral) else float(value)
        if not math.isfinite(number):
            raise NotArithmeticError(f"it works with {number}")
        return self.note(("number", repr(number)))


@dataclass(frozen=True, eq=False)
class Trace:
    lines: tuple[Line, ...]  # Operations, in order
    results: Mapping[str, int]  # Line number of each result

    @cached_property
    def text(self) -> str:
        body = [f"{number} = {' '.join(line)}" for number, line in enumerate(self.lines)]
        return "\n".join([*body, *(f"{name} = {line}" for name, line in self.results.items())])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Trace) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)

    @property
    def inputs(self) -> tuple[str, ...]:
        used = {int(n) for sign, *operands in self.lines if sign not in ("input", "number") for n in operands}
        used |= set(self.results.values())
        return tuple(line[1] for number, line in enumerate(self.lines) if line[0] == "input" and number in used)

    @cached_property
    def shared(self) -> frozenset[int]:
        """Operations whose result is used more than once."""
        used = [int(n) for sign, *operands in self.lines if sign not in ("input", "number") for n in operands]
        return frozenset(line for line, uses in Counter([*used, *self.results.values()]).items() if uses > 1)

    def replay(
        self,
        inputs: Mapping[str, Number],
        number: Callable[[int | float], Number] = lambda value: value,
        functions: Mapping[str, Callable[..., Number]] = COLUMNS,
        put: Callable[[str, Number], Number] = lambda name, value: value,  # Names what is used more than once
    ) -> dict[str, Number]:
        values: list[Number] = []
        for place, (sign, *operands) in enumerate(self.lines):
            if sign == "input":
                values.append(inputs.get(operands[0]))
            elif sign == "number":
                values.append(number(int(operands[0]) if operands[0].lstrip("-").isdigit() else float(operands[0])))
            else:
                operation = functions.get(sign) or OPERATORS[sign]
                value = operation(*(values[int(operand)] for operand in operands))
                values.append(put(f"part_{place}", value) if place in self.shared else value)
        return {name: values[line] for name, line in self.results.items()}


def trace_of_terms(table: TermTable) -> Trace:
    notes, _, results = notes_of_terms(table)
    return Trace(tuple(notes.lines), results)


def notes_of_terms(table: TermTable) -> tuple[Notes, dict[str, Recorded], dict[str, int]]:
    """Return the lines of a table, the placeholders of its quantities, and the line of each term."""
    notes, results = Notes(), {}
    inputs = {name: notes.note(("input", name)) for name in sorted(table.quantities)}
    for term in table.terms:
        try:
            results[term.name] = notes.of(term.column(inputs)).line
        except Exception as error:
            raise uncompiled(term, error) from error
    return notes, inputs, results


def trace_of(function: Callable[[Any], Mapping[str, Number]], names: Mapping[str, str], what: str) -> Trace:
    notes = Notes()
    quantities = SimpleNamespace(**{name: notes.note(("input", input_name)) for name, input_name in names.items()})
    try:
        results = {name: notes.of(value).line for name, value in function(quantities).items()}
    except InputError:
        raise
    except AttributeError as error:
        raise InputError(f"{what} needs an unknown quantity ({error}); known: {', '.join(names)}") from error
    except Exception as error:
        raise InputError(
            f"{what} cannot be compiled ({error}); write it with arithmetic, abs() and minimum, maximum, clip, choice "
            "and angle of narrows.quantities.arithmetic"
        ) from error
    return Trace(tuple(notes.lines), results)
