"""The design matrix: which column holds which regressor, evaluated on blocks of rows."""

import threading
from collections.abc import Callable, Iterator

import numpy as np

from narrows.captive.columns import check_given
from narrows.captive.tests import Block, Tests
from narrows.identification.regression.normal_equations import ONE
from narrows.quantities.names import FORCES, Number, asked_by
from narrows.terms.regressors import Composed
from narrows.terms.term import TermTable, uncompiled


class DesignMatrix:
    """Columns of the design by regressor; built once for a table of terms."""

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
        self.terms = terms
        self.inputs, self.actuators = terms.inputs, terms.actuators
        self._memory = threading.local()

    @property
    def size(self) -> int:
        """Number of columns."""
        return len(self.regressors) + len(self.forces) + 1

    def evaluate(self, block: Block) -> np.ndarray:
        """Evaluate every column on a block of rows, (m, rows), into memory that the thread's next block overwrites."""
        check_given((*self.inputs, *self.forces), block.values, block.headers, self.actuators)
        design = self._room(block.rows)
        values, known = block.values, {}
        for i, (regressor, inputs) in enumerate(self.regressors):
            if isinstance(regressor, Composed):
                # Sway and yaw have terms of one pressure: it is computed once a block.
                parameter = regressor.parameter
                if parameter not in known:
                    known[parameter] = parameter(*[values[name] for name in asked_by(parameter)])
                design[i] = regressor.of(known[parameter], values)
            else:
                design[i] = self._evaluated(i, [values[name] for name in inputs])
        for i, force in enumerate(self.forces, start=len(self.regressors)):
            design[i] = block.values[force]
        design[-1] = 1.0
        return design

    def _evaluated(self, i: int, values: list[Number]) -> Number:
        try:
            return self.regressors[i][0](*values)
        except (TypeError, ValueError) as error:  # The regressor is a function of floats, or has an if.
            term = next(term for term in self.terms.terms if self.columns[term.name] == i)
            raise uncompiled(term, error) from error

    def _room(self, rows: int) -> np.ndarray:
        whole: np.ndarray = getattr(self._memory, "whole", np.empty((self.size, 0)))
        if whole.shape[1] < rows:
            whole = self._memory.whole = np.empty((self.size, rows))
        return whole[:, :rows]


def design_rows(tests: Tests, terms: TermTable) -> Iterator[tuple[DesignMatrix, np.ndarray]]:
    """Yield the columns themselves, block by block, for what sums of products cannot say."""
    matrix = DesignMatrix(terms)
    for block in tests.blocks(1):
        yield matrix, matrix.evaluate(block)
