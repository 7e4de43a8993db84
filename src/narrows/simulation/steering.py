"""Control laws for the engine: traced once, with their numbers by the names of the lines."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from narrows.codegen.choices import LENGTH, TIME, WATER, Actuated, Law
from narrows.codegen.free_motion import STATE
from narrows.codegen.trace import trace_of
from narrows.errors import InputError, check_choice
from narrows.quantities.arithmetic import angle
from narrows.quantities.names import Number
from narrows.simulation.controllers import ControlLaw, Controller, ExternalOrder, Named, Order

CURRENT, WATER_PREFIX = "current", "water_"
# Names in the lines of a law's numbers and its memory.
PARAMETER, MEMORY = "law_{}".format, "memory_{}".format


@dataclass(frozen=True)
class Steering:
    law: Law  # The traced law for the engine's steps
    parameters: Mapping[str, Any]  # Numbers by the names of the lines
    controller: ControlLaw  # The original controller
    asked: Controller | Order | None = None  # An object or function of Python that gives the orders, if it is no law

    def memory(self, start: Named) -> dict[str, Number]:
        return {MEMORY(name): value for name, value in self.controller.memory(start).items()}


def steering_of(controller: Any, actuators: Sequence[Actuated]) -> Steering | None:
    law, asked = controller, None
    if controller is None:
        return None
    if not isinstance(controller, ControlLaw):
        law, asked = ExternalOrder(), controller
        if not isinstance(controller, Controller) and (not callable(controller) or isinstance(controller, type)):
            raise InputError(
                f"a {type(controller).__name__} is no controller: it has neither `orders` (a law in arithmetic) "
                "nor `begin`, and is no function of time and state"
            )
    parameters = dict(law.parameters())
    memory = tuple(law.memory(dict.fromkeys((*STATE, *(actuator.name for actuator in actuators)), 0.0)))
    traced = _law(law, tuple(parameters), memory, tuple(actuators))
    return Steering(traced, {PARAMETER(name): value for name, value in parameters.items()}, law, asked)


def _law(
    controller: ControlLaw, parameters: Sequence[str], kept: Sequence[str], actuators: tuple[Actuated, ...]
) -> Law:
    what, known = f"the controller {type(controller).__name__}", [actuator.name for actuator in actuators]
    gear = [f"{actuator.name}{of}" for actuator in actuators for of in ("", "_limit", "_rate")]
    quantities = {name: name for name in (*STATE, TIME, CURRENT, *gear)} | {"dt": LENGTH}
    ours = {name: PARAMETER(name) for name in parameters} | {name: MEMORY(name) for name in kept}
    for name in ours:
        if name in quantities or name in ("psi", "water") or (name in parameters and name in kept):
            raise InputError(f"{what} has a number called {name!r}, which means something else already; rename it")

    def results(at: Any) -> dict[str, Number]:
        at.psi, at.water = angle(at.cos_psi, at.sin_psi), water
        orders, memory = controller.orders(at)
        for name in orders:
            if name not in known:
                has = f"it has {', '.join(known)}" if known else "it has nothing to steer with"
                raise InputError(f"{what} gives orders to {name}, for which this model has no terms: {has}; add them")
        if set(memory) != set(kept):
            raise InputError(
                f"{what} keeps {sorted(memory)} and began with {sorted(kept)}; return the same memory each step"
            )
        return {**orders, **{MEMORY(name): value for name, value in memory.items()}}

    trace = trace_of(results, {**quantities, **ours}, what)
    ordered = tuple(one for one in actuators if one.name in trace.results)
    return Law(trace, tuple(MEMORY(name) for name in kept), ordered)


def water(name: str, x: Any) -> Any:
    # name [1/m]; x [m]
    check_choice("the observed section", name, [known.removeprefix(WATER_PREFIX) for known in WATER])
    return x.apply_function(f"{WATER_PREFIX}{name}", (x,))
