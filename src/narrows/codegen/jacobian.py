"""Exact derivatives of the motion, from the same trace: by state, by control, by coefficient."""

from collections.abc import Mapping, Sequence

from sympy import Integer, sympify

from narrows.codegen.choices import Actuated
from narrows.codegen.derivatives import with_tangents
from narrows.codegen.free_motion import ACCELERATIONS, STATE, Expr, FreeMotion, symbol
from narrows.codegen.kernels.elementary import HEADER, elementary_text
from narrows.codegen.linearisation import LINEARISED, arguments, controlled
from narrows.codegen.lines import Lines, real
from narrows.codegen.lowering import straight_lines
from narrows.codegen.printers.python import Arithmetic, function_text
from narrows.codegen.rates import Rates
from narrows.quantities.names import FORCES

ANGLES = ("cos_{}", "sin_{}")


def jacobian_text(
    motion: FreeMotion, names: Sequence[str], actuators: Sequence[Actuated], section: Sequence[str] = ()
) -> str:
    """Write the module of derivatives."""
    rates = Rates(motion, arguments(actuators, section)[len(STATE) :], pushed=True)
    linear, by_coefficient = _linear(rates, actuators), _by_coefficient(rates, names)
    constants = rates.constants
    inputs = (*arguments(actuators, section), *constants.names)
    assignments, results = straight_lines(list(constants.table))
    used = set().union(*(expression.free_symbols for expression in constants.table))
    asked = {name: parameter for name, parameter in motion.names.items() if parameter in used}
    parts = [
        f"PARAMETERS = {tuple(asked)!r}\nCONSTANTS = {constants.names!r}",
        function_text("constants", [str(parameter) for parameter in asked.values()], assignments, results),
        function_text("linear", inputs, linear[0].needed_for(linear[1]).assignments, linear[1]),
        function_text(
            "coefficients", inputs, by_coefficient[0].needed_for(by_coefficient[1]).assignments, by_coefficient[1]
        ),
    ]
    return "\n\n".join(parts)


def _directions(actuators: Sequence[Actuated]) -> tuple[str, ...]:
    return (*LINEARISED, *controlled(actuators))


BATCH = """
@cached
def batch(values, constants, out):
    for row in range(len(values)):
        derivatives = linear(values[row], constants)
        for entry in range(len(derivatives)):
            out[row, entry] = derivatives[entry]
"""


def batch_text(motion: FreeMotion, actuators: Sequence[Actuated], version: str, section: Sequence[str] = ()) -> str:
    """Write the module of derivatives by state and control, to be compiled."""
    rates = Rates(motion, arguments(actuators, section)[len(STATE) :], pushed=True)
    (lines, results), printer = _linear(rates, actuators), Arithmetic(column="{:.1f}".format)
    body = [f"{name} = values[{index}]" for index, name in enumerate(arguments(actuators, section))]
    body += [f"{name} = constants[{index}]" for index, name in enumerate(rates.constants.names)]
    body += [f"{name} = {printer.doprint(value)}" for name, value in lines.needed_for(results).assignments]
    body.append(f"return ({', '.join(printer.doprint(sympify(value)) for value in results)},)")
    text = "\n    ".join(["@called\ndef linear(values, constants):", *body]) + "\n"
    head = HEADER.format(version=version, precision="float64")
    return "\n\n".join([head, "CELL_ENTRIES = 0", elementary_text(text, "float64"), text, BATCH])


def _linear(rates: Rates, actuators: Sequence[Actuated]) -> tuple[Lines, list[Expr]]:
    lines, results = rates.program()
    return linear_slopes(lines, {**results, "psi": real("r")}, actuators)


def linear_slopes(lines: Lines, rates: Mapping[str, Expr], actuators: Sequence[Actuated]) -> tuple[Lines, list[Expr]]:
    """Write the derivatives of the rates of ``LINEARISED`` by state and by control, row by row."""
    angles = {"psi", *(actuator.name for actuator in actuators if actuator.angle)}
    directions = _directions(actuators)
    slopes: dict[Expr, list[Expr]] = {}
    for number, name in enumerate(directions):
        moved = _angle_slopes(name) if name in angles else {name: 1}
        for component, slope in moved.items():
            slopes[real(component)] = [slope if k == number else 0 for k in range(len(directions))]
    more, slopes_of = with_tangents(lines, slopes, len(directions))
    return more, [entry for name in LINEARISED for entry in slopes_of(rates[name])]


def _angle_slopes(name: str) -> dict[str, Expr]:
    cosine, sine = (text.format(name) for text in ANGLES)
    return {cosine: -real(sine), sine: real(cosine)}


def _by_coefficient(rates: Rates, names: Sequence[str]) -> tuple[Lines, list[Expr]]:
    lines = Lines()
    return lines, coefficient_slopes(lines, rates, names, {name: real(name) for name in (*STATE, *rates.moving)})


def coefficient_slopes(lines: Lines, rates: Rates, names: Sequence[str], values: Mapping[str, Expr]) -> list[Expr]:
    """Write the derivatives of the accelerations by coefficients, row by row."""
    # With F(accelerations) + F_in = 0 a coefficient moves the accelerations by M^-1 times its regressor.
    motion = rates.motion
    solved = rates.written(lines, "", values)
    known = list(motion.regressors)
    columns = [rates.constants.lift(sympify(motion.regressors[name][1])) for name in known]
    where = {symbol(name): solved[state] for name, state in zip(ACCELERATIONS.values(), ("u", "v", "r"), strict=True)}
    where |= {symbol(name): value for name, value in values.items()}
    regressors = dict(zip(known, lines.inline("g_", *straight_lines(columns), where), strict=True))
    rows = dict(zip(motion.freedoms, motion.pushes, strict=True))
    entries = []
    for force in FORCES:
        for name in names:
            if name not in regressors or force not in rows:
                entries.append(Integer(0))
                continue
            inverse = rates.constants.lift(rows[force][motion.freedoms.index(motion.regressors[name][0])])
            entries.append(inverse * regressors[name])
    return entries
