"""Speeds beside the way made good: axes, signs, knots, a course or a log that says something else."""

from collections.abc import Iterator, Mapping

import numpy as np

from narrows.logbook import settings
from narrows.logbook.checking.agreement import Turned, changes, factor_of, nearest, turned_of
from narrows.logbook.checking.finding import Examined, Finding, LogStage, log_check
from narrows.quantities.names import KNOT

# The way over what its speed says, where that is in another unit.
UNITS = {"knots": KNOT, "kilometres an hour": 1 / 3.6, "metres a second read as knots": 1 / KNOT}


@log_check(LogStage.MOTION)
def check_velocities(at: Examined) -> Iterator[Finding]:
    if not np.isfinite(at.motion.position).any():
        return
    yield from _over_ground(at)
    yield from _by_course(at)
    yield from _through_water(at)


def _ways(at: Examined, velocities: Mapping[str, np.ndarray]) -> dict[str, Turned]:
    """Return the agreement of the way made good with velocities on the map, by how these are read."""
    windows = at.motion.windows(settings.VELOCITY_WINDOW)
    way = changes(at.motion.position, windows)
    found = {name: turned_of(way, at.motion.integrals(column, windows)) for name, column in velocities.items()}
    return {name: turned for name, turned in found.items() if turned is not None}


def _over_ground(at: Examined) -> Iterator[Finding]:
    motion = at.motion
    if not {"u_ground", "v_ground", "psi"} <= motion.columns.keys():
        return
    told, ahead, line = (
        motion["u_ground"] + 1j * motion["v_ground"],
        np.exp(1j * motion["psi"]),
        np.exp(1j * motion.axis),
    )
    readings = {
        "": told * ahead * line,
        "they are along x and y, not along the ship: call them x_rate and y_rate": told * line,
        "they are to north and east, not along the ship: call them north_rate and east_rate": told,
        "they are along the ship already: call them u_ground and v_ground": told * ahead**2 * line,
        'v_ground counts to port: [positive] v_ground = "port"': np.conj(told) * ahead * line,
        'psi counts to port: [positive] psi = "port"': told * np.conj(ahead) * line,
        'y counts to port: [positive] y = "port"': np.conj(told * ahead) * line,
        "psi counts degrees: head it 'psi [deg]'": told * np.exp(1j * np.radians(motion["psi"])) * line,
    }
    yield from _read_otherwise(at, "velocity over ground", "u_ground and v_ground", _ways(at, readings))


def _by_course(at: Examined) -> Iterator[Finding]:
    motion = at.motion
    if not {"speed_over_ground", "course"} <= motion.columns.keys():
        return
    speed, course, line = motion["speed_over_ground"], motion["course"], np.exp(1j * motion.axis)
    readings = {
        "": speed * np.exp(1j * course) * line,
        'course counts to port: [positive] course = "port"': speed * np.exp(-1j * course) * line,
        "course counts degrees: head it 'course [deg]'": speed * np.exp(1j * np.radians(course)) * line,
        "course is from north: call it course_over_ground": speed * np.exp(1j * course),
    }
    yield from _read_otherwise(at, "speed over ground", "speed_over_ground and course", _ways(at, readings))


def _read_otherwise(at: Examined, check: str, what: str, ways: Mapping[str, Turned]) -> Iterator[Finding]:
    """Yield faults of velocities, by their agreement with the way as recorded and as otherwise read."""
    if "" not in ways:
        return
    told, best = ways[""], min(ways, key=lambda name: ways[name].apart)
    evidence = {"apart": told.apart, "stretch": told.stretch, "turn_deg": np.degrees(told.turn)}
    if told.apart > settings.UNEXPLAINED and told.apart > settings.READING_BETTER * ways[best].apart:
        alike = [name for name, way in ways.items() if way.apart < settings.READING_ALIKE * ways[best].apart]
        yield at.finding(
            check, f"{what} leave {told.apart:.1%} of the way made good unexplained, {ways[best].apart:.1%} if read "
            "otherwise",
            ", or ".join(alike), {**evidence, "apart_otherwise": ways[best].apart},
        )  # fmt: skip
        told = ways[best]
    elif told.apart > settings.DISAGREEMENT:
        yield at.finding(
            check, f"{what} leave {told.apart:.0%} of the way made good unexplained", "look for other columns", evidence
        )
        return
    yield from _stretched(at, check, what, told)
    if abs(told.turn) > settings.MISALIGNED + 4 * told.error:
        yield at.finding(
            check, f"the way made good is {np.degrees(told.turn):.3g} deg off what {what} say",
            "check where headings are measured from, the compass's zero and the signs of the velocities", evidence,
            wrong=abs(told.turn) > settings.WRONG_TURN,
        )  # fmt: skip


def _stretched(at: Examined, check: str, what: str, told: Turned) -> Iterator[Finding]:
    if not abs(np.log(told.stretch)) > np.log(settings.SPEED_SLACK) + 4 * told.error:
        return
    unit = nearest(told.stretch, UNITS)
    yield at.finding(
        check, f"the way made good is {told.stretch:.3g} times what {what} say",
        f"they look like {unit}: give the unit" if unit else "check the unit of the speed", {"stretch": told.stretch},
    )  # fmt: skip


def _through_water(at: Examined) -> Iterator[Finding]:
    """Surge by its mean, which a current moves too; sway by how it changes."""
    motion = at.motion
    if "psi" not in motion or "u" not in motion:
        return
    windows = motion.windows(settings.VELOCITY_WINDOW)
    ground = np.gradient(motion.position, motion.dt) * np.exp(-1j * motion.heading)
    known = np.isfinite(ground.real + motion["u"])
    if not known.any():
        return
    mean, through = float(np.mean(ground.real[known])), float(np.mean(motion["u"][known]))
    if through != 0 and abs(mean - through) > settings.MOST_CURRENT * abs(mean):
        unit = nearest(mean / through, UNITS, 1.25)
        yield at.finding(
            "speed through the water", f"the mean of u is {through:.3g} m/s, and {mean:.3g} m/s over ground",
            f"it looks like {unit}: give the unit" if unit else "check its sign and unit: no current is so strong",
            {"through": through, "over_ground": mean},
        )  # fmt: skip
    if "v" not in motion:
        return
    factor = factor_of(motion.integrals(motion["v"], windows), motion.integrals(ground.imag, windows))
    if factor.told and factor.high < 0:
        yield at.finding(
            "speed through the water", f"v is {factor.middle:.3g} times the sway velocity over ground, by "
            f"{factor.windows:.0f} windows with a correlation of {factor.correlation:.2f}",
            'v counts to port: [positive] v = "port"', {"factor": factor.middle, "correlation": factor.correlation},
        )  # fmt: skip
