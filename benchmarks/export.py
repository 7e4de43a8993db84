"""The exported C beside the package's kernel: a step of one vessel, one after another, by the machine's own compiler.

    python benchmarks/export.py [STEPS] [--small]

The header is compiled with -O3 -march=native. The kernel sails 2048 vessels in lanes, the C one vessel after another,
and 64 side by side, without and with fused products and sums, which the kernel has.
"""

import ctypes
import shutil
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from common import machine, sizes
from rich.console import Console
from rich.table import Table

import narrows as nw
from narrows.simulation.inputs import START
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.ship import SimulatedShip

ROUNDS = 7
PROGRAM = """
#include "ship.h"
double run(long steps, double u, double h) {
    ship_constants constants;
    ship_inputs inputs = ship_at_rest;
    double state[SHIP_NUMBERS] = {[SHIP_COS_PSI] = 1.0, [SHIP_Y] = 0.01};
    state[SHIP_U] = u;
    ship_prepare(&ship_model, &constants);
    for (long step = 0; step < steps; ++step) {
        ship_step(state, state, h, &inputs, &constants);
        if (step % 64 == 63) state[SHIP_Y] = 0.01, state[SHIP_COS_PSI] = 1.0, state[SHIP_SIN_PSI] = 0.0,
            state[SHIP_U] = u, state[SHIP_V] = 0.0, state[SHIP_R] = 0.0;
    }
    return state[SHIP_X];
}
double run_block(long steps, double u, double h) {
    static double state[SHIP_NUMBERS][SHIP_LANES], inputs[sizeof(ship_inputs) / sizeof(double)][SHIP_LANES];
    const double *at_rest = (const double *)(const void *)&ship_at_rest;
    ship_constants constants;
    ship_prepare(&ship_model, &constants);
    for (unsigned j = 0; j < sizeof(ship_inputs) / sizeof(double); ++j)
        for (int lane = 0; lane < SHIP_LANES; ++lane) inputs[j][lane] = at_rest[j];
    for (long step = 0; step < steps / SHIP_LANES; ++step) {
        if (step % 64 == 0) for (int lane = 0; lane < SHIP_LANES; ++lane) {
            for (int j = 0; j < SHIP_STATES; ++j) state[j][lane] = 0.0;
            state[SHIP_Y][lane] = 0.01, state[SHIP_COS_PSI][lane] = 1.0, state[SHIP_U][lane] = u;
        }
        ship_step_block(state, h, inputs, &constants);
    }
    return state[SHIP_X][0];
}
"""


def compiled(
    model: nw.Model,
    u: float,
    dt: float,
    surge: str,
    steps: int,
    compiler: str,
    name: str = "run",
    contract: str = "off",
) -> Callable[[], int]:
    """A loop of steps in C."""
    folder = Path(tempfile.mkdtemp())
    nw.export.write(model, folder / "ship.h", surge=surge)
    (folder / "run.c").write_text(PROGRAM, encoding="utf-8")
    flags = ["-std=c99", "-O3", "-march=native", f"-ffp-contract={contract}", "-fno-math-errno", "-shared", "-fPIC"]
    subprocess.run([compiler, *flags, folder / "run.c", "-o", folder / "run.so", "-lm"], check=True)
    run = getattr(ctypes.CDLL(str(folder / "run.so")), name)
    run.restype, run.argtypes = ctypes.c_double, [ctypes.c_long, ctypes.c_double, ctypes.c_double]

    def call() -> int:
        assert np.isfinite(run(steps, u, dt))
        return steps

    return call


def kernel(model: nw.Model, u: float, dt: float, surge: str, vessels: int) -> Callable[[], int]:
    """The package's own lanes."""
    run = KernelRun(SimulatedShip(model, surge), 64 * dt, dt)
    values = {
        **START, "X": 0.0, "Y": 0.0, "N": 0.0, "rudder": 0.0, "heave": 0.0, "u": u, "y": 0.01,
        **model.configuration.values(), **model.coefficients,
    }  # fmt: skip
    return run.prepared(values, vessels, 1)


def main() -> None:
    """Measure, and print medians with ratios to the kernel."""
    steps, small = sizes(__doc__, 1_000_000, 2_000)
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        print("no C compiler is here: no ratio")
        return
    cases = {
        "DTC, paper": (nw.published("mikkelsen2025_dtc"), 1.0, 0.02, "held"),
        "KVLCC2, MMG": (nw.published("yasukawa2015_kvlcc2"), 1.179, 0.2, "free"),
    }
    for name, case in cases.items():
        runs = {
            "kernel, lanes": kernel(*case, 64 if small else 2048),
            "C, one vessel": compiled(*case, steps, compiler),
            "C, a block of 64": compiled(*case, steps, compiler, "run_block"),
            "the same, fused": compiled(*case, steps, compiler, "run_block", "fast"),
        }
        cost: dict[str, list[float]] = {work: [] for work in runs}
        for round in range(ROUNDS + 1):
            for work, run in runs.items():
                begun = time.process_time_ns()
                done = run()
                if round:
                    cost[work].append((time.process_time_ns() - begun) / done)
        table = Table(title=f"one step of one vessel, {name}", caption=machine())
        for header in ("work", "ns", "ratio"):
            table.add_column(header, justify="left" if header == "work" else "right")
        first = statistics.median(next(iter(cost.values())))
        for work, own in cost.items():
            table.add_row(work, f"{statistics.median(own):.3g}", f"{statistics.median(own) / first:.2f}")
        Console().print(table)


main()
