"""Functions of a model as text: those of floats or columns, and those of fleets as loops over a block of lanes.

Each round of a step is a loop of its own, since a long loop is a longer chain than a processor looks ahead. No loop
branches on data, so that it is written as vectors.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import sympy

from narrows.codegen.choices import BOOK, LANES, SHARED, Choices
from narrows.codegen.free_motion import MIDSHIP, OPEN, STATE, Expr
from narrows.codegen.lines import LaneFields, Lines, asked_by, real, rounds
from narrows.codegen.printers.python import constants_text, function_text, module_text, plain
from narrows.codegen.step import Rates, Step, ends_left, least_clearance, step_of

SPEED_LIMITS = {"u": "most_speed", "v": "most_speed", "r": "most_rate"}
# Margin [m] to an end that a voyage cannot meet, and the ends but a bank.
UNREACHED = sympy.Integer(10) ** 9
ENDS = ("heading", "ahead", "astern", "afloat")


def plain_text(choices: Choices, rates: Rates) -> str:
    """Write constants, rates, step and clearance of a system as functions of floats or columns."""
    kept, lines, ends, state = choices.kept, Lines(), Lines(), {name: real(name) for name in STATE}
    clearance, side = least_clearance(lines, choices, state)
    left = dict(zip(ENDS, ends_of(ends, choices, state), strict=True))
    step, (program, derivatives) = step_of(rates, choices), rates.program()
    parts = [
        '"""Made by narrows from a table of terms: made again where it is missing, so do not edit."""\n',
        constants_text(rates.parameters, rates.constants),
        _function("rates", program, {name: derivatives[name] for name in STATE}, STATE),
        _function("step", step.lines, {name: step.out[name] for name in (*kept, "clearance", "side")}, kept, "table"),
        _function("least_clearance", lines, {"clearance": clearance, "side": side}, STATE[:5], "table"),
        _function("ends", ends, left, STATE[:5], "table"),
    ]
    return "\n\n".join(parts)


def _function(name: str, lines: Lines, out: Mapping[str, Expr], first: tuple[str, ...], *table: str) -> str:
    program, results = lines.needed_for(list(out.values())).assignments, [*out.values()]
    rest = tuple(sorted({*asked_by(program, results)} - {*first}))
    text = function_text(name, (*table, *first, *rest), program, results)
    return f"{name.upper()}_INPUTS = {rest!r}\n\n\n{text}"


def ends_of(lines: Lines, choices: Choices, state: Mapping[str, Expr]) -> tuple[Expr, ...]:
    left = ends_left(lines, choices, state)
    return tuple(left.get(name, UNREACHED) for name in ENDS)


def kernel_text(choices: Choices, rates: Rates) -> str:
    step = step_of(rates, choices, whole=True)
    out = tuple(step.out.values())
    needed = step.lines.needed_for(out)
    inputs = {*asked_by(needed.assignments, out), *SPEED_LIMITS.values()} - {*choices.kept, *BOOK}
    vessel_inputs = tuple(sorted(inputs - {*SHARED}))
    fields = (*BOOK, *choices.kept, *(f"old {name}" for name in choices.kept), *vessel_inputs)
    lanes = Lanes(step, choices, tuple(sorted(inputs & {*SHARED})), LaneFields(rounds(needed), out, fields))
    numbers = {
        "LANES": LANES, "FIELDS": lanes.layout.size, "KEPT_NAMES": choices.kept, "VESSEL_INPUTS": vessel_inputs,
        "EXACT": choices.waterway and choices.contact not in (MIDSHIP, OPEN), "LEAVES": choices.leaves,
    }  # fmt: skip
    names = "\n".join(f"{name} = {value!r}" for name, value in numbers.items())
    return module_text(choices.row, names, *lanes.end_texts(), lanes.text())


@dataclass(frozen=True)
class Lanes:
    """A block of vessels, (fields, lanes)."""

    step: Step  # The program
    choices: Choices
    shared: tuple[str, ...]  # Inputs that all vessels share
    layout: LaneFields

    def place(self, name: str, first: str = "") -> str:
        if name in SHARED:
            return f"shared[{SHARED.index(name)}]"
        return f"block[{first * (name in self.choices.kept)}{self.layout.fields[name]}, lane]"

    def end_texts(self) -> Iterator[str]:
        state, own, ends = {name: real(name) for name in STATE}, Lines(), Lines()
        for name, lines, results, first in (
            ("clearance_of", own, least_clearance(own, self.choices, state), ""),
            ("ends_of", ends, ends_of(ends, self.choices, state), "first"),
        ):
            arguments = ("block", "lane", *filter(None, [first]), "table", "shared")
            head = [f"{one} = {self.place(one, f'{first} + ' * bool(first))}" for one in lines.inputs]
            yield function_text(name, arguments, lines.assignments, results, head)

    def text(self) -> str:
        """Print the function ``step(block, table, shared)``, which returns whether any lane needs attention."""
        body = [*(f"{name} = {self.place(name)}" for name in self.shared), "all_well = True"]
        for number, part in enumerate(self.layout.parts):
            body.append(f"for lane in range({LANES}):")
            body += [f"    {line}" for line in self._round(number, part)]
        return "\n    ".join(["def step(block, table, shared):", *body, "return any_false(all_well)"]) + "\n"

    def _round(self, number: int, part: Sequence[tuple[Expr, Expr]]) -> Iterator[str]:
        last = number == len(self.layout.parts) - 1
        read = self.layout.read(number) | (set(self.choices.kept) if last else set())
        yield from (f"{name} = {self.place(name)}" for name in sorted(read - {*self.shared}))
        yield from (f"{target} = {plain.doprint(value)}" for target, value in part)
        yield from (f"{self.place(name)} = {name}" for name in self.layout.stored(number))
        if last:
            yield from self._close()

    def _close(self) -> Iterator[str]:
        out = {name: plain.doprint(sympy.sympify(value)) for name, value in self.step.out.items()}
        yield from (f"{self.place(f'old {name}')} = {name}" for name in self.choices.kept)
        yield f"clearance_before = {self.place('clearance')}"
        yield f"{self.place('clearance_before')} = clearance_before"
        stored = (name for name in ("clearance", "side", *self.choices.kept) if name in out)
        yield from (f"{self.place(name)} = {out[name]}" for name in stored)
        yield f"left = {self.place('left')} - 1.0"
        yield f"{self.place('left')} = left"
        must = f"{self.choices.leaves!r} * clearance_before" if self.choices.leaves else "0.0"
        sane = " & ".join(f"(abs({out[name]}) < {most})" for name, most in SPEED_LIMITS.items())
        yield f"well = (left > 0.0) & ({out['clearance']} > {must}) & {sane}"
        yield f"{self.place('flag')} = where(well, 0.0, 1.0)"
        yield "all_well = all_well & well"
