"""The exported C, with what sails fleets of it, as WebAssembly."""

import re
import subprocess
import sys
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory

from narrows.errors import InputError, needs
from narrows.export.c_header import c_text
from narrows.export.exported_ship import ExportedShip

FLAGS = (
    "-std=gnu99", "-O3", "-msimd128", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off", "-mllvm",
    "-inline-threshold=5000", "-nostdlib", "-Wl,--no-entry", "-Wl,--strip-all", "-Wl,-z,stack-size=65536",
)  # fmt: skip
SOURCES = ("fleet.c", "lanes.c", "math.h")
NUMBER = re.compile(r"(?<![\w.])(\d+\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+)(?![\w.])")
FUNCTION = re.compile(r"(?<![\w.])(exp|log|pow|sin|cos|hypot|fmod|floor|trunc|fabs|sqrt|atan2)\(")
LANE, SHIP = "lane", "ship"


def lacks_zig() -> str:
    """Return what to do for a page that sails by WebAssembly where its compiler is not here, else nothing."""
    try:
        with needs("fmu", "WebAssembly"):
            import ziglang  # noqa: F401
    except InputError as error:
        return f"the page sails by plain JavaScript, a few times slower: {error}"
    return ""


def wasm_of(exported: ExportedShip, single: bool = True) -> bytes:
    """Return a module that sails fleets of a ship, 64 side by side."""
    ship = c_text(exported)
    lane = re.sub(rf"\b{SHIP}_", f"{LANE}_", re.sub(rf"\b{SHIP.upper()}_", f"{LANE.upper()}_", ship))
    texts = {"ship.h": ship, "lane.h": in_single_precision(lane) if single else lane}
    texts |= {name: (files("narrows.export.page") / "fleet" / name).read_text("utf-8") for name in SOURCES}
    with TemporaryDirectory(prefix="narrows-page-") as folder:
        for name, text in texts.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        return _compiled(Path(folder), ("-DSTEERED",) * ("rudder" in exported.portable.kept), single)


def in_single_precision(text: str) -> str:
    """Return C with every ``double``, number and function of <math.h> in single precision."""
    text = FUNCTION.sub(r"\1f(", NUMBER.sub(r"\1f", text))
    return re.sub(r"\bdouble\b", "float", text)


def _compiled(folder: Path, more: tuple[str, ...], single: bool) -> bytes:
    target = folder / "fleet.wasm"
    zig = (sys.executable, "-m", "ziglang", "cc", "-target", "wasm32-freestanding")
    real = f"-DLANE_REAL={'float' if single else 'double'}"
    command = [*zig, *FLAGS, *more, real, f"-I{folder}", str(folder / "fleet.c"), "-o", str(target)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode or not target.exists():
        line = next((text for text in done.stderr.splitlines() if "error" in text), "it says nothing")
        raise InputError(f"the compiler for WebAssembly fails ({line.strip()[:200]}); nothing was written")
    return target.read_bytes()
