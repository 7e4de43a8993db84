"""Motion about a state with the controls held: eigenvalues and bank stiffness."""

from typing import Any

import numpy as np
import xarray as xr

from narrows.aliases import accept_aliases
from narrows.codegen.free_motion import INPUTS as PUSHES
from narrows.codegen.linearisation import LINEARISED
from narrows.model.model import Model
from narrows.ship.particulars import Configuration
from narrows.simulation.grid import grid_of
from narrows.simulation.initial_state import check_irrelevant
from narrows.simulation.inputs import INPUTS, START
from narrows.simulation.outcome import section_notes
from narrows.simulation.ship import SimulatedShip


def bank_stiffness(configuration: Configuration) -> float:
    """Return the slope of delta across the centreline [1/m], 8 B W / (W - B)^3.

    Parameters
    ----------
    configuration : Configuration
        Ship and canal.

    References
    ----------
    The derivative of Mikkelsen et al. (2025), eq. (Delta_1).

    Examples
    --------
    >>> round(float(nw.bank_stiffness(model.configuration)), 3)
    0.121
    """
    beam, width = configuration.ship.beam, configuration.canal.width
    return 8 * beam * width / (width - beam) ** 3


def eigenvalues(model: Model, bank: bool = True, **state: Any) -> np.ndarray:
    """Return the eigenvalues of motion about a state [1/s], the most unstable first.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    bank : bool
        True: of (y, psi, v, r) with the bank; false: of (v, r) in open water.
    **state : float
        x, y [m], psi [rad], u, v [m/s], r [rad/s], rudder [rad], revolutions [1/s]. Default: on the centreline at 1
        m/s, rudder amidships, the model's propeller revolutions.

    Examples
    --------
    >>> round(float(nw.eigenvalues(model, y=0.5, u=1.0).real.max()), 3)
    0.266
    """
    return np.asarray(stability(model, bank, **state)["eigenvalue"].to_numpy().ravel())


@accept_aliases
def stability(model: Model, bank: bool = True, **vary: Any) -> xr.Dataset:
    """Map the eigenvalues of motion over states, speeds, canals and coefficients.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    bank : bool
        With the bank, or in open water.
    **vary : number, sequence or DataArray
        As in ``ensemble``.

    Returns
    -------
    xarray.Dataset
        ``eigenvalue`` [1/s], complex, along ``mode``, the most unstable first; ``growth`` [1/s], the largest real part;
        ``notes`` names models without a bank force and sections outside the tested range.

    Raises
    ------
    InputError
        If a name is unknown, or has no effect.
    """
    ship = SimulatedShip(model)
    grid = grid_of(model, vary, samples=0, seed=0)
    check_irrelevant(ship, {name: value for name, value in vary.items() if name not in INPUTS})
    values, shape = grid.flat(slice(0, grid.sizes[grid.axis]))
    silent = {} if bank else {term.name: 0.0 for term in model.terms.terms if term.from_bank}
    inputs = {**ship.values(), **values, **silent}
    linear = ship.linearisation(inputs)
    at = {name: values[name] for name in START} | {mover.name: inputs.get(mover.name, 0.0) for mover in ship.actuators}
    matrix = linear.state(at | {name: values[force] for name, force in zip(PUSHES.values(), INPUTS, strict=True)})
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
