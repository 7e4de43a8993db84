"""The forecaster: from an estimate to what will happen, at every update."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from narrows.control.local_water import local_water
from narrows.control.regulator import regulator
from narrows.control.regulator_law import Regulator
from narrows.errors import InputError, check_count
from narrows.estimation.estimate import Estimate
from narrows.estimation.estimator import Estimator
from narrows.estimation.ship_lanes import RUDDER
from narrows.quantities.constants import GRAVITY
from narrows.warning.forecasting.bridge_predictors import Beside
from narrows.warning.forecasting.forecast import SOON, BankForecast, CaseForecast, LikelyRun
from narrows.warning.forecasting.forecast_cases import AFTER, CASES, CHANCES, LIKELY
from narrows.warning.forecasting.future_lanes import Ends, FutureBlock, FutureLanes, Ships
from narrows.warning.forecasting.members import Drawn, Members
from narrows.warning.forecasting.predicted_fan import BLOCKS, FAN_MEMBERS, PredictedFan, fan_of
from narrows.warning.forecasting.rudder_needed import rudder_needed

# Of the root of length over gravity; and a time [s] that is a whole number of steps, as all times of the cases are.
STEPS_A_PERIOD, EVEN = 2.0, 10.0
# Along the way, and of the speed, after which the pilot is made anew for the place and the speed.
AGAIN_LENGTHS, AGAIN_SHARE = 5.0, 0.2
# Froude number by length: for slower ships the pilot is that of this speed [1].
SLOWEST = 0.01


class Forecaster:
    """Forecasts of one ship, laid out once."""

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
        """Return what will happen."""
        # positions [rad]
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
        beside = Beside(model.configuration.ship, water.width / 2, y, psi, u, v, r, water.curvature)
        return float(beside.curved_contact(AFTER)[0])

    def fan(self, estimate: Estimate, positions: Mapping[str, float]) -> PredictedFan:
        """Return where the ship may go, for pictures."""
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

    def _ships(self, drawn: Drawn, rudder: float) -> Ships:
        terms = self.filter.model.terms
        columns = dict(zip(self.filter.states.names, drawn.states.T, strict=True))
        coefficients = dict(zip(terms.names, drawn.coefficients.T, strict=True))
        bank = columns.get("bank", 1.0)
        coefficients |= {term.name: bank * coefficients[term.name] for term in terms.terms if term.from_bank}
        return Ships(columns, rudder + columns.get("rudder_bias", np.zeros(len(drawn.states))), coefficients)

    def _laid_out(self, now: Mapping[str, float]) -> FutureLanes:
        """The lanes, with a pilot for this place and speed."""
        length = self.filter.model.configuration.ship.length
        place, speed = self._pilot_for
        far = self.filter.waterway is not None and abs(now["x"] - place) > AGAIN_LENGTHS * length
        if self._lanes and not far and abs(now["u"] - speed) <= AGAIN_SHARE * speed:
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
        step = EVEN / math.ceil(EVEN * STEPS_A_PERIOD / math.sqrt(ship.length / GRAVITY) - 0.5)
        if waterway is not None and waterway.step is None:
            waterway = replace(waterway, step=ship.beam)  # Contact to some hundredths of the beam, in less time.
        return FutureLanes(self.filter.ship, waterway, pilot, blocks, step)

    def _pilot(self, now: Mapping[str, float]) -> Regulator:
        model, waterway = self.filter.model, self.filter.waterway
        at = 0.0 if waterway is None else min(max(now["x"], 0.0), waterway.line.length)
        slow = SLOWEST * math.sqrt(GRAVITY * model.configuration.ship.length)
        return regulator(model, self.line, max(now["u"], slow), waterway=waterway, at=at)


def _of_case(ends: Ends, place: int, name: str) -> CaseForecast:
    contact, side = ends.contact[place], ends.side[place]
    meets = np.isfinite(contact)
    share = float(meets.mean())
    time = float(np.median(contact[meets])) if share else math.inf
    return CaseForecast(name, share, float((contact <= SOON).mean()), time, _side(side[meets].sum()) if share else "")


def _likely(ends: Ends) -> LikelyRun:
    contact = float(ends.contact[0, 0])
    met = np.isfinite(ends.contact[1 : 1 + len(CHANCES), 0])
    clear = int(met.argmax()) if met.any() else len(CHANCES)
    last = math.inf if clear == len(CHANCES) else CHANCES[max(clear - 1, 0)]
    return LikelyRun(contact, _side(ends.side[0, 0]) if math.isfinite(contact) else "", last, clear == 0)


def _side(sign: float) -> str:
    return "starboard" if sign > 0 else "port"
