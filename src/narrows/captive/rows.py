"""Rows of a table in the documented columns: recognised, checked, in SI, by test."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pandas as pd

from narrows.captive import check, magnitudes
from narrows.captive.columns import COLUMNS, columns_with
from narrows.captive.formats import layouts
from narrows.captive.kinematics import MotionColumns, check_kinematics
from narrows.captive.selection import chosen_early, chosen_late
from narrows.captive.tests import LABELS, CaptiveTests, Headers
from narrows.model.source import Source
from narrows.quantities.names import Quantity
from narrows.readers import cells
from narrows.readers.headers import Column, Vocabulary, recognised_in
from narrows.readers.mapping import ColumnMapping
from narrows.ship.actuator import Actuator
from narrows.ship.actuators import STANDARD
from narrows.ship.particulars import Configuration

# Columns taken as 0 where a table has none.
ASSUMED = ("heave",)


class Rows(NamedTuple):
    """Checked rows of a table."""

    columns: dict[str, np.ndarray]  # (rows,) In SI
    test: np.ndarray  # (rows,) Whose each row is; no conditions where the table names none
    condition: np.ndarray  # (rows,) Whose each row is; no conditions where the table names none
    notes: tuple[str, ...]  # What there is to say of them
    headers: Headers  # Of the table


class Reading(NamedTuple):
    """How a table is to be read."""

    table: str  # The file, for sentences
    where: str | None = None  # Which rows to take
    mapping: ColumnMapping | None = None  # Its own names, units and signs
    actuators: tuple[Actuator, ...] = ()  # Beside those of the package

    @property
    def known(self) -> dict[str, Quantity]:
        """What the table may carry."""
        return columns_with(self.actuators)


def prepared(raw: pd.DataFrame, asked: Reading) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Bring a raw frame to the documented headers and rows."""
    table, where = asked.table, asked.where
    mapped, notes = asked.mapping.applied(raw, table, Vocabulary(asked.known, LABELS)) if asked.mapping else (raw, ())
    early = chosen_early(mapped, where, table)
    frame, of_layout = layouts.translated(mapped if early is None else mapped[early], where or "", table)
    if early is None and where:
        frame = frame[chosen_late(raw, frame, where, table, asked.known)]
    return frame, (*notes, *of_layout)


def checked(
    frame: pd.DataFrame, configuration: Configuration, table: str, actuators: Iterable[Actuator] = (),
    ship_file: str = "",
) -> Rows:  # fmt: skip
    """Check a frame and bring it to SI."""
    movers = {actuator.name: actuator for actuator in (*STANDARD, *actuators)}
    known = columns_with(movers.values())
    recognised = recognised_in(frame, known, table)
    headers = [str(header) for header in frame.columns]
    cells.check_once(recognised, headers, COLUMNS, table)
    columns = {c.quantity: cells.numbers(frame, c.header, table) * c.scale for c in recognised}
    test = tests_of(frame, table)
    by_name = {c.quantity: c for c in recognised}
    if "t" in columns:
        order = _grouped(test)[0]
        check.check_time(frame.iloc[order], test[order], columns["t"][order], table)
    if "psi" in columns:
        check.check_heading(frame, columns["psi"], by_name["psi"], table)
        check.check_rates(columns, test, by_name, table)
        columns |= {"cos_psi": np.cos(columns["psi"]), "sin_psi": np.sin(columns["psi"])}
    for name in movers.keys() & columns.keys():
        columns |= movers[name].placed(columns[name])
    assumed = [name for name in ASSUMED if name not in columns]
    columns |= {name: np.zeros(len(frame)) for name in assumed}
    condition = _conditions(frame, columns, configuration, table)
    check.check_inside(frame, columns, configuration, table)
    sense = _physical_sense(frame, columns, test, configuration, by_name, table)
    notes = [f"column {name!r} is absent: taken as 0" for name in assumed]
    notes += [] if "test" in frame else ["column 'test' is absent: all rows are taken as one test"]
    unread = tuple(header for header in headers if header not in {c.header for c in recognised})
    return Rows(columns, test, condition, (*notes, *sense), Headers(table, unread, ship_file))


def _physical_sense(
    frame: pd.DataFrame, columns: dict[str, np.ndarray], test: np.ndarray, configuration: Configuration,
    by_name: dict[str, Column], table: str,
) -> tuple[str, ...]:  # fmt: skip
    """Raise what cannot be of this ship, and return what is odd."""
    notes = magnitudes.check_mass(configuration, table)
    notes += magnitudes.check_heave(frame, columns, configuration, by_name.get("heave"), table)
    magnitudes.check_forces(columns, configuration, by_name, table)
    magnitudes.check_drift(columns, by_name, table)
    order, names, starts = _grouped(test)
    motions = MotionColumns(
        {name: column[order] for name, column in columns.items()}, starts, configuration.ship.length
    )
    return notes + check_kinematics(motions, names, by_name, table)


def gathered(rows: Rows, configuration: Configuration, source: Source, notes: tuple[str, ...] = ()) -> CaptiveTests:
    """Put the rows of each test together."""
    order, names, starts = _grouped(rows.test)
    return CaptiveTests(
        columns={name: column[order] for name, column in rows.columns.items()},
        names=names,
        starts=starts,
        configuration=configuration,
        conditions=tuple(rows.condition[order][starts[:-1]]) if rows.condition.size else (),
        source=source,
        notes=notes + rows.notes,
        headers=rows.headers,
    )


def tests_of(frame: pd.DataFrame, table: str) -> np.ndarray:
    """Return the name of each row's test."""
    return cells.labels(frame, "test", table) if "test" in frame else np.full(len(frame), "all", dtype=object)


def _conditions(
    frame: pd.DataFrame, columns: dict[str, np.ndarray], configuration: Configuration, table: str
) -> np.ndarray:
    """Each row's condition; a condition that the ship file gives a depth gets it as a column."""
    if "condition" in frame:
        condition = cells.labels(frame, "condition", table)
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
