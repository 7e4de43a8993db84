"""A heading from its cosine and sine, whole turns counted."""

import numpy as np

from narrows.quantities.names import Number


def counted_heading(cosine: Number, sine: Number, near: Number) -> np.ndarray:
    """Return the angle of a cosine and a sine that is nearest to another [rad] (ours).

    Parameters
    ----------
    cosine, sine : number or array [1]
        Of the heading.
    near : number or array [rad]
        The heading that was counted through the voyage, or the one at the start of a voyage that cannot turn round.
    """
    angle = np.arctan2(sine, cosine)
    return np.asarray(angle + 2 * np.pi * np.round((near - angle) / (2 * np.pi)))
