"""Standard manoeuvring trials: turning circles and zigzags in open water, and their measures."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.results import BaseResult
from narrows.model.data_range import extrapolation
from narrows.model.model import Model
from narrows.simulation.controllers import ConstantRudder, ControlLaw, Zigzag
from narrows.simulation.initial_state import steady_ahead, voyage_defaults
from narrows.simulation.inputs import finite_numbers
from narrows.simulation.voyage import Voyage, simulate

if TYPE_CHECKING:
    import pandas as pd

STEPS_A_LENGTH = 120

# Length [m] below which a hull counts as a model.
MODEL_LENGTH = 30.0

# Duration of a trial, in ship lengths at the approach speed.
TURNING_LENGTHS, ZIGZAG_LENGTHS = 40.0, 40.0

# Angles below this [deg] were probably given in radians.
LEAST_DEG = 1.0

# Measures of a turning circle, at these changes of heading.
MEASURES = ("advance", "transfer", "tactical_diameter")
QUARTER, HALF = np.pi / 2, np.pi


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
        if turned.max() < HALF:
            by, why = np.degrees(turned.max()), voyage.outcome.sentence.partition(". ")[0].removesuffix(".")
            raise InputError(f"the ship turned by {by:.0f} degrees of the 180 asked for: {why}; sail slower or longer")
        x, y = (column - column[0] for column in (voyage.x, voyage.y))
        first = slice(0, int(np.argmax(turned >= HALF)) + 1)
        along, across = (np.interp((QUARTER, HALF), turned[first], np.abs(column[first])) for column in (x, y))
        return cls(float(along[0]), float(across[0]), float(across[1]), voyage, notes)

    def summary(self) -> str:
        ratios = self.over_length()
        parts = (
            f"{name.replace('_', ' ')} {ratios[f'{name}_over_length']:.2f} L ({getattr(self, name):.4g} m)"
            for name in MEASURES
        )
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

    def __repr__(self) -> str:
        return f"<Trials of {self.model.configuration.ship.name or 'a ship'} at {self.speed:g} m/s>"

    def summary(self) -> str:
        circles = [
            f"Rudder {order} degrees: advance {measures['advance_over_length']:.2f} L, tactical diameter "
            f"{measures['tactical_diameter_over_length']:.2f} L."
            for order, measures in self._circles().items()
        ]
        zigzags = [f"Zigzag {order}{test.summary().removeprefix('Zigzag')}" for order, test in self.zigzags.items()]
        return "\n".join(circles + zigzags)

    def to_dict(self) -> dict[str, Any]:
        return {
            "speed": self.speed,
            "turning": self._circles(),
            "zigzags": {order: test.to_dict() for order, test in self.zigzags.items()},
            "summary": self.summary(),
            "notes": list(self.notes),
        }

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the measures as a table: one row for each manoeuvre and measure."""
        import pandas as pd

        measured = {f"turning {order}": measures for order, measures in self._circles().items()}
        for order, test in self.zigzags.items():
            numbered = enumerate(test.overshoots_deg, start=1)
            measured[f"zigzag {order}"] = {f"overshoot_{number}_deg": angle for number, angle in numbered}
        rows = {(manoeuvre, name): value for manoeuvre, part in measured.items() for name, value in part.items()}
        return pd.Series(rows, name="value").rename_axis(["manoeuvre", "measure"]).to_frame()

    def _circles(self) -> dict[str, dict[str, float]]:
        return {order: circle.over_length() for order, circle in self.turning.items()}


@accept_aliases
def turning_circle(
    model: Model, rudder: float = 35.0, speed: float | None = None, dt: float | None = None,
    duration: float | None = None,
) -> Turning:  # fmt: skip
    """Simulate a turning circle in open water.

    Raises an InputError as ``sail_trials`` does.

    Parameters
    ----------
    model : Model
        A model with the terms of a rudder; those of the banks are left out.
    rudder : float [deg]
        Angle, positive if it turns the bow to starboard.
    speed, dt : float [m/s, s], optional
        As for ``sail_trials``.
    duration : float [s], optional
        Time from the order; default: 40 ship lengths at the approach speed.
    """
    return TrialShip.of(model, speed, dt, duration).turn(rudder)


@accept_aliases
def zigzag(
    model: Model, rudder: float = 10.0, heading: float = 10.0, speed: float | None = None, dt: float | None = None,
    duration: float | None = None,
) -> ZigzagTest:  # fmt: skip
    """Simulate a zigzag in open water.

    Raises an InputError as ``sail_trials`` does.

    Parameters
    ----------
    model : Model
        A model with the terms of a rudder; those of the banks are left out.
    rudder : float [deg]
        Angle; negative for a first order to port.
    heading : float [deg]
        Heading change at which the rudder is reversed.
    speed, dt, duration : float [m/s, s], optional
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
    turn_deg : float [deg]
        Rudder angle of the circles.
    zigzags : pairs of float [deg]
        Rudder angle and heading change.
    dt : float [s], optional
        Step; default: a hundred and twentieth of the time for a ship length.
    """
    ship = TrialShip.of(model, speed, dt)
    ship.check(rudder=turn_deg)
    for rudder, heading in zigzags:
        ship.check(rudder=rudder, heading=heading)
    turning = {f"{sign * turn_deg:+g}": ship.turn(sign * turn_deg) for sign in (1, -1)}
    tacking = {
        f"{sign * rudder:+g}/{heading:g}": ship.zigzag(sign * rudder, heading)
        for rudder, heading in zigzags
        for sign in (1, -1)
    }
    return Trials(ship.model, ship.speed, turning, tacking, ship.notes)


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
        notes = [note for note in ship.notes if note != ship.bank_note]
        notes += extrapolation(ship.data_range, {"speed": u})
        ship, steady = steady_ahead(ship, u)
        notes += [steady] * bool(steady)
        if not ship.surge_inertia > 0:
            notes.append("the speed is held: the model has no inertia in surge (a_udot)")
        if model.configuration.steering is None and hull.length < MODEL_LENGTH:
            notes.append("the gear is as slow as a ship's, and this is a model's size: give [steering] its rate")
        if model.terms.has_bank:
            notes.append("the terms of the banks are left out: open water, and the depth that the others hold for")
        return cls(ship, u, hull.length / u / STEPS_A_LENGTH if dt is None else dt, tuple(notes), duration)

    def check(self, **angles: float) -> None:
        limit = self.model.configuration.gear.limit_deg
        for name, angle in finite_numbers(**angles).items():
            if name == "rudder" and not 0 < abs(angle) <= limit:
                raise InputError(
                    f"a rudder of {angle:g} degrees is not between 0 and the gear's {limit:g}; choose another"
                )
            if 0 < abs(angle) < LEAST_DEG:
                raise InputError(f"a {name} of {angle:g} degrees turns no ship; give it in degrees, not in radians")

    def turn(self, rudder: float) -> Turning:
        self.check(rudder=rudder)
        return Turning.of(self.sail(ConstantRudder(math.radians(rudder)), TURNING_LENGTHS), self.notes)

    def zigzag(self, rudder: float, heading: float) -> ZigzagTest:
        self.check(rudder=rudder, heading=heading)
        law = Zigzag(math.radians(rudder), math.radians(heading))
        voyage = self.sail(law, ZIGZAG_LENGTHS)
        return ZigzagTest(tuple(math.degrees(angle) for angle in overshoots(voyage, law)), voyage, self.notes)

    def sail(self, law: ControlLaw, lengths: float) -> Voyage:
        usual = lengths * self.model.configuration.ship.length / self.speed
        longest = usual if self.duration is None else self.duration
        surge: Any = "free" if self.model.surge_inertia > 0 else "held"
        return simulate(
            self.model, u=self.speed, duration=longest, dt=self.dt, contact="none", surge=surge, controller=law
        )


def overshoots(voyage: Voyage, zigzag: Zigzag) -> tuple[float, ...]:
    """Return the further heading change after each order that reversed the rudder [rad].

    Raises an InputError if the voyage ends before the first overshoot does.

    Parameters
    ----------
    voyage : Voyage
        A voyage in open water under the zigzag.
    zigzag : Zigzag
        The zigzag's order.
    """
    turned = np.abs(voyage.psi - voyage.psi[0])
    crossings = np.flatnonzero(np.diff(turned >= zigzag.heading)) + 1
    # Each excursion from its order until the heading has come back; the last may be unfinished.
    angles = tuple(
        float(turned[begun:back].max() - zigzag.heading)
        for begun, back in zip(crossings[::2], crossings[1::2], strict=False)
    )
    if not angles:
        raise InputError("the voyage ends before the heading comes back once; sail on for longer")
    return angles
