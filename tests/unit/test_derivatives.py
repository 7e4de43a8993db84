"""Derivatives line by line: against SymPy's own, against central differences, through a whole step in a waterway."""

import math

import numpy as np
import pytest
import sympy

from engine_models import ACTUATED, bent, function_of
from narrows.codegen.free_motion import ROW
from narrows.codegen.kernel import slope, with_tangents
from narrows.codegen.lines import FUNCTIONS, Lines, real
from narrows.codegen.printers.python import function_text
from narrows.codegen.step import step_of
from narrows.codegen.system import scalar_functions
from narrows.simulation.controllers import Autopilot, Zigzag
from narrows.simulation.ship import SimulatedShip, along_waterway, steering_of

A, B, C = (real(name) for name in "abc")
SCALAR = scalar_functions(ROW)
SAMPLES = np.random.default_rng(4).uniform(-2.0, 2.0, (40, 3))
ARITHMETIC = {
    "sum and product": A * B + 3 * A - B * C**2 / 7,
    "quotient": (A - B) / (C**2 + 1),
    "powers": (A**2 + 1) ** sympy.Rational(3, 2) * B**5 - (B**2 + 2) ** sympy.Rational(-1, 2),
    "power of a number": 2 ** (-A / 3) + sympy.exp(A * B / 4),
    "power of a variable": (A**2 + sympy.Rational(1, 2)) ** (B / 2),
    "root": sympy.sqrt(A**2 + B**2 + 1),
}
FUNCTIONS_OF_LINES = {
    "abs": A * sympy.Abs(A * B - C),
    "minimum": FUNCTIONS["minimum"](A * B, C),
    "maximum": FUNCTIONS["maximum"](A, B * C) ** 2,
    "choice": FUNCTIONS["choice"](A - B, A * C, B**2),
    "sine": FUNCTIONS["sine"](A * B),
    "cosine": C * FUNCTIONS["cosine"](A + B),
    "angle": FUNCTIONS["angle"](A, B) * C,
    "whole": A * FUNCTIONS["whole"](3 * B),
    "positive": A * FUNCTIONS["positive"](B - C),
    "nested": FUNCTIONS["minimum"](FUNCTIONS["maximum"](A * B, -C), FUNCTIONS["sine"](sympy.Abs(B))),
}


def value_of(expression: sympy.Expr, at: np.ndarray) -> float:
    """Printed, at a sample of a, b, c."""
    function = function_of(function_text("f", ("a", "b", "c"), [], [expression]), "f", SCALAR)
    return float(function(*map(float, at))[0])


def difference(expression: sympy.Expr, at: np.ndarray, place: int, width: float = 1e-6) -> float:
    step = width * np.eye(3)[place]
    return (value_of(expression, at + step) - value_of(expression, at - step)) / (2 * width)


@pytest.mark.parametrize("name", [*ARITHMETIC, *FUNCTIONS_OF_LINES])
def test_slopes_are_differences(name: str) -> None:
    expression = (ARITHMETIC | FUNCTIONS_OF_LINES)[name]
    for place, by in enumerate((A, B, C)):
        found = slope(expression, by)
        for at in SAMPLES:
            assert value_of(found, at) == pytest.approx(difference(expression, at, place), rel=2e-7, abs=2e-8), (by, at)


def test_an_odd_function_is_smooth_where_it_changes_sign() -> None:
    """|a| a at nought: its slope is nought, and no sign of nought is asked for."""
    assert value_of(slope(A * sympy.Abs(A), A), np.zeros(3)) == 0.0


def test_slopes_go_through_lines() -> None:
    """A line that moves by another's is differentiated by it, along directions of one's own."""
    lines = Lines()
    first = lines.put("first", A * B)
    second = lines.put("second", FUNCTIONS["sine"](first) + C)
    lines.put("aside", C * 2)
    more, slopes_of = with_tangents(lines, {A: [1, 0], B: [0, 2]}, 2)
    out = [second, *slopes_of(second), *slopes_of(C), *slopes_of(first * first)]
    at = SAMPLES[0]
    text = function_text("f", ("a", "b", "c"), more.needed_for(out).assignments, out)
    found = function_of(text, "f", SCALAR)(*map(float, at))
    a, b, c = at
    cosine = math.cos(a * b)
    expected = (math.sin(a * b) + c, cosine * b, 2 * cosine * a, 0, 0, 2 * a * b * b, 4 * a * b * a)
    np.testing.assert_allclose(found, expected, rtol=1e-14)
    assert not any(str(name).startswith("aside_") for name, _ in more.assignments)


LAWS = {
    "pilot": Autopilot(0.3, (0.15, 1.2, 0.4, 2.0), 0.01, 0.005, -0.01),
    "zigzag": Zigzag(0.17, 0.06),
}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", ACTUATED)
def test_tangents_of_a_step_in_a_waterway_are_differences(name: str, law: str) -> None:
    """By everything that is kept, by a number of the law, by a constant of the ship, by the length of the step."""
    model = ACTUATED[name]()
    ship, hull = SimulatedShip(model), model.configuration.ship
    steering = steering_of(LAWS[law], ship.actuators)
    system, values = ship.system(True, steering.law), ship.values()
    channel = along_waterway(bent(hull.length, model.configuration.canal.width), model, ship.shape)
    (lines, after), kept = step_of(system.rates, system.choices), system.choices.kept
    inputs = {
        **values, **system.constants(values), **channel.inputs, **steering.parameters, "step_length": 0.3, "share": 0.7,
    }  # fmt: skip
    size = hull.length / 4
    start = {
        "x": 11.3 * hull.length, "y": 0.21 * size, "cos_psi": math.cos(0.04), "sin_psi": math.sin(0.04), "u": 1.05,
        "v": 0.03, "r": -0.011, "rudder": 0.02,
    }  # fmt: skip
    start |= steering.memory(start)
    number = next(key for key in steering.parameters if key != "law_first")
    moved = [*(n for n in kept if n != "memory_side"), number, "k0", "k1", "share", "current"]
    everything = {**{n: float(inputs[n]) for n in system.scalar.STEP_INPUTS}, **start}
    unit = {real(n): [int(k == place) for k in range(len(moved))] for place, n in enumerate(moved)}
    more, slopes_of = with_tangents(lines, unit, len(moved))
    rows = {n: after[n] for n in (*kept, "clearance", "side")}
    out = [*rows.values(), *(entry for value in rows.values() for entry in slopes_of(value))]
    text = function_text("tangent", ("table", *everything), more.needed_for(out).assignments, out)
    table = channel.table.tolist()
    found = function_of(text, "tangent", SCALAR)(table, *everything.values())

    def stepped(**changed: float) -> np.ndarray:
        given = {**everything, **changed}
        rest = [given[n] for n in system.scalar.STEP_INPUTS]
        return np.array(system.scalar.step(table, *(given[n] for n in kept), *rest))

    np.testing.assert_allclose(found[: len(rows)], stepped(), rtol=1e-13, atol=1e-14)
    slopes = np.array(found[len(rows) :]).reshape(len(rows), len(moved))
    for place, n in enumerate(moved):
        width = 1e-6 * max(1.0, abs(everything[n]))
        ahead, behind = (stepped(**{n: everything[n] + sign * width}) for sign in (1, -1))
        np.testing.assert_allclose(slopes[:, place], (ahead - behind) / (2 * width), rtol=1e-6, atol=2e-8, err_msg=n)
    assert np.count_nonzero(slopes) > 0.4 * slopes.size
