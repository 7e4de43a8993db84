"""What ships do in truth: an hour on a canal with bends and narrows, hands of several kinds, and lapses at the helm."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

import narrows as nw
from narrows.control.regulator import HeldLine, Regulator
from narrows.estimation.states import ProcessNoise
from narrows.identification.fitting import bundled_ship
from narrows.model.tables import table_named
from narrows.ship.particulars import half_swept
from narrows.simulation.controllers import ExternalOrder
from narrows.simulation.grid import sampled
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.ship import PARAMETER, SimulatedShip, steering_of
from narrows.waterway import Bank, Centreline
from narrows.waterway.waterway import Waterway

SPEED, DURATION, DT = 4.5, 3600, 1.0
LENGTH, WIDTH, DEPTH = 230.0, 300.0, 16.2
LINES = np.arange(-40.0, 41.0, 20.0)
"""That ships are held on [m]."""
EPOCH, CROSSING = 720, 0.05
"""Between two lines or speeds of a ship [s]; angle at which a hand crosses to another line [rad]."""
BENDS = ((3000.0, 4500.0, 5000.0), (7500.0, 9000.0, -4000.0), (12000.0, 13500.0, 6000.0))
"""From, to [m], radius to starboard [m]."""
NARROWS = ((0.0, 150.0), (5400.0, 150.0), (5700.0, 130.0), (6700.0, 130.0), (7000.0, 150.0), (10000.0, 165.0),
           (11400.0, 165.0), (11800.0, 145.0), (30000.0, 145.0))  # fmt: skip
"""Half the width along the way [m]."""
AREA, LEVER, WIND, GUST, BLOWS = 6000.0, 15.0, 14.0, 60.0, 4
"""Of the ship above water [m2], of the wind forward of midship [m]; fastest wind [m/s], how long [s], how often."""
MEETING, MEETINGS, MEETING_LEVER = 45.0, 3, 30.0
"""How long another ship is felt [s], how often, and how far off midship [m]."""
SHEAR_LENGTH = 500.0
"""A current with shear changes its direction in so many metres, times pi."""
STRENGTH, CURRENT, BIAS = 0.15, 0.3, np.radians(0.5)
"""Standard deviations: of the banks' strength, the current along [m/s], and the rudder's indicator."""
HANDS = {"steady": (0, 10, 1.0), "late": (4, 12, 1.0), "over-steering": (3, 8, 1.7), "change-over": (0, 10, 1.0)}
"""Hands: from what is seen to the order, between two orders [s], and times the regulator's move."""
OTHER_HANDS = {"slow": (5, 20, 0.7), "nervous": (2, 5, 2.0)}
NEAR = 20.0
"""Clearance of a near miss [m]."""
LAPSES = ("forgotten", "wrong order", "strong bank")


@dataclass(frozen=True)
class Physics:
    """What the ships are, that the warning takes for another."""

    words: str  # For the table
    exponential: bool = False  # Whether banks act by the exponential of the gap beside the hull
    spread: float = 1.0  # Times the standard deviations of the coefficients
    depth: float = DEPTH  # Of the water [m]
    shear: float = 0.0  # Of the current: how much it changes along the way, ahead and across [m/s]
    other_hands: bool = False  # Whether hands steer by a law of their own, in steps of 5 degrees
    abrupt: bool = False  # Whether hands steer to another line at once, with all the rudder that this takes


@cache
def modelled() -> nw.Model:
    """The ship as the warning knows it."""
    return bundled_ship(LENGTH, WIDTH, DEPTH, table_named("speed+helm"))


def true_model(physics: Physics) -> nw.Model:
    """The ship as it is, before its coefficients are drawn."""
    known = modelled()
    model = known if physics.depth == DEPTH else nw.at_depth(known, physics.depth).model
    return replace(model, covariance=model.covariance * physics.spread**2)


@cache
def exponential_scales() -> tuple[float, float]:
    """Force [N s2/m2] and moment [N s2/m] of exponential banks: the model's, 40 m off the middle."""
    y, force = 40.0, modelled().bank_forces(nw.Motion.at(y=40.0, u=SPEED))
    unit = exponential_difference(np.array([y]), np.zeros(1), WIDTH / 2)[0] * SPEED**2
    return force["Y"] / unit, force["N"] / unit


def exponential_difference(y: np.ndarray, psi: np.ndarray, half_width: Any) -> np.ndarray:
    """Difference of exp(-gap / beam) to starboard and to port, the mean of two places of the hull."""
    beam = modelled().configuration.ship.beam
    ends = y + np.array([[-0.25], [0.25]]) * LENGTH * np.sin(psi)
    starboard, port = (np.exp(-(half_width - side * ends - beam / 2) / beam) for side in (1.0, -1.0))
    return np.asarray((starboard - port).mean(axis=0))


@cache
def waterway() -> Waterway:
    """The canal."""
    s = np.arange(0.0, 22001.0, 20.0)
    bend = sum(np.where((s >= first) & (s < last), 1.0 / radius, 0.0) for first, last, radius in BENDS)
    heading = np.cumsum(20.0 * bend)
    line = Centreline(np.cumsum(20.0 * np.stack([np.sin(heading), np.cos(heading)], axis=1), axis=0))
    at, half = np.array(NARROWS).T
    at = np.minimum(at, line.length)
    ends = np.array([0.0, line.length])
    return Waterway(line, Bank("starboard", at, half), Bank("port", at, half), (ends, np.full(2, DEPTH)), name="canal")


class Ships:
    """Ships on their way, a lane each, each with a clock of its own.

    Parameters
    ----------
    model : Model
        The ship as it is, before its coefficients are drawn.
    own : mapping
        Columns of what each ship has of its own.
    state : mapping
        Columns of the state.
    t : (ships,) [s]
        Clocks.
    seed : int
        Of what disturbs them.
    """

    def __init__(
        self, model: nw.Model, own: Mapping[str, np.ndarray], state: Mapping[str, np.ndarray], t: np.ndarray, seed: int
    ) -> None:
        self.model, self.own, self.state, self.t = model, dict(own), dict(state), np.array(t, float)
        self.random, self.count = np.random.default_rng(seed), len(self.t)
        self.contact, self.least = np.full(self.count, np.inf), np.full(self.count, np.inf)
        self.ship = ship = SimulatedShip(model, "held")
        run = KernelRun(ship, DT, DT, steering=steering_of(ExternalOrder(), ship.actuators), waterway=waterway())
        values = {**self.state, **self.coefficients, "psi": 0.0, "push_end": np.inf, PARAMETER("order"): self.order}
        values |= dict.fromkeys("XYN", np.zeros(self.count))
        self._sailing = run.prepared(values, self.count, 1)
        self._constants = run.system(values).constants
        self._inputs = {name: place for place, name in enumerate(self._sailing.kernel.VESSEL_INPUTS)}
        self._values, self._walks = ship.values(), ProcessNoise.of_length(LENGTH).by_state()
        self.banks = [term.name for term in model.terms.terms if term.from_bank]

    @property
    def coefficients(self) -> dict[str, np.ndarray]:
        """Each ship's own."""
        return {name: self.own[name] for name in self.model.terms.names}

    @property
    def order(self) -> np.ndarray:
        """Rudders that are ordered."""
        return self.state["order"]

    @property
    def alive(self) -> np.ndarray:
        """Which have met no bank."""
        return np.isinf(self.contact)

    @property
    def psi(self) -> np.ndarray:
        """Headings."""
        return np.arctan2(self.state["sin_psi"], self.state["cos_psi"])

    @property
    def indicated(self) -> np.ndarray:
        """The rudder as the bridge sees it."""
        return self.state["rudder"] - self.own["bias"]

    @property
    def epoch(self) -> np.ndarray:
        """Which of its lines and speeds each ship has."""
        return np.minimum(self.t // EPOCH, self.own["lines"].shape[1] - 1).astype(int)

    @property
    def bend(self) -> np.ndarray:
        """Curvature of the line at each ship."""
        return bend_at(self.state["x"])

    @property
    def across(self) -> np.ndarray:
        """Current to starboard of the line at each ship [m/s]."""
        return self.own["shear"] * np.sin(self.state["x"] / SHEAR_LENGTH)

    def step(self) -> None:
        """Sail a second."""
        self._load()
        self._sailing()
        hit = (self._sailing.codes[:, 0] != 0) & self.alive
        self.contact[hit] = self.t[hit] + DT
        going = self.alive
        for name, column in zip(self._sailing.kernel.KEPT_NAMES, self._sailing.end.T, strict=True):
            if name in self.state and name != "t":
                self.state[name] = np.where(going, column, self.state[name])
        for name in ("u", "v", "r"):
            self.state[name] = self.state[name] + self._walks[name] * self.random.standard_normal(self.count) * going
        wanted = self.own["speeds"][np.arange(self.count), self.epoch]
        self.state["u"] = self.state["u"] + np.clip(wanted - self.state["u"], -0.005, 0.005) * going
        self._drift(going)
        self.t += DT
        self.least = np.where(going, np.minimum(self.least, self.clearance()), self.least)

    def _drift(self, going: np.ndarray) -> None:
        phase, shear = self.state["x"] / SHEAR_LENGTH, self.own["shear"] * going
        gone = (self.own["current"] * going + shear * np.sin(phase)) * DT
        psi = self.psi - self.bend * gone
        # Through the water the ship moves against a current across that it comes into.
        change = shear * np.cos(phase) * self.state["u"] / SHEAR_LENGTH * DT
        self.state |= {"y": self.state["y"] + shear * np.sin(phase) * DT, "v": self.state["v"] - change}
        self.state |= {"x": self.state["x"] + gone, "cos_psi": np.cos(psi), "sin_psi": np.sin(psi)}

    def clearance(self) -> Any:
        """Of the hull's corners to the banks [m]."""
        width = np.interp(self.state["x"], *np.array(NARROWS).T)
        return width - np.abs(self.state["y"]) - half_swept(self.model.configuration.ship, self.psi)

    def _load(self) -> None:
        sailing, inputs, own = self._sailing, self._inputs, self.own
        acts = (self.t >= own["when"]) & (self.t < own["when"] + own["bank lasts"])
        strength = own["strength"] + own["bank grows"] * acts
        force, moment = self._pushes()
        other = strength * own["exponential"] * self.state["u"] ** 2 * self._exponential_banks()
        force, moment = force + exponential_scales()[0] * other, moment + exponential_scales()[1] * other
        banks = {name: strength * (1.0 - own["exponential"]) * own[name] for name in self.banks}
        columns = {PARAMETER("order"): self.order, "Y_in": force, "N_in": moment}
        columns |= self._constants({**self._values, **self.coefficients, **banks})
        for name, column in columns.items():
            if name in inputs:
                sailing.vessel_inputs[:, inputs[name]] = column
        for place, name in enumerate(sailing.kernel.KEPT_NAMES):
            sailing.start[:, place] = self.state.get(name, 0.0)

    def _exponential_banks(self) -> np.ndarray:
        half = np.interp(self.state["x"], *np.array(NARROWS).T)
        return exponential_difference(self.state["y"], self.psi, half)

    def _pushes(self) -> tuple[np.ndarray, np.ndarray]:
        """Of gusts, and of ships that pass: a push and then a pull."""
        since = self.t[:, None] - self.own["blows"]
        wind = (self.own["gusts"] * ((since >= 0) & (since < GUST))).sum(axis=1)
        since = self.t[:, None] - self.own["meets"]
        meets = (since >= 0) & (since < MEETING)
        push = (self.own["passing"] * meets * np.where(since < MEETING / 2, 1.0, -1.0)).sum(axis=1)
        return wind + push, LEVER * wind + MEETING_LEVER * push

    def taken(self, ships: np.ndarray, state: Mapping[str, np.ndarray], t: np.ndarray, seed: int) -> "Ships":
        """The same ships (several times, perhaps) in states at times."""
        return Ships(self.model, {name: column[ships] for name, column in self.own.items()}, state, t, seed)

    def fresh(self, seed: int) -> "Ships":
        """The same ships once more from the start."""
        return self.taken(np.arange(self.count), self.state, self.t, seed)


@cache
def _bend_table() -> tuple[np.ndarray, np.ndarray]:
    s = np.arange(0.0, 22001.0, 10.0)
    return s, sum(np.where((s >= first) & (s < last), 1.0 / radius, 0.0) for first, last, radius in BENDS)


def bend_at(x: np.ndarray) -> np.ndarray:
    """Curvature of the line [1/m]."""
    return np.interp(x, *_bend_table())


CREW_CLEARANCE = 30.0
"""A crew that comes nearer to a bank than this in a calm hour does not sail this ship: the hand cannot hold it [m]."""
DRAWN = 4
"""Ships drawn for each that is watched with a lapse: most lapses end well, and those that do not are wanted."""


@cache
def departing(physics: Physics, count: int, seed: int) -> Ships:
    """Ships at the beginning of the hour: the first half have a lapse at the helm, which ends in a contact or near it.

    Ships that their hands cannot hold in a calm hour are left out, and so are most lapses that end well.
    """
    half = count // 2
    drawn = _drawn(physics, DRAWN * half + half + half // 2, DRAWN * half, seed)
    calm = dict.fromkeys(("gusts", "passing", "bank grows", "away"), 0.0) | {"when": np.inf}
    calm_hour = {name: np.full_like(drawn.own[name], value) for name, value in calm.items()}
    held, went = _sailed(drawn, calm_hour, physics.abrupt), _sailed(drawn, {}, physics.abrupt)
    held_lapses = np.flatnonzero((held >= CREW_CLEARANCE) & drawn.own["lapse"])
    lapses = held_lapses[np.argsort(went[held_lapses] > NEAR, kind="stable")][:half]
    others = np.flatnonzero((held >= CREW_CLEARANCE) & ~drawn.own["lapse"])[:half]
    which = np.concatenate([lapses, others])
    return drawn.taken(which, {name: column[which] for name, column in drawn.state.items()}, drawn.t[which], seed + 1)


def _sailed(ships: Ships, changes: Mapping[str, np.ndarray], abrupt: bool) -> np.ndarray:
    """Least clearance of ships in the hour, some things of their own changed [m]."""
    one = Ships(ships.model, {**ships.own, **changes}, ships.state, ships.t, 0)
    hands = Hands(one, abrupt)
    for t in range(DURATION):
        hands.steer(t)
        one.step()
    return np.where(one.alive, one.least, 0.0)


def _drawn(physics: Physics, count: int, lapses: int, seed: int) -> Ships:
    model, draw, n = true_model(physics), np.random.default_rng(seed), count
    lines = draw.choice(LINES, (n, DURATION // EPOCH + 1))
    held = helm(lines[:, 0]).lines[0]
    lapse, kind = np.arange(n) < lapses, draw.choice(len(LAPSES), n, p=(0.5, 0.25, 0.25))
    push = float(nw.wind_force(1.0, AREA))
    surge = lapse & ((kind == 2) | (draw.random(n) < 0.5))
    hands = np.array([*(OTHER_HANDS if physics.other_hands else HANDS).values()])
    hand = draw.integers(0, len(hands), n)
    own = {name: np.array(one) for name, one in sampled(model, n, seed).items()} | {
        "lines": lines, "speeds": SPEED + draw.uniform(-0.7, 0.5, lines.shape), "lapse": lapse, "kind": kind,
        "when": np.where(lapse, draw.uniform(400, 3200, n), np.inf), "bank lasts": draw.uniform(60, 150, n),
        "bank grows": np.where(surge, draw.uniform(0.5, 3.0, n), 0.0),
        "away": np.where(kind == 0, draw.uniform(45, 180, n), np.where(kind == 1, draw.uniform(30, 90, n), 0.0)),
        "wrong": np.radians(draw.uniform(8, 27, n)) * draw.choice([-1, 1], n), "hand": hand,
        "gusts": push * draw.uniform(0, WIND, (n, BLOWS)) ** 2 * draw.choice([-1, 1], (n, BLOWS)),
        "blows": draw.uniform(60, DURATION, (n, BLOWS)), "meets": draw.uniform(200, DURATION, (n, MEETINGS)),
        "passing": push * draw.uniform(4, 10, (n, MEETINGS)) ** 2 * draw.choice([-1, 1], (n, MEETINGS)),
        "strength": 1 + STRENGTH * draw.standard_normal(n), "shear": np.full(n, physics.shear),
        "exponential": np.full(n, float(physics.exponential)), "other hand": np.full(n, float(physics.other_hands)),
        "current": CURRENT * draw.standard_normal(n), "bias": BIAS * draw.standard_normal(n),
        "delay": hands[hand, 0], "interval": hands[hand, 1], "boldness": hands[hand, 2],
        "changes": (hand == 3) & ~np.array(physics.other_hands),
    }  # fmt: skip
    psi = held.psi + 0.005 * draw.standard_normal(n)
    state = {"x": np.full(n, 200.0), "y": lines[:, 0], "u": own["speeds"][:, 0], "r": np.zeros(n), "t": np.zeros(n)}
    state |= {"v": held.v, "rudder": held.rudder}
    state |= {"order": state["rudder"].copy(), "cos_psi": np.cos(psi), "sin_psi": np.sin(psi)}
    return Ships(model, own, state, np.zeros(n), seed + 1)


class Hands:
    """Who steers: the regulator of the ship as modelled, as a hand of its kind gives its orders; or nobody."""

    def __init__(self, ships: Ships, abrupt: bool) -> None:
        self.ships, self._seen = ships, deque[dict[str, np.ndarray]](maxlen=16)
        self._line, self.abrupt = ships.own["lines"][:, 0].copy(), abrupt
        self._memory: Mapping[str, Any] = {}
        self._trim = np.zeros(ships.count)

    def steer(self, t: int) -> None:
        """Give the orders of a second."""
        ships, own = self.ships, self.ships.own
        self._seen.append({**ships.state, "psi": ships.psi})
        since = t - own["when"]
        away = (since >= 0) & (since < own["away"])
        changing = own["changes"] & (t % 900 >= 870)
        wrong = (since >= 0) & (since < DT) & (own["kind"] == 1)
        due = (t % own["interval"] == 0) & ~away & ~changing
        left = own["lines"][np.arange(ships.count), ships.epoch] - self._line
        self._line += left if self.abrupt else np.clip(left, -CROSSING * SPEED, CROSSING * SPEED)
        if due.any() and ships.own["other hand"].any():
            self._order_by_course(due)
        elif due.any():
            self._order(t, due)
        ships.state["order"] = np.where(wrong, own["wrong"], ships.order)

    def _seen_late(self) -> dict[str, np.ndarray]:
        """What each hand steers by: the state some seconds ago."""
        back = len(self._seen) - 1 - np.minimum(self.ships.own["delay"].astype(int), len(self._seen) - 1)
        rows = np.arange(self.ships.count)
        return {name: np.stack([one[name] for one in self._seen])[back, rows] for name in self._seen[-1]}

    def _order_by_course(self, due: np.ndarray) -> None:
        """An order in steps of 5 degrees to a course to the line, two lengths ahead; what is held long is trim."""
        ships, seen = self.ships, self._seen_late()
        course = np.clip((self._line - seen["y"]) / (2.0 * LENGTH), -0.1, 0.1)
        turn = (seen["r"] - bend_at(seen["x"]) * seen["u"]) * LENGTH / seen["u"]
        self._trim = np.clip(self._trim + due * 0.02 * (course - seen["psi"]), -0.2, 0.2)
        wanted = (1.5 * (course - seen["psi"]) - 1.5 * turn) * ships.own["boldness"] + self._trim
        step = np.radians(5.0)
        wanted = np.clip(step * np.round(wanted / step), -4.0 * step, 4.0 * step)
        ships.state["order"] = np.where(due, wanted, ships.order)

    def _order(self, t: int, due: np.ndarray) -> None:
        ships, gear = self.ships, self.ships.model.configuration.gear
        law = helm(self._line)
        at = {
            **self._seen_late(), **law.parameters(), "rudder": ships.state["rudder"], "t": float(t),
            "dt": ships.own["interval"], "current": 0.0, "rudder_limit": gear.limit, "rudder_rate": gear.rate,
            "water": lambda name, x: bend_at(x),
        }  # fmt: skip
        memory = self._memory or law.memory(at)
        orders, after = law.orders(SimpleNamespace(**{**at, **memory}))
        move = (orders["rudder"] - ships.state["rudder"]) * ships.own["boldness"]
        wanted = np.clip(ships.state["rudder"] + move, -gear.limit, gear.limit)
        ships.state["order"] = np.where(due, wanted, ships.order)
        self._memory = {name: np.where(due, value, memory[name]) for name, value in after.items()}


@cache
def _held_lines() -> list[HeldLine]:
    return [nw.control.regulator(modelled(), y, SPEED).lines[0] for y in LINES.tolist()]


@cache
def _regulator() -> Regulator:
    return nw.control.regulator(modelled(), 0.0, SPEED)


def helm(lines: np.ndarray) -> Regulator:
    """People who steer: the regulator of the ship as modelled, its numbers between those of ``LINES``."""

    def between(numbers: list[Any]) -> np.ndarray:
        return np.interp(lines, LINES, numbers)

    held = _held_lines()
    numbers = {name: between([getattr(one, name) for one in held]) for name in ("y", "rudder", "psi", "v")}
    gains, turning = (
        tuple(between(list(column)) for column in zip(*(getattr(one, name) for one in held), strict=True))
        for name in ("gains", "turning")
    )
    return Regulator(
        (HeldLine(gains=gains, turning=turning, **numbers),), SPEED, _regulator().lead, _regulator().unwinding
    )
