"""The design matrix, and sums of products of its columns, test by test: all that the fit needs of the rows.

Its columns are the regressors of the terms, the forces, the constant, then what systematic errors need: ``"heading of
b_v"`` is the derivative of the regressor of b_v to the heading.
"""

import os
import threading
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import islice
from operator import itemgetter
from typing import Any, Literal, NamedTuple

import numpy as np

from narrows.base.errors import InputError
from narrows.base.named_values import Named
from narrows.captive.columns import check_given
from narrows.captive.read import Tests
from narrows.captive.tests import Block
from narrows.model.data_range import DataRange
from narrows.model.term import Term, TermTable, uncompiled
from narrows.quantities.names import FORCES, Number

# Units of equal weight in a fit.
Balance = Literal["tests", "rows"]
# Products computed at once: a strip fits the cache, and is too small for BLAS to start threads of its own, which would
# slow such small products and compete with those of the package.
STRIP = 2**19
AHEAD = 16  # Blocks that are in memory at once
# Features of a test that define its motion and its water.
MOVED = ("u", "v", "r", "y", "sin_psi", "udot", "vdot", "rdot", "depth", "draft", "width", "rudder")
NOT_SET = ("x", "cos_psi", "heave")  # Quantities of terms that follow from the others
Values = dict[Any, Number]  # Quantities of a block by name, and the columns so far by key
Column = Callable[[Values], Number]
NamedColumn = tuple[str, Any, Column]  # The key is that of its function: equal ones are one column
# Name of the column of ones.
ONE = "1"
STEP = 1e-4  # Step of the central differences [rad, m, s]
DEFAULTS = dict.fromkeys(("y", "u", "v", "r", "udot", "vdot", "rdot", "sin_psi", "N"), 0.0) | {"cos_psi": 1.0}
MOTION_COLUMNS: dict[str, Column] = {
    "y": lambda q: q["y"],
    "y u": lambda q: q["y"] * q["u"],
    "y u2": lambda q: q["y"] * q["u"] ** 2,
    "y2 u2": lambda q: abs(q["y"]) * q["y"] * q["u"] ** 2,
    "u2": lambda q: q["u"] ** 2,
    "v": lambda q: q["v"],
    "r": lambda q: q["r"],
    "v3": lambda q: q["v"] ** 3,
    "r3": lambda q: q["r"] ** 3,
    "|r|v": lambda q: abs(q["r"]) * q["v"],
    "|v|r": lambda q: abs(q["v"]) * q["r"],
    "v y2": lambda q: q["v"] * q["u"] * q["y"] ** 2,
    "r y2": lambda q: q["r"] * q["u"] * q["y"] ** 2,
}
# Other forms of the bank: each multiplies the column of a bank's term.
FORM_COLUMNS: dict[str, Column] = {
    "near": lambda q: q["y"] ** 2,
    "wall": lambda q: q["y"] ** 6,
    "far": lambda q: np.sqrt(abs(q["y"])),
    "side": lambda q: np.sign(q["y"]),
}


class DesignMatrix:
    """Columns of the design by name; columns that are the same function share one place."""

    def __init__(self, terms: TermTable, effects: bool = True) -> None:
        self.terms, self.forces = terms, [force for force in FORCES if terms.forces[force]]
        columns = [*_fitted_columns(terms, self.forces), *(_effect_columns(terms, self.forces) if effects else ())]
        self._functions: dict[Any, Column] = {}
        for _, key, column in columns:
            self._functions.setdefault(key, column)
        places = {key: i for i, key in enumerate(self._functions)}
        self.columns = {name: places[key] for name, key, _ in columns}
        self._memory = threading.local()

    def evaluate(self, block: Block) -> np.ndarray:
        """Evaluate every column on a block of rows, (m, rows), into memory that the thread's next block overwrites."""
        check_given((*self.terms.inputs, *self.forces), block.values, block.headers, self.terms.actuators)
        whole: np.ndarray = getattr(self._memory, "whole", np.empty((len(self._functions), 0)))
        if whole.shape[1] < block.rows:
            whole = self._memory.whole = np.empty((len(self._functions), block.rows))
        design, q = whole[:, : block.rows], {**DEFAULTS, **block.values}
        for i, (key, column) in enumerate(self._functions.items()):
            design[i] = column(q)
            q.setdefault(key, design[i])
        return design


def _fitted_columns(terms: TermTable, forces: list[str]) -> Iterator[NamedColumn]:
    for term in terms.terms:
        yield term.name, (term.regressor, term.inputs), partial(_evaluated, term)
    for force in forces:
        yield force, force, itemgetter(force)
    yield ONE, ONE, lambda _: 1.0


def _effect_columns(terms: TermTable, forces: list[str]) -> Iterator[NamedColumn]:
    for name, column in MOTION_COLUMNS.items():
        yield f"column {name}", f"column {name}", column
    for term in terms.terms:
        own = (term.regressor, term.inputs)
        kinds: dict[str, Column] = {"time": partial(_derivative, term, _rates)}
        if "v" in term.inputs:
            kinds["heading"] = partial(_derivative, term, lambda q: {"v": q["u"]})
            kinds["heading with y"] = partial(_times, ("heading", own), itemgetter("y"))
            kinds["mount"] = partial(_times, ("heading", own), itemgetter("N"))
        if term.from_bank:
            kinds["rail"] = partial(_derivative, term, lambda _: {"y": 1.0})
            kinds |= {kind: partial(_times, own, form) for kind, form in FORM_COLUMNS.items()}
        for kind, column in kinds.items():
            yield f"{kind} of {term.name}", (kind, own), column
    for force in forces:
        yield f"column |{force}|{force}", f"column |{force}|{force}", partial(_signed_square, force)


def _signed_square(name: str, q: Values) -> Number:
    return abs(q[name]) * q[name]


def _times(own: Any, form: Column, q: Values) -> Number:
    return q[own] * form(q)


def _evaluated(term: Term, q: Values) -> Number:
    try:
        return term.column(q)
    except (TypeError, ValueError) as error:  # The regressor is a function of floats, or has an if.
        raise uncompiled(term, error) from error


def _derivative(term: Term, change: Callable[[Values], dict[str, Number]], q: Values) -> Number:
    rate = {name: value for name, value in change(q).items() if name in term.inputs}
    if not rate:
        return 0.0
    ahead, behind = (
        term.column({**q, **{name: q[name] + s * STEP * value for name, value in rate.items()}}) for s in (1, -1)
    )
    return (ahead - behind) / (2 * STEP)


def _rates(q: Values) -> dict[str, Number]:
    """Rate of each quantity of the motion; that of an acceleration is not known here."""
    return {
        "u": q["udot"],
        "v": q["vdot"],
        "r": q["rdot"],
        "y": q["u"] * q["sin_psi"] + q["v"] * q["cos_psi"],
        "sin_psi": q["cos_psi"] * q["r"],
        "cos_psi": -q["sin_psi"] * q["r"],
    }


@dataclass(frozen=True)
class NormalEquations:
    """Sums of products over the rows of each piece of each test."""

    # Which column of the sums is which coefficient's regressor, force, or the constant ``1``; coefficients with the
    # same regressor share one
    columns: Mapping[str, int]
    unweighted: np.ndarray  # (pieces, m, m) Products of columns, summed over rows
    tests: tuple[str, ...]  # The test of each piece
    # (pieces, 3) Rows, sum and sum of squares of each quantity that describes the motion of a test
    moved: Mapping[str, np.ndarray]
    length: float  # Length of the ship [m]
    balance: Balance = "rows"

    @cached_property
    def sums(self) -> np.ndarray:
        """The sums of rows by their weights, (pieces, m, m): by ``tests`` each test counts alike."""
        if self.balance == "rows":
            return self.unweighted
        one = self.columns[ONE]
        rows = self.by_test(self.unweighted[:, one, one])
        return np.asarray(self.unweighted * (rows.mean() / rows)[self.test][:, None, None])

    @cached_property
    def total(self) -> np.ndarray:
        return np.asarray(self.sums.sum(axis=0))

    @cached_property
    def of_each_test(self) -> np.ndarray:
        """The sums of rows of each test, every row counted once, (tests, m, m)."""
        return self.by_test(self.unweighted)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(self.tests))

    @cached_property
    def test(self) -> np.ndarray:
        """Index of the test of each piece, (pieces,)."""
        position = {name: i for i, name in enumerate(self.names)}
        return np.array([position[name] for name in self.tests])

    def by_test(self, values: np.ndarray) -> np.ndarray:
        """Add up values of pieces, (pieces, ...), over each test: (tests, ...)."""
        sums = np.zeros((len(self.names), *values.shape[1:]))
        np.add.at(sums, self.test, values)
        return sums

    def of_tests(self, names: Collection[str]) -> "NormalEquations":
        keep = np.array([name in names for name in self.tests])
        moved = {name: moments[keep] for name, moments in self.moved.items()}
        tests = tuple(name for name in self.tests if name in names)
        return replace(self, unweighted=self.unweighted[keep], tests=tests, moved=moved)

    def pick(self, sums: np.ndarray, rows: list[str], columns: list[str] | None = None) -> np.ndarray:
        i = [self.columns[name] for name in rows]
        j = [self.columns[name] for name in columns] if columns else i
        return sums[..., np.array(i)[:, None], np.array(j)[None, :]]


def accumulate(
    tests: Tests, terms: TermTable, pieces: int = 1, balance: Balance = "rows"
) -> tuple[NormalEquations, DataRange]:
    matrix = DesignMatrix(terms)
    # The motion, and further set quantities that the terms need.
    quantities = tuple(dict.fromkeys((*MOVED, *(name for name in terms.inputs if name not in NOT_SET))))
    sums, moments, ranges, moved = Counter[Any](), Counter[Any](), dict[str, tuple[float, float]](), list[str]()
    for columns, parts, covered in _shared_out(partial(_summed, matrix, quantities), tests.blocks(pieces)):
        moved = columns
        for key, own, moment in parts:
            sums[key], moments[key] = sums[key] + own, moments[key] + moment
        for name, (low, high) in covered.items():
            least, most = ranges.get(name, (low, high))
            ranges[name] = min(least, low), max(most, high)
    if not sums:
        source = tests.source.table or tests.source.text
        raise InputError(f"{source}: no rows are left; give more, or another selection")
    total, by_quantity = np.stack(list(sums.values())), np.stack(list(moments.values()), axis=1)
    names = tuple(test for test, _ in sums)
    for name, i in matrix.columns.items():
        if (wrong := ~np.isfinite(total[:, i, i])).any():
            test = names[int(np.argmax(wrong))]
            raise InputError(f"the column of {name} is not finite in test {test}; mend its regressor or leave rows out")
    length = tests.configuration.ship.length
    described = dict(zip(moved, by_quantity, strict=True))
    return NormalEquations(matrix.columns, total, names, described, length, balance), DataRange(**ranges)


def products(design: np.ndarray) -> np.ndarray:
    """Return ``design @ design.T`` of a design (m, rows), in strips that stay in the cache."""
    total = np.zeros((len(design), len(design)))
    strip = max(STRIP // len(design) ** 2, 1)
    with np.errstate(all="ignore"):
        for start in range(0, design.shape[1], strip):
            part = design[:, start : start + strip]
            total += np.dot(part, part.T)
    return total


def _summed(matrix: DesignMatrix, quantities: tuple[str, ...], block: Block) -> tuple[list[str], list[Any], Any]:
    """The quantities that vary; test and piece, products and moments of each span; the ranges of all rows."""
    design, values = matrix.evaluate(block), block.values
    moved = [name for name in quantities if np.ndim(values.get(name, 0.0))]
    columns = np.array([values[name] for name in moved])
    # Rows, sum and sum of squares of each quantity in each span: (spans, quantities, 3).
    powers = np.stack([np.ones_like(columns), columns, columns**2], axis=1)
    moments = np.moveaxis(np.add.reduceat(powers, [span.start for span in block.spans], axis=2), 2, 0)
    sums = [products(design[:, span.start : span.stop]) for span in block.spans]
    keys = [(span.test, span.piece) for span in block.spans]
    covered = {f"abs_{name}": np.abs(values[name]) for name in ("y", "psi", "r") if name in values}
    covered |= {"speed": values["u"]} if "u" in values else {}
    covered |= {
        f"{one}_to_{other}": np.divide(values[one], values[other])
        for one, other in (("width", "beam"), ("depth", "draft"))
        if one in values
    }
    ranges = {name: (float(np.min(column)), float(np.max(column))) for name, column in covered.items()}
    return moved, list(zip(keys, sums, moments, strict=True)), ranges


def _shared_out(work: partial[Any], blocks: Iterator[Block]) -> Iterator[Any]:
    """Let the cores share the blocks, a few at a time, and yield what comes of each in order."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        while some := list(islice(blocks, AHEAD)):
            # A thread for one block would cost more than it gives.
            yield from pool.map(work, some) if len(some) > 1 else map(work, some)


class Score(NamedTuple):
    r2: float  # Share of the variance explained [1]
    rmse: float  # Root mean squared error [N]


class Scored:
    """Errors by force of what has ``scores``."""

    @property
    def rsquared(self: Any) -> dict[str, float]:
        """R2 of each force on the rows of the tests [1]."""
        return Named({force: found.r2 for force, found in self.scores.items()})

    @property
    def rmse(self: Any) -> dict[str, float]:
        """Root mean squared error of each force on the rows of the tests [N, N, N m]."""
        return Named({force: found.rmse for force, found in self.scores.items()})


def score(
    equations: NormalEquations, sums: np.ndarray, terms: TermTable, values: Mapping[str, float] | np.ndarray
) -> dict[str, Score]:
    """Score coefficients on the rows behind some sums (m, m), or each row of values (groups, n) on its own sums."""
    if isinstance(values, Mapping):
        sums, values = sums[None], np.array([[values[name] for name in terms.names]])
    one, total = equations.columns[ONE], sums.sum(axis=0)
    rows, scores = total[one, one], {}
    for force, part in terms.forces.items():
        if not part:
            continue
        names, y = [term.name for term in part], equations.columns[force]
        own = values[:, [terms.names.index(name) for name in names]]
        cross = equations.pick(sums, names, [force])[..., 0]
        fitted = np.einsum("gi,gij,gj->g", own, equations.pick(sums, names), own)
        error = np.maximum(sums[:, y, y] - 2 * (own * cross).sum(axis=1) + fitted, 0.0).sum()
        spread = total[y, y] - total[one, y] ** 2 / rows
        scores[force] = Score(float(1 - error / spread) if spread > 0 else float("nan"), float(np.sqrt(error / rows)))
    return Named(scores)
