"""Columns of the design matrix that systematic errors need besides the regressors of the terms."""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from narrows.captive.tests import Block
from narrows.identification.regression.design_matrix import DesignMatrix
from narrows.quantities.names import Number
from narrows.terms.term import Term, TermTable

Values = Mapping[str, Number]
STEP = 1e-4  # of the central differences: [rad] of heading, [m] of offset, [s] of time
MOTION_COLUMNS: dict[str, Callable[[dict[str, np.ndarray]], np.ndarray]] = {
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


class EffectDesign(DesignMatrix):
    """The regressors of the terms, then the columns of the effects; all are summed in one pass.

    Columns of effects are named ``"heading of b_v"``: the derivative of the regressor of b_v to the heading.
    """

    def __init__(self, terms: TermTable) -> None:
        super().__init__(terms)
        self.base = super().size
        self.extra: list[Callable[[dict[str, np.ndarray]], np.ndarray]] = []
        self._seen: dict[tuple[object, ...], int] = {}
        for name, column in MOTION_COLUMNS.items():
            self._add(f"column {name}", (name,), column)
        for term in terms.terms:
            if self.columns[term.name] < len(self.regressors):
                self._add_derivatives(term)
        for force in self.forces:
            self._add(f"column |{force}|{force}", (force,), partial(_signed_square, force))

    @property
    def size(self) -> int:
        return self.base + len(getattr(self, "extra", ()))

    def evaluate(self, block: Block) -> np.ndarray:
        design = super().evaluate(block)
        design[self.base - 1] = 1.0
        rows = block.rows
        q = {name: np.broadcast_to(value, rows) for name, value in block.values.items() if np.ndim(value) < 2}
        for name in ("y", "u", "v", "r", "udot", "vdot", "rdot", "sin_psi"):
            q.setdefault(name, np.zeros(rows))
        q.setdefault("cos_psi", np.ones(rows))
        for i, column in enumerate(self.extra, start=self.base):
            design[i] = column(q)
        return design

    def _add(self, name: str, key: tuple[object, ...], column: Callable[[dict[str, np.ndarray]], np.ndarray]) -> None:
        """Name a column; two names of one column share it."""
        if key not in self._seen:
            self._seen[key] = self.size
            self.extra.append(column)
        self.columns[name] = self._seen[key]

    def _add_derivatives(self, term: Term) -> None:
        own = self.columns[term.name]
        if "v" in term.inputs:
            turn = _derivative(term, lambda q: {"v": q["u"]})
            self._add(f"heading of {term.name}", ("heading", own), turn)
            self._add(f"heading with y of {term.name}", ("heading y", own), lambda q: turn(q) * q["y"])
            self._add(f"mount of {term.name}", ("mount", own), lambda q: turn(q) * q.get("N", np.zeros_like(q["y"])))
        if term.from_bank:
            self._add(f"rail of {term.name}", ("rail", own), _derivative(term, lambda q: {"y": np.ones_like(q["y"])}))
            self._add(f"near of {term.name}", ("near", own), lambda q: _column(term, q) * q["y"] ** 2)
            self._add(f"wall of {term.name}", ("wall", own), lambda q: _column(term, q) * q["y"] ** 6)
            self._add(f"far of {term.name}", ("far", own), lambda q: _column(term, q) * np.sqrt(np.abs(q["y"])))
            self._add(f"side of {term.name}", ("side", own), lambda q: _column(term, q) * np.sign(q["y"]))
        self._add(f"time of {term.name}", ("time", own), _derivative(term, _rates))


def _signed_square(name: str, q: dict[str, np.ndarray]) -> np.ndarray:
    return np.asarray(np.abs(q[name]) * q[name])


def _column(term: Term, q: dict[str, np.ndarray]) -> np.ndarray:
    return np.asarray(term.column(q))


def _derivative(
    term: Term, change: Callable[[dict[str, np.ndarray]], dict[str, np.ndarray]]
) -> Callable[[dict[str, np.ndarray]], np.ndarray]:
    """Central difference of a regressor along a change of its inputs."""

    def difference(q: dict[str, np.ndarray]) -> np.ndarray:
        rate = {name: value for name, value in change(q).items() if name in term.inputs}
        if not rate:
            return np.zeros_like(q["y"])
        ahead, behind = (
            _column(term, {**q, **{name: q[name] + s * STEP * value for name, value in rate.items()}}) for s in (1, -1)
        )
        return np.asarray((ahead - behind) / (2 * STEP))

    return difference


def _rates(q: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Rate of each quantity of the motion; that of an acceleration is not known here."""
    return {
        "u": q["udot"],
        "v": q["vdot"],
        "r": q["rdot"],
        "y": q["u"] * q["sin_psi"] + q["v"] * q["cos_psi"],
        "sin_psi": q["cos_psi"] * q["r"],
        "cos_psi": -q["sin_psi"] * q["r"],
    }
