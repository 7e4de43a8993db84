"""Steady courses: the balance of sway and yaw by drift and rudder, with its exact slopes, compiled for many ships."""

from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from narrows.codegen.cache import generated

if TYPE_CHECKING:
    from narrows.codegen.system import System

STEERED_BY = "rudder"


def balance_module(system: "System") -> ModuleType:
    """Return the module that finds steady courses; its ``solve`` compiles when first called."""
    # Its ``COLUMNS`` names what a row of its table holds: constants of the ship, y [m], u [m/s], forces from outside,
    # the curvature of the ship's own path ``path_curvature`` [1/m], to starboard, and the current along it [m/s].
    return generated("balance", system.key, lambda: _text(system))


def _text(system: "System") -> str:
    import sympy

    from narrows.codegen.derivatives import with_tangents
    from narrows.codegen.free_motion import STATE
    from narrows.codegen.kernels.elementary import HEADER, elementary_text
    from narrows.codegen.lines import FUNCTIONS, Lines, real
    from narrows.codegen.printers.python import Arithmetic

    lines, (drift, angle) = Lines(), (real("drift"), real("angle"))
    cosine = lines.put("cos_psi", (1 + drift * drift) ** sympy.Rational(-1, 2))
    at = {name: real(name) for name in (*STATE, *system.rates.moving)}
    sway = lines.put("v", drift * real("u"))
    pace = lines.put("pace", real("u") * cosine + sway * drift * cosine + real("current"))
    at |= {"cos_psi": cosine, "sin_psi": lines.put("sin_psi", -drift * cosine), "v": sway}
    at |= {
        "r": lines.put("r", real("path_curvature") * pace),
        f"cos_{STEERED_BY}": lines.put("cos_angle", FUNCTIONS["cosine"](angle)),
        f"sin_{STEERED_BY}": lines.put("sin_angle", FUNCTIONS["sine"](angle)),
    }
    rates = system.rates.written(lines, "", at)
    unit = {drift: [sympy.Integer(1), sympy.Integer(0)], angle: [sympy.Integer(0), sympy.Integer(1)]}
    more, slopes = with_tangents(lines, unit, 2)
    out = [rates["v"], rates["r"], *slopes(rates["v"]), *slopes(rates["r"])]
    program, printer = more.needed_for(out), Arithmetic(column="{:.1f}".format)
    inputs = tuple(name for name in program.inputs if name not in ("drift", "angle"))
    body = [f"{name} = inputs[{number}]" for number, name in enumerate(inputs)]
    body += [f"{name} = {printer.doprint(value)}" for name, value in program.assignments]
    body.append(f"return {', '.join(printer.doprint(value) for value in out)}")
    text = "\n    ".join(["@called\ndef balance(drift, angle, inputs):", *body]) + "\n"
    tail = Path(__file__).with_name("kernels").joinpath("newton.py").read_text(encoding="utf-8")
    head = HEADER.format(version=version("narrows"), precision="float64")
    # The series of the kernels hold up to a quarter turn, and no further is looked: the C library's do as well here.
    names = f"COLUMNS = {inputs!r}\nCELL_ENTRIES = 16\nsine, cosine = sin, cos\n"
    return "\n\n".join([head, names, elementary_text(text.replace("sine(", ""), "float64"), text, tail])
