"""Tables of captive tests, files or in memory, to CaptiveTests."""

import hashlib
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
from narrows.base.errors import InputError, path_of
from narrows.base.progress import stage
from narrows.captive import tests
from narrows.captive.rows import checked, clean, grouped, tests_of, with_rates
from narrows.captive.tests import Block, CaptiveTests, Span, cuts
from narrows.model.sections import Source
from narrows.readers.cells import as_sheet, name_of, sha256_of_frame
from narrows.readers.frames import guarding, notes_of, read_chunks, read_frame
from narrows.readers.mapping import ColumnMapping, read_mapping
from narrows.ship.actuators import Actuator
from narrows.ship.particulars import Configuration
from narrows.ship.ship_file import ShipSource, ship_from

NO_SHIP = (
    "a table has no ship of its own; give ship='ship.toml', a Configuration, or {'ship': {'length': ...}, 'canal': "
    "{'width': ...}}"
)
NO_ROWS = "no rows are left to read; add rows under the header, or select less strictly (where)"


@accept_aliases
def read_captive(
    table: Any, ship: ShipSource | None = None, where: str | None = None, actuators: Iterable[Actuator] = (),
    mapping: str | Path | Mapping[str, Any] | ColumnMapping | None = None,
) -> CaptiveTests:  # fmt: skip
    """Read a table of captive tests into memory, checked and in SI.

    The result does not depend on the terms fitted later: a missing column is reported only when terms need it.

    Raises an InputError of one sentence with file, row, column and remedy.

    Parameters
    ----------
    table : str, Path, DataFrame or Dataset
        CSV in any dialect, Parquet, Excel, or a table of pandas, Polars, Arrow or xarray; columns ``test, t, x,
        y, psi, u, v, r, udot, vdot, rdot, heave, X, Y, N``, SI and radians unless the header has a unit, as in ``psi
        [deg]``. Optional: ``condition``, and ``depth``, ``draft``, ``width`` if they change from row to row.
    ship : str, Path, Configuration or mapping
        The ship file, its configuration, or its sections as mappings.
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
    if ship is None:
        raise InputError(NO_SHIP)
    movers = tuple(actuators)
    configuration = ship_from(ship, movers)
    path = Path(table) if isinstance(table, str | os.PathLike) else None
    name = str(path) if path else name_of(table)
    sheet = read_frame(path) if path else as_sheet(table)
    with stage("checking the table"):
        frame, notes = clean(sheet.frame, name, where, read_mapping(mapping), movers)
        if not len(frame):
            raise InputError(f"{name}: {NO_ROWS}")
        read = with_rates(checked(frame, configuration, name, movers))
        hashed = sha256_of(path) if path else sha256_of_frame(sheet.frame)
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
