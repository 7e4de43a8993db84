"""What verbs do alike: folders, names of files, JSON."""

from collections.abc import Callable, Iterable
from pathlib import Path

import typer

from narrows.errors import InputError
from narrows.files import form_of, is_stream

NOT_IN_NAMES = str.maketrans({character: f"%{ord(character):02X}" for character in "/\\\0%"})
"""What a file's name cannot hold, written as addresses write it."""

DATASETS = (".nc", ".zarr", ".csv", ".parquet", ".mat", ".json")
TRACKS = (*DATASETS, ".geojson", ".kml")
TABLES = (".csv", ".parquet", ".mat", ".json")
MODELS, PAGES, WATERWAYS = (".toml",), (".html", ".htm"), (".geojson", ".json")
"""Suffixes of what verbs write; the first is what a device without one gets."""


def named(forms: tuple[str, ...]) -> Callable[[Path | None], Path | None]:
    """Return what refuses a file's name before anything is computed for it (ours).

    Parameters
    ----------
    forms : tuple of str
        The suffixes that can be.
    """

    def checked(path: Path | None) -> Path | None:
        if path is not None:
            form_of(path, forms)
        return path

    return checked


def say_written(paths: Iterable[Path | None], json: bool = False) -> None:
    """Print what was written where; nothing beside JSON, nor of what flows on (ours).

    Parameters
    ----------
    paths : iterable of Path or None
        None where it was not asked for.
    json : bool
        Whether JSON is printed.
    """
    files = [path for path in paths if path is not None]
    if not json and not any(map(is_stream, files)):
        for path in files:
            typer.echo(f"wrote {path}")


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
