"""Errors of user input: one sentence with the place and the remedy."""

import os
import platform
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from importlib.metadata import PackageNotFoundError, requires, version
from numbers import Integral
from pathlib import Path
from reprlib import Repr

# Longest quotation of another library's message, or of a value [characters].
LONGEST = 200


class InputError(ValueError):
    """Bad input: the message is one sentence that names the place and the remedy.

    The command line prints it on stderr and exits with code 2.

    Parameters
    ----------
    sentence : str
        The message; a line break from a cell or a name becomes a blank, unprintable characters are escaped, and the
        middle of a very long one is left out.

    Examples
    --------
    >>> issubclass(nw.InputError, ValueError)
    True
    """

    def __init__(self, sentence: str) -> None:
        unprintable, words = r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]", " ".join(sentence.splitlines())
        line = re.sub(unprintable, lambda match: ascii(match[0])[1:-1], words)
        super().__init__(line if len(line) <= 2000 else f"{line[:900]} ... {line[-900:]}")


def near_miss(word: str, known: Iterable[str], cutoff: float = 0.6) -> str:
    """Return ``'; did you mean X?'`` for a near miss, else nothing."""
    word, known = str(word), sorted(known)
    same = [candidate for candidate in known if candidate.lower() == word.lower()]
    longer = [candidate for candidate in known if len(word) > 2 and word.lower() in candidate.lower()]
    near = same or longer[: len(longer) == 1] or get_close_matches(word, known, n=1, cutoff=cutoff)
    return f"; did you mean {near[0]!r}?" if near else ""


def did_you_mean(word: str, known: Iterable[str], cutoff: float = 0.6) -> str:
    """Return ``'; did you mean X?'`` for a near miss, else the list of what is known."""
    known = sorted(known)
    return near_miss(word, known, cutoff) or f"; known: {', '.join(known)}"


def shown(value: object) -> str:
    """Return a value as written, shortened if it is long."""
    if isinstance(value, float):  # Includes NumPy's numbers, whose repr would add the type
        return float.__repr__(value)
    try:
        if isinstance(value, int):
            str(value)  # Python does not print integers of more than 4300 digits; since 3.14 reprlib hides that
        return _SHORT.repr(value)
    except ValueError:
        return f"a {type(value).__name__} too long to show"


_SHORT = Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 60


def reason(error: BaseException) -> str:
    """Return another library's error message in one short line."""
    text = (error.strerror if isinstance(error, OSError) else None) or str(error)
    if isinstance(error, MemoryError):
        text = "too large for this computer's memory"
    if isinstance(error, RecursionError):
        text = "nested too deeply"
    return " ".join((text or type(error).__name__).split())[:LONGEST]


@contextmanager
def needs(extra: str, what: str) -> Iterator[None]:
    """Turn a missing library into one sentence with the command that installs it."""
    try:
        yield
    except ImportError as error:
        asked = libraries_of(extra) or [error.name or extra]
        names = " and ".join(re.split(r"[^\w.-]", library)[0] for library in asked)
        raise InputError(f"{what} needs {names}: {installing(asked)}") from None


def libraries_of(extra: str) -> list[str]:
    return [line.split(";")[0].strip() for line in _required() if re.search(f";.*extra == ['\"]{extra}['\"]", line)]


def _required() -> list[str]:
    try:
        return requires("narrows") or []
    except PackageNotFoundError:  # It runs from a folder
        return []


def show_versions() -> None:
    """Print the versions of narrows, Python, the system and the libraries, extras among them."""
    found = {"narrows": version_of("narrows"), "python": platform.python_version(), "system": platform.platform()}
    found |= {name: version_of(name) for name in sorted({re.split(r"[^\w.-]", line)[0] for line in _required()})}
    width = max(map(len, found))
    print("\n".join(f"{name:{width}}  {number}" for name, number in found.items()))


def version_of(library: str) -> str:
    try:
        return version(library)
    except PackageNotFoundError:
        return "not installed"


def installing(libraries: Iterable[str]) -> str:
    """Return the command that installs libraries for the running Python, for a package or a checkout."""
    python = min(sys.executable, os.path.relpath(sys.executable), key=len)
    return f"{python} -m pip install {' '.join(map(repr, libraries))}"


def check_choice(name: str, value: object, known: Iterable[str]) -> None:
    known = tuple(known)
    if not isinstance(value, str) or value not in known:
        near = near_miss(value, known) if isinstance(value, str) and len(value) < LONGEST else ""
        raise InputError(f"{name} = {shown(value)} is unknown" + (near or f"; choose {' or '.join(known)}"))


def check_count(name: str, value: object, least: int = 0, most: float = 2**63 - 1) -> None:
    if isinstance(value, bool) or not isinstance(value, Integral) or not least <= int(value) <= most:
        upto = f" to {most}" if most < 2**63 - 1 else ""
        raise InputError(f"{name} = {shown(value)}: give a whole number from {least}{upto}")


def path_of(name: str, value: object) -> Path:
    if not isinstance(value, str | os.PathLike):
        raise InputError(f"{name} = {shown(value)} is no path; give the name of a file")
    return Path(value)
