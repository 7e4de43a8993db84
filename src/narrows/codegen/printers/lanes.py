"""Lines as loops over lanes: a block of vessels, field after field in one flat array.

Each round of the program is a loop of its own, since a long loop is a longer chain than a processor looks ahead. No
loop branches on data, so that it is written as vectors.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy

from narrows.codegen.choices import BOOK, SHARED
from narrows.codegen.free_motion import STATE, Expr
from narrows.codegen.lines import Assignment, Lines, rounds
from narrows.codegen.printers.python import Arithmetic
from narrows.codegen.rates import ITEM, RATES, CalledRates
from narrows.codegen.step import Step

SPEED_LIMITS = {"u": "most_speed", "v": "most_speed", "r": "most_rate"}


# Places of numbers that one loop over lanes computes and a later one reads.
@dataclass(frozen=True)
class LaneFields:
    """Fields of a lane; a field is reused once its number is no longer needed."""

    parts: Sequence[Sequence[Assignment]]  # The rounds, one loop over lanes each
    results: tuple[Expr, ...]  # Results of the last round
    first: tuple[str, ...] = ()  # Numbers with the first fields, never reused

    @cached_property
    def _last_use(self) -> dict[str, int]:
        """The last round in which each number is read."""
        last = {name: number for number, part in enumerate(self.parts) for _, value in part for name in names_in(value)}
        return last | {name: len(self.parts) - 1 for value in self.results for name in names_in(value)}

    @cached_property
    def fields(self) -> dict[str, int]:
        """The field of each number that lives from round to round."""
        index = {name: number for number, name in enumerate(self.first)}
        total, free, busy = len(index), list[int](), list[str]()
        for number, part in enumerate(self.parts):
            for name in [name for name in busy if self._last_use[name] < number]:
                busy.remove(name)
                free.append(index[name])
            for name in (str(target) for target, _ in part):
                if self._last_use.get(name, -1) > number:
                    index[name] = free.pop() if free else total
                    total += index[name] == total
                    busy.append(name)
        return index

    @property
    def size(self) -> int:
        return max(self.fields.values(), default=-1) + 1

    def read(self, number: int) -> set[str]:
        """Return the inputs of a round; the last one also needs the results."""
        part = self.parts[number]
        values = [*(value for _, value in part), *(self.results if number == len(self.parts) - 1 else ())]
        return {name for value in values for name in names_in(value)} - {str(target) for target, _ in part}

    def stored(self, number: int) -> list[str]:
        """Return the numbers that later rounds need, in alphabetical order."""
        made = {str(target) for target, _ in self.parts[number]}
        return sorted(name for name in made if self._last_use.get(name, -1) > number)


class LaneArithmetic(Arithmetic):
    """Arithmetic of one lane, which calls the rates of the same lane."""

    def _print_Function(self, value: Expr) -> str:
        if value.func == RATES:
            return self.called("rates", "block", "lane", *map(self._print, value.args))
        if value.func == ITEM:
            return f"{self._print(value.args[0])}[{value.args[1]}]"
        return str(super()._print_Function(value))


@dataclass(frozen=True)
class Lanes:
    rates: CalledRates
    step: Step  # The program, which calls the rates
    kept: tuple[str, ...]  # Quantities carried from step to step
    count: int  # Lanes of a block

    @cached_property
    def _rates_program(self) -> tuple[Lines, list[Expr]]:
        lines, rates = self.rates.program()
        results = [rates[name] for name in STATE]
        return lines.needed_for(results), results

    @cached_property
    def parts(self) -> list[list[Assignment]]:
        """The rounds, without unused lines."""
        return rounds(self.step.lines.needed_for(list(self.step.out.values())))

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        """Inputs of the program besides the state and the queue's fields."""
        made = {str(name) for part in self.parts for name, _ in part}
        asked = {name for part in self.parts for _, value in part for name in names_in(value)}
        asked |= {name for value in self.step.out.values() for name in names_in(value)}
        asked |= {*SPEED_LIMITS.values(), *self._rates_inputs}
        return tuple(sorted(asked - made - {*self.kept, *BOOK}))

    @cached_property
    def _rates_inputs(self) -> list[str]:
        """Inputs of the rates besides the arguments of their calls."""
        lines, results = self._rates_program
        asked = {*lines.inputs, *(name for rate in results for name in names_in(rate))}
        return sorted(asked - {*self.rates.arguments, *(str(name) for name, _ in lines.assignments)})

    @property
    def vessel_inputs(self) -> tuple[str, ...]:
        return tuple(name for name in self.inputs if name not in SHARED)

    @property
    def shared_inputs(self) -> tuple[str, ...]:
        return tuple(name for name in self.inputs if name in SHARED)

    @cached_property
    def layout(self) -> LaneFields:
        names = (*BOOK, *self.kept, *(f"old {name}" for name in self.kept), *self.vessel_inputs)
        return LaneFields(self.parts, tuple(self.step.out.values()), names)

    def entry(self, name: str) -> str:
        return f"block[{self.layout.fields[name] * self.count} + lane]"

    def rates_text(self, printer: Arithmetic) -> str:
        """Print the function ``rates(block, lane, ...)`` of one lane."""
        lines, results = self._rates_program
        body = [f"{name} = {self.entry(name)}" for name in self._rates_inputs]
        body += [f"{target} = {printer.doprint(value)}" for target, value in lines.assignments]
        body.append(f"return ({', '.join(map(printer.doprint, results))},)")
        return "\n    ".join([f"def rates(block, lane, {', '.join(self.rates.arguments)}):", *body]) + "\n"

    def text(self, printer: Arithmetic, leaves: float = 0.0) -> str:
        """Print the function ``step(block, table, shared)``, which returns whether any lane needs attention."""
        head = [f"{name} = shared[{SHARED.index(name)}]" for name in self.shared_inputs]
        body = [*head, "all_well = True"]
        for number, part in enumerate(self.parts):
            body.append(f"for lane in range({self.count}):")
            body += [f"    {line}" for line in self._round(number, part, printer, leaves)]
        return "\n    ".join(["def step(block, table, shared):", *body, "return not all_well"]) + "\n"

    def _round(self, number: int, part: Sequence[Assignment], printer: Arithmetic, leaves: float) -> Iterator[str]:
        last = number == len(self.parts) - 1
        read = self.layout.read(number) | (set(self.kept) if last else set())
        for name in sorted(read - set(self.shared_inputs)):
            yield f"{name} = {self.entry(name)}"
        for target, value in part:
            yield f"{target} = {printer.doprint(value)}"
        for name in self.layout.stored(number):
            yield f"{self.entry(name)} = {name}"
        if last:
            yield from self._close(printer, leaves)

    def _close(self, printer: Arithmetic, leaves: float) -> Iterator[str]:
        """Store the state before the step and after it, and whether the lane continues."""
        out = {name: printer.doprint(sympy.sympify(value)) for name, value in self.step.out.items()}
        for name in self.kept:
            yield f"{self.entry(f'old {name}')} = {name}"
        yield f"clearance_before = {self.entry('clearance')}"
        yield f"{self.entry('clearance_before')} = clearance_before"
        for name in ("clearance", "side", *self.kept):
            if name in out:
                yield f"{self.entry(name)} = {out[name]}"
        yield f"left = {self.entry('left')} - 1.0"
        yield f"{self.entry('left')} = left"
        must = f"{leaves!r} * clearance_before" if leaves else "0.0"
        sane = " & ".join(f"(abs({out[name]}) < {most})" for name, most in SPEED_LIMITS.items())
        yield f"well = (left > 0.0) & ({out['clearance']} > {must}) & {sane}"
        yield f"{self.entry('flag')} = 0.0 if well else 1.0"
        yield "all_well = all_well & well"


def names_in(value: Expr) -> set[str]:
    return {str(s) for s in sympy.sympify(value).free_symbols}
