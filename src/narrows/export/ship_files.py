"""A ship as one file of a language: a C header, an ES module, a Python file."""

import ast
import gzip
import json
import tarfile
from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from io import BytesIO

from narrows.codegen.choices import COUNTED, LENGTH
from narrows.codegen.free_motion import INPUTS, OPEN
from narrows.codegen.linearisation import LINEARISED
from narrows.codegen.lines import Lines, Program
from narrows.codegen.printers.c import BlockC, C, CTranslation, c_block, lane_functions
from narrows.codegen.printers.language import JavaScript, Matlab, PythonFile
from narrows.codegen.printers.translation import Translation
from narrows.export.exported_ship import ExportedNumber, ExportedShip
from narrows.export.fmu_variables import HEADING
from narrows.export.rendering import (
    OUTCOME_CODES,
    bodies_of,
    explained,
    last_functions,
    numbers_of,
    places_in,
    plain_functions,
    rendered,
    translated,
    water_of,
)
from narrows.simulation.initial_state import voyage_defaults


def c_text(exported: ExportedShip) -> str:
    language, filling = C(exported.prefix), ("fill_table",) if exported.waterway else ()
    bodies = {**bodies_of(exported, language), "step_block": "\n    ".join(_block(exported))}
    lanes = lane_functions() if "_lane_" in bodies["step_block"] else {}
    return rendered(
        "model.h.j2", exported, language, f=bodies, lanes=lanes, water=water_of(exported, language),
        **translated(exported, partial(CTranslation, prefix=exported.prefix), *filling),
    )  # fmt: skip


def cpp_text(exported: ExportedShip) -> str:
    """Return the C of a ship with a class around it."""
    return rendered(
        "model.hpp.j2", exported, C(exported.prefix), c=c_text(exported), outcomes=OUTCOME_CODES,
        counted=COUNTED in exported.portable.kept, between_banks=exported.ship.shape != OPEN,
    )  # fmt: skip


def _block(exported: ExportedShip) -> list[str]:
    language = BlockC(exported.prefix)
    portable, places = exported.portable, places_in(exported, language)
    for column, rows in (("state", portable.kept), ("inputs", portable.inputs)):
        places |= {name: f"{column}[{number}][lane]" for number, name in enumerate(rows)}
    results = {
        f"state[{number}][lane]": portable.step.out[name]
        for number, name in enumerate((*portable.kept, "clearance", "side"))
    }
    return c_block(portable.step.lines, results, places, language, f"{exported.prefix.upper()}_LANES")


def javascript_text(exported: ExportedShip, derivatives: bool = True) -> str:
    language = JavaScript()
    return rendered(
        "model.js.j2", exported, language, f=bodies_of(exported, language), water=water_of(exported, language),
        derivatives=derivatives, **translated(exported, Translation),
    )  # fmt: skip


def npm_bytes(exported: ExportedShip) -> bytes:
    """Return an npm package of the module, for ``npm install``."""
    language = JavaScript()
    types = rendered(
        "package.d.ts.j2",
        exported,
        language,
        f=bodies_of(exported, language),
        water=exported.waterway,
        outcomes=OUTCOME_CODES,
    )
    own = {
        "name": exported.prefix.lower(), "version": version("narrows"), "type": "module",
        "license": "SEE LICENSE IN README.md",
        "description": next(exported.about()), "exports": {".": {"types": "./index.d.ts", "default": "./index.mjs"}},
        "types": "./index.d.ts",
    }  # fmt: skip
    texts = {
        "package.json": json.dumps(own, indent=2) + "\n", "index.mjs": javascript_text(exported), "index.d.ts": types,
        "README.md": "\n\n".join(exported.about()) + "\n",
    }  # fmt: skip
    packed = BytesIO()
    with tarfile.open(fileobj=packed, mode="w") as archive:
        for name, text in texts.items():
            member = tarfile.TarInfo(f"package/{name}")
            member.size, member.mode = len(text.encode()), 0o644
            archive.addfile(member, BytesIO(text.encode()))
    return gzip.compress(packed.getvalue(), mtime=0)


def python_text(exported: ExportedShip) -> str:
    language, source = PythonFile(), plain_functions(exported)
    functions = last_functions(exported, source)
    asked = {one.id for function in functions for one in ast.walk(function) if isinstance(one, ast.Name)}
    return rendered(
        "model.py.j2", exported, language, f=bodies_of(exported, language), water=water_of(exported, language),
        plain=[ast.unparse(one) for one in functions], numbers=numbers_of(source, asked),
    )  # fmt: skip


def matlab_text(exported: ExportedShip) -> str:
    """Return the rates of a ship as a function of MATLAB, with the states in the order of MSS."""
    language, portable = Matlab(), exported.portable
    order = [one.name for one in _states_of_mss(exported)]
    where = {name: f"x({number})" for number, name in enumerate(order, 1)}
    for angle in ("psi", *(actuator.name for actuator in portable.geared)):
        where |= {f"{function}_{angle}": language.called(function, where[angle]) for function in ("cos", "sin")}
    inputs = _orders_first(exported)
    where |= {name: f"ui({number})" for number, (name, _) in enumerate(inputs, 1)}
    where |= {LENGTH: language.literal(voyage_defaults(exported.ship.model).dt)}
    motion, gear = portable.continuous[:2]
    asked = [name for name in exported.constants if name in {*motion.asked, *gear.asked, *exported.water}]
    where |= {name: name for name in asked}
    rates = {f"d_{name}": f"xdot({order.index(name) + 1})" for name in (*LINEARISED, *portable.gear)}
    targets = list(rates.values())
    lines = [
        *language.body(motion, targets[: len(LINEARISED)], where),
        *language.body(gear, targets[len(LINEARISED) :], where),
    ]
    known = dict(zip(exported.constants, exported.programs["constants"].results, strict=True))
    constants = Program.of(Lines(list(exported.programs["constants"].assignments)), [known[name] for name in asked])
    return rendered(
        "model.m.j2", exported, language, lines=lines, inputs=[one for _, one in inputs],
        states=_states_of_mss(exported),
        parameters=[one for one in exported.parameters if one.name in constants.asked],
        constants=explained(
            exported, language, language.body(constants, asked, {name: name for name in constants.asked}), asked
        ),
        sizes={"speed": "x(1)", "abs_y": "x(5)", "abs_psi": "angle(cos(x(6)), sin(x(6)))", "abs_r": "x(3)",
               **{name: name for name in exported.water}},
    )  # fmt: skip


def _orders_first(exported: ExportedShip) -> list[tuple[str, ExportedNumber]]:
    """Return the inputs in the order of MSS, each with its name in the lines."""
    pairs = zip(exported.portable.inputs, exported.inputs, strict=True)
    return sorted(pairs, key=lambda pair: pair[0] in INPUTS.values())


def _states_of_mss(exported: ExportedShip) -> list[ExportedNumber]:
    states = {one.name: one for one in exported.state} | {"psi": ExportedNumber("psi", 0.0, "rad", HEADING)}
    return [states[name] for name in ("u", "v", "r", "x", "y", "psi", *exported.portable.gear)]


def simulink_text(exported: ExportedShip) -> str:
    """Return the C of a ship with an S-function of Simulink around it."""
    language = C(exported.prefix)
    return rendered(
        "simulink.c.j2", exported, language, c=c_text(exported), states=_states_of_mss(exported),
        inputs=[one for _, one in _orders_first(exported)], dt=voyage_defaults(exported.ship.model).dt,
        **rates_of(exported, language),
    )  # fmt: skip


def rates_of(exported: ExportedShip, language: C) -> dict[str, str]:
    """Return the bodies of the template ``evaluate.h.j2``: rates of the motion, then of the gear."""
    places, start, bodies = places_in(exported, language), 0, {}
    for name, program in zip(("motion", "gear"), exported.portable.continuous, strict=False):
        targets = [f"result[{start + number}]" for number in range(len(program.results))]
        bodies[name] = "\n    ".join(language.body(program, targets, places))
        start += len(targets)
    return bodies


# The text of a whole ship, by the suffix of its file.
TEXTS: dict[str, Callable[[ExportedShip], str | bytes]] = {
    ".h": c_text, ".hpp": cpp_text, ".mjs": javascript_text, ".js": javascript_text, ".tgz": npm_bytes,
    ".py": python_text, ".m": matlab_text, ".c": simulink_text,
}  # fmt: skip
