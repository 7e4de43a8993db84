"""Files of results, by suffix: tables, datasets, tracks, figures."""

import json
import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.files import PICTURES, form_of, matlab_of, netcdf_of, parquet_of, picture_of, write_whole, write_zarr

if TYPE_CHECKING:
    import pandas as pd
    import xarray

# Makes a file's content, or writes a folder itself.
Form = Callable[[], str | bytes | None]
# Returns the descriptions of a table, by name.
Words = Callable[[], dict[str, str]]
# Suffixes by the libraries' names of formats, as in ``to_netcdf``.
FORMS = {"netcdf": ".nc", "parquet": ".parquet", "zarr": ".zarr", "mat": ".mat", "geojson": ".geojson", "kml": ".kml"}


def save_dataset(dataset: "xarray.Dataset", path: str | Path) -> None:
    """Write a dataset in the format of the suffix, whole or not at all."""
    forms = _dataset_forms(dataset, path) | {".json": lambda: to_json(_as_mapping(dataset))}
    write(forms, path)


def write(forms: Mapping[str, Form], path: str | Path) -> None:
    content = forms[form_of(path, tuple(forms))]()
    if content is not None:
        write_whole(path, content)


def forms_of(result: Any, path: str | Path) -> dict[str, Form]:
    """Return a result's formats by suffix; the first is used for a device."""
    forms: dict[str, Form] = {}
    if hasattr(result, "dataset"):
        forms |= _dataset_forms(result.dataset(), path)
    if hasattr(result, "to_dataframe"):
        forms |= _table_forms(
            result.to_dataframe, path, lambda: {"summary": result.summary(), "notes": "\n".join(result.notes)}
        )
    forms[".json"] = lambda: to_json(
        {**result.to_dict(), **({"data": _as_mapping(result.dataset())} if hasattr(result, "dataset") else {})}
    )
    if hasattr(result, "track"):
        forms |= {".geojson": lambda: str(result.track().geojson()), ".kml": lambda: str(result.track().kml())}
    if hasattr(result, "animate"):
        forms[".gif"] = lambda: result.animate(path) and None
    return forms | {suffix: lambda kind=suffix: picture_of(result.plot(), kind) for suffix in PICTURES}


def _table_forms(table: Callable[[], "pd.DataFrame"], path: str | Path, words: Words) -> dict[str, Form]:
    return {
        ".csv": lambda: csv_of(table()),
        ".parquet": lambda: parquet_of(_noted(table(), words()), path),
        ".mat": lambda: matlab_of({str(name): column.to_numpy() for name, column in table().items()} | words()),
    }


def _noted(frame: "pd.DataFrame", words: Mapping[str, str]) -> "pd.DataFrame":
    frame = frame.copy(deep=False)
    frame.attrs.update(words)
    return frame


def _dataset_forms(dataset: "xarray.Dataset", path: str | Path) -> dict[str, Form]:
    def rows() -> "pd.DataFrame":
        frame: pd.DataFrame = dataset.to_dataframe() if dataset.sizes else dataset.expand_dims("row").to_dataframe()
        return frame.reset_index()

    def words() -> dict[str, str]:
        return {str(name): value for name, value in dataset.attrs.items() if isinstance(value, str)}

    arrays = {str(name): variable.to_numpy() for name, variable in dataset.variables.items()}
    return {
        ".nc": lambda: netcdf_of(dataset, path),
        ".zarr": lambda: write_zarr(dataset, path),
        **_table_forms(rows, path, words),
        ".mat": lambda: matlab_of(words() | arrays),
    }


def _as_mapping(dataset: "xarray.Dataset") -> dict[str, Any]:
    return {
        "attributes": dict(dataset.attrs),
        "coordinates": {str(name): _column(coordinate) for name, coordinate in dataset.coords.items()},
        "variables": {str(name): _column(variable) for name, variable in dataset.data_vars.items()},
    }


def _column(array: "xarray.DataArray") -> dict[str, Any]:
    return {"dimensions": list(array.dims), "unit": array.attrs.get("units", ""), "values": array.to_numpy()}


def csv_of(frame: Any, **options: Any) -> str:
    """Return a table as text; unnamed rows are not numbered."""
    return str(frame.to_csv(**{"index": frame.index.names != [None], **options}))


# The one conversion of results to JSON.
def plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, Iterable):
        return [plain(part) for part in value]
    raise TypeError(f"{type(value).__name__} has no place in JSON")


def to_json(value: Any) -> str:
    """Write a value, or a result's ``to_dict()``, as JSON."""
    return json.dumps(plain(value), indent=2, allow_nan=False)
