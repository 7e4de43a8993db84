"""The heading: jumps and whole turns; beside the yaw rate and beside the track: signs, degrees, minutes."""

from collections.abc import Iterator

import numpy as np

from narrows.logbook import settings
from narrows.logbook.checking.agreement import (
    Estimates,
    EvenMotion,
    Factor,
    changes,
    factor_of,
    least_squares,
    nearest,
    pooled,
)
from narrows.logbook.checking.finding import Examined, Finding, LogStage, log_check

FULL_TURN = 2 * np.pi
DEGREES = 180 / np.pi
# Causes of a factor between the heading's change and the integral of the yaw rate.
RATES = {
    "r counts degrees a second": 1 / DEGREES, "r counts degrees a minute": 1 / (60 * DEGREES),
    "psi counts degrees": DEGREES, "r is 60 times too small": 60.0,
}  # fmt: skip
TURNED = '{} counts to port: turn its sign ([positive] {} = "port")'


@log_check(LogStage.HEADING)
def check_heading(at: Examined) -> Iterator[Finding]:
    """Yield what is wrong with heading and yaw rate, the first cause alone."""
    if "psi" not in at.motion:
        return
    for check in (_wraps, _signs_and_units, _jumps, _no_yaw_rate):
        if found := list(check(at)):
            yield from found
            return


def _steps(at: Examined) -> tuple[np.ndarray, np.ndarray]:
    """Steps of the heading, and the most that a ship turns in their time, with its noise."""
    psi = at.record["psi"]
    steps = np.diff(psi.values)
    noise = 1.4826 * np.median(np.abs(np.diff(steps))) / np.sqrt(6.0) if len(steps) > 2 else 0.0
    return steps, settings.MOST_YAW_RATE * np.diff(
        psi.t
    ) / at.motion.pace + settings.NOISE_FACTOR * noise + settings.COMPASS_STEP


def _wraps(at: Examined) -> Iterator[Finding]:
    steps, most = _steps(at)
    wraps = (np.abs(np.abs(steps) - FULL_TURN) < most) & (most < np.pi / 2)
    if wraps.any() and not ((np.abs(steps) > most) & ~wraps).any():
        count = int(wraps.sum())
        yield at.finding(
            "heading", f"the heading wraps: it jumps by a whole turn {count} times", "np.unwrap it", {"jumps": count}
        )


def _jumps(at: Examined) -> Iterator[Finding]:
    steps, most = _steps(at)
    jumps = np.abs(steps) > most
    if not jumps.any():
        return
    first, largest = at.record["psi"].t[1:][jumps][0], np.degrees(np.abs(steps).max())
    yield at.finding(
        "heading",
        f"the heading jumps by up to {largest:.3g} deg from one value to the next, {int(jumps.sum())} times, first at "
        f"t = {first:.6g} s",
        "look for a compass that was reset, two compasses in turn, or degrees taken as radians",
        {"jumps": jumps.sum(), "first": first, "largest_deg": largest},
    )  # fmt: skip


def _signs_and_units(at: Examined) -> Iterator[Finding]:
    """Heading beside yaw rate and track: what disagrees with both others is wrong."""
    motion = at.motion
    track = _best(_of_track(motion, lengths) for lengths in settings.HEADING_WINDOWS[1:])
    rate = _best(_of_rate(motion, lengths) for lengths in settings.HEADING_WINDOWS) if "r" in motion else None
    off_track = track is not None and track.told and not track.holds(1.0, settings.TRACK_SLACK)
    off_rate = rate is not None and rate.told and not rate.holds(1.0, settings.RATE_SLACK)
    if rate is not None and off_rate:
        yield _beside_rate(at, rate, "psi" if off_track else "r")
    elif track is not None and off_track:
        yield _beside_track(at, track, rate is not None and rate.told)


def _no_yaw_rate(at: Examined) -> Iterator[Finding]:
    """A yaw rate, however noisy, holds the changes of a heading that is clear of its noise."""
    motion = at.motion
    if "r" not in motion:
        return
    turned = changes(motion.heading, motion.windows(1.0))
    if not np.isfinite(turned).any() or not np.nanstd(turned) > settings.CLEAR_OF_NOISE * _noise(motion["psi"]):
        return
    shown = _shown(motion, 1.0)
    if shown and shown.values[0] + settings.SURE * shown.errors[0] < settings.LEAST_SHOWN:
        share, error = shown.values[0], 1.96 * shown.errors[0]
        yield at.finding(
            "yaw rate",
            f"r is not the heading's derivative: it shows {share:.2g} +- {error:.1g} of the heading's changes",
            "look for another column: this may be a roll rate", {"shown": share, "error": shown.errors[0]},
        )  # fmt: skip


def rate_shown(at: Examined) -> Estimates | None:
    """Return how much of the heading's changes the yaw rate shows; None where it is not told."""
    motion = at.motion
    if "r" not in motion or "psi" not in motion:
        return None
    shown = (_shown(motion, lengths) for lengths in settings.HEADING_WINDOWS)
    return min(filter(None, shown), key=lambda told: told.errors[0], default=None)


def _shown(motion: EvenMotion, lengths: float) -> Estimates | None:
    """The share of the heading's changes that the yaw rate shows, and what it shows without."""
    windows = motion.windows(lengths)
    turned = changes(motion.heading, windows)
    return least_squares(motion.integrals(motion["r"], windows), [turned, np.ones(len(turned))])


def judge_yaw_rates(shown: list[tuple[float, float]], record: str) -> Iterator[Finding]:
    """Yield where the yaw rate counts the other way, by what several records show of the heading's changes."""
    # shown (float, float)
    if (told := pooled(shown)) is None:
        return
    share, error, records = told
    if share + settings.SURE * error < 0:
        seen = f"the yaw rate shows {share:.2f} +- {1.96 * error:.2f} of the heading's changes, by {records} records"
        evidence = {"shown": share, "error": error, "records": float(records)}
        yield Finding("yaw rate", record, seen, TURNED.format("r", "r"), evidence)


def _beside_rate(at: Examined, factor: Factor, suspect: str) -> Finding:
    unit = nearest(abs(factor.middle), RATES, 1.3)
    causes = [TURNED.format(suspect, suspect)] if factor.middle < 0 else []
    causes += [f"{unit}: give its unit"] if unit else []
    return at.finding(
        "yaw rate" if suspect == "r" else "heading",
        f"the heading changes by {factor.middle:.3g} times what the yaw rate says, by {_numbers(factor)}",
        "; ".join(causes) or "check unit and calibration of r",
        {"factor": factor.middle, "correlation": factor.correlation, "windows": factor.windows},
    )  # fmt: skip


def _beside_track(at: Examined, factor: Factor, rate_agrees: bool) -> Finding:
    """The track against the heading: with a yaw rate that agrees with the heading, it is the position that is wrong."""
    sign = TURNED.format("y", "y") if rate_agrees else f"{TURNED.format('psi', 'psi')}, or y"
    unit = "psi counts degrees" + (", and r degrees a second" if rate_agrees else "") + ": give its unit"
    return at.finding(
        "heading", f"the track turns {factor.middle:.3g} times as far as the heading, by {_numbers(factor)}",
        sign if factor.middle < 0 else unit if factor.middle < 1 else "check the unit of psi",
        {"factor": factor.middle, "correlation": factor.correlation},
    )  # fmt: skip


def _numbers(factor: Factor) -> str:
    return f"{factor.windows:.0f} windows with a correlation of {factor.correlation:.2f}"


def _of_rate(motion: EvenMotion, lengths: float) -> Factor:
    windows = motion.windows(lengths)
    return factor_of(changes(motion.heading, windows), motion.integrals(motion["r"], windows))


def _of_track(motion: EvenMotion, lengths: float) -> Factor:
    """Ratio of the track's turn to the mean heading's, from each window to the one after the next."""
    windows = motion.windows(lengths)
    way, mean = changes(motion.position, windows), motion.integrals(motion.heading, windows)
    turn = np.angle(way[2:] * np.conj(way[:-2]))
    return factor_of(turn, (mean[2:] - mean[:-2]) / (lengths * motion.pace))


def _best(factors: Iterator[Factor]) -> Factor | None:
    enough = [factor for factor in factors if np.isfinite(factor.low)]
    return max(enough, key=lambda factor: abs(factor.correlation) * np.sqrt(factor.windows), default=None)


def _noise(values: np.ndarray) -> float:
    return float(1.4826 * np.nanmedian(np.abs(np.diff(values, 2))) / np.sqrt(6.0))
