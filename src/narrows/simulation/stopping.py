"""Stopping test: the propeller turns astern until the ship lies still."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.results import BaseResult
from narrows.model.additions import TRANSVERSE_THRUST
from narrows.model.model import Model
from narrows.quantities.arithmetic import maximum, minimum
from narrows.simulation.controllers import Named
from narrows.simulation.inputs import finite_numbers
from narrows.simulation.manoeuvring_trials import TrialShip
from narrows.simulation.voyage import Voyage

# Longest duration of a test, in ship lengths at the approach speed.
STOPPING_LENGTHS = 80.0
# Largest track reach of IMO resolution MSC.137(76) [ship lengths].
LARGEST_TRACK_REACH = 15.0

NO_TRANSVERSE_THRUST = (
    "The model has no transverse thrust of its propeller, so the ship stops straight ahead; nw.with_transverse_thrust "
    "adds that of a similar ship."
)


@dataclass(frozen=True)
class EngineReversal:
    """A law for the propeller: from revolutions ahead to revolutions astern, after a delay and evenly in time."""

    ahead: float  # [1/s]
    astern: float  # [1/s]
    delay: float  # [s]
    reversal: float  # [s]

    def parameters(self) -> Mapping[str, Any]:
        return vars(self)

    def memory(self, start: Named) -> Named:
        return {}

    def orders(self, at: Any) -> tuple[Named, Named]:
        # At once if the reversal takes no time.
        share = minimum(maximum((at.t + at.dt - at.delay) / maximum(at.reversal, at.dt), 0.0), 1.0)
        return {"revolutions": at.ahead + share * (at.astern - at.ahead)}, {}


@dataclass(frozen=True, repr=False)
class StoppingTest(BaseResult):
    """A stopping test, measured from the order; the result of ``crash_stop``.

    >>> nw.crash_stop(nw.published("yasukawa2015_kvlcc2")).track_reach > 0
    True
    """

    track_reach: float  #: Distance along the track [m]
    head_reach: float  #: Distance along the first course [m]
    side_reach: float  #: Distance across it, to starboard [m]
    time: float  #: Time until the ship lies still [s]
    voyage: Voyage  #: The test itself, until the first step astern
    notes: tuple[str, ...] = ()  #: Assumptions

    def summary(self) -> str:
        lengths = self.track_reach / self.voyage.configuration.ship.length
        return (
            f"The ship stops in {self.time:.0f} s on {self.track_reach:.4g} m ({lengths:.1f} L; IMO allows "
            f"{LARGEST_TRACK_REACH:g} L), {self.head_reach:.4g} m ahead and {self.side_reach:+.3g} m to starboard."
        )

    def to_dict(self) -> dict[str, Any]:
        names = ("track_reach", "head_reach", "side_reach", "time")
        over = self.track_reach / self.voyage.configuration.ship.length
        return {**{name: getattr(self, name) for name in names}, "track_reach_over_length": over}


@accept_aliases
def crash_stop(
    model: Model, speed: float | None = None, revolutions: float | None = None, delay: float = 0.0,
    reversal: float = 0.0,
) -> StoppingTest:  # fmt: skip
    """Simulate a stopping test in open water, rudder amidships.

    Its side reach is that of the transverse thrust, which ``with_transverse_thrust`` adds to a model.

    Raises an InputError if the thrust astern is unknown, the model has no free surge motion, a time is negative, or the
    ship does not stop.

    Source: IMO (2002), resolution MSC.137(76), Standards for ship manoeuvrability.

    Parameters
    ----------
    model : Model
        A model with terms of a propeller whose thrust astern is known, and with a surge inertia.
    speed : float [m/s], optional
        Speed of the approach; default: one that suits the ship.
    revolutions : float [1/s], optional
        Revolutions astern, below 0; default: as many as on the approach.
    delay : float [s]
        Time from the order until the revolutions begin to change.
    reversal : float [s]
        Time of that change.

    Examples
    --------
    >>> tanker = nw.published("yasukawa2015_kvlcc2_full")
    >>> round(nw.crash_stop(tanker, revolutions=-1.0, delay=10.0, reversal=60.0).time)
    1184
    """
    if not model.terms.propelled or not model.surge_inertia > 0:
        raise InputError(
            "a stopping test needs terms of a propeller and an inertia in surge, as those of nw.MMG; take a ship that "
            "has them, such as nw.published('estimated_kcs')"
        )
    ship = TrialShip.of(model, speed)
    ahead = ship.model.configuration.values()["revolutions"]
    given = {"revolutions": -ahead if revolutions is None else revolutions, "delay": delay, "reversal": reversal}
    numbers = finite_numbers(**given)
    if not numbers["revolutions"] < 0 or min(numbers["delay"], numbers["reversal"]) < 0:
        raise InputError(f"revolutions astern are below 0, delay and reversal are from 0 s; {given} are not")
    law = EngineReversal(ahead, numbers["revolutions"], numbers["delay"], numbers["reversal"])
    voyage = ship.sail(law, STOPPING_LENGTHS)
    if not voyage.u.min() < 0:
        raise InputError(
            f"the ship still makes {voyage.u[-1]:.2g} m/s after {voyage.t[-1]:.0f} s; give more revolutions"
        )
    # The forces of the hull are those ahead, so that the test ends at the first step astern.
    last = int(np.argmax(voyage.u < 0))
    voyage = ship.sail(law, voyage.t[last] * ship.speed / ship.model.configuration.ship.length)
    share = voyage.u[-2] / (voyage.u[-2] - voyage.u[-1])

    def stopped(column: np.ndarray) -> float:
        return float(column[-2] + share * (column[-1] - column[-2]) - column[0])

    track = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(voyage.x), np.diff(voyage.y)))])
    reach, ahead_of, aside, time = (stopped(column) for column in (track, voyage.x, voyage.y, voyage.t))
    pushed = TRANSVERSE_THRUST.names(model.terms)[0] in model.terms.names
    return StoppingTest(reach, ahead_of, aside, time, voyage, ship.notes + (() if pushed else (NO_TRANSVERSE_THRUST,)))
