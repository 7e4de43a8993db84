"""The fixed-interval smoother: each state by all that was measured before and after it.

References
----------
Rauch, Tung and Striebel (1965), Maximum likelihood estimates of linear dynamic systems.
Sarkka (2008), Unscented Rauch-Tung-Striebel smoother.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from narrows.estimation.unscented import Normal, Transformed


class Stage(NamedTuple):
    """A step of the filter, as the smoother asks for it."""

    before: Normal  # The state by what was measured until then
    moved: Transformed  # What the motion made of it
    after: Normal  # The state after the motion, before what was measured there


def smoothed(stages: Sequence[Stage], last: Normal) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return means and covariances at the start of each stage and at the end of the last."""
    mean, covariance = last.mean, last.covariance
    found = [(mean, covariance)]
    for stage in reversed(stages):
        size = stage.before.root.shape[1]
        # Columns of the root after those of the state are disturbances: what came of them is in the state after.
        shared = stage.before.root @ stage.moved.slopes[:size]
        ahead = stage.after.covariance
        gain = np.linalg.lstsq(ahead, shared.T, rcond=None)[0].T
        mean = stage.before.mean + gain @ (mean - stage.after.mean)
        covariance = stage.before.covariance + gain @ (covariance - ahead) @ gain.T
        covariance = (covariance + covariance.T) / 2
        found.append((mean, covariance))
    return found[::-1]
