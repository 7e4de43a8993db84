"""What is wrong with a table, in one sentence that names file, row, column and remedy."""

import math
import re
from typing import Any

import numpy as np
import pandas as pd

from narrows.captive.columns import COLUMNS, Column
from narrows.captive.table_head import seen
from narrows.captive.text_table import FIRST_ROW
from narrows.errors import InputError, shown
from narrows.ship.particulars import Configuration

LONGEST_CELL = 60
LARGEST = 1e20
"""Beyond this a number stands for a missing one (netCDF fills with 9.97e36), and its square spoils every sum."""


def row_number(frame: pd.DataFrame, where: np.ndarray) -> int:
    """Return the file's row of the first hit (ours).

    Parameters
    ----------
    frame : DataFrame
        Its index counts the rows of the file.
    where : array (rows,) of bool
        The hits.
    """
    return int(frame.index[int(np.argmax(where))]) + FIRST_ROW


def check_once(columns: list[Column], headers: list[str], table: str) -> None:
    """Raise where no header is a quantity, or a quantity has two columns (ours).

    Parameters
    ----------
    columns : list of Column
        What was recognised.
    headers : list of str
        Every header of the table.
    table : str
        The file.

    Raises
    ------
    InputError
        Names the quantity and both headers.
    """
    if not columns:
        raise InputError(
            f"{table}: no column is headed as a quantity: seen {seen(headers)}; head them {', '.join(COLUMNS)}, "
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


def numbers(frame: pd.DataFrame, header: str, table: str) -> np.ndarray:
    """Return a column as floats (ours).

    Parameters
    ----------
    frame : DataFrame
        The table.
    header : str
        The column.
    table : str
        The file.

    Raises
    ------
    InputError
        At the first cell that is not a finite number, or beyond all measure.
    """
    values = _floats(frame[header])
    # NaN is not below either.
    wrong = ~(np.abs(values) < LARGEST)
    if wrong.any():
        cell = _word(frame[header].iloc[int(np.argmax(wrong))])
        fault = "which nothing measures" if np.isfinite(values[wrong][0]) else "not a finite number"
        row = row_number(frame, wrong)
        raise InputError(f"{table}: row {row}, column {header!r} holds {cell}, {fault}; mend the cell")
    return values


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
    """Return a column of names as words, without blanks around them (ours).

    Parameters
    ----------
    frame : DataFrame
        The table.
    header : str
        The column.
    table : str
        The file.

    Raises
    ------
    InputError
        At the first empty cell.
    """
    empty = frame[header].isna().to_numpy()
    if empty.any():
        raise InputError(f"{table}: row {row_number(frame, empty)}, column {header!r} is empty; name the {header}")
    return frame[header].astype(str).str.strip().to_numpy(dtype=object)


def check_time(frame: pd.DataFrame, test: np.ndarray, t: np.ndarray, table: str) -> None:
    """Raise where time stands still or runs back inside a test (ours).

    Parameters
    ----------
    frame : DataFrame
        The table.
    test : array (rows,)
        Name of each row's test.
    t : array (rows,) [s]
        Time.
    table : str
        The file.

    Raises
    ------
    InputError
        Names the row and says whether the time is a duplicate or unsorted.
    """
    stuck = np.concatenate([[False], (np.diff(t) <= 0) & (test[1:] == test[:-1])])
    if stuck.any():
        i = int(np.argmax(stuck))
        fault = "repeats the time of the row above" if t[i] == t[i - 1] else "goes back in time"
        row = row_number(frame, stuck)
        raise InputError(f"{table}: row {row}, column 't' {fault} (test {test[i]}, t = {t[i]:g} s); sort it by time")


def check_heading(frame: pd.DataFrame, psi: np.ndarray, column: Column, table: str) -> None:
    """Raise where the ship lies across the canal, or the heading looks like degrees (ours).

    Parameters
    ----------
    frame : DataFrame
        The table.
    psi : array (rows,) [rad]
        Heading.
    column : Column
        Where it came from.
    table : str
        The file.

    Raises
    ------
    InputError
        Names the row.
    """
    across = np.abs(psi) >= math.pi / 2
    if not across.any():
        return
    row, value = row_number(frame, across), psi[int(np.argmax(across))]
    if not column.stated:
        raise InputError(
            f"{table}: row {row}, column {column.header!r} = {value:g} rad looks like degrees; "
            "head the column 'psi [deg]'"
        )
    raise InputError(
        f"{table}: row {row}, column {column.header!r} is a heading of {math.degrees(value):.1f} deg; "
        "the model holds for |psi| < 90 deg, leave the row out"
    )


def check_rates(columns: dict[str, np.ndarray], test: np.ndarray, by_name: dict[str, Column], table: str) -> None:
    """Raise where psi and r differ by the factor of degrees to radians (ours).

    Parameters
    ----------
    columns : dict of str to array (rows,)
        In what should be SI.
    test : array (rows,)
        Name of each row's test.
    by_name : dict of str to Column
        Where each came from.
    table : str
        The file.

    Raises
    ------
    InputError
        Names the column that is likely in degrees.
    """
    if not {"t", "psi", "r"} <= columns.keys():
        return
    inside = test[1:] == test[:-1]
    turned = np.diff(columns["psi"])[inside]
    expected = (0.5 * (columns["r"][1:] + columns["r"][:-1]) * np.diff(columns["t"]))[inside]
    if not (turned @ turned > 0 and expected @ expected > 0):
        return
    correlation = turned @ expected / math.sqrt((turned @ turned) * (expected @ expected))
    factor = math.sqrt((turned @ turned) / (expected @ expected))
    for name, ratio in (("psi", factor), ("r", 1 / factor)):
        if correlation > 0.9 and 40 < ratio < 80 and not by_name[name].stated:
            unit = "deg" if name == "psi" else "deg/s"
            raise InputError(
                f"{table}: column {name!r} is {ratio:.0f} times what "
                f"{'r' if name == 'psi' else 'psi'} says, so it looks like degrees; head it '{name} [{unit}]'"
            )


def check_inside(frame: pd.DataFrame, columns: dict[str, np.ndarray], configuration: Configuration, table: str) -> None:
    """Raise where a hull corner touches or crosses a bank (ours).

    Parameters
    ----------
    frame : DataFrame
        The table.
    columns : dict of str to array (rows,)
        With y, cos_psi and sin_psi.
    configuration : Configuration
        Ship and canal.
    table : str
        The file.

    Raises
    ------
    InputError
        Names the row.
    """
    if not {"y", "cos_psi", "sin_psi"} <= columns.keys():
        return
    ship, width = configuration.ship, columns.get("width", configuration.canal.width)
    reach = np.abs(columns["y"]) + ship.length / 2 * np.abs(columns["sin_psi"]) + ship.beam / 2 * columns["cos_psi"]
    touching = reach >= np.asarray(width) / 2
    if touching.any():
        row, first = row_number(frame, touching), int(np.argmax(touching))
        y, width_there = columns["y"][first], float(np.broadcast_to(width, touching.shape)[first])
        raise InputError(
            f"{table}: row {row}, column 'y' = {y:g} m puts the hull on the bank of a canal "
            f"{width_there:g} m wide; check y, psi and the ship file"
        )
