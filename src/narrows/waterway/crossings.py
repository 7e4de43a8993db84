"""Polylines that cross themselves, as hand-drawn and digitised ones do."""

import numpy as np


def with_crossings(points: np.ndarray) -> np.ndarray:
    """Return the points of a polyline with those between where it crosses itself."""
    # points (n, 2) [m]
    one, other = _beside(points)
    start, way = points[:-1], np.diff(points, axis=0)
    across = _cross(way[one], way[other])
    one, other, across = one[across != 0], other[across != 0], across[across != 0]
    apart = start[other] - start[one]
    share, share_other = _cross(apart, way[other]) / across, _cross(apart, way[one]) / across
    inside = (share > 0) & (share < 1) & (share_other > 0) & (share_other < 1) & (np.abs(one - other) > 1)
    piece, share = np.concatenate([one[inside], other[inside]]), np.concatenate([share[inside], share_other[inside]])
    order = np.lexsort((share, piece))
    piece, share = piece[order], share[order]
    return np.insert(points, piece + 1, start[piece] + share[:, None] * way[piece], axis=0)


def _beside(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of pieces that overlap along the longer way of the whole."""
    column = points[:, int(np.ptp(points, axis=0).argmax())]
    low, high = np.minimum(column[1:], column[:-1]), np.maximum(column[1:], column[:-1])
    order = np.argsort(low)
    low, high, pairs = low[order], high[order], [np.empty((2, 0), int)]
    for offset in range(1, len(order)):
        near = np.flatnonzero(low[offset:] <= high[:-offset])
        if not near.size:
            break
        pairs.append(order[np.stack([near, near + offset])])
    one, other = np.concatenate(pairs, axis=1)
    return one, other


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
