"""A ship prepared for export: the lines of the engine by purpose, and their numbers with unit and meaning."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import sympy
from sympy import Float

from narrows.base.errors import InputError
from narrows.base.files import is_stream
from narrows.codegen.free_motion import AFLOAT_SPEED, INPUTS, LENGTH, OPEN, Actuated, Choices, Law, exact_number
from narrows.codegen.kernel import coefficient_slopes, linear_slopes
from narrows.codegen.linearisation import LINEARISED
from narrows.codegen.lines import FUNCTIONS, Expr, Lines, Program, real, straight_lines
from narrows.codegen.step import Rates, least_clearance, rate_here, section_at, section_here, step_of
from narrows.codegen.system import DEFAULTS
from narrows.codegen.trace import trace_of
from narrows.export.passport import RANGE_BITS, passport
from narrows.model.model import Model
from narrows.model.water import speeds_afloat
from narrows.physics.squat_and_depth import BOUNDLESS
from narrows.quantities.arithmetic import minimum
from narrows.quantities.names import FORCES, REGRESSOR_INPUTS, Quantity
from narrows.simulation.settings import NEAR_THE_BANK
from narrows.simulation.ship import Channel, SimulatedShip, Steering, steering_of
from narrows.waterway.centreline import check_along_only
from narrows.waterway.waterway import Waterway

USUAL_PREFIX = "ship"
ORDERED = "ordered_{}".format  # Name in the lines of a caller's order to an actuator with a gear
# Inputs of the lines from the table of a waterway.
PLACES = ("x_first", "x_last", "cells_a_metre", "last_cell")
HEADING = "heading, positive clockwise seen from above"
WALLS = ("wall_starboard", "wall_port")
FORCES_FROM_OUTSIDE = {
    INPUTS[force]: Quantity(quantity.unit, f"{quantity.meaning}, from outside") for force, quantity in FORCES.items()
}
OTHERS = {
    "current": Quantity("m/s", "current along the line of the waterway where its flow is 1"),
    "counted_psi": Quantity("rad", "heading that counts whole turns"), "t": Quantity("s", "time"),
    "surge_inertia": Quantity("kg", "added to the mass in surge"),
}  # fmt: skip
OF_HULL = Quantity("m", "of the hull that meets a bank")
# Unit and meaning of an actuator's limits, by the ending of the name.
GEAR = {
    "limit": ("{}", "largest size"), "rate": ("{}/s", "fastest change"), "dead_time": ("s", "dead time"),
    "lag": ("s", "time constant"), "dead_band": ("{}", "dead band"),
}  # fmt: skip
DELAYED = "order on its way to the {}: begin where the actuator is"
PARTICULARS = ("length", "beam", "draft", "block_coefficient")  # Particulars that relate a section to the ship
ALWAYS = ("hull_length", "least_cos", "near_bank")  # Constants that the rule of a voyage needs, whatever the hull


@dataclass(frozen=True)
class ExportedNumber:
    name: str  # Name in the file
    value: float  # Default
    unit: str  # SI unit
    meaning: str  # Meaning in words


@dataclass(frozen=True)
class ExportedShip:
    ship: SimulatedShip  # Model under its choices
    waterway: Waterway | None = None  # Its table goes into the file if the section changes along the way
    prefix: str = USUAL_PREFIX  # Prefix of the names in the file
    steering: Steering | None = None  # Control law that gives the orders instead of a caller

    @classmethod
    def of(
        cls, model: Model, path: str | Path, waterway: Waterway | None = None, controller: Any = None, **choices: Any
    ) -> "ExportedShip":
        """Return a ship under its choices with its control law; names begin with that of the file."""
        if waterway is not None:
            check_along_only(waterway, "a file")
        ship = SimulatedShip(model, **choices)
        return cls(ship, waterway, prefix_of(path), steering_of(controller, ship.actuators, single=False))

    # Actuators that are angles have a gear, which follows an order of the caller or of the law; the caller sets the
    # others.

    @cached_property
    def geared(self) -> tuple[Actuated, ...]:
        return tuple(actuator for actuator in self.ship.actuators if actuator.angle)

    @cached_property
    def choices(self) -> Choices:
        shape, law = self.ship.shape, self.steering.law if self.steering else None
        if self.geared and not law:
            names = {actuator.name: ORDERED(actuator.name) for actuator in self.geared}
            trace = trace_of(
                lambda at: {name: getattr(at, order) for name, order in names.items()},
                {**{order: order for order in names.values()}, "dt": LENGTH},
                "the gear",
            )
            law = Law(trace, (), self.geared)
        return Choices(shape if isinstance(shape, str) else len(shape), self.waterway is not None, law, "always")

    @property
    def kept(self) -> tuple[str, ...]:
        return self.choices.kept

    @cached_property
    def rates(self) -> Rates:
        """The rates of the state; everything that a caller may change counts as moving."""
        controls = [name for actuator in self.ship.actuators for name in actuator.controls]
        section = ("width", "depth") if self.waterway else ()
        return Rates(self.ship.system().rates.motion, (*INPUTS.values(), *controls, *section), pushed=True)

    @cached_property
    def step(self) -> tuple[Lines, dict[str, Expr]]:
        """A whole step and its results, with the places where a loop over vessels may be split."""
        return step_of(self.rates, self.choices, whole=True)

    @cached_property
    def _rates_here(self) -> tuple[Lines, dict[str, Expr]]:
        lines = Lines()
        rates = rate_here(lines, self.rates, self.choices, self.rates.symbols, "")
        return lines, {**rates, "psi": rates["counted_psi"]}

    @cached_property
    def _equations(self) -> dict[str, Program]:
        (lines, rates), (step, after), by, near = self._rates_here, self.step, Lines(), Lines()
        symbols = self.rates.symbols
        if self.waterway:
            symbols, _ = section_here(by, self.rates, self.choices, symbols, "")
        more, entries = linear_slopes(lines, rates, self.ship.actuators)
        rows = [entries[first : first + len(entries) // 6] for first in range(0, len(entries), len(entries) // 6)]
        names = self.ship.model.terms.names
        programs = {
            "rates": Program.of(lines, [rates[name] for name in self.kept if name in rates]),
            "step": Program.of(step, [after[name] for name in (*self.kept, "clearance", "side")]),
            "least_clearance": Program.of(near, least_clearance(near, self.choices, self.rates.symbols)),
            "by_state": Program.of(more, [entry for row in rows for entry in row[:6]]),
            "by_input": Program.of(more, [entry for row in rows for entry in row[6:]]),
            "by_coefficient": Program.of(by, coefficient_slopes(by, self.rates, names, symbols)),
        }
        if self.ship.shape != OPEN:
            # To starboard and to port; in a waterway from the least distance at which its banks can be met.
            programs["clearance"] = Program.of(near, [real("clearance_starboard"), real("clearance_port")])
        if self.waterway:  # Width and depth of the water at the ship's place
            here = Lines()
            at = section_at(here, self.choices, real("x"), ("starboard", "port", "depth"), "here")
            programs["section"] = Program.of(here, [at["starboard"] + at["port"], at["depth"]])
        return programs

    @cached_property
    def programs(self) -> Mapping[str, Program]:
        """Programs of the equations, and of their constants; ``section`` gives ``_over_ship`` at a place."""
        programs = dict(self._equations)  # The derivatives need more constants than the rates: those come last
        parts = [straight_lines([*self.rates.constants.table]), straight_lines([*self._derived.values()], "s")]
        constants, results = ([one for part in parts for one in part[kind]] for kind in (0, 1))
        programs["constants"] = Program(tuple(constants), tuple(results))
        if self.waterway:
            place = programs["section"]
            lines, results = straight_lines([*_over_ship(*place.results).values()])
            programs["section"] = Program((*place.assignments, *lines), tuple(results))
        return programs

    @cached_property
    def continuous(self) -> tuple[Program, Program]:
        """Rates of x, y, psi, u, v, r, and those of the gear."""
        (lines, rates), (step, after) = self._rates_here, self.step
        motion = Program.of(lines, [rates[name] for name in LINEARISED])
        # The rate equals that of a whole step.
        moved = [(after[name] - real(name)) / real(LENGTH) for name in self.choices.gear]
        return motion, Program.of(step, moved)

    @cached_property
    def water(self) -> dict[str, Expr]:
        """Return the numbers of the water that ``beyond`` reads; in a waterway ``section`` gives them."""
        if self.waterway:
            return _over_ship(real("width"), real("depth"))
        found = _over_ship(sympy.oo if self.ship.shape == OPEN else real("width"), real("depth"))
        absent = {"width_to_beam"} if self.ship.shape == OPEN else set[str]()
        absent |= {"depth_to_draft", AFLOAT_SPEED} if self._values.get("depth") is None else set()
        return {name: value for name, value in found.items() if name not in absent}

    @property
    def constants(self) -> tuple[str, ...]:
        derived = self._derived  # The derivatives need more constants than the rates
        return (*self.rates.constants.names, *derived)

    @cached_property
    def _derived(self) -> dict[str, Expr]:
        known: dict[str, Any] = {
            "half_length": real("length") / 2, "half_beam": real("beam") / 2,
            "least_cos": Float(self.channel.inputs["least_cos"], 17),
            "near_bank": Float(NEAR_THE_BANK, 17) * real("width"), "hull_length": real("length"),
            **{name: real("width") / 2 for name in WALLS if name not in self._values}, **self.water,
        }  # fmt: skip
        asked = {name for own in ("step", "least_clearance") for name in self._equations[own].asked}
        asked -= {*self.rates.constants.names, *self.kept, *self.input_names, *PLACES, LENGTH}
        asked |= {*ALWAYS, *(PARTICULARS if self.waterway else self.water)}
        return {name: known.get(name, real(name)) for name in sorted(asked)}

    @cached_property
    def _values(self) -> dict[str, Any]:
        outline = {name: value for name, value in self.channel.inputs.items() if name.startswith("outline_")}
        return {**DEFAULTS, **self.ship.values(), **outline}

    @cached_property
    def channel(self) -> Channel:
        return self.ship.channel(self.waterway, self.ship.values())

    @cached_property
    def parameters(self) -> tuple[ExportedNumber, ...]:
        symbols = {str(symbol): name for name, symbol in self.rates.parameters.items()}
        known = {name: symbols.get(name, name) for name in self.programs["constants"].asked}
        for name in known.values():
            if self._values.get(name) is None:
                raise InputError(f"the equations of motion need {name}; give it in the ship or the model file")
        return tuple(
            ExportedNumber(name, float(np.ravel(self._values[own])[0]), *self._quantities.get(own, OF_HULL))
            for name, own in known.items()
        )

    @cached_property
    def _quantities(self) -> dict[str, Quantity]:
        """Unit and meaning of every number, by its name in the lines."""
        terms, steering = self.ship.model.terms, self.steering
        known = {**REGRESSOR_INPUTS, **FORCES_FROM_OUTSIDE, **OTHERS}
        for one, traced in zip(terms.actuators, self.ship.actuators, strict=True):
            order = Quantity(one.unit, f"ordered {one.meaning}")
            known |= {**one.quantities, one.name: Quantity(one.unit, one.meaning), ORDERED(one.name): order}
            known |= dict.fromkeys(traced.stages, Quantity(one.unit, DELAYED.format(one.name)))
            for of, (unit, meaning) in GEAR.items():
                known[f"{one.name}_{of}"] = Quantity(unit.format(one.unit), f"{meaning} of the {one.name}")
        for term in terms.terms:
            ends = zip(("least", "most"), term.bound, strict=True)
            limits = "".join(f", at {word} {end:g}" for word, end in ends if np.isfinite(end))
            known[term.name] = Quantity(term.dimension.unit, f"coefficient {term.name}, {term.kind.value}{limits}")
        for name in (*steering.parameters, *steering.law.memory) if steering else ():
            known[name] = Quantity("1", f"{name.partition('_')[2]} of the controller, in SI units")
        return known

    @cached_property
    def input_names(self) -> tuple[str, ...]:
        """Names in the lines of the ``inputs``."""
        orders = [ORDERED(one.name) if one.angle else one.name for one in self.ship.actuators]
        of_law = self.steering.parameters if self.steering else ()
        known = (*INPUTS.values(), *orders, *of_law, *(("current",) if self.waterway else ()))
        return tuple(name for name in known if name in self._equations["step"].asked)

    @cached_property
    def inputs(self) -> tuple[ExportedNumber, ...]:
        given: dict[str, Any] = {one.name: self._values.get(one.name) or 0.0 for one in self.ship.actuators}
        given |= self.steering.parameters if self.steering else {}
        given |= {"current": self.waterway.reference_current} if self.waterway else {}
        called = {ORDERED(one.name): f"{one.name}_order" for one in self.geared}
        return tuple(
            ExportedNumber(called.get(name, name), float(given.get(name, 0.0)) + 0.0, *self._quantities[name])
            for name in self.input_names
        )

    @cached_property
    def state(self) -> tuple[ExportedNumber, ...]:
        start = {**dict.fromkeys(self.kept, 0.0), "cos_psi": 1.0}
        start |= self.steering.memory(start) if self.steering else {}
        return tuple(ExportedNumber(name, float(start[name]), *self._quantities[name]) for name in self.kept)

    @property
    def controls(self) -> tuple[str, ...]:
        return (*INPUTS.values(), *(actuator.name for actuator in self.ship.actuators))

    @cached_property
    def afloat_speed(self) -> float:
        """Least speed through the water at which the ship touches the bottom or chokes a section [m/s]."""
        channel = replace(self.ship, bottom=True).channel(self.waterway, self.ship.values())
        if self.waterway is None:
            return float(channel.inputs[AFLOAT_SPEED])
        first, rise = channel.table.reshape(int(channel.inputs["last_cell"]) + 1, -1)[:, -2:].T
        return float(np.minimum(first, first + rise).min())

    def about(self) -> Iterator[str]:
        yield from passport(self.ship.model)
        on = f" Voyages go on, and beyond has {RANGE_BITS['bottom'][0]}."
        yield self.bottom_note + on * (self.afloat_speed < BOUNDLESS)

    @property
    def bottom_note(self) -> str:
        fast = self.afloat_speed
        until = f" From {fast:.4g} m/s the ship touches it or chokes the section." if fast < BOUNDLESS else ""
        return f"This file does not model the bottom.{until}"


def _over_ship(width: Expr, depth: Expr) -> dict[str, Expr]:
    """Return the section over the ship, and the speed at which the ship touches the bottom or chokes the section."""
    names = {name: name for name in (*PARTICULARS, "width", "depth")}
    trace = trace_of(lambda at: {AFLOAT_SPEED: minimum(*speeds_afloat(vars(at)))}, names, "the speed afloat")
    symbols = {**{name: real(name) for name in PARTICULARS}, "width": width, "depth": depth}
    afloat = trace.replay(symbols, exact_number, FUNCTIONS)
    return {"width_to_beam": width / real("beam"), "depth_to_draft": depth / real("draft"), **afloat}


def prefix_of(path: str | Path) -> str:
    stem = re.sub(r"\W+", "_", Path(path).stem, flags=re.ASCII).strip("_")
    return USUAL_PREFIX if is_stream(path) or not stem else stem if stem[0].isalpha() else f"{USUAL_PREFIX}_{stem}"
