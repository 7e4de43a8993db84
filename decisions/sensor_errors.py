"""Share of the true offsets within the estimator's 95 % band if fixes have slow errors: a table of docs/benchmarks.md.

python decisions/sensor_errors.py [--write]
"""

import math

import numpy as np
from estimation import SENSORS, U, Y, model, track_pilot
from pages import markdown, publish

from narrows.estimation import Estimator, GaussMarkov, Gnss
from narrows.estimation.consistency import sail_twins

TWINS, DURATION, SETTLED = 20, 420.0, 60.0
MULTIPATH, BEGINS, ENDS = 6.0, 200.0, 320.0
"""Error of fixes that are reflected [m], and when it begins and ends [s]: along half a kilometre of the canal."""
WHITE, SLOW = Gnss(1.5, coloured=None), Gnss(0.5, coloured=GaussMarkov(1.5, 60.0))
ERRORS = {
    "white, 1.5 m": (WHITE, 0.0),
    "white 0.5 m, slow 1.5 m over 60 s": (SLOW, 0.0),
    "white 1.5 m, 6 m off for two minutes": (WHITE, MULTIPATH),
}
DECLARED = {
    "`Gnss(1.5)`": Gnss(1.5),
    "`Gnss(0.5, coloured=GaussMarkov(1.5, 60.0))`": SLOW,
}


def covered(true: Gnss, told: Gnss, off: float) -> tuple[float, float, float]:
    """Share of the offsets within the band, root mean square error and standard deviation [m], while the error acts."""
    sailing, one = (Estimator(model(), [own, *SENSORS[1:]]) for own in (true, told))
    pilot = track_pilot(model(), Y, U)
    start = (0.0, Y, U, float(pilot.psi))
    truth = sail_twins(sailing.filter, pilot, start, TWINS, DURATION, True, math.radians(3.0), 31)
    first, last = (BEGINS, ENDS) if off else (SETTLED, DURATION)
    error, std = np.full((2, len(truth.t), TWINS), np.nan)
    for twin in np.flatnonzero(~truth.aground):
        one.forget()
        for number, t in enumerate(truth.t):
            readings = {name: column[number, twin] for name, column in truth.readings.items()}
            readings["gnss"] = readings["gnss"] + np.array([0.0, off * (BEGINS <= t < ENDS)])
            now = one.update(float(t), {**readings, "rudder": truth.indicated[number, twin, 0]})
            if now.ready and first <= t < last:
                error[number, twin], std[number, twin] = now["y"] - truth.states[number, twin, 1], now.std["y"]
    inside, known = np.abs(error) <= 1.959964 * std, np.isfinite(error)
    return float(inside.sum() / known.sum()), float(np.sqrt(np.nanmean(error**2))), float(np.nanmean(std))


def text(chosen: tuple[str, ...] = tuple(ERRORS)) -> str:
    """One row for each error of the fixes, or those chosen: a column a declaration."""
    header = ("error of the fixes", *DECLARED)
    rows = []
    for error, (true, off) in ((error, ERRORS[error]) for error in chosen):
        found = (covered(true, told, off) for told in DECLARED.values())
        rows.append((error, *(f"{100 * share:.0f} %, {rmse:.1f}, {1.96 * std:.1f}" for share, rmse, std in found)))
    return markdown(header, rows)


if __name__ == "__main__":
    publish(__file__, "benchmarks.md", text())
