"""The linear state-space system of a ship about a steady course, with named states and inputs."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from inspect import isfunction, signature
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.base.aliases import name_here
from narrows.base.errors import check_choice, needs
from narrows.base.results import BaseResult
from narrows.control.settings import FREQUENCIES

if TYPE_CHECKING:
    import pandas as pd

UNITS = {
    "y": "m", "psi": "rad", "u": "m/s", "v": "m/s", "r": "rad/s", "rudder": "rad", "revolutions": "1/s", "X": "N",
    "Y": "N", "N": "N m", "current": "m/s", "curvature": "1/m",
}  # fmt: skip


class Nomoto(NamedTuple):
    """Indices of the yaw rate r by the rudder: T r' + r = K rudder, and T1 T2 r'' + (T1 + T2) r' + r = K (1 + T3 d/dt).

    Nomoto, Taguchi, Honda and Hirano (1957), On the steering qualities of ships. Negative for an unstable ship.
    """

    K: float  # Steady yaw rate per rudder angle [1/s]
    T: float  # T1 + T2 - T3 [s]
    T1: complex  # The larger time constant [s]
    T2: complex  # The smaller time constant [s]
    T3: float  # [s]


@dataclass(frozen=True, repr=False, eq=False)
class LinearSystem(BaseResult):
    """A ship near its steady course: dx/dt = A x + B u + G d, exact in the limit of small x, u and d.

    x, u and d are deviations of state, controls and disturbances from the course.
    """

    A: np.ndarray  # (states, states) Rates by states
    B: np.ndarray  # (states, controls) Rates by positions of actuators
    # (states, disturbances) Rates by external forces, the current along the line, and the line's curvature
    G: np.ndarray
    states: tuple[str, ...]  # Names of rows and columns, in ``units``
    controls: tuple[str, ...]
    disturbances: tuple[str, ...]
    # The steady course: y [m], u [m/s], psi, rudder [rad], v [m/s], r [rad/s] and other constant quantities
    course: Mapping[str, float]
    length: float  # Length of the ship [m]; with its speed it scales the states
    notes: tuple[str, ...]  # Notes on the validity of the system

    @property
    def units(self) -> dict[str, str]:
        """The unit of each state, control and disturbance."""
        return {name: UNITS.get(name, "") for name in (*self.states, *self.controls, *self.disturbances)}

    def matrices(self, *controls: str) -> tuple[np.ndarray, np.ndarray]:
        """Return A and B, with B for some controls; for all unless given."""
        for name in controls:
            check_choice("control", name, self.controls)
        return self.A, self.B[:, [self.controls.index(name) for name in controls or self.controls]]

    def __iter__(self) -> Iterator[np.ndarray]:
        """A and B, as in ``A, B = model.linearize()``."""
        return iter(self.matrices())

    def eigenvalues(self) -> np.ndarray:
        """Return the eigenvalues of A [1/s], (states,), the most unstable first."""
        values = np.linalg.eigvals(self.A).astype(complex)
        return np.asarray(values[np.argsort(-values.real, kind="stable")])

    def modes(self) -> "pd.DataFrame":
        """Return the modes: growth rate, doubling or halving time, period, damping ratio, shape.

        The shape is the eigenvector with states in ship lengths and speeds, its largest entry 1.
        """
        import pandas as pd

        speed, (values, vectors) = self.course["u"], np.linalg.eig(self.A)
        sizes = {"y": self.length, "u": speed, "v": speed, "r": speed / self.length}
        order = np.argsort(-values.real, kind="stable")
        values, shapes = values[order], vectors[:, order]
        shapes = shapes / np.array([[sizes.get(name, 1.0)] for name in self.states])
        shapes = shapes / shapes[np.abs(shapes).argmax(axis=0), np.arange(len(values))]
        with np.errstate(divide="ignore"):
            times = {
                "doubling_s": np.where(values.real > 0, np.log(2) / values.real, np.inf),
                "halving_s": np.where(values.real < 0, -np.log(2) / values.real, np.inf),
                "period_s": 2 * np.pi / np.abs(values.imag),
            }
        damping = (0.0 - values.real) / np.maximum(np.abs(values), np.finfo(float).tiny)  # 0 of a zero root
        shape = dict(zip(self.states, shapes, strict=True))
        rates = {"growth": values.real, "angular_frequency": values.imag}
        return pd.DataFrame({**rates, **times, "damping_ratio": damping, **shape}).rename_axis("mode")

    def nomoto(self) -> Nomoto:
        """Return Nomoto's indices of the rudder, from sway and yaw alone: without bank, line and other controls.

        Raises an InputError if the ship has no rudder.
        """
        A, b = self.matrices("rudder")
        (a_vv, a_vr), (a_rv, a_rr) = A[np.ix_(*[[self.states.index(name) for name in ("v", "r")]] * 2)]
        b_v, b_r = (float(b[self.states.index(name), 0]) for name in ("v", "r"))
        stiffness, push = a_vv * a_rr - a_vr * a_rv, a_rv * b_v - a_vv * b_r
        T12, T3 = -(a_vv + a_rr) / stiffness, b_r / push
        T1, T2 = sorted(-1 / np.linalg.eigvals([[a_vv, a_vr], [a_rv, a_rr]]), key=abs, reverse=True)
        return Nomoto(float(push / stiffness), float(T12 - T3), T1, T2, float(T3))

    def state_space(self) -> Any:
        """Return a state space of python-control, with named states, inputs and outputs.

        Its inputs are controls, then disturbances; its outputs are the states. Its methods and the functions of
        python-control for it are those of this system, too: ``bode(input="rudder", output="r")``, ``sample(0.5)`` ...
        """
        with needs("control", "state_space"):
            import control
        inputs, states = [*self.controls, *self.disturbances], list(self.states)
        named: dict[str, Any] = {"inputs": inputs, "states": states, "outputs": states, "name": "ship"}
        return control.ss(self.A, np.hstack([self.B, self.G]), np.eye(len(states)), 0, **named)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            try:
                return super().__getattr__(name)
            except AttributeError:
                if name[0] == "_" or not find_spec("control") or (found := of_python_control(self, name)) is None:
                    raise
                return found

    def summary(self) -> str:
        at, growth = self.course, float(self.eigenvalues()[0].real)
        rudder = f"rudder {np.degrees(at['rudder']):.2f} degrees" if "rudder" in at else "held by forces from outside"
        bend = f" in a bend of {1 / abs(at['curvature']):.4g} m" if at["curvature"] else ""
        where = f"{at['y']:g} m off the middle at {at['u']:.3g} m/s{bend}"
        held = f"{rudder}, heading {np.degrees(at['psi']):.2f} degrees"
        return f"Motion about the steady course {where}: {held}; the largest growth rate is {growth:.3g} 1/s."

    def to_dict(self) -> dict[str, Any]:
        values = self.eigenvalues()
        names = {name: getattr(self, name) for name in ("states", "controls", "disturbances", "units", "A", "B", "G")}
        poles = np.stack([values.real, values.imag], axis=-1)
        names |= {"course": dict(self.course), "eigenvalues": poles}
        return {**names, "summary": self.summary(), "notes": list(self.notes)}

    def to_dataframe(self) -> "pd.DataFrame":
        """Return A, B and G side by side: a row per rate, a column per state, control, disturbance."""
        import pandas as pd

        rows = pd.Index([f"d{name}/dt" for name in self.states], name="rate")
        return pd.DataFrame(np.hstack([self.A, self.B, self.G]), index=rows, columns=list(self.units))


def of_python_control(linear: LinearSystem, name: str) -> Any:
    """Return what python-control has under a name for the state space of a system; None if nothing.

    Its functions take names of signals, from controls to states: ``bode("rudder", "r")`` or ``input=``, ``output=``.
    """
    import control

    name = name_here(name, "python_control") or name
    function = getattr(control, f"{name}_plot", None) or getattr(control, name, None)
    if not isfunction(function) or "A" in signature(function).parameters:
        return getattr(linear.state_space(), name, None)

    def called(*values: Any, input: Any = None, output: Any = None, **given: Any) -> Any:
        signals = [value for value in values if isinstance(value, str)]
        from_one = input or [name for name in signals if name in linear.controls] or list(linear.controls)
        to_one = output or [name for name in signals if name in linear.states] or list(linear.states)
        numbers = [value for value in values if not isinstance(value, str)]
        return function(linear.state_space()[to_one, from_one], *numbers, **given)

    return called


def loop_margins(
    A: np.ndarray, B: np.ndarray, C: np.ndarray, lowest: float, highest: float, dt: float
) -> dict[str, float]:  # fmt: skip
    """Return the margins of the discrete loop C (zI - A)^-1 B under negative feedback, from frequencies [rad/s]."""
    # Astrom and Murray (2021), Feedback Systems, 2nd ed., section 10.3. Crossings between two frequencies of a fine
    # grid are refined by 40 bisections; "distance" is the modulus margin, from -1 to the Nyquist curve.
    unit = np.eye(len(A))

    def response(omega: np.ndarray) -> np.ndarray:
        z, right = np.exp(1j * omega * dt)[:, None, None], np.broadcast_to(B, (len(omega), *B.shape))
        return np.asarray((C @ np.linalg.solve(z * unit - A, right))[:, 0, 0])

    omega = np.geomspace(lowest, highest, FREQUENCIES)
    loop = response(omega)

    def crossings(value: Callable[[np.ndarray], np.ndarray], where: np.ndarray | bool) -> np.ndarray:
        signs = value(loop) > 0
        first = np.flatnonzero((signs[1:] != signs[:-1]) & where)
        low, high, start = omega[first], omega[first + 1], signs[first]
        for _ in range(40):
            middle = np.sqrt(low * high)
            same = (value(response(middle)) > 0) == start
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return np.sqrt(low * high)

    gain_crossings = crossings(lambda at: np.abs(at) - 1.0, True)
    # Phase crossing at half a turn: the imaginary part changes its sign while the real part is negative.
    phase_crossings = crossings(np.imag, loop.real[:-1] < 0)
    # At rest, and at half the sampling frequency, the loop is real.
    ends = (_value_at(A, B, C, at) for at in (1.0, -1.0))
    negative = [*np.abs(response(phase_crossings)), *(-value for value in ends if value < 0)]
    factors, phase = 1.0 / np.array(negative), np.angle(-response(gain_crossings))
    # A delay turns the loop clockwise: the delay margin is the clockwise angle to half a turn.
    delays = np.mod(phase, 2 * math.pi) / gain_crossings
    distance = float(np.abs(1.0 + loop).min())
    return {
        "gain": float(factors[factors > 1].min(initial=math.inf)),
        "gain_down": float(factors[factors < 1].max(initial=0.0)),
        "phase_deg": float(np.degrees(np.abs(phase)).min(initial=math.inf)),
        "delay": float(delays.min(initial=math.inf)),
        "distance": distance,
        "sensitivity_peak": 1.0 / distance,
    }


def _value_at(A: np.ndarray, B: np.ndarray, C: np.ndarray, at: float) -> float:
    """Return C (at I - A)^-1 B; 0 at a pole of the loop."""
    matrix = at * np.eye(len(A)) - A
    return float((C @ np.linalg.solve(matrix, B))[0, 0]) if np.linalg.matrix_rank(matrix) == len(A) else 0.0
