"""Physical dimensions as exponents of mass, length and time."""

import re
from functools import cache
from typing import NamedTuple

from narrows.base.errors import InputError


class Dimension(NamedTuple):
    """Physical dimension of a coefficient.

    Examples
    --------
    >>> nw.Dimension(mass=1).unit
    'kg'
    """

    mass: int = 0  #: Exponent of kg [1]
    length: int = 0  #: Exponent of m [1]
    time: int = 0  #: Exponent of s [1]

    @property
    def unit(self) -> str:
        """The SI unit in words, ``kg m/s`` for (1, 1, -1) and ``1`` for a pure number."""
        powers = list(zip(("kg", "m", "s"), self, strict=True))
        above = " ".join(_power(name, n) for name, n in powers if n > 0)
        below = " ".join(_power(name, -n) for name, n in powers if n < 0)
        return (above or "1") + (f"/{below}" if below else "")


def _power(name: str, exponent: int) -> str:
    return name if exponent == 1 else f"{name}{exponent}"


NUMBER = Dimension()
KG = Dimension(1)
KG_M = Dimension(1, 1)
KG_M2 = Dimension(1, 2)
KG_PER_M = Dimension(1, -1)
KG_PER_S = Dimension(1, 0, -1)
KG_M_PER_S = Dimension(1, 1, -1)
KG_M2_PER_S = Dimension(1, 2, -1)
# Exponents of the base units.
BASE = {
    "1": (0, 0, 0), "rad": (0, 0, 0), "deg": (0, 0, 0), "kg": (1, 0, 0), "m": (0, 1, 0), "s": (0, 0, 1),
    "N": (1, 1, -2),
}  # fmt: skip


@cache
def dimension_of(unit: str) -> Dimension:
    """Return the dimension of a unit in the vocabulary's spelling: ``kg m2``, ``rad/s``, ``1``."""
    above, _, below = unit.partition("/")
    parts = [(word, 1) for word in above.split()] + [(word, -1) for word in below.split()]
    total = NUMBER
    for word, sign in parts:
        match = re.fullmatch(r"(1|[A-Za-z]+)(\d?)", word)
        if not match or match[1] not in BASE:
            raise InputError(f"{unit!r} is no unit here; write one of {', '.join(BASE)}, as in 'kg m2/s'")
        power = sign * int(match[2] or 1)
        total = Dimension(*(a + power * b for a, b in zip(total, BASE[match[1]], strict=True)))
    return total
