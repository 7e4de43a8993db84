"""How a table of text is written: its encoding, what parts cells and decimals, where header and rows begin."""

import codecs
import csv
import re
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

from narrows.errors import InputError, shown
from narrows.readers.table_head import Head, head_of, is_number, width_of

# Bytes that are looked at.
SAMPLE = 1 << 18
ROWS = 400
# What may part cells; blanks are any white space.
SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", "|": "bars", " ": "blanks"}
# With which a comment begins.
REMARKS = ("#", "%")
MARKS = {
    codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16",
}  # fmt: skip
LINE = re.compile(r"\r\n|\n|\r")


class Dialect(NamedTuple):
    """How a file is written."""

    encoding: str  # Of its text
    separator: str  # Of cells; a blank stands for any white space
    decimal: str  # Point or comma
    head: Head  # Header and first row


class Split(NamedTuple):
    """Lines parted at a separator."""

    separator: str  # Of cells
    rows: list[list[str]]  # The cells
    decimal: str  # Point or comma, whichever makes more cells numbers
    score: float  # Share of the later cells that are numbers in rows of one width [1]


def dialect_of(path: Path) -> Dialect:
    """Find how a table of text is written."""
    encoding, numbered = _sample(path)
    lines = [(number, line) for number, line in numbered if not line.lstrip().startswith(REMARKS)][:ROWS]
    if not lines:
        raise InputError("the table is empty; give a header and rows")
    split = _best([line for _, line in lines])
    numbers = [number for number, _ in lines]
    if split.decimal == ",":
        _check_decimals(split.rows, numbers)
    head = head_of(split.rows, numbers, split.decimal, _remark(numbered, split))
    return Dialect(encoding, split.separator, split.decimal, head)


def _sample(path: Path) -> tuple[str, list[tuple[int, str]]]:
    """The encoding of a file, and its first lines with their numbers, empty ones left out."""
    with path.open("rb") as file:
        raw = file.read(SAMPLE)
    encoding = _encoding(raw)
    lines = LINE.split(raw.decode(encoding, errors="replace"))
    whole = lines[:-1] if len(raw) == SAMPLE and len(lines) > 1 else lines
    if any("\0" in line for line in whole):
        kind = "a ZIP archive, as workbooks are (name it .xlsx)" if raw.startswith(b"PK") else "no text in UTF-8"
        raise InputError(f"it holds bytes that are no characters: it is {kind}; export it as text")
    return encoding, [(number, line) for number, line in enumerate(whole, 1) if line.strip()]


def _encoding(raw: bytes) -> str:
    """By its mark, else UTF-8 where it is that, else the Latin of measuring computers."""
    for mark, encoding in MARKS.items():
        if raw.startswith(mark):
            return encoding
    try:
        codecs.getincrementaldecoder("utf-8")().decode(raw, final=len(raw) < SAMPLE)
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def _best(lines: list[str]) -> Split:
    """Part the lines at what makes most cells numbers; where there are none, at what makes most cells."""
    splits = [_split(lines, separator) for separator in SEPARATORS]
    best = max(splits, key=lambda split: (round(split.score, 3), split.separator != " ", width_of(split.rows)))
    if width_of(best.rows) < 2:
        raise InputError(
            f"no column is headed as a quantity, and no semicolon, tab, comma or bar parts the cells: line 1 reads "
            f"{shown(lines[0])}; part them by one of these"
        )
    return best


def _split(lines: list[str], separator: str) -> Split:
    rows = list(cells_of(lines, separator))
    width, later = width_of(rows), rows[len(rows) // 2 :]
    if width < 2:
        return Split(separator, rows, ".", 0.0)
    counts = {
        decimal: sum(is_number(cell, decimal) for row in later if len(row) == width for cell in row)
        for decimal in (".", ",")
    }
    # Whole numbers read either way; a point is usual.
    decimal = "," if counts[","] > counts["."] else "."
    return Split(separator, rows, decimal, counts[decimal] / (width * len(later)))


def _check_decimals(rows: list[list[str]], lines: list[int]) -> None:
    """Raise where one column writes its decimals with commas here and with points there."""
    for column in zip_longest(*rows, fillvalue=""):
        commas, points = (
            [i for i, cell in enumerate(column) if mark in cell and is_number(cell, mark)] for mark in (",", ".")
        )
        if commas and points:
            raise InputError(
                f"line {lines[commas[0]]} holds {shown(column[commas[0]])} and line {lines[points[0]]} "
                f"{shown(column[points[0]])} in one column; write all decimals with commas, or all with points"
            )


def cells_of(lines: Sequence[str], separator: str) -> Iterator[list[str]]:
    """Part lines into cells."""
    if separator == " ":
        return (line.split() for line in lines)
    return (next(csv.reader([line], delimiter=separator, skipinitialspace=True)) for line in lines)


def _remark(numbered: list[tuple[int, str]], split: Split) -> list[str]:
    """Cells of the last comment above the first line that is none, as NumPy writes headers."""
    above: list[str] = []
    for _, line in numbered:
        if not line.lstrip().startswith(REMARKS):
            break
        above = [line.lstrip().lstrip("".join(REMARKS)).strip()]
    return next(iter(cells_of(above, split.separator)), []) if above else []
