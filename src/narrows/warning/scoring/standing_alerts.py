"""Since when an alert stands, for any number whose size tells how urgent it is: one rule for all predictors.

Urgency is a number over its threshold. An alert is raised where it was 1 or more for as long as ``BankLevel`` waits,
and lowered where it was below the margin for as long as that waits.
"""

import numpy as np

from narrows.warning.alerts.bank_level import LOWERED_AFTER, MARGIN, RAISED_AFTER

# That an alert stands before a contact [s]; what comes later is missed.
NEEDED = 20.0
# Times [s] that are one.
SAME = 1e-9


def standing_since(t: np.ndarray, urgency: np.ndarray) -> np.ndarray:
    """Return since when an alert stands, (times,...) [s]; infinite where none does."""
    # t (times,) [s]; urgency (times, ...)
    shape = urgency.shape[1:]
    above, below, since = (np.full(shape, np.inf) for _ in range(3))
    told = np.empty(urgency.shape)
    for k, now in enumerate(t):
        known = ~np.isnan(urgency[k])
        high, low = known & (urgency[k] >= 1.0), known & (urgency[k] < MARGIN)
        above = np.where(high, np.minimum(above, now), np.where(known, np.inf, above))
        below = np.where(low, np.minimum(below, now), np.where(known, np.inf, below))
        stands = np.isfinite(since)
        since = np.where(~stands & (now - above >= RAISED_AFTER - SAME), now, since)
        since = np.where(stands & (now - below >= LOWERED_AFTER - SAME), np.inf, since)
        told[k] = since
    return told


def lead_times(t: np.ndarray, since: np.ndarray, struck: np.ndarray) -> np.ndarray:
    """Return how long before a contact the alert that then stands was raised [s]; 0 where none stands."""
    # t (times,) [s]; since (times, n) [s]; struck (n,) [s]
    last = np.maximum(np.searchsorted(t, struck - SAME) - 1, 0)
    stands = since[last, np.arange(len(struck))]
    return np.where(np.isfinite(stands), struck - stands, 0.0)


def highest_held(t: np.ndarray, urgency: np.ndarray, struck: np.ndarray) -> np.ndarray:
    """Return the highest urgency that would raise an alert, (n,): it held for as long as one waits."""
    # t (times,) [s]; urgency (times, n); struck (n,) [s]
    rows = 1 + int(np.ceil((RAISED_AFTER - SAME) / (t[1] - t[0])))
    live = np.where((t[:, None] < struck), np.nan_to_num(urgency), 0.0)
    held = np.lib.stride_tricks.sliding_window_view(live, rows, axis=0).min(axis=-1)
    return np.asarray(held.max(axis=0))
