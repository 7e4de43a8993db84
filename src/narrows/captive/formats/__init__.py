"""Layouts of tables that are known by name; any other must come in the documented columns."""

import pkgutil
from importlib import import_module
from typing import Protocol, cast

import pandas as pd


class Layout(Protocol):
    """What a module that knows a layout offers; its first line of documentation says whose tables they are."""

    __name__: str
    __doc__: str | None

    def recognises(self, frame: pd.DataFrame) -> bool:
        """Say whether a frame has this layout."""

    def translated(self, frame: pd.DataFrame, chosen: str, table: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
        """Bring the layout to the documented headers, with what there is to say of it."""

    def sample(self) -> pd.DataFrame:
        """Give a few rows as its tables have them."""


# Every module of this folder. No two recognise one table, so that their order means nothing.
LAYOUTS: tuple[Layout, ...] = tuple(
    cast(Layout, import_module(f"{__name__}.{found.name}")) for found in pkgutil.iter_modules(__path__)
)


def translated(frame: pd.DataFrame, chosen: str, table: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Bring a frame of a known layout to the documented headers, with what there is to say of it."""
    for layout in LAYOUTS:
        if layout.recognises(frame):
            return layout.translated(frame, chosen, table)
    return frame, ()
