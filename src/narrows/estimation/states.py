"""What is estimated: pose, velocities, and what disturbs them, with units."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

MOTION_STATES = ("x", "y", "psi", "u", "v", "r")
# Units and meanings; those after the motion are left out where nothing lets them differ from what is expected.
STATES = {
    "x": ("m", "midship along the canal"),
    "y": ("m", "midship to starboard of the line"),
    "psi": ("rad", "heading"),
    "u": ("m/s", "surge velocity through the water"),
    "v": ("m/s", "sway velocity through the water"),
    "r": ("rad/s", "yaw rate"),
    "bank": ("1", "strength of the bank over the model's"),
    "current": ("m/s", "current along the canal"),
    "current_across": ("m/s", "current to starboard of the canal"),
    "rudder_bias": ("rad", "rudder angle over the indicated one"),
    "heading_bias": ("rad", "indicated heading over the heading"),
}
# What a state is where it is left out and where nothing is known of it; the others are 0.
RESTING = {"bank": 1.0}


@dataclass(frozen=True)
class StateNames:
    """The states of one estimator, in order."""

    names: tuple[str, ...]  # Some of ``STATES``, those of the motion first

    def __len__(self) -> int:
        """How many."""
        return len(self.names)

    def __contains__(self, name: str) -> bool:
        """Whether a state is estimated."""
        return name in self.names

    @cached_property
    def places(self) -> dict[str, int]:
        """Where each stands."""
        return {name: place for place, name in enumerate(self.names)}

    def vector(self, values: dict[str, float]) -> np.ndarray:
        """Return numbers by name as a vector; what is not said is at rest."""
        return np.array([float(values.get(name, RESTING.get(name, 0.0))) for name in self.names])


class Columns:
    """States at many points, a column each, as sensors ask for them."""

    bank: np.ndarray | float = 1.0
    current: np.ndarray | float = 0.0
    current_across: np.ndarray | float = 0.0
    rudder_bias: np.ndarray | float = 0.0
    heading_bias: np.ndarray | float = 0.0
    x: np.ndarray
    y: np.ndarray
    psi: np.ndarray
    u: np.ndarray
    v: np.ndarray
    r: np.ndarray

    def __init__(self, points: np.ndarray, names: StateNames, curvature: float = 0.0) -> None:
        self.__dict__.update(zip(names.names, points.T, strict=False))
        self.curvature = curvature
