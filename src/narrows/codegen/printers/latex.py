"""The forces of a table of terms in LaTeX, from the shared trace, in lines that fit a page."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from narrows.base.errors import check_choice
from narrows.codegen.free_motion import Expr, exact_number, symbol
from narrows.codegen.lines import FUNCTIONS
from narrows.codegen.trace import OPERATORS, Recorded, notes_of_terms
from narrows.model.additions import Grouped
from narrows.model.term import TermTable
from narrows.physics import clearance, hull
from narrows.physics import propeller_and_rudder as mmg
from narrows.quantities.names import FORCES, argument_names

# Symbols of quantities, those of propeller and rudder as in the MMG standard method.
WRITTEN = {
    "x": "x", "y": "y", "cos_psi": r"(\cos\psi)", "sin_psi": r"(\sin\psi)", "u": "u", "v": "v", "r": "r",
    "udot": r"\dot{u}", "vdot": r"\dot{v}", "rdot": r"\dot{r}", "heave": "z", "length": "L", "beam": "B",
    "draft": "T_0", "block_coefficient": "C_B", "mass": "m", "inertia": "I_z", "x_g": "x_G", "width": "W",
    "depth": "h", "density": r"\rho", "flow_straightening": r"\gamma_R", "cos_rudder": r"(\cos\delta_R)",
    "sin_rudder": r"(\sin\delta_R)", "revolutions": "n_P", "propeller_diameter": "D_P", "propeller_wake": "w_{P0}",
    "propeller_thrust_0": "k_0", "propeller_thrust_1": "k_1", "propeller_thrust_2": "k_2",
    "propeller_astern_0": "a_0", "propeller_astern_1": "a_1", "propeller_astern_2": "a_2",
    "propeller_position": "x_P'", "propeller_wake_rate": "C_1", "propeller_wake_starboard": "C_2^+",
    "propeller_wake_port": "C_2^-", "rudder_area": "A_R", "rudder_lift": r"f_\alpha",
    "rudder_wake_ratio": r"\varepsilon", "rudder_slipstream": r"\kappa", "rudder_in_slipstream": r"\eta",
    "rudder_position": r"\ell_R'", "rudder_straightening_starboard": r"\gamma_R^+",
    "rudder_straightening_port": r"\gamma_R^-",
}  # fmt: skip
# Quantities with a symbol of their own in the literature, defined where the terms use them.
NAMED: dict[str, Callable[..., Any]] = {
    "U": hull.speed,  # Total speed through the water
    r"\tau_\beta": hull.half_drift,  # Tangent of half the drift angle
    r"\beta": hull.drift,  # Drift angle
    r"\beta_P": mmg.angle_to_propeller,  # Angle of the inflow to the propeller
    "C_2": mmg.wake_share,  # Wake ratio of a hard turn to straight running
    "u_P": mmg.inflow,  # Inflow to the propeller
    r"\tau_P": mmg.loading,  # Thrust over density and squared diameter
    "T": mmg.thrust,  # Thrust
    "u_R": mmg.axial_velocity,  # Inflow along the rudder
    r"\beta_R": mmg.inflow_angle,  # Angle of the inflow to the rudder
    "v_R": mmg.lateral_velocity,  # Inflow across the rudder
    "F_N": mmg.normal_force,  # Normal force of the rudder
    r"\delta_B": clearance.delta,  # Pressure parameter of the banks
}
DIGITS = 4
# Letters on a line of a page with usual margins, and of an expression that needs no name of its own, by ``_letters``.
LINE, WIDEST = 57, 54


def latex(
    table: TermTable, coefficients: Mapping[str, float] | None = None, forces: Sequence[str] = tuple(FORCES)
) -> str:
    """Write the equations of the forces in lines that fit a page; forces without terms are left out.

    Quantities that several terms share, such as the inflow to a rudder, are defined below with the symbols of the MMG
    standard method, or as ``q_1`` and so on.

    Raises an InputError if a force does not exist, or a regressor does more than arithmetic.

    Parameters
    ----------
    table : TermTable
        The terms.
    coefficients : mapping of str to float, optional
        Values to write instead of the coefficients' symbols, to four digits.
    forces : sequence of str
        Forces to write: ``X``, ``Y``, ``N``.

    Examples
    --------
    >>> print(nw.latex(nw.PAPER, forces=("X",)).count("="))
    1
    """
    for force in forces:
        check_choice("force", force, FORCES)
    written = Equations(table)
    return environment("aligned", [*written.of_forces(forces, coefficients), *written.definitions()])


def environment(name: str, lines: Sequence[str]) -> str:
    rows = " \\\\\n".join(lines)
    return f"\\begin{{{name}}}\n{rows}\n\\end{{{name}}}"


@dataclass
class Equations:
    table: TermTable
    symbols: dict[Expr, str] = field(default_factory=dict)  # Symbols as written
    meanings: dict[str, Expr] = field(default_factory=dict)  # Definitions of the symbols, in order
    used: set[Expr] = field(default_factory=set)

    def __post_init__(self) -> None:
        notes, inputs, results = notes_of_terms(self.table)
        lines = list(notes.lines)
        named = _named(inputs, len(lines))
        values: list[Any] = []
        for number, (sign, *operands) in enumerate(lines):
            if sign == "input":
                values.append(symbol(operands[0]))
                self.symbols[values[-1]] = WRITTEN.get(operands[0], rf"\text{{{operands[0].replace('_', ' ')}}}")
            elif sign == "number":
                values.append(_constant(operands[0]))
            else:
                values.append(self._operation(sign, [int(one) for one in operands], values))
            if number in named and not values[-1].is_Atom:
                values[-1] = self._defined(named[number], values[-1])
        self.regressors: dict[str, Expr] = {name: values[line] for name, line in results.items()}

    def _defined(self, written: str, value: Expr) -> Expr:
        self.meanings[written] = value
        name = symbol(f"defined_{len(self.meanings)}")
        self.symbols[name] = written
        return name

    def _operation(self, sign: str, operands: list[int], values: list[Any]) -> Expr:
        """Do an operation; if it makes a line too long, its longest operand gets a symbol first."""
        operation = OPERATORS.get(sign) or FUNCTIONS[sign]
        while True:
            value = operation(*(values[one] for one in operands))
            longest = max(operands, key=lambda one: _letters(self.text(values[one])))
            if _letters(self.text(value)) <= WIDEST or values[longest].is_Atom:
                return value
            number = sum(written.startswith("q_") for written in self.meanings) + 1
            values[longest] = self._defined(f"q_{{{number}}}", values[longest])

    def of_forces(self, forces: Sequence[str], coefficients: Mapping[str, float] | None = None) -> list[str]:
        """Return one line per force, or more if one is too long; terms whose coefficient is zero are left out."""
        lines = []
        for force in forces:
            terms = [term for term in self.table.forces[force] if coefficients is None or coefficients[term.name]]
            parts = [self._term(term, coefficients) for term in terms]
            if self.table.forces[force]:
                first, *others = _packed(parts) or ["0"]
                lines += [f"{force} &= {first.removeprefix('+ ')}", *(rf"&\quad {other}" for other in others)]
        return lines

    def _term(self, term: Any, coefficients: Mapping[str, float] | None) -> str:
        expression = self.regressors[term.name]
        self.used |= expression.free_symbols
        minus = expression.could_extract_minus_sign()
        times = self.text(-expression if minus else expression)
        value = None if coefficients is None else coefficients[term.name]
        sign = "-" if minus != (value is not None and value < 0) else "+"
        own = {self.symbols.get(symbol(name)) for name in term.inputs}
        factor = (f"({term.symbol})" if re.search(r" [+-] ", term.symbol) else term.symbol) if value is None else ""
        # The rigid body's own mass is not written twice.
        factor = "" if factor in own and times else factor
        if value is not None and not (abs(value) == 1 and times):
            factor = _number(abs(value))
        return f"{sign} {factor} {times}".replace("  ", " ").rstrip()

    def text(self, expression: Expr) -> str:
        """Write an expression that is a factor of a product."""
        import sympy

        if expression == 1:
            return ""
        text = str(sympy.latex(expression, symbol_names=self.symbols))
        text = text.replace(r"\operatorname{maximum}", r"\max").replace(r"\operatorname{minimum}", r"\min")
        return rf"\left({text}\right)" if expression.is_Add else text

    def definitions(self) -> list[str]:
        """Return a line for each symbol that the forces written so far use, after its first use."""
        lines, named = [], {self.symbols[one]: one for one in self.symbols}
        for written, value in reversed(self.meanings.items()):
            if named[written] in self.used:
                self.used |= value.free_symbols
                text = self.text(value)
                bare = text[len(r"\left(") : -len(r"\right)")] if value.is_Add else text
                lines.append(f"{written} &= {bare}")
        return lines


def _named(inputs: Mapping[str, Recorded], known: int) -> dict[int, str]:
    """Return the symbols of named quantities, by their line on the trace."""
    found: dict[int, str] = {}
    for written, function in NAMED.items():
        asked = Grouped(function) if argument_names(function) == ("at",) else function
        names = argument_names(asked)
        if all(name in inputs for name in names):
            value = asked(*[inputs[name] for name in names])
            found |= {value.line: written} if value.line < known else {}
    return found


def _packed(parts: Sequence[str]) -> list[str]:
    lines: list[str] = []
    for part in parts:
        if lines and _letters(longer := f"{lines[-1]} {part}") <= LINE:
            lines[-1] = longer
        else:
            lines.append(part)
    return lines


def _constant(text: str) -> Expr:
    """Return a number of the equations, as a multiple of pi if it is one."""
    from sympy import nsimplify, pi

    if text.lstrip("-").isdigit():
        return exact_number(int(text))
    share = nsimplify(float(text) * pi.evalf(20), tolerance=1e-12, rational=True)
    return share / pi if share.q == 1 and share != 0 else exact_number(float(text))


def _letters(written: str) -> int:
    """Return about the width of a formula [letters]; both parts of a fraction count, which makes lines shorter."""
    plain = re.sub(r"\\(left|right|frac|mathrm|,|quad)|[{}_^ ]", "", written)
    return len(re.sub(r"\\[a-zA-Z]+", "x", plain)) + 2 * len(re.findall(r" [+-] ", written))


def _number(value: float) -> str:
    digits, _, exponent = f"{value:.{DIGITS}g}".partition("e")
    return rf"{digits} \cdot 10^{{{int(exponent)}}}" if exponent else digits
