"""Captive tests in memory, and their blocks of rows for identification."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import compress, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.base.aliases import accept_aliases, name_here
from narrows.base.errors import InputError, check_choice, did_you_mean, near_miss, reason, shown
from narrows.base.files import csv_of
from narrows.base.results import Tabulated, given_or_written, same_content
from narrows.captive.columns import LABELS, NO_TABLE, Headers, check_given
from narrows.model.sections import Source
from narrows.model.term import TermTable
from narrows.quantities.names import FORCES, MOTION, PARTICULARS, Number, Quantity
from narrows.readers.cells import floats, parse_header
from narrows.ship.actuators import STANDARD
from narrows.ship.particulars import Configuration, Configured

if TYPE_CHECKING:
    import pandas as pd

# Rows per block: large enough for NumPy, small enough for the cache and for memory.
BLOCK_ROWS = 32_000


class Span(NamedTuple):
    """Consecutive rows of one test inside a block."""

    test: str  # Its name
    piece: int  # Index of the stretch in the test
    start: int  # Rows of the block
    stop: int  # Rows of the block


# Share of the speed, of a sway velocity or of yaw rate by length, below which a test has no such motion.
LEAST_MOTION = 0.015
# Rows that the filter of forces needs in a test, beyond which it is continued.
PADDED = 15
# Words for kinds of motion that tell nothing more.
OF_ALL_KINDS = {"harmonic", "static", "steady", "dynamic", "pmm", "test", "tests"}


class Block(NamedTuple):
    values: Mapping[str, Number]  # Every quantity by name, columns and particulars alike
    rows: int  # Number of rows
    spans: list[Span]  # Tests of the rows
    headers: Headers = NO_TABLE  # Headers of their table


def cuts(rows: int, pieces: int) -> np.ndarray:
    """Return the edges of about equal stretches of a test, first and last row included."""
    return np.unique(np.linspace(0, rows, pieces + 1).astype(int))


@accept_aliases
@dataclass(frozen=True, repr=False)
class CaptiveTests(Configured, Tabulated):
    """Captive tests in memory, in SI and radians.

    >>> tests["v"].shape == (tests.rows,)
    True
    """

    #: (rows,) Motion, forces, and particulars that change from row to row; ``cos_psi`` and ``sin_psi`` for psi
    columns: Mapping[str, np.ndarray]
    names: tuple[str, ...]  #: The tests, in the order of their rows
    starts: np.ndarray  #: First row of each test, and the number of rows
    configuration: Configuration  #: Ship, canal and water
    conditions: tuple[str, ...] = ()  #: The condition (a water depth, say) of each test
    source: Source = field(default_factory=Source)  #: Origin of the rows
    notes: tuple[str, ...] = ()  #: Notes of the reader: rows left out, columns assumed
    headers: Headers = NO_TABLE  #: Headers of their table
    __eq__ = same_content

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self.starts[-1])

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column; None if unknown."""
        known = {name: quantity.unit for name, quantity in {**MOTION, **PARTICULARS, **FORCES}.items()}
        known |= {"t": "s", "psi": "rad"} | {own.name: own.unit for own in STANDARD}
        return {name: known.get(name, "1" if _is_part(name, self.columns) else "") for name in self.columns}

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kind of each test: ``straight``, ``drift``, ``turn``, ``pure sway``, ``pure yaw``, ``sway and yaw``.

        ``yaw with drift`` is one with a mean drift, and so are ``turn with drift`` and the like.
        """
        return tuple(_kind(self.rows_of(place), self.ship.length) for place in range(len(self)))

    def summary(self) -> str:
        labels = list(dict.fromkeys(self.conditions))
        several = f" in {len(labels)} conditions" if len(labels) > 1 else ""
        tests = f"{len(self.names)} test{'s' * (len(self.names) > 1)}{several}, {int(self.starts[-1])} rows"
        forces = ", ".join(force for force in FORCES if force in self.columns) or "no force"
        return f"{tests}, with {forces}: {self.configuration.summary()}."

    def to_dict(self) -> dict[str, Any]:
        return {
            "tests": list(self.names), "conditions": list(self.conditions), "starts": self.starts,
            "columns": dict(self.columns), "units": self.units, "configuration": self.configuration.to_dict(),
            "summary": self.summary(), "notes": list(self.notes),
        }  # fmt: skip

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the rows as a table in the documented columns, SI and radians, which ``read_captive`` reads again."""
        import pandas as pd

        lengths = np.diff(self.starts)
        labels = {"condition": np.repeat(self.conditions, lengths)} if self.conditions else {}
        columns = {name: column for name, column in self.columns.items() if not _is_part(name, self.columns)}
        return pd.DataFrame({"test": np.repeat(self.names, lengths), **labels, **columns})

    def to_csv(self, path: str | Path | None = None, **options: Any) -> str | None:
        """Write the rows as CSV, with ship and canal as columns, so that ``read_captive`` reads it without a ship.

        ``options`` are those of pandas; without a ``path`` it is returned as text. Raises an InputError if the file
        cannot be written.
        """
        sizes = {name: value for name, value in self.configuration.values().items() if name in PARTICULARS}
        table = self.to_dataframe().assign(ship=self.ship.name)
        table = table.assign(**{name: size for name, size in sizes.items() if name not in table})
        return given_or_written(csv_of(table, **options), path)

    def __len__(self) -> int:
        return len(self.names)

    def __iter__(self) -> "Iterator[CaptiveTests]":
        return (self[place] for place in range(len(self)))

    def __contains__(self, name: object) -> bool:
        return name in self.columns or name in self.names

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        """Refuse conversion to an array: pandas and NumPy would make one of the tests."""
        raise TypeError("tests are several tables; take their rows by tests.to_dataframe(), a column by tests['y']")

    def __getitem__(self, key: Any) -> Any:
        """Return a column by name, a table of several, a test by name or number, a slice of tests, or masked rows."""
        if isinstance(key, int | np.integer | slice) and not isinstance(key, bool):
            chosen = np.arange(len(self.names))[key]
            return self.where(np.isin(np.arange(len(self.names)), chosen))
        if isinstance(key, list) and key and {*map(str, key)} <= {*self.columns, *LABELS}:
            return self.to_dataframe()[key]
        if not isinstance(key, str):
            return self.of_rows(key)
        if key not in self:
            key = name_here(key, "attributes", self.columns.__contains__) or key
        if key in LABELS:
            return self.to_dataframe()[key].to_numpy() if key in self.to_dataframe() else ()
        if key in self.columns:
            return self.columns[key]
        if key not in self.names:
            hint = did_you_mean(key, (*self.columns, *self.names))
            raise InputError(f"there is no column and no test {key!r}{hint}")
        return self.where([name == key for name in self.names])

    def of_rows(self, keep: Any) -> "CaptiveTests":
        """Return the rows that ``keep`` marks, (rows,) of bool; tests without rows are left out.

        Raises an InputError if the mask has the wrong length, or no row is kept.
        """
        mask = np.asarray(keep)
        if mask.dtype != bool or mask.shape != (self.rows,):
            raise InputError(
                f"rows are chosen by {self.rows} times True or False, one a row; for one test write "
                f"tests[{self.names[0]!r}]"
            )
        left = np.add.reduceat(mask, self.starts[:-1], dtype=int)
        if not left.any():
            raise InputError("no row is left after the selection; widen it")
        kept = left > 0
        return replace(
            self,
            columns={name: column[mask] for name, column in self.columns.items()},
            names=tuple(compress(self.names, kept)),
            starts=np.concatenate([[0], np.cumsum(left[kept])]),
            conditions=tuple(compress(self.conditions, kept)),
        )

    @accept_aliases
    def query(self, where: str = "", **columns: Any) -> "CaptiveTests":
        """Return the rows for which ``where`` holds, as in ``"abs(y) < 0.5 and psi > 0"``; SI and radians.

        Or those in which ``columns`` have a value, are in a range, as in ``u=(0.3, 0.6)``, or among three or more
        values; ``kind="pure yaw"``: tests whose kind of motion has these words.

        Raises an InputError if the expression is invalid, or no row is left.
        """
        if "cutoff" in columns:
            return self.lowpass(columns.pop("cutoff")).query(where, **columns)
        if "kind" in columns:
            asked = {*re.findall(r"[a-z]+", str(columns.pop("kind")).lower())} - OF_ALL_KINDS
            of_kind = [asked <= {*kind.split()} for kind in self.kinds]
            if not any(of_kind):
                raise InputError(f"no test is of that kind; these are: {', '.join(dict.fromkeys(self.kinds))}")
            return self.where(of_kind).query(where, **columns)
        if not where and not columns:
            return self
        if columns:
            kept = [
                (self[name] >= of[0]) & (self[name] <= of[1]) if np.size(of) == 2 else np.isin(self[name], of)
                for name, of in columns.items()
            ]
            return self.of_rows(np.all(kept, axis=0)).query(where)
        frame, known = self.to_dataframe(), {name: Quantity(unit, "") for name, unit in self.units.items() if unit}
        return self.of_rows(selection(where, frame, frame, known, "the tests"))

    def lowpass(self, cutoff: float) -> "CaptiveTests":
        """Return the tests with forces that vary more slowly than a ``cutoff`` [Hz], by a filter without delay.

        It is a Butterworth filter of order 4, forward and backward; a test that is sampled too slowly for frequencies
        above the cutoff stays as it is. Raises an InputError if the cutoff is not positive, or times are unknown.
        """
        from scipy.signal import butter, sosfiltfilt

        if not cutoff > 0:
            raise InputError(f"cutoff = {shown(cutoff)} is no frequency; give hertz over 0")
        t, forces = self.columns.get("t"), {name: self[name].copy() for name in FORCES if name in self.columns}
        if t is None and "x" not in self.columns:
            raise InputError("these tests have no times; give a column t [s] or x [m]")
        for rows in (slice(*ends) for ends in pairwise(self.starts)):
            steps = np.diff(self["x"][rows]) / self["u"][rows][1:] if t is None else np.diff(t[rows])
            if len(steps) > PADDED and (share := 2 * cutoff * float(np.median(np.abs(steps)))) < 1:
                for column in forces.values():
                    column[rows] = sosfiltfilt(butter(4, share, output="sos"), column[rows])
        note = f"Forces are filtered: nothing faster than {cutoff:g} Hz."
        return replace(self, columns={**self.columns, **forces}, notes=(*self.notes, note))

    def test(self, name: str) -> dict[str, np.ndarray]:
        """Return the columns of one test by its ``name``; an InputError if there is no such test."""
        if name not in self.names:
            raise InputError(f"no test is called {name!r}{did_you_mean(name, self.names)}")
        return self.rows_of(self.names.index(name))

    def where(self, keep: list[bool] | np.ndarray) -> "CaptiveTests":
        """Return the tests that ``keep`` marks, (tests,) of bool; an InputError if none is kept."""
        kept = np.asarray(keep, dtype=bool)
        if not kept.any():
            raise InputError("no test is left after the selection; widen it")
        return self.of_rows(np.repeat(kept, np.diff(self.starts)))

    def drop(self, *names: str) -> "CaptiveTests":
        """Return all tests but those of some ``names``; an InputError if one is unknown, or none is left."""
        for name in names:
            check_choice("test", name, self.names)
        return self.where([name not in names for name in self.names])

    def by_condition(self) -> dict[str, "CaptiveTests"]:
        """Split the tests by condition, each with its own water depth."""
        labels, conditions = dict.fromkeys(self.conditions or ("",)), np.array(self.conditions)
        parts = {label: self.where(conditions == label) if len(labels) > 1 else self for label in labels}
        return {label: part._with_own_depth() for label, part in parts.items()}

    def _with_own_depth(self) -> "CaptiveTests":
        depth = self.columns.get("depth")
        if depth is None or np.ptp(depth) > 0:
            return self
        canal = replace(self.configuration.canal, depth=float(depth[0]))
        return replace(self, configuration=replace(self.configuration, canal=canal, depths={}))

    def blocks(self, pieces: int = 1) -> Iterator[Block]:
        """Yield every row once, in blocks; ``pieces`` is the number of consecutive stretches of each test."""
        pieces_of_tests = [
            (test, piece, int(a), int(b))
            for test, start, stop in zip(self.names, self.starts, self.starts[1:], strict=False)
            for piece, (a, b) in enumerate(pairwise(start + cuts(stop - start, pieces)))
        ]
        particulars = self.configuration.values()
        for start in range(0, self.rows, BLOCK_ROWS):
            stop = min(start + BLOCK_ROWS, self.rows)
            spans = [
                Span(test, piece, max(a, start) - start, min(b, stop) - start)
                for test, piece, a, b in pieces_of_tests
                if a < stop and b > start
            ]
            columns = {name: column[start:stop] for name, column in self.columns.items()}
            yield Block({**particulars, **columns}, stop - start, spans, self.headers)

    def force_rows(self: Any, terms: TermTable, values: Mapping[str, float], measured: bool = False) -> "pd.DataFrame":
        """Return the forces of each row by ``terms`` with coefficients ``values``, or what was ``measured`` beyond.

        Raises an InputError if a column is missing.
        """
        import pandas as pd

        frames = []
        for block in self.blocks(1):
            check_given(terms.inputs, block.values, block.headers, terms.actuators)
            names = np.repeat([span.test for span in block.spans], [span.stop - span.start for span in block.spans])
            rows = {"test": names} | {name: block.values[name] for name in ("t",) if name in block.values}
            for force, own in terms.forces.items():
                if own:
                    parts = (values[term.name] * term.column(block.values) for term in own)
                    estimated = np.broadcast_to(sum(parts, np.zeros(block.rows)), block.rows)
                    rows[force] = block.values[force] - estimated if measured else estimated
            frames.append(pd.DataFrame(rows))
        frame = pd.concat(frames)
        return frame.set_index([name for name in ("test", "t") if name in frame])

    def rows_of(self, i: int) -> dict[str, np.ndarray]:
        """Return the columns of one test by its index ``i`` in ``names``."""
        rows = slice(int(self.starts[i]), int(self.starts[i + 1]))
        return {name: column[rows] for name, column in self.columns.items()}


def _kind(test: Mapping[str, np.ndarray], length: float) -> str:
    speed = max(float(np.hypot(test["u"], test["v"]).mean()), 1e-9)
    over = {"sway": test["v"] / speed, "yaw": test["r"] * length / speed}
    moving = [word for word, motion in over.items() if motion.std() > LEAST_MOTION]
    drifts = abs(over["sway"].mean()) > LEAST_MOTION
    if not moving and abs(over["yaw"].mean()) < LEAST_MOTION:
        return "drift" if drifts else "straight"
    kind = " and ".join(moving) if len(moving) > 1 else f"pure {moving[0]}" if moving else "turn"
    return f"{kind.removeprefix('pure ')} with drift" if drifts else kind


def _is_part(name: str, columns: Mapping[str, np.ndarray]) -> bool:
    return name.startswith(("cos_", "sin_")) and name[4:] in columns


def selection(
    where: str, raw: "pd.DataFrame", frame: "pd.DataFrame", known: Mapping[str, Quantity], table: str
) -> np.ndarray:
    """Return the rows for which an expression holds, on raw headers or on the documented names of the same rows."""
    import pandas as pd

    headers = [str(header) for header in raw.columns]
    words = set(re.findall(r"[^\W\d]\w*", where)) - set(headers)
    named: Any = {word: frame[word] for word in words & set(LABELS) & set(frame.columns)}
    try:
        columns = {column.quantity: column for header in frame if (column := parse_header(str(header), known))}
        for word in words:  # ``psi`` in SI, ``psi_deg`` in degrees
            if (asked := parse_header(word, known)) and (column := columns.get(asked.quantity)):
                named[word] = floats(frame[column.header]) * (column.scale / asked.scale)
        chosen: Any = raw.eval(where, engine="python", resolvers=(named,), local_dict={}, global_dict={})
        if not pd.api.types.is_bool_dtype(chosen) or np.shape(chosen) != (len(frame),):
            raise TypeError("it is not true or false for each row")
    except InputError as error:
        raise InputError(str(error) if str(error).startswith(table) else f"{table}: {error}") from None
    except Exception as error:  # pandas raises many kinds of errors on invalid expressions
        near = ""
        if isinstance(error, pd.errors.UndefinedVariableError):
            near = near_miss(str(error).split("'")[1], [*headers, *known]) or f"; it has {', '.join(headers[:20])}"
        raise InputError(
            f"{table}: cannot select rows where {shown(where)} ({reason(error)}{near}); use names as u, psi_deg, or "
            "the table's headers, those with blanks as `Heading [deg]`"
        ) from None
    return np.asarray(chosen, dtype=bool)
