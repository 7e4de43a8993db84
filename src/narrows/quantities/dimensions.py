"""Physical dimensions as exponents of mass, length and time."""

from typing import NamedTuple


class Dimension(NamedTuple):
    """What a coefficient is measured in.

    Parameters
    ----------
    mass, length, time : int [1]
        Exponents of kg, m and s.
    """

    mass: int = 0
    length: int = 0
    time: int = 0

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
METRE = Dimension(0, 1)
KG = Dimension(1)
KG_M = Dimension(1, 1)
KG_M2 = Dimension(1, 2)
KG_PER_M = Dimension(1, -1)
KG_PER_S = Dimension(1, 0, -1)
KG_M_PER_S = Dimension(1, 1, -1)
KG_M2_PER_S = Dimension(1, 2, -1)
