"""Functions of a model as text: those of floats or columns, and those of fleets as loops over a block of lanes.

Each round of a step is a loop of its own, since a long loop is a longer chain than a processor looks ahead. No loop
branches on data, so that it is written as vectors.
"""

from collections.abc import Iterator, Mapping
from itertools import chain

import sympy

from narrows.codegen.choices import BOOK, LANES, SHARED, Choices
from narrows.codegen.free_motion import MIDSHIP, OPEN, STATE, Expr
from narrows.codegen.lines import LaneLoops, Lines, asked_by, real, rounds
from narrows.codegen.printers.python import constants_text, function_text, module_text, plain
from narrows.codegen.printers.translation import Language
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


class Kernel(Language):
    TABLE, DECLARED, ASSIGNED = "table", "{} = {}", "{} = {}"


def kernel_text(choices: Choices, rates: Rates) -> str:
    """Write the function ``step(block, table, shared)`` of a block of vessels, (fields, lanes), and its ends."""
    step, kept = step_of(rates, choices, whole=True), choices.kept
    out = tuple(step.out.values())
    needed = step.lines.needed_for(out)
    loops = LaneLoops(rounds(needed), out)
    inputs = {*asked_by(needed.assignments, out), *SPEED_LIMITS.values()} - {*kept, *BOOK}
    vessel_inputs = tuple(sorted(inputs - {*SHARED}))
    stored = chain.from_iterable(loops.stored)
    fields = (*BOOK, *kept, *(f"old {name}" for name in kept), *vessel_inputs, *stored)
    places = {name: f"block[{field}, lane]" for field, name in enumerate(fields)}
    places |= {name: f"shared[{place}]" for place, name in enumerate(SHARED)}
    numbers = {
        "LANES": LANES, "FIELDS": len(fields), "KEPT_NAMES": kept, "VESSEL_INPUTS": vessel_inputs,
        "EXACT": choices.waterway and choices.contact not in (MIDSHIP, OPEN), "LEAVES": choices.leaves,
    }  # fmt: skip
    names = "\n".join(f"{name} = {value!r}" for name, value in numbers.items())
    body = [*(f"{name} = {places[name]}" for name in sorted(inputs & {*SHARED})), "all_well = True"]
    for number in range(len(loops.parts)):
        inside = Kernel().loop_body(loops, number, places)
        if number == len(loops.parts) - 1:
            own = (f"{name} = {places[name]}" for name in sorted({*kept} - loops.read[number]))
            inside += [*own, *_close(choices, step, places)]
        body += [f"for lane in range({LANES}):", *(f"    {line}" for line in inside)]
    text = "\n    ".join(["def step(block, table, shared):", *body, "return any_false(all_well)"]) + "\n"
    return module_text(choices.row, names, *_end_texts(choices, places), text)


def _end_texts(choices: Choices, places: Mapping[str, str]) -> Iterator[str]:
    state, own, ends = {name: real(name) for name in STATE}, Lines(), Lines()
    before = {name: places[name].replace("[", "[first + ") for name in choices.kept}
    for name, lines, results, first, where in (
        ("clearance_of", own, least_clearance(own, choices, state), (), places),
        ("ends_of", ends, ends_of(ends, choices, state), ("first",), {**places, **before}),
    ):
        head = [f"{one} = {where[one]}" for one in lines.inputs]
        yield function_text(name, ("block", "lane", *first, "table", "shared"), lines.assignments, results, head)


def _close(choices: Choices, step: Step, places: Mapping[str, str]) -> Iterator[str]:
    out = {name: plain.doprint(sympy.sympify(value)) for name, value in step.out.items()}
    yield from (f"{places[f'old {name}']} = {name}" for name in choices.kept)
    yield f"clearance_before = {places['clearance']}"
    yield f"{places['clearance_before']} = clearance_before"
    yield from (f"{places[name]} = {out[name]}" for name in ("clearance", "side", *choices.kept) if name in out)
    yield f"left = {places['left']} - 1.0"
    yield f"{places['left']} = left"
    must = f"{choices.leaves!r} * clearance_before" if choices.leaves else "0.0"
    sane = " & ".join(f"(abs({out[name]}) < {most})" for name, most in SPEED_LIMITS.items())
    yield f"well = (left > 0.0) & ({out['clearance']} > {must}) & {sane}"
    yield f"{places['flag']} = where(well, 0.0, 1.0)"
    yield "all_well = all_well & well"
