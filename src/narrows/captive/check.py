"""Checks of a table: one sentence with file, row, column and remedy."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from narrows.base.errors import InputError
from narrows.captive import settings
from narrows.captive.columns import COLUMNS
from narrows.model.water import displacement
from narrows.physics.squat_and_depth import critical_speed
from narrows.quantities.names import GRAVITY
from narrows.readers.cells import row_number
from narrows.readers.headers import Column
from narrows.ship.particulars import Configuration

Columns = Mapping[str, np.ndarray]


class CheckedColumns(NamedTuple):
    frame: pd.DataFrame  # As it was read
    columns: Columns  # (rows,) Columns in SI
    by_name: Mapping[str, Column]  # Headers by quantity
    configuration: Configuration  # Ship, canal and water
    table: str  # Its name

    def is_bare(self, name: str) -> bool:
        return name in self.by_name and not self.by_name[name].stated

    def place(self, name: str, wrong: np.ndarray) -> str:
        return f"{self.table}: row {row_number(self.frame, wrong)}, column {self.by_name[name].header!r}"


def check_time(frame: pd.DataFrame, test: np.ndarray, t: np.ndarray, table: str) -> None:
    """Raise if time stands still or runs back inside a test."""
    stuck = np.concatenate([[False], (np.diff(t) <= 0) & (test[1:] == test[:-1])])
    if stuck.any():
        i = int(np.argmax(stuck))
        fault = "repeats the time of the row above" if t[i] == t[i - 1] else "goes back in time"
        remedy = "leave one out" if t[i] == t[i - 1] else "sort it by time"
        if t[i] < t[i - 1] and frame.duplicated().iloc[i]:
            fault, remedy = "begins rows that stand above already", "leave the second ones out"
        remedy = remedy if "test" in frame else f"{remedy}, or name the tests in a column 'test'"
        row = row_number(frame, stuck)
        raise InputError(f"{table}: row {row}, column 't' {fault} (test {test[i]}, t = {t[i]:g} s); {remedy}")


def check_heading(table: CheckedColumns) -> None:
    """Raise if the ship lies across the canal, or the heading looks like degrees."""
    psi = table.columns["psi"]
    across = np.abs(psi) >= math.pi / 2
    if not across.any():
        return
    place, value = table.place("psi", across), psi[int(np.argmax(across))]
    if table.is_bare("psi"):
        raise InputError(
            f"{place} = {value:g} rad looks like degrees; "
            "head the column 'psi [deg]', or give its unit in the --mapping file: [units] psi = \"deg\""
        )
    raise InputError(
        f"{place} is a heading of {math.degrees(value):.1f} deg; "
        "the model holds for |psi| < 90 deg; leave such rows out: --where 'abs(psi_deg) < 90'"
    )


def check_inside(table: CheckedColumns) -> None:
    """Raise if a hull corner touches or crosses a bank."""
    columns, ship = table.columns, table.configuration.ship
    if not {"y", "cos_psi", "sin_psi"} <= columns.keys():
        return
    y, width = columns["y"], columns.get("width", table.configuration.canal.width)
    reach = np.abs(y) + ship.length / 2 * np.abs(columns["sin_psi"]) + ship.beam / 2 * columns["cos_psi"]
    half = np.broadcast_to(np.asarray(width) / 2, y.shape)
    touching = reach >= half
    if not touching.any():
        return
    row, first = row_number(table.frame, touching), int(np.argmax(touching))
    remedy = "check y, psi, their units and the ship file"
    if (np.abs(y) < 2 * half).all() and (np.all(y > 0) or np.all(y < 0)):
        middle = f"half the width, {half[first]:g} m"
        remedy = f"if it counts from a bank, count it from the middle: {'subtract' if y[0] > 0 else 'add'} {middle}"
        remedy += f" (from a bank to starboard, take it from {half[first]:g} m)" * bool(y[0] > 0)
    elif table.is_bare("y") and (np.abs(y) / 1e3 + reach - np.abs(y) < half).all():
        remedy = "head it 'y [mm]' if that is its unit"
    raise InputError(
        f"{table.table}: row {row}, column 'y' = {y[first]:g} m puts the hull on the bank of a canal "
        f"{2 * half[first]:g} m wide; {remedy}"
    )


def check_units(table: CheckedColumns) -> None:
    """Raise if a column without a unit has a size that only another unit explains."""
    ship, values = table.configuration.ship, {**table.configuration.values(), **table.columns}
    fastest = settings.FASTEST * math.sqrt(GRAVITY * ship.length)
    if values.get("depth") is not None:
        section = {name: values[name] for name in ("beam", "draft", "width", "depth")}
        fastest = np.minimum(fastest, settings.PAST_CHOKING * critical_speed(**section))
    most = {
        "rudder": (math.pi / 2, "deg"), "draft": (3 * ship.draft, "mm"), "depth": (settings.DEEPEST * ship.draft, "mm"),
        "width": (settings.WIDEST * ship.beam, "mm"), "u": (fastest, "kn"),
    }  # fmt: skip
    for name, (largest, other) in most.items():
        if table.is_bare(name) and (large := np.abs(table.columns[name]) > largest).any():
            value, unit = table.columns[name][int(np.argmax(large))], COLUMNS[name].unit
            then = ", which then chokes the canal or rides its own wave" * (name == "u")
            raise InputError(
                f"{table.place(name, large)} = {value:g} {unit} is too large for this ship{then}; "
                f"head it '{name} [{other}]' if that is its unit, or '{name} [{unit}]'"
            )


def check_mass(configuration: Configuration, table: str) -> tuple[str, ...]:
    """Raise if mass or inertia contradict the displacement; return notes on smaller differences."""
    ship, displaced = configuration.ship, displacement(configuration)
    ratio = 1.0 if ship.mass is None else ship.mass / displaced
    finding = f"[ship] mass = {ship.mass} kg is {ratio:.3g} of what its hull displaces, {displaced:.4g} kg"
    if not 1 / settings.MASS_APART <= ratio <= settings.MASS_APART:
        raise InputError(f"{table}: {finding}; give it in kg at the scale of the hull, or mend the hull")
    gyration = 0.25 if ship.inertia is None else (ship.inertia / (ship.mass or displaced)) ** 0.5 / ship.length
    if not settings.GYRATION[0] <= gyration <= settings.GYRATION[1]:
        raise InputError(
            f"{table}: [ship] inertia = {ship.inertia} kg m2 is a radius of gyration of {gyration:.3g} lengths, where "
            "0.25 is usual; give it in kg m2 about midship, at the scale of the hull"
        )
    return () if 1 / settings.MASS_OFF <= ratio <= settings.MASS_OFF else (f"{finding}: was all of it on the balance?",)


def check_heave(table: CheckedColumns) -> tuple[str, ...]:
    """Raise if heave is no part of the draft, or the hull sinks into the ground; return a note if it is large."""
    if "heave" not in table.by_name:
        return ()
    columns, configuration = table.columns, table.configuration
    heave = columns["heave"]
    draft = np.broadcast_to(columns.get("draft", configuration.ship.draft), heave.shape)
    large = np.abs(heave) > settings.MOST_HEAVE * draft
    if large.any():
        i = int(np.argmax(large))
        remedy = "head it 'heave [mm]' if that is its unit" if table.is_bare("heave") else "check its unit"
        raise InputError(
            f"{table.place('heave', large)} = {heave[i]:g} m is {abs(heave[i]) / draft[i]:.2g} times "
            f"the draft, which no ship sinks under way; {remedy}"
        )
    depth = columns.get("depth", configuration.canal.depth)
    if depth is not None and (aground := draft + heave >= depth).any():
        raise InputError(f"{table.place('heave', aground)} puts the hull on the ground; check heave and depth")
    most = float((np.abs(heave) / draft).max())
    return (f"Heave reaches {most:.2g} of the draft: check its unit.",) if most > settings.MUCH_HEAVE else ()


def check_forces(table: CheckedColumns) -> None:
    """Raise if forces are far too large for a ship of this mass."""
    columns, length, mass = table.columns, table.configuration.ship.length, displacement(table.configuration)
    if "u" not in columns:
        return
    # Acceleration of the measured motion, or of a turn in one length [m/s2]; at least a hundredth of gravity
    speed = np.hypot(columns["u"], columns.get("v", 0.0))
    parts = [speed**2 / length, *(np.abs(columns[name]) for name in ("udot", "vdot") if name in columns)]
    parts += [length * np.abs(columns["rdot"])] if "rdot" in columns else []
    pull = max(float(np.mean(sum(parts))), GRAVITY / 1e4)
    for force, arm in (("X", 1.0), ("Y", 1.0), ("N", length)):
        ratio = float(np.sqrt(np.mean(columns[force] ** 2))) / (mass * pull * arm) if force in columns else 0.0
        if ratio > settings.STRONGEST:
            raise InputError(
                f"{table.table}: column {table.by_name[force].header!r} would move a ship of {mass:.3g} kg "
                f"{ratio:.2g} times faster than it was moved; check the unit of the force, and the scale of the ship "
                "file"
            )


def check_drift(table: CheckedColumns) -> None:
    """Raise if steady rows go sideways along the canal by twice their drift: heading or sway is reversed."""
    columns = table.columns
    if not {"u", "v", "psi"} <= columns.keys():
        return
    steady = np.ones(len(columns["u"]), bool)
    for name in ("r", "udot", "vdot", "rdot"):
        steady &= np.abs(columns.get(name, 0.0)) < settings.STEADY_RATE
    from_heading = (columns["u"] * np.sin(columns["psi"]))[steady]
    from_sway = (columns["v"] * np.cos(columns["psi"]))[steady]
    drifts = np.abs(from_heading) > settings.LEAST_LEEWAY * np.abs(columns["u"][steady])
    if drifts.any() and np.allclose(from_heading[drifts], from_sway[drifts], rtol=0.1):
        heading, sway = (repr(table.by_name[name].header) for name in ("psi", "v"))
        raise InputError(
            f"{table.table}: straight runs go across the canal at twice their drift; turn the sign of {heading} "
            f"or of {sway} (heading clockwise from above, sway to starboard)"
        )
