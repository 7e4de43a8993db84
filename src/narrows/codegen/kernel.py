"""The kernel of a fleet: one file that Numba compiles, with a step over a block of lanes and its bookkeeping."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import sympy

from narrows.codegen.choices import Choices
from narrows.codegen.free_motion import MIDSHIP, OPEN, STATE, Expr
from narrows.codegen.kernels.elementary import HEADER, NUMBER, elementary_text
from narrows.codegen.lines import Lines, real
from narrows.codegen.printers.lanes import SHARED, Lanes
from narrows.codegen.printers.python import Arithmetic, constants_text, function_text
from narrows.codegen.step import Rates, Step, ends_left, room_left

LANES = 64

FIELDS = {
    "X": "x", "Y": "y", "COS": "cos_psi", "SIN": "sin_psi", "U": "u", "V": "v", "R": "r", "STEP_LENGTH": "step_length",
    "LEFT": "left", "FLAG": "flag", "ROOM": "room", "LEAN": "lean", "ROOM_BEFORE": "room_before",
}  # fmt: skip


def kernel_text(lanes: Lanes, choices: Choices, precision: str, version: str) -> str:
    """Write the module that integrates a fleet."""
    printer = Arithmetic(NUMBER[precision], column="{:.1f}".format)
    body = "\n\n".join([*_end_texts(lanes, choices, printer), lanes.text(printer, choices.leaves)])
    exact = choices.waterway and choices.contact not in (MIDSHIP, OPEN)
    return "\n\n".join(
        [
            HEADER.format(version=version, precision=precision),
            _places(lanes, choices, exact),
            elementary_text(body, precision),
            body,
            SHARED_FUNCTIONS + (EXACT_ROOM if exact else ABSENT),
            Path(__file__).with_name("kernels").joinpath("queue.py").read_text(encoding="utf-8"),
        ]
    )


# Code that all kernels share is compiled once: it takes a fourth of a kernel's compile time.
SHARED_FUNCTIONS = """
from narrows.codegen.cache import compiled_loops
from narrows.codegen.kernels import event
from narrows.codegen.kernels.event import ASTERN, BACK, CLOCK, CLOSED, COUNT, FINISHED, GROUNDED, LOST, NEXT, TRIES

shared = compiled_loops(event)
begin, cause, cleared, accept_step = shared.begin, shared.cause, shared.cleared, shared.accept_step
"""
EXACT_ROOM = """
from narrows.waterway import room as banks

exact_room = compiled_loops(banks).exact_room
"""
ABSENT = """

@jit
def exact_room(track, step, s, n, cosine, sine, outline):
    return inf, 0.0
"""


def _places(lanes: Lanes, choices: Choices, exact: bool) -> str:
    fields, shared, vessel_inputs = lanes.layout.fields, lanes.shared_inputs, lanes.vessel_inputs
    numbers: dict[str, float] = {name: fields[field] for name, field in FIELDS.items()}
    numbers |= {f"AT_{name.upper()}": shared.index(name) if name in shared else 0 for name in SHARED}
    numbers |= {"LANES": lanes.count, "FIELDS": lanes.layout.size, "KEPT": len(lanes.kept), "CELL_ENTRIES": choices.row}
    numbers["FIRST_VESSEL_INPUT"] = fields[vessel_inputs[0]] if vessel_inputs else 0
    numbers |= {"EXACT": exact, "WATERWAY": choices.waterway, "LEAVES": choices.leaves}
    names = {"KEPT_NAMES": lanes.kept, "VESSEL_INPUTS": vessel_inputs, "SHARED": shared}
    passed = {"FIRST": 0, "NOW": 0, "OLD": fields["old x"]}  # Numba compiles a function again for each literal
    lines = [f"{name} = {value!r}" for name, value in (numbers | names).items()]
    return "\n".join([*lines, *(f"{name} = np.int64({value})" for name, value in passed.items())])


def _end_texts(lanes: Lanes, choices: Choices, printer: Arithmetic) -> Iterator[str]:
    """Write the clearance of one lane and its margins to every end but a bank."""
    state = {name: real(name) for name in STATE}
    rooms, ends = Lines(), Lines()
    yield _of_one("room_of(block, lane, table, shared)", rooms, room_left(rooms, choices, state), lanes, printer)
    left = ends_of(ends, choices, state)
    yield _of_one("ends_of(block, lane, first, table, shared)", ends, left, lanes, printer, "first * LANES + ")


# Margin [m] to an end that a voyage cannot meet.
FAR = sympy.Integer(10) ** 9


def ends_of(lines: Lines, choices: Choices, state: Mapping[str, Expr]) -> tuple[Expr, ...]:
    left = ends_left(lines, choices, state)
    return tuple(left.get(name, FAR) for name in ("heading", "ahead", "astern", "afloat"))


def _of_one(
    head: str, lines: Lines, results: tuple[Expr, ...], lanes: Lanes, printer: Arithmetic, kept_from: str = ""
) -> str:
    body = []
    for name in lines.inputs:
        place = lanes.entry(name) if name in lanes.layout.fields else f"shared[{lanes.shared_inputs.index(name)}]"
        body.append(f"{name} = {place.replace('[', f'[{kept_from}') if name in lanes.kept else place}")
    body += [f"{target} = {printer.doprint(value)}" for target, value in lines.assignments]
    body.append(f"return {', '.join(printer.doprint(result) for result in results)}")
    return "\n    ".join([f"@jit\ndef {head}:", *body]) + "\n"


# The plain module of a system: constants, rates, step and clearance as functions of floats or columns.
def plain_text(choices: Choices, rates: Rates, step: Step) -> str:
    kept, lines, ends, state = choices.kept, Lines(), Lines(), {name: real(name) for name in STATE}
    room, lean = room_left(lines, choices, state)
    left = dict(zip(("heading", "ahead", "astern", "afloat"), ends_of(ends, choices, state), strict=True))
    program, derivatives = rates.program()
    parts = [
        '"""Made by narrows from a table of terms: made again where it is missing, so do not edit."""\n',
        constants_text(rates.parameters, rates.constants),
        _function("rates", program, {name: derivatives[name] for name in STATE}, STATE, False),
        _function("step", step.lines, {name: step.out[name] for name in (*kept, "room", "lean")}, kept, True),
        _function("room", lines, {"room": room, "lean": lean}, STATE[:5], True),
        _function("ends", ends, left, STATE[:5], True),
    ]
    return "\n\n".join(parts)


def _function(name: str, lines: Lines, out: Mapping[str, Expr], first: tuple[str, ...], table: bool) -> str:
    """Return a function and the names of its arguments after the first ones."""
    program = lines.needed_for(list(out.values()))
    asked = {str(s) for value in out.values() for s in real(name).free_symbols | value.free_symbols}
    made = {str(target) for target, _ in program.assignments}
    rest = tuple(sorted((set(program.inputs) | asked) - made - {*first, name}))
    text = function_text(name, (*first, *rest), program.assignments, list(out.values()), table)
    return f"{name.upper()}_INPUTS = {rest!r}\n\n\n{text}"
