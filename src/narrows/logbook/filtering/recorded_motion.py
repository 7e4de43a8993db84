"""The motion of a ship with the recorded rudder, piece by piece, with exact slopes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from narrows.codegen.choices import COUNTED
from narrows.codegen.free_motion import INPUTS as PUSHED
from narrows.logbook.filtering.predicted_signals import RECORDED, RUDDER, RUDDER_OFFSET, RecordedHelm, unlimited
from narrows.model.model import Model
from narrows.simulation.sensitivities import TangentIntegrator
from narrows.simulation.steering import PARAMETER

STATES = ("x", "y", "psi", "u", "v", "r")
PUSHES = ("X", "Y", "N")
# Quantities of a waterway, along its line.
CURRENT = "current"


@dataclass(frozen=True)
class RecordedMotion:
    """A model and the choices with which it is integrated under recorded orders."""

    model: Model  # The ship
    positions: Mapping[str, float]  # Actuators that follow a record, each with a position that is usual
    # Derivatives are taken by these, by the initial states, the external forces and the rudder's zero
    coefficients: tuple[str, ...]
    choices: Mapping[str, Any]  # As for ``simulate``: surge, contact, waterway, u

    @cached_property
    def directions(self) -> tuple[str, ...]:
        """Variables of the slopes, in order."""
        offset = (RUDDER_OFFSET,) if RUDDER in self.positions else ()
        current = (CURRENT,) if self.choices.get("waterway") is not None else ()
        return (*STATES, *PUSHES, *offset, *current, *self.coefficients)

    @cached_property
    def integrator(self) -> TangentIntegrator:
        """Its lines and numbers."""
        helm = RecordedHelm(dict(self.positions))
        return TangentIntegrator.of(self.model, self.directions, {**self.choices, **self.positions, "controller": helm})

    @cached_property
    def of_records(self) -> "RecordedMotion":
        """The same motion without derivatives by coefficients: for parameters of single records."""
        return replace(self, coefficients=())

    def with_coefficients(self, values: Mapping[str, float]) -> "RecordedMotion":
        """Return the motion with other coefficients."""
        model = self.model.with_coefficients(**values)
        return replace(self, model=model)

    def sailed(
        self, starts: np.ndarray, pushes: np.ndarray, first: np.ndarray, times: np.ndarray,
        positions: Mapping[str, np.ndarray], offset: np.ndarray, current: float = 0.0,
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Sail every piece of a record from its own start."""
        # starts (pieces, 6): x, y [m], psi [rad], u, v [m/s], r [rad/s]; pushes (pieces, 3): X, Y [N], N [N m]
        # first (pieces + 1,); times (nodes,) [s]; offset (pieces,) [rad]; current [m/s]
        integrator = self.integrator
        kept, count = integrator.integrator.choices.kept, np.diff(first)
        begun = first[:-1]
        at_start = {name: positions[name][begun] + (offset if name == RUDDER else 0.0) for name in self.positions}
        begin, slopes = self._started(kept, starts, at_start)
        pushed = {PUSHED[name]: np.repeat(pushes[:, i], count) for i, name in enumerate(PUSHES)}
        after = slice(first[0] + 1, first[-1] + 1)
        orders = {PARAMETER(RECORDED(name)): positions[name][after] for name in self.positions}
        orders[PARAMETER(RUDDER_OFFSET)] = np.repeat(offset, count)
        lengths = np.diff(times[first[0] : first[-1] + 1])
        others = unlimited(tuple(self.positions))
        if CURRENT in self.directions:
            others[CURRENT] = integrator.integrator.inputs[CURRENT] + current
        return _poses(kept, starts, first, *integrator.segments(
            begin, slopes, first - first[0], {**orders, **pushed}, lengths, **others
        ))  # fmt: skip

    def _started(
        self, kept: Sequence[str], starts: np.ndarray, positions: Mapping[str, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the initial memory of each piece, and its slopes."""
        state = dict(zip(STATES, starts.T, strict=True))
        cosine, sine = np.cos(state["psi"]), np.sin(state["psi"])
        state |= {"cos_psi": cosine, "sin_psi": sine, COUNTED: state["psi"], "t": np.zeros(len(starts)), **positions}
        begin = np.stack([state[name] for name in kept], axis=1)
        slopes = np.zeros((len(starts), len(kept), len(self.directions)))
        by = {name: self.directions.index(name) for name in STATES}
        turned = {"cos_psi": -sine, "sin_psi": cosine, COUNTED: np.ones(len(starts))}
        for i, name in enumerate(kept):
            if name in by:
                slopes[:, i, by[name]] = 1.0
            elif name in turned:
                slopes[:, i, by["psi"]] = turned[name]
            elif name == RUDDER and RUDDER_OFFSET in self.directions:
                slopes[:, i, self.directions.index(RUDDER_OFFSET)] = 1.0
        return begin, slopes


def _poses(
    kept: Sequence[str], starts: np.ndarray, first: np.ndarray, states: np.ndarray, slopes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the six states and their derivatives; the heading does not jump by 2 pi within a piece."""
    column = {name: i for i, name in enumerate(kept)}
    heading, turned = _heading(column, starts, first, states, slopes)
    pose, moved = np.empty((len(states), 6)), np.empty((len(states), 6, slopes.shape[2]))
    pose[:, 2], moved[:, 2] = heading, turned
    for i, name in enumerate(STATES):
        if name != "psi":
            pose[:, i], moved[:, i] = states[:, column[name]], slopes[:, column[name]]
    return pose, moved


def _heading(
    column: Mapping[str, int], starts: np.ndarray, first: np.ndarray, states: np.ndarray, slopes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the heading and its derivatives, from the counted heading if there is one, else from cosine and sine."""
    if COUNTED in column:
        return states[:, column[COUNTED]], slopes[:, column[COUNTED]]
    cosine, sine = states[:, column["cos_psi"]], states[:, column["sin_psi"]]
    begun = np.repeat(starts[:, 2], np.diff(first) + 1)
    turned = np.arctan2(sine, cosine) - begun
    moved = cosine[:, None] * slopes[:, column["sin_psi"]] - sine[:, None] * slopes[:, column["cos_psi"]]
    return begun + turned - 2 * np.pi * np.round(turned / (2 * np.pi)), moved
