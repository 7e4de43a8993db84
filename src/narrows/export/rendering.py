"""Code shared by files of all languages: plain functions as source, templates, safe comments."""

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from inspect import getsource
from textwrap import wrap
from typing import Any

from narrows.codegen.choices import AFLOAT_SPEED, COLUMNS, COUNTED, LENGTH
from narrows.codegen.free_motion import INPUTS, STATE
from narrows.codegen.kernels import event, filling, single
from narrows.codegen.portable import PLACES
from narrows.codegen.printers.language import Language
from narrows.codegen.printers.python import PlainSource
from narrows.codegen.printers.translation import Translation
from narrows.export.exported_ship import ExportedShip
from narrows.export.passport import RANGE_BITS, bits_in_words, ends_of_data
from narrows.waterway import bank_clearance

WIDTH = 108
# Outcomes of a voyage, in the order of their codes.
OUTCOME_CODES = ("AFLOAT", "GROUNDED", "DIVERGED", "OUTSIDE", "ASTERN", "PASSED", "REFUSED")

CANNOT_INTEGRATE = (
    "give a step over 0, a hundred or more to a ship length, at most 1e9 in all, and a waterway with a length"
)

# Modules of plain functions: the rule for ends of a voyage, banks of a waterway, one vessel to its end, tables.
PLAIN = (event, bank_clearance, single, filling)


def plain_functions(exported: ExportedShip) -> PlainSource:
    absent = frozenset[str]() if exported.waterway else frozenset({"waterway"})
    return PlainSource(tuple(map(getsource, PLAIN)), exported.rule, absent)


def places_in(exported: ExportedShip, language: Language) -> dict[str, str]:
    """Return the place of each number in the lines: state, inputs, constants, waterway."""
    portable = exported.portable
    places = {name: language.field("constants", name) for name in exported.constants}
    places |= {name: f"state[{number}]" for number, name in enumerate(portable.kept)}
    for actuator in portable.geared:
        position = f"state[{portable.kept.index(actuator.name)}]"
        places |= {f"{function}_{actuator.name}": language.called(function, position) for function in ("cos", "sin")}
    names = zip(portable.inputs, exported.inputs, strict=True)
    places |= {name: language.field("inputs", one.name) for name, one in names}
    places |= {name: language.field("waterway", name) for name in PLACES}
    # Derivatives by inputs may need more than the step.
    return {**dict.fromkeys(INPUTS.values(), "0.0"), **places, LENGTH: LENGTH}


def bodies_of(exported: ExportedShip, language: Language) -> dict[str, str]:
    places = places_in(exported, language)
    bodies = {}
    for name, program in exported.programs.items():
        targets, where = [f"result[{number}]" for number in range(len(program.results))], places
        if name == "constants":
            targets = [language.field("constants", constant) for constant in exported.constants]
            where = {one.name: language.field("parameters", one.name) for one in exported.parameters}
        lines = language.body(program, targets, where)
        bodies[name] = "\n    ".join(explained(exported, language, lines) if name == "constants" else lines)
    return bodies


def explained(exported: ExportedShip, language: Language, lines: list[str], names: Sequence[str] = ()) -> list[str]:
    """Return the lines that assign the constants, each with its meaning."""
    names = names or exported.constants
    meanings = [exported.meanings.get(name, "") for name in names]
    return [*lines[: -len(names)], *map(language.commented, lines[-len(names) :], meanings)]


def translated(exported: ExportedShip, language: Callable[[PlainSource], Translation], *more: str) -> dict[str, Any]:
    source = plain_functions(exported)
    translation = language(source)
    plain = [translation.text(one) for one in last_functions(exported, source, *more)]
    stated = {*OUTCOME_CODES, *(name.upper() for name in exported.portable.kept)}
    columns = [" ".join(name.split("_")) for name in COLUMNS]
    numbers = numbers_of(source, translation.used - stated)
    return {"plain": plain, "numbers": numbers, "columns": columns, "outcomes": OUTCOME_CODES}


def numbers_of(source: PlainSource, names: Set[str]) -> list[tuple[str, Any, str]]:
    """Return name, value and meaning of the constants that plain functions need, in the order of their modules."""
    return [(name, value, source.about.get(name, "")) for name, value in source.constants.items() if name in names]


def last_functions(exported: ExportedShip, source: PlainSource, *more: str) -> list[ast.FunctionDef]:
    """Return the plain functions at the end of a file: the clearance if the hull is known, and the voyage."""
    return source.needed(*(("clearance",) * exported.exact), "integrate", *more)


def water_of(exported: ExportedShip, language: Language) -> dict[str, Any] | None:
    """Return the table of the waterway as text, its arrays with their lengths; None in a straight canal."""
    if exported.waterway is None:
        return None
    channel = exported.channel
    arrays = {"table": channel.water.table, "track": channel.water.track, "outline": channel.water.outline}
    text = {
        name: "\n    ".join(wrap(", ".join(map(language.literal, values)), WIDTH)) for name, values in arrays.items()
    }
    places = {name: language.literal(channel.inputs[name]) for name in PLACES}
    return {"arrays": text, "lengths": {name: len(values) for name, values in arrays.items()}, "places": places}


def commented(text: str) -> str:
    """Return text that can neither end its comment nor begin another."""
    plain = " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())
    return plain.replace("\\", "|").replace("??", "? ?").replace("*/", "* /").replace("/*", "/ *")


def environment() -> Any:
    """Return the environment of the templates with their filters."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    loader = PackageLoader("narrows.export", "templates")
    found = Environment(loader=loader, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    found.filters["commented"] = commented
    found.filters["set_in"] = lambda text, by="    ": text.replace("\n", f"\n{by}")
    return found


def filled(template: str, **context: Any) -> str:
    text: str = environment().get_template(template).render(context)
    return text.rstrip() + "\n"


def _tested(
    exported: ExportedShip, language: Language, sizes: Mapping[str, str]
) -> Iterator[tuple[str, int, str, str]]:
    """Comparison of a state with the data: the size, its bit, the limits."""
    for name, (bit, low, high) in ends_of_data(exported.ship.model.data_range, sizes).items():
        size = language.called("abs", sizes[name]) if name.startswith("abs") else sizes[name]
        yield size, bit, language.literal(low), language.literal(high)
    if AFLOAT_SPEED in sizes:
        bit = RANGE_BITS["bottom"][0]
        yield language.called("abs", sizes["speed"]), bit, language.literal(0.0), sizes[AFLOAT_SPEED]


def rendered(template: str, exported: ExportedShip, language: Language, **context: Any) -> str:
    turned = language.called("angle", "state[2]", "state[3]")
    sizes = {"speed": "state[4]", "abs_y": "state[1]", "abs_psi": turned, "abs_r": "state[6]"}
    # In a waterway the program ``section`` gives the numbers of the water at the place.
    water = {name: language.field("constants", name) for name in exported.water}
    if exported.waterway:
        water = {name: f"result[{number}]" for number, name in enumerate(exported.water)}
    measured = {**sizes, **water, **context.get("sizes", {})}
    rates = tuple(name for name in exported.portable.kept if name in (*STATE, COUNTED))  # Results of ``rates``
    alike = {"ship": exported, "prefix": exported.prefix, "row": exported.portable.choices.row, "rates": rates,
             "number": language.literal,
             "cannot_integrate": CANNOT_INTEGRATE, "name": language.named, "beyond_bits": tuple(RANGE_BITS.values()),
             "bits": f"{bits_in_words(exported.ship.model)}, {RANGE_BITS['bottom'][0]} bottom",
             "tested": tuple(_tested(exported, language, measured))}  # fmt: skip
    return filled(template, **{**alike, **context})
