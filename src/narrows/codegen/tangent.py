"""The tangent of a voyage: a step with the slopes of everything it keeps, directions as lanes.

The lines of the step and their partial derivatives are floats, written once; the slopes along the directions are one
loop over a block of lanes, which LLVM vectorises, so that a direction costs a few additions and products a line.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from narrows.codegen.choices import LENGTH, ROW
from narrows.codegen.derivatives import with_tangents
from narrows.codegen.free_motion import Expr
from narrows.codegen.kernels.elementary import HEADER, elementary_text
from narrows.codegen.lines import Assignment, Lines, real
from narrows.codegen.lowering import straight_lines
from narrows.codegen.printers.python import Arithmetic, function_text
from narrows.codegen.rates import Rates
from narrows.codegen.step import Step

# Lanes of a block; more directions take more passes.
DIRECTIONS = 32
SLOPE = "d_{}".format


@dataclass(frozen=True)
class Tangent:
    """A step and its slopes, parted into what is a float and what is a lane."""

    step: Step  # Whole steps
    kept: tuple[str, ...]  # What goes from step to step
    moving: tuple[str, ...]  # Inputs that have slopes, beside what is kept

    @cached_property
    def _program(self) -> tuple[Lines, dict[str, Expr], dict[str, Expr]]:
        out = {name: self.step.out[name] for name in self.kept}
        seeds = {real(name): [real(SLOPE(name))] for name in (*self.kept, *self.moving)}
        lines, slopes_of = with_tangents(self.step.lines.needed_for(list(out.values())), seeds, 1)
        slopes = {name: slopes_of(value)[0] for name, value in out.items()}
        return lines.needed_for([*out.values(), *slopes.values()]), out, slopes

    @cached_property
    def _parts(self) -> tuple[list[Assignment], list[Assignment]]:
        """The lines of floats, and those of lanes: what any slope enters."""
        lanes = {real(SLOPE(name)) for name in (*self.kept, *self.moving)}
        floats: list[Assignment] = []
        slopes: list[Assignment] = []
        for name, value in self._program[0].assignments:
            if value.free_symbols & lanes:
                lanes.add(name)
                slopes.append((name, value))
            else:
                floats.append((name, value))
        return floats, slopes

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        """What the step asks for beside what is kept; those with slopes first."""
        asked = {*self._program[0].inputs, LENGTH}
        asked |= {str(s) for value in self._program[1].values() for s in value.free_symbols}
        made = {str(name) for name, _ in self._program[0].assignments}
        known = {SLOPE(name) for name in (*self.kept, *self.moving)}
        rest = sorted(asked - made - known - {*self.kept, *self.moving})
        return (*self.moving, *rest)

    def text(self, printer: Arithmetic) -> str:
        """Print the function ``step(z, block, inputs, table)``, in place."""
        body = "\n    ".join(self._body(printer))
        return f"@jit\ndef step(z, block, inputs, table):\n    {body}\n"

    def _body(self, printer: Arithmetic) -> Iterator[str]:
        floats, slopes = self._parts
        _, out, slopes_out = self._program
        yield from (f"{name} = z[{i}]" for i, name in enumerate(self.kept))
        yield from (f"{name} = inputs[{i}]" for i, name in enumerate(self.inputs))
        yield from (f"{name} = {printer.doprint(value)}" for name, value in floats)
        yield from (f"z[{i}] = {printer.doprint(out[name])}" for i, name in enumerate(self.kept))
        yield f"for lane in range({DIRECTIONS}):"
        fields = (*self.kept, *self.moving)
        yield from (f"    {SLOPE(name)} = block[{i * DIRECTIONS} + lane]" for i, name in enumerate(fields))
        yield from (f"    {name} = {printer.doprint(value)}" for name, value in slopes)
        for i, name in enumerate(self.kept):
            yield f"    block[{i * DIRECTIONS} + lane] = {printer.doprint(slopes_out[name])}"


def tangent_text(step: Step, kept: tuple[str, ...], moving: Sequence[str], version: str) -> str:
    """Write the module that sails a voyage with its slopes."""
    tangent, printer = Tangent(step.with_whole_steps(), kept, tuple(moving)), Arithmetic(column="{:.1f}".format)
    body = tangent.text(printer)
    numbers = {"KEPT": len(kept), "MOVING": len(moving), "DIRECTIONS": DIRECTIONS, "CELL_ENTRIES": ROW}
    numbers["LENGTH"] = tangent.inputs.index(LENGTH)
    names = {"KEPT_NAMES": kept, "INPUTS": tangent.inputs}
    return "\n\n".join(
        [
            HEADER.format(version=version, precision="float64"),
            "\n".join(f"{name} = {value!r}" for name, value in (numbers | names).items()),
            elementary_text(body, "float64"),
            body,
            Path(__file__).with_name("kernels").joinpath("sensitivity.py").read_text(encoding="utf-8"),
        ]
    )


def constants_text(rates: Rates) -> str:
    """Write the function of the slopes of what stays the same through a voyage."""
    constants, names = rates.constants, rates.motion.names
    assignments, results = straight_lines(list(constants.table))
    used = set().union(*(expression.free_symbols for expression in constants.table))
    asked = {name: symbol for name, symbol in names.items() if symbol in used}
    lines = Lines()
    values = lines.inline("", assignments, results, {})
    seeds = {symbol: [real(SLOPE(symbol))] for symbol in asked.values()}
    more, slopes_of = with_tangents(lines, seeds, 1)
    slopes = [slopes_of(value)[0] for value in values]
    arguments = [*map(str, asked.values()), *(SLOPE(symbol) for symbol in asked.values())]
    text = function_text("constants_slopes", arguments, more.needed_for(slopes).assignments, slopes)
    return f"PARAMETERS = {tuple(asked)!r}\n\n\n{text}"
