"""The bank's force of a model as one function in another language, for simulators with a hull of their own."""

from collections.abc import Mapping
from pathlib import Path

import sympy

from narrows.codegen.free_motion import Expr, exact_number, symbolic_functions
from narrows.codegen.lines import Program, real, straight_lines
from narrows.codegen.printers.c import C
from narrows.codegen.printers.language import CSharp, JavaScript, Language, Matlab
from narrows.codegen.tape import tape_of_terms
from narrows.errors import InputError
from narrows.export.passport import passport
from narrows.export.rendering import commented, environment
from narrows.model.data_range import SLACK
from narrows.model.model import Model
from narrows.quantities.names import MOTION

# What a caller says of the ship and the water.
ASKED = ("y", "cos_psi", "sin_psi", "u", "width", "depth")
RESULTS = ("Y", "N", "Y_variance", "N_variance")
# What a call may be beyond the tests in: its bit, and how a language without names for them computes it.
BITS = {"speed": 1, "abs_y": 2, "abs_psi": 4, "width_to_beam": 16, "depth_to_draft": 32}


def force_program(model: Model) -> Program:
    """Return the lines of sway force, yaw moment and their variances, by ``ASKED``."""
    if not model.feels_bank:
        raise InputError(model.bank_note)
    tape, values = tape_of_terms(model.terms), {**model.configuration.values(), **dict.fromkeys(MOTION, 0.0)}
    # Rudder, propeller and accelerations make no force of the bank.
    inputs = {name: exact_number(float(values.get(name) or 0.0)) for name in tape.inputs}
    inputs |= {name: real(name) for name in ASKED}
    regressors = tape.replay(inputs, exact_number, symbolic_functions())
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


# By the suffix of a file: its language, and how it declares a result.
LANGUAGES: dict[str, tuple[type[Language], str]] = {
    ".h": (C, "const double {}"), ".cs": (CSharp, "double {}"), ".mjs": (JavaScript, "const {}"), ".m": (Matlab, "{}"),
}  # fmt: skip


def force_text(model: Model, path: str | Path, prefix: str) -> str:
    """Return the file of a model, in the language of its suffix."""
    suffix = Path(path).suffix
    language, declared = LANGUAGES[suffix]
    lines = language(prefix).body(
        force_program(model), [*map(declared.format, RESULTS)], {name: name for name in ASKED}
    )
    ship, known = model.configuration.ship, model.data_range
    scales = {"width_to_beam": ship.beam, "depth_to_draft": ship.draft}
    tested = []
    for name, bit in BITS.items():
        if (pair := getattr(known, name)) is not None:
            slack, scale = SLACK * max(map(abs, pair)), scales.get(name, 1.0)
            tested.append((name, bit, repr(scale * (pair[0] - slack)), repr(scale * (pair[1] + slack))))
    text: str = environment().get_template(f"bank_force{suffix}.j2").render(
        prefix=prefix, lines=lines, tested=tested,
        about=[commented(line) for line in passport(model)],
    )  # fmt: skip
    return text.rstrip() + "\n"
