"""Headers: which column is which quantity, in which unit, and what one of it is in SI."""

import math
import re
from collections.abc import Mapping
from importlib.util import find_spec
from typing import TYPE_CHECKING, NamedTuple

from narrows.errors import InputError, installing, libraries_of
from narrows.quantities.names import Quantity
from narrows.readers.units import unit_named

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
    """Say whether a word, without brackets, is a unit of anything."""
    named = any(character.isalpha() or character == "°" for character in word)
    return named and (word in TEMPERATURES or unit_named(word) is not None)


# Units that tables have and that no factor brings to SI.
TEMPERATURES = ("°C", "degC", "°F", "degF")
