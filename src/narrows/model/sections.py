"""Model files: sections of TOML, which reproduce the forces to the last bit."""

import json
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

import narrows
from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, did_you_mean, shown
from narrows.base.files import form_of, write_whole
from narrows.base.named_values import Coefficients
from narrows.model.data_range import DataRange, Range
from narrows.model.tables import table_named
from narrows.model.term import TermTable
from narrows.ship.actuators import MODEL_SECTIONS
from narrows.ship.particulars import given_values
from narrows.ship.ship_file import (
    NEEDED,
    actuator_sections,
    assumptions,
    check_table,
    configuration_from,
    load_toml,
    section_of,
)  # fmt: skip

PARTS = tuple(NEEDED)
REQUIRED = (*PARTS, "terms", "coefficients")


@dataclass(frozen=True)
class Source:
    """Origin of the numbers."""

    text: str = ""  #: A citation, or the method
    table: str = ""  #: File name of the table of tests
    sha256: str = ""  #: Hash of that file
    estimate: str = ""  #: Data behind an estimated model, in sentences, if the ship was not tested


def sections_of(model: "narrows.Model") -> dict[str, Any]:
    configuration, terms = model.configuration, model.terms
    parts = {**{name: getattr(configuration, name) for name in PARTS}, **configuration.parts}
    tables: dict[str, Any] = {name: given_values(part) for name, part in parts.items()}
    for (section, key), note in assumptions(configuration.water).items():
        if note in configuration.notes:  # Who reads the file assumes it too
            tables[section].pop(key)
    lists = {force: [term.name for term in group] for force, group in terms.forces.items()}
    tables["terms"] = {"table": terms.name, **lists}
    tables["coefficients"] = {name: float(model.coefficients[name]) for name in terms.names}
    if model.covariance is not None:
        tables["covariance"] = {"names": list(terms.names), "matrix": model.covariance.tolist()}
    tables["data_range"] = {name: list(pair) for name, pair in given_values(model.data_range).items()}
    tables["source"] = asdict(model.source)
    if model.verdicts:
        tables["verdicts"] = dict(model.verdicts)
    return tables


def fields_of(tables: Mapping[str, Any], terms: TermTable | None) -> dict[str, Any]:
    actuators = terms.actuators if terms else ()
    parts = (*PARTS, *actuator_sections(actuators))
    _check_sections(tables, parts)
    try:
        terms = terms or table_named(str(tables["terms"].get("table", "")))
    except InputError as error:
        raise InputError(f"{error}; a table of your own goes in as load_model(path, terms=...)") from None
    sections = {name: table for name, table in tables.items() if name in parts}
    covered = {name: _pair(name, pair) for name, pair in tables.get("data_range", {}).items()}
    cited = {name: str(text) for name, text in tables.get("source", {}).items()}
    return {
        "configuration": configuration_from(sections, "its setting", actuators),
        "terms": terms,
        "coefficients": Coefficients(tables["coefficients"]),
        "covariance": _covariance(tables.get("covariance"), terms),
        "data_range": section_of(DataRange, "data_range", covered),
        "verdicts": tables.get("verdicts", {}),
        "source": section_of(Source, "source", cited),
    }


def _check_sections(tables: Mapping[str, Any], parts: Iterable[str]) -> None:
    if "ship" in tables and not {"terms", "coefficients"} & set(tables):
        raise InputError(
            "this is a ship file, which has no coefficients; give a model, as narrows identify makes of tests of this "
            "ship"
        )
    known = {*MODEL_SECTIONS, *parts}
    for name, table in tables.items():
        if name not in known:
            raise InputError(f"unknown section [{name}]{did_you_mean(name, known)}")
        check_table(name, table, "its tables")
    for name in REQUIRED:
        if name not in tables:
            raise InputError(f"section [{name}] is missing; a model file has {', '.join(REQUIRED)}")


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
        names, matrix = list(section["names"]), np.array(section["matrix"], dtype=float)
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


@accept_aliases
def save_model(model: "narrows.Model", path: str | Path) -> None:
    """Write a model file.

    Raises an InputError if the suffix is not that of TOML, or the file cannot be written.

    Parameters
    ----------
    model : Model
        The model.
    path : str or Path
        Output file.
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
def load_model(path: str | Path, terms: TermTable | None = None) -> "narrows.Model":
    """Read a model file: the same model as was saved.

    Raises an InputError if the file is absent, or a section, a key or a coefficient is missing or misspelt.

    Parameters
    ----------
    path : str or Path
        The file, or the name of a published model.
    terms : TermTable, optional
        The user's own table, if the file was made with one.

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
        return narrows.Model.from_dict(tables, terms)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
