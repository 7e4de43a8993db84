"""Truths of one model that sail abreast, a step a call, and what a helm is told of them."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

import narrows as nw
from narrows.simulation.controllers import ExternalOrder
from narrows.simulation.grid import sampled
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.ship import PARAMETER, SimulatedShip, steering_of
from narrows.waterway import Waterway
from scenes.five_scenes import SPEED

DT = 1.0
NOISE = {"y": 0.3, "psi": np.radians(0.05), "v": 0.01, "r": np.radians(0.002)}
"""Of what a helm is told, standard deviations: m, rad, m/s, rad/s."""


@dataclass
class Fleet:
    """Truths of one model that sail abreast, a step a call, each with an order and a push of its own."""

    model: nw.Model
    count: int
    seed: int = 7
    waterway: Waterway | None = None
    state: dict[str, np.ndarray] = field(default_factory=dict)
    psi: np.ndarray = field(init=False)
    lost: np.ndarray = field(init=False)

    @cached_property
    def truths(self) -> dict[str, np.ndarray]:
        """Coefficients."""
        return {name: column.to_numpy() for name, column in sampled(self.model, self.count, self.seed).items()}

    def begin(self, y: Any, psi: Any, v: float, rudder: float) -> None:
        """Place every ship."""
        self.psi = psi
        columns = {"x": 200.0, "y": y, "u": SPEED, "v": v, "r": 0.0, "rudder": rudder, "cos_psi": np.cos(psi)}
        columns |= {"sin_psi": np.sin(psi), "t": 0.0}
        self.state = {name: np.full(self.count, column, float) for name, column in columns.items()}
        ship = SimulatedShip(self.model)
        run = KernelRun(ship, DT, DT, steering=steering_of(ExternalOrder(), ship.actuators), waterway=self.waterway)
        each = np.zeros(self.count)
        values = {**self.state, **self.truths, "psi": each, "X": each, "Y": each, "N": each, "push_end": np.inf}
        self.sailing = run.prepared({**values, PARAMETER("order"): each}, self.count, 1)
        self.kept, self.inputs = self.sailing.kernel.KEPT_NAMES, self.sailing.kernel.VESSEL_INPUTS
        self.alive, self.travel = np.ones(self.count, bool), np.zeros(self.count)

    def step(self, order: np.ndarray, push: tuple[float, float]) -> None:
        """Sail a step; a ship that touches a bank stays where it is."""
        columns = {PARAMETER("order"): order, "Y_in": push[0], "N_in": push[1]}
        for name, column in columns.items():
            self.sailing.vessel_inputs[:, self.inputs.index(name)] = column
        for index, name in enumerate(self.kept):
            self.sailing.start[:, index] = self.state[name]
        self.sailing()
        self.alive &= self.sailing.codes[:, 0] == 0
        after = dict(zip(self.kept, self.sailing.end.T, strict=True))
        self.travel += np.abs(after["rudder"] - self.state["rudder"]) * self.alive
        for name, column in after.items():
            self.state[name] = np.where(self.alive, column, self.state[name])

    def told(self, rng: np.random.Generator) -> dict[str, np.ndarray]:
        """What a helm is told."""
        off = {name: size * rng.standard_normal(self.count) for name, size in NOISE.items()}
        psi = np.arctan2(self.state["sin_psi"], self.state["cos_psi"]) + off.pop("psi")
        seen = {name: self.state[name] + off.get(name, 0.0) for name in ("x", "y", "u", "v", "r", "rudder", "t")}
        return {**seen, "cos_psi": np.cos(psi), "sin_psi": np.sin(psi), "psi": psi}
