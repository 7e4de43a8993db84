"""A picture of a model: what its banks do across the canal, or its hull in a drift."""

import numpy as np
from matplotlib.figure import Figure

from narrows.model.model import Model
from narrows.report.style import BLUE, FORCE_LABELS, ORANGE, notes_below, panels
from narrows.ship.motion import Motion

REACH, DRIFT, POINTS = 0.9, 20.0, 181
# Froude number of the speed of the picture, where the data did not say one.
SPEED_OF_LENGTH = 0.1


def model_figure(model: Model) -> Figure:
    """Draw sway force and yaw moment over the offset, the bank's part beside the whole; over drift without banks."""
    speed = _speed(model)
    figure, axes = panels(2, 1, 4.2, sharex=True)
    if model.feels_bank:
        place = REACH * _most_offset(model) * np.linspace(-1, 1, POINTS)
        motion, label = Motion(y=place, u=speed), "offset y to starboard of the centreline [m]"
    else:
        place = np.linspace(-DRIFT, DRIFT, POINTS)
        motion = Motion(u=speed * np.cos(np.radians(place)), v=-speed * np.sin(np.radians(place)))
        label = "drift angle, bow to starboard of the way [deg]"
    forces, banks = model.forces(motion), model.bank_forces(motion)
    for panel, force in zip(axes[:, 0], ("Y", "N"), strict=True):
        panel.plot(place, np.broadcast_to(forces[force], place.shape), color=BLUE, label="all terms")
        if model.feels_bank:
            panel.plot(place, np.broadcast_to(banks[force], place.shape), "--", color=ORANGE, label="bank's part")
        panel.set_ylabel(FORCE_LABELS[force])
        panel.grid(alpha=0.3)
    axes[0, 0].set_title(f"{model.ship.in_words}; {speed:.3g} m/s", loc="left")
    axes[0, 0].legend(frameon=False)
    axes[-1, 0].set_xlabel(label)
    notes_below(figure, model.notes)
    return figure


def _most_offset(model: Model) -> float:
    """Of the hull at rest from both banks [m]."""
    return (model.configuration.canal.width - model.ship.beam) / 2


def _speed(model: Model) -> float:
    """The middle of the tested speeds [m/s]."""
    covered = model.data_range.speed
    return float(np.mean(covered)) if covered else SPEED_OF_LENGTH * float(np.sqrt(9.81 * model.ship.length))
