"""An exported page beside the package's kernel: a step of one vessel in Node, and a map in a headless Chromium.

    python benchmarks/page.py [SHIPS] [--small]

The fleets of a page by WebAssembly (where ziglang is) and by plain JavaScript, one thread, process time; then what the
page itself takes for its map, with a worker for each core, as the clock has it.
"""

import json
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from common import machine, sizes
from rich.console import Console
from rich.table import Table

import narrows as nw
from narrows.export.exported_ship import ExportedShip
from narrows.export.page.page_text import model_script
from narrows.export.page.script_bundle import bundled
from narrows.export.page.wasm_build import SHIP, lacks_zig, wasm_of
from narrows.simulation.inputs import START
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.ship import SimulatedShip

ROUNDS, STEPS, ACROSS = 5, 650, 200
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
console.log(JSON.stringify([spent.sort((a, b) => a - b)[Math.floor(rounds / 2)] * 1e3 / steps, steps]));
"""


def in_node(exported: ExportedShip, task: dict[str, Any], single: bool | None) -> tuple[float, float]:
    """Nanoseconds a step, and steps: by WebAssembly in either precision, or by plain JavaScript."""
    known: set[str] = set()
    given = {"model.js": model_script(exported)}
    modules = "".join(bundled(name, given, known) for name in ("plain_fleet.js", "wasm_fleet.js", "model.js"))
    names = {"parameters": [one.name for one in exported.parameters], "inputs": [one.name for one in exported.inputs]}
    shape = {"states": len(exported.portable.kept), "parameters": len(names["parameters"]), "rudder": -1,
             "paths": 0, "samples": 0}  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        wasm = Path(folder, "fleet.wasm")
        if single is not None:
            wasm.write_bytes(wasm_of(exported, single))
        asked = {"shape": shape, "names": names, "task": task, "rounds": ROUNDS,
                 "wasm": None if single is None else str(wasm)}  # fmt: skip
        command = ["node", "--input-type=module", "-e", modules + NODE]
        done = subprocess.run(command, input=json.dumps(asked), capture_output=True, text=True, check=True)
    return tuple(json.loads(done.stdout))


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


def in_browser(model: nw.Model) -> float | None:
    """Milliseconds that a page takes for its map; None where there is no browser to drive."""
    chromium = shutil.which("chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        return None
    if chromium is None:
        return None
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        path = Path(folder, "ship.html")
        nw.export.write_page(model, path)
        browser = driver.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page()
        page.goto(f"{path.as_uri()}#ships=500&map={ACROSS}")
        page.wait_for_function("document.documentElement.dataset.settled")
        spent = page.evaluate("narrowsPage.scene.now.mapped")
        browser.close()
        return float(spent)


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
    if not lacks_zig():
        cost = {"WebAssembly, single": in_node(exported, task, True), "double": in_node(exported, task, False), **cost}
    first = kernel_cost(exported, y, cost["plain JavaScript"][1])
    table = Table(title="one step of one vessel, DTC, paper", caption=machine())
    for header in ("work", "ns", "ratio"):
        table.add_column(header, justify="left" if header == "work" else "right")
    for work, own in {"kernel, lanes": (first, 0.0), **cost}.items():
        table.add_row(work, f"{own[0]:.3g}", f"{own[0] / first:.2f}")
    Console().print(table)
    if not small and (spent := in_browser(model)) is not None:
        print(f"a map of {ACROSS} x {ACROSS} voyages in Chromium: {spent:.0f} ms")


main()
