"""Files to data frames: text, Parquet, Excel and MATLAB, whole or in chunks."""

import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from narrows.base.errors import InputError, needs, reason
from narrows.base.progress import stage
from narrows.readers.settings import SHEET_ROWS
from narrows.readers.text_table import FIRST_ROW, dialect_of, head_of, read_text, text_chunks

TEXT = (".csv", ".txt", ".tsv", ".dat", ".asc")
READABLE = (*TEXT, ".parquet", ".xlsx", ".mat")
STREAMED = (*TEXT, ".parquet")


class Sheet(NamedTuple):
    frame: pd.DataFrame  # Its index is the row number in the file, less ``FIRST_ROW``
    notes: tuple[str, ...] = ()  # Notes on the file


def read_frame(path: Path) -> Sheet:
    readers: dict[str, Callable[[Path], Sheet]] = {
        **dict.fromkeys(TEXT, _read_text), ".parquet": _read_parquet, ".xlsx": _read_excel, ".mat": _read_mat,
    }  # fmt: skip
    reader = readers[_suffix(path, READABLE)]
    with nullcontext() if reader is _read_text else stage(f"reading {path.name}"), guarding(path):
        return reader(path)  # Text is read with counted bytes


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


@contextmanager
def guarding(path: Path) -> Iterator[None]:
    """Turn the errors of readers into one sentence with the file."""
    try:
        yield
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file; check the path") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except Exception as error:  # Readers raise many kinds of errors on files of another format
        raise InputError(
            f"{path}: is not a readable {path.suffix[1:]} table ({reason(error)}); export it again"
        ) from None


def _read_text(path: Path) -> Sheet:
    dialect = dialect_of(path)
    return Sheet(read_text(path, dialect), dialect.head.notes)


def _parquet() -> Any:
    with needs("parquet", "Parquet"):
        import pyarrow.parquet
    return pyarrow.parquet


def _read_parquet(path: Path) -> Sheet:
    """Read Parquet; a column that pandas saved as its index becomes an ordinary column."""
    return Sheet(_parquet().read_table(path).to_pandas(ignore_metadata=True))


def _read_excel(path: Path) -> Sheet:
    with needs("excel", "Excel"):
        import openpyxl  # noqa: F401  # pandas needs it
    with pd.ExcelFile(path, engine="openpyxl") as book:
        sheets = pd.read_excel(book, sheet_name=None, header=None)
    names = list(sheets)
    read = _sheet_of_data(sheets)
    frame, notes = _of_cells(sheets[read], str(names[0]))
    which = "the first" if read == names[0] else "the first with many numbers"
    alike = {read: frame} | {name: other for name in names if (other := _alike(sheets[name], frame)) is not None}
    if len(alike) > 1:
        every = pd.concat([part.assign(sheet=str(name)) for name, part in alike.items()])
        return Sheet(every, (f"{len(alike)} sheets with the same columns are read, {len(names)} in all", *notes))
    others = (f"sheet {read!r} is read, {which} of {len(names)}",) if len(names) > 1 else ()
    return Sheet(frame, (*others, *notes))


def _alike(cells: pd.DataFrame, frame: pd.DataFrame) -> pd.DataFrame | None:
    """A sheet with the same columns as another, all numbers; a column of names would distinguish its rows."""
    if cells.shape[1] != frame.shape[1] or any(frame[header].dtype.kind not in "fiu" for header in frame):
        return None
    with suppress(InputError):
        other = _of_cells(cells, "")[0]
        return other if list(other.columns) == list(frame.columns) else None
    return None


def _of_cells(cells: pd.DataFrame, first: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
    cells.index = pd.RangeIndex(len(cells))
    cells = cells.dropna(how="all")
    if cells.empty:
        raise InputError(f"sheet {first!r} is empty; give a header and rows, in the first sheet")
    top = [["" if pd.isna(cell) else str(cell) for cell in row] for row in cells.head(SHEET_ROWS).to_numpy()]
    head = head_of(top, [int(row) + 1 for row in cells.index[:SHEET_ROWS]])
    frame = cells[cells.index >= head.first - 1].set_axis(list(head.headers), axis="columns").infer_objects()
    frame.index += 1 - FIRST_ROW
    return frame, head.notes


def _sheet_of_data(sheets: Mapping[Any, pd.DataFrame]) -> Any:
    """The first sheet that has a tenth of the numbers of the fullest: cover sheets have few."""

    def is_number(cell: object) -> bool:
        return isinstance(cell, int | float) and cell == cell  # An empty cell is NaN.

    numbers = {name: int(cells.map(is_number).to_numpy().sum()) for name, cells in sheets.items()}
    return next(name for name, count in numbers.items() if count >= max(numbers.values()) / 10)


def _read_mat(path: Path) -> Sheet:
    from scipy.io import loadmat

    # SciPy ends the whole process on some invalid files, so another one tries.
    trial = [sys.executable, "-c", "import sys; from scipy.io import loadmat; loadmat(sys.argv[1])", str(path)]
    if subprocess.run(trial, stderr=subprocess.DEVNULL).returncode:
        raise ValueError("SciPy does not read it")
    variables = loadmat(path, simplify_cells=True)
    loaded = {k: v for k, v in variables.items() if not k.startswith("__")}
    if len(loaded) == 1 and isinstance(struct := next(iter(loaded.values())), dict):
        loaded = struct
    return Sheet(pd.DataFrame(loaded))
