"""Verdict on each coefficient, by its posterior and its columns, and implausible masses, signs and rudders of a fit."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from narrows.base.results import Aliased, equal_to, interval, with_error
from narrows.captive.tests import CaptiveTests
from narrows.identification.estimates import HALF, CoefficientEstimates
from narrows.identification.least_squares import RANK_TOLERANCE
from narrows.identification.motions import DistinctMotions
from narrows.identification.normal_equations import ONE, NormalEquations, Score, score
from narrows.identification.systematic_effects import Effect
from narrows.model.term import Term, TermKind, TermTable
from narrows.model.water import ittc57, ship_inertia, ship_mass, wetted_surface
from narrows.physics.hull import clarke_sway, clarke_yaw
from narrows.quantities.names import evaluate

IDENTIFIED, IMPRECISE, NOT_SEPARABLE, ZERO = "identified", "imprecise", "not separable", "zero"
AT_BOUND, NOT_EXCITED, NOT_IDENTIFIABLE = "at bound", "not excited", "not identifiable"
# Half width of the interval over the estimate, below which a coefficient is identified.
PRECISE = 0.5
# Share of the force that a term makes, below which its coefficient is zero for practical purposes.
NEGLIGIBLE = 0.02
# Posterior correlation of two coefficients beyond which the tests do not separate them.
INSEPARABLE = 0.9
# A column takes part in a direction of unit length where its share is larger than this.
INVOLVED = 1e-3


@dataclass(frozen=True)
class Diagnosis:
    names: tuple[str, ...]  # The coefficients
    rank: int  # Number of directions with data
    condition: float  # Condition number of the matrix with columns scaled to one; infinite where the rank is short [1]
    # Variance inflation, 1/(1 - R2) of a column on the others, without intercept as the model has none; infinite
    # where the column is a combination of others, NaN where it is zero [1]
    vif: Mapping[str, float]
    correlation: np.ndarray  # (n, n) Correlation of the columns; NaN where one does not vary
    empty: tuple[str, ...]  # Coefficients whose column is zero
    # (k, n) Directions without data, of unit length, among the columns that are not zero, each scaled to one
    missing: np.ndarray

    def to_dict(self) -> dict[str, Any]:
        return {"rank": self.rank, "columns": len(self.names), "condition": self.condition, "vif": dict(self.vif)}


def diagnose(equations: NormalEquations, sums: np.ndarray, terms: tuple[Term, ...]) -> Diagnosis:
    names = [term.name for term in terms]
    gram, mean = equations.pick(sums, names), equations.pick(sums, names, [ONE])[:, 0]
    norm = np.sqrt(np.diag(gram))
    live = norm > 0
    lengths = np.where(live, norm, np.nan)
    alignment = gram / np.outer(lengths, lengths)
    values, vectors = np.linalg.eigh(alignment[np.ix_(live, live)])
    singular = np.sqrt(np.maximum(values, 0.0))
    kept = singular > RANK_TOLERANCE * singular.max(initial=1e-300)
    missing = np.zeros((int((~kept).sum()), len(names)))
    missing[:, live] = vectors[:, ~kept].T
    vif = np.full(len(names), np.nan)
    vif[live] = np.maximum((vectors[:, kept] ** 2 / values[kept]).sum(axis=1), 1.0)
    vif[(np.abs(missing) > INVOLVED).any(axis=0)] = np.inf
    covariance = gram - np.outer(mean, mean) / equations.pick(sums, [ONE])[0, 0]
    variance = np.diag(covariance)
    # A constant column leaves only rounding.
    spread = np.sqrt(np.where(variance > 1e-12 * np.diag(gram), variance, np.nan))
    return Diagnosis(
        tuple(names),
        rank=int(kept.sum()),
        condition=float(singular[-1] / singular[0]) if kept.sum() == len(names) else float("inf"),
        vif=dict(zip(names, vif.tolist(), strict=True)),
        correlation=np.clip(covariance / np.outer(spread, spread), -1.0, 1.0),
        empty=tuple(name for name, alive in zip(names, live, strict=True) if not alive),
        missing=missing,
    )


@dataclass(frozen=True)
class Diagnostics:
    """The columns of every force, whatever the forces are; each diagnosis is made when it is first asked for."""

    equations: NormalEquations  # The sums
    terms: TermTable  # The terms
    motions: DistinctMotions  # The distinct motions, and their speeds

    @cached_property
    def overall(self) -> dict[str, Diagnosis]:
        """Over all rows: force -> diagnosis."""
        return self.over(self.equations.total)

    @cached_property
    def by_speed(self) -> dict[float, dict[str, Diagnosis]]:
        """Over the tests of each speed together: mean speed [m/s] -> force -> diagnosis."""
        motions = self.motions
        return {
            float(np.mean(motions.features["speed"][members])): self.over(motions.sums[members].sum(axis=0))
            for members in motions.by_speed
        }

    def over(self, sums: np.ndarray) -> dict[str, Diagnosis]:
        return {force: diagnose(self.equations, sums, part) for force, part in self.terms.forces.items() if part}

    def determined(self, name: str) -> bool:
        """Return whether rows determine a coefficient, through its own force or through one that it is tied to."""
        tied = {name, *(other for tie in self.terms.ties if name in tie for other in tie)}
        return any(np.isfinite(d.vif[other]) for d in self.overall.values() for other in tied if other in d.names)


@dataclass(frozen=True)
class Verdict(Aliased):
    """Verdict on a coefficient."""

    status: str  # identified, imprecise, not separable, zero, at bound, not identifiable or not excited
    reasons: tuple[str, ...] = ()  # Why, each a clause
    partners: tuple[str, ...] = ()  # Coefficients from which the tests do not separate it
    # Errors of a campaign that would bring the interval to 0, the least unusual first, each with its size; those that
    # move the estimate by its standard error, or are too large to be sure that they do not
    tipping: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    __eq__ = equal_to("status")

    @property
    def determined(self) -> bool:
        """Whether the data determine the coefficient at all."""
        return self.status not in (NOT_EXCITED, NOT_IDENTIFIABLE)

    @property
    def words(self) -> str:
        """The status, and the coefficients from which the tests do not separate it."""
        word = NOT_IDENTIFIABLE if self.status == NOT_EXCITED else self.status
        return f"{word} from {' and '.join(self.partners)}" if self.partners else word

    def sentence(self, name: str) -> str:
        limited = (f"off by a standard error with {' or '.join(self.limits)}",) * bool(self.limits)
        tipped = (f"overturned by {' or '.join(self.tipping)}",) * bool(self.tipping)
        clauses = "; ".join((*self.reasons, *limited, *tipped))
        return f"{name} is {self.words}" + (f": {clauses}." if clauses else ".")


def verdicts(
    diagnostics: Diagnostics, found: CoefficientEstimates, left_out: Mapping[str, Score]
) -> dict[str, Verdict]:
    judged = {}
    for force, part in diagnostics.terms.forces.items():
        for term in part:
            verdict = _without_data(term, force, diagnostics) or _judged(term.name, found)
            # No interval is trusted where the mean predicts a force of left-out tests better than the terms do.
            if verdict.status == IDENTIFIED and left_out[force].r2 < 0:
                r2 = f"R2 {left_out[force].r2:.2f}"
                reason = f"{force} of left-out tests is predicted worse than by its mean ({r2})"
                verdict = Verdict(IMPRECISE, (*verdict.reasons, reason))
            judged[term.name] = verdict
    return judged


def _without_data(term: Term, force: str, diagnostics: Diagnostics) -> Verdict | None:
    """A coefficient that its own force's columns do not determine; one that is tied may be known by its partner."""
    overall = diagnostics.overall[force]
    if diagnostics.determined(term.name):
        return None
    if term.name in overall.empty:
        what = term.inputs[0] if len(term.inputs) == 1 else "its regressor"
        return Verdict(NOT_EXCITED, (f"{what} is 0 in every test",))
    for direction in overall.missing:  # The data determine the orthogonal combinations
        involved = [name for name, part in zip(overall.names, direction, strict=True) if abs(part) > INVOLVED]
        if term.name in involved:
            names = " and ".join(involved)
            reason = f"the tests determine {names} only in combination, their columns being dependent"
            return Verdict(NOT_IDENTIFIABLE, (reason,))
    return None


def _judged(name: str, found: CoefficientEstimates) -> Verdict:
    names, slot = found.problem.terms.names, found.problem.slot
    index = names.index(name)
    value, (low, high) = float(found.values[index]), found.ends[index].tolist()
    half = (high - low) / 2
    if found.held[index]:
        return Verdict(AT_BOUND, (f"the data alone would put it beyond, at {found.free_values[index]:.3g}",))
    known = with_error(value, half)
    if (low > 0 or high < 0) and half < PRECISE * abs(value):
        tipping, limits = (_named(errors[name]) for errors in (found.tipping, found.limits))
        return Verdict(IDENTIFIED, (f"{known}, {half / abs(value):.0%}",), (), tipping, limits)
    part = next(part for part in found.forces if slot[name] in part.rows.free_parameters)
    # The unit is the value at which the term is as large as its force.
    if max(abs(low), abs(high)) < NEGLIGIBLE * part.unit[part.rows.free_parameters.index(slot[name])]:
        return Verdict(ZERO, (f"{low:.2g} to {high:.2g} makes less than {NEGLIGIBLE:.0%} of the force",))
    # The coefficient whose estimate is most correlated with this one's, and the combination that the tests determine.
    c, size = found.covariance, np.sqrt(np.diag(found.covariance))
    others = np.array([slot[other] != slot[name] for other in names]) & (size > 0)
    correlation = np.abs(c[index]) / np.where(others & (size[index] > 0), size * size[index], np.inf)
    other = int(correlation.argmax())
    if correlation[other] > INSEPARABLE:
        slope = -c[index, other] / c[other, other]
        error = HALF * float(np.sqrt(max(c[index, index] + slope * c[index, other], 0.0)))
        combined = with_error(value + slope * found.values[other], error)
        reason = f"the tests determine {name} {slope:+.3g} {names[other]} = {combined}"
        return Verdict(NOT_SEPARABLE, (reason,), (names[other],))
    return Verdict(IMPRECISE, (f"{known}, its 95 % interval is {interval((low, high), half)}",))


def _named(errors: list[tuple[Effect, float]]) -> tuple[str, ...]:
    """The three least unusual errors, one of each kind."""
    by_kind: dict[str, str] = {}
    for effect, size in errors:
        by_kind.setdefault(effect.name.split(" ")[0], f"{size:.2g} {effect.unit} of {effect.name}")
    return tuple(by_kind.values())[:3]


# Least share of the added mass in deep water that a hull has; most times mass and added mass in deep water, which
# shallow water and near banks multiply.
LEAST_ADDED, MOST = 0.5, 10.0
# Standard errors by which a mass must exceed its plausible range; least force of such a mass over the residual of the
# fit for a warning.
SURE, LEAST_FORCE = 2.0, 0.1
# Sign conventions of a force whose other sign fits better.
AXES = {"X": "X counted astern", "Y": "Y counted to port", "N": "N counted anticlockwise"}
# Units of forces other than N and N m, and their factors.
UNITS = {"kgf or kgf m": 9.80665, "kN or kN m": 1e3}
EXCHANGED = (
    "Neither the mass in sway nor the inertia in yaw is this ship's, and Y grows with the yaw acceleration as a moment "
    "does: are the columns Y and N exchanged?"
)
Known = dict[str, tuple[float, float]]  # Estimate without bounds and standard error, where the tests determine it
# Force, acceleration and name of a mass or inertia; its unit, its bare value and its added value in deep water.
MASSES = (
    ("Y", "vdot", "mass in sway", "kg", ship_mass, clarke_sway),
    ("N", "rdot", "inertia in yaw", "kg m2", ship_inertia, clarke_yaw),
)


def implausible(fit: Any) -> tuple[str, ...]:
    turned = [force for force in AXES if fits_reversed(fit, force)]
    names, determined = fit.terms.names, fit.diagnostics.determined
    columns = zip(names, fit.estimates.free_values.tolist(), fit.estimates.free_std.tolist(), strict=True)
    known = {name: (value, std) for name, value, std in columns if determined(name)}
    rejected = [name for name, held in zip(names, fit.estimates.held, strict=True) if held]
    wrong = " and ".join(t.name for t in fit.terms.terms if t.kind == TermKind.RUDDER and t.name in rejected)
    # Y that answers a yaw acceleration by half of the ship's inertia in yaw is a moment.
    answers = [known.get(term.name, (0.0, 0.0))[0] for term in fit.terms.forces["Y"] if term.inputs == ("rdot",)]
    half = ship_inertia(fit.tests.configuration) / 2
    masses = [mass_sentence(fit, known, *mass) for mass in MASSES if mass[0] not in turned]
    sentences = (
        *(f"{force} of the other sign fits far better: is {AXES[force]}?" for force in turned),
        "" if "X" in turned else surge_sentence(fit),
        "" if turned else bank_sentence(fit.terms, known),
        *((EXCHANGED,) if masses and all(masses) and any(answer > half for answer in answers) else masses),
        f"The data put {wrong} below 0: is the rudder's sign reversed (positive where it turns the bow to starboard)?"
        * bool(wrong),
    )
    return tuple(filter(None, sentences))


def fits_reversed(fit: Any, force: str) -> bool:
    if not fit.terms.forces[force]:
        return False
    equations, sign = fit.normal_equations, np.ones(len(fit.normal_equations.total))
    sign[equations.columns[force]] = -1
    other = equations.total * np.outer(sign, sign)
    again = fit.problem.named(fit.problem.solve(other).z)
    now = score(equations, equations.total, fit.terms, fit.least_squares)[force].rmse
    return score(equations, other, fit.terms, again)[force].rmse < 0.7 * now  # Clearly less


def surge_sentence(fit: Any) -> str:
    """Warn that X pushes the ship ahead, run by run, or resists less than its friction; empty where a propeller may."""
    tests, ship, terms = fit.tests, fit.tests.configuration.ship, fit.terms
    if not terms.forces["X"] or not isinstance(tests, CaptiveTests):
        return ""
    means = np.array([np.mean(np.sign(run["u"]) * run["X"]) for run in tests])
    propelled = any(actuator.name == "revolutions" for actuator in terms.actuators) or len(means) < 2
    # Three standard errors over the runs
    if not propelled and means.mean() > 3 * means.std(ddof=1) / math.sqrt(len(means)):
        return (
            f"X pushes the ship the way it goes, by {means.mean():.2g} N in the mean of {len(means)} runs: is X "
            "counted astern, or does a propeller push?"
        )
    u, density = tests.columns["u"], tests.configuration.water.density
    fast = np.abs(u) > np.abs(u).max() / 2
    speed = float(np.sqrt(np.mean(u[fast] ** 2)))
    line = ittc57(max(speed * ship.length / 1.0e-6, 1e5))  # Fresh water at 20 degrees; least Reynolds number
    friction = 0.5 * density * wetted_surface(ship) * speed**2 * line
    drag = -float(np.mean(np.sign(u[fast]) * tests.columns["X"][fast]))
    # Every hull resists with more than the friction of the line, and knots read as m/s divide the ratio by 3.8.
    if "revolutions" in tests.columns or not 0 < drag < 0.9 * friction:
        return ""
    return (
        f"X resists with {drag:.2g} N in the mean, {drag / friction:.2g} of the friction of this hull at "
        f"{speed:.2g} m/s: is u in knots ('u [kn]'), X in another unit, or does a propeller push?"
    )


def bank_sentence(terms: TermTable, known: Known) -> str:
    """Warn that both force and moment of the bank have the wrong sign; empty where they have not."""
    bank = [known.get(term.name, (0.0, 0.0)) for term in terms.terms if term.from_bank]
    if len(bank) != 2 or not all(value < 0 and value <= -SURE * std for value, std in bank):
        return ""
    return (
        "The nearer bank pushes the ship off and draws in its bow, the opposite of every published bank: are port and "
        "starboard exchanged in y, or does y count from a bank?"
    )


def mass_sentence(
    fit: Any, known: Known, force: str, rate: str, words: str, unit: str, bare_of: Any, clarke: Any
) -> str:
    """Warn that a mass or inertia is implausible for the ship with its added mass, and why."""
    names = [term.name for term in fit.terms.forces[force] if term.inputs == (rate,)]
    if len(names) != 1 or names[0] not in known:
        return ""
    (name,), equations, configuration = names, fit.normal_equations, fit.tests.configuration
    bare, added = bare_of(configuration), evaluate(clarke, configuration.values())
    least, most, (value, std) = bare + LEAST_ADDED * added, MOST * (bare + added), known[name]
    if least <= value + SURE * std and value - SURE * std <= most:
        return ""
    # Such a mass must change the forces by more than the residuals.
    (size, _), (_, rows) = equations.pick(equations.total, [name, ONE])
    left = score(equations, equations.total, fit.terms, fit.least_squares)[force].rmse
    if least * math.sqrt(size / rows) <= LEAST_FORCE * left:
        return ""
    cause = _cause(value, bare + added, force, value + SURE * std < least)
    return (
        f"{name} = {value:.3g} {unit} cannot be this ship's {words}, which with its added "
        f"mass is about {bare + added:.3g} {unit} in deep water and more in shallow: {cause}"
    )


def _cause(value: float, expected: float, force: str, small: bool) -> str:
    if value <= 0:
        return f"is the sign of {force}, or of the accelerations, reversed?"
    if not small:
        return f"is the unit of {force} smaller than that of its header, or the ship file of a smaller model?"
    for unit, size in UNITS.items():
        if abs(math.log(expected / value / size)) < math.log(2):
            return f"is {force} in {unit}?"
    return f"has the ship's own inertia been taken off {force} already, or is the ship file of a larger model?"


def unmodelled_rudder(equations: NormalEquations, terms: TermTable) -> str:
    """Return a warning, with remedy, of a moving rudder without a rudder term; empty if there is none."""
    if "rudder" not in equations.moved or any(actuator.name == "rudder" for actuator in terms.actuators):
        return ""
    rows, total, squares = equations.moved["rudder"].T
    mean = total / rows  # By the sums of each stretch, as of a sine about its mean
    angle = float((np.abs(mean) + np.sqrt(2 * np.maximum(squares / rows - mean**2, 0.0))).max())
    if angle < math.radians(1):
        return ""
    return (
        f"the rudder goes to about {math.degrees(angle):.0f} deg and no term has it, so other terms absorb its force: "
        f"take the terms {terms.name}+helm, or rows with it amidships (--where 'abs(rudder_deg) < 1')"
    )
