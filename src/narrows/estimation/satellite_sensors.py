"""Satellite receivers: the place of an antenna, and its velocity over ground."""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from narrows.errors import InputError
from narrows.estimation.sensor import Measuring, Values
from narrows.estimation.states import Columns

# Curvature [1/m] of a line that is straight.
STRAIGHT = 1e-9


@dataclass(frozen=True)
class Antenna(Measuring):
    """What receivers have in common: an antenna, and two numbers, along and across."""

    _: KW_ONLY
    forward: float = 0.0  # Of the antenna, from midship [m]
    starboard: float = 0.0  # Of the antenna, from midship [m]
    angles: ClassVar[tuple[bool, ...]] = (False, False)
    source: ClassVar[str] = "satellites"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (math.isfinite(self.forward) and math.isfinite(self.starboard)):
            raise InputError("an antenna needs a place; give forward and starboard in metres from midship")


@dataclass(frozen=True)
class Gnss(Antenna):
    """A satellite receiver: the place of its antenna in the canal.

    Parameters
    ----------
    noise : float [m]
        Standard deviation along and across.
    period : float [s]
        Between readings.
    late : float [s]
        How old a reading is when it comes.
    name : str
        Of its readings.
    forward, starboard : float [m]
        Of the antenna, from midship.

    Raises
    ------
    InputError
        Where a number is none.
    """

    noise: float = 1.5
    _: KW_ONLY
    name: str = "gnss"

    @property
    def straight(self) -> bool:
        """Where the antenna stands at midship."""
        return not (self.forward or self.starboard)

    @property
    def fields(self) -> tuple[str, ...]:
        """Along and across."""
        return (f"{self.name}_x", f"{self.name}_y")

    def measured(self, at: Columns) -> Values:
        """Return where the antenna is; along a bend by the circle that the line follows there.

        Parameters
        ----------
        at : Columns
            The states.
        """
        if not (self.forward or self.starboard):
            return at.x, at.y
        cosine, sine = np.cos(at.psi), np.sin(at.psi)
        ahead = self.forward * cosine - self.starboard * sine
        side = at.y + self.forward * sine + self.starboard * cosine
        bend = at.curvature
        if abs(bend) < STRAIGHT:
            return at.x + ahead, side
        inward, along = 1.0 - bend * side, bend * ahead
        reach = np.hypot(inward, along)
        return at.x + np.arctan2(along, inward) / bend, (2.0 * side - bend * (side * side + ahead * ahead)) / (
            1.0 + reach
        )

    def start(self, reading: Sequence[float]) -> dict[str, tuple[float, float]]:
        """Return the place; the antenna's own, which the estimator brings to midship.

        Parameters
        ----------
        reading : sequence of float [m]
            Along and across.
        """
        return {"x": (reading[0], self.noise), "y": (reading[1], self.noise)}


@dataclass(frozen=True)
class CourseOverGround(Antenna):
    """Course and speed over ground, as a satellite receiver tells them from Doppler shifts.

    Told as course and speed, believed as velocities along and across, whose noise does not depend on the speed. With
    the model's drift they tell a gyro's bias.

    Parameters
    ----------
    noise : float [m/s]
        Standard deviation of the velocity along and across.
    period : float [s]
        Between readings.
    late : float [s]
        How old a reading is when it comes.
    name : str
        Of its readings.
    forward, starboard : float [m]
        Of the antenna, from midship.

    Raises
    ------
    InputError
        Where a number is none.
    """

    noise: float = 0.05
    _: KW_ONLY
    name: str = "course"

    @property
    def straight(self) -> bool:
        """Not linear in the heading."""
        return False

    @property
    def fields(self) -> tuple[str, ...]:
        """Course [rad] and speed [m/s]."""
        return (f"{self.name}_over_ground", f"{self.name}_speed")

    def numbers(self, reading: Sequence[float]) -> Values:
        """Return the velocities along and across [m/s].

        Parameters
        ----------
        reading : sequence of float
            Course [rad] and speed [m/s].
        """
        course, speed = reading
        return speed * math.cos(course), speed * math.sin(course)

    def reading(self, numbers: Values) -> Values:
        """Return course [rad] and speed [m/s] of velocities along and across.

        Parameters
        ----------
        numbers : tuple of float or array [m/s]
            Along and across.
        """
        return np.arctan2(numbers[1], numbers[0]), np.hypot(*numbers)

    def measured(self, at: Columns) -> Values:
        """Return the velocities of the antenna along and across.

        Parameters
        ----------
        at : Columns
            The states.
        """
        cosine, sine = np.cos(at.psi), np.sin(at.psi)
        ahead, side = at.u - at.r * self.starboard, at.v + at.r * self.forward
        return ahead * cosine - side * sine + at.current, ahead * sine + side * cosine + at.current_across

    def start(self, reading: Sequence[float]) -> dict[str, tuple[float, float]]:
        """Return nothing: a current or a drift may stand between it and the state.

        Parameters
        ----------
        reading : sequence of float
            Course [rad] and speed [m/s].
        """
        return {}
