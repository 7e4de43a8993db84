"""A ship as one file of a language: a C header, an ES module, a Python file."""

import ast
from collections.abc import Callable, Iterator, Mapping, Set
from functools import partial
from inspect import getsource
from itertools import product
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np
import sympy

from narrows.base.errors import InputError
from narrows.codegen.free_motion import AFLOAT_SPEED, COLUMNS, COUNTED, INPUTS, LENGTH, OPEN, STATE, Expr, exact_number
from narrows.codegen.kernels import event, single
from narrows.codegen.linearisation import LINEARISED
from narrows.codegen.lines import FUNCTIONS, Lines, Program, real, straight_lines
from narrows.codegen.printers.c import BlockC, C, CTranslation, c_block
from narrows.codegen.printers.latex import Equations, environment
from narrows.codegen.printers.python import PlainSource, polynomials
from narrows.codegen.printers.translation import CSharp, JavaScript, Language, Matlab, PythonFile, Translation
from narrows.codegen.trace import trace_of_terms
from narrows.export.exported_ship import HEADING, PLACES, ExportedNumber, ExportedShip
from narrows.export.passport import ASKED_OF_BANK, RANGE_BITS, bits_in_words, ends_of_data, passport
from narrows.model.bank_force import CONTACT, beside_banks
from narrows.model.model import Model
from narrows.quantities.names import FORCES, MOTION
from narrows.simulation.initial_state import voyage_defaults
from narrows.simulation.ship import SimulatedShip
from narrows.waterway import bank_clearance

WIDTH = 108
# Outcomes of a voyage, in the order of their codes.
OUTCOME_CODES = ("AFLOAT", "GROUNDED", "DIVERGED", "OUTSIDE", "ASTERN", "PASSED", "REFUSED")

CANNOT_INTEGRATE = (
    "give a step over 0, a hundred or more to a ship length, at most 1e9 in all, and a waterway with a length"
)

# Modules of plain functions: the rule for ends of a voyage, banks of a waterway, one vessel to its end.
PLAIN = (event, bank_clearance, single)


def plain_functions(exported: ExportedShip) -> PlainSource:
    own = exported.choices
    rule = {"EXACT": own.exact, "WATERWAY": own.waterway, "LEAVES": own.leaves, "KEPT": len(own.kept)}
    return PlainSource(
        tuple(map(getsource, PLAIN)), rule, frozenset[str]() if own.waterway else frozenset({"waterway"})
    )


def places_in(exported: ExportedShip, language: Language) -> dict[str, str]:
    """Return the place of each number in the lines: state, inputs, constants, waterway."""
    places = {name: language.field("constants", name) for name in exported.constants}
    places |= {name: f"state[{number}]" for number, name in enumerate(exported.kept)}
    for actuator in exported.geared:
        position = f"state[{exported.kept.index(actuator.name)}]"
        places |= {f"{function}_{actuator.name}": language.called(function, position) for function in ("cos", "sin")}
    names = zip(exported.input_names, exported.inputs, strict=True)
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
        bodies[name] = "\n    ".join(language.body(program, targets, where))
    return bodies


def translated(exported: ExportedShip, language: Callable[[PlainSource], Translation]) -> dict[str, Any]:
    source = plain_functions(exported)
    translation = language(source)
    plain = [translation.text(one) for one in last_functions(exported, source)]
    stated = {*OUTCOME_CODES, *(name.upper() for name in exported.kept)}
    columns = [" ".join(name.split("_")) for name in COLUMNS]
    numbers = numbers_of(source, translation.used - stated)
    return {"plain": plain, "numbers": numbers, "columns": columns, "outcomes": OUTCOME_CODES}


def numbers_of(source: PlainSource, names: Set[str]) -> list[tuple[str, Any, str]]:
    """Return name, value and meaning of the constants that plain functions need, in the order of their modules."""
    return [(name, value, source.about.get(name, "")) for name, value in source.constants.items() if name in names]


def last_functions(exported: ExportedShip, source: PlainSource) -> list[ast.FunctionDef]:
    """Return the plain functions at the end of a file: the clearance if the hull is known, and the voyage."""
    return source.needed(*(("clearance",) * exported.choices.exact), "integrate")


def water_of(exported: ExportedShip, language: Language) -> dict[str, Any] | None:
    """Return the table of the waterway as text, its arrays with their lengths; None in a straight canal."""
    if exported.waterway is None:
        return None
    channel = exported.channel
    arrays = {name: getattr(channel, name) for name in ("table", "track", "outline")}
    text = {
        name: "\n    ".join(wrap(", ".join(map(language.literal, values)), WIDTH)) for name, values in arrays.items()
    }
    places = {name: language.literal(channel.inputs[name]) for name in PLACES}
    return {"arrays": text, "lengths": {name: len(values) for name, values in arrays.items()}, "places": places}


def commented(text: str) -> str:
    """Return text that can neither end its comment nor begin another."""
    plain = " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())
    return plain.replace("\\", "|").replace("??", "? ?").replace("*/", "* /").replace("/*", "/ *")


def filled(template: str, **context: Any) -> str:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    loader = PackageLoader("narrows.export", "templates")
    found = Environment(loader=loader, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    found.filters["commented"] = commented
    found.filters["set_in"] = lambda text, by="    ": text.replace("\n", f"\n{by}")
    return str(found.get_template(template).render(context)).rstrip() + "\n"


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
    rates = tuple(name for name in exported.kept if name in (*STATE, COUNTED))  # Results of ``rates``
    alike = {"ship": exported, "prefix": exported.prefix, "row": exported.choices.row, "rates": rates,
             "number": language.literal,
             "cannot_integrate": CANNOT_INTEGRATE, "name": language.named, "beyond_bits": tuple(RANGE_BITS.values()),
             "bits": f"{bits_in_words(exported.ship.model)}, {RANGE_BITS['bottom'][0]} bottom",
             "tested": tuple(_tested(exported, language, measured))}  # fmt: skip
    return filled(template, **{**alike, **context})


def c_text(exported: ExportedShip) -> str:
    language = C(exported.prefix)
    bodies = {**bodies_of(exported, language), "step_block": "\n    ".join(_block(exported))}
    lanes = polynomials() if "_lane_" in bodies["step_block"] else {}
    return rendered(
        "model.h.j2", exported, language, f=bodies, lanes=lanes, water=water_of(exported, language),
        **translated(exported, partial(CTranslation, prefix=exported.prefix)),
    )  # fmt: skip


def cpp_text(exported: ExportedShip) -> str:
    return rendered(
        "model.hpp.j2", exported, C(exported.prefix), c=c_text(exported), outcomes=OUTCOME_CODES,
        counted=COUNTED in exported.kept, between_banks=exported.ship.shape != OPEN,
    )  # fmt: skip


def _block(exported: ExportedShip) -> list[str]:
    language = BlockC(exported.prefix)
    places = places_in(exported, language)
    for column, rows in (("state", exported.kept), ("inputs", exported.input_names)):
        places |= {name: f"{column}[{number}][lane]" for number, name in enumerate(rows)}
    lines, after = exported.step
    kept = (*exported.kept, "clearance", "side")
    results = {f"state[{number}][lane]": after[name] for number, name in enumerate(kept)}
    return c_block(lines, results, places, language, f"{exported.prefix.upper()}_LANES")


def javascript_text(exported: ExportedShip, derivatives: bool = True) -> str:
    language = JavaScript()
    return rendered(
        "model.js.j2", exported, language, f=bodies_of(exported, language), water=water_of(exported, language),
        derivatives=derivatives, **translated(exported, Translation),
    )  # fmt: skip


def python_text(exported: ExportedShip) -> str:
    language, source = PythonFile(), plain_functions(exported)
    functions = last_functions(exported, source)
    asked = {one.id for function in functions for one in ast.walk(function) if isinstance(one, ast.Name)}
    return rendered(
        "model.py.j2", exported, language, f=bodies_of(exported, language), water=water_of(exported, language),
        plain=[ast.unparse(one) for one in functions], numbers=numbers_of(source, asked),
    )  # fmt: skip


def matlab_text(exported: ExportedShip) -> str:
    language = Matlab()
    known = {one.name: one for one in exported.state} | {"psi": ExportedNumber("psi", 0.0, "rad", HEADING)}
    states = [known[name] for name in ("u", "v", "r", "x", "y", "psi", *exported.choices.gear)]
    where = {one.name: f"x({number})" for number, one in enumerate(states, 1)}
    for angle in ("psi", *(actuator.name for actuator in exported.geared)):
        where |= {f"{function}_{angle}": language.called(function, where[angle]) for function in ("cos", "sin")}
    pairs = zip(exported.input_names, exported.inputs, strict=True)
    inputs = sorted(pairs, key=lambda pair: pair[0] in INPUTS.values())  # Orders come first
    where |= {name: f"ui({number})" for number, (name, _) in enumerate(inputs, 1)}
    where |= {LENGTH: language.literal(voyage_defaults(exported.ship.model).dt)}
    motion, gear = exported.continuous
    asked = [name for name in exported.constants if name in {*motion.asked, *gear.asked, *exported.water}]
    where |= {name: name for name in asked}
    targets = [f"xdot{where[name][1:]}" for name in (*LINEARISED, *exported.choices.gear)]
    lines = language.body(motion, targets[: len(LINEARISED)], where)
    lines += language.body(gear, targets[len(LINEARISED) :], where)
    results = dict(zip(exported.constants, exported.programs["constants"].results, strict=True))
    constants = Program.of(Lines(list(exported.programs["constants"].assignments)), [results[name] for name in asked])
    return rendered(
        "model.m.j2", exported, language, lines=lines, states=states, inputs=[one for _, one in inputs],
        parameters=[one for one in exported.parameters if one.name in constants.asked],
        constants=language.body(constants, asked, {name: name for name in constants.asked}),
        sizes={"speed": "x(1)", "abs_y": "x(5)", "abs_psi": "angle(cos(x(6)), sin(x(6)))", "abs_r": "x(3)",
               **{name: name for name in exported.water}},
    )  # fmt: skip


def latex_file(model: Model, path: str | Path, suffix: str) -> tuple[str, None]:
    about = [*passport(model), ExportedShip(SimulatedShip(model)).bottom_note]
    lines = [f"% {commented(line)}" for line in about]
    written = Equations(model.terms)
    by_symbols = [*written.of_forces(tuple(FORCES)), *written.definitions()]
    by_numbers = written.of_forces(tuple(FORCES), model.coefficients)
    # Pages break between lines.
    parts = [environment("align*", one) for one in (by_symbols, by_numbers)]
    return "\n".join([*lines, "{\\allowdisplaybreaks", *parts, "}"]) + "\n", None


# The text of a whole ship, by the suffix of its file.
TEXTS: dict[str, Callable[[ExportedShip], str]] = {
    ".h": c_text, ".hpp": cpp_text, ".mjs": javascript_text, ".js": javascript_text,
    ".py": python_text, ".m": matlab_text,
}  # fmt: skip


def ship_file(model: Model, path: str | Path, suffix: str, **choices: Any) -> tuple[str, None]:
    return TEXTS[suffix](ExportedShip.of(model, path, **choices)), None


# The bank's force of a model as one function in another language, for simulators with their own hull model.
# Inputs from the caller: ship and water.
ASKED = ("y", "cos_psi", "sin_psi", "u", "width", "depth")
RESULTS = ("Y", "N", "Y_variance", "N_variance")


def force_program(model: Model) -> Program:
    if not model.has_bank:
        raise InputError(model.bank_note)
    trace, values = trace_of_terms(model.terms), {**model.configuration.values(), **dict.fromkeys(MOTION, 0.0)}
    # The bank's force does not depend on rudder, propeller and accelerations.
    inputs = {name: exact_number(float(values.get(name) or 0.0)) for name in trace.inputs}
    inputs |= {name: real(name) for name in ASKED}
    regressors = trace.replay(inputs, exact_number, FUNCTIONS)
    own = [[term.name for term in group if term.from_bank] for group in list(model.terms.forces.values())[1:]]
    forces = [sum((exact_number(model[name]) * regressors[name] for name in names), sympy.Integer(0)) for names in own]
    lines, results = straight_lines([*forces, *(_variance(model, names, regressors) for names in own)])
    return Program(tuple(lines), tuple(results))


def _variance(model: Model, names: list[str], regressors: Mapping[str, Expr]) -> Expr:
    if model.covariance is None:
        return sympy.Integer(-1)
    matrix = model.covariance[np.ix_(*[[model.terms.names.index(name) for name in names]] * 2)]
    pairs = zip(matrix.flat, product(names, repeat=2), strict=True)
    parts = (exact_number(float(size)) * regressors[one] * regressors[other] for size, (one, other) in pairs)
    return sum(parts, sympy.Integer(0))


# By the suffix of a file: its language, and its declaration of a result.
LANGUAGES: dict[str, tuple[type[Language], str]] = {
    ".h": (C, "const double {}"), ".cs": (CSharp, "double {}"), ".mjs": (JavaScript, "const {}"), ".m": (Matlab, "{}"),
}  # fmt: skip


def force_text(model: Model, suffix: str, prefix: str) -> str:
    language, declared = LANGUAGES[suffix]
    written, hull = language(prefix), model.configuration.ship
    lines = written.body(force_program(model), [*map(declared.format, RESULTS)], {name: name for name in ASKED})
    y, psi, sine = (written.called("abs", name) for name in ("y", "psi", "sin_psi"))
    section = f"width / {hull.beam!r}", f"depth / {hull.draft!r}"
    sizes = dict(zip(ASKED_OF_BANK, ("u", y, psi, *section), strict=True))
    ends = ends_of_data(beside_banks(model), ASKED_OF_BANK).items()
    return filled(
        f"bank_force{suffix}.j2", prefix=prefix, lines=lines, contact=CONTACT,
        tested=[(sizes[name], bit, repr(low), repr(high)) for name, (bit, low, high) in ends],
        reach=f"{0.5 * hull.length!r} * {sine} + {0.5 * hull.beam!r} * cos_psi", draft=repr(hull.draft),
        about=[commented(line) for line in passport(model)], bits=bits_in_words(model, ASKED_OF_BANK),
    )  # fmt: skip
