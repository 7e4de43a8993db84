"""Faults of a ship's own log, by the filter that learns from it."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from narrows.errors import InputError
from narrows.logbook import settings
from narrows.logbook.checking.faults import FAULTS, FaultTest, FaultTests, misreading, stuck
from narrows.logbook.checking.record_checks import (
    RECORD_CHECKS,
    Finding,
    LogFindings,
    check_clock,
    check_place,
    checked_record,
)
from narrows.logbook.filtering.record_grid import RUDDER, RecordGrid
from narrows.logbook.filtering.search import search
from narrows.logbook.learning.log_posterior import Spread
from narrows.logbook.learning.log_setup import LogSetup, log_problem
from narrows.logbook.sensor_grades import SensorGrade
from narrows.logbook.ship_log import SIGNALS, ShipLog, ShipRecord
from narrows.model.model import Model
from narrows.progress import stage
from narrows.results.base_results import with_error
from narrows.waterway import Waterway

ALL = "all records"


def check_log(
    log: Iterable[ShipRecord], model: Model, waterway: Waterway | None = None, *, sensors: str | SensorGrade = "vdr",
    spread: Spread | None = None,
) -> LogFindings:  # fmt: skip
    """Find what is wrong with a ship's log: signs, units, zeros, gains, delays, the antenna's place, steps.

    Clocks, gaps and sizes are checked in each record. Then the model is fitted to the first 20 records as ``learn``
    does, and each fault is one parameter of the same filter, tested by its score (Lagrange multiplier test). Signs,
    units and axes are compared by their likelihood. The strongest fault is named with its size and its effect on
    the coefficients; mend it and check again. A quiet record has little information: a clean log is no proof.

    Parameters
    ----------
    log : ShipLog, StreamedLog or sequence of ShipRecord
        Records of the ship.
    model : Model
        Model of the ship, at its size.
    waterway : Waterway, optional
        Line of x and y, and banks; default: the log's own.
    sensors : {"rtk", "vdr", "ais", "basin"} or SensorGrade
        Grade of the sensors.
    spread : float or mapping of str to float, optional
        As for ``learn``; a tenth of each coefficient where the model has no covariance.

    Returns
    -------
    LogFindings
        Each with its evidence in numbers and the remedy.

    Raises
    ------
    InputError
        Where there is no record.
    """
    water = getattr(log, "waterway", None) if waterway is None else waterway
    findings, good, count = list[Finding](), list[ShipRecord](), 0
    for whole in log:
        record = replace(whole, signals={name: whole[name] for name in whole if len(whole[name]) > 1})
        count += 1
        try:
            at = checked_record(record, model, water)
            found = list(check_clock(at)) or [one for check in RECORD_CHECKS[1:-1] for one in check(at)]
        except InputError as error:
            found = [Finding("missing", record.name, str(error), "leave it out, or record what is missing")]
        findings += found
        if not any(one.wrong for one in found) and len(good) < settings.MOST_CHECKED:
            twice = record.name in {other.name for other in good}
            good.append(replace(record, name=f"{record.name} ({count})") if twice else record)
    if not count:
        raise InputError("there is no record to check; give one or more")
    if good:
        checked = ShipLog(tuple(good), water)
        spread = settings.CHECKED_SPREAD if spread is None and model.covariance is None else spread
        with stage("checking the records"):
            findings += _by_filter(checked, model, sensors, spread)
        if not any(one.wrong for one in findings):  # A hull in a bank is a consequence of other faults.
            findings += [one for record in good for one in check_place(checked_record(record, model, water))]
    return LogFindings(tuple(findings), count)


def _by_filter(log: ShipLog, model: Model, sensors: str | SensorGrade, spread: Spread | None) -> Iterator[Finding]:
    setup = log_problem(model, log, sensors, spread=spread)
    for note in setup.left_out:
        yield Finding("missing", log.names[0], note.removesuffix("."), "leave it out, or record what is missing")
    if not (grids := list(setup)):
        return
    where = grids[0].record.name if len(grids) == 1 else ALL
    held = [
        Finding("stuck", grid.record.name, f"{name} keeps one value from t = {begin:.6g} to {end:.6g} s while the ship "
                "moves by all other signals", "leave that time out, or that signal", {"from": begin, "to": end})
        for grid in grids for name, begin, end in stuck(setup.problem, grid)
    ]  # fmt: skip
    if held:
        yield from held
    elif best := misreading(setup.problem, grids[: settings.MOST_REREAD]):
        gain, other = best
        better = f": with it changed, the log-likelihood rises by {gain / 2:.3g}" if np.isfinite(gain) else ""
        check, evidence = " and ".join(other.signals[:2]), {"log_likelihood_ratio": gain / 2} if better else {}
        yield Finding(check, where, other.sentence + better, other.remedy, evidence)
    else:
        gusty = setup.assumptions.gusts
        pushed = setup if gusty else log_problem(model, log, sensors, spread=spread, gusts=True)
        yield from _tested(setup, pushed, grids, where)


def _tested(setup: LogSetup, pushed: LogSetup, grids: list[RecordGrid], where: str) -> Iterator[Finding]:
    """Yield the fault with the strongest score after a fit that harms, and the strongest that does not."""
    learned = _scores(setup, grids)
    # Without disturbances, the residual of the model is a force: it must not pass for a fault of a sensor.
    scores = learned if pushed is setup else _scores(pushed, list(pushed))
    if not (learned and scores):
        said = "the model cannot follow this log at all: its motion goes to infinity"
        yield Finding("model", where, said, "look at signs, units and axes, and at the size of the model")
        return
    known = list[int]()
    while len(known) < settings.MOST_HARMLESS:
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
    fault, kind = test.fault, FAULTS[test.fault.kind]
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
        f"{kind.sentence.format(**words)} (at {abs(test.significance):.1f} standard errors); mended, {names[most]} "
        f"moves by {harm:+.1f} of its standard errors"
    )
    # The prior alone separates a rudder's fault from another force of the rudder, and here it is contradicted.
    of_model = fault.signal == RUDDER and likely < settings.CONTRADICTION
    if of_model:
        said += (
            f", and the coefficients still contradict their prior (p < {settings.CONTRADICTION}): it may be the model"
        )
    evidence = {"size": test.size, "error": test.error, "significance": test.significance, "effect": harm}
    check = fault.kind if fault.kind == "antenna" else f"{name} {fault.kind}"
    remedy = f"{kind.remedy.format(**words)}; then check again"
    return Finding(check, test.record, said, remedy, evidence, abs(harm) > settings.HARMFUL_SHIFT and not of_model)
