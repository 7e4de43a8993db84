"""KVLCC2 learned from the zigzags of one tank, judged on the circles and zigzags of another.

python decisions/kvlcc2_log.py [FOLDER] [--write]

FOLDER, or ``shared/data/kvlcc2_free_running`` beside the repository, holds ``hsva``: the free-running tests of SIMMAN
2008 as published by github.com/martinlarsalbert/System-identification-of-Vessel-Manoeuvring-Models, public and not ours
to pass on. The rudder is written positive to port there, and the velocities are those of the positions, so that
positions, heading and yaw rate are taken. Of MARIN's tests nothing enters but the judgement (``manoeuvres.py``).
"""

import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from manoeuvres import APPROACH, CIRCLES, OVERSHOOTS
from pages import markdown, publish
from scipy.signal import savgol_filter

import narrows as nw
from narrows.logbook.filtering.likelihood import SearchResult, search
from narrows.logbook.learned_coefficients import with_spread
from narrows.logbook.learning.learn_log import log_result
from narrows.logbook.learning.log_setup import log_problem
from narrows.ship.actuators import Actuator

FOLDER = Path(__file__).parents[2] / "shared" / "data" / "kvlcc2_free_running"
DEGREE = np.pi / 180
SPREADS = (0.1, 0.2, 0.3, 0.5, 0.8)
"""Of the published coefficients, over their size."""
SPREAD, CORRELATED = 0.2, 200.0
"""Of equation error, and readings for each independent one in the marginal likelihood."""
SMOOTHED, ORDER = (2.0,), 3
"""Seconds over which equation error smooths, and the order of its polynomials."""
STEP = 0.1
"""Of even times, for smoothing [s]."""


def hsva(folder: Path) -> list[nw.ShipRecord]:
    """Zigzags of a 7 m model, 20 times a second."""
    records = []
    for path in sorted((folder / "hsva").glob("*.dat")):
        t, x, y, psi, _, _, r, _, rudder, turns = np.loadtxt(path, skiprows=4, encoding="cp1252")[:, :10].T
        told = {"x": x, "y": y, "psi": psi * DEGREE, "r": r * DEGREE, "rudder": -rudder * DEGREE, "revolutions": turns}
        t, once = np.unique(t, return_index=True)
        name = path.stem.removeprefix("HSVA_CPMC_KVLCC2_")
        records.append(nw.ShipRecord(name, {own: nw.Signal(t, column[once]) for own, column in told.items()}))
    return records


def smoothed(model: nw.Model, records: Iterable[nw.ShipRecord], seconds: float, spread: float) -> nw.Model:
    """The rival: velocities and accelerations by smoothing, then one regression of the balance of forces."""
    sizes = np.diag(with_spread(model, spread).covariance)
    names = [n for n, size in zip(model.terms.names, sizes, strict=True) if size]
    rows, right, force_of = [], [], []
    for record in records:
        values = _smoothed_motion(model, record, seconds)
        for place, terms in enumerate(model.terms.forces.values()):
            columns = {term.name: np.broadcast_to(term.column(values), values["u"].shape) for term in terms}
            rows.append(np.stack([columns.get(name, 0 * values["u"]) for name in names], axis=1))
            right.append(-sum(model[name] * column for name, column in columns.items() if name not in names))
            force_of.append(np.full(len(values["u"]), place))
    matrix, target, force = np.concatenate(rows), np.concatenate(right), np.concatenate(force_of)
    mean = np.array([model[name] for name in names])
    size, theta = np.array([target[force == place].std() or 1.0 for place in range(3)]), mean
    for _ in range(3):
        weighed = np.vstack([matrix / size[force][:, None], np.diag(1 / (spread * np.abs(mean)))])
        theta = np.linalg.lstsq(weighed, np.append(target / size[force], np.sign(mean) / spread), rcond=None)[0]
        left = matrix @ theta - target
        size = np.array([left[force == place].std() for place in range(3)])
    return model.with_coefficients(**dict(zip(names, theta.tolist(), strict=True)))


def _smoothed_motion(model: nw.Model, record: nw.ShipRecord, seconds: float) -> dict[str, np.ndarray]:
    t = np.arange(record.start, record.stop, STEP)
    width = round(seconds / STEP) // 2 * 2 + 1

    def at(name: str, order: int = 0) -> np.ndarray:
        column = np.interp(t, record[name].t, record[name].values)
        return savgol_filter(column, width, ORDER, deriv=order, delta=STEP)

    psi, r = at("psi"), at("r")
    cosine, sine = np.cos(psi), np.sin(psi)
    rates, second = [at("x", 1), at("y", 1)], [at("x", 2), at("y", 2)]
    u, v = rates[0] * cosine + rates[1] * sine, rates[1] * cosine - rates[0] * sine
    turned = second[0] * cosine + second[1] * sine + v * r, second[1] * cosine - second[0] * sine - u * r
    moving = {"u": u, "v": v, "r": r, "udot": turned[0], "vdot": turned[1], "rdot": at("r", 1), "heave": 0.0}
    actuators: dict[str, Actuator] = {actuator.name: actuator for actuator in model.terms.actuators}
    placed = {
        name: value
        for own in ("rudder", "revolutions")
        for name, value in actuators[own].placed(np.interp(t, record[own].t, record[own].values)).items()
    }
    return {**model.configuration.values(), "psi": psi, **moving, **placed}


def judged(words: str, model: nw.Model) -> tuple[str, ...]:
    """Advance and tactical diameter to either side, and the overshoots of four zigzags."""
    found = nw.sail_trials(model, APPROACH).to_dict()
    circles = []
    for order, measured in CIRCLES.items():
        for name, value in (("advance", measured[0]), ("tactical_diameter", measured[2])):
            circles.append(100 * (found["turning"][order][f"{name}_over_length"] / value - 1))
    off = [
        found["zigzags"][order]["overshoots_deg"][place] - value
        for order, measured in OVERSHOOTS.items()
        for place, value in enumerate(measured)
    ]
    root = float(np.sqrt(np.mean(np.square(off))))
    return (words, *(f"{value:+.0f} %" for value in circles), f"{root:.1f}")


def learned(published: nw.Model, records: list[nw.ShipRecord], spread: float) -> tuple[str, ...]:
    """Judge the model of a spread; its marginal likelihood, and the headings it misses of zigzags left out."""
    setup = log_problem(published, records, "basin", spread=spread)
    found = search(setup.problem, setup)
    fit = log_result(setup, found, ())
    missed = np.degrees(fit.whole_missed["after"])
    return (*judged(f"learned, spread {spread:g}", fit.model), f"{missed:.2f}", f"{evidence(found):.0f}")


def evidence(found: SearchResult) -> float:
    """Minus twice the logarithm of the marginal likelihood, to a constant, by Laplace's approximation."""
    share, precision = found.problem.correlated / CORRELATED, found.problem.precision
    cost = share * sum(one.cost for one in found.records) + found.unknowns @ precision @ found.unknowns
    after = precision + share * found.information
    return float(cost + np.linalg.slogdet(after)[1] - np.linalg.slogdet(precision)[1])


def text(folder: Path = FOLDER) -> str:
    """One table."""
    published, records = nw.published("yasukawa2015_kvlcc2"), hsva(folder)
    rows = [(*judged("as published, from captive tests", published), "", "")]
    rows += [learned(published, records, spread) for spread in SPREADS]
    for seconds in SMOOTHED:
        rival = smoothed(published, records, seconds, SPREAD)
        words = f"equation error, smoothed over {seconds:g} s, spread {SPREAD:g}"
        rows.append((*judged(words, rival), "", ""))
    heads = [f"{name} {order}" for order in CIRCLES for name in ("advance", "tactical diameter")]
    others = ("overshoots, rms [deg]", "headings of left-out zigzags, rms [deg]", "-2 ln marginal likelihood")
    return markdown(("model", *heads, *others), rows)


if __name__ == "__main__":
    folder = next((Path(word) for word in sys.argv[1:] if not word.startswith("--")), FOLDER)
    if not (folder / "hsva").is_dir():
        raise SystemExit(f"{folder} has no hsva in it; give the folder that has")
    publish(__file__, "learning.md", text(folder))
