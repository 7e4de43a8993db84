"""The motion of a ship with the recorded rudder, piece by piece, with exact slopes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from narrows.codegen.choices import COUNTED
from narrows.codegen.free_motion import INPUTS as PUSHED
from narrows.logbook.filtering.predicted_signals import OFFSET
from narrows.model.model import Model
from narrows.results import BaseSummary
from narrows.simulation.controllers import Named
from narrows.simulation.sensitivities import TangentIntegrator
from narrows.simulation.steering import PARAMETER

STATES = ("x", "y", "psi", "u", "v", "r")
PUSHES = ("X", "Y", "N")
# Quantities of a waterway, along its line.
CURRENT = "current"
# Name, in the law, of an actuator's position at the end of the step; actuators go there straight within the step.
RECORDED = "recorded_{}".format
# Limit and rate of what was recorded: it went where it went.
UNLIMITED = 1e9


@dataclass(frozen=True, repr=False)
class RecordedHelm(BaseSummary):
    """A control law that follows recorded positions, straight between the ends of the steps."""

    positions: Mapping[str, float]  # Positions of the recorded actuators, at the start

    def summary(self) -> str:
        return f"as recorded: {', '.join(self.positions)}"

    def parameters(self) -> Mapping[str, float]:
        """Return the positions at the end of the step, and how far they are off."""
        offsets = {OFFSET(name): 0.0 for name in self.positions}
        return {RECORDED(name): position for name, position in self.positions.items()} | offsets

    def memory(self, start: Named) -> Named:
        return {}

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return where the actuators are at the end of the step."""
        return {name: getattr(at, RECORDED(name)) + getattr(at, OFFSET(name)) for name in self.positions}, {}


@dataclass(frozen=True)
class RecordedMotion:
    """A model and the choices with which it is integrated under recorded orders."""

    model: Model  # The ship
    positions: Mapping[str, float]  # Actuators that follow a record, each with a position that is usual
    # Derivatives are taken by these too, and by the initial states, the external forces and the offsets of positions
    coefficients: tuple[str, ...]
    choices: Mapping[str, Any]  # As for ``simulate``: surge, contact, waterway, u

    @cached_property
    def directions(self) -> tuple[str, ...]:
        """Variables of the slopes, in order."""
        offsets = map(OFFSET, self.positions)
        current = (CURRENT,) if self.choices.get("waterway") is not None else ()
        return (*STATES, *PUSHES, *offsets, *current, *self.coefficients)

    @cached_property
    def integrator(self) -> TangentIntegrator:
        """Its lines and numbers."""
        helm = RecordedHelm(dict(self.positions))
        return TangentIntegrator.of(self.model, self.directions, {**self.choices, **self.positions, "controller": helm})

    def with_coefficients(self, values: Mapping[str, float]) -> "RecordedMotion":
        """Return the motion with other coefficients."""
        other = replace(self, model=self.model.with_coefficients(**values))
        other.__dict__["integrator"] = self.integrator.with_coefficients(other.model)
        return other

    def sailed(
        self, starts: np.ndarray, pushes: np.ndarray, first: np.ndarray, times: np.ndarray,
        positions: Mapping[str, np.ndarray], offsets: Mapping[str, np.ndarray] | None = None, current: float = 0.0,
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Sail every piece of a record from its own start; return the six states and their derivatives."""
        # starts (pieces, 6): x, y [m], psi [rad], u, v [m/s], r [rad/s]; pushes (pieces, 3): X, Y [N], N [N m]
        # first (pieces + 1,); times (nodes,) [s]; offsets of actuators (pieces,); current [m/s]
        integrator = self.integrator
        kept, count = integrator.integrator.choices.kept, np.diff(first)
        off = {name: np.zeros(len(count)) for name in self.positions} | dict(offsets or {})
        at_start = {name: positions[name][first[:-1]] + off[name] for name in self.positions}
        begin, slopes = self._started(kept, starts, at_start)
        inputs = {PUSHED[name]: np.repeat(pushes[:, i], count) for i, name in enumerate(PUSHES)}
        after = slice(first[0] + 1, first[-1] + 1)
        inputs |= {PARAMETER(RECORDED(name)): positions[name][after] for name in self.positions}
        inputs |= {PARAMETER(OFFSET(name)): np.repeat(off[name], count) for name in self.positions}
        lengths = np.diff(times[first[0] : first[-1] + 1])
        others = {f"{name}_{end}": UNLIMITED for name in self.positions for end in ("limit", "rate")}
        if CURRENT in self.directions:
            others[CURRENT] = integrator.integrator.inputs[CURRENT] + current
        columns = integrator.segments(begin, slopes, first - first[0], inputs, lengths, **others)
        found = {name: tuple(part[:, i] for part in columns) for i, name in enumerate(kept)}
        found["psi"] = found[COUNTED] if COUNTED in found else _heading(found, np.repeat(starts[:, 2], count + 1))
        states, moved = (np.stack(part, axis=1) for part in zip(*(found[name] for name in STATES), strict=True))
        return states, moved

    def _started(
        self, kept: Sequence[str], starts: np.ndarray, positions: Mapping[str, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the initial memory of each piece, and its slopes."""
        state = dict(zip(STATES, starts.T, strict=True))
        cosine, sine = np.cos(state["psi"]), np.sin(state["psi"])
        state |= {"cos_psi": cosine, "sin_psi": sine, COUNTED: state["psi"], "t": np.zeros(len(starts)), **positions}
        begin = np.stack([state[name] for name in kept], axis=1)
        slopes = np.zeros((len(starts), len(kept), len(self.directions)))
        by = {name: (name, 1.0) for name in STATES} | {name: (OFFSET(name), 1.0) for name in positions}
        by |= {"cos_psi": ("psi", -sine), "sin_psi": ("psi", cosine), COUNTED: ("psi", 1.0)}
        for i, name in enumerate(kept):
            if name in by and by[name][0] in self.directions:
                slopes[:, i, self.directions.index(by[name][0])] = by[name][1]
        return begin, slopes


def _heading(found: Mapping[str, tuple[np.ndarray, ...]], begun: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Heading and its derivatives from cosine and sine; it does not jump by 2 pi within a piece."""
    (cosine, by_cosine), (sine, by_sine) = found["cos_psi"], found["sin_psi"]
    turned = np.arctan2(sine, cosine) - begun
    moved = cosine[:, None] * by_sine - sine[:, None] * by_cosine
    return begun + turned - 2 * np.pi * np.round(turned / (2 * np.pi)), moved
