"""Checks of a table, its kinematic consistency among them: one sentence with file, row, column and remedy.

Each motion is the rate of another, and a mistake in one has a sign or a unit.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd

from narrows.base.errors import InputError
from narrows.captive import settings
from narrows.captive.columns import COLUMNS
from narrows.captive.tests import cuts
from narrows.model.water import displacement
from narrows.physics.squat_and_depth import critical_speed
from narrows.quantities.names import DEGREE, GRAVITY, KNOT
from narrows.readers.cells import Column, row_number
from narrows.ship.particulars import Configuration, half_swept

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


def check_time(frame: pd.DataFrame, names: Sequence[str], starts: np.ndarray, t: np.ndarray, table: str) -> None:
    """Raise if time stands still or runs back inside a test."""
    stuck = np.diff(t, prepend=t[0]) <= 0
    stuck[starts[:-1]] = False
    if stuck.any():
        i = int(np.argmax(stuck))
        test = names[int(np.searchsorted(starts, i, side="right")) - 1]
        fault = "repeats the time of the row above" if t[i] == t[i - 1] else "goes back in time"
        remedy = "leave one out" if t[i] == t[i - 1] else "sort it by time"
        if t[i] < t[i - 1] and frame.duplicated().iloc[i]:
            fault, remedy = "begins rows that stand above already", "leave the second ones out"
        remedy = remedy if "test" in frame else f"{remedy}, or name the tests in a column 'test'"
        place = f"{table}: row {row_number(frame, stuck)}, column 't'"
        raise InputError(f"{place} {fault} (test {test}, t = {t[i]:g} s); {remedy}")


def check_heading(table: CheckedColumns) -> None:
    """Raise if the ship lies across the canal, or the heading looks like degrees."""
    psi = table.columns["psi"]
    across = np.abs(psi) >= math.pi / 2
    if not across.any():
        return
    place, value = table.place("psi", across), psi[int(np.argmax(across))]
    remedy = "the model holds for |psi| < 90 deg; leave such rows out: --where 'abs(psi_deg) < 90'"
    if table.is_bare("psi"):
        remedy = "head the column 'psi [deg]', or give its unit in the --mapping file: [units] psi = \"deg\""
        raise InputError(f"{place} = {value:g} rad looks like degrees; {remedy}")
    raise InputError(f"{place} is a heading of {math.degrees(value):.1f} deg; {remedy}")


def check_inside(table: CheckedColumns) -> None:
    """Raise if a hull corner touches or crosses a bank."""
    columns, ship = table.columns, table.configuration.ship
    if not {"y", "psi"} <= columns.keys():
        return
    y, width = columns["y"], columns.get("width", table.configuration.canal.width)
    reach = np.abs(y) + half_swept(ship, columns["psi"])
    half = np.broadcast_to(np.asarray(width) / 2, y.shape)
    touching = reach >= half
    if not touching.any():
        return
    first = int(np.argmax(touching))
    remedy = "check y, psi, their units and the ship file"
    if (np.abs(y) < 2 * half).all() and (np.all(y > 0) or np.all(y < 0)):
        middle = f"half the width, {half[first]:g} m"
        remedy = f"if it counts from a bank, count it from the middle: {'subtract' if y[0] > 0 else 'add'} {middle}"
        remedy += f" (from a bank to starboard, take it from {half[first]:g} m)" * bool(y[0] > 0)
    elif table.is_bare("y") and (np.abs(y) / 1e3 + reach - np.abs(y) < half).all():
        remedy = "head it 'y [mm]' if that is its unit"
    bank = f"the bank of a canal {2 * half[first]:g} m wide"
    raise InputError(f"{table.place('y', touching)} = {y[first]:g} m puts the hull on {bank}; {remedy}")


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


# Columns that determine the rate of each column.
RATES = {
    "x": ("u", "v", "psi"), "y": ("u", "v", "psi"), "psi": ("r",), "u": ("udot",), "v": ("vdot",), "r": ("rdot",),
}  # fmt: skip
TURNING = ("psi", "r", "rdot", "psi r", "r rdot", "psi r rdot")
MOVING = ("x", "y", "x y", "u", "v", "vdot", "udot", "v vdot", "u v", "u v udot vdot")
SPEEDS = ("u", "v", "u v")
SI = ("rad", "m/s")
# Columns whose signs are reversed together, the fewest first.
MIRRORED = (*TURNING, "y", "v", "vdot", "udot", "v vdot", "y v vdot")
# Columns that are in another unit together: how many of the first unit one of the second is. A header with a unit is
# wrong only if the column is in SI.
UNITS = (
    *((names, DEGREE, "rad", "deg") for names in TURNING), *((names, 1 / DEGREE, "deg", "rad") for names in TURNING),
    *((names, 1e-3, "m", "mm") for names in MOVING),
    *((names, KNOT, "m/s", "kn") for names in SPEEDS), *((names, 1 / KNOT, "kn", "m/s") for names in SPEEDS),
    ("t", 1e-3, "s", "ms"), ("t", 60.0, "s", "minute"),
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
        most = settings.SLOPE_TOLERANCE
        far = (self.correlation < 0) | (self.factor > most) | (self.factor < 1 / most)
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


def check_axes(motions: MotionColumns, agreements: Mapping[str, Agreement], table: str) -> None:
    """Raise if u and v are the velocities along and across the canal, not those in the axes of a ship that yaws."""
    columns = motions.columns
    if not {"t", "y", "psi", "u", "v"} <= columns.keys():
        return
    u, v, psi, lapses = columns["u"], columns["v"], columns["psi"], _lapses(motions)
    known, turning = lapses > 0, agreements.get("psi")
    if not known.any() or (turning and turning.apart.any()):  # A heading in degrees, which check_kinematics refuses
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
    motions: MotionColumns, agreements: Mapping[str, Agreement], names: Iterable[str], by_name: Mapping[str, Column],
    table: str,
) -> tuple[str, ...]:  # fmt: skip
    """Raise if a column has the wrong sign or unit; return other disagreements."""
    wrong = sum((agreement.apart for agreement in agreements.values()), np.zeros(1, bool)) > 0
    if not wrong.any():
        return ()
    sentence = _disagreement(agreements, [name for name, bad in zip(names, wrong, strict=True) if bad])
    causes = _causes(motions, agreements, by_name)
    if not causes:
        worst = motions.only(wrong)
        causes = _causes(worst, kinematic_consistency(worst), by_name)
    if causes:
        raise InputError(f"{table}: {sentence}; {causes}")
    return (f"{sentence[0].upper()}{sentence[1:]}: check these columns.",)


def kinematic_consistency(motions: MotionColumns) -> dict[str, Agreement]:
    """Compare the changes of each column with its rate, by column."""
    columns, length, lapses = motions.columns, motions.length, _lapses(motions)
    speed = float(np.abs(columns.get("u", np.ones(1))).mean())
    sizes = {"x": length, "y": length, "psi": 1.0, "u": speed, "v": speed, "r": speed / length}
    return {
        name: _agreement(columns[name], rate, lapses, motions.starts)
        for name, rate in rates_of(columns).items()
        if np.std(columns[name]) > sizes[name] * settings.SHAKE  # More than a carriage's vibration
    }


def rates_of(columns: Columns) -> dict[str, np.ndarray]:
    """Return the rates of columns computed from other columns, midway between rows, (rows - 1,)."""
    known = [name for name, asked in RATES.items() if {name, *asked} <= columns.keys()]
    rates = {name: columns[RATES[name][0]] for name in known}
    if "y" in known:
        rates["y"] = columns["u"] * np.sin(columns["psi"]) + columns["v"] * np.cos(columns["psi"])
    if "x" in known:
        rates["x"] = columns["u"] * np.cos(columns["psi"]) - columns["v"] * np.sin(columns["psi"])
    means = {name: 0.5 * (rate[1:] + rate[:-1]) for name, rate in rates.items()}
    # A carriage may count x to either end of the tank.
    return means | ({"x": np.copysign(means["x"], np.diff(columns["x"]))} if "x" in means else {})


def _lapses(motions: MotionColumns) -> np.ndarray:
    """Time between rows [s], from t or from the path; 0 if unknown."""
    columns, starts = motions.columns, motions.starts
    inside = np.ones(int(starts[-1]) - 1, bool)
    inside[starts[1:-1] - 1] = False
    lapses = np.zeros(len(inside))
    if "t" in columns:
        lapses = np.diff(columns["t"])
    elif {"x", "u", "v", "psi"} <= columns.keys():
        with np.errstate(all="ignore"):
            lapses = np.diff(columns["x"]) / rates_of(columns)["x"]
        if not ((lapses[inside] > 0) & np.isfinite(lapses[inside])).all():
            return np.zeros(len(inside))
    # Leave out steps between tests, and those over excluded rows.
    known = np.where(inside, lapses, 0.0)
    medians = [np.median(known[a : b - 1]) if b - a > 1 else 0.0 for a, b in pairwise(starts)]
    return np.where(known > settings.ROW_GAP * np.repeat(medians, np.diff(starts))[:-1], 0.0, known)


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
    mean = np.stack([cc, ee]) / np.maximum(rows, 1)  # Mean squares of each test
    strong = (mean / np.maximum(mean.max(axis=1, keepdims=True), 1e-300)).min(axis=0)
    enough = (rows >= settings.FEWEST_STRETCHES) & (strong > settings.FAINT_SHARE**2)
    with np.errstate(all="ignore"):
        return Agreement(np.where(enough, ce / np.sqrt(cc * ee), 0.0), np.where(enough, np.sqrt(cc / ee), 0.0))


def _disagreement(agreements: Mapping[str, Agreement], tests: list[str]) -> str:
    """Describe the disagreement, with the numbers of the first informative test."""
    parts = []
    for name, agreement in agreements.items():
        if agreement.apart.any():
            i = int(np.argmax(agreement.apart))
            said = "what u, v and psi say" if name in ("x", "y") else RATES[name][0]
            slope = math.copysign(agreement.factor[i], agreement.correlation[i])
            parts.append(f"d{name}/dt is {slope:.2g} times {said}")
    others = f" and {len(tests) - 1} more" if len(tests) > 1 else ""
    return f"in test {tests[0]}{others}, {' and '.join(parts)}"


def _causes(motions: MotionColumns, agreements: Mapping[str, Agreement], by_name: Mapping[str, Column]) -> str:
    """Describe the fewest columns that agree with all others after a change of sign, or else in another unit."""
    mended = [names for names in map(str.split, MIRRORED) if _mends(motions, agreements, dict.fromkeys(names, -1.0))]
    if mended:
        fewest = min(map(len, mended))
        choices = ", or ".join(_listed(names, by_name) for names in mended if len(names) == fewest)
        return f"turn the sign of {choices} (y and v count to starboard, angles clockwise from above)"
    in_units = {
        tuple(words.split()): (common, unit)
        for words, scale, common, unit in UNITS
        if all(name in by_name and by_name[name].stated == (unit in SI) for name in words.split())
        and _mends(motions, agreements, dict.fromkeys(words.split(), scale))
    }
    parts = []
    for names, (common, unit) in in_units.items():
        if len(names) > min(map(len, in_units)):
            continue
        units = [own if unit in SI else own.replace(common, unit, 1) for own in (COLUMNS[name].unit for name in names)]
        heads = " and ".join(f"'{name} [{own}]'" for name, own in zip(names, units, strict=True))
        parts.append(f"{_listed(names, by_name)} {'look' if len(names) > 1 else 'looks'} like {units[0]}; head {heads}")
    return ", or ".join(parts)


def _mends(motions: MotionColumns, agreements: Mapping[str, Agreement], scales: Mapping[str, float]) -> bool:
    """Return whether all columns agree once some are scaled, with no fewer informative tests."""
    columns = motions.columns
    if not columns.keys() >= scales.keys():
        return False
    scaled = {**columns, **{name: columns[name] * scale for name, scale in scales.items()}}
    again = kinematic_consistency(motions._replace(columns=scaled))
    return all(
        name in again and not again[name].apart.any() and again[name].alike.sum() >= agreement.alike.sum()
        for name, agreement in agreements.items()
    )


def _listed(names: Sequence[str], by_name: Mapping[str, Column]) -> str:
    headers = [repr(by_name[name].header) if name in by_name else repr(name) for name in names]
    return " and ".join([", ".join(headers[:-1]), headers[-1]] if len(headers) > 1 else headers)
