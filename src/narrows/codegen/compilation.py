"""Numba compilation: a progress bar, and checked files of compiled code."""

import gc
import hashlib
import logging
import pickle
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from types import ModuleType
from typing import Any

from numba.core import event
from numba.core.caching import IndexDataCacheFile

from narrows.progress import bar, is_shown

# Number of functions to compile in each generated file, by file name.
FUNCTIONS: dict[str, int] = {}


class CompilationBar(event.Listener):  # type: ignore[misc]
    """Progress bar of the functions that Numba compiles; Numba's lock admits one thread at a time."""

    def __init__(self) -> None:
        self.depth, self.file, self.collected = 0, "", False
        self.shown = ExitStack()
        self.advance: Callable[[int], None] = lambda done: None

    def on_start(self, event: Any) -> None:
        """Start the bar with the outermost function."""
        if (total := FUNCTIONS.get(_file(event))) is None:
            return
        if self.depth == 0:
            logging.getLogger("narrows").info(
                "compiling loops over vessels, which takes some seconds and is kept for the next time ..."
            )
            self.file, self.collected = _file(event), gc.isenabled()
            gc.disable()  # Looking for garbage among what Numba makes takes a sixth of the time.
            self.advance = self.shown.enter_context(bar(total, is_shown(), "compiling"))
        self.depth += 1

    def on_end(self, event: Any) -> None:
        """Count a function; close the bar with the outermost."""
        if _file(event) in FUNCTIONS:
            self.advance(_file(event) == self.file)  # Shared functions belong to no file's count
            self.depth -= 1
            if self.depth == 0:
                self.shown.close()
                if self.collected:
                    gc.enable()


def _file(event: Any) -> str:
    return str(event.data["dispatcher"].py_func.__code__.co_filename)


def watch(module: ModuleType, text: str) -> None:
    """Report from now on when functions of a generated module are compiled."""
    if not FUNCTIONS:
        event.register("numba:compile", CompilationBar())
    FUNCTIONS[str(module.__file__)] = text.count("\n@cached\n")


# Numba does not check its files: a truncated one ends in a traceback, and corrupt machine code in worse. So a damaged
# file is compiled again, and an unwritable one is ignored.
SIZE = hashlib.sha256().digest_size


class CheckedFile(IndexDataCacheFile):  # type: ignore[misc]
    """One file per signature of a function, named by the signature, which begins with the hash of its content.

    Numba numbers the files in an index: two processes that compile two signatures at once get the same number, and one
    of them runs the other's code.
    """

    def save(self, key: Any, data: Any) -> None:
        kept = self._dump((self._version, self._source_stamp, key, data))
        with self._open_for_write(self._place(key)) as file:
            file.write(hashlib.sha256(kept).digest() + kept)

    def load(self, key: Any) -> Any:
        """Read the code of a signature; None if it is absent, damaged or of another version."""
        with suppress(OSError):
            content = Path(self._place(key)).read_bytes()
            if hashlib.sha256(content[SIZE:]).digest() == content[:SIZE]:
                *known, data = pickle.loads(content[SIZE:])
                return data if known == [self._version, self._source_stamp, key] else None
        return None

    def _place(self, key: Any) -> str:
        return str(self._data_path(self._data_name(int(hashlib.sha256(repr(key).encode()).hexdigest()[:12], 16))))


class CheckedCache:
    """Cache of one compiled function; the function compiles even if the disk fails."""

    def __init__(self, cache: Any) -> None:
        old = cache._cache_file
        cache._cache_file = CheckedFile(old._cache_path, "", old._source_stamp)
        vars(cache._cache_file).update(vars(old))
        self._cache = cache

    def __getattr__(self, name: str) -> Any:
        return getattr(self._cache, name)

    def save_overload(self, signature: Any, data: Any) -> None:
        with suppress(OSError):
            self._cache.save_overload(signature, data)


def checked(module: ModuleType) -> None:
    for value in vars(module).values():
        cache = getattr(value, "_cache", None)
        if hasattr(cache, "_cache_file"):
            value._cache = CheckedCache(cache)
