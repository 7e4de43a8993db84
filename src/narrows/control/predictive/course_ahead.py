"""The course that a helm holds at the speed of the moment, and the best linear helm about it, place by place."""

from collections.abc import Mapping
from contextlib import suppress

import numpy as np

from narrows.control.predictive.line_frame import RUDDER, over_interval
from narrows.control.predictive.linear_quadratic import Weights, regulator_of
from narrows.control.predictive.push_estimate import BankSpread
from narrows.control.predictive.steady_track import WAYS, SteadyTrack, steady_track
from narrows.control.predictive.uncertainty_margin import margins_of
from narrows.control.predictive.water_ahead import WaterAhead
from narrows.errors import InputError
from narrows.simulation.ship import SimulatedShip

# Of the way to a bank, up to which its forces are told, and places between the banks at which they are.
FURTHEST, SHARES = 0.9, 61
# Change of speed [1] from which steady courses are found anew.
OTHER_SPEED = 0.02

# Gains of the best linear helm (5,), and what a state off costs it for ever, (5, 5).
Regulated = tuple[np.ndarray, np.ndarray]


class CourseAhead:
    """The steady course along a line, found anew where the speed has changed."""

    def __init__(
        self, ship: SimulatedShip, water: WaterAhead, y: float, u: float, margin: float,
        positions: Mapping[str, float], weights: Weights, interval: float,
    ) -> None:  # fmt: skip
        self.ship, self.water, self.y, self.margin = ship, water, y, margin
        self.positions, self.weights, self.interval = dict(positions), weights, interval
        self._start(u, steady_track(ship, water, y, u, margin, positions))
        self._usual = self._regulated(self.narrowest)
        self.spread = self._spread()

    def _start(self, u: float, track: SteadyTrack) -> None:
        self.speed, self.track = u, track
        self._known: dict[tuple[int, int], Regulated] = {}

    @property
    def narrowest(self) -> int:
        """The number of the place where the course leaves the least room."""
        there, off = self.water.at(self.track.places), self.track.states[0, :, 0]
        return int(np.minimum(there["keel_starboard"] - off, there["keel_port"] + off).argmin())

    def at_speed(self, u: float) -> SteadyTrack:
        """Return the course at a speed; where none is found, as it was before."""
        # u [m/s]
        if u > 0 and abs(u - self.speed) > OTHER_SPEED * self.speed:
            with suppress(InputError):
                self._start(u, steady_track(self.ship, self.water, self.y, u, self.margin, self.positions))
        return self.track

    def regulated(self, x: float, way: float) -> Regulated:
        """Return the best linear helm about the course at a place; where none holds, that of the narrowest."""
        # x [m]
        place = self.track.nearest(x), round(way * (WAYS - 1))
        if place not in self._known:
            try:
                self._known[place] = self._regulated(*place)
            except InputError:
                self._known[place] = self._usual
        return self._known[place]

    def _regulated(self, place: int, way: int = 0) -> Regulated:
        (A,), (integral,) = over_interval(self.track.slopes[way, place : place + 1], self.interval)
        return regulator_of(A, integral[:, RUDDER], self.weights)

    def margins(self, intervals: int, confidence: float) -> np.ndarray:
        """Return the margins of clearance after each interval of a plan [m], by where the course has the least room."""
        place, (gains, _) = self.narrowest, self._usual
        steady = self.track.states[0, place]
        (A,), (integral,) = over_interval(self.track.slopes[0, place : place + 1], self.interval)
        off = np.zeros(len(steady))
        off[0] = np.copysign(self.ship.model.configuration.ship.beam / 2, steady[0])
        states = [steady + off]
        for _ in range(intervals):
            off = (A - np.outer(integral[:, RUDDER], gains)) @ off
            states.append(steady + off)
        recovery = np.array(states)
        by_coefficient = self._by_coefficient(place, recovery)
        model = self.ship.model
        return margins_of(model, (A, integral), by_coefficient, gains, self.margin, confidence)

    def _by_coefficient(self, place: int, states: np.ndarray) -> np.ndarray:
        there = self.water.at(self.track.places[place : place + 1])
        section = {} if self.water.straight else {name: float(there[name][0]) for name in ("width", "depth")}
        values = {**self.ship.values(**self.positions), **section}
        y, psi, v, r, rudder = states.T
        at = {"y": y - there["middle"][0], "psi": psi, "u": self.speed, "v": v, "r": r, "rudder": rudder}
        return self.ship.linearisation(values).coefficients({**at, **self.positions})

    def _spread(self) -> BankSpread:
        """How far the bank's forces may be off, by the covariance, where the course has the least room."""
        model, place = self.ship.model, self.narrowest
        there = self.water.at(self.track.places[place : place + 1])
        half, beam = float(there["width"][0]) / 2, model.configuration.ship.beam
        most = (half - beam / 2) / half
        furthest = FURTHEST * most
        from_bank = [k for k, term in enumerate(model.terms.terms) if term.from_bank]
        if model.covariance is None or not from_bank:
            return BankSpread(furthest, np.zeros((SHARES, 2)))
        states = np.zeros((SHARES, 5))
        states[:, 0] = np.linspace(-furthest, furthest, SHARES) * half + there["middle"][0]
        by_coefficient = self._by_coefficient(place, states)[:, 4:, from_bank]
        forces = self.track.force_of[0, place] @ by_coefficient
        variance = np.einsum("nfp,pq,nfq->nf", forces, model.covariance[np.ix_(from_bank, from_bank)], forces)
        return BankSpread(furthest, np.sqrt(np.maximum(variance, 0.0)) * np.sign(forces.sum(axis=2)))
