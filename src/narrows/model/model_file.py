"""Model files: TOML that gives back the same forces to the last bit."""

import os
from importlib.resources import files
from pathlib import Path
from typing import overload

from narrows.errors import InputError, did_you_mean
from narrows.files import form_of, write_whole
from narrows.model.model import Model
from narrows.ship.ship_file import load_toml
from narrows.terms.term import TermTable


def save_model(model: Model, path: str | Path) -> None:
    """Write a model file.

    Parameters
    ----------
    model : Model
        What to write.
    path : str or Path
        Where to.

    Raises
    ------
    InputError
        Where the file is none of TOML by its suffix, or cannot be written.
    """
    import tomli_w

    form_of(path, (".toml",))
    write_whole(path, tomli_w.dumps(model.to_dict()))


def load_model(path: str | Path, terms: TermTable | None = None) -> Model:
    """Read a model file.

    Parameters
    ----------
    path : str or Path
        The file.
    terms : TermTable, optional
        The user's own table, where the file was made with one.

    Returns
    -------
    Model
        The same as was saved.

    Raises
    ------
    InputError
        Where the file is absent, or a section, a key or a coefficient is missing or misspelt.
    """
    tables = load_toml(path)
    try:
        return Model.from_dict(tables, terms)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


@overload
def published() -> list[str]:
    """List the names of the models that papers published."""


@overload
def published(name: str) -> Model:
    """Load a model that a paper published.

    Parameters
    ----------
    name : str
        As in ``mikkelsen2025_dtc``.
    """


def published(name: str | None = None) -> "Model | list[str]":
    """Load a model that a paper published, as a file of this package, or list their names.

    Parameters
    ----------
    name : str, optional
        As in ``mikkelsen2025_dtc``; the names that there are unless given.

    Returns
    -------
    Model or list of str
        With its citation in ``source``; or the names.

    Raises
    ------
    InputError
        Where no such model is known.
    """
    folder = files("narrows") / "model" / "published"
    known = sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml"))
    if name is None:
        return known
    if name not in known:
        raise InputError(f"no published model is called {name!r}{did_you_mean(name, known)}")
    return load_model(Path(str(folder / f"{name}.toml")))


def model_named(name: str) -> Model:
    """Return a model by its file, or by the name of a paper's model."""
    return load_model(name) if "." in name or "/" in name or os.path.exists(name) else published(name)
