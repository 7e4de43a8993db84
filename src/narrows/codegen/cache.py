"""Generated modules on disk: written whole, named by what they were made from, shared by processes."""

import hashlib
import importlib.util
import os
import platform
import sys
import tempfile
from collections.abc import Callable, Iterable
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from threading import Lock
from types import ModuleType

from narrows.errors import InputError

FOLDER_VARIABLE = "NARROWS_CACHE_DIR"
LAST_LINE = "# end of a module made by narrows\n"
SAME_TIME = 946_684_800
"""Every generated file bears one time [s], the year 2000. Numba asks the time of a file whether its compiled form is
stale; the name of a file says all of its text, so two processes that write it at once must not seem to change it."""


@lru_cache(maxsize=1)
def versions() -> str:
    """Everything but a model that decides what its compiled form is; Numba itself minds the processor (ours)."""
    packages = [f"{name} {version(name)}" for name in ("narrows", "numpy", "numba", "sympy")]
    sources = sorted(Path(__file__).parent.rglob("*.py"))
    ours = hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()
    return "\n".join([*packages, sys.version, platform.machine(), ours])


def key_of(parts: Iterable[object]) -> str:
    """Name what is made from these parts by this version of everything (ours).

    Parameters
    ----------
    parts : iterable
        Their texts matter.
    """
    text = "\n".join([versions(), *map(str, parts)])
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def cache_folder() -> Path:
    """Return where generated modules are: the user's cache folder, or a temporary one where that is closed.

    ``NARROWS_CACHE_DIR`` names another.
    """
    import platformdirs

    return _usable(Path(os.environ.get(FOLDER_VARIABLE) or platformdirs.user_cache_dir("narrows")) / "compiled")


@lru_cache(maxsize=8)
def _usable(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        return _temporary_folder()


@lru_cache(maxsize=1)
def _temporary_folder() -> Path:
    folder = tempfile.TemporaryDirectory(prefix="narrows-")
    _KEPT.append(folder)
    return Path(folder.name)


_KEPT: list[tempfile.TemporaryDirectory[str]] = []  # removed when the process ends


def source(name: str, parts: Iterable[object], make: Callable[[], str]) -> str:
    """Return a generated text, made now if no process has made it before.

    Parameters
    ----------
    name : str
        A word for people.
    parts : iterable
        What it is made from.
    make : callable
        Writes it.
    """
    path = cache_folder() / f"{name}_{key_of(parts)}.py"
    with _LOCK:
        return _whole_text(path) or _whole_text(_written(path, make())) or str(_unloadable(path))


def _whole_text(path: Path) -> str | None:
    """The text of a file, or None where the file is absent or was cut short."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None
    return text if text.endswith(LAST_LINE) else None


def generated(name: str, parts: Iterable[object], make: Callable[[], str]) -> ModuleType:
    """Import a generated module, made now if no process has made it before.

    Parameters
    ----------
    name : str
        A word for people.
    parts : iterable
        What it is made from.
    make : callable
        Writes its text.
    """
    path = cache_folder() / f"{name}_{key_of(parts)}.py"
    with _LOCK:
        return _loaded(path) or _loaded(_written(path, make())) or _unloadable(path)


_LOCK = Lock()
_MODULES: dict[Path, ModuleType] = {}


def _loaded(path: Path) -> ModuleType | None:
    """The module of a file, or None where the file is absent or was cut short."""
    if path not in _MODULES:
        try:
            if not path.read_text(encoding="utf-8").endswith(LAST_LINE):
                return None
        except (OSError, UnicodeDecodeError):
            return None
        _MODULES[path] = _imported(path)
    return _MODULES[path]


def _imported(path: Path) -> ModuleType:
    name = f"narrows_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None  # noqa: PT018
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _written(path: Path, text: str) -> Path:
    """Write a file beside its place, give it its time, then put it there: no reader sees less than the whole."""
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}.")
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(f"{text.rstrip()}\n\n\n{LAST_LINE}")
    os.utime(temporary, (SAME_TIME, SAME_TIME))
    os.replace(temporary, path)
    return path


def _unloadable(path: Path) -> ModuleType:
    raise InputError(f"{path}: was written but does not read back; check the disk, or set {FOLDER_VARIABLE}")
