"""Pilots by name, none of whom knows the coefficients of the ship that is drawn: what is tried at every place."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.control.helmsman import CAP_DEG, DELAY, Helmsman
from narrows.control.regulator import LEAD, UNWINDING
from narrows.control.regulator_law import FELT, HeldLine, Regulator
from narrows.control.stacked_regulators import Tightness, stacked_gains
from narrows.control.track_pilot import FELT as TRACKED
from narrows.control.track_pilot import track_gains
from narrows.safety.likely_courses import LikelyCourses
from narrows.simulation.controllers import Autopilot, ControlLaw
from narrows.simulation.ship import SimulatedShip

# What a pilot goes by, by name: arrays over offsets and speeds, or columns of them.
Numbers = dict[str, np.ndarray]
# Rudder [rad] of a sensible helm by hand for half a beam off, a heading off [rad] and a yaw rate in ship lengths.
SENSIBLE = (0.56, 8.0, 7.7)
# Times of a ship length in which a helm by hand trims as much as it orders at once.
TRIMMED = 10.0


# y [m] and u [m/s] of each trial, and what holds the drawn ship there: rudder, psi [rad], v [m/s]; arrays (n,).
Course = Mapping[str, Any]


@dataclass(frozen=True)
class Pilot:
    """Who is tried: made for the most likely coefficients, one for all samples."""

    words: str  # Who it is, as a sentence of the answer has it
    tunings: tuple[Any, ...]  # What may be chosen of it by trials; the usual one first
    # Gives what it goes by at offsets and speeds, of the most likely courses and a tuning
    numbers: Callable[[LikelyCourses, Any], Numbers]
    # Gives the law of many trials, of the ship, what it goes by in each, and the course of each
    law: Callable[[SimulatedShip, Numbers, Course], ControlLaw]


def _regulator_numbers(courses: LikelyCourses, tuning: Tightness) -> Numbers:
    """Gains, and rudder, heading and drift of the most likely course."""
    gains = courses.filled(stacked_gains(courses.ship, courses.values, courses.course, tuning))
    return {**{f"by_{name}": gains[..., i] for i, name in enumerate(FELT)}, **courses.held()}


def _regulator(ship: SimulatedShip, numbers: Numbers, course: Course) -> ControlLaw:
    """The regulator; of the drawn ship only y and u are used."""
    return regulator_of(ship, [numbers[f"by_{name}"] for name in FELT], {**numbers, "y": course["y"]}, course["u"])


def _track_numbers(courses: LikelyCourses, tuning: None) -> Numbers:
    """Gains, one set a speed."""
    rows = [track_gains(courses.ship, speed, **felt) for speed, felt in courses.on_the_centreline()]
    gains = np.broadcast_to(np.array(rows), (len(courses.offsets), len(rows), len(TRACKED)))
    return {f"by_{name}": gains[..., index] for index, name in enumerate(TRACKED)}


def _track_pilot(ship: SimulatedShip, numbers: Numbers, course: Course) -> ControlLaw:
    """The autopilot about the course of the drawn ship."""
    by_y, by_psi, by_v, by_r = (numbers[f"by_{name}"] for name in TRACKED)
    return Autopilot(course["y"], (by_y, by_psi, by_v, by_r), course["rudder"], course["psi"], course["v"])


def _hand_numbers(courses: LikelyCourses, share: float) -> Numbers:
    """A share of sensible gains, and rudder and heading of the most likely course."""
    hull, held = courses.ship.model.configuration.ship, courses.held()
    time = hull.length / np.broadcast_to(courses.speeds, held["rudder"].shape)
    by_y, by_psi, by_r = (share * gain for gain in SENSIBLE)
    gains = {"by_y": by_y / (hull.beam / 2) + 0 * time, "by_psi": by_psi + 0 * time, "by_r": by_r * time}
    return {**gains, "by_trim": gains["by_y"] / (TRIMMED * time), "rudder": held["rudder"], "psi": held["psi"]}


def _hand(ship: SimulatedShip, numbers: Numbers, course: Course) -> ControlLaw:
    """The helmsman; of the drawn ship only y is used."""
    gains = numbers["by_y"], numbers["by_psi"], numbers["by_r"]
    return Helmsman(course["y"], gains, numbers["by_trim"], numbers["rudder"], numbers["psi"])


# Regulators that trust the bank of the most likely coefficients, beside the usual one.
TIGHTER = Tightness(8.0, knowing=True), Tightness(16.0, knowing=True), Tightness(32.0, 4.0, knowing=True)
# Pilots by name, the usual one first.
PILOTS = {
    "regulator": Pilot(
        "a regulator made for the most likely coefficients, as tight as holds most",
        (Tightness(), *TIGHTER), _regulator_numbers, _regulator,
    ),
    "track": Pilot(
        "a track pilot without an integral, made on the centreline for the most likely coefficients, and told what "
        "rudder holds the ship",
        (None,), _track_numbers, _track_pilot,
    ),
    "human": Pilot(
        f"a hand at the wheel: a look every {DELAY:g} s, an order in whole degrees, heard {DELAY:g} s later, of "
        f"{CAP_DEG:g} degrees at most",
        (1.0, 0.5, 0.25, 0.125), _hand_numbers, _hand,
    ),
}  # fmt: skip


def regulator_of(ship: SimulatedShip, gains: list[Any], held: Mapping[str, Any], made_for: Any) -> Regulator:
    """Return the regulator of many trials."""
    # gains (n,); held [m]; made_for (n,) [m/s]
    time = ship.model.configuration.ship.length / np.asarray(made_for)
    one, two, three, four, five, six = gains
    line = HeldLine(held["y"], (one, two, three, four, five, six), held["rudder"], held["psi"], held["v"])
    return Regulator((line,), made_for, LEAD * time, UNWINDING * time)
