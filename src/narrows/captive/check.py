"""What is wrong with a table, in one sentence that names file, row, column and remedy."""

import math

import numpy as np
import pandas as pd

from narrows.errors import InputError
from narrows.readers.cells import row_number
from narrows.readers.headers import Column
from narrows.ship.particulars import Configuration


def check_time(frame: pd.DataFrame, test: np.ndarray, t: np.ndarray, table: str) -> None:
    """Raise where time stands still or runs back inside a test."""
    # test (rows,); t (rows,) [s]
    stuck = np.concatenate([[False], (np.diff(t) <= 0) & (test[1:] == test[:-1])])
    if stuck.any():
        i = int(np.argmax(stuck))
        fault = "repeats the time of the row above" if t[i] == t[i - 1] else "goes back in time"
        row = row_number(frame, stuck)
        raise InputError(f"{table}: row {row}, column 't' {fault} (test {test[i]}, t = {t[i]:g} s); sort it by time")


def check_heading(frame: pd.DataFrame, psi: np.ndarray, column: Column, table: str) -> None:
    """Raise where the ship lies across the canal, or the heading looks like degrees."""
    # psi (rows,) [rad]
    across = np.abs(psi) >= math.pi / 2
    if not across.any():
        return
    row, value = row_number(frame, across), psi[int(np.argmax(across))]
    if not column.stated:
        raise InputError(
            f"{table}: row {row}, column {column.header!r} = {value:g} rad looks like degrees; "
            "head the column 'psi [deg]'"
        )
    raise InputError(
        f"{table}: row {row}, column {column.header!r} is a heading of {math.degrees(value):.1f} deg; "
        "the model holds for |psi| < 90 deg, leave the row out"
    )


def check_rates(columns: dict[str, np.ndarray], test: np.ndarray, by_name: dict[str, Column], table: str) -> None:
    """Raise where psi and r differ by the factor of degrees to radians."""
    # test (rows,)
    if not {"t", "psi", "r"} <= columns.keys():
        return
    inside = test[1:] == test[:-1]
    turned = np.diff(columns["psi"])[inside]
    expected = (0.5 * (columns["r"][1:] + columns["r"][:-1]) * np.diff(columns["t"]))[inside]
    if not (turned @ turned > 0 and expected @ expected > 0):
        return
    correlation = turned @ expected / math.sqrt((turned @ turned) * (expected @ expected))
    factor = math.sqrt((turned @ turned) / (expected @ expected))
    for name, ratio in (("psi", factor), ("r", 1 / factor)):
        if correlation > 0.9 and 40 < ratio < 80 and not by_name[name].stated:
            unit = "deg" if name == "psi" else "deg/s"
            raise InputError(
                f"{table}: column {name!r} is {ratio:.0f} times what "
                f"{'r' if name == 'psi' else 'psi'} says, so it looks like degrees; head it '{name} [{unit}]'"
            )


def check_inside(frame: pd.DataFrame, columns: dict[str, np.ndarray], configuration: Configuration, table: str) -> None:
    """Raise where a hull corner touches or crosses a bank."""
    if not {"y", "cos_psi", "sin_psi"} <= columns.keys():
        return
    ship, width = configuration.ship, columns.get("width", configuration.canal.width)
    reach = np.abs(columns["y"]) + ship.length / 2 * np.abs(columns["sin_psi"]) + ship.beam / 2 * columns["cos_psi"]
    touching = reach >= np.asarray(width) / 2
    if touching.any():
        row, first = row_number(frame, touching), int(np.argmax(touching))
        y, width_there = columns["y"][first], float(np.broadcast_to(width, touching.shape)[first])
        raise InputError(
            f"{table}: row {row}, column 'y' = {y:g} m puts the hull on the bank of a canal "
            f"{width_there:g} m wide; check y, psi and the ship file"
        )
