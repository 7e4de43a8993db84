"""The engine: vessel-steps, calls, voyages, groundings, Jacobians, first starts.

    python benchmarks/engine.py [VESSELS] [--small]

Rows of a table are measured in the same run, rounds interleaved, medians of process time. No vessel grounds in the
first table: a vessel-step is a lane-step.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from common import machine, sizes
from rich.console import Console
from rich.table import Table

import narrows as nw
from narrows.captive.measured import measured_files
from narrows.model.tables import table_named
from narrows.simulation.inputs import START
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.sensitivities import TangentIntegrator
from narrows.simulation.ship import SimulatedShip, steering_of
from narrows.waterway import Bank, Centreline, Waterway

PAPER, KVLCC2 = nw.published("mikkelsen2025_dtc"), nw.published("yasukawa2015_kvlcc2")
ROUNDS = 7
STEPS = 240
DIRECTIONS = 26
PILOTED = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"


def container_ship() -> nw.Model:
    """The KCS at 50 % clearance, 230 m long in a canal 370 m wide, with its rudder."""
    terms = table_named("speed+helm")
    tests = nw.read_captive(*measured_files("kcs"), PILOTED).by_condition()["C0101A02"]
    return nw.scale_model(nw.identify(tests, terms).model, 230.0, 1025.0, width=370.0, depth=16.2).model


def bent(model: nw.Model) -> Waterway:
    """Thirty ship lengths of bends of R = 5 L either way, a bank that narrows, a current."""
    ship, width = model.configuration.ship, model.configuration.canal.width
    wave = 15.0 * ship.length
    north = np.linspace(0, 2 * wave, 161)
    east = wave**2 / (4 * np.pi**2 * 5 * ship.length) * np.sin(2 * np.pi * north / wave)
    line = Centreline(np.stack([east, north], axis=1))
    s = line.length * np.array([0.0, 0.2, 0.3, 0.55, 0.7, 1.0])
    sides = width * np.array([[0.5, 0.5, 0.45, 0.5, 0.6, 0.5], [0.5, 0.45, 0.5, 0.55, 0.5, 0.5]])
    depth = (s[[0, -1]], np.full(2, model.configuration.canal.depth or 2 * ship.draft))
    return Waterway(line, Bank("starboard", s, sides[0]), Bank("port", s, sides[1]), depth, current=0.1)


def pilot(model: nw.Model, speed: float) -> nw.Autopilot:
    """A track pilot of plain gains."""
    length = model.configuration.ship.length
    return nw.Autopilot(0.0, (1.0 / length, 2.0, 0.0, length / speed))


def prepared(model: nw.Model, speed: float, dt: float, vessels: int, steps: int = STEPS, **choices):
    """Lay out vessels about the line, that none of them leaves in the time."""
    options = {name: choices.pop(name) for name in ("surge",) if name in choices}
    ship = SimulatedShip(model, **options)
    draw, length = np.random.default_rng(5), model.configuration.ship.length
    steering = steering_of(choices.pop("controller", None), ship.actuators)
    run = KernelRun(ship, steps * dt, dt, steering, choices.pop("waterway", None))
    values = {
        **START, "X": 0.0, "Y": 0.0, "N": 0.0, "rudder": 0.0, "heave": 0.0, "u": speed,
        "x": draw.uniform(2, 8, vessels) * length, "y": draw.uniform(-0.05, 0.05, vessels) * length,
        "psi": draw.uniform(-0.02, 0.02, vessels), **model.configuration.values(), **model.coefficients, **choices,
    }  # fmt: skip
    return run.prepared(values, vessels, 1)


def interleaved(runs: dict[str, Callable[[], int]]) -> dict[str, list[float]]:
    """Process time a lane-step [ns], in rounds."""
    cost: dict[str, list[float]] = {name: [] for name in runs}
    for run in runs.values():
        run()
    for _ in range(ROUNDS):
        for name, run in runs.items():
            begun = time.process_time_ns()
            steps = run()
            cost[name].append((time.process_time_ns() - begun) / steps)
    return cost


def shown(title: str, unit: str, rows: dict[str, list[float]]) -> None:
    """Print medians, and ratios to the first row by rounds."""
    table = Table(title=title, caption=machine())
    for header in ("work", unit, "ratio"):
        table.add_column(header, justify="left" if header == "work" else "right")
    first = next(iter(rows.values()))
    for name, own in rows.items():
        ratio = statistics.median(a / b for a, b in zip(own, first, strict=True))
        table.add_row(name, f"{statistics.median(own):.3g}", f"{ratio:.3g}")
    Console().print(table)


def vessel_steps(vessels: int, kcs: nw.Model, small: bool) -> None:
    """What a step of a vessel costs; in small without the rows that compile a kernel for nothing else."""
    dtc, mmg = (PAPER, 1.0, 0.02), (KVLCC2, 1.179, 0.2)
    far = replace(KVLCC2, configuration=replace(KVLCC2.configuration, canal=nw.Canal(14.0)))
    full, bends = (kcs, 4.5, 2.0), bent(kcs)
    runs = {
        "straight canal, no rudder": prepared(*dtc, vessels),
        "rudder, gear and pilot, straight": prepared(*full, vessels, controller=pilot(kcs, 4.5)),
        "rudder, gear and pilot, in a waterway": prepared(*full, vessels, controller=pilot(kcs, 4.5), waterway=bends),
    }
    if not small:
        runs |= {
            "straight, constants of each vessel's own": prepared(*dtc, vessels, b_v=np.full(vessels, 100.0)),
            "zigzag, straight": prepared(*full, vessels, controller=nw.Zigzag(0.1, 0.1)),
            "MMG, straight": prepared(*mmg, vessels, surge="free"),
            "MMG, pilot, in a waterway": prepared(
                far, 1.179, 0.2, vessels, surge="free", controller=pilot(KVLCC2, 1.179), waterway=bent(far)
            ),
        }
    cost = interleaved(runs)
    for name, run in runs.items():
        if run.codes.any():
            raise SystemExit(f"{name}: vessels meet something, so that this is no row of plain steps")
    shown(f"one step of one vessel, {vessels} vessels", "ns", cost)


def calls(kcs: nw.Model) -> None:
    """What a call costs, its arrays kept."""
    cases = {
        "one vessel, one step": prepared(PAPER, 1.0, 0.02, 1, 1),
        "the same with a pilot in a waterway": prepared(
            kcs, 4.5, 2.0, 1, 1, controller=pilot(kcs, 4.5), waterway=bent(kcs)
        ),
        "1000 vessels x 60 steps, a pilot": prepared(kcs, 4.5, 2.0, 1000, 60, controller=pilot(kcs, 4.5)),
        "the same in a waterway": prepared(kcs, 4.5, 2.0, 1000, 60, controller=pilot(kcs, 4.5), waterway=bent(kcs)),
    }
    cost: dict[str, list[float]] = {name: [] for name in cases}
    for name, run in cases.items():
        run()
        many = max(1, 20_000 // max(1, run.lane_steps // 64))
        for _ in range(ROUNDS):
            begun = time.process_time_ns()
            for _ in range(many):
                run()
            cost[name].append((time.process_time_ns() - begun) / many / 1e3)
    shown("a call of a prepared run", "us", cost)


def voyages(kcs: nw.Model) -> None:
    """One voyage in Python, a step; a vessel to a located grounding."""
    cost: dict[str, list[float]] = {"straight, no rudder": [], "pilot, in a waterway": []}
    way = bent(kcs)
    for _ in range(ROUNDS):
        for name in cost:
            begun = time.process_time_ns()
            if name == "straight, no rudder":
                done = nw.simulate(PAPER, y=0.0, u=1.0, duration=40.0, dt=0.02)
            else:
                done = nw.simulate(
                    kcs, x=500.0, u=4.5, duration=500.0, dt=0.5, waterway=way, controller=pilot(kcs, 4.5)
                )
            cost[name].append((time.process_time_ns() - begun) / (len(done.t) - 1) / 1e3)
    shown("one voyage in Python, a step", "us", cost)


def jacobians(kcs: nw.Model) -> None:
    """A and B at thirty points."""
    ship = SimulatedShip(kcs)
    linear = ship.system().linearisation(ship.values(), ship.actuators)
    at = {"y": np.linspace(-60, 60, 30), "u": 4.5, "v": 0.01, "r": 1e-4, "rudder": 0.02}
    batch = linear.batch(30)
    cost: dict[str, list[float]] = {"columns of NumPy": [], "compiled": []}
    for _ in range(ROUNDS):
        for name, work in (("columns of NumPy", lambda: linear.linear(at)), ("compiled", lambda: batch(at))):
            work()
            begun = time.process_time_ns()
            for _ in range(200):
                work()
            cost[name].append((time.process_time_ns() - begun) / 200e3)
    shown("A and B at 30 points", "us", cost)


def tangents(kcs: nw.Model) -> None:
    """A step with the derivatives of its state along 26 directions: start, coefficients, forces."""
    start, times = {"y": 10.0, "u": 4.5}, np.arange(0.0, 500.0, 0.5)
    cost: dict[str, list[float]] = {}
    for name, model, told in (("bank and rudder", kcs, {}), ("MMG", KVLCC2, {"revolutions": 10.0, "contact": "none"})):
        names = (*START, *model.terms.names, "Y", "N")[:DIRECTIONS]
        integrator = TangentIntegrator.of(model, names, {**start, **told, "N": 1.0})
        integrator.slopes(times)
        for _ in range(ROUNDS):
            begun = time.process_time_ns()
            integrator.slopes(times)
            cost.setdefault(f"{name}, {len(names)} directions", []).append(
                (time.process_time_ns() - begun) / (len(times) - 1) / 1e3
            )
    shown("a step with its tangent, in a voyage of 1000", "us", cost)


START_UP = """
import time, narrows as nw
begun = time.perf_counter()
model = nw.published("{model}")
{work}
print(time.perf_counter() - begun)
"""
WORKS = {
    "first voyage of the paper's model": ("mikkelsen2025_dtc", "nw.simulate(model, y=0.5)"),
    "first map of it": ("mikkelsen2025_dtc", "nw.ensemble(model, y=[0.5, 1.0])"),
    "first MMG voyage": (
        "yasukawa2015_kvlcc2", "nw.simulate(model, u=1.179, surge='free', contact='none', dt=0.1)",
    ),
    "first MMG fleet": (
        "yasukawa2015_kvlcc2", "nw.ensemble(model, u=[1.1, 1.179], surge='free', contact='none', dt=0.1)",
    ),
    "first MMG Jacobian": ("yasukawa2015_kvlcc2", "nw.stability(model, bank=False, u=1.179)"),
}  # fmt: skip


def starts() -> None:
    """From an empty cache to a first answer, and again from what was kept, each in a process of its own."""
    table = Table(title="From nothing to a first answer [s]", caption=machine())
    for header in ("work", "empty cache", "kept"):
        table.add_column(header, justify="left" if header == "work" else "right")
    for name, (model, work) in WORKS.items():
        with tempfile.TemporaryDirectory() as folder:
            code, environment = START_UP.format(model=model, work=work), {**os.environ, "NARROWS_CACHE_DIR": folder}
            took = [
                float(subprocess.run(
                    [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
                ).stdout)
                for _ in range(2)
            ]  # fmt: skip
        table.add_row(name, *(f"{seconds:.2f}" for seconds in took))
    Console().print(table)


def main() -> None:
    """Measure and print."""
    vessels, small = sizes(__doc__, usual=2048, small=128)
    kcs = container_ship()
    vessel_steps(vessels, kcs, small)
    calls(kcs)
    voyages(kcs)
    jacobians(kcs)
    tangents(kcs)
    if not small:
        starts()


if __name__ == "__main__":
    main()
