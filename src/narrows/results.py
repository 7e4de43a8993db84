"""What every result can do, and the one way from a result to JSON."""

import json
import math
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np

from narrows.errors import Described
from narrows.files import (
    PICTURES,
    form_of,
    matlab_of,
    netcdf_of,
    parquet_of,
    picture_of,
    write_whole,
    write_zarr,
)

if TYPE_CHECKING:
    import pandas as pd
    import xarray
    from matplotlib.figure import Figure

Form = Callable[[], str | bytes | None]
"""Makes what goes into a file, or writes a folder itself."""


@runtime_checkable
class Result(Protocol):
    """What a fit, a voyage, a plan, a safe envelope and every other result can do.

    Results whose data make a table have ``to_dataframe()`` too, those of several dimensions ``dataset()``.
    """

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know before the result is used, each a sentence: assumptions, data left, what was not corrected."""

    def summary(self) -> str:
        """Say what was found, a line for each sentence."""

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name, as the verb's ``--json`` prints it; see the folder ``schemas``."""

    def plot(self) -> "Figure":
        """Draw it."""

    def save(self, path: str | Path) -> None:
        """Write it in the form that the suffix says.

        Parameters
        ----------
        path : str or Path
            Where to.
        """


class Shown(Described):
    """A result that draws itself, goes into files and shows itself in a notebook."""

    def plot(self) -> "Figure":
        """Draw it, as a Matplotlib figure."""
        # Pictures are made in a room above those of results, which is looked up when one is asked for.
        figure: Figure = import_module("narrows.report.figures").figure_of(self)
        return figure

    def save(self, path: str | Path) -> None:
        """Write it in the form that the suffix says, whole or not at all.

        Parameters
        ----------
        path : str or Path
            Where to: ``.json``, ``.png``, ``.svg`` or ``.pdf``; ``.csv``, ``.parquet`` and ``.mat`` where it makes a
            table, ``.nc`` and ``.zarr`` where it has several dimensions, ``.geojson`` and ``.kml`` where it is a track
            on the map. A device without a suffix gets the dataset, or else the table.

        Raises
        ------
        InputError
            Where there is no such form, or the file cannot be written.
        """
        _write(_forms(self, path), path)

    def to_csv(self, path: str | Path | None = None) -> str | None:
        """Write the table as CSV, as pandas does.

        Parameters
        ----------
        path : str or Path, optional
            Where to; returned as text unless given.

        Raises
        ------
        InputError
            Where the file cannot be written.
        """
        result: Any = self
        return _given_or_written(_csv_of(result.to_dataframe()), path)

    def to_json(self, path: str | Path | None = None) -> str | None:
        """Write everything by name as JSON.

        Parameters
        ----------
        path : str or Path, optional
            Where to; returned as text unless given.

        Raises
        ------
        InputError
            Where the file cannot be written.
        """
        result: Any = self
        return _given_or_written(to_json(result.to_dict()), path)

    def to_xarray(self) -> "xarray.Dataset":
        """Give the data as an xarray Dataset."""
        result: Any = self
        data: xarray.Dataset = result.dataset() if hasattr(result, "dataset") else result.to_dataframe().to_xarray()
        return data


def _given_or_written(text: str, path: str | Path | None) -> str | None:
    if path is None:
        return text
    write_whole(path, text)
    return None


def save_dataset(dataset: "xarray.Dataset", path: str | Path) -> None:
    """Write a dataset in the form that the suffix says, whole or not at all.

    Parameters
    ----------
    dataset : Dataset
        Of an ensemble.
    path : str or Path
        Where to: ``.nc``, ``.zarr``, ``.csv``, ``.parquet``, ``.mat`` or ``.json``; NetCDF into a device.

    Raises
    ------
    InputError
        Where there is no such form, or the file cannot be written.
    """
    forms = _dataset_forms(dataset, path) | {".json": lambda: to_json(_as_mapping(dataset))}
    _write(forms, path)


def _write(forms: Mapping[str, Form], path: str | Path) -> None:
    content = forms[form_of(path, tuple(forms))]()
    if content is not None:
        write_whole(path, content)


def _forms(result: Any, path: str | Path) -> dict[str, Form]:
    """What a result can be written as, by suffix; the first is what a device gets."""
    forms: dict[str, Form] = {}
    if hasattr(result, "dataset"):
        forms |= _dataset_forms(result.dataset(), path)
    if hasattr(result, "to_dataframe"):
        forms |= _table_forms(result.to_dataframe, path)
    forms[".json"] = lambda: to_json(_with_data(result))
    if hasattr(result, "track"):
        forms |= {".geojson": lambda: str(result.track().geojson()), ".kml": lambda: str(result.track().kml())}
    return forms | {suffix: lambda kind=suffix: picture_of(result.plot(), kind) for suffix in PICTURES}


def _with_data(result: Any) -> dict[str, Any]:
    """A result by name, and its data where these are a dataset."""
    data = {"data": _as_mapping(result.dataset())} if hasattr(result, "dataset") else {}
    return dict(result.to_dict()) | data


def _table_forms(table: Callable[[], "pd.DataFrame"], path: str | Path) -> dict[str, Form]:
    return {
        ".csv": lambda: _csv_of(table()),
        ".parquet": lambda: parquet_of(table(), path),
        ".mat": lambda: matlab_of({str(name): column.to_numpy() for name, column in table().items()}),
    }


def _dataset_forms(dataset: "xarray.Dataset", path: str | Path) -> dict[str, Form]:
    def rows() -> "pd.DataFrame":
        frame: pd.DataFrame = dataset.to_dataframe() if dataset.sizes else dataset.expand_dims("row").to_dataframe()
        return frame.reset_index()

    return {
        ".nc": lambda: netcdf_of(dataset, path),
        ".zarr": lambda: write_zarr(dataset, path),
        **_table_forms(rows, path),
        ".mat": lambda: matlab_of({str(name): variable.to_numpy() for name, variable in dataset.variables.items()}),
    }


def _as_mapping(dataset: "xarray.Dataset") -> dict[str, Any]:
    """A dataset by name: its coordinates, its variables and what is known of it."""
    return {
        "attributes": dict(dataset.attrs),
        "coordinates": {str(name): _column(coordinate) for name, coordinate in dataset.coords.items()},
        "variables": {str(name): _column(variable) for name, variable in dataset.data_vars.items()},
    }


def _column(array: "xarray.DataArray") -> dict[str, Any]:
    return {"dimensions": list(array.dims), "unit": array.attrs.get("units", ""), "values": array.to_numpy()}


def _csv_of(frame: Any) -> str:
    """Rows that have no names are not numbered."""
    return str(frame.to_csv(index=frame.index.names != [None]))


def plain(value: Any) -> Any:
    """Return a value as JSON can hold it: None for NaN and infinity, lists for arrays.

    Parameters
    ----------
    value : Any
        Mappings, sequences, arrays, numbers, words, True, False, None.

    Raises
    ------
    TypeError
        Where there is anything else in it.
    """
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
    """Write a value, or what a result's ``to_dict`` gives, as JSON.

    Parameters
    ----------
    value : Any
        As in ``plain``.
    """
    return json.dumps(plain(value), indent=2, allow_nan=False)
