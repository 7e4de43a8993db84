"""Helms: two that know the mean coefficients alone, and one that knows each truth."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

import narrows as nw
from narrows.control.regulator import HeldLine, Regulator, RegulatorWeights, stacked_gains
from narrows.quantities.arithmetic import COLUMNS
from narrows.simulation.controllers import VoyageState
from narrows.simulation.ship import SimulatedShip, steering_of
from scenes.five_scenes import SPEED, Scene
from scenes.fleet import DT, Fleet


class Laws:
    """One control law on all ships."""

    def __init__(self, law: Any, fleet: Fleet) -> None:
        ship = SimulatedShip(fleet.model)
        steering = steering_of(law, ship.actuators)
        self.trace, self.memory = steering.law.trace, steering.memory(fleet.state)
        self.inputs = {**ship.values(), **steering.parameters, "step_length": DT, "current": 0.0}
        way = fleet.waterway
        bends = (
            (lambda x: way.line.curvature(np.clip(x, 0, way.line.length))) if way else (lambda x: np.zeros(np.shape(x)))
        )
        self.functions = {**COLUMNS, "water_curvature": bends}

    def __call__(self, told: Mapping[str, np.ndarray], alive: np.ndarray) -> np.ndarray:
        """The orders."""
        results = self.trace.replay({**self.inputs, **told, **self.memory}, functions=self.functions)
        self.memory = {name: results[name] for name in self.memory}
        return np.broadcast_to(results["rudder"], alive.shape)


class Objects:
    """One object of Python a ship."""

    def __init__(self, controller: Any, fleet: Fleet) -> None:
        self.orders = [controller.begin() for _ in range(fleet.count)]

    def __call__(self, told: Mapping[str, np.ndarray], alive: np.ndarray) -> np.ndarray:
        """The orders."""
        rows = zip(*(told[name] for name in VoyageState._fields), strict=True)
        states = [VoyageState(*map(float, row)) for row in rows]
        t = float(told["t"][0])
        return np.array([o(t, s) if on else 0.0 for o, s, on in zip(self.orders, states, alive, strict=True)])


Helm = Callable[[Fleet, Scene], Any]


def track_pilot(model: nw.Model, y: float, u: float) -> nw.Autopilot:
    """Linear-quadratic on the rudder, by Bryson's rule on the centreline, without an integral."""
    course, half_beam = nw.control.linearize(model, y, u).course, model.configuration.ship.beam / 2
    weights = [half_beam**-2, np.radians(5.0) ** -2, 0.0, 0.0]
    (gains,), *_ = nw.control.lqr(nw.control.linearize(model, u=u), weights, np.radians(10.0) ** -2, "rudder")
    return nw.Autopilot(y, tuple(gains), *(float(course[name]) for name in ("rudder", "psi", "v")))


def track(fleet: Fleet, scene: Scene) -> Any:
    """The track pilot, its line moved where the scene asks."""
    return [(start, track_pilot(fleet.model, y, SPEED)) for start, y in scene.lines]


def regulated(fleet: Fleet, scene: Scene) -> Regulator:
    """The regulator."""
    lines = scene.lines if len(scene.lines) > 1 else scene.lines[0][1]
    return nw.control.regulator(fleet.model, lines, SPEED)


def knowing(fleet: Fleet, scene: Scene) -> Regulator:
    """A regulator that knows of each truth what holds it on its lines, and has gains made for it."""
    usual = regulated(fleet, scene)
    return replace(usual, lines=tuple(_known(fleet, line) for line in usual.lines))


def _known(fleet: Fleet, line: HeldLine) -> HeldLine:
    """A line as each truth needs it; the usual one for those that no rudder holds on it."""
    course = nw.steady_course(fleet.model, y=line.y, u=SPEED, samples=fleet.count, seed=fleet.seed)
    needs = {name: course[name].to_numpy() for name in ("rudder", "psi", "v")}
    holds = np.abs(needs["rudder"]) <= fleet.model.configuration.gear.limit
    at = {"y": np.full(fleet.count, line.y), "u": np.full(fleet.count, SPEED)}
    at |= {name: np.where(holds, needs[name], np.nan) for name in ("v", "rudder")}
    gains = stacked_gains(SimulatedShip(fleet.model), fleet.truths, at, RegulatorWeights(bank=1.0))
    holds &= np.isfinite(gains).all(axis=1)
    known = {name: np.where(holds, column, getattr(line, name)) for name, column in needs.items()}
    one, two, three, four, five, six = (np.where(holds, *each) for each in zip(gains.T, line.gains, strict=True))
    return replace(line, gains=(one, two, three, four, five, six), **known)


HELMS: dict[str, Helm] = {"track": track, "regulator": regulated, "regulator that knows the ship": knowing}
