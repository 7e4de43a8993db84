"""A ship prepared for its page: a helm if it has a rudder, WebAssembly if there is a compiler."""

import base64
import json
import math
import re
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import partial
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
from narrows.export.passport import passport
from narrows.export.ship_files import c_text, javascript_text
from narrows.model.data_range import Range, tolerated
from narrows.model.model import SETTLED, Model
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
    canal = "between the banks of a canal" if model.has_bank else "in a canal, without a bank force"
    where = "in open water" if is_open_water(model) else canal
    title = title or f"{model.configuration.ship.name} {where}: every line is one ship"
    notes = (f"{SLOWER}: {lacking}" if lacking else "", why, model.bank_note)
    return page_text(exported, speed, title, why, wasm), tuple(filter(None, notes))


SLOWER = "the page sails by plain JavaScript, a few times slower"
BARE_DEFLATE = -15
# Scripts of both the page and its workers.
FIRST = ("fleet_shape.js", "model.js", "plain_fleet.js")
MODEL = "export const model = (() => {{\n{}\nreturn {{ prepare, rates, least_clearance, integrate }};\n}})();\n"


def page_text(exported: ExportedShip, speed: float, title: str, helm: str, wasm: bytes | None) -> str:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    model, known, given = exported.ship.model, set[str](), {"model.js": model_script(exported)}
    packed = base64.b64encode(zlib.compress(wasm, 9, BARE_DEFLATE)).decode() if wasm else ""
    data = json.dumps(page_data(exported, speed, title) | {"wasm": packed}, separators=(",", ":"))
    template = Environment(loader=PackageLoader("narrows.export.page", "."), undefined=StrictUndefined)
    whose = "tests of other ships" if model.source.estimate else "the tests"
    has_range = model.data_range.speed is not None or model.data_range.abs_y is not None
    parts, of_map = ", ".join(model.configuration.parts), "" if is_open_water(model) else ", 100th on the map"
    return template.get_template("page.html.j2").render(
        title=title, banks=model.has_bank, open=is_open_water(model), helm=helm, ship=model.configuration.ship.in_words,
        foot=f"{f'; with {parts}' if parts else ''}. Sailed here, by the equations of the package: Runge-Kutta steps "
        f"of a 200th of a ship length{of_map}. The speed is {exported.ship.surge}.",
        dotted=f"; dotted: what {whose} covered" * has_range,
        passport=list(passport(model)), data=data.replace("<", "\\u003c"),
        style=asset("palette.css") + files("narrows.export.page").joinpath("page.css").read_text("utf-8"),
        shared="".join(bundled(name, given, known) for name in FIRST),
        worker=bundled("worker.js", given, set(known)), script=bundled("page.js", given, known),
    )  # fmt: skip


def model_script(exported: ExportedShip) -> str:
    return MODEL.format(without_exports(javascript_text(exported, derivatives=False)))


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
    path = files("narrows.export.page") / "script" / name
    text = given.get(name) or (path.read_text("utf-8") if path.is_file() else asset(name))
    for match in (*IMPORT.finditer(text), *SHARED.finditer(text)):
        yield from _modules(match[2], given, known)
    exported = [word for match in EXPORT.finditer(text) for word in re.split(r"\W+", match[1] or match[2])]
    body = without_exports(IMPORT.sub(_taken, SHARED.sub(_taken, text)))
    yield f"const module_{name.removesuffix('.js')} = (() => {{\n{body}return {{ {', '.join(exported)} }};\n}})();\n"


def _taken(match: re.Match[str]) -> str:
    return f"const {{ {match[1].replace(' as ', ': ')} }} = module_{match[2].removesuffix('.js')};\n"


LENGTHS = 7.0  # Distance shown [ship lengths]
# Constants of fleet.c: ships of a task, ships with stored paths, points of a path.
MOST, PATHS, SAMPLES = 4096, 1024, 96
UNSETTLED = "The tests of this ship do not settle how strongly the banks pull and turn it."
UNTESTED = "How strongly the banks pull and turn this ship is estimated from other ships."


def page_data(exported: ExportedShip, speed: float, title: str) -> dict[str, Any]:
    model, kept = exported.ship.model, exported.kept
    ship, sliders = model.configuration.ship, [*sliders_of(exported, speed)]
    names = [slider["name"] for slider in sliders if slider["group"] == COEFFICIENTS]
    speeds = next(slider for slider in sliders if slider["name"] == "u")
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
        "root": root_of(model, names), "share": ASSUMED,
        "assumed": model.covariance is None,
        "sliders": sliders, "speeds": [speeds["low"], speeds["high"]],
        "tested": {
            "u": covered(model.data_range.speed), "y": covered(model.data_range.abs_y, both=True),
            "psi": covered(model.data_range.abs_psi, both=True),
        },
        "notes": _notes(model),
    }  # fmt: skip


def _turned(exported: ExportedShip) -> list[int]:
    """Indices of the state from the rudder on: itself, orders on their way, the last one."""
    kept, steering = exported.kept, exported.steering
    start = {**dict.fromkeys((*STATE, "rudder"), 0.0), "cos_psi": 1.0}
    at = [steering.memory({**start, "rudder": angle}) if steering else {} for angle in (0.0, 1.0)]
    turned = {"rudder", *(name for name, value in at[1].items() if value != at[0][name])}
    turned |= {stage for one in exported.geared for stage in one.stages}
    return [place for place, name in enumerate(kept) if name in turned]


def _notes(model: Model) -> list[str]:
    known, estimate = model.data_range, model.source.estimate
    asked = ((known.speed, "speeds"), (known.abs_y, "offsets"))[: 1 if is_open_water(model) else 2]
    unsaid = " and ".join(words for covered, words in asked if covered is None)
    # Without a bank force the headline gives the note
    doubt = [UNTESTED if estimate else UNSETTLED] * bool(model.trust_note)
    return doubt + [f"Which {unsaid} its tests covered is not known."] * bool(unsaid and not estimate)


def root_of(model: Model, names: list[str]) -> list[Any]:
    """Return a root of the covariance of some coefficients to ten digits; its diagonal where a model has none."""
    root = np.array([deviation(model, name) for name in names])
    if model.covariance is not None:
        places = [model.terms.names.index(name) for name in names]
        root = symmetric_root(model.covariance[np.ix_(places, places)])
    return np.vectorize(lambda value: float(f"{value:.10g}"), otypes=[float])(root).tolist()  # type: ignore[no-any-return]


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


# The sliders: inputs of the model's terms, with ranges that suit the ship and the tested range.
VOYAGE, CANAL, UNKNOWN = "The voyage", "The canal", "Uncertainty"
PICTURES, COEFFICIENTS = "The pictures", "Coefficients"
ASSUMED = 0.05  # Relative standard deviation of a coefficient if the model has no covariance
# Range of a coefficient's slider [standard deviations]; canal widths: least [beams], most relative to the model's own.
WIDE, NARROWEST, WIDEST = 3.0, 1.6, 2.0
# Standard deviation of the starting offset [ship lengths] and of the heading [degrees].
START_SPREAD, HEADING_SPREAD = 0.0125, 0.5
# Open water: clearance to either bank, and largest starting offset [ship lengths]; a voyage is 7 long.
CLEARANCE, OFFSET = 10.0, 2.0


def is_open_water(model: Model) -> bool:
    """Return whether a model has no bank force, and the banks of its canal are out of reach."""
    ship = model.configuration.ship
    return not model.has_bank and model.configuration.canal.width > 2 * CLEARANCE * ship.length


def sliders_of(exported: ExportedShip, speed: float) -> Iterator[dict[str, Any]]:
    model, inputs = exported.ship.model, {one.name: one.value for one in exported.inputs}
    ship, canal, known = model.configuration.ship, model.configuration.canal, model.data_range
    is_open, names = is_open_water(model), {parameter.name for parameter in exported.parameters}
    most, slider = OFFSET * ship.length if is_open else (canal.width - ship.beam) / 2, partial(_slider, model, VOYAGE)
    if exported.steering is not None:
        line = "dashed line" if is_open else "middle"
        yield _described("helm", f"helm: hold the {line}", "", VOYAGE, 0, 1, 1, 0, switch=True)
    fine, off = _fine(speed / 50), _fine(most / 200)
    yield slider("u", "speed", "m/s", (0.3 * speed, 1.6 * speed), fine, speed, known.speed)
    start = _to(min(most / 9, ship.length), off)
    yield slider("y", "start, to starboard", "m", (-most, most), off, start, known.abs_y, both=True)
    degree = math.degrees(1.0)
    yield slider("psi", "heading, to starboard", "°", (-12, 12), 0.1, 0, known.abs_psi, degree, both=True)
    if "rudder" in exported.kept:
        limit = math.floor(math.degrees(model.configuration.gear.limit))
        yield slider("rudder", "rudder, to starboard", "°", (-limit, limit), 0.5, 0)
    if "revolutions" in inputs:
        n = inputs["revolutions"]
        astern = getattr(model.configuration.propeller, "turns_astern", False)
        yield slider("revolutions", "revolutions", "1/s", (-2 * n if astern else 0, 2 * n), _fine(n / 100), n)
    yield slider("current", "current, from astern", "m/s", (-0.25 * speed, 0.5 * speed), fine, 0)
    slider = partial(_slider, model, CANAL)
    if not is_open:
        yield slider("width", "width", "m", (NARROWEST * ship.beam, WIDEST * canal.width), _fine(canal.width / 200),
                     canal.width, known.width_to_beam, ship.beam, told="the width of the canal")  # fmt: skip
    if "depth" in names and canal.depth:
        ends = 1.1 * ship.draft, max(4 * ship.draft, canal.depth)
        yield slider("depth", "depth", "m", ends, _fine(ship.draft / 100), canal.depth, known.depth_to_draft,
                     ship.draft, told="the depth of the canal")  # fmt: skip
    slider, fine, spread = partial(_slider, model, UNKNOWN), _fine(ship.length / 800), START_SPREAD * ship.length
    yield slider("sd_y", "spread of starts", "m", (0, 6 * spread), fine, _to(spread, fine))
    yield slider("sd_psi", "spread of headings", "°", (0, 3), 0.05, HEADING_SPREAD)
    yield slider("doubt", "spread of coefficients", "×", (0, 3), 0.05, 1)
    yield _described("ships", "ships", "", PICTURES, 500, 10_000, 500, 3000)
    if not is_open:
        yield _described("map", "map, cells across", "", PICTURES, 40, 240, 20, 200)
    yield from (_coefficient(model, name) for name in model.terms.names if name in names)


def _described(
    name: str, label: str, unit: str, group: str, low: float, high: float, step: float, value: float, **more: Any
) -> dict[str, Any]:
    """Return a slider by its name in the address and its label, in a group with a heading."""
    # ``tested``: range of the data; ``beyond``: that range in words for a value beyond it; ``told``: name in the list
    # of values beyond the data; ``switch``: an on-off switch.
    own = {"name": name, "label": label, "unit": unit, "group": group, "low": low, "high": high, "step": step}
    known = {key: given for key, given in more.items() if given is not None}
    return {**own, "value": value, **known, "digits": max(0, -math.floor(math.log10(step) + 1e-9))}


def _slider(
    model: Model, group: str, name: str, label: str, unit: str, ends: Range, fine: float, value: float,
    known: Range | None = None, scale: float = 1.0, both: bool = False, told: str | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Return a slider by its step, with the range of the data: ``known`` times ``scale``, of ``both`` signs."""
    words = None
    if known is not None:
        whose = "other ships" if model.source.estimate else "tested"
        words = f"{whose}: {_ends((scale * known[0], scale * known[1]), fine)}{'' if unit == '°' else ' '}{unit}"
    low, high = (_to(end, fine) for end in ends)
    more = {"tested": covered(known, scale, both), "beyond": words, "told": told}
    return _described(name, label, unit, group, low, high, fine, value, **more)


def deviation(model: Model, name: str) -> float:
    """Return the standard deviation of a coefficient, or the assumed one without a covariance."""
    if model.covariance is None:
        return ASSUMED * abs(model.coefficients[name])
    place = model.terms.names.index(name)
    return float(np.sqrt(model.covariance[place, place]))


def _coefficient(model: Model, name: str) -> dict[str, Any]:
    value, bound = model.coefficients[name], model.terms[name].bound
    size = WIDE * deviation(model, name) or abs(value) or 1.0
    size = max(size, abs(value) if model.covariance is None else 0.0)
    low, high = max(value - size, bound[0]), min(value + size, bound[1])
    verdict = model.verdicts.get(name, "no verdict")
    unit = model.terms[name].dimension.unit
    inside = None if model.covariance is None else (value - 2 * size / WIDE, value + 2 * size / WIDE)
    label, fine = name if verdict == SETTLED else f"{name}, {verdict}", _fine(size / 100)
    words = None if inside is None else f"interval: {_ends(inside, fine)}"
    return _described(name, label, "" if unit == "1" else unit, COEFFICIENTS, low, high, fine, value,
                      tested=inside, beyond=words, told=name)  # fmt: skip


def covered(known: Range | None, scale: float = 1.0, both: bool = False) -> Range | None:
    """Return the range of the data; of ``both`` signs where they limit an absolute value."""
    if known is None:
        return None
    low, high = tolerated(known)
    return -scale * high if both else scale * low, scale * high


def _ends(known: Range, fine: float) -> str:
    return ("–" if known[0] >= 0 else " to ").join(dict.fromkeys(f"{_to(end, fine):g}" for end in known))


def _fine(size: float) -> float:
    """Return a step of 1, 2 or 5 times a power of ten, no larger."""
    power = 10.0 ** math.floor(math.log10(size))
    return float(f"{max(step for step in (1, 2, 5) if step * power <= size * (1 + 1e-9)) * power:.3g}")


def _to(value: float, fine: float) -> float:
    return float(f"{round(value / fine) * fine:.10g}")
