"""What verbs do alike: folders, names of files, JSON."""

from collections.abc import Callable, Iterable
from pathlib import Path

import click

from narrows.errors import InputError
from narrows.files import form_of, is_stream

# What a file's name cannot hold, written as addresses write it.
NOT_IN_NAMES = str.maketrans({character: f"%{ord(character):02X}" for character in "/\\\0%"})
DATASETS = (".nc", ".zarr", ".csv", ".parquet", ".mat", ".json")
TRACKS = (*DATASETS, ".geojson", ".kml")
TABLES = (".csv", ".parquet", ".mat", ".json")
# Suffixes of what verbs write; the first is what a device without one gets.
MODELS, PAGES, WATERWAYS = (".toml",), (".html", ".htm"), (".geojson", ".json")


def named(forms: tuple[str, ...]) -> Callable[[Path | None], Path | None]:
    """Return what refuses a file's name before anything is computed for it."""

    def checked(path: Path | None) -> Path | None:
        if path is not None:
            form_of(path, forms)
        return path

    return checked


def say_written(paths: Iterable[Path | None], json: bool = False) -> None:
    """Print what was written where; nothing beside JSON, nor of what flows on."""
    files = [path for path in paths if path is not None]
    if not json and not any(map(is_stream, files)):
        for path in files:
            click.echo(f"wrote {path}")


def folder(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot be made a folder ({error.strerror}); choose another") from None


def output_of(path: Path, label: str) -> Path:
    """Return where a condition's own file goes: its label is added to the name, and all share a device."""
    if is_stream(path):
        return path
    if not path.name:
        raise InputError(f"{path}: is a folder; name a file")
    return path.with_name(f"{path.stem}-{label.translate(NOT_IN_NAMES)}{path.suffix}")


def print_json(value: object) -> None:
    from narrows.results import to_json

    click.echo(to_json(value))
