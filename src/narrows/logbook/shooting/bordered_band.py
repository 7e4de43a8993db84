"""Normal equations of a chain of windows with a border: solved by Cholesky factors of blocks, the border by Schur.

LAPACK's band solver takes right-hand sides one by one, which for windows as small as these is three times slower.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.codegen.cache import compiled_loops
from narrows.logbook.shooting import window_loops


@dataclass(frozen=True)
class BorderedBand:
    """Normal equations whose windows touch their neighbours and a border."""

    diagonal: np.ndarray  # (windows, m, m) Of each window with itself
    # (windows - 1, m, m) Of each window with the one before; nothing where windows stand alone
    below: np.ndarray | None
    border: np.ndarray  # (windows, m, b) Of each window with the border
    corner: np.ndarray  # (b, b) Of the border with itself
    right: np.ndarray  # (windows, m) Right-hand side of the windows
    right_border: np.ndarray  # (b,) Of the border
    cost: float  # Twice what is minimised, where the search stands [1]

    def eliminated(self) -> "Eliminated":
        """Solve for the windows."""
        count, size, wide = self.border.shape
        linked = self.below is not None
        below = self.below if self.below is not None else np.empty((0, size, size))
        sides = np.concatenate([self.right[:, :, None], self.border], axis=2)
        factor, across = np.empty((2, count, size, size))
        determinant = compiled_loops(window_loops).eliminate(self.diagonal, below, factor, across, sides)
        if not np.isfinite(determinant):
            raise np.linalg.LinAlgError("the equations of the windows are not positive definite")
        flat = sides.reshape(-1, 1 + wide)
        squares = flat.T @ flat
        corner, right = self.corner - squares[1:, 1:], self.right_border - squares[1:, 0]
        halves = HalfSolved(factor, across, linked, sides)
        return Eliminated(halves, (corner + corner.T) / 2, right, self.cost - float(squares[0, 0]), determinant)


@dataclass(frozen=True)
class HalfSolved:
    """Windows on the way to their solution."""

    factor: np.ndarray  # (windows, m, m) Cholesky factors of each window with itself and with the one before
    across: np.ndarray  # (windows, m, m) Cholesky factors of each window with itself and with the one before
    linked: bool  # Whether windows have anything to do with each other
    sides: np.ndarray  # (windows, m, 1 + b) Right-hand sides, half solved: that of the equations, and the border

    @cached_property
    def solved(self) -> np.ndarray:
        """The other half, (windows, m, 1 + b)."""
        sides = self.sides.copy()
        compiled_loops(window_loops).substitute_back(self.factor, self.across, self.linked, sides)
        return sides


@dataclass(frozen=True)
class Eliminated:
    """What is left of the equations without the windows."""

    halves: HalfSolved  # The windows: they are solved for when they are asked for
    corner: np.ndarray  # (b, b) Of the border, the windows at their best
    right: np.ndarray  # (b,) Its right-hand side
    cost: float  # With the windows at their best, the border where it is [1]
    determinant: float  # Logarithm of that of the windows [1]

    @property
    def by_border(self) -> np.ndarray:
        """How the windows go against the border, (windows, m, b)."""
        return np.asarray(self.halves.solved[:, :, 1:])

    def windows(self, border: np.ndarray) -> np.ndarray:
        """Return the step of the windows, (windows, m), for a step of the first of the border."""
        # border (k,)
        return np.asarray(self.halves.solved[:, :, 0] - self.by_border[:, :, : len(border)] @ border)

    def followed(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Return how windows and the first of the border follow the rest of it, (windows, m, b - k) and (k, b - k)."""
        first = -np.linalg.solve(self.corner[:count, :count], self.corner[:count, count:])
        return -(self.by_border[:, :, count:] + self.by_border[:, :, :count] @ first), first

    def without(self, count: int) -> "Eliminated":
        """Solve for the first of the border as well, and return what is left of it."""
        if not count:
            return self
        inner = np.linalg.cholesky(self.corner[:count, :count])
        cross, first = (np.linalg.solve(inner, part) for part in (self.corner[:count, count:], self.right[:count]))
        corner = self.corner[count:, count:] - cross.T @ cross
        right = self.right[count:] - cross.T @ first
        determinant = self.determinant + 2 * float(np.log(np.diag(inner)).sum())
        least = self.cost - float(first @ first)
        return Eliminated(self.halves, corner, right, least, determinant)
