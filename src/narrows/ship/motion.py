"""The motion of a ship, as floats, columns or symbols."""

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from narrows.quantities.names import Number


@dataclass(frozen=True)
class Motion:
    """Pose, velocity and acceleration in the paper's axes.

    x runs along the canal, y to starboard of the centreline; psi and r are clockwise seen from above.

    Examples
    --------
    >>> motion = nw.Motion.at(y=0.5, psi=0.1, u=1.0)
    >>> round(float(model.forces(motion)["N"]), 1)
    -6.8
    """

    x: Number = 0.0  #: Position of midship along the canal [m]
    y: Number = 0.0  #: Position of midship to starboard of the centreline [m]
    cos_psi: Number = 1.0  #: Cosine of the heading [1]
    sin_psi: Number = 0.0  #: Sine of the heading [1]
    u: Number = 0.0  #: Surge velocity through the water [m/s]
    v: Number = 0.0  #: Sway velocity through the water [m/s]
    r: Number = 0.0  #: Yaw rate [rad/s]
    udot: Number = 0.0  #: Surge acceleration [m/s2], in the ship's axes
    vdot: Number = 0.0  #: Sway acceleration [m/s2], in the ship's axes
    rdot: Number = 0.0  #: Yaw acceleration [rad/s2]
    heave: Number = 0.0  #: Midship sinkage [m], positive down

    @classmethod
    def at(cls, psi: Number = 0.0, **rest: Number) -> "Motion":
        """Return a Motion from a heading ``psi`` [rad] instead of its cosine and sine; ``rest`` are the other fields,
        by name.
        """
        of: Any = math if isinstance(psi, float | int) else np
        return cls(cos_psi=of.cos(psi), sin_psi=of.sin(psi), **rest)

    def values(self) -> dict[str, Number]:
        """Every field by its name, for the arguments of terms."""
        return {f.name: getattr(self, f.name) for f in fields(self)}
