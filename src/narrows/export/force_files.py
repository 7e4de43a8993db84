"""The bank's force of a model as one function in another language, for simulators with their own hull model."""

import math
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import sympy

from narrows.base.errors import InputError
from narrows.codegen.free_motion import Expr, exact_number
from narrows.codegen.lines import FUNCTIONS, Program, real, straight_lines
from narrows.codegen.printers.c import C
from narrows.codegen.printers.translation import CSharp, JavaScript, Language, Matlab
from narrows.codegen.trace import trace_of_terms
from narrows.export.exported_ship import HEADING, prefix_of
from narrows.export.fmu import SIDES, FmuVariable, Kind, fmu_of, source_of
from narrows.export.passport import ASKED_OF_BANK, bits_in_words, ends_of_data, passport
from narrows.export.ship_files import commented, filled
from narrows.model.bank_force import CONTACT, beside_banks
from narrows.model.model import Model
from narrows.quantities.names import FORCES, MOTION
from narrows.ship.checks import SMALLEST
from narrows.simulation.initial_state import voyage_defaults

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
    places = [model.terms.names.index(name) for name in names]
    return sum(
        (
            exact_number(float(model.covariance[row, column])) * regressors[one] * regressors[other]
            for row, one in zip(places, names, strict=True)
            for column, other in zip(places, names, strict=True)
        ),
        sympy.Integer(0),
    )


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


def force_file(model: Model, path: str | Path, suffix: str, fmi: int = 2) -> tuple[str | bytes, tuple[str, ...] | None]:
    """Return a function, or an FMU without states, whose outputs are the force at its inputs."""
    prefix = prefix_of(path)
    if suffix != ".fmu":
        return force_text(model, suffix, prefix), None
    variables = tuple(_variables(model))
    start = [C().literal(one.start or 0.0) for one in variables if one.kind is Kind.INPUT]
    filling = partial(filled, "bank_choices.h.j2", deviations=2 * (model.covariance is not None), start=start)
    sources = {"bank.h": force_text(model, ".h", "bank"), "instance.h": source_of("bank_instance.h")}
    about = passport(model)
    return fmu_of(model, variables, sources, filling, about, fmi, identifier=prefix, stop=1.0, output=0.1)


def _variables(model: Model) -> Iterator[FmuVariable]:
    """Variables in the order of ``bank_instance.h``."""
    ship, canal = model.configuration.ship, model.configuration.canal
    foot = "from the line to the foot of the {} bank"
    sloped = "how far the {} bank recedes for each metre that it rises"
    yield FmuVariable("time", Kind.TIME_ITSELF, "s", "time")
    yield FmuVariable("y", Kind.INPUT, "m", MOTION["y"].meaning, 0.0)
    yield FmuVariable("psi", Kind.INPUT, "rad", HEADING, 0.0)
    yield FmuVariable("u", Kind.INPUT, "m/s", MOTION["u"].meaning, float(voyage_defaults(model).speed))
    for side in SIDES:
        yield FmuVariable(side, Kind.INPUT, "m", foot.format(side), canal.width / 2)
    for side in SIDES:
        yield FmuVariable(f"slope_{side}", Kind.INPUT, "1", sloped.format(side), 0.0, 0, (0.0, math.inf))
    # A model whose canal has no depth needs none; the file needs one over the draft.
    yield FmuVariable("depth", Kind.INPUT, "m", "water depth", canal.depth or 2.0 * ship.draft, 0, (SMALLEST, math.inf))
    for of in ("", "standard deviation of the ")[: 1 if model.covariance is None else 2]:
        for force in "YN":
            name, (unit, meaning) = f"{force}{'_deviation' * bool(of)}", FORCES[force]
            yield FmuVariable(name, Kind.CALCULATED, unit, f"{of}{meaning}")
    bits = f"quantities outside the tested range, a sum of: {bits_in_words(model, ASKED_OF_BANK)}"
    yield FmuVariable("beyond", Kind.WHOLE, "1", f"{bits}; {CONTACT} if the hull touches a bank or the bottom")
