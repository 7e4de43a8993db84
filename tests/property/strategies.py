"""What Hypothesis draws from."""

import math

from hypothesis import strategies as st


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_infinity=False)


HEADINGS = numbers(-1.5, 1.5)
"""Short of 90 degrees either way [rad]."""

STATES = st.fixed_dictionaries(
    {
        "y": numbers(-2.5, 2.5),
        "psi": HEADINGS,
        "u": numbers(-2.0, 2.0),
        "v": numbers(-0.5, 0.5),
        "r": numbers(-0.2, 0.2),
        "udot": numbers(-0.1, 0.1),
        "vdot": numbers(-0.1, 0.1),
        "rdot": numbers(-0.05, 0.05),
        "heave": numbers(-0.01, 0.03),
    }
)
"""Motions in the paper's tank, as arguments of ``Motion.at``."""

RIGHT_ANGLE = math.pi / 2
