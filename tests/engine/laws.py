"""Control laws for the reference: the package's own written again, any other by its own arithmetic; mirrored."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

import narrows as nw
from narrows.codegen.free_motion import WATER
from narrows.control.predictive.course_ahead import water_ahead
from narrows.simulation.controllers import ControlLaw

State = np.ndarray
"""x or s, y or n [m], psi [rad], u, v [m/s], r [rad/s], rudder [rad]."""
Order = Callable[[float, float, State], float]
"""The order of a step: of the time at its start and its length [s], and the state there."""


def order_of(law: ControlLaw, model: nw.Model, waterway: nw.Waterway | None) -> Order:
    """Return what gives the orders of one voyage, evaluated at the start of each step."""
    second = SECOND_WRITINGS.get(type(law))
    return second(law) if second else _by_its_own_arithmetic(law, model, waterway)


def _constant(law: nw.ConstantRudder) -> Order:
    return lambda time, dt, state: law.rudder


def _zigzag(law: nw.Zigzag) -> Order:
    memory: dict[str, float] = {}

    def order(time: float, dt: float, state: State) -> float:
        start, side = memory.setdefault("start", state[2]), memory.setdefault("side", math.copysign(1.0, law.rudder))
        if side * (state[2] - start) >= law.heading:
            memory["side"] = -side
        return memory["side"] * abs(law.rudder)

    return order


def _pilot(law: nw.Autopilot) -> Order:
    by_y, by_psi, by_v, by_r = law.gains

    def order(time: float, dt: float, z: State) -> float:
        off = by_y * (z[1] - law.y) + by_psi * (z[2] - law.psi) + by_v * (z[4] - law.v) + by_r * z[5]
        return law.rudder - off

    return order


SECOND_WRITINGS: Mapping[type, Callable[[Any], Order]] = {
    nw.ConstantRudder: _constant,
    nw.Zigzag: _zigzag,
    nw.Autopilot: _pilot,
}


def _by_its_own_arithmetic(law: ControlLaw, model: nw.Model, waterway: nw.Waterway | None) -> Order:
    """The law on plain floats: what holds the engine that traces, prints and compiles it."""
    gear, ahead = model.configuration.gear, water_ahead(model, waterway)
    about = {"rudder_limit": gear.limit, "rudder_rate": gear.rate}
    about["water"] = lambda name, x: float(ahead.at(np.array([x]))[WATER[f"water_{name}"]][0])
    memory: dict[str, Any] = {}

    def order(time: float, dt: float, state: State) -> float:
        x, y, psi, u, v, r, rudder = state.tolist()
        about["current"] = float(ahead.at(np.array([x]))["current"][0])
        motion = {"x": x, "y": y, "u": u, "v": v, "r": r, "rudder": rudder}
        motion |= {"cos_psi": math.cos(psi), "sin_psi": math.sin(psi)}
        if not memory:
            memory.update(law.memory(motion))
        at = SimpleNamespace(**motion, **about, **law.parameters(), **memory, psi=psi, t=time, dt=dt)
        orders, after = law.orders(at)
        memory.update(after)
        return float(orders["rudder"])

    return order


@dataclass(frozen=True)
class Mirrored:
    """A law that orders to port what another orders to starboard, in the mirror."""

    law: ControlLaw

    def parameters(self) -> Mapping[str, Any]:
        return self.law.parameters()

    def memory(self, start: Mapping[str, Any]) -> Mapping[str, Any]:
        return self.law.memory({**start, **{name: -start[name] for name in MIRRORED if name in start}})

    def orders(self, at: Any) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
        orders, memory = self.law.orders(_InMirror(at))
        return {name: -order for name, order in orders.items()}, memory


MIRRORED = ("y", "sin_psi", "psi", "v", "r", "rudder")
OTHER_SIDE = {"starboard": "port", "port": "starboard"}


class _InMirror:
    def __init__(self, at: Any) -> None:
        self._at = at

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._at, name)
        return -value if name in MIRRORED else value

    def water(self, name: str, x: Any) -> Any:
        """Banks change sides, and bends their sign."""
        value = self._at.water(OTHER_SIDE.get(name, name), x)
        return -value if name == "curvature" else value


def mirrored_law(law: ControlLaw | None) -> ControlLaw | None:
    """Return the same orders to the other side; where numbers alone do it, by the same kernel."""
    if isinstance(law, nw.ConstantRudder | nw.Zigzag):
        return replace(law, rudder=-law.rudder)
    if isinstance(law, nw.Autopilot):
        return replace(law, y=-law.y, rudder=-law.rudder, psi=-law.psi, v=-law.v)
    if isinstance(law, nw.PID):
        return replace(law, psi=-law.psi)
    return None if law is None else Mirrored(law)
