"""Elementary functions without branches or calls of the C library, so that loops over lanes vectorise."""

from collections.abc import Sequence
from importlib.metadata import version
from math import factorial

# Terms of the series of sine and cosine: exact to the last place up to a quarter turn, enough for any rudder.
SINE_TERMS = 11
# Coefficients of (arctan t)/t in t squared up to 22.51 degrees: interpolated at Chebyshev's points with 50 digits.
ARCTANGENT = (
    1.0, -0.3333333333333312, 0.19999999999940354, -0.1428571427919797, 0.11111110742319581, -0.09090896733922893,
    0.07692043981943032, -0.06662936310726283, 0.05846764171822936, -0.05034582119172788, 0.03795188185921145,
    -0.017790581120278405,
)  # fmt: skip
EXPONENTIAL_DEGREE = 13

# The exponential, to one unit in the last place, is e^x = 2^k e^r with k the nearest integer to x / ln 2, itself in two
# parts: Cody and Waite (1980), Software Manual for the Elementary Functions. Adding 1.5 2^52 rounds to that integer and
# leaves it in the low bits; a shift puts it into the exponent: a reason why kernels are compiled without ``reassoc``.
# An angle is a rotation by multiples of 45 degrees, one division and a short polynomial.
HEADER = '''"""Made by narrows {version} from a table of terms: made again where it is missing, so do not edit."""
import numpy as np
from numpy import float64 as real
from numpy import cos, log, sin, sqrt

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


def exp(x):
    x = min(max(x, -708.0), 709.0)
    shifted = x * 1.4426950408889634 + 6755399441055744.0
    whole = shifted - 6755399441055744.0
    rest = x - whole * 0.6931471803691238 - whole * 1.9082149292705877e-10
    power = np.int64((real(shifted).view(np.int64) + 1023) << 52)
    return ({exponential}) * power.view(real)


def sine(a):
    q = a * a
    return a * ({sine})


def cosine(a):
    q = a * a
    return {cosine}


def angle(cosine, sine):
    a, b = abs(sine), abs(cosine)
    some, most = a > 0.41421356237309503 * b, a > 2.414213562373095 * b
    turn_c = 0.0 if most else (0.7071067811865476 if some else 1.0)
    turn_s = 1.0 if most else (0.7071067811865476 if some else 0.0)
    by = 1.5707963267948966 if most else (0.7853981633974483 if some else 0.0)
    t = (a * turn_c - b * turn_s) / (b * turn_c + a * turn_s)
    q = t * t
    arctangent = by + t * ({arctangent})
    arctangent = arctangent if cosine >= 0.0 else 3.141592653589793 - arctangent
    return arctangent if sine >= 0.0 else -arctangent
'''


def module_text(cells: int, *parts: str) -> str:
    """Write a module that may call the elementary functions; ``cells`` is the width of a waterway's table."""
    sine, cosine = (horner("q", [(-1) ** k / factorial(2 * k + first) for k in range(SINE_TERMS)]) for first in (1, 0))
    exponential = horner("rest", [1 / factorial(power) for power in range(EXPONENTIAL_DEGREE + 1)])
    head = HEADER.format(
        version=version("narrows"), cells=cells, exponential=exponential, sine=sine, cosine=cosine,
        arctangent=horner("q", ARCTANGENT),
    )  # fmt: skip
    return "\n\n\n".join(part.strip() for part in (head, *parts)) + "\n"


def horner(x: str, coefficients: Sequence[float]) -> str:
    text = repr(coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        text = f"{coefficient!r} + {x} * ({text})"
    return text
