"""The helmsman's control law, identified as the ship sails, the probability that nobody steers, and the futures.

The law is linear in offset, heading and yaw rate, with a delay; a Kalman filter for each of some delays learns its
gains. The helm is attended or not: a hidden Markov model of two states. The rudder of a hand scatters about its law, as
widely as is learned; a rudder that nobody holds has any angle, and moves less often. All futures of all samples are one
call of the package's kernel: every one a lane, laid out once.

Source: Rabiner (1989), Proceedings of the IEEE 77, A tutorial on hidden Markov models.
"""

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from narrows.base.results import BaseSummary
from narrows.codegen.free_motion import CURRENT_ACROSS, stages_at
from narrows.quantities.arithmetic import choice, clip
from narrows.quantities.names import FORCES
from narrows.simulation.controllers import ORDER_TOLERANCE, Named
from narrows.simulation.inputs import START
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.outcome import Code
from narrows.simulation.ship import CURRENT, PARAMETER, SimulatedShip, steering_of
from narrows.warning import settings
from narrows.waterway.waterway import Waterway


class Helmsmen:
    def __init__(self, count: int, length: float) -> None:
        self.count, self.length = count, length
        shape = count, len(settings.HELM_DELAYS), 4
        # Gains of 1, offset, heading, yaw rate
        self.gains = np.broadcast_to(np.array(settings.HELM_GAINS), shape).copy()
        self._walk = np.diag(np.array(settings.HELM_GAINS_SIGMA) ** 2) / settings.HELM_MEMORY
        self._covariance = np.broadcast_to(np.diag(np.array(settings.HELM_GAINS_SIGMA) ** 2), (*shape, 4)).copy()
        self._squares = np.full(shape[:2], (2 * settings.LEAST_HELM_SCATTER) ** 2)  # Squared deviations from the law
        self._past: deque[np.ndarray] = deque(maxlen=max(settings.HELM_DELAYS) + 1)
        self.unattended = np.full(count, 0.02)  # Chance that nobody steers [1]
        self.off = np.zeros(count)  # The rudder from the law's [rad]
        self.limit = np.full(count, settings.LEAST_HELM_LIMIT)  # The largest angle that is used [rad]
        self._held: np.ndarray | None = None  # Angle of the rudder since it last moved [rad]

    @property
    def _best(self) -> np.ndarray:
        return np.asarray(self._squares.argmin(axis=1))

    def update(self, y: np.ndarray, psi: np.ndarray, turn: np.ndarray, u: np.ndarray, rudder: np.ndarray) -> None:
        """Take in a second: offset [m], heading [rad] and yaw rate [rad/s] to the waterway, speed [m/s], rudder."""
        pace = self.length / np.maximum(u, 0.1)
        self._past.append(np.stack([np.ones_like(y), -y / self.length, -psi, -turn * pace], axis=-1))
        seen = np.stack([self._past[max(len(self._past) - 1 - delay, 0)] for delay in settings.HELM_DELAYS], axis=1)
        off = rudder[:, None] - (self.gains * seen).sum(axis=-1)
        here = np.arange(self.count), self._best
        self.off = off[here]
        self._judge(rudder)
        self._learn(seen, off, 1.0 - self.unattended)
        faded = self.limit * math.exp(-1.0 / settings.HELM_MEMORY)
        self.limit = np.maximum(np.maximum(faded, settings.LEAST_HELM_LIMIT), np.abs(rudder))

    def _judge(self, rudder: np.ndarray) -> None:
        self._held = rudder.copy() if self._held is None else self._held
        step = rudder - self._held
        moved = np.abs(step) > settings.RUDDER_MOVES
        # Only a move that brings the rudder nearer to the law shows a hand at work: a wrong order does not.
        steered = moved & (np.abs(self.off) < np.abs(self.off - step))
        self._held = np.where(moved, rudder, self._held)
        gone = self.unattended
        before = gone + (1.0 - gone) / settings.LAPSE_INTERVAL - gone / settings.RETURN_TIME
        scatter = np.sqrt(self._squares[np.arange(self.count), self._best])
        evidence = log_student(self.off, settings.UNATTENDED_SCATTER) - log_student(self.off, scatter)
        odds = np.log(before / (1.0 - before)) + evidence / settings.DEVIATION_TIME
        odds += steered * math.log(settings.UNATTENDED_MOVES * settings.ORDER_INTERVAL)
        self.unattended = np.clip(1.0 / (1.0 + np.exp(-odds)), *settings.UNATTENDED_BOUNDS)

    def _learn(self, seen: np.ndarray, off: np.ndarray, weight: np.ndarray) -> None:
        """One step of the Kalman filters; steps without a helmsman change nothing."""
        self._covariance += self._walk
        noise = self._squares * settings.ORDER_INTERVAL / np.maximum(weight, 1e-3)[:, None]
        shared = (self._covariance @ seen[..., None])[..., 0]
        gain = shared / ((shared * seen).sum(axis=-1) + noise)[..., None]
        self.gains += gain * off[..., None]
        self.gains[..., 1:] = np.maximum(self.gains[..., 1:], 0.0)
        self._covariance -= gain[..., None] * shared[..., None, :]
        share = weight[:, None] / settings.HELM_MEMORY
        self._squares += share * (np.maximum(off**2, settings.LEAST_HELM_SCATTER**2) - self._squares)

    def law(self, u: np.ndarray) -> dict[str, np.ndarray]:
        """Return the numbers of the law for a lane of each ship (``LineOfSight``)."""
        trim, by_y, by_psi, by_r = np.moveaxis(self.gains[np.arange(self.count), self._best], -1, 0)
        heading = np.maximum(by_psi, 0.05)
        return {
            "since": np.array(settings.HELM_DELAYS)[self._best] + 0.5 * settings.ORDER_INTERVAL, "trim": trim,
            "by_psi": heading, "line": np.zeros(self.count), "reach": by_y / self.length / heading,
            "by_r": by_r * self.length / np.maximum(u, 0.1), "most": self.limit,
        }  # fmt: skip


def log_student(off: np.ndarray, scale: float | np.ndarray) -> np.ndarray:
    """Log density of Student's t with ``HELM_FREEDOM`` degrees of freedom, less its constant."""
    freedom = settings.HELM_FREEDOM
    return np.asarray(-np.log(scale) - 0.5 * (freedom + 1.0) * np.log1p((off / scale) ** 2 / freedom))


REVOLUTIONS = "revolutions"


class Manoeuvre(NamedTuple):
    words: str  # Order after the first one
    kick: float = 1.0  # Revolutions over those of now [1]


# The best of 37 manoeuvres (angles back to the line, gains, counter rudder alone) in each case saves less than half a
# percent of the contacts more than the first one here: decisions/warning_scores.py.
STEADY = Manoeuvre("then steady parallel to the bank")
KICK = Manoeuvre("kick ahead, then steady parallel to the bank", settings.ENGINE_KICK)


@dataclass(frozen=True, repr=False)
class LineOfSight(BaseSummary):
    """Line-of-sight guidance with a proportional-derivative autopilot, after a time for which the rudder is held.

    Its heading to the line is less by ``crab``, the angle that a current across needs.

    Source: Fossen (2011), Handbook of Marine Craft Hydrodynamics and Motion Control, for guidance by line of sight.
    """

    driven: bool = False  # True where it also orders revolutions

    def parameters(self) -> Mapping[str, Any]:
        """Return its numbers as they are before they are loaded: all of them differ from lane to lane."""
        names = ("since", "ordered", "line", "reach", "approach", "crab", "by_psi", "by_r", "trim", "most")
        return dict.fromkeys(names, 1.0) | (dict.fromkeys(("turns", "kicked"), 0.0) if self.driven else {})

    def memory(self, start: Named) -> Named:
        return {}

    def orders(self, at: Any) -> tuple[Named, Named]:
        pace = at.u + at.current
        off = at.psi + at.crab - clip((at.line - at.y) * at.reach, at.approach)
        turn = at.r - at.water("curvature", at.x) * pace
        law = clip(at.trim - at.by_psi * off - at.by_r * turn, at.most)
        on = at.t - at.since + ORDER_TOLERANCE * at.dt
        orders: dict[str, Any] = {"rudder": choice(on, law, at.ordered)}
        if self.driven:
            orders[REVOLUTIONS] = choice(on, at.kicked, at.turns)
        return orders, {}


def escape_numbers(line: float, length: float, limit: float) -> dict[str, float]:
    """Return the law's numbers of an escape: hard over, and checked in time; ``by_r`` is divided by the speed [m/s]."""
    return {
        "line": line, "reach": 1.0 / (settings.REACH_LENGTHS * length), "approach": settings.ESCAPE_ANGLE, "trim": 0.0,
        "most": limit, "by_psi": settings.ESCAPE_HEADING_GAIN, "by_r": settings.ESCAPE_TURN_GAIN * length,
    }  # fmt: skip


RUDDER = "rudder"
# Flow [1] of a waterway below which an estimated current gives no information on that elsewhere: the tide turns there.
LEAST_FLOW = 0.1
# Outcomes of a lane in a bank, or across the canal, which is on the way there.
MEETS = (Code.GROUNDED, Code.DIVERGED, Code.OUTSIDE)
NEVER = 1e9


class Case(NamedTuple):
    """One future: the rudder as it is until a time, then a manoeuvre, or the helmsman's own steering."""

    duration: float  # Length of the forecast [s]
    since: float = NEVER  # When the rudder is taken over [s]
    manoeuvre: Manoeuvre | None = None  # None: the helmsman steers as in the last minutes
    ordered: float | None = None  # Rudder until then [rad]; None: as it is


class FutureBlock(NamedTuple):
    cases: Sequence[Case]  # Each of every ship
    ships: int  # Number of ships

    @property
    def lanes(self) -> int:
        return len(self.cases) * self.ships


class Ships(NamedTuple):
    columns: Mapping[str, np.ndarray]  # (ships,) x, y [m], psi [rad], u, v [m/s], r [rad/s]
    rudder: np.ndarray  # (ships,) Its true angle [rad]
    coefficients: Mapping[str, np.ndarray]  # (ships,) By name, those of the bank as strong as it is estimated
    helmsman: Mapping[str, np.ndarray]  # (ships,) Numbers of the law by which the helmsman steers


class Outcomes(NamedTuple):
    contact: np.ndarray  # (cases, ships) When a bank is met; infinite where none is [s]
    side: np.ndarray  # (cases, ships) Which: negative to port, positive to starboard


class FutureLanes:
    def __init__(
        self, ship: SimulatedShip, waterway: Waterway, line: float, blocks: Sequence[FutureBlock], step: float
    ) -> None:
        self.ship, self.waterway, self.blocks, self.line = ship, waterway, blocks, line
        self._driven = any(actuator.name == REVOLUTIONS for actuator in ship.actuators)
        steering = steering_of(LineOfSight(self._driven), ship.actuators)
        assert steering is not None
        lanes = sum(block.lanes for block in blocks)
        duration = np.concatenate([np.repeat([case.duration for case in b.cases], b.ships) for b in blocks])
        run = KernelRun(ship, duration, step, steering=steering, waterway=waterway)
        many = {name: np.full(lanes, value) for name, value in ship.model.coefficients.items()}
        many |= {name: np.full(lanes, value) for name, value in steering.parameters.items()}
        still = dict.fromkeys((*START, *FORCES, CURRENT_ACROSS), 0.0)
        self._prepared = run.prepared({**still, "u": 1.0, **many}, lanes, workers=1)
        self._prepared.limits[0] = settings.CONTACT_TOLERANCE * ship.model.configuration.ship.beam
        self._constants = ship.system(True, steering.law).constants
        self._ship_values = ship.values()
        kernel = self._prepared.kernel
        self._kept = {name: place for place, name in enumerate(kernel.KEPT_NAMES)}
        self._inputs = {name: place for place, name in enumerate(kernel.VESSEL_INPUTS)}

    def __call__(self, ships: Sequence[Ships], revolutions: float | None = None) -> list[Outcomes]:
        for lanes, block, own in zip(self._parts(), self.blocks, ships, strict=True):
            self._load(lanes, block, own, revolutions)
        self._prepared()
        codes, time = self._prepared.codes, self._prepared.time
        contact = np.where(np.isin(codes[:, 0], MEETS), time, np.inf)
        ends = []
        for lanes, block in zip(self._parts(), self.blocks, strict=True):
            shape = len(block.cases), block.ships
            ends.append(Outcomes(contact[lanes].reshape(shape), codes[lanes, 1].reshape(shape)))
        return ends

    def _parts(self) -> list[slice]:
        stops = np.cumsum([block.lanes for block in self.blocks]).tolist()
        return [slice(stop - block.lanes, stop) for stop, block in zip(stops, self.blocks, strict=True)]

    def _load(self, lanes: slice, block: FutureBlock, ships: Ships, revolutions: float | None) -> None:
        shape, columns = (len(block.cases), block.ships, -1), ships.columns
        rows = self._prepared.start[lanes].reshape(shape)
        inputs = self._prepared.vessel_inputs[lanes].reshape(shape)
        own: dict[str, Any] = {name: columns[name] for name in ("x", "y", "u", "v", "r")}
        own |= {"cos_psi": np.cos(columns["psi"]), "sin_psi": np.sin(columns["psi"]), RUDDER: ships.rudder}
        turns = self._ship_values.get(REVOLUTIONS) if revolutions is None else revolutions
        own |= {REVOLUTIONS: np.full(block.ships, turns)} if self._driven else {}
        # Orders that are on their way in a gear with dead time or lag: those of the rudder as it is.
        own |= stages_at(self.ship.actuators, own.__getitem__)
        for name, column in own.items():
            if name in self._kept:
                rows[..., self._kept[name]] = column
        constants = self._constants({**self._ship_values, **ships.coefficients})
        for name, column in {**constants, **self._currents(columns)}.items():
            if name in self._inputs:
                inputs[..., self._inputs[name]] = column
        for part, case in zip(inputs, block.cases, strict=True):
            for name, value in self._law(case, ships, turns).items():
                part[:, self._inputs[PARAMETER(name)]] = value

    def _currents(self, columns: Mapping[str, np.ndarray]) -> dict[str, Any]:
        """Return the current along the line where its flow is 1, and that across."""
        usual, flow = self.waterway.reference_current, self.waterway.flow(columns["x"])
        known = np.abs(flow) >= LEAST_FLOW
        along = np.where(known, columns[CURRENT] / np.where(known, flow, 1.0), usual) if CURRENT in columns else usual
        return {CURRENT_ACROSS: columns.get(CURRENT_ACROSS, 0.0), CURRENT: along}

    def _law(self, case: Case, ships: Ships, turns: Any) -> dict[str, Any]:
        hull, gear = self.ship.model.configuration.ship, self.ship.model.configuration.gear
        ordered = ships.rudder if case.ordered is None else case.ordered
        numbers: dict[str, Any] = {"since": case.since, "ordered": ordered}
        if case.manoeuvre is None:
            numbers |= {"approach": 10.0, "crab": 0.0, **ships.helmsman}
            numbers["since"] = np.maximum(numbers["since"], case.since)
        else:
            u = np.maximum(ships.columns["u"], 0.1)
            numbers |= escape_numbers(self.line, hull.length, gear.limit)
            numbers |= {"by_r": numbers["by_r"] / u, "crab": ships.columns.get(CURRENT_ACROSS, 0.0) / u}
        if self._driven:
            kick = case.manoeuvre.kick if case.manoeuvre else 1.0
            numbers |= {"turns": turns, "kicked": kick * turns}
        return numbers

    def poses(self) -> list[np.ndarray]:
        """Return where the futures of each block ended, after a call: x, y [m], psi [rad] (cases, ships, 3)."""
        end, kept = self._prepared.end, self._kept
        psi = np.arctan2(end[:, kept["sin_psi"]], end[:, kept["cos_psi"]])
        poses = np.stack([end[:, kept["x"]], end[:, kept["y"]], psi], axis=1)
        parts = zip(self._parts(), self.blocks, strict=True)
        return [poses[lanes].reshape(len(block.cases), block.ships, 3) for lanes, block in parts]
