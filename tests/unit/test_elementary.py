"""Elementary functions of the kernels, compiled as there, against NumPy and the C library."""

import ctypes
import math
from collections.abc import Callable
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from narrows.codegen.cache import import_generated
from narrows.codegen.compilation import address
from narrows.codegen.free_motion import ROW
from narrows.codegen.printers.python import module_text
from narrows.codegen.system import column_functions, scalar_functions

LANES = 64
ARGUMENTS = {
    "exp": 1, "sine": 1, "cosine": 1, "whole": 1, "positive": 1, "minimum": 2, "maximum": 2, "angle": 2, "power": 2,
    "choice": 3,
}  # fmt: skip
READ_COLUMNS = (0, 5, ROW - 1)


def over_lanes(name: str, call: str) -> str:
    return (
        f"def {name}_of(block, table):\n    for lane in range({LANES}):\n        block[{3 * LANES} + lane] = {call}\n"
    )


def compiled() -> SimpleNamespace:
    """All of them, on whole columns."""
    columns = [f"block[{LANES * k} + lane]" for k in range(3)]
    calls = {name: f"{name}({', '.join(columns[:count])})" for name, count in ARGUMENTS.items()}
    calls |= {f"entry_{column}": f"entry(table, {column}, {columns[0]})" for column in READ_COLUMNS}
    text = module_text(ROW, *(over_lanes(name, call) for name, call in calls.items()))
    module = import_generated("elementary", [text], lambda: text)
    return SimpleNamespace(**{name: lanes(module, name) for name in calls}, written=module)


def lanes(module: ModuleType, name: str) -> Callable[..., np.ndarray]:
    """A function of columns, which the compiled one takes lane by lane."""
    function = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p)(address(module, f"{name}_of"))

    def of(*columns: np.ndarray, table: np.ndarray = np.zeros(1)) -> np.ndarray:
        found = []
        for first in range(0, len(columns[0]), LANES):
            block = np.zeros((4, LANES))
            for row, column in zip(block, columns, strict=False):
                row[: len(column[first : first + LANES])] = column[first : first + LANES]
            function(block.ctypes.data, table.ctypes.data)
            found.append(block[3])
        return np.concatenate(found)[: len(columns[0])]

    return of


@pytest.fixture(scope="module")
def double() -> SimpleNamespace:
    return compiled()


def test_the_exponential_is_good_to_the_last_place(double: SimpleNamespace) -> None:
    x = np.random.default_rng(0).uniform(-700.0, 700.0, 2000)
    np.testing.assert_allclose(double.exp(x), [math.exp(own) for own in x], rtol=3e-16)


@pytest.mark.parametrize(("name", "exact"), [("sine", np.sin), ("cosine", np.cos)])
def test_sine_and_cosine_up_to_a_quarter_turn(double, name: str, exact) -> None:
    x = np.linspace(-np.pi / 2, np.pi / 2, 4001)
    found = getattr(double, name)(x)
    assert np.abs(found - exact(x)).max() < 3e-16
    np.testing.assert_array_equal(getattr(double, name)(-x), found if name == "cosine" else -found)


def test_the_angle_over_the_whole_circle(double: SimpleNamespace) -> None:
    """Of vectors of any length; odd to the bit, the eighths of the circle and their neighbours too."""
    eighths = np.arange(-8, 9) * np.pi / 8
    turns = np.sort(np.concatenate([np.linspace(-np.pi, np.pi, 4001), eighths, eighths + 1e-9, eighths - 1e-9]))
    for length in (1.0, 3.7e-3, 1e4):
        c, s = length * np.cos(turns), length * np.sin(turns)
        found, expected = double.angle(c, s), np.arctan2(s, c)
        # Relative: half a turn is known to no more than the last place of half a turn.
        error = np.abs(found - expected) / np.maximum(1.0, np.abs(expected))
        assert error.max() < 4e-16
        seen = s != 0
        np.testing.assert_array_equal(double.angle(c, -s)[seen], -found[seen])


def test_the_angle_on_the_axes(double: SimpleNamespace) -> None:
    c, s = np.array([1.0, 0.0, -1.0, 0.0]), np.array([0.0, 1.0, 0.0, -1.0])
    np.testing.assert_array_equal(double.angle(c, s), [0.0, np.pi / 2, np.pi, -np.pi / 2])


def test_a_small_angle_keeps_its_digits(double: SimpleNamespace) -> None:
    small = 10.0 ** np.arange(-300.0, -1.0, 7)
    np.testing.assert_allclose(double.angle(np.ones_like(small), small), np.arctan(small), rtol=4e-16)


PAIRS = np.random.default_rng(2).uniform(-3, 3, (3, 200))


def test_the_simple_ones_are_those_of_floats_and_of_columns(double: SimpleNamespace) -> None:
    """One meaning in kernels, in single voyages and in columns."""
    a, b, c = PAIRS
    floats, columns = scalar_functions(ROW), column_functions()
    cases = {
        "minimum": (a, b), "maximum": (a, b), "choice": (a, b, c), "positive": (a,), "whole": (3 * a,),
        "power": (np.abs(a), b),
    }  # fmt: skip
    for name, given in cases.items():
        found = getattr(double, name)(*given)
        np.testing.assert_allclose(found, columns[name](*given), rtol=1e-15, err_msg=name)
        alone = [floats[name](*map(float, row)) for row in zip(*given, strict=True)]
        np.testing.assert_allclose(found, alone, rtol=1e-15, err_msg=name)


def test_nought_is_not_over_nought(double: SimpleNamespace) -> None:
    zero = np.zeros(1)
    for functions in (vars(double), column_functions()):
        assert functions["positive"](zero)[0] == 0.0
        assert functions["choice"](zero, zero + 1, zero + 2)[0] == 2.0
    assert double.written.choice(0.0, 1.0, 2.0) == 2.0
    assert scalar_functions(ROW)["choice"](0.0, 1.0, 2.0) == 2.0


@pytest.mark.parametrize("exponent", [-3.0, -1.0, 0.5, 1.5, 2.0, 5.0, 7.0])
def test_powers_of_negative_numbers(double: SimpleNamespace, exponent: float) -> None:
    """Whole ones are; no other is a number, and none is an error or complex."""
    base = np.array([-2.0, -0.3, 0.7, 3.0])
    with np.errstate(invalid="ignore"):
        expected = np.power(base, exponent)
    np.testing.assert_allclose(double.power(base, np.full(4, exponent)), expected, rtol=1e-15)
    alone = [scalar_functions(ROW)["power"](float(own), exponent) for own in base]
    np.testing.assert_allclose(alone, expected, rtol=1e-15)


def test_a_root_of_a_negative_number_is_none() -> None:
    assert math.isnan(scalar_functions(ROW)["sqrt"](-1e-300))
    assert scalar_functions(ROW)["sqrt"](2.25) == 1.5


def test_entries_are_read_cell_by_cell(double: SimpleNamespace) -> None:
    table, cells = np.arange(3.0 * ROW), np.array([2.0, 0.0, 1.0])
    for column in READ_COLUMNS:
        expected = table.reshape(3, ROW)[cells.astype(int), column]
        np.testing.assert_array_equal(getattr(double, f"entry_{column}")(cells, table=table), expected)
        assert double.written.entry(table, column, 1.0) == expected[2]
        assert scalar_functions(ROW)["entry"](table.tolist(), column, 1.0) == expected[2]


def test_as_written_they_are_what_is_compiled(double: SimpleNamespace) -> None:
    """Without a compiler the text itself runs."""
    a, b, c = PAIRS
    for name, count in ARGUMENTS.items():
        given = [np.abs(a) if name == "power" else a, b, c][:count]
        alone = [getattr(double.written, name)(*row) for row in zip(*given, strict=True)]
        np.testing.assert_allclose(getattr(double, name)(*given), alone, rtol=4e-16, atol=1e-15, err_msg=name)
