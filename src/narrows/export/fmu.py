"""A model as an FMU: its C code, an interface, a description, and libraries for the available platforms."""

import hashlib
import zipfile
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import wrap
from typing import Any

from narrows.codegen.choices import COUNTED
from narrows.codegen.free_motion import OPEN
from narrows.codegen.linearisation import LINEARISED
from narrows.codegen.portable import ALONG
from narrows.codegen.printers.c import C
from narrows.export.exported_ship import ExportedShip
from narrows.export.fmu_variables import (
    INTEGERS,
    KNOWNS,
    REALS,
    UNKNOWNS,
    FmuVariable,
    Kind,
    indicators,
    unit_powers,
    variables_of,
)
from narrows.export.native_build import NativeBuild, libraries_of_source
from narrows.export.passport import passport
from narrows.export.rendering import commented, filled, places_in, rendered
from narrows.export.ship_files import c_text, rates_of
from narrows.model.model import Model
from narrows.simulation.initial_state import voyage_defaults

# All files in an FMU have one time, so that writing it again gives the same file.
SAME_TIME = (2000, 1, 1, 0, 0, 0)
# Sources of either standard that do not depend on the model.
SOURCES = {
    2: ("calls.h", "fmi2.c", "fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("calls.h", "fmi3.c", "fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
# Letters on a line of C.
LETTERS_A_LINE = 100
# Steps between the outputs of a default experiment.
OUTPUT_STEPS = 10


def fmu_bytes(
    exported: ExportedShip, identifier: str, speed: float, dt: float, builds: tuple[NativeBuild, ...], fmi: int = 2
) -> bytes:
    header, variables, model = c_text(exported), variables_of(exported, speed, dt), exported.ship.model
    token = token_of(header, identifier, speed, dt, fmi)
    defaults = voyage_defaults(model, speed)
    output = OUTPUT_STEPS * defaults.dt
    stop = round(round(defaults.duration / output) * output, 6)  # No step of a default experiment passes its end
    description = description_text(
        model, variables, fmi, identifier=identifier, token=token, stop=stop, output=output,
        derivatives="true",
    )  # fmt: skip
    sources = {"ship.h": header, "choices.h": _choices(exported, variables, token, speed, dt)}
    sources["instance.h"] = source_of("instance.h")
    return fmu_of(sources, description, exported.about(), identifier, builds, fmi)


def token_of(*parts: object) -> str:
    """Return the identifier that distinguishes an FMU from every other."""
    return hashlib.sha256(" ".join(map(str, parts)).encode()).hexdigest()[:32]


def source_of(name: str) -> str:
    return (files("narrows.export") / "fmi" / name).read_text("utf-8")


def fmu_of(
    own: Mapping[str, str],
    description: str,
    about: Iterable[str],
    identifier: str,
    builds: tuple[NativeBuild, ...],
    fmi: int,
) -> bytes:
    """Return the archive: the description, the sources, the libraries, the passport."""
    sources = {**own, **{name: source_of(name) for name in SOURCES[fmi]}}
    parts = {"modelDescription.xml": description.encode()}
    parts |= {f"sources/{name}": text.encode() for name, text in sources.items()}
    if fmi > 2:
        parts["sources/buildDescription.xml"] = filled("build.xml.j2", identifier=identifier).encode()
    parts["documentation/passport.txt"] = "".join(f"{line}\n" for line in about).encode()
    with TemporaryDirectory(prefix="narrows-fmu-") as folder:
        for name, text in sources.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        parts |= libraries_of_source(Path(folder, f"fmi{fmi}.c"), identifier, builds)
    return _packed(parts)


def _packed(parts: Mapping[str, bytes]) -> bytes:
    archive = BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in parts.items():
            packed.writestr(zipfile.ZipInfo(name, SAME_TIME), content, zipfile.ZIP_DEFLATED)
    return archive.getvalue()


def _choices(exported: ExportedShip, variables: tuple[FmuVariable, ...], token: str, speed: float, dt: float) -> str:
    letters = "".join(one.kind for one in variables)
    bounded = [one.bounds for one in variables if one.kind in (Kind.FIXED, Kind.INPUT, Kind.TUNABLE)]
    outcomes = [f"SHIP_{outcome.upper()}" for _, outcome, _ in indicators(exported)]
    return rendered(
        "choices.h.j2", exported, C(), token=token, speed=speed, dt=dt, events=outcomes,
        banks=exported.ship.shape != OPEN, counted=COUNTED in exported.portable.kept, kinds={k.name: k for k in Kind},
        reals=REALS, integers=INTEGERS, unknowns=UNKNOWNS, knowns=KNOWNS,
        letters=[f'"{line}"' for line in wrap(letters, LETTERS_A_LINE)],
        low=[C().literal(low) for low, _ in bounded], high=[C().literal(high) for _, high in bounded],
        lever=exported.ship.model.configuration.ship.length / 2, **_programs(exported),
    )  # fmt: skip


def _programs(exported: ExportedShip) -> dict[str, str]:
    """Programs of ``evaluate`` and the like, with the derivatives along a direction."""
    portable, language = exported.portable, C(exported.prefix)
    places = places_in(exported, language)
    # Places of each number's derivative along the direction.
    ways = {ALONG(name): f"along_{where}" for name, where in places.items() if "->" in where}
    ways |= {ALONG(name): "0.0" for name, where in places.items() if where == "0.0"}
    ways |= {ALONG(name): f"along_state[{number}]" for number, name in enumerate((*LINEARISED, *portable.gear))}
    known = rates_of(exported, language)
    # In open water there is no clearance.
    starts = {"motion": 0, "gear": len(LINEARISED), "clearance": 0}
    for (name, start), program in zip(starts.items(), portable.continuous, strict=False):
        targets = [f"result[{start + number}]" for number in range(len(program.results))]
        known[f"{name}_along"] = "\n    ".join(language.body(portable.along(program), targets, places | ways))
    names = [one.name for one in exported.parameters]
    where = {name: language.field("parameters", name) for name in names}
    where |= {ALONG(name): language.field("along_parameters", name) for name in names}
    targets = [language.field("along_constants", name) for name in exported.constants]
    along = language.body(portable.along(exported.programs["constants"]), targets, where)
    return known | {"constants_along": "\n    ".join(along)}


def description_text(model: Model, variables: tuple[FmuVariable, ...], fmi: int, **context: Any) -> str:
    # FMI 2.0 has its event indicators and its time without a variable.
    shown = tuple(one for one in variables if fmi > 2 or one.kind not in (Kind.INDICATOR, Kind.TIME_ITSELF))
    indices: dict[str, list[int]] = {"Outputs": [], "Derivatives": [], "InitialUnknowns": []}
    for index, one in enumerate(shown, 1):
        asked: dict[str, Any] = {
            "Outputs": one.kind.causality == "output", "Derivatives": one.derivative,
            "InitialUnknowns": one.kind.initial == "calculated" and one.kind is not Kind.INDICATOR,
        }  # fmt: skip
        for part, wanted in asked.items():
            indices[part] += [index] if wanted else []
    return filled(
        f"fmi{fmi}.xml.j2", variables=shown, version=version("narrows"), number=repr, kinds=Kind,
        name=commented(model.configuration.ship.name), about=commented(" ".join(passport(model, covariance=False))),
        units={unit: unit_powers(unit) for unit in dict.fromkeys(one.unit for one in shown)},
        structure=indices, indicators=[one.reference for one in variables if one.kind is Kind.INDICATOR], **context,
    )  # fmt: skip
