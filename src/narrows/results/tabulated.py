"""A result whose data are rows of a table."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from narrows.results.shown_results import Shown, table_has


class Tabulated(Shown):
    """A result whose data are rows: what it does not do itself, the data frame of its rows does.

    What reads tables by Arrow (Polars, DuckDB, Altair) reads it as one.
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
