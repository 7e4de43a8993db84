"""Steady legs to either side: what they would teach of a 400 m ship, and on twins of many kinds how often it is right.

python decisions/steady.py [--write]

The ship is the KCS as identified from measured tests, at 399.94 m in a canal 205 m wide (``suez.py``). Twins are drawn
from the covariance of its tests; those that need more rudder than a leg may are broken off and not counted.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from pages import Rows, markdown, part, publish, records
from suez import CLEARANCES, measured

import narrows as nw
from narrows.control import regulator
from narrows.logbook.settings import SETTLING
from narrows.logbook.steady_readings import left_over, reading_error, shared_errors
from narrows.quantities.names import KNOT
from narrows.simulation.grid import sampled

TWINS, SAILED, LONG = 200, 100, 2000
SPEED, FAR = 8 * KNOT, (5.0, 20.0)
"""Of the legs, and the offsets at which the rudder is predicted: where they were held, and four times as far."""
LEGS = (5.0, -5.0, -5.0, 5.0)
KEPT = 2.0
"""How far from its line a ship is held, standard deviation [m]."""
GUST, LEVER, MEMORY, PIECE = 1.5e5, 25.0, 40.0, 5.0
"""Of gusts: force [N], lever [m], how long they last and how long one piece of a schedule is [s]."""
MOST = np.radians(35.0 * 2 / 3)
RANGE = (0.05, 0.5, 0.95)


@dataclass(frozen=True)
class Kind:
    """What a twin has that the answer does not know.

    Parameters
    ----------
    words : str
        For the table.
    legs : tuple of float [m]
        Offsets.
    wind_change : float [1]
        From leg to leg; 0.2 is what the answer takes.
    rudder_zero : float [deg]
        Standard deviation; 1 is what the answer takes.
    gain : float [1]
        Of the rudder's indicator.
    shifted : float [m]
        How far the banks are from where they are thought to be.
    form : str
        Of the bank; as strong as the model's at the offset of the legs.
    bank : float [1]
        What the bank's coefficients are multiplied by.
    sailed : bool
        Whether a regulator in gusts sails each leg, who does not know the coefficients.
    thrust : float [1]
        Of what keeps the speed, for legs that are sailed.
    """

    words: str
    legs: tuple[float, ...] = LEGS
    wind_change: float = 0.2
    rudder_zero: float = 1.0
    gain: float = 1.0
    shifted: float = 0.0
    form: str = "delta"
    bank: float = 1.0
    sailed: bool = False
    thrust: float = 1.0


KINDS = (
    Kind("default assumptions"),
    Kind("two legs only", legs=(5.0, -5.0)),
    Kind("all legs on one side", legs=(5.0, 5.0, 5.0, 5.0)),
    Kind("wind changes by half of what it is", wind_change=0.5),
    Kind("wind changes by as much as it is", wind_change=1.0),
    Kind("rudder reads 5 degrees wrong", rudder_zero=5.0),
    Kind("rudder reads a tenth too much", gain=1.1),
    Kind("banks 3 m from where they are thought", shifted=3.0),
    Kind("banks 5 m from where they are thought", shifted=5.0),
    Kind("bank of the form y_B", form="distance"),
    Kind("bank of the form with the keel's gap", form="keel_gap"),
    Kind("no bank at all", bank=0.0),
    Kind("sailed by a regulator in gusts", sailed=True),
    Kind("the same, the speed falling", sailed=True, thrust=0.6),
)


@cache
def hulls() -> dict[str, nw.Model]:
    """The KCS at three clearances."""
    return measured()


def reported() -> str:
    """What two legs at 10 m and 10 knots would teach, rudder known to 1 degree and drift to 0.2."""
    rows = []
    for label, model in hulls().items():
        for words, conditions in TAKEN:
            held = nw.steady_course(model, y=10.0, u=10 * KNOT, heave=nw.squat(model.configuration, 10 * KNOT).sinkage)
            read = {"y": [10.0, -10.0], "u": [10 * KNOT] * 2}
            read |= {name: [float(held[angle]), -float(held[angle])] for name, angle in ANGLES.items()}
            fit = nw.learn_steady(model, read, conditions=conditions)
            cells = (f"{fit.coefficients[name].prior_std:.3f} to {fit.std[name]:.3f}" for name in ("c_bank", "b_bank"))
            angles = (band(found, 10.0, 10 * KNOT) for found in (model, fit.model))
            rows.append((CLEARANCES[label], words, *cells, *(f"{low} to {high}" for low, _, high in angles)))
    heads = "clearance", "errors assumed", "c_bank", "b_bank", "rudder at 10 m before [deg]", "after [deg]"
    return markdown(heads, rows)


ANGLES = {"rudder": "rudder", "drift": "psi"}
TAKEN = (
    ("default", nw.SteadyConditions()),
    ("exact offset and speed, no remaining motion",
     nw.SteadyConditions(wind_change=0.0, y_zero=0.0, yaw_rate_deg=0.0, yaw_change_deg=0.0, sway_change=0.0,
                         y_error=0.0, u_error=0.0)),
)  # fmt: skip


def band(model: nw.Model, y: float, u: float) -> list[str]:
    """The rudder of 5 %, half and 95 % of the samples [deg]."""
    angle = np.degrees(nw.steady_course(model, y=y, u=u, samples=LONG)["rudder"].to_numpy())
    limit = model.configuration.gear.limit_deg
    ordered = np.quantile(np.where(np.isnan(angle), np.inf, angle), RANGE, method="higher")
    return [f"{value:+.1f}" if abs(value) <= limit else "beyond the gear" for value in ordered]


def twins(kind: Kind, count: int, seed: int = 0) -> Iterator[tuple[dict[str, Any], nw.Model]]:
    """Readings of twins, and their truths, so many or fewer where legs were broken off."""
    model, draw = hulls()["C0101A02"], np.random.default_rng(seed)
    truths = [truth_of(model, kind, values) for values in drawn(model, count, seed)]
    for truth in truths:
        read = _sailed(truth, kind, draw) if kind.sailed else _held(truth, kind, draw)
        if read is not None:
            yield read, truth


def drawn(model: nw.Model, count: int, seed: int) -> Iterator[dict[str, float]]:
    """Coefficients from the covariance of the tests."""
    columns = {name: column.to_numpy() for name, column in sampled(model, count, seed).items()}
    for i in range(count):
        yield {name: float(column[i]) for name, column in columns.items()}


def truth_of(model: nw.Model, kind: Kind, values: dict[str, float]) -> nw.Model:
    """A ship of such coefficients, whose bank is of another form, or none."""
    terms = table(kind.form)
    other = replace(model, terms=terms, covariance=None, verdicts={})
    at = nw.Motion(y=max(kind.legs), u=SPEED)
    strong, weak = (abs(one.with_coefficients(b_bank=1.0).bank_forces(at)["Y"]) for one in (model, other))
    bank = {name: values[name] * kind.bank * strong / weak for name in ("b_bank", "c_bank")}
    return other.with_coefficients(**{**values, **bank})


@cache
def table(form: str) -> nw.TermTable:
    """The terms with another form of the bank."""
    own = hulls()["C0101A02"].terms
    return nw.with_bank(own, form, own.name)


def _held(truth: nw.Model, kind: Kind, draw: np.random.Generator) -> dict[str, Any] | None:
    """Steady legs by the balance, with wind, zeros, a rest of motion and errors; None where one is broken off."""
    legs, conditions = len(kind.legs), nw.SteadyConditions()
    shared, left = shared_errors(conditions, truth), left_over(conditions, truth)
    common = shared[:2] * draw.standard_normal(2)
    change = kind.wind_change * shared[:2] * draw.standard_normal((legs, 2))
    # A rest of acceleration is a force the other way; what is left of turning is a tenth of it, and left out here.
    mass = np.array([truth["b_vdot"], truth["c_rdot"]])
    push = common + change + mass * left[3:] * draw.standard_normal((legs, 2))
    y = np.array(kind.legs) + KEPT * draw.standard_normal(legs)
    u = SPEED + 0.1 * draw.standard_normal(legs)
    aside = kind.shifted or shared[-1] * draw.standard_normal()
    columns = {"y": y + aside, "u": u, "Y": push[:, 0], "N": push[:, 1], "heave": _heave(truth, u)}
    held = nw.steady_course(truth, **{name: xr.DataArray(column, dims="leg") for name, column in columns.items()})
    if not (np.abs(held["rudder"]) <= MOST).all():
        return None
    return _read(y, u, held["rudder"].to_numpy(), held["psi"].to_numpy(), kind, draw)


def _heave(model: nw.Model, speeds: np.ndarray) -> np.ndarray:
    return np.array([nw.squat(model.configuration, float(speed)).sinkage for speed in speeds])


def _sailed(truth: nw.Model, kind: Kind, draw: np.random.Generator) -> dict[str, Any] | None:
    """Legs that a regulator holds in gusts, with the time to settle of a plan and two minutes to read."""
    model, conditions = hulls()["C0101A02"], nw.SteadyConditions()
    wind = shared_errors(conditions, truth)[:2] * draw.standard_normal(2)
    settling = SETTLING * model.configuration.ship.length / SPEED
    told: dict[str, Any] = {"u": SPEED, "duration": settling + conditions.leg_time, "dt": 1.0}
    if kind.thrust != 1.0:
        whole = truth.resistance(SPEED, rudder=0.0)
        told |= {"surge": "free", "surge_inertia": 1.05 * float(mass_of(truth)), "X": kind.thrust * whole}
    means = []
    for offset in kind.legs:
        gust = _gusts(told["duration"], draw)
        pushes = {name: [(t, wind[i] + lever * force) for t, force in gust]
                  for i, (name, lever) in enumerate((("Y", 1.0), ("N", LEVER)))}  # fmt: skip
        voyage = nw.simulate(truth, y=offset, controller=law(offset), **pushes, **told)
        read = voyage.t > told["duration"] - conditions.leg_time
        if voyage.t[-1] < told["duration"] or np.abs(voyage.rudder[read]).max() > MOST:
            return None
        drift = -np.arctan2(voyage.v, voyage.u)  # Heading less course, which is not that of the canal.
        means.append([part[read].mean() for part in (voyage.y, voyage.u, voyage.rudder, drift)])
    y, u, rudder, drift = np.array(means).T
    return {**_read(y, u, rudder, drift, kind, draw), "heave": np.zeros(len(y))}


def mass_of(model: nw.Model) -> float:
    """Displacement [kg]."""
    ship = model.configuration.ship
    return ship.length * ship.beam * ship.draft * ship.block_coefficient * model.configuration.water.density


@cache
def law(offset: float) -> Any:
    """A regulator made for the most likely coefficients."""
    return regulator(hulls()["C0101A02"], offset, SPEED)


def _gusts(duration: float, draw: np.random.Generator) -> list[tuple[float, float]]:
    """A force with a memory, in pieces [N]."""
    times, force = np.arange(0.0, duration, PIECE), GUST * draw.standard_normal()
    kept, pieces = np.exp(-PIECE / MEMORY), []
    for t in times.tolist():
        pieces.append((t, float(force)))
        force = kept * force + GUST * np.sqrt(1 - kept**2) * draw.standard_normal()
    return pieces


def _read(
    y: np.ndarray, u: np.ndarray, rudder: np.ndarray, psi: np.ndarray, kind: Kind, draw: np.random.Generator
) -> dict[str, Any]:
    """What instruments show of legs."""
    zeros = np.radians([kind.rudder_zero, nw.SteadyConditions().drift_zero_deg]) * draw.standard_normal(2)
    true = {"y": y, "u": u, "rudder": kind.gain * rudder + zeros[0], "drift": psi + zeros[1]}
    errors = {name: reading_error(nw.SteadyConditions(), name) for name in true}
    return {name: column + errors[name] * draw.standard_normal(len(column)) for name, column in true.items()}


@dataclass(frozen=True)
class Score:
    """Of one twin: which intervals hold the truth, and what is called.

    Parameters
    ----------
    coefficients : tuple of bool
        b_bank and c_bank.
    rudders : tuple of bool
        At the offsets ``FAR``.
    std : float [1]
        Of c_bank.
    learned, contradicted, resolved : bool
        c_bank is called learned; the legs are called a contradiction; the interval of c_bank excludes 0.
    """

    coefficients: tuple[bool, bool]
    rudders: tuple[bool, ...]
    std: float
    learned: bool
    contradicted: bool
    resolved: bool


def score(read: dict[str, Any], truth: nw.Model, kind: Kind) -> Score:
    """What the legs teach of a twin, beside the twin."""
    fit = nw.learn_steady(hulls()["C0101A02"], read)
    inside = tuple(low <= truth[name] <= high for name, (low, high) in fit.intervals.items()
                   if name in ("b_bank", "c_bank"))  # fmt: skip
    heave = float(_heave(truth, np.array([SPEED]))[0])
    at = {"y": xr.DataArray(np.array(FAR), dims="place"), "u": SPEED, "heave": heave}
    predicted = nw.steady_course(fit.model, samples=200, **at)["rudder"].transpose("place", "sample").to_numpy()
    low, high = np.quantile(np.where(np.isnan(predicted), np.inf, predicted), (0.025, 0.975), axis=1, method="higher")
    true = np.nan_to_num(nw.steady_course(truth, **at)["rudder"].to_numpy(), nan=np.inf)
    c_bank = fit.coefficients["c_bank"]
    return Score(
        inside, tuple(((low <= true) & (true <= high)).tolist()), c_bank.std, c_bank.status == "learned",
        fit.contradicted, not c_bank.unresolved,
    )  # fmt: skip


def row(kind: Kind, count: int | None = None) -> tuple[str, ...]:
    """A kind's shares over its twins."""
    tried = count or (SAILED if kind.sailed else TWINS)
    scores = [score(read, truth, kind) for read, truth in twins(kind, tried, KINDS.index(kind))]
    held, contradicted = len(scores), np.mean([one.contradicted for one in scores])
    scores = [one for one in scores if not one.contradicted]

    def share(of: Callable[[Score], bool]) -> str:
        return f"{100 * np.mean([of(one) for one in scores]):.0f} %"

    own = [share(lambda one, i=i: one.coefficients[i]) if kind.form == "delta" else "-" for i in (1, 0)]
    return (
        kind.words, f"{held} of {tried}", f"{100 * contradicted:.0f} %", *own,
        *(share(lambda one, i=i: one.rudders[i]) for i in range(len(FAR))),
        f"{np.median([one.std for one in scores]):.4f}", share(lambda one: one.learned),
        share(lambda one: one.resolved),
    )  # fmt: skip


HEADS = (
    "twins", "held", "called contradicted", "c_bank covered", "b_bank", "rudder at 5 m", "at 20 m",
    "standard error of c_bank", "learned", "interval of c_bank excludes 0",
)  # fmt: skip


def text() -> str:
    """Two tables."""
    return f"{reported()}\n\n{markdown(HEADS, [row(kind) for kind in KINDS])}"


def shown(rows: Rows) -> str:
    """The first table with default errors."""
    first = [row for row in records(rows, "clearance") if row["errors assumed"] == "default"]
    return part(first, *(name for name in first[0] if name != "errors assumed"))


def figure() -> Figure:
    """The legs of the KCS at 50 % clearance."""
    return nw.plan_steady(hulls()["C0101A02"], speeds=[SPEED]).plot()


if __name__ == "__main__":
    publish(__file__, "benchmarks.md", text(), shown)
