"""Standard manoeuvring trials in open water: turning circles, zigzags, stopping tests, and their measures."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.results import BaseResult
from narrows.model.additions import TRANSVERSE_THRUST
from narrows.model.data_range import extrapolation
from narrows.model.model import Model
from narrows.quantities.arithmetic import maximum, minimum
from narrows.simulation.controllers import ConstantRudder, ControlLaw, Named, WithoutMemory, Zigzag
from narrows.simulation.initial_state import steady_revolutions, voyage_defaults
from narrows.simulation.inputs import finite_numbers
from narrows.simulation.voyage import Voyage, simulate

if TYPE_CHECKING:
    import pandas as pd

STEPS_A_LENGTH = 120
# Longest duration of a circle or a zigzag, and of a stopping test, in ship lengths at the approach speed.
LENGTHS, STOPPING_LENGTHS = 40.0, 80.0
# Length [m] below which a hull counts as a model.
MODEL_LENGTH = 30.0
# Largest track reach of IMO resolution MSC.137(76) [ship lengths].
LARGEST_TRACK_REACH = 15.0
# Angles below this [deg] were probably given in radians.
LEAST_DEG = 1.0
MEASURES = ("advance", "transfer", "tactical_diameter")
NO_TRANSVERSE_THRUST = (
    "The model has no transverse thrust of its propeller, so the ship stops straight ahead; nw.with_transverse_thrust "
    "adds that of a similar ship."
)


@dataclass(frozen=True, repr=False)
class Turning(BaseResult):
    """A turning circle, measured from the rudder order; the result of ``turning_circle``."""

    advance: float  #: Distance along the first course at a heading change of 90 degrees [m]
    transfer: float  #: Distance across it, then [m]
    tactical_diameter: float  #: Distance across it at a heading change of 180 degrees [m]
    voyage: Voyage  #: The circle itself
    notes: tuple[str, ...] = ()  #: Assumptions

    @classmethod
    def of(cls, voyage: Voyage, notes: tuple[str, ...] = ()) -> "Turning":
        """Read a turning circle from a ``voyage`` that begins with the order, x along the first course; add ``notes``.

        Raises an InputError if the ship has not turned by 180 degrees.
        """
        turned = np.abs(voyage.psi - voyage.psi[0])
        if turned.max() < np.pi:
            by, why = np.degrees(turned.max()), voyage.outcome.sentence.partition(". ")[0].removesuffix(".")
            raise InputError(f"the ship turned by {by:.0f} degrees of the 180 asked for: {why}; sail slower or longer")
        x, y = (column - column[0] for column in (voyage.x, voyage.y))
        first = slice(0, int(np.argmax(turned >= np.pi)) + 1)
        along, across = (np.interp((np.pi / 2, np.pi), turned[first], np.abs(column[first])) for column in (x, y))
        return cls(float(along[0]), float(across[0]), float(across[1]), voyage, notes)

    def summary(self) -> str:
        of = self.to_dict()
        parts = (f"{n.replace('_', ' ')} {of[f'{n}_over_length']:.2f} L ({of[n]:.4g} m)" for n in MEASURES)
        return f"Rudder {math.degrees(self.voyage.rudder[-1]):+.3g} degrees: {', '.join(parts)}."

    def to_dict(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in MEASURES} | self.over_length()

    def over_length(self) -> dict[str, float]:
        """Return the measures over the ship's length, and the steady speed over that of the approach [1]."""
        length, u = self.voyage.configuration.ship.length, np.hypot(self.voyage.u, self.voyage.v)
        measures = {f"{name}_over_length": getattr(self, name) / length for name in MEASURES}
        return {**measures, "speed_over_approach": float(u[-1] / u[0])}


@dataclass(frozen=True, repr=False)
class ZigzagTest(BaseResult):
    """A zigzag and its overshoots; the result of ``zigzag``."""

    overshoots_deg: tuple[float, ...]  #: Further heading change after each order that reversed the rudder [deg]
    voyage: Voyage  #: The zigzag itself
    notes: tuple[str, ...] = ()  #: Assumptions

    def summary(self) -> str:
        return f"Zigzag: overshoots {', '.join(f'{angle:.1f}' for angle in self.overshoots_deg)} degrees."

    def to_dict(self) -> dict[str, Any]:
        return {"overshoots_deg": list(self.overshoots_deg)}


@dataclass(frozen=True, repr=False)
class Trials(BaseResult):
    """Trials of one ship."""

    model: Model  #: Model in open water
    speed: float  #: Speed of the approach [m/s]
    turning: dict[str, Turning]  #: Turning circles by order, as in ``+35``
    zigzags: dict[str, ZigzagTest]  #: Zigzags by rudder and heading, as in ``+10/10``
    notes: tuple[str, ...]  #: Assumptions

    def summary(self) -> str:
        form = (
            "Rudder {} degrees: advance {advance_over_length:.2f} L, "
            "tactical diameter {tactical_diameter_over_length:.2f} L."
        )
        circles = [form.format(order, **circle.over_length()) for order, circle in self.turning.items()]
        zigzags = [f"Zigzag {order}{test.summary().removeprefix('Zigzag')}" for order, test in self.zigzags.items()]
        return "\n".join(circles + zigzags)

    def to_dict(self) -> dict[str, Any]:
        turning = {order: circle.over_length() for order, circle in self.turning.items()}
        zigzags = {order: test.to_dict() for order, test in self.zigzags.items()}
        said = {"summary": self.summary(), "notes": list(self.notes)}
        return {"speed": self.speed, "turning": turning, "zigzags": zigzags, **said}

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the measures as a table: one row for each manoeuvre and measure."""
        import pandas as pd

        measured = {f"turning {order}": pd.Series(circle.over_length()) for order, circle in self.turning.items()}
        for order, test in self.zigzags.items():
            numbered = enumerate(test.overshoots_deg, start=1)
            measured[f"zigzag {order}"] = pd.Series({f"overshoot_{number}_deg": angle for number, angle in numbered})
        return pd.concat(measured, names=["manoeuvre", "measure"]).to_frame("value")


@accept_aliases
def turning_circle(
    model: Model, rudder: float = 35.0, speed: float | None = None, dt: float | None = None,
    duration: float | None = None,
) -> Turning:  # fmt: skip
    """Simulate a turning circle in open water; refusals (InputError) and other arguments are those of ``sail_trials``.

    Parameters
    ----------
    model, rudder : Model, float [deg]
        Angle, positive if it turns the bow to starboard.
    speed, dt, duration : float [m/s, s, s], optional
        Longest time from the order; default: 40 ship lengths at the approach speed.
    """
    return TrialShip.of(model, speed, dt, duration).turn(rudder)


@accept_aliases
def zigzag(
    model: Model, rudder: float = 10.0, heading: float = 10.0, speed: float | None = None, dt: float | None = None,
    duration: float | None = None,
) -> ZigzagTest:  # fmt: skip
    """Simulate a zigzag in open water; refusals (InputError) and other arguments are those of ``turning_circle``.

    Parameters
    ----------
    model, rudder, heading : Model, float [deg], float [deg]
        Angle, negative for a first order to port, and the heading change at which it is reversed.
    speed, dt, duration : float [m/s, s, s], optional
        As for ``turning_circle``.
    """
    return TrialShip.of(model, speed, dt, duration).zigzag(rudder, heading)


@accept_aliases
def sail_trials(
    model: Model, speed: float | None = None, turn_deg: float = 35.0,
    zigzags: tuple[tuple[float, float], ...] = ((10, 10), (20, 20)), dt: float | None = None,
) -> Trials:  # fmt: skip
    """Simulate turning circles and zigzags in open water, each to either side (IMO resolution MSC.137(76), 2002).

    The speed is free if the model has a surge inertia, and constant otherwise. If the model's own revolutions are for
    another speed than the approach, those that keep it are used.

    Raises an InputError if the model has no rudder or the gear does not reach an angle, the speed or the step is not
    positive, or the ship does not turn far enough.

    Parameters
    ----------
    model : Model
        A model with the terms of a rudder; those of the banks are left out.
    speed : float [m/s], optional
        Speed of the approach; default: one that suits the ship.
    turn_deg, zigzags : float [deg], pairs of float [deg]
        Rudder angle of the circles; rudder angle and heading change of each zigzag.
    dt : float [s], optional
        Step; default: a hundred and twentieth of the time for a ship length.
    """
    ship = TrialShip.of(model, speed, dt)
    asked = [{"rudder": turn_deg}, *({"rudder": rudder, "heading": heading} for rudder, heading in zigzags)]
    radians, notes = zip(*(ship.in_radians(**angles) for angles in asked), strict=True)
    (turn,), *pairs = ([math.degrees(angle) for angle in angles] for angles in radians)
    turning = {f"{angle:+g}": ship.turn(angle) for angle in (turn, -turn)}
    both = [(sign * rudder, heading) for rudder, heading in pairs for sign in (1, -1)]
    tacking = {f"{rudder:+g}/{heading:g}": ship.zigzag(rudder, heading) for rudder, heading in both}
    return Trials(ship.model, ship.speed, turning, tacking, tuple(dict.fromkeys(chain(*notes))))


@dataclass(frozen=True)
class TrialShip:
    model: Model
    speed: float
    dt: float
    notes: tuple[str, ...]
    duration: float | None = None

    @classmethod
    def of(
        cls, model: Model, speed: float | None, dt: float | None = None, duration: float | None = None
    ) -> "TrialShip":
        u = voyage_defaults(model).speed if speed is None else finite_numbers(speed=speed)["speed"]
        if not u > 0:
            raise InputError(f"speed = {u} m/s of the approach must be over 0; give it in m/s")
        ship, hull = model.in_open_water(), model.configuration.ship
        own = (note for note in ship.notes if note != ship.bank_note)
        notes = [*own, *extrapolation(ship.data_range, {"speed": u})]
        propeller, steady = ship.configuration.propeller, steady_revolutions(ship, u)
        if steady is not None and propeller is not None and ship.surge_inertia > 0:
            were = f"the model's own, {propeller.revolutions:.3g}, are for another"
            notes.append(f"{steady:.3g} revolutions a second keep the approach speed; {were}")
            running = replace(ship.configuration, propeller=replace(propeller, revolutions=steady))
            ship = replace(ship, configuration=running)
        if not ship.surge_inertia > 0:
            notes.append("the speed is held: the model has no inertia in surge (a_udot)")
        if model.configuration.steering is None and hull.length < MODEL_LENGTH:
            notes.append("the gear is as slow as a ship's, and this is a model's size: give [steering] its rate")
        if model.terms.has_bank:
            notes.append("the terms of the banks are left out: open water, and the depth that the others hold for")
        return cls(ship, u, hull.length / u / STEPS_A_LENGTH if dt is None else dt, tuple(notes), duration)

    def in_radians(self, **angles: float) -> tuple[list[float], tuple[str, ...]]:
        """Return angles in radians, and notes on those that are too small to turn a ship unless they are in radians."""
        limit, notes, found = self.model.configuration.gear.limit_deg, list(self.notes), []
        for name, angle in finite_numbers(**angles).items():
            if 0 < abs(angle) < LEAST_DEG:
                notes.append(f"the {name} of {angle:g} was read in radians, {math.degrees(angle):.4g} degrees")
                angle = math.degrees(angle)
            if name == "rudder" and not LEAST_DEG <= abs(angle) <= limit * (1 + 1e-9):
                raise InputError(f"a rudder of {angle:g} degrees: choose {LEAST_DEG:g} to the gear's {limit:g}")
            found.append(math.radians(angle))
        return found, tuple(notes)

    def turn(self, rudder: float) -> Turning:
        (angle,), notes = self.in_radians(rudder=rudder)
        return Turning.of(self.sail(ConstantRudder(angle)), notes)

    def zigzag(self, rudder: float, heading: float) -> ZigzagTest:
        angles, notes = self.in_radians(rudder=rudder, heading=heading)
        voyage = self.sail(law := Zigzag(*angles))
        return ZigzagTest(tuple(map(math.degrees, overshoots(voyage, law))), voyage, notes)

    def sail(self, law: ControlLaw, lengths: float = LENGTHS) -> Voyage:
        time = lengths * self.model.configuration.ship.length / self.speed if self.duration is None else self.duration
        options: Any = {"surge": "free" if self.model.surge_inertia > 0 else "held", "controller": law}
        return simulate(self.model, u=self.speed, duration=time, dt=self.dt, contact="none", **options)


def overshoots(voyage: Voyage, zigzag: Zigzag) -> tuple[float, ...]:
    """Return the further heading change after each order that reversed the rudder [rad].

    Raises an InputError if the voyage ends before the first overshoot does.

    Parameters
    ----------
    voyage, zigzag : Voyage, Zigzag
        A voyage in open water, and its controller.
    """
    turned = np.abs(voyage.psi - voyage.psi[0])
    crossings = np.flatnonzero(np.diff(turned >= zigzag.heading)) + 1
    # Each excursion from its order until the heading has come back; the last may be unfinished.
    excursions = zip(crossings[::2], crossings[1::2], strict=False)
    angles = tuple(float(turned[begun:back].max() - zigzag.heading) for begun, back in excursions)
    if not angles:
        raise InputError("the voyage ends before the heading comes back once; sail on for longer")
    return angles


@dataclass(frozen=True)
class EngineReversal(WithoutMemory):
    """A law for the propeller: from revolutions ahead to revolutions astern, after a delay and evenly in time."""

    ahead: float  # Revolutions [1/s]
    astern: float
    delay: float  # [s]
    reversal: float  # [s]

    def parameters(self) -> Mapping[str, Any]:
        return vars(self)

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
        lengths = self.to_dict()["track_reach_over_length"]
        return (
            f"The ship stops in {self.time:.0f} s on {self.track_reach:.4g} m ({lengths:.1f} L; IMO allows "
            f"{LARGEST_TRACK_REACH:g} L), {self.head_reach:.4g} m ahead and {self.side_reach:+.3g} m to starboard."
        )

    def to_dict(self) -> dict[str, Any]:
        values = {name: getattr(self, name) for name in ("track_reach", "head_reach", "side_reach", "time")}
        return {**values, "track_reach_over_length": self.track_reach / self.voyage.configuration.ship.length}


@accept_aliases
def crash_stop(
    model: Model, speed: float | None = None, revolutions: float | None = None, delay: float = 0.0,
    reversal: float = 0.0,
) -> StoppingTest:  # fmt: skip
    """Simulate a stopping test in open water, rudder amidships (IMO resolution MSC.137(76), 2002).

    Its side reach is that of the transverse thrust, which ``with_transverse_thrust`` adds to a model.

    >>> tanker = nw.published("yasukawa2015_kvlcc2_full")
    >>> round(nw.crash_stop(tanker, revolutions=-1.0, delay=10.0, reversal=60.0).time)
    1184

    Raises an InputError if the thrust astern or a surge inertia is unknown, a time is negative, or it does not stop.

    Parameters
    ----------
    model, speed : Model, float [m/s], optional
        As for ``sail_trials``.
    revolutions : float [1/s], optional
        Revolutions astern, below 0; default: as many as on the approach.
    delay, reversal : float [s]
        Time from the order until the revolutions begin to change, and time of that change.
    """
    if not model.terms.propelled or not model.surge_inertia > 0:
        needs = "a stopping test needs terms of a propeller and an inertia in surge"
        raise InputError(f"{needs}, as nw.MMG has; take such a ship: nw.published('estimated_kcs')")
    ship = TrialShip.of(model, speed)
    ahead = ship.model.configuration.values()["revolutions"]
    given = {"revolutions": -ahead if revolutions is None else revolutions, "delay": delay, "reversal": reversal}
    numbers = finite_numbers(**given)
    if not numbers["revolutions"] < 0 or min(numbers["delay"], numbers["reversal"]) < 0:
        raise InputError(f"revolutions astern are below 0, delay and reversal are from 0 s; {given} are not")
    law = EngineReversal(ahead, numbers["revolutions"], numbers["delay"], numbers["reversal"])
    voyage = ship.sail(law, STOPPING_LENGTHS)
    if not voyage.u.min() < 0:
        raise InputError(f"the ship makes {voyage.u[-1]:.2g} m/s after {voyage.t[-1]:.0f} s; give more revolutions")
    # The forces of the hull are those ahead, so that the test ends at the first step astern.
    last = int(np.argmax(voyage.u < 0))
    voyage = ship.sail(law, voyage.t[last] * ship.speed / ship.model.configuration.ship.length)
    track = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(voyage.x), np.diff(voyage.y)))])
    columns = track, voyage.x, voyage.y, voyage.t
    reach, ahead_of, aside, time = (float(np.interp(0.0, voyage.u[:-3:-1], c[:-3:-1]) - c[0]) for c in columns)
    pushed = TRANSVERSE_THRUST.names(model.terms)[0] in model.terms.names
    return StoppingTest(reach, ahead_of, aside, time, voyage, ship.notes + (() if pushed else (NO_TRANSVERSE_THRUST,)))
