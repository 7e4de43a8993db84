"""What drives and steers a ship: propeller, rudder, steering gear, and the actuators that they make."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar

from narrows.quantities.names import PARTICULARS, Quantity
from narrows.ship.actuator import Actuator, Part


@dataclass(frozen=True)
class Propeller(Part):
    """A propeller, as the MMG standard method asks for it.

    Parameters
    ----------
    diameter : float [m]
        D_P.
    revolutions : float [1/s]
        n, held.
    wake : float [1]
        Wake fraction straight ahead, w_P0.
    thrust_0, thrust_1, thrust_2 : float [1]
        K_T = k_0 + k_1 J + k_2 J^2.
    position : float [1]
        Forward of midship over L, x_P'.
    wake_rate : float [1]
        How soon the wake thins as the ship turns, C_1.
    wake_starboard, wake_port : float [1]
        Inflow turning over inflow straight, C_2, in a turn to starboard (beta_P > 0, flow from port) and to port.

    Raises
    ------
    InputError
        Where a number is not finite, a size is not positive, or the wake is not a fraction.
    """

    SECTION: ClassVar[str] = "propeller"
    POSITION: ClassVar[str] = "revolutions"
    NUMBERS: ClassVar[Mapping[str, Quantity]] = {
        "diameter": Quantity("m", "propeller diameter D_P"),
        "revolutions": Quantity("1/s", "propeller revolutions n"),
        "wake": Quantity("1", "wake fraction at the propeller straight ahead w_P0"),
        "thrust_0": Quantity("1", "K_T at no advance k_0"),
        "thrust_1": Quantity("1", "slope of K_T by the advance k_1"),
        "thrust_2": Quantity("1", "curvature of K_T by the advance k_2"),
        "position": Quantity("1", "propeller forward of midship over L, x_P'"),
        "wake_rate": Quantity("1", "how soon the wake thins as the ship turns C_1"),
        "wake_starboard": Quantity("1", "inflow turning to starboard over inflow straight C_2"),
        "wake_port": Quantity("1", "inflow turning to port over inflow straight C_2"),
    }

    diameter: float
    revolutions: float
    wake: float
    thrust_0: float
    thrust_1: float
    thrust_2: float
    position: float = -0.5
    wake_rate: float = 0.0
    wake_starboard: float = 1.0
    wake_port: float = 1.0


@dataclass(frozen=True)
class Rudder(Part):
    """A rudder, as the MMG standard method asks for it.

    Parameters
    ----------
    area : float [m2]
        A_R.
    lift : float [1]
        Slope of the lift, f_alpha.
    wake_ratio : float [1]
        Inflow over that of the propeller, epsilon.
    slipstream : float [1]
        How far the slipstream is sped up, kappa.
    in_slipstream : float [1]
        Propeller diameter over rudder height, eta.
    position : float [1]
        Effective place over L, l_R'.
    straightening_starboard, straightening_port : float [1]
        gamma_R in a turn to starboard (beta_R > 0, flow from port) and to port.

    Raises
    ------
    InputError
        Where a number is not finite, or a size is not positive.
    """

    SECTION: ClassVar[str] = "rudder"
    POSITION: ClassVar[str] = "rudder"
    NUMBERS: ClassVar[Mapping[str, Quantity]] = {
        "area": Quantity("m2", "rudder area A_R"),
        "lift": Quantity("1", "slope of the rudder's lift f_alpha"),
        "wake_ratio": Quantity("1", "inflow at the rudder over that at the propeller epsilon"),
        "slipstream": Quantity("1", "how far the slipstream is sped up at the rudder kappa"),
        "in_slipstream": Quantity("1", "propeller diameter over rudder height eta"),
        "position": Quantity("1", "effective place of the rudder over L, l_R'"),
        "straightening_starboard": Quantity("1", "flow straightening in a turn to starboard gamma_R"),
        "straightening_port": Quantity("1", "flow straightening in a turn to port gamma_R"),
    }

    area: float
    lift: float
    wake_ratio: float
    slipstream: float
    in_slipstream: float
    position: float
    straightening_starboard: float
    straightening_port: float


@dataclass(frozen=True)
class SteeringGear(Part):
    """What turns the rudder; unless said otherwise as slow as the rules allow a ship.

    Parameters
    ----------
    limit_deg : float [deg]
        Largest rudder angle.
    rate_deg : float [deg/s]
        Of the rudder.

    Raises
    ------
    InputError
        Where a value is not a positive number, or the limit is beyond 90 degrees.

    References
    ----------
    SOLAS regulation II-1/29.3.2: from 35 degrees on one side to 30 on the other in 28 s.
    """

    SECTION: ClassVar[str] = "steering"
    POSITION: ClassVar[str] = "rudder"
    NUMBERS: ClassVar[Mapping[str, Quantity]] = {
        "limit_deg": Quantity("deg", "largest rudder angle"),
        "rate_deg": Quantity("deg/s", "rate of the rudder"),
    }
    ASKED: ClassVar[bool] = False

    limit_deg: float = 35.0
    rate_deg: float = 65 / 28

    @classmethod
    def known_as(cls, number: str) -> str:
        """Return the key itself: terms ask for neither.

        Parameters
        ----------
        number : str
            Its key in the section.
        """
        return number

    @property
    def limit(self) -> float:
        """Largest rudder angle [rad]."""
        return math.radians(self.limit_deg)

    @property
    def rate(self) -> float:
        """Rate of the rudder [rad/s]."""
        return math.radians(self.rate_deg)

    def values(self) -> dict[str, float]:
        """Limit [rad] and rate [rad/s] of the rudder."""
        return {"rudder_limit": self.limit, "rudder_rate": self.rate}


RUDDER = Actuator(
    "rudder", "rad", "rudder angle, positive where it turns the bow to starboard", angle=True, rest=0.0,
    parts=(Rudder, SteeringGear),
)  # fmt: skip
PROPELLER = Actuator("revolutions", "1/s", "propeller revolutions n", parts=(Propeller,))
# The actuators that come with the package, in the order in which they are listed.
STANDARD = (RUDDER, PROPELLER)


def particulars_with(actuators: Iterable[Actuator] = ()) -> dict[str, Quantity]:
    """Return unit and meaning of every particular of ship, canal, water and actuators."""
    return {
        **PARTICULARS,
        **{name: quantity for actuator in (*STANDARD, *actuators) for name, quantity in actuator.particulars.items()},
    }
