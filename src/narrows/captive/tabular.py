"""Tests as a table: what a data frame shows of them, in words, by name and in the documented columns."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.quantities.names import FORCES, MOTION, PARTICULARS
from narrows.results import Tabulated
from narrows.ship.actuators import STANDARD
from narrows.ship.particulars import Configuration

if TYPE_CHECKING:
    import pandas as pd


class Tabular(Tabulated):
    """Tests that show themselves as a table."""

    columns: Mapping[str, np.ndarray]
    names: tuple[str, ...]
    starts: np.ndarray
    conditions: tuple[str, ...]
    configuration: Configuration
    notes: tuple[str, ...]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the table."""
        rows, columns = self.to_dataframe().shape
        return rows, columns

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column; nothing where none is known."""
        known = {name: quantity.unit for name, quantity in {**MOTION, **PARTICULARS, **FORCES}.items()}
        known |= {"t": "s", "psi": "rad"} | {own.name: own.unit for own in STANDARD}
        return {name: known.get(name, "1" if _is_part(name, self.columns) else "") for name in self.columns}

    def summary(self) -> str:
        """Say how many tests and rows there are, of which ship in which water, and what was measured."""
        labels = list(dict.fromkeys(self.conditions))
        several = f" in {len(labels)} conditions" if len(labels) > 1 else ""
        tests = f"{len(self.names)} test{'s' * (len(self.names) > 1)}{several}, {int(self.starts[-1])} rows"
        return f"{tests}, with {', '.join(measured(self.columns)) or 'no force'}: {self.configuration.summary()}."

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name."""
        return {
            "tests": list(self.names), "conditions": list(self.conditions), "starts": self.starts,
            "columns": dict(self.columns), "units": self.units, "configuration": self.configuration.to_dict(),
            "summary": self.summary(), "notes": list(self.notes),
        }  # fmt: skip

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the rows as a table in the documented columns, SI and radians, which ``read_captive`` reads again."""
        import pandas as pd

        lengths = np.diff(self.starts)
        labels = {"condition": np.repeat(self.conditions, lengths)} if self.conditions else {}
        columns = {name: column for name, column in self.columns.items() if not _is_part(name, self.columns)}
        return pd.DataFrame({"test": np.repeat(self.names, lengths), **labels, **columns})


def _is_part(name: str, columns: Mapping[str, np.ndarray]) -> bool:
    """Whether a column is the cosine or sine of another."""
    return name.startswith(("cos_", "sin_")) and name[4:] in columns


def measured(columns: Mapping[str, np.ndarray]) -> list[str]:
    """Return which of X, Y, N a table has."""
    return [force for force in FORCES if force in columns]
