"""Layouts of tables that are known by name; any other must come in the documented columns."""

from typing import Protocol

import pandas as pd

from narrows.captive.formats import dtc, fhr, lataire


class Layout(Protocol):
    """What a module that knows a layout offers."""

    def recognises(self, frame: pd.DataFrame) -> bool:
        """Say whether a frame has this layout."""

    def translated(self, frame: pd.DataFrame, chosen: str, table: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
        """Bring the layout to the documented headers, with what there is to say of it."""


LAYOUTS: tuple[Layout, ...] = (fhr, lataire, dtc)


def translated(frame: pd.DataFrame, chosen: str, table: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Bring a frame of a known layout to the documented headers, with what there is to say of it."""
    for layout in LAYOUTS:
        if layout.recognises(frame):
            return layout.translated(frame, chosen, table)
    return frame, ()
