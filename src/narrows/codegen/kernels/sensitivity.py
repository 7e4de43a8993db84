"""A voyage and its derivatives: segments, each from its own start, integrated from sample to sample.

One compiled copy serves all models: they pass their step by address.
"""

from typing import Any, NamedTuple

import numpy as np

from narrows.codegen.addresses import call
from narrows.codegen.choices import DIRECTIONS

Array = np.ndarray[Any, Any]


class TangentProgram(NamedTuple):
    """A step with derivatives along every direction of a block, in place, and its sizes."""

    step: int  # Its address
    kept: int  # Numbers carried from step to step
    moving: int  # Inputs with derivatives
    length: int  # Place of the length of a step among the inputs


def integrate(
    sizes: Array,
    start: Array, start_slopes: Array, first: Array, inputs: Array, input_slopes: Array,
    places: Array, orders: Array, lengths: Array, parts: int, table: Array, states: Array, slopes: Array,
) -> None:  # fmt: skip
    """Integrate every segment from its start; write states and derivatives at each sample and at segment ends.

    ``start`` (segments, kept); ``start_slopes`` (segments, kept, directions); ``first`` (segments + 1,) the first step
    of each; ``inputs`` (inputs,) with ``input_slopes`` (moving, directions); ``orders`` (steps, places), the values of
    the inputs ``places`` in each step; ``lengths`` (steps,) [s], each step in so many equal ``parts``; ``states``
    (steps + segments, kept) and ``slopes`` (steps + segments, kept, directions), the samples of each segment with its
    end, one segment after the other.
    """
    program = TangentProgram(sizes[0], sizes[1], sizes[2], sizes[3])
    directions = start_slopes.shape[2]
    block, z, now = np.zeros((program.kept + program.moving) * DIRECTIONS), np.empty(program.kept), inputs.copy()
    for begun in range(0, directions, DIRECTIONS):
        count = min(DIRECTIONS, directions - begun)
        block[:] = 0.0
        for i in range(program.moving):
            for lane in range(count):
                block[(program.kept + i) * DIRECTIONS + lane] = input_slopes[i, begun + lane]
        row = 0
        for segment in range(start.shape[0]):
            for i in range(program.kept):
                z[i] = start[segment, i]
                for lane in range(count):
                    block[i * DIRECTIONS + lane] = start_slopes[segment, i, begun + lane]
            for taken in range(first[segment], first[segment + 1] + 1):
                for i in range(program.kept):
                    states[row, i] = z[i]
                    for lane in range(count):
                        slopes[row, i, begun + lane] = block[i * DIRECTIONS + lane]
                row += 1
                if taken == first[segment + 1]:
                    break
                for i in range(places.shape[0]):
                    now[places[i]] = orders[taken, i]
                now[program.length] = lengths[taken] / parts
                for _ in range(parts):
                    call(program.step, (z, block, now, table))
