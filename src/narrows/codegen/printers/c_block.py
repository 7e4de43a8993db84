"""A step as C over a block of vessels: the lines of one vessel in loops over lanes, which compilers vectorise."""

from collections.abc import Iterator, Mapping, Sequence

import sympy

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Lines
from narrows.codegen.lowering import reads_table, rounds
from narrows.codegen.printers.c import LIBRARY, CArithmetic, c_name, unpacked
from narrows.codegen.printers.lane_fields import LaneFields

# Functions of <math.h> that processors have instructions for.
PLAIN = ("fabs", "sqrt", "floor")
CALLED = tuple(f"{name}(" for name in {*LIBRARY.values(), "angle"} - {*PLAIN})


def c_block(
    lines: Lines, results: Mapping[str, Expr], places: Mapping[str, str], printer: CArithmetic, lanes: str
) -> list[str]:
    """Write a program over a block as statements of C."""
    # places [lane]
    # Calls of the library and reads of a waterway's table have loops of their own, so that the others vectorise.
    values = tuple(map(sympy.sympify, results.values()))
    parts = rounds(lines.needed_for(values), lambda value: reads_table(value) or _calls(value, printer))
    layout = LaneFields(parts, values)
    shared = [name for name in _asked(layout) if "[lane]" not in places[name]]
    scratch = [f"double rows[{layout.size}][{lanes}];"] if layout.size else []
    body = [*unpacked(shared, places), *scratch]
    for number in range(len(parts)):
        last = tuple(results) if number == len(parts) - 1 else ()
        body += [f"for (int lane = 0; lane < {lanes}; ++lane) {{"]
        body += [f"    {line}" for line in _round(layout, number, last, places, printer)]
        body += ["}"]
    return body


def _asked(layout: LaneFields) -> list[str]:
    """What the rounds read and none of them makes."""
    made = {str(target) for part in layout.parts for target, _ in part}
    return sorted({name for number in range(len(layout.parts)) for name in layout.read(number)} - made)


def _round(
    layout: LaneFields, number: int, targets: Sequence[str], places: Mapping[str, str], printer: CArithmetic
) -> Iterator[str]:
    kept = {name: f"rows[{field}][lane]" for name, field in layout.fields.items()}
    read = {name: kept.get(name, places.get(name, name)) for name in layout.read(number)}
    yield from unpacked(sorted(name for name, where in read.items() if "[lane]" in where), read)
    for target, value in layout.parts[number]:
        yield f"const double {c_name(str(target))} = {printer.doprint(value)};"
    for name in layout.stored(number):
        yield f"{kept[name]} = {c_name(name)};"
    yield from (f"{target} = {printer.doprint(value)};" for target, value in zip(targets, layout.results, strict=False))


def _calls(value: Expr, printer: CArithmetic) -> bool:
    return any(name in printer.doprint(value) for name in CALLED)
