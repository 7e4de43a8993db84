"""Cells that nothing measured: marks of missing values and lone spikes, found run by run and left out by row."""

from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np
import pandas as pd

from narrows.captive import settings
from narrows.errors import InputError
from narrows.readers.cells import floats, row_number
from narrows.readers.headers import Column


def screened(
    frame: pd.DataFrame, columns: Iterable[Column], test: np.ndarray, table: str
) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Return a table without rows that hold a mark of a missing value or a lone spike, and a note of each column."""
    spoiled, notes = np.zeros(len(frame), bool), []
    runs = list(_runs(test))
    for column in columns:
        values = floats(frame[column.header])
        wrong = _outliers(values, runs)
        if not wrong.any():
            continue
        row, value = row_number(frame, wrong), values[int(np.argmax(wrong))]
        place = f"row {row}, column {column.header!r} holds {value:g}"
        if wrong.mean() > settings.MOST_SPOILED:
            raise InputError(
                f"{table}: {place}, as do {int(wrong.sum()) - 1} more rows that the others of their runs contradict; "
                "select good rows with --where, or mend the column"
            )
        more = f", and {int(wrong.sum()) - 1} more like it" if wrong.sum() > 1 else ""
        notes.append(f"{place}{more}, which the other rows of its run contradict: left out")
        spoiled |= wrong
    return (frame[~spoiled], tuple(notes)) if notes else (frame, ())


def _runs(test: np.ndarray) -> Iterator[tuple[np.ndarray, bool]]:
    """Rows of each test, and True; those of tests too short to judge by themselves come together, with False."""
    codes = pd.factorize(test)[0]
    order = np.argsort(codes, kind="stable")
    edges = np.concatenate([[0], np.cumsum(np.bincount(codes))]) if len(codes) else [0]
    parts = [order[start:stop] for start, stop in pairwise(edges)]
    yield from ((rows, True) for rows in parts if len(rows) >= settings.FEWEST_SCREENED)
    short = [rows for rows in parts if len(rows) < settings.FEWEST_SCREENED]
    if sum(map(len, short)) >= settings.FEWEST_SCREENED:
        yield np.concatenate(short), False


def _outliers(values: np.ndarray, runs: list[tuple[np.ndarray, bool]]) -> np.ndarray:
    wrong = np.zeros(len(values), bool)
    marks = np.isin(np.abs(values), settings.MISSING_MARKS)
    sizes = np.abs(values[~marks & np.isfinite(values)])
    usual = float(np.quantile(sizes, settings.USUAL_SHARE)) if sizes.size else 0.0
    for rows, is_run in runs:
        wrong[rows] = _spikes(values[rows], marks[rows], usual, is_run)
    return wrong


def _spikes(values: np.ndarray, marks: np.ndarray, usual: float, is_run: bool) -> np.ndarray:
    """Rows whose distance from the run's median is many times that of nearly all others."""
    plain = values[~marks & np.isfinite(values)]
    if not plain.size:
        return np.zeros(len(values), bool)
    away = np.abs(values - np.median(plain))
    others = np.sort(np.abs(plain - np.median(plain)))
    lone = max(1, int(settings.LONE_SHARE * len(others)))
    spread = others[-1 - lone] if len(others) > lone else 0.0
    # A column that stands still in a run may still step by as much as it is in the table.
    scale = max(float(spread), usual)
    marked = marks & (away > settings.MARK_APART * scale)
    # Tests of one condition each may differ by any amount: among them a value alone is no spike.
    return np.asarray(marked | (away > settings.SPIKE * scale) if is_run else marked)
