"""One pass over the rows: blocks of the design matrix to sums of products, and the ranges that the rows cover."""

import os
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import islice

import numpy as np

from narrows.captive.tests import Block, Tests
from narrows.errors import InputError
from narrows.identification.design_matrix import DesignMatrix
from narrows.identification.normal_equations import Balance, NormalEquations
from narrows.model.data_range import DataRange, Range
from narrows.quantities.names import Number
from narrows.terms.term import TermTable

# Products computed at once: a strip fits the cache, and is too small for BLAS to start threads of its own, which would
# slow such small products and compete with those of the package.
STRIP = 2**19
# Blocks that are in memory at once.
AHEAD = 16
# Features of a test that define its motion and its water.
MOVED = ("u", "v", "r", "y", "sin_psi", "udot", "vdot", "rdot", "depth", "draft", "width", "rudder")
# Quantities of terms that follow from the others.
NOT_SET = ("x", "cos_psi", "heave")

# The quantities that vary in a block; test and piece, products and moments of each span; the ranges of all rows.
Summed = tuple[list[str], list[tuple[tuple[str, int], np.ndarray, np.ndarray]], dict[str, Range]]


def accumulate(
    tests: Tests, terms: TermTable, pieces: int = 1, balance: Balance = "rows"
) -> tuple[NormalEquations, DataRange]:
    """Sum over every row, once."""
    matrix = DesignMatrix(terms)
    # The motion, and further set quantities that the terms need.
    quantities = tuple(dict.fromkeys((*MOVED, *(name for name in terms.inputs if name not in NOT_SET))))
    sums: dict[tuple[str, int], np.ndarray] = {}
    moments: dict[tuple[str, int], np.ndarray] = {}
    ranges: dict[str, Range] = {}
    moved: list[str] = []
    for columns, parts, covered in _shared_out(partial(_summed, matrix, quantities), tests.blocks(pieces)):
        moved = columns
        for key, own, moment in parts:
            sums[key], moments[key] = sums.get(key, 0.0) + own, moments.get(key, 0.0) + moment
        ranges |= {name: _joined(pair, ranges.get(name, pair)) for name, pair in covered.items()}
    if not sums:
        source = tests.source.table or tests.source.text
        raise InputError(f"{source}: no rows are left; give more, or another selection")
    equations = NormalEquations(
        matrix.columns,
        np.stack(list(sums.values())),
        tuple(test for test, _ in sums),
        dict(zip(moved, np.stack(list(moments.values()), axis=1), strict=True)),
        tests.configuration.ship.length,
    )
    _check_finite(equations)
    return equations.balanced() if balance == "tests" else equations, DataRange(**ranges)


def products(design: np.ndarray) -> np.ndarray:
    """Return ``design @ design.T`` of a design (m, rows), in strips that stay in the cache."""
    total = np.zeros((len(design), len(design)))
    strip = max(STRIP // len(design) ** 2, 1)
    with np.errstate(all="ignore"):
        for start in range(0, design.shape[1], strip):
            part = design[:, start : start + strip]
            total += np.dot(part, part.T)
    return total


def _summed(matrix: DesignMatrix, quantities: tuple[str, ...], block: Block) -> Summed:
    design = matrix.evaluate(block)
    moved = [name for name in quantities if np.ndim(block.values.get(name, 0.0))]
    columns = np.array([block.values[name] for name in moved])
    # Rows, sum and sum of squares of each quantity in each span: (spans, quantities, 3).
    powers = np.stack([np.ones_like(columns), columns, columns**2], axis=1)
    moments = np.moveaxis(np.add.reduceat(powers, [span.start for span in block.spans], axis=2), 2, 0)
    sums = [products(design[:, span.start : span.stop]) for span in block.spans]
    keys = [(span.test, span.piece) for span in block.spans]
    return moved, list(zip(keys, sums, moments, strict=True)), _covered(block.values)


def _shared_out(work: partial[Summed], blocks: Iterator[Block]) -> Iterator[Summed]:
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


def _covered(values: Mapping[str, Number]) -> dict[str, Range]:
    columns = {f"abs_{name}": np.abs(values[name]) for name in ("y", "psi", "r") if name in values}
    columns["width_to_beam"] = np.divide(values["width"], values["beam"])
    if "u" in values:
        columns["speed"] = np.asarray(values["u"])
    if "depth" in values:
        columns["depth_to_draft"] = np.divide(values["depth"], values["draft"])
    return {name: (float(np.min(column)), float(np.max(column))) for name, column in columns.items()}


def _joined(one: Range, other: Range) -> Range:
    return min(one[0], other[0]), max(one[1], other[1])
