"""A ship prepared for its page: a helm if it has a rudder, WebAssembly if there is a compiler."""

import base64
import json
import re
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from narrows.base.errors import InputError
from narrows.codegen.free_motion import STATE
from narrows.codegen.printers.translation import JavaScript
from narrows.export.exported_ship import ExportedShip
from narrows.export.fmu import ZIG_CC, compiled, lacks_zig
from narrows.export.page.page_sliders import (
    ASSUMED,
    COEFFICIENTS,
    Slider,
    covered,
    deviation,
    is_open_water,
    sliders_of,
)  # fmt: skip
from narrows.export.passport import passport
from narrows.export.ship_files import c_text, javascript_text
from narrows.model.model import Model
from narrows.quantities.arithmetic import choice
from narrows.simulation.controllers import LAST_ORDER, ControlLaw, Named
from narrows.simulation.grid import symmetric_root
from narrows.simulation.initial_state import voyage_defaults
from narrows.simulation.inputs import finite_numbers
from narrows.simulation.ship import SimulatedShip, steering_of
from narrows.web import asset, without_exports


def page_file(
    model: Model, path: str | Path, suffix: str, title: str = "", u: float | None = None, **choices: Any
) -> tuple[str, tuple[str, ...]]:
    ship = SimulatedShip(model, **choices)
    if ship.contact == "none":
        raise InputError("a page shows a canal, and contact 'none' has no banks; choose 'corners'")
    speed = float(voyage_defaults(model).speed if u is None else u)
    finite_numbers(u=speed)
    if not speed > 0:
        raise InputError(f"u = {speed:g} m/s: a page shows ships that make way; give a speed over 0")
    helm, why = helm_of(model, speed)
    exported = ExportedShip(ship, None, SHIP, steering_of(helm, ship.actuators))
    lacking = lacks_zig("WebAssembly")
    wasm = None if lacking else wasm_of(exported)
    title = title or f"{model.configuration.ship.name} {_where(model)}: every line is one ship"
    notes = (f"{SLOWER}: {lacking}" if lacking else "", why, model.bank_note)
    return page_text(exported, speed, title, why, wasm), tuple(filter(None, notes))


def _where(model: Model) -> str:
    if is_open_water(model):
        return "in open water"
    return "between the banks of a canal" if model.has_bank else "in a canal, without a bank force"


SLOWER = "the page sails by plain JavaScript, a few times slower"
BARE_DEFLATE = -15
# Scripts of both the page and its workers.
FIRST = ("fleet_shape.js", "model.js", "plain_fleet.js")
MODEL = "export const model = (() => {{\n{}\nreturn {{ prepare, rates, least_clearance, integrate }};\n}})();\n"


def page_text(exported: ExportedShip, speed: float, title: str, helm: str, wasm: bytes | None) -> str:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    data = json.dumps(page_data(exported, speed, title) | {"wasm": packed(wasm) if wasm else ""}, separators=(",", ":"))
    template = Environment(loader=PackageLoader("narrows.export.page", "."), undefined=StrictUndefined)
    known: set[str] = set()
    given, data_range = {"model.js": model_script(exported)}, exported.ship.model.data_range
    whose = "tests of other ships" if exported.ship.model.source.estimate else "the tests"
    has_range = data_range.speed is not None or data_range.abs_y is not None
    return template.get_template("page.html.j2").render(
        title=title, banks=exported.ship.model.has_bank, open=is_open_water(exported.ship.model),
        foot=_foot(exported), helm=helm,
        ship=exported.ship.model.configuration.ship.in_words, dotted=f"; dotted: what {whose} covered" * has_range,
        passport=list(passport(exported.ship.model)), data=data.replace("<", "\\u003c"),
        style=asset("palette.css") + files("narrows.export.page").joinpath("page.css").read_text("utf-8"),
        shared="".join(bundled(name, given, known) for name in FIRST),
        worker=bundled("worker.js", given, set(known)), script=bundled("page.js", given, known),
    )  # fmt: skip


def model_script(exported: ExportedShip) -> str:
    return MODEL.format(without_exports(javascript_text(exported, derivatives=False)))


def packed(wasm: bytes) -> str:
    press = zlib.compressobj(9, zlib.DEFLATED, BARE_DEFLATE)
    return base64.b64encode(press.compress(wasm) + press.flush()).decode()


def _foot(exported: ExportedShip) -> str:
    parts = ", ".join(exported.ship.model.configuration.parts)
    of_map = "" if is_open_water(exported.ship.model) else ", 100th on the map"
    return (
        f"{f'; with {parts}' if parts else ''}. Sailed here, by the equations of the package: Runge-Kutta "
        f"steps of a 200th of a ship length{of_map}. The speed is "
        f"{'held' if exported.ship.surge == 'held' else 'free'}."
    )


IMPORT = re.compile(r'^import \{ ([^}]*) \} from "\./([\w/.]+)";\n', re.MULTILINE)
SHARED = re.compile(r'^import \{ ([^}]*) \} from "\.\./\.\./\.\./web/([\w.]+)";\n', re.MULTILINE)
EXPORT = re.compile(r"^export (?:(?:async )?function|const|let) (?:(\w+)|\[([^\]]*)\])", re.MULTILINE)
# Lines that are comments, and what indents the others: a third of a script.
DISPENSABLE = re.compile(r"^[ \t]*(?:(?://.*|/\*\*.*?\*/)[ \t]*\n)?", re.MULTILINE)


def bundled(entry: str, given: Mapping[str, str], known: set[str]) -> str:
    return DISPENSABLE.sub("", "".join(_modules(entry, given, known)))


def _modules(name: str, given: Mapping[str, str], known: set[str]) -> Iterator[str]:
    if name in known:
        return
    known.add(name)
    text = given.get(name) or _read(name)
    for match in (*IMPORT.finditer(text), *SHARED.finditer(text)):
        yield from _modules(match[2], given, known)
    exported = [word for match in EXPORT.finditer(text) for word in re.split(r"\W+", match[1] or match[2])]
    body = without_exports(IMPORT.sub(_taken, SHARED.sub(_taken, text)))
    yield f"const {_variable(name)} = (() => {{\n{body}return {{ {', '.join(exported)} }};\n}})();\n"


def _read(name: str) -> str:
    path = files("narrows.export.page") / "script" / name
    return path.read_text("utf-8") if path.is_file() else asset(name)


def _taken(match: re.Match[str]) -> str:
    return f"const {{ {match[1].replace(' as ', ': ')} }} = {_variable(match[2])};\n"


def _variable(name: str) -> str:
    return f"module_{name.removesuffix('.js')}"


LENGTHS = 7.0  # Distance shown [ship lengths]
# Constants of fleet.c: ships of a task, ships with stored paths, points of a path.
MOST, PATHS, SAMPLES = 4096, 1024, 96
UNSETTLED = "The tests of this ship do not settle how strongly the banks pull and turn it."
UNTESTED = "How strongly the banks pull and turn this ship is estimated from other ships."


def page_data(exported: ExportedShip, speed: float, title: str) -> dict[str, Any]:
    model, kept = exported.ship.model, exported.kept
    ship, sliders = model.configuration.ship, sliders_of(exported, speed, exported.steering is not None)
    names = [slider.name for slider in sliders if slider.group == COEFFICIENTS]
    speeds = next(slider for slider in sliders if slider.name == "u")
    return {
        "title": title, "picture": "narrows.png", "lengths": LENGTHS,
        "ship": {"length": ship.length, "beam": ship.beam},
        "shape": {
            "states": len(kept), "parameters": len(exported.parameters), "most": MOST, "paths": PATHS,
            "samples": SAMPLES, "rudder": kept.index("rudder") if "rudder" in kept else -1,
            "turned": _turned(exported),
        },
        "canal": {name: value for name, value in asdict(model.configuration.canal).items() if value is not None},
        "open": is_open_water(model), "banks": model.has_bank,
        "settled": not (model.trust_note or model.covariance is None),
        "basis": "estimate" if model.source.estimate else "assumed" if model.covariance is None else "tests",
        "names": {
            "parameters": [JavaScript().named(one.name) for one in exported.parameters],
            "inputs": [JavaScript().named(one.name) for one in exported.inputs],
        },
        "parameters": [one.value for one in exported.parameters], "inputs": [one.value for one in exported.inputs],
        "coefficients": [
            {"name": name, "bounds": [float(end) if np.isfinite(end) else None for end in model.terms[name].bound]}
            for name in names
        ],
        "root": _written(root_of(model, names)), "share": ASSUMED,
        "assumed": model.covariance is None,
        "sliders": [slider.to_dict() for slider in sliders], "speeds": [speeds.low, speeds.high],
        "tested": {
            "u": covered(model.data_range.speed), "y": covered(model.data_range.abs_y, both=True),
            "psi": covered(model.data_range.abs_psi, both=True),
        },
        "notes": _notes(model, sliders),
    }  # fmt: skip


def _turned(exported: ExportedShip) -> list[int]:
    """Indices of the state from the rudder on: itself, orders on their way, the last one."""
    kept, steering = exported.kept, exported.steering
    start = {**dict.fromkeys((*STATE, "rudder"), 0.0), "cos_psi": 1.0}
    at = [steering.memory({**start, "rudder": angle}) if steering else {} for angle in (0.0, 1.0)]
    turned = {"rudder", *(name for name, value in at[1].items() if value != at[0][name])}
    turned |= {stage for one in exported.geared for stage in one.stages}
    return [place for place, name in enumerate(kept) if name in turned]


def _written(root: np.ndarray) -> list[Any]:
    """The rows of a matrix to ten digits; only its diagonal if the rest is zero."""
    diagonal = np.diag(root)
    if np.array_equal(root, np.diag(diagonal)):
        return [float(f"{value:.10g}") for value in diagonal]
    return [[float(f"{value:.10g}") for value in row] for row in root]


def _notes(model: Model, sliders: list[Slider]) -> list[str]:
    said = {slider.name for slider in sliders if slider.tested}
    asked = (("u", "speeds"), ("y", "offsets"))[: 1 if is_open_water(model) else 2]
    unsaid = [words for name, words in asked if name not in said]
    doubt = UNTESTED if model.source.estimate else UNSETTLED
    notes = [doubt] if model.trust_note else []  # Without a bank force the headline gives the note
    tested = unsaid and not model.source.estimate
    silent = f"Which {' and '.join(unsaid)} its tests covered is not known." if tested else ""
    return [*notes, *filter(None, [silent])]


def root_of(model: Model, names: list[str]) -> np.ndarray:
    if model.covariance is None:
        return np.diag([deviation(model, name) for name in names])
    places = [model.terms.names.index(name) for name in names]
    return symmetric_root(model.covariance[np.ix_(places, places)])


@dataclass(frozen=True)
class SwitchedLaw(ControlLaw):
    """A control law that is switched on by hand; until then the rudder keeps an ordered angle, its last order."""

    law: ControlLaw

    def parameters(self) -> Mapping[str, Any]:
        return {**self.law.parameters(), "ordered": 0.0, "steers": 0.0}  # Over 0 if the law steers

    def memory(self, start: Named) -> Named:
        return self.law.memory(start)

    def orders(self, at: Any) -> tuple[Named, Named]:
        orders, memory = self.law.orders(at)
        before = {name: at.ordered if name == LAST_ORDER else getattr(at, name) for name in memory}
        kept = {name: choice(at.steers, value, before[name]) for name, value in memory.items()}
        return {**orders, "rudder": choice(at.steers, orders["rudder"], at.ordered)}, kept


def helm_of(model: Model, speed: float) -> tuple[SwitchedLaw | None, str]:
    from narrows.control.regulator import regulator

    if not any(actuator.name == "rudder" for actuator in model.terms.actuators):
        return None, "This model has no rudder: nothing steers."
    try:
        return SwitchedLaw(regulator(model, 0.0, speed)), ""
    except InputError as error:
        return None, f"No helm: {error}."


# The exported C, with what sails fleets of it, as WebAssembly.
FLAGS = (
    "-std=gnu99", "-O3", "-msimd128", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off", "-mllvm",
    "-inline-threshold=5000", "-nostdlib", "-Wl,--no-entry", "-Wl,--strip-all", "-Wl,-z,stack-size=65536",
)  # fmt: skip

SOURCES = ("fleet.c", "lanes.c", "math.h")
NUMBER = re.compile(r"(?<![\w.])(\d+\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+)(?![\w.])")
FUNCTION = re.compile(r"(?<![\w.])(exp|log|pow|sin|cos|hypot|fmod|floor|trunc|fabs|sqrt|atan2)\(")
LANE, SHIP = "lane", "ship"


def wasm_of(exported: ExportedShip, single: bool = True) -> bytes:
    """Return a WebAssembly module that simulates fleets of a ship, 64 at a time."""
    ship = c_text(exported)
    lane = re.sub(rf"\b{SHIP}_", f"{LANE}_", re.sub(rf"\b{SHIP.upper()}_", f"{LANE.upper()}_", ship))
    if single:
        lane = re.sub(r"\bdouble\b", "float", FUNCTION.sub(r"\1f(", NUMBER.sub(r"\1f", lane)))
    texts = {"ship.h": ship, "lane.h": lane}
    texts |= {name: (files("narrows.export.page") / "fleet" / name).read_text("utf-8") for name in SOURCES}
    with TemporaryDirectory(prefix="narrows-page-") as folder:
        for name, text in texts.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        chosen = f"-DLANE_REAL={'float' if single else 'double'}", *("-DSTEERED",) * ("rudder" in exported.kept)
        command = *ZIG_CC, "-target", "wasm32-freestanding", *FLAGS, *chosen, f"-I{folder}", f"{folder}/fleet.c"
        return compiled(command, Path(folder, "fleet.wasm"), "WebAssembly")
