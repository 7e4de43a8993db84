"""A model and its control law as a traced system with its input values, shared by voyages, fleets and the envelope."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

from narrows.base.errors import InputError, check_choice
from narrows.codegen.choices import LENGTH, TIME, WATER, Across, Actuated, Choices, Law, Pushed
from narrows.codegen.free_motion import OPEN, STATE, Outline, Surge
from narrows.codegen.linearisation import Linearisation
from narrows.codegen.system import System
from narrows.codegen.trace import trace_of
from narrows.model.model import Model
from narrows.model.term import TermTable
from narrows.quantities.arithmetic import angle
from narrows.quantities.names import Number
from narrows.ship.checks import check_ahead
from narrows.simulation.channel import Channel, along_waterway, check_outline, straight_channel
from narrows.simulation.controllers import ControlLaw, Controller, ExternalOrder, Named, Order
from narrows.simulation.inputs import Contact, check_flag, check_options

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

# Points of the waterline: (forward of midship, to starboard) [m].
Points = Sequence[Sequence[float]]


@dataclass(frozen=True)
class SimulatedShip:
    model: Model  # The ship in its canal
    surge: Surge = "held"  # ``held``: constant speed; ``free``: it is integrated
    surge_inertia: float | None = None  # Mass in surge with its added mass, for ``free`` [kg]
    coriolis: bool = False  # Add the rigid body's Coriolis force; damping fitted at one speed already contains it
    # ``corners`` of the hull's rectangle, ``midship`` as in the paper, or an outline of (forward, starboard);
    # ``none`` in open water [m]
    contact: Contact | Points = "corners"
    bottom: bool = False  # True if bottom contact or a choked section ends a voyage

    def __post_init__(self) -> None:
        check_options(self.surge, self.surge_inertia, self.coriolis, self.contact)
        check_flag("bottom", self.bottom)
        if self.shape == OPEN and self.model.terms.has_bank:
            raise InputError("contact 'none' is open water, and these terms have a bank; choose 'corners'")
        if self.model.terms.propelled and self.model.configuration.propeller is None:
            raise InputError("this model's terms need a propeller; give [propeller] in its file")
        if self.surge == "free" and not self.values()["surge_inertia"] + self.model.surge_inertia > 0:
            raise InputError(
                "this model has no mass in surge (its tests held the speed), so a free speed needs an inertia: "
                "give surge_inertia in kg, mass and added mass together, or hold the speed"
            )

    @cached_property
    def shape(self) -> str | Outline:
        if isinstance(self.contact, str):
            return self.contact
        outline = tuple((float(forward), float(starboard)) for forward, starboard in self.contact)
        ship, has_bank = self.model.configuration.ship, self.model.terms.has_bank
        check_outline(ship, outline, has_bank)
        # The suction of a bank becomes infinite when a side meets it at midship: contact must not come later.
        return (*outline, (0.0, ship.beam / 2), (0.0, -ship.beam / 2)) if has_bank else outline

    @cached_property
    def actuators(self) -> tuple[Actuated, ...]:
        late = {"rudder"} if not self.model.configuration.gear.follows_at_once else set()
        return tuple(Actuated(one.name, one.angle, one.name in late) for one in self.model.terms.actuators)

    def system(
        self, waterway: bool = False, law: Law | None = None, pushed: Pushed = "never", across: Across = "none"
    ) -> System:
        contact = self.shape if isinstance(self.shape, str) else len(self.shape)
        choices = Choices(contact, waterway, law, pushed, self.bottom, across)
        return _system(self.model.terms, self.surge, self.coriolis, choices)

    def values(self, **positions: Number) -> dict[str, Number]:
        """Return every particular and coefficient by name, with the limits of the gear."""
        check_ahead(positions.get("revolutions"), self.model.configuration.propeller)
        # The equations add this to the table's own mass in surge; the user gives the sum.
        added = 0.0 if self.surge_inertia is None else self.surge_inertia - self.model.surge_inertia
        rest = {name: at for actuator in self.model.terms.actuators for name, at in actuator.at_rest().items()}
        ship = {**rest, **self.model.configuration.values(), **self.model.coefficients}
        for actuator in self.model.terms.actuators:
            if actuator.name in positions:
                ship |= {actuator.name: positions[actuator.name], **actuator.placed(positions[actuator.name])}
        return {**ship, "heave": 0.0, "surge_inertia": added}

    def channel(self, waterway: "Waterway | None", values: Mapping[str, Number]) -> Channel:
        if waterway is None:
            return straight_channel(values, self.shape, self.bottom)
        return along_waterway(waterway, self.model, self.shape, self.bottom)

    def linearisation(self, values: Mapping[str, Number]) -> Linearisation:
        return self.system().linearisation(values, self.actuators)

    def __getstate__(self) -> Mapping[str, Any]:
        # Workers trace the system themselves, or find it in the cache.
        return {name: value for name, value in self.__dict__.items() if name not in ("shape", "actuators")}


@lru_cache(maxsize=64)
def _system(terms: TermTable, surge: Any, coriolis: bool, choices: Choices) -> System:
    return System(terms, surge, coriolis, choices)


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


def steering_of(controller: Any, actuators: Sequence[Actuated], single: bool = True) -> Steering | None:
    """Trace a controller; an object or function of Python is one of single voyages in Python."""
    law, asked = controller, None
    if controller is None:
        return None
    if not isinstance(controller, ControlLaw):
        law, asked = ExternalOrder(), controller
        if not isinstance(controller, Controller) and (not callable(controller) or isinstance(controller, type)):
            raise InputError(
                f"a {type(controller).__name__} is no controller: it has neither `orders` (a law in arithmetic) "
                "nor `begin`, and is no function of time and state; nw.control.regulator(model, y, u) is one"
            )
        if not single:
            raise InputError(
                f"a {type(controller).__name__} steers in nw.simulate alone; write it as a law in arithmetic (with "
                "`parameters`, `memory` and `orders`), such as a regulator"
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
                has = f"it has {', '.join(known)}; add them" if known else "nw.borrow_rudder adds a rudder"
                raise InputError(f"{what} gives orders to {name}, for which this model has no terms: {has}")
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
