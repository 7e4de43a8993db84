"""``plan_steady``: which offsets and speeds to hold, so that a few legs tell most of the bank, within what is safe."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from narrows.control.steady_course import check_inside, check_rudder, steady_course
from narrows.errors import InputError, check_count, shown
from narrows.logbook.learned_coefficient import learnable
from narrows.logbook.settings import (
    FASTEST_LEG,
    LEG_SPEEDS,
    MOST_LEGS,
    MOST_PLAN_SAMPLES,
    OFFSET_STEPS,
    PLAN_SAMPLES,
    SLOWEST_LEG,
)
from narrows.logbook.steady_legs.learn_steady import check_covariance
from narrows.logbook.steady_legs.steady_plan import PlannedLeg, SteadyPlan
from narrows.logbook.steady_legs.steady_readings import ReadingErrors, SteadyConditions, SteadyReadings
from narrows.logbook.steady_legs.steady_update import LegReadings, SteadyBalance, felt_on, steady_prior
from narrows.model.model import Model
from narrows.quantities.names import KNOT
from narrows.safety.request import keel_at
from narrows.safety.settings import KEEL_SHARE, RESERVE, SURE_SHARE
from narrows.ship.checks import is_finite

WHO_HOLDS = (
    "The plan looks at the steady rudder, the side and the keel; whether a pilot holds the ship there is what the safe "
    "envelope says, and the master decides."
)


def plan_steady(
    model: Model, offsets: Sequence[float] | np.ndarray | None = None,
    speeds: Sequence[float] | np.ndarray | None = None, *, legs: int = 4,
    targets: Sequence[str] = (), errors: ReadingErrors | None = None, conditions: SteadyConditions | None = None,
    reserve: float = RESERVE, clearance: float | None = None, samples: int = PLAN_SAMPLES, seed: int = 0,
) -> SteadyPlan:  # fmt: skip
    """Choose the steady legs that make some coefficients best known, among those that are safe to hold.

    Legs come in pairs to either side, for opposite sides cancel wind and zeros. A leg is allowed where in 19 of 20
    samples of the coefficients the steady rudder leaves its reserve, and side and keel their clearance. Whether a pilot
    holds the ship there is what ``safe_envelope`` says.

    Parameters
    ----------
    model : Model
        Model of the ship at its own size in its canal, with a rudder and a covariance.
    offsets : sequence of float [m], optional
        Largest offset, to either side, that may be held.
    speeds : sequence of float [m/s], optional
        Through the water, likewise.
    legs : int
        Number of legs; even.
    targets : sequence of str
        The coefficients that matter; those of the bank unless given.
    errors : ReadingErrors, optional
        Errors of the readings.
    conditions : SteadyConditions, optional
        Wind, zeros, and what is left of motion.
    reserve : float [1]
        Rudder to be left.
    clearance : float [m], optional
        Clearance from the hull's side to a bank; half a beam unless given.
    samples : int
        Number of samples of the coefficients.
    seed : int
        Seed of the samples.

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
    part = roots[-1][: len(model.terms.names)]
    after = replace(model, covariance=part @ part.T)
    then = candidates(after, beside, ahead, reserve, side, samples, seed) if order else found
    far = _farthest(found), max(_farthest(found), _farthest(then))
    return SteadyPlan(
        tuple(planned), names, std, model, errors, conditions, reserve, side, len(allowed), far,
        (*_refused(found, reserve, side), f"Taken for granted: {errors.summary()}; {conditions.summary()}.", WHO_HOLDS),
    )  # fmt: skip


def _check(legs: int, samples: int, reserve: float, clearance: float) -> None:
    check_count("legs", legs, 2, MOST_LEGS)
    check_count("samples", samples, 1, MOST_PLAN_SAMPLES)
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


@dataclass(frozen=True)
class Candidates:
    offsets: np.ndarray  # (places,) Offset to starboard, or 0 [m]
    speeds: np.ndarray  # (places,) Through the water [m/s]
    rudder: np.ndarray  # (places,) Rudder with the most likely coefficients [rad]
    psi: np.ndarray  # (places,) Drift with the most likely coefficients [rad]
    rudder_told: np.ndarray  # (places, 3) 5 %, 50 %, 95 % of the samples; infinite without a course [rad]
    psi_told: np.ndarray  # (places, 3) The same [rad]
    within: np.ndarray  # (places,) Share of the samples that leave the rudder its reserve [1]
    clear: np.ndarray  # (places,) True where side and keel have their clearance

    def allowed(self, share: float) -> np.ndarray:
        """Return at which places a ship may be held, (places,) of bool."""
        return np.asarray(self.clear & (self.within >= share) & np.isfinite(self.rudder))


def _both_sides(found: Candidates, place: int, turn: int) -> tuple[PlannedLeg, PlannedLeg]:
    """A pair, the side that comes first in turn: what grows with time then cancels too."""
    rudder, drift = found.rudder_told[place], found.psi_told[place]
    leg = PlannedLeg(float(found.offsets[place]), float(found.speeds[place]), _angles(rudder), _angles(drift))
    other = PlannedLeg(-leg.offset, leg.speed, _angles(-rudder[::-1]), _angles(-drift[::-1]))
    return (other, leg) if turn % 2 else (leg, other)


def _angles(told: np.ndarray) -> tuple[float, float, float]:
    low, middle, high = told.tolist()
    return low, middle, high


def _farthest(found: Candidates) -> float:
    return float(found.offsets[found.allowed(SURE_SHARE)].max(initial=0.0))


def _refused(found: Candidates, reserve: float, clearance: float) -> list[str]:
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


@dataclass(frozen=True)
class PairDesign:
    """Legs as readings with independent errors of size one, of independent unknowns of size one."""

    root: np.ndarray  # (n, rank) Root of the prior covariance of the unknowns: ``root`` times the independent ones
    rows: np.ndarray  # (pairs, 2, 2, rank) Rows of sway and yaw on the legs to starboard and to port

    def chosen(self, wanted: list[int], pairs: int) -> list[int]:
        best: list[int] = []
        for _ in range(pairs if len(self.rows) else 0):
            best.append(self._next(best, wanted))
        for place in range(len(best)):
            best[place] = self._next(best[:place] + best[place + 1 :], wanted)
        return best

    def roots_after(self, order: list[int]) -> np.ndarray:
        """Return roots of the covariance before the first leg and after each, (legs + 1, n, rank)."""
        legs = self.rows[order].reshape(-1, 2, self.rows.shape[-1])
        inners = [self._inner(legs[:count]) for count in range(len(legs) + 1)]
        return np.array([np.linalg.solve(inner, self.root.T).T for inner in inners])

    def _inner(self, legs: np.ndarray) -> np.ndarray:
        rows = legs.reshape(-1, self.rows.shape[-1])
        return np.linalg.cholesky(np.eye(rows.shape[1]) + rows.T @ rows)

    def _next(self, held: list[int], wanted: list[int]) -> int:
        inner = self._inner(self.rows[held])
        now = np.linalg.solve(inner, self.root[wanted].T)
        seen = np.linalg.solve(inner, self.rows.reshape(len(self.rows), -1, self.rows.shape[-1]).swapaxes(1, 2))
        more = np.eye(seen.shape[2]) + seen.swapaxes(1, 2) @ seen
        gain = np.linalg.solve(np.linalg.cholesky(more), seen.swapaxes(1, 2) @ now)
        before = np.sum(self.root[wanted] ** 2, axis=1)
        left = np.sum(now**2, axis=0) - np.sum(gain**2, axis=1)
        return int((left / np.where(before > 0, before, np.inf)).sum(axis=1).argmin())


def pair_design(
    model: Model, found: Candidates, allowed: np.ndarray, errors: ReadingErrors, conditions: SteadyConditions
) -> PairDesign:
    prior = steady_prior(model, conditions)
    if not allowed.size:
        return PairDesign(prior.root, np.zeros((0, 2, 2, prior.root.shape[1])))
    values = {name: np.concatenate([column[allowed], sign * column[allowed]])
              for name, column, sign in (("y", found.offsets, -1), ("u", found.speeds, 1),
                                         ("rudder", found.rudder, -1), ("drift", found.psi, -1))}  # fmt: skip
    size = {name: np.full(2 * len(allowed), errors.of(name)) for name in values}
    read = LegReadings.of(SteadyReadings(tuple(map(str, range(2 * len(allowed)))), values, size))
    balance = SteadyBalance(model, felt_on(model, values["u"], {}))
    blocks, _ = read.blocks(balance, read.first(), prior.mean, conditions.left_over(model))
    rows = blocks.whitened()[1] @ prior.root
    return PairDesign(prior.root, np.stack([rows[: len(allowed)], rows[len(allowed) :]], axis=1))


# Number of offsets to either side, about, and their steps times a power of ten.
NICE = (1.0, 2.0, 2.5, 5.0, 10.0)
# Shares of the samples, below which angles are told.
TOLD = (0.05, 0.5, 0.95)


def usual_offsets(model: Model, clearance: float) -> np.ndarray:
    """Return offsets to starboard that leave a clearance, in round steps, (n,) [m]."""
    room = (model.configuration.canal.width - model.configuration.ship.beam) / 2 - clearance
    if room <= 0:
        raise InputError(f"a clearance of {clearance:g} m leaves no offset in this canal; give less")
    power = 10.0 ** math.floor(math.log10(room / OFFSET_STEPS))
    step = next(nice * power for nice in NICE if nice * power >= room / OFFSET_STEPS)
    return np.asarray(step * np.arange(1, math.floor(room / step) + 1))


def usual_speeds(model: Model) -> np.ndarray:
    """Return speeds that a canal lets a ship go, within those of its tests, (n,) [m/s]."""
    choke, covered = keel_at(model, np.empty(0)).choke, model.data_range.speed
    if math.isinf(choke) and covered is None:
        raise InputError("neither a depth nor the tests bound the speed; give the speeds to look at")
    low, high = (SLOWEST_LEG * choke, FASTEST_LEG * choke) if math.isfinite(choke) else covered or (0.0, 0.0)
    if covered and max(low, covered[0]) < min(high, covered[1]):
        low, high = max(low, covered[0]), min(high, covered[1])
    # In the second digit of knots, that a bridge can steer for.
    speeds = np.linspace(low, high, LEG_SPEEDS) / KNOT
    digit = 10.0 ** (math.floor(math.log10(high / KNOT)) - 1)
    return np.unique(np.floor(speeds / digit + 0.5) * digit) * KNOT


def candidates(
    model: Model, offsets: np.ndarray, speeds: np.ndarray, reserve: float, clearance: float, samples: int, seed: int
) -> Candidates:
    """Find the steady courses at offsets and speeds, and whether a ship may be held there."""
    y, u = (part.ravel() for part in np.meshgrid(offsets, speeds, indexing="ij"))
    keel = keel_at(model, u)
    felt = {name: xr.DataArray(part, dims="place") for name, part in {"y": y, "u": u, "heave": keel.midship}.items()}
    mean = steady_course(model, **felt)
    drawn = steady_course(model, samples=samples, seed=seed, **felt).transpose("place", "sample")
    rudder, psi = (np.nan_to_num(drawn[name].to_numpy(), nan=np.inf) for name in ("rudder", "psi"))
    gear, ship, canal = model.configuration.gear, model.configuration.ship, model.configuration.canal
    turned = ship.length / 2 * np.abs(np.sin(mean["psi"].to_numpy()))
    beside = canal.width / 2 - np.abs(y) - ship.beam / 2 - turned >= clearance
    unknown = np.isnan(keel.clearance) & (canal.depth is None)
    under = (unknown | (keel.clearance >= KEEL_SHARE * ship.draft)) & (u < keel.choke)
    rudder_told, psi_told = (np.quantile(part, TOLD, axis=1, method="higher").T for part in (rudder, psi))
    within = (np.abs(rudder) <= (1 - reserve) * gear.limit).mean(axis=1)
    likely, clear = (mean["rudder"].to_numpy(), mean["psi"].to_numpy()), beside & under
    return Candidates(y, u, *likely, rudder_told, psi_told, within, clear)
