"""Tables of text, whole or in chunks, in the detected dialect."""

import codecs
import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from io import BytesIO
from itertools import compress, islice, takewhile, zip_longest
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
import pandas as pd

from narrows.base.errors import InputError, shown
from narrows.base.progress import opened
from narrows.quantities.names import is_unit
from narrows.readers.settings import DIALECT_BYTES, DIALECT_ROWS, FULL_SHARE, HEADER_LINES, UNIT_SHARE

FIRST_ROW = 2  # Row number below a header in an editor: the index of a frame counts from there
SKIPPED = rb"[ \t]*[#%\r\n]"  # Begin of a comment, or an empty line
MORE_CELLS = "row {} has more cells than the header; give each column one header, and put words with spaces in quotes"
OPEN_QUOTE = "row {} opens a quote that no row closes; close it, or leave it out"


class Head(NamedTuple):
    headers: tuple[str, ...]  # One per column, with the unit if a row of units follows
    first: int  # Line, or row of a sheet, where the data begin, counted from 1
    notes: tuple[str, ...]  # Notes on it


class Dialect(NamedTuple):
    encoding: str  # Encoding of the text
    separator: str  # Cell separator; a blank stands for any white space
    decimal: str  # Decimal point or comma
    head: Head  # Header and first row


def text_chunks(path: Path, dialect: Dialect, rows: int | None) -> Iterator[pd.DataFrame]:
    """Yield a table by so many lines, or as one, without comments and empty lines."""
    first, encoding = dialect.head.first, dialect.encoding
    # An encoding error far down must not end in a traceback, nor give two columns one name.
    options: dict[str, Any] = {
        "sep": r"\s+" if dialect.separator == " " else dialect.separator, "decimal": dialect.decimal,
        "encoding_errors": "backslashreplace", "header": None, "names": list(dialect.head.headers),
        "skipinitialspace": True, "low_memory": False,
    }  # fmt: skip
    with opened(path) as file:
        is_plain = encoding != "utf-16" and b"\n" in file.readline(DIALECT_BYTES)
        file.seek(0)
        if not is_plain:  # Also lines that end with a carriage return alone
            whole = file.read().decode(encoding, "backslashreplace")
            file, encoding = BytesIO(LINE.sub("\n", whole).encode()), "utf-8"
        for _ in range(first - 1):
            file.readline()
        while text := _block(file, rows):
            numbers = np.arange(first, first + text.count(b"\n") + (not text.endswith(b"\n")))
            first += len(numbers)
            if re.match(SKIPPED, text) or re.search(b"\n" + SKIPPED, text):
                lines = text.split(b"\n")[: len(numbers)]
                kept = [not re.match(SKIPPED, line + b"\n") for line in lines]
                numbers, text = numbers[kept], b"\n".join(compress(lines, kept))
            if not text:
                continue
            try:
                frame = pd.read_csv(BytesIO(text), encoding=encoding, **options)
            except pd.errors.ParserError as error:
                more = re.search(r"fields in line (\d+)", str(error))  # Counted within this text
                if more and int(more[1]) <= len(numbers):
                    raise InputError(MORE_CELLS.format(numbers[int(more[1]) - 1])) from None
                if "EOF inside string" in str(error):  # It begins at the last quote
                    raise InputError(OPEN_QUOTE.format(numbers[text[: text.rindex(b'"')].count(b"\n")])) from None
                raise
            yield _finished(frame, dialect, numbers)


def _block(file: IO[bytes], rows: int | None) -> bytes:
    """Return so many lines or all, and further ones if a cell in quotes goes on there."""
    text, more = file.read() if rows is None else b"".join(islice(file, rows)), list[bytes]()
    if text.count(b'"') % 2:
        for line in islice(file, rows):
            more.append(line)
            if line.count(b'"') % 2:
                break
    return b"".join([text, *more])


def _finished(frame: pd.DataFrame, dialect: Dialect, lines: np.ndarray) -> pd.DataFrame:
    """Number the rows by lines, and convert decimal commas in columns that also hold words, which pandas leaves."""
    if not isinstance(frame.index, pd.RangeIndex):  # pandas takes extra cells for row names
        raise InputError(MORE_CELLS.format(lines[0]))
    # If a cell in quotes spans lines, rows are counted from the first line.
    frame.index = pd.Index((lines if len(frame) == len(lines) else lines[0] + np.arange(len(frame))) - FIRST_ROW)
    for header in frame.columns if dialect.decimal == "," else ():
        if not pd.api.types.is_numeric_dtype(frame[header]):
            cells = frame[header].astype(object)
            words = cells.astype(str)
            numbers = pd.to_numeric(words.str.replace(",", "."), errors="coerce")
            frame[header] = cells.where(numbers.isna() | words.str.contains(".", regex=False), numbers)
    return frame


NUMBER = re.compile(r"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|nan|inf(?:inity)?)", re.IGNORECASE)
NO_UNIT = ("-", "--", "n/a", "none")
Row = Sequence[str]


def is_number(cell: str, decimal: str = ".") -> bool:
    if decimal == ",":
        cell = "" if "." in cell else cell.replace(",", ".")
    return NUMBER.fullmatch(cell.strip()) is not None


def width_of(rows: Sequence[Row]) -> int:
    """Return the number of cells in most of the later rows."""
    return Counter(len(row) for row in rows[len(rows) // 2 :]).most_common(1)[0][0]


def head_of(rows: Sequence[Row], lines: Sequence[int], decimal: str = ".", remark: Row = ()) -> Head:
    width = width_of(rows)
    full = FULL_SHARE * sorted(map(_filled, rows[len(rows) // 2 :]))[len(rows[len(rows) // 2 :]) // 2]
    texts = [not any(is_number(cell, decimal) for cell in row) and _filled(row) >= full for row in rows]
    is_data = [not text and _filled(row) >= full and len(row) >= width for row, text in zip(rows, texts, strict=True)]
    first = is_data.index(True) if True in is_data else len(rows)
    named = [i for i in range(first) if texts[i] and len(_trimmed(rows[i], width)) == width]
    while len(named) > 1 and named[-1] - named[0] >= len(named):
        named.pop(0)  # Only adjacent rows directly above the numbers
    if not named or named[-1] != first - 1:
        return _without_header(rows, lines, texts, first, width, remark)
    under = len(named) > 1 and _are_units(rows[named[-1]])
    top = named[-2] if under else named[0]  # Of names over symbols over units, the symbols
    units = rows[top + 1] if under else ()
    begin = top + 1 + bool(units)
    above = (f"{lines[top] - 1} lines above the header were passed over",) if top else ()
    headers = _headers(_trimmed(rows[top], width), _trimmed(units, width))
    return Head(headers, lines[begin] if begin < len(rows) else lines[-1] + 1, above)


def _without_header(
    rows: Sequence[Row], lines: Sequence[int], texts: Sequence[bool], first: int, width: int, remark: Row
) -> Head:
    """Use the comment above the rows as header, or number the columns, unless a header of another length exists."""
    if first == len(rows):  # There are no numbers at all
        return Head(_headers(rows[0], ()), lines[0] + 1, ())
    if len(remark) == width:
        return Head(_headers(remark, ()), lines[first], ())
    if first and texts[first - 1] and len(rows[first - 1]) >= FULL_SHARE * width:
        fault = "more" if width > len(rows[first - 1]) else "fewer"
        raise InputError(
            f"row {lines[first]} has {fault} cells than the header, {width} where {lines[first - 1]} has "
            f"{len(rows[first - 1])}; give each column one header, and commas to either cells or decimals"
        )
    note = "no line heads the columns: they are called 'column 1', 'column 2' and so on"
    return Head(_headers([""] * width, ()), lines[first], (note,))


def _filled(row: Row) -> int:
    return sum(bool(cell.strip()) for cell in row)


def _trimmed(row: Row, width: int) -> Row:
    """Return a row without trailing empty cells that no column has."""
    return row[:width] if not any(cell.strip() for cell in row[width:]) else row


def _are_units(row: Row) -> bool:
    words = [_bare(cell) for cell in row if cell.strip()]
    known = sum(word.lower() in NO_UNIT or is_unit(word) for word in words)
    return bool(words) and known >= UNIT_SHARE * len(words)


def _bare(cell: str) -> str:
    return cell.strip().strip("[]()").strip()


def _headers(names: Row, units: Row) -> tuple[str, ...]:
    """Names with their units; duplicates are numbered as in pandas."""
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
    return ", ".join(shown(cell.strip()) for cell in row[:5]) + (", ..." if len(row) > 5 else "")


# Cell separators; blanks are any white space.
SEPARATORS = (";", "\t", ",", "|", " ")
# First characters of a comment.
REMARKS = ("#", "%")

MARKS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}

LINE = re.compile(r"\r\n|\n|\r")


class Split(NamedTuple):
    separator: str  # Cell separator
    rows: list[list[str]]  # The cells
    decimal: str  # Decimal point or comma, whichever makes more cells numbers
    score: float  # Share of numeric cells among the later rows of one width [1]


def dialect_of(path: Path) -> Dialect:
    encoding, numbered = _sample(path)
    lines = [(number, line) for number, line in numbered if not line.lstrip().startswith(REMARKS)][:DIALECT_ROWS]
    if not lines:
        raise InputError("the table is empty; give a header and rows")
    numbers, texts = zip(*_joined(lines), strict=True)
    # The separator that gives most numbers; without numbers, the one that gives most cells.
    splits = [_split(texts, separator) for separator in SEPARATORS]
    split = max(splits, key=lambda split: (round(split.score, 3), split.separator != " ", width_of(split.rows)))
    if width_of(split.rows) < 2:
        raise InputError(
            f"no column is headed as a quantity, and no semicolon, tab, comma or bar parts the cells: line 1 reads "
            f"{shown(texts[0])}; part them by one of these"
        )
    if split.decimal == ",":
        _check_decimals(split.rows, numbers)
    # NumPy writes headers as comments: the last one above the first other line.
    above = takewhile(lambda line: line.startswith(REMARKS), (line.strip() for _, line in numbered))
    remarks = [line.lstrip("".join(REMARKS)).strip() for line in above]
    head = head_of(split.rows, numbers, split.decimal, next(cells_of(remarks[-1:], split.separator), []))
    return Dialect(encoding, split.separator, split.decimal, head)


def _joined(lines: list[tuple[int, str]]) -> list[tuple[int, str]]:
    """Lines whose first is whole: a header in quotes may go on in the next ones."""
    for stop in range(1, min(len(lines), HEADER_LINES) + 1):
        first = " ".join(line for _, line in lines[:stop])
        if first.count('"') % 2 == 0:
            return [(lines[0][0], first), *lines[stop:]]
    return lines


def _sample(path: Path) -> tuple[str, list[tuple[int, str]]]:
    with path.open("rb") as file:
        raw = file.read(DIALECT_BYTES)
    encoding = _encoding(raw)
    lines = LINE.split(raw.decode(encoding, errors="replace"))
    whole = lines[:-1] if len(raw) == DIALECT_BYTES and len(lines) > 1 else lines
    if any("\0" in line for line in whole):
        kind = "a ZIP archive, as workbooks are (name it .xlsx)" if raw.startswith(b"PK") else "no text in UTF-8"
        raise InputError(f"it holds bytes that are no characters: it is {kind}; export it as text")
    return encoding, [(number, line) for number, line in enumerate(whole, 1) if line.strip()]


def _encoding(raw: bytes) -> str:
    """Encoding by its byte-order mark, else the first of UTF-8, Chinese, Japanese and Latin that is valid."""
    for mark, encoding in MARKS.items():
        if raw.startswith(mark):
            return encoding
    for encoding in ("utf-8", "gb2312", "cp932"):  # Bytes above 127 come in pairs in Chinese, mostly alone in Latin.
        with suppress(UnicodeDecodeError):
            text = codecs.getincrementaldecoder(encoding)().decode(raw, final=len(raw) < DIALECT_BYTES)
            if encoding != "cp932" or not re.search(r"(?<![^\0-\x7f])[^\0-\x7f](?![^\0-\x7f])", text):
                return encoding
    return "latin-1"


def _split(lines: Sequence[str], separator: str) -> Split:
    rows = list(cells_of(lines, separator))
    width, later = width_of(rows), rows[len(rows) // 2 :]
    counts = {
        decimal: sum(is_number(cell, decimal) for row in later if len(row) == width for cell in row)
        for decimal in (".", ",")
    }
    # Whole numbers allow either; a point is usual.
    decimal = "," if counts[","] > counts["."] else "."
    return Split(separator, rows, decimal, counts[decimal] / (width * len(later)) if width > 1 else 0.0)


def _check_decimals(rows: list[list[str]], lines: Sequence[int]) -> None:
    """Raise if one column has both decimal commas and decimal points."""
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
    if separator == " ":
        return (line.split() for line in lines)
    return (next(csv.reader([line], delimiter=separator, skipinitialspace=True)) for line in lines)
