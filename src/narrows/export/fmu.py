"""A model as an FMU: its C, an interface, a description, and libraries for the platforms that can be built for."""

import hashlib
import platform
import shutil
import struct
import subprocess
import sys
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from narrows.codegen.linearisation import LINEARISED
from narrows.codegen.portable import ORDERED
from narrows.errors import InputError, needs
from narrows.export.exported_ship import ExportedNumber, ExportedShip
from narrows.export.rendering import c_number, c_text, commented, rendered
from narrows.quantities.dimensions import dimension_of
from narrows.quantities.names import MOTION

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


@dataclass(frozen=True)
class NativeBuild:
    folder: str  # Of the platform in an FMU
    command: tuple[str, ...]  # That compiles and links
    suffix: str  # Of what it makes

    def compiled(self, source: Path) -> bytes:
        target = source.with_name(f"{self.folder}{self.suffix}")
        libraries = () if self.suffix == ".dll" else ("-lm",)
        try:
            done = subprocess.run(
                [*self.command, *FLAGS, str(source), "-o", str(target), *libraries], capture_output=True, text=True
            )
        except OSError as error:
            raise InputError(f"{self.command[0]} cannot be run ({error.strerror}); mend the compiler") from None
        if done.returncode or not target.exists():
            line = next((text for text in done.stderr.splitlines() if "error" in text), "it says nothing")
            raise InputError(f"the compiler for {self.folder} fails ({line.strip()[:200]}); nothing was written")
        return target.read_bytes()


def fmu_bytes(exported: ExportedShip, speed: float, dt: float, builds: tuple[NativeBuild, ...], fmi: int = 2) -> bytes:
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


HEADING = "heading, positive clockwise seen from above"
CLEARANCES = {"clearance_starboard": "starboard", "clearance_port": "port"}
INDICATORS = {"contact_starboard": "starboard", "contact_port": "port"}
PER_SECOND = {"m": "m/s", "rad": "rad/s", "m/s": "m/s2", "rad/s": "rad/s2"}


@dataclass(frozen=True)
class FmuVariable:
    """A variable; its reference is its place in the array of ``fmi/instance.h``."""

    name: str  # In the FMU
    reference: int  # Its place
    causality: str  # As the standard has them; no initial where it forbids one
    variability: str  # As the standard has them; no initial where it forbids one
    initial: str  # As the standard has them; no initial where it forbids one
    unit: str  # In SI, and in words
    meaning: str  # In SI, and in words
    start: float | None = None  # Its value at the start, where that may be set
    derivative: int = 0  # Index of the variable that it is the rate of; 0 of none
    truth: bool = False  # Whether it is true or false


def variables_of(exported: ExportedShip, speed: float, dt: float, fmi: int) -> tuple[FmuVariable, ...]:
    variables = tuple(_variables(exported, speed, dt))
    return variables if fmi < 3 else (*variables, *_indicators(len(variables)))


def _indicators(first: int) -> Iterator[FmuVariable]:
    for place, (name, side) in enumerate(INDICATORS.items(), first):
        meaning = f"event indicator: the room to {side}, below 0 once the hull has touched"
        yield FmuVariable(name, place, "local", "continuous", "calculated", "m", meaning)


def _variables(exported: ExportedShip, speed: float, dt: float) -> Iterator[FmuVariable]:
    yield FmuVariable("time", 0, "independent", "continuous", "", "s", "time")
    units = {name: MOTION[name].unit if name in MOTION else "rad" for name in LINEARISED}
    for place, (name, unit) in enumerate(units.items(), 1):
        meaning = MOTION[name].meaning if name in MOTION else HEADING
        start = speed if name == "u" else 0.0
        yield FmuVariable(name, place, "output", "continuous", "exact", unit, meaning, start)
    for place, (name, unit) in enumerate(units.items(), 7):
        of = ("local", "continuous", "calculated", PER_SECOND[unit], f"rate of {name}")
        # The index of a variable is its place in the list, from 1.
        yield FmuVariable(f"der({name})", place, *of, derivative=place - 5)
    for place, (name, side) in enumerate(CLEARANCES.items(), 13):
        yield FmuVariable(name, place, "output", "continuous", "calculated", "m", f"room to {side} of the hull")
    stuck = "whether the hull has touched a bank; from then on the ship lies still"
    yield FmuVariable("aground", 15, "output", "discrete", "calculated", "1", stuck, truth=True)
    yield FmuVariable("step", 16, "parameter", "fixed", "exact", "s", "longest step of co-simulation", dt)
    positions, first = exported.state[7:], 17 + len(exported.state) - 7
    for place, one in enumerate(positions, 17):
        yield FmuVariable(one.name, place, "output", "continuous", "calculated", one.unit, one.meaning)
    for place, one in enumerate(exported.inputs, first):
        yield _number(one, one.name, place, "input", "continuous", "")
    for place, one in enumerate(exported.parameters, first + len(exported.inputs)):
        yield _number(one, f"parameters.{one.name}", place, "parameter", "tunable", "exact")


def _number(one: ExportedNumber, name: str, place: int, causality: str, variability: str, initial: str) -> FmuVariable:
    return FmuVariable(name, place, causality, variability, initial, one.unit, one.meaning, one.value)


def unit_powers(unit: str) -> dict[str, int]:
    """Return a unit as powers of base units, ``kg m/s2`` as kg 1, m 1, s -2."""
    dimension = dimension_of(unit)
    powers = {"kg": dimension.mass, "m": dimension.length, "s": dimension.time, "rad": int(unit.startswith("rad"))}
    return {base: power for base, power in powers.items() if power}


def description_text(exported: ExportedShip, variables: tuple[FmuVariable, ...], token: str, fmi: int) -> str:
    outputs = [index for index, one in enumerate(variables, 1) if one.causality == "output"]
    rates = [index for index, one in enumerate(variables, 1) if one.derivative]
    first = [
        index for index, one in enumerate(variables, 1) if one.initial == "calculated" and one.name not in INDICATORS
    ]
    return rendered(
        f"fmi{fmi}.xml.j2", exported, variables=variables, token=token, version=version("narrows"), number=repr,
        name=commented(exported.ship.model.configuration.ship.name), about=commented(" ".join(exported.about())),
        units={unit: unit_powers(unit) for unit in dict.fromkeys(one.unit for one in variables)},
        structure={"Outputs": outputs, "Derivatives": rates, "InitialUnknowns": first},
        indicators=[one.reference for one in variables if one.name in INDICATORS],
    )  # fmt: skip


FLAGS = ("-std=c99", "-O2", "-shared", "-fPIC", "-ffp-contract=off", "-fno-math-errno")

# What zig calls each platform (an old C library, so that it loads anywhere), its folder in an FMU of either standard,
# its suffix.
ZIG = (
    ("x86_64-linux-gnu.2.17", {2: "linux64", 3: "x86_64-linux"}, ".so"),
    ("aarch64-linux-gnu.2.17", {2: "aarch64-linux", 3: "aarch64-linux"}, ".so"),
    ("x86_64-windows-gnu", {2: "win64", 3: "x86_64-windows"}, ".dll"),
    ("x86_64-macos.11.0", {2: "darwin64", 3: "x86_64-darwin"}, ".dylib"),
    ("aarch64-macos.11.0", {2: "darwin64", 3: "aarch64-darwin"}, ".dylib"),
)

PAGE = 1 << 14
FAT, PROCESSOR, ALIGNMENT = 0xCAFEBABE, slice(4, 12), 14
LOCAL = {("Linux", "x86_64"): ZIG[0][1], ("Linux", "aarch64"): ZIG[1][1]}


def lacks_zig() -> str:
    """Return what to do for libraries for all platforms where their compiler is not here, else nothing."""
    try:
        with needs("fmu", "an FMU for Linux, Windows and macOS at once"):
            import ziglang  # noqa: F401
    except InputError as error:
        return str(error)
    return ""


def builds_here(fmi: int = 2) -> tuple[NativeBuild, ...]:
    """Return a compiler for each platform that can be built for: all by ziglang, else this machine's own."""
    if not lacks_zig():
        zig = (sys.executable, "-m", "ziglang", "cc", "-s", "-target")
        return tuple(NativeBuild(folders[fmi], (*zig, target), suffix) for target, folders, suffix in ZIG)
    compiler, folders = shutil.which("gcc") or shutil.which("cc"), LOCAL.get((platform.system(), platform.machine()))
    return (NativeBuild(folders[fmi], (compiler, "-s"), ".so"),) if compiler and folders else ()


def libraries_of_source(source: Path, builds: tuple[NativeBuild, ...]) -> Mapping[str, bytes]:
    """Return the library of a source for each platform, by its place in an FMU."""
    made: dict[str, list[bytes]] = {}
    for build in builds:
        made.setdefault(f"binaries/{build.folder}/ship{build.suffix}", []).append(build.compiled(source))
    return {place: own[0] if len(own) == 1 else universal(own) for place, own in made.items()}


def universal(libraries: Sequence[bytes]) -> bytes:
    """Return one library for macOS of those for its processors: a table of them, then each on pages of its own."""
    entries, body = b"", b""
    for library in libraries:
        processor, kind = struct.unpack("<2I", library[PROCESSOR])
        entries += struct.pack(">5I", processor, kind, PAGE + len(body), len(library), ALIGNMENT)
        body += library + bytes(-len(library) % PAGE)
    head = struct.pack(">2I", FAT, len(libraries)) + entries
    return head + bytes(PAGE - len(head)) + body
