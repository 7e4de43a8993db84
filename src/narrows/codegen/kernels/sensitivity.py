"""A voyage and its derivatives: segments, each from its own start, integrated from sample to sample.

This text is appended to every generated tangent module, below ``step`` of that model.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeVar

    Function = TypeVar("Function", bound=Callable[..., Any])
    Array = np.ndarray[Any, Any]
    KEPT = MOVING = DIRECTIONS = LENGTH = 0

    def cached(function: Function) -> Function:
        """Compile once for all processes."""

    def step(z: Array, block: Array, inputs: Array, table: Array) -> None:
        """Take a step in place, with its derivatives along every direction of the block."""
elif __name__ == "narrows.codegen.kernels.sensitivity":  # Imported alone, by tools that import all modules
    cached = staticmethod


@cached
def integrate(
    start: "Array", start_slopes: "Array", first: "Array", inputs: "Array", input_slopes: "Array",
    places: "Array", orders: "Array", lengths: "Array", parts: int, table: "Array", states: "Array", slopes: "Array",
) -> None:  # fmt: skip
    """Integrate every segment from its start; write states and derivatives at each sample and at segment ends.

    ``start`` (segments, kept); ``start_slopes`` (segments, kept, directions); ``first`` (segments + 1,) the first step
    of each; ``inputs`` (inputs,) with ``input_slopes`` (moving, directions); ``orders`` (steps, places), the values of
    the inputs ``places`` in each step; ``lengths`` (steps,) [s], each step in so many equal ``parts``; ``states``
    (steps + segments, kept) and ``slopes`` (steps + segments, kept, directions), the samples of each segment with its
    end, one segment after the other.
    """
    directions = start_slopes.shape[2]
    block, z, now = np.zeros((KEPT + MOVING) * DIRECTIONS), np.empty(KEPT), inputs.copy()
    for begun in range(0, directions, DIRECTIONS):
        count = min(DIRECTIONS, directions - begun)
        block[:] = 0.0
        for i in range(MOVING):
            for lane in range(count):
                block[(KEPT + i) * DIRECTIONS + lane] = input_slopes[i, begun + lane]
        row = 0
        for segment in range(start.shape[0]):
            for i in range(KEPT):
                z[i] = start[segment, i]
                for lane in range(count):
                    block[i * DIRECTIONS + lane] = start_slopes[segment, i, begun + lane]
            for taken in range(first[segment], first[segment + 1] + 1):
                for i in range(KEPT):
                    states[row, i] = z[i]
                    for lane in range(count):
                        slopes[row, i, begun + lane] = block[i * DIRECTIONS + lane]
                row += 1
                if taken == first[segment + 1]:
                    break
                for i in range(places.shape[0]):
                    now[places[i]] = orders[taken, i]
                now[LENGTH] = lengths[taken] / parts
                for _ in range(parts):
                    step(z, block, now, table)
