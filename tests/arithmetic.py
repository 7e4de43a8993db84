"""Whether a function is arithmetic: the same on floats, columns and numbers of 30 digits."""

from collections.abc import Callable

import mpmath
import numpy as np
import pytest

import narrows as nw
from limits import within
from narrows.quantities.arithmetic import COLUMNS
from narrows.quantities.names import argument_names, name_of

DEPTH = 0.4
"""Of the water in which regressors are evaluated [m]."""
DIGITS, SECONDS = 30, 20
SMALLEST = 1e-150
"""Of results that are compared: squares of smaller numbers vanish in floats."""
EXACT = {"angle": lambda cosine, sine: mpmath.atan2(sine, cosine), "sine": mpmath.sin, "cosine": mpmath.cos}


def values_at(model: nw.Model, state: dict[str, float]) -> dict[str, float]:
    """Everything that a regressor may ask for, in a motion."""
    return model.configuration.values() | nw.Motion.at(**state).values() | {"depth": DEPTH}


def check_arithmetic(function: Callable[..., float], known: dict[str, float]) -> None:
    """Hold a function on columns and on numbers of 30 digits to what it gives for floats."""
    values = {name: known[name] for name in argument_names(function)}
    expected = function(*values.values())
    columns = {name: np.full(3, value) for name, value in values.items()}
    np.testing.assert_allclose(np.broadcast_to(function(*columns.values()), 3), expected, rtol=1e-15, atol=0)
    with within(SECONDS, name_of(function)), mpmath.workdps(DIGITS), pytest.MonkeyPatch.context() as patch:
        for name, exact in EXACT.items():
            patch.setitem(COLUMNS, name, exact)
        precise = function(*(mpmath.mpf(value) for value in values.values()))
    assert expected == pytest.approx(float(precise), rel=1e-12, abs=SMALLEST), "floats lose digits to cancellation"
