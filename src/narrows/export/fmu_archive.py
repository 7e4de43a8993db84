"""A model as an FMU: its C, an interface, a description, and libraries for the platforms that can be built for."""

import hashlib
import zipfile
from collections.abc import Mapping
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from narrows.codegen.portable import ORDERED
from narrows.export.c_header import c_number, c_text
from narrows.export.exported_ship import ExportedShip
from narrows.export.fmu_description import description_text, variables_of
from narrows.export.native_builds import NativeBuild, libraries_of_source
from narrows.export.rendering import rendered

# Every file in an FMU bears one time, so that written again it is the same.
SAME_TIME = (2000, 1, 1, 0, 0, 0)
# Of either standard: what stands beside the header of the ship.
SOURCES = {
    2: ("instance.h", "fmi2.c", "fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: (
        "instance.h",
        "fmi3.c",
        "fmi3Functions.h",
        "fmi3FunctionTypes.h",
        "fmi3PlatformTypes.h",
        "buildDescription.xml",
    ),
}


def fmu_bytes(exported: ExportedShip, speed: float, dt: float, builds: tuple[NativeBuild, ...], fmi: int = 2) -> bytes:
    """Return an FMU."""
    # speed [m/s]; dt [s]
    header, variables = c_text(exported), variables_of(exported, speed, dt, fmi)
    token = hashlib.sha256(f"{header} {speed!r} {dt!r} {fmi}".encode()).hexdigest()[:32]
    sources = {"ship.h": header, "choices.h": _choices(exported, token, speed, dt)}
    sources |= {name: (files("narrows.export") / "fmi" / name).read_text("utf-8") for name in SOURCES[fmi]}
    parts = {"modelDescription.xml": description_text(exported, variables, token, fmi).encode()}
    parts |= {f"sources/{name}": text.encode() for name, text in sources.items()}
    with TemporaryDirectory(prefix="narrows-fmu-") as folder:
        for name, text in sources.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        parts |= libraries_of_source(Path(folder, f"fmi{fmi}.c"), builds)
    return _packed(parts)


def _choices(exported: ExportedShip, token: str, speed: float, dt: float) -> str:
    controls = exported.controls
    ordered = {ORDERED(actuator.name): actuator.name for actuator in exported.portable.geared}
    names = [ordered.get(name, name) for name in exported.portable.inputs]
    columns = [controls.index(name) if name in controls else -1 for name in names]
    geared = [actuator.name for actuator in exported.portable.geared]
    return rendered(
        "choices.h.j2", exported, token=token, speed=speed, dt=dt, columns=columns, geared=geared, number=c_number
    )


def _packed(parts: Mapping[str, bytes]) -> bytes:
    archive = BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in parts.items():
            packed.writestr(zipfile.ZipInfo(name, SAME_TIME), content, zipfile.ZIP_DEFLATED)
    return archive.getvalue()
