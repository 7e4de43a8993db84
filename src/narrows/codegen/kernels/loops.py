"""Loops over points: derivatives of a motion, and Newton's method for steady courses. One compiled copy serves all."""

from typing import Any

import numpy as np

from narrows.codegen.addresses import call_into

Array = Any

ROUNDS = 40
DONE = 1e-11
FURTHEST = 1.2  # largest drift over speed, or rudder angle [rad], of the search
LARGEST = 0.25  # largest step of the search


def at_points(linear: Any, values: Array, constants: Array, out: Array) -> None:
    """Write what ``linear(values, constants)``, by its address, returns at each row of values into that of ``out``."""
    for row in range(len(values)):
        call_into(linear, out[row], (values[row], constants))


def solve(balance: Any, inputs: Array, drifts: Array, angles: Array) -> None:
    """Find drift over speed and rudder angle [rad] for every row of ``inputs``, NaN if no course is steady.

    The search starts straight ahead with the rudder amidships. ``balance(drift, angle, inputs)``, by its address,
    gives the accelerations in sway and yaw and their derivatives by relative drift and rudder angle.
    """
    found = np.empty(6)
    for row in range(len(inputs)):
        drift, angle, converged = 0.0, 0.0, False
        for _ in range(ROUNDS):
            call_into(balance, found, (drift, angle, inputs[row]))
            a, b, a_drift, a_angle, b_drift, b_angle = found
            determinant = a_drift * b_angle - a_angle * b_drift
            step = (a_angle * b - b_angle * a) / determinant
            turn = (b_drift * a - a_drift * b) / determinant
            drift += min(max(step, -LARGEST), LARGEST)
            angle += min(max(turn, -LARGEST), LARGEST)
            if not (abs(drift) < FURTHEST and abs(angle) < FURTHEST):
                break
            if abs(step) < DONE and abs(turn) < DONE:
                converged = True
                break
        drifts[row] = drift if converged else np.nan
        angles[row] = angle if converged else np.nan
