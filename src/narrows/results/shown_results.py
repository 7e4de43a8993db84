"""What every result can do."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import narrows
from narrows.files import write_whole
from narrows.results.described import Described
from narrows.results.plain_values import to_json
from narrows.results.saving import FORMS, csv_of, forms_of, write

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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

    def plot(self, ax: "Axes | None" = None) -> "Figure":
        """Draw it.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to; a figure of its own unless given.
        """

    def save(self, path: str | Path) -> None:
        """Write it in the form that the suffix says.

        Parameters
        ----------
        path : str or Path
            Where to.
        """


class Shown(Described):
    """A result that draws itself, goes into files and shows itself in a notebook."""

    def plot(self, ax: "Axes | None" = None) -> "Figure":
        """Draw it, as a Matplotlib figure.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw what has one panel, or its main one; a figure of its own unless given.

        Raises
        ------
        InputError
            Where nothing is drawn of its kind, or axes are given and it has several panels, none of them the main one.
        """
        return narrows.report.figure_of(self, ax)

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
        write(forms_of(self, path), path)

    def to_csv(self, path: str | Path | None = None, **options: Any) -> str | None:
        """Write the table as CSV, as pandas does.

        Parameters
        ----------
        path : str or Path, optional
            Where to; returned as text unless given.
        **options : Any
            As of a data frame's ``to_csv``: ``sep``, ``index``, ``decimal`` ...

        Raises
        ------
        InputError
            Where the file cannot be written.
        """
        result: Any = self
        text: str | None = _given_or_written(csv_of(result.to_dataframe(), **options), path)
        return text

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
        text: str | None = _given_or_written(to_json(result.to_dict()), path)
        return text

    def to_xarray(self) -> "xarray.Dataset":
        """Give the data as an xarray Dataset."""
        result: Any = self
        data: xarray.Dataset = result.dataset() if hasattr(result, "dataset") else result.to_dataframe().to_xarray()
        return data

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            form = FORMS.get(name.removeprefix("to_")) if name.startswith("to_") else None
            if form is not None and form in forms_of(self, ""):
                return lambda path=None: _given_or_written(forms_of(self, path or "")[form](), path)
            if name.startswith("to_") and hasattr(type(self), "to_dataframe") and table_has(name):
                return getattr(self.to_dataframe(), name)
            return super().__getattr__(name)


def table_has(name: str) -> bool:
    """Return whether data frames do what is called so."""
    import pandas as pd

    return hasattr(pd.DataFrame, name)


def _given_or_written(content: str | bytes | None, path: str | Path | None) -> Any:
    if path is None:
        return content
    if content is not None:
        write_whole(path, content)
    return None
