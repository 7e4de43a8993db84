"""Run every regressor of a table once and write down what it does: one line an operation, no SymPy.

The text is canonical (equal operations share a line), so it names a model in the cache, and a second run finds
its compiled form without a symbol being made. Replayed with floats, columns or symbols it gives the terms again.
"""

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral, Real
from typing import Any, NoReturn

from narrows.errors import InputError
from narrows.quantities.names import Number
from narrows.terms.term import TermTable

Line = tuple[str, ...]
"""``("input", name)``, ``("number", text)``, or an operation and the numbers of the lines that it works on."""

OPERATIONS: dict[str, Callable[..., Number]] = {
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
    """A regressor did something that cannot be written down."""


class Recorded:
    """A placeholder that notes what is done to it."""

    __array_ufunc__ = None  # a NumPy scalar then leaves the operation to us; a NumPy function fails
    __hash__ = object.__hash__

    def __init__(self, notes: "Notes", line: int) -> None:
        self.notes, self.line = notes, line

    def __neg__(self) -> "Recorded":
        return self.notes.operation("negative", self)

    def __pos__(self) -> "Recorded":
        return self

    def __abs__(self) -> "Recorded":
        return self.notes.operation("abs", self)


def _forward(sign: str) -> Callable[[Recorded, Any], Recorded]:
    return lambda self, other: self.notes.operation(sign, self, other)


def _backward(sign: str) -> Callable[[Recorded, Any], Recorded]:
    return lambda self, other: self.notes.operation(sign, other, self)


def _refusal(deed: str) -> Callable[..., NoReturn]:
    def refuse(*_: Any) -> NoReturn:
        raise NotArithmeticError(f"it {deed}")

    return refuse


for _sign, _name in {"+": "add", "-": "sub", "*": "mul", "/": "truediv", "**": "pow"}.items():
    setattr(Recorded, f"__{_name}__", _forward(_sign))
    setattr(Recorded, f"__r{_name}__", _backward(_sign))
for _deed, _names in REFUSED.items():
    for _name in _names.split():
        setattr(Recorded, _name, _refusal(_deed))


class Notes:
    """The lines written so far; the same operation on the same lines is written once."""

    def __init__(self) -> None:
        self.lines: dict[Line, int] = {}

    def note(self, line: Line) -> Recorded:
        """Write a line, or find it."""
        return Recorded(self, self.lines.setdefault(line, len(self.lines)))

    def operation(self, sign: str, *operands: Any) -> Recorded:
        """Write an operation on placeholders and numbers."""
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


@dataclass(frozen=True)
class Record:
    """What the regressors of a table do.

    Parameters
    ----------
    lines : tuple of Line
        The operations, in order.
    results : mapping of str to (str, int)
        For each term the force that it adds to and the line of its regressor.
    """

    lines: tuple[Line, ...]
    results: Mapping[str, tuple[str, int]]

    @cached_property
    def text(self) -> str:
        """The whole record in words, the same for the same terms."""
        body = [f"{number} = {' '.join(line)}" for number, line in enumerate(self.lines)]
        return "\n".join([*body, *(f"{force} {name} = {line}" for name, (force, line) in self.results.items())])

    @property
    def inputs(self) -> tuple[str, ...]:
        """The quantities that the regressors ask for between them."""
        return tuple(line[1] for line in self.lines if line[0] == "input")

    def replay(
        self, inputs: Mapping[str, Number], number: Callable[[int | float], Number] = lambda value: value
    ) -> dict[str, Number]:
        """Evaluate the regressor of every term.

        Parameters
        ----------
        inputs : mapping of str to number
            Floats, columns or symbols by name; more than needed is welcome.
        number : callable
            Makes of a plain number what goes with the inputs.
        """
        values: list[Number] = []
        for sign, *operands in self.lines:
            if sign == "input":
                values.append(inputs[operands[0]])
            elif sign == "number":
                values.append(number(int(operands[0]) if operands[0].lstrip("-").isdigit() else float(operands[0])))
            else:
                values.append(OPERATIONS[sign](*(values[int(operand)] for operand in operands)))
        return {name: values[line] for name, (_, line) in self.results.items()}


def record(table: TermTable) -> Record:
    """Write down what the regressors of a table do.

    Parameters
    ----------
    table : TermTable
        The terms.

    Raises
    ------
    InputError
        Where a regressor does more than arithmetic and ``abs()``.
    """
    notes, results = Notes(), {}
    inputs = {name: notes.note(("input", name)) for name in table.quantities}
    for force, terms in table.forces.items():
        for term in terms:
            try:
                results[term.name] = (force, notes.of(term.column(inputs)).line)
            except Exception as error:
                raise InputError(
                    f"term {term.name}: its regressor cannot be compiled ({error}); "
                    "write it with arithmetic and abs() alone"
                ) from error
    return Record(tuple(notes.lines), results)
