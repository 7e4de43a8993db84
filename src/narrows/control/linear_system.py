"""The linear state-space system of a ship about a steady course, with named states and inputs."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.errors import InputError, check_choice, needs
from narrows.base.results import BaseResult
from narrows.control.settings import FREQUENCIES

if TYPE_CHECKING:
    import pandas as pd
    import xarray

UNITS = {
    "y": "m", "psi": "rad", "u": "m/s", "v": "m/s", "r": "rad/s", "rudder": "rad", "revolutions": "1/s", "X": "N",
    "Y": "N", "N": "N m", "current": "m/s", "curvature": "1/m",
}  # fmt: skip
RANK_TOLERANCE = 1e-9  # Smallest singular value relative to the largest that counts in a rank [1]
LOWEST, HIGHEST = 1e-5, 1e5  # Frequency range of margins, relative to speed over length [rad]


@dataclass(frozen=True, repr=False, eq=False)
class LinearSystem(BaseResult):
    """A ship near its steady course: dx/dt = A x + B u + G d, exact in the limit of small x, u and d.

    x, u and d are deviations of state, controls and disturbances from the course. With several courses, the dimensions
    of ``course`` come first in the matrices; methods for one course then raise ``InputError``: choose one by ``one``.
    """

    A: np.ndarray  # (..., states, states) Rates by states
    B: np.ndarray  # (..., states, controls) Rates by positions of actuators
    # (..., states, disturbances) Rates by external forces, the current along the line, and the line's curvature
    G: np.ndarray
    states: tuple[str, ...]  # Names of rows and columns, in ``units``
    controls: tuple[str, ...]
    disturbances: tuple[str, ...]
    # The steady course: y [m], u [m/s], psi, rudder [rad], v [m/s], r [rad/s] and other constant quantities
    course: Mapping[str, np.ndarray]
    varied: tuple[str, ...]  # The dimensions, in order: y, u, or none
    motion: Callable[[Mapping[str, Any]], Mapping[str, Any]]  # Rates of y, psi, u, v, r of the nonlinear ship
    length: float  # Length of the ship [m]; with its speed it scales the states
    notes: tuple[str, ...]  # Notes on the validity of the system

    @property
    def units(self) -> dict[str, str]:
        """The unit of each state, control and disturbance."""
        return {name: UNITS.get(name, "") for name in (*self.states, *self.controls, *self.disturbances)}

    def one(self, *index: int) -> "LinearSystem":
        """Return one course of several, by its index in each dimension of ``varied``."""
        course = {name: column[index] for name, column in self.course.items()}
        parts = {name: getattr(self, name)[index] for name in ("A", "B", "G")}
        return replace(self, **parts, course=course, varied=())

    def matrices(self, *controls: str) -> tuple[np.ndarray, np.ndarray]:
        """Return A and B of one course, with B for some controls; for all unless given."""
        for name in controls:
            check_choice("control", name, self.controls)
        columns = [self.controls.index(name) for name in controls or self.controls]
        return self._of_one(self.A), self._of_one(self.B)[:, columns]

    def __iter__(self) -> Iterator[np.ndarray]:
        """A and B, as in ``A, B = model.linearize()``."""
        return iter(self.matrices())

    def rates(self, x: np.ndarray, u: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Return the nonlinear rates of the states at absolute states x, actuator positions u and disturbances d."""
        names = (*self.states, *self.controls, *self.disturbances)
        rates = self.motion({**self.course, **dict(zip(names, (*x, *u, *d), strict=True))})
        return np.array([float(rates[name]) for name in self.states])

    def eigenvalues(self) -> np.ndarray:
        """Return the eigenvalues of A [1/s], (..., states), the most unstable first."""
        values = np.full(self.A.shape[:-1], np.nan + 0j)
        known = np.isfinite(self.A).all(axis=(-2, -1))
        values[known] = np.linalg.eigvals(self.A[known])
        return np.take_along_axis(values, np.argsort(-values.real, axis=-1, kind="stable"), axis=-1)

    def modes(self) -> "pd.DataFrame":
        """Return the modes of one course: growth rate, doubling or halving time, period, damping ratio, shape.

        The shape is the eigenvector with states in ship lengths and speeds, its largest entry 1.
        """
        import pandas as pd

        values, vectors = np.linalg.eig(self._of_one(self.A))
        order = np.argsort(-values.real, kind="stable")
        values, shapes = values[order], (vectors / self._scales()[:, None])[:, order]
        shapes = shapes / shapes[np.abs(shapes).argmax(axis=0), np.arange(len(values))]
        with np.errstate(divide="ignore"):
            times = {
                "doubling_s": np.where(values.real > 0, np.log(2) / values.real, np.inf),
                "halving_s": np.where(values.real < 0, -np.log(2) / values.real, np.inf),
                "period_s": 2 * np.pi / np.abs(values.imag),
            }
        damping = np.where(values != 0, -values.real / np.maximum(np.abs(values), np.finfo(float).tiny), 0.0)
        shape = dict(zip(self.states, shapes, strict=True))
        rates = {"growth": values.real, "angular_frequency": values.imag}
        return pd.DataFrame({**rates, **times, "damping_ratio": damping, **shape}).rename_axis("mode")

    def controllability(self, *controls: str) -> int:
        """Return the number of states of one course that the controls reach: the rank of Kalman's matrix.

        States are scaled to ship lengths. Give ``controls`` to use some alone.
        """
        A, B = self.matrices(*controls)
        scales = self._scales()
        A, B = self._time_scale() * A * scales / scales[:, None], B / scales[:, None]
        sizes = np.linalg.norm(B, axis=0)
        unit_columns = B / np.where(sizes > 0, sizes, 1.0)
        reached = np.hstack([np.linalg.matrix_power(A, power) @ unit_columns for power in range(len(A))])
        return int(np.linalg.matrix_rank(reached, tol=RANK_TOLERANCE * np.linalg.norm(reached, 2)))

    def margins(self, gains: Any, control: str = "rudder") -> dict[str, float]:
        """Return the margins of the loop closed by ``u = -gains x``, broken at one control, as ``ClosedLoop.margins``.

        ``gains``: control per deviation of each state. With two more gains they are those of a regulator: the control's
        rate is proportional to the states, to the control itself and to the integral of the offset.
        """
        gains, count = np.asarray(gains, float), len(self.states)
        if gains.shape not in ((count,), (count + 2,)):
            raise InputError(
                f"there are {count} states, {', '.join(self.states)}; give a gain for each, and where a rate is "
                "ordered two more, for the control and the integral of the offset"
            )
        (A, B), C = self.matrices(control), gains[None, :]
        if len(gains) > count:
            # States, then the ordered control and the integral of the offset.
            whole = np.zeros((count + 2, count + 2))
            whole[:count, :count], whole[count], whole[count + 1, self.states.index("y")] = A, -gains, 1.0
            A, B, C = whole, np.vstack([B, np.zeros((2, 1))]), -np.eye(count + 2)[count : count + 1]
        return loop_margins(A, B, C, LOWEST / self._time_scale(), HIGHEST / self._time_scale())

    def state_space(self) -> Any:
        """Return one course as a state space of python-control, with named states, inputs and outputs.

        Its inputs are controls, then disturbances; its outputs are the states.
        """
        with needs("control", "state_space"):
            import control
        inputs, states = [*self.controls, *self.disturbances], list(self.states)
        driven = np.hstack([self._of_one(self.B), self._of_one(self.G)])
        named: dict[str, Any] = {"inputs": inputs, "states": states, "outputs": states, "name": "ship"}
        return control.ss(self._of_one(self.A), driven, np.eye(len(states)), 0, **named)

    def nonlinear(self) -> Any:
        """Return the nonlinear ship as a system of python-control, with the names of ``state_space``.

        Its states and inputs are absolute, not deviations: ``operating_point`` gives those of the course.
        """
        self._of_one(self.A)
        with needs("control", "nonlinear"):
            import control
        split, rates = len(self.controls), self.rates

        def update(t: float, x: np.ndarray, u: np.ndarray, parameters: Mapping[str, Any]) -> np.ndarray:
            return rates(x, u[:split], u[split:])

        inputs, states = [*self.controls, *self.disturbances], list(self.states)
        return control.nlsys(update, None, inputs=inputs, states=states, outputs=states, name="ship")

    def operating_point(self) -> tuple[np.ndarray, np.ndarray]:
        """Return absolute states and inputs of one course, for ``nonlinear``."""
        self._of_one(self.A)
        names = (*self.controls, *self.disturbances)
        state, inputs = (np.array([float(self.course[name]) for name in part]) for part in (self.states, names))
        return state, inputs

    def summary(self) -> str:
        if self.A.ndim > 2:
            known = np.isfinite(self.A).all(axis=(-2, -1))
            growth = self.eigenvalues().real.max(axis=-1)[known]
            rates = f": the largest growth rate is {growth.min():.3g} to {growth.max():.3g} 1/s" if known.any() else ""
            return f"Motion about {int(known.sum())} steady courses of {known.size} asked for{rates}."
        at = {name: float(value) for name, value in self.course.items()}
        rudder = f"rudder {np.degrees(at['rudder']):.2f} degrees" if "rudder" in at else "held by forces from outside"
        bend = f" in a bend of {1 / abs(at['curvature']):.4g} m" if at["curvature"] else ""
        where = f"{at['y']:g} m off the middle at {at['u']:.3g} m/s{bend}"
        held, growth = f"{rudder}, heading {np.degrees(at['psi']):.2f} degrees", float(self.eigenvalues()[0].real)
        return f"Motion about the steady course {where}: {held}; the largest growth rate is {growth:.3g} 1/s."

    def to_dict(self) -> dict[str, Any]:
        values = self.eigenvalues()
        names = {name: getattr(self, name) for name in ("states", "controls", "disturbances", "units", "A", "B", "G")}
        poles = np.stack([values.real, values.imag], axis=-1)
        names |= {"course": dict(self.course), "eigenvalues": poles}
        return {**names, "summary": self.summary(), "notes": list(self.notes)}

    def dataset(self) -> "xarray.Dataset":
        """Return the matrices over the dimensions of the courses, with named states and inputs."""
        import xarray

        values, lead = self.eigenvalues(), self.varied
        columns = {"of_state": self.states, "control": self.controls, "disturbance": self.disturbances}
        data = {n: (lead, column, {"units": UNITS.get(n, "")}) for n, column in self.course.items() if n not in lead}
        data |= {n: ((*lead, "state", column), getattr(self, n), {}) for n, column in zip("ABG", columns, strict=True)}
        modes = {"growth": values.real, "angular_frequency": values.imag}
        data |= {name: ((*lead, "mode"), part, {"units": "1/s"}) for name, part in modes.items()}
        labels: dict[str, Any] = {"state": list(self.states)} | {name: list(names) for name, names in columns.items()}
        for axis, name in enumerate(lead):
            column = np.moveaxis(self.course[name], axis, 0)
            labels[name] = (name, column.reshape(len(column), -1)[:, 0], {"units": UNITS[name]})
        return xarray.Dataset(data, coords=labels, attrs={"summary": self.summary(), "notes": "\n".join(self.notes)})

    def to_dataframe(self) -> "pd.DataFrame":
        """Return A, B and G of one course side by side: a row per rate, a column per state, control, disturbance."""
        import pandas as pd

        rows = pd.Index([f"d{name}/dt" for name in self.states], name="rate")
        whole = np.hstack([self._of_one(matrix) for matrix in (self.A, self.B, self.G)])
        return pd.DataFrame(whole, index=rows, columns=[*self.states, *self.controls, *self.disturbances])

    def _of_one(self, matrix: np.ndarray) -> np.ndarray:
        if matrix.ndim > 2:
            raise InputError("these are several courses at once; linearise about one y and one u")
        return matrix

    def _time_scale(self) -> float:
        """Time of one ship length [s]."""
        return self.length / float(self.course["u"])

    def _scales(self) -> np.ndarray:
        """Return the scale of each state, by the ship's length and speed."""
        speed = float(self.course["u"])
        sizes = {"y": self.length, "u": speed, "v": speed, "r": speed / self.length}
        return np.array([sizes.get(name, 1.0) for name in self.states])


def loop_margins(
    A: np.ndarray, B: np.ndarray, C: np.ndarray, lowest: float, highest: float, dt: float = 0.0
) -> dict[str, float]:
    """Return the margins of the loop C (sI - A)^-1 B under negative feedback, or a discrete one if dt [s] is over 0."""
    # Astrom and Murray (2021), Feedback Systems, 2nd ed., section 10.3. Crossings between two frequencies of a fine
    # grid are refined by 40 bisections; "distance" is the modulus margin, from -1 to the Nyquist curve.
    unit = np.eye(len(A))

    def response(omega: np.ndarray) -> np.ndarray:
        s = np.exp(1j * omega * dt) if dt else 1j * omega
        right = np.broadcast_to(B, (len(omega), *B.shape))
        return np.asarray((C @ np.linalg.solve(s[:, None, None] * unit - A, right))[:, 0, 0])

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
    ends = (_value_at(A, B, C, at) for at in ((1.0, -1.0) if dt else (0.0,)))
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
