"""Lines as Python: one function of floats or columns, whose elementary functions the caller brings."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import sympy
from sympy.printing.pycode import PythonCodePrinter

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Assignment, Program

LONGEST_PRODUCT = 4
DIGITS = 20


class Arithmetic(PythonCodePrinter):  # type: ignore[misc]
    """SymPy's printer of Python, with short powers as products and the functions of ``lines`` by their names."""

    # What the table of a waterway is called.
    TABLE = "table"

    def __init__(self, number: Callable[[str], str] = "{}".format, column: Callable[[int], str] = str) -> None:
        super().__init__({"fully_qualified_modules": False})
        self.number, self.column = number, column

    def called(self, name: str, *arguments: str) -> str:
        """Write the call of a function."""
        return f"{name}({', '.join(arguments)})"

    def _print_Float(self, value: Expr) -> str:
        text = self.number(repr(abs(float(value.evalf(DIGITS)))))
        return f"-{text}" if value < 0 else text

    _print_Rational = _print_Half = _print_Integer = _print_Zero = _print_One = _print_NegativeOne = _print_Float
    _print_NumberSymbol = _print_Exp1 = _print_Pi = _print_Float

    def _print_Abs(self, value: Expr) -> str:
        return self.called("abs", self._print(value.args[0]))

    def _print_exp(self, value: Expr) -> str:
        return self.called("exp", self._print(value.args[0]))

    def _print_log(self, value: Expr) -> str:
        return self.called("log", self._print(value.args[0]))

    def _print_Pow(self, value: Expr, **_: Any) -> str:
        base, power = value.args
        if base == sympy.E:
            return self.called("exp", self._print(power))
        if power.is_Rational and power < 0:
            return f"({self.number('1.0')} / {self.parenthesize(sympy.Pow(base, -power), 1000)})"
        if power.is_Integer and power <= LONGEST_PRODUCT:
            return "(" + " * ".join([self.parenthesize(base, 1000)] * int(power)) + ")"
        if power == sympy.Rational(1, 2):
            return self.called("sqrt", self._print(base))
        if power.is_Rational and power.q == 2:
            whole = self.parenthesize(base ** (power - sympy.Rational(1, 2)), 1000)
            return f"({whole} * {self.called('sqrt', self._print(base))})"
        if base.is_number and not power.is_number:
            return self.called("exp", self._print(power * sympy.log(base).evalf(DIGITS)))
        return self.called("power", self._print(base), self._print(power))

    def _print_Function(self, value: Expr) -> str:
        name = str(value.func)
        if name == "entry":
            return self.called(name, self.TABLE, self.column(int(value.args[0])), self._print(value.args[1]))
        return self.called(name, *map(self._print, value.args))


plain = Arithmetic()


def statements(
    program: Program, targets: Sequence[str], printer: Arithmetic, declared: str = "{} = {}", assigned: str = "{} = {}"
) -> list[str]:
    """Print the lines of a program, and what its results are assigned to."""
    lines = [declared.format(*map(printer.doprint, line)) for line in program.assignments]
    results = zip(targets, program.results, strict=True)
    return lines + [assigned.format(target, printer.doprint(value)) for target, value in results]


def function_text(
    name: str, arguments: Sequence[str], assignments: Iterable[Assignment], results: Sequence[Expr], table: bool = False
) -> str:
    """Print a function."""
    # assignments (symbol, expression)
    parameters = (*(("table",) if table else ()), *arguments)
    body = [f"{target} = {plain.doprint(value)}" for target, value in assignments]
    values = ", ".join(plain.doprint(sympy.sympify(value)) for value in results)
    return "\n    ".join([f"def {name}({', '.join(parameters)}):", *body, f"return ({values},)"]) + "\n"
