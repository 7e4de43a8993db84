"""Which rows of a table are taken: an expression on its headers, or on plain names."""

import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from narrows.captive.tests import LABELS
from narrows.errors import InputError, near_miss, reason, shown
from narrows.quantities.names import Quantity
from narrows.readers.headers import parse_header


def plain_columns(
    where: str, frame: pd.DataFrame, known: Mapping[str, Quantity], hidden: Iterable[str]
) -> dict[str, pd.Series]:
    """Return the columns that an expression calls by plain names: ``psi`` in SI, ``psi_deg`` in degrees."""
    parsed = [parse_header(str(header), known) for header in frame.columns]
    columns = {column.quantity: column for column in parsed if column}
    words = set(re.findall(r"[^\W\d]\w*", where)) - set(hidden)
    columns_by_word = {word: frame[word] for word in words & set(LABELS) & set(frame.columns)}
    for word in words:
        asked = parse_header(word, known)
        if asked and asked.quantity in columns:
            column = columns[asked.quantity]
            columns_by_word[word] = pd.to_numeric(frame[column.header], errors="coerce") * (column.scale / asked.scale)
    return columns_by_word


def chosen_early(frame: pd.DataFrame, where: str | None, table: str) -> np.ndarray | None:
    """Return the rows that an expression on the headers alone takes, None where it uses other names."""
    if where is None or where == "":
        return np.ones(len(frame), bool)
    try:
        return _evaluated(frame, where, table, ())
    except pd.errors.UndefinedVariableError:
        return None


def chosen_late(
    raw: pd.DataFrame, frame: pd.DataFrame, where: str, table: str, known: Mapping[str, Quantity]
) -> np.ndarray:
    """Return the rows that an expression on headers and plain names takes, (rows,) of bool."""
    here = raw if raw.index.equals(frame.index) else raw.loc[frame.index]
    headers = [str(header) for header in raw.columns]
    try:
        names = plain_columns(where, frame, known, headers)
        return _evaluated(here, where, table, (names,))
    except InputError as error:
        raise InputError(str(error) if str(error).startswith(table) else f"{table}: {error}") from None
    except pd.errors.UndefinedVariableError as error:
        word = str(error).split("'")[1]
        near = near_miss(word, [*headers, *known]) or f"; it has {', '.join(headers[:20])}"
        raise _not_understood(where, f"{reason(error)}{near}", table) from None


def _evaluated(frame: pd.DataFrame, where: str, table: str, resolvers: tuple[Any, ...]) -> np.ndarray:
    try:
        chosen: Any = frame.eval(where, engine="python", resolvers=resolvers, local_dict={}, global_dict={})
        if not pd.api.types.is_bool_dtype(chosen):
            raise TypeError("it is neither true nor false")
        if np.shape(chosen) != (len(frame),):
            raise TypeError("it is not one answer for each row")
    except pd.errors.UndefinedVariableError:
        raise
    except Exception as error:
        raise _not_understood(where, reason(error), table) from None
    return np.asarray(chosen, dtype=bool)


def _not_understood(where: str, why: str, table: str) -> InputError:
    return InputError(
        f"{table}: cannot select rows where {shown(where)} ({why}); use the table's headers, or names as u, psi_deg"
    )
