"""About what forces a run would have: errors of gain and zero are shares of them."""

from dataclasses import replace

import numpy as np

from narrows.captive.runs import Run
from narrows.captive.synthetic import motion_of
from narrows.experiment_design.information import Forces
from narrows.model.froude import scale_model
from narrows.model.model_file import published
from narrows.ship.particulars import Configuration


def expected_forces(configuration: Configuration) -> Forces:
    """Return about what forces a motion would have: those of the published model by Froude's law."""
    scaled = scale_model(published("mikkelsen2025_dtc"), configuration.ship.length).model
    model = replace(scaled, configuration=configuration)
    return lambda motion, _: model.forces(motion)


def usual_forces(offered: list[Run], forces: Forces) -> dict[str, float]:
    """Return the root mean square of each force over the runs on offer [N, N, N m]."""
    squares = [
        {
            force: float(np.mean(np.square(values)))
            for force, values in forces(motion_of(run.columns(1.0)), run.depth).items()
        }
        for run in offered
    ]
    return {force: float(np.sqrt(np.mean([square[force] for square in squares]))) for force in squares[0]}
