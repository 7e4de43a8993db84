"""Model files: TOML that reproduces the forces to the last bit."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import narrows
from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.files import form_of, write_whole
from narrows.model.model import Model
from narrows.model.term import TermTable
from narrows.ship.ship_file import load_toml


@accept_aliases
def save_model(model: Model, path: str | Path) -> None:
    """Write a model file.

    Raises an InputError if the suffix is not that of TOML, or the file cannot be written.

    Parameters
    ----------
    model : Model
        The model.
    path : str or Path
        Output file.

    Examples
    --------
    >>> nw.save_model(model, "dtc.toml")
    """
    form_of(path, (".toml",))
    write_whole(path, to_toml(model.to_dict()))


def to_toml(table: Mapping[str, Any], name: str = "") -> str:
    """Return nested tables of numbers, text, booleans and lists as TOML."""
    tables = {key: value for key, value in table.items() if isinstance(value, Mapping)}
    lines = [f"{_key(key)} = {_value(value)}\n" for key, value in table.items() if key not in tables]
    head = f"[{name}]\n" if name and (lines or not tables) else ""
    below = [to_toml(value, f"{name}.{_key(key)}" if name else _key(key)) for key, value in tables.items()]
    return "\n".join(filter(None, [head + "".join(lines), *below]))


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _value(name)


def _value(value: Any, indent: str = "") -> str:
    if isinstance(value, str):
        # JSON escapes the same characters as TOML, except the control character DEL.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        inner = indent + "    "
        return "[\n" + "".join(f"{inner}{_value(one, inner)},\n" for one in value) + f"{indent}]" if value else "[]"
    if not isinstance(value, bool | int | float):
        raise TypeError(f"{type(value).__name__} has no form in TOML")
    return str(value).lower()  # true, nan and 1e+16 are lower case in both; str gives every digit of a float


@accept_aliases
def load_model(path: str | Path, terms: TermTable | None = None) -> Model:
    """Read a model file.

    Raises an InputError if the file is absent, or a section, a key or a coefficient is missing or misspelt.

    Parameters
    ----------
    path : str or Path
        The file, or the name of a published model.
    terms : TermTable, optional
        The user's own table, if the file was made with one.

    Returns
    -------
    Model
        The same as the saved model.

    Examples
    --------
    >>> nw.save_model(model, "dtc.toml")
    >>> nw.load_model("dtc.toml") == model
    True
    """
    if isinstance(path, str) and not Path(path).suffix and path in narrows.published():
        return narrows.published(path)
    tables = load_toml(path)
    try:
        return Model.from_dict(tables, terms)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
