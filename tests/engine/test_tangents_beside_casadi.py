"""Slopes of a recorded voyage are those of CasADi's automatic differentiation, to 1e-12.

The step is written here a second time, from the terms of the table, and CasADi differentiates it: nothing of the
package's own compiler enters.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pytest
from cases import steered, waterway_for

import narrows as nw
from narrows.logbook.filtering.log_problem import RecordedMotion
from narrows.quantities.names import FORCES

casadi = pytest.importorskip("casadi", reason="CasADi, the independent differentiation, is not installed")
STEP, FIRST = 0.1, np.array([0, 10, 24])
"""Length of a step [s]; two windows begin and end at these nodes."""
ACCELERATIONS = ("udot", "vdot", "rdot")
PUSHES = np.array([[1.0, -2.0, 3.0], [-0.5, 1.5, -4.0]])
OFFSETS, CURRENT = np.array([0.02, -0.01]), 0.03
"""Zero of the rudder in each window; current beside that of the waterway."""
NODES = np.arange(FIRST[-1] + 1)
HELM = 0.05 + 0.2 * np.sin(NODES / 3)
CELL, NEAR = 0.2, 20
"""Length of a cell of the waterway [m], and how many about where a window begins."""
INERTIA = 280.0
"""In surge, where it is free [kg]."""


@dataclass(frozen=True)
class Case:
    """A ship and its waterway."""

    model: nw.Model
    surge: str = "held"
    waterway: nw.Waterway | None = None

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Coefficients that move the ship."""
        felt = [force for force in FORCES if force != "X" or self.surge == "free"]
        return tuple(term.name for force in felt for term in self.model.terms.forces[force])

    @cached_property
    def motion(self) -> RecordedMotion:
        choices: dict[str, Any] = {"u": 1.0, "surge": self.surge}
        choices |= {"surge_inertia": INERTIA} if self.surge == "free" else {}
        choices |= {} if self.waterway is None else {"waterway": self.waterway}
        return RecordedMotion(self.model, {"rudder": HELM[0]}, self.names, choices)

    @cached_property
    def starts(self) -> np.ndarray:
        size = self.model.configuration.ship.length / 4
        begun = 0.0 if self.waterway is None else 10 * size
        aside = [[begun, 0.5 * size, 0.02, 1.0, 0.01, 0.005], [begun + 1, -0.4 * size, -0.05, 0.9, -0.02, -0.01]]
        return np.array(aside)

    def sailed(self) -> tuple[np.ndarray, np.ndarray]:
        """As a fit sails it."""
        helm = {"rudder": HELM}
        return self.motion.sailed(self.starts, PUSHES, FIRST, STEP * NODES, helm, {"rudder": OFFSETS}, CURRENT)


def in_bends() -> nw.Waterway:
    """Bends both ways, banks that narrow and widen unlike, a current."""
    return replace(waterway_for("steered"), step=CELL)


CASES = {
    "bank, rudder and gear in a straight canal": Case(steered()),
    "in bends between banks that widen and narrow": Case(steered(), "free", in_bends()),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_slopes_of_a_record_are_those_of_casadi(name: str) -> None:
    case = CASES[name]
    for part, exact in zip(case.sailed(), by_casadi(case), strict=True):
        size = np.maximum(np.abs(exact).max(axis=0), 1e-300)
        np.testing.assert_allclose(part / size, exact / size, rtol=0, atol=1e-12)


def by_casadi(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """The states at the nodes of each window, and their slopes by starts, pushes, offset, current, coefficients."""
    if hasattr(casadi.GlobalOptions, "setNumpyMode"):
        casadi.GlobalOptions.setNumpyMode(1)  # NumPy's functions give symbols of symbols, without a word
    rows = []
    for window, start in enumerate(case.starts):
        step = Step(case, start[0]).function()
        numbers = [*PUSHES[window], OFFSETS[window], CURRENT, *(case.model[name] for name in case.names)]
        z, slopes = begun(start, len(numbers))
        rows.append(pose(z, slopes))
        for node in range(FIRST[window], FIRST[window + 1]):
            after, by_state, by_number = (np.array(part) for part in step(z, numbers, HELM[node : node + 2]))
            z, slopes = after.ravel(), by_state @ slopes
            slopes[:, 6:] += by_number
            rows.append(pose(z, slopes))
    states, whole = (np.array(part) for part in zip(*rows, strict=True))
    return states, whole if case.waterway else np.delete(whole, 10, axis=2)


def begun(start: np.ndarray, numbers: int) -> tuple[np.ndarray, np.ndarray]:
    """x, y, cosine, sine, u, v, r, and their slopes."""
    x, y, psi, *velocities = start
    slopes = np.zeros((7, 6 + numbers))
    slopes[[0, 1, 4, 5, 6], [0, 1, 3, 4, 5]] = 1.0
    slopes[2:4, 2] = -np.sin(psi), np.cos(psi)
    return np.array([x, y, np.cos(psi), np.sin(psi), *velocities]), slopes


def pose(z: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """With the heading as an angle."""
    turned = z[2] * slopes[3] - z[3] * slopes[2]
    return np.r_[z[:2], np.arctan2(z[3], z[2]), z[4:]], np.vstack([slopes[:2], turned, slopes[4:]])


class Step:
    """A step of Runge and Kutta's method in CasADi's symbols, from the terms one by one."""

    def __init__(self, case: Case, x: float) -> None:
        self.case, self.nodes = case, None if case.waterway is None else nodes_about(case, x)
        self.numbers = casadi.SX.sym("numbers", 5 + len(case.names))
        self.helm = casadi.SX.sym("helm", 2)
        coefficients = dict(zip(case.names, casadi.vertsplit(self.numbers[5:]), strict=True))
        self.terms = [
            [(coefficients[term.name], term) for term in case.model.terms.forces[force] if term.name in coefficients]
            for force in FORCES
        ]

    def function(self) -> Any:
        z = casadi.SX.sym("z", 7)
        a = self.rates(z, 0.0)
        b = self.rates(z + STEP / 2 * a, 0.5)
        c = self.rates(z + STEP / 2 * b, 0.5)
        after = z + STEP / 6 * (a + 2 * b + 2 * c + self.rates(z + STEP * c, 1.0))
        after[2:4] = after[2:4] * (1.5 - 0.5 * casadi.sumsqr(after[2:4]))
        slopes = (casadi.jacobian(after, by) for by in (z, self.numbers))
        return casadi.Function("step", [z, self.numbers, self.helm], [after, *slopes])

    def rates(self, z: Any, share: float) -> Any:
        x, y, cosine, sine, u, v, r = casadi.vertsplit(z)
        width, middle, depth, curvature, flow = self.section(x)
        at = {"y": y - middle, "cos_psi": cosine, "sin_psi": sine, "u": u, "v": v, "r": r, "width": width}
        moved = self.accelerations({**at, **self.rudder(share), **({} if depth is None else {"depth": depth})})
        current = 0.0 if self.nodes is None else flow * (self.case.waterway.current + self.numbers[4])
        pace = (u * cosine - v * sine + current) / (1 - curvature * y)
        turn = r - curvature * pace
        return casadi.vertcat(pace, u * sine + v * cosine, -turn * sine, turn * cosine, moved)

    def rudder(self, share: float) -> dict[str, Any]:
        """Straight from where it was recorded to the next, farther by its zero."""
        angle = (1 - share) * self.helm[0] + share * self.helm[1] + self.numbers[3]
        return {"cos_rudder": casadi.cos(angle), "sin_rudder": casadi.sin(angle)}

    def accelerations(self, at: dict[str, Any]) -> Any:
        """Of a ship on whose rig no force is left."""
        fixed = {**self.case.model.configuration.values(), "x": 0.0, "heave": 0.0}
        rates = casadi.SX.sym("rates", 3)
        values = {**fixed, **at, **dict(zip(ACCELERATIONS, casadi.vertsplit(rates), strict=True))}
        forces = casadi.vertcat(*(self.force(own, values) for own in self.terms))
        free = self.case.surge == "free"
        mass, still = -casadi.jacobian(forces, rates), casadi.substitute(forces, rates, casadi.SX.zeros(3))
        if not free:
            return casadi.vertcat(0, casadi.solve(mass[1:, 1:], still[1:] + self.numbers[1:3]))
        mass[0, 0] += INERTIA
        return casadi.solve(mass, still + self.numbers[:3])

    def force(self, terms: list[tuple[Any, nw.Term]], values: dict[str, Any]) -> Any:
        return sum((c * term.regressor(*(values[name] for name in term.inputs)) for c, term in terms), casadi.SX(0))

    def section(self, x: Any) -> tuple[Any, ...]:
        """Width, middle, depth, curvature and the current over that at the beginning, straight from node to node."""
        canal = self.case.model.configuration.canal
        if self.nodes is None:
            return canal.width, 0.0, canal.depth, 0.0, 1.0
        s, *columns = self.nodes
        return tuple(casadi.pw_lin(x, s, column) if np.isfinite(column).all() else None for column in columns)


def nodes_about(case: Case, x: float) -> list[np.ndarray]:
    way = case.waterway
    s = np.linspace(0.0, way.line.length, int(np.ceil(way.line.length / CELL)) + 1)
    near = np.abs(s - x) < NEAR * s[1]
    section = way.section(s)
    columns = (*section, section.width[0] / section.width)
    return [s[near], *(np.broadcast_to(column, s.shape)[near] for column in columns)]
