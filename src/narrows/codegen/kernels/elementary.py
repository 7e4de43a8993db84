"""Elementary functions without branches or calls of the C library, so that loops over lanes vectorise."""

import re
from functools import lru_cache
from importlib.metadata import version
from math import factorial, radians
from types import ModuleType
from typing import NamedTuple

from narrows.codegen.cache import generated

SINE_TERMS = 11
"""Terms of the series of sine and cosine: exact to the last place up to a quarter turn, enough for any rudder."""
ANGLE_TERMS = 12
"""Terms of the polynomial for arctan t/t up to an eighth of half a turn."""

NUMBER = {"float64": "{}".format, "float32": "real({})".format}
"""Spelling of a number in each precision: a literal is a double, and calls of ``real`` compile slowly."""
CAST = re.compile(r"real\(([0-9.e+-]+)\)")

HEADER = '''"""Made by narrows {version} from a table of terms: made again where it is missing, so do not edit."""
from math import cos, hypot, inf, nan, sin, sqrt

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy import {precision} as real

try:
    import numba
except ImportError:  # The functions run as written. NumPy's roots and quotients raise no errors, like compiled ones.
    from numpy import cos, hypot, sin, sqrt

    def jit(function):
        return function

    def cached(function):
        return np.errstate(all="ignore")(function)

    called = inlined = jit
else:
    FAST = {{"nsz", "contract"}}  # fused multiply-add, nothing reordered: the mirrored voyage is the mirror to the bit
    jit = numba.njit(fastmath=FAST, error_model="numpy", nogil=True, forceinline=True)
    called = numba.njit(fastmath=FAST, error_model="numpy", nogil=True)
    cached = numba.njit(fastmath=FAST, error_model="numpy", nogil=True, cache=True)
    inlined = numba.njit(fastmath=FAST, error_model="numpy", nogil=True, cache=True, forceinline=True)
'''
# Functions that all modules of a precision share, so that they are compiled once.
CALLS = """
from narrows.codegen.kernels.elementary import shared_functions

shared = shared_functions("{precision}")
minimum, maximum, choice, positive, whole = (
    shared.minimum, shared.maximum, shared.choice, shared.positive, shared.whole
)
power, exp, sine, cosine, angle = shared.power, shared.exp, shared.sine, shared.cosine, shared.angle
CELL_ENTRIES = {cells}


@jit
def entry(table, column, cell):
    return table[np.uint64(CELL_ENTRIES * np.int64(cell) + np.int64(column))]
"""

SIMPLE = """
@jit
def minimum(a, b):
    return a if a < b else b


@jit
def maximum(a, b):
    return a if a > b else b


@jit
def choice(test, over, under):
    return over if test > real(0.0) else under


@jit
def positive(test):
    return real(1.0) if test > real(0.0) else real(0.0)


@jit
def whole(number):
    return real(np.int64(number))


@jit
def power(base, exponent):
    return base**exponent
"""
ANGLE = """
@jit
def angle(cosine, sine):
    a, b = abs(sine), abs(cosine)
    some, most = a > real({eighth!r}) * b, a > real({three_eighths!r}) * b
    turn_c = real(0.0) if most else (real({half!r}) if some else real(1.0))
    turn_s = real(1.0) if most else (real({half!r}) if some else real(0.0))
    by = real({quarter_turn!r}) if most else (real({eighth_turn!r}) if some else real(0.0))
    t = (a * turn_c - b * turn_s) / (b * turn_c + a * turn_s)
    q = t * t
    arctangent = by + t * ({series})
    arctangent = arctangent if cosine >= real(0.0) else real({half_turn!r}) - arctangent
    return arctangent if sine >= real(0.0) else -arctangent
"""


def module_text(precision: str, cells: int, *parts: str) -> str:
    """Write a module that may call the elementary functions; ``cells`` is the width of a waterway's table."""
    head = HEADER.format(version=version("narrows"), precision=precision)
    return "\n\n".join([head, CALLS.format(precision=precision, cells=cells), *parts])


def shared_functions(precision: str) -> ModuleType:
    """Return the elementary functions of a precision."""

    def text() -> str:
        functions = [SIMPLE, exponential_text(precision), _series("sine", 1), _series("cosine", 0), _angle_text()]
        body = "\n\n\n".join(function.strip() for function in functions).replace("@jit", "@inlined") + "\n"
        head = HEADER.format(version=version("narrows"), precision=precision)
        return head + "\n\n" + (CAST.sub(r"\1", body) if precision == "float64" else body)

    return generated("elementary", [precision], text)


def _series(name: str, first: int) -> str:
    """Sine or cosine by its series, in Horner's form."""
    signs = [(-1) ** k / factorial(2 * k + first) for k in range(SINE_TERMS)]
    text = f"real({signs[-1]!r})"
    for coefficient in reversed(signs[:-1]):
        text = f"real({coefficient!r}) + q * ({text})"
    lead = "a * " if first else ""
    return f"@jit\ndef {name}(a):\n    q = a * a\n    return {lead}({text})"


@lru_cache(maxsize=1)
def _angle_text() -> str:
    """Write the angle of a cosine and a sine: rotation by a multiple of 45 degrees, one division, a short polynomial.

    The coefficients interpolate arctan t/t in t squared at Chebyshev's points, computed with 50 digits.
    """
    from mpmath import mp  # type: ignore[import-untyped]

    with mp.workdps(50):
        top = mp.tan(mp.mpf(radians(22.51))) ** 2
        places = [top * (1 + mp.cos(mp.pi * (2 * k + 1) / (2 * ANGLE_TERMS))) / 2 for k in range(ANGLE_TERMS)]
        values = mp.matrix([mp.atan(mp.sqrt(q)) / mp.sqrt(q) for q in places])
        coefficients = mp.lu_solve(mp.matrix([[q**p for p in range(ANGLE_TERMS)] for q in places]), values)
        series = f"real({float(coefficients[ANGLE_TERMS - 1])!r})"
        for k in reversed(range(ANGLE_TERMS - 1)):
            series = f"real({float(coefficients[k])!r}) + q * ({series})"
        numbers = {
            "eighth": float(mp.tan(mp.pi / 8)), "three_eighths": float(mp.tan(3 * mp.pi / 8)),
            "half": float(mp.sqrt(mp.mpf(1) / 2)), "quarter_turn": float(mp.pi / 2), "eighth_turn": float(mp.pi / 4),
            "half_turn": float(mp.pi),
        }  # fmt: skip
    return ANGLE.format(series=series, **numbers).strip()


class Width(NamedTuple):
    """Constants of a floating-point format for the exponential."""

    integer: str
    low: float
    high: float
    magic: float
    ln2_high: float
    ln2_low: float
    bias: int
    mantissa: int
    degree: int


WIDTHS = {
    "float64": Width(
        "int64", -708.0, 709.0, 1.5 * 2.0**52, 6.93147180369123816490e-01, 1.90821492927058770002e-10, 1023, 52, 13
    ),
    "float32": Width("int32", -87.0, 88.0, 1.5 * 2.0**23, 0.693359375, -2.12194440054690583e-4, 127, 23, 8),
}
# e^x = 2^k e^r with k the nearest integer to x / ln 2. Adding 1.5 2^52 rounds to that integer and leaves it in the low
# bits; a shift puts it into the exponent. This is one reason why kernels are not compiled with ``reassoc``.
TEXT = """
@jit
def exp(x):
    x = min(max(x, real({low})), real({high}))
    shifted = x * real(1.4426950408889634) + real({magic})
    whole = shifted - real({magic})
    rest = x - whole * real({ln2_high}) - whole * real({ln2_low})
    power = np.{integer}((real(shifted).view(np.{integer}) + {bias}) << {mantissa})
    return ({polynomial}) * power.view(real)
"""


def exponential_text(precision: str) -> str:
    """Write the function ``exp`` of a kernel, accurate to one unit in the last place [1]_.

    Parameters
    ----------
    precision : str
        ``float64`` or ``float32``.

    References
    ----------
    .. [1] Cody and Waite (1980), Software Manual for the Elementary Functions: ln 2 in two parts.
    """
    width = WIDTHS[precision]
    polynomial = f"real({1 / factorial(width.degree)!r})"
    for power in reversed(range(width.degree)):
        polynomial = f"({polynomial}) * rest + real({1 / factorial(power)!r})"
    return TEXT.format(polynomial=polynomial, **width._asdict()).lstrip()
