"""Exact derivatives of the motion, from the same trace: by state, by control, by coefficient."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from narrows.compile.emit import Constants, Emitted, function
from narrows.compile.spell import PLAIN
from narrows.compile.trace import ACCELERATIONS, ARGUMENTS, INPUTS, STATE, Expr, symbol
from narrows.quantities.names import FORCES, Number
from narrows.ship.actuators import RUDDER

LINEARISED = ("x", "y", "psi", "u", "v", "r")
"""The state of a linearised model; the heading is one angle [rad] again."""
CONTROLLED = (*INPUTS.values(), "rudder", "revolutions")
"""What a linearised model is driven by; the rudder is one angle [rad] again."""
HEADER = '''"""Made by narrows {version} from a table of terms: made again where it is missing, so do not edit."""
from numpy import log

E = 2.718281828459045
'''


def jacobian_text(emitted: Emitted, names: Iterable[str], version: str) -> str:
    """Write the module of derivatives.

    Parameters
    ----------
    emitted : Emitted
        The equations, with inputs as arguments.
    names : iterable of str
        Every coefficient of the table, in order.
    version : str
        Of narrows.
    """
    constants = emitted.constants
    rates = _rates(emitted)
    wholes = {
        "state": [entry for rate in rates for entry in _by_state(rate)],
        "controls": [entry for rate in rates for entry in _by_control(rate)],
        "coefficients": _by_coefficient(emitted, constants, tuple(names)),
    }
    arguments = (*STATE, *emitted.inputs, *constants.names)
    texts = [function(name, arguments, entries, PLAIN) for name, entries in wholes.items()]
    return "\n\n".join([HEADER.format(version=version), emitted.prologue(), *texts])


def _rates(emitted: Emitted) -> list[Expr]:
    """Derivatives in time of the linearised state."""
    xdot, ydot, _, _, udot, vdot, rdot = emitted.derivatives
    return [xdot, ydot, symbol("r"), udot, vdot, rdot]


def _by_state(rate: Expr) -> list[Expr]:
    turned = _turned(rate, "psi")
    return [turned if name == "psi" else _slope(rate, symbol(name)) for name in LINEARISED]


def _by_control(rate: Expr) -> list[Expr]:
    return [_turned(rate, name) if name == "rudder" else _slope(rate, symbol(name)) for name in CONTROLLED]


def _turned(rate: Expr, angle: str) -> Expr:
    """Differentiate by an angle that enters as its cosine and sine."""
    cosine, sine = symbol(f"cos_{angle}"), symbol(f"sin_{angle}")
    return cosine * _slope(rate, sine) - sine * _slope(rate, cosine)


def _slope(expression: Expr, by: Expr) -> Expr:
    """Differentiate; the slope of |a| is the sign of a, and sign(a) a is |a|."""
    import sympy

    class size(sympy.Function):  # type: ignore[misc]
        def fdiff(self, argindex: int = 1) -> Expr:
            return sympy.sign(self.args[0])

    slope = sympy.sympify(expression).replace(sympy.Abs, size).diff(by)
    return slope.replace(lambda e: e.is_Mul and e.has(sympy.sign), _unsigned).replace(size, sympy.Abs)


def _unsigned(product: Expr) -> Expr:
    import sympy

    for factor in product.args:
        if isinstance(factor, sympy.sign) and factor.args[0] in product.args:
            return product / factor / factor.args[0] * sympy.Abs(factor.args[0])
    return product


def _by_coefficient(emitted: Emitted, constants: Constants, names: tuple[str, ...]) -> list[Expr]:
    """With F(accelerations) + F_in = 0 a coefficient moves the accelerations by M^-1 times its regressor."""
    import sympy

    traced = emitted.traced
    solved = dict(zip(ACCELERATIONS, emitted.derivatives[4:], strict=True))
    moved = {symbol(ACCELERATIONS[force]): value for force, value in solved.items()}
    rows = dict(zip(traced.freedoms, traced.pushes, strict=True))
    entries: dict[tuple[str, str], Expr] = {}
    for name, (force, regressor) in traced.regressors.items():
        column = constants.lift(sympy.sympify(regressor))
        for row, inverse in rows.items():
            entries[row, name] = constants.lift(inverse[traced.freedoms.index(force)]) * column.subs(moved)
    zero = sympy.Integer(0)
    still = [zero] * (len(names) * (len(LINEARISED) - len(FORCES)))
    return still + [entries.get((force, name), zero) for force in FORCES for name in names]


@dataclass(frozen=True)
class Linearisation:
    """Derivatives of the motion of one ship, or of a fleet where the values were columns.

    Parameters
    ----------
    module : module
        The generated functions.
    constants : tuple of number
        Of the ship.
    names : tuple of str
        The coefficients, in the order of the columns of ``coefficients``.
    """

    module: ModuleType
    constants: tuple[Number, ...]
    names: tuple[str, ...]

    def state(self, state: Mapping[str, Number], inputs: Mapping[str, Number] | None = None) -> np.ndarray:
        """Differentiate the rates of x, y, psi, u, v, r by x, y, psi, u, v, r: (..., 6, 6).

        Parameters
        ----------
        state : mapping of str to number
            By the names of ``STATE``: heading as ``cos_psi`` and ``sin_psi``; SI.
        inputs : mapping of str to number, optional
            ``X_in`` [N], ``Y_in`` [N], ``N_in`` [N m], ``cos_rudder``, ``sin_rudder`` [1], ``revolutions`` [1/s];
            no force, the rudder amidships and a propeller that stands unless given.
        """
        return self._matrix("state", state, inputs)

    def controls(self, state: Mapping[str, Number], inputs: Mapping[str, Number] | None = None) -> np.ndarray:
        """Differentiate the same rates by ``CONTROLLED``, forces, rudder and revolutions: (..., 6, 5).

        Parameters
        ----------
        state : mapping of str to number
            By the names of ``STATE``; SI.
        inputs : mapping of str to number, optional
            ``X_in`` [N], ``Y_in`` [N], ``N_in`` [N m], ``cos_rudder``, ``sin_rudder`` [1], ``revolutions`` [1/s];
            no force, the rudder amidships and a propeller that stands unless given.
        """
        return self._matrix("controls", state, inputs)

    def coefficients(self, state: Mapping[str, Number], inputs: Mapping[str, Number] | None = None) -> np.ndarray:
        """Differentiate the same rates by every coefficient of the table: (..., 6, n).

        Parameters
        ----------
        state : mapping of str to number
            By the names of ``STATE``; SI.
        inputs : mapping of str to number, optional
            ``X_in`` [N], ``Y_in`` [N], ``N_in`` [N m], ``cos_rudder``, ``sin_rudder`` [1], ``revolutions`` [1/s];
            no force, the rudder amidships and a propeller that stands unless given.
        """
        return self._matrix("coefficients", state, inputs)

    def _matrix(self, name: str, state: Mapping[str, Number], inputs: Mapping[str, Number] | None) -> np.ndarray:
        values: list[Any] = [state.get(part, 0.0) for part in STATE]
        values += [{**RUDDER.at_rest(), **(inputs or {})}.get(part, 0.0) for part in ARGUMENTS]
        entries = getattr(self.module, name)(*values, *self.constants)
        shape = np.broadcast_shapes(*(np.shape(value) for value in (*values, *self.constants)))
        stacked = np.stack([np.broadcast_to(entry, shape) for entry in entries], axis=-1)
        return stacked.reshape(*shape, len(LINEARISED), -1)
