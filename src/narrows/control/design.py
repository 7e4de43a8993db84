"""Tune the weights of a regulator by simulated voyages of sampled ships, and test them on other ships (Monte Carlo)."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, check_count
from narrows.base.progress import bar
from narrows.base.results import BaseSummary
from narrows.codegen.free_motion import INPUTS
from narrows.control import settings
from narrows.control.regulator import (
    FEEDBACK,
    HeldLine,
    Regulator,
    RegulatorWeights,
    held_line,
    regulator,
    regulator_gains,
)
from narrows.control.settings import TRIAL_LENGTHS, TRIAL_STEPS
from narrows.control.steady_course import check_rudder, linearize
from narrows.model.model import Model
from narrows.quantities.arithmetic import choice, maximum
from narrows.ship.actuators import SteeringGear
from narrows.simulation.controllers import ControlLaw, Named
from narrows.simulation.grid import sampled
from narrows.simulation.inputs import finite_numbers
from narrows.simulation.kernel_run import PUSH_END, KernelRun
from narrows.simulation.ship import MEMORY, PARAMETER, SimulatedShip, steering_of

if TYPE_CHECKING:
    import pandas as pd


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
        self, model: Model, y: float, u: float, scenes: Sequence[Scene], ships: int, seed: int,
        noise: Mapping[str, float] | None = None,
    ) -> None:  # fmt: skip
        self.model, self.scenes, self.ships = model, scenes, ships
        self.systems = [linearize(model, scene.offset * y, u) for scene in scenes]
        hull, ship, random = model.configuration.ship, SimulatedShip(model), np.random.default_rng(seed)
        self.time, self._half_beam, trials = hull.length / u, hull.beam / 2, len(scenes) * ships
        sway, turn = settings.TRIAL_NOISE
        defaults = {"y": sway * hull.beam, "psi": turn, "v": turn * u, "r": turn / self.time}
        lines = [held_line(model, system) for system in self.systems]
        names = "y", "rudder", "psi", "v"
        held, rudder, course, drift = (self._each([getattr(line, name) for line in lines]) for name in names)
        # Each trial sets the gains and the time of unwinding.
        line = HeldLine(held, (0.0,) * len(FEEDBACK), rudder, course, drift)
        law = Regulator((line,), u, settings.LEAD_TIME * self.time, self.time)
        late = (TRIAL_LENGTHS - settings.LATE_LENGTHS) * self.time
        steering = steering_of(SeenWithNoise(law, {**defaults, **(noise or {})}, late), ship.actuators)
        assert steering is not None
        drawn = {name: np.tile(column, len(scenes)) for name, column in sampled(model, ships, seed).items()}
        psi = course + settings.TRIAL_HEADING * random.standard_normal(trials)
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


@dataclass(frozen=True, repr=False)
class RegulatorDesign(BaseSummary):
    """A regulator designed by simulation; the result of ``design``."""

    model: Model  # The ship
    y: float  # Design offset [m]
    u: float  # Surge velocity [m/s]
    weights: RegulatorWeights  # Weights with the lowest cost: lost ships, late offset and rudder travel
    # By scene: the shares of other ships that are ``lost``, the same with the default weights (``usual``), and the
    # median ``travel`` of the rudder of both [rad]
    judged: Mapping[str, Mapping[str, float]]

    @property
    def regulator(self) -> Regulator:
        """The regulator at the design offset and speed."""
        return regulator(self.model, self.y, self.u, weights=self.weights)

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the test results, one row per scene."""
        import pandas as pd

        return pd.DataFrame.from_dict({name: dict(row) for name, row in self.judged.items()}, orient="index")

    def summary(self) -> str:
        parts = [f"{name} {1000 * row['lost']:.0f} ({1000 * row['usual']:.0f})" for name, row in self.judged.items()]
        lost = f"Ships lost per 1000 test ships (default weights in brackets): {', '.join(parts)}."
        return " ".join([lost, *self.model.notes])


@accept_aliases
def design(
    model: Model, y: float, u: float, *, gear: SteeringGear | None = None, noise: Mapping[str, float] | None = None,
    ships: int = 200, rounds: int = 20, seed: int = 0, progress: bool = False,
) -> RegulatorDesign:  # fmt: skip
    """Tune the weights of a regulator by simulated voyages of sampled ships, with the gear's delays and noise.

    Ships with coefficients from the model's covariance sail four scenes: an offset, a receding bank, gusts, and both
    far off the centreline. A ship is lost if it meets a bank, or if it is still half a beam off its line at the end.
    The objective is the share of lost ships, plus small shares for late offset and rudder travel; other ships test it.

    Source: Nelder and Mead (1965), A simplex method for function minimization, The Computer Journal 7(4), 308-313.

    Parameters
    ----------
    model, gear : Model, SteeringGear, optional
        A model with terms of a rudder and the covariance of its coefficients; another gear than its own.
    y, u : float
        Offset to hold, to starboard of the centreline [m], and surge velocity through the water [m/s].
    noise : mapping of str to float, optional
        Standard deviations of the regulator's readings: y [m], psi [rad], v [m/s], r [rad/s].
    ships, rounds, seed, progress : int, int, int, bool
        Number of ships for tuning (ten times as many are used for testing), rounds of the search of twelve designs
        each, seed of all random numbers, a bar on stderr.
    """
    check_rudder(model)
    if model.covariance is None:
        raise InputError("a design draws ships from the covariance of the coefficients; identify the model from tests")
    finite_numbers(y=y, u=u, **(noise or {}))
    check_count("ships", ships, 10)
    check_count("rounds", rounds, 1)
    check_count("seed", seed)
    geared = model if gear is None else with_gear(model, gear)
    scenes = tuple(SCENES.values())
    trials = DesignTrials(geared, y, u, scenes, ships, seed, noise)

    def cost(point: np.ndarray) -> float:
        advance(1)
        weights = weights_at(point)
        result = trials.run(weights) if weights else None
        return math.inf if result is None else cost_of(result)

    with bar(settings.DESIGNS_A_ROUND * rounds, progress, "designs") as advance:
        best = searched(cost, np.append(np.zeros(len(TUNED)), RegulatorWeights.bank), rounds)
    weights = weights_at(best) or RegulatorWeights()
    judge = DesignTrials(geared, y, u, scenes, settings.DESIGN_JUDGES * ships, seed + 1, noise)
    tuned, default = judge.run(weights), judge.run(RegulatorWeights())
    assert tuned is not None
    assert default is not None
    judged = {
        name: {
            "lost": float(tuned.lost[row].mean()), "usual": float(default.lost[row].mean()),
            "travel": float(np.median(tuned.travel[row])), "usual_travel": float(np.median(default.travel[row])),
        }
        for row, name in enumerate(SCENES)
    }  # fmt: skip
    return RegulatorDesign(geared, float(y), float(u), weights, judged)


def with_gear(model: Model, gear: SteeringGear) -> Model:
    return replace(model, configuration=replace(model.configuration, steering=gear))


def weights_at(point: np.ndarray) -> RegulatorWeights | None:
    tuned: dict[str, Any] = {n: getattr(RegulatorWeights, n) * math.exp(p) for n, p in zip(TUNED, point, strict=False)}
    bank = float(point[-1])
    return RegulatorWeights(**tuned, bank=bank) if 0.0 <= bank <= 1.0 else None


def cost_of(result: TrialResult) -> float:
    late = np.minimum(result.off, 3.0).mean()
    usual = settings.FULL_TRAVEL * TRIAL_LENGTHS
    travel = np.minimum(result.travel, 2 * usual).mean() / usual
    return float(result.lost.mean() + settings.OFF_SHARE * late + settings.TRAVEL_SHARE * travel)


def searched(cost: Callable[[np.ndarray], float], start: np.ndarray, rounds: int) -> np.ndarray:
    """Return the best point of a simplex search that stays away from infinite costs."""
    from scipy.optimize import minimize

    # The last number, the bank's share, moves down: it may be 1 already.
    steps = settings.DESIGN_STEP * np.append(np.ones(len(start) - 1), -1.0)
    corners = start + np.vstack([np.zeros(len(start)), np.diag(steps)])
    most = settings.DESIGNS_A_ROUND * rounds
    options: Any = {"maxfev": most, "initial_simplex": corners, "xatol": 1e-4, "fatol": 0.0}
    return np.asarray(minimize(cost, start, method="Nelder-Mead", options=options).x)
