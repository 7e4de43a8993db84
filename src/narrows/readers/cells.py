"""Headers and cells of a table: quantity, unit, numbers and words, or one sentence of error with the remedy."""

import hashlib
import math
import re
from collections.abc import Iterable, Mapping
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from narrows.base.errors import InputError, needs, reason, shown
from narrows.quantities.names import Quantity, unit_named
from narrows.readers.frames import Sheet
from narrows.readers.settings import LARGEST, LONGEST_CELL
from narrows.readers.text_table import FIRST_ROW, seen

# Units behind an underscore, as in psi_deg.
SUFFIXES = (
    "m", "mm", "deg", "rad", "mps", "mps2", "degps", "degps2", "radps", "radps2", "s", "N", "kN", "Nm", "kNm", "kn",
    "rpm", "rps",
)  # fmt: skip
EPOCH = pd.Timestamp("1970-01-01", tz="UTC")  # In microseconds: dates from 2263 on exceed 64 bits of nanoseconds


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
    si, stated = known[name].unit, name != header.strip()
    if not stated or unit == si:
        return Column(header, name, 1.0, stated)
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


def recognised_in(frame: pd.DataFrame, known: Mapping[str, Quantity], table: str) -> list[Column]:
    try:
        return [column for header in frame.columns if (column := parse_header(str(header), known))]
    except InputError as error:
        raise InputError(f"{table}: {error}") from None


# Thousands in groups; without a decimal point the comma could be a decimal one.
THOUSANDS = r"^\s*[+-]?\d{1,3}(?:,\d{3})+\.\d+\s*$"


def row_number(frame: pd.DataFrame, where: np.ndarray) -> int:
    return int(frame.index[int(np.argmax(where))]) + FIRST_ROW


def check_once(columns: list[Column], headers: list[str], known: Iterable[str], table: str) -> None:
    if not columns:
        raise InputError(
            f"{table}: no column is headed as a quantity: seen {seen(headers)}; head them {', '.join(known)}, "
            "or say which is which in a file for --mapping"
        )
    names = {column.header: column.quantity for column in columns}
    # If two columns share a header, pandas calls the second `header.1`.
    bare = {header: re.sub(r"\.\d+$", "", header) for header in headers}
    twins = [(twin, header) for header, twin in bare.items() if twin in names and twin != header]
    twins += [(one, other) for one, other in combinations(names, 2) if names[one] == names[other]]
    for one, other in twins:
        raise InputError(f"{table}: columns {one!r} and {other!r} are both {names[one]}; keep one")


def numbers(frame: pd.DataFrame, header: str, table: str, blanks: bool = False) -> np.ndarray:
    values = floats(frame[header])
    # True for NaN too.
    wrong = ~(np.abs(values) < LARGEST)
    if blanks:
        wrong &= ~_blank(frame[header])
    if wrong.any():
        first = int(np.argmax(wrong))
        cell = frame[header].iloc[first]
        cell = cell if isinstance(cell, str) and len(cell) < LONGEST_CELL else shown(cell)
        size = "which nothing measures" if np.isfinite(values[first]) else "not a finite number"
        fault = "is empty or NaN" if _blank(frame[header])[first] else f"holds {cell}, {size}"
        remedy = "mend them or leave their rows out" if wrong.sum() > 1 else "mend the cell or leave the row out"
        place = f"{table}: row {row_number(frame, wrong)}, column {header!r}"
        raise InputError(f"{place} {fault}{more_like_it(wrong)}; {remedy}")
    return values


def more_like_it(rows: np.ndarray) -> str:
    return f", and {int(rows.sum()) - 1} more like it" if rows.sum() > 1 else ""


def _blank(column: pd.Series) -> np.ndarray:
    empty = column.isna().to_numpy()
    return empty if column.dtype.kind in "fiub" else empty | (column.astype(str).str.strip() == "").to_numpy()


def floats(column: pd.Series) -> np.ndarray:
    """Return a column as floats, NaN for dates, lists or huge integers."""
    if column.dtype.kind in "mM":
        return np.full(len(column), np.nan)
    try:
        values = pd.to_numeric(column, errors="coerce").to_numpy(dtype=float)
        lost = np.isnan(values) & column.notna().to_numpy()
        if column.dtype.kind in "fiub" or not lost.any():
            return values
        plain = column.astype(str).str.replace("\u2212", "-")
        plain = plain.str.replace(THOUSANDS, lambda match: match[0].replace(",", ""), regex=True)
        plain = plain.str.replace(r"(?<=[\d.])[dD](?=[+-]\d+$)", "e", regex=True)  # Fortran's exponent
        return np.where(lost, pd.to_numeric(plain, errors="coerce").to_numpy(dtype=float), values)
    except (TypeError, ValueError, ArithmeticError):
        return np.array([_float(cell) for cell in column])


def _float(cell: Any) -> float:
    try:
        return float(cell)
    except (TypeError, ValueError, ArithmeticError):
        return math.nan


def labels(frame: pd.DataFrame, header: str, table: str) -> np.ndarray:
    empty = frame[header].isna().to_numpy()
    if empty.any():
        raise InputError(f"{table}: row {row_number(frame, empty)}, column {header!r} is empty; name the {header}")
    return frame[header].astype(str).str.strip().to_numpy(dtype=object)


def with_seconds(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a table whose times of day, or dates with times, are in seconds."""
    if "t" not in frame or frame["t"].dtype.kind in "fiub":
        return frame
    words = frame["t"].astype(str).str.strip()
    times = pd.to_timedelta(words.where(words.str.match(r"\d+:\d+:\d")), errors="coerce")
    if times.isna().any():
        dotted = r"^(\d\d)\.(\d\d)\.(\d{4})[ T]"  # With dots the day comes first
        words = words.str.replace(dotted, r"\3-\2-\1T", regex=True)
        dates = words.where(words.str.match(r"\d{4}-\d\d-\d\d"))
        times = pd.to_datetime(dates, errors="coerce", format="ISO8601", utc=True) - EPOCH
    return frame if times.isna().any() else frame.assign(t=times.dt.total_seconds())


def as_sheet(table: object) -> Sheet:
    try:
        frame = _as_frame(table)
    except InputError:
        raise
    except Exception as error:  # Libraries of tables raise many kinds of errors on bad columns
        raise InputError(f"{name_of(table)}: cannot be read as a table ({reason(error)}); give a DataFrame") from None
    frame = frame.set_axis([str(header) for header in frame.columns], axis="columns")
    if (twice := frame.columns[frame.columns.duplicated()]).size:
        raise InputError(f"{name_of(table)}: two columns are headed {twice[0]!r}; keep one")
    frame.index = pd.RangeIndex(-FIRST_ROW, len(frame) - FIRST_ROW)
    return Sheet(frame)


def name_of(table: object) -> str:
    return f"the {type(table).__name__}"


def sha256_of_frame(frame: pd.DataFrame) -> str:
    words = {header: str for header in frame if pd.api.types.is_object_dtype(frame[header])}
    rows = pd.util.hash_pandas_object(frame.astype(words), index=False)
    return hashlib.sha256("\n".join(frame.columns).encode() + rows.to_numpy().tobytes()).hexdigest()


def _as_frame(table: Any) -> pd.DataFrame:
    if isinstance(table, pd.DataFrame):
        # An index with names becomes ordinary columns.
        return table.reset_index(drop=table.index.names == [None])
    if hasattr(table, "data_vars"):
        frame: pd.DataFrame = table.to_dataframe().reset_index()
        units = {name: own.attrs.get("units") for name, own in table.variables.items() if "[" not in str(name)}
        return frame.rename(columns={n: f"{n} [{unit}]" for n, unit in units.items() if unit and isinstance(unit, str)})
    if hasattr(table, "to_pandas"):
        with needs("parquet", f"a {type(table).__name__}"):
            return pd.DataFrame(table.to_pandas())
    if isinstance(table, Mapping):
        return pd.DataFrame(dict(table))
    raise InputError(f"table = {shown(table)} is neither a path nor a table; give a file, a DataFrame or a Dataset")
