"""The design matrix: which column holds which regressor, evaluated on blocks of rows."""

from collections.abc import Callable, Iterator

import numpy as np

from narrows.captive.tests import Block, Tests
from narrows.errors import InputError
from narrows.identification.regression.normal_equations import ONE
from narrows.quantities.names import FORCES, Number
from narrows.terms.term import TermTable


class DesignMatrix:
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

    def evaluate(self, block: Block) -> np.ndarray:
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


def design_rows(tests: Tests, terms: TermTable) -> Iterator[tuple[DesignMatrix, np.ndarray]]:
    """Yield the columns themselves, block by block, for what sums of products cannot say (ours).

    Parameters
    ----------
    tests : CaptiveTests or StreamedTests
        The rows.
    terms : TermTable
        The columns.
    """
    matrix = DesignMatrix(terms)
    for block in tests.blocks(1):
        yield matrix, matrix.evaluate(block)
