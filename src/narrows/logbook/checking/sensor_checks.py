"""Single sensors: what is missing, what is stuck, a rudder that never moves or is seldom told."""

from collections.abc import Iterator

import numpy as np

from narrows.logbook import settings
from narrows.logbook.checking.agreement import Estimates, changes, least_squares
from narrows.logbook.checking.finding import Examined, Finding, LogStage, log_check
from narrows.logbook.ship_record import Signal


@log_check(LogStage.SENSORS)
def check_sensors(at: Examined) -> Iterator[Finding]:
    yield from _missing(at)
    yield from _stuck(at)
    yield from _seldom(at)


def _missing(at: Examined) -> Iterator[Finding]:
    steered = any(own.name == "rudder" for own in at.model.terms.actuators)
    wanted = {
        "rudder": ("the fit steers by it" if steered else "", "take it from the voyage data recorder"),
        "psi": ("drift and rudder have no meaning without it", "record the gyrocompass"),
        "x": ("the banks are known by it", "record the position"),
    }
    for name, (why, remedy) in wanted.items():
        if why and name not in at.record:
            yield at.finding("missing", f"the record has no {name}: {why}", remedy, {}, wrong=name != "x")


def _seldom(at: Examined) -> Iterator[Finding]:
    """A rudder that moves more than once between two of its values: twins are in doubt from there on."""
    if "rudder" not in at.record:
        return
    rudder = at.record["rudder"]
    lengths, moves = rudder.step / at.motion.pace, float(np.std(np.diff(rudder.values)))
    if lengths > settings.SELDOM and moves > settings.STILL:
        yield at.finding(
            "sampling",
            f"the rudder is told every {rudder.step:.3g} s only, in which the ship makes {lengths:.2g} of its length: "
            "what it did between is not known",
            "record it each second", {"step": rudder.step, "lengths": lengths}, wrong=False,
        )  # fmt: skip


def _stuck(at: Examined) -> Iterator[Finding]:
    for name in ("psi", "r", "x"):
        if name not in at.record:
            continue
        signal = at.record[name]
        start, stop = longest_run(signal.values)
        lasting = float(signal.t[stop] - signal.t[start])
        if stop - start < settings.STUCK_STEPS or lasting < settings.STUCK_LENGTHS * at.motion.pace:
            continue
        begin, end = float(signal.t[start]), float(signal.t[stop])
        if evidence := _contradiction(at, name, begin, end):
            yield at.finding(
                "stuck", f"{name} says the same from t = {begin:.6g} to {end:.6g} s, while {evidence}",
                "leave that time out, or that signal", {"from": begin, "to": end},
            )  # fmt: skip


def _contradiction(at: Examined, name: str, begin: float, end: float) -> str:
    """Return the quantity that moved while a sensor stood still; empty where none did."""
    if name == "x":
        way = at.speed * (end - begin)
        still = "y" in at.record and np.ptp(at.record["y"].between(begin, end).values) == 0
        return f"the ship made some {way:.3g} m" if still and way > settings.LEAST_MOVE * at.length else ""
    other = "psi" if name == "r" else "r"
    if other not in at.record or len(seen := at.record[other].between(begin, end)) < 3:
        return ""
    angle = seen.values if name == "r" else _integral(seen) - np.median(at.record["r"].values) * (seen.t - begin)
    rate = at.record["r"].values[np.searchsorted(at.record["r"].t, begin)] if name == "r" else 0.0
    turned = float(np.ptp(angle - rate * (seen.t - begin)))
    grain = _grain(at.record[name]) * ((end - begin) if name == "r" else 1.0)
    return (
        f"the ship turned by {np.degrees(turned):.3g} deg more by {other}"
        if turned > settings.COMPASS_STEP + grain
        else ""
    )


def _integral(signal: Signal) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(np.diff(signal.t) * (signal.values[1:] + signal.values[:-1]) / 2)])


def _grain(signal: Signal) -> float:
    steps = np.abs(np.diff(signal.values))
    return float(steps[steps > 0].min()) if (steps > 0).any() else 0.0


@log_check(LogStage.MOTION)
def check_rudder_moves(at: Examined) -> Iterator[Finding]:
    """Yield where a rudder is not told, while the ship swings to and fro or keeps clear of banks."""
    if "rudder" not in at.record or "psi" not in at.motion:
        return
    rudder = at.record["rudder"]
    start, stop = longest_run(rudder.values)
    still = np.ptp(rudder.values) < settings.STILL
    begin, end = (rudder.t[0], rudder.t[-1]) if still else (rudder.t[start], rudder.t[stop])
    lengths = float(end - begin) / at.motion.pace
    swings = _swings(at, begin, end)
    confined = at.waterway is not None or at.model.feels_bank
    if lengths > settings.RUDDER_REST and (
        swings >= settings.SWINGS or (confined and lengths > settings.RUDDER_REST_BETWEEN_BANKS)
    ):
        how = "never moves" if still else f"stays where it is from t = {begin:.6g} s on"
        yield at.finding(
            "rudder", f"the rudder {how} for {lengths:.3g} ship lengths, while the ship swings {swings} times",
            "look for another column of it, or for a sensor that fell silent",
            {"from": begin, "to": end, "swings": swings},
        )  # fmt: skip


def _swings(at: Examined, begin: float, end: float) -> int:
    """Return the number of turns of the heading from one side to the other, beyond any noise."""
    first, last = at.motion.windows(1.0)
    inside = (at.motion.t[first] >= begin) & (at.motion.t[last] <= end)
    turned = changes(at.motion.heading, (first[inside], last[inside]))
    sides = np.sign(turned[np.abs(turned) > settings.LEAST_TURN])
    return int((np.diff(sides) != 0).sum())


def longest_run(values: np.ndarray) -> tuple[int, int]:
    """Return first and last place of the longest stretch of one value."""
    # values (n,)
    edges = np.flatnonzero(np.concatenate([[True], np.diff(values) != 0, [True]]))
    longest = int(np.argmax(np.diff(edges)))
    return int(edges[longest]), int(edges[longest + 1]) - 1


# Causes, by the multiple of the ship's velocity in a wind.
CAUSES = {
    1.0: "it is the wind as felt on board: call it apparent_wind_speed and apparent_wind_angle",
    -2.0: "its angle says where the wind goes, not where it comes from: add half a turn",
    -1.0: "the ship's own wind was taken off twice",
}


@log_check(LogStage.MODEL)
def check_wind(at: Examined) -> Iterator[Finding]:
    """Yield where the wind goes with the ship."""
    motion = at.motion
    if not {"wind_speed", "wind_direction", "psi"} <= motion.columns.keys() or not np.isfinite(motion.position).any():
        return
    wind = motion["wind_speed"] * np.exp(1j * (motion["wind_direction"] + motion.axis))
    ship = np.gradient(motion.position, motion.dt)
    told, by_bow = (_held(at, column, ship) for column in (wind, wind * np.exp(1j * motion["psi"])))
    if told is None or by_bow is None:
        return
    (share, unsteady), (_, unsteady_by_bow) = told, by_bow
    if unsteady > settings.WIND_STEADIER * unsteady_by_bow:
        yield at.finding(
            "wind",
            f"the wind varies by {unsteady:.3g} m/s on the map, by {unsteady_by_bow:.2g} m/s if told from the bow",
            "its direction is told from the bow: add the heading", {"unsteady": unsteady, "by_bow": unsteady_by_bow},
        )  # fmt: skip
        return
    held, error = share.values[0], share.errors[0]
    if abs(held) > settings.WIND_SHARE + settings.SURE * error:
        nearest = min(CAUSES, key=lambda cause: abs(cause - held))
        yield at.finding(
            "wind", f"the wind holds {held:.2f} +- {1.96 * error:.2f} times the ship's own velocity", CAUSES[nearest],
            {"share": held, "error": error},
        )  # fmt: skip


def _held(at: Examined, wind: np.ndarray, ship: np.ndarray) -> tuple[Estimates, float] | None:
    """Return the share of the ship's velocity in a wind, and its other variation [m/s]."""
    windows = at.motion.windows(1.0)
    lasting = (windows[1] - windows[0]) * at.motion.dt
    means = [at.motion.integrals(column, windows) / lasting for column in (wind, ship)]
    one = np.ones(len(lasting))
    blowing, moving, east = (np.concatenate([part.real, part.imag]) for part in (*means, 1j * one))
    found = least_squares(blowing, [moving, 1 - east, east])
    if found is None:
        return None
    left = blowing - np.stack([moving, 1 - east, east], axis=1) @ found.values
    return found, float(np.sqrt(2 * np.nanmean(left**2)))
