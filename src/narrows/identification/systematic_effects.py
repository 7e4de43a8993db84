"""Errors that several runs share, each with a name, a unit and a usual size: the random effects of the mixed model."""

from dataclasses import dataclass

import numpy as np

from narrows.identification.design_matrix import ONE
from narrows.identification.force_rows import ForceRows
from narrows.identification.mixed_model import BlockErrors, MixedModel
from narrows.identification.run_errors import RunErrors
from narrows.quantities.names import FORCES
from narrows.ship.particulars import Configuration

DEGREE = np.pi / 180
# Groups of effects; those of a group share one learned scale, so that rival explanations count alike.
DAMPING, INERTIA, HULL, BANK, SHAPE = "damping", "inertia", "hull form", "bank form", "bank shape"
WITH_OFFSET = "with offset"
TYPES, STRAIGHT, CAMPAIGN, CLOCK = "types of run", "straight runs", "campaign", "clock"
SETTLING, CROSSTALK = "settling", "crosstalk"
# Effects whose columns hold measured forces: learning their scale would explain the forces by themselves.
FIXED = "fixed"
OF_A_CAMPAIGN = (TYPES, STRAIGHT, CAMPAIGN, WITH_OFFSET, CLOCK, SETTLING, CROSSTALK, FIXED)
# Usual sizes, by which the scales' priors are stated: shares of a term or of a force's level, or the effect's unit.
SIZES = {
    "damping by speed": 0.3, "damping by period": 0.05, "damping by depth": 0.3,  # power, per octave, power
    "inertia by speed": 0.04, "inertia by period": 0.05, "inertia by depth": 0.2,
    "damping in straight runs": 0.02, "other hull terms": 0.01, "walls": 0.005,
    "bank form": 0.004, "type of run": 0.004, "bank lag": 0.05, "straight zero": 0.01, "straight offset": 0.004,
    "heading": 0.03, "rail": 0.003, "clock": 0.02, "crosstalk": 0.001, "common zero": 0.005, "side force": 0.005,
    "settling": 0.01, "curvature": 0.001, "mount": 0.0025,
    "force with y": 0.0003, "heading with y": 0.004, "rudder with y": 0.02, "crossflow with y": 0.01,
}  # fmt: skip
# Degrees of freedom of the half-t priors where they are not the usual ones: few where an error may be large.
FREEDOM = {TYPES: 1.5, HULL: 2.0, BANK: 2.0, SHAPE: 2.0, WITH_OFFSET: 5.0, SETTLING: 2.0, CROSSTALK: 4.0}
USUAL_FREEDOM = 3.0
# Groups that may mimic a coefficient, or another of these groups.
RIVALS = (f"{INERTIA} by speed", f"{INERTIA} by period", SHAPE, BANK, TYPES, WITH_OFFSET, SETTLING, CROSSTALK)
# Trends of less than this, in logarithms or octaves, count as one level.
ONE_LEVEL = 0.05
# Side force of a usual rudder [N] per degree at 1 m/s, over density x L x T: area LT/48, slope of the normal force
# 2.45, times 1.3 with the pressure on the hull.
RUDDER = 0.5 / 48 * 2.45 * 1.3 * DEGREE
# Root mean square of a sine over its amplitude's half: offsets at which other forms of the bank are as large as it.
TYPICAL = 1.5
# Singular value of columns of unit size, over the largest, below which they are one column.
COLLINEAR = 1e-3
# Sizes that no laboratory overlooks, by unit; a force or a zero may be all of the measured force.
LARGEST_SIZES = {"%": 50.0, "m": 0.3, "s": 3.0, "deg": 5.0, "cm/s": 10.0}
# Change of a force, over its level, up to which it is proportional to a delay or rotation. Beyond it, on twins, also
# coefficients without a linear response change (decisions/trust_campaign.py).
LINEAR = 0.04
CLOCKS, MOUNT = "delay between clocks", "compliance of the mount"
BENT = (CLOCKS, MOUNT)


@dataclass(frozen=True)
class Effect:
    """An error that several runs share."""

    name: str
    unit: str
    usual: float  # size in that unit
    group: str
    most: float = np.inf  # size that no laboratory overlooks
    linear: float = np.inf  # size up to which forces follow it in proportion

    @property
    def learned(self) -> bool:
        """True where the tests determine its size."""
        return self.group != FIXED

    @property
    def has_usual_size(self) -> bool:
        """True if laboratories know its usual size, so that it has a tipping point."""
        return self.group in OF_A_CAMPAIGN and bool(self.unit)


class Effects:
    """Effects and their columns, in the rows of every force."""

    def __init__(self, rows: ForceRows, errors: RunErrors, configuration: Configuration) -> None:
        self.rows, self.configuration = rows, configuration
        self.effects: list[Effect] = []
        self.columns: list[np.ndarray] = []
        self.share = dict.fromkeys((HULL, DAMPING, INERTIA), errors.hull)
        self.share |= {BANK: errors.bank, SHAPE: errors.bank}
        self.campaign = errors.campaign
        if not errors.none:
            self._hull()
        if not errors.none and rows.blocks.forces != ("X",):
            self._bank()
            self._with_offset()
            self._motion()
            self._gauges()

    def add(self, name: str, column: np.ndarray, usual: float, group: str, unit: str = "") -> None:
        """Add an effect by the column of one unit of it; one without force is left out."""
        usual *= self.share.get(group.split(" by ")[0], self.campaign)
        if usual > 0 and np.abs(column).max(initial=0.0) > 0:
            whole = 1 / self._share(column)
            most, linear = LARGEST_SIZES.get(unit.split(" ")[0], whole), LINEAR * whole if name in BENT else np.inf
            self.effects.append(Effect(name, unit, usual, group, most, linear))
            self.columns.append(column * usual)

    def _share(self, column: np.ndarray) -> float:
        """Largest root mean square of a column over the level of its force."""
        rows = self.rows
        parts = zip(column.reshape(rows.count, -1), rows.blocks.level, strict=True)
        return float(max(rows.rms(part) / level for part, level in parts))

    def _hull(self) -> None:
        """Hull terms that change with speed, period and depth, in straight runs, or are of another form."""
        rows = self.rows
        trends = {"speed": rows.speeds, "period": rows.octaves, "depth": rows.depths}
        for f, term in rows.terms:
            if term.from_bank:
                continue
            slope = rows.of(f, rows.raw(term.name) * rows.size(f, term))
            kind = INERTIA if any(name.endswith("dot") for name in term.inputs) else DAMPING
            for name, trend in trends.items():
                self._trend(f"{term.name} with {name}", slope, rows.all(trend), f"{kind} by {name}")
            if rows.mixed and kind == DAMPING:
                still = slope * rows.all(rows.steady)
                self.add(f"{term.name} in straight runs", still, SIZES["damping in straight runs"], HULL)
        for f in self._lateral():
            for name in ("v3", "r3", "|r|v", "|v|r"):
                self._scaled(f, name, SIZES["other hull terms"], HULL)
            for name in ("v y2", "r y2"):
                self._scaled(f, name, SIZES["walls"], HULL)

    def _lateral(self) -> list[int]:
        """Forces that a side force, an offset or another hull form changes: sway and yaw."""
        return [f for f, force in enumerate(self.rows.blocks.forces) if force != "X"]

    def _trend(self, name: str, slope: np.ndarray, trend: np.ndarray, group: str) -> None:
        """A term that changes along a trend, and along its square where there are three levels."""
        if np.ptp(trend) < ONE_LEVEL:
            return
        self.add(name, slope * trend, SIZES[group], group)
        if len(np.unique(np.round(trend / ONE_LEVEL))) > 2:
            self.add(f"{name} squared", slope * trend**2, SIZES[group] / 2, group)

    def _scaled(self, f: int, name: str, usual: float, group: str) -> None:
        """A column scaled to the force's level."""
        rows = self.rows
        column = rows.raw(f"column {name}")
        rms = rows.rms(column)
        if rms > 1e-9:
            level = rows.blocks.level[f]
            self.add(f"{name} in {rows.blocks.forces[f]}", rows.of(f, column / rms * level), usual, group)

    def _bank(self) -> None:
        """A bank of another form, one that differs by side, speed or type of run, and one that lags."""
        rows = self.rows
        typical = max(TYPICAL * rows.rms(rows.raw("column y")), 1e-9)
        for f, term in rows.terms:
            if not term.from_bank:
                continue
            size, own = rows.size(f, term), rows.raw(term.name)
            # All are zero at the centreline and in straight runs: there the coefficient is what it is called.
            forms = {
                "as y2": rows.raw(f"near of {term.name}") / typical**2,
                "as y6": rows.raw(f"wall of {term.name}") / typical**6,
                "as the root of y": rows.raw(f"far of {term.name}") / np.sqrt(typical),
                "by side": rows.raw(f"side of {term.name}"),
                "with depth": own * rows.depths * (np.ptp(rows.depths) > ONE_LEVEL),
                "with speed": own * rows.speeds * (np.ptp(rows.speeds) > ONE_LEVEL),
            }
            for name, column in forms.items():
                group = SHAPE if name.startswith("as") else BANK
                self.add(f"{term.name} {name}", rows.of(f, column * size), SIZES["bank form"], group)
            harmonic = rows.of(f, own * (1 - rows.steady) * size) / 100
            self.add(f"{term.name} in harmonic runs", harmonic, 100 * SIZES["type of run"], TYPES, "%")
            lag = rows.of(f, rows.raw(f"time of {term.name}") * size)
            self.add(f"lag of {term.name}", lag, SIZES["bank lag"], STRAIGHT, "s")

    def _with_offset(self) -> None:
        """Effects that vary with the offset as a bank does: a cable, a trimmed heading or rudder, a crossflow."""
        rows, place = self.rows, f"at {self.rows.reach:.2g} m"
        speed = float(np.median(rows.speed))
        powers: dict[str, tuple[str, float]] = {
            "y": ("force proportional to y", 1.0),
            "y u": ("force proportional to y u", speed),
            "y u2": ("force proportional to y u2", speed**2),
            "y2 u2": ("force proportional to y2 u2", speed**2 * rows.reach),
        }
        for f in self._lateral():
            force = rows.blocks.forces[f]
            unit = f"{FORCES[force].unit} {place}"
            usual = SIZES["force with y"] * rows.blocks.level[f]
            for name, (words, scale) in powers.items():
                column = rows.of(f, rows.raw(f"column {name}") / (scale * rows.reach))
                self.add(f"{words} in {force}", column, usual, WITH_OFFSET, unit)
        turned = (rows.shift("heading with y") + self._unexcited_sway(rows.raw("column y u2"))) / rows.reach
        self.add("heading proportional to y", turned * DEGREE, SIZES["heading with y"], WITH_OFFSET, f"deg {place}")
        across = turned / rows.all(rows.speed) * 0.01
        self.add("crossflow proportional to y", across, SIZES["crossflow with y"], WITH_OFFSET, f"cm/s {place}")
        self._rudder(rows.raw("column y u2") / rows.reach, f"deg {place}")

    def _unexcited_sway(self, column: np.ndarray) -> np.ndarray:
        """Force of a heading of one radian on a usual hull, for tests without sway."""
        # Clarke, Gedling, Hine (1983): Y'v about pi T/L + 1.4 CB B/L. N'v is 0.14 to 0.41 in tests of KCS and DTC.
        rows, ship = self.rows, self.configuration.ship
        if np.abs(rows.shift("heading")).max(initial=0.0) > 0 and rows.rms(rows.raw("column v")) > 1e-6:
            return np.zeros(rows.each * rows.count)
        sway = np.pi * ship.draft / ship.length + 1.4 * ship.block_coefficient * ship.beam / ship.length
        slopes = {"Y": sway, "N": 0.35 * ship.length}
        size = 0.5 * self.configuration.water.density * ship.length * ship.draft
        parts = [rows.of(f, slopes.get(force, 0.0) * size * column) for f, force in enumerate(rows.blocks.forces)]
        return np.asarray(sum(parts))

    def _rudder(self, along: np.ndarray, unit: str) -> None:
        ship, rows = self.configuration.ship, self.rows
        force = RUDDER * self.configuration.water.density * ship.length * ship.draft * along
        levers = {"Y": 1.0, "N": -ship.length / 2}
        column = sum(rows.of(f, levers.get(name, 0.0) * force) for f, name in enumerate(rows.blocks.forces))
        self.add("rudder angle proportional to y", np.asarray(column), SIZES["rudder with y"], WITH_OFFSET, unit)

    def _motion(self) -> None:
        """Errors of the motion: heading, rail, clock, mount."""
        rows = self.rows
        turned = (rows.shift("heading") + self._unexcited_sway(rows.raw("column u2"))) * DEGREE
        moved = rows.shift("rail")
        still, side = rows.all(rows.steady) * rows.mixed, rows.all(rows.steady * rows.side)
        self.add("heading", turned, SIZES["heading"], CAMPAIGN, "deg")
        self.add("heading of straight runs", turned * still, SIZES["heading"], CAMPAIGN, "deg")
        self.add("heading of straight runs by side", turned * side, SIZES["heading"] / 2, CAMPAIGN, "deg")
        self.add("offset of the rail", moved, SIZES["rail"], CAMPAIGN, "m")
        self.add("offset of straight runs by side", moved * side, SIZES["straight offset"], TYPES, "m")
        self.add(CLOCKS, rows.rate(), SIZES["clock"], CLOCK, "s")
        if "N" in rows.names:
            given = (rows.shift("mount") + self._unexcited_sway(rows.raw("N") * rows.speed**2)) * DEGREE / 20
            self.add(MOUNT, given, SIZES["mount"], FIXED, "deg per 20 N m")

    def _gauges(self) -> None:
        """Errors of the gauges that all runs share, and a side force of the hull."""
        rows = self.rows
        fitted, early = rows.fitted(rows.blocks.columns), rows.fitted(rows.blocks.early)
        for f, (force, level) in enumerate(zip(rows.blocks.forces, rows.blocks.level, strict=True)):
            one, unit = rows.of(f, rows.raw(ONE)), FORCES[force].unit
            self.add(f"zero of {force}", one, SIZES["common zero"] * level, CAMPAIGN, unit)
            if rows.mixed:
                still = rows.all(rows.steady)
                usual = SIZES["straight zero"] * level
                self.add(f"zero of {force} in straight runs", one * still, usual, STRAIGHT, unit)
                gain = rows.of(f, fitted[f]) * still / 100
                self.add(f"gain of {force} in straight runs", gain, 100 * SIZES["type of run"], TYPES, "%")
            self.add(f"settling of {force}", rows.of(f, early[f]), SIZES["settling"], SETTLING)
            if f in self._lateral():
                self._scaled(f, "u2", SIZES["side force"], CAMPAIGN)
            curved = rows.of(f, rows.raw(f"column |{force}|{force}") / (2 * level)) / 100
            self.add(f"curvature of the gauge of {force}", curved, 100 * SIZES["curvature"], FIXED, "%")
            for g, other in enumerate(rows.blocks.forces):
                if g != f:
                    leak = rows.of(f, fitted[g] * level / rows.blocks.level[g]) / 100
                    self.add(f"crosstalk of {other} into {force}", leak, 100 * SIZES["crosstalk"], CROSSTALK, "%")


def assemble(
    rows: ForceRows, errors: RunErrors, configuration: Configuration
) -> tuple[MixedModel, list[Effect], np.ndarray]:
    """The mixed model of some forces, its effects, and the unit of each scaled coefficient."""
    found = Effects(rows, errors, configuration)
    groups = list(dict.fromkeys(effect.group for effect in found.effects if effect.learned))
    unit = rows.units()
    x = np.column_stack([rows.x * unit, *found.columns])
    bank = SIZES["bank form"] * errors.bank * (not errors.none)
    scatter = 0.0 if errors.none else errors.scatter
    runs = [errors.gain, bank, scatter, *[errors.form] * rows.count, *[errors.zero] * rows.count]
    places = {name: len(runs) + i for i, name in enumerate([*groups, FIXED])}
    group = np.array([places[effect.group] for effect in found.effects], int)
    prior = np.array([*runs, *[1.0] * len(groups)])
    freedom = np.array([USUAL_FREEDOM] * len(runs) + [FREEDOM.get(name, USUAL_FREEDOM) for name in groups])
    rivals = tuple(places[name] for name in RIVALS if name in places)
    taken = _taken(rows, x, found.effects)
    model = MixedModel(x, rows.y, len(rows.free_parameters), group, _block_errors(rows), prior, freedom, rivals, taken)
    return model, found.effects, unit


def _taken(rows: ForceRows, x: np.ndarray, effects: list[Effect]) -> np.ndarray:
    """Regression of the effects on the hull terms, with equal weight of each motion: (coefficients, effects).

    A hull coefficient is the one that fits the forces on the hull best; a bank's is the slope at the centreline.
    """
    p = len(rows.free_parameters)
    hull = np.array(sorted({rows.place(term) for _, term in rows.terms if not term.from_bank}), int)
    changes = np.array([effect.group.split(" by ")[0] in (DAMPING, INERTIA, HULL) for effect in effects], bool)
    taken = np.zeros((p, len(effects)))
    scaled = x * rows.weights()[:, None]
    a = scaled[:, hull]
    size = np.sqrt((a**2).sum(axis=0))
    size = np.where(size > COLLINEAR * size.max(initial=0.0), size, np.inf)
    taken[np.ix_(hull, changes)] = np.linalg.pinv(a / size, rcond=COLLINEAR) @ scaled[:, p:][:, changes] / size[:, None]
    return taken


def _block_errors(rows: ForceRows) -> BlockErrors:
    blocks, count = rows.blocks, rows.count
    one = np.outer(blocks.level, blocks.reference[:, rows.names[ONE]])
    fitted, bank = rows.fitted(blocks.reference), rows.fitted(blocks.reference, bank=True)
    shapes = np.column_stack([fitted.ravel(), bank.ravel(), one.ravel()])
    measured = [blocks.reference[:, rows.names[force]] for force in blocks.forces]
    # A form error spreads half along the force itself and half over all directions.
    form = [0.5 * np.add.reduceat(force**2, blocks.starts) / blocks.sizes for force in measured]
    share = rows.length[blocks.starts] ** 2 / blocks.sizes / blocks.runs
    return BlockErrors(
        starts=np.concatenate([blocks.starts + f * rows.each for f in range(count)]),
        shapes=shapes,
        noise=np.concatenate([noise / blocks.runs for noise in blocks.noise]),
        form=np.concatenate(form),
        scatter=np.outer(blocks.level**2, share).ravel(),
        runs=np.tile(blocks.runs, count),
        is_mean=np.tile(blocks.is_mean, count),
        form_scale=np.repeat(3 + np.arange(count), len(blocks.runs)),
        zero_scale=np.repeat(3 + count + np.arange(count), len(blocks.runs)),
    )
