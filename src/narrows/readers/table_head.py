"""Which row of a table is its header, which its units, and where its numbers begin."""

import re
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from narrows.errors import InputError, shown
from narrows.readers.headers import is_unit

NUMBER = re.compile(r"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|nan|inf(?:inity)?)", re.IGNORECASE)
# Of its cells that a row has at least, where it is no line of text above the table.
MOST = 0.5
# Of the cells under a header that read as units, where they are its units.
UNITS = 0.6
NO_UNIT = ("-", "--", "n/a", "none")

Row = Sequence[str]


class Head(NamedTuple):
    """The top of a table."""

    headers: tuple[str, ...]  # One for each column, with the unit where a row of units stands under them
    first: int  # The line, or row of a sheet, with which the data begin, counted from 1
    notes: tuple[str, ...]  # What there is to say of it


def is_number(cell: str, decimal: str = ".") -> bool:
    """Say whether a cell reads as a number."""
    if decimal == ",":
        cell = "" if "." in cell else cell.replace(",", ".")
    return NUMBER.fullmatch(cell.strip()) is not None


def width_of(rows: Sequence[Row]) -> int:
    """Return how many cells most of the later rows have."""
    return Counter(len(row) for row in rows[len(rows) // 2 :]).most_common(1)[0][0]


def head_of(rows: Sequence[Row], lines: Sequence[int], decimal: str = ".", remark: Row = ()) -> Head:
    """Find header, units and first row of a table."""
    width = width_of(rows)
    full = MOST * sorted(map(_filled, rows[len(rows) // 2 :]))[len(rows[len(rows) // 2 :]) // 2]
    texts = [not any(is_number(cell, decimal) for cell in row) and _filled(row) >= full for row in rows]
    is_data = [not text and _filled(row) >= full and len(row) >= width for row, text in zip(rows, texts, strict=True)]
    first = is_data.index(True) if True in is_data else len(rows)
    named = [i for i in range(first) if texts[i] and len(_trimmed(rows[i], width)) == width]
    while len(named) > 1 and named[-1] - named[0] >= len(named):
        named.pop(0)  # Only rows that stand together, directly above the numbers.
    if not named or named[-1] != first - 1:
        return _without_header(rows, lines, texts, first, width, remark)
    top = named[0]
    units = rows[top + 1] if len(named) > 1 and _are_units(rows[top + 1]) else ()
    begin = top + 1 + bool(units)
    above = (f"{lines[top] - 1} lines above the header were passed over",) if top else ()
    headers = _headers(_trimmed(rows[top], width), _trimmed(units, width))
    return Head(headers, lines[begin] if begin < len(rows) else lines[-1] + 1, above)


def _without_header(
    rows: Sequence[Row], lines: Sequence[int], texts: Sequence[bool], first: int, width: int, remark: Row
) -> Head:
    """Take the comment above the rows for header, or number them, unless a header of another length is there."""
    if first == len(rows):  # There are no numbers at all.
        return Head(_headers(rows[0], ()), lines[0] + 1, ())
    if len(remark) == width:
        return Head(_headers(remark, ()), lines[first], ())
    if first and texts[first - 1] and len(rows[first - 1]) >= MOST * width:
        fault = "more" if width > len(rows[first - 1]) else "fewer"
        raise InputError(
            f"row {lines[first]} has {fault} cells than the header, {width} where {lines[first - 1]} has "
            f"{len(rows[first - 1])}; give each column one header, and commas to either cells or decimals"
        )
    numbered = tuple(f"column {i}" for i in range(1, width + 1))
    return Head(
        numbered, lines[first], ("no line heads the columns: they are called 'column 1', 'column 2' and so on",)
    )


def _filled(row: Row) -> int:
    return sum(bool(cell.strip()) for cell in row)


def _trimmed(row: Row, width: int) -> Row:
    """A row without the empty cells at its end that no column has."""
    return row[:width] if not any(cell.strip() for cell in row[width:]) else row


def _are_units(row: Row) -> bool:
    words = [_bare(cell) for cell in row if cell.strip()]
    known = sum(word.lower() in NO_UNIT or is_unit(word) for word in words)
    return bool(words) and known >= UNITS * len(words)


def _bare(cell: str) -> str:
    """A unit without its brackets."""
    return cell.strip().strip("[]()").strip()


def _headers(names: Row, units: Row) -> tuple[str, ...]:
    """Names with their units, each once; a second of one name is told apart as pandas does."""
    known: Counter[str] = Counter()
    headers = []
    for i, name in enumerate(names):
        unit = _bare(units[i]) if i < len(units) else ""
        name = name.strip() or f"column {i + 1}"
        header = f"{name} [{unit}]" if unit and unit.lower() not in NO_UNIT and name[-1] not in "])" else name
        headers.append(f"{header}.{known[header]}" if known[header] else header)
        known[header] += 1
    return tuple(headers)


def seen(row: Row) -> str:
    """Return the first cells of a row, for a sentence."""
    return ", ".join(shown(cell.strip()) for cell in row[:5]) + (", ..." if len(row) > 5 else "")
