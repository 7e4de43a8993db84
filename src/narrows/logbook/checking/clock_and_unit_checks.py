"""Clocks: that go back, stand still or jump, and gaps in which nothing came."""

from collections.abc import Iterator

import numpy as np

from narrows.logbook import settings
from narrows.logbook.checking.agreement import usual_speed
from narrows.logbook.checking.finding import Examined, Finding, LogStage, log_check
from narrows.logbook.ship_record import ShipRecord
from narrows.quantities.names import GRAVITY


def check_clock(record: ShipRecord, length: float) -> Iterator[Finding]:
    backward = list(_backward(record))
    yield from backward
    if not backward:
        yield from _jumps_and_gaps(record, length)


def _backward(record: ShipRecord) -> Iterator[Finding]:
    for name, signal in record.signals.items():
        steps = np.diff(signal.t)
        back = steps <= 0
        if not back.any():
            continue
        worst, first = float(-steps.min()), float(signal.t[1:][back][0])
        how = f"goes back by up to {worst:.4g} s" if worst > 0 else "stands still"
        yield Finding(
            "clock", record.name, f"the time of {name} {how}, {int(back.sum())} times, first at t = {first:.6g} s",
            "sort the log by time; where the clock was set, begin another record there",
            {"times": float(back.sum()), "first": first, "back": worst},
        )  # fmt: skip
        return


def _jumps_and_gaps(record: ShipRecord, length: float) -> Iterator[Finding]:
    speed = usual_speed(record)
    if speed is None:
        return
    pace = length / speed
    jumps = (
        _jumps(record, _gaps(record["x"].t, settings.CLOCK_JUMP_STEPS, settings.CLOCK_JUMP_LENGTHS * pace))
        if {"x", "y"} <= record.signals.keys()
        else []
    )
    if jumps:
        at, lost = max(jumps, key=lambda jump: jump[1])
        often = f", the largest of {len(jumps)} jumps" if len(jumps) > 1 else ""
        yield Finding(
            "clock", record.name,
            f"the clock jumps on by some {lost:.4g} s at t = {at:.6g} s{often}: the ship made no way in that time",
            "take the jump out of the times after it, or begin another record there",
            {"at": at, "jump": lost, "jumps": float(len(jumps))},
        )  # fmt: skip
        return
    gaps = {
        name: _gaps(signal.t, settings.GAP_STEPS, settings.GAP_LENGTHS * pace)
        for name, signal in record.signals.items()
    }
    if found := {name: steps for name, steps in gaps.items() if steps.size}:
        longest = {name: float(np.diff(record[name].t)[steps].max()) for name, steps in found.items()}
        name = max(longest, key=lambda own: longest[own])
        yield Finding(
            "gaps", record.name,
            f"nothing came of {' and '.join(found)} for up to {longest[name]:.4g} s, where {record[name].step:.3g} s "
            "is usual",
            "nothing, if the fit need not join over them; else cut the record there",
            {"gaps": float(sum(steps.size for steps in found.values())), "longest": longest[name]}, wrong=False,
        )  # fmt: skip


def _gaps(t: np.ndarray, wide: float, matters: float) -> np.ndarray:
    """Places of steps in time that are gaps."""
    steps = np.diff(t)
    if steps.size == 0:
        return np.empty(0, int)
    return np.flatnonzero(steps > max(wide * float(np.median(steps)), matters))


def _jumps(record: ShipRecord, gaps: np.ndarray) -> list[tuple[float, float]]:
    """Times of gaps in the position over which the ship made no way, and how much of each is no time."""
    t, x = record["x"].t, record["x"].values
    y = record["y"].at(t)
    found = []
    for gap in gaps.tolist():
        speeds = [_speed(t[part], x[part], y[part]) for part in (_before(gap), _after(gap))]
        speed, lapse = float(np.nanmean(speeds)), float(t[gap + 1] - t[gap])
        way = float(np.hypot(x[gap + 1] - x[gap], y[gap + 1] - y[gap]))
        if 0 < way < settings.LITTLE_WAY * speed * lapse:
            found.append((float(t[gap]), lapse - way / speed))
    return found


def _before(gap: int) -> slice:
    return slice(max(gap - settings.SPEED_POSITIONS, 0), gap + 1)


def _after(gap: int) -> slice:
    return slice(gap + 1, gap + 2 + settings.SPEED_POSITIONS)


def _speed(t: np.ndarray, x: np.ndarray, y: np.ndarray) -> float:
    return float(np.hypot(x[-1] - x[0], y[-1] - y[0]) / (t[-1] - t[0])) if len(t) > 1 else np.nan


@log_check(LogStage.PLACE)
def check_place(at: Examined) -> Iterator[Finding]:
    """Yield where the hull would lie in a bank."""
    motion, ship = at.motion, at.model.configuration.ship
    if not {"x", "y", "psi"} <= motion.columns.keys() or not (at.waterway or at.model.feels_bank):
        return
    reach = ship.length / 2 * np.abs(np.sin(motion["psi"])) + ship.beam / 2 * np.abs(np.cos(motion["psi"]))
    starboard, port = _room(at)
    beyond = np.fmax(motion["y"] + reach - starboard, reach - motion["y"] - port)
    share = float(np.nanmean(beyond > 0))
    if not share > settings.ASHORE:
        return
    worst = int(np.nanargmax(beyond))
    mirrored = np.fmax(reach - motion["y"] - starboard, motion["y"] + reach - port)
    turned = float(np.nanmean(mirrored > 0)) <= settings.ASHORE
    yield at.finding(
        "banks", f"the hull reaches {beyond[worst]:.3g} m into a bank at t = {motion.t[worst]:.6g} s, y = "
        f"{motion['y'][worst]:.4g} m, and {share:.1%} of the time into one",
        'y counts to port: [positive] y = "port"' if turned else "check the waterway, the datum of the position, the "
        "antenna's place, and whether x and y are along and across it",
        {"beyond": beyond[worst], "share": share, "at": motion.t[worst]},
    )  # fmt: skip


def _room(at: Examined) -> tuple[np.ndarray, np.ndarray]:
    """Return the distances of the banks to starboard and to port of the line, where the ship is [m]."""
    if at.waterway is None:
        half = np.full(len(at.motion.t), at.model.configuration.canal.width / 2)
        return half, half
    here = at.waterway.room(np.nan_to_num(at.motion["x"]), at.model.configuration.ship.draft)
    return here.width / 2 + here.middle, here.width / 2 - here.middle


DEGREE = np.pi / 180


@log_check(LogStage.SENSORS)
def check_units(at: Examined) -> Iterator[Finding]:
    """Yield what no ship of this size does."""
    yield from _speed_units(at)
    yield from _rudder(at)
    yield from _revolutions(at)
    yield from _yaw_rate(at)


def _speed_units(at: Examined) -> Iterator[Finding]:
    froude = at.speed / np.sqrt(GRAVITY * at.length)
    if froude > settings.MOST_FROUDE:
        yield at.finding(
            "speed", f"at {at.speed:.3g} m/s a ship of {at.length:.4g} m has a Froude number of {froude:.2f}, which no "
            "displacement ship reaches",
            "give the log the model of its own ship's size (nw.scale_model), and positions and speeds in metres",
            {"speed": at.speed, "froude": froude},
        )  # fmt: skip


def _rudder(at: Examined) -> Iterator[Finding]:
    if "rudder" not in at.record:
        return
    most, limit = float(np.quantile(np.abs(at.record["rudder"].values), 0.99)), at.model.configuration.gear.limit
    if most <= settings.RUDDER_EXCESS * limit:
        return
    degrees = most <= settings.RUDDER_EXCESS * limit / DEGREE
    yield at.finding(
        "rudder",
        f"the rudder reaches {np.degrees(most):.4g} deg, where the gear's limit is {np.degrees(limit):.3g} deg",
        "it looks like degrees taken as radians: head it 'rudder [deg]'" if degrees else "check its unit, and the gear",
        {"rudder_deg": np.degrees(most), "limit_deg": np.degrees(limit)}, wrong=degrees,
    )  # fmt: skip


def _yaw_rate(at: Examined) -> Iterator[Finding]:
    if "r" not in at.record:
        return
    turns = float(np.quantile(np.abs(at.record["r"].values), 0.99)) * at.motion.pace
    if turns > settings.MOST_TURN:
        yield at.finding(
            "yaw rate", f"the ship would turn by {np.degrees(turns):.3g} deg on the way of its own length",
            "r looks like degrees a second, or a minute, taken as radians a second: give its unit", {"turns": turns},
        )  # fmt: skip


def _revolutions(at: Examined) -> Iterator[Finding]:
    if "revolutions" not in at.record:
        return
    turns = float(np.median(np.abs(at.record["revolutions"].values)))
    propeller, ship = at.model.configuration.propeller, at.model.configuration.ship
    diameter = propeller.diameter if propeller else settings.DIAMETER * ship.draft
    if not turns > 0:
        return
    advance = at.speed / (turns * diameter)
    if settings.ADVANCE_RATIOS[0] <= advance <= settings.ADVANCE_RATIOS[1]:
        return
    causes = {60.0: "turns a minute taken as turns a second: head them 'revolutions [rpm]'",
              1 / 60: "turns a second taken as turns a minute: head them 'revolutions [1/s]'"}  # fmt: skip
    cause = next(
        (
            word
            for factor, word in causes.items()
            if settings.ADVANCE_RATIOS[0] <= factor * advance <= settings.ADVANCE_RATIOS[1]
        ),
        None,
    )
    yield at.finding(
        "revolutions",
        f"at {turns:.4g} turns a second and {at.speed:.3g} m/s a propeller of {diameter:.3g} m has an advance ratio of "
        f"{advance:.2g}",
        f"they look like {cause}" if cause else "check the unit of the revolutions",
        {"revolutions": turns, "advance_ratio": advance}, wrong=cause is not None,
    )  # fmt: skip
