"""Model files: TOML that gives back the same forces to the last bit."""

import math
import os
from dataclasses import asdict
from importlib.resources import files
from pathlib import Path
from typing import Any, overload

import numpy as np

from narrows.errors import InputError, did_you_mean, shown
from narrows.files import form_of, write_whole
from narrows.model.data_range import DataRange, Range
from narrows.model.model import Model, Source
from narrows.ship.ship_file import actuator_sections, check_table, configuration_from, load_toml
from narrows.terms.tables import table_named
from narrows.terms.term import TermTable

PARTS = ("ship", "canal", "water")
REQUIRED = (*PARTS, "terms", "coefficients")
OPTIONAL = ("covariance", "data_range", "source", "verdicts")


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
    write_whole(path, tomli_w.dumps(as_tables(model)))


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
        return from_tables(tables, terms)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


@overload
def published() -> list[str]: ...
@overload
def published(name: str) -> Model: ...
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
    """Return a model by its file, or by the name of a paper's model.

    Parameters
    ----------
    name : str
        A path, or as in ``published``.

    Raises
    ------
    InputError
        Where it is neither.
    """
    return load_model(name) if "." in name or "/" in name or os.path.exists(name) else published(name)


def as_tables(model: Model) -> dict[str, Any]:
    """Return a model as the sections of its file (ours).

    Parameters
    ----------
    model : Model
        The model.
    """
    configuration = model.configuration
    parts = {**{name: getattr(configuration, name) for name in PARTS}, **configuration.parts}
    tables: dict[str, Any] = {name: _without_none(asdict(part)) for name, part in parts.items()}
    lists = {force: [term.name for term in terms] for force, terms in model.terms.forces.items()}
    tables["terms"] = {"table": model.terms.name, **lists}
    tables["coefficients"] = {name: float(model.coefficients[name]) for name in model.terms.names}
    if model.covariance is not None:
        tables["covariance"] = {"names": list(model.terms.names), "matrix": model.covariance.tolist()}
    tables["data_range"] = {name: list(pair) for name, pair in _without_none(asdict(model.data_range)).items()}
    tables["source"] = asdict(model.source)
    if model.verdicts:
        tables["verdicts"] = dict(model.verdicts)
    return tables


def _without_none(values: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value is not None}


def from_tables(tables: dict[str, Any], terms: TermTable | None) -> Model:
    """Return the model of the sections of a file (ours).

    Parameters
    ----------
    tables : dict of str to dict
        By section.
    terms : TermTable, optional
        The user's own table, where the file was made with one.

    Raises
    ------
    InputError
        Where a section, a key or a coefficient is missing or misspelt.
    """
    actuators = terms.actuators if terms else ()
    parts = (*PARTS, *actuator_sections(actuators))
    known = {*REQUIRED, *OPTIONAL, *parts}
    if "ship" in tables and not {"terms", "coefficients"} & set(tables):
        raise InputError(
            "this is a ship file, which has no coefficients; give a model, as narrows identify makes of tests of this "
            "ship"
        )
    for name, table in tables.items():
        if name not in known:
            raise InputError(f"unknown section [{name}]{did_you_mean(name, known)}")
        check_table(name, table, "its tables")
    for name in REQUIRED:
        if name not in tables:
            raise InputError(f"section [{name}] is missing; a model file has {', '.join(REQUIRED)}")
    terms = terms or _known_table(str(tables["terms"].get("table", "")))
    sections = {name: table for name, table in tables.items() if name in parts}
    return Model(
        configuration=configuration_from(sections, "its setting", actuators),
        terms=terms,
        coefficients=tables["coefficients"],
        covariance=_covariance(tables.get("covariance"), terms),
        data_range=_of(
            "data_range", DataRange, {n: _pair(n, pair) for n, pair in tables.get("data_range", {}).items()}
        ),
        verdicts=tables.get("verdicts", {}),
        source=_of("source", Source, {n: str(text) for n, text in tables.get("source", {}).items()}),
    )


def _known_table(name: str) -> TermTable:
    try:
        return table_named(name)
    except InputError as error:
        raise InputError(f"{error}; a table of your own goes in as load_model(path, terms=...)") from None


def _is_covariance(matrix: np.ndarray) -> bool:
    if not np.isfinite(matrix).all() or not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0):
        return False
    size = np.sqrt(np.abs(np.diag(matrix)))
    scaled = matrix / np.outer(size, size) if size.all() else matrix / max(size.max() ** 2, 1e-300)
    return bool((np.diag(matrix) >= 0).all() and np.linalg.eigvalsh(scaled).min() > -1e-6)


def _covariance(section: dict[str, Any] | None, terms: TermTable) -> np.ndarray | None:
    if section is None:
        return None
    fault = InputError("[covariance] does not have one row and one column for each coefficient; mend it")
    try:
        names = list(section["names"])
        matrix = np.array(section["matrix"], dtype=float)
    except (KeyError, TypeError, ValueError, OverflowError):
        raise fault from None
    if matrix.shape != (len(names), len(names)) or sorted(map(str, names)) != sorted(terms.names):
        raise fault
    if not _is_covariance(matrix):
        raise InputError("[covariance] is no covariance: symmetric, finite, nothing below 0; mend it or leave it out")
    order = [names.index(name) for name in terms.names]
    return matrix[np.ix_(order, order)]


def _pair(name: str, pair: Any) -> Range:
    try:
        low, high = (float(end) for end in pair)
    except (TypeError, ValueError, OverflowError):
        low = high = math.nan
    if not -math.inf < low <= high < math.inf:
        raise InputError(f"[data_range] {name} = {shown(pair)} is not a pair of numbers; give lowest and highest")
    return low, high


def _of(section: str, cls: type, values: dict[str, Any]) -> Any:
    known = cls.__annotations__
    for name in values:
        if name not in known:
            raise InputError(f"[{section}] unknown key {name!r}{did_you_mean(name, known)}")
    return cls(**values)
