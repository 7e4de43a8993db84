"""Monte Carlo trials of regulators: drawn ships, disturbances and sensor noise, in the kernel."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from narrows.codegen.free_motion import INPUTS
from narrows.codegen.run import PreparedRun
from narrows.control.linearization import linearize
from narrows.control.regulator import held_line
from narrows.control.regulator_gains import RegulatorWeights, regulator_gains
from narrows.control.regulator_law import FEEDBACK, HeldLine, Regulator
from narrows.control.settings import (
    LATE_LENGTHS,
    LEAD_TIME,
    TRIAL_HEADING,
    TRIAL_LENGTHS,
    TRIAL_NOISE,
    TRIAL_STEPS,
)
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.quantities.arithmetic import choice, maximum
from narrows.simulation.controllers import ControlLaw, Named
from narrows.simulation.grid import sampled
from narrows.simulation.kernel_run import PUSH_END, KernelRun
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import MEMORY, PARAMETER, steering_of

STATES = ("y", "psi", "v", "r")


class ScenePush(NamedTuple):
    start: float  # Start [time of a ship length]
    stop: float  # End, likewise
    force: float  # Sway force, relative to one that accelerates as fast as the moment of this rudder angle turns [rad]
    moment: float  # Yaw moment, as that of this rudder angle [rad]


class Scene(NamedTuple):
    offset: float  # Offset of the held line, relative to the requested one [1]
    begins: float  # Starting distance from that line [beams]
    pushes: tuple[ScenePush, ...] = ()


@dataclass(frozen=True)
class SeenWithNoise:
    """A law with white noise on its readings; it records the ship's late offset and the rudder travel."""

    law: ControlLaw
    noise: Mapping[str, float]  # Standard deviations of y [m], psi [rad], v [m/s], r [rad/s]
    late: Any  # Time from which the offset counts [s]

    def parameters(self) -> Mapping[str, Any]:
        return {**self.law.parameters(), **{f"noise_of_{n}": self.noise[n] for n in STATES}, "late_from": self.late}

    def memory(self, start: Named) -> Named:
        chaos = {f"chaos_{name}": 0.4 for name in STATES}
        return {**self.law.memory(start), **chaos, "farthest": 0.0, "travel": 0.0, "was": start["rudder"]}

    def orders(self, at: Any) -> tuple[Named, Named]:
        # The logistic map gives uncorrelated numbers from 0 to 1 of variance 1/8 by arithmetic alone. Ulam and von
        # Neumann (1947), Bulletin of the American Mathematical Society 53, 1120.
        chaos = {name: getattr(at, f"chaos_{name}") for name in STATES}
        seen = {n: getattr(at, n) + getattr(at, f"noise_of_{n}") * 8**0.5 * (chaos[n] - 0.5) for n in STATES}
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
        self.model, self.scenes, self.ships, self.speed = model, scenes, ships, u
        hull = model.configuration.ship
        self.time = hull.length / u
        sway, turn = TRIAL_NOISE
        defaults = {"y": sway * hull.beam, "psi": turn, "v": turn * u, "r": turn / self.time}
        self.noise = {**defaults, **(noise or {})}
        self.systems = [linearize(model, scene.offset * y, u) for scene in scenes]
        self._random = np.random.default_rng(seed)
        self._seed = seed

    @property
    def _half_beam(self) -> float:
        return self.model.configuration.ship.beam / 2

    def _each(self, values: Sequence[float] | np.ndarray) -> np.ndarray:
        """A column over all trials of one number per scene."""
        return np.repeat(np.asarray(values, float), self.ships)

    @cached_property
    def _law(self) -> SeenWithNoise:
        lines = [held_line(self.model, system) for system in self.systems]
        count = len(lines) * self.ships
        gains = [self._each([line.gains[place] for line in lines]) for place in range(len(FEEDBACK))]
        held = {name: self._each([getattr(line, name) for line in lines]) for name in ("y", "rudder", "psi", "v")}
        line = HeldLine(held["y"], tuple(gains), held["rudder"], held["psi"], held["v"])
        lead = np.full(count, LEAD_TIME * self.time)
        law = Regulator((line,), np.full(count, self.speed), lead, np.full(count, self.time))
        return SeenWithNoise(law, self.noise, (TRIAL_LENGTHS - LATE_LENGTHS) * self.time)

    @cached_property
    def _prepared(self) -> PreparedRun:
        ship, line = SimulatedShip(self.model), self._law.law.lines[0]  # type: ignore[attr-defined]
        count = len(self.scenes) * self.ships
        steering = steering_of(self._law, ship.actuators)
        assert steering is not None
        drawn = {}
        if self.model.covariance is not None:
            columns = sampled(self.model, self.ships, self._seed)
            drawn = {name: np.tile(column.to_numpy(), len(self.scenes)) for name, column in columns.items()}
        psi = line.psi + TRIAL_HEADING * self._random.standard_normal(count)
        y = line.y + self._each([scene.begins for scene in self.scenes]) * 2 * self._half_beam
        start = {"x": 0.0, "y": y, "psi": psi, "u": self.speed, "v": line.v, "r": 0.0, "rudder": line.rudder}
        forces = {"X": 0.0, "Y": np.zeros(count), "N": np.zeros(count), PUSH_END: np.inf}
        turns = {name: float(self.systems[0].course[name]) for name in ("revolutions",) if self.model.terms.propelled}
        run = KernelRun(ship, TRIAL_LENGTHS * self.time, self.step, steering=steering)
        prepared = run.prepared({**start, **turns, **forces, **drawn, **steering.parameters}, count, 1)
        kept = prepared.kernel.KEPT_NAMES
        for name in STATES:
            prepared.start[:, kept.index(MEMORY(f"chaos_{name}"))] = self._random.uniform(0.05, 0.95, count)
        return prepared

    @cached_property
    def _begun(self) -> np.ndarray:
        return np.array(self._prepared.start)

    @property
    def step(self) -> float:
        return self.time / TRIAL_STEPS

    @cached_property
    def _segments(self) -> list[tuple[int, dict[str, np.ndarray]]]:
        """Steps between changes of the external forces, and the forces in them."""
        times = {0.0, TRIAL_LENGTHS, *(t for scene in self.scenes for push in scene.pushes for t in push[:2])}
        steps = sorted(round(time * TRIAL_STEPS) for time in times)
        system = self.systems[0]
        turn, rudder = system.states.index("r"), system.controls.index("rudder")
        moment = float(system.B[turn, rudder] / system.G[turn, system.disturbances.index("N")])
        force = moment / self.model.configuration.ship.length
        segments = []
        for first, last in pairwise(steps):
            now = [[p for p in scene.pushes if p.start * TRIAL_STEPS - 0.5 <= first < p.stop * TRIAL_STEPS - 0.5]
                   for scene in self.scenes]  # fmt: skip
            Y = self._each([force * sum(push.force for push in pushes) for pushes in now])
            N = self._each([moment * sum(push.moment for push in pushes) for pushes in now])
            segments.append((last - first, {INPUTS["Y"]: Y, INPUTS["N"]: N}))
        return segments

    def run(self, weights: RegulatorWeights) -> TrialResult | None:
        """Simulate every scene under the regulator of these weights; None if there is no such regulator."""
        try:
            gains = np.array([regulator_gains(self.model, system, weights) for system in self.systems])
        except InputError:
            return None
        run = self._prepared
        self._begun  # noqa: B018  # as it is before the first trial
        inputs = list(run.kernel.VESSEL_INPUTS)
        for place, name in enumerate(FEEDBACK):
            run.vessel_inputs[:, inputs.index(PARAMETER(f"by_{name}_0"))] = self._each(gains[:, place])
        run.vessel_inputs[:, inputs.index(PARAMETER("unwinding"))] = weights.unwinding_time * self.time
        run.start[:], alive = self._begun, np.ones(len(run.start), bool)
        for steps, forces in self._segments:
            for name, column in forces.items():
                run.vessel_inputs[:, inputs.index(name)] = column
            run.times[:, 0], run.times[:, 1], run.times[:, 2] = self.step, np.where(alive, steps, 0), 0.0
            run()
            alive &= run.codes[:, 0] == 0
            run.start[:] = np.where(alive[:, None], run.end, run.start)
        kept, shape = run.kernel.KEPT_NAMES, (len(self.scenes), self.ships)
        off = np.where(alive, run.start[:, kept.index(MEMORY("farthest"))] / self._half_beam, np.inf).reshape(shape)
        return TrialResult(off > 1.0, off, run.start[:, kept.index(MEMORY("travel"))].reshape(shape))
