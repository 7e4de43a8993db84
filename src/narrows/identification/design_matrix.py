"""The design matrix: regressors of the terms, forces, the constant, then the columns that systematic errors need.

A column of an effect is named ``"heading of b_v"``: the derivative of the regressor of b_v to the heading.
"""

import threading
from collections.abc import Callable, Mapping
from functools import partial
from operator import itemgetter

import numpy as np

from narrows.captive.columns import check_given
from narrows.captive.tests import Block
from narrows.quantities.names import FORCES, Number
from narrows.terms.term import Term, TermTable, uncompiled

Values = dict[str, np.ndarray]
# A function of the quantities of a block, and of the columns before it.
Column = Callable[[Values, np.ndarray], np.ndarray]
# Name of the column of ones.
ONE = "1"
STEP = 1e-4  # Step of the central differences [rad, m, s]
MOTION_COLUMNS: dict[str, Callable[[Values], np.ndarray]] = {
    "y": lambda q: q["y"],
    "y u": lambda q: q["y"] * q["u"],
    "y u2": lambda q: q["y"] * q["u"] ** 2,
    "y2 u2": lambda q: np.abs(q["y"]) * q["y"] * q["u"] ** 2,
    "u2": lambda q: q["u"] ** 2,
    "v": lambda q: q["v"],
    "r": lambda q: q["r"],
    "v3": lambda q: q["v"] ** 3,
    "r3": lambda q: q["r"] ** 3,
    "|r|v": lambda q: np.abs(q["r"]) * q["v"],
    "|v|r": lambda q: np.abs(q["v"]) * q["r"],
    "v y2": lambda q: q["v"] * q["u"] * q["y"] ** 2,
    "r y2": lambda q: q["r"] * q["u"] * q["y"] ** 2,
}
# Other forms of the bank: each multiplies the column of a bank's term.
FORM_COLUMNS: dict[str, Callable[[Values], np.ndarray]] = {
    "near": lambda q: q["y"] ** 2,
    "wall": lambda q: q["y"] ** 6,
    "far": lambda q: np.sqrt(np.abs(q["y"])),
    "side": lambda q: np.sign(q["y"]),
}


class DesignMatrix:
    """Columns of the design by name; columns that are the same function share one place."""

    def __init__(self, terms: TermTable, effects: bool = True) -> None:
        self.terms = terms
        self.columns: dict[str, int] = {}
        self.forces = [force for force in FORCES if terms.forces[force]]
        self._regressors: list[Term] = []
        self._others: list[Column] = []
        self._place: dict[tuple[object, ...], int] = {}
        self._memory = threading.local()
        for term in terms.terms:
            key = (term.regressor, term.inputs)
            if key not in self._place:
                self._place[key] = len(self._regressors)
                self._regressors.append(term)
            self.columns[term.name] = self._place[key]
        for force in self.forces:
            self._add(force, (force,), _of_motion(itemgetter(force)))
        self._add(ONE, (ONE,), _of_motion(lambda q: np.ones_like(q["y"])))
        if effects:
            self._add_effects()

    @property
    def size(self) -> int:
        """Number of columns."""
        return len(self._regressors) + len(self._others)

    def evaluate(self, block: Block) -> np.ndarray:
        """Evaluate every column on a block of rows, (m, rows), into memory that the thread's next block overwrites."""
        check_given((*self.terms.inputs, *self.forces), block.values, block.headers, self.terms.actuators)
        design, rows = self._memory_for(block.rows), block.rows
        for i, term in enumerate(self._regressors):
            design[i] = _evaluated(term, block.values)
        q = {name: np.broadcast_to(value, rows) for name, value in block.values.items() if np.ndim(value) < 2}
        for name in ("y", "u", "v", "r", "udot", "vdot", "rdot", "sin_psi"):
            q.setdefault(name, np.zeros(rows))
        q.setdefault("cos_psi", np.ones(rows))
        for i, column in enumerate(self._others, start=len(self._regressors)):
            design[i] = column(q, design)
        return design

    def _memory_for(self, rows: int) -> np.ndarray:
        whole: np.ndarray = getattr(self._memory, "whole", np.empty((self.size, 0)))
        if whole.shape[1] < rows:
            whole = self._memory.whole = np.empty((self.size, rows))
        return whole[:, :rows]

    def _add(self, name: str, key: tuple[object, ...], column: Column) -> None:
        if key not in self._place:
            self._place[key] = self.size
            self._others.append(column)
        self.columns[name] = self._place[key]

    def _add_effects(self) -> None:
        for name, column in MOTION_COLUMNS.items():
            self._add(f"column {name}", (name,), _of_motion(column))
        for term in self.terms.terms:
            self._add_derivatives(term)
        for force in self.forces:
            self._add(f"column |{force}|{force}", ("square", force), _of_motion(partial(_signed_square, force)))

    def _add_derivatives(self, term: Term) -> None:
        own = self.columns[term.name]

        def add(kind: str, column: Column) -> None:
            self._add(f"{kind} of {term.name}", (kind, own), column)

        if "v" in term.inputs:
            add("heading", _of_motion(_derivative(term, lambda q: {"v": q["u"]})))
            heading = self._place["heading", own]
            add("heading with y", lambda q, design: design[heading] * q["y"])
            add("mount", lambda q, design: design[heading] * q.get("N", np.zeros_like(q["y"])))
        if term.from_bank:
            add("rail", _of_motion(_derivative(term, lambda q: {"y": np.ones_like(q["y"])})))
            for kind, form in FORM_COLUMNS.items():
                add(kind, partial(_times, own, form))
        add("time", _of_motion(_derivative(term, _rates)))


def _of_motion(function: Callable[[Values], np.ndarray]) -> Column:
    return lambda q, _: function(q)


def _signed_square(name: str, q: Values) -> np.ndarray:
    return np.asarray(np.abs(q[name]) * q[name])


def _times(own: int, form: Callable[[Values], np.ndarray], q: Values, design: np.ndarray) -> np.ndarray:
    return np.asarray(design[own] * form(q))


def _evaluated(term: Term, values: Mapping[str, Number]) -> Number:
    try:
        return term.column(values)
    except (TypeError, ValueError) as error:  # The regressor is a function of floats, or has an if.
        raise uncompiled(term, error) from error


def _derivative(term: Term, change: Callable[[Values], Values]) -> Callable[[Values], np.ndarray]:
    """Central difference of a regressor along a change of its inputs."""

    def difference(q: Values) -> np.ndarray:
        rate = {name: value for name, value in change(q).items() if name in term.inputs}
        if not rate:
            return np.zeros_like(q["y"])
        ahead, behind = (
            term.column({**q, **{name: q[name] + s * STEP * value for name, value in rate.items()}}) for s in (1, -1)
        )
        return np.asarray((np.asarray(ahead) - behind) / (2 * STEP))

    return difference


def _rates(q: Values) -> Values:
    """Rate of each quantity of the motion; that of an acceleration is not known here."""
    return {
        "u": q["udot"],
        "v": q["vdot"],
        "r": q["rdot"],
        "y": q["u"] * q["sin_psi"] + q["v"] * q["cos_psi"],
        "sin_psi": q["cos_psi"] * q["r"],
        "cos_psi": -q["sin_psi"] * q["r"],
    }
