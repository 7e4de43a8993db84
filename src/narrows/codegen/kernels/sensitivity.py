"""A voyage and its derivatives: segments, each from its own start, integrated from sample to sample.

One compiled copy serves all models: they pass their step by address.
"""

from typing import Any

import numpy as np

from narrows.codegen.addresses import call
from narrows.codegen.choices import DIRECTIONS

Array = np.ndarray[Any, Any]


def integrate(
    sizes: Array,
    start: Array, start_slopes: Array, first: Array, inputs: Array, input_slopes: Array,
    places: Array, orders: Array, lengths: Array, parts: int, table: Array, states: Array, slopes: Array,
) -> None:  # fmt: skip
    """Integrate every segment; write states and derivatives at each sample and at segment ends."""
    # sizes: address of a step with derivatives along every direction of a block, in place; numbers carried from step to
    # step; inputs with derivatives; place of the length of a step among the inputs.
    # start (segments, kept), start_slopes (segments, kept, directions); first (segments + 1,) the first step of each;
    # inputs (inputs,), input_slopes (moving, directions); orders (steps, places), the inputs ``places`` in each step;
    # lengths (steps,) [s], each step in so many equal ``parts``; states (steps + segments, kept) and slopes
    # (steps + segments, kept, directions), the samples of each segment with its end, one segment after the other.
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
                now[length] = lengths[taken] / parts
                for _ in range(parts):
                    call(step, (z, block, now, table))
