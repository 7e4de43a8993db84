"""What verbs do alike: folders, names of files, JSON."""

from pathlib import Path

import typer

from narrows.errors import InputError
from narrows.files import is_stream

NOT_IN_NAMES = str.maketrans({character: f"%{ord(character):02X}" for character in "/\\\0%"})
"""What a file's name cannot hold, written as addresses write it."""


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


def output_of(path: Path, label: str) -> Path:
    """Return where a condition's own file goes: its label is added to the name, and all share a device (ours).

    Parameters
    ----------
    path : Path
        As the user named it.
    label : str
        Of the condition.

    Raises
    ------
    InputError
        Where the path names no file.
    """
    if is_stream(path):
        return path
    if not path.name:
        raise InputError(f"{path}: is a folder; name a file")
    return path.with_name(f"{path.stem}-{label.translate(NOT_IN_NAMES)}{path.suffix}")


def print_json(value: object) -> None:
    """Print a value as JSON on standard output (ours).

    Parameters
    ----------
    value : object
        Of numbers and words, what a result's ``to_dict`` gives.
    """
    from narrows.results import to_json

    typer.echo(to_json(value))
