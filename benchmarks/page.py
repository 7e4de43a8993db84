"""An exported page beside the package's kernel: a step of one vessel in Node, and a map in a headless Chromium.

    python benchmarks/page.py [SHIPS] [--small]

The fleets of a page by WebAssembly (where ziglang is) and by plain JavaScript, one thread, process time; then what the
page itself takes for its map and to its first paint, by the clock, the best of some.
"""

import json
import os
import shutil
import statistics
import subprocess
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from common import machine, sizes
from rich.console import Console
from rich.table import Table

import narrows as nw
from narrows.export.exported_ship import ExportedShip
from narrows.export.fmu import lacks_zig
from narrows.export.page.assembly import SHIP, bundled, model_script, wasm_of
from narrows.model.tables import table_named
from narrows.simulation.inputs import START
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.ship import SimulatedShip

ROUNDS, STEPS, ACROSS = 5, 650, 200
MAPS, PAINTS = 8, 6
NODE = """
import { readFileSync } from "fs";
const { shape, names, task, wasm, rounds } = JSON.parse(readFileSync(0, "utf8"));
for (const name of ["starts", "parameters", "told"]) task[name] = Float64Array.from(task[name]);
const { wasmFleet } = module_wasm_fleet, { plainFleet } = module_plain_fleet;
const fleet = wasm ? await wasmFleet(readFileSync(wasm), shape) : plainFleet(module_model.model, shape, names);
const [spent, row] = [[], shape.states + 2];
let ends;
for (let round = 0; round <= rounds; round += 1) {
  const begun = process.cpuUsage().user;
  ({ ends } = fleet.sailed(task));
  if (round) spent.push(process.cpuUsage().user - begun);
}
let steps = 0;
for (let at = 0; at < ends.length; at += row) steps += ends[at + shape.states] / task.starts[shape.states];
console.log(JSON.stringify([spent.sort((a, b) => a - b)[Math.floor(rounds / 2)] * 1e3 / steps, steps, [...ends]]));
"""


def in_node(
    exported: ExportedShip, task: dict[str, Any], single: bool | None, rounds: int = ROUNDS
) -> tuple[float, float, np.ndarray]:
    """Nanoseconds a step, steps, and how each ends: by WebAssembly in either precision, or by plain JavaScript."""
    known: set[str] = set()
    given = {"model.js": model_script(exported)}
    modules = "".join(bundled(name, given, known) for name in ("plain_fleet.js", "wasm_fleet.js", "model.js"))
    names = {"parameters": [one.name for one in exported.parameters], "inputs": [one.name for one in exported.inputs]}
    shape = {"states": len(exported.kept), "parameters": len(names["parameters"]), "rudder": -1,
             "paths": 0, "samples": 0}  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        wasm = Path(folder, "fleet.wasm")
        if single is not None:
            wasm.write_bytes(wasm_of(exported, single))
        asked = {"shape": shape, "names": names, "task": task, "rounds": rounds,
                 "wasm": None if single is None else str(wasm)}  # fmt: skip
        command = ["node", "--input-type=module", "-e", modules + NODE]
        done = subprocess.run(command, input=json.dumps(asked), capture_output=True, text=True, check=True)
    cost, steps, ends = json.loads(done.stdout)
    return cost, steps, np.reshape(ends, (-1, shape["states"] + 2))


def single_precision(model: nw.Model, low: float, high: float, ships: int) -> str:
    """How far ends in single precision are from those in double, of ships all over a canal at speeds [m/s] between."""
    exported, length = ExportedShip(SimulatedShip(model), None, SHIP), model.configuration.ship.length
    clear = 0.8 * (model.configuration.canal.width / 2 - model.configuration.ship.beam / 2)
    states, number = len(exported.kept), np.arange(ships)
    starts = np.zeros((ships, states + 1))
    starts[:, 1], starts[:, 2] = -clear + 2 * clear * (number + 0.5) / ships, 1.0
    starts[:, 4] = low + (high - low) * (number * 7 % 100) / 100
    starts[:, -1] = length / 200 / starts[:, 4]
    parameters, told = [one.value for one in exported.parameters], [one.value for one in exported.inputs]
    task = {"starts": starts.ravel().tolist(), "parameters": parameters, "told": told, "steps": 1400, "every": 0}
    double, single = (in_node(exported, task, kind, 0)[2] for kind in (False, True))
    off = np.abs(double[:, :2] - single[:, :2]).max(axis=1)
    differ = int((double[:, -1] != single[:, -1]).sum())
    return f"{off.max():.1e} m at most, {np.quantile(off, 0.99):.1e} m in 99 of 100, {differ} of {ships} end otherwise"


def kvlcc2() -> nw.Model:
    """The published KVLCC2 in a canal of eleven beams, its bank borrowed from the DTC."""
    published, dtc = nw.published("yasukawa2015_kvlcc2"), nw.published("mikkelsen2025_dtc")
    known = {**published.coefficients, "Y_bank": dtc["b_bank"], "N_bank": dtc["c_bank"]}
    return nw.Model(replace(published.configuration, canal=nw.Canal(14.0)), table_named("mmg+delta"), known)


def kernel_cost(exported: ExportedShip, y: np.ndarray, steps: float) -> float:
    """Nanoseconds a step of the package's lanes, for the same ships."""
    model = exported.ship.model
    values = {
        **START,
        "X": 0.0,
        "Y": 0.0,
        "N": 0.0,
        "y": y,
        "u": 1.0,
        **model.configuration.values(),
        **model.coefficients,
    }
    run = KernelRun(exported.ship, STEPS * 0.04, 0.04).prepared(values, len(y), 1)
    run()
    spent = []
    for _ in range(ROUNDS):
        begun = time.process_time_ns()
        run()
        spent.append(time.process_time_ns() - begun)
    return statistics.median(spent) / steps


def in_browser(model: nw.Model) -> dict[str, float]:
    """Milliseconds of a page, the best of some; nothing where no browser can be driven."""
    chromium = shutil.which("chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        return {}
    if chromium is None:
        return {}
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        path = Path(folder, "ship.html")
        nw.export.write(model, path)
        browser = driver.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        told = {f"a map of {ACROSS} x {ACROSS} voyages, by one worker": best_map(browser, path, 1)}
        told[f"the same, by {os.cpu_count()}"] = best_map(browser, path, os.cpu_count() or 1)
        told["to the first paint"] = min(first_paint(browser, path) for _ in range(PAINTS))
        browser.close()
    return told


def best_map(browser: Any, path: Path, workers: int) -> float:
    """The least time for a map of so many workers."""
    page = browser.new_page()
    page.add_init_script(f"Object.defineProperty(navigator, 'hardwareConcurrency', {{ get: () => {workers} }})")
    page.goto(f"{path.as_uri()}#ships=500&map={ACROSS}")
    at = "document.documentElement.dataset.settled"
    settled = f"before => {at} > before && {at} == narrowsPage.scene.run"
    spent: list[float] = []
    last = 0
    for turn in range(MAPS):
        page.wait_for_function(settled, arg=last)
        last = int(page.evaluate("narrowsPage.scene.run"))
        spent.append(float(page.evaluate("narrowsPage.scene.now.mapped")))
        page.evaluate(f"narrowsPage.settings.values.y = {0.1 + 0.01 * turn}; narrowsPage.changed()")
    page.close()
    return min(spent)


def first_paint(browser: Any, path: Path) -> float:
    """When a new page has painted anything of its contents."""
    page = browser.new_page()
    page.goto(path.as_uri())
    page.wait_for_function("performance.getEntriesByName('first-contentful-paint').length")
    painted = page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime")
    page.close()
    return float(painted)


def main() -> None:
    """Measure, and print a table with ratios to the kernel."""
    ships, small = sizes(__doc__, 4000, 200)
    if shutil.which("node") is None:
        print("no Node is here: no ratio")
        return
    model = nw.published("mikkelsen2025_dtc")
    exported = ExportedShip(SimulatedShip(model), None, SHIP)
    y = np.linspace(-2.2, 2.2, ships)
    starts = np.zeros((ships, 8))
    starts[:, 1], starts[:, 2], starts[:, 4], starts[:, 7] = y, 1.0, 1.0, 0.04
    parameters, told = [one.value for one in exported.parameters], [one.value for one in exported.inputs]
    task = {"starts": starts.ravel().tolist(), "parameters": parameters, "told": told, "steps": STEPS, "every": 0}
    cost = {"plain JavaScript": in_node(exported, task, None)}
    if not lacks_zig("WebAssembly"):
        cost = {"WebAssembly, single": in_node(exported, task, True), "double": in_node(exported, task, False), **cost}
    first = kernel_cost(exported, y, cost["plain JavaScript"][1])
    table = Table(title="one step of one vessel, DTC, paper", caption=machine())
    for header in ("work", "ns", "ratio"):
        table.add_column(header, justify="left" if header == "work" else "right")
    for work, own in {"kernel, lanes": (first, 0.0), **cost}.items():
        table.add_row(work, f"{own[0]:.3g}", f"{own[0] / first:.2f}")
    Console().print(table)
    if not lacks_zig("WebAssembly") and not small:
        print(f"single precision, DTC: {single_precision(model, 0.4, 1.4, ships)}")
        print(f"single precision, KVLCC2: {single_precision(kvlcc2(), 0.4, 1.2, ships)}")
    for work, spent in ({} if small else in_browser(model)).items():
        print(f"{work}, in Chromium: {spent:.0f} ms")


main()
