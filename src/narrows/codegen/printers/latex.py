"""The forces of a table of terms in LaTeX, from the same tape as everything else."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from narrows.codegen.free_motion import exact_number, symbol, symbolic_functions
from narrows.codegen.tape import tape_of_terms
from narrows.errors import check_choice
from narrows.quantities.names import FORCES
from narrows.terms.term import TermTable

# Quantities as texts write them; others stand upright by their names.
WRITTEN = {
    "x": "x", "y": "y", "cos_psi": r"(\cos\psi)", "sin_psi": r"(\sin\psi)", "u": "u", "v": "v", "r": "r",
    "udot": r"\dot{u}", "vdot": r"\dot{v}", "rdot": r"\dot{r}", "heave": "z", "length": "L", "beam": "B",
    "draft": "T_0", "block_coefficient": "C_B", "mass": "m", "inertia": "I_z", "x_g": "x_G", "width": "W",
    "depth": "h", "density": r"\rho", "flow_straightening": r"\gamma_R", "cos_rudder": r"(\cos\delta_R)",
    "sin_rudder": r"(\sin\delta_R)", "revolutions": "n",
}  # fmt: skip
DIGITS = 4


def latex(
    table: TermTable, coefficients: Mapping[str, float] | None = None, forces: Sequence[str] = tuple(FORCES)
) -> str:
    """Write the equations of the forces, a line a force; forces without terms are left out.

    Parameters
    ----------
    table : TermTable
        The terms.
    coefficients : mapping of str to float, optional
        Values to write instead of the coefficients' symbols, to four digits.
    forces : sequence of str
        Which: ``X``, ``Y``, ``N``.

    Raises
    ------
    InputError
        Where there is no such force, or a regressor does more than arithmetic.
    """
    for force in forces:
        check_choice("force", force, FORCES)
    tape = tape_of_terms(table)
    regressors = tape.replay({name: symbol(name) for name in tape.inputs}, exact_number, symbolic_functions())
    lines = []
    for force in forces:
        parts = [_term(term.symbol, regressors[term.name], None if coefficients is None else coefficients[term.name])
                 for term in table.forces[force]]  # fmt: skip
        if parts:
            lines.append(f"{force} &= {' '.join(parts).removeprefix('+ ')}")
    return "\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}"


def _term(written: str, regressor: Any, value: float | None) -> str:
    import sympy

    expression = sympy.sympify(regressor)
    minus = expression.could_extract_minus_sign()
    expression = -expression if minus else expression
    sign = "-" if minus != (value is not None and value < 0) else "+"
    symbol_of = f"({written})" if re.search(r" [+-] ", written) else written
    factor = symbol_of if value is None else _number(abs(value))
    names = {
        own: WRITTEN.get(own.name, rf"\mathrm{{{own.name}}}".replace("_", r"\_")) for own in expression.free_symbols
    }
    times = "" if expression == 1 else sympy.latex(expression, symbol_names=names)
    times = times.replace(r"\operatorname{maximum}", r"\max").replace(r"\operatorname{minimum}", r"\min")
    times = rf"\left({times}\right)" if expression.is_Add else times
    return f"{sign} {factor} {times}".rstrip()


def _number(value: float) -> str:
    digits, _, exponent = f"{value:.{DIGITS}g}".partition("e")
    return rf"{digits} \cdot 10^{{{int(exponent)}}}" if exponent else digits
