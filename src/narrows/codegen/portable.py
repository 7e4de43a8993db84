"""The equations of one ship as programs for other languages: the lines of the engine, by purpose."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy

from narrows.codegen.choices import COUNTED, LENGTH, Actuated, Choices, Law, control_names
from narrows.codegen.derivatives import coefficient_slopes, linear_slopes, with_tangents
from narrows.codegen.free_motion import INPUTS, OPEN, STATE, Expr, FreeMotion
from narrows.codegen.linearisation import LINEARISED
from narrows.codegen.lines import Lines, Program, real
from narrows.codegen.rates import Rates
from narrows.codegen.step import Step, least_clearance, rate_here, section_at, section_here, step_of
from narrows.codegen.trace import trace_of

# Name in the lines of a caller's order to an actuator with a gear.
ORDERED = "ordered_{}".format

# Derivative of a number along the direction that a caller gives.
ALONG = "along_{}".format

# Inputs of the lines from the table of a waterway.
PLACES = ("x_first", "x_last", "cells_a_metre", "last_cell")


@dataclass(frozen=True)
class Portable:
    """The engine's lines of one ship, with orders, forces and waterway as inputs."""

    # Actuators that are angles have a gear, which follows an order of the caller or of a law; the caller sets the
    # others.

    motion: FreeMotion  # The equations of motion
    names: tuple[str, ...]  # The coefficients
    actuators: tuple[Actuated, ...]  # Actuators of the model
    contact: str | int  # ``corners``, ``midship``, ``none``, or the number of points of an outline
    waterway: bool  # True if the section of the water changes
    law: Law | None = None  # Control law that gives the orders instead of a caller
    told: tuple[str, ...] = ()  # Parameters of the law, which a caller gives

    @property
    def geared(self) -> tuple[Actuated, ...]:
        return tuple(actuator for actuator in self.actuators if actuator.angle)

    @cached_property
    def choices(self) -> Choices:
        return Choices(self.contact, self.waterway, self.law or _followed(self.geared), "always")

    @property
    def kept(self) -> tuple[str, ...]:
        return self.choices.kept

    @cached_property
    def rates(self) -> Rates:
        """The rates of the state; everything that a caller may change counts as moving."""
        controls = [name for actuator in self.actuators for name in control_names(actuator)]
        section = ("width", "depth") if self.waterway else ()
        return Rates(self.motion, (*INPUTS.values(), *controls, *section), pushed=True)

    @cached_property
    def parameters(self) -> dict[str, Expr]:
        return self.rates.parameters

    @cached_property
    def programs(self) -> Mapping[str, Program]:
        (lines, rates), by, values = self._rates_here, Lines(), self._values
        if self.waterway:
            values, _ = section_here(by, self.rates, self.choices, values, "")
        more, entries = linear_slopes(lines, rates, self.actuators)
        rows = [entries[first : first + len(entries) // 6] for first in range(0, len(entries), len(entries) // 6)]
        programs = {
            "rates": Program.of(lines, [rates[name] for name in self.kept if name in rates]),
            "step": Program.of(self.step.lines, [self.step.out[name] for name in (*self.kept, "clearance", "side")]),
            "least_clearance": Program.of(*self._least_clearance),
            "by_state": Program.of(more, [entry for row in rows for entry in row[:6]]),
            "by_input": Program.of(more, [entry for row in rows for entry in row[6:]]),
            "by_coefficient": Program.of(by, coefficient_slopes(by, self.rates, self.names, values)),
        }
        if self.contact != OPEN:
            programs["clearance"] = self._clearance
        if self.waterway:  # Width and depth of the water at the ship's place
            here = Lines()
            at = section_at(here, self.choices, real("x"), ("starboard", "port", "depth"), "here")
            programs["section"] = Program.of(here, [at["starboard"] + at["port"], at["depth"]])
        return programs

    @cached_property
    def _rates_here(self) -> tuple[Lines, dict[str, Expr]]:
        lines = Lines()
        rates = rate_here(lines, self.rates, self.choices, self._values, "")
        return lines, {**rates, "psi": rates[COUNTED]}

    @cached_property
    def _least_clearance(self) -> tuple[Lines, tuple[Expr, Expr]]:
        lines = Lines()
        return lines, least_clearance(lines, self.choices, self._values)

    @property
    def _clearance(self) -> Program:
        """Clearance to starboard and to port; in a waterway from the least distance at which its banks can be met."""
        return Program.of(self._least_clearance[0], [real("clearance_starboard"), real("clearance_port")])

    @property
    def gear(self) -> tuple[str, ...]:
        return tuple(name for name in self.kept if name not in (*STATE, COUNTED))

    @cached_property
    def continuous(self) -> tuple[Program, ...]:
        """Rates of x, y, psi, u, v, r; those of the gear; and, between banks, the clearance to either side."""
        lines, rates = self._rates_here
        motion = Program.of(lines, [rates[name] for name in LINEARISED])
        # The rate equals that of a whole step.
        moved = [(self.step.out[name] - real(name)) / real(LENGTH) for name in self.gear]
        return motion, Program.of(self.step.lines, moved), *((self._clearance,) if self.contact != OPEN else ())

    def along(self, program: Program) -> Program:
        """Return the derivatives of a program's results along a direction in state, inputs and constants, ``ALONG``."""
        values = (*(value for _, value in program.assignments), *program.results)
        used, moving = set().union(*(sympy.sympify(value).free_symbols for value in values)), {*program.asked}
        seeds = {one: [real(ALONG(str(one)))] for one in used if str(one) in moving - {*PLACES, LENGTH}}
        for angle in ("psi", *(actuator.name for actuator in self.geared)):
            cosine, sine, along = real(f"cos_{angle}"), real(f"sin_{angle}"), real(ALONG(angle))
            seeds |= {name: [way] for name, way in ((cosine, -sine * along), (sine, cosine * along)) if name in seeds}
        lines, slopes_of = with_tangents(Lines(list(program.assignments)), seeds, 1)
        return Program.of(lines, [slopes_of(result)[0] for result in program.results])

    @property
    def _values(self) -> dict[str, Expr]:
        return {name: real(name) for name in (*STATE, *self.rates.moving)}

    @property
    def inputs(self) -> tuple[str, ...]:
        """Inputs that a caller may change from step to step, by their names in the lines."""
        orders = [ORDERED(one.name) if one.angle else one.name for one in self.actuators]
        known = (*INPUTS.values(), *orders, *self.told, *(("current",) if self.waterway else ()))
        return tuple(name for name in known if name in self.programs["step"].asked)

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of the constants in ``rates.constants``; the derivatives need more than the rates."""
        assert self.programs
        return self.rates.constants.names

    @property
    def hull(self) -> tuple[str, ...]:
        """Further constants of step and clearance: hull, walls, gear."""
        asked = {name for own in ("step", "least_clearance") for name in self.programs[own].asked}
        return tuple(sorted(asked - {*self.constants, *self.kept, *self.inputs, *PLACES, LENGTH}))

    @cached_property
    def step(self) -> Step:
        """A whole step, with the places where a loop over vessels may be split."""
        return step_of(self.rates, self.choices).with_whole_steps()


def _followed(actuators: Sequence[Actuated]) -> Law | None:
    if not actuators:
        return None
    names = {ORDERED(actuator.name): ORDERED(actuator.name) for actuator in actuators}
    trace = trace_of(
        lambda at: {actuator.name: getattr(at, ORDERED(actuator.name)) for actuator in actuators},
        {**names, "dt": LENGTH},
        "the gear",
    )
    return Law(trace, (), tuple(actuators))
