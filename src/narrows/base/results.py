"""Base classes of results."""

import ast
import builtins
import math
import re
from collections.abc import Collection, Iterator, Sequence
from functools import cache, partial, wraps
from html import escape
from importlib import import_module
from inspect import CO_VARKEYWORDS, isfunction, signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import narrows
from narrows.base.aliases import accept_aliases, aliases, function_named, name_here, names_of, unit_of
from narrows.base.errors import InputError, did_you_mean
from narrows.base.files import FORMS, csv_of, forms_of, to_json, write, write_whole
from narrows.base.named_values import Named

if TYPE_CHECKING:
    import pandas as pd
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# Methods of a data frame that need columns of numbers.
OF_NUMBERS = ("mean", "std", "var", "sem", "median", "quantile", "skew", "kurt", "corr", "cov", "abs")

# Marks methods in the tables of names.
CALL = "()"


def table_has(name: str) -> bool:
    import pandas as pd

    return hasattr(pd.DataFrame, name)


def given_or_written(content: str | None, path: str | Path | None) -> str | None:
    if path is None:
        return content
    if content is not None:
        write_whole(path, content)
    return None


def _head(path: str) -> str:
    return re.split(r"[(.]", path)[0]


_LIBRARIES = {"np": "numpy", "nw": "narrows", "pd": "pandas"}


@cache
def _names_in(formula: str) -> set[str]:
    """Return the names that a formula reads, without attributes and builtins."""
    nodes = [*ast.walk(ast.parse(formula))]
    names = [node for node in nodes if isinstance(node, ast.Name)]
    read = {one.id for one in names} - {one.id for one in names if isinstance(one.ctx, ast.Store)}
    return read - vars(builtins).keys() - {node.arg for node in nodes if isinstance(node, ast.arg)}


def _value(value: Any, name: str, *values: Any, **given: Any) -> Any:
    """Return the value of an attribute that is a method elsewhere."""
    why = name_here(name, "why")
    if [of for of in (*values, *given.values()) if not (why and "95 %" in why and of in (0.05, 0.95))]:
        raise InputError(f"{name} takes no arguments here{f': {why}' if why else ''}; write {name}()")
    return value


def _with_call(table: "pd.DataFrame", name: str) -> "pd.DataFrame":
    """Return a table that a call returns again, since it is a method in some libraries."""

    def again(self: Any, *values: Any, **given: Any) -> Any:
        return _value(table, name, *values, **given)

    def reduced(self: Any, protocol: Any) -> Any:
        return type(table), (table,)

    kind: Any = type("DataFrame", (type(table),), {"__call__": again, "__reduce_ex__": reduced})
    return kind(table)  # type: ignore[no-any-return]


def answer(thing: Any, name: str, columns: Collection[str] = ()) -> Any:
    """Return an object's value under another library's name."""
    kind = type(thing)
    known, fields = {*names_of(kind), *columns}, getattr(kind, "__dataclass_fields__", ())
    of_fields = [(ours, theirs) for ours, theirs in aliases("arguments").items() if ours in fields]
    # Formulas in the object's own attributes, such as ``abs(r).max()``, then attributes and fields.
    for row, theirs in [*aliases("formulas").items(), *aliases("attributes").items(), *of_fields]:
        if not (called := name + CALL in theirs) and name not in theirs:
            continue
        ours = row.removeprefix(f"{kind.__name__.lower()}.")  # A voyage's ``outcome.time`` is an outcome's ``time``
        used = _names_in(ours)
        is_method = any(isfunction(getattr(kind, one, None)) for one in used)
        if used <= {*known, *_LIBRARIES} and not ("." in ours and is_method):
            scope = {short: import_module(_LIBRARIES[short]) for short in used & _LIBRARIES.keys()}
            value = eval(ours.removesuffix(CALL), scope | {one: getattr(thing, one) for one in used & known})
            if type(value).__name__ == "DataFrame":
                return _with_call(value, name)
            if called == ours.endswith(CALL) or isinstance(value, Named):
                return value
            made: Any = partial(_value, value, name) if called else value()
            return _with_call(made, name) if type(made).__name__ == "DataFrame" else made
    stem = name.rpartition("_")[0]
    own = stem if stem in known else name_here(stem, "attributes", lambda row: _head(row) in known)
    if own and (size := unit_of(name, own.rpartition(".")[2])) and not callable(value := getattr(thing, stem)):
        return np.divide(value, size)
    drawn = name.removeprefix("plot_")  # ``plot_heading()`` is ``plot(y="psi")``
    if (
        drawn != name
        and "plot" in known
        and (own := name_here(drawn, "attributes", known.__contains__) or drawn) in known
    ):
        return partial(thing.plot, y=own)
    function = function_named(name) or (getattr(narrows, name) if name in dir(narrows) else None)
    if isfunction(function) and next(iter(signature(function).parameters), "") in aliases("first").get(
        kind.__name__, ()
    ):
        return partial(function, thing)
    # A property that raised: its own error, not one of a missing name.
    if name.startswith("_") or name in names_of(kind):
        return object.__getattribute__(thing, name)
    raise AttributeError(_refusal(thing, name, columns), name=None, obj=None)


def _refusal(thing: Any, name: str, columns: Collection[str]) -> str:
    """Return why an object has no such name, and what to write instead."""
    known = {*names_of(type(thing)), *columns}
    heads = {*known, "nw", type(thing).__name__.lower()}
    remedy = name_here(name, "instead", lambda row: re.split(r"[ (.,]", row)[0] in heads)
    if not remedy and "plot" in name and "plot" in known:
        remedy = "plot()"
    if not remedy and "to_dataframe" in known and table_has(name) and name not in OF_NUMBERS:
        remedy = f"to_dataframe().{name}"
    if not remedy and type(thing).__name__ in aliases("first"):
        remedy = name_here(name, "other_functions")
    if "coefficients" in known and name in thing.coefficients:
        remedy = f"{type(thing).__name__.lower()}[{name!r}]"
    why = f": {reason}" if (reason := name_here(name, "why")) else ""
    kinds = (kind for kind in type(thing).__mro__ if kind.__module__.startswith("narrows"))
    words = {*columns, *getattr(type(thing), "__dataclass_fields__", ()), *(it for kind in kinds for it in vars(kind))}
    shown = {word for word in words if word[0] != "_"}
    other = f"; write {remedy}" if remedy else did_you_mean(name, shown, cutoff=0.75)
    return f"{type(thing).__name__} has no {name!r}{why}{other}"


class Answering(type):
    """Names the function that makes an object, where a class lacks the constructor of another library."""

    def __getattr__(cls, name: str) -> Any:
        if constructor := name_here(f"{cls.__name__}.{name}", "constructors"):
            return getattr(narrows, constructor)
        made = name_here(cls.__name__, "made_by")
        raise AttributeError(f"{cls.__name__} has no {name!r}" + (f"; write {made}" if made else ""))


class Aliased(metaclass=Answering):
    """An object that answers to the names of other libraries."""

    def __dir__(self) -> list[str]:
        known, libraries = names_of(type(self)), _LIBRARIES.keys()
        rows = [names for ours, names in aliases("attributes").items() if _head(ours) in known]
        rows += [names for formula, names in aliases("formulas").items() if _names_in(formula) <= known | libraries]
        theirs = (name.removesuffix(CALL) for names in rows for name in names)
        return sorted({*super().__dir__(), *theirs})

    if not TYPE_CHECKING:  # Type checkers see the real attributes only

        def __getattr__(self, name: str) -> Any:
            return answer(self, name)


def equal_to(word: str) -> Any:
    """Return an ``__eq__`` by content, or of the attribute ``word`` with a text."""
    by_content: Any = lambda one, other: type(one) is type(other) and vars(one) == vars(other)  # noqa: E731
    return lambda one, other: getattr(one, word) == other if isinstance(other, str) else by_content(one, other)


class ShownText(str):
    """A text that an interpreter or a notebook shows in its lines, without quotes."""

    __slots__ = ()
    __repr__ = str.__str__


class BaseSummary(Aliased):
    """An object with a one-line summary, and a longer one in a notebook.

    It has ``summary()``, and ``to_dataframe()`` and ``notes`` if applicable.
    """

    def __init_subclass__(cls) -> None:
        """Let its summary be shown in lines."""
        if said := vars(cls).get("summary"):
            setattr(cls, "summary", wraps(said)(lambda self: ShownText(said(self))))  # noqa: B010
        if values := vars(cls).get("to_dict"):  # Text would stand there without quotes
            plain = wraps(values)(
                lambda self: {n: str(v) if isinstance(v, ShownText) else v for n, v in values(self).items()}
            )
            setattr(cls, "to_dict", plain)  # noqa: B010

    def summary(self) -> str:
        """Describe it in words, its main result first, then its table after an empty line."""
        raise NotImplementedError

    def __str__(self) -> str:
        return self.summary()

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {shortened(self.summary())}>"

    def __float__(self) -> float:
        numbers = [name for name, value in vars(self).items() if isinstance(value, float)]
        raise TypeError(
            f"a {type(self).__name__} is no number; take one of its own: {', '.join(numbers) or 'its columns'}"
        )

    def __format__(self, form: str) -> str:
        return format(float(self), form) if form else str(self)

    def _repr_html_(self: Any) -> str:
        lines = "<br>".join(escape(line) for line in self.summary().partition("\n\n")[0].splitlines())
        notes = "".join(f"<li>{escape(note)}</li>" for note in getattr(self, "notes", ()))
        table = self.to_dataframe().to_html(max_rows=30) if hasattr(self, "to_dataframe") else ""
        return f"<p>{lines}</p>{table}" + (f"<ul>{notes}</ul>" if notes else "")


class BaseResult(BaseSummary):
    """A result with a plot, files and a notebook view: a fit, a voyage, a plan, a safe envelope.

    Its ``notes`` are one sentence each, to be read before use. Results with rows also have ``to_dataframe()``, those of
    several dimensions ``dataset()``.
    """

    def __init_subclass__(cls) -> None:
        """Accept the other names of arguments in methods, and answer wrong ones, as public functions do."""
        super().__init_subclass__()
        for name, method in [*vars(cls).items()]:
            code = getattr(method, "__code__", None)
            if code and name[0] != "_" and code.co_argcount > 1 and not code.co_flags & CO_VARKEYWORDS:
                setattr(cls, name, accept_aliases(method))

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name, as the verb's ``--json`` prints it; see the folder ``schemas``."""
        raise NotImplementedError

    @accept_aliases
    def plot(self, ax: "Axes | Figure | str | Path | Sequence[str] | None" = None, **style: Any) -> "Figure":
        """Draw it, as a Matplotlib figure: one panel, or its main one, on Axes ``ax`` if given.

        With a path for ``ax`` the figure is written there: ``.png``, ``.svg`` or ``.pdf``. Columns of its table for
        ``ax`` or ``y`` are drawn over the column ``x``, else over time or rows. ``style`` is ``title``, ``figsize``,
        and for the main line ``label``, ``color`` and the like. Raises an InputError if its kind has no figure, or axes
        are given and it has several panels without a main one.
        """
        return narrows.report.figure_of(self, ax, **style)

    def save(self, path: str | Path) -> None:
        """Write it to a ``path`` in the format of its suffix, whole or not at all.

        These are ``.json``, ``.png``, ``.svg`` and ``.pdf``; ``.csv``, ``.parquet`` and ``.mat`` for a table, ``.nc``
        for several dimensions, ``.geojson`` for a track on the map. A device without a suffix gets the dataset, or
        else the table. Raises an InputError for another format, or if it cannot be written.
        """
        write(forms_of(self, path), path)

    def to_csv(self: Any, path: str | Path | None = None, **options: Any) -> str | None:
        """Write the table as CSV to a ``path``, with ``options`` as of pandas; return it as text without one.

        Raises an InputError if the file cannot be written.
        """
        return given_or_written(csv_of(self.to_dataframe(), **options), path)

    def to_json(self, path: str | Path | None = None) -> str | None:
        """Write everything by name as JSON to a ``path``; return it as text without one.

        Raises an InputError if the file cannot be written.
        """
        return given_or_written(to_json(self.to_dict()), path)

    def to_xarray(self: Any) -> "xarray.Dataset":
        """Return the data as an xarray Dataset."""
        data: xarray.Dataset = self.dataset() if hasattr(self, "dataset") else self.to_dataframe().to_xarray()
        return data

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            form = FORMS.get(name.removeprefix("to_")) if name.startswith("to_") else None
            if form is not None and form in forms_of(self, ""):
                return lambda path=None: given_or_written(forms_of(self, path or "")[form](), path)
            if name.startswith("to_") and hasattr(type(self), "to_dataframe") and table_has(name):
                return getattr(self.to_dataframe(), name)
            return super().__getattr__(name)


def same_content(result: Any, other: Any) -> bool:
    """Return whether two results of one class have the same rows and the same content by name."""

    def content(one: Any) -> tuple[Any, Any]:
        return to_json(one.to_dict()), csv_of(one.to_dataframe())

    return result is other or (type(result) is type(other) and content(result) == content(other))


def shortened(text: str, most: int = 120) -> str:
    line = text.partition("\n")[0].rstrip(".")
    return line if len(line) <= most else f"{line[: most - 3]}..."


class Tabulated(BaseResult):
    """A result of rows: the data frame of its rows provides all further methods.

    Libraries that read tables by Arrow (Polars, DuckDB, Altair) read it as one.
    """

    def to_dataframe(self: Any) -> "pd.DataFrame":
        """Return the rows as a table."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def __iter__(self: Any) -> Iterator[Any]:
        """The rows, each a tuple with names."""
        return iter(self.to_dataframe().reset_index().itertuples(index=False, name="Row"))

    def __arrow_c_stream__(self: Any, requested_schema: Any = None) -> Any:
        return self.to_dataframe().reset_index().__arrow_c_stream__(requested_schema)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            if name in ("describe", "info"):  # Elsewhere these are methods of a summary
                return getattr(self.to_dataframe(), name)
            try:
                return super().__getattr__(name)
            except AttributeError:
                if name.startswith("_") or not hasattr(table := self.to_dataframe(), name):
                    raise
                return getattr(table.select_dtypes("number") if name in OF_NUMBERS else table, name)


def readable(value: float, std: float = math.nan) -> str:
    """Write a number to the second digit of its standard error, or to four digits; some by powers of ten."""
    if not math.isfinite(value):
        return "-" if math.isnan(value) else ("inf" if value > 0 else "-inf")
    if not (math.isfinite(std) and std > 0):
        return f"{value:.4g}"
    digits = 1 - math.floor(math.log10(std))
    if abs(value) >= 1e5 or digits > 8:
        return f"{value:.{max(1, digits + 1 + math.floor(math.log10(abs(value) or 1.0)))}g}"
    return f"{round(value, digits):.{max(digits, 0)}f}"


def with_error(value: float, error: float) -> str:
    """Write a number and its standard error or half width."""
    return f"{readable(value, error)} ± {readable(error, error)}"


def interval(ends: tuple[float, float], std: float) -> str:
    return f"{readable(ends[0], std)} to {readable(ends[1], std)}"
