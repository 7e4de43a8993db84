"""Headers: which column is which quantity, in which unit, and what one of it is in SI."""

import math
import re
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from narrows.errors import InputError
from narrows.quantities.names import KNOT, Quantity

if TYPE_CHECKING:
    import pandas as pd

DEGREE = math.pi / 180
# How headers spell units, where that is not how the units library does.
SPELLINGS = {
    "1": "dimensionless", "°": "deg", "Nm": "N*m", "N m": "N*m", "kNm": "kN*m", "Nmm": "N*mm", "kn": "knot",
    # A revolution is one turn here, and not 2 pi of anything.
    "rpm": "1/minute", "rps": "1/s",
    "mps": "m/s", "mps2": "m/s^2", "degps": "deg/s", "degps2": "deg/s^2", "radps": "rad/s", "radps2": "rad/s^2",
}  # fmt: skip
# How many of an SI unit one of another is, for those that most tables have: the units library takes long to load.
USUAL = {
    "m": {"mm": 1e-3, "cm": 1e-2}, "m/s": {"mm/s": 1e-3, "mps": 1.0, "kn": KNOT, "knot": KNOT},
    "m/s2": {"mps2": 1.0, "mm/s2": 1e-3, "m/s^2": 1.0},
    "rad": {"deg": DEGREE, "°": DEGREE}, "rad/s": {"radps": 1.0, "deg/s": DEGREE, "degps": DEGREE, "°/s": DEGREE},
    "rad/s2": {"radps2": 1.0, "deg/s2": DEGREE, "degps2": DEGREE, "rad/s^2": 1.0, "deg/s^2": DEGREE},
    "N": {"kN": 1e3}, "N m": {"Nm": 1.0, "kNm": 1e3, "N*m": 1.0, "Nmm": 1e-3}, "1/s": {"rpm": 1 / 60, "rps": 1.0},
}  # fmt: skip
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
    blanks: bool = False  # Whether a cell of numbers may be empty


class Column(NamedTuple):
    header: str  # As in the table
    quantity: str  # Of the vocabulary
    scale: float  # How many SI units one of it is [1]
    stated: bool  # Whether the header carries a unit


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
    """Return the unit that any header carries, be it of a quantity or not; empty where it carries none."""
    if match := re.search(r"(?:\[([^\]]*)\]|\(([^)]*)\))\s*$", header):
        return (match[1] or match[2] or "").strip()
    name, _, suffix = header.strip().rpartition("_")
    return suffix if name and suffix in SUFFIXES else ""


def _split(header: str, known: Mapping[str, Quantity]) -> tuple[str, str | None]:
    if match := re.fullmatch(r"(\w+)\s*(?:\[(.*)\]|\((.*)\))", header):
        return match[1], (match[2] or match[3] or "").strip()
    name, _, suffix = header.rpartition("_")
    return (name, suffix) if name in known and suffix in SUFFIXES else (header, None)


@cache
def _scale(header: str, unit: str, si: str) -> float:
    if unit == si or unit in USUAL.get(si, ()):
        return USUAL.get(si, {}).get(unit, 1.0)

    import pint

    registry = _registry()
    try:
        parsed, target = (registry(SPELLINGS.get(word, _powers(word))) for word in (unit, si))
        return float((1 * parsed).to(target.units).magnitude)
    except pint.DimensionalityError:
        raise InputError(f"column {header!r}: {unit} is not a unit of this quantity; give it in {si}") from None
    except Exception:  # The units library raises nearly anything on what is no unit.
        raise InputError(f"column {header!r}: unknown unit [{unit}]; give it in [{si}]") from None


def _powers(unit: str) -> str:
    """Spell ``m/s2`` as ``m/s^2``."""
    return re.sub(r"([a-z])(\d)", r"\1^\2", unit).replace("°", "deg")


@cache
def is_unit(word: str) -> bool:
    try:
        _registry()(SPELLINGS.get(word, _powers(word)))
    except Exception:  # The units library raises nearly anything on what is no unit.
        return False
    return any(character.isalpha() or character == "°" for character in word)


@cache
def _registry():  # type: ignore[no-untyped-def]
    import pint

    return pint.UnitRegistry()
