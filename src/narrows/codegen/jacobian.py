"""Exact derivatives of the motion, from the same trace: by state, by control, by coefficient."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.codegen.derivatives import with_tangents
from narrows.codegen.free_motion import ACCELERATIONS, INPUTS, STATE, Expr, FreeMotion, symbol
from narrows.codegen.lines import Lines, real
from narrows.codegen.lowering import straight_lines
from narrows.codegen.printers.python import function_text
from narrows.codegen.rates import Rates
from narrows.codegen.step import Actuated, control_names
from narrows.quantities.names import FORCES, Number

LINEARISED = ("x", "y", "psi", "u", "v", "r")
"""The state of a linearised model; the heading is one angle [rad] again."""
ANGLES = ("cos_{}", "sin_{}")


def controlled(actuators: Sequence[Actuated]) -> tuple[str, ...]:
    """Return what a linearised model is driven by: forces from outside, and positions of actuators.

    Parameters
    ----------
    actuators : sequence of Actuated
        Of the model.
    """
    return (*INPUTS.values(), *(own.name for own in actuators))


def arguments(actuators: Sequence[Actuated]) -> tuple[str, ...]:
    """Return what the generated functions are given before the constants: state, forces from outside, controls.

    Parameters
    ----------
    actuators : sequence of Actuated
        Of the model.
    """
    return (*STATE, *INPUTS.values(), *(name for own in actuators for name in control_names(own)))


def jacobian_text(motion: FreeMotion, names: Sequence[str], actuators: Sequence[Actuated]) -> str:
    """Write the module of derivatives.

    Parameters
    ----------
    motion : FreeMotion
        The equations of motion.
    names : sequence of str
        Every coefficient of the table, in order.
    actuators : sequence of Actuated
        Of the model.
    """
    rates = Rates(motion, arguments(actuators)[len(STATE) :], pushed=True)
    linear, by_coefficient = _linear(rates, actuators), _by_coefficient(rates, names)
    constants = rates.constants
    given = (*arguments(actuators), *constants.names)
    assignments, results = straight_lines(list(constants.table))
    used = set().union(*(expression.free_symbols for expression in constants.table))
    asked = {name: own for name, own in motion.names.items() if own in used}
    parts = [
        f"PARAMETERS = {tuple(asked)!r}\nCONSTANTS = {constants.names!r}",
        function_text("constants", [str(own) for own in asked.values()], assignments, results),
        function_text("linear", given, linear[0].needed_for(linear[1]).assignments, linear[1]),
        function_text(
            "coefficients", given, by_coefficient[0].needed_for(by_coefficient[1]).assignments, by_coefficient[1]
        ),
    ]
    return "\n\n".join(parts)


def _directions(actuators: Sequence[Actuated]) -> tuple[str, ...]:
    return (*LINEARISED, *controlled(actuators))


def _linear(rates: Rates, actuators: Sequence[Actuated]) -> tuple[Lines, list[Expr]]:
    """The rates of ``LINEARISED`` by state and by control, row by row."""
    lines, found = rates.program()
    angles = {"psi", *(own.name for own in actuators if own.angle)}
    directions = _directions(actuators)
    slopes: dict[Expr, list[Expr]] = {}
    for number, name in enumerate(directions):
        moved = _angle_slopes(name) if name in angles else {name: 1}
        for own, slope in moved.items():
            slopes[real(own)] = [slope if k == number else 0 for k in range(len(directions))]
    more, slopes_of = with_tangents(lines, slopes, len(directions))
    rows = [found["x"], found["y"], real("r"), found["u"], found["v"], found["r"]]
    return more, [entry for row in rows for entry in slopes_of(row)]


def _angle_slopes(name: str) -> dict[str, Expr]:
    cosine, sine = (text.format(name) for text in ANGLES)
    return {cosine: -real(sine), sine: real(cosine)}


def _by_coefficient(rates: Rates, names: Sequence[str]) -> tuple[Lines, list[Expr]]:
    """With F(accelerations) + F_in = 0 a coefficient moves the accelerations by M^-1 times its regressor."""
    import sympy

    motion, lines = rates.motion, Lines()
    solved = rates.written(lines, "", {name: real(name) for name in (*STATE, *rates.moving)})
    known = list(motion.regressors)
    columns = [rates.constants.lift(sympy.sympify(motion.regressors[name][1])) for name in known]
    where = {symbol(name): solved[state] for name, state in zip(ACCELERATIONS.values(), ("u", "v", "r"), strict=True)}
    where |= {symbol(name): real(name) for name in (*STATE, *rates.moving)}
    values = dict(zip(known, lines.inline("g_", *straight_lines(columns), where), strict=True))
    rows = dict(zip(motion.freedoms, motion.pushes, strict=True))
    zero = sympy.Integer(0)
    entries = []
    for force in FORCES:
        for name in names:
            if name not in values or force not in rows:
                entries.append(zero)
                continue
            inverse = rates.constants.lift(rows[force][motion.freedoms.index(motion.regressors[name][0])])
            entries.append(inverse * values[name])
    return lines, entries


@dataclass(frozen=True)
class Linearisation:
    """Derivatives of the motion of one ship, or of a fleet where the values were columns.

    Parameters
    ----------
    functions : mapping of str to callable
        The generated functions, for floats and columns.
    constants : tuple of number
        Of the ship.
    names : tuple of str
        The coefficients, in the order of the columns of ``coefficients``.
    actuators : tuple of Actuated
        Of the model.
    """

    functions: Mapping[str, Any]
    constants: tuple[Number, ...]
    names: tuple[str, ...]
    actuators: tuple[Actuated, ...]

    @property
    def controlled(self) -> tuple[str, ...]:
        """The columns of ``controls``."""
        return controlled(self.actuators)

    def state(self, at: Mapping[str, Number]) -> np.ndarray:
        """Differentiate the rates of x, y, psi, u, v, r by x, y, psi, u, v, r: (..., 6, 6).

        Parameters
        ----------
        at : mapping of str to number
            State, forces from outside and positions of actuators: x, y, psi or cos_psi and sin_psi, u, v, r, X_in,
            Y_in, N_in, rudder, revolutions; SI. On the line, along it, at rest and amidships unless given.
        """
        return self._linear(at)[..., : len(LINEARISED)]

    def controls(self, at: Mapping[str, Number]) -> np.ndarray:
        """Differentiate the same rates by ``controlled``: (..., 6, n).

        Parameters
        ----------
        at : mapping of str to number
            As for ``state``.
        """
        return self._linear(at)[..., len(LINEARISED) :]

    def coefficients(self, at: Mapping[str, Number]) -> np.ndarray:
        """Differentiate the same rates by every coefficient of the table: (..., 6, n).

        Parameters
        ----------
        at : mapping of str to number
            As for ``state``.
        """
        found = self._matrix("coefficients", at, len(FORCES))
        return np.concatenate([np.zeros_like(found), found], axis=-2)

    def _linear(self, at: Mapping[str, Number]) -> np.ndarray:
        return self._matrix("linear", at, len(LINEARISED))

    def _matrix(self, name: str, at: Mapping[str, Number], rows: int) -> np.ndarray:
        values = [*argument_values(at, self.actuators), *self.constants]
        entries = self.functions[name](*values)
        shape = np.broadcast_shapes(*(np.shape(value) for value in values))
        stacked = np.stack([np.broadcast_to(entry, shape) for entry in entries], axis=-1)
        return stacked.reshape(*shape, rows, -1)


def argument_values(at: Mapping[str, Number], actuators: Sequence[Actuated]) -> list[Number]:
    """Return what the generated functions are given before the constants.

    Parameters
    ----------
    at : mapping of str to number
        As for ``Linearisation.state``.
    actuators : sequence of Actuated
        Of the model.
    """
    given = dict(at)
    for name in ("psi", *(own.name for own in actuators if own.angle)):
        if f"cos_{name}" not in given:
            position = given.get(name, 0.0)
            given |= {f"cos_{name}": np.cos(position), f"sin_{name}": np.sin(position)}
    return [given.get(name, 0.0) for name in arguments(actuators)]
