"""The forecast: contact if nobody acts, the last chance to act, the best manoeuvre now and its remaining risk."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from narrows.base.errors import InputError, check_count
from narrows.base.results import BaseSummary
from narrows.codegen.free_motion import CURRENT_ACROSS
from narrows.control.steady_course import RUDDER, local_water, steady_courses
from narrows.estimation.estimator import Estimator
from narrows.estimation.states import Estimate
from narrows.quantities.names import GRAVITY
from narrows.ship.particulars import Ship, half_swept
from narrows.simulation.ship import SimulatedShip
from narrows.warning import settings
from narrows.warning.forecasting.helmsman import (
    KICK,
    REVOLUTIONS,
    STEADY,
    Case,
    FutureBlock,
    FutureLanes,
    Helmsmen,
    Manoeuvre,
    Outcomes,
    Ships,
    escape_numbers,
)
from narrows.waterway.waterway import Waterway

# [s] a whole number of steps, as all times of the cases are.
EVEN = 5.0
AFTER, ESCAPE_TIME = settings.HORIZON, settings.ESCAPE_TIME
TAKEOVERS, CHANCES = np.array(settings.TAKEOVERS), np.array(settings.LIKELY_TAKEOVERS)
# Times of the tracks that are drawn [s].
TIMES = np.arange(5.0, AFTER + 1.0, 5.0)
FAN_EVERY, FAN_MEMBERS = 2, 32  # Every second time, and the samples, of the fan
# The rudder as it is; the helmsman steers as in the last minutes.
AS_IS, HELMSMAN = Case(AFTER), Case(AFTER, 0.0)
# Numbers of a forecast in ``to_dict``.
NUMBERS = (
    "t", "last_chance", "failing", "nobody", "unattended", "as_is", "wrong_order", "rudder",
    "rudder_needed", "rudder_limit", "rudder_margin",
)  # fmt: skip
NEARLY_HARD = 0.9  # Share of the rudder's limit [1] from which an order reads "hard"


@dataclass(frozen=True)
class LikelyRun:
    """The forecast from the mean of state and coefficients."""

    contact: float  # Time until contact with the rudder unchanged; infinite without contact [s]
    side: str  # Side of that bank; empty without contact
    last_chance: float  # Latest time of an escape that stays clear; negative if there is none [s]

    @property
    def gone(self) -> bool:
        return self.last_chance < 0.0


@dataclass(frozen=True)
class Escape:
    """The manoeuvre that keeps the most samples clear."""

    then: str  # Order after the first one
    order: float  # First order of the rudder [rad]
    limit: float  # Limit of the gear [rad]
    clearance: float  # Least clearance of the most likely ship [m]

    def words(self) -> str:
        side, angle = "starboard" if self.order > 0 else "port", abs(self.order)
        how = "Hard" if angle > NEARLY_HARD * self.limit else f"{math.degrees(angle):.0f} degrees"
        return f"{how} to {side}, {self.then}"


class Tracks(NamedTuple):
    """Forecast tracks of a ship: each pose along the waterway and off its line [m], and the heading to it [rad]."""

    times: np.ndarray  # (times,) Times from now on [s]
    fan: np.ndarray  # (samples, some of the times, 3) Tracks with the rudder unchanged; they stop at contact
    as_is: np.ndarray  # (times, 3) Track of the most likely ship with the rudder unchanged
    escape: np.ndarray  # (times, 3) Track of the same ship with the escape


@dataclass(frozen=True, repr=False)
class BankForecast(BaseSummary):
    t: float  # Time of the forecast [s]
    likely: LikelyRun  # Most likely run
    last_chance: float  # Last chance of the 95 % ship: infinite beyond the horizon, negative where it has passed [s]
    failing: float  # Share of samples that meet a bank in spite of the best escape now [1]
    nobody: float  # Chance that a bank is met because nobody acts in time [1]
    unattended: float  # Chance that nobody is at the helm [1]
    as_is: float  # Chance of contact within the horizon with the rudder unchanged [1]
    wrong_order: float  # Last chance of the likely ship after an order hard over to the worse side now [s]
    escape: Escape  # Best manoeuvre now
    rudder: float  # Present rudder angle [rad]
    rudder_needed: float  # Rudder of the steady course here by the estimated bank [rad]; infinite if there is none
    rudder_limit: float  # Limit of the gear [rad]
    tracks: Tracks | None = None  # Tracks for the page

    @property
    def gone(self) -> bool:
        """Whether the last chance of the 95 % ship has passed."""
        return self.last_chance < 0.0

    @property
    def level_time(self) -> float:
        """Time that determines the alert level [s]: longer if somebody probably acts in time."""
        return float(level_time(self.last_chance, self.nobody))

    @property
    def clear(self) -> bool:
        """Whether there is no last chance, hardly a sample meets a bank, and a wrong order would leave time."""
        calm = self.last_chance == math.inf and self.as_is <= settings.CLEAR_SHARE
        return calm and self.wrong_order >= settings.WRONG_ORDER_TIME

    @property
    def side(self) -> str:
        """Side of the danger; empty where there is none."""
        return self.likely.side

    @property
    def rudder_margin(self) -> float:
        """Rudder left of the limit on the steady course [rad]; negative if it needs more."""
        return self.rudder_limit - abs(self.rudder_needed)

    @property
    def notes(self) -> tuple[str, ...]:
        return ("Contact with the rudder as it is happens only if nobody acts: it is no chance of grounding.",)

    def summary(self) -> str:
        return self.words()

    def time_left(self) -> str:
        later = f"later than {TAKEOVERS[-1]:.0f} s"
        return "gone" if self.gone else f"in {self.last_chance:.0f} s" if math.isfinite(self.last_chance) else later

    def words(self) -> str:
        """Text of the alert, in few words, the number first."""
        run = self.likely
        if not math.isfinite(self.last_chance):
            if self.wrong_order < settings.WRONG_ORDER_TIME:
                return f"{max(self.wrong_order, 0.0):.0f} s to act after a wrong order hard over"
            return f"No contact within {settings.HORIZON:.0f} s, rudder as it is"
        side = f" to {self.side}" if self.side else ""
        if self.gone:
            left = f"{run.contact:.0f} s to contact" if math.isfinite(run.contact) else "No time left"
            return f"{left}: bank{side}. {self.escape.words()}"
        return f"{self.last_chance:.0f} s to act: bank{side}. {self.escape.words()}"

    def to_dict(self) -> dict[str, Any]:
        numbers = {name: getattr(self, name) for name in NUMBERS}
        escape = {**vars(self.escape), "words": self.escape.words()}
        likely = {**vars(self.likely), "gone": self.likely.gone}
        return {"summary": self.summary(), **numbers, "likely": likely, "escape": escape, "notes": [*self.notes]}


def level_time(last_chance: np.ndarray | float, nobody: np.ndarray | float) -> np.ndarray:
    """Return the time until the last chance, up to ten times as long where somebody acts in time [s]."""
    share = settings.ATTENDED_SHARE
    return np.asarray(np.maximum(last_chance, 0.0) / (share + (1.0 - share) * nobody))


def escapes(manoeuvres: tuple[Manoeuvre, ...], takeovers: np.ndarray) -> list[Case]:
    return [Case(since + ESCAPE_TIME, since, one) for one in manoeuvres for since in takeovers.tolist()]


class Forecaster:
    def __init__(
        self, estimator: Estimator, line: float = 0.0, *, members: int = settings.MEMBERS,
        escaping: int = settings.ESCAPING_MEMBERS, ships: int = 1, seed: int = 0,
    ) -> None:  # fmt: skip
        check_count("members", members, 2)
        self.filter, self.line, self.ships = estimator.filter, line, ships
        if RUDDER not in self.filter.actuators:
            raise InputError("this model has no terms of a rudder, so nobody can take over; give one with a rudder")
        assert self.filter.waterway is not None
        self.waterway = self.filter.waterway
        self.manoeuvres = (STEADY, KICK) if REVOLUTIONS in self.filter.actuators else (STEADY,)
        # Standard normal numbers of the samples of a block, (samples, n): they stay the same, so that from one forecast
        # to the next only the posterior changes. Half of them mirror the other half; the most likely ship has zeros.
        size = len(self.filter.states) + self.filter.root.shape[1]
        draws = ((members, seed), (escaping, seed + 1), (FAN_MEMBERS, seed))
        halves = [np.random.default_rng(own).standard_normal(((count + 1) // 2, size)) for count, own in draws]
        self.members, self.escaping, self._fan = (np.concatenate([half, -half]) for half in halves)
        self.likely = np.zeros((1, size))

    @cached_property
    def _lanes(self) -> FutureLanes:
        count, cases = self.ships, escapes(self.manoeuvres, TAKEOVERS)
        likely = [AS_IS, *escapes(self.manoeuvres, CHANCES), *self.wrong_orders]
        blocks = ((AS_IS, HELMSMAN), len(self.members)), (cases, len(self.escaping)), (likely, 1)
        return self.laid_out(*(FutureBlock(each, count * members) for each, members in blocks))

    @cached_property
    def wrong_orders(self) -> list[Case]:
        """Futures with the rudder hard over to either side from now on, until an escape begins."""
        limit, times = self.filter.model.configuration.gear.limit, settings.WRONG_ORDER_TAKEOVERS
        return [Case(since + ESCAPE_TIME, since, STEADY, order) for order in (-limit, limit) for since in times]

    @cached_property
    def _track_lanes(self) -> FutureLanes:
        fan = [Case(t) for t in TIMES[1::FAN_EVERY].tolist()]
        own = [Case(t) for t in TIMES.tolist()]
        saved = [Case(t, 0.0, one) for one in self.manoeuvres for t in TIMES.tolist()]
        return self.laid_out(FutureBlock(fan, FAN_MEMBERS), FutureBlock([*own, *saved], 1))

    def laid_out(self, *blocks: FutureBlock) -> FutureLanes:
        ship, waterway = self.filter.model.configuration.ship, self.waterway
        step = EVEN / math.ceil(EVEN * settings.STEPS_A_PERIOD / math.sqrt(ship.length / GRAVITY) - 0.5)
        if waterway.step is None:
            waterway = replace(waterway, step=ship.beam)  # Contact to some hundredths of the beam, in less time.
        return FutureLanes(self.filter.ship, waterway, self.line, blocks, step)

    def __call__(self, estimate: Estimate, positions: Mapping[str, float], helmsman: Helmsmen) -> BankForecast:
        now, rudder = estimate.values, np.array([positions.get(RUDDER, 0.0)])
        joint = estimate.joint
        if joint is None:
            raise InputError("nothing is known of this ship yet, so nothing can be forecast")
        mean, root = joint.mean[None], joint.root[None]
        law, turns = helmsman.law(np.array([now["u"]])), positions.get(REVOLUTIONS)
        seen = self.judge(mean, root, rudder, law, helmsman.unattended, turns)
        best, limit = int(seen.best[0]), self.filter.model.configuration.gear.limit
        lanes, count = self._track_lanes, len(TIMES)
        lanes([self.sampled(mean, root, normals, rudder, law) for normals in (self._fan, self.likely)], turns)
        fan, ends = lanes.poses()
        first = count * (1 + best)
        tracks = Tracks(TIMES, fan.swapaxes(0, 1), ends[:count, 0], ends[first : first + count, 0])
        needed = rudder_needed(self.filter.ship, self.waterway, now, positions)
        escape = Escape(self.manoeuvres[best].words, self.order(now), limit, self._least_water(tracks.escape))
        side = "starboard" if seen.side[0] > 0 else "port" if seen.side[0] < 0 else ""
        likely = LikelyRun(float(seen.contact[0]), side, float(seen.likely_chance[0]))
        return BankForecast(
            estimate.t, likely, float(seen.last_chance[0]), float(seen.failing[0, best, 0]), float(seen.nobody[0]),
            float(helmsman.unattended[0]), float(seen.as_is[0]), float(seen.wrong_order[0]), escape,
            float(rudder[0]) + now.get("rudder_bias", 0.0), needed, limit, tracks,
        )  # fmt: skip

    def judge(
        self, mean: np.ndarray, root: np.ndarray, rudder: np.ndarray, law: Any, unattended: np.ndarray,
        revolutions: float | None = None,
    ) -> "JudgedFutures":  # fmt: skip
        """Simulate the futures of ships abreast: mean (ships, n), root (ships, n, k)."""
        drawn = self.members, self.escaping, self.likely
        blocks = [self.sampled(mean, root, normals, rudder, law) for normals in drawn]
        return judged(self._lanes(blocks, revolutions), self.ships, len(self.manoeuvres), unattended)

    def order(self, now: Mapping[str, float]) -> float:
        """Return the first rudder angle of an escape [rad]."""
        water = local_water(self.filter.model, self.waterway, now["x"])
        hull, limit = self.filter.model.configuration.ship, self.filter.model.configuration.gear.limit
        numbers = escape_numbers(self.line, hull.length, limit)
        course = float(np.clip((self.line - now["y"]) * numbers["reach"], -numbers["approach"], numbers["approach"]))
        turn = (now["r"] - water.curvature * now["u"]) * numbers["by_r"] / max(now["u"], 0.1)
        crab = now.get(CURRENT_ACROSS, 0.0) / max(now["u"], 0.1)
        return float(np.clip(-numbers["by_psi"] * (now["psi"] + crab - course) - turn, -limit, limit))

    def _least_water(self, track: np.ndarray) -> float:
        """Least water beside the hull on a track [m]; none left where it ends in a bank."""
        if not np.isfinite(track).all():
            return 0.0
        (x, y, psi), ship = track.T, self.filter.model.configuration.ship
        return max(float(water_beside(ship, self.waterway, x, y, half_swept(ship, psi)).min()), 0.0)

    def sampled(
        self, mean: np.ndarray, root: np.ndarray, normals: np.ndarray, rudder: np.ndarray, law: Mapping[str, np.ndarray]
    ) -> Ships:
        """Return samples of the joint posterior of state and coefficients, one ship abreast after the other."""
        terms, own, size = self.filter.model.terms, self.filter.model.coefficients, len(self.filter.states)
        points = mean[:, None] + normals[:, : root.shape[2]] @ root.transpose(0, 2, 1)
        points, count = points.reshape(-1, mean.shape[1]), len(normals)
        columns = dict(zip(self.filter.states.names, points[:, :size].T, strict=True))
        # Coefficients by the directions of their covariance, within the bounds of their terms.
        middle, (low, high) = np.array([own[name] for name in terms.names]), np.array([t.bound for t in terms.terms]).T
        drawn = middle + points[:, size:] @ self.filter.root.T
        drawn = np.clip(drawn, np.minimum(low, middle), np.maximum(high, middle))
        coefficients = dict(zip(terms.names, drawn.T, strict=True))
        bank = columns.get("bank", 1.0)
        coefficients |= {term.name: bank * coefficients[term.name] for term in terms.terms if term.from_bank}
        true = np.repeat(rudder, count) + columns.get("rudder_bias", 0.0)
        return Ships(columns, true, coefficients, {name: np.repeat(value, count) for name, value in law.items()})


class JudgedFutures(NamedTuple):
    """Forecast outcomes of many ships, (ships,...)."""

    contact: np.ndarray  # Contact of the most likely ship, the rudder as it is; infinite where there is none [s]
    side: np.ndarray  # Side of that contact: negative to port
    likely_chance: np.ndarray  # Its last chance; infinite beyond what is tried, negative where it is gone [s]
    last_chance: np.ndarray  # Last chance of the 95 % ship [s]
    failing: np.ndarray  # (ships, manoeuvres, takeovers) Share of samples that meet a bank all the same [1]
    best: np.ndarray  # Index of the best manoeuvre
    nobody: np.ndarray  # Chance that nobody acts in time [1]
    as_is: np.ndarray  # Chance of contact within the horizon, the rudder as it is [1]
    helmsman: np.ndarray  # The same where the helmsman steers on [1]
    wrong_order: np.ndarray  # Last chance after an order hard over to the worse side now [s]


def judged(outcomes: list[Outcomes], ships: int, count: int, unattended: np.ndarray) -> JudgedFutures:
    members, escaping, likely = outcomes
    as_is, helmsman = members.contact.reshape(2, ships, -1)
    failing = np.isfinite(escaping.contact).reshape(count, len(TAKEOVERS), ships, -1).mean(axis=-1)
    failing = np.maximum.accumulate(failing.transpose(2, 0, 1), axis=2)
    met, tries = np.isfinite(likely.contact[1:]), count * len(CHANCES)
    single = met[:tries].reshape(count, len(CHANCES), ships).transpose(2, 0, 1)
    best_share = failing.min(axis=1)
    # Somebody comes back to the helm after an exponential time; from the last takeover on nobody is in time.
    side = np.where(np.isfinite(escaping.contact), escaping.side, 0)[-1].reshape(ships, -1).sum(axis=1)
    weights = -np.diff(np.exp(-np.array([0.0, *(TAKEOVERS[1:] + TAKEOVERS[:-1]) / 2, np.inf]) / settings.RETURN_TIME))
    steered = np.isfinite(helmsman).mean(axis=1)
    nobody = unattended * (best_share * weights).sum(axis=1) + (1.0 - unattended) * steered
    return JudgedFutures(
        likely.contact[0], np.where(np.isfinite(likely.contact[0]), likely.side[0], side),
        crossing(CHANCES, single.min(axis=1), 0.5),
        crossing(TAKEOVERS, best_share, settings.FAILING_SHARE), failing, failing[:, :, :2].sum(axis=2).argmin(axis=1),
        nobody, np.isfinite(as_is).mean(axis=1), steered,
        wrong_order_chance(met[tries:]),
    )  # fmt: skip


def wrong_order_chance(met: np.ndarray) -> np.ndarray:
    """Return the last chance after an order to the worse side [s], of contacts (cases of both sides, ships)."""
    times = np.array(settings.WRONG_ORDER_TAKEOVERS)
    return crossing(times, met.reshape(2, len(times), -1).max(axis=0).T, 0.5)


def crossing(times: np.ndarray, share: np.ndarray, limit: float) -> np.ndarray:
    """Return when rising shares (n, times) come over a limit [s]; -1 where they begin over it, infinite where never."""
    share = np.maximum.accumulate(np.asarray(share, float), axis=1)
    over = share > limit
    after = np.where(over.any(axis=1), over.argmax(axis=1), 0)
    rows, before = np.arange(len(share)), np.maximum(after - 1, 0)
    low, high = share[rows, before], share[rows, after]
    part = np.where(high > low, (limit - low) / np.where(high > low, high - low, 1.0), 0.0)
    when = times[before] + part * (times[after] - times[before])
    return np.where(over[:, 0], -1.0, np.where(over.any(axis=1), when, np.inf))


def water_beside(ship: Ship, waterway: Waterway, x: Any, y: Any, half: Any) -> np.ndarray:
    """Return the water to port and starboard [m] of a hull that reaches ``half`` to either side, at keel depth."""
    here = waterway.section(np.clip(x, 0.0, waterway.line.length), ship.draft)
    room, off = here.width / 2 - half, y - here.middle
    return np.array([room + off, room - off])


def rudder_needed(
    ship: SimulatedShip, waterway: Waterway, at: Mapping[str, float], positions: Mapping[str, float]
) -> float:
    """Return the rudder of the steady course here, the bank as strong as estimated [rad]; infinite without one."""
    model = ship.model
    water = local_water(model, waterway, at["x"])
    if abs(at["y"] - water.middle) >= (water.width - model.configuration.ship.beam) / 2 or not at["u"] > 0.0:
        return math.inf
    bank = at.get("bank", 1.0)
    banks = {term.name: bank * model.coefficients[term.name] for term in model.terms.terms if term.from_bank}
    turns = {name: value for name, value in positions.items() if name != RUDDER}
    _, course = steady_courses(ship, water, np.array([at["y"]]), np.array([at["u"]]), {**banks, **turns})
    return float(course["rudder"][0]) if math.isfinite(course["rudder"][0]) else math.inf
