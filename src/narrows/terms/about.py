"""What is known of a term beside its regressor: what it describes, how it changes with depth, what does not scale."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from narrows.physics import shallow
from narrows.quantities.names import Number


class TermKind(StrEnum):
    """What a term describes."""

    INERTIA = "inertia"
    RESISTANCE = "resistance"
    DAMPING = "damping"
    LIFT = "lift"
    CROSSFLOW = "crossflow"
    HULL = "hull polynomial"
    BANK = "bank"
    RUDDER = "rudder"
    PROPELLER = "propeller"
    THRUSTER = "thruster"
    OTHER = "other"


class ScaleEffect(StrEnum):
    """What of a coefficient does not follow Froude's law."""

    FRICTION = "friction"
    CROSSFLOW_DRAG = "drag of crossflow"
    TEST_SPEED = "speed of the tests"
    WAKE = "wake at the propeller"
    BANK_SHAPE = "shape of the banks"


@dataclass(frozen=True)
class DepthLaw:
    """How a coefficient grows over deep water."""

    factor: Callable[..., Number]  # Of names of the ship's particulars and ``depth``; 1 in deep water
    verified: bool = True  # Whether it was read in its source


DRIFT_FORCE = DepthLaw(shallow.kijima_drift_force)
DRIFT_MOMENT = DepthLaw(shallow.kijima_drift_moment, verified=False)
YAW_MOMENT = DepthLaw(shallow.kijima_yaw_moment)
