"""Headers: the quantity of a column, its unit, and the factor to SI; units by name."""

import math
import re
from collections.abc import Mapping
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING, NamedTuple

from narrows.errors import InputError, installing, libraries_of
from narrows.quantities.names import Quantity

if TYPE_CHECKING:
    import pandas as pd


DEGREE = math.pi / 180
SUFFIXES = (
    "m",
    "mm",
    "deg",
    "rad",
    "mps",
    "mps2",
    "degps",
    "degps2",
    "radps",
    "radps2",
    "s",
    "N",
    "kN",
    "Nm",
    "kNm",
    "kn",
    "rpm",
    "rps",
)


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
        rarer = "" if find_spec("pint") else f"; for rarer units: {installing(libraries_of('units') or ['pint'])}"
        raise InputError(f"column {header!r}: unknown unit [{unit}]; give it in [{si}]{rarer}")
    if given.powers != wanted.powers:
        raise InputError(f"column {header!r}: {unit} is not a unit of this quantity; give it in {si}")
    return given.scale / wanted.scale


def is_unit(word: str) -> bool:
    """Return whether a word, without brackets, is a unit."""
    named = any(character.isalpha() or character == "°" for character in word)
    return named and (word in TEMPERATURES or unit_named(word) is not None)


# Units in tables without a factor to SI.
TEMPERATURES = ("°C", "degC", "°F", "degF")


class Unit(NamedTuple):
    """Factor to SI, and powers of metre, kilogram, second, ampere and kelvin."""

    scale: float
    powers: tuple[int, ...] = (0, 0, 0, 0, 0)


_LENGTH, _MASS, _TIME = (1, 0, 0, 0, 0), (0, 1, 0, 0, 0), (0, 0, 1, 0, 0)
_SPEED, _FORCE, _PRESSURE, _POWER = (1, 0, -1, 0, 0), (1, 1, -2, 0, 0), (-1, 1, -2, 0, 0), (2, 1, -3, 0, 0)
_RATE, _ANGULAR_ACCELERATION, _MOMENT = (0, 0, -1, 0, 0), (0, 0, -2, 0, 0), (2, 1, -2, 0, 0)
_FOOT, _MILE, _POUND, _GRAVITY = 0.3048, 1609.344, 0.45359237, 9.80665
# Angles are dimensionless. One revolution counts as 1 in rpm and rps, as usual for propellers, but as 2 pi in
# "revolution".
SYMBOLS = {
    "m": Unit(1, _LENGTH), "g": Unit(1e-3, _MASS), "s": Unit(1, _TIME), "N": Unit(1, _FORCE), "Pa": Unit(1, _PRESSURE),
    "J": Unit(1, _MOMENT), "W": Unit(1, _POWER), "Hz": Unit(1, _RATE), "rad": Unit(1), "A": Unit(1, (0, 0, 0, 1, 0)),
    "V": Unit(1, (2, 1, -3, -1, 0)), "K": Unit(1, (0, 0, 0, 0, 1)),
}  # fmt: skip
"""Units that take a prefix: mm, kN, mrad."""
PREFIXES = {
    "n": 1e-9, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1, "h": 1e2, "k": 1e3, "M": 1e6, "G": 1e9,
}  # fmt: skip
ABBREVIATIONS = {
    "ft": Unit(_FOOT, _LENGTH), "feet": Unit(_FOOT, _LENGTH), "in": Unit(_FOOT / 12, _LENGTH),
    "inches": Unit(_FOOT / 12, _LENGTH), "yd": Unit(3 * _FOOT, _LENGTH), "mi": Unit(_MILE, _LENGTH),
    "nmi": Unit(1852, _LENGTH), "t": Unit(1e3, _MASS), "lb": Unit(_POUND, _MASS), "min": Unit(60, _TIME),
    "h": Unit(3600, _TIME), "hr": Unit(3600, _TIME), "d": Unit(86400, _TIME),
    **dict.fromkeys(("kn", "kt", "kts"), Unit(1852 / 3600, _SPEED)), "mph": Unit(_MILE / 3600, _SPEED),
    "kph": Unit(1 / 3.6, _SPEED), "kgf": Unit(_GRAVITY, _FORCE), "lbf": Unit(_POUND * _GRAVITY, _FORCE),
    "bar": Unit(1e5, _PRESSURE), "mbar": Unit(1e2, _PRESSURE),
    "psi": Unit(_POUND * _GRAVITY / (_FOOT / 12) ** 2, _PRESSURE),
    "hp": Unit(550 * _FOOT * _POUND * _GRAVITY, _POWER),
    "°": Unit(math.pi / 180), "deg": Unit(math.pi / 180), "arcmin": Unit(math.pi / 10800),
    "arcsec": Unit(math.pi / 648000), "rpm": Unit(1 / 60, _RATE), "rps": Unit(1, _RATE), "%": Unit(0.01),
    "percent": Unit(0.01), "dimensionless": Unit(1), "mps": Unit(1, _SPEED), "mps2": Unit(1, (1, 0, -2, 0, 0)),
    "degps": Unit(math.pi / 180, _RATE), "degps2": Unit(math.pi / 180, _ANGULAR_ACCELERATION),
    "radps": Unit(1, _RATE), "radps2": Unit(1, _ANGULAR_ACCELERATION),
    "Nm": Unit(1, _MOMENT), "kNm": Unit(1e3, _MOMENT), "Nmm": Unit(1e-3, _MOMENT),
}  # fmt: skip
WORDS = {
    **dict.fromkeys(("metre", "meter"), Unit(1, _LENGTH)),
    **dict.fromkeys(("kilometre", "kilometer"), Unit(1e3, _LENGTH)),
    **dict.fromkeys(("centimetre", "centimeter"), Unit(1e-2, _LENGTH)),
    **dict.fromkeys(("millimetre", "millimeter"), Unit(1e-3, _LENGTH)),
    "foot": Unit(_FOOT, _LENGTH), "inch": Unit(_FOOT / 12, _LENGTH), "yard": Unit(3 * _FOOT, _LENGTH),
    "mile": Unit(_MILE, _LENGTH), "nautical_mile": Unit(1852, _LENGTH),
    **dict.fromkeys(("sec", "second"), Unit(1, _TIME)), "minute": Unit(60, _TIME), "hour": Unit(3600, _TIME),
    "day": Unit(86400, _TIME), "millisecond": Unit(1e-3, _TIME), "knot": Unit(1852 / 3600, _SPEED),
    "gram": Unit(1e-3, _MASS), "kilogram": Unit(1, _MASS), "tonne": Unit(1e3, _MASS), "pound": Unit(_POUND, _MASS),
    "newton": Unit(1, _FORCE), "kilonewton": Unit(1e3, _FORCE), "pascal": Unit(1, _PRESSURE),
    "joule": Unit(1, _MOMENT), "watt": Unit(1, _POWER), "kilowatt": Unit(1e3, _POWER), "hertz": Unit(1, _RATE),
    "volt": SYMBOLS["V"], "ampere": SYMBOLS["A"], "kelvin": SYMBOLS["K"], "radian": Unit(1),
    "degree": Unit(math.pi / 180), "arcminute": Unit(math.pi / 10800), "arcsecond": Unit(math.pi / 648000),
    "revolution": Unit(2 * math.pi), "turn": Unit(2 * math.pi),
}  # fmt: skip
"""Units that take a plural s."""


@cache
def unit_named(text: str) -> Unit | None:
    """Return a unit from its spelling in headers, ``m/s2``, ``kN m`` or ``deg/s^2``; None if it is unknown.

    The units here are those of ships and of model basins. pint adds the others if it is installed.
    """
    return _product(text) or _by_pint(text)


def _product(text: str) -> Unit | None:
    products = re.sub(r"(?<=[A-Za-z])-(?=[A-Za-z])", "*", text.strip())
    signs = products.replace("**", "^").translate({ord("²"): "^2", ord("³"): "^3", ord("·"): "*", ord("・"): "*"})
    parts = re.split(r"\s*([*/])\s*|\s+", signs)
    scale, powers = 1.0, (0, 0, 0, 0, 0)
    for sign, part in zip(["*", *parts[1::2]], parts[::2], strict=True):
        if (factor := _factor(part)) is None:
            return None
        way = -1 if sign == "/" else 1
        scale *= factor.scale**way
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


def _single(word: str) -> Unit | None:
    if known := SYMBOLS.get(word) or ABBREVIATIONS.get(word) or WORDS.get(word) or WORDS.get(word.removesuffix("s")):
        return known
    symbol, prefix = SYMBOLS.get(word[1:]), PREFIXES.get(word[:1])
    return Unit(prefix * symbol.scale, symbol.powers) if symbol and prefix else None


def _by_pint(text: str) -> Unit | None:
    try:
        one = _registry()(re.sub(r"([a-z])(\d)", r"\1^\2", text).replace("°", "deg")).to_base_units()
        powers = dict(one.dimensionality)
        base = [powers.pop(f"[{name}]", 0) for name in ("length", "mass", "time", "current", "temperature")]
    except Exception:  # It is absent, or raises one of many errors on other words
        return None
    return None if powers else Unit(float(one.magnitude), tuple(base))


@cache
def _registry():  # type: ignore[no-untyped-def]
    import pint

    return pint.UnitRegistry()
