"""What verbs do alike: folders, lists of numbers, JSON."""

from pathlib import Path

import typer

from narrows.errors import InputError


def folder(path: Path) -> None:
    """Make a folder where there is none (ours).

    Parameters
    ----------
    path : Path
        Where.

    Raises
    ------
    InputError
        Where it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot be made a folder ({error.strerror}); choose another") from None


def numbers(text: str, option: str) -> tuple[float, ...]:
    """Read numbers between commas (ours).

    Parameters
    ----------
    text : str
        As given.
    option : str
        What they were given for.

    Raises
    ------
    InputError
        Where one is no number.
    """
    try:
        return tuple(float(word) for word in text.split(",") if word)
    except ValueError:
        raise InputError(f"{option} {text!r} is not numbers between commas; write 0.6,0.9") from None


def print_json(value: object) -> None:
    """Print a value as JSON on standard output (ours).

    Parameters
    ----------
    value : object
        Of plain numbers and words.
    """
    from json import dumps

    typer.echo(dumps(value, indent=2, allow_nan=False))
