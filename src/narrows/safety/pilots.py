"""Pilots by name, none of whom knows the coefficients of the ship that is drawn: what is tried at every place."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from narrows.control.helmsman import CAP_DEG, DELAY, Helmsman
from narrows.control.regulator import LEAD, UNWINDING
from narrows.control.regulator_law import FELT, HeldLine, Regulator
from narrows.control.stacked_regulators import Tightness, stacked_gains
from narrows.control.track_pilot import track_gains
from narrows.safety.likely_courses import LikelyCourses
from narrows.simulation.controllers import Autopilot, ControlLaw
from narrows.simulation.ship import SimulatedShip

Numbers = dict[str, np.ndarray]
"""What a pilot goes by, by name: arrays over offsets and speeds, or columns of them."""
SENSIBLE = (0.56, 8.0, 7.7)
"""Rudder [rad] of a sensible helm by hand for half a beam off, a heading off [rad] and a yaw rate in ship lengths."""
TRIMMED = 10.0
"""Times of a ship length in which a helm by hand trims as much as it orders at once."""


class Pilot(Protocol):
    """Who is tried: made for the most likely coefficients, one for all samples."""

    @property
    def words(self) -> str:
        """Who it is, as a sentence of the answer has it."""

    @property
    def tunings(self) -> tuple[Any, ...]:
        """What may be chosen of it by trials."""

    def numbers(self, courses: LikelyCourses, tuning: Any) -> Numbers:
        """Return what it goes by at offsets and speeds.

        Parameters
        ----------
        courses : LikelyCourses
            Of the most likely coefficients.
        tuning : Any
            One of its own.
        """

    def law(self, ship: SimulatedShip, numbers: Numbers, course: Mapping[str, Any]) -> ControlLaw:
        """Return the law of many trials.

        Parameters
        ----------
        ship : SimulatedShip
            The model.
        numbers : mapping of str to array (n,)
            What it goes by, for each trial.
        course : mapping of str to array (n,)
            y [m] and u [m/s] of the trial, and what holds the drawn ship there: rudder, psi [rad], v [m/s].
        """


@dataclass(frozen=True)
class RegulatorPilot:
    """The regulator of the most likely coefficients, as tight as holds most."""

    @property
    def words(self) -> str:
        """Who it is."""
        return "a regulator made for the most likely coefficients, as tight as holds most"

    @property
    def tunings(self) -> tuple[Tightness, ...]:
        """The usual regulator, and tighter ones that trust the bank of the most likely coefficients."""
        tighter = Tightness(8.0, knowing=True), Tightness(16.0, knowing=True), Tightness(32.0, 4.0, knowing=True)
        return Tightness(), *tighter

    def numbers(self, courses: LikelyCourses, tuning: Tightness) -> Numbers:
        """Return gains, and rudder, heading and drift of the most likely course.

        Parameters
        ----------
        courses : LikelyCourses
            Of the most likely coefficients.
        tuning : Tightness
            How hard it holds the line.
        """
        gains = courses.filled(stacked_gains(courses.ship, courses.values, courses.course, tuning))
        return {**{f"by_{name}": gains[..., i] for i, name in enumerate(FELT)}, **courses.held()}

    def law(self, ship: SimulatedShip, numbers: Numbers, course: Mapping[str, Any]) -> ControlLaw:
        """Return the regulator.

        Parameters
        ----------
        ship : SimulatedShip
            The model.
        numbers : mapping of str to array (n,)
            What it goes by.
        course : mapping of str to array (n,)
            Of the drawn ship; only y and u are used.
        """
        return regulator_of(ship, [numbers[f"by_{name}"] for name in FELT], {**numbers, "y": course["y"]}, course["u"])


@dataclass(frozen=True)
class TrackPilot:
    """The track pilot of earlier envelopes, without an integral, told what holds each sample."""

    @property
    def words(self) -> str:
        """Who it is."""
        return (
            "a track pilot without an integral, made on the centreline for the most likely coefficients, and told what "
            "rudder holds the ship"
        )

    @property
    def tunings(self) -> tuple[None]:
        """None but its own."""
        return (None,)

    def numbers(self, courses: LikelyCourses, tuning: None) -> Numbers:
        """Return its gains, one set a speed.

        Parameters
        ----------
        courses : LikelyCourses
            Of the most likely coefficients.
        tuning : None
            None.
        """
        rows = [track_gains(courses.ship, speed, **felt) for speed, felt in courses.on_the_centreline()]
        gains = np.broadcast_to(np.array(rows), (len(courses.offsets), len(rows), 4))
        return {f"by_{name}": gains[..., index] for index, name in enumerate(("y", "psi", "v", "r"))}

    def law(self, ship: SimulatedShip, numbers: Numbers, course: Mapping[str, Any]) -> ControlLaw:
        """Return the autopilot about the course of the drawn ship.

        Parameters
        ----------
        ship : SimulatedShip
            The model.
        numbers : mapping of str to array (n,)
            Its gains.
        course : mapping of str to array (n,)
            Of the drawn ship.
        """
        by_y, by_psi, by_v, by_r = (numbers[f"by_{name}"] for name in ("y", "psi", "v", "r"))
        return Autopilot(course["y"], (by_y, by_psi, by_v, by_r), course["rudder"], course["psi"], course["v"])


@dataclass(frozen=True)
class HumanPilot:
    """A helm by hand: a look every few seconds, whole degrees, a cap."""

    @property
    def words(self) -> str:
        """Who it is."""
        return (
            f"a hand at the wheel: a look every {DELAY:g} s, an order in whole degrees, heard {DELAY:g} s later, of "
            f"{CAP_DEG:g} degrees at most"
        )

    @property
    def tunings(self) -> tuple[float, ...]:
        """Shares of what is sensible."""
        return 1.0, 0.5, 0.25, 0.125

    def numbers(self, courses: LikelyCourses, tuning: float) -> Numbers:
        """Return its gains, and rudder and heading of the most likely course.

        Parameters
        ----------
        courses : LikelyCourses
            Of the most likely coefficients.
        tuning : float [1]
            Share of what is sensible.
        """
        hull, held = courses.ship.model.configuration.ship, courses.held()
        time = hull.length / np.broadcast_to(courses.speeds, held["rudder"].shape)
        by_y, by_psi, by_r = (tuning * gain for gain in SENSIBLE)
        gains = {"by_y": by_y / (hull.beam / 2) + 0 * time, "by_psi": by_psi + 0 * time, "by_r": by_r * time}
        return {**gains, "by_trim": gains["by_y"] / (TRIMMED * time), "rudder": held["rudder"], "psi": held["psi"]}

    def law(self, ship: SimulatedShip, numbers: Numbers, course: Mapping[str, Any]) -> ControlLaw:
        """Return the helmsman.

        Parameters
        ----------
        ship : SimulatedShip
            The model.
        numbers : mapping of str to array (n,)
            What it goes by.
        course : mapping of str to array (n,)
            Of the drawn ship; only y is used.
        """
        gains = numbers["by_y"], numbers["by_psi"], numbers["by_r"]
        return Helmsman(course["y"], gains, numbers["by_trim"], numbers["rudder"], numbers["psi"])


PILOTS: dict[str, Pilot] = {"regulator": RegulatorPilot(), "track": TrackPilot(), "human": HumanPilot()}
"""Pilots by name, the usual one first."""


def regulator_of(ship: SimulatedShip, gains: list[Any], held: Mapping[str, Any], made_for: Any) -> Regulator:
    """Return the regulator of many trials (ours).

    Parameters
    ----------
    ship : SimulatedShip
        The model.
    gains : six arrays (n,)
        For what ``FELT`` names.
    held : mapping of str to array (n,)
        y [m], rudder, psi [rad] and v [m/s] that are held, at the speed that they are for.
    made_for : float or array (n,) [m/s]
        That speed.
    """
    time = ship.model.configuration.ship.length / np.asarray(made_for)
    one, two, three, four, five, six = gains
    line = HeldLine(held["y"], (one, two, three, four, five, six), held["rudder"], held["psi"], held["v"])
    return Regulator((line,), made_for, LEAD * time, UNWINDING * time)
