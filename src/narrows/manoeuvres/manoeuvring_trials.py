"""The trials that ships are judged by: a turning circle to either side, zigzags to either side first."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.errors import InputError
from narrows.model.model import Model
from narrows.results import Shown
from narrows.simulation.controllers import ConstantRudder, Zigzag
from narrows.simulation.voyage import Voyage, simulate

if TYPE_CHECKING:
    import pandas as pd

STEPS_A_LENGTH = 120

# Below this [m] a hull is taken for a model's.
MODEL_LENGTH = 30.0

# Ship lengths at the approach speed that a trial lasts.
TURNING_LENGTHS, ZIGZAG_LENGTHS = 40.0, 40.0


@dataclass(frozen=True)
class Turning:
    """A turning circle, from where the rudder was ordered.

    Parameters
    ----------
    advance : float [m]
        Along the first course when the heading has changed by 90 degrees.
    transfer : float [m]
        Across it, then.
    tactical_diameter : float [m]
        Across it when the heading has changed by 180 degrees.
    """

    advance: float
    transfer: float
    tactical_diameter: float


@dataclass(frozen=True, repr=False)
class Trials(Shown):
    """Trials of one ship.

    Parameters
    ----------
    model : Model
        In open water.
    speed : float [m/s]
        Of the approach.
    turning : dict of str to (Voyage, Turning)
        By the order, as in ``+35``.
    zigzags : dict of str to (Voyage, tuple of float [rad])
        By rudder and heading, as in ``+10/10``, with the overshoots.
    notes : tuple of str
        What was assumed.
    """

    model: Model
    speed: float
    turning: dict[str, tuple[Voyage, Turning]]
    zigzags: dict[str, tuple[Voyage, tuple[float, ...]]]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<Trials of {self.model.configuration.ship.name or 'a ship'} at {self.speed:g} m/s>"

    def summary(self) -> str:
        """Say what was measured of each manoeuvre: a line each."""
        circles = [
            f"Rudder {order} degrees: advance {measures['advance_over_length']:.2f} L, tactical diameter "
            f"{measures['tactical_diameter_over_length']:.2f} L."
            for order, measures in self._circles().items()
        ]
        zigzags = [
            f"Zigzag {order}: overshoots {', '.join(f'{angle:.1f}' for angle in measures['overshoots_deg'])} degrees."
            for order, measures in self._zigzags().items()
        ]
        return "\n".join(circles + zigzags)

    def to_dict(self) -> dict[str, Any]:
        """Give the results by name, as ``trials --json`` prints them: lengths over the ship's, degrees."""
        return {
            "speed": self.speed,
            "turning": self._circles(),
            "zigzags": self._zigzags(),
            "summary": self.summary(),
            "notes": list(self.notes),
        }

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the measures as a table: a row for each manoeuvre and measure."""
        import pandas as pd

        circles = [
            (f"turning {order}", *pair) for order, measures in self._circles().items() for pair in measures.items()
        ]
        zigzags = [
            (f"zigzag {order}", f"overshoot_{number}_deg", angle)
            for order, measures in self._zigzags().items()
            for number, angle in enumerate(measures["overshoots_deg"], start=1)
        ]
        return pd.DataFrame(circles + zigzags, columns=["manoeuvre", "measure", "value"]).set_index(
            ["manoeuvre", "measure"]
        )

    def _circles(self) -> dict[str, dict[str, float]]:
        length = self.model.configuration.ship.length
        return {
            order: {
                "advance_over_length": circle.advance / length,
                "transfer_over_length": circle.transfer / length,
                "tactical_diameter_over_length": circle.tactical_diameter / length,
                "speed_over_approach": float(voyage.u[-1] / self.speed),
            }
            for order, (voyage, circle) in self.turning.items()
        }

    def _zigzags(self) -> dict[str, dict[str, list[float]]]:
        return {
            order: {"overshoots_deg": [math.degrees(angle) for angle in overshoot_angles]}
            for order, (_, overshoot_angles) in self.zigzags.items()
        }


def sail_trials(
    model: Model, speed: float, turn_deg: float = 35.0, zigzags: tuple[tuple[float, float], ...] = ((10, 10), (20, 20)),
    dt: float | None = None,
) -> Trials:  # fmt: skip
    """Sail turning circles and zigzags in open water.

    The speed is free where the model knows what resists its change, and held where it does not.

    Parameters
    ----------
    model : Model
        With the terms of a rudder; those of the banks are left out.
    speed : float [m/s]
        Of the approach.
    turn_deg : float [deg]
        Rudder of the circles.
    zigzags : pairs of float [deg]
        Rudder and heading.
    dt : float [s], optional
        Step; a hundred and twentieth of the time for a ship length unless given.

    Raises
    ------
    InputError
        Where the model has no rudder or the gear does not reach an angle, the speed or the step is not positive, or it
        does not turn far enough.
    """
    if not 0 < speed < math.inf:
        raise InputError(f"an approach at {speed} m/s is none; give its speed over 0")
    limit = model.configuration.gear.limit_deg
    for angle in (turn_deg, *(rudder for rudder, _ in zigzags)):
        if not 0 < angle <= limit:
            raise InputError(f"a rudder of {angle:g} degrees is not between 0 and the gear's {limit:g}; choose another")
    ship = model.in_open_water()
    free = ship.surge_inertia > 0
    pace = ship.configuration.ship.length / speed
    step = pace / STEPS_A_LENGTH if dt is None else dt
    options: dict[str, Any] = {"u": speed, "dt": step, "contact": "none", "surge": "free" if free else "held"}
    turning, tacking = {}, {}
    for sign in (1, -1):
        order = ConstantRudder(math.radians(sign * turn_deg))
        voyage = simulate(ship, duration=TURNING_LENGTHS * pace, controller=order, **options)
        turning[f"{sign * turn_deg:+g}"] = (voyage, turning_circle(voyage))
    for rudder, heading in zigzags:
        for sign in (1, -1):
            zigzag = Zigzag(math.radians(sign * rudder), math.radians(heading))
            voyage = simulate(ship, duration=ZIGZAG_LENGTHS * pace, controller=zigzag, **options)
            tacking[f"{sign * rudder:+g}/{heading:g}"] = (voyage, overshoots(voyage, zigzag))
    notes = () if free else ("the speed is held: nothing in the model says what resists its change",)
    if model.configuration.steering is None and model.configuration.ship.length < MODEL_LENGTH:
        notes = (*notes, "the gear is as slow as a ship's, and this is a model's size: give [steering] its rate")
    if ship is not model:
        notes = (*notes, "the terms of the banks are left out: open water, and the depth that the others hold for")
    return Trials(ship, speed, turning, tacking, notes)


def parse_zigzags(text: str) -> tuple[tuple[float, float], ...]:
    """Read ``10/10,20/20``."""
    # text [deg]
    try:
        pairs = [word.split("/") for word in text.split(",") if word]
        return tuple((float(rudder), float(heading)) for rudder, heading in pairs)
    except ValueError:
        raise InputError(f"--zigzags {text!r} is not understood; write 10/10,20/20, in degrees") from None


# What trials are read for: a turning circle's advance and diameter, a zigzag's overshoots.
QUARTER, HALF = np.pi / 2, np.pi


def turning_circle(voyage: Voyage) -> Turning:
    """Read a turning circle from a voyage that starts with the order, x along the first course.

    Parameters
    ----------
    voyage : Voyage
        In open water, under a held rudder.

    Returns
    -------
    Turning
        To either side, positive.

    Raises
    ------
    InputError
        Where the ship has not turned by 180 degrees.

    References
    ----------
    IMO (2002), resolution MSC.137(76), Standards for ship manoeuvrability.
    """
    turned = np.abs(voyage.psi - voyage.psi[0])
    if turned.max() < HALF:
        raise InputError(
            f"the ship turned by {np.degrees(turned.max()):.0f} degrees of the 180 asked for; sail on for longer"
        )
    x, y = (column - column[0] for column in (voyage.x, voyage.y))
    first = slice(0, int(np.argmax(turned >= HALF)) + 1)
    along, across = (np.interp((QUARTER, HALF), turned[first], np.abs(column[first])) for column in (x, y))
    return Turning(float(along[0]), float(across[0]), float(across[1]))


def overshoots(voyage: Voyage, zigzag: Zigzag) -> tuple[float, ...]:
    """Return how far the heading went on after each order that reversed the rudder [rad].

    Parameters
    ----------
    voyage : Voyage
        In open water, under the zigzag.
    zigzag : Zigzag
        Its order.

    Raises
    ------
    InputError
        Where the voyage ends before the first overshoot does.

    References
    ----------
    IMO (2002), resolution MSC.137(76), Standards for ship manoeuvrability.
    """
    heading = np.sign(zigzag.rudder) * (voyage.psi - voyage.psi[0])
    angles, side, row = [], 1.0, 0
    while True:
        over = np.flatnonzero(side * heading[row:] >= zigzag.heading)
        if not over.size:
            break
        row += int(over[0])
        back = np.flatnonzero(side * heading[row:] < zigzag.heading)
        if not back.size:
            break
        angles.append(float((side * heading[row : row + int(back[0])]).max() - zigzag.heading))
        row += int(back[0])
        side = -side
    if not angles:
        raise InputError("the voyage ends before the heading comes back once; sail on for longer")
    return tuple(angles)
