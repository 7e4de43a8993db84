"""The design matrix: regressors of the terms, forces, the constant, then the columns that systematic errors need.

A column of an effect is named ``"heading of b_v"``: the derivative of the regressor of b_v to the heading.
"""

import threading
from collections.abc import Callable
from functools import partial
from operator import itemgetter
from typing import Any

import numpy as np

from narrows.captive.columns import check_given
from narrows.captive.tests import Block
from narrows.quantities.names import FORCES, Number
from narrows.terms.term import Term, TermTable, uncompiled

Values = dict[Any, Number]  # Quantities of a block by name, and the columns so far by key
Column = Callable[[Values], Number]
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
        self.terms = terms
        self.columns: dict[str, int] = {}
        self.forces = [force for force in FORCES if terms.forces[force]]
        self._functions: dict[Any, Column] = {}
        self._memory = threading.local()
        for term in terms.terms:
            self._add(term.name, (term.regressor, term.inputs), partial(_evaluated, term))
        for force in self.forces:
            self._add(force, force, itemgetter(force))
        self._add(ONE, ONE, lambda _: 1.0)
        if effects:
            for name, column in MOTION_COLUMNS.items():
                self._add(f"column {name}", f"column {name}", column)
            for term in terms.terms:
                self._add_derivatives(term)
            for force in self.forces:
                self._add(f"column |{force}|{force}", f"column |{force}|{force}", partial(_signed_square, force))

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

    def _add(self, name: str, key: Any, column: Column) -> None:
        self._functions.setdefault(key, column)
        self.columns[name] = list(self._functions).index(key)

    def _add_derivatives(self, term: Term) -> None:
        own = (term.regressor, term.inputs)

        def add(kind: str, column: Column) -> None:
            self._add(f"{kind} of {term.name}", (kind, own), column)

        if "v" in term.inputs:
            add("heading", partial(_derivative, term, lambda q: {"v": q["u"]}))
            add("heading with y", lambda q: q["heading", own] * q["y"])
            add("mount", lambda q: q["heading", own] * q["N"])
        if term.from_bank:
            add("rail", partial(_derivative, term, lambda _: {"y": 1.0}))
            for kind, form in FORM_COLUMNS.items():
                add(kind, partial(_times, own, form))
        add("time", partial(_derivative, term, _rates))


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
    """Central difference of a regressor along a change of its inputs."""
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
