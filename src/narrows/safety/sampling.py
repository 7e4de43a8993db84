"""How far a share of samples can be trusted, and whether more of them would move an edge."""

import numpy as np

# Standard deviations either way, 95 % of a normal distribution.
SURE = 1.959964


def share_interval(share: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the 95 % interval of a share that was counted, low and high [1]."""
    # Wilson (1927), Probable inference, the law of succession, and statistical inference.
    square = SURE**2 / count
    middle = (share + square / 2) / (1 + square)
    half = SURE * np.sqrt(share * (1 - share) / count + square / (4 * count)) / (1 + square)
    return np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)


def is_settled(low: np.ndarray, high: np.ndarray, share: float, clear: np.ndarray) -> bool:
    """Say whether the edge of what is safe is known to a step of the grid."""
    # low, high (offsets, speeds); clear (offsets, speeds)
    sure, perhaps = (low >= share) & clear, (high >= share) & clear
    near = sure.copy()
    near[1:] |= sure[:-1]
    near[:-1] |= sure[1:]
    near[:, 1:] |= sure[:, :-1]
    near[:, :-1] |= sure[:, 1:]
    return not (perhaps & ~near).any()
