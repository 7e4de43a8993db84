"""A heading from its cosine and sine, whole turns counted."""

import numpy as np

from narrows.quantities.names import Number


def counted_heading(cosine: Number, sine: Number, near: Number) -> np.ndarray:
    """Return the angle of a cosine and a sine that is nearest to another [rad]."""
    # near [rad]
    angle = np.arctan2(sine, cosine)
    return np.asarray(angle + 2 * np.pi * np.round((near - angle) / (2 * np.pi)))
