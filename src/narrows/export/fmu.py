"""An FMU: its variables, its description, its sources and compiled libraries in one archive.

A value reference is a place in the one array of ``fmi/instance.h``.
"""

import hashlib
import math
import platform
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from importlib.metadata import version
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import wrap
from types import MappingProxyType
from typing import Any

from narrows.base.errors import InputError, needs
from narrows.codegen.free_motion import COUNTED, OPEN
from narrows.codegen.linearisation import LINEARISED
from narrows.codegen.printers.c import C
from narrows.export.exported_ship import HEADING, USUAL_PREFIX, ExportedNumber, ExportedShip, prefix_of
from narrows.export.passport import ASKED_OF_BANK, RANGE_BITS, bits_in_words, passport
from narrows.export.ship_files import c_text, commented, filled, force_text, places_in, rendered
from narrows.model.bank_force import CONTACT
from narrows.model.model import Model
from narrows.quantities.names import FORCES, MOTION, dimension_of
from narrows.ship.checks import POSITIVE, SMALLEST
from narrows.simulation.initial_state import voyage_defaults
from narrows.simulation.inputs import finite_numbers

FLAGS = ("-std=c99", "-O2", "-shared", "-fPIC", "-ffp-contract=off", "-fno-math-errno")

# Zig's name of each platform (an old C library, so that it loads anywhere), its folder in an FMU of either standard
# (FMI 2.0 has one for macOS), its suffix.
ZIG = (
    ("x86_64-linux-gnu.2.17", {2: "linux64", 3: "x86_64-linux"}, ".so"),
    ("aarch64-linux-gnu.2.17", {2: "aarch64-linux", 3: "aarch64-linux"}, ".so"),
    ("x86_64-windows-gnu", {2: "win64", 3: "x86_64-windows"}, ".dll"),
    ("x86_64-macos.11.0", {3: "x86_64-darwin"}, ".dylib"),
    ("aarch64-macos.11.0", {2: "darwin64", 3: "aarch64-darwin"}, ".dylib"),
)

ZIG_CC = (sys.executable, "-m", "ziglang", "cc")
LOCAL = {("Linux", "x86_64"): ZIG[0][1], ("Linux", "aarch64"): ZIG[1][1]}


def lacks_zig(what: str) -> str:
    """Return the remedy if the compiler of all platforms is missing, else nothing."""
    try:
        with needs("fmu", what):
            import ziglang  # noqa: F401
    except InputError as error:
        return str(error)
    return ""


def compiled(command: Sequence[str], target: Path, what: str) -> bytes:
    """Run a compiler; return its output file, or raise its first error."""
    try:
        done = subprocess.run([*command, "-o", str(target)], capture_output=True, text=True)
    except OSError as error:
        raise InputError(f"{command[0]} cannot be run ({error.strerror}); mend the compiler") from None
    if done.returncode or not target.exists():
        line = next((text for text in done.stderr.splitlines() if "error" in text), "it gives no message")
        raise InputError(f"the compiler for {what} fails ({line.strip()[:200]}); nothing was written")
    return target.read_bytes()


def builds_here(fmi: int = 2) -> list[tuple[str, Sequence[str], str]]:
    """Return each available platform's folder, compiler and suffix: all with ziglang, else this machine's own."""
    if not lacks_zig(""):
        return [(place[fmi], (*ZIG_CC, "-s", "-target", name), suffix) for name, place, suffix in ZIG if fmi in place]
    compiler, folders = shutil.which("gcc") or shutil.which("cc"), LOCAL.get((platform.system(), platform.machine()))
    return [(folders[fmi], (compiler, "-s"), ".so")] if compiler and folders else []


class Kind(Enum):
    """Kind of a variable: its letter in ``KINDS`` of C; causality, variability and initial of the standard."""

    def __init__(self, letter: str, causality: str, variability: str, initial: str) -> None:
        self.letter, self.causality, self.variability = letter, causality, variability
        self.initial = initial  # Empty where the standard forbids it

    TIME_ITSELF = "t", "independent", "continuous", ""
    STATE = "s", "output", "continuous", "exact"
    RATE = "d", "local", "continuous", "calculated"
    CALCULATED = "c", "output", "continuous", "calculated"
    TRUTH = "b", "output", "discrete", "calculated"
    WHOLE = "i", "output", "discrete", "calculated"
    MOMENT = "o", "output", "discrete", "calculated"
    FIXED = "f", "parameter", "fixed", "exact"
    INPUT = "u", "input", "continuous", ""
    TUNABLE = "p", "parameter", "tunable", "exact"
    INDICATOR = "n", "local", "continuous", "calculated"


REALS, INTEGERS = "tsdcofupn", "i"
SIDES = ("starboard", "port")
PER_SECOND = {"m": "m/s", "rad": "rad/s", "m/s": "m/s2", "rad/s": "rad/s2"}
# Outcomes of a voyage, in the order of the codes in C, with the reason in words.
OUTCOMES = {
    "afloat": "the voyage goes on",
    "grounded": "the hull has touched a bank and lies still",
    "diverged": "the numbers are no longer valid",
    "outside": "the ship lies across the canal and lies still",
    "astern": "the ship left the waterway at its beginning and lies still",
    "passed": "the ship has passed the end of the waterway and lies still",
}
# Longest step of co-simulation, as a multiple of the ship's default step: ten steps a ship length.
LONGEST_STEP = 20.0
WIDEST = (-math.inf, math.inf)
# Particulars with an upper bound of their own.
HIGHEST = MappingProxyType({"block_coefficient": 1.0, "rudder_limit": math.pi / 2})


@dataclass(frozen=True)
class FmuVariable:
    name: str  # Name in the FMU
    kind: Kind
    unit: str  # SI unit
    meaning: str  # Meaning in words
    start: float | None = None  # Start value, if it may be set
    derivative: int = 0  # Value reference of the variable that it differentiates; 0 for none
    bounds: tuple[float, float] = WIDEST  # Limits for an importer
    reference: int = 0  # Value reference


def indicators(exported: ExportedShip) -> tuple[tuple[str, str, str], ...]:
    """Return name, outcome and meaning of each event indicator: below 0 the voyage has ended."""
    banks = [(f"contact_{side}", "grounded", f"the clearance to {side}") for side in SIDES]
    along = [
        ("end_ahead", "passed", "the distance to the end ahead"),
        ("end_astern", "astern", "the distance to the end astern"),
    ]
    across = [("heading_across", "outside", "cosine of the heading over its least")]
    has_banks = exported.ship.shape != OPEN
    return tuple((banks + across) * has_banks + along * (exported.waterway is not None))


def _variables(exported: ExportedShip, speed: float, dt: float) -> Iterator[FmuVariable]:
    yield FmuVariable("time", Kind.TIME_ITSELF, "s", "time")
    known = {one.name: (one.name, one.unit, one.meaning) for one in exported.state}
    known["psi"] = "psi", "rad", HEADING
    states = [known[name] for name in (*LINEARISED, *exported.choices.gear)]
    for name, unit, meaning in states:
        yield FmuVariable(name, Kind.STATE, unit, meaning, speed if name == "u" else 0.0)
    for number, (name, unit, _) in enumerate(states):
        yield FmuVariable(f"der({name})", Kind.RATE, PER_SECOND.get(unit, "1/s"), f"rate of {name}", None, number + 1)
    if exported.ship.shape != OPEN:
        for side in SIDES:
            yield FmuVariable(f"clearance_{side}", Kind.CALCULATED, "m", f"clearance to {side} of the hull")
    yield FmuVariable(
        "aground", Kind.TRUTH, "1", "whether the hull has touched a bank; from then on the ship lies still"
    )
    outcomes = "; ".join(f"{code} {name}, {words}" for code, (name, words) in enumerate(OUTCOMES.items()))
    yield FmuVariable("outcome", Kind.WHOLE, "1", f"outcome of the voyage: {outcomes}")
    yield FmuVariable("side", Kind.WHOLE, "1", "side of the bank that was touched: 1 starboard, -1 port, 0 none")
    yield FmuVariable("outcome_time", Kind.MOMENT, "s", "time of the end of the voyage; 0 until then")
    beyond = f"{bits_in_words(exported.ship.model)}, {RANGE_BITS['bottom'][0]} bottom"
    yield FmuVariable("beyond", Kind.WHOLE, "1", f"quantities outside the tested range, a sum of: {beyond}")
    yield FmuVariable("step", Kind.FIXED, "s", "longest step of co-simulation", dt, 0, (SMALLEST, LONGEST_STEP * dt))
    for one in exported.inputs:
        yield FmuVariable(one.name, Kind.INPUT, one.unit, one.meaning, one.value)
    for one in exported.parameters:
        name, bounds = f"parameters.{one.name}", _bounds(exported, one)
        yield FmuVariable(name, Kind.TUNABLE, one.unit, one.meaning, one.value, 0, bounds)
    for name, _, meaning in indicators(exported):
        yield FmuVariable(name, Kind.INDICATOR, "1" if "heading" in name else "m", f"event indicator: {meaning}")


def _bounds(exported: ExportedShip, one: ExportedNumber) -> tuple[float, float]:
    terms = exported.ship.model.terms
    positive = one.name in POSITIVE or (one.name.endswith(("_limit", "_rate")) and not one.name.endswith("wake_rate"))
    low, high = terms[one.name].bound if one.name in terms.names else (SMALLEST if positive else -math.inf, math.inf)
    return min(low, one.value), max(min(high, HIGHEST.get(one.name, math.inf)), one.value)


def unit_powers(unit: str) -> Mapping[str, int]:
    """Return a unit as powers of base units, ``kg m/s2`` as kg 1, m 1, s -2."""
    dimension = dimension_of(unit)
    powers = {"kg": dimension.mass, "m": dimension.length, "s": dimension.time, "rad": int(unit.startswith("rad"))}
    return {base: power for base, power in powers.items() if power}


SAME_TIME = (2000, 1, 1, 0, 0, 0)  # All files in an FMU have one time, so that writing it again gives the same file
# Sources of either standard that do not depend on the model.
SOURCES = {
    2: ("calls.h", "fmi2.c", "fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("calls.h", "fmi3.c", "fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
LETTERS_A_LINE = 100  # Letters on a line of C
OUTPUT_STEPS = 10  # Steps between the outputs of a default experiment


def fmu_file(
    model: Model, path: str | Path, suffix: str, fmi: int = 2, u: float | None = None, dt: float | None = None,
    **choices: Any,
) -> tuple[bytes, tuple[str, ...]]:  # fmt: skip
    """Compile the C of a ship for every platform that there is a compiler for."""
    usual = voyage_defaults(model, u)
    speed, step = float(usual.speed if u is None else u), float(usual.dt if dt is None else dt)
    finite_numbers(u=speed, dt=step)
    if not step > 0:
        raise InputError(f"dt = {step:g} s is no step; give a time over 0")
    exported = ExportedShip.of(model, path, **choices)
    identifier, exported = exported.prefix, replace(exported, prefix=USUAL_PREFIX)
    defaults = voyage_defaults(model, speed)
    output = OUTPUT_STEPS * defaults.dt
    filling = partial(
        rendered, "choices.h.j2", exported, C(), speed=speed, dt=step, banks=exported.ship.shape != OPEN,
        events=[f"SHIP_{outcome.upper()}" for _, outcome, _ in indicators(exported)], counted=COUNTED in exported.kept,
        **_rates(exported),
    )  # fmt: skip
    return fmu_of(
        model, _variables(exported, speed, step), {"ship.h": c_text(exported), "instance.h": source_of("instance.h")},
        filling, exported.about(), fmi, identifier=identifier, output=output,
        # No step of a default experiment passes its end.
        stop=round(round(defaults.duration / output) * output, 6),
    )  # fmt: skip


def source_of(name: str) -> str:
    return (files("narrows.export") / "fmi" / name).read_text("utf-8")


def fmu_of(
    model: Model, variables: Iterable[FmuVariable], sources: dict[str, str], filling: Callable[..., str],
    about: Iterable[str], fmi: int, identifier: str, **experiment: Any,
) -> tuple[bytes, tuple[str, ...]]:  # fmt: skip
    """Return an FMU and the platforms of its libraries; ``filling`` writes what of its sources depends on the model."""
    if fmi not in (2, 3):
        raise InputError(f"fmi = {fmi!r} is no version of the standard; give 2 or 3")
    variables = tuple(replace(one, reference=place) for place, one in enumerate(variables))
    bounded = [one.bounds for one in variables if one.kind in (Kind.FIXED, Kind.INPUT, Kind.TUNABLE)]
    letters = wrap("".join(one.kind.letter for one in variables), LETTERS_A_LINE)
    token = hashlib.sha256(f"{sources} {variables} {identifier} {fmi}".encode()).hexdigest()[:32]
    sources["choices.h"] = filling(
        token=token, kinds={kind.name: kind.letter for kind in Kind}, reals=REALS, integers=INTEGERS,
        letters=[f'"{line}"' for line in letters],
        low=[C().literal(low) for low, _ in bounded], high=[C().literal(high) for _, high in bounded],
    )  # fmt: skip
    sources |= {name: source_of(name) for name in SOURCES[fmi]}
    description = description_text(model, variables, fmi, identifier=identifier, token=token, **experiment)
    parts = {"modelDescription.xml": description.encode()}
    parts |= {f"sources/{name}": text.encode() for name, text in sources.items()}
    if fmi > 2:
        parts["sources/buildDescription.xml"] = filled("build.xml.j2", identifier=identifier).encode()
    parts["documentation/passport.txt"] = "".join(f"{line}\n" for line in about).encode()
    with TemporaryDirectory(prefix="narrows-fmu-") as folder:
        for name, text in sources.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        for place, compiler, suffix in builds_here(fmi):
            command = *compiler, *FLAGS, f"{folder}/fmi{fmi}.c", *(() if suffix == ".dll" else ("-lm",))
            library = compiled(command, Path(folder, f"{place}{suffix}"), place)
            parts[f"binaries/{place}/{identifier}{suffix}"] = library
    archive = BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in parts.items():
            packed.writestr(zipfile.ZipInfo(name, SAME_TIME), content, zipfile.ZIP_DEFLATED)
    return archive.getvalue(), tuple(place.split("/")[1] for place in parts if place.startswith("binaries/"))


def _rates(exported: ExportedShip) -> dict[str, str]:
    """Return the bodies of ``evaluate``: rates of motion and gear."""
    language, bodies, place = C(exported.prefix), {}, 0
    for name, program in zip(("motion", "gear"), exported.continuous, strict=True):
        targets = [f"result[{place + number}]" for number in range(len(program.results))]
        bodies[name] = "\n    ".join(language.body(program, targets, places_in(exported, language)))
        place += len(targets)
    return bodies


def description_text(model: Model, variables: tuple[FmuVariable, ...], fmi: int, **context: Any) -> str:
    # FMI 2.0 has its event indicators and its time without a variable.
    shown = tuple(one for one in variables if fmi > 2 or one.kind not in (Kind.INDICATOR, Kind.TIME_ITSELF))
    numbered = [*enumerate(shown, 1)]
    initial = (i for i, one in numbered if one.kind.initial == "calculated" and one.kind is not Kind.INDICATOR)
    structure = {
        "Outputs": [i for i, one in numbered if one.kind.causality == "output"],
        "Derivatives": [i for i, one in numbered if one.derivative], "InitialUnknowns": [*initial],
    }  # fmt: skip
    return filled(
        f"fmi{fmi}.xml.j2", variables=shown, version=version("narrows"), number=repr, kinds=Kind,
        name=commented(model.configuration.ship.name), about=commented(" ".join(passport(model, covariance=False))),
        units={unit: unit_powers(unit) for unit in dict.fromkeys(one.unit for one in shown)},
        structure=structure, indicators=[one.reference for one in variables if one.kind is Kind.INDICATOR], **context,
    )  # fmt: skip


# The bank's force as an FMU without states, or as one function in a language.
def force_file(model: Model, path: str | Path, suffix: str, fmi: int = 2) -> tuple[str | bytes, tuple[str, ...] | None]:
    """Return a function, or an FMU without states, whose outputs are the force at its inputs."""
    prefix = prefix_of(path)
    if suffix != ".fmu":
        return force_text(model, suffix, prefix), None
    variables = tuple(_bank_variables(model))
    start = [C().literal(one.start or 0.0) for one in variables if one.kind is Kind.INPUT]
    filling = partial(filled, "bank_choices.h.j2", deviations=2 * (model.covariance is not None), start=start)
    sources = {"bank.h": force_text(model, ".h", "bank"), "instance.h": source_of("bank_instance.h")}
    about = passport(model)
    return fmu_of(model, variables, sources, filling, about, fmi, identifier=prefix, stop=1.0, output=0.1)


def _bank_variables(model: Model) -> Iterator[FmuVariable]:
    """Variables in the order of ``bank_instance.h``."""
    ship, canal = model.configuration.ship, model.configuration.canal
    foot = "from the line to the foot of the {} bank"
    sloped = "how far the {} bank recedes for each metre that it rises"
    yield FmuVariable("time", Kind.TIME_ITSELF, "s", "time")
    yield FmuVariable("y", Kind.INPUT, "m", MOTION["y"].meaning, 0.0)
    yield FmuVariable("psi", Kind.INPUT, "rad", HEADING, 0.0)
    yield FmuVariable("u", Kind.INPUT, "m/s", MOTION["u"].meaning, float(voyage_defaults(model).speed))
    for side in SIDES:
        yield FmuVariable(side, Kind.INPUT, "m", foot.format(side), canal.width / 2)
    for side in SIDES:
        yield FmuVariable(f"slope_{side}", Kind.INPUT, "1", sloped.format(side), 0.0, 0, (0.0, math.inf))
    # A model whose canal has no depth needs none; the file needs one over the draft.
    yield FmuVariable("depth", Kind.INPUT, "m", "water depth", canal.depth or 2.0 * ship.draft, 0, (SMALLEST, math.inf))
    for of in ("", "standard deviation of the ")[: 1 if model.covariance is None else 2]:
        for force in "YN":
            name, (unit, meaning) = f"{force}{'_deviation' * bool(of)}", FORCES[force]
            yield FmuVariable(name, Kind.CALCULATED, unit, f"{of}{meaning}")
    bits = f"quantities outside the tested range, a sum of: {bits_in_words(model, ASKED_OF_BANK)}"
    yield FmuVariable("beyond", Kind.WHOLE, "1", f"{bits}; {CONTACT} if the hull touches a bank or the bottom")
