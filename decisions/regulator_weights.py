"""Default weights of the regulator: tuned by trials of the KCS at full size, with a gear, at two covariances.

The KCS of 230 m sails with the covariance of its tests, which counts twice, and with 2.5 times its standard deviations,
about those of a ship without tests. The gear has 1 s of dead time and 1.5 s of lag. The printed weights are rounded by
hand into ``RegulatorWeights``. For another ship, change ``HOLD``, ``SPEED``, ``GEAR`` and the model in ``trials``.

Ships with coefficients from the model's covariance sail four scenes: an offset, a receding bank, gusts, and both far
off the centreline. A ship is lost if it meets a bank, or if it is still half a beam off its line at the end. The
objective is the share of lost ships, plus small shares for late offset and rudder travel; other ships test the weights.

Source: Nelder and Mead (1965), A simplex method for function minimization, The Computer Journal 7(4), 308-313.

python decisions/regulator_weights.py
"""

import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

import narrows as nw
from narrows.base.errors import InputError
from narrows.codegen.free_motion import INPUTS
from narrows.control.regulator import (
    DEFAULT_WEIGHTS,
    FEEDBACK,
    HeldLine,
    Regulator,
    RegulatorWeights,
    held_line,
    regulator_gains,
)
from narrows.control.settings import LEAD_TIME
from narrows.control.steady_course import linearize
from narrows.quantities.arithmetic import choice, maximum
from narrows.simulation.controllers import ControlLaw, Named
from narrows.simulation.grid import sampled
from narrows.simulation.kernel_run import PUSH_END, KernelRun
from narrows.simulation.ship import MEMORY, PARAMETER, SimulatedShip, steering_of

sys.path.append(str(Path(__file__).parent.parent / "benchmarks"))
from envelope import full_scale

HOLD, SPEED, GEAR = 50.0, 4.5, nw.SteeringGear(dead_time=1.0, lag=1.5)
DOUBTS = {1.0: 2.0, 2.5: 1.0}
"""Factor of the standard deviations, and how much its trials count."""
# Trials of a regulator design: length [ship lengths], its last part in which the offset counts, steps per length.
TRIAL_LENGTHS, LATE_LENGTHS, TRIAL_STEPS = 11.7, 1.2, 50
# Standard deviations of readings: offset [beams]; heading [rad], also the share of speed in sway and of turn in yaw.
TRIAL_NOISE = 0.01, np.radians(0.1)
# Standard deviation of the heading at the start [rad].
TRIAL_HEADING = np.radians(1.0)
# Cost of a design besides the share of lost ships, as shares of a lost ship [1]: late offset of half a beam, and rudder
# travel of so much per ship length [rad].
OFF_SHARE, TRAVEL_SHARE, FULL_TRAVEL = 0.3, 0.1, np.radians(10.0)
# First step of the search, in logarithms [1]; designs of a round; ratio of testing to tuning ships.
DESIGN_STEP, DESIGNS_A_ROUND, DESIGN_JUDGES = 0.3, 12, 10


class ScenePush(NamedTuple):
    start: float  # Start [time of a ship length]
    stop: float  # End, likewise
    force: float  # Sway force, relative to one that accelerates as fast as the moment of this rudder angle turns [rad]
    moment: float  # Yaw moment, as that of this rudder angle [rad]


class Scene(NamedTuple):
    offset: float  # Offset of the held line, relative to the requested one [1]
    begins: float  # Starting distance from that line [beams]
    pushes: tuple[ScenePush, ...] = ()


SIX, FIVE = math.radians(6.0), math.radians(5.0)
# Test scenes: an offset, a bank that recedes twice, gusts, and a gust and a receding bank far off the centreline.
SCENES = {
    "offset": Scene(0.8, 0.3),
    "bank": Scene(1.0, 0.0, (ScenePush(2.0, 3.5, 0.0, SIX), ScenePush(5.9, 7.4, 0.0, -SIX))),
    "gust": Scene(0.8, 0.0, (ScenePush(2.0, 3.2, SIX, FIVE), ScenePush(5.9, 7.0, -SIX, -FIVE))),
    "hard": Scene(1.3, 0.0, (ScenePush(2.0, 3.2, 1.5 * SIX, 1.5 * FIVE), ScenePush(4.9, 6.1, 0.0, FIVE))),
}
# Tuned weights, as logarithms; the share of the bank is tuned on its own scale.
TUNED = ("heading_deg", "rudder_deg", "stroke_time", "integral_time", "unwinding_time")


@dataclass(frozen=True)
class SeenWithNoise:
    """A law with white noise on its readings; it records the ship's late offset and the rudder travel."""

    law: ControlLaw
    noise: Mapping[str, float]  # Standard deviations of y [m], psi [rad], v [m/s], r [rad/s]
    late: Any  # Time from which the offset counts [s]

    def parameters(self) -> Mapping[str, Any]:
        noise = {f"noise_of_{name}": self.noise[name] for name in FEEDBACK[:4]}
        return {**self.law.parameters(), **noise, "late_from": self.late}

    def memory(self, start: Named) -> Named:
        chaos = {f"chaos_{name}": 0.4 for name in FEEDBACK[:4]}
        return {**self.law.memory(start), **chaos, "farthest": 0.0, "travel": 0.0, "was": start["rudder"]}

    def orders(self, at: Any) -> tuple[Named, Named]:
        # The logistic map gives uncorrelated numbers from 0 to 1 of variance 1/8 by arithmetic alone. Ulam and von
        # Neumann (1947), Bulletin of the American Mathematical Society 53, 1120.
        chaos = {name: getattr(at, f"chaos_{name}") for name in FEEDBACK[:4]}
        seen = {n: getattr(at, n) + getattr(at, f"noise_of_{n}") * 8**0.5 * (chaos[n] - 0.5) for n in FEEDBACK[:4]}
        orders, memory = self.law.orders(SimpleNamespace(**{**vars(at), **seen}))
        kept = {f"chaos_{name}": 4.0 * value * (1.0 - value) for name, value in chaos.items()}
        off = choice(at.t + at.dt / 2 - at.late_from, abs(at.y - at.held_y_0), 0.0)
        record = {"farthest": maximum(at.farthest, off), "travel": at.travel + abs(at.rudder - at.was)}
        return orders, {**memory, **kept, **record, "was": at.rudder}


class TrialResult(NamedTuple):
    lost: np.ndarray  # (scenes, ships) Aground, or more than half a beam off the line at the end
    off: np.ndarray  # (scenes, ships) Late offset [half beams]; infinite if aground
    travel: np.ndarray  # (scenes, ships) Rudder travel [rad]


class DesignTrials:
    """Scenes of sampled ships, with arrays allocated once."""

    def __init__(
        self, model: nw.Model, y: float, u: float, scenes: Sequence[Scene], ships: int, seed: int,
        noise: Mapping[str, float] | None = None,
    ) -> None:  # fmt: skip
        self.model, self.scenes, self.ships = model, scenes, ships
        self.systems = [linearize(model, scene.offset * y, u) for scene in scenes]
        hull, ship, random = model.configuration.ship, SimulatedShip(model), np.random.default_rng(seed)
        self.time, self._half_beam, trials = hull.length / u, hull.beam / 2, len(scenes) * ships
        sway, turn = TRIAL_NOISE
        defaults = {"y": sway * hull.beam, "psi": turn, "v": turn * u, "r": turn / self.time}
        lines = [held_line(model, system) for system in self.systems]
        names = "y", "rudder", "psi", "v"
        held, rudder, course, drift = (self._each([getattr(line, name) for line in lines]) for name in names)
        # Each trial sets the gains and the time of unwinding.
        line = HeldLine(held, (0.0,) * len(FEEDBACK), rudder, course, drift)
        law = Regulator((line,), u, LEAD_TIME * self.time, self.time)
        late = (TRIAL_LENGTHS - LATE_LENGTHS) * self.time
        steering = steering_of(SeenWithNoise(law, {**defaults, **(noise or {})}, late), ship.actuators)
        assert steering is not None
        drawn = {name: np.tile(column, len(scenes)) for name, column in sampled(model, ships, seed).items()}
        psi = course + TRIAL_HEADING * random.standard_normal(trials)
        y_start = held + self._each([scene.begins for scene in scenes]) * hull.beam
        start = {"x": 0.0, "y": y_start, "psi": psi, "u": u, "v": drift, "r": 0.0, "rudder": rudder}
        forces = {"X": 0.0, "Y": np.zeros(trials), "N": np.zeros(trials), PUSH_END: np.inf}
        turns = {name: float(self.systems[0].course[name]) for name in ("revolutions",) if model.terms.propelled}
        run = KernelRun(ship, TRIAL_LENGTHS * self.time, self.time / TRIAL_STEPS, steering=steering)
        self._run = run.prepared({**start, **turns, **forces, **drawn, **steering.parameters}, trials, 1)
        self._kept = self._run.kernel.KEPT_NAMES
        for name in FEEDBACK[:4]:
            self._run.start[:, self._kept.index(MEMORY(f"chaos_{name}"))] = random.uniform(0.05, 0.95, trials)
        self._begun, self._segments = np.array(self._run.start), list(self._pushed())

    def _each(self, values: Sequence[float] | np.ndarray) -> np.ndarray:
        return np.repeat(np.asarray(values, float), self.ships)

    def _pushed(self) -> Iterator[tuple[int, dict[str, np.ndarray]]]:
        """Yield the steps between changes of the external forces, and the forces in them."""
        times = {0.0, TRIAL_LENGTHS, *(t for scene in self.scenes for push in scene.pushes for t in push[:2])}
        steps = sorted(round(time * TRIAL_STEPS) for time in times)
        system = self.systems[0]
        turn, rudder = system.states.index("r"), system.controls.index("rudder")
        moment = float(system.B[turn, rudder] / system.G[turn, system.disturbances.index("N")])
        force = moment / self.model.configuration.ship.length
        for first, last in pairwise(steps):
            now = [[p for p in scene.pushes if p.start * TRIAL_STEPS - 0.5 <= first < p.stop * TRIAL_STEPS - 0.5]
                   for scene in self.scenes]  # fmt: skip
            Y = self._each([force * sum(push.force for push in pushes) for pushes in now])
            N = self._each([moment * sum(push.moment for push in pushes) for pushes in now])
            yield last - first, {INPUTS["Y"]: Y, INPUTS["N"]: N}

    def run(self, weights: RegulatorWeights) -> TrialResult | None:
        """Simulate every scene under the regulator of these weights; None if there is no such regulator."""
        try:
            gains = np.array([regulator_gains(self.model, system, weights) for system in self.systems])
        except InputError:
            return None
        run, inputs = self._run, list(self._run.kernel.VESSEL_INPUTS)
        for place, name in enumerate(FEEDBACK):
            run.vessel_inputs[:, inputs.index(PARAMETER(f"by_{name}_0"))] = self._each(gains[:, place])
        run.vessel_inputs[:, inputs.index(PARAMETER("unwinding"))] = weights.unwinding_time * self.time
        run.start[:], alive = self._begun, np.ones(len(run.start), bool)
        for steps, forces in self._segments:
            for name, column in forces.items():
                run.vessel_inputs[:, inputs.index(name)] = column
            run.times[:, 0], run.times[:, 1], run.times[:, 2] = self.time / TRIAL_STEPS, np.where(alive, steps, 0), 0.0
            run()
            alive &= run.codes[:, 0] == 0
            run.start[:] = np.where(alive[:, None], run.end, run.start)
        farthest, travel = (run.start[:, self._kept.index(MEMORY(name))] for name in ("farthest", "travel"))
        shape = len(self.scenes), self.ships
        off = np.where(alive, farthest / self._half_beam, np.inf).reshape(shape)
        return TrialResult(off > 1.0, off, travel.reshape(shape))


def weights_at(point: np.ndarray) -> RegulatorWeights | None:
    tuned: dict[str, Any] = {n: getattr(RegulatorWeights, n) * math.exp(p) for n, p in zip(TUNED, point, strict=False)}
    bank = float(point[-1])
    return RegulatorWeights(**tuned, bank=bank) if 0.0 <= bank <= 1.0 else None


def cost_of(result: TrialResult) -> float:
    late = np.minimum(result.off, 3.0).mean()
    usual = FULL_TRAVEL * TRIAL_LENGTHS
    travel = np.minimum(result.travel, 2 * usual).mean() / usual
    return float(result.lost.mean() + OFF_SHARE * late + TRAVEL_SHARE * travel)


def searched(cost: Callable[[np.ndarray], float], start: np.ndarray, rounds: int) -> np.ndarray:
    """Return the best point of a simplex search that stays away from infinite costs."""
    from scipy.optimize import minimize

    # The last number, the bank's share, moves down: it may be 1 already.
    steps = DESIGN_STEP * np.append(np.ones(len(start) - 1), -1.0)
    corners = start + np.vstack([np.zeros(len(start)), np.diag(steps)])
    most = DESIGNS_A_ROUND * rounds
    options: Any = {"maxfev": most, "initial_simplex": corners, "xatol": 1e-4, "fatol": 0.0}
    return np.asarray(minimize(cost, start, method="Nelder-Mead", options=options).x)


def trials(ships: int, seed: int) -> list[tuple[float, DesignTrials]]:
    ship, scenes = full_scale(), tuple(SCENES.values())
    model = replace(ship, configuration=replace(ship.configuration, steering=GEAR))
    doubtful = {size: replace(model, covariance=model.covariance * size**2) for size in DOUBTS}
    return [(DOUBTS[size], DesignTrials(own, HOLD, SPEED, scenes, ships, seed)) for size, own in doubtful.items()]


def main(ships: int = 250, rounds: int = 30) -> None:
    tuning = trials(ships, 5)

    def cost(point: np.ndarray) -> float:
        weights = weights_at(point)
        results = [(share, trial.run(weights)) for share, trial in tuning] if weights else [(1.0, None)]
        return sum(math.inf if one is None else share * cost_of(one) for share, one in results)

    found = weights_at(searched(cost, np.append(np.zeros(len(TUNED)), DEFAULT_WEIGHTS.bank), rounds))
    print(found)
    for _, trial in trials(DESIGN_JUDGES * ships, 99):
        for weights in (found, DEFAULT_WEIGHTS):
            result = trial.run(weights)
            print(dict(zip(SCENES, (1000 * result.lost.mean(axis=1)).round(), strict=True)))


if __name__ == "__main__":
    main()
