"""A ship's own log into records: tables, text, Parquet, NMEA 0183; whole, or record by record."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from narrows.errors import InputError, check_count
from narrows.logbook.reading.log_mapping import log_mapping
from narrows.logbook.reading.streamed_log import LogReading, StreamedLog, as_path
from narrows.logbook.ship_log import ShipLog
from narrows.logbook.ship_record import ShipRecord
from narrows.readers.nmea.nmea_recording import is_nmea
from narrows.waterway import Waterway, read_waterway

# Without a row [s], after which another record begins.
GAP = 300.0


def read_log(
    log: Any, waterway: Waterway | str | Path | None = None,
    mapping: str | Path | Mapping[str, Any] | None = None, units: Mapping[str, str] | None = None, *,
    late: Mapping[str, float] | None = None, antenna: tuple[float, float] | None = None,
    condition: Mapping[str, float] | None = None, gap: float = GAP, mmsi: int | None = None,
) -> ShipLog:  # fmt: skip
    """Read a ship's own records into memory.

    Columns are those of ``SIGNALS``, SI and radians unless a header carries a unit, and those of docs/ship-log.md:
    longitude and latitude, heading and course from north, velocities in fixed axes, wind as felt on board. Empty
    cells are times at which that was not measured.

    Parameters
    ----------
    log : str, Path, DataFrame, Dataset, or a sequence of them
        CSV and text in any dialect, Parquet, Excel, a recording of NMEA 0183, or a table.
    waterway : Waterway, str or Path, optional
        Along which to tell where the ship is; a plane where there is none.
    mapping : str, Path or mapping, optional
        The ship's own names, units and signs, what is late and where the antenna stands: TOML with ``[columns]``,
        ``[units]``, ``[positive]``, ``[late]``, ``[antenna]`` and ``[condition]``.
    units : mapping of str to str, optional
        Of columns whose headers do not say it.
    late : mapping of str to float, optional [s]
        By how much columns were reported later than they were measured.
    antenna : pair of float, optional [m]
        Of the position: forward and to starboard of midship.
    condition : mapping of str to float, optional
        How the ship was loaded, as in ``{"draft": 10.2}``.
    gap : float [s]
        A time without a row after which another record begins, where no column ``record`` names them.
    mmsi : int, optional
        Whose AIS reports to read of a recording; what the ship reports of itself unless given.

    Returns
    -------
    ShipLog
        In SI and the package's axes; ``check_log`` says what is wrong with it.

    Raises
    ------
    InputError
        In one sentence with file, row, column and remedy.
    """
    parts = log if isinstance(log, list | tuple) else [log]
    if not parts:
        raise InputError("there is no log to read; give one or more")
    options: dict[str, Any] = {"late": late, "antenna": antenna, "condition": condition, "gap": gap, "mmsi": mmsi}
    records: list[ShipRecord] = []
    notes: list[str] = []
    for part in parts:
        streamed = stream_log(part, waterway, mapping, units, **options)
        reading = LogReading(streamed)
        taken = {record.name for record in records}
        records += [_named_apart(record, streamed.name, taken) for record in reading.records()]
        notes += [note for note in reading.notes() if note not in notes]
    return ShipLog(tuple(records), streamed.waterway, tuple(notes))


def stream_log(
    log: Any, waterway: Waterway | str | Path | None = None,
    mapping: str | Path | Mapping[str, Any] | None = None, units: Mapping[str, str] | None = None, *,
    late: Mapping[str, float] | None = None, antenna: tuple[float, float] | None = None,
    condition: Mapping[str, float] | None = None, gap: float = GAP, mmsi: int | None = None,
) -> StreamedLog:  # fmt: skip
    """Open a log whose records are read one by one each time they are asked for.

    Parameters
    ----------
    log : str, Path or DataFrame
        CSV, text or Parquet, or a recording of NMEA 0183.
    waterway : Waterway, str or Path, optional
        Along which to tell where the ship is; a plane where there is none.
    mapping : str, Path or mapping, optional
        As in ``read_log``, like what follows.
    units : mapping of str to str, optional
        Of columns whose headers do not say it.
    late : mapping of str to float, optional [s]
        By how much columns were reported later than they were measured.
    antenna : pair of float, optional [m]
        Of the position: forward and to starboard of midship.
    condition : mapping of str to float, optional
        How the ship was loaded.
    gap : float [s]
        A time without a row after which another record begins.
    mmsi : int, optional
        Whose AIS reports to read.

    Returns
    -------
    StreamedLog
        What ``check_log`` and fits take as they take a ``ShipLog``.

    Raises
    ------
    InputError
        Where the file is absent, or an option is none; rows are checked as they pass.
    """
    if not gap > 0:
        raise InputError(f"gap = {gap} s is no time without a row; give one over 0")
    if mmsi is not None:
        check_count("mmsi", mmsi, 1, 999_999_999)
    table = as_path(log)
    if isinstance(table, Path) and not table.is_file():
        raise InputError(f"{table}: there is no such file; check the path")
    if mmsi is not None and not (isinstance(table, Path) and is_nmea(table)):
        raise InputError(f"mmsi = {mmsi} asks for AIS reports, and the log is no recording of NMEA 0183; leave it out")
    water = read_waterway(waterway) if isinstance(waterway, str | Path) else waterway
    return StreamedLog(table, log_mapping(mapping, units, late, antenna, condition), water, gap, mmsi)


def _named_apart(record: ShipRecord, log: str, taken: set[str]) -> ShipRecord:
    """The record, its name with that of its file where another file has one of its name."""
    return replace(record, name=f"{Path(log).stem} {record.name}") if record.name in taken else record
