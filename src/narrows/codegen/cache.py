"""Generated modules on disk: written atomically, named by a hash of their inputs, shared by processes."""

import hashlib
import inspect
import logging
import os
import platform
import re
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from threading import RLock
from types import ModuleType

from narrows.base.errors import InputError
from narrows.base.files import write_whole

FOLDER_VARIABLE = "NARROWS_CACHE_DIR"

SEAL = "# sha256 of all above: "
LAST_LINE = "# end of a module made by narrows\n"

# Modification time of every generated file [s]: the year 2000. Numba takes a new time for a new text. But the file name
# is a hash of the text: two processes that write the same file must not seem to change it.
SAME_TIME = 946_684_800

_LOCK = RLock()  # Reentrant: a kernel imports the shared functions
_MODULES: dict[Path, ModuleType] = {}


@lru_cache(maxsize=1)
def versions() -> str:
    """Versions that decide the compiled form, apart from the model; Numba itself checks the processor."""
    packages = [f"{name} {version(name)}" for name in ("narrows", "numpy", "sympy")]
    with suppress(PackageNotFoundError):  # Without Numba nothing is compiled
        packages.append(f"numba {version('numba')}")
    # Sources of the functions that are compiled with a kernel.
    sources = [
        *sorted(Path(__file__).parent.rglob("*.py")),
        Path(__file__).parents[1] / "waterway" / "bank_clearance.py",
    ]
    source_hash = hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()
    return "\n".join([*packages, sys.version, platform.machine(), source_hash])


def key_of(parts: Iterable[object]) -> str:
    text = "\n".join([versions(), *map(str, parts)])
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def user_cache_folder() -> Path:
    home = Path("~").expanduser()
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local") / "narrows" / "narrows" / "Cache"
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / "narrows"
    return Path(os.environ.get("XDG_CACHE_HOME", "").strip() or home / ".cache") / "narrows"


def import_generated(name: str, parts: Iterable[object], make: Callable[[], str]) -> ModuleType:
    """Import a generated module; make it if no process has made it before."""
    # A damaged file is made again. Where the folder cannot be written, the module is kept in memory.
    folder = Path(os.environ.get(FOLDER_VARIABLE) or user_cache_folder())
    path = folder / "compiled" / f"{name}_{key_of(parts)}.py"
    with _LOCK:
        if path not in _MODULES:
            text = _read(path)
            _MODULES[path] = _make_module(path, make()) if text is None else _execute(path, text)
        return _MODULES[path]


def _read(path: Path) -> str | None:
    """Return the text of a file, or None if it is absent or damaged."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None
    return text if text == _sealed(text.partition(SEAL)[0]) else None


def _sealed(text: str) -> str:
    text = f"{text.rstrip()}\n\n\n"
    return f"{text}{SEAL}{hashlib.sha256(text.encode()).hexdigest()}\n{LAST_LINE}"


def _make_module(path: Path, text: str) -> ModuleType:
    text = _sealed(text)
    # Numba raises RuntimeError if it cannot store compiled code next to a file.
    with suppress(OSError, RuntimeError, InputError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)
        os.utime(path, (SAME_TIME, SAME_TIME))
        return _execute(path, text)
    return _execute(path, text.replace("cache=True", "cache=False"))


def _execute(path: Path, text: str) -> ModuleType:
    """Execute a module's text, without Python's bytecode cache, whose content has no checksum."""
    module = ModuleType(f"narrows_{path.stem}")
    code = compile(text, path, "exec")
    module.__file__ = str(path)
    vars(module).update(TEXT=text, CODE=code)
    sys.modules[module.__name__] = module
    try:
        exec(code, vars(module))
    except BaseException:
        del sys.modules[module.__name__]
        raise
    if sys.modules.get("numba"):  # None marks a blocked import
        from narrows.codegen.compilation import check_files

        check_files(module)
    return module


# Header of a compiled copy of a module of Python loops.
HEADER = '''"""Made by narrows from {name}: made again where it is missing, so do not edit."""
import numba

cached = numba.njit(fastmath={{"nsz", "contract"}}, error_model="numpy", nogil=True, cache=True)

'''


def lacks_compiler() -> bool:
    """Return whether Numba is not installed (the extra ``compiled``; a browser has none)."""
    try:
        return find_spec("numba") is None
    except ValueError:  # A placeholder in sys.modules is no module
        return True


@lru_cache
def compiled_loops(module: ModuleType) -> ModuleType:
    """Return a module's functions: compiled at their first call, or plain Python without Numba."""
    if lacks_compiler():
        return module
    text = inspect.getsource(module)
    name = module.__name__.rpartition(".")[2]

    def written() -> str:
        note = "compiling loops over vessels, which takes some seconds and is kept for the next time ..."
        logging.getLogger("narrows").info(note)
        # Without the module's docstring, which would follow the header's imports.
        body = text.split('"""\n', 1)[1]
        return HEADER.format(name=name) + re.sub(r"^def ", "@cached\ndef ", body, flags=re.MULTILINE)

    compiled = import_generated(name, [text, HEADER], written)
    for imported, function in list(vars(compiled).items()):
        # Compiled code can call only compiled functions.
        if inspect.isfunction(function) and function.__module__.startswith("narrows."):
            setattr(compiled, imported, getattr(compiled_loops(sys.modules[function.__module__]), imported))
    return compiled
