"""Predict the information on the bank coefficients from future transits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, check_count
from narrows.base.progress import bar, is_shown
from narrows.base.results import Tabulated
from narrows.control.steady_course import check_rudder
from narrows.logbook import settings
from narrows.logbook.filtering.likelihood import FIRST_PASSES, scored
from narrows.logbook.filtering.log_problem import SWAY, YAW
from narrows.logbook.learned_coefficient import ON_TWINS, learnable
from narrows.logbook.learning.log_posterior import check_covariance, expected_std
from narrows.logbook.learning.log_setup import LogSetup, log_problem
from narrows.logbook.sensor_grades import SensorGrade, sensor_grade
from narrows.logbook.ship_log import ShipLog
from narrows.logbook.steady_legs.plan_steady import usual_speeds
from narrows.logbook.transits.transit_twins import TransitConditions, TransitTwin, gust_push, recorded
from narrows.model.model import Model
from narrows.quantities.names import KNOT
from narrows.simulation.inputs import check_waterway, finite_numbers
from narrows.waterway import Waterway

TRANSITS = (1, 5, 20)
LEAST_GUST_SHARE = 0.01  # Least assumed strength of gusts over the usual one [1]


@dataclass(frozen=True, repr=False)
class InformationForecast(Tabulated):
    """Expected standard errors of coefficients."""

    transits: tuple[int, ...]  #: How many transits are sailed
    targets: tuple[str, ...]  #: The coefficients
    std: Mapping[str, np.ndarray]  #: (transits,) Their standard errors after so many transits
    prior_std: Mapping[str, float]  #: Their standard errors now
    model: Model  #: The ship
    grade: SensorGrade  #: Its sensors
    conditions: TransitConditions  #: Wind, gusts and wander of the aim
    u: float  #: Speed through the water [m/s]
    duration: float  #: Duration of a transit [s]

    @property
    def notes(self) -> tuple[str, ...]:
        """Assumptions."""
        taken = (
            f"Assumptions: {self.conditions.summary()}; sensors {self.grade.summary()}; the terms of the model; "
            "the banks of the chart, with an unknown zero; each transit has its own wind and zeros; no other ship."
        )
        return (*self.model.notes, taken, ON_TWINS)

    def summary(self) -> str:
        gains = "; ".join(
            f"{name} from {self.prior_std[name]:.2g} to {', '.join(f'{size:.2g}' for size in std)}"
            for name, std in self.std.items()
        )
        after = " and ".join(map(str, self.transits))
        return (
            f"Standard errors after {after} routine transits of {self.duration / 60:.0f} minutes at "
            f"{self.u / KNOT:.3g} knots, sensors {self.grade.name}: {gains}.\n{ON_TWINS}"
        )

    def rows(self) -> list[dict[str, Any]]:
        """Give a row for each number of transits, with the standard error of each target."""
        columns = {"transits": self.transits} | {f"std {name}": std.tolist() for name, std in self.std.items()}
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]

    def to_dict(self) -> dict[str, Any]:
        return {
            "summary": self.summary(), "speed": self.u / KNOT, "duration": self.duration, "sensors": self.grade.name,
            "targets": dict(self.prior_std), "after": self.rows(), "notes": list(self.notes),
        }  # fmt: skip


@accept_aliases
def predict_information(
    model: Model, waterway: Waterway | None = None, sensors: str | SensorGrade = "vdr",
    transits: int | Sequence[int] = TRANSITS, *, u: float | None = None, duration: float | None = None,
    targets: Sequence[str] = (), conditions: TransitConditions | None = None, seed: int = 0,
) -> InformationForecast:  # fmt: skip
    """Predict the standard errors of the bank coefficients after future transits.

    The best-estimate ship is simulated with a pilot whose aim wanders, in gusts, and its sensors are simulated. The
    standard errors follow from the expected (Fisher) information of the likelihood that ``learn`` maximises.

    Raises an InputError where the model or the sensors have no rudder, the model no covariance, a number is out of
    range, or the ship does not come through.

    Parameters
    ----------
    model : Model
        Model of the ship at its own size, with a rudder and a covariance.
    waterway : Waterway, optional
        Instead of the model's own canal.
    sensors, transits : str or SensorGrade, int or sequence of int
        ``rtk``, ``vdr``, ``ais``, or your own; numbers of transits to predict for.
    u, duration : float [m/s], [s], optional
        Speed through the water, by default one that the canal and the tests allow; duration of a transit, by default 40
        minutes, or the waterway's length to an hour.
    targets : sequence of str
        Coefficients of interest, by default those of the bank.
    conditions, seed : TransitConditions, int
        Wind, gusts, wander of the aim; seed of these.
    """
    check_rudder(model)
    check_covariance(model)
    check_waterway(waterway)
    counts = tuple(transits) if isinstance(transits, Sequence | np.ndarray) else (transits,)
    if not counts:
        raise InputError("transits is empty; give numbers of transits such as [1, 5, 20]")
    for count in counts:
        check_count("transits", count, 1)
    names, grade, conditions = learnable(model, targets), sensor_grade(sensors), conditions or TransitConditions()
    if "rudder" not in grade.signals:
        raise InputError(
            f"sensors {grade.name!r} have no rudder angle: what transits tell of the bank then depends on the assumed "
            "pilot; record the rudder"
        )
    plan = _plan(model, waterway, u, duration, conditions)
    sizes, push = model.to_dataframe()["std"], gust_push(conditions, model)
    now = {name: float(sizes[name]) for name in names}
    std, seeds = list[list[list[float]]](), range(seed, seed + settings.SIMULATED_TRANSITS)
    with bar(len(seeds), is_shown(), "transits") as done:
        for number in seeds:
            record = recorded(f"transit {number}", plan.sailed(number), grade, number, current=0.0)
            setup = log_problem(model, ShipLog((record,), waterway), grade, gusts=True)
            one = expected_information(setup, push @ push.T, conditions.gust_time)
            after = [expected_std(setup.problem, count * one) for count in counts]
            std.append([[each[name] for each in after] for name in names])
            done(1)
    found = dict(zip(names, np.median(std, axis=0), strict=True))
    return InformationForecast(counts, names, found, now, model, grade, conditions, plan.u, plan.duration)


def _plan(
    model: Model, waterway: Waterway | None, u: float | None, duration: float | None, conditions: TransitConditions
) -> TransitTwin:
    speed = float(usual_speeds(model)[0]) if u is None else finite_numbers(u=u)["u"]
    if speed <= 0:
        raise InputError(f"u = {speed:g} m/s is no speed ahead; give one over 0")
    if duration is not None:
        lasting = finite_numbers(duration=duration)["duration"]
    elif waterway is not None:
        whole = waterway.line.length / (speed + waterway.reference_current)
        lasting = min(0.95 * whole, settings.LONGEST_TRANSIT)
    else:
        lasting = settings.ROUTINE
    if not 0 < lasting <= settings.MOST_TIME:
        raise InputError(f"a transit of {lasting:g} s is none; give a duration over 0, to {settings.MOST_TIME:g}")
    return TransitTwin(model, speed, lasting, conditions, waterway)


def expected_information(setup: LogSetup, gusts: np.ndarray, memory: float) -> np.ndarray:
    """Return the information of records at the prior mean, with gusts of covariance (2, 2) and memory [s], (P, P)."""
    problem = setup.problem
    unknowns, usual = np.zeros(len(problem.precision)), {one.name: one for one in problem.model.processes}
    std = np.sqrt(np.diag(gusts))
    size = dict(zip((SWAY, YAW), std / problem.at(np.zeros(problem.count))[1][1:], strict=True))
    for place, (of, names, _) in enumerate(problem.model.estimated, start=problem.count):
        if of == "std" and names[0] in size:
            unknowns[place] = np.log(max(size[names[0]] / usual[names[0]].std, LEAST_GUST_SHARE))
        elif of == "memory" and SWAY in names:
            unknowns[place] = np.log(memory / usual[SWAY].memory)
        elif of == "correlation":
            unknowns[place] = np.arctanh(np.clip(gusts[0, 1] / max(std.prod(), np.finfo(float).tiny), -0.99, 0.99))
    found = scored(problem, setup, unknowns, [], FIRST_PASSES)
    if found is None:
        raise InputError(
            "these sensors are too coarse to locate a ship of this size in its canal; give a grade of finer sensors"
        )
    return found.information
