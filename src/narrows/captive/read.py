"""Tables of captive tests, files or in memory, to CaptiveTests: screened, checked, in SI, sorted by test."""

import hashlib
import math
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, near_miss, path_of
from narrows.base.progress import stage
from narrows.captive import check, layouts, settings, tests
from narrows.captive.columns import COLUMNS, LABELS, Headers, begun, columns_with, renamed
from narrows.captive.tests import Block, CaptiveTests, Span, cuts, selection
from narrows.model.sections import Source
from narrows.readers import cells
from narrows.readers.cells import Column, Vocabulary, floats, more_like_it, recognised_in, row_number
from narrows.readers.frames import guarding, notes_of, read_chunks, read_frame
from narrows.readers.mapping import ColumnMapping, read_mapping
from narrows.ship.actuators import Actuator, with_standard
from narrows.ship.particulars import Configuration
from narrows.ship.ship_file import ShipSource, check_same_ship, configuration_in, ship_from

NO_ROWS = "no rows are left to read; add rows under the header, or select less strictly (where)"


@accept_aliases
def read_captive(
    table: Any, ship: ShipSource | None = None, where: str | None = None, actuators: Iterable[Actuator] = (),
    mapping: str | Path | Mapping[str, Any] | ColumnMapping | None = None,
) -> CaptiveTests:  # fmt: skip
    """Read a table of captive tests into memory, checked and in SI; columns that no term needs may be missing.

    Raises an InputError of one sentence with file, row, column and remedy.

    Parameters
    ----------
    table : str, Path, DataFrame or Dataset
        CSV in any dialect, Parquet, Excel, or a table of pandas, Polars, Arrow or xarray; columns ``test, t, x,
        y, psi, u, v, r, udot, vdot, rdot, heave, X, Y, N``, SI and radians unless the header has a unit, as in ``psi
        [deg]``. Optional: ``condition``, and ``depth``, ``draft``, ``width`` if they change from row to row.
    ship : str, Path, Configuration or mapping
        The ship file, its configuration, or its sections; a table of ``tests.to_csv`` has them as columns of its own.
    where : str, optional
        Selection of rows, as in ``"abs(y) < 0.5 and psi_deg > 2"``: on the headers of the table, or on the names above,
        SI unless they end in a unit.
    actuators : iterable of Actuator
        Additional actuators, whose columns the table and whose sections the ship file may have.
    mapping : str, Path, mapping or ColumnMapping, optional
        A laboratory's own names, units and signs: TOML with ``[columns]``, ``[units]`` and ``[positive]``, or the same
        as mappings.

    Examples
    --------
    >>> table = tests.to_dataframe().rename(columns={"v": "Sway velocity [m/s]"})
    >>> nw.read_captive(table, tests.configuration).rows == tests.rows
    True
    """
    movers = tuple(actuators)
    path = Path(table) if isinstance(table, str | os.PathLike) else None
    name = str(path) if path else cells.name_of(table)
    configuration = None if ship is None else ship_from(ship, movers)
    sheet = read_frame(path) if path else cells.as_sheet(table)
    if configuration and {"length", "beam", "block_coefficient"} <= {*map(str, sheet.frame)}:
        check_same_ship(sheet.frame, name, configuration)
    elif configuration is None:
        configuration, own = configuration_in(sheet.frame, name, movers)
        sheet = sheet._replace(frame=sheet.frame.drop(columns=own))
    with stage("checking the table"):
        frame, notes = clean(sheet.frame, name, where, read_mapping(mapping), movers)
        if not len(frame):
            raise InputError(f"{name}: {NO_ROWS}")
        read = with_rates(checked(frame, configuration, name, movers))
        hashed = sha256_of(path) if path else cells.sha256_of_frame(sheet.frame)
    source = Source("captive tests", path.name if path else type(table).__name__, hashed)
    return replace(read, source=source, notes=sheet.notes + notes + read.notes)


def as_tests(tests: Any, ship: ShipSource | None, default: ShipSource | None = None) -> Any:
    if hasattr(tests, "blocks"):
        if ship is not None:
            raise InputError("these tests have a ship already; give ship where they are a file or a table")
        return tests
    return read_captive(tests, default if ship is None else ship)


def sha256_of(path: Path) -> str:
    with guarding(path), path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@dataclass(frozen=True)
class StreamedTests:
    path: Path  # CSV or Parquet
    configuration: Configuration  # Ship, canal and water
    where: str | None = None  # Selection of rows
    mapping: ColumnMapping | None = None  # A laboratory's own names, units and signs
    actuators: tuple[Actuator, ...] = ()  # Additional actuators, whose columns the table may have
    source: Source = field(default_factory=Source)  # Origin of the rows
    notes: tuple[str, ...] = ("rows streamed from disk",)  # Notes of the reader
    force_rows = CaptiveTests.force_rows

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.lengths)

    @cached_property
    def lengths(self) -> dict[str, int]:
        lengths: dict[str, int] = {}
        last = ""
        for frame in self._frames():
            order, names, starts = grouped(tests_of(frame, str(self.path)))
            for name, start, stop in zip(names, starts, starts[1:], strict=False):
                is_split = order[stop - 1] - order[start] >= stop - start
                if is_split or (name in lengths and name != last):
                    raise InputError(f"{self.path}: the rows of test {name} do not stand together; sort it by test")
                lengths[name] = lengths.get(name, 0) + int(stop - start)
                last = name
        if not lengths:
            raise InputError(f"{self.path}: {NO_ROWS}")
        return lengths

    def blocks(self, pieces: int = 1) -> Iterator[Block]:
        done = dict.fromkeys(self.names, 0)
        last: tuple[str, float] = ("", -np.inf)
        conditions: set[str] = set()
        for frame in self._frames():
            rows = checked(frame, self.configuration, str(self.path), self.actuators)
            conditions |= set(rows.conditions)
            self._check_continued(rows, last, conditions)
            last = (rows.names[-1], float(rows["t"][-1]) if "t" in rows.columns else -np.inf)
            spans = list(self._spans(rows, pieces, done))
            yield Block({**self.configuration.values(), **rows.columns}, rows.rows, spans, rows.headers)

    def _frames(self) -> Iterator[pd.DataFrame]:
        for chunk in read_chunks(self.path, tests.BLOCK_ROWS):
            frame, _ = clean(chunk, str(self.path), self.where, self.mapping, self.actuators)
            if len(frame):
                yield frame

    def _spans(self, rows: CaptiveTests, pieces: int, done: dict[str, int]) -> Iterator[Span]:
        """Cut the rows at hand where the whole test would be cut; ``done`` counts earlier rows."""
        for name, (start, stop) in zip(rows.names, pairwise(rows.starts.tolist()), strict=True):
            first = done[name]
            done[name] += stop - start
            for piece, (a, b) in enumerate(pairwise(cuts(self.lengths[name], pieces).tolist())):
                low, high = max(a, first), min(b, done[name])
                if low < high:
                    yield Span(name, piece, start + low - first, start + high - first)

    def _check_continued(self, rows: CaptiveTests, last: tuple[str, float], conditions: set[str]) -> None:
        if len(conditions) > 1:
            raise InputError(
                f"{self.path}: holds several conditions ({', '.join(sorted(conditions)[:3])}, ...); "
                "choose one with a selection of rows"
            )
        name, t = last
        if "t" in rows.columns and rows.names[0] == name and rows["t"][0] <= t:
            raise InputError(f"{self.path}: test {name} goes back in time at t = {rows['t'][0]:g} s; sort it")


Tests = CaptiveTests | StreamedTests


@accept_aliases
def stream_captive(
    path: str | Path, ship: ShipSource, where: str | None = None, actuators: Iterable[Actuator] = (),
    mapping: str | Path | Mapping[str, Any] | ColumnMapping | None = None,
) -> StreamedTests:  # fmt: skip
    """Open a table of captive tests for ``identify`` that is read block by block at each use.

    Raises an InputError if the file is absent; rows are checked as they are read.

    Parameters
    ----------
    path, ship, where, actuators, mapping : Any
        As for ``read_captive``; the file is CSV or Parquet.
    """
    path = path_of("path", path)
    movers = tuple(actuators)
    configuration = ship_from(ship, movers)
    source, named = Source("captive tests", path.name, sha256_of(path)), read_mapping(mapping)
    of_mapping = (f"columns by {named.name}",) if named else ()
    notes = ("rows streamed from disk", *notes_of(path), *of_mapping, *configuration.notes)
    return StreamedTests(path, configuration, where, named, movers, source, notes)


def clean(
    raw: pd.DataFrame, table: str, where: str | None, mapping: ColumnMapping | None, actuators: Iterable[Actuator]
) -> tuple[pd.DataFrame, tuple[str, ...]]:  # fmt: skip
    known = columns_with(actuators)
    raw, of_rows = without_words(raw)
    mapped, notes = mapping.applied(raw, table, Vocabulary(known, LABELS)) if mapping else (raw, ())
    frame, of_layout = layouts.translated(mapped, where or "", table)
    if not mapping:
        frame, of_headers = renamed(frame, known, table)
        of_layout = (*of_layout, *of_headers)
    if where:
        frame = frame[selection(where, (mapped if mapping else raw).loc[frame.index], frame, known, table)]
    if not len(frame):
        return frame, (*notes, *of_layout)
    frame, of_totals = without_totals(cells.with_seconds(frame))
    frame, left_out = screened(frame, recognised_in(frame, known, table), tests_of(frame, table), table)
    return frame, (*notes, *of_rows, *of_layout, *of_totals, *left_out)


def without_words(frame: pd.DataFrame) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Return a table without rows that hold no number, such as repeated headers, and a note."""
    words = [header for header in frame.columns if frame[header].dtype.kind not in "fiub"]
    bare = np.asarray(frame.drop(columns=words).isna().to_numpy().all(axis=1))
    for header in words if bare.any() else ():  # A row stays bare unless a column of text holds a number there
        bare[bare] = ~np.isfinite(floats(frame[header][bare]))
    if not bare.any() or bare.all():
        return frame, ()
    kept = frame[~bare]
    numbers = {header: values for header in words if np.isfinite(values := floats(kept[header])).all()}
    return kept.assign(**numbers), (f"row {row_number(frame, bare)} holds no number{more_like_it(bare)}: left out",)


def without_totals(frame: pd.DataFrame) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Return a table without single rows that are called a mean or total of the others, and a note."""
    if "test" not in frame:
        return frame, ()
    names = frame["test"].astype(str).str.strip().str.casefold()
    total = (names.isin(settings.TOTALS) & ~names.duplicated(keep=False)).to_numpy()
    if not total.any() or total.all():
        return frame, ()
    row = row_number(frame, total)
    return frame[~total], (f"row {row} is named {frame['test'][total].iloc[0]!r}{more_like_it(total)}: left out",)


def checked(
    frame: pd.DataFrame, configuration: Configuration, table: str, actuators: Iterable[Actuator] = ()
) -> CaptiveTests:
    """Return the rows test by test, in SI, with notes of assumptions and of columns that were not read."""
    by_actuator = {actuator.name: actuator for actuator in with_standard(actuators)}
    order, names, starts = grouped(tests_of(frame, table))
    frame = frame.iloc[order]
    recognised = recognised_in(frame, columns_with(by_actuator.values()), table)
    headers = [str(header) for header in frame.columns]
    # A table of one row for each channel has no known header but time.
    unique = recognised if {column.quantity for column in recognised} - {"t"} else []
    cells.check_once(unique, headers, COLUMNS, table)
    columns = {c.quantity: cells.numbers(frame, c.header, table) * c.scale for c in recognised}
    by_name = {c.quantity: c for c in recognised}
    found = check.CheckedColumns(frame, columns, by_name, configuration, table)
    if "t" in columns:
        check.check_time(frame, names, starts, columns["t"], table)
    if "psi" in columns:
        if by_name["psi"].stated:  # A compass counts from 0 to 360.
            columns["psi"] = np.where(columns["psi"] > math.pi, columns["psi"] - 2 * math.pi, columns["psi"])
        check.check_heading(found)
        columns |= {"cos_psi": np.cos(columns["psi"]), "sin_psi": np.sin(columns["psi"])}
    check.check_units(found)
    for name in by_actuator.keys() & columns.keys():
        columns |= by_actuator[name].placed(columns[name])
    notes = [] if "heave" in columns else ["column 'heave' is absent: taken as 0"]
    notes += [] if "test" in frame else ["column 'test' is absent: all rows are taken as one test"]
    columns.setdefault("heave", np.zeros(len(frame)))
    condition = _conditions(frame, columns, configuration, table)
    conditions = tuple(condition[starts[:-1]]) if condition.size else ()
    check.check_inside(found)
    unread = tuple(header for header in headers if header not in {*LABELS, *(c.header for c in recognised)})
    doubtful = {header: name for header in unread if (name := begun(header)) and name not in {*columns, *LABELS}}
    notes += [f"column {header!r} is not read: is it {name}?" for header, name in doubtful.items()]
    notes += _check_plausible(found, names, starts)
    return CaptiveTests(
        columns, names, starts, configuration, conditions, notes=tuple(notes), headers=Headers(table, unread)
    )


def _check_plausible(found: check.CheckedColumns, names: tuple[str, ...], starts: np.ndarray) -> tuple[str, ...]:
    notes = found.configuration.notes + check.check_mass(found.configuration, found.table) + check.check_heave(found)
    check.check_forces(found)
    motions = check.MotionColumns(found.columns, starts, found.configuration.ship.length)
    agreements = check.kinematic_consistency(motions)
    check.check_axes(motions, agreements, found.table)
    check.check_drift(found)
    return notes + check.check_kinematics(motions, agreements, names, found.by_name, found.table)


def with_rates(tests: CaptiveTests) -> CaptiveTests:
    """Return tests with missing heading, yaw rate and accelerations computed from the other columns, test by test."""
    columns, made = dict(tests.columns), []
    steady = "t" not in columns and tests.rows == len(tests)  # One row for each test

    def rate_of(name: str) -> np.ndarray | None:
        """Return central differences over t, or 0 for steady tests; None if there is no time."""
        if steady:
            return np.zeros(tests.rows)
        if not {"t", name} <= columns.keys() or (np.diff(tests.starts) < 2).any():
            return None
        parts = pairwise(tests.starts.tolist())
        return np.concatenate([np.gradient(columns[name][a:b], columns["t"][a:b]) for a, b in parts])

    turns = steady and np.any(columns.get("r", 0.0))
    lacks_psi = "psi" not in columns and {"y", "u", "v"} <= columns.keys()
    if lacks_psi and not near_miss("psi", tests.headers.unread) and not turns and (aside := rate_of("y")) is not None:
        u, v = columns["u"], columns["v"]
        with np.errstate(all="ignore"):  # From dy/dt = u sin(psi) + v cos(psi); 0 at no speed
            columns["psi"] = np.nan_to_num(np.arcsin(np.clip(aside / np.hypot(u, v), -1, 1)) - np.arctan2(v, u))
        columns |= {"cos_psi": np.cos(columns["psi"]), "sin_psi": np.sin(columns["psi"])}
        made.append(f"psi is absent: taken from u, v and {'a constant y' if steady else 'y over t'}")
    for velocity, acceleration in (("psi", "r"), ("u", "udot"), ("v", "vdot"), ("r", "rdot")):
        if acceleration not in columns and (rate := rate_of(velocity)) is not None:
            columns[acceleration] = rate
            how = "as 0, for each test is one row" if steady else f"from {velocity} over t by differences"
            made.append(f"{acceleration} is absent: taken {how}")
    return replace(tests, columns=columns, notes=(*tests.notes, *made))


def tests_of(frame: pd.DataFrame, table: str) -> np.ndarray:
    return cells.labels(frame, "test", table) if "test" in frame else np.full(len(frame), "all", dtype=object)


def _conditions(
    frame: pd.DataFrame, columns: dict[str, np.ndarray], configuration: Configuration, table: str
) -> np.ndarray:
    """Return each row's condition; the depth of a condition in the ship file becomes a column."""
    if "condition" in frame:
        condition = cells.labels(frame, "condition", table)
        if "depth" not in columns and configuration.depths and set(condition) <= configuration.depths.keys():
            columns["depth"] = np.array([configuration.depths[name] for name in condition], dtype=float)
        return condition
    if "depth" in columns and np.ptp(columns["depth"]) > 0:
        return np.array([f"h{depth:.4g}" for depth in columns["depth"]])
    return np.empty(0, dtype=object)


def grouped(test: np.ndarray) -> tuple[np.ndarray, tuple[str, ...], np.ndarray]:
    codes, names = pd.factorize(test)
    order = np.argsort(codes, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(codes))])
    return order, tuple(str(name) for name in names), starts


def screened(
    frame: pd.DataFrame, columns: Iterable[Column], test: np.ndarray, table: str
) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Return a table without rows that hold a missing-value marker or a lone spike, and a note per column."""
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
        notes.append(f"{place}{more_like_it(wrong)}, which the other rows of its run contradict: left out")
        spoiled |= wrong
    return (frame[~spoiled], tuple(notes)) if notes else (frame, ())


def _runs(test: np.ndarray) -> Iterator[tuple[np.ndarray, bool]]:
    """Yield the rows of each test, with True; those of all short tests together, with False."""
    order, _, starts = grouped(test)
    parts = [order[start:stop] for start, stop in pairwise(starts)]
    yield from ((rows, True) for rows in parts if len(rows) >= settings.FEWEST_SCREENED)
    short = [rows for rows in parts if len(rows) < settings.FEWEST_SCREENED]
    if sum(map(len, short)) >= settings.FEWEST_SCREENED:
        yield np.concatenate(short), False


def _outliers(values: np.ndarray, runs: list[tuple[np.ndarray, bool]]) -> np.ndarray:
    """Return the rows whose distance from the run's median is many times that of nearly all others."""
    wrong, marks = np.zeros(len(values), bool), np.isin(np.abs(values), settings.MISSING_MARKS)
    plain = ~marks & np.isfinite(values)
    if not plain.any():
        return wrong
    typical = float(np.quantile(np.abs(values[plain]), settings.USUAL_SHARE))
    for rows, is_run in runs:
        if plain[rows].any():
            away = np.abs(values[rows] - np.median(values[rows][plain[rows]]))
            others = np.sort(away[plain[rows]])
            lone = max(1, int(settings.LONE_SHARE * len(others)))
            # A column that is constant in a run may still step by its size in the table.
            scale = max(others[-1 - lone] if len(others) > lone else 0.0, typical)
            # Tests of one condition each may differ by any amount, so a value alone is no spike.
            spikes = away > settings.SPIKE * scale if is_run else False
            wrong[rows] = marks[rows] & (away > settings.MARK_APART * scale) | spikes
    # Readings of a gauge hardly repeat: a marker value in several rows is no reading, whatever its size.
    counts = np.unique(values[plain], return_counts=True)[1]
    if 2 * len(counts) > counts.sum():
        for mark, count in zip(*np.unique(values[marks], return_counts=True), strict=True):
            if count >= settings.FEWEST_MARKED and count > counts.max():
                wrong |= values == mark
    return wrong
