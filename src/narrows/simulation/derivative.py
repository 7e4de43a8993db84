"""The motion of one ship at a moment: its rates, derivatives and eigenvalues."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, did_you_mean, shown
from narrows.base.results import BaseResult
from narrows.codegen.free_motion import INPUTS, Surge
from narrows.codegen.linearisation import LINEARISED
from narrows.model.model import Model
from narrows.quantities.names import FORCES, Number
from narrows.ship.checks import check_angles
from narrows.simulation.grid import grid_of
from narrows.simulation.initial_state import POSE, check_irrelevant, check_positions
from narrows.simulation.inputs import START, finite_numbers
from narrows.simulation.outcome import section_notes
from narrows.simulation.ship import SimulatedShip


@accept_aliases
def derivative(
    model: Model, state: Any, *, X: Number = 0.0, Y: Number = 0.0, N: Number = 0.0, surge: Surge = "held",
    surge_inertia: float | None = None, coriolis: bool = False, **positions: Number,
) -> np.ndarray:  # fmt: skip
    """Return the rates of x, y [m/s], psi [rad/s], u, v [m/s2] and r [rad/s2] of the free ship, (6, ...).

    Raises an InputError if the state is not of six numbers, or an actuator is unknown.

    Parameters
    ----------
    model, state : Model, sequence of six numbers or mapping of str to number
        x, y [m], psi [rad], u, v [m/s], r [rad/s]; floats or columns. A mapping's missing entries are 0.
    X, Y, N, surge, surge_inertia, coriolis
        As for ``simulate`` [N, N m, kg], but constant.
    **positions : number
        Positions of actuators by name: rudder [rad], revolutions [1/s]; at rest unless given.

    Examples
    --------
    >>> nw.derivative(model, (0.0, 0.5, 0.0, 1.0, 0.0, 0.0)).shape
    (6,)
    """
    ship = SimulatedShip(model, surge, surge_inertia, coriolis)
    check_positions(positions, ship)
    at = {name: np.asarray(value, float) for name, value in state_of(state).items()}
    rates = ship.rates(ship.values(**positions), {**at, "X": X, "Y": Y, "N": N})
    return np.stack(np.broadcast_arrays(*(rates[name] for name in POSE)))


def state_of(state: Any) -> dict[str, Number]:
    if isinstance(state, Mapping):
        for name in state:
            if name not in POSE:
                raise InputError(f"a state has no {name!r}{did_you_mean(str(name), POSE)}")
        return {name: state.get(name, 0.0) for name in POSE}
    if np.ndim(state) == 0 or len(state) != len(POSE):
        raise InputError(f"state = {shown(state)} is not {', '.join(POSE)}; give these six, or some of them by name")
    return dict(zip(POSE, state, strict=True))


@dataclass(frozen=True, repr=False, eq=False)
class Jacobian(BaseResult):
    """Exact derivatives of the rates of x, y, psi, u, v, r at a state.

    >>> nw.jacobian(model, y=0.5, u=1.0).A.shape
    (6, 6)
    """

    A: np.ndarray  #: (6, 6) Derivatives by the state: SI units of rate over state
    B: np.ndarray  #: (6, inputs) Derivatives by external forces X, Y [N], N [N m] and positions of actuators
    G: np.ndarray  #: (6, coefficients) Derivatives by the coefficients of the model
    states: tuple[str, ...]  #: Names of the rows
    inputs: tuple[str, ...]  #: Names of the columns of B
    coefficients: tuple[str, ...]  #: Names of the columns of G
    state: dict[str, Number]  #: The state: x, y [m], psi [rad], u, v [m/s], r [rad/s]
    notes: tuple[str, ...]  #: Uncertainties of the bank force

    def poles(self) -> np.ndarray:
        """Return the eigenvalues of A [1/s], the most unstable first."""
        found = np.linalg.eigvals(self.A)
        return np.asarray(found[np.argsort(-found.real, kind="stable")])

    def summary(self) -> str:
        where = ", ".join(f"{name} = {float(value):.3g}" for name, value in self.state.items() if value)
        return f"Motion about {where or 'rest'}: the largest growth rate is {self.poles()[0].real:.3g} 1/s."

    def to_dict(self) -> dict[str, Any]:
        poles = [[float(pole.real), float(pole.imag)] for pole in self.poles()]
        names = {name: getattr(self, name) for name in ("state", "states", "inputs", "coefficients", "A", "B", "G")}
        return {**names, "poles": poles, "summary": self.summary(), "notes": list(self.notes)}

    def to_dataframe(self) -> pd.DataFrame:
        """Return A and B side by side: one row per rate, one column per state or input."""
        rows = pd.Index([f"d{name}/dt" for name in self.states], name="rate")
        return pd.DataFrame(np.hstack([self.A, self.B]), index=rows, columns=[*self.states, *self.inputs])


@accept_aliases
def jacobian(
    model: Model, y: float = 0.0, u: float = 1.0, *, x: float = 0.0, psi: float = 0.0, v: float = 0.0, r: float = 0.0,
    X: float = 0.0, Y: float = 0.0, N: float = 0.0, surge: Surge = "held", surge_inertia: float | None = None,
    coriolis: bool = False, **positions: float,
) -> Jacobian:  # fmt: skip
    """Differentiate the motion of the free ship exactly at a state.

    Raises an InputError if a number is not finite, or an actuator is unknown.

    Parameters
    ----------
    model, y, u, x, psi, v, r : Model, float [m, m/s, m, rad, m/s, rad/s]
        The state; y is to starboard of the centreline.
    X, Y, N, surge, surge_inertia, coriolis, **positions
        As for ``derivative`` [N, N m, kg].

    Examples
    --------
    >>> round(float(nw.jacobian(model, y=0.5, u=1.0).poles()[0].real), 3)
    0.266
    """
    ship = SimulatedShip(model, surge, surge_inertia, coriolis)
    check_positions(positions, ship)
    state = state_of((x, y, psi, u, v, r))
    numbers = finite_numbers(**state, X=X, Y=Y, N=N, **positions)
    check_angles(numbers)
    pushes, movers = {INPUTS[force]: numbers[force] for force in FORCES}, [one.name for one in ship.actuators]
    values = {**ship.values(**positions), **pushes}
    linear, at = ship.linearisation(values), {**state, **pushes, **{name: values.get(name, 0.0) for name in movers}}
    a, b = np.split(linear.linear(at), [len(LINEARISED)], axis=1)
    slopes = linear.coefficients(at)
    return Jacobian(a, b, slopes, LINEARISED, (*FORCES, *movers), linear.names, state, model.bank_notes)


@accept_aliases
def stability(model: Model, bank: bool = True, **vary: Any) -> xr.Dataset:
    """Map the eigenvalues of motion over states, speeds, canals and coefficients.

    The result has ``eigenvalue`` [1/s], complex, along ``mode``, the most unstable first; ``growth`` [1/s], the largest
    real part; ``notes`` names models without a bank force and sections outside the tested range.

    Raises an InputError if a name is unknown, or has no effect.

    Parameters
    ----------
    model, bank : Model, bool
        True: of (y, psi, v, r) with the bank; false: of (v, r) in open water.
    **vary : number, sequence or DataArray
        As in ``ensemble``; default: on the centreline at 1 m/s, rudder amidships, the model's propeller revolutions.

    Examples
    --------
    >>> round(float(nw.stability(model, y=0.5, u=1.0)["growth"].item()), 3)
    0.266
    """
    ship = SimulatedShip(model)
    grid = grid_of(model, vary, samples=0, seed=0)
    check_irrelevant(ship, {name: value for name, value in vary.items() if name not in INPUTS})
    values, shape = grid.flat(slice(0, grid.sizes[grid.axis]))
    silent = {} if bank else {term.name: 0.0 for term in model.terms.terms if term.from_bank}
    inputs = {**ship.values(), **values, **silent}
    linear = ship.linearisation(inputs)
    at = {name: values[name] for name in START} | {mover.name: inputs.get(mover.name, 0.0) for mover in ship.actuators}
    matrix = linear.linear(at | {name: values[force] for force, name in INPUTS.items()})
    states = ("y", "psi", "v", "r") if bank else ("v", "r")  # Nothing depends on x, and the speed is constant
    indices = [LINEARISED.index(name) for name in states]
    modes = np.linalg.eigvals(matrix[..., np.array(indices)[:, None], indices])
    modes = np.take_along_axis(modes, np.argsort(-modes.real, axis=-1, kind="stable"), axis=-1)
    modes = np.broadcast_to(modes, (grid.vessels, len(indices))).reshape(*shape, len(indices))
    data = {
        "eigenvalue": ((*grid.sizes, "mode"), modes, {"units": "1/s"}),
        "growth": (tuple(grid.sizes), modes.real.max(axis=-1), {"units": "1/s", "long_name": "largest growth rate"}),
    }
    notes = (*(model.bank_notes if bank else ()), *section_notes(model, inputs, bank))
    return xr.Dataset(data, coords=grid.coordinates(), attrs={"notes": "\n".join(notes)})
