"""A pilot as a linear law with an aim that wanders: what the rudder contributes to the likelihood."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from narrows.logbook.filtering.first_guess import first_guess
from narrows.logbook.filtering.predicted_signals import ERROR, ONE, RUDDER, PredictedSignal, SeenStates
from narrows.logbook.filtering.record_grid import HELM, RecordGrid
from narrows.logbook.filtering.recorded_motion import RecordedMotion

SEEN = (1, 2, 4, 5)  # y, psi, v and r among the states: what a pilot answers
FITTED = 20  # records that the first gains are fitted to
RIDGE = 1e-3  # of the mean square of what is regressed on


@dataclass(frozen=True)
class HelmLaw:
    """The rudder at the end of a step by the rudder and the states at its start."""

    # A pilot who sees more than the sensors makes the rudder informative about the ship: without this factor of the
    # likelihood coefficients are biased alike in every record.

    scale: np.ndarray  # (5,) Units of the gains: of the rudder before, y, psi, v and r
    gains: np.ndarray  # (5,) In these units

    def moved(self, numbers: np.ndarray) -> "HelmLaw":
        """Return the law with other gains."""
        return replace(self, gains=self.gains + numbers)

    def predicted(self, at: SeenStates, before: np.ndarray) -> PredictedSignal:
        """Return the recorded rudder at the end of a step, from that before, (n,)."""
        by_rudder, *by_state = (self.gains * self.scale).tolist()
        value = by_rudder * before + at.states[:, SEEN] @ by_state + at.error(ERROR(HELM))
        return PredictedSignal(value, {i: gain * ONE for i, gain in zip(SEEN, by_state, strict=True)}, {ERROR(HELM): ONE})


def fitted_helm(law: HelmLaw, motion: RecordedMotion, grids: Iterable[RecordGrid]) -> HelmLaw:
    """Regress recorded rudders on those before and on smoothed readings: the gains to begin with."""
    square, product = np.zeros((5, 5)), np.zeros(5)
    for grid in islice(grids, FITTED):
        read, states = grid.readings[HELM], first_guess(motion, grid)
        columns = np.column_stack([grid.positions[RUDDER][read.row], states[read.window][:, SEEN]]) * law.scale
        columns -= columns.mean(axis=0)
        square += columns.T @ columns
        product += columns.T @ (read.values - read.values.mean())
    return replace(law, gains=np.linalg.solve(square + RIDGE * np.diag(np.diag(square)), product))
