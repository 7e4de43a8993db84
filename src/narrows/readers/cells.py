"""Cells of a table: numbers and words, or what is wrong with one in a sentence with file, row, column and remedy."""

import math
import re
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd

from narrows.errors import InputError, shown
from narrows.readers.headers import Column
from narrows.readers.table_head import seen
from narrows.readers.text_table import FIRST_ROW

LONGEST_CELL = 60
# Beyond this a number stands for a missing one (netCDF fills with 9.97e36), and its square spoils every sum.
LARGEST = 1e20


def row_number(frame: pd.DataFrame, where: np.ndarray) -> int:
    """Return the file's row of the first hit."""
    # where (rows,)
    return int(frame.index[int(np.argmax(where))]) + FIRST_ROW


def check_once(columns: list[Column], headers: list[str], known: Iterable[str], table: str) -> None:
    """Raise where no header is a quantity, or a quantity has two columns."""
    if not columns:
        raise InputError(
            f"{table}: no column is headed as a quantity: seen {seen(headers)}; head them {', '.join(known)}, "
            "or say which is which in a file for --mapping"
        )
    quantities = [column.quantity for column in columns]
    for name in quantities:
        if quantities.count(name) > 1:
            both = [c.header for c in columns if c.quantity == name]
            raise InputError(f"{table}: columns {both[0]!r} and {both[1]!r} are both {name}; keep one")
    for header in headers:
        # Of two columns with one header, pandas calls the second `header.1`.
        twin = re.sub(r"\.\d+$", "", header)
        if twin != header and any(column.header == twin for column in columns):
            raise InputError(f"{table}: columns {twin!r} and {header!r} are both {twin}; keep one")


def numbers(frame: pd.DataFrame, header: str, table: str, blanks: bool = False) -> np.ndarray:
    """Return a column as floats."""
    values = _floats(frame[header])
    # NaN is not below either.
    wrong = ~(np.abs(values) < LARGEST)
    if blanks:
        wrong &= ~_blank(frame[header])
    if wrong.any():
        cell = _word(frame[header].iloc[int(np.argmax(wrong))])
        fault = "which nothing measures" if np.isfinite(values[wrong][0]) else "not a finite number"
        row = row_number(frame, wrong)
        raise InputError(f"{table}: row {row}, column {header!r} holds {cell}, {fault}; mend the cell")
    return values


def _blank(column: pd.Series) -> np.ndarray:
    empty = column.isna().to_numpy()
    return empty if column.dtype.kind in "fiub" else empty | (column.astype(str).str.strip() == "").to_numpy()


def _floats(column: pd.Series) -> np.ndarray:
    """A column as floats, not a number where it holds dates, lists or integers without end."""
    if column.dtype.kind in "mM":
        return np.full(len(column), np.nan)
    try:
        return pd.to_numeric(column, errors="coerce").to_numpy(dtype=float)
    except (TypeError, ValueError, ArithmeticError):
        return np.array([_float(cell) for cell in column])


def _word(cell: Any) -> str:
    return cell if isinstance(cell, str) and len(cell) < LONGEST_CELL else shown(cell)


def _float(cell: Any) -> float:
    try:
        return float(cell)
    except (TypeError, ValueError, ArithmeticError):
        return math.nan


def labels(frame: pd.DataFrame, header: str, table: str) -> np.ndarray:
    """Return a column of names as words, without blanks around them."""
    empty = frame[header].isna().to_numpy()
    if empty.any():
        raise InputError(f"{table}: row {row_number(frame, empty)}, column {header!r} is empty; name the {header}")
    return frame[header].astype(str).str.strip().to_numpy(dtype=object)
