"""The trials that ships are judged by: a turning circle to either side, zigzags to either side first."""

from dataclasses import dataclass
from math import degrees, radians
from typing import Any

from narrows.errors import InputError
from narrows.model import Model
from narrows.simulation.manoeuvres import Turning, overshoots, turning_circle
from narrows.simulation.steering import Held, Zigzag
from narrows.simulation.voyage import Voyage, simulate

TURNING_LENGTHS, ZIGZAG_LENGTHS = 40.0, 40.0
"""Ship lengths at the approach speed that a trial lasts."""


@dataclass(frozen=True)
class Trials:
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

    def summary(self) -> dict[str, Any]:
        """Return the results as plain values: lengths over the ship's, degrees."""
        length = self.model.setting.ship.length
        return {
            "speed": self.speed,
            "turning": {
                order: {
                    "advance_over_length": own.advance / length,
                    "transfer_over_length": own.transfer / length,
                    "tactical_diameter_over_length": own.tactical_diameter / length,
                    "speed_over_approach": float(voyage.u[-1] / self.speed),
                }
                for order, (voyage, own) in self.turning.items()
            },
            "zigzags": {
                order: {"overshoots_deg": [degrees(angle) for angle in own]} for order, (_, own) in self.zigzags.items()
            },
            "notes": list(self.notes),
        }


def sail_trials(
    model: Model, speed: float, turn_deg: float = 35.0, zigzags: tuple[tuple[float, float], ...] = ((10, 10), (20, 20)),
    dt: float = 0.05,
) -> Trials:  # fmt: skip
    """Sail turning circles and zigzags in open water (ours).

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
    dt : float [s]
        Step.

    Raises
    ------
    InputError
        Where the model has no rudder, the speed is not positive, or she does not turn far enough.
    """
    if not speed > 0:
        raise InputError(f"an approach at {speed} m/s is none; give its speed over 0")
    ship = model.in_open_water()
    free = ship.surge_inertia > 0
    options: dict[str, Any] = {"u": speed, "dt": dt, "contact": "none", "surge": "free" if free else "held"}
    pace = ship.setting.ship.length / speed
    turning, tacking = {}, {}
    for sign in (1, -1):
        order = Held(radians(sign * turn_deg))
        voyage = simulate(ship, duration=TURNING_LENGTHS * pace, helm=order, **options)
        turning[f"{sign * turn_deg:+g}"] = (voyage, turning_circle(voyage))
    for rudder, heading in zigzags:
        for sign in (1, -1):
            zigzag = Zigzag(radians(sign * rudder), radians(heading))
            voyage = simulate(ship, duration=ZIGZAG_LENGTHS * pace, helm=zigzag, **options)
            tacking[f"{sign * rudder:+g}/{heading:g}"] = (voyage, overshoots(voyage, zigzag))
    notes = () if free else ("the speed is held: nothing in the model says what resists its change",)
    if ship is not model:
        notes = (*notes, "the terms of the banks are left out: open water, and the depth that the others hold for")
    return Trials(ship, speed, turning, tacking, notes)


def parse_zigzags(text: str) -> tuple[tuple[float, float], ...]:
    """Read ``10/10,20/20`` (ours).

    Parameters
    ----------
    text : str
        Rudder and heading [deg].

    Raises
    ------
    InputError
        Where it is not that.
    """
    try:
        pairs = [word.split("/") for word in text.split(",") if word]
        return tuple((float(rudder), float(heading)) for rudder, heading in pairs)
    except ValueError:
        raise InputError(f"--zigzags {text!r} is not understood; write 10/10,20/20, in degrees") from None
