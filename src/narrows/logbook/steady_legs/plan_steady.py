"""``plan_steady``: which offsets and speeds to hold, so that a few legs tell most of the bank, within what is safe."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from narrows.control.steady_course import check_inside, check_rudder
from narrows.errors import InputError, check_count, shown
from narrows.logbook.steady_legs.learn_steady import check_covariance
from narrows.logbook.steady_legs.pair_design import pair_design
from narrows.logbook.steady_legs.steady_candidates import Candidates, candidates, usual_offsets, usual_speeds
from narrows.logbook.steady_legs.steady_conditions import SteadyConditions
from narrows.logbook.steady_legs.steady_plan import PlannedLeg, SteadyPlan
from narrows.logbook.steady_legs.steady_readings import ReadingErrors
from narrows.logbook.targets import learnable
from narrows.model.model import Model
from narrows.safety.answer import SURE_SHARE
from narrows.safety.envelope import RESERVE
from narrows.ship.checks import is_finite

# Of coefficients, that must leave the rudder its reserve.
SAMPLES = 400
MOST_LEGS, MOST_SAMPLES = 1000, 100_000
WHO_HOLDS = (
    "The plan looks at the steady rudder, the side and the keel; whether a pilot holds the ship there is what the safe "
    "envelope says, and the master decides."
)


def plan_steady(
    model: Model, offsets: Sequence[float] | np.ndarray | None = None,
    speeds: Sequence[float] | np.ndarray | None = None, *, legs: int = 4,
    targets: Sequence[str] = (), errors: ReadingErrors | None = None, conditions: SteadyConditions | None = None,
    reserve: float = RESERVE, clearance: float | None = None, samples: int = SAMPLES, seed: int = 0,
) -> SteadyPlan:  # fmt: skip
    """Choose the steady legs that make some coefficients best known, among those that are safe to hold.

    Legs come in pairs to either side, for opposite sides cancel wind and zeros. A leg is allowed where in 19 of 20
    samples of the coefficients the steady rudder leaves its reserve, and side and keel their clearance. Whether a pilot
    holds the ship there is what ``safe_envelope`` says.

    Parameters
    ----------
    model : Model
        Of the ship at its own size in its canal, with the terms of a rudder and a covariance.
    offsets : sequence of float [m], optional
        Off the middle, to either side, that may be held.
    speeds : sequence of float [m/s], optional
        Through the water, likewise.
    legs : int
        How many there is time for; an even number.
    targets : sequence of str
        The coefficients that matter; those of the bank unless given.
    errors : ReadingErrors, optional
        Of what will be read.
    conditions : SteadyConditions, optional
        Wind, zeros, and what is left of motion.
    reserve : float [1]
        Of the rudder, to be left.
    clearance : float [m], optional
        From the hull's side to a bank, to be left; half a beam unless given.
    samples : int
        Of the coefficients.
    seed : int
        Of the samples.

    Returns
    -------
    SteadyPlan
        The legs, what to expect on each, and what they will tell; without legs where none is allowed.

    Raises
    ------
    InputError
        Where the model has no rudder or no covariance, a number is out of range, or a target is unknown.
    """
    check_rudder(model)
    check_covariance(model)
    names, conditions, errors = learnable(model, targets), conditions or SteadyConditions(), errors or ReadingErrors()
    side = model.configuration.ship.beam / 2 if clearance is None else clearance
    _check(legs, samples, reserve, side)
    beside = usual_offsets(model, side) if offsets is None else _rising("offsets", offsets)
    ahead = usual_speeds(model) if speeds is None else _rising("speeds", speeds)
    check_inside(beside, model.configuration.canal.width, model.configuration.ship.beam)
    found = candidates(model, beside, ahead, reserve, side, samples, seed)
    allowed = np.flatnonzero(found.allowed(SURE_SHARE))
    design = pair_design(model, found, allowed, errors, conditions)
    best = design.chosen([model.terms.names.index(name) for name in names], legs // 2)
    order = sorted(best, key=lambda i: (found.offsets[allowed[i]], found.speeds[allowed[i]]))
    planned = [leg for turn, i in enumerate(order) for leg in _both_sides(found, allowed[i], turn)]
    roots = design.roots_after(order)
    std = {name: np.linalg.norm(roots[:, model.terms.names.index(name)], axis=1) for name in names}
    then = candidates(_as_sure_as(model, roots[-1]), beside, ahead, reserve, side, samples, seed) if order else found
    far = _farthest(found), max(_farthest(found), _farthest(then))
    return SteadyPlan(
        tuple(planned), names, std, model, errors, conditions, reserve, side, len(allowed), far,
        (*_refused(found, reserve, side), f"Taken for granted: {errors.summary()}; {conditions.summary()}.", WHO_HOLDS),
    )  # fmt: skip


def _check(legs: int, samples: int, reserve: float, clearance: float) -> None:
    check_count("legs", legs, 2, MOST_LEGS)
    check_count("samples", samples, 1, MOST_SAMPLES)
    if legs % 2:
        raise InputError(
            f"legs = {legs}: give an even number, for each side cancels what the other has of wind and zeros"
        )
    if not (is_finite(reserve) and 0 <= reserve < 1 and is_finite(clearance) and clearance >= 0):
        raise InputError(
            f"a reserve of {shown(reserve)} and {shown(clearance)} m of clearance: give a share under 1, metres from 0"
        )


def _rising(name: str, values: object) -> np.ndarray:
    try:
        column = np.asarray(values, float)
    except (TypeError, ValueError, OverflowError):
        column = np.array([np.nan])
    if column.ndim != 1 or not column.size or not (np.isfinite(column) & (column > 0)).all():
        raise InputError(f"the {name} that may be held are finite numbers over 0; give a sequence of them")
    return np.unique(column)


def _both_sides(found: Candidates, place: int, turn: int) -> tuple[PlannedLeg, PlannedLeg]:
    """A pair, the side that comes first in turn: what grows with time then cancels too."""
    rudder, drift = found.rudder_told[place], found.psi_told[place]
    leg = PlannedLeg(float(found.offsets[place]), float(found.speeds[place]), _angles(rudder), _angles(drift))
    other = PlannedLeg(-leg.offset, leg.speed, _angles(-rudder[::-1]), _angles(-drift[::-1]))
    return (other, leg) if turn % 2 else (leg, other)


def _angles(told: np.ndarray) -> tuple[float, float, float]:
    low, middle, high = told.tolist()
    return low, middle, high


def _as_sure_as(model: Model, root: np.ndarray) -> Model:
    """The model with the covariance that it will have."""
    part = root[: len(model.terms.names)]
    return replace(model, covariance=part @ part.T)


def _farthest(found: Candidates) -> float:
    return float(found.offsets[found.allowed(SURE_SHARE)].max(initial=0.0))


def _refused(found: Candidates, reserve: float, clearance: float) -> list[str]:
    """What was not allowed, and the nearest of each kind."""
    short = found.clear & ~found.allowed(SURE_SHARE)
    notes = []
    if short.any():
        first = int(np.flatnonzero(short)[found.offsets[short].argmin()])
        notes.append(
            f"{short.sum()} of {len(short)} places are not allowed for the rudder: at {found.offsets[first]:.3g} m "
            f"only {100 * found.within[first]:.0f} % of the samples leave {100 * reserve:.0f} % of it."
        )
    if not found.clear.all():
        notes.append(f"{(~found.clear).sum()} are not allowed for the keel, or for {clearance:.3g} m to the bank.")
    return notes
