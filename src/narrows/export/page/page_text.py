"""The one file of a page: markup, styles, numbers, the exported model, scripts, and WebAssembly as text."""

import base64
import json
import re
import zlib
from importlib.metadata import version

from narrows.export.exported_ship import ExportedShip
from narrows.export.javascript_module import javascript_text
from narrows.export.page.page_data import page_data
from narrows.export.page.script_bundle import bundled, smaller

BARE_DEFLATE = -15
# What both the page and its workers run.
FIRST = ("fleet_shape.js", "model.js", "plain_fleet.js")
# Signs of the model's text, which has no words between quotes, that need no blank beside them.
SUMS = re.compile(r" ([+-]) (?![+-])")
# Which the page's numbers say already.
DEFAULTS = re.compile(r"^const (?:model|atRest)=Object.freeze\(\{[^}]*\}\);\n", re.MULTILINE)
# Fields of a structure unpacked one after another.
UNPACKED = re.compile(r"^const (\w+)=(inputs|constants|parameters)\.\1;\n(?:const (\w+)=\2\.\3;\n)*", re.MULTILINE)
# Behind a number of the model's text.
MEANING = re.compile(r"(?<=;)//.*$", re.MULTILINE)
# Lines of the model's text that name a number each.
IN_A_ROW = re.compile(r"(?:^const \w+=.*;\n){2,}", re.MULTILINE)
MODEL = "export const model = (() => {{\n{}\nreturn {{ prepare, rates, room, sail }};\n}})();\n"


def page_text(exported: ExportedShip, speed: float, title: str, helm: str, wasm: bytes | None) -> str:
    """Return the page of a ship."""
    # speed [m/s]
    from jinja2 import Environment, PackageLoader, StrictUndefined

    from narrows.web.assets import asset

    data = json.dumps(page_data(exported, speed, title) | {"wasm": packed(wasm) if wasm else ""}, separators=(",", ":"))
    template = Environment(loader=PackageLoader("narrows.export.page", "."), undefined=StrictUndefined)
    known: set[str] = set()
    given = {"model.js": model_script(exported)}
    return template.get_template("page.html.j2").render(
        title=title, foot=_foot(exported), helm=helm, data=data.replace("<", "\\u003c"),
        style=smaller(asset("palette.css") + own_style()),
        shared="".join(bundled(name, given, known) for name in FIRST),
        worker=bundled("worker.js", given, set(known)), script=bundled("page.js", given, known),
    )  # fmt: skip


def own_style() -> str:
    """Return the style of the page itself."""
    from importlib.resources import files

    return (files("narrows.export.page") / "page.css").read_text("utf-8")


def model_script(exported: ExportedShip) -> str:
    """Return the exported model as a module that gives what a page asks for."""
    text = smaller(javascript_text(exported, derivatives=False)).replace("export ", "")
    text = UNPACKED.sub(_destructured, DEFAULTS.sub("", MEANING.sub("", text)))
    return MODEL.format(IN_A_ROW.sub(_together, SUMS.sub(r"\1", text)))


def _together(match: re.Match[str]) -> str:
    return match[0][:-1].replace(";\nconst ", ",\n") + "\n"


def _destructured(match: re.Match[str]) -> str:
    names = re.findall(r"^const (\w+)", match[0], re.MULTILINE)
    return f"const {{ {', '.join(names)} }} = {match[2]};\n"


def packed(wasm: bytes) -> str:
    """Return bytes as text: deflated, base 64."""
    press = zlib.compressobj(9, zlib.DEFLATED, BARE_DEFLATE)
    return base64.b64encode(press.compress(wasm) + press.flush()).decode()


def _foot(exported: ExportedShip) -> str:
    model = exported.ship.model
    return (
        f"{model.configuration.summary()}. {model.source.text + '. ' if model.source.text else ''}Sailed here, by the "
        f"equations of the package: Runge-Kutta steps of a 200th of a ship length, 100th on the map. The speed is "
        f"{'held' if exported.ship.surge == 'held' else 'free'}. Written by narrows {version('narrows')}."
    )
