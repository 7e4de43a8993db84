"""Motion about a state with the controls held: eigenvalues, and the stiffness of the bank."""

from typing import Any

import numpy as np
import xarray as xr

from narrows.codegen.free_motion import INPUTS as PUSHES
from narrows.codegen.linearisation import LINEARISED
from narrows.model.model import Model
from narrows.ship.particulars import Configuration
from narrows.simulation.grid import INPUTS, START, grid_of
from narrows.simulation.ship import SimulatedShip

FELT = ("y", "psi", "v", "r")
"""What runs away or comes back: nothing depends on x, and the speed is held."""
OPEN_WATER = ("v", "r")


def bank_stiffness(configuration: Configuration) -> float:
    """Return the slope of delta across the centreline [1/m], 8 B W / (W - B)^3.

    Parameters
    ----------
    configuration : Configuration
        Ship and canal.

    References
    ----------
    The derivative of Mikkelsen et al. (2025), eq. (Delta_1); closed form ours.
    """
    beam, width = configuration.ship.beam, configuration.canal.width
    return 8 * beam * width / (width - beam) ** 3


def eigenvalues(model: Model, bank: bool = True, **state: Any) -> np.ndarray:
    """Return the eigenvalues of motion about a state [1/s], the most unstable first.

    Parameters
    ----------
    model : Model
        The ship in her canal.
    bank : bool
        With the bank: of (y, psi, v, r); without: of (v, r) in open water.
    **state : float
        x, y [m], psi [rad], u, v [m/s], r [rad/s], rudder [rad], revolutions [1/s]; on the centreline at 1 m/s, the
        rudder amidships and the propeller as the model has it unless given.
    """
    return np.asarray(stability(model, bank, **state)["eigenvalue"].to_numpy().ravel())


def stability(model: Model, bank: bool = True, **vary: Any) -> xr.Dataset:
    """Map the eigenvalues of motion over states, speeds, canals and coefficients.

    Parameters
    ----------
    model : Model
        The ship in her canal.
    bank : bool
        With the bank, or in open water.
    **vary : number, sequence or DataArray
        As in ``ensemble``.

    Returns
    -------
    xarray.Dataset
        ``eigenvalue`` [1/s], complex, along ``mode``, the most unstable first; ``growth`` [1/s], the largest real
        part.
    """
    ship = SimulatedShip(model)
    grid = grid_of(model, vary, samples=0, seed=0)
    values, shape = grid.flat(slice(0, grid.sizes[grid.axis]))
    silent = {} if bank else {term.name: 0.0 for term in model.terms.terms if term.from_bank}
    given = {**ship.values(), **values, **silent}
    linear = ship.system().linearisation(given, ship.actuators)
    at = {name: values[name] for name in START} | {own.name: given.get(own.name, 0.0) for own in ship.actuators}
    matrix = linear.state(at | {name: values[own] for name, own in zip(PUSHES.values(), INPUTS, strict=True)})
    place = [LINEARISED.index(name) for name in (FELT if bank else OPEN_WATER)]
    found = np.linalg.eigvals(matrix[..., np.array(place)[:, None], place])
    found = np.take_along_axis(found, np.argsort(-found.real, axis=-1, kind="stable"), axis=-1)
    found = np.broadcast_to(found, (grid.vessels, len(place))).reshape(*shape, len(place))
    data = {
        "eigenvalue": ((*grid.sizes, "mode"), found, {"units": "1/s"}),
        "growth": (tuple(grid.sizes), found.real.max(axis=-1), {"units": "1/s", "long_name": "largest growth rate"}),
    }
    return xr.Dataset(data, coords=grid.coordinates())
