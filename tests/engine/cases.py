"""The matrix of voyages: ships, waterways, controllers, starts; each case by name, for voyages, fleets, reference."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import product
from typing import Any

import numpy as np
from reference import Reference

import narrows as nw
from narrows.model.tables import table_named
from narrows.simulation.controllers import CONTROLLERS, ControlLaw
from narrows.waterway import Bank, Centreline, Waterway

STEPS = {"paper": 0.02, "steered": 0.01, "mmg+delta": 0.0125}
"""Of the control law and of Runge-Kutta [s], short enough for times to 3e-7 s."""
ENDURANCE = {"paper": 25.0, "steered": 25.01, "mmg+delta": 30.01}
"""Longest time [s]; two of them no multiple of the step."""
COURSES, SURGES = ("straight", "waterway"), ("held", "free")
CONTACTS = ("corners", "midship", "outline", "none")
OUTLINE = ((0.5, 0.0), (0.36, 0.5), (-0.45, 0.5), (-0.5, 0.2), (-0.5, -0.2), (-0.45, -0.5), (0.36, -0.5))
"""A hull with a pointed bow: (forward over length, starboard over beam)."""
SUCTION, CUSHION = 1.07, 0.13
"""The paper's b_bank and c_bank."""
HELM = {"a_helm": 5.0, "b_helm": 6.0, "c_helm": 2.9}
CROSSFLOW = {"a_vv": 40.0, "a_vr": -300.0, "a_rr": 30.0, "b_vr": 120.0, "b_rv": -60.0, "c_vr": -45.0, "c_rv": 80.0}


@cache
def paper() -> nw.Model:
    """The published model."""
    return nw.published("mikkelsen2025_dtc")


@cache
def steered() -> nw.Model:
    """The published hull under the terms of ``steered``, its damping that of the paper at 1 m/s."""
    own = paper()
    lift = {f"{axis}_u{motion}": own.coefficients[f"{axis}_{motion}"] for axis in "bc" for motion in "vr"}
    table = nw.STEERED
    known = {**own.coefficients, **lift, **HELM, **CROSSFLOW}
    ship = replace(own.configuration.ship, flow_straightening=0.5, mass=260.0)
    configuration = replace(own.configuration, ship=ship, steering=nw.SteeringGear(25.0, 18.0))
    return nw.Model(configuration, table, {name: known[name] for name in table.names})


@cache
def mmg() -> nw.Model:
    """KVLCC2's published coefficients, and the paper's bank."""
    own = nw.published("yasukawa2015_kvlcc2")
    configuration = replace(own.configuration, canal=nw.Canal(14.0))
    table = mmg_with_bank()
    bank = {term.name: SUCTION for term in table.sway if term.from_bank}
    bank |= {term.name: CUSHION for term in table.yaw if term.from_bank}
    return nw.Model(configuration, table, {**own.coefficients, **bank})


def mmg_with_bank() -> nw.TermTable:
    """The table ``mmg+delta``, or the same by hand."""
    try:
        return table_named("mmg+delta")
    except nw.InputError:
        return nw.with_bank(nw.MMG, "delta")


SHIPS = {"paper": paper, "steered": steered, "mmg+delta": mmg}


@cache
def waterway_for(ship: str, mirrored: bool = False) -> Waterway:
    """Bends both ways of R = 5 L, banks that narrow and widen unlike, a current."""
    configuration = SHIPS[ship]().configuration
    return bent(configuration.ship.length, configuration.canal.width, mirrored)


def deep(way: Waterway, ship: str) -> Waterway:
    """The same, six drafts deep."""
    ends = np.array([0.0, way.line.length])
    return replace(way, depths=(ends, np.full(2, 6 * SHIPS[ship]().configuration.ship.draft)))


def bent(length: float, width: float, mirrored: bool = False) -> Waterway:
    """A waterway of 15 ship lengths, in which a ship of this length turns on the fifth of a radius."""
    wave = 15.0 * length
    amplitude = wave**2 / (4 * np.pi**2 * 5 * length)
    north = np.linspace(0, 2 * wave, 161)
    line = Centreline(np.stack([(-1) ** mirrored * amplitude * np.sin(2 * np.pi * north / wave), north], axis=1))
    s = line.length * np.array([0.0, 0.2, 0.3, 0.55, 0.7, 1.0])
    starboard, port = width * np.array([[0.5, 0.5, 0.45, 0.5, 0.6, 0.5], [0.5, 0.45, 0.5, 0.55, 0.5, 0.5]])
    if mirrored:
        starboard, port = port, starboard
    current = 0.08 * length**0.5
    return Waterway(
        line, Bank("starboard", s, starboard), Bank("port", s, port), current=current, name="bent", step=length / 800
    )


@dataclass(frozen=True)
class Case:
    """One cell of the matrix."""

    ship: str
    course: str
    surge: str
    controller: str
    contact: str

    def __str__(self) -> str:
        return "-".join((self.ship, self.course, self.surge, self.controller, self.contact))

    @cached_property
    def model(self) -> nw.Model:
        """Without the bank's terms where the banks are to be passed through."""
        model = SHIPS[self.ship]()
        return model.in_open_water() if self.contact == "none" else model

    @property
    def shape(self) -> Any:
        """The contact as ``simulate`` takes it."""
        own = self.model.configuration.ship
        return [(own.length * f, own.beam * s) for f, s in OUTLINE] if self.contact == "outline" else self.contact

    @property
    def law(self) -> ControlLaw | None:
        """The controller; a hull without a rudder has none."""
        length = self.model.configuration.ship.length
        return None if self.ship == "paper" else CONTROLLERS[self.controller](length)

    @property
    def speed(self) -> float:
        """At the start [m/s]."""
        return 1.179 if self.ship == "mmg+delta" else 1.0

    @property
    def starts(self) -> dict[str, np.ndarray]:
        """Where the voyages start, each column one voyage."""
        size = self.model.configuration.ship.length / 4
        at = 10.0 * size if self.course == "waterway" else 3.0
        starts = {
            "x": np.array([at, at + 1.0, at, at + 9.0, at]),
            "y": size * np.array([0.5, -0.7, 0.1, 1.1, 0.0]),
            "psi": np.array([0.02, 0.01, -0.05, 0.03, 0.3]),
            "u": self.speed * np.array([1.0, 1.0, 0.9, 1.1, 1.0]),
            "v": np.array([0.0, 0.01, 0.0, -0.02, 0.03]),
            "r": np.array([0.0, 0.002, 0.004, 0.0, -0.01]),
        }
        return starts if self.ship == "paper" else {**starts, "rudder": np.array([0.0, 0.05, -0.02, 0.0, 0.1])}

    @property
    def options(self) -> dict[str, Any]:
        """What voyages, fleets and the reference are told alike."""
        free = {"surge": "free"} | ({} if self.ship == "mmg+delta" else {"surge_inertia": 280.0})
        return free if self.surge == "free" else {"surge": "held"}

    @property
    def push(self) -> dict[str, float]:
        """Forces from outside [N, N, N m]; in surge what the towing carriage gave where there is no propeller."""
        thrust = 11.0 if self.surge == "free" and self.ship != "mmg+delta" else 0.0
        return {"X": thrust, "Y": 0.7, "N": -0.4}

    @property
    def waterway(self) -> Waterway | None:
        """Where the ship goes, unless in the model's own canal."""
        return waterway_for(self.ship) if self.course == "waterway" else None

    @property
    def dt(self) -> float:
        """Step [s]; a longer one in open water that is straight, where no bank draws the ship and nothing bends."""
        return (4 if (self.course, self.contact) == ("straight", "none") else 1) * STEPS[self.ship]

    @property
    def duration(self) -> float:
        """Longest time [s]."""
        return ENDURANCE[self.ship]

    def start(self, number: int) -> dict[str, float]:
        """One of the starts."""
        return {name: float(column[number]) for name, column in self.starts.items()}

    def reference(self, number: int) -> Reference:
        """The track of a start, shared by the contacts that let the ship go on as far."""
        return _reference(self.ship, self.course, self.surge, self.controller, self.contact == "none", number)


@cache
def _reference(ship: str, course: str, surge: str, controller: str, open_water: bool, number: int) -> Reference:
    case = Case(ship, course, surge, controller, "none" if open_water else "corners")
    return Reference(
        case.model, case.duration, case.dt, case.start(number), **case.options, forces=tuple(case.push.values()),
        waterway=case.waterway, controller=case.law, open_water=open_water,
    )  # fmt: skip


def matrix() -> Iterator[Case]:
    """Every cell that means something: a hull without a rudder has no controller."""
    for axes in product(SHIPS, COURSES, SURGES, CONTROLLERS, CONTACTS):
        case = Case(*axes)
        if case.ship != "paper" or case.controller == "constant":
            yield case


def axes_of(case: Case) -> tuple[str, ...]:
    """Its levels, in order."""
    return case.ship, case.course, case.surge, case.controller, case.contact


def mirrored(model: nw.Model) -> nw.Model:
    """A ship that turns to port as another turns to starboard."""
    configuration = model.configuration
    propeller, rudder = configuration.propeller, configuration.rudder
    if propeller is not None:
        wakes = {"wake_starboard": propeller.wake_port, "wake_port": propeller.wake_starboard}
        propeller = replace(propeller, **wakes)
    if rudder is not None:
        flows = (rudder.straightening_port, rudder.straightening_starboard)
        rudder = replace(rudder, straightening_starboard=flows[0], straightening_port=flows[1])
    return replace(model, configuration=replace(configuration, propeller=propeller, rudder=rudder))
