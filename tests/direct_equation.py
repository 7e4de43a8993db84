"""The equation of motion evaluated directly from the table of terms: the reference for every compiled form."""

from typing import Any

import numpy as np

from narrows.codegen.free_motion import ACCELERATIONS
from narrows.model.model import Model
from narrows.quantities.names import FORCES, Number
from narrows.ship.motion import Motion


def accelerations(
    model: Model, motion: Motion, forces: tuple[Number, Number, Number] = (0.0, 0.0, 0.0),
    surge_inertia: float | None = None,
) -> np.ndarray:  # fmt: skip
    """Solve M d(nu)/dt = f + d_bank + inputs for the accelerations, (3, ...).

    A captive test measures F(motion, accelerations); a free ship has F + inputs = 0. F is linear in the accelerations,
    so M is the decrease of F per unit of each.
    """
    still = _forces(model, motion)
    shape = np.broadcast(*still, *forces).shape
    columns = [_forces(model, motion, **{name: 1.0}) for name in ACCELERATIONS.values()]
    matrix = np.empty((*shape, 3, 3))
    right = np.empty((*shape, 3))
    for i in range(3):
        right[..., i] = still[i] + forces[i]
        for j in range(3):
            matrix[..., i, j] = still[i] - columns[j][i]
    if surge_inertia is None:
        matrix[..., 0, :], right[..., 0] = (1.0, 0.0, 0.0), 0.0
    else:
        matrix[..., 0, 0] = surge_inertia
    return np.moveaxis(np.linalg.solve(matrix, right[..., None])[..., 0], -1, 0)


def _forces(model: Model, motion: Motion, **unit: float) -> list[Any]:
    moving = {**motion.values(), **dict.fromkeys(ACCELERATIONS.values(), 0.0), **unit}
    forces = model.forces(Motion(**moving))
    return [forces[force] for force in FORCES]
