"""``foresee``: how tight the bank's coefficients will get after some transits, and which excursions would help most."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.control.steady_course import check_rudder
from narrows.errors import InputError, check_count
from narrows.logbook.gaussian_update import NormalPrior
from narrows.logbook.sensor_grades import SensorGrade, sensor_grade
from narrows.logbook.steady_legs.learn_steady import check_covariance
from narrows.logbook.steady_legs.steady_candidates import usual_offsets, usual_speeds
from narrows.logbook.targets import learnable
from narrows.logbook.transits.foresight import ForeseenTransit, Foresight
from narrows.logbook.transits.planned_transit import Excursion, PlannedTransit
from narrows.logbook.transits.transit_conditions import TransitConditions
from narrows.logbook.transits.transit_filter import Unknowns
from narrows.model.model import Model
from narrows.safety.envelope import safe_envelope
from narrows.simulation.inputs import check_waterway, finite_numbers

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

TRANSITS = (1, 5, 20)
ROUTINE, LONGEST = 2400.0, 3600.0
"""Of a transit [s]: where no waterway says how long, and at most."""
MOST = 86_400.0
"""Seconds of a transit."""
SAILED = 2
"""Transits of each kind, over whose gusts and wander what they tell is averaged."""
SHARES = (0.5, 1.0)
"""Of the safe offset, that excursions go to."""
STAY, TURN = 5.0, 0.6
"""How long an excursion stays aside and how long it takes to get there, in times of a ship length."""
MINUTE = 60.0
ENVELOPE_SAMPLES = 200
NO_RUDDER = (
    "Without the rudder's angle what a transit tells follows the pilot whom one assumes, and not the bank: nothing is "
    "foretold; record the rudder."
)
NOWHERE = (
    "No excursion is looked at: the safe envelope lets this ship off the middle nowhere at {:.3g} m/s with what is "
    "known now; hold steady legs first (plan_steady), or sail routine transits and ask again."
)


def foresee(
    model: Model, waterway: "Waterway | None" = None, sensors: str | SensorGrade = "vdr",
    transits: Sequence[int] = TRANSITS, *, u: float | None = None, duration: float | None = None,
    targets: Sequence[str] = (), within: float | None = None, conditions: TransitConditions | None = None,
    seed: int = 0,
) -> Foresight:  # fmt: skip
    """Foretell how well transits will tell the bank's coefficients, before any is sailed (ours).

    The ship of the most likely coefficients is sailed by a pilot whose aim wanders, in gusts. Along that voyage the
    motion is linear in what is small, by exact derivatives, and a filter that needs no readings says what the sensors
    leave open of the coefficients: gusts are a force with a memory, wind and zeros of sensors are each transit's own.

    Parameters
    ----------
    model : Model
        Of the ship at its own size, with the terms of a rudder and a covariance.
    waterway : Waterway, optional
        Instead of the model's own canal.
    sensors : str or SensorGrade
        ``rtk``, ``vdr``, ``ais``, or your own.
    transits : sequence of int
        After how many it is foretold.
    u : float [m/s], optional
        Through the water; a speed that the canal and the tests allow unless given.
    duration : float [s], optional
        Of a transit; 40 minutes, or the waterway's length to an hour, unless given.
    targets : sequence of str
        The coefficients that matter; those of the bank unless given.
    within : float [m], optional
        How far off the middle excursions may go; as far as a quick safe envelope lets the ship unless given.
    conditions : TransitConditions, optional
        Wind, gusts, wander of the aim.
    seed : int
        Of gusts, wander and the samples of the envelope.

    Returns
    -------
    Foresight
        Standard errors after so many transits, routine and with each excursion.

    Raises
    ------
    InputError
        Where the model has no rudder or no covariance, a number is out of range, or the ship does not come through.
    """
    check_rudder(model)
    check_covariance(model)
    check_waterway(waterway)
    for count in transits:
        check_count("transits", count, 1)
    names, grade, conditions = learnable(model, targets), sensor_grade(sensors), conditions or TransitConditions()
    plan = _plan(model, waterway, u, duration, conditions)
    prior = NormalPrior.of(np.zeros(len(model.terms.names)), np.asarray(model.covariance))
    told: dict[str, Any] = {"model": model, "grade": grade, "conditions": conditions, "u": plan.u}
    told |= {"duration": plan.duration, "transits": tuple(transits), "targets": names}
    told |= {"prior_std": _std(model, names, prior.root)}
    if "rudder" not in grade.signals:
        return Foresight((), safe_offset=0.0, reasons=(NO_RUDDER,), **told)
    safe = within if within is not None else safe_offset(_narrowest(model, waterway), plan.u, seed)
    unknowns = Unknowns(conditions.gust_push(model), conditions.steady_push(model), conditions.gust_time, grade, prior)
    kinds, reasons = _kinds(plan, unknowns, finite_numbers(within=safe)["within"], names, transits, seed)
    return Foresight(kinds, safe_offset=safe, reasons=reasons, **told)


def _plan(
    model: Model, waterway: "Waterway | None", u: float | None, duration: float | None, conditions: TransitConditions
) -> PlannedTransit:
    speed = float(usual_speeds(model)[0]) if u is None else finite_numbers(u=u)["u"]
    if speed <= 0:
        raise InputError(f"u = {speed:g} m/s is no speed ahead; give one over 0")
    lasting = _duration(waterway, speed) if duration is None else finite_numbers(duration=duration)["duration"]
    if not 0 < lasting <= MOST:
        raise InputError(f"a transit of {lasting:g} s is none; give a duration over 0, to {MOST:g}")
    return PlannedTransit(model, speed, lasting, conditions, waterway)


def _kinds(
    plan: PlannedTransit, unknowns: Unknowns, safe: float, names: tuple[str, ...], transits: Sequence[int], seed: int
) -> tuple[tuple[ForeseenTransit, ...], tuple[str, ...]]:
    """What routine tells, and each excursion that comes through; why others are left out."""
    kinds, reasons = [_foreseen(plan, unknowns, Excursion("routine"), names, transits, seed)], []
    for excursion in excursions(safe, plan.model.configuration.ship.length / plan.u):
        try:
            kinds.append(_foreseen(plan, unknowns, excursion, names, transits, seed))
        except InputError as error:
            reasons.append(f"Left out: {error}.")
    reasons += [] if safe > 0 else [NOWHERE.format(plan.u)]
    return tuple(kinds), tuple(reasons)


def safe_offset(model: Model, u: float, seed: int = 0) -> float:
    """Return how far off the middle a quick safe envelope lets a ship, tested there or not [m] (ours).

    Parameters
    ----------
    model : Model
        With the terms of a rudder.
    u : float [m/s]
        Through the water.
    seed : int
        Of the samples.
    """
    offsets = np.append(0.0, usual_offsets(model, model.configuration.ship.beam / 2))
    found = safe_envelope(model, offsets, np.array([u]), samples=ENVELOPE_SAMPLES, seed=seed)
    safe = found.by_model().to_numpy()[:, 0]
    return float(offsets[int(np.argmin(safe)) - 1]) if safe[0] and not safe.all() else float(offsets[-1] * safe[0])


def excursions(safe: float, time: float) -> list[Excursion]:
    """Return small excursions within an offset that is safe (ours).

    Parameters
    ----------
    safe : float [m]
        Off the middle; 0 for no excursion.
    time : float [s]
        Of a ship length.
    """
    ways = (("aside to one side", (1,)), ("aside to either side, as in meetings", (1, -1)))
    minutes = f"for {STAY * time / 60:.1g} minutes" if STAY * time >= MINUTE else f"for {STAY * time:.2g} s"
    return [
        Excursion(f"{share * safe:.3g} m {words}, {minutes}", share * safe, sides, STAY * time, TURN * time)
        for share in SHARES if safe > 0 for words, sides in ways
    ]  # fmt: skip


def _foreseen(
    plan: PlannedTransit, unknowns: Unknowns, excursion: Excursion, names: tuple[str, ...], transits: Sequence[int],
    seed: int,
) -> ForeseenTransit:  # fmt: skip
    voyages = [plan.sailed(excursion, seed + number) for number in range(SAILED)]
    told = np.mean([unknowns.information(plan.system(voyage)) for voyage in voyages], axis=0)
    columns: dict[str, list[float]] = {name: [] for name in names}
    for count in transits:
        inner = np.linalg.cholesky(np.eye(len(told)) + count * (told + told.T) / 2)
        root = np.linalg.solve(inner, unknowns.prior.root.T).T
        for name, std in _std(plan.model, names, root).items():
            columns[name].append(std)
    return ForeseenTransit(excursion, {name: np.array(column) for name, column in columns.items()})


def _std(model: Model, names: Sequence[str], root: np.ndarray) -> dict[str, float]:
    return {name: float(np.linalg.norm(root[model.terms.names.index(name)])) for name in names}


def _duration(waterway: "Waterway | None", u: float) -> float:
    return ROUTINE if waterway is None else min(0.95 * waterway.line.length / (u + waterway.current), LONGEST)


def _narrowest(model: Model, waterway: "Waterway | None") -> Model:
    """The model in the narrowest section of a waterway."""
    if waterway is None:
        return model
    canals = [waterway.canal(float(x)) for x in np.linspace(0, waterway.line.length, 101)]
    canal = min(canals, key=lambda one: one.width)
    depth = canal.depth if canal.depth is not None else model.configuration.canal.depth
    return replace(model, configuration=replace(model.configuration, canal=replace(canal, depth=depth)))
