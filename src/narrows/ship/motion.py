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

    Parameters
    ----------
    x, y : number [m]
        Position of midship in the canal.
    cos_psi, sin_psi : number [1]
        Cosine and sine of the heading.
    u, v : number [m/s]
        Surge and sway velocity through the water.
    r : number [rad/s]
        Yaw rate.
    udot, vdot : number [m/s2]
        Surge and sway acceleration, in the ship's axes.
    rdot : number [rad/s2]
        Yaw acceleration.
    heave : number [m]
        Midship sinkage, positive down.

    Examples
    --------
    >>> motion = nw.Motion.at(y=0.5, psi=0.1, u=1.0)
    >>> round(float(model.forces(motion)["N"]), 1)
    -6.8
    """

    x: Number = 0.0
    y: Number = 0.0
    cos_psi: Number = 1.0
    sin_psi: Number = 0.0
    u: Number = 0.0
    v: Number = 0.0
    r: Number = 0.0
    udot: Number = 0.0
    vdot: Number = 0.0
    rdot: Number = 0.0
    heave: Number = 0.0

    @classmethod
    def at(cls, psi: Number = 0.0, **rest: Number) -> "Motion":
        """Return a Motion from a heading instead of its cosine and sine.

        Parameters
        ----------
        psi : number [rad]
            Heading, a float or a column.
        **rest : number
            The other fields, by name.
        """
        of: Any = math if isinstance(psi, float | int) else np
        return cls(cos_psi=of.cos(psi), sin_psi=of.sin(psi), **rest)

    def values(self) -> dict[str, Number]:
        """Every field by its name, for the arguments of terms."""
        return {f.name: getattr(self, f.name) for f in fields(self)}
