"""Pages and their scripts: modules that Node runs, and pages that a headless Chromium opens."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import narrows as nw
from narrows.export.exported_ship import ExportedShip
from narrows.export.fmu import lacks_zig
from narrows.export.page.assembly import SHIP, bundled, helm_of, model_script, wasm_of
from narrows.simulation.ship import SimulatedShip, steering_of

NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="no Node is here to run the scripts of a page with")
ZIG = Path(sys.prefix, "zig")
"""Where ``make check`` has the compiler, for WebAssembly alone: the first FMU for every platform takes it minutes."""
needs_zig = pytest.mark.skipif(
    bool(lacks_zig("WebAssembly")) and not (ZIG / "ziglang").exists(),
    reason="no ziglang is here to compile WebAssembly with",
)
SHAPE = {"most": 4096, "paths": 1024, "samples": 96}
RUN = """
import {{ readFileSync }} from "fs";
{modules}
const {{ wasmFleet }} = module_wasm_fleet, {{ plainFleet }} = module_plain_fleet, {{ model }} = module_model;
const {{ shape, names, task, wasm }} = JSON.parse(readFileSync(0, "utf8"));
for (const name of ["starts", "parameters", "told"]) task[name] = Float64Array.from(task[name]);
const fleet = wasm ? await wasmFleet(readFileSync(wasm), shape) : plainFleet(model, shape, names);
const {{ ends, paths, kept }} = fleet.sailed(task);
console.log(JSON.stringify({{ ends: [...ends], paths: [...paths], kept: [...kept] }}));
"""


def on_page(model: nw.Model, speed: float) -> ExportedShip:
    """A ship as a page has it."""
    ship = SimulatedShip(model)
    return ExportedShip(ship, None, SHIP, steering_of(helm_of(model, speed)[0], ship.actuators))


def wasm_here(exported: ExportedShip, single: bool = False) -> bytes:
    """The module of a ship, by the compiler that is here."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", os.pathsep.join([str(ZIG), *filter(None, [os.environ.get("PYTHONPATH")])]))
        return wasm_of(exported, single)


def fleet_ends(exported: ExportedShip, starts: np.ndarray, steps: int, wasm: Path | None, **told: float) -> np.ndarray:
    """How ships end: the state, the time and the outcome of each, by WebAssembly or by plain JavaScript."""
    given = {"model.js": model_script(exported)}
    known: set[str] = set()
    modules = "".join(bundled(name, given, known) for name in ("plain_fleet.js", "wasm_fleet.js", "model.js"))
    inputs = [told.get(one.name, one.value) for one in exported.inputs]
    names = {
        "parameters": [one.name for one in exported.parameters],
        "inputs": [one.name for one in exported.inputs],
    }
    kept = exported.kept
    shape = {**SHAPE, "states": len(kept), "parameters": len(names["parameters"]),
             "rudder": kept.index("rudder") if "rudder" in kept else -1}  # fmt: skip
    parameters = [one.value for one in exported.parameters]
    task = {"starts": starts.ravel().tolist(), "parameters": parameters, "told": inputs, "steps": steps, "every": 0}
    asked = {"shape": shape, "names": names, "task": task, "wasm": str(wasm) if wasm else None}
    return np.array(answer(RUN.format(modules=modules), asked)["ends"]).reshape(len(starts), -1)


def answer(script: str, asked: Any) -> Any:
    """What a script that Node runs makes of something that it is given."""
    assert NODE is not None
    done = subprocess.run(
        [NODE, "--input-type=module", "-e", script], input=json.dumps(asked), capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def opened(browser: Any, path: Path, width: int, height: int, **more: Any) -> tuple[Any, list[str]]:
    """A page, settled, with what goes wrong and what it asks the network for."""
    page = browser.new_page(viewport={"width": width, "height": height}, **more)
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda told: wrong.append(told.text) if told.type == "error" else None)
    page.on("request", lambda asked: None if local(asked.url) else wrong.append(asked.url))
    page.goto(f"{path.as_uri()}#ships=500&map=40")
    settled(page)
    return page, wrong


def local(url: str) -> bool:
    """Whether an address is the page itself, or what it made."""
    return url.startswith(("file:", "blob:", "data:"))


def settled(page: Any) -> None:
    """Wait until the page has sailed what its settings ask for."""
    page.wait_for_function("document.documentElement.dataset.settled == narrowsPage.scene.run", timeout=60_000)
