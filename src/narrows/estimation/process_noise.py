"""What the model does not tell: how fast the motion wanders from it, and what is believed before any measurement."""

import math
from dataclasses import dataclass, fields

from narrows.errors import InputError

# Of the ship [m] whose numbers stand below; other ships' follow by Froude's law.
REFERENCE_LENGTH = 230.0


def _check(numbers: object) -> None:
    """Raise InputError where a standard deviation is none."""
    for field in fields(numbers):  # type: ignore[arg-type]
        value = getattr(numbers, field.name)
        if not (math.isfinite(value) and value >= 0.0):
            what = type(numbers).__name__
            raise InputError(f"{what}: {field.name} = {value} is no standard deviation; give a finite number from 0")


@dataclass(frozen=True)
class ProcessNoise:
    """Random walks that are added to the model: the standard deviation that each gathers in one second.

    Parameters
    ----------
    surge, sway : float [m/s per root s]
        Of the velocities: gusts, waves, squat, what the terms leave out.
    yaw : float [rad/s per root s]
        Of the yaw rate, by the same.
    bank : float [1 per root s]
        Of the bank's strength: the banks are not as they are drawn.
    current, current_across : float [m/s per root s]
        Of the current; across, 0 with a prior of 0 leaves that state out.
    rudder_bias, heading_bias : float [rad per root s]
        Of the biases.

    Raises
    ------
    InputError
        Where a number is none.
    """

    surge: float = 0.005
    sway: float = 0.003
    yaw: float = 1.5e-5
    bank: float = 0.01
    current: float = 0.002
    current_across: float = 0.0002
    rudder_bias: float = 1e-5
    heading_bias: float = 1e-6

    def __post_init__(self) -> None:
        _check(self)

    @classmethod
    def of_length(cls, length: float) -> "ProcessNoise":
        """Return the usual noise of a ship, by Froude's law from one of 230 m.

        Parameters
        ----------
        length : float [m]
            Of the ship.
        """
        usual, scale = cls(), length / REFERENCE_LENGTH
        velocity, per_root_second = scale**0.25, scale**-0.25
        return cls(
            usual.surge * velocity, usual.sway * velocity, usual.yaw * scale**-0.75, usual.bank * per_root_second,
            usual.current * velocity, usual.current_across * velocity, usual.rudder_bias * per_root_second,
            usual.heading_bias * per_root_second,
        )  # fmt: skip

    def by_state(self) -> dict[str, float]:
        """Return it by the names of states."""
        walks = {"u": self.surge, "v": self.sway, "r": self.yaw, "bank": self.bank, "current": self.current}
        walks |= {"current_across": self.current_across, "rudder_bias": self.rudder_bias}
        return {**walks, "heading_bias": self.heading_bias, "x": 0.0, "y": 0.0, "psi": 0.0}


@dataclass(frozen=True)
class Prior:
    """What is believed before any measurement: standard deviations about rest and about the model.

    A place, a heading and a speed are taken from the first readings; biases of sensors stand with the sensors.

    Parameters
    ----------
    sway : float [m/s]
        Of the sway velocity about 0.
    yaw_rate : float [rad/s]
        Of the yaw rate about 0, where no sensor tells it.
    bank : float [1]
        Of the bank's strength about 1, the model's.
    current, current_across : float [m/s]
        Of the current, about the waterway's and about 0.

    Raises
    ------
    InputError
        Where a number is none.
    """

    sway: float = 0.15
    yaw_rate: float = 5e-4
    bank: float = 0.2
    current: float = 0.3
    current_across: float = 0.05

    def __post_init__(self) -> None:
        _check(self)

    @classmethod
    def of_length(cls, length: float) -> "Prior":
        """Return the usual prior of a ship, by Froude's law from one of 230 m.

        Parameters
        ----------
        length : float [m]
            Of the ship.
        """
        usual, root = cls(), math.sqrt(length / REFERENCE_LENGTH)
        speeds = (usual.current * root, usual.current_across * root)
        return cls(usual.sway * root, usual.yaw_rate / root, usual.bank, *speeds)
