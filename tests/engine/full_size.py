"""The KCS of 230 m in its canal, with gears, and a controller whose orders are heard exactly so many steps later."""

import math
from collections import deque
from dataclasses import replace
from functools import cache
from typing import Any

import narrows as nw
from narrows.identification.fitting import bundled_ship
from narrows.model.tables import table_named
from narrows.quantities.arithmetic import COLUMNS
from narrows.simulation.controllers import VoyageState
from narrows.simulation.ship import SimulatedShip, steering_of

STEP = 1.0
"""Between orders [s]."""


@cache
def full_size() -> nw.Model:
    return bundled_ship(230.0, 300.0, 16.2, table_named("speed+helm"))


def geared(model: nw.Model, **gear: Any) -> nw.Model:
    configuration = model.configuration
    return replace(model, configuration=replace(configuration, steering=replace(configuration.gear, **gear)))


class Exactly:
    """A law of the ship at full size whose orders are heard exactly so many steps later, by a list of them."""

    def __init__(self, law: Any, steps: int) -> None:
        self.law, self.steps = law, steps

    def begin(self) -> Any:
        ship = SimulatedShip(full_size())
        steering = steering_of(self.law, ship.actuators)
        memory, on_its_way = {}, deque()

        def order(t: float, seen: VoyageState) -> float:
            at = {**seen._asdict(), "cos_psi": math.cos(seen.psi), "sin_psi": math.sin(seen.psi), "t": t}
            if not memory:
                memory.update(steering.memory(at))
                on_its_way.extend([seen.rudder] * self.steps)
            numbers = {**ship.values(), **steering.parameters, **at, **memory, "step_length": STEP, "current": 0.0}
            found = steering.law.trace.replay(numbers, functions={**COLUMNS, "water_curvature": lambda x: 0.0})
            memory.update({name: float(found[name]) for name in memory})
            on_its_way.append(float(found["rudder"]))
            return on_its_way.popleft()

        return order
