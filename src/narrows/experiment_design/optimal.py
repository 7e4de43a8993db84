"""The best few of many runs for some coefficients, whatever the form of the bank: greedy choice, then exchanges."""

from collections.abc import Sequence

import numpy as np

CRITERIA = ("c", "d")
ROUNDS = 20
# Over the largest information of each parameter: stands for what is known of it before any test, next to nothing.
RIDGE = 1e-9
# Share of the spread within which runs are as good as one another: while a parameter is unknown, rounding over the
# ridge moves the spread by about 1e-5 of it.
TIE = 1e-4


def spread(information: np.ndarray, targets: Sequence[int], criterion: str) -> np.ndarray:
    """Return what is to be made small, for each of a stack of information matrices, under the worst form."""
    # information (..., forms, p, p)
    covariance = np.linalg.inv(information)[..., np.array(targets)[:, None], np.array(targets)]
    if criterion == "c":
        return np.asarray(np.trace(covariance, axis1=-2, axis2=-1).max(axis=-1))
    return np.asarray(np.linalg.slogdet(covariance)[1].max(axis=-1))


def choose(runs: np.ndarray, known: np.ndarray, count: int, targets: Sequence[int], criterion: str = "c") -> list[int]:
    """Choose runs, each at most once: the order is that of their use."""
    # runs (n, forms, p, p); known (forms, p, p)
    # Fedorov (1972), Theory of optimal experiments: the exchange.
    scale = np.sqrt(np.diagonal(runs, axis1=2, axis2=3).max(axis=0))
    scale[scale == 0] = 1.0
    outer = scale[:, :, None] * scale[:, None, :]
    runs, known = runs / outer, known / outer
    base = known + RIDGE * np.eye(known.shape[-1])
    chosen: list[int] = []
    for _ in range(min(count, len(runs))):
        chosen.append(_best(runs, base + runs[chosen].sum(axis=0), chosen, targets, criterion))
    for _ in range(ROUNDS):
        before = list(chosen)
        for i in range(len(chosen)):
            rest = chosen[:i] + chosen[i + 1 :]
            best = _best(runs, base + runs[rest].sum(axis=0), rest, targets, criterion)
            chosen = [*chosen[:i], best, *chosen[i + 1 :]]
        if chosen == before:
            break
    return _in_order(runs, base, chosen, targets, criterion)


def _best(runs: np.ndarray, so_far: np.ndarray, taken: list[int], targets: Sequence[int], criterion: str) -> int:
    rest = np.setdiff1d(np.arange(len(runs)), taken)
    return int(rest[_least(so_far + runs[rest], targets, criterion)])


def _least(information: np.ndarray, targets: Sequence[int], criterion: str) -> int:
    """The least spread; among those that differ by rounding the least determinant, and then the first."""
    worth = spread(information, targets, criterion)
    tied = np.flatnonzero(worth <= worth.min() + TIE * (worth.min() if criterion == "c" else 1.0))
    volume = spread(information[tied], targets, "d")
    return int(tied[np.flatnonzero(volume <= volume.min() + TIE)[0]])


def _in_order(
    runs: np.ndarray, base: np.ndarray, chosen: list[int], targets: Sequence[int], criterion: str
) -> list[int]:
    """Put first what helps most by itself."""
    left = list(chosen)
    order: list[int] = []
    while left:
        so_far = base + runs[order].sum(axis=0)
        order.append(left.pop(_least(so_far + runs[left], targets, criterion)))
    return order
