"""Tables of captive tests, in the documented columns, to CaptiveTests."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from narrows.captive import check
from narrows.captive.columns import Column, columns_with, parse_header
from narrows.captive.formats import layouts
from narrows.captive.frames import read_frame
from narrows.captive.tests import CaptiveTests
from narrows.errors import InputError, reason, shown
from narrows.files import path_of, reading
from narrows.model.model import Source
from narrows.quantities.names import MOTION, Quantity
from narrows.ship.actuators import STANDARD
from narrows.ship.particulars import Configuration
from narrows.ship.ship_file import read_ship
from narrows.terms.canal_tables import PAPER
from narrows.terms.term import TermTable


class Rows(NamedTuple):
    """Checked rows of a table.

    Parameters
    ----------
    columns : dict of str to array (rows,)
        In SI.
    test, condition : array (rows,) of str
        Whose each row is; no conditions where the table names none.
    notes : tuple of str
        What there is to say of them.
    """

    columns: dict[str, np.ndarray]
    test: np.ndarray
    condition: np.ndarray
    notes: tuple[str, ...]


def read_captive(
    path: str | Path, ship: str | Path | Configuration, terms: TermTable = PAPER, where: str | None = None
) -> CaptiveTests:
    """Read a table of captive tests into memory.

    Parameters
    ----------
    path : str or Path
        CSV, Parquet or .mat; columns ``test, t, x, y, psi, u, v, r, udot, vdot, rdot, heave, X, Y, N``, SI
        and radians unless the header carries a unit, as in ``psi [deg]``. Optional: ``condition``, and
        ``depth``, ``draft``, ``width`` where they change from row to row.
    ship : str, Path or Configuration
        The ship file, or what was read from it.
    terms : TermTable
        What the columns must suffice for.
    where : str, optional
        Which rows to take, as in ``"abs(y) < 0.5 and u > 0.3"``, on the headers of the table.

    Returns
    -------
    CaptiveTests
        Checked, in SI.

    Raises
    ------
    InputError
        In one sentence with file, row, column and remedy.
    """
    path = path_of("path", path)
    configuration = ship if isinstance(ship, Configuration) else read_ship(ship)
    frame, notes = prepared(read_frame(path), where, str(path))
    if not len(frame):
        raise InputError(f"{path}: no rows are left to read; give a test at least one row")
    rows = checked(frame, configuration, terms, str(path))
    return gathered(rows, configuration, Source("captive tests", path.name, sha256_of(path)), notes)


def prepared(frame: pd.DataFrame, where: str | None, place: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Bring a raw frame to the documented headers and rows (ours).

    Parameters
    ----------
    frame : DataFrame
        As read.
    where : str, optional
        Which rows to take.
    place : str
        The file.

    Raises
    ------
    InputError
        Where the selection cannot be understood.
    """
    if where:
        frame = _selected(frame, where, place)
    return layouts.translated(frame, where or "", place)


def checked(frame: pd.DataFrame, configuration: Configuration, terms: TermTable, place: str) -> Rows:
    """Check a frame and bring it to SI (ours).

    Parameters
    ----------
    frame : DataFrame
        In the documented headers; its index counts the rows of the file.
    configuration : Configuration
        Ship, canal and water.
    terms : TermTable
        What the columns must suffice for.
    place : str
        The file.

    Raises
    ------
    InputError
        At the first thing that is wrong.
    """
    movers = {own.name: own for own in (*STANDARD, *terms.actuators)}
    known = columns_with(movers.values())
    found = _recognised(frame, known, place)
    wanted, assumed = _needed(terms, {c.quantity for c in found})
    needed = {name: known[name] for name in wanted}
    check.check_present(found, [str(h) for h in frame.columns], needed, place)
    columns = {c.quantity: check.numbers(frame, c.header, place) * c.scale for c in found}
    test = tests_of(frame, place)
    by_name = {c.quantity: c for c in found}
    if "t" in columns:
        order = _grouped(test)[0]
        check.check_time(frame.iloc[order], test[order], columns["t"][order], place)
    if "psi" in columns:
        check.check_heading(frame, columns["psi"], by_name["psi"], place)
        check.check_rates(columns, test, by_name, place)
        columns |= {"cos_psi": np.cos(columns["psi"]), "sin_psi": np.sin(columns["psi"])}
    for name in movers.keys() & columns.keys():
        columns |= movers[name].placed(columns[name])
    columns |= {name: np.zeros(len(frame)) for name in assumed}
    condition = _conditions(frame, columns, configuration, place)
    check.check_inside(frame, columns, configuration, place)
    notes = [f"column {name!r} is absent: taken as 0" for name in assumed]
    notes += [] if "test" in frame else ["column 'test' is absent: all rows are taken as one test"]
    return Rows(columns, test, condition, tuple(notes))


def gathered(rows: Rows, configuration: Configuration, source: Source, notes: tuple[str, ...] = ()) -> CaptiveTests:
    """Put the rows of each test together (ours).

    Parameters
    ----------
    rows : Rows
        Checked rows.
    configuration : Configuration
        Ship, canal and water.
    source : Source
        Where they come from.
    notes : tuple of str
        What to say beside the rows' own notes.
    """
    order, names, starts = _grouped(rows.test)
    return CaptiveTests(
        columns={name: column[order] for name, column in rows.columns.items()},
        names=names,
        starts=starts,
        configuration=configuration,
        conditions=tuple(rows.condition[order][starts[:-1]]) if rows.condition.size else (),
        source=source,
        notes=notes + rows.notes,
    )


def tests_of(frame: pd.DataFrame, place: str) -> np.ndarray:
    """Return the name of each row's test (ours).

    Parameters
    ----------
    frame : DataFrame
        In the documented headers.
    place : str
        The file.
    """
    return check.labels(frame, "test", place) if "test" in frame else np.full(len(frame), "all", dtype=object)


def _recognised(frame: pd.DataFrame, known: Mapping[str, Quantity], place: str) -> list[Column]:
    try:
        return [column for header in frame.columns if (column := parse_header(str(header), known))]
    except InputError as error:
        raise InputError(f"{place}: {error}") from None


def _needed(terms: TermTable, found: set[str]) -> tuple[list[str], list[str]]:
    """Columns that the terms need, and those of them that may be taken as zero."""
    columns = {"cos_psi": "psi", "sin_psi": "psi"} | {
        word: own.name for own in terms.actuators for word in own.controls
    }
    needed = [columns.get(name, name) for name in terms.inputs if name in MOTION or name in columns]
    forces = [force for force, own in terms.forces.items() if own]
    assumed = [name for name in ("heave",) if name in needed and name not in found]
    return [name for name in [*needed, *forces] if name not in assumed], assumed


def _conditions(
    frame: pd.DataFrame, columns: dict[str, np.ndarray], configuration: Configuration, place: str
) -> np.ndarray:
    """Each row's condition; a condition that the ship file gives a depth gets it as a column."""
    if "condition" in frame:
        condition = check.labels(frame, "condition", place)
        if "depth" not in columns and configuration.depths and set(condition) <= configuration.depths.keys():
            columns["depth"] = np.array([configuration.depths[name] for name in condition], dtype=float)
        return condition
    if "depth" in columns and np.ptp(columns["depth"]) > 0:
        return np.array([f"h{depth:.4g}" for depth in columns["depth"]])
    return np.empty(0, dtype=object)


def _grouped(test: np.ndarray) -> tuple[np.ndarray, tuple[str, ...], np.ndarray]:
    codes, names = pd.factorize(test)
    order = np.argsort(codes, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(codes))])
    return order, tuple(str(name) for name in names), starts


def _selected(frame: pd.DataFrame, where: str, place: str) -> pd.DataFrame:
    try:
        chosen: Any = frame.eval(where, engine="python")
        if not pd.api.types.is_bool_dtype(chosen):
            raise TypeError("it is neither true nor false")
        selected: pd.DataFrame = frame[chosen]
    except Exception as error:
        said = f"{shown(where)} ({reason(error)})"
        raise InputError(f"{place}: cannot select rows where {said}; use the table's headers") from None
    return selected


def sha256_of(path: Path) -> str:
    """Return the hash of a file, read in pieces (ours).

    Parameters
    ----------
    path : Path
        The file.
    """
    with reading(path, "a table"), path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
