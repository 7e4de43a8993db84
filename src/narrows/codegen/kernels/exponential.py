"""An exponential of arithmetic alone, which vectorises where a call of the C library would not."""

from math import factorial
from typing import NamedTuple


class Width(NamedTuple):
    """What the exponential needs to know of a floating-point format."""

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
# bits, whence it is shifted into the exponent: one more reason why kernels are not compiled with ``reassoc``.
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
    """Write the function ``exp`` of a kernel, good to a unit in the last place [1]_.

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
