"""Lines as text: powers, roots, numbers to the bit, lanes in loops; programs without what nothing asks for."""

import math

import numpy as np
import pytest
import sympy

from engine_models import function_of
from narrows.codegen.free_motion import ROW, exact_number
from narrows.codegen.lines import (
    CUT,
    FUNCTIONS,
    Constants,
    Lines,
    clipped,
    greatest,
    least,
    real,
    rounds,
    straight_lines,
)
from narrows.codegen.printers.python import Arithmetic, function_text
from narrows.codegen.system import column_functions, scalar_functions

A, B = real("a"), real("b")
AT = [(0.7, 1.9), (-0.7, 1.9), (1.4, -0.6)]


def evaluated(expression: sympy.Expr, a: float, b: float, functions: dict | None = None) -> float:
    text = function_text("f", ("a", "b"), [], [sympy.sympify(expression)])
    return function_of(text, "f", functions or scalar_functions(ROW))(a, b)[0]


POWERS = {
    A**2: lambda a, b: a * a,
    A**4: lambda a, b: a**4,
    A**5: lambda a, b: a**5,
    (A + B) ** 3: lambda a, b: (a + b) ** 3,
    A**-1: lambda a, b: 1 / a,
    A**-3: lambda a, b: a**-3,
    (A + B) ** -2 * A: lambda a, b: a / (a + b) ** 2,
    sympy.sqrt(A**2 + B**2): lambda a, b: math.hypot(a, b),
    (A**2 + 1) ** sympy.Rational(3, 2): lambda a, b: (a * a + 1) ** 1.5,
    (A**2 + 1) ** sympy.Rational(-5, 2): lambda a, b: (a * a + 1) ** -2.5,
    (A**2 + 1) ** B: lambda a, b: (a * a + 1) ** b,
    (A**2 + 1) ** sympy.Rational(1, 3): lambda a, b: (a * a + 1) ** (1 / 3),
    sympy.Integer(2) ** (-A / 3): lambda a, b: 2 ** (-a / 3),
    sympy.exp(A) * sympy.E: lambda a, b: math.exp(a + 1),
    -sympy.Abs(A) * (-B) ** 3: lambda a, b: abs(a) * b**3,
}


@pytest.mark.parametrize("expression", POWERS, ids=str)
def test_powers_are_what_they_say(expression: sympy.Expr) -> None:
    for a, b in AT:
        assert evaluated(expression, a, b) == pytest.approx(POWERS[expression](a, b), rel=1e-15)
        columns = evaluated(expression, np.array([a, a]), np.array([b, b]), column_functions())
        np.testing.assert_allclose(columns, POWERS[expression](a, b), rtol=4e-15)


def test_short_powers_are_products_and_long_ones_calls() -> None:
    printer = Arithmetic()
    assert "power" not in printer.doprint(A**4)
    assert "**" not in printer.doprint(A**4)
    assert printer.doprint(A**5).startswith("power(")
    assert printer.doprint((A + 1) ** sympy.Rational(1, 2)).startswith("sqrt(")


def test_a_root_of_a_negative_number_is_no_number() -> None:
    """And no error, nor complex: the voyage has diverged there."""
    assert math.isnan(evaluated(sympy.sqrt(A), -2.0, 0.0))
    assert math.isnan(evaluated(A ** sympy.Rational(3, 2), -2.0, 0.0))
    assert math.isnan(evaluated(A**B, -2.0, 0.5))


NUMBERS = [0.1, 1 / 3, 1e-300, 6.02e23, -0.7, 2.0**-40, math.pi, 5, -3, 0.5, math.e]


@pytest.mark.parametrize("number", NUMBERS)
def test_numbers_keep_every_bit(number: float) -> None:
    assert evaluated(exact_number(number) + 0 * A, 1.0, 1.0) == number
    assert evaluated(exact_number(number) * A, 1.0, 1.0) == number


def test_least_greatest_and_clipped() -> None:
    for a, b in AT:
        assert evaluated(least(A, B, A * B), a, b) == min(a, b, a * b)
        assert evaluated(greatest(A, B, A * B), a, b) == max(a, b, a * b)
        assert evaluated(clipped(A, sympy.Rational(1, 2)), a, b) == min(max(a, -0.5), 0.5)


class TestLines:
    def test_a_name_that_is_taken_is_marked(self) -> None:
        lines = Lines()
        names = [str(lines.put("t", A * k)) for k in (2, 3, 4)]
        assert names == ["t", "t_", "t__"]

    def test_a_symbol_or_a_number_needs_no_line(self) -> None:
        lines = Lines()
        assert (lines.put("t", A), lines.put("t", 3)) == (A, 3)
        assert not lines.assignments

    def test_what_nothing_asks_for_is_left_out(self) -> None:
        lines = Lines()
        first = lines.put("first", A * 2)
        lines.put("idle", first * B)
        lines.cut()
        last = lines.put("last", first + 1)
        kept = lines.needed_for([last])
        assert [str(name) for name, _ in kept.assignments] == ["first", "last"]
        assert kept.inputs == ("a",)
        assert CUT in kept.program

    def test_a_function_is_written_in_place(self) -> None:
        lines, square = Lines(), (real("t"), real("x") ** 2)
        (found,) = lines.inline("one_", [square], [real("t") + 1], {real("x"): A + B})
        (other,) = lines.inline("one_", [square], [real("t") + 1], {real("x"): B})
        text = function_text("f", ("a", "b"), lines.assignments, [found, other])
        assert function_of(text, "f", {})(2.0, 3.0) == (26.0, 10.0)


def test_straight_lines_give_what_formulas_give() -> None:
    formulas = [(A + B) ** 2 / (A * B), sympy.sqrt((A + B) ** 2 + 1) * A, (A + B) ** -3]
    assignments, results = straight_lines(formulas)
    assert assignments
    found = function_of(function_text("f", ("a", "b"), assignments, results), "f", scalar_functions(ROW))(0.7, 1.9)
    np.testing.assert_allclose(found, [float(own.subs({A: 0.7, B: 1.9})) for own in formulas], rtol=1e-14)


def test_what_parameters_alone_decide_is_lifted_out() -> None:
    k, m = real("k"), real("m")
    constants = Constants({k, m})
    lifted = constants.lift(A * k * m / (1 + k) + FUNCTIONS["minimum"](k, B) + sympy.sqrt(m))
    assert not lifted.free_symbols & {k, m}
    numbers = {k: 0.3, m: 2.5}
    known = {name: float(value.subs(numbers)) for value, name in constants.table.items()}
    found = lifted.subs(known).subs({A: 1.5})
    expected = 1.5 * 0.75 / 1.3 + FUNCTIONS["minimum"](0.3, B) + math.sqrt(2.5)
    assert float((found - expected).subs(B, 1)) == pytest.approx(0.0, abs=1e-12)


def reads_table(value: sympy.Expr) -> bool:
    return str(value.func) == "entry"


class TestRounds:
    """A loop over lanes each."""

    def program(self, reads: bool) -> Lines:
        lines = Lines()
        cell = lines.put("cell", FUNCTIONS["whole"](A))
        value = lines.put("value", FUNCTIONS["entry"](3, cell) if reads else cell * 2)
        middle = lines.put("middle", value * B)
        lines.cut()
        after = lines.put("after", middle + B)
        lines.put("again", FUNCTIONS["entry"](4, after) if reads else after)
        return lines

    @pytest.mark.parametrize("reads", [False, True])
    def test_each_line_comes_after_what_it_needs(self, reads: bool) -> None:
        lines, made, seen = self.program(reads), {"a", "b"}, []
        for part in rounds(lines, reads_table):
            for name, value in part:
                assert {str(own) for own in value.free_symbols} <= made
                made.add(str(name))
                seen.append(name)
        assert sorted(map(str, seen)) == sorted(str(name) for name, _ in lines.assignments)

    def test_reads_of_the_table_have_rounds_of_their_own(self) -> None:
        kinds = [{str(value.func) == "entry" for _, value in part} for part in rounds(self.program(True), reads_table)]
        assert all(len(kind) == 1 for kind in kinds)
        assert sum(kind == {True} for kind in kinds) == 2

    def test_a_cut_parts_a_program(self) -> None:
        assert len(rounds(self.program(False))) == 2
