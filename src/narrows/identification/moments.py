"""One pass over the rows: the sums of products of every column with every other, test by test.

Everything that identification says (fit, standard errors, left-out errors, rank, VIF, Shapley shares) follows
from these sums, so its cost after the pass, and its memory, do not grow with the rows.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from narrows.captive.tests import Block, Tests
from narrows.errors import InputError
from narrows.model.model import DataRange, Range
from narrows.quantities.names import FORCES, Number
from narrows.terms.term import TermTable

ONE = "1"
SPEED_GAP = 1.15
"""Tests whose speeds differ by less than this factor count as one speed."""
STRIP_ROWS = 3000
PARTS, PART_ROWS = 8, 12_000


@dataclass(frozen=True)
class Moments:
    """Sums of products over the rows of each piece of each test.

    Parameters
    ----------
    columns : mapping of str to int
        Which column of the sums is which coefficient's regressor, force, or the constant ``1``; coefficients
        with the same regressor share one.
    sums : array (pieces, m, m)
        Products of columns, summed over rows.
    tests : tuple of str
        The test of each piece.
    speeds : array (pieces,) [m/s]
        Mean surge velocity of each piece.
    """

    columns: Mapping[str, int]
    sums: np.ndarray
    tests: tuple[str, ...]
    speeds: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """The sums over all rows, (m, m)."""
        return np.asarray(self.sums.sum(axis=0))

    @property
    def names(self) -> tuple[str, ...]:
        """The tests, once each."""
        return tuple(dict.fromkeys(self.tests))

    @property
    def speed_groups(self) -> list[np.ndarray]:
        """The pieces of each speed, slowest first."""
        order = np.argsort(np.abs(self.speeds))
        size = np.maximum(np.abs(self.speeds[order]), 1e-9)
        return np.split(order, np.flatnonzero(size[1:] > SPEED_GAP * size[:-1]) + 1)

    def of_test(self, name: str) -> np.ndarray:
        """Return the sums over one test, (m, m).

        Parameters
        ----------
        name : str
            The test.
        """
        return np.asarray(self.sums[[own == name for own in self.tests]].sum(axis=0))

    def by_test(self) -> np.ndarray:
        """Return the sums over each test, (tests, m, m)."""
        return np.stack([self.of_test(name) for name in self.names])

    def pick(self, sums: np.ndarray, rows: list[str], columns: list[str] | None = None) -> np.ndarray:
        """Return the sums of some columns.

        Parameters
        ----------
        sums : array (..., m, m)
            Of this object.
        rows, columns : list of str
            Coefficients, forces or ``1``; the columns are the rows where left out.
        """
        i = [self.columns[name] for name in rows]
        j = [self.columns[name] for name in columns] if columns else i
        return sums[..., np.array(i)[:, None], np.array(j)[None, :]]


def count(sums: np.ndarray, columns: Mapping[str, int]) -> int:
    """Return the number of rows behind some sums (ours).

    Parameters
    ----------
    sums : array (m, m)
        Of a Moments.
    columns : mapping of str to int
        Its columns.
    """
    return round(float(sums[columns[ONE], columns[ONE]]))


class Layout:
    """Which column of the design holds which regressor; built once a table of terms.

    Parameters
    ----------
    terms : TermTable
        The terms.
    """

    def __init__(self, terms: TermTable) -> None:
        self.regressors: list[tuple[Callable[..., Number], tuple[str, ...]]] = []
        self.columns: dict[str, int] = {}
        for term in terms.terms:
            entry = (term.regressor, term.inputs)
            if entry not in self.regressors:
                self.regressors.append(entry)
            self.columns[term.name] = self.regressors.index(entry)
        self.forces = [force for force in FORCES if terms.forces[force]]
        for name in (*self.forces, ONE):
            self.columns[name] = len(self.regressors) + len(self.columns) - len(terms.terms)
        self.inputs = terms.inputs
        self._buffer = np.empty((self.size, 0))

    @property
    def size(self) -> int:
        """Number of columns."""
        return len(self.regressors) + len(self.forces) + 1

    def design(self, block: Block) -> np.ndarray:
        """Evaluate every column on a block of rows, (m, rows), into memory that the next block overwrites.

        Parameters
        ----------
        block : Block
            The rows.

        Raises
        ------
        InputError
            Where a term needs what neither the table nor the ship file gives.
        """
        for name in (*self.inputs, *self.forces):
            if name not in block.values:
                raise InputError(f"the terms need {name}, which neither the tests nor the ship file give; add it")
        design = self._buffer[:, : block.rows]
        if design.shape[1] < block.rows:
            design = self._buffer = np.empty((self.size, block.rows))
        for i, (regressor, inputs) in enumerate(self.regressors):
            design[i] = regressor(*[block.values[name] for name in inputs])
        for i, force in enumerate(self.forces, start=len(self.regressors)):
            design[i] = block.values[force]
        design[-1] = 1.0
        return design


def products(design: np.ndarray) -> np.ndarray:
    """Return ``design @ design.T``, (m, m), in strips that stay in the cache (ours).

    Long designs are cut into a fixed number of parts for the cores to share and summed in order, so that the
    result does not depend on how many cores there are.

    Parameters
    ----------
    design : array (m, rows)
        Columns, one a row.
    """
    if design.shape[1] < PARTS * PART_ROWS:
        return _products(design)
    with ThreadPoolExecutor() as pool:
        return np.asarray(sum(pool.map(_products, np.array_split(design, PARTS, axis=1))))


def _products(design: np.ndarray) -> np.ndarray:
    # A copy as the second factor makes BLAS take its general product, which for a few columns and many rows is
    # twice as fast as the symmetric one that it takes where both factors are the same memory.
    total = np.zeros((len(design), len(design)))
    strip = np.empty((len(design), min(STRIP_ROWS, design.shape[1])))
    with np.errstate(all="ignore"):
        for start in range(0, design.shape[1], STRIP_ROWS):
            part = design[:, start : start + STRIP_ROWS]
            copy = strip[:, : part.shape[1]]
            np.copyto(copy, part)
            total += np.dot(part, copy.T)
    return total


def accumulate(tests: Tests, terms: TermTable, pieces: int = 1) -> tuple[Moments, DataRange]:
    """Sum over every row, once.

    Parameters
    ----------
    tests : CaptiveTests or StreamedTests
        The rows.
    terms : TermTable
        The columns.
    pieces : int
        Into how many stretches each test is cut.

    Returns
    -------
    Moments, DataRange
        The sums, and the ranges that the rows cover.

    Raises
    ------
    InputError
        Where there are no rows, or a column is not finite.
    """
    layout = Layout(terms)
    sums: dict[tuple[str, int], np.ndarray] = defaultdict(lambda: np.zeros((layout.size, layout.size)))
    way: dict[tuple[str, int], float] = defaultdict(float)
    data_range = DataRange()
    for block in tests.blocks(pieces):
        design = layout.design(block)
        speed = np.broadcast_to(block.values.get("u", 0.0), block.rows)
        for test, piece, start, stop in block.spans:
            sums[test, piece] += products(design[:, start:stop])
            way[test, piece] += float(speed[start:stop].sum())
        data_range = _joined(data_range, _covered(block))
    if not sums:
        place = tests.source.table or tests.source.text
        raise InputError(f"{place}: no rows are left; give more, or another selection")
    speeds = [way[key] / total[-1, -1] for key, total in sums.items()]
    stacked = np.stack(list(sums.values()))
    moments = Moments(layout.columns, stacked, tuple(test for test, _ in sums), np.array(speeds))
    _check_finite(moments)
    return moments, data_range


def _check_finite(moments: Moments) -> None:
    for name, i in moments.columns.items():
        wrong = ~np.isfinite(moments.sums[:, i, i])
        if wrong.any():
            test = moments.tests[int(np.argmax(wrong))]
            raise InputError(f"the column of {name} is not finite in test {test}; mend its regressor or leave rows out")


def design_rows(tests: Tests, terms: TermTable) -> Iterator[tuple[Layout, np.ndarray]]:
    """Yield the columns themselves, block by block, for what sums of products cannot say (ours).

    Parameters
    ----------
    tests : CaptiveTests or StreamedTests
        The rows.
    terms : TermTable
        The columns.
    """
    layout = Layout(terms)
    for block in tests.blocks(1):
        yield layout, layout.design(block)


def _covered(block: Block) -> DataRange:
    values = block.values
    ratio = np.divide(values["depth"], values["draft"]) if "depth" in values else None
    wide = np.divide(values["width"], values["beam"])
    return DataRange(
        speed=_range(values.get("u")),
        abs_y=_range(_size(values.get("y"))),
        abs_psi=_range(_size(values.get("psi"))),
        abs_r=_range(_size(values.get("r"))),
        depth_to_draft=_range(ratio),
        width_to_beam=_range(wide),
    )


def _size(column: Number | None) -> Number | None:
    return None if column is None else np.abs(column)


def _range(column: Number | None) -> Range | None:
    return None if column is None else (float(np.min(column)), float(np.max(column)))


def _joined(one: DataRange, other: DataRange) -> DataRange:
    ranges = {}
    for name in DataRange.__annotations__:
        known = [pair for pair in (getattr(one, name), getattr(other, name)) if pair is not None]
        ranges[name] = (min(p[0] for p in known), max(p[1] for p in known)) if known else None
    return DataRange(**ranges)
