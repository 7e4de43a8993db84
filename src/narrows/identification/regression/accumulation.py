"""One pass over the rows: blocks of the design matrix to sums of products, and the ranges that the rows cover."""

import os
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import islice

import numpy as np

from narrows.captive.tests import Block, Span, Tests
from narrows.errors import InputError
from narrows.identification.regression.design_matrix import DesignMatrix
from narrows.identification.regression.effect_columns import EffectDesign
from narrows.identification.regression.normal_equations import Balance, NormalEquations
from narrows.model.data_range import DataRange, Range
from narrows.quantities.names import Number
from narrows.terms.term import TermTable

PARTS, PART_ROWS = 8, 12_000
# Products at once: a strip in the cache, and too few for BLAS to share among threads of its own, which for products as
# small as these costs many times what it gains and fights with ours.
STRIP = 2**19
# Rows of a span, on average, below which spans are summed together, and how many at once.
SHORT, TOGETHER = 32, 100
# Blocks that are in memory at once.
AHEAD = 16
# Features of a test that define its motion and its water.
MOVED = ("u", "v", "r", "y", "sin_psi", "udot", "vdot", "rdot", "depth", "draft", "width", "rudder")
# Quantities of terms that follow from the others.
NOT_SET = ("x", "cos_psi", "heave")


def products(design: np.ndarray) -> np.ndarray:
    """Return ``design @ design.T``, (m, m), in strips that stay in the cache."""
    # design (m, rows)
    # Long designs are cut into a fixed number of parts for the cores to share and summed in order, so that the result
    # does not depend on how many cores there are.
    if design.shape[1] < PARTS * PART_ROWS:
        return _products(design)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return np.asarray(sum(pool.map(_products, np.array_split(design, PARTS, axis=1))))


def _products(design: np.ndarray) -> np.ndarray:
    total = np.zeros((len(design), len(design)))
    strip = max(STRIP // len(design) ** 2, 1)
    with np.errstate(all="ignore"):
        for start in range(0, design.shape[1], strip):
            part = design[:, start : start + strip]
            total += np.dot(part, part.T)
    return total


def accumulate(
    tests: Tests, terms: TermTable, pieces: int = 1, balance: Balance = "rows"
) -> tuple[NormalEquations, DataRange]:
    """Sum over every row, once."""
    matrix = EffectDesign(terms)
    sums: dict[tuple[str, int], np.ndarray] = defaultdict(lambda: np.zeros((matrix.size, matrix.size)))
    moved: dict[tuple[str, int], dict[str, np.ndarray]] = defaultdict(lambda: defaultdict(lambda: np.zeros(3)))
    data_range = DataRange()
    for parts, covered in _shared_out(partial(_summed, matrix, _saying(terms)), tests.blocks(pieces)):
        for key, total, moments in parts:
            sums[key] += total
            for name, moment in moments.items():
                moved[key][name] += moment
        data_range = _joined(data_range, covered)
    if not sums:
        source = tests.source.table or tests.source.text
        raise InputError(f"{source}: no rows are left; give more, or another selection")
    named = dict.fromkeys(name for moments in moved.values() for name in moments)
    equations = NormalEquations(
        matrix.columns,
        np.stack(list(sums.values())),
        tuple(test for test, _ in sums),
        {name: np.stack([moved[key][name] for key in sums]) for name in named},
        tests.configuration.ship.length,
    )
    _check_finite(equations)
    return equations.balanced() if balance == "tests" else equations, data_range


Sums = tuple[list[dict[str, np.ndarray]], list[np.ndarray]]
Summed = tuple[list[tuple[tuple[str, int], np.ndarray, dict[str, np.ndarray]]], DataRange]


def _saying(terms: TermTable) -> tuple[str, ...]:
    """Return what says of a test what is done in it: the motion, and what else the terms ask for that is set."""
    return tuple(dict.fromkeys((*MOVED, *(name for name in terms.inputs if name not in NOT_SET))))


def _summed(matrix: DesignMatrix, saying: tuple[str, ...], block: Block) -> Summed:
    """The sums over each span of a block, with its test and piece and the moments of what moved; and the ranges."""
    design = matrix.evaluate(block)
    columns = {name: block.values[name] for name in saying if np.ndim(block.values.get(name, 0.0))}
    keys = [(span.test, span.piece) for span in block.spans]
    short = block.rows < SHORT * len(keys)
    moments, sums = (_of_short if short else _of_long)(columns, design, block.spans)
    return list(zip(keys, sums, moments, strict=True)), _covered(block)


def _of_long(columns: Mapping[str, np.ndarray], design: np.ndarray, spans: list[Span]) -> Sums:
    """Moments and products span by span."""
    rows = [slice(span.start, span.stop) for span in spans]
    moments = [{name: _moments(column[span]) for name, column in columns.items()} for span in rows]
    return moments, [_products(design[:, span]) for span in rows]


def _moments(column: np.ndarray) -> np.ndarray:
    """Rows, sum and sum of squares; not by BLAS, which wakes threads of its own for columns as long as these."""
    return np.array([len(column), column.sum(), np.einsum("i,i", column, column)])


def _of_short(columns: Mapping[str, np.ndarray], design: np.ndarray, spans: list[Span]) -> Sums:
    """Moments and products of many spans of few rows, a call for a hundred of them instead of one each."""
    moments: list[dict[str, np.ndarray]] = []
    sums: list[np.ndarray] = []
    for first in range(0, len(spans), TOGETHER):
        some = spans[first : first + TOGETHER]
        rows = slice(some[0].start, some[-1].stop)
        starts = [span.start - some[0].start for span in some]
        part = design[:, rows]
        with np.errstate(all="ignore"):
            sums += list(np.moveaxis(np.add.reduceat(part[:, None] * part[None], starts, axis=2), 2, 0))
        powers = {name: np.stack([np.ones(len(c[rows])), c[rows], c[rows] ** 2]) for name, c in columns.items()}
        added = {name: np.add.reduceat(values, starts, axis=1).T for name, values in powers.items()}
        moments += [{name: each[i] for name, each in added.items()} for i in range(len(some))]
    return moments, sums


def _shared_out(work: Callable[[Block], Summed], blocks: Iterator[Block]) -> Iterator[Summed]:
    """Let the cores share the blocks, a few at a time, and yield what comes of each in order."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        while some := list(islice(blocks, AHEAD)):
            # A thread for one block would cost more than it gives.
            yield from pool.map(work, some) if len(some) > 1 else map(work, some)


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
