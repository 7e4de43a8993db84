"""Known table layouts; any other table must have the documented columns."""

import pkgutil
from importlib import import_module
from typing import Protocol, cast

import pandas as pd


class Layout(Protocol):
    """Interface of a layout module; the first line of its docstring names the laboratory."""

    __name__: str
    __doc__: str | None

    def recognises(self, frame: pd.DataFrame) -> bool: ...
    def translated(self, frame: pd.DataFrame, chosen: str, table: str) -> tuple[pd.DataFrame, tuple[str, ...]]: ...
    def sample(self) -> pd.DataFrame:
        """Return a few rows in its format."""


# Every module of this folder. No two recognise the same table, so their order does not matter.
LAYOUTS: tuple[Layout, ...] = tuple(
    cast(Layout, import_module(f"{__name__}.{found.name}")) for found in pkgutil.iter_modules(__path__)
)


def is_known(frame: pd.DataFrame) -> bool:
    return any(layout.recognises(frame) for layout in LAYOUTS)


def translated(frame: pd.DataFrame, chosen: str, table: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Convert a frame of a known layout to the documented headers, with notes."""
    for layout in LAYOUTS:
        if layout.recognises(frame):
            return layout.translated(frame, chosen, table)
    return frame, ()
