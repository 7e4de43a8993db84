"""Faults of a ship's own log: by the filter that learns from it, and by checks that need none: clocks, sizes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pandas as pd

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.progress import stage
from narrows.base.results import BaseResult, with_error
from narrows.logbook import settings
from narrows.logbook.checking.faults import FAULTS, FaultTest, FaultTests, longest_run, misreading, stuck
from narrows.logbook.filtering.likelihood import search
from narrows.logbook.filtering.record_grid import RUDDER, RecordGrid
from narrows.logbook.learned_coefficients import Spread
from narrows.logbook.learning.log_setup import LogSetup, log_problem, log_records, speed_of
from narrows.logbook.ship_log import SIGNALS, SensorGrade, ShipLog, ShipRecord
from narrows.model.model import Model
from narrows.quantities.names import GRAVITY
from narrows.waterway import Waterway


class Finding(NamedTuple):
    record: str
    check: str  # What was looked at, as in ``rudder's sign``
    sentence: str  # What was seen, with its numbers
    remedy: str
    wrong: bool = True  # Whether it must be mended before a fit; else it is to be looked at


@dataclass(frozen=True, repr=False)
class LogFindings(BaseResult):
    """Faults and doubts of a log."""

    findings: tuple[Finding, ...]  #: In the order of the records
    records: int  #: How many of these were looked at
    notes: ClassVar[tuple[str, ...]] = (
        "no finding is no proof: a quiet record has little information on the sign of its rudder",
    )

    def __len__(self) -> int:
        return len(self.findings)

    def __iter__(self) -> Iterator[Finding]:
        return iter(self.findings)

    @property
    def clean(self) -> bool:
        """True where nothing must be mended before a fit."""
        return not self.wrong

    @property
    def wrong(self) -> tuple[Finding, ...]:
        """Faults that must be mended before a fit."""
        return tuple(finding for finding in self.findings if finding.wrong)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Doubts, which need not be mended: a sentence for each kind."""
        return tuple(self._lines([finding for finding in self.findings if not finding.wrong]))

    @staticmethod
    def _lines(findings: Sequence[Finding]) -> list[str]:
        alike = dict[tuple[str, str], list[Finding]]()
        for own in findings:
            alike.setdefault((own.check, own.remedy), []).append(own)
        return [
            f"{check}{'' if first.wrong else ' (doubtful)'}: in {first.record}"
            f"{f' and {len(others)} more' * bool(others)}, {first.sentence}; {remedy}."
            for (check, remedy), (first, *others) in alike.items()
        ]

    def summary(self) -> str:
        looked = f"{self.records} record{'s' * (self.records > 1)} looked at"
        if not self.findings:
            return f"Nothing is wrong: {looked}."
        lines = self._lines(self.findings)
        return "\n".join([f"{len(lines)} finding{'s' * (len(lines) > 1)}, {looked}.", *lines])

    def to_dict(self) -> dict[str, Any]:
        return {
            "records": self.records, "clean": self.clean, "findings": [own._asdict() for own in self.findings],
            "summary": self.summary(), "notes": list(self.notes),
        }  # fmt: skip

    def to_dataframe(self) -> pd.DataFrame:
        """Give a row for each finding: record, check, sentence, remedy, whether it is wrong."""
        return pd.DataFrame(self.findings, columns=Finding._fields)


class Checked(NamedTuple):
    record: ShipRecord
    model: Model
    waterway: Waterway | None  # Line of x and y
    pace: float  # Time of the way of a ship length [s]

    def finding(self, check: str, sentence: str, remedy: str, wrong: bool = True) -> Finding:
        return Finding(self.record.name, check, sentence, remedy, wrong)


def check_clock(at: Checked) -> Iterator[Finding]:
    """Find times that go back or stand still."""
    for name, signal in at.record.signals.items():
        steps = np.diff(signal.t)
        if (back := steps <= 0).any():
            worst, first = float(-steps.min()), float(signal.t[1:][back][0])
            how = f"goes back by up to {worst:.4g} s" if worst > 0 else "stands still"
            yield at.finding(
                "clock", f"the time of {name} {how}, {int(back.sum())} times, first at t = {first:.6g} s",
                "sort the log by time; where the clock was set, begin another record there",
            )  # fmt: skip
            return


def check_repeats(at: Checked) -> Iterator[Finding]:
    """Find signals that are written more often than they are measured."""
    for name, signal in at.record.signals.items():
        runs = np.diff(np.flatnonzero(np.diff(signal.values, prepend=np.nan, append=np.nan) != 0))
        if len(runs) < settings.FEWEST_RUNS or (usual := int(np.median(runs))) < 2:
            continue
        if np.mean(runs == usual) > settings.REGULAR and usual * signal.step > settings.REPEATED_LENGTHS * at.pace:
            yield at.finding(
                "repeats", f"{name} is written every {signal.step:.3g} s and changes every {usual * signal.step:.3g} s",
                "leave repeated values out of the log",
            )  # fmt: skip


def check_speed(at: Checked) -> Iterator[Finding]:
    """Find speeds that no displacement ship reaches."""
    length = at.model.configuration.ship.length
    froude = length / at.pace / np.sqrt(GRAVITY * length)
    if froude > settings.MOST_FROUDE:
        yield at.finding(
            "speed", f"at {length / at.pace:.3g} m/s a ship of {length:.4g} m has a Froude number of {froude:.2f}, "
            "which no displacement ship reaches",
            "give the log the model of its own ship's size (nw.scale_model), and positions and speeds in metres",
        )  # fmt: skip


def check_rudder(at: Checked) -> Iterator[Finding]:
    """Find a rudder that is read too seldom, or stands still while the ship swings."""
    if RUDDER not in at.record or not len(rudder := at.record[RUDDER]):
        return
    lengths, moves = rudder.step / at.pace, float(np.std(np.diff(rudder.values))) if len(rudder) > 1 else 0.0
    if lengths > settings.SELDOM and moves > settings.STILL:
        yield at.finding(
            "sampling", f"the rudder is read every {rudder.step:.3g} s only, or every {lengths:.2g} ship lengths",
            "record it each second", wrong=False,
        )  # fmt: skip
    begin, end = rudder.t[longest_run(rudder.values)].tolist()
    confined = at.waterway is not None or at.model.has_bank
    still, swings = (end - begin) / at.pace, _swings(at.record, begin, end)
    if still > settings.RUDDER_REST and (
        swings >= settings.SWINGS or (confined and still > settings.RUDDER_REST_BETWEEN_BANKS)
    ):
        yield at.finding(
            "rudder", f"the rudder stands still from t = {begin:.6g} s for {still:.3g} ship lengths, in which the "
            f"ship swings {swings} times",
            "look for another column of it, or for a sensor that fell silent",
        )  # fmt: skip


def _swings(record: ShipRecord, begin: float, end: float) -> int:
    """Return how often the heading turns from one side to the other, beyond any noise."""
    from scipy.signal import find_peaks

    if "psi" not in record or not len(record["psi"]):
        return 0
    seen = np.unwrap(record["psi"].between(begin, end).values)
    return sum(len(find_peaks(side * seen, prominence=settings.LEAST_TURN)[0]) for side in (1, -1))


def check_place(at: Checked) -> Iterator[Finding]:
    """Find a hull that would lie in a bank."""
    record, ship = at.record, at.model.configuration.ship
    if not {"x", "y", "psi"} <= record.signals.keys() or not (at.waterway or at.model.has_bank):
        return
    t, x = record["x"].t, record["x"].values
    y, psi = record["y"].at(t), record["psi"].at(t)
    reach = ship.length / 2 * np.abs(np.sin(psi)) + ship.beam / 2 * np.abs(np.cos(psi))
    half, middle = np.full(len(y), at.model.configuration.canal.width / 2), np.zeros(len(y))
    if at.waterway is not None:
        here = at.waterway.section(x, ship.draft)
        half, middle = here.width / 2, here.middle
    beyond, turned = (reach - half + np.abs(side * y - middle) for side in (1, -1))
    if not (share := float(np.nanmean(beyond > 0))) > settings.ASHORE:
        return
    worst = int(np.nanargmax(beyond))
    yield at.finding(
        "banks", f"the hull reaches {beyond[worst]:.3g} m into a bank at t = {t[worst]:.6g} s, y = {y[worst]:.4g} m, "
        f"and {share:.1%} of the time into one",
        'y counts to port: [positive] y = "port"' if np.nanmean(turned > 0) <= settings.ASHORE else "check the "
        "waterway, the datum of the position, the antenna's place, and whether x and y are along and across it",
    )  # fmt: skip


# The clock is checked before all others, which need right times; the place after them, since a hull in a bank is a
# consequence of other faults.
RECORD_CHECKS = (check_clock, check_repeats, check_speed, check_rudder, check_place)
ALL = "all records"
MISSING_REMEDY = "leave the record out, or record what is missing"


@accept_aliases
def check_log(
    log: Any, model: Model, waterway: Waterway | None = None, *, sensors: str | SensorGrade = "vdr",
    spread: Spread | None = None,
) -> LogFindings:  # fmt: skip
    """Find what is wrong with a ship's log: signs, units, zeros, gains, delays, the antenna's place, steps.

    Clocks and sizes are checked in each record. Then the model is fitted to the first 20 records, and each fault is one
    parameter of the same filter, tested by its score (Lagrange multiplier test). The strongest fault is named with its
    size and its effect on the coefficients; mend it and check again.

    Raises an InputError where there is no record.

    Parameters
    ----------
    log, model, waterway, sensors, spread : Any
        As for ``learn``; the spread is a tenth of each coefficient where the model has no covariance.
    """
    log = log_records(log, waterway)
    water = getattr(log, "waterway", None) if waterway is None else waterway
    findings, good, count = list[Finding](), list[Checked](), 0
    between = [check for check in RECORD_CHECKS if check not in (check_clock, check_place)]
    for whole in log:
        count += 1
        record = replace(whole, signals={name: whole[name] for name in whole if len(whole[name]) > 1})
        try:
            at = Checked(record, model, water, model.configuration.ship.length / speed_of(record))
            found = list(check_clock(at)) or [one for check in between for one in check(at)]
        except InputError as error:
            words = str(error)
            found = [Finding(record.name, "missing", words.rpartition("; ")[0] or words, MISSING_REMEDY)]
        findings += found
        if not any(one.wrong for one in found) and len(good) < settings.MOST_CHECKED:
            good.append(at)
    if not count:
        raise InputError("there is no record to check; give one or more")
    if good:
        checked = ShipLog(tuple(at.record for at in good), water)
        spread = settings.CHECKED_SPREAD if spread is None and model.covariance is None else spread
        with stage("checking the records"):
            findings += _by_filter(checked, model, sensors, spread)
        if not any(one.wrong for one in findings):
            findings += [one for at in good for one in check_place(at)]
    return LogFindings(tuple(findings), count)


def _by_filter(log: ShipLog, model: Model, sensors: str | SensorGrade, spread: Spread | None) -> Iterator[Finding]:
    setup = log_problem(model, log, sensors, spread=spread)
    grids = list(setup)
    for note in setup.left_out:
        yield Finding(log.names[0], "missing", note.removesuffix("."), MISSING_REMEDY)
    if not grids:
        return
    where = grids[0].record.name if len(grids) == 1 else ALL
    if held := [
        Finding(grid.record.name, "stuck", f"{name} keeps one value from t = {begin:.6g} to {end:.6g} s while the ship "
                "moves by all other signals", "leave that time out, or that signal")
        for grid in grids for name, begin, end in stuck(setup.problem, grid)
    ]:  # fmt: skip
        yield from held
    elif best := misreading(setup.problem, grids[: settings.MOST_REREAD]):
        gain, other = best
        # The model may not follow a record at all that is in another unit.
        better = f": with it changed, the log-likelihood rises by {gain / 2:.3g}" if np.isfinite(gain) else ""
        yield Finding(where, " and ".join(other.signals[:2]), other.sentence + better, other.remedy)
    else:
        pushed = setup if setup.gusts else log_problem(model, log, sensors, spread=spread, gusts=True)
        yield from _tested(setup, pushed, grids, where)


def _tested(setup: LogSetup, pushed: LogSetup, grids: list[RecordGrid], where: str) -> Iterator[Finding]:
    """Yield the fault with the strongest score after a fit that harms, and the strongest that does not."""
    learned = _scores(setup, grids)
    # Without disturbances, the residual of the model is a force: it must not pass for a fault of a sensor.
    scores = learned if pushed is setup else _scores(pushed, list(pushed))
    if not (learned and scores):
        said = "the model cannot follow this log at all: its motion goes to infinity"
        yield Finding(where, "model", said, "look at signs, units and axes, and at the size of the model")
        return
    known = list[int]()
    for _ in range(settings.MOST_HARMLESS):
        tests = scores.tested(known)
        beyond = [one for one in tests if one.probability < settings.FALSE_ALARM / len(tests)]
        if not beyond:
            return
        best = max(beyond, key=lambda one: abs(one.significance))
        finding = _finding(best, learned)
        if finding.wrong or not known:
            yield finding
        if finding.wrong:  # Others may follow from it.
            return
        known.append(best.place)


def _scores(setup: LogSetup, grids: list[RecordGrid]) -> FaultTests | None:
    found = search(setup.problem, setup, settings.CHECK_STEPS)
    return FaultTests.of(found, grids, ALL) if found and found.records and not found.diverged else None


def _finding(test: FaultTest, learned: FaultTests) -> Finding:
    fault, (sentence, cure) = test.fault, FAULTS[test.fault.kind]
    unit, factor = SIGNALS[fault.signal].unit, 1.0
    if unit.startswith("rad") and fault.kind in ("zero", "step"):
        unit, factor = unit.replace("rad", "deg"), 180 / np.pi
    value = factor * test.size + (fault.kind == "gain")
    name = "position" if fault.signal == "x" and fault.kind == "delay" else fault.signal
    words = {"name": name, "unit": unit, "size": with_error(value, 1.96 * factor * test.error), "at": fault.at,
             "value": value, "column": fault.signal}  # fmt: skip
    effect, likely = learned.mended(test)
    names, model = learned.found.problem.prior.names, learned.found.problem.motion.model
    bank = [place for place, own in enumerate(names) if model.terms[own].from_bank]
    most = max(bank or range(len(names)), key=lambda place: abs(effect[place]))
    harm = float(effect[most])
    said = (
        f"{sentence.format(**words)} (at {abs(test.significance):.1f} standard errors); mended, {names[most]} "
        f"moves by {harm:+.1f} of its standard errors"
    )
    # The prior alone separates a rudder's fault from another force of the rudder, and here it is contradicted.
    of_model = fault.signal == RUDDER and likely < settings.CONTRADICTION
    if of_model:
        said += f", and coefficients still contradict their prior (p < {settings.CONTRADICTION}): it may be the model"
    check = fault.kind if fault.kind == "antenna" else f"{name} {fault.kind}"
    remedy = f"{cure.format(**words)}; then check again"
    return Finding(test.record, check, said, remedy, abs(harm) > settings.HARMFUL_SHIFT and not of_model)
