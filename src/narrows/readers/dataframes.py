"""Tables that a program has already: pandas, Polars, Arrow, xarray, or a mapping of columns."""

import hashlib
from collections.abc import Mapping
from typing import Any

import pandas as pd

from narrows.errors import InputError, needs, reason, shown
from narrows.readers.frames import Sheet
from narrows.readers.text_table import FIRST_ROW


def as_sheet(table: object) -> Sheet:
    """Return a table of a program as the reader takes it: rows counted from 0 in sentences."""
    try:
        frame = _as_frame(table)
    except InputError:
        raise
    except Exception as error:  # Libraries of tables raise nearly anything on columns that are none.
        raise InputError(f"{name_of(table)}: makes no table ({reason(error)}); give a DataFrame") from None
    frame = frame.set_axis([str(header) for header in frame.columns], axis="columns")
    frame.index = pd.RangeIndex(-FIRST_ROW, len(frame) - FIRST_ROW)
    return Sheet(frame)


def name_of(table: object) -> str:
    """Return what to call a table that is no file."""
    return f"the {type(table).__name__}"


def sha256_of_frame(frame: pd.DataFrame) -> str:
    """Return a hash of the cells and headers of a frame."""
    words = {header: str for header in frame if pd.api.types.is_object_dtype(frame[header])}
    rows = pd.util.hash_pandas_object(frame.astype(words), index=False)
    return hashlib.sha256("\n".join(frame.columns).encode() + rows.to_numpy().tobytes()).hexdigest()


def _as_frame(table: Any) -> pd.DataFrame:
    if isinstance(table, pd.DataFrame):
        # An index with names is columns like any others.
        return table.reset_index(drop=table.index.names == [None])
    if hasattr(table, "data_vars"):
        frame: pd.DataFrame = table.to_dataframe().reset_index()
        return frame.rename(columns={name: _with_unit(table, name) for name in frame.columns})
    if hasattr(table, "to_pandas"):
        with needs("parquet", f"a {type(table).__name__}"):
            return pd.DataFrame(table.to_pandas())
    if isinstance(table, Mapping):
        return pd.DataFrame(dict(table))
    raise InputError(f"table = {shown(table)} is neither a path nor a table; give a file, a DataFrame or a Dataset")


def _with_unit(dataset: Any, name: Any) -> str:
    unit = dataset[name].attrs.get("units") if name in dataset.variables else None
    return f"{name} [{unit}]" if isinstance(unit, str) and unit and "[" not in str(name) else str(name)
