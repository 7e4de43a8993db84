"""Helms on five scenes, the truth's coefficients drawn from the covariance and the measurements noisy.

A 230 m container ship in a canal 300 m wide: a line 10 m further off, a bank that recedes for 80 s (the moment of 6
degrees of rudder), gusts of 15 m/s, a bend of 2500 m, and all at once 65 m off the middle in 18 m/s of wind. The helm
knows the mean coefficients; which truth it steers it does not know.

python benchmarks/helm_scenes.py [TRUTHS] [--small]
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from common import machine, sizes
from envelope import full_scale
from rich.console import Console
from rich.table import Table

import narrows as nw
from narrows.quantities.arithmetic import COLUMNS
from narrows.simulation.controllers import Asked, VoyageState
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.samples import sampled
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import PARAMETER, steering_of
from narrows.waterway import Bank, Centreline, Waterway

SPEED, DURATION, DT, LATE = 4.5, 600, 1.0, 60
RADIUS, BEND, STEP = 2500.0, (650.0, 1640.0), 10.0
NOISE = {"y": 0.3, "psi": np.radians(0.05), "v": 0.01, "r": np.radians(0.002)}
"""Of what a helm is told, standard deviations: m, rad, m/s, rad/s."""
AREA, LEVER = 6000.0, 20.0
"""Of the ship above the water [m2], and of the wind forward of midship [m]."""
Push = tuple[float, float, float, float]


@dataclass(frozen=True)
class Scene:
    """What happens in ten minutes: the lines to hold (time, offset), pushes (from, to, Y, N), where."""

    lines: tuple[tuple[float, float], ...]
    pushes: tuple[Push, ...] = ()
    waterway: Waterway | None = None

    def wanted(self, t: float) -> float:
        """The offset to hold."""
        return [y for start, y in self.lines if start <= t + 1e-9][-1]

    def push(self, t: float) -> tuple[float, float]:
        """Sway force and yaw moment."""
        acting = [(Y, N) for start, stop, Y, N in self.pushes if start <= t < stop]
        return (sum(Y for Y, _ in acting), sum(N for _, N in acting))


def bend(model: nw.Model) -> Waterway:
    """Straight on, 990 m of bend to starboard, and straight on."""
    canal, s = model.configuration.canal, STEP * np.arange(500)
    curvature = np.where((s > BEND[0]) & (s < BEND[1]), 1 / RADIUS, 0.0)
    heading = np.cumsum((curvature[1:] + curvature[:-1]) / 2 * STEP) - curvature[1:] * STEP / 2
    way = np.cumsum(STEP * np.stack([np.sin(heading), np.cos(heading)], axis=1), axis=0)
    line = Centreline(np.concatenate([[[0.0, 0.0]], way]))
    ends, half = np.array([0.0, line.length]), np.full(2, canal.width / 2)
    return Waterway(line, Bank("starboard", ends, half), Bank("port", ends, half), (ends, np.full(2, canal.depth)))


def scenes(model: nw.Model) -> dict[str, Scene]:
    """The five scenes of one ship."""
    linear = nw.control.linearize(model, y=0.0, u=SPEED)
    turn = linear.states.index("r")
    moment = float(linear.B[turn, 0] / linear.G[turn, linear.disturbances.index("N")])  # of a radian of rudder
    gust, storm = nw.wind_force(15.0, AREA), nw.wind_force(18.0, AREA)
    six, five = np.radians(6) * moment, np.radians(5) * moment
    return {
        "offset": Scene(((0.0, 40.0), (60.0, 50.0), (330.0, 40.0))),
        "bank": Scene(((0.0, 50.0),), ((100, 180, 0.0, six), (300, 380, 0.0, -six))),
        "gust": Scene(((0.0, 40.0),), ((100, 160, gust, LEVER * gust), (300, 360, -gust, -LEVER * gust))),
        "bend": Scene(((0.0, 0.0),), (), bend(model)),
        "hard": Scene(((0.0, 65.0),), ((100, 160, storm, LEVER * storm), (250, 310, 0.0, five))),
    }  # fmt: skip


@dataclass
class Fleet:
    """Truths of one model that sail abreast, a step a call, each with an order and a push of its own."""

    model: nw.Model
    count: int
    seed: int = 7
    waterway: Waterway | None = None
    state: dict[str, np.ndarray] = field(default_factory=dict)

    @cached_property
    def truths(self) -> dict[str, np.ndarray]:
        """Coefficients."""
        return {name: column.to_numpy() for name, column in sampled(self.model, self.count, self.seed).items()}

    def holdable(self, scene: Scene) -> np.ndarray:
        """Which of them some rudder angle holds on every line of a scene."""
        holds = np.ones(self.count, bool)
        for _, y in scene.lines:
            course = nw.steady_course(self.model, y=y, u=SPEED, samples=self.count, seed=self.seed)
            rudder = course["rudder"].to_numpy()
            holds &= np.abs(rudder) <= self.model.configuration.gear.limit
        return holds

    def begin(self, y: Any, psi: Any, v: float, rudder: float) -> None:
        """Place every ship."""
        columns = {"x": 200.0, "y": y, "u": SPEED, "v": v, "r": 0.0, "rudder": rudder, "cos_psi": np.cos(psi)}
        columns |= {"sin_psi": np.sin(psi), "t": 0.0}
        self.state = {name: np.full(self.count, column, float) for name, column in columns.items()}
        ship = SimulatedShip(self.model)
        run = KernelRun(ship, DT, DT, steering=steering_of(Asked(), ship.actuators), waterway=self.waterway)
        each = np.zeros(self.count)
        values = {**self.state, **self.truths, "psi": each, "X": each, "Y": each, "N": each, "push_end": np.inf}
        self.sailing = run.prepared({**values, PARAMETER("order"): each}, self.count, 1)
        self.kept, self.inputs = self.sailing.kernel.KEPT_NAMES, self.sailing.kernel.VESSEL_INPUTS
        self.alive, self.travel = np.ones(self.count, bool), np.zeros(self.count)

    def step(self, order: np.ndarray, push: tuple[float, float]) -> None:
        """Sail a step; a ship that touches a bank stays where it is."""
        columns = {PARAMETER("order"): order, "Y_in": push[0], "N_in": push[1]}
        for name, column in columns.items():
            self.sailing.vessel_inputs[:, self.inputs.index(name)] = column
        for index, name in enumerate(self.kept):
            self.sailing.start[:, index] = self.state[name]
        self.sailing()
        self.alive &= self.sailing.codes[:, 0] == 0
        after = dict(zip(self.kept, self.sailing.end.T, strict=True))
        self.travel += np.abs(after["rudder"] - self.state["rudder"]) * self.alive
        for name, column in after.items():
            self.state[name] = np.where(self.alive, column, self.state[name])

    def told(self, rng: np.random.Generator) -> dict[str, np.ndarray]:
        """What a helm is told."""
        off = {name: size * rng.standard_normal(self.count) for name, size in NOISE.items()}
        psi = np.arctan2(self.state["sin_psi"], self.state["cos_psi"]) + off.pop("psi")
        seen = {name: self.state[name] + off.get(name, 0.0) for name in ("x", "y", "u", "v", "r", "rudder", "t")}
        return {**seen, "cos_psi": np.cos(psi), "sin_psi": np.sin(psi), "psi": psi}


class Laws:
    """One control law on all ships."""

    def __init__(self, law: Any, fleet: Fleet) -> None:
        ship = SimulatedShip(fleet.model)
        steering = steering_of(law, ship.actuators)
        self.tape, self.memory = steering.law.tape, steering.memory({})
        self.inputs = {**ship.values(), **steering.parameters, "step_length": DT, "current": 0.0}
        way = fleet.waterway
        bends = (
            (lambda x: way.line.curvature(np.clip(x, 0, way.line.length))) if way else (lambda x: np.zeros(np.shape(x)))
        )
        self.functions = {**COLUMNS, "water_curvature": bends}

    def __call__(self, told: Mapping[str, np.ndarray], alive: np.ndarray) -> np.ndarray:
        """The orders."""
        results = self.tape.replay({**self.inputs, **told, **self.memory}, functions=self.functions)
        self.memory = {name: results[name] for name in self.memory}
        return np.broadcast_to(results["rudder"], alive.shape)


class Objects:
    """One object of Python a ship."""

    def __init__(self, controller: Any, fleet: Fleet) -> None:
        self.orders = [controller.begin() for _ in range(fleet.count)]

    def __call__(self, told: Mapping[str, np.ndarray], alive: np.ndarray) -> np.ndarray:
        """The orders."""
        rows = zip(*(told[name] for name in VoyageState._fields), strict=True)
        states = [VoyageState(*map(float, row)) for row in rows]
        t = float(told["t"][0])
        return np.array([o(t, s) if on else 0.0 for o, s, on in zip(self.orders, states, alive, strict=True)])


Helm = Callable[[nw.Model, Scene], Any]


def track(model: nw.Model, scene: Scene) -> Any:
    """The track pilot, its line moved where the scene asks: linear-quadratic on the rudder, without an integral."""
    return [(start, nw.track_pilot(model, y, SPEED)) for start, y in scene.lines]


def regulated(model: nw.Model, scene: Scene) -> Any:
    """The regulator."""
    lines = scene.lines if len(scene.lines) > 1 else scene.lines[0][1]
    return nw.control.regulator(model, lines, SPEED)


HELMS: dict[str, Helm] = {"track": track, "regulator": regulated}


def fly(fleet: Fleet, scene: Scene, helm: Any, seed: int = 3) -> dict[str, float]:
    """Fly one scene: how far off, how much rudder, how many lost."""
    rng, linear = np.random.default_rng(seed), nw.control.linearize(fleet.model, scene.lines[0][1], SPEED)
    course = {name: float(value) for name, value in linear.course.items()}
    psi = course["psi"] + np.radians(1) * rng.standard_normal(fleet.count)
    fleet.begin(scene.lines[0][1], psi, course["v"], course["rudder"])
    several = helm if isinstance(helm, list) else [(0.0, helm)]
    kind = Laws if hasattr(several[0][1], "orders") else Objects
    helms = [(start, kind(own, fleet)) for start, own in several]
    far, late, spent = np.zeros(fleet.count), np.zeros(fleet.count), 0.0
    for t in range(DURATION):
        told, now = fleet.told(rng), [own for start, own in helms if start <= t][-1]
        begun = time.process_time()
        order = now(told, fleet.alive)
        spent += time.process_time() - begun
        fleet.step(order, scene.push(t))
        off = np.abs(fleet.state["y"] - scene.wanted(t))
        far = np.where(fleet.alive, np.maximum(far, off), far)
        late = np.maximum(late, off) if t >= DURATION - LATE else late
    lost = ~(fleet.alive & (late < fleet.model.configuration.ship.beam / 2))
    afloat = fleet.alive if fleet.alive.any() else ~fleet.alive
    return {
        "deviation": float(np.median(far[afloat])), "deviation_95": float(np.quantile(far[afloat], 0.95)),
        "travel": float(np.degrees(np.median(fleet.travel[afloat]))), "aground": float((~fleet.alive).mean()),
        "lost": float(lost.mean()), "lost_with_course": float(lost[fleet.holdable(scene)].mean()),
        "order_us": 1e6 * spent / DURATION / fleet.count,
    }  # fmt: skip


def flown(model: nw.Model, truths: int, helms: Mapping[str, Helm] = HELMS) -> dict[tuple[str, str], dict[str, float]]:
    """Every scene under every helm."""
    found = {}
    for name, scene in scenes(model).items():
        for kind, helm in helms.items():
            found[name, kind] = fly(Fleet(model, truths, waterway=scene.waterway), scene, helm(model, scene))
    return found


def recovered(model: nw.Model, y: float, helm: Any, across: int) -> float:
    """The share of starts off the line, of those that have room, from which the mean ship is back after 500 s."""
    off, turned = (
        part.ravel() for part in np.meshgrid(np.linspace(-60, 60, across), np.radians(np.linspace(-12, 12, across)))
    )
    course = {name: float(value) for name, value in nw.control.linearize(model, y, SPEED).course.items()}
    psi, ship = course["psi"] + turned, model.configuration.ship
    reach = ship.length / 2 * np.abs(np.sin(psi)) + ship.beam / 2 * np.cos(psi)
    fits = model.configuration.canal.width / 2 - np.abs(y + off) - reach > 1.0
    start = {"y": y + off[fits], "psi": psi[fits]}
    columns = {name: xr.DataArray(column, dims="start") for name, column in start.items()}
    told = {"u": SPEED, "v": course["v"], "rudder": course["rudder"], "duration": 500.0, "dt": DT}
    ended = nw.ensemble(model, controller=helm, **columns, **told)
    return float(((ended["outcome"] == 0) & (np.abs(ended["y_end"] - y) < ship.beam / 2)).mean())


def main(truths: int, across: int) -> None:
    """Fly and print."""
    model = full_scale()
    console = Console(width=150)
    table = Table(title=f"five scenes, {truths} truths each", caption=machine())
    headers = (
        "scene",
        "helm",
        "median deviation m",
        "95 % m",
        "rudder travel deg",
        "aground of 1000",
        "lost of 1000",
        "ratio",
        "us an order",
    )
    for header in headers:
        table.add_column(header, justify="left" if header in headers[:2] else "right")
    rows = flown(model, truths)
    first = {scene: row for (scene, _), row in reversed(rows.items())}  # the helm that the others are compared with
    for (scene, kind), row in rows.items():
        before = first[scene]["lost"]
        numbers = [
            row["deviation"],
            row["deviation_95"],
            row["travel"],
            1000 * row["aground"],
            1000 * row["lost"],
            row["lost"] / before if before else float("nan"),
            row["order_us"],
        ]
        table.add_row(scene, kind, *(f"{number:.3g}" for number in numbers))
    console.print(table)
    starts = Table(title=f"share of {across} x {across} starts recovered, 60 m and 12 degrees to either side")
    for header in ("y m", "track", "regulator"):
        starts.add_column(header, justify="right")
    for y in (50.0, 65.0):
        helms = (nw.track_pilot(model, y, SPEED), nw.control.regulator(model, y, SPEED))
        starts.add_row(f"{y:g}", *(f"{recovered(model, y, helm, across):.3f}" for helm in helms))
    console.print(starts)


if __name__ == "__main__":
    truths, small = sizes(__doc__, usual=1000, small=3)
    main(truths, across=5 if small else 21)
