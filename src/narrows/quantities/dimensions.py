"""Units by their spelling, and physical dimensions as exponents of mass, length and time."""

import math
import re
from functools import cache
from typing import NamedTuple

from narrows.base.errors import InputError
from narrows.quantities.names import DEGREE


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
        above, below = (
            " ".join(f"{name}{abs(n)}".removesuffix("1") for name, n in powers if way * n > 0) for way in (1, -1)
        )
        return (above or "1") + (f"/{below}" if below else "")


NUMBER = Dimension()
KG = Dimension(1)
KG_M = Dimension(1, 1)
KG_M2 = Dimension(1, 2)
KG_PER_M = Dimension(1, -1)
KG_PER_S = Dimension(1, 0, -1)
KG_M_PER_S = Dimension(1, 1, -1)
KG_M2_PER_S = Dimension(1, 2, -1)


@cache
def dimension_of(unit: str) -> Dimension:
    """Return the dimension of an SI unit, or of degrees, in the vocabulary's spelling: ``kg m2``, ``rad/s``, ``1``."""
    above, *below = (unit or "1").split("/")
    known = unit_named("/".join([above, *" ".join(below).split()]))  # All behind the stroke divides
    if known is None or known.scale not in (1.0, DEGREE) or any(known.powers[3:]):
        raise InputError(f"{unit!r} is no unit here; write SI units, as in 'kg m2/s'")
    length, mass, time = known.powers[:3]
    return Dimension(mass, length, time)


def is_unit(word: str) -> bool:
    """Return whether a word, without brackets, is a unit."""
    named = any(character.isalpha() or character == "°" for character in word)
    return named and (word in TEMPERATURES or unit_named(word) is not None)


TEMPERATURES = ("°C", "degC", "°F", "degF")  # Units in tables without a factor to SI


class Unit(NamedTuple):
    """Factor to SI, and powers of metre, kilogram, second, ampere and kelvin."""

    scale: float
    powers: tuple[int, ...] = (0, 0, 0, 0, 0)


BASES = {
    "m": Unit(1.0, (1, 0, 0, 0, 0)), "kg": Unit(1.0, (0, 1, 0, 0, 0)), "s": Unit(1.0, (0, 0, 1, 0, 0)),
    "A": Unit(1.0, (0, 0, 0, 1, 0)), "K": Unit(1.0, (0, 0, 0, 0, 1)),
}  # fmt: skip
# Units by others, the names of one unit together. Angles are dimensionless. One revolution counts as 1 in rpm and rps,
# as usual for propellers, but as 2 pi in "revolution". Names of three letters and more take a plural s.
PREFIXED = {
    "m metre meter": "m", "g gram": "0.001 kg", "s sec second": "s", "N newton": "kg m/s2", "Pa pascal": "N/m2",
    "J joule": "N m", "W watt": "J/s", "Hz hertz": "1/s", "rad radian": "1", "A ampere": "A", "V volt": "W/A",
    "K kelvin": "K",
}  # fmt: skip
WHOLE = {
    "ft foot feet": "0.3048 m", "in inch inches": "ft/12", "yd yard": "3 ft", "mi mile": "1609.344 m",
    "nmi nautical_mile": "1852 m", "t tonne": "1000 kg", "lb pound": "0.45359237 kg", "min minute": "60 s",
    "h hr hour": "3600 s", "d day": "24 h", "kn kt kts knot": "nmi/h", "mph": "mi/h", "kph": "km/h", "mps": "m/s",
    "mps2": "m/s2", "kgf": "9.80665 N", "lbf": "9.80665 lb m/s2", "psi": "lbf/in2", "hp": "550 ft lbf/s",
    "Nm": "N m", "kNm": "kN m", "Nmm": "N mm", "° deg degree": repr(DEGREE), "arcmin arcminute": "deg/60",
    "arcsec arcsecond": "arcmin/60", "revolution turn": "360 deg", "degps": "deg/s", "degps2": "deg/s2",
    "radps": "rad/s", "radps2": "rad/s2", "rpm": "1/min", "rps": "1/s", "% percent": "0.01", "dimensionless": "1",
    "bar": "100000 Pa", "mbar": "100 Pa",
}  # fmt: skip
UNITS = {name: text for names, text in (PREFIXED | WHOLE).items() for name in names.split()}
PREFIXES = {
    "n": 1e-9, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1, "h": 1e2, "k": 1e3, "M": 1e6, "G": 1e9,
    "milli": 1e-3, "centi": 1e-2, "kilo": 1e3,
}  # fmt: skip


@cache
def unit_named(text: str) -> Unit | None:
    """Return a unit from its spelling in headers, ``m/s2``, ``kN m`` or ``deg/s^2``; None if it is unknown."""
    products = re.sub(r"(?<=[A-Za-z])[-.](?=[A-Za-z])", "*", text.strip())
    signs = products.replace("**", "^").translate({ord("²"): "^2", ord("³"): "^3", ord("·"): "*", ord("・"): "*"})
    parts = re.split(r"\s*([*/])\s*|\s+", signs)
    scale, powers = 1.0, (0, 0, 0, 0, 0)
    for sign, part in zip(["*", *parts[1::2]], parts[::2], strict=True):
        if (factor := _factor(part)) is None:
            return None
        way = -1 if sign == "/" else 1
        scale = scale / factor.scale if sign == "/" else scale * factor.scale
        powers = tuple(a + way * b for a, b in zip(powers, factor.powers, strict=True))  # type: ignore[assignment]
    return Unit(scale, powers)


def _factor(text: str) -> Unit | None:
    """A number, a unit, or a power of one."""
    if known := _single(text):
        return known
    if re.fullmatch(r"\d+(\.\d+)?(e[+-]?\d+)?", text) and 0 < float(text) < math.inf:
        return Unit(float(text))
    power = re.fullmatch(r"(\D+?)(?:\^?(\d)|\^\(?(-\d)\)?)", text)
    if power is None or (known := _single(power[1])) is None:
        return None
    exponent = int(power[2] or power[3])
    return Unit(known.scale**exponent, tuple(exponent * one for one in known.powers))


@cache
def _single(word: str) -> Unit | None:
    """A unit by its name, singular or plural, with or without a prefix."""
    for name in (word, word.removesuffix("s") if len(word) > 3 else word):
        if known := BASES.get(name) or (unit_named(UNITS[name]) if name in UNITS else None):
            return known
        for prefix, factor in PREFIXES.items():
            one = name.removeprefix(prefix)
            if one != name and any(one in names.split() for names in PREFIXED) and (known := _single(one)):
                return Unit(factor * known.scale, known.powers)
    return None
