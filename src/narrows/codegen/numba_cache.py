"""Numba's files of compiled code, checked: what is damaged is compiled again, what cannot be written is done without.

Numba trusts its files. A part of one ends in a traceback, and machine code with a few bytes wrong in worse.
"""

import hashlib
import pickle
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any

from numba.core.caching import IndexDataCacheFile

SIZE = hashlib.sha256().digest_size


class CheckedFile(IndexDataCacheFile):  # type: ignore[misc]
    """Numba's index and data files, each behind the hash of what it holds."""

    def _load_index(self) -> dict[Any, str]:
        try:
            version, stamp, overloads = self._read(self._index_path)
        except OSError:
            return {}
        return overloads if (version, stamp) == (self._version, self._source_stamp) else {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._write(self._index_path, (self._version, self._source_stamp, overloads))

    def _load_data(self, name: str) -> Any:
        return self._read(self._data_path(name))

    def _save_data(self, name: str, data: Any) -> None:
        self._write(self._data_path(name), data)

    def _read(self, path: str) -> Any:
        content = Path(path).read_bytes()
        if hashlib.sha256(content[SIZE:]).digest() != content[:SIZE]:
            raise OSError(f"{path} is damaged")  # which Numba takes for absent
        return pickle.loads(content[SIZE:])

    def _write(self, path: str, value: Any) -> None:
        data = self._dump(value)
        with self._open_for_write(path) as file:
            file.write(hashlib.sha256(data).digest() + data)


class CheckedCache:
    """The cache of one compiled function, with which the function compiles whatever the disk does."""

    def __init__(self, cache: Any) -> None:
        old = cache._cache_file
        cache._cache_file = CheckedFile(old._cache_path, "", old._source_stamp)
        vars(cache._cache_file).update(vars(old))
        self._cache = cache

    def __getattr__(self, name: str) -> Any:
        return getattr(self._cache, name)

    def save_overload(self, signature: Any, data: Any) -> None:
        """Keep what was compiled, where the disk takes it."""
        with suppress(OSError):
            self._cache.save_overload(signature, data)


def checked(module: ModuleType) -> None:
    """Check the compiled files of every function of a module that Numba keeps."""
    for value in vars(module).values():
        cache = getattr(value, "_cache", None)
        if hasattr(cache, "_cache_file"):
            value._cache = CheckedCache(cache)
