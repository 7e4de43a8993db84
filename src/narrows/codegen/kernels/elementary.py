"""Elementary functions without branches or calls of the C library, so that loops over lanes vectorise."""

from functools import lru_cache
from importlib.metadata import version
from math import factorial, radians
from typing import NamedTuple

SINE_TERMS = 11
"""Terms of the series of sine and cosine: exact to the last place up to a quarter turn, enough for any rudder."""
ANGLE_TERMS = 12
"""Terms of the polynomial for (arctan t)/t, for angles up to 22.5 degrees."""

HEADER = '''"""Made by narrows {version} from a table of terms: made again where it is missing, so do not edit."""
import numpy as np
from numpy import {precision} as real
from numpy import cos, log, sin, sqrt

PRECISION = "{precision}"
CELL_ENTRIES = {cells}

# Without a compiler the functions run as written. NumPy's roots and quotients raise no errors, like compiled ones.
quiet = np.errstate(all="ignore")


def entry(table, column, cell):
    return table[CELL_ENTRIES * int(cell) + int(column)]


def minimum(a, b):
    return a if a < b else b


def maximum(a, b):
    return a if a > b else b


def choice(test, over, under):
    return over if test > 0.0 else under


def positive(test):
    return 1.0 if test > 0.0 else 0.0


def whole(number):
    return real(np.int64(number))


def power(base, exponent):
    return base**exponent
'''

ANGLE = """
def angle(cosine, sine):
    a, b = abs(sine), abs(cosine)
    some, most = a > {eighth!r} * b, a > {three_eighths!r} * b
    turn_c = 0.0 if most else ({half!r} if some else 1.0)
    turn_s = 1.0 if most else ({half!r} if some else 0.0)
    by = {quarter_turn!r} if most else ({eighth_turn!r} if some else 0.0)
    t = (a * turn_c - b * turn_s) / (b * turn_c + a * turn_s)
    q = t * t
    arctangent = by + t * ({series})
    arctangent = arctangent if cosine >= 0.0 else {half_turn!r} - arctangent
    return arctangent if sine >= 0.0 else -arctangent
"""


def module_text(precision: str, cells: int, *parts: str) -> str:
    """Write a module that may call the elementary functions; ``cells`` is the width of a waterway's table."""
    head = HEADER.format(version=version("narrows"), precision=precision, cells=cells)
    functions = [exponential_text(precision), _series("sine", 1), _series("cosine", 0), _angle_text()]
    return "\n\n\n".join(part.strip() for part in (head, *functions, *parts)) + "\n"


def _series(name: str, first: int) -> str:
    """Sine or cosine by its series, in Horner's form."""
    signs = [(-1) ** k / factorial(2 * k + first) for k in range(SINE_TERMS)]
    text = repr(signs[-1])
    for coefficient in reversed(signs[:-1]):
        text = f"{coefficient!r} + q * ({text})"
    lead = "a * " if first else ""
    return f"def {name}(a):\n    q = a * a\n    return {lead}({text})"


@lru_cache(maxsize=1)
def _angle_text() -> str:
    """Write the angle of a cosine and a sine: rotation by multiples of 45 degrees, one division, a short polynomial."""
    # The coefficients interpolate arctan t/t in t squared at Chebyshev's points, computed with 50 digits.
    from mpmath import mp  # type: ignore[import-untyped]

    with mp.workdps(50):
        top = mp.tan(mp.mpf(radians(22.51))) ** 2
        places = [top * (1 + mp.cos(mp.pi * (2 * k + 1) / (2 * ANGLE_TERMS))) / 2 for k in range(ANGLE_TERMS)]
        values = mp.matrix([mp.atan(mp.sqrt(q)) / mp.sqrt(q) for q in places])
        coefficients = mp.lu_solve(mp.matrix([[q**p for p in range(ANGLE_TERMS)] for q in places]), values)
        series = repr(float(coefficients[ANGLE_TERMS - 1]))
        for k in reversed(range(ANGLE_TERMS - 1)):
            series = f"{float(coefficients[k])!r} + q * ({series})"
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
def exp(x):
    x = min(max(x, {low}), {high})
    shifted = x * 1.4426950408889634 + {magic}
    whole = shifted - {magic}
    rest = x - whole * {ln2_high} - whole * {ln2_low}
    power = np.{integer}((real(shifted).view(np.{integer}) + {bias}) << {mantissa})
    return ({polynomial}) * power.view(real)
"""


def exponential_text(precision: str) -> str:
    """Write the function ``exp`` of a kernel, accurate to one unit in the last place."""
    # ln 2 in two parts: Cody and Waite (1980), Software Manual for the Elementary Functions.
    width = WIDTHS[precision]
    polynomial = repr(1 / factorial(width.degree))
    for power in reversed(range(width.degree)):
        polynomial = f"({polynomial}) * rest + {1 / factorial(power)!r}"
    return TEXT.format(polynomial=polynomial, **width._asdict()).lstrip()
