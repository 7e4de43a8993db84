"""Initial conditions of a voyage: the inputs of its integrator, and errors of an impossible start."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.codegen.choices import AFTER, COUNTED, stages_at
from narrows.codegen.free_motion import INPUTS
from narrows.codegen.kernels import event
from narrows.errors import InputError, did_you_mean
from narrows.model.model import Model
from narrows.model.squat import choke_speed
from narrows.quantities.names import GRAVITY
from narrows.ship.actuators import places_of
from narrows.simulation.channel import Channel, across_of, along_waterway, straight_channel
from narrows.simulation.inputs import INPUTS as PUSHED
from narrows.simulation.inputs import START
from narrows.simulation.integrator import VoyageIntegrator, near_the_bank
from narrows.simulation.settings import (
    DEFAULT_FROUDE,
    DEFAULT_LENGTHS,
    DEFAULT_OFFSET,
    DEFAULT_SHARE_OF_CHOKING,
    DEFAULT_STEPS_A_LENGTH,
)
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import Steering

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

POSE = ("x", "y", "psi", "u", "v", "r")


def check_positions(positions: Mapping[str, float], ship: SimulatedShip) -> None:
    known = [actuator.name for actuator in ship.actuators]
    for name in positions:
        if name not in known:
            stem = name.removesuffix("_deg")
            in_degrees = stem != name and stem in {*POSE, *known, "rudder"}
            if in_degrees:
                raise InputError(f"there is no argument {name!r}; write {stem}=np.radians(...)")
            hint = did_you_mean(name, known) if known else "; it has none"
            raise InputError(f"there is no argument {name!r}, and no actuator of the model has this name{hint}")


def initial_state(
    ship: SimulatedShip, steering: Steering | None, numbers: dict[str, float], waterway: "Waterway | None", pushed: bool
) -> tuple[VoyageIntegrator, tuple[float, ...]]:
    """Return the integrator with every input of its lines, and its initial state."""
    values = ship.values(**{name: number for name, number in numbers.items() if name not in POSE})
    channel = _channel(ship, values, waterway, numbers["x"])
    law = steering.law if steering else None
    system = ship.system(waterway is not None, law, "until" if pushed else "never", across_of(waterway))
    inputs = {**values, **system.constants(values), **channel.inputs, **(steering.parameters if steering else {})}
    inputs |= {**dict.fromkeys((*INPUTS.values(), *map(AFTER, INPUTS.values())), 0.0), "push_end": math.inf}
    order = steering.asked.begin() if steering and steering.asked else None
    integrator = VoyageIntegrator(system.scalar, system.choices, inputs, channel, near_the_bank(values), order)
    psi = numbers["psi"]
    pose = {**numbers, "cos_psi": math.cos(psi), "sin_psi": math.sin(psi), COUNTED: psi}
    state = complete_state(ship, steering, pose, numbers)
    start = tuple(float(state[name]) for name in system.choices.kept)
    _check_afloat(integrator, start)
    return integrator, start


def _channel(ship: SimulatedShip, values: dict[str, Any], waterway: "Waterway | None", x: float) -> Channel:
    if waterway is None:
        return straight_channel(values, ship.shape, ship.bottom)
    if not 0 <= x < waterway.line.length:
        raise InputError(f"x = {x:g} m is not on {waterway.name}, 0 to {waterway.line.length:.0f} m; start on it")
    return along_waterway(waterway, ship.model, ship.shape, ship.bottom)


def complete_state(
    ship: SimulatedShip, steering: Steering | None, state: Mapping[str, Any], values: Mapping[str, Any]
) -> dict[str, Any]:
    """Return a state with time, actuators (at rest unless given), their stored orders and the memory of a law."""
    rest = {**ship.values(), **values}
    positions = {one.name: rest.get(one.name) for one in ship.actuators}
    whole = {"t": 0.0, **state, **{name: 0.0 if value is None else value for name, value in positions.items()}}
    whole |= stages_at(ship.actuators, whole.__getitem__)
    return {**whole, **(steering.memory(whole) if steering else {})}


def _check_afloat(integrator: VoyageIntegrator, start: tuple[float, ...]) -> None:
    _, y, cosine, sine, *_ = start
    if cosine <= integrator.inputs["least_cos"]:
        heading = math.degrees(math.atan2(sine, cosine))
        raise InputError(f"psi = {heading:.1f} deg lies across the canal; start within 85 deg")
    clearance, _ = integrator.clearance(start)
    met = integrator.cause(event.CLOSED, start)
    if met == event.GROUNDED and (clearance < 0 or (clearance == 0 and start[0] != integrator.channel.start)):
        raise InputError(
            f"y = {y:g} m starts with the hull {-clearance:.3g} m into the bank; start nearer the centreline"
        )
    # The shortest step: with none at all, a rate without limit would give 0 times infinity.
    if not all(map(math.isfinite, integrator.stepped(start, math.ulp(0.0))[0])):
        u, v, r = start[4:7]
        raise InputError(f"the forces of this model are not finite at u = {u:g}, v = {v:g}, r = {r:g}; start otherwise")


def check_irrelevant(ship: SimulatedShip, given: Mapping[str, Any]) -> None:
    """Raise if an argument has no effect: the caller expects one."""
    terms = ship.model.terms
    relevant = {*START, *PUSHED, *terms.inputs, *terms.names, "length", "beam", "width", *places_of(terms.actuators)}
    relevant |= {actuator.name for actuator in terms.actuators}
    relevant |= {"mass", "inertia", "x_g"} if ship.coriolis else set()
    relevant |= {"depth", "draft", "block_coefficient"} if ship.bottom else set()
    relevant -= {"X"} if ship.surge == "held" else set()
    for name, value in given.items():
        is_zero = name in ("X", "rudder", "heave") and not np.any(value)
        if name not in relevant and not is_zero:
            remedy = "give surge='free', or leave it out" if name == "X" else "leave it out"
            why = "the speed is held" if name == "X" else "no term of this model depends on it"
            raise InputError(f"{name} changes nothing here: {why}; {remedy}")


class VoyageDefaults(NamedTuple):
    speed: float  # Within the tested range, and below choking [m/s]
    duration: float  # Longest time [s]
    dt: float  # Time step [s]
    offset: float  # Largest starting offset of a map [m]


def voyage_defaults(model: Model, speeds: Any = None) -> VoyageDefaults:
    """Return defaults for the ship of a model in its canal, at given speeds if any, each to two digits."""
    ship, canal = model.configuration.ship, model.configuration.canal
    given = np.abs(np.asarray([] if speeds is None else speeds, float))
    given = given[(given > 0) & (given < math.inf)]
    u = given if given.size else np.array([_default_speed(model)])
    longest, step = DEFAULT_LENGTHS * ship.length / u.min(), ship.length / u.max() / DEFAULT_STEPS_A_LENGTH
    offset = max(canal.width - ship.beam, 0.0) / 2 * DEFAULT_OFFSET
    return VoyageDefaults(*(float(f"{value:.2g}") for value in (u.max(), longest, step, offset)))


def _default_speed(model: Model) -> float:
    low, high = model.data_range.speed or (0.0, math.inf)
    most = DEFAULT_SHARE_OF_CHOKING * choke_speed(model.configuration) if model.configuration.canal.depth else math.inf
    return min(max(DEFAULT_FROUDE * math.sqrt(GRAVITY * model.configuration.ship.length), low), high, most)
