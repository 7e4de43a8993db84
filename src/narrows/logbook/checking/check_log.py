"""A ship's own log beside its model, before any fit: what is wrong with it, with evidence and remedy."""

import pkgutil
from collections.abc import Iterable, Iterator
from dataclasses import replace
from importlib import import_module
from typing import NamedTuple

from narrows.errors import InputError
from narrows.logbook import checking
from narrows.logbook.checking.agreement import even_motion
from narrows.logbook.checking.clock_and_unit_checks import check_clock
from narrows.logbook.checking.finding import CHECKS, Examined, Finding, LogFindings, LogStage
from narrows.logbook.checking.heading_checks import judge_yaw_rates, rate_shown
from narrows.logbook.checking.model_checks import check_antenna, judge_rudder, model_rates, rudder_effect
from narrows.logbook.settings import SURE
from narrows.logbook.ship_record import ShipRecord
from narrows.model.model import Model
from narrows.waterway import Waterway

ALL = "all records"
# Checks whose findings leave nothing for the next stage to go by.
SPOILING = ("heading", "speed", "stuck", "yaw rate")

# Each module of checks adds its own to ``CHECKS``.
for found in pkgutil.iter_modules(checking.__path__):
    if found.name.endswith("_checks"):
        import_module(f"{checking.__name__}.{found.name}")


class _Told(NamedTuple):
    """Weak evidence of each record, with standard errors: the rudder's effect, and the yaw rate's sign."""

    rudders: list[tuple[float, float]]
    yaw_rates: list[tuple[float, float]]


def check_log(log: Iterable[ShipRecord], model: Model, waterway: Waterway | None = None) -> LogFindings:
    """Find what is wrong with a ship's log before anything is fitted to it.

    Clocks, gaps, stuck sensors; units and signs of rudder, heading, yaw rate, speeds, revolutions, wind; velocities in
    fixed axes taken for the ship's; a yaw rate that is not the heading's derivative; a hull in a bank; an antenna that
    stands elsewhere. What rests on a signal that is wrong already is not looked at. A quiet record has little
    information: no finding is no proof.

    Parameters
    ----------
    log : ShipLog, StreamedLog or sequence of ShipRecord
        What was recorded.
    model : Model
        Model of the ship, at its size.
    waterway : Waterway, optional
        That x and y are told along; the log's own unless given, and the model's canal where its banks are felt.

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
    findings: list[Finding] = []
    told, records = _Told([], []), 0
    for whole in log:
        record = replace(whole, signals={name: whole[name] for name in whole if len(whole[name]) > 1})
        records += 1
        found = list(check_clock(record, model.configuration.ship.length))
        if not _wrong(found):
            found += _of_motion(record, model, water, told)
        findings += found
    if not records:
        raise InputError("there is no record to check; give one or more")
    if records > 1:
        findings += _together(told, {own.check for own in findings})
    return LogFindings(tuple(findings), records)


def _together(told: _Told, before: set[str]) -> list[Finding]:
    """Pool the evidence of quiet records; of the rudder, where the sign of the yaw rate is right."""
    found = [] if "yaw rate" in before else list(judge_yaw_rates(told.yaw_rates, ALL))
    if not found and not any(check.startswith("rudder") for check in before):
        found += judge_rudder(told.rudders, ALL)
    return found


def _wrong(findings: Iterable[Finding]) -> bool:
    return any(own.wrong for own in findings)


def _of_motion(record: ShipRecord, model: Model, waterway: Waterway | None, told: _Told) -> list[Finding]:
    """Yield faults of the recorded motion; compared with the model only where its signals have none."""
    motion = even_motion(record, model.configuration.ship.length, waterway)
    if motion is None:
        said = "the record is too short, or tells neither the ship's place nor its speed: nothing of it was looked at"
        return [Finding("missing", record.name, said, "leave it out, or record the position")]
    at = Examined(record, motion, model, waterway)
    found: list[Finding] = []
    for stage in LogStage:
        if stage is LogStage.MODEL and _wrong(found):
            return found
        found += [own for one in CHECKS if one.stage is stage for own in one.check(at)]
        if any(own.wrong and own.check in SPOILING for own in found):
            return found
    if shown := rate_shown(at):
        told.yaw_rates.append((float(shown.values[0]), float(shown.errors[0])))
    return found + list(_beside_model(at, told))


def _beside_model(at: Examined, told: _Told) -> Iterator[Finding]:
    rates = model_rates(at)
    if rates is None:
        return
    found = rudder_effect(at, rates)
    if found is None:
        return
    effect, error = float(found.values[0]), float(found.errors[0])
    told.rudders.append((effect, error))
    yield from judge_rudder(told.rudders[-1:], at.record.name)
    if effect > SURE * error:  # What the ship drifts by rests on a rudder that is right.
        yield from check_antenna(at, rates)
