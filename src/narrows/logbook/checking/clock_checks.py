"""Clocks: that go back, stand still or jump, and gaps in which nothing came."""

from collections.abc import Iterator

import numpy as np

from narrows.logbook.checking.even_motion import usual_speed
from narrows.logbook.checking.finding import Finding
from narrows.logbook.ship_record import ShipRecord

# Usual steps of a signal, beyond which a step is a gap, and beyond which the clock may have jumped.
WIDE, JUMPING = 10.0, 2.5
# Of the time for a ship length, beyond which a gap matters, and a jump of the clock.
A_GAP, A_JUMP = 0.25, 0.05
# Of the way that a gap takes at the usual speed, below which the clock jumped and the ship did not.
LITTLE_WAY = 0.5
# Positions before and after a gap, by which the ship's speed there is known.
BESIDE = 5


def check_clock(record: ShipRecord, length: float) -> Iterator[Finding]:
    """Yield what is wrong with the times of a record."""
    # length [m]
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
    jumps = _jumps(record, _gaps(record["x"].t, JUMPING, A_JUMP * pace)) if {"x", "y"} <= record.signals.keys() else []
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
    gaps = {name: _gaps(signal.t, WIDE, A_GAP * pace) for name, signal in record.signals.items()}
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
        if 0 < way < LITTLE_WAY * speed * lapse:
            found.append((float(t[gap]), lapse - way / speed))
    return found


def _before(gap: int) -> slice:
    return slice(max(gap - BESIDE, 0), gap + 1)


def _after(gap: int) -> slice:
    return slice(gap + 1, gap + 2 + BESIDE)


def _speed(t: np.ndarray, x: np.ndarray, y: np.ndarray) -> float:
    return float(np.hypot(x[-1] - x[0], y[-1] - y[0]) / (t[-1] - t[0])) if len(t) > 1 else np.nan
