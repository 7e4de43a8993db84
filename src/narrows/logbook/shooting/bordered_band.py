"""Normal equations of a chain of windows with a border: solved by a band's Cholesky factor, the border by Schur."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded


@dataclass(frozen=True)
class BorderedBand:
    """Normal equations whose windows touch their neighbours and a border.

    Parameters
    ----------
    diagonal : array (windows, m, m)
        Of each window with itself.
    below : array (windows - 1, m, m), optional
        Of each window with the one before; nothing where windows stand alone.
    border : array (windows, m, b)
        Of each window with the border.
    corner : array (b, b)
        Of the border with itself.
    right : array (windows, m)
        Right-hand side of the windows.
    right_border : array (b,)
        Of the border.
    cost : float [1]
        Twice what is minimised, where the search stands.
    """

    diagonal: np.ndarray
    below: np.ndarray | None
    border: np.ndarray
    corner: np.ndarray
    right: np.ndarray
    right_border: np.ndarray
    cost: float

    def eliminated(self) -> "Eliminated":
        """Solve for the windows.

        Raises
        ------
        LinAlgError
            Where the matrix is not positive definite.
        """
        count, size, _ = self.diagonal.shape
        whole = count * size
        root = np.sqrt(np.einsum("kii->ki", self.diagonal)).ravel()
        factor = cholesky_banded(_band(self.diagonal, self.below, 1 / root), lower=True, check_finite=False)
        sides = np.concatenate([self.right.reshape(whole, 1), self.border.reshape(whole, -1)], axis=1)
        solved = cho_solve_banded((factor, True), sides / root[:, None], check_finite=False) / root[:, None]
        alone, by_border = solved[:, 0], solved[:, 1:]
        border = self.border.reshape(whole, -1)
        corner = self.corner - border.T @ by_border
        right = self.right_border - border.T @ alone
        determinant = 2 * float(np.sum(np.log(factor[0])) + np.sum(np.log(root)))
        least = self.cost - float(self.right.ravel() @ alone)
        return Eliminated(alone, by_border, (corner + corner.T) / 2, right, least, determinant, size)


@dataclass(frozen=True)
class Eliminated:
    """What is left of the equations without the windows.

    Parameters
    ----------
    alone : array (windows m,)
        The windows where the border stays.
    by_border : array (windows m, b)
        How they go against the border.
    corner : array (b, b)
        Of the border, the windows at their best.
    right : array (b,)
        Its right-hand side.
    cost : float [1]
        With the windows at their best, the border where it is.
    determinant : float [1]
        Logarithm of that of the windows.
    size : int
        Unknowns of a window.
    """

    alone: np.ndarray
    by_border: np.ndarray
    corner: np.ndarray
    right: np.ndarray
    cost: float
    determinant: float
    size: int

    def windows(self, border: np.ndarray) -> np.ndarray:
        """Return the step of the windows, (windows, m), for a step of the first of the border.

        Parameters
        ----------
        border : array (k,)
            Step of its first k; the others stay.
        """
        step: np.ndarray = self.alone - self.by_border[:, : len(border)] @ border
        return step.reshape(-1, self.size)

    def followed(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Return how the windows and the first of the border follow the rest of it, (windows, m, b - k) and (k, b - k).

        Parameters
        ----------
        count : int
            How many of the border, k, are at their best as well.
        """
        first = -np.linalg.solve(self.corner[:count, :count], self.corner[:count, count:])
        windows = -(self.by_border[:, count:] + self.by_border[:, :count] @ first)
        return windows.reshape(-1, self.size, windows.shape[1]), first

    def without(self, count: int) -> "Eliminated":
        """Solve for the first of the border as well, and return what is left of it.

        Parameters
        ----------
        count : int
            How many.
        """
        if not count:
            return self
        inner = np.linalg.cholesky(self.corner[:count, :count])
        cross, first = (np.linalg.solve(inner, part) for part in (self.corner[:count, count:], self.right[:count]))
        corner = self.corner[count:, count:] - cross.T @ cross
        right = self.right[count:] - cross.T @ first
        determinant = self.determinant + 2 * float(np.log(np.diag(inner)).sum())
        least = self.cost - float(first @ first)
        return Eliminated(self.alone, self.by_border, corner, right, least, determinant, self.size)


def _band(diagonal: np.ndarray, below: np.ndarray | None, scale: np.ndarray) -> np.ndarray:
    """The lower band of the scaled matrix, as LAPACK has it."""
    count, size, _ = diagonal.shape
    whole = count * size
    band = np.zeros((size if below is None else 2 * size, whole))
    for i in range(size):
        for j in range(i + 1):
            band[i - j, j::size] = diagonal[:, i, j]
    if below is not None:
        for i in range(size):
            for j in range(size):
                band[size + i - j, j : whole - size : size] = below[:, i, j]
    for offset in range(min(len(band), whole)):
        band[offset, : whole - offset] *= scale[: whole - offset] * scale[offset:]
    return band
