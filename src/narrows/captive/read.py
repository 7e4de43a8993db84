"""Tables of captive tests, files or in memory, in the documented columns, to CaptiveTests."""

import hashlib
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from narrows.captive.rows import Reading, checked, gathered, prepared
from narrows.captive.tests import CaptiveTests
from narrows.errors import InputError
from narrows.model.source import Source
from narrows.progress import file_stage
from narrows.readers.dataframes import as_sheet, name_of, sha256_of_frame
from narrows.readers.frames import guarded, read_frame
from narrows.readers.mapping import ColumnMapping, read_mapping
from narrows.ship.actuator import Actuator
from narrows.ship.ship_file import ShipSource, ship_file_of, ship_from


def read_captive(
    table: Any, ship: ShipSource, where: str | None = None, actuators: Iterable[Actuator] = (),
    mapping: str | Path | Mapping[str, Any] | ColumnMapping | None = None,
) -> CaptiveTests:  # fmt: skip
    """Read a table of captive tests into memory.

    What is read does not depend on what will be fitted: a column that terms need and the table lacks is missed there.

    Parameters
    ----------
    table : str, Path, DataFrame or Dataset
        CSV in any dialect, Parquet, Excel, .mat, or a table of pandas, Polars, Arrow or xarray; columns
        ``test, t, x, y, psi, u, v, r, udot, vdot, rdot, heave, X, Y, N``, SI and radians unless the header carries a
        unit, as in ``psi [deg]``. Optional: ``condition``, and ``depth``, ``draft``, ``width`` where they change
        from row to row.
    ship : str, Path, Configuration or mapping
        The ship file, what was read from it, or its sections as mappings.
    where : str, optional
        Which rows to take, as in ``"abs(y) < 0.5 and psi_deg > 2"``: on the headers of the table, or on the names
        above, SI unless they end in a unit.
    actuators : iterable of Actuator
        Of one's own, whose columns the table and whose sections the ship file may have.
    mapping : str, Path, mapping or ColumnMapping, optional
        A laboratory's own names, units and signs: TOML with ``[columns]``, ``[units]`` and ``[positive]``, or the same
        as mappings.

    Returns
    -------
    CaptiveTests
        Checked, in SI.

    Raises
    ------
    InputError
        In one sentence with file, row, column and remedy.
    """
    movers = tuple(actuators)
    configuration = ship_from(ship, movers)
    path = Path(table) if isinstance(table, str | os.PathLike) else None
    name = str(path) if path else name_of(table)
    sheet = read_frame(path) if path else as_sheet(table)
    with file_stage("checking", path):
        frame, notes = prepared(sheet.frame, Reading(name, where, read_mapping(mapping), movers))
        if not len(frame):
            raise InputError(f"{name}: no rows are left to read; give a test at least one row")
        rows = checked(frame, configuration, name, movers, ship_file_of(ship))
        hashed = sha256_of(path) if path else sha256_of_frame(sheet.frame)
    source = Source("captive tests", path.name if path else type(table).__name__, hashed)
    return gathered(rows, configuration, source, sheet.notes + notes)


def as_tests(tests: Any, ship: ShipSource | None, usual: ShipSource | None = None) -> Any:
    """Return tests as they are, or read a table of them."""
    if hasattr(tests, "blocks"):
        if ship is not None:
            raise InputError("these tests have a ship already; give ship where they are a file or a table")
        return tests
    known = usual if ship is None else ship
    if known is None:
        raise InputError("a table does not say which ship it is of; give ship='ship.toml', or a Configuration")
    return read_captive(tests, known)


def sha256_of(path: Path) -> str:
    """Return the hash of a file, read in pieces."""
    return str(guarded(path, lambda: _digest(path)))


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
