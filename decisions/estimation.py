"""An estimator on twins, two ways with its coefficients: the table and figure of docs/benchmarks.md.

Particle filters are left out. They were tried with nine states, 2000 particles, and with the strength of the bank by a
Kalman filter of its own in each particle: beside sensors this good they degenerate: a few carry all the weight.

python decisions/estimation.py [--write]
"""

import math
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from pages import markdown, publish
from scipy.special import chdtri

import narrows as nw
from narrows.captive.measured import measured_files
from narrows.estimation import (
    Consistency,
    EstimatedTrack,
    Estimator,
    Gnss,
    Gyro,
    Log,
    RateOfTurn,
    RudderIndicator,
    consistency,
)
from narrows.estimation.consistency import sail_twins
from narrows.estimation.states import described
from narrows.model.tables import table_named
from narrows.report.figures import IN_DEGREES, SHOWN

sys.path.append(str(Path(__file__).parent.parent / "benchmarks"))
from scenes.helms import track_pilot

TURNED = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"
SENSORS = (Gnss(), Gyro(math.radians(0.2)), RateOfTurn(math.radians(0.03)), Log(), RudderIndicator())
WAYS = ("certain", "estimated")
Y, U, TWINS = 50.0, 4.5, 4
BEGUN, SPOOF, LENGTH = 150.0, 0.5, 240.0
"""When faults begin [s], the speed of the spoof [m/s], and how long twins with faults sail [s]."""
Fault = Callable[[float, dict[str, Any]], dict[str, Any]]


@cache
def model() -> nw.Model:
    """The KCS of the measured tests with a rudder, 230 m long, in a canal 300 m wide and 16.2 m deep."""
    terms = table_named("speed+helm")
    tests = nw.read_captive(*measured_files("kcs"), TURNED).by_condition()["C0101A02"]
    fit = nw.identify(tests, terms)
    return nw.scale_model(fit.model, length=230.0, density=1025.0, width=300.0, depth=16.2).model


def moved(across: Callable[[float], float]) -> Fault:
    """Fixes moved to starboard by a distance that depends on the time since the fault began."""

    def fault(t: float, readings: dict[str, Any]) -> dict[str, Any]:
        return {**readings, "gnss": readings["gnss"] + np.array([0.0, across(t - BEGUN) if t >= BEGUN else 0.0])}

    return fault


def silent(t: float, readings: dict[str, Any]) -> dict[str, Any]:
    """No fixes for a minute."""
    return {name: told for name, told in readings.items() if name != "gnss" or not BEGUN <= t < BEGUN + 60.0}


jump = moved(lambda since: 50.0 * (since < 20.0))
spoof = moved(lambda since: SPOOF * since)


def tried(way: str, **told: Any) -> Consistency:
    """Twins, each the same whatever the filter does with its coefficients."""
    return consistency(model(), SENSORS, Y, U, twins=TWINS, coefficients=way, **told)


def largest(way: str, fault: Fault) -> str:
    """Median and worst of the twins' largest error across, from the fault on [m]."""
    found = tried(way, seed=21, duration=LENGTH, fault=fault)
    worst = np.abs(found.error[:, found.t >= BEGUN, 1]).max(axis=1)
    return f"{np.median(worst):.1f}, {worst.max():.1f}"


def drifted(way: str) -> str:
    """Median and worst drift at which the spoof was told [m]."""
    found = tried(way, seed=21, duration=LENGTH, fault=spoof)
    told = found.suspected["gnss"][:, found.t >= BEGUN]
    drift = np.where(told.any(axis=1), SPOOF * told.argmax(axis=1), math.inf)
    worst = f"{drift.max():.1f}" if np.isfinite(drift).all() else f"{int(np.isinf(drift).sum())} of {len(drift)} never"
    return f"{np.median(drift):.1f}, {worst}"


def row(way: str) -> tuple[str, ...]:
    """All measures of one way."""
    true, drawn = tried(way, seed=11), tried(way, seed=11, drawn=True)
    false = sum(
        int(np.any([flag.any(axis=1) for flag in own.suspected.values()], axis=0).sum()) for own in (true, drawn)
    )
    nees = (
        f"{true.mean_nees:.2f}",
        f"{np.nanmedian(drawn.nees[:, drawn.counted]) / chdtri(len(drawn.states), 0.5):.2f}",
    )
    faults = (largest(way, jump), largest(way, silent), drifted(way))
    return (f"`{way}`", *nees, f"{drawn.rmse['y']:.2f}", *faults, f"{false} of {len(true.nees) + len(drawn.nees)}")


def text(ways: tuple[str, ...] = WAYS) -> str:
    """The table, or the rows of some ways."""
    header = (
        "coefficients", "mean NEES, true", "median NEES, drawn", "error across, drawn [m]", "50 m jump [m]",
        "60 s without fixes [m]", "drift of the fixes when reported [m]", "twins with a false alarm",
    )  # fmt: skip
    return markdown(header, [row(way) for way in ways])


def told_to_bridge() -> tuple[EstimatedTrack, np.ndarray]:
    """One twin with a jump, a minute of silence and a spoof: its estimate and its truth."""
    one, pilot = Estimator(model(), SENSORS), track_pilot(model(), Y, U)
    start = (0.0, Y, U, float(pilot.psi))
    twins = sail_twins(one.filter, pilot, start, TWINS, 540.0, True, math.radians(3.0), 11)
    twin = int(np.argmin(twins.aground))
    t, rudder = twins.t, twins.indicated[:, twin, 0]
    records = {"t": t, "rudder": rudder}
    for name, sensor in one.filter.sensors.items():
        records |= {field: twins.readings[name][:, twin, k].copy() for k, field in enumerate(sensor.fields)}
    records["gnss_y"][(t >= 200.0) & (t < 220.0)] += 50.0
    records["gnss_x"][(t >= 300.0) & (t < 360.0)] = math.nan
    records["gnss_y"] += SPOOF * np.maximum(t - 500.0, 0.0)
    track = one.run(records)
    return track, twins.states[len(t) - len(track.t) :, twin]


def figure() -> Any:
    """Estimate, truth and band of that twin."""
    track, truth = told_to_bridge()
    drawn = track.plot()
    for axes, name in zip(drawn.axes, (name for name in SHOWN if name in track.states), strict=True):
        factor = IN_DEGREES.get(described(name)[0], ("", 1.0))[1]
        axes.plot(track.t, factor * truth[:, track.states.index(name)], "k--", linewidth=1.0)
    return drawn


if __name__ == "__main__":
    publish(__file__, "benchmarks.md", text())
