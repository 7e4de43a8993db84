"""What a voyage takes where nothing is said: a speed, a time, a step and offsets that suit the size of the ship."""

import math
from typing import NamedTuple

from narrows.model.model import Model
from narrows.model.squat import choke_speed
from narrows.quantities.constants import GRAVITY

# Of the speed, over the ship's length.
FROUDE = 0.16
# Of the speed that chokes the canal, which is not passed.
OF_CHOKING = 0.7
# Ship lengths of a voyage, and steps in each.
LENGTHS, STEPS_A_LENGTH = 15.0, 200.0
# Of the way from the middle to where the side of the hull meets a bank.
ASIDE = 0.78


class UsualVoyage(NamedTuple):
    """What suits a ship."""

    speed: float  # Within what the tests covered, and below choking [m/s]
    duration: float  # Of fifteen ship lengths [s]
    dt: float  # Of a two hundredth of a ship length [s]
    offset: float  # Farthest off the middle where a map starts [m]


def usual_voyage(model: Model, speed: float | None = None) -> UsualVoyage:
    """Return what suits the ship of a model in its canal, each to two digits."""
    # speed [m/s]
    ship, canal = model.configuration.ship, model.configuration.canal
    u = _speed(model) if speed is None else abs(speed) or _speed(model)
    pace = ship.length / u
    offset = max(canal.width - ship.beam, 0.0) / 2 * ASIDE
    return UsualVoyage(*(float(f"{value:.2g}") for value in (u, LENGTHS * pace, pace / STEPS_A_LENGTH, offset)))


def _speed(model: Model) -> float:
    ship, known = model.configuration.ship, model.data_range.speed
    low, high = known or (0.0, math.inf)
    most = OF_CHOKING * choke_speed(model.configuration) if model.configuration.canal.depth else math.inf
    return min(max(FROUDE * math.sqrt(GRAVITY * ship.length), low), high, most)
