"""Checks of a table: one sentence with file, row, column and remedy."""

import math
from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd

from narrows.captive import settings
from narrows.captive.columns import COLUMNS
from narrows.captive.tests import cuts
from narrows.errors import InputError
from narrows.model.masses import displacement
from narrows.quantities.names import GRAVITY
from narrows.readers.cells import row_number
from narrows.readers.headers import Column
from narrows.ship.particulars import Configuration, Ship


def check_time(frame: pd.DataFrame, test: np.ndarray, t: np.ndarray, table: str) -> None:
    """Raise if time stands still or runs back inside a test."""
    stuck = np.concatenate([[False], (np.diff(t) <= 0) & (test[1:] == test[:-1])])
    if stuck.any():
        i = int(np.argmax(stuck))
        fault = "repeats the time of the row above" if t[i] == t[i - 1] else "goes back in time"
        remedy = "leave one out" if t[i] == t[i - 1] else "sort it by time"
        remedy = remedy if "test" in frame else f"{remedy}, or name the tests in a column 'test'"
        row = row_number(frame, stuck)
        raise InputError(f"{table}: row {row}, column 't' {fault} (test {test[i]}, t = {t[i]:g} s); {remedy}")


def check_heading(frame: pd.DataFrame, psi: np.ndarray, column: Column, table: str) -> None:
    """Raise if the ship lies across the canal, or the heading looks like degrees."""
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
    """Raise if psi and r differ by the factor of degrees to radians."""
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
    """Raise if a hull corner touches or crosses a bank."""
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


Columns = Mapping[str, np.ndarray]


def check_units(frame: pd.DataFrame, columns: Columns, by_name: Mapping[str, Column], ship: Ship, table: str) -> None:
    """Raise if a column without a unit has a size that only another unit explains."""
    most = {
        "rudder": (math.pi / 2, "rudder [deg]"), "draft": (3 * ship.draft, "draft [mm]"),
        "depth": (settings.DEEPEST * ship.draft, "depth [mm]"), "width": (settings.WIDEST * ship.beam, "width [mm]"),
    }  # fmt: skip
    for name, (largest, header) in most.items():
        large = np.abs(columns[name]) > largest if name in by_name and not by_name[name].stated else np.zeros(1, bool)
        if large.any():
            value, unit = columns[name][int(np.argmax(large))], COLUMNS[name].unit
            raise InputError(
                f"{table}: row {row_number(frame, large)}, column {by_name[name].header!r} = {value:g} {unit} is too "
                f"large for this ship; head it {header!r} if that is its unit, or '{name} [{unit}]'"
            )


def check_mass(configuration: Configuration, table: str) -> tuple[str, ...]:
    """Raise if mass or inertia contradict the displacement; return notes on smaller differences."""
    ship, displaced = configuration.ship, displacement(configuration)
    ratio = 1.0 if ship.mass is None else ship.mass / displaced
    told = f"[ship] mass = {ship.mass} kg is {ratio:.3g} of what its hull displaces, {displaced:.4g} kg"
    if not 1 / settings.MASS_APART <= ratio <= settings.MASS_APART:
        raise InputError(f"{table}: {told}; give it in kg at the scale of the hull, or mend the hull")
    gyration = 0.25 if ship.inertia is None else (ship.inertia / (ship.mass or displaced)) ** 0.5 / ship.length
    if not settings.GYRATION[0] <= gyration <= settings.GYRATION[1]:
        raise InputError(
            f"{table}: [ship] inertia = {ship.inertia} kg m2 is a radius of gyration of {gyration:.3g} lengths, where "
            "0.25 is usual; give it in kg m2 about midship, at the scale of the hull"
        )
    return () if 1 / settings.MASS_OFF <= ratio <= settings.MASS_OFF else (f"{told}: was all of it on the balance?",)


def check_heave(
    frame: pd.DataFrame, columns: Columns, configuration: Configuration, column: Column | None, table: str
) -> tuple[str, ...]:
    """Raise if heave is no part of the draft, or the hull sinks into the ground; return a note if it is large."""
    if column is None:
        return ()
    heave, draft = columns["heave"], np.asarray(columns.get("draft", configuration.ship.draft))
    large = np.abs(heave) > settings.MOST_HEAVE * draft
    if large.any():
        i = int(np.argmax(large))
        ratio = float(abs(heave[i]) / np.broadcast_to(draft, heave.shape)[i])
        remedy = "check its unit" if column.stated else "head it 'heave [mm]' if that is its unit"
        raise InputError(
            f"{table}: row {row_number(frame, large)}, column {column.header!r} = {heave[i]:g} m is {ratio:.2g} times "
            f"the draft, which no ship sinks under way; {remedy}"
        )
    depth = columns.get("depth", configuration.canal.depth)
    aground = np.zeros(len(heave), bool) if depth is None else draft + heave >= depth
    if aground.any():
        row = row_number(frame, aground)
        raise InputError(
            f"{table}: row {row}, column {column.header!r} puts the hull on the ground; check heave and depth"
        )
    most = float((np.abs(heave) / draft).max())
    return (f"Heave reaches {most:.2g} of the draft: check its unit.",) if most > settings.MUCH_HEAVE else ()


def check_forces(columns: Columns, configuration: Configuration, by_name: Mapping[str, Column], table: str) -> None:
    """Raise if forces are far too large for a ship of this mass."""
    if "u" not in columns:
        return
    length, mass = configuration.ship.length, displacement(configuration)
    pull = _usual_acceleration(columns, length)
    for force, arm in (("X", 1.0), ("Y", 1.0), ("N", length)):
        if force not in columns:
            continue
        ratio = float(np.sqrt(np.mean(columns[force] ** 2))) / (mass * pull * arm)
        if ratio > settings.STRONGEST:
            raise InputError(
                f"{table}: column {by_name[force].header!r} would move a ship of {mass:.3g} kg {ratio:.2g} times "
                "faster than it was moved; check the unit of the force, and the scale of the ship file"
            )


def _usual_acceleration(columns: Columns, length: float) -> float:
    """Acceleration of the measured motion, or of a turn in one length [m/s2]; at least a hundredth of gravity."""
    speed = np.hypot(columns["u"], columns.get("v", 0.0))
    parts = [speed**2 / length, *(np.abs(columns[name]) for name in ("udot", "vdot") if name in columns)]
    parts += [length * np.abs(columns["rdot"])] if "rdot" in columns else []
    return max(float(np.mean(sum(parts))), GRAVITY / 1e4)


def check_drift(columns: Columns, by_name: Mapping[str, Column], table: str) -> None:
    """Raise if steady rows go sideways along the canal by twice their drift: heading or sway is reversed."""
    if not {"u", "v", "psi"} <= columns.keys():
        return
    steady = np.ones(len(columns["u"]), bool)
    for name in ("r", "udot", "vdot", "rdot"):
        steady &= np.abs(columns.get(name, 0.0)) < settings.STEADY_RATE
    from_heading = (columns["u"] * np.sin(columns["psi"]))[steady]
    from_sway = (columns["v"] * np.cos(columns["psi"]))[steady]
    drifts = np.abs(from_heading) > settings.LEAST_LEEWAY * np.abs(columns["u"][steady])
    if drifts.any() and np.allclose(from_heading[drifts], from_sway[drifts], rtol=0.1):
        heading, sway = (repr(by_name[name].header) for name in ("psi", "v"))
        raise InputError(
            f"{table}: straight runs go across the canal at twice their drift; turn the sign of {heading} or of {sway} "
            "(heading clockwise from above, sway to starboard)"
        )


DEGREE = math.pi / 180
# Columns that determine the rate of each column.
RATES = {"y": ("u", "v", "psi"), "psi": ("r",), "u": ("udot",), "v": ("vdot",), "r": ("rdot",)}
SAYS = {"y": "what u, v and psi say", "psi": "r", "u": "udot", "v": "vdot", "r": "rdot"}

# Columns whose signs are reversed together, the fewest first.
MIRRORED = (
    ("y",), ("psi",), ("v",), ("r",), ("vdot",), ("rdot",), ("udot",), ("psi", "r"), ("r", "rdot"), ("v", "vdot"),
    ("psi", "r", "rdot"), ("y", "v", "vdot"),
)  # fmt: skip

TURNING = (("psi",), ("r",), ("rdot",), ("psi", "r"), ("r", "rdot"), ("psi", "r", "rdot"))
MOVING = (("y",), ("u",), ("v",), ("vdot",), ("udot",), ("v", "vdot"), ("u", "v"), ("u", "v", "udot", "vdot"))

# Columns that are in another unit together: how many of the first unit one of the second is.
UNITS = (
    *((names, DEGREE, "rad", "deg") for names in TURNING), *((names, 1 / DEGREE, "deg", "rad") for names in TURNING),
    *((names, 1e-3, "m", "mm") for names in MOVING),
    *((names, 0.514444, "m/s", "kn") for names in (("u",), ("v",), ("u", "v"))),
    (("t",), 1e-3, "s", "ms"), (("t",), 60.0, "s", "minute"),
)  # fmt: skip


class Agreement(NamedTuple):
    """Agreement of a column's changes with its rate, one number per test."""

    correlation: np.ndarray  # (tests,) Correlation of the two [1]
    factor: np.ndarray  # (tests,) The column's change relative to its rate; 0 if a test carries no information [1]

    @property
    def alike(self) -> np.ndarray:
        """Tests in which the two are the same motion up to size or sign, (tests,) of bool."""
        return np.asarray((self.factor > 0) & (np.abs(self.correlation) > settings.LEAST_CORRELATION))

    @property
    def apart(self) -> np.ndarray:
        """Tests that contradict it, (tests,) of bool."""
        far = (
            (self.correlation < 0)
            | (self.factor > settings.SLOPE_TOLERANCE)
            | (self.factor < 1 / settings.SLOPE_TOLERANCE)
        )
        return np.asarray(self.alike & far)


class MotionColumns(NamedTuple):
    columns: Columns  # (rows,) Columns meant to be in SI, test by test
    starts: np.ndarray  # (tests + 1,) First row of each test, and the number of rows
    length: float  # Length of the ship [m]

    def only(self, tests: np.ndarray) -> "MotionColumns":
        rows = np.diff(self.starts)
        kept = np.repeat(tests, rows)
        starts = np.concatenate([[0], np.cumsum(rows[tests])])
        return self._replace(columns={name: column[kept] for name, column in self.columns.items()}, starts=starts)


def check_axes(motions: MotionColumns, table: str) -> None:
    """Raise if u and v are the velocities along and across the canal, not those in the axes of a ship that yaws."""
    columns = motions.columns
    if not {"t", "y", "psi", "u", "v"} <= columns.keys():
        return
    u, v, psi, lapses = columns["u"], columns["v"], columns["psi"], _lapses(motions, {})
    known = lapses > 0
    if not known.any():
        return
    own, canal = (
        float(np.std((np.diff(columns["y"]) - 0.5 * (rate[1:] + rate[:-1]) * lapses)[known]))
        for rate in (u * np.sin(psi) + v * np.cos(psi), v)
    )
    if own > 4 * canal and own > settings.LEAST_LEEWAY * float(np.mean(np.abs(u[1:] * lapses)[known])):
        raise InputError(
            f"{table}: dy/dt is v, not u sin(psi) + v cos(psi), so u and v are along and across the canal; give those "
            "in the ship's axes, u cos(psi) + v sin(psi) and v cos(psi) - u sin(psi), and their rates or none"
        )


def check_kinematics(
    motions: MotionColumns, names: Iterable[str], by_name: Mapping[str, Column], table: str
) -> tuple[str, ...]:
    """Raise if a column has the wrong sign or unit; return other disagreements."""
    agreements = kinematic_consistency(motions)
    wrong = sum((agreement.apart for agreement in agreements.values()), np.zeros(1, bool)) > 0
    if not wrong.any():
        return ()
    sentence = _disagreement(agreements, [name for name, bad in zip(names, wrong, strict=True) if bad])
    for some in (motions, motions.only(wrong)):
        agreement = kinematic_consistency(some)
        if causes := _turned_round(some, agreement, by_name) or _in_another_unit(some, agreement, by_name):
            raise InputError(f"{table}: {sentence}; {causes}")
    return (f"{sentence[0].upper()}{sentence[1:]}: check these columns.",)


def kinematic_consistency(motions: MotionColumns) -> dict[str, Agreement]:
    """Compare the changes of each column with its rate, by column."""
    rates = {name: rate for name, rate in rates_of(motions.columns).items() if _moves(motions, name)}
    lapses = _lapses(motions, rates)
    return {name: _agreement(motions.columns[name], rate, lapses, motions.starts) for name, rate in rates.items()}


def rates_of(columns: Columns) -> dict[str, np.ndarray]:
    """Return the rates of columns computed from other columns, midway between rows, (rows - 1,)."""
    known = [name for name, asked in RATES.items() if {name, *asked} <= columns.keys()]
    rates = {
        name: columns["u"] * np.sin(columns["psi"]) + columns["v"] * np.cos(columns["psi"])
        if name == "y"
        else columns[RATES[name][0]]
        for name in known
    }
    return {name: 0.5 * (rate[1:] + rate[:-1]) for name, rate in rates.items()}


def _moves(motions: MotionColumns, name: str) -> bool:
    """Return whether a column varies by more than a carriage's vibration."""
    speed = float(np.abs(motions.columns.get("u", np.ones(1))).mean())
    least = {"y": motions.length, "psi": 1.0, "u": speed, "v": speed, "r": speed / motions.length}[
        name
    ] * settings.SHAKE
    return bool(np.std(motions.columns[name]) > least)


def _lapses(motions: MotionColumns, rates: Columns) -> np.ndarray:
    """Time between rows [s]: from t, from the path, or constant of unknown size; 0 if unknown."""
    columns, starts = motions.columns, motions.starts
    inside = np.ones(int(starts[-1]) - 1, bool)
    inside[starts[1:-1] - 1] = False
    if "t" in columns:
        return _without_gaps(np.diff(columns["t"]), inside, starts)
    if {"x", "u", "v", "psi"} <= columns.keys():
        ahead = columns["u"] * np.cos(columns["psi"]) - columns["v"] * np.sin(columns["psi"])
        with np.errstate(all="ignore"):
            lapses = np.abs(2 * np.diff(columns["x"]) / (ahead[1:] + ahead[:-1]))
        if (lapses[inside] > 0).all() and np.isfinite(lapses[inside]).all():
            return _without_gaps(lapses, inside, starts)
    return _even(columns, starts, rates, inside)


def _without_gaps(lapses: np.ndarray, inside: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Leave out steps between tests, and those over excluded rows."""
    known = np.where(inside, lapses, 0.0)
    usual = np.repeat([np.median(known[a : b - 1]) if b - a > 1 else 0.0 for a, b in pairwise(starts)], np.diff(starts))
    return np.where(known > settings.ROW_GAP * usual[:-1], 0.0, known)


def _even(columns: Columns, starts: np.ndarray, rates: Columns, inside: np.ndarray) -> np.ndarray:
    """Constant time between rows in each test, the median over its columns; 0 if only one column determines it."""
    seen = [_agreement(columns[name], rate, inside * 1.0, starts) for name, rate in rates.items()]
    if not seen:
        return inside * 1.0
    told = np.array([np.where(one.alike, one.factor, np.nan) for one in seen])
    enough = np.isfinite(told).sum(axis=0) >= settings.FEWEST_RATES
    step = np.array(
        [np.nanmedian(factors) if several else 0.0 for factors, several in zip(told.T, enough, strict=True)]
    )
    return np.asarray(inside * np.repeat(step, np.diff(starts))[:-1])


def _agreement(column: np.ndarray, rate: np.ndarray, lapses: np.ndarray, starts: np.ndarray) -> Agreement:
    """Compare over stretches of each test; a test of few stretches, or of small changes, carries no information."""
    ends = [start + cuts(int(stop - start) - 1, settings.STRETCHES) for start, stop in pairwise(starts)]
    edges, count = np.concatenate(ends), len(ends)
    test = np.repeat(np.arange(count), [len(edge) for edge in ends])
    way, unknown = (np.concatenate([[0.0], np.cumsum(column_of)])[edges] for column_of in (rate * lapses, lapses == 0))
    whole = np.diff(unknown) == 0
    whose, change, expected = test[1:][whole], np.diff(column[edges])[whole], np.diff(way)[whole]
    cc, ee, ce = (np.bincount(whose, product, count) for product in (change**2, expected**2, change * expected))
    rows = np.bincount(whose, minlength=count)
    told = (rows >= settings.FEWEST_STRETCHES) & (
        np.minimum(_strong(cc, rows), _strong(ee, rows)) > settings.FAINT_SHARE**2
    )
    with np.errstate(all="ignore"):
        return Agreement(np.where(told, ce / np.sqrt(cc * ee), 0.0), np.where(told, np.sqrt(cc / ee), 0.0))


def _strong(squares: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Mean square of each test relative to the largest."""
    mean = squares / np.maximum(rows, 1)
    return np.asarray(mean / max(mean.max(), 1e-300))


def _disagreement(agreements: Mapping[str, Agreement], tests: list[str]) -> str:
    """Describe the disagreement, with the numbers of the first informative test."""
    parts = []
    for name, agreement in agreements.items():
        if agreement.apart.any():
            i = int(np.argmax(agreement.apart))
            parts.append(
                f"d{name}/dt is {math.copysign(agreement.factor[i], agreement.correlation[i]):.2g} times {SAYS[name]}"
            )
    others = f" and {len(tests) - 1} more" if len(tests) > 1 else ""
    return f"in test {tests[0]}{others}, {' and '.join(parts)}"


def _turned_round(motions: MotionColumns, agreements: Mapping[str, Agreement], by_name: Mapping[str, Column]) -> str:
    """Describe the fewest columns that agree with all others after a change of sign."""
    mended = [names for names in MIRRORED if _mends(motions, agreements, dict.fromkeys(names, -1.0))]
    fewest = [names for names in mended if len(names) == len(mended[0])]
    if not fewest:
        return ""
    choices = ", or ".join(_listed(names, by_name) for names in fewest)
    return f"turn the sign of {choices} (y and v count to starboard, angles clockwise from above)"


def _in_another_unit(motions: MotionColumns, agreements: Mapping[str, Agreement], by_name: Mapping[str, Column]) -> str:
    """Describe the fewest columns that agree with all others in another unit."""
    mended = [
        (names, usual, unit)
        for names, scale, usual, unit in UNITS
        # A header with a unit may be wrong only if that is not the usual one.
        if all(name in by_name and by_name[name].stated == (unit == "rad") for name in names)
        and _mends(motions, agreements, dict.fromkeys(names, scale))
    ]
    fewest = min((len(names) for names, _, _ in mended), default=0)
    parts = []
    for names, usual, unit in (mend for mend in mended if len(mend[0]) == fewest):
        units = [COLUMNS[name].unit.replace(usual, unit, 1) if unit != "rad" else COLUMNS[name].unit for name in names]
        heads = " and ".join(f"'{name} [{spelled}]'" for name, spelled in zip(names, units, strict=True))
        parts.append(f"{_listed(names, by_name)} {'look' if len(names) > 1 else 'looks'} like {units[0]}; head {heads}")
    return ", or ".join(parts)


def _mends(motions: MotionColumns, agreements: Mapping[str, Agreement], scales: Mapping[str, float]) -> bool:
    """Return whether all columns agree once some are scaled, with no fewer informative tests."""
    columns = motions.columns
    if not columns.keys() >= scales.keys():
        return False
    again = kinematic_consistency(
        motions._replace(columns={**columns, **{n: columns[n] * k for n, k in scales.items()}})
    )
    return all(
        name in again and not again[name].apart.any() and again[name].alike.sum() >= agreement.alike.sum()
        for name, agreement in agreements.items()
    )


def _listed(names: tuple[str, ...], by_name: Mapping[str, Column]) -> str:
    headers = [repr(by_name[name].header) if name in by_name else repr(name) for name in names]
    return " and ".join([", ".join(headers[:-1]), headers[-1]] if len(headers) > 1 else headers)
