"""The forecaster: from an estimate to what will happen, at every update."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.control.local_motion import local_water
from narrows.control.regulator import regulator
from narrows.control.regulator_law import Regulator
from narrows.control.self_propulsion import with_propulsion
from narrows.control.steady_course import RUDDER, solved
from narrows.errors import InputError, check_count
from narrows.estimation.estimate import Estimate
from narrows.estimation.estimator import Estimator
from narrows.estimation.ship_filter import ShipFilter
from narrows.quantities.names import GRAVITY
from narrows.ship.cross_section import half_swept
from narrows.ship.particulars import Ship
from narrows.simulation.ship import SimulatedShip
from narrows.warning import settings
from narrows.warning.forecasting.forecast import AFTER, CASES, CHANCES, LIKELY, BankForecast, CaseForecast, LikelyRun
from narrows.warning.forecasting.future_lanes import (
    BLOCKS,
    FAN_MEMBERS,
    FutureBlock,
    FutureLanes,
    Outcomes,
    PredictedFan,
    Ships,
    fan_of,
)

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

# [s] a whole number of steps, as all times of the cases are.
EVEN = 10.0


class Samples(NamedTuple):
    states: np.ndarray  # (ships, states) Of the estimate
    coefficients: np.ndarray  # (ships, coefficients) In the order of the model's table


class Forecaster:
    def __init__(self, estimator: Estimator, line: float = 0.0, *, members: int = 1000, seed: int = 0) -> None:
        check_count("members", members, 2)
        self.filter, self.line = estimator.filter, line
        if RUDDER not in self.filter.actuators:
            raise InputError("this model has no terms of a rudder, so nobody can take over; give one with a rudder")
        self._members = Members(self.filter, members + members % 2, seed)
        self._fan_members = Members(self.filter, FAN_MEMBERS, seed)
        self._lanes: FutureLanes | None = None
        self._fan_lanes: FutureLanes | None = None
        self._pilot_for = (-math.inf, math.inf)

    def __call__(self, estimate: Estimate, positions: Mapping[str, float]) -> BankForecast:
        ships = self._members.drawn(estimate), self._members.likely(estimate)
        now, rudder = estimate.values, positions.get(RUDDER, 0.0)
        lanes = self._flowing(self._laid_out(now), now, positions)
        members, likely = lanes([self._ships(drawn, rudder) for drawn in ships])
        cases = {case.name: _of_case(members, number, case.name) for number, case in enumerate(CASES)}
        needed = rudder_needed(self.filter.ship, self.filter.waterway, now, positions)
        limit = self.filter.model.configuration.gear.limit
        true = rudder + now.get("rudder_bias", 0.0)
        return BankForecast(estimate.t, cases, _likely(likely), self._curved(now), true, needed, limit)

    def _curved(self, now: Mapping[str, float]) -> float:
        """To contact of a track that is curved by the yaw rate."""
        model, waterway = self.filter.model, self.filter.waterway
        water = local_water(model, waterway, now["x"] if waterway is not None else 0.0)
        psi, u, v, r = (np.array([now[name]]) for name in ("psi", "u", "v", "r"))
        y = np.array([now["y"] - water.middle])
        beside = BridgePredictor(model.configuration.ship, water.width / 2, y, psi, u, v, r, water.curvature)
        return float(beside.curved_contact(AFTER)[0])

    def fan(self, estimate: Estimate, positions: Mapping[str, float]) -> PredictedFan:
        rudder, likely = positions.get(RUDDER, 0.0), self._members.likely(estimate)
        self._laid_out(estimate.values)
        if self._fan_lanes is None:
            self._fan_lanes = self._made(self._takes_over, BLOCKS)
        self._fan_lanes.steer(self._takes_over)
        lanes = self._flowing(self._fan_lanes, estimate.values, positions)
        lanes([self._ships(drawn, rudder) for drawn in (self._fan_members.drawn(estimate), likely, likely)])
        return fan_of(lanes.poses())

    def _flowing(self, lanes: FutureLanes, now: Mapping[str, float], positions: Mapping[str, float]) -> FutureLanes:
        current = now.get("current", self.filter.waterway.current if self.filter.waterway else 0.0)
        lanes.flow(current, positions.get("revolutions"))
        return lanes

    def _ships(self, drawn: Samples, rudder: float) -> Ships:
        terms = self.filter.model.terms
        columns = dict(zip(self.filter.states.names, drawn.states.T, strict=True))
        coefficients = dict(zip(terms.names, drawn.coefficients.T, strict=True))
        bank = columns.get("bank", 1.0)
        coefficients |= {term.name: bank * coefficients[term.name] for term in terms.terms if term.from_bank}
        return Ships(columns, rudder + columns.get("rudder_bias", np.zeros(len(drawn.states))), coefficients)

    def _laid_out(self, now: Mapping[str, float]) -> FutureLanes:
        length = self.filter.model.configuration.ship.length
        place, speed = self._pilot_for
        far = self.filter.waterway is not None and abs(now["x"] - place) > settings.PILOT_REDESIGN_LENGTHS * length
        if self._lanes and not far and abs(now["u"] - speed) <= settings.PILOT_REDESIGN_SPEED * speed:
            return self._lanes
        pilot = self._takes_over = self._pilot(now)
        if self._lanes is None:
            self._lanes = self._made(pilot, (FutureBlock(CASES, self._members.count), FutureBlock(LIKELY, 1)))
        self._lanes.steer(pilot)
        self._pilot_for = (now["x"], now["u"])
        return self._lanes

    def _made(self, pilot: Regulator, blocks: Sequence[FutureBlock]) -> FutureLanes:
        model, waterway = self.filter.model, self.filter.waterway
        ship = model.configuration.ship
        step = EVEN / math.ceil(EVEN * settings.STEPS_A_PERIOD / math.sqrt(ship.length / GRAVITY) - 0.5)
        if waterway is not None and waterway.step is None:
            waterway = replace(waterway, step=ship.beam)  # Contact to some hundredths of the beam, in less time.
        return FutureLanes(self.filter.ship, waterway, pilot, blocks, step)

    def _pilot(self, now: Mapping[str, float]) -> Regulator:
        model, waterway = self.filter.model, self.filter.waterway
        at = 0.0 if waterway is None else min(max(now["x"], 0.0), waterway.line.length)
        slow = settings.LEAST_FROUDE * math.sqrt(GRAVITY * model.configuration.ship.length)
        return regulator(model, self.line, max(now["u"], slow), waterway=waterway, at=at)


def _of_case(ends: Outcomes, place: int, name: str) -> CaseForecast:
    contact, side = ends.contact[place], ends.side[place]
    meets = np.isfinite(contact)
    share = float(meets.mean())
    time = float(np.median(contact[meets])) if share else math.inf
    return CaseForecast(
        name, share, float((contact <= settings.SOON).mean()), time, _side(side[meets].sum()) if share else ""
    )


def _likely(ends: Outcomes) -> LikelyRun:
    contact = float(ends.contact[0, 0])
    met = np.isfinite(ends.contact[1 : 1 + len(CHANCES), 0])
    clear = int(met.argmax()) if met.any() else len(CHANCES)
    last = math.inf if clear == len(CHANCES) else CHANCES[max(clear - 1, 0)]
    return LikelyRun(contact, _side(ends.side[0, 0]) if math.isfinite(contact) else "", last, clear == 0)


def _side(sign: float) -> str:
    return "starboard" if sign > 0 else "port"


@dataclass
class Members:
    """Samples of the joint posterior of state and coefficients."""

    # The standard normal numbers stay the same: from one forecast to the next only the posterior changes.

    filter: ShipFilter  # Of the estimator
    count: int  # How many, an even number: half of them mirror the other half about the mean
    seed: int  # Of the numbers

    @cached_property
    def _normals(self) -> np.ndarray:
        size = len(self.filter.states) + self.filter.root.shape[1]
        half = np.random.default_rng(self.seed).standard_normal((self.count // 2, size))
        return np.concatenate([half, -half])

    def drawn(self, estimate: Estimate) -> Samples:
        return self._ships(estimate, self._normals)

    def likely(self, estimate: Estimate) -> Samples:
        return self._ships(estimate, np.zeros((1, self._normals.shape[1])))

    def _ships(self, estimate: Estimate, normals: np.ndarray) -> Samples:
        joint, size = estimate.joint, len(self.filter.states)
        if joint is None:
            raise InputError("there is nothing known of this ship yet, so nothing can be foretold")
        points = joint.mean + normals[:, : joint.root.shape[1]] @ joint.root.T
        carried = normals[:, : self.filter.considered]
        directions = points[:, size:] if self.filter.estimated else carried
        return Samples(points[:, :size], self._coefficients(directions))

    def _coefficients(self, directions: np.ndarray) -> np.ndarray:
        """Coefficients by the directions of their covariance, within the bounds of their terms."""
        model = self.filter.model
        middle = np.array([model.coefficients[name] for name in model.terms.names])
        low, high = np.array([term.bound for term in model.terms.terms]).T
        drawn = middle + directions @ self.filter.root[:, : directions.shape[1]].T
        return np.asarray(np.clip(drawn, np.minimum(low, middle), np.maximum(high, middle)))


def rudder_needed(
    ship: SimulatedShip, waterway: "Waterway | None", at: Mapping[str, float], positions: Mapping[str, float]
) -> float:
    """Return the rudder of the steady course here, the bank as strong as estimated [rad]; infinite without one."""
    model = ship.model
    water = local_water(model, waterway, at["x"] if waterway is not None else 0.0)
    offset = at["y"] - water.middle
    if abs(offset) >= (water.width - model.configuration.ship.beam) / 2 or not at["u"] > 0.0:
        return math.inf
    bank = at.get("bank", 1.0)
    banks = {term.name: bank * model.coefficients[term.name] for term in model.terms.terms if term.from_bank}
    place = {"path_curvature": water.curvature / (1.0 - water.curvature * at["y"]), "current": water.current}
    turns = {name: value for name, value in positions.items() if name != RUDDER}
    turning = with_propulsion(model, {**turns, "u": at["u"]})
    values = {**ship.values(), **banks, **water.sections, **place, **turning, "y": offset}
    _, rudder = solved(ship, values, 1, 1)
    return float(rudder[0]) if math.isfinite(rudder[0]) else math.inf


class BridgePredictor(NamedTuple):
    """Predictions of a bridge without a model; the banks continue as beside the ship, bent as the line is there."""

    hull: Ship  # Length and beam
    half_width: float  # Of the water [m]
    y: np.ndarray  # (n,) To starboard of the middle [m]
    psi: np.ndarray  # (n,) Heading, to the line [rad]
    u: np.ndarray  # (n,) Surge and sway velocity [m/s]
    v: np.ndarray  # (n,) Surge and sway velocity [m/s]
    r: np.ndarray  # (n,) Yaw rate [rad/s]
    bend: float = 0.0  # Curvature of the line [1/m]

    def clearance(self, y: np.ndarray, psi: np.ndarray) -> Any:
        """Return the water beside the corners of the hull [m]."""
        return self.half_width - np.abs(y) - half_swept(self.hull, psi)

    @property
    def now(self) -> Any:
        return self.clearance(self.y, self.psi)

    def straight_contact(self, until: float) -> np.ndarray:
        """Return when a ship that goes straight on meets a bank, (n,) [s]; infinite where it does not by then."""
        return self._contact(np.zeros_like(self.r), until)

    def curved_contact(self, until: float) -> np.ndarray:
        """Return the same of a ship that goes on turning as fast as it does."""
        return self._contact(self.r, until)

    def _contact(self, turn: np.ndarray, until: float) -> np.ndarray:
        t = np.arange(0.0, until + settings.TRACK_STEP / 2, settings.TRACK_STEP)
        psi = self.psi[:, None] + (turn - self.bend * self.u)[:, None] * t
        across = self.u[:, None] * np.sin(psi) + self.v[:, None] * np.cos(psi)
        gone = np.cumsum((across[:, 1:] + across[:, :-1]) / 2 * settings.TRACK_STEP, axis=1)
        y = self.y[:, None] + np.concatenate([np.zeros((len(self.y), 1)), gone], axis=1)
        met = self.clearance(y, psi) <= 0.0
        return np.where(met.any(axis=1), t[met.argmax(axis=1)], np.inf)
