"""Fleets to their grounding: the compiled kernel beside a kernel written by hand for the paper's model, in one run.

    python benchmarks/kernel.py [VESSELS] [--small]

The hand-written one has the paper's numbers in its text, keeps the lanes of grounded vessels idle until the whole
block is done, and finds the grounding to a whole step. A vessel-step is one step of one vessel that still sails;
a lane-step counts idle lanes too. Rounds alternate, and the ratio is the median of the rounds' own ratios.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import numba
import numpy as np
from common import machine, sizes
from rich.console import Console
from rich.table import Table

import narrows as nw
from narrows.codegen.run import PreparedRun
from narrows.simulation.grid import INPUTS, START
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.ship import SimulatedShip

MODEL = nw.published("mikkelsen2025_dtc")
TAPERED = nw.Model(MODEL.configuration, nw.TAPERED, MODEL.coefficients)
DT, DURATION, ROUNDS, BLOCK = 0.02, 40.0, 7, 64
SHIP, WIDTH = MODEL.configuration.ship, MODEL.configuration.canal.width
LENGTH, BEAM = SHIP.length, SHIP.beam
BANK = 0.5 * SHIP.block_coefficient * 1000.0 * LENGTH * SHIP.draft
M11, M12, M21, M22 = (float(m) for m in np.linalg.inv([[733, -56.1], [-56.1, 712]]).ravel())
jit = numba.njit(fastmath=True, error_model="numpy", nogil=True)


@jit
def rhs(y, c, s, v, r):
    """The published model at 1 m/s, three divisions."""
    secant = 1.0 / c
    starboard, port = (WIDTH * 0.5 - y) * secant, (WIDTH * 0.5 + y) * secant
    a, b = starboard / (starboard - BEAM * 0.5), port / (port - BEAM * 0.5)
    bank = BANK * (a * a - b * b)
    Y = -100.0 * v - 118.0 * r - 3298.0 * abs(v) * v + 161.0 * abs(r) * r + 1.07 * bank
    N = -414.0 * v - 84.9 * r - 589.0 * abs(v) * v - 3346.0 * abs(r) * r - 0.13 * bank * LENGTH
    return s + v * c, -r * s, r * c, M11 * Y + M12 * N, M21 * Y + M22 * N, c - v * s


@jit
def step(x, h):
    """One Runge-Kutta step of a block; how many lanes still sail."""
    afloat = 0.0
    for i in range(BLOCK):
        y, c, s = x[i], x[BLOCK + i], x[2 * BLOCK + i]
        v, r, alive = x[3 * BLOCK + i], x[4 * BLOCK + i], x[6 * BLOCK + i]
        g, z = h * 0.5, alive * h / 6.0
        a1, b1, c1, d1, e1, f1 = rhs(y, c, s, v, r)
        a2, b2, c2, d2, e2, f2 = rhs(y + g * a1, c + g * b1, s + g * c1, v + g * d1, r + g * e1)
        a3, b3, c3, d3, e3, f3 = rhs(y + g * a2, c + g * b2, s + g * c2, v + g * d2, r + g * e2)
        a4, b4, c4, d4, e4, f4 = rhs(y + h * a3, c + h * b3, s + h * c3, v + h * d3, r + h * e3)
        y += z * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        c += z * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
        s += z * (c1 + 2.0 * c2 + 2.0 * c3 + c4)
        unit = 1.5 - 0.5 * (c * c + s * s)
        c, s = c * unit, s * unit
        x[i], x[BLOCK + i], x[2 * BLOCK + i] = y, c, s
        x[3 * BLOCK + i] = v + z * (d1 + 2.0 * d2 + 2.0 * d3 + d4)
        x[4 * BLOCK + i] = r + z * (e1 + 2.0 * e2 + 2.0 * e3 + e4)
        x[5 * BLOCK + i] += z * (f1 + 2.0 * f2 + 2.0 * f3 + f4)
        gap = WIDTH * 0.5 - abs(y) - LENGTH * 0.5 * abs(s) - BEAM * 0.5 * c
        alive = alive if gap > 0.0 else 0.0
        x[6 * BLOCK + i] = alive
        afloat += alive
    return afloat


@jit
def by_hand(y0, psi0, h, steps, distance):
    """Sail block after block, each to its last grounding; return the lane-steps."""
    work = 0
    for j in range(y0.size // BLOCK):
        x = np.zeros(7 * BLOCK)
        part = slice(j * BLOCK, (j + 1) * BLOCK)
        x[:BLOCK] = y0[part]
        x[BLOCK : 2 * BLOCK] = np.cos(psi0[part])
        x[2 * BLOCK : 3 * BLOCK] = np.sin(psi0[part])
        x[6 * BLOCK :] = 1.0
        for _ in range(steps):
            work += BLOCK
            if step(x, h) == 0.0:
                break
        distance[part] = x[5 * BLOCK : 6 * BLOCK]
    return work


def seconds(work: Callable[[], object]) -> float:
    """Time one run [s]."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def rounds(runs: dict[str, Callable[[], object]]) -> dict[str, list[float]]:
    """Warm up, then run all of them in turn, again and again."""
    for run in runs.values():
        run()
    times: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(ROUNDS):
        for name, run in runs.items():
            times[name].append(seconds(run))
    return times


def fleets(vessels: int) -> None:
    """Compare the kernels."""
    draw = np.random.default_rng(0)
    y, psi = draw.uniform(-2.6, 2.6, vessels), draw.normal(0, 0.05, vessels)
    distance = np.zeros(vessels)

    def sail(model=MODEL, workers=1, precision="float64", **varied: np.ndarray) -> PreparedRun:
        run = KernelRun(SimulatedShip(model), DURATION, DT, precision)
        start = {**dict.fromkeys((*START, *INPUTS), 0.0), "rudder": 0.0, "y": y, "psi": psi, "u": 1.0}
        prepared = run.prepared({**start, **varied}, vessels, workers)
        prepared()
        return prepared

    varied = {"b_v": np.full(vessels, MODEL.coefficients["b_v"])}
    times = rounds(
        {
            "by hand, one core": lambda: by_hand(y, psi, DT, round(DURATION / DT), distance),
            "compiled, one core": sail,
            "compiled, two cores": lambda: sail(workers=2),
            "compiled, single precision": lambda: sail(precision="float32"),
            "compiled, constants of each vessel's own": lambda: sail(**varied),
            "compiled, tapered table (an exponential)": lambda: sail(TAPERED),
        }
    )
    lane_steps = {"by hand, one core": by_hand(y, psi, DT, round(DURATION / DT), distance)}
    ends = {"compiled, tapered table (an exponential)": sail(TAPERED)}
    table = Table(title=f"{vessels} vessels to a grounding, Runge-Kutta, dt {DT} s", caption=machine())
    for header in ("work", "us/vessel", "ns/vessel-step", "ns/lane-step", "ratio"):
        table.add_column(header, justify="left" if header == "work" else "right")
    paper_end = sail()
    for name, own in times.items():
        end = ends.get(name, paper_end)
        median, lanes = statistics.median(own), lane_steps.get(name, end.lane_steps)
        ratio = statistics.median(a / b for a, b in zip(own, times["by hand, one core"], strict=True))
        figures = median / vessels * 1e6, median / np.ceil(end.time / DT).sum() * 1e9, median / lanes * 1e9
        table.add_row(name, *(f"{figure:.2f}" for figure in figures), f"{ratio:.3f}")
    Console().print(table)
    pairs = zip(times["compiled, one core"], times["compiled, two cores"], strict=True)
    print(f"two cores are {statistics.median(one / two for one, two in pairs):.2f} times one")
    print(f"mean distance by hand {distance.mean():.4f} m, located {paper_end.end[:, 0].mean():.4f} m")


START = """
import time
clock = time.perf_counter
t = [clock()]
import narrows as nw
from narrows.simulation.ship import SimulatedShip
model = nw.published("mikkelsen2025_dtc")
ship = SimulatedShip(model)
t.append(clock())
if FIRST:
    import sympy
t.append(clock())
system = ship.system()
system.constants(ship.values())
t.append(clock())
import numba
numba.njit(lambda x: x + 1)(1)
t.append(clock())
kernel = system.kernel((), "float64")
t.append(clock())
nw.ensemble(model, y=0.5, duration=1.0)
t.append(clock())
print(*(b - a for a, b in zip(t, t[1:])))
"""
PARTS = ("import narrows", "import sympy", "trace and emit", "start numba", "emit the kernel", "compile it")


def starts() -> None:
    """Time the parts of a first start and of a cached one, each in a process of its own."""
    table = Table(title="From nothing to a first fleet [s]", caption=machine())
    for header in ("start", *PARTS, "trace, emit, compile"):
        table.add_column(header, justify="left" if header == "start" else "right")
    with tempfile.TemporaryDirectory() as folder:
        for name in ("first", "cached"):
            code = START.replace("FIRST", str(name == "first"))
            done = subprocess.run(
                [sys.executable, "-c", code],
                env={**os.environ, "NARROWS_CACHE_DIR": folder}, capture_output=True, text=True, check=True,
            )  # fmt: skip
            parts = [float(word) for word in done.stdout.split()]
            table.add_row(name, *(f"{part:.2f}" for part in parts), f"{parts[2] + parts[4] + parts[5]:.2f}")
    Console().print(table)


if __name__ == "__main__":
    fleets(sizes(__doc__, usual=65_536, small=1024)[0])
    starts()
