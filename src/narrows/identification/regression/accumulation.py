"""One pass over the rows: blocks of the design matrix to sums of products, and the ranges that the rows cover."""

from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from narrows.captive.tests import Block, Tests
from narrows.errors import InputError
from narrows.identification.regression.design_matrix import DesignMatrix
from narrows.identification.regression.normal_equations import NormalEquations
from narrows.model.data_range import DataRange, Range
from narrows.quantities.names import Number
from narrows.terms.term import TermTable

STRIP_ROWS = 3000
PARTS, PART_ROWS = 8, 12_000


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


def accumulate(tests: Tests, terms: TermTable, pieces: int = 1) -> tuple[NormalEquations, DataRange]:
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
    NormalEquations, DataRange
        The sums, and the ranges that the rows cover.

    Raises
    ------
    InputError
        Where there are no rows, or a column is not finite.
    """
    matrix = DesignMatrix(terms)
    sums: dict[tuple[str, int], np.ndarray] = defaultdict(lambda: np.zeros((matrix.size, matrix.size)))
    way: dict[tuple[str, int], float] = defaultdict(float)
    data_range = DataRange()
    for block in tests.blocks(pieces):
        design = matrix.evaluate(block)
        speed = np.broadcast_to(block.values.get("u", 0.0), block.rows)
        for test, piece, start, stop in block.spans:
            sums[test, piece] += products(design[:, start:stop])
            way[test, piece] += float(speed[start:stop].sum())
        data_range = _joined(data_range, _covered(block))
    if not sums:
        source = tests.source.table or tests.source.text
        raise InputError(f"{source}: no rows are left; give more, or another selection")
    speeds = [way[key] / total[-1, -1] for key, total in sums.items()]
    stacked = np.stack(list(sums.values()))
    equations = NormalEquations(matrix.columns, stacked, tuple(test for test, _ in sums), np.array(speeds))
    _check_finite(equations)
    return equations, data_range


def _check_finite(equations: NormalEquations) -> None:
    for name, i in equations.columns.items():
        wrong = ~np.isfinite(equations.sums[:, i, i])
        if wrong.any():
            test = equations.tests[int(np.argmax(wrong))]
            raise InputError(f"the column of {name} is not finite in test {test}; mend its regressor or leave rows out")


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
