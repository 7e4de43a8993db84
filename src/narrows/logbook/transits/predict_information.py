"""Predict the information on the bank coefficients from future transits and excursions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.aliases import accept_aliases
from narrows.control.steady_course import check_rudder
from narrows.errors import InputError, check_count
from narrows.logbook import settings
from narrows.logbook.filtering.log_problem import SWAY, YAW
from narrows.logbook.filtering.search import FIRST_PASSES, scored
from narrows.logbook.learned_coefficient import ON_TWINS, learnable
from narrows.logbook.learning.log_posterior import check_covariance, expected_std
from narrows.logbook.learning.log_setup import LogSetup, log_problem
from narrows.logbook.sensor_grades import SensorGrade, sensor_grade
from narrows.logbook.ship_log import ShipLog
from narrows.logbook.steady_legs.plan_steady import usual_offsets, usual_speeds
from narrows.logbook.transits.transit_twins import (
    ROUTINE,
    Excursion,
    TransitConditions,
    TransitTwin,
    gust_push,
    recorded,
)
from narrows.model.model import Model
from narrows.progress import bar, is_shown
from narrows.quantities.names import KNOT
from narrows.results import Tabulated
from narrows.safety.envelope import safe_envelope
from narrows.simulation.inputs import check_waterway, finite_numbers

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

TRANSITS = (1, 5, 20)
MINUTE = 60.0
LEAST_GUST_SHARE = 0.01  # Least assumed strength of gusts over the usual one [1]


@dataclass(frozen=True)
class TransitInformation:
    excursion: Excursion  # Excursion from the middle; the first kind has none
    std: Mapping[str, np.ndarray]  # (transits,) Standard error of each target after so many, in the coefficient's unit


@dataclass(frozen=True, repr=False)
class InformationForecast(Tabulated):
    """Expected standard errors of coefficients.

    Parameters
    ----------
    kinds, transits : tuple of TransitInformation, tuple of int
        Routine transits, then those with excursions; only routine where none is safe. How many are sailed.
    targets, prior_std : tuple of str, mapping of str to float
        The coefficients, and their standard errors now.
    model, grade, conditions : Model, SensorGrade, TransitConditions
        The ship, its sensors, and wind, gusts and wander of the aim.
    u, duration : float [m/s], [s]
        Speed through the water, and duration of a transit.
    safe_offset : float [m]
        How far off the middle the safe envelope lets it go on purpose.
    reasons : tuple of str
        Why nothing is predicted, or why no excursion is among the kinds.
    """

    kinds: tuple[TransitInformation, ...]
    transits: tuple[int, ...]
    targets: tuple[str, ...]
    prior_std: Mapping[str, float]
    model: Model
    grade: SensorGrade
    conditions: TransitConditions
    u: float
    duration: float
    safe_offset: float
    reasons: tuple[str, ...]

    @property
    def best(self) -> TransitInformation | None:
        """The kind with the smallest standard errors after the fewest transits; None without a prediction."""

        def left(kind: TransitInformation) -> float:
            return sum(float(kind.std[name][0] / now) ** 2 for name, now in self.prior_std.items() if now)

        return min(self.kinds, key=left, default=None)

    @property
    def notes(self) -> tuple[str, ...]:
        """Reasons for missing forecasts, and assumptions."""
        taken = (
            f"Assumptions: {self.conditions.summary()}; sensors {self.grade.summary()}; the terms of the model; "
            "the banks of the chart, with an unknown zero; each transit has its own wind and zeros; no other ship."
        )
        return (*self.reasons, *self.model.notes, taken, ON_TWINS)

    def summary(self) -> str:
        """Expected error of each target by routine transits, and the most informative excursion."""
        if not self.kinds:
            return "\n".join((*self.reasons, ON_TWINS))
        routine, best, after = self.kinds[0], self.best, " and ".join(map(str, self.transits))
        gains = "; ".join(
            f"{name} from {now:.2g} to {', '.join(f'{std:.2g}' for std in routine.std[name])}"
            for name, now in self.prior_std.items()
        )
        lines = [f"Standard errors after {after} routine transits of {self.duration / 60:.0f} minutes at "
                 f"{self.u / KNOT:.3g} knots, sensors {self.grade.name}: {gains}."]  # fmt: skip
        if best is not None and best is not routine:
            helped = ", ".join(f"{n} {best.std[n][0]:.2g} instead of {std[0]:.2g}" for n, std in routine.std.items())
            lines.append(f"The best excursion is {best.excursion.words}: after {self.transits[0]}, {helped}.")
        return "\n".join((*lines, *self.reasons, ON_TWINS))

    def rows(self) -> list[dict[str, Any]]:
        """Give a row for each kind and number of transits, with the standard error of each target."""
        return [
            {"excursion": kind.excursion.words, "offset": kind.excursion.offset, "transits": count}
            | {f"std {name}": float(kind.std[name][i]) for name in self.targets}
            for kind in self.kinds for i, count in enumerate(self.transits)
        ]  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name."""
        return {
            "summary": self.summary(), "speed": self.u / KNOT, "duration": self.duration, "sensors": self.grade.name,
            "safe_offset": self.safe_offset, "targets": dict(self.prior_std), "kinds": self.rows(),
            "notes": list(self.notes),
        }  # fmt: skip


@accept_aliases
def predict_information(
    model: Model, waterway: "Waterway | None" = None, sensors: str | SensorGrade = "vdr",
    transits: int | Sequence[int] = TRANSITS, *, u: float | None = None, duration: float | None = None,
    targets: Sequence[str] = (), within: float | None = None, conditions: TransitConditions | None = None,
    seed: int = 0,
) -> InformationForecast:  # fmt: skip
    """Predict the standard errors of the bank coefficients after future transits.

    The best-estimate ship is simulated with a pilot whose aim wanders, in gusts, and its sensors are simulated. The
    standard errors follow from the expected (Fisher) information of the likelihood that ``learn`` maximises.

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
    targets, within : sequence of str, float [m], optional
        Coefficients of interest, by default those of the bank; how far off the middle excursions may go, 0 for none, by
        default as far as a quick safe envelope lets the ship.
    conditions, seed : TransitConditions, int
        Wind, gusts, wander of the aim; seed of these and of the samples of the envelope.

    Raises
    ------
    InputError
        Where the model has no rudder or no covariance, a number is out of range, or the ship does not come through.
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
    plan = _plan(model, waterway, u, duration, conditions)
    std = model.to_dataframe()["std"]
    told = counts, names, {name: float(std[name]) for name in names}, model, grade, conditions, plan.u, plan.duration
    if "rudder" not in grade.signals:
        no_rudder = (
            "Nothing is predicted: without the rudder angle, the information depends on the assumed pilot and not on "
            "the bank; record the rudder."
        )
        return InformationForecast((), *told, 0.0, (no_rudder,))
    if within is None:
        safe = safe_offset(_narrowest(model, waterway), plan.u, seed)
    elif (safe := finite_numbers(within=within)["within"]) < 0:
        raise InputError(f"within = {safe:g} m: give how far off the middle excursions may go, from 0 (none)")
    kinds, reasons = [_information(plan, ROUTINE, grade, names, counts, seed)], []
    for excursion in excursions(safe, model.configuration.ship.length / plan.u):
        try:
            kinds.append(_information(plan, excursion, grade, names, counts, seed))
        except InputError as error:
            reasons.append(f"Left out: {error}.")
    if within is None and not safe:
        reasons.append(
            f"No excursion is considered: with the present uncertainty, no offset is safe at {plan.u:.3g} m/s; hold "
            "steady legs first (plan_steady), or sail routine transits."
        )
    return InformationForecast(tuple(kinds), *told, safe, tuple(reasons))


def _plan(
    model: Model, waterway: "Waterway | None", u: float | None, duration: float | None, conditions: TransitConditions
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


def safe_offset(model: Model, u: float, seed: int = 0) -> float:
    offsets = np.append(0.0, usual_offsets(model, model.configuration.ship.beam / 2))
    found = safe_envelope(model, offsets, np.array([u]), samples=settings.ENVELOPE_SAMPLES, seed=seed)
    safe = found.by_model().to_numpy()[:, 0]
    return float(offsets[int(np.argmin(safe)) - 1]) if safe[0] and not safe.all() else float(offsets[-1] * safe[0])


def excursions(safe: float, time: float) -> list[Excursion]:
    ways = (("aside to one side", (1,)), ("aside to either side, as in meetings", (1, -1)))
    stay, turn = settings.EXCURSION_STAY * time, settings.EXCURSION_TURN * time
    lasting = f"for {stay / MINUTE:.1g} minutes" if stay >= MINUTE else f"for {stay:.2g} s"
    return [
        Excursion(f"{share * safe:.3g} m {words}, {lasting}", share * safe, sides, stay, turn)
        for share in settings.EXCURSION_SHARES if safe > 0 for words, sides in ways
    ]  # fmt: skip


def _information(
    plan: TransitTwin, excursion: Excursion, grade: SensorGrade, names: Sequence[str], counts: Sequence[int], seed: int
) -> TransitInformation:
    push, std = gust_push(plan.conditions, plan.truth), []
    with bar(settings.SIMULATED_TRANSITS, is_shown(), excursion.words) as done:
        for number in range(seed, seed + settings.SIMULATED_TRANSITS):
            record = recorded(f"transit {number}", plan.sailed(number, excursion), grade, number, current=0.0)
            setup = log_problem(plan.truth, ShipLog((record,), plan.waterway), grade, gusts=True)
            one = expected_information(setup, push @ push.T, plan.conditions.gust_time)
            after = [expected_std(setup.problem, count * one) for count in counts]
            std.append([[each[name] for name in names] for each in after])
            done(1)
    return TransitInformation(excursion, dict(zip(names, np.median(std, axis=0).T, strict=True)))


def _narrowest(model: Model, waterway: "Waterway | None") -> Model:
    if waterway is None:
        return model
    places = np.linspace(0, waterway.line.length, 101)
    canal = waterway.canal(float(places[waterway.section(places).width.argmin()]))
    canal = replace(canal, depth=canal.depth or model.configuration.canal.depth)
    return replace(model, configuration=replace(model.configuration, canal=canal))


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
