"""Sensitivities: against numbers that carry their own derivatives, against differences, against the voyage itself."""

import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from cases import mmg, paper, steered, waterway_for
from hypothesis import given, settings
from hypothesis import strategies as st

import narrows as nw
from narrows.codegen.free_motion import INPUTS as PUSHES
from narrows.simulation.sensitivities import TangentIntegrator

PILOT = nw.Autopilot(0.3, (0.15, 1.2, 0.4, 2.0), 0.01, 0.005, -0.01)
STATES = ("x", "y", "psi", "u", "v", "r")


@dataclass(frozen=True)
class Dual:
    """A number with its derivatives along some directions."""

    value: float
    slope: np.ndarray

    def __add__(self, other: Any) -> "Dual":
        other = dual(other, self)
        return Dual(self.value + other.value, self.slope + other.slope)

    def __mul__(self, other: Any) -> "Dual":
        other = dual(other, self)
        return Dual(self.value * other.value, self.slope * other.value + self.value * other.slope)

    def __truediv__(self, other: Any) -> "Dual":
        other = dual(other, self)
        ratio = self.value / other.value
        return Dual(ratio, (self.slope - ratio * other.slope) / other.value)

    def __neg__(self) -> "Dual":
        return Dual(-self.value, -self.slope)

    def __sub__(self, other: Any) -> "Dual":
        return self + (-dual(other, self))

    def __rsub__(self, other: Any) -> "Dual":
        return dual(other, self) - self

    def __rtruediv__(self, other: Any) -> "Dual":
        return dual(other, self) / self

    def __abs__(self) -> "Dual":
        return self if self.value >= 0 else -self

    __radd__, __rmul__ = __add__, __mul__


def dual(number: Any, like: Dual) -> Dual:
    return number if isinstance(number, Dual) else Dual(float(number), np.zeros_like(like.slope))


def number_of(value: Any) -> float:
    return value.value if isinstance(value, Dual) else float(value)


def chained(function: Any, slope: Any) -> Any:
    """A function of one number, given its derivative."""

    def of(value: Any) -> Any:
        if not isinstance(value, Dual):
            return function(value)
        return Dual(function(value.value), slope(value.value) * value.slope)

    return of


def turned(cosine: Any, sine: Any) -> Any:
    if not isinstance(cosine, Dual) and not isinstance(sine, Dual):
        return math.atan2(sine, cosine)
    like = cosine if isinstance(cosine, Dual) else sine
    c, s = dual(cosine, like), dual(sine, like)
    size = c.value**2 + s.value**2
    return Dual(math.atan2(s.value, c.value), (c.value * s.slope - s.value * c.slope) / size)


def raised(base: Any, exponent: Any) -> Any:
    value, power = number_of(base), number_of(exponent)
    whole = value**power
    if not isinstance(base, Dual):
        return whole
    return Dual(whole, power * value ** (power - 1) * base.slope)


def functions(table: np.ndarray, row: int) -> dict[str, Any]:
    return {
        "minimum": lambda a, b: a if number_of(a) < number_of(b) else b,
        "maximum": lambda a, b: a if number_of(a) > number_of(b) else b,
        "choice": lambda test, over, under: over if number_of(test) > 0 else under,
        "positive": lambda test: 1.0 if number_of(test) > 0 else 0.0,
        "whole": lambda value: float(int(number_of(value))),
        "angle": turned,
        "sine": chained(math.sin, math.cos),
        "cosine": chained(math.cos, lambda a: -math.sin(a)),
        "sqrt": chained(math.sqrt, lambda a: 0.5 / math.sqrt(a)),
        "exp": chained(math.exp, math.exp),
        "log": chained(math.log, lambda a: 1 / a),
        "power": raised,
        "entry": lambda _, column, cell: float(table[row * int(number_of(cell)) + column]),
    }


def by_dual_numbers(tangent: TangentIntegrator, times: np.ndarray) -> np.ndarray:
    """The printed step and the printed constants, run on dual numbers: (kept, by) at the end."""
    from narrows.codegen.free_motion import ROW

    table = tangent.integrator.channel.table
    system = tangent.integrator.system
    scope = SimpleNamespace(**system._executed("plain", functions(table, ROW)))
    unit = {name: np.array([float(name == other) for other in tangent.by]) for name in tangent.by}
    none = np.zeros(len(tangent.by))
    asked = {name: tangent._ship_values.get(name) or 0.0 for name in (*scope.PARAMETERS, *scope.STEP_INPUTS)}
    values = {
        name: Dual(float(value), unit.get(name, none)) for name, value in asked.items() if name in tangent._ship_values
    }
    for actuator in tangent.ship.actuators:
        if actuator.angle and actuator.name in unit:
            angle = tangent._position(actuator.name)
            values[f"cos_{actuator.name}"] = Dual(math.cos(angle), -math.sin(angle) * unit[actuator.name])
            values[f"sin_{actuator.name}"] = Dual(math.sin(angle), math.cos(angle) * unit[actuator.name])
    constants = dict(
        zip(
            scope.CONSTANTS,
            scope.constants(*(values.get(name, Dual(0.0, none)) for name in scope.PARAMETERS)),
            strict=True,
        )
    )
    pushes = {f"{name}_in": unit.get(name, none) for name in "XYN"}
    laws = {f"law_{name}": slope for name, slope in unit.items()}
    slopes = {**pushes, **laws, **unit}
    numbers = {name: tangent.integrator.inputs[name] for name in scope.STEP_INPUTS if name in tangent.integrator.inputs}
    inputs = {name: Dual(float(value), slopes.get(name, none)) for name, value in numbers.items()}
    inputs |= values | constants
    inputs |= {f"{name}_in": Dual(float(tangent.schedules[name]), pushes[f"{name}_in"]) for name in "XYN"}
    state = [Dual(value, slope) for value, slope in zip(tangent.start, tangent.start_slopes(), strict=True)]
    for length in np.diff(times):
        now = {**inputs, "step_length": Dual(float(length), none), "share": Dual(1.0, none)}
        state = [
            dual(part, state[0])
            for part in scope.step(table, *state, *(now[name] for name in scope.STEP_INPUTS))[: len(state)]
        ]
    return np.array([part.slope for part in state])


CASES = {
    "paper, held, pushed": (
        paper(),
        {"N": 3.0, "Y": -2.0},
        ("y", "psi", "u", "v", "r", "Y", "N", "b_bank", "c_bank", "b_v", "width", "b_vdot"),
    ),
    "paper, free": (paper(), {"surge": "free", "surge_inertia": 340.0}, ("u", "a_u", "X", "b_bank", "psi")),
    "steered, held rudder": (steered(), {"rudder": 0.1, "coriolis": True}, ("rudder", "c_helm", "mass", "b_bank", "y")),
    "steered, pilot": (
        steered(),
        {"controller": PILOT},
        ("by_y", "by_psi", "held_y", "rudder", "c_helm", "b_bank", "psi"),
    ),
    "steered, zigzag": (steered(), {"controller": nw.Zigzag(0.17, 0.06)}, ("c_helm", "psi", "c_bank", "rudder")),
    "mmg, pilot in a waterway": (
        mmg(),
        {
            "controller": PILOT, "waterway": waterway_for("mmg+delta"), "x": 6.0, "v": 0.02, "revolutions": 10.0,
            "surge": "free",
        },
        ("x", "y", "current", "u", "revolutions", "Y_bank", "N_rrr", "by_y", "v"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_slopes_are_those_of_dual_numbers(name: str) -> None:
    """Of the same printed step; the derivative of each line is not ours there."""
    model, told, by = CASES[name]
    voyage = {"y": 0.4, "u": 1.0, **told}
    found = nw.sensitivities(model, by, duration=2.5, dt=0.05, **voyage)
    tangent = TangentIntegrator.of(model, by, voyage)
    expected = by_dual_numbers(tangent, found.voyage.t)
    kept = tangent.integrator.choices.kept
    for state in ("x", "y", "u", "v", "r"):
        size = np.abs(expected[kept.index(state)]).max() or 1.0
        np.testing.assert_allclose(
            found.slopes[-1, STATES.index(state)],
            expected[kept.index(state)],
            rtol=1e-11,
            atol=1e-12 * size,
        )


@pytest.mark.parametrize("name", CASES)
def test_the_tangent_sails_the_voyage(name: str) -> None:
    model, told, by = CASES[name]
    voyage = {"y": 0.4, "u": 1.0, **told}
    sailed = nw.simulate(model, **voyage, duration=2.5, dt=0.05)
    tangent = TangentIntegrator.of(model, by, voyage)
    pushed = dict(zip(PUSHES.values(), tangent._pushes(sailed.t).T, strict=True))
    whole = np.array([0, len(sailed.t) - 1])
    states, _ = tangent.segments(
        np.array([tangent.start]), tangent.start_slopes()[None], whole, pushed, np.diff(sailed.t)
    )
    kept = tangent.integrator.choices.kept
    for column in ("x", "y", "u", "v", "r"):
        np.testing.assert_allclose(states[:, kept.index(column)], sailed[column], rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("by", ["y", "psi", "v", "N", "b_bank", "c_bank", "b_rdot"])
def test_slopes_are_differences_of_voyages(by: str) -> None:
    """Through the public door, to a grounding, with a push that ends."""
    start = {"y": 1.0, "u": 1.0, "psi": 0.02, "v": 0.0, "N": 0.0, "dt": 0.02, "duration": 3.0}
    found = nw.sensitivities(paper(), (by,), **start)
    size = 1e-5 * max(abs(paper().coefficients.get(by, 1.0)), 0.1)

    def end(change: float) -> np.ndarray:
        if by in paper().coefficients:
            changed = paper().with_coefficients(**{by: paper().coefficients[by] + change})
            voyage = nw.simulate(changed, **start)
        else:
            voyage = nw.simulate(paper(), **{**start, by: start[by] + change})
        return np.array([voyage[name][-1] for name in STATES])

    difference = (end(size) - end(-size)) / (2 * size)
    np.testing.assert_allclose(found.slopes[-1, :, 0], difference, rtol=2e-6, atol=1e-7 * np.abs(difference).max())


def test_a_push_that_jumps_counts_while_it_lasts() -> None:
    """The slope is of the voyage with the push, not of one without."""
    pushed = [(0.0, 2.0), (1.0, 0.0)]
    found = nw.sensitivities(paper(), ("y",), y=0.3, N=pushed, duration=3.0, dt=0.05)
    step = 1e-5
    ends = [nw.simulate(paper(), 0.3 + by, duration=3.0, dt=0.05, N=pushed).y[-1] for by in (step, -step)]
    assert found.of("y", "y")[-1] == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-6)


@settings(max_examples=10, deadline=None)
@given(y=st.floats(-1.5, 1.5), psi=st.floats(-0.2, 0.2))
def test_the_mirrored_voyage_has_the_mirrored_slopes(y: float, psi: float) -> None:
    one, other = (
        nw.sensitivities(paper(), ("y", "b_bank"), side * y, psi=side * psi, duration=1.0, dt=0.1) for side in (1, -1)
    )
    np.testing.assert_allclose(one.of("y", "y"), other.of("y", "y"), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(one.of("y", "b_bank"), -other.of("y", "b_bank"), rtol=1e-12, atol=1e-15)


def test_more_directions_than_lanes_are_the_same_one_by_one() -> None:
    names = (*mmg().terms.names, "x", "y", "psi", "u", "v", "r")
    assert len(names) > 32
    start = {"y": 0.5, "duration": 1.0, "dt": 0.1, "revolutions": 10.0}
    together = nw.sensitivities(mmg(), names, **start)
    for name in names[::9]:
        alone = nw.sensitivities(mmg(), (name,), **start)
        np.testing.assert_allclose(alone.of("y", name), together.of("y", name), rtol=1e-12, atol=1e-18)


class Drifter:
    """A controller of Python."""

    def begin(self) -> Any:
        return lambda t, seen: 0.0


@pytest.mark.parametrize(
    ("by", "told", "says"),
    [
        (("b_bnk",), {}, "did you mean"), (("y", "y"), {}, "twice"),
        (("y",), {"controller": Drifter()}, "law in arithmetic"), (("current",), {}, "no 'current'"),
    ],
)  # fmt: skip
def test_what_cannot_be_differentiated_is_said(by: tuple[str, ...], told: dict[str, Any], says: str) -> None:
    with pytest.raises(nw.InputError, match=says):
        nw.sensitivities(steered(), by, duration=1.0, dt=0.1, **told)


def test_the_answer_names_what_moves_the_voyage_most() -> None:
    """By one percent of each quantity, at the end, in metres to starboard."""
    model = paper()
    found = nw.sensitivities(model, ["b_bank", "c_bank", "b_v"], y=0.3, u=0.8, duration=5.0)
    moved = {name: 0.01 * model[name] * found.of("y", name)[-1] for name in found.by}
    largest = max(moved, key=lambda name: abs(moved[name]))
    assert f"to starboard by: {largest} {moved[largest]:+.3g} m" in found.summary()
    told = found.to_dict()
    assert told["at_end"]["y"]["b_bank"] == found.of("y", "b_bank")[-1]
    assert told["notes"] == list(found.voyage.notes) == list(found.notes)
    with pytest.raises(nw.InputError, match="no derivative of y by b_r; by: b_bank, c_bank, b_v"):
        found.of("y", "b_r")
