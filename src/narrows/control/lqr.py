"""The linear-quadratic regulator for the user's own weights."""

from typing import Any

import numpy as np
from scipy.linalg import LinAlgError, solve_continuous_are

from narrows.control.linear_system import LinearSystem
from narrows.errors import InputError


def lqr(linear: LinearSystem, Q: Any, R: Any, *controls: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the gains that minimise the integral of x'Qx + u'Ru, as python-control's ``lqr`` does.

    This is the textbook regulator; ``regulator`` makes a whole helm with gear, integral and tuned weights.

    Parameters
    ----------
    linear : LinearSystem
        Linear system about one course.
    Q : array (states, states)
        Weights of the states, in the order of ``linear.states``.
    R : array (controls, controls)
        Weights of the controls, in their order.
    *controls : str
        Controls to use, such as ``"rudder"``; those of ``linear.controls`` unless given.

    Returns
    -------
    tuple of arrays
        Gains K (controls, states) of u = -K x, the solution of the Riccati equation (states, states), and the poles of
        the closed loop [1/s].

    Raises
    ------
    InputError
        If a matrix has the wrong shape, or no gains stabilise the ship.

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods.
    """
    A, B, used = *linear.matrices(*controls), controls or linear.controls
    weights = np.asarray(Q, float), np.atleast_2d(np.asarray(R, float))
    for name, matrix, names in zip("QR", weights, (linear.states, used), strict=True):
        if matrix.shape != (len(names), len(names)):
            raise InputError(f"{name} has the shape {matrix.shape}; give a row and a column for {', '.join(names)}")
    try:
        riccati = solve_continuous_are(A, B, *weights)
    except (LinAlgError, ValueError):
        raise InputError("no gains hold this ship with these weights; give R over 0, and Q over 0 for y") from None
    gains = np.linalg.solve(weights[1], B.T @ riccati)
    return gains, riccati, np.linalg.eigvals(A - B @ gains)
