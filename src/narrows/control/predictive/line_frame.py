"""A ship beside its line: derivatives of the rates of y, psi, v, r, rudder, in a bend and a current too."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from narrows.codegen.linearisation import LINEARISED

# The state of a plan; the speed is held through it, and the rudder's rate drives it.
HELD = ("y", "psi", "v", "r", "rudder")
MOVED = [LINEARISED.index(name) for name in HELD[:4]]
PSI, RUDDER = HELD.index("psi"), HELD.index("rudder")
# What forces accelerate.
FORCED = slice(HELD.index("v"), HELD.index("r") + 1)


def line_slopes(linear: np.ndarray, rudder: int, at: Mapping[str, Any], current: float) -> np.ndarray:
    """Return the derivatives of the rates of ``HELD`` by ``HELD``, (points, 5, 5)."""
    # linear (points, 6, columns); at [m]; current [m/s]
    slopes = np.zeros((len(linear), len(HELD), len(HELD)))
    slopes[:, :4] = linear[:, MOVED][:, :, [*MOVED, rudder]]
    curvature, psi = at["curvature"], at["psi"]
    if not np.any(curvature):
        return slopes
    # The line turns under the ship by its curvature times the pace along it.
    room, sine, cosine = 1 - curvature * at["y"], np.sin(psi), np.cos(psi)
    pace = (at["u"] * cosine - at["v"] * sine + current) / room
    slopes[:, PSI, 0] -= curvature**2 * pace / room
    slopes[:, PSI, PSI] += curvature * (at["u"] * sine + at["v"] * cosine) / room
    slopes[:, PSI, 2] += curvature * sine / room
    return slopes


def over_interval(slopes: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return how a state acts over a time, exp(A t), and how constant rates do: (points, 5, 5) each."""
    # slopes (points, 5, 5); time [s]
    # By the series to the fifth power: an interval is short beside what grows in it.
    step, unit = slopes * time, np.eye(slopes.shape[-1])
    square = step @ step
    integral = unit + step / 2 + square / 6 + square @ (step / 24 + square / 120)
    return unit + step @ integral, time * integral
