"""Transits before they are sailed: the information that they will give."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, check_count, shown
from narrows.base.progress import bar, is_shown
from narrows.base.results import Tabulated
from narrows.control.regulator import Regulator, regulator
from narrows.control.steady_course import check_rudder, steady_course
from narrows.logbook import settings
from narrows.logbook.filtering.likelihood import FIRST_PASSES, scored
from narrows.logbook.filtering.log_problem import SWAY, YAW
from narrows.logbook.learned_coefficients import ON_TWINS, check_covariance, expected_std, learnable
from narrows.logbook.learning.log_setup import LogSetup, log_problem
from narrows.logbook.ship_log import SensorGrade, ShipLog, ShipRecord, Signal, sensor_grade
from narrows.logbook.steady_legs import usual_speeds
from narrows.logbook.steady_readings import BeamWind, steady_push
from narrows.model.model import Model
from narrows.quantities.names import DEGREE, KNOT
from narrows.simulation.controllers import Order, VoyageState
from narrows.simulation.initial_state import self_propulsion
from narrows.simulation.inputs import check_waterway, finite_numbers
from narrows.simulation.voyage import Voyage, simulate
from narrows.waterway import Waterway


@dataclass(frozen=True, repr=False)
class TransitConditions(BeamWind):
    """Wind and aim of transits, as standard deviations.

    Raises an InputError where a number is negative or not finite, a time is 0, or a correlation is more than 1.
    """

    gust: float = 0.3  #: Force and moment of gusts over those of the wind [1]
    gust_time: float = 40.0  #: Correlation time of gusts [s]
    wander: float = 3.0  #: Wander of a pilot's aim about the middle [m]
    wander_time: float = 400.0  #: Its correlation time [s]
    #: Correlation between force and moment of gusts: 1 where they act at one place ahead of midship [1]
    gust_correlation: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.gust_correlation > 1:
            raise InputError(f"gust_correlation = {shown(self.gust_correlation)}: a correlation is 1 at most")

    def summary(self) -> str:
        return (
            f"beam wind {self.wind:g} m/s, gusts of {100 * self.gust:.0f} % of its force that stay {self.gust_time:g} s"
            f", an aim that wanders by {self.wander:g} m in {self.wander_time:g} s (standard deviations)"
        )


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
        std = {f"std {name}": size for name, size in self.std.items()}
        return [{"transits": count} | {n: float(s[i]) for n, s in std.items()} for i, count in enumerate(self.transits)]

    def to_dict(self) -> dict[str, Any]:
        return {
            "summary": self.summary(), "speed": self.u / KNOT, "duration": self.duration, "sensors": self.grade.name,
            "targets": dict(self.prior_std), "after": self.rows(), "notes": list(self.notes),
        }  # fmt: skip


@accept_aliases
def predict_information(
    model: Model, waterway: Waterway | None = None, sensors: str | SensorGrade = "vdr",
    transits: int | Sequence[int] = (1, 5, 20), *, u: float | None = None, duration: float | None = None,
    targets: Sequence[str] = (), conditions: TransitConditions | None = None, seed: int = 0,
) -> InformationForecast:  # fmt: skip
    """Predict the standard errors of the bank coefficients after future transits.

    The best-estimate ship is simulated with a pilot whose aim wanders, in gusts, and its sensors are simulated. The
    standard errors follow from the expected (Fisher) information of the likelihood that ``learn`` maximises.

    Raises an InputError where the model or the sensors have no rudder, the model no covariance, a number is out of
    range, or the ship does not come through.

    Parameters
    ----------
    model, waterway : Model, Waterway
        The ship at its own size, with a rudder and a covariance; a waterway instead of the model's own canal.
    sensors, transits : str or SensorGrade, int or sequence of int
        ``rtk``, ``vdr``, ``ais``, or your own; numbers of transits to predict for.
    u, duration : float [m/s], [s], optional
        Speed through the water, by default one that the canal and the tests allow; duration of a transit, by default 40
        minutes, or the waterway's length to an hour.
    targets, conditions, seed : sequence of str, TransitConditions, int
        Coefficients of interest, by default those of the bank; wind, gusts, wander of the aim, and seed of these.
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
            f"sensors {grade.name!r} have no rudder angle, so that all rests on the assumed pilot; record the rudder"
        )
    plan = _plan(model, waterway, u, duration, conditions)
    sizes, push = model.to_dataframe()["std"], gust_push(conditions, model)
    std, seeds = [], range(seed, seed + settings.SIMULATED_TRANSITS)
    with bar(len(seeds), is_shown(), "transits") as done:
        for number in seeds:
            record = recorded(f"transit {number}", plan.sailed(number), grade, number, current=0.0)
            setup = log_problem(model, ShipLog((record,), waterway), grade, gusts=True)
            one = expected_information(setup, push @ push.T, conditions.gust_time)
            std.append([[expected_std(setup.problem, count * one)[name] for count in counts] for name in names])
            done(1)
    found = dict(zip(names, np.median(std, axis=0), strict=True))
    now = {name: float(sizes[name]) for name in names}
    return InformationForecast(counts, names, found, now, model, grade, conditions, plan.u, plan.duration)


def _plan(
    model: Model, waterway: Waterway | None, u: float | None, duration: float | None, conditions: TransitConditions
) -> "TransitTwin":
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
        raise InputError("these sensors are too coarse to locate a ship of this size in its canal; give finer ones")
    return found.information


def gust_push(conditions: TransitConditions, model: Model) -> np.ndarray:
    """Return sway force [N] and yaw moment [N m] of two independent gusts of size one, (2, 2)."""
    along, apart = conditions.gust_correlation, math.sqrt(1 - conditions.gust_correlation**2)
    return np.asarray(conditions.gust * steady_push(conditions, model)[:, None] * [[1.0, 0.0], [along, apart]])


def wandering(
    size: float, memory: float, step: float, count: int, draw: np.random.Generator, width: int = 1
) -> np.ndarray:
    from scipy.signal import lfilter

    kept, normal = math.exp(-step / memory), draw.standard_normal((count, width))
    normal[1:] *= math.sqrt(1 - kept**2)
    return np.asarray(size * lfilter([1.0], [1.0, -kept], normal, axis=0))


@dataclass(frozen=True)
class TransitPilot:
    """A pilot at the wheel: an order every few seconds, in whole degrees."""

    model: Model
    u: float  # [m/s]
    times: np.ndarray  # (n,) [s]
    aims: np.ndarray  # (n,) Where it wants to be, straight between these times [m]
    waterway: Waterway | None = None  # Whose bends it follows

    @cached_property
    def courses(self) -> np.ndarray:
        """Offset [m], rudder, heading [rad] and sway velocity [m/s] of steady courses, (4, offsets)."""
        far = max(float(np.abs(self.aims).max()), 1e-6)
        y = np.linspace(-far, far, settings.PILOT_COURSES)
        held = steady_course(self.model, y=xr.DataArray(y, dims="place"), u=self.u)
        courses = np.stack([y, *(held[name].to_numpy() for name in ("rudder", "psi", "v"))])
        if not np.isfinite(courses).all():
            raise InputError(f"no rudder holds this ship {far:.3g} m off the middle at {self.u:.3g} m/s; aim nearer")
        return courses

    @cached_property
    def law(self) -> Regulator:
        return regulator(self.model, float(self.courses[0, -1]), self.u)  # Where it is hardest.

    def begin(self) -> Order:
        by_y, by_psi, by_v, by_r, by_rudder, by_integral = (float(gain) for gain in self.law.lines[0].gains)
        ship, gear = self.model.configuration.ship, self.model.configuration.gear
        interval = min(settings.ORDER_INTERVAL, ship.length / self.u / settings.ORDERS_A_LENGTH)
        memory = {"t": 0.0, "off": 0.0, "next": 0.0, "order": 0.0}

        def order(t: float, at: VoyageState) -> float:
            if t < memory["next"] - 1e-6:
                return memory["order"]
            aim, rudder, psi, v, turn = self._held(t, at)
            step, memory["t"] = t - memory["t"], t
            wanted = by_y * (at.y - aim) + by_psi * (at.psi - psi) + by_v * (at.v - v) + by_r * (at.r - turn)
            wanted += by_rudder * (at.rudder - rudder) + by_integral * memory["off"]
            asked = float(at.rudder - step * wanted / (1 + step * by_rudder))
            # At the end of the rudder the integral waits.
            memory["off"] += step * (at.y - aim) * (abs(asked) < gear.limit)
            memory["next"], memory["order"] = t + interval, round(asked / DEGREE) * DEGREE
            return memory["order"]

        return order

    def _held(self, t: float, at: VoyageState) -> tuple[Any, ...]:
        aim, (y, *courses) = float(np.interp(t, self.times, self.aims)), self.courses
        rudder, psi, v = (float(np.interp(aim, y, course)) for course in courses)
        if self.waterway is None:
            return aim, rudder, psi, v, 0.0
        ahead = min(max(at.x + float(self.law.lead) * at.u, 0.0), self.waterway.line.length)
        turn = float(self.waterway.section(ahead).curvature) * (at.u + float(self.waterway.current_at(ahead)))
        by_psi, by_v, by_rudder = (float(slope) for slope in self.law.lines[0].turning)
        return aim, rudder + by_rudder * turn, psi + by_psi * turn, v + by_v * turn, turn


@dataclass(frozen=True)
class TransitTwin:
    truth: Model
    u: float  # Through the water [m/s]
    duration: float = 2400.0  # [s]
    conditions: TransitConditions = field(default_factory=TransitConditions)  # Wind, gusts, and wander of the aim
    waterway: Waterway | None = None  # Instead of the model's own canal

    def sailed(self, seed: int) -> Voyage:
        draw, conditions = np.random.default_rng((seed, 11)), self.conditions
        length_time = self.truth.configuration.ship.length / self.u
        step = min(settings.AIM_STEP, settings.AIM_LENGTHS * length_time)
        times = step * np.arange(math.ceil(self.duration / step) + 1)
        aims = wandering(conditions.wander, conditions.wander_time, step, len(times), draw)[:, 0]
        helm = TransitPilot(self.truth, self.u, times, aims, self.waterway)
        started: dict[str, Any] = {"y": float(aims[0]), "u": self.u, **self._pushes(draw)}
        if self.truth.terms.propelled:
            started["revolutions"] = self_propulsion(self.truth, self.u)
        dt = min(settings.PUSH_STEP, length_time / settings.TRANSIT_STEPS)
        voyage = simulate(self.truth, duration=self.duration, dt=dt, controller=helm, waterway=self.waterway, **started)
        if voyage.t[-1] < self.duration - settings.PUSH_STEP:
            raise InputError("in these gusts the ship does not come through")
        return voyage

    def _pushes(self, draw: np.random.Generator) -> dict[str, list[tuple[float, float]]]:
        conditions, step = self.conditions, min(settings.PUSH_STEP, self.conditions.gust_time / settings.GUST_PIECES)
        times = np.arange(0.0, self.duration, step)
        gusts = wandering(1.0, conditions.gust_time, step, len(times), draw, 2) @ gust_push(conditions, self.truth).T
        pushes = gusts + draw.standard_normal(2) * steady_push(conditions, self.truth)
        return {name: list(zip(times.tolist(), pushes[:, i].tolist(), strict=True)) for i, name in enumerate("YN")}


def recorded(name: str, voyage: Voyage, grade: SensorGrade, seed: int, current: float = 0.0) -> ShipRecord:
    draw = np.random.default_rng((seed, 13))
    drift, t, psi = current * float(draw.standard_normal()), voyage.t, voyage.psi
    ahead, aside = voyage.u + drift * np.cos(psi), voyage.v - drift * np.sin(psi)
    columns = {own: voyage[own] for own in ("y", "psi", "r", "u", "v", "rudder")}
    columns |= {"x": voyage.x + drift * t, "u_ground": ahead, "v_ground": aside}
    columns["speed_over_ground"] = np.hypot(ahead, aside)
    signals = {}
    for own, error in grade.signals.items():
        if own in columns:
            times = np.arange(t[0], t[-1], error.period)
            memory = error.wander, error.memory, error.period, len(times), draw
            wander = wandering(*memory)[:, 0] if error.wander else 0.0
            noise = error.noise * draw.standard_normal(len(times)) + error.zero * draw.standard_normal() + wander
            signals[own] = Signal(times, np.interp(times, t, columns[own]) + noise)
    return ShipRecord(name, signals)
