"""C libraries for the platforms of an FMU, by ziglang or by this machine's own compiler."""

import platform
import shutil
import struct
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from narrows.errors import InputError, needs


@dataclass(frozen=True)
class NativeBuild:
    folder: str  # Folder of the platform in an FMU
    command: tuple[str, ...]  # Command that compiles and links
    suffix: str  # Suffix of the library

    def compiled(self, source: Path) -> bytes:
        target = source.with_name(f"{self.folder}{self.suffix}")
        libraries = () if self.suffix == ".dll" else ("-lm",)
        return compiled((*self.command, *FLAGS, str(source), *libraries), target, self.folder)


FLAGS = ("-std=c99", "-O2", "-shared", "-fPIC", "-ffp-contract=off", "-fno-math-errno")

# Zig's name of each platform (an old C library, so that it loads anywhere), its folder in an FMU of either standard,
# its suffix.
ZIG = (
    ("x86_64-linux-gnu.2.17", {2: "linux64", 3: "x86_64-linux"}, ".so"),
    ("aarch64-linux-gnu.2.17", {2: "aarch64-linux", 3: "aarch64-linux"}, ".so"),
    ("x86_64-windows-gnu", {2: "win64", 3: "x86_64-windows"}, ".dll"),
    ("x86_64-macos.11.0", {2: "darwin64", 3: "x86_64-darwin"}, ".dylib"),
    ("aarch64-macos.11.0", {2: "darwin64", 3: "aarch64-darwin"}, ".dylib"),
)

ZIG_CC = (sys.executable, "-m", "ziglang", "cc")
PAGE = 1 << 14
FAT, PROCESSOR, ALIGNMENT = 0xCAFEBABE, slice(4, 12), 14
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


def builds_here(fmi: int = 2) -> tuple[NativeBuild, ...]:
    """Return a compiler for each available platform: all with ziglang, else this machine's own."""
    if not lacks_zig(""):
        return tuple(
            NativeBuild(folders[fmi], (*ZIG_CC, "-s", "-target", target), suffix) for target, folders, suffix in ZIG
        )
    compiler, folders = shutil.which("gcc") or shutil.which("cc"), LOCAL.get((platform.system(), platform.machine()))
    return (NativeBuild(folders[fmi], (compiler, "-s"), ".so"),) if compiler and folders else ()


def libraries_of_source(source: Path, name: str, builds: tuple[NativeBuild, ...]) -> Mapping[str, bytes]:
    made: dict[str, list[bytes]] = {}
    for build in builds:
        made.setdefault(f"binaries/{build.folder}/{name}{build.suffix}", []).append(build.compiled(source))
    return {place: own[0] if len(own) == 1 else universal(own) for place, own in made.items()}


def universal(libraries: Sequence[bytes]) -> bytes:
    """Join the libraries for macOS processors: a table of them, then each on pages of its own."""
    entries, body = b"", b""
    for library in libraries:
        processor, kind = struct.unpack("<2I", library[PROCESSOR])
        entries += struct.pack(">5I", processor, kind, PAGE + len(body), len(library), ALIGNMENT)
        body += library + bytes(-len(library) % PAGE)
    head = struct.pack(">2I", FAT, len(libraries)) + entries
    return head + bytes(PAGE - len(head)) + body
