"""Base classes of results."""

import math
import re
from collections.abc import Iterator
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import narrows
from narrows.files import write_whole
from narrows.results.saving import FORMS, csv_of, forms_of, to_json, write

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@runtime_checkable
class Result(Protocol):
    """The common interface of a fit, a voyage, a plan, a safe envelope and every other result.

    Results with rows also have ``to_dataframe()``, those of several dimensions ``dataset()``.
    """

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes before use, one sentence each: assumptions, omitted data, uncorrected effects."""

    def summary(self) -> str:
        """Return the findings, one line per sentence."""

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name, as the verb's ``--json`` prints it; see the folder ``schemas``."""

    def plot(self, ax: "Axes | None" = None) -> "Figure":
        """Draw it.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; a new figure unless given.
        """

    def save(self, path: str | Path) -> None:
        """Write it in the format of the suffix.

        Parameters
        ----------
        path : str or Path
            Output file.
        """


def table_has(name: str) -> bool:
    """Return whether data frames have a method of this name."""
    import pandas as pd

    return hasattr(pd.DataFrame, name)


def _given_or_written(content: str | bytes | None, path: str | Path | None) -> Any:
    if path is None:
        return content
    if content is not None:
        write_whole(path, content)
    return None


def other_names(thing: Any) -> list[str]:
    """Return the names of other libraries that an object supports."""
    known = _known(thing)
    return [
        name.removesuffix(CALL) for ours, theirs in SAME.items() if ours.removesuffix(CALL) in known for name in theirs
    ]


def _known(thing: Any) -> set[str]:
    return {*dir(type(thing)), *getattr(type(thing), "__dataclass_fields__", ())}


def answer(thing: Any, name: str) -> Any:
    """Return an object's value under another library's name."""
    known = _known(thing)
    for ours, theirs in SAME.items():
        attribute = ours.removesuffix(CALL)
        if attribute in known and (name in theirs or name + CALL in theirs):
            value = getattr(thing, attribute)
            called, calls = name + CALL in theirs, ours.endswith(CALL)
            if called == calls:
                return value
            return partial(getattr, thing, attribute) if called else value()
    remedy = next((it for it in ANOTHER.get(name, ()) if re.split(r"[(.]", it)[0] in {*known, "nw"}), None)
    if remedy is None:
        return object.__getattribute__(thing, name)
    why = f": {WHY[name]}" if name in WHY else ""
    raise AttributeError(f"a {type(thing).__name__} has no {name!r}{why}; write {remedy}", name=None, obj=None)


# Summary of an object.
class BaseSummary:
    """An object with a one-line summary, a longer one in a notebook, and names of other libraries.

    It has ``summary()``, and ``to_dataframe()`` and ``notes`` if applicable.
    """

    def __repr__(self) -> str:
        said: Any = self
        return f"<{type(self).__name__}: {shortened(said.summary())}>"

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *other_names(self)})

    def _repr_html_(self) -> str:
        said: Any = self
        lines = "<br>".join(escape(line) for line in said.summary().splitlines())
        notes = "".join(f"<li>{escape(note)}</li>" for note in getattr(said, "notes", ()))
        table = said.to_dataframe().to_html(max_rows=30) if hasattr(said, "to_dataframe") else ""
        return f"<p>{lines}</p>{table}" + (f"<ul>{notes}</ul>" if notes else "")

    if not TYPE_CHECKING:  # Type checkers see the real attributes only

        def __getattr__(self, name: str) -> Any:
            return answer(self, name)


class BaseResult(BaseSummary):
    """A result with a plot, files and a notebook view."""

    def plot(self, ax: "Axes | None" = None) -> "Figure":
        """Draw it, as a Matplotlib figure.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes for a figure of one panel, or for its main one; a new figure unless given.

        Raises
        ------
        InputError
            If its kind has no figure, or axes are given and it has several panels without a main one.
        """
        return narrows.report.figure_of(self, ax)

    def save(self, path: str | Path) -> None:
        """Write it in the format of the suffix, whole or not at all.

        Parameters
        ----------
        path : str or Path
            Output file: ``.json``, ``.png``, ``.svg`` or ``.pdf``; ``.csv``, ``.parquet`` and ``.mat`` for a table,
            ``.nc`` and ``.zarr`` for several dimensions, ``.geojson`` and ``.kml`` for a track on the map. A device
            without a suffix gets the dataset, or else the table.

        Raises
        ------
        InputError
            If there is no such format, or the file cannot be written.
        """
        write(forms_of(self, path), path)

    def to_csv(self, path: str | Path | None = None, **options: Any) -> str | None:
        """Write the table as CSV, as pandas does.

        Parameters
        ----------
        path : str or Path, optional
            Output file; returned as text unless given.
        **options : Any
            Options of a data frame's ``to_csv``: ``sep``, ``index``, ``decimal`` ...

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        result: Any = self
        text: str | None = _given_or_written(csv_of(result.to_dataframe(), **options), path)
        return text

    def to_json(self, path: str | Path | None = None) -> str | None:
        """Write everything by name as JSON.

        Parameters
        ----------
        path : str or Path, optional
            Output file; returned as text unless given.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        result: Any = self
        text: str | None = _given_or_written(to_json(result.to_dict()), path)
        return text

    def to_xarray(self) -> "xarray.Dataset":
        """Return the data as an xarray Dataset."""
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


def shortened(text: str, most: int = 120) -> str:
    """Return the first line of a text, shortened if it is long."""
    line = text.partition("\n")[0].rstrip(".")
    return line if len(line) <= most else f"{line[: most - 3]}..."


# Names in other libraries: aliases, and names with another solution here.
CALL = "()"

# Names here by other libraries' names; brackets mark methods.
SAME = {
    "coefficients": ("params", "coef_", "coef"),
    "std": ("bse", "stderr", "standard_errors", "std_errors"),
    "covariance": ("pcov", "cov()", "cov_params()"),
    "intervals": ("confidence_intervals", "ci"),
    "residuals": ("resid",),
    "predict()": ("fittedvalues", "fitted"),
    "corr()": ("correlation", "correlation_matrix"),
    "latex()": ("to_latex()", "equations()"),
    "poles()": ("eigenvalues()", "eigvals()"), "eigenvalues()": ("poles()", "eigvals()"),
    "state_space()": ("to_ss()", "ss()", "to_control()"),
    "with_coefficients()": ("replace()", "set_params()", "assign()", "set_coefficients()", "with_values()"),
    "with_parts()": ("replace()",),
    "to_dataframe()": ("df", "to_frame()", "to_pandas()"),
    "save()": ("write()", "dump()", "to_toml()", "to_file()"),
    "t": ("time", "times"),
    "length": ("L", "Lpp"), "beam": ("B",), "draft": ("T",), "block_coefficient": ("Cb",),
}  # fmt: skip

# Names with another meaning, and what to use here instead.
ANOTHER = {
    **dict.fromkeys(("success", "status", "message"), ("outcome",)),
    **dict.fromkeys(("show", "figure"), ("plot()",)),
    **dict.fromkeys(("pvalues", "tvalues", "zvalues"), ("verdicts",)),
    **dict.fromkeys(("aic", "bic", "llf"), ("left_out",)),
    **dict.fromkeys(("heading", "psi_deg", "heading_deg"), ("psi",)),
    **dict.fromkeys(("data", "values_"), ("to_dataframe()",)),
    **dict.fromkeys(("trajectory", "states", "positions", "path", "forces"), ("to_dataframe()",)),
    **dict.fromkeys(("plot_trajectory", "plot_track", "plot_coefficients", "plot_forces"), ("plot()",)),
    **dict.fromkeys(("bode", "nyquist", "step_response", "root_locus"), ("state_space() for python-control",)),
    **dict.fromkeys(("is_stable", "stable", "damping"), ("modes()", "eigenvalues()", "poles()")),
    **dict.fromkeys(("info", "describe"), ("summary()",)),
    **dict.fromkeys(("write", "to_geojson"), ("nw.write_waterway(waterway, path)",)),
    "distance": ("outcome.distance",), "time_to_grounding": ("outcome.time",), "max_heading": ("psi",),
    "r2": ("rsquared",), "chi2": ("scores",), "nparams": ("coefficients",), "outliers": ("influence",),
    "condition_number": ("diagnostics.overall",), "is_identified": ("verdicts",), "compare": ("nw.compare(tests)",),
    "confidence_interval": ("conf_int()",), "simulate": ("model.simulate()",), "copy": ("with_coefficients()",),
    "predict": ("forces(u=..., y=...)",), "scale_to": ("scale(length)",),
    "derivatives": ("nw.nondimensional(model)",),
    "width": ("section(s).width", "configuration.canal.width"), "length": ("line.length",),
    "tests": ("test(name)",), "speed": ("u",), "get_influence": ("influence",), "f_test": ("verdicts",),
    "rsquared_adj": ("left_out",), "plot_bank_force": ("plot()",), "rudder_angle": ("rudder",),
    "grounding_time": ("outcome.time",), "min_distance": ("outcome",), "distance_to_bank": ("outcome",),
    **dict.fromkeys(("max_speed", "safe_speed", "limits"), ("highest_speed()",)), "is_safe": ("safe()",),
    **dict.fromkeys(("ss", "to_ss"), ("linearize().state_space()",)), "steady_state": ("nw.steady_course(model)",),
    "draft": ("ship.draft",), "depth": ("configuration.canal.depth",),
    "popt": ("coefficients",),  # SciPy's is an array; these go by name
}  # fmt: skip

# Reasons why an object lacks such a number.
WHY = {
    **dict.fromkeys(("pvalues", "tvalues", "zvalues"), "rows of one run share its errors, and such tests assume none"),
    **dict.fromkeys(("aic", "bic", "llf"), "rows of one run are not independent"),
}


# A result of table rows.
class Tabulated(BaseResult):
    """A result of rows: the data frame of its rows provides all further methods.

    Libraries that read tables by Arrow (Polars, DuckDB, Altair) read it as one.
    """

    def __iter__(self) -> Iterator[Any]:
        """The rows, each a tuple with names."""
        table: Any = self
        return iter(table.to_dataframe().reset_index().itertuples(index=False, name="Row"))

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        table: Any = self
        return table.to_dataframe().reset_index().__arrow_c_stream__(requested_schema)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            try:
                return super().__getattr__(name)
            except AttributeError:
                if name.startswith("_") or not (table_has(name) or name in self.__dict__.get("columns", ())):
                    raise
                return getattr(self.to_dataframe(), name)


def readable(value: float, std: float = math.nan) -> str:
    """Write a number to the second digit of its standard error, or to four digits."""
    if not math.isfinite(value):
        return "-" if math.isnan(value) else ("inf" if value > 0 else "-inf")
    if not (math.isfinite(std) and std > 0):
        return f"{value:.4g}"
    digits = max(0, 1 - math.floor(math.log10(std)))
    return f"{round(value, digits):.{min(digits, 8)}f}"


def interval(ends: tuple[float, float], std: float) -> str:
    """Write an interval to the second digit of a standard error."""
    return f"{readable(ends[0], std)} to {readable(ends[1], std)}"
