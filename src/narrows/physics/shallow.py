"""Factors of hydrodynamic derivatives in shallow water."""

from narrows.quantities.names import Number


def _factor(share: Number, power: Number) -> Number:
    """1/(1 - T/h)^n - T/h, for the share T/h; 1 in deep water."""
    return 1 / (1 - share) ** power - share


def kijima_drift_force(beam: Number, draft: Number, block_coefficient: Number, depth: Number) -> Number:
    """Factor on the sway force of drift [1]. Source: Kijima et al. (1990)."""
    return _factor(draft / depth, 0.40 * block_coefficient * beam / draft)


def kijima_drift_moment(beam: Number, draft: Number, block_coefficient: Number, depth: Number) -> Number:
    """Factor on the yaw moment of drift [1]. Source: form of Kijima et al. (1990)."""
    # The exponent is not verified against the text.
    return _factor(draft / depth, 0.425 * block_coefficient * beam / draft)


def kijima_yaw_moment(length: Number, draft: Number, depth: Number) -> Number:
    """Factor on the yaw moment of turning [1].

    Source: Kijima et al. (1990), as printed: the exponent falls as the draft grows.
    """
    return _factor(draft / depth, 1.5 - 14.28 * draft / length)
