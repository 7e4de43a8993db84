"""What goes wrong with a user's input, said in one sentence with the place and the remedy."""

from collections.abc import Iterable
from difflib import get_close_matches


class InputError(ValueError):
    """Bad input: the message is one sentence that names the place and the remedy (ours).

    The command line prints it on stderr and leaves with exit code 2.

    Parameters
    ----------
    sentence : str
        What to say; a line break in it, out of a cell or a name, becomes a blank.
    """

    def __init__(self, sentence: str) -> None:
        super().__init__(" ".join(sentence.splitlines()))


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
