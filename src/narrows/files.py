"""Files: written whole or not at all, read or refused in one sentence."""

import os
import re
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EACCES
from pathlib import Path
from uuid import uuid4

from narrows.errors import InputError, reason, shown

DESCRIPTOR = re.compile(r"/(?:dev|proc/self)/fd/(\d+)")
"""What ``/dev/stdout`` and the like lead to: something that this process has open already."""
MOST_LINKS = 40


def path_of(name: str, value: object) -> Path:
    """Return an argument as a path (ours).

    Parameters
    ----------
    name : str
        Of the argument.
    value : object
        As a caller gave it.

    Raises
    ------
    InputError
        Where it is none.
    """
    if not isinstance(value, str | os.PathLike):
        raise InputError(f"{name} = {shown(value)} is no path; give the name of a file")
    return Path(value)


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write a file so that a reader finds the old one or the new one, never a part (ours).

    A symbolic link stays and the file behind it is replaced, which keeps its mode; a new file has the mode that the
    umask leaves. Devices, FIFOs and open descriptors (``/dev/stdout``) are written to as they are.

    Parameters
    ----------
    path : str or Path
        Where to.
    content : str or bytes
        What; text as UTF-8.

    Raises
    ------
    InputError
        Where the folder is absent or closed, or the disk is full.
    """
    data = content.encode("utf-8") if isinstance(content, str) else content
    try:
        if is_stream(path):
            _pour(path, data)
        else:
            _replace(Path(os.path.realpath(path)), data)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written ({reason(error)}); check its folder and the disk") from None


def is_stream(path: str | Path) -> bool:
    """Say whether what is written to a path flows on, as into a device, a FIFO or ``/dev/stdout`` (ours).

    Parameters
    ----------
    path : str or Path
        Where to; it need not exist.
    """
    try:
        if _descriptor(path) is not None:
            return True
        kind = os.stat(path).st_mode
    except (OSError, ValueError):
        return False
    return not (stat.S_ISREG(kind) or stat.S_ISDIR(kind))


@contextmanager
def reading(path: str | Path, kind: str) -> Iterator[None]:
    """Turn whatever the reader of a format throws into one sentence (ours).

    Parameters
    ----------
    path : str or Path
        The file.
    kind : str
        What it should be, as in ``valid TOML``.

    Raises
    ------
    InputError
        Where the file cannot be read, or is not what it should be.
    """
    try:
        yield
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({reason(error)}); check the path") from None
    except Exception as error:  # Readers of formats raise nearly anything on what is none.
        raise InputError(f"{path}: is not {kind} ({reason(error)}); mend it there") from None


def _descriptor(path: str | Path) -> int | None:
    """The number of the open file that a path leads to."""
    place = os.path.abspath(path)
    for _ in range(MOST_LINKS):
        if found := DESCRIPTOR.fullmatch(place.replace(f"/proc/{os.getpid()}/", "/proc/self/")):
            return int(found[1])
        if not os.path.islink(place):
            return None
        place = os.path.normpath(os.path.join(os.path.dirname(place), os.readlink(place)))
    return None


def _pour(path: str | Path, data: bytes) -> None:
    number = _descriptor(path)
    if number is not None and sys.stdout is not None:
        sys.stdout.flush()  # What was printed before comes before.
    # Opened anew, a descriptor's file would be written from its beginning; a device is never made, only opened.
    handle = os.open(path, os.O_WRONLY) if number is None else os.dup(number)
    with open(handle, "wb") as file:
        file.write(data)


def _replace(path: Path, data: bytes) -> None:
    known = _known(path)
    if known and not os.access(path, os.W_OK):
        raise PermissionError(EACCES, os.strerror(EACCES))
    temporary = path.parent / f".narrows-{uuid4().hex}"
    try:
        with temporary.open("xb") as file:
            file.write(data)
        if known:
            _resemble(temporary, known)
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise


def _known(path: Path) -> os.stat_result | None:
    try:
        return path.stat()
    except FileNotFoundError:
        return None


def _resemble(path: Path, known: os.stat_result) -> None:
    """Give a file the owner, as far as that is allowed, and the mode of the one that it replaces."""
    with suppress(OSError, AttributeError):
        os.chown(path, known.st_uid, known.st_gid)
    path.chmod(stat.S_IMODE(known.st_mode))
