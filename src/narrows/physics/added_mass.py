"""Added mass and inertia of a hull in deep water, by regression over ships."""

import math


def clarke_sway(length: float, beam: float, draft: float, block_coefficient: float, density: float) -> float:
    """Added mass in sway in deep water [kg]. Source: Clarke, Gedling and Hine (1983)."""
    slender = 1 + 0.16 * block_coefficient * beam / draft - 5.1 * (beam / length) ** 2
    return math.pi * (draft / length) ** 2 * slender * density * length**3 / 2


def clarke_yaw(length: float, beam: float, draft: float, block_coefficient: float, density: float) -> float:
    """Added moment of inertia in yaw about midship in deep water [kg m2]. Source: Clarke, Gedling and Hine (1983)."""
    slender = 1 / 12 + 0.017 * block_coefficient * beam / draft - 0.33 * beam / length
    return math.pi * (draft / length) ** 2 * slender * density * length**5 / 2
