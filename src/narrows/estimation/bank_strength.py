"""Inputs of lanes by the strength of the bank: a straight line, where the bank's terms hold no accelerations."""

from collections.abc import Callable

import numpy as np

from narrows.errors import InputError

AFFINE = 1e-9


def by_bank(inputs: Callable[[float], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the inputs without a bank, and what a bank of strength 1 adds (ours).

    Parameters
    ----------
    inputs : callable
        From a strength to the inputs of lanes.

    Raises
    ------
    InputError
        Where the model's terms make the bank's strength more than a factor.
    """
    none, full, double = (inputs(strength) for strength in (0.0, 1.0, 2.0))
    if not (np.abs(double - 2 * full + none) <= AFFINE * (np.abs(full) + np.abs(none))).all():
        raise InputError("the bank's terms of this model hold accelerations, so its strength cannot be estimated")
    return none, full - none
