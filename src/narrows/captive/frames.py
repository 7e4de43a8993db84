"""Files to data frames: CSV, Parquet, MATLAB and raw tab-separated records, whole or in chunks."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd

from narrows.captive.matlab import check_elements
from narrows.errors import InputError, reason, shown

FIRST_ROW = 2
"""What editors call the row under a header."""
READABLE = (".csv", ".parquet", ".mat", ".dat")


def read_frame(path: Path) -> pd.DataFrame:
    """Read a whole table (ours).

    Parameters
    ----------
    path : Path
        CSV, Parquet, MATLAB or a raw record by its suffix.

    Raises
    ------
    InputError
        Where the file is absent, empty, damaged or of another kind.
    """
    readers = {".csv": _read_csv, ".parquet": _read_parquet, ".mat": _read_mat, ".dat": _read_dat}
    reader: Any = readers[_suffix(path, READABLE)]
    frame: pd.DataFrame = _guarded(path, lambda: _sound(reader(path)))
    return frame


def read_chunks(path: Path, rows: int) -> Iterator[pd.DataFrame]:
    """Read a table chunk by chunk, holding one at a time (ours).

    Parameters
    ----------
    path : Path
        CSV or Parquet by its suffix.
    rows : int
        Of a chunk, at most.

    Raises
    ------
    InputError
        Where the file is absent, empty, damaged or of another kind.
    """
    suffix = _suffix(path, READABLE[:2])
    chunks = (_csv_chunks if suffix == ".csv" else _parquet_chunks)(path, rows)
    while (chunk := _guarded(path, lambda: _sound(next(chunks, None)))) is not None:
        yield chunk


def _csv_chunks(path: Path, rows: int) -> Iterator[pd.DataFrame]:
    with pd.read_csv(path, chunksize=rows, low_memory=False) as chunks:
        yield from chunks


def _parquet_chunks(path: Path, rows: int) -> Iterator[pd.DataFrame]:
    first = 0
    with _parquet().ParquetFile(path) as file:
        for batch in file.iter_batches(batch_size=rows):
            frame = batch.to_pandas(ignore_metadata=True)
            frame.index = range(first, first + len(frame))
            first += len(frame)
            yield frame


def _sound(frame: Any) -> Any:
    """A frame whose rows are counted and whose headers differ; pandas takes a surplus of cells for names of rows."""
    if frame is None:
        return None
    if not isinstance(frame.index, pd.RangeIndex):
        raise InputError(f"row {FIRST_ROW} has more cells than the header; give each column one header")
    twice = frame.columns[frame.columns.duplicated()]
    if len(twice):
        raise InputError(f"two columns are headed {shown(twice[0])}; keep one")
    return frame


def _suffix(path: Path, allowed: tuple[str, ...]) -> str:
    suffix = path.suffix.lower()
    if suffix not in allowed:
        raise InputError(f"{path}: cannot read a {suffix or 'nameless'} file here; give {', '.join(allowed)}")
    return suffix


def _guarded(path: Path, read: Any) -> Any:
    try:
        return read()
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file; check the path") from None
    except pd.errors.EmptyDataError:
        raise InputError(f"{path}: the table is empty; give a header and rows") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except Exception as error:  # Readers of formats raise nearly anything on what is none.
        raise InputError(
            f"{path}: is not a readable {path.suffix[1:]} table ({reason(error)}); export it again"
        ) from None


def _read_csv(path: Path) -> pd.DataFrame:
    return pd.read_csv(path, low_memory=False)


def _parquet() -> Any:
    try:
        import pyarrow.parquet
    except ImportError:
        raise InputError(
            "Parquet needs pyarrow: install narrows with its extra, pip install 'narrows[parquet]'"
        ) from None
    return pyarrow.parquet


def _read_parquet(path: Path) -> pd.DataFrame:
    """A column that pandas saved as its index is a column like any other."""
    frame: pd.DataFrame = _parquet().read_table(path).to_pandas(ignore_metadata=True)
    return frame


def _read_mat(path: Path) -> pd.DataFrame:
    from scipy.io import loadmat

    check_elements(path.read_bytes())
    variables = loadmat(path, simplify_cells=True)
    loaded = {k: v for k, v in variables.items() if not k.startswith("__")}
    if len(loaded) == 1 and isinstance(struct := next(iter(loaded.values())), dict):
        loaded = struct
    return pd.DataFrame(loaded)


def _read_dat(path: Path) -> pd.DataFrame:
    """Tab separated, latin-1, a line of names over a line of units."""
    with path.open(encoding="latin-1") as file:
        names, units = (file.readline().rstrip("\n").split("\t") for _ in range(2))
    frame = pd.read_csv(path, sep="\t", encoding="latin-1", header=None, skiprows=2)
    headers = [f"{name.strip()} [{unit.strip()}]" for name, unit in zip(names, units, strict=True) if name.strip()]
    frame.index += 1  # Two lines stand above the rows.
    return frame.iloc[:, : len(headers)].set_axis(headers, axis="columns")
