"""Loops that one compiled copy serves for all models, which pass their functions by address.

Derivatives of a motion at points; Newton's method for steady courses; a voyage and its derivatives.
"""

from typing import Any

import numpy as np

from narrows.codegen.addresses import call
from narrows.codegen.free_motion import DIRECTIONS

Array = Any

ROUNDS = 40
DONE = 1e-11
FURTHEST = 1.2  # largest drift over speed, or rudder angle [rad], of the search
LARGEST = 0.25  # largest step of the search


def at_points(linear: Any, values: Array, constants: Array, out: Array) -> None:
    """Write what ``linear(values, constants)``, by its address, returns at each row of values into that of ``out``."""
    for row in range(len(values)):
        call(linear, (values[row], constants, out[row]))


def solve(balance: Any, inputs: Array, drifts: Array, angles: Array) -> None:
    """Find drift over speed and rudder angle [rad] for every row of ``inputs``, NaN if no course is steady.

    The search starts straight ahead with the rudder amidships. ``balance(drift, angle, inputs)``, by its address,
    gives the accelerations in sway and yaw and their derivatives by relative drift and rudder angle.
    """
    found = np.empty(6)
    for row in range(len(inputs)):
        drift, angle, converged = 0.0, 0.0, False
        for _ in range(ROUNDS):
            call(balance, (drift, angle, inputs[row], found))
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


def integrate(
    sizes: Array,
    start: Array, start_slopes: Array, first: Array, inputs: Array, input_slopes: Array,
    places: Array, orders: Array, lengths: Array, table: Array, states: Array, slopes: Array,
) -> None:  # fmt: skip
    """Integrate every segment; write states and derivatives at each sample and at segment ends."""
    # sizes: address of a step with derivatives along every direction of a block, in place; numbers carried from step to
    # step; inputs with derivatives; place of the length of a step among the inputs.
    # start (segments, kept), start_slopes (segments, kept, directions); first (segments + 1,) the first step of each;
    # inputs (inputs,), input_slopes (moving, directions); orders (steps, places), the inputs ``places`` in each step;
    # lengths (steps,) [s]; states (steps + segments, kept) and slopes (steps + segments, kept, directions), the samples
    # of each segment with its end, one segment after the other.
    step, kept, moving, length = sizes[0], sizes[1], sizes[2], sizes[3]
    directions = start_slopes.shape[2]
    block, z, now = np.zeros((kept + moving) * DIRECTIONS), np.empty(kept), inputs.copy()
    for begun in range(0, directions, DIRECTIONS):
        count = min(DIRECTIONS, directions - begun)
        block[:] = 0.0
        for i in range(moving):
            for lane in range(count):
                block[(kept + i) * DIRECTIONS + lane] = input_slopes[i, begun + lane]
        row = 0
        for segment in range(start.shape[0]):
            for i in range(kept):
                z[i] = start[segment, i]
                for lane in range(count):
                    block[i * DIRECTIONS + lane] = start_slopes[segment, i, begun + lane]
            for taken in range(first[segment], first[segment + 1] + 1):
                for i in range(kept):
                    states[row, i] = z[i]
                    for lane in range(count):
                        slopes[row, i, begun + lane] = block[i * DIRECTIONS + lane]
                row += 1
                if taken == first[segment + 1]:
                    break
                for i in range(places.shape[0]):
                    now[places[i]] = orders[taken, i]
                now[length] = lengths[taken]
                call(step, (z, block, now, table))
