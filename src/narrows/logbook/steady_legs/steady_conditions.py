"""What all legs of a held ship share and nobody measured: wind, the zeros of the instruments, a rest of motion."""

import math
from dataclasses import dataclass, fields

import numpy as np

from narrows.errors import InputError, shown
from narrows.logbook.beam_wind import beam_wind
from narrows.model.model import Model
from narrows.results import Described
from narrows.ship.checks import is_finite

# What is estimated beside the coefficients: force [N] and moment [N m] of the wind, zeros of angles [rad], y [m].
UNKNOWN = ("wind_Y", "wind_N", "rudder_zero", "drift_zero", "heading_zero", "y_zero")
# Of the beam, that banks are from where they are thought to be: used where nothing is given.
MISPLACED = 1 / 30


@dataclass(frozen=True, repr=False)
class SteadyConditions(Described):
    """How much what all legs share may be, as standard deviations, and what changes from leg to leg.

    Force and moment of the wind are the same on every leg but for ``wind_change`` of their standard deviations, and so
    are the zeros. Opposite sides cancel all of them. What still moves on a leg is a force of its own.

    Parameters
    ----------
    wind : float [m/s]
        Speed of a beam wind of one standard deviation, from either side.
    windage : float [m2], optional
        Lateral area above the water; a tenth of the square of the length unless given.
    wind_lever : float [m], optional
        Standard deviation of where the wind's force acts, off midship; a tenth of the length unless given.
    wind_change : float [1]
        Of force and moment of the wind, from leg to leg.
    rudder_zero_deg, drift_zero_deg, heading_zero_deg : float [deg]
        Of the readings, the same on every leg.
    y_zero : float [m], optional
        Of the offset: how far banks and antenna are from where they are thought to be; a thirtieth of the beam unless
        given.
    yaw_rate_deg : float [deg/s]
        Mean over a leg: what is left of turning.
    yaw_change_deg : float [deg/s]
        Of the yaw rate between the begin and the end of a leg.
    sway_change : float [m/s]
        Of the sway velocity, likewise.
    leg_time : float [s]
        How long a leg is read.

    Raises
    ------
    InputError
        Where a number is negative or not finite, or the time of a leg is 0.
    """

    wind: float = 8.0
    windage: float | None = None
    wind_lever: float | None = None
    wind_change: float = 0.2
    rudder_zero_deg: float = 1.0
    drift_zero_deg: float = 1.0
    heading_zero_deg: float = 1.0
    y_zero: float | None = None
    yaw_rate_deg: float = 0.005
    yaw_change_deg: float = 0.01
    sway_change: float = 0.02
    leg_time: float = 120.0

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            missing = value is None and entry.default is None
            if not missing and (not is_finite(value) or value < 0 or (entry.name == "leg_time" and value == 0)):
                raise InputError(f"conditions of legs: {entry.name} = {shown(value)} must be a finite number from 0")

    def summary(self) -> str:
        """Say them."""
        aside = f"{self.y_zero:g} m" if self.y_zero is not None else f"{MISPLACED:.2f} beams"
        return (
            f"beam wind {self.wind:g} m/s, its force changing by {100 * self.wind_change:.0f} % from leg to leg; zeros "
            f"of rudder {self.rudder_zero_deg:g}, drift {self.drift_zero_deg:g} and heading {self.heading_zero_deg:g} "
            f"deg, of the offset {aside}; turning at {self.yaw_rate_deg:g} deg/s (standard deviations)"
        )

    def shared(self, model: Model) -> np.ndarray:
        """Return the standard deviations of ``UNKNOWN`` for a ship, (6,) [N, N m, rad, rad, rad, m].

        Parameters
        ----------
        model : Model
            The ship.
        """
        zeros = map(math.radians, (self.rudder_zero_deg, self.drift_zero_deg, self.heading_zero_deg))
        aside = MISPLACED * model.configuration.ship.beam if self.y_zero is None else self.y_zero
        return np.array([*self._wind(model), *zeros, aside], float)

    def left_over(self, model: Model) -> np.ndarray:
        """Return what is left on each leg: force and moment [N, N m], yaw rate [rad/s], accelerations [m/s2, rad/s2].

        Parameters
        ----------
        model : Model
            The ship.
        """
        gust = self.wind_change * self._wind(model)
        rates = self.sway_change / self.leg_time, math.radians(self.yaw_change_deg) / self.leg_time
        return np.array([*gust, math.radians(self.yaw_rate_deg), *rates])

    def _wind(self, model: Model) -> np.ndarray:
        return np.array(beam_wind(model.configuration.ship.length, self.wind, self.windage, self.wind_lever))
