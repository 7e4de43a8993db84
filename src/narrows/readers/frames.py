"""Files to data frames: text, Parquet and Excel, whole or in chunks."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from narrows.base.errors import InputError, needs
from narrows.base.files import reading
from narrows.base.progress import stage
from narrows.readers.settings import SHEET_ROWS
from narrows.readers.text_table import FIRST_ROW, dialect_of, head_of, text_chunks

TEXT = (".csv", ".txt", ".tsv", ".dat", ".asc")
READABLE = (*TEXT, ".parquet", ".xlsx")
STREAMED = (*TEXT, ".parquet")


class Sheet(NamedTuple):
    frame: pd.DataFrame  # Its index is the row number in the file, less ``FIRST_ROW``
    notes: tuple[str, ...] = ()  # Notes on the file


def read_frame(path: Path) -> Sheet:
    readers: dict[str, Callable[[Path], Sheet]] = {
        # A column that pandas saved as its index becomes an ordinary column.
        ".parquet": lambda path: Sheet(_parquet().read_table(path).to_pandas(ignore_metadata=True)),
        ".xlsx": _read_excel,
    }
    reader = readers.get(_suffix(path, READABLE))
    with nullcontext() if reader is None else stage(f"reading {path.name}"), guarding(path):
        if reader:
            return reader(path)
        dialect = dialect_of(path)
        nothing = pd.DataFrame(columns=list(dialect.head.headers), index=pd.RangeIndex(0))
        return Sheet(next(text_chunks(path, dialect, None), nothing), dialect.head.notes)  # With counted bytes


def read_chunks(path: Path, rows: int) -> Iterator[pd.DataFrame]:
    is_parquet = _suffix(path, STREAMED) == ".parquet"
    with guarding(path):
        chunks = _parquet_chunks(path, rows) if is_parquet else text_chunks(path, dialect_of(path), rows)
    while True:
        with guarding(path):
            chunk = next(chunks, None)
        if chunk is None:
            return
        yield chunk


def notes_of(path: Path) -> tuple[str, ...]:
    if _suffix(path, STREAMED) == ".parquet":
        return ()
    with guarding(path):
        return dialect_of(path).head.notes


def guarding(path: Path) -> AbstractContextManager[None]:
    return reading(path, f"a readable {path.suffix[1:]} table")


def _parquet_chunks(path: Path, rows: int) -> Iterator[pd.DataFrame]:
    first = 0
    # Without pre_buffer=False, buffers remain until the file is closed: memory would grow with it.
    with _parquet().ParquetFile(path, pre_buffer=False) as file:
        for batch in file.iter_batches(batch_size=rows):
            frame = batch.to_pandas(ignore_metadata=True)
            frame.index = range(first, first + len(frame))
            first += len(frame)
            yield frame


def _suffix(path: Path, allowed: tuple[str, ...]) -> str:
    suffix = path.suffix.lower()
    if suffix not in allowed:
        raise InputError(f"{path}: cannot read a {suffix or 'nameless'} file here; give {', '.join(allowed)}")
    return suffix


def _parquet() -> Any:
    with needs("parquet", "Parquet"):
        import pyarrow.parquet
    return pyarrow.parquet


def _read_excel(path: Path) -> Sheet:
    with needs("excel", "Excel"):
        import openpyxl  # noqa: F401  # pandas needs it
    with pd.ExcelFile(path, engine="openpyxl") as book:
        sheets = pd.read_excel(book, sheet_name=None, header=None)
    names = list(sheets)
    counts = {name: cells.apply(pd.to_numeric, errors="coerce").count().sum() for name, cells in sheets.items()}
    # The first that has a tenth of the numbers of the fullest: cover sheets have few.
    read = next(name for name, count in counts.items() if count >= max(counts.values()) / 10)
    cells = sheets[read].dropna(how="all")
    if cells.empty:
        raise InputError(f"sheet {str(names[0])!r} is empty; give a header and rows, in the first sheet")
    top = [["" if pd.isna(cell) else str(cell) for cell in row] for row in cells.head(SHEET_ROWS).to_numpy()]
    head = head_of(top, [int(row) + 1 for row in cells.index[:SHEET_ROWS]])
    frame = cells[cells.index >= head.first - 1].set_axis(list(head.headers), axis="columns").infer_objects()
    frame.index += 1 - FIRST_ROW
    which = "the first" if read == names[0] else "the first with many numbers"
    others = (f"sheet {read!r} is read, {which} of {len(names)}",) if len(names) > 1 else ()
    return Sheet(frame, (*others, *head.notes))
