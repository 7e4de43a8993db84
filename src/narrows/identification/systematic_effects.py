"""Errors that several runs share, each with a name, a unit and a usual size: the random effects of the mixed model."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from itertools import chain

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.results import Aliased
from narrows.identification.mixed_model import MixedModel
from narrows.identification.motions import ForceRows
from narrows.identification.normal_equations import ONE
from narrows.quantities.names import DEGREE, FORCES
from narrows.ship.particulars import Configuration

# Groups of effects; those of a group share one learned scale, so that rival explanations count alike.
DAMPING, INERTIA, HULL, BANK, SHAPE = "damping", "inertia", "hull form", "bank form", "bank shape"
WITH_OFFSET = "with offset"
TYPES, STRAIGHT, CAMPAIGN, CLOCK = "types of run", "straight runs", "campaign", "clock"
SETTLING, CROSSTALK = "settling", "crosstalk"
# The groups of the hull's discrepancies, and their global scale: if the terms fit the forces, all of them are small.
HULL_GROUPS, DISCREPANCY = (DAMPING, INERTIA, HULL), "hull discrepancy"
# Effects whose columns hold measured forces: learning their scale would explain the forces by themselves.
FIXED = "fixed"
# Usual sizes, by which the scales' priors are stated: shares of a term or of a force's level, or the effect's unit.
SIZES = {
    "damping by speed": 0.3, "damping by period": 0.05, "damping by depth": 0.3,  # power, per octave, power
    "inertia by speed": 0.04, "inertia by period": 0.05, "inertia by depth": 0.2,
    "damping in straight runs": 0.02, "other hull terms": 0.01, "walls": 0.005,
    "bank form": 0.004, "type of run": 0.004, "bank lag": 0.05, "straight zero": 0.01, "straight offset": 0.004,
    "heading": 0.03, "rail": 0.003, "clock": 0.02, "crosstalk": 0.001, "common zero": 0.005, "side force": 0.005,
    "settling": 0.01, "curvature": 0.001, "mount": 0.0025,
    DISCREPANCY: 0.5,  # the usual sizes of the hull, those of the KCS, are at two standard deviations
    "force with y": 0.0003, "heading with y": 0.004, "rudder with y": 0.02, "crossflow with y": 0.01,
}  # fmt: skip
# Degrees of freedom of the half-t priors where they are not 3: few where an error may be large, many of a half-normal.
FREEDOM = {TYPES: 1.5, HULL: 2.0, BANK: 2.0, SHAPE: 2.0, WITH_OFFSET: 5.0, SETTLING: 2.0, CROSSTALK: 4.0}
FREEDOM[DISCREPANCY] = 1e6
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


@dataclass(frozen=True)
class Effect:
    name: str
    unit: str  # empty where no laboratory knows its usual size
    usual: float  # size in that unit
    group: str
    most: float = np.inf  # size that no laboratory overlooks
    linear: float = np.inf  # size up to which forces follow it in proportion


@accept_aliases
@dataclass(frozen=True)
class RunErrors(Aliased):
    """Prior scales of the errors that rows share; the tests then determine the size of each.

    Each is the scale of a half-t prior, which admits larger errors. The defaults of gain, zero and form are the scatter
    of repeats in the bundled KCS tests (1.1 to 3.4 % of a force).

    Raises an InputError where a size is negative, or as large as the force itself.
    """

    gain: float = 0.02  #: Gain of a run [1]: each force is off by this share of itself
    zero: float = 0.02  #: Zero of a run [1], over the force's root mean square in all tests
    form: float = 0.02  #: Model error of a motion [1], over the motion's own force; the same in every repeat of it
    #: Scatter from run to run in any direction [1], over the force's root mean square in all tests
    scatter: float = 0.003
    #: Multiplies the usual sizes of what changes hull terms [1]: speed, period, depth, straight runs, walls
    hull: float = 1.0
    #: Multiplies the usual sizes of what changes the bank's term [1]: its form, sides and speeds. These are assumed,
    #: like those of straight runs against harmonic ones. Fits of the KCS and Lataire tests nearly return their priors.
    bank: float = 1.0
    #: Multiplies the usual sizes of errors that runs share [1]: forces, headings and rudder angles that go with y,
    #: rail, clock, gauges. The sizes themselves are listed in ``docs/uncertainty.md``.
    campaign: float = 1.0

    def __post_init__(self) -> None:
        for name, size in vars(self).items():
            share = name in ("gain", "zero", "form", "scatter")
            if not 0 <= size < (1.0 if share else np.inf):
                what = "is no share of a force; give 0.02 for 2 %" if share else "must not be negative; give 1"
                raise InputError(f"run errors: {name} = {size} {what}")

    @property
    def none(self) -> bool:
        """Whether runs are assumed to differ only by the noise within them."""
        return self.gain == self.zero == self.form == 0


def run_errors_of(written: str) -> RunErrors:
    """Read errors of runs, ``gain,zero,form`` and, if wished, ``scatter,hull,bank,campaign``."""
    try:
        sizes = [float(part) for part in written.split(",")]
    except ValueError:
        sizes = []
    if not 3 <= len(sizes) <= len(fields(RunErrors)):
        raise InputError(f"run errors {written!r} are not understood; give gain,zero,form as in 0.02,0.02,0.02")
    return RunErrors(*sizes)


# Name, column of one unit, usual size in that unit, group and unit of an error.
EffectRow = tuple[str, np.ndarray, float, str, str]


def _hull(rows: ForceRows) -> Iterator[EffectRow]:
    """Hull terms that change with speed, period and depth, in straight runs, or are of another form."""
    trends = {"speed": rows.speeds, "period": rows.octaves, "depth": rows.depths}
    for f, term in rows.terms:
        if term.from_bank:
            continue
        slope = rows.raw(term.name) * rows.size(f, term)
        kind = INERTIA if any(name.endswith("dot") for name in term.inputs) else DAMPING
        for name, trend in trends.items():
            group = f"{kind} by {name}"
            if np.ptp(trend) >= ONE_LEVEL:
                yield f"{term.name} with {name}", rows.of(f, slope * trend), SIZES[group], group, ""
                if len(np.unique(np.round(trend / ONE_LEVEL))) > 2:
                    squared = rows.of(f, slope * trend**2)
                    yield f"{term.name} with {name} squared", squared, SIZES[group] / 2, group, ""
        if rows.mixed and kind == DAMPING:
            still = rows.of(f, slope * rows.steady)
            yield f"{term.name} in straight runs", still, SIZES["damping in straight runs"], HULL, ""
    others = dict.fromkeys(("v3", "r3", "|r|v", "|v|r"), "other hull terms") | dict.fromkeys(("v y2", "r y2"), "walls")
    for f in rows.lateral:
        for name, kind in others.items():
            yield _scaled(rows, f, name, SIZES[kind], HULL)


def _scaled(rows: ForceRows, f: int, name: str, usual: float, group: str) -> EffectRow:
    """A column scaled to the force's level; 0 where it holds rounding only."""
    column = rows.raw(f"column {name}")
    rms = rows.rms(column)
    scaled = column * (rows.level[f] / rms if rms > 1e-9 else 0.0)
    return f"{name} in {rows.forces[f]}", rows.of(f, scaled), usual, group, ""


def _bank(rows: ForceRows) -> Iterator[EffectRow]:
    """A bank of another form, one that differs by side, speed or type of run, and one that lags."""
    typical = max(TYPICAL * rows.rms(rows.raw("column y")), 1e-9)
    for f, term in rows.terms:
        if not term.from_bank:
            continue
        size, own = rows.size(f, term), rows.raw(term.name)
        # All are zero at the centreline and in straight runs: there the coefficient is what it is called.
        near, wall, far = (rows.raw(f"{kind} of {term.name}") for kind in ("near", "wall", "far"))
        forms = (
            ("as y2", near / typical**2, SHAPE),
            ("as y6", wall / typical**6, SHAPE),
            ("as the root of y", far / np.sqrt(typical), SHAPE),
            ("by side", rows.raw(f"side of {term.name}"), BANK),
            ("with depth", own * rows.depths * (np.ptp(rows.depths) > ONE_LEVEL), BANK),
            ("with speed", own * rows.speeds * (np.ptp(rows.speeds) > ONE_LEVEL), BANK),
        )
        for name, column, group in forms:
            yield f"{term.name} {name}", rows.of(f, column * size), SIZES["bank form"], group, ""
        harmonic = rows.of(f, own * (1 - rows.steady) * size) / 100
        yield f"{term.name} in harmonic runs", harmonic, 100 * SIZES["type of run"], TYPES, "%"
        lag = rows.of(f, rows.raw(f"time of {term.name}") * size)
        yield f"lag of {term.name}", lag, SIZES["bank lag"], STRAIGHT, "s"


def _with_offset(rows: ForceRows, configuration: Configuration) -> Iterator[EffectRow]:
    """Effects that vary with the offset as a bank does: a cable, a trimmed heading or rudder, a crossflow."""
    speed, ship, place = float(np.median(rows.speed)), configuration.ship, f"at {rows.reach:.2g} m"
    powers = {"y": 1.0, "y u": speed, "y u2": speed**2, "y2 u2": speed**2 * rows.reach}
    for f in rows.lateral:
        force, usual = rows.forces[f], SIZES["force with y"] * rows.level[f]
        for name, scale in powers.items():
            column = rows.of(f, rows.raw(f"column {name}") / (scale * rows.reach))
            unit = f"{FORCES[force].unit} {place}"
            yield f"force proportional to {name} in {force}", column, usual, WITH_OFFSET, unit
    along = rows.raw("column y u2") / rows.reach
    turned = rows.shift("heading with y") / rows.reach + _unexcited_sway(rows, configuration, along)
    yield "heading proportional to y", turned * DEGREE, SIZES["heading with y"], WITH_OFFSET, f"deg {place}"
    across = turned / rows.all(rows.speed) * 0.01
    yield "crossflow proportional to y", across, SIZES["crossflow with y"], WITH_OFFSET, f"cm/s {place}"
    side_force = RUDDER * configuration.water.density * ship.length * ship.draft * along
    trimmed = rows.side_force(side_force, -ship.length / 2)
    yield "rudder angle proportional to y", trimmed, SIZES["rudder with y"], WITH_OFFSET, f"deg {place}"


def _unexcited_sway(rows: ForceRows, configuration: Configuration, column: np.ndarray) -> np.ndarray:
    """Force of a heading of one radian on a usual hull, for tests without sway."""
    # Clarke, Gedling, Hine (1983): Y'v about pi T/L + 1.4 CB B/L. N'v is 0.14 to 0.41 in tests of KCS and DTC.
    ship = configuration.ship
    if np.abs(rows.shift("heading")).max(initial=0.0) > 0 and rows.rms(rows.raw("column v")) > 1e-6:
        return np.zeros(rows.each * rows.count)
    sway = np.pi * ship.draft / ship.length + 1.4 * ship.block_coefficient * ship.beam / ship.length
    size = 0.5 * configuration.water.density * ship.length * ship.draft
    return rows.side_force(sway * size * column, 0.35 * ship.length / sway)


def _motion(rows: ForceRows, configuration: Configuration) -> Iterator[EffectRow]:
    turned = (rows.shift("heading") + _unexcited_sway(rows, configuration, rows.raw("column u2"))) * DEGREE
    moved, usual = rows.shift("rail"), SIZES["heading"]
    still, side = rows.all(rows.steady) * rows.mixed, rows.all(rows.steady * rows.side)
    yield "heading", turned, usual, CAMPAIGN, "deg"
    yield "heading of straight runs", turned * still, usual, CAMPAIGN, "deg"
    yield "heading of straight runs by side", turned * side, usual / 2, CAMPAIGN, "deg"
    yield "offset of the rail", moved, SIZES["rail"], CAMPAIGN, "m"
    yield "offset of straight runs by side", moved * side, SIZES["straight offset"], TYPES, "m"
    yield CLOCKS, rows.rate(), SIZES["clock"], CLOCK, "s"
    if "N" in rows.names:
        given = rows.shift("mount") + _unexcited_sway(rows, configuration, rows.raw("N") * rows.speed**2)
        yield MOUNT, given * DEGREE / 20, SIZES["mount"], FIXED, "deg per 20 N m"


def _gauges(rows: ForceRows) -> Iterator[EffectRow]:
    """Errors of the gauges that all runs share, and a side force of the hull."""
    fitted, early, still = rows.fitted(rows.columns), rows.fitted(rows.early), rows.all(rows.steady) * rows.mixed
    for f, (force, level) in enumerate(zip(rows.forces, rows.level, strict=True)):
        one, unit = rows.of(f, rows.raw(ONE)), FORCES[force].unit
        yield f"zero of {force}", one, SIZES["common zero"] * level, CAMPAIGN, unit
        yield f"zero of {force} in straight runs", one * still, SIZES["straight zero"] * level, STRAIGHT, unit
        gain = rows.of(f, fitted[f]) * still / 100
        yield f"gain of {force} in straight runs", gain, 100 * SIZES["type of run"], TYPES, "%"
        yield f"settling of {force}", rows.of(f, early[f]), SIZES["settling"], SETTLING, ""
        if force != "X":
            yield _scaled(rows, f, "u2", SIZES["side force"], CAMPAIGN)
        curved = rows.of(f, rows.raw(f"column |{force}|{force}") / (2 * level)) / 100
        yield f"curvature of the gauge of {force}", curved, 100 * SIZES["curvature"], FIXED, "%"
        for g, other in enumerate(rows.forces):
            if g != f:
                leak = rows.of(f, fitted[g] * level / rows.level[g]) / 100
                yield f"crosstalk of {other} into {force}", leak, 100 * SIZES["crosstalk"], CROSSTALK, "%"


def _effects(rows: ForceRows, errors: RunErrors, configuration: Configuration) -> tuple[list[Effect], list[np.ndarray]]:
    """The effects with a force and a size, and their columns, each of a usual size."""
    multiples = dict.fromkeys(HULL_GROUPS, errors.hull) | dict.fromkeys((BANK, SHAPE), errors.bank)
    tables = [] if errors.none else [_hull(rows)]
    if tables and rows.lateral:
        tables += [_bank(rows), _with_offset(rows, configuration), _motion(rows, configuration), _gauges(rows)]
    effects, columns = [], []
    for name, column, size, group, unit in chain(*tables):
        usual = size * multiples.get(group.split(" by ")[0], errors.campaign)
        sizes = [rows.rms(part) / level for part, level in zip(np.split(column, rows.count), rows.level, strict=True)]
        if usual > 0 and max(sizes) > 0:
            # Size at which the largest root mean square of the column is the level of its force.
            whole = 1 / max(sizes)
            linear = LINEAR * whole if name in (CLOCKS, MOUNT) else np.inf
            effects.append(Effect(name, unit, usual, group, LARGEST_SIZES.get(unit.split(" ")[0], whole), linear))
            columns.append(column * usual)
    return effects, columns


def assemble(
    rows: ForceRows, errors: RunErrors, configuration: Configuration
) -> tuple[MixedModel, list[Effect], np.ndarray]:
    """The mixed model of some forces, its effects, and the unit of each scaled coefficient."""
    effects, columns = _effects(rows, errors, configuration)
    unit = rows.units()
    x = np.column_stack([rows.x * unit, *columns])
    runs = {name: parts for name, parts in _run_errors(rows, errors).items() if parts[0] > 0 and not errors.none}
    priors = {name: size for name, (size, _, _) in runs.items()}
    priors |= {effect.group: 1.0 for effect in effects if effect.group != FIXED}
    hull = tuple(i for i, name in enumerate(priors) if name.startswith(HULL_GROUPS))
    priors |= {DISCREPANCY: SIZES[DISCREPANCY]} if len(hull) > 1 else {}
    places = {name: i for i, name in enumerate((*priors, FIXED))}
    model = MixedModel(
        tuple(priors), x, rows.y,
        starts=np.concatenate([rows.starts + f * rows.each for f in range(rows.count)]),
        noise=np.outer(rows.noise, 1 / np.repeat(rows.runs, rows.sizes)).ravel(),
        shared=np.reshape([shared for _, shared, _ in runs.values()], (len(runs), len(x))).T,
        independent=np.reshape([apart for _, _, apart in runs.values()], (len(runs), len(x))).T,
        group=np.array([places[effect.group] for effect in effects], int),
        prior=np.array(list(priors.values())),
        freedom=np.array([FREEDOM.get(name, 3.0) for name in priors]),
        absorbed=_absorbed(rows, x, effects),
        forces=rows.count,
        confounding_scales=tuple(places[name] for name in RIVALS if name in places),
        multiples=hull if len(hull) > 1 else (),
    )  # fmt: skip
    return model, effects, unit


def _run_errors(rows: ForceRows, errors: RunErrors) -> dict[str, tuple[float, np.ndarray, np.ndarray]]:
    """Prior scale of each error within blocks, what it adds in proportion to each row, its variance of each alone."""
    fitted, one, none = rows.fitted(rows.reference), rows.reference[:, rows.names[ONE]], np.zeros(len(rows.y))
    runs, sizes = np.repeat(rows.runs, rows.sizes), np.repeat(rows.sizes, rows.sizes)
    bank = rows.fitted(rows.reference, bank=True) * rows.of_mean
    scatter = np.outer(rows.level**2, rows.length**2 / sizes / runs)
    # A form error spreads half along the force itself and half over all directions.
    measured = [rows.reference[:, rows.names[force]] for force in rows.forces]
    square = [np.repeat(np.add.reduceat(force**2, rows.starts), rows.sizes) / sizes for force in measured]
    along, around = np.sqrt(0.5) * fitted * rows.of_mean, 0.5 * np.stack(square) * rows.of_mean
    parts = {
        "gain": (errors.gain, (fitted / np.sqrt(runs)).ravel(), none),
        "form of the bank": (SIZES["bank form"] * errors.bank, bank.ravel(), none),
        "scatter": (errors.scatter, none, scatter.ravel()),
    }
    for f, force in enumerate(rows.forces):
        parts[f"form of {force}"] = errors.form, rows.of(f, along[f]), rows.of(f, around[f])
    for f, force in enumerate(rows.forces):
        parts[f"zero of {force}"] = errors.zero, rows.of(f, rows.level[f] * one / np.sqrt(runs)), none
    return parts


def _absorbed(rows: ForceRows, x: np.ndarray, effects: list[Effect]) -> np.ndarray:
    """Regression of the effects on the hull terms, with equal weight of each motion: (coefficients, effects)."""
    # A hull coefficient is the one that fits the forces on the hull best; a bank's is the slope at the centreline.
    p = len(rows.free_parameters)
    hull = np.array(sorted({rows.place(term) for _, term in rows.terms if not term.from_bank}), int)
    changes = np.array([effect.group.startswith(HULL_GROUPS) for effect in effects], bool)
    absorbed = np.zeros((p, len(effects)))
    scaled = x * rows.weights()[:, None]
    a = scaled[:, hull]
    size = np.sqrt((a**2).sum(axis=0))
    size = np.where(size > COLLINEAR * size.max(initial=0.0), size, np.inf)
    inverse = np.linalg.pinv(a / size, rcond=COLLINEAR)
    absorbed[np.ix_(hull, changes)] = inverse @ scaled[:, p:][:, changes] / size[:, None]
    return absorbed
