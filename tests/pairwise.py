"""A cover of a matrix by pairs: few cells in which every pair of levels of every two factors occurs."""

from collections.abc import Callable, Hashable, Iterable, Sequence
from itertools import combinations
from typing import TypeVar

Cell = TypeVar("Cell", bound=Sequence[Hashable])


def pairs_of(cell: Sequence[Hashable]) -> set[tuple]:
    """The levels of every two factors of a cell."""
    return set(combinations(enumerate(cell), 2))


def pairwise_cover(cells: Iterable[Cell], pairs: Callable[[Cell], set[tuple]] = pairs_of) -> list[Cell]:
    """Return cells that hold every pair that occurs at all; where several add as many pairs, the first of them.

    Greedy, after Cohen et al. (1997), The AETG system, IEEE Transactions on Software Engineering 23(7).
    """
    known = {cell: pairs(cell) for cell in cells}
    left, cover = set().union(*known.values()), []
    while left:
        best = max(known, key=lambda cell: len(known[cell] & left))
        cover.append(best)
        left -= known[best]
    return cover
