"""What throws a ship off: a course that is wrong, and a gust."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from narrows.errors import InputError
from narrows.quantities.names import AIR_DENSITY


@dataclass(frozen=True)
class Disturbance:
    """What throws a ship off.

    Parameters
    ----------
    heading_deg : float [deg]
        Heading off at the start: standard deviation of normal samples.
    offset : float [m]
        Off the line at the start: likewise.
    gust : float [N]
        Sway force from the start on, to starboard or to port by even odds.
    gust_lever : float [m]
        Of that force, forward of midship.
    gust_time : float [s]
        How long it lasts.
    wind : float [m/s], optional
        That the gust comes from, for words alone.

    Raises
    ------
    InputError
        Where a number is negative (but the lever), or not finite.
    """

    heading_deg: float = 2.0
    offset: float = 0.0
    gust: float = 0.0
    gust_lever: float = 0.0
    gust_time: float = 60.0
    wind: float | None = None

    def __post_init__(self) -> None:
        for name in ("heading_deg", "offset", "gust", "gust_time"):
            if not 0 <= getattr(self, name) < math.inf:
                raise InputError(f"a disturbance's {name} = {getattr(self, name)} must be a number from 0")
        if not math.isfinite(self.gust_lever):
            raise InputError("a gust's lever must be a finite number of metres")

    @property
    def words(self) -> str:
        """What it is, as a pilot would say it."""
        parts = [f"heading off by {self.heading_deg:g} deg"] if self.heading_deg else []
        parts += [f"offset by {self.offset:g} m"] if self.offset else []
        begin = f" at the start {' and '.join(parts)} (standard deviation)" if parts else " nothing off at the start"
        if not self.gust:
            return f"no wind;{begin}"
        strength = f"{self.gust / 1e3:.4g} kN" if self.wind is None else f"{self.wind:.3g} m/s"
        return f"a gust of {strength} on the beam for {self.gust_time:g} s, from either side;{begin}"

    def drawn(self, samples: int, seed: int) -> dict[str, xr.DataArray]:
        """Draw disturbances along a dimension ``sample``: psi [rad], y [m], Y [N], N [N m] off.

        Parameters
        ----------
        samples : int
            How many.
        seed : int
            Of the samples.

        Raises
        ------
        InputError
            Where there is no sample, or the seed is negative.
        """
        if samples < 1 or seed < 0:
            raise InputError(f"samples = {samples} and seed = {seed}: give one sample at least, and a seed from 0")
        heading, offset, side = np.random.default_rng((seed, 1)).standard_normal((3, samples))
        gust = np.sign(side)
        columns = {
            "psi": math.radians(self.heading_deg) * heading,
            "y": self.offset * offset,
            "Y": self.gust * gust,
            "N": self.gust * self.gust_lever * gust,
        }
        return {name: xr.DataArray(column, dims="sample") for name, column in columns.items()}


def wind_force(speed: float, area: float, coefficient: float = 1.0) -> float:
    """Return the sway force of a beam wind [N], C 1/2 rho A V^2 (the drag law).

    Parameters
    ----------
    speed : float [m/s]
        Of the wind.
    area : float [m2]
        Lateral, above the water.
    coefficient : float [1]
        Of the side.

    Raises
    ------
    InputError
        Where a number is negative or not finite.
    """
    if not all(0 <= number < math.inf for number in (speed, area, coefficient)):
        raise InputError("a wind's speed, area and coefficient are numbers from 0; check them")
    return 0.5 * AIR_DENSITY * coefficient * area * speed * speed
