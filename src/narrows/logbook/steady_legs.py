"""Steady legs: a ship is held to one side, then to the other; learn from rudder and drift, and plan which to hold."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from scipy.special import chdtrc

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, check_count
from narrows.base.results import Tabulated
from narrows.control.steady_course import check_inside, check_rudder, steady_course
from narrows.logbook import settings
from narrows.logbook.learned_coefficients import (
    LEARNED,
    ON_TWINS,
    LearnedAnswer,
    check_covariance,
    coefficient_prior,
    expected_std,
    learnable,
    learned_model,
    log_posterior,
)
from narrows.logbook.steady_readings import (
    READ,
    SHARED,
    UNKNOWN,
    LegFit,
    LegProblem,
    SteadyConditions,
    SteadyReadings,
    reading_error,
    shared_errors,
    steady_readings,
)
from narrows.model.data_range import extrapolation
from narrows.model.model import Model
from narrows.model.sections import Source
from narrows.quantities.names import KNOT
from narrows.safety.request import keel_at
from narrows.safety.settings import KEEL_SHARE, RESERVE, SURE_SHARE
from narrows.simulation.grid import labelled
from narrows.simulation.outcome import water_notes


@dataclass(frozen=True, repr=False)
class SteadyFit(LearnedAnswer):
    """Result of learning from steady legs."""

    readings: SteadyReadings  #: The legs
    conditions: SteadyConditions  #: Assumptions on wind, zeros and remaining motion
    #: Common errors of all legs in SI, most likely value and standard error: ``wind_Y``, ``wind_N``, ``rudder_zero``,
    #: ``drift_zero``, ``y_zero``
    shared: Mapping[str, tuple[float, float]]
    chi_square: float  #: Sum of squares of the readings over their expected errors [1]
    freedom: int  #: Its degrees of freedom
    probability: float  #: Probability of at least this sum if model, prior and errors are right [1]
    leg_probabilities: Mapping[str, float]  #: The same probability of each leg, given all others
    findings: tuple[str, ...]  #: Faults and undetermined quantities

    @property
    def contradicted(self) -> bool:
        """True where the legs contradict the model, each other or their errors."""
        return self.probability < settings.CONTRADICTION

    @property
    def informative(self) -> bool:
        """True where a coefficient of the bank was learned, and nothing contradicts it."""
        return not self.contradicted and any(c.from_bank and c.status == LEARNED for c in self.coefficients.values())

    @property
    def notes(self) -> tuple[str, ...]:
        """Contradictions, undetermined quantities, assumptions."""
        agreeing = (
            "Legs that agree do not show that they are of this ship: on twins those of one a quarter shorter or longer "
            "agree, and a rudder of the wrong sign may; see to ship, draft and signs."
        )
        taken, doubt = f"Assumed: {self.conditions.summary()}.", () if self.contradicted else (agreeing,)
        return (*self.findings, taken, *self.prior.configuration.notes, *doubt, ON_TWINS)

    def summary(self) -> str:
        agree = (
            f"The legs {'contradict' if self.contradicted else 'agree with'} the model: a sum of squares of "
            f"{self.chi_square:.1f}, {self.freedom} expected."
        )
        return "\n".join((self._learned_sentence(self.readings.summary()), agree, ON_TWINS))

    def to_dict(self) -> dict[str, Any]:
        prior, read = shared_errors(self.conditions, self.prior), self.readings.values
        legs = pd.DataFrame({
            "leg": self.readings.legs, "y": read["y"], "u": read["u"], "rudder_deg": np.degrees(read["rudder"]),
            "direction_deg": np.degrees(read["drift"]), "probability": self.leg_probabilities.values(),
        })  # fmt: skip
        return {
            "summary": self.summary(),
            "informative": self.informative,
            "coefficients": [coefficient.to_dict() for coefficient in self.coefficients.values()],
            "shared": [
                {"name": name, "unit": unit, "value": factor * self.shared[name][0],
                 "std": factor * self.shared[name][1], "prior_std": factor * before}
                for (name, (_, unit, factor)), before in zip(SHARED.items(), prior.tolist(), strict=True)
            ],
            **{name: getattr(self, name) for name in ("chi_square", "freedom", "probability", "contradicted")},
            "legs": legs.to_dict("records"),
            "source": {"table": self.readings.source, "sha256": self.readings.sha256},
            "notes": list(self.notes),
        }  # fmt: skip


@accept_aliases
def learn_steady(model: Model, observations: Any, *, conditions: SteadyConditions | None = None) -> SteadyFit:
    """Learn from a ship that was held off the middle: the steady rudder and drift, to both sides.

    The covariance of the model's coefficients is the prior; the balance of sway and yaw on each leg updates it. Wind
    and the zeros of the instruments are unknown and the same on all legs; the slope over both sides cancels them.

    Raises an InputError where the model has no rudder or no covariance, or the rows are no legs of this ship in this
    canal.

    Parameters
    ----------
    model : Model
        Model of the ship at its own size in the canal of the legs, with a rudder and a covariance.
    observations : DataFrame, mapping of str to array, str or Path
        A row a leg: y [m], u [m/s], rudder, drift, and their errors ``y_error`` and so on where they are
        known; SI and radians unless a header has a unit (``rudder [deg]``).
    conditions : SteadyConditions, optional
        Sizes of wind and zeros, the remaining motion on a leg, and errors that the rows lack.
    """
    check_rudder(model)
    check_covariance(model)
    conditions = conditions or SteadyConditions()
    readings = steady_readings(observations, conditions)
    read = readings.values
    check_inside(read["y"], model.configuration.canal.width, model.configuration.ship.beam)
    problem = LegProblem(coefficient_prior(model, "held"), conditions, readings)
    try:
        found = problem.fit()
    except np.linalg.LinAlgError:
        raise InputError("errors of these readings are beyond all measure; check each, and its unit") from None
    probability = float(chdtrc(found.counted, max(found.chi_square, 0.0)))
    each = chdtrc(found.counted // len(readings), np.maximum(found.left_out, 0.0))
    by_leg = dict(zip(readings.legs, each.tolist(), strict=True))
    posterior = log_posterior(problem, found.unknowns, found.information)
    text, contradicted = f"learned from {readings.summary()} ({readings.source})", probability < settings.CONTRADICTION
    source = Source(text, readings.source, readings.sha256)
    after, learned = learned_model(model, posterior, source, abs(read["y"]), read["u"], contradicted)
    std = np.sqrt(np.diag(problem.covariance(found.information)))
    common = problem.common[:, None] * np.stack([found.unknowns, std], axis=1)[problem.count :]
    shared = dict(zip(UNKNOWN, map(tuple, common.tolist()), strict=True))
    findings = tuple(_findings(problem, found, min(by_leg, key=by_leg.__getitem__), probability))
    checks = found.chi_square, found.counted, probability, by_leg, findings
    return SteadyFit(after, model, learned, readings, conditions, shared, *checks)


def _findings(problem: LegProblem, found: LegFit, worst: str, probability: float) -> Iterator[str]:
    read, squares = problem.readings.values, found.chi_square
    if not read["y"].min() < 0 < read["y"].max():
        yield "All legs are on one side of the middle: wind and zeros do not cancel; hold the other side too."
    if probability < settings.CONTRADICTION:
        yield (
            f"The legs contradict the model, each other or their errors: a sum of squares of {squares:.1f} where "
            f"{found.counted} was to be expected; leg {worst} fits worst. Hold it again, or look at the instruments."
        )
    for name in ("rudder", "drift") if squares > settings.WRONG_SIGN_GAIN else ():  # Else there is nothing to be won.
        turned = replace(problem.readings, values={**read, name: -read[name]})
        other = replace(problem, readings=turned).fit().chi_square
        if squares - other > settings.WRONG_SIGN_GAIN:
            yield (
                f"With the other sign of {name} the legs fit far better, {other:.1f} instead of {squares:.1f}: is it "
                "positive where it turns the bow to starboard, or where the bow is to starboard?"
            )
    if not found.converged:
        yield "The search for the true states of the legs did not converge; give smaller errors of y and u."
    asked, covered = {"speed": read["u"], "abs_y": np.abs(read["y"])}, problem.model.data_range
    yield from extrapolation(covered, {name: column for name, column in asked.items() if getattr(covered, name)})
    yield "A steady balance determines ratios of forces: their scale is that of the tests."


@dataclass(frozen=True, repr=False)
class SteadyPlan(Tabulated):
    """Legs to hold, in the order to hold them."""

    #: A row a leg; none where none is allowed: ``offset`` to starboard [m], ``side``, ``speed`` through the water [kn],
    #: 5 %, 50 % and 95 % quantiles of rudder and drift, given the tests (``rudder_low`` ...) [deg], and standard errors
    #: once it is read (``std b_bank`` ...)
    legs: tuple[Mapping[str, Any], ...]
    std: Mapping[str, np.ndarray]  #: (legs + 1,) Standard error of each target, before the first leg and after each
    model: Model  #: The ship
    conditions: SteadyConditions  #: Wind, zeros, what is left of motion, and errors of the readings
    farthest: float  #: Largest allowed offset of legs [m]
    notes: tuple[str, ...]  #: Rejected legs and why, and assumptions

    @property
    def most_rudder(self) -> float:
        """Rudder [rad] at which a leg is to be broken off: what leaves the reserve."""
        return (1 - RESERVE) * self.model.configuration.gear.limit

    @property
    def settling(self) -> float:
        """Settling time before a leg is read [s]."""
        speed = KNOT * self.legs[0]["speed"] if self.legs else np.inf
        return settings.SETTLING * self.model.configuration.ship.length / speed

    def summary(self) -> str:
        if not self.legs:
            return "No leg off the middle is allowed: what the tests leave open of the rudder is more than its reserve."
        gains = "; ".join(f"{name}: standard error {s[0]:.2g} now, {s[-1]:.2g} after" for name, s in self.std.items())
        held = f"{len(self.legs)} legs of {self.conditions.leg_time:g} s: {gains}."
        return f"{held}\nLegs are allowed to {self.farthest:.3g} m off the middle.\n{ON_TWINS}"

    def rows(self) -> list[dict[str, Any]]:
        """Give a row a leg, in metres, knots and degrees, with the standard errors once it is read."""
        return [dict(leg) for leg in self.legs]

    def to_dict(self) -> dict[str, Any]:
        return {
            "summary": self.summary(),
            "legs": self.rows(),
            "targets": {n: {"std": float(std[0]), "std_after": float(std[-1])} for n, std in self.std.items()},
            "break_off_rudder": float(np.degrees(self.most_rudder)),
            "clearance": self.model.configuration.ship.beam / 2,
            "farthest": self.farthest,
            "notes": list(self.notes),
        }  # fmt: skip


ANGLES = [f"{angle}_{quantile}" for angle in ("rudder", "drift") for quantile in ("low", "median", "high")]


@accept_aliases
def plan_steady(
    model: Model, offsets: Sequence[float] | np.ndarray | None = None,
    speeds: Sequence[float] | np.ndarray | None = None, *, legs: int = 4,
    targets: Sequence[str] = (), conditions: SteadyConditions | None = None,
) -> SteadyPlan:  # fmt: skip
    """Choose the offset and speed of steady legs that make some coefficients best known, among those safe to hold.

    Legs are held to either side in turn, since opposite sides cancel wind and zeros. A leg is allowed if in 95 % of the
    samples of the coefficients the steady rudder leaves a third of its range, the side half a beam to the bank, and the
    keel its clearance. Whether a pilot holds the ship there is a test of ``safe_envelope``.

    Raises an InputError where the model has no rudder or no covariance, a number is out of range, or a target is
    unknown.

    Parameters
    ----------
    model : Model
        As for ``learn_steady``.
    offsets, speeds : sequence of float [m], [m/s], optional
        Offsets to either side, and speeds through the water, that may be held.
    legs, targets, conditions : int, sequence of str, SteadyConditions
        Number of legs, even; the coefficients that matter, by default those of the bank; errors of the readings.
    """
    check_rudder(model)
    check_covariance(model)
    names, conditions = learnable(model, targets), conditions or SteadyConditions()
    check_count("legs", legs, 2, settings.MOST_LEGS)
    if legs % 2:
        raise InputError(f"legs = {legs}: give an even number, for wind and zeros cancel over both sides")
    beside = usual_offsets(model) if offsets is None else _rising("offsets", offsets)
    ahead = usual_speeds(model) if speeds is None else _rising("speeds", speeds)
    check_inside(beside, model.configuration.canal.width, model.configuration.ship.beam)
    (y, u, rudder, drift), refused = allowed_legs(model, beside, ahead)
    # Legs held exactly at each place, to starboard and then to port.
    side = np.repeat([1.0, -1.0], len(y))
    medians = side * np.tile(y, 2), np.tile(u, 2), *(side * np.tile(angle[:, 1], 2) for angle in (rudder, drift))
    stated = {name: np.full(len(side), reading_error(conditions, name)) for name in READ}
    readings = SteadyReadings(tuple(map(str, range(len(side)))), dict(zip(READ, medians, strict=True)), stated)
    problem = LegProblem(coefficient_prior(model, "held"), conditions, readings)
    starboard, port = np.split(problem.informations(), 2)
    information = np.zeros(problem.precision.shape)
    before, rows = expected_std(problem, information), list[dict[str, Any]]()

    def left(i: int) -> float:  # Relative variance of the targets with all legs there
        after = expected_std(problem, legs / 2 * (starboard[i] + port[i]))
        return sum((after[name] / before[name]) ** 2 for name in names if before[name] > 0)

    if len(y):
        best = min(range(len(y)), key=left)
        for turn in range(legs):
            sign = 1 if turn % 4 in (0, 3) else -1  # The sides come first in turn, so that what grows with time cancels
            information = information + (starboard if sign > 0 else port)[best]
            after = expected_std(problem, information)
            angles = np.degrees([sign * angle[best, ::sign] for angle in (rudder, drift)]).ravel().tolist()
            place = {"offset": sign * float(y[best]), "side": "port" if sign < 0 else "starboard"}
            row = place | {"speed": float(u[best]) / KNOT} | dict(zip(ANGLES, angles, strict=True))
            rows.append(row | {f"std {name}": after[name] for name in names})
    std = {name: np.array([before[name], *(row[f"std {name}"] for row in rows)]) for name in names}
    notes = (
        *model.notes, *water_notes(None, model.configuration.canal.depth), *refused,
        f"Assumed: {conditions.summary()}.",
        "The plan looks at the steady rudder, the side and the keel; the safe envelope tests whether a pilot holds the "
        "ship there, and the master decides.",
    )  # fmt: skip
    return SteadyPlan(tuple(rows), std, model, conditions, float(y.max(initial=0.0)), notes)


def _rising(name: str, values: object) -> np.ndarray:
    column = np.unique(labelled(name, values))
    if column[0] <= 0:
        raise InputError(f"the {name} that may be held are numbers over 0; give a sequence of them")
    return column


def usual_offsets(model: Model) -> np.ndarray:
    """Return offsets to starboard that leave half a beam to the bank, in round steps, (n,) [m]."""
    room = model.configuration.canal.width / 2 - model.configuration.ship.beam
    if room <= 0:
        raise InputError("half a beam to the bank leaves no offset in this canal; plan in a wider one")
    step = float(f"{room / settings.OFFSET_STEPS:.0e}")
    return np.asarray(step * np.arange(1, math.floor(room / step) + 1))


def usual_speeds(model: Model) -> np.ndarray:
    """Return speeds that a canal lets a ship go, within those of its tests, (n,) [m/s]."""
    choke, covered = keel_at(model, np.empty(0)).choke, model.data_range.speed
    if math.isinf(choke):
        if covered is None:
            raise InputError("neither a depth nor the tests bound the speed; give the speeds to look at")
        choke = covered[1] / settings.FASTEST_LEG
    low, high = settings.SLOWEST_LEG * choke, settings.FASTEST_LEG * choke
    if covered and max(low, covered[0]) < min(high, covered[1]):
        low, high = max(low, covered[0]), min(high, covered[1])
    # In the second digit of knots, that a bridge can steer for.
    speeds = np.linspace(low, high, settings.LEG_SPEEDS) / KNOT
    digit = 10.0 ** (math.floor(math.log10(high / KNOT)) - 1)
    return np.unique(np.floor(speeds / digit + 0.5) * digit) * KNOT


def allowed_legs(
    model: Model, offsets: np.ndarray, speeds: np.ndarray
) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray], list[str]]:
    """Return offsets, speeds, rudders and drifts (n, 3) of legs to starboard that may be held; sentences on others."""
    y, u = (part.ravel() for part in np.meshgrid(offsets, speeds, indexing="ij"))
    keel = keel_at(model, u)
    steady = {name: xr.DataArray(part, dims="place") for name, part in {"y": y, "u": u, "heave": keel.midship}.items()}
    drawn = steady_course(model, samples=settings.PLAN_SAMPLES, **steady).transpose("place", "sample")
    helm, psi = (np.nan_to_num(drawn[name].to_numpy(), nan=np.inf) for name in ("rudder", "psi"))
    rudder, drift = (np.quantile(part, (0.05, 0.5, 0.95), axis=1, method="higher").T for part in (helm, psi))
    gear, ship, canal = model.configuration.gear, model.configuration.ship, model.configuration.canal
    with np.errstate(invalid="ignore"):  # No steady course
        turned = ship.length / 2 * np.abs(np.sin(drift[:, 1]))
    beside = canal.width / 2 - np.abs(y) - ship.beam / 2 - turned >= ship.beam / 2
    unknown = np.isnan(keel.clearance) & (canal.depth is None)
    clear = beside & (unknown | (keel.clearance >= KEEL_SHARE * ship.draft)) & (u < keel.choke)
    within = (np.abs(helm) <= (1 - RESERVE) * gear.limit).mean(axis=1)
    notes, allowed = [], clear & (within >= SURE_SHARE)
    if (short := clear & ~allowed).any():
        first = int(np.argmin(np.where(short, y, np.inf)))
        notes.append(
            f"{short.sum()} of {len(y)} places are not allowed for the rudder: at {y[first]:.3g} m only "
            f"{100 * within[first]:.0f} % of the samples leave {100 * RESERVE:.0f} % of it."
        )
    if not clear.all():
        notes.append(f"{(~clear).sum()} are not allowed for the keel, or for {ship.beam / 2:.3g} m to the bank.")
    return (y[allowed], u[allowed], rudder[allowed], drift[allowed]), notes
