"""Headers: the quantity of a column, its unit, and the factor to SI."""

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

from narrows.base.errors import InputError
from narrows.quantities.dimensions import unit_named
from narrows.quantities.names import Quantity

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


def split_header(header: str) -> tuple[str, str]:
    """Return the words of any header, and its unit, if any: of ``psi [deg]``, ``psi (deg)`` or ``psi_deg``."""
    header = header.strip()
    if match := re.fullmatch(r"(.*?)\s*(?:\[([^\]]*)\]|\(([^)]*)\))", header, re.DOTALL):
        return match[1], (match[2] or match[3] or "").strip()
    name, _, suffix = header.rpartition("_")
    return (name, suffix) if name and suffix in SUFFIXES else (header, "")


def parse_header(header: str, known: Mapping[str, Quantity]) -> Column | None:
    name, unit = (header.strip(), "") if header.strip() in known else split_header(header)
    if name not in known:
        return None
    si = known[name].unit
    if unit in ("", si):
        return Column(header, name, 1.0, bool(unit))
    given, wanted = unit_named(unit), unit_named(si)
    if given is None or wanted is None:
        raise InputError(f"column {header!r}: unknown unit [{unit}]; give it in [{si}]")
    if given.powers != wanted.powers:
        raise InputError(f"column {header!r}: {unit} is not a unit of this quantity; give it in {si}")
    return Column(header, name, given.scale / wanted.scale, True)


def quantity_of(header: str, vocabulary: Vocabulary) -> str:
    """Return the quantity or label of a header, in whatever unit; empty if it is none."""
    words = (header.strip(), split_header(header)[0])
    return next((name for name in words if name in vocabulary.quantities or name in vocabulary.labels), "")


def recognised_in(frame: "pd.DataFrame", known: Mapping[str, Quantity], table: str) -> list[Column]:
    try:
        return [column for header in frame.columns if (column := parse_header(str(header), known))]
    except InputError as error:
        raise InputError(f"{table}: {error}") from None
