"""Tables of text, whole or in chunks, by the dialect that was found."""

import re
from collections.abc import Iterator
from io import StringIO
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from narrows.errors import InputError
from narrows.progress import opened
from narrows.readers.dialect import REMARKS, Dialect

# What editors call the row under a header: the index of a frame counts from there.
FIRST_ROW = 2
# Bytes that are looked at together.
BLOCK = 1 << 22
# Before a line that is a comment or empty.
BROKEN = re.compile(rb"\n[ \t]*[#%\r\n]")


def read_text(path: Path, dialect: Dialect) -> pd.DataFrame:
    """Read a whole table; its index counts the lines of the file."""
    if not _is_broken(path, dialect):
        with opened(path) as file:
            frame: pd.DataFrame = pd.read_csv(file, skiprows=dialect.head.first - 1, **_options(dialect))
        return _counted(_with_commas(frame, dialect), dialect.head.first - FIRST_ROW)
    return next(_from_lines(path, dialect, None), _nothing(dialect))


def text_chunks(path: Path, dialect: Dialect, rows: int) -> Iterator[pd.DataFrame]:
    """Read a table chunk by chunk."""
    if _is_broken(path, dialect):
        yield from _from_lines(path, dialect, rows)
        return
    first = dialect.head.first - FIRST_ROW
    with (
        opened(path) as file,
        pd.read_csv(file, skiprows=dialect.head.first - 1, chunksize=rows, **_options(dialect)) as chunks,
    ):
        for frame in chunks:
            yield _counted(_with_commas(frame, dialect), first)
            first += len(frame)


def _options(dialect: Dialect) -> dict[str, Any]:
    separator = r"\s+" if dialect.separator == " " else dialect.separator
    # An encoding that is wrong far down must not end in a traceback, nor make two names one.
    return {
        "sep": separator, "decimal": dialect.decimal, "encoding": dialect.encoding,
        "encoding_errors": "backslashreplace", "header": None, "names": list(dialect.head.headers),
        "skipinitialspace": True, "low_memory": False,
    }  # fmt: skip


def _nothing(dialect: Dialect) -> pd.DataFrame:
    return pd.DataFrame(columns=list(dialect.head.headers), index=pd.RangeIndex(0))


def _counted(frame: pd.DataFrame, first: int) -> pd.DataFrame:
    """Rows by their lines; pandas takes a surplus of cells for names of rows."""
    if not isinstance(frame.index, pd.RangeIndex):
        raise InputError(f"row {first + FIRST_ROW} has more cells than the header; give each column one header")
    frame.index = pd.RangeIndex(first, first + len(frame))
    return frame


def _with_commas(frame: pd.DataFrame, dialect: Dialect) -> pd.DataFrame:
    """Make numbers of cells with a comma in columns that hold a word too, which pandas leaves as they are."""
    if dialect.decimal == ",":
        for header in frame.columns:
            if not pd.api.types.is_numeric_dtype(frame[header]):
                cells = frame[header].astype(object)
                words = cells.astype(str)
                numbers = pd.to_numeric(words.str.replace(",", "."), errors="coerce")
                frame[header] = cells.where(numbers.isna() | words.str.contains(".", regex=False), numbers)
    return frame


def _is_broken(path: Path, dialect: Dialect) -> bool:
    """Whether comments or empty lines may stand among the rows, so that lines must be looked at one by one."""
    if dialect.encoding == "utf-16":
        return True
    with path.open("rb") as file:
        for _ in range(dialect.head.first - 2):
            file.readline()
        line = b""
        while block := file.read(BLOCK):
            text = line + block
            if BROKEN.search(text):
                return True
            line = text[text.rfind(b"\n") :] if b"\n" in text else b""
    return False


def _from_lines(path: Path, dialect: Dialect, rows: int | None) -> Iterator[pd.DataFrame]:
    """Frames of so many lines that are neither empty nor comments, or of all."""
    with path.open(encoding=dialect.encoding, errors="backslashreplace") as file:
        told = (
            (number, line) for number, line in enumerate(file, 1)
            if number >= dialect.head.first and line.strip() and not line.lstrip().startswith(REMARKS)
        )  # fmt: skip
        while lines := list(islice(told, rows)):
            options = _options(dialect) | {"encoding": None}
            frame = _counted(
                _with_commas(pd.read_csv(StringIO("".join(line for _, line in lines)), **options), dialect), 0
            )
            if len(frame) == len(lines):  # Else a cell in quotes holds lines.
                frame.index = pd.Index(np.array([number for number, _ in lines]) - FIRST_ROW)
            yield frame
