"""Edges of what is safe on a grid of offsets and speeds."""

import numpy as np


def first_run(safe: np.ndarray) -> tuple[int, int] | None:
    """Return the first and the last place of the first run of true; None where nothing is."""
    # safe (n,)
    if not safe.any():
        return None
    first = int(safe.argmax())
    after = np.flatnonzero(~safe[first:])
    return first, first + int(after[0]) - 1 if after.size else len(safe) - 1


def largest_rectangle(safe: np.ndarray, y: np.ndarray, u: np.ndarray) -> tuple[slice, slice] | None:
    """Return the block of offsets and speeds of the largest area in which everything is safe; None where nothing is."""
    # safe (offsets, speeds)
    wide, high = (np.gradient(values) if len(values) > 1 else np.ones(1) for values in (y, u))
    area, block = 0.0, None
    for first in range(len(y)):
        held = np.ones(len(u), bool)
        for last in range(first, len(y)):
            held &= safe[last]
            for low, up in _runs(held):
                covered = float(wide[first : last + 1].sum() * high[low : up + 1].sum())
                if covered > area:
                    area, block = covered, (slice(first, last + 1), slice(low, up + 1))
    return block


def _runs(held: np.ndarray) -> list[tuple[int, int]]:
    ends = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in zip(ends[::2], ends[1::2], strict=True)]


def crossing(y: np.ndarray, share: np.ndarray, inside: int, outside: int, least: float) -> float:
    """Return the offset between two places where a share falls to its least, straight between them."""
    # y (n,) [m]; share (n,)
    if share[outside] >= least:
        return float(y[inside])
    part = (share[inside] - least) / (share[inside] - share[outside])
    return float(y[inside] + part * (y[outside] - y[inside]))
