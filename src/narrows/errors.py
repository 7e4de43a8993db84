"""What goes wrong with a user's input, said in one sentence with the place and the remedy."""

import re
from collections.abc import Iterable
from difflib import get_close_matches
from numbers import Integral
from reprlib import Repr

UNPRINTABLE = re.compile(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]")
LONGEST_SENTENCE = 2000
LONGEST = 200
"""Characters of what another library said, or of a value, that a sentence repeats."""


class InputError(ValueError):
    """Bad input: the message is one sentence that names the place and the remedy (ours).

    The command line prints it on stderr and leaves with exit code 2.

    Parameters
    ----------
    sentence : str
        What to say; a line break in it, out of a cell or a name, becomes a blank, what does not print is spelled out,
        and the middle of what is very long is left out.
    """

    def __init__(self, sentence: str) -> None:
        line = UNPRINTABLE.sub(lambda found: ascii(found[0])[1:-1], " ".join(sentence.splitlines()))
        super().__init__(line if len(line) <= LONGEST_SENTENCE else f"{line[:900]} ... {line[-900:]}")


def near_miss(word: str, known: Iterable[str]) -> str:
    """Return ``'; did you mean X?'`` for a near miss, else nothing (ours).

    Parameters
    ----------
    word : str
        What the user wrote.
    known : iterable of str
        What would have been understood.
    """
    known = sorted(known)
    same = [own for own in known if own.lower() == word.lower()]
    near = same or get_close_matches(word, known, n=1, cutoff=0.6)
    return f"; did you mean {near[0]!r}?" if near else ""


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return ``'; did you mean X?'`` for a near miss, else the list of what is known (ours).

    Parameters
    ----------
    word : str
        What the user wrote.
    known : iterable of str
        What would have been understood.
    """
    known = sorted(known)
    return near_miss(word, known) or f"; known: {', '.join(known)}"


def shown(value: object) -> str:
    """Return a value as it is written, cut short where it is long (ours).

    Parameters
    ----------
    value : object
        As given.
    """
    if isinstance(value, float):  # NumPy's among them, which would say of what kind they are
        return float.__repr__(value)
    try:
        return _SHORT.repr(value)
    except ValueError:  # Python does not write out integers of more than 4300 digits.
        return f"a {type(value).__name__} too long to show"


_SHORT = Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 60


def reason(error: BaseException) -> str:
    """Return what an error of another library says, in one short line (ours).

    Parameters
    ----------
    error : exception
        As it was caught.
    """
    said = (error.strerror if isinstance(error, OSError) else None) or str(error)
    if isinstance(error, MemoryError):
        said = "too large for this computer's memory"
    if isinstance(error, RecursionError):
        said = "nested too deeply"
    return " ".join((said or type(error).__name__).split())[:LONGEST]


def check_choice(name: str, value: object, known: Iterable[str]) -> None:
    """Raise where an argument is none of the words that it may be (ours).

    Parameters
    ----------
    name : str
        Of the argument.
    value : object
        As a caller gave it.
    known : iterable of str
        What it may be.

    Raises
    ------
    InputError
        Names the argument and the words.
    """
    known = tuple(known)
    if not isinstance(value, str) or value not in known:
        near = near_miss(value, known) if isinstance(value, str) and len(value) < LONGEST else ""
        raise InputError(f"{name} = {shown(value)} is unknown" + (near or f"; choose {' or '.join(known)}"))


def check_count(name: str, value: object, least: int = 0, most: float = 2**63 - 1) -> None:
    """Raise where an argument is no whole number that counts (ours).

    Parameters
    ----------
    name : str
        Of the argument.
    value : object
        As a caller gave it.
    least, most : int
        Between which it must be.

    Raises
    ------
    InputError
        Names the argument and its limits.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or not least <= int(value) <= most:
        upto = f" to {most}" if most < 2**63 - 1 else ""
        raise InputError(f"{name} = {shown(value)}: give a whole number from {least}{upto}")
