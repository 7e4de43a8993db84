"""Where a ship may go: places of the members time after time, to be drawn and not to be warned by."""

from typing import NamedTuple

import numpy as np

from narrows.warning.forecasting.forecast_cases import AFTER, AS_IS, NEVER, Case
from narrows.warning.forecasting.future_lanes import FutureBlock

# Between the places of a track [s].
EVERY = 10.0
TIMES = tuple(np.arange(EVERY, AFTER + EVERY / 2, EVERY).tolist())
# Whose tracks are drawn.
FAN_MEMBERS = 32
AS_IT_IS = tuple(Case(f"{AS_IS} for {t:g} s", NEVER, t) for t in TIMES)
WITH_PILOT = tuple(Case(f"pilot for {t:g} s", 0.0, t) for t in TIMES)
# A lane for every place of a track: it ends there.
BLOCKS = FutureBlock(AS_IT_IS, FAN_MEMBERS), FutureBlock(AS_IT_IS, 1), FutureBlock(WITH_PILOT, 1)


class PredictedFan(NamedTuple):
    """Tracks, each pose of them along the waterway and off its line [m] and the heading to it [rad]."""

    times: np.ndarray  # (times,) From now on [s]
    # (members, times, 3) Of ships that what is known leaves possible, the rudder as it is; one that meets a bank
    # stays there
    members: np.ndarray
    likely: np.ndarray  # (times, 3) Of the most likely one
    pilot: np.ndarray  # (times, 3) Of the same with a pilot who takes over now


def fan_of(poses: list[np.ndarray]) -> PredictedFan:
    """Return the tracks of lanes that were laid out by ``BLOCKS``."""
    # poses (times, ships, 3)
    members, likely, pilot = poses
    return PredictedFan(np.array(TIMES), members.swapaxes(0, 1), likely[:, 0], pilot[:, 0])
