"""Headers: the quantity of a column, its unit, and the factor to SI; units by name."""

import math
import re
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from narrows.base.errors import InputError
from narrows.quantities.names import DEGREE, Quantity

if TYPE_CHECKING:
    import pandas as pd


# Units behind an underscore, as in psi_deg.
SUFFIXES = (
    "m", "mm", "deg", "rad", "mps", "mps2", "degps", "degps2", "radps", "radps2", "s", "N", "kN", "Nm", "kNm", "kn",
    "rpm", "rps",
)  # fmt: skip


class Vocabulary(NamedTuple):
    quantities: Mapping[str, Quantity]  # Columns of numbers
    labels: tuple[str, ...] = ()  # Columns of words
    blanks: bool = False  # True if a cell of numbers may be empty


class Column(NamedTuple):
    header: str  # Text in the table
    quantity: str  # Name in the vocabulary
    scale: float  # Factor to SI [1]
    stated: bool  # True if the header has a unit


def parse_header(header: str, known: Mapping[str, Quantity]) -> Column | None:
    """Read one header: ``psi``, ``psi [deg]``, ``psi (deg)`` or ``psi_deg``."""
    name, unit = _split(header.strip(), known)
    if name not in known:
        return None
    si = known[name].unit
    return Column(header, name, 1.0 if unit is None else _scale(header, unit, si), unit is not None)


def recognised_in(frame: "pd.DataFrame", known: Mapping[str, Quantity], table: str) -> list[Column]:
    try:
        return [column for header in frame.columns if (column := parse_header(str(header), known))]
    except InputError as error:
        raise InputError(f"{table}: {error}") from None


def unit_of(header: str) -> str:
    """Return the unit of any header, of a quantity or not; empty if it has none."""
    if match := re.search(r"(?:\[([^\]]*)\]|\(([^)]*)\))\s*$", header):
        return (match[1] or match[2] or "").strip()
    name, _, suffix = header.strip().rpartition("_")
    return suffix if name and suffix in SUFFIXES else ""


def _split(header: str, known: Mapping[str, Quantity]) -> tuple[str, str | None]:
    if match := re.fullmatch(r"(\w+)\s*(?:\[(.*)\]|\((.*)\))", header):
        return match[1], (match[2] or match[3] or "").strip()
    name, _, suffix = header.rpartition("_")
    return (name, suffix) if name in known and suffix in SUFFIXES else (header, None)


def _scale(header: str, unit: str, si: str) -> float:
    if unit == si:
        return 1.0
    given, wanted = unit_named(unit), unit_named(si)
    if given is None or wanted is None:
        raise InputError(f"column {header!r}: unknown unit [{unit}]; give it in [{si}]")
    if given.powers != wanted.powers:
        raise InputError(f"column {header!r}: {unit} is not a unit of this quantity; give it in {si}")
    return given.scale / wanted.scale


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
