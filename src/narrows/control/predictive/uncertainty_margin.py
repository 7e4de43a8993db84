"""How far a hull may stray from its plan because the coefficients are not known: the margin of its clearance."""

from statistics import NormalDist

import numpy as np

from narrows.control.predictive.line_frame import FORCED, RUDDER
from narrows.model.model import Model


def margins_of(
    model: Model, motion: tuple[np.ndarray, np.ndarray], slopes_by_coefficient: np.ndarray, gains: np.ndarray,
    margin: float, confidence: float,
) -> np.ndarray:  # fmt: skip
    """Return margins after each interval of a plan."""
    # motion (5, 5); slopes_by_coefficient (intervals + 1, 6, coefficients); gains (5,); margin [m]
    # While the ship comes back from half a beam off, under the best linear helm: what its forces are there is
    # uncertain, less what the push that is estimated tells of them at the start.
    (A, integral), count = motion, len(slopes_by_coefficient) - 1
    if model.covariance is None:
        return np.full(count, margin)
    closed = A - np.outer(integral[:, RUDDER], gains)
    sway_and_yaw = slopes_by_coefficient[:, 4:]
    astray = np.zeros((len(A), sway_and_yaw.shape[-1]))
    spread = np.zeros(count)
    lever = model.configuration.ship.length / 2
    ends = np.array([[1.0, lever, 0, 0, 0], [1.0, -lever, 0, 0, 0]])
    for k in range(count):
        astray = closed @ astray + integral[:, FORCED] @ (sway_and_yaw[k] - sway_and_yaw[0])
        corners = ends @ astray
        spread[k] = np.sqrt(np.maximum(np.einsum("ip,pq,iq->i", corners, model.covariance, corners), 0.0)).max()
    return margin + NormalDist().inv_cdf(confidence) * spread
