"""What the data behind a model covered, and the one rule of what lies outside of it."""

from dataclasses import dataclass

import numpy as np

from narrows.quantities.names import Number

Range = tuple[float, float]
SLACK = 0.01
"""Of the larger end of a range, by which a value may leave it and still count as covered: a depth or a speed is no
better known."""


@dataclass(frozen=True)
class DataRange:
    """The ranges that the data covered; None where they did not say.

    Parameters
    ----------
    speed : pair of float [m/s]
        Surge velocity.
    abs_y : pair of float [m]
        Distance off the centreline.
    abs_psi : pair of float [rad]
        Size of the heading.
    abs_r : pair of float [rad/s]
        Size of the yaw rate.
    depth_to_draft : pair of float [1]
        h/T.
    width_to_beam : pair of float [1]
        W/B.
    """

    speed: Range | None = None
    abs_y: Range | None = None
    abs_psi: Range | None = None
    abs_r: Range | None = None
    depth_to_draft: Range | None = None
    width_to_beam: Range | None = None

    def outside(self, name: str, values: Number) -> Number:
        """Return whether values lie outside of what the data covered, for each; False where that is not known.

        Parameters
        ----------
        name : str
            ``speed``, ``abs_y``, ``abs_psi``, ``abs_r``, ``depth_to_draft`` or ``width_to_beam``.
        values : number
            In its unit.
        """
        low, high = getattr(self, name) or (-np.inf, np.inf)
        slack = SLACK * max(abs(low), abs(high))
        return np.logical_or(values < low - slack, values > high + slack)
