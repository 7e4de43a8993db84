"""Coefficients before and after a record: prior, posterior, standard errors by the scatter of records, verdicts."""

import math
from collections.abc import Collection, Mapping
from dataclasses import astuple, dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from scipy import special

from narrows.base.errors import InputError, shown
from narrows.base.named_values import Named
from narrows.base.results import Aliased, BaseResult
from narrows.identification.least_squares import free_parameters
from narrows.identification.verdict import IDENTIFIED
from narrows.logbook.filtering.log_problem import CoefficientPrior, Unknowns
from narrows.logbook.settings import LEARNED_TO, SHARPENED_TO
from narrows.model.additions import ASYMMETRY, RUDDER_EVEN, STRAIGHTENED, STRAIGHTENING, asymmetric
from narrows.model.data_range import DataRange, Range
from narrows.model.derived_models import extend
from narrows.model.model import Model
from narrows.model.sections import Source
from narrows.model.term import TermKind
from narrows.quantities.names import ACCELERATIONS, FORCES
from narrows.ship.motion import Motion
from narrows.simulation.ship import SimulatedShip

LEARNED, SHARPENED, PRIOR, UNRESOLVED = "learned", "sharpened", "from the prior", "unresolved"
QUANTILE_95 = 1.959964  # Half-width of the central 95 % of a normal distribution [standard errors]


@dataclass(frozen=True)
class LearnedCoefficient(Aliased):
    """A coefficient before a record and after it."""

    name: str
    unit: str
    prior: float  # Value before
    prior_std: float  # Standard error before
    value: float  # Value after
    std: float  # Standard error after
    from_bank: bool  # Whether its term is one of the bank

    @property
    def std_ratio(self) -> float:
        """Standard error over the one before; 1 where that was 0."""
        return self.std / self.prior_std if self.prior_std > 0 else 1.0

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval after."""
        return self.value - QUANTILE_95 * self.std, self.value + QUANTILE_95 * self.std

    @property
    def likelihood_interval(self) -> tuple[float, float]:
        """95 % interval by the record alone, the prior of this coefficient removed; infinite without information."""
        before, after = (1 / std**2 if std > 0 else math.inf for std in (self.prior_std, self.std))  # Precisions
        if not before < after < math.inf:
            return -math.inf, math.inf
        gained = after - before
        value = (self.value * after - self.prior * before) / gained
        return value - QUANTILE_95 / math.sqrt(gained), value + QUANTILE_95 / math.sqrt(gained)

    @property
    def unresolved(self) -> bool:
        """True if the interval contains 0; for a learned coefficient also if that of the record alone does."""
        intervals = (self.interval, self.likelihood_interval) if self.status == LEARNED else (self.interval,)
        return any(low <= 0 <= high for low, high in intervals)

    @property
    def status(self) -> str:
        """``learned``, ``sharpened`` or ``from the prior``."""
        return LEARNED if self.std_ratio <= LEARNED_TO else SHARPENED if self.std_ratio <= SHARPENED_TO else PRIOR

    @property
    def verdict(self) -> str:
        """The status; for a bank coefficient that may be 0 also ``unresolved``."""
        return f"{self.status}, {UNRESOLVED}" if self.from_bank and self.unresolved else self.status

    def to_dict(self) -> dict[str, Any]:
        known = {"prior": self.prior, "prior_std": self.prior_std, "value": self.value, "std": self.std}
        return {"name": self.name, "unit": self.unit, **known, "interval": list(self.interval), "verdict": self.verdict}

    def sentence(self) -> str:
        low, high = self.interval
        words = f"{self.name} is {low:.3g} to {high:.3g} (standard error {self.std:.2g}, {self.prior_std:.2g} before)"
        if not (self.from_bank and self.unresolved):
            return words
        own_low, own_high = self.likelihood_interval
        among = "0 is among it" if low <= 0 <= high else f"by the record alone it is {own_low:.3g} to {own_high:.3g}"
        return f"{words}: unresolved, for {among}"


@dataclass(frozen=True, repr=False)
class LearnedAnswer(BaseResult):
    model: Model  #: The model after the record
    prior: Model  #: The model before
    coefficients: Mapping[str, LearnedCoefficient]  #: Each before and after

    @property
    def std(self) -> dict[str, float]:
        """Standard error of each coefficient."""
        return {name: c.std for name, c in self.coefficients.items()}

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """95 % interval of each coefficient."""
        return {name: c.interval for name, c in self.coefficients.items()}

    @property
    def verdicts(self) -> dict[str, str]:
        """Verdict on each coefficient, in a word or two."""
        return {name: c.verdict for name, c in self.coefficients.items()}

    def to_dataframe(self) -> pd.DataFrame:
        """Give the coefficients as a table: a row each, before and after."""
        known = self.coefficients
        rows = [
            (c.prior, c.prior_std, c.value, c.std, *c.interval, c.std_ratio, c.unit, c.verdict) for c in known.values()
        ]
        columns = ["prior", "prior_std", "value", "std", "low", "high", "std_left", "unit", "verdict"]
        return pd.DataFrame(rows, columns=columns, index=pd.Index(list(known), name="coefficient"))

    def _learned_sentence(self, source: str) -> str:
        known = [c for c in self.coefficients.values() if c.prior_std > 0]
        sentences = [c.sentence() for c in known if c.from_bank and c.status != PRIOR]
        learned = [c.name for c in known if c.status == LEARNED and not c.from_bank]
        sentences += [f"learned: {', '.join(learned)}"] * bool(learned)
        unchanged = ", ".join(c.name for c in known if c.status == PRIOR)
        rest = f" Unchanged from the prior: {unchanged}." if unchanged else ""
        return f"Learned from {source}: {'; '.join(sentences) or 'nothing'}.{rest}"


def learnable(model: Model, targets: object) -> tuple[str, ...]:
    names = (targets,) if isinstance(targets, str) else targets
    if not isinstance(names, tuple | list):
        raise InputError(f"targets = {shown(targets)}: give names of coefficients")
    for name in names:
        model[str(name)]  # Raises where there is none
    names = tuple(names) or tuple(term.name for term in model.terms.terms if term.from_bank)
    if not names:
        raise InputError("this model has no terms of the bank to learn; name the coefficients that matter as targets")
    return names


# Note on every page, result and report.
ON_TWINS = "Bank coefficients from legs and transits are tested on simulated twins only."


def learned_model(
    prior: Model, posterior: "LogPosterior", source: Source, offsets: np.ndarray, speeds: np.ndarray,
    contradicted: bool = False,
) -> tuple[Model, dict[str, LearnedCoefficient]]:  # fmt: skip
    # offsets [m] and speeds [m/s] of the record
    values, covariance = posterior.values, posterior.covariance
    before, after = (np.sqrt(np.maximum(np.diag(each), 0.0)) for each in (np.asarray(prior.covariance), covariance))
    learned, verdicts = dict[str, LearnedCoefficient](), dict[str, str]()
    for term, known, value, std in zip(
        prior.terms.terms, *map(np.ndarray.tolist, (before, values, after)), strict=True
    ):
        own = LearnedCoefficient(
            term.name, term.dimension.unit, prior.coefficients[term.name], known, value, std, term.from_bank
        )
        learned[term.name] = own
        if own.status == LEARNED:
            doubt = "contradicted" if contradicted else UNRESOLVED if UNRESOLVED in own.verdict else ""
            verdicts[term.name] = f"{doubt} by the ship's own record" if doubt else IDENTIFIED
    sources = zip(astuple(prior.source), astuple(source), strict=True)
    model = replace(
        prior,
        coefficients=Named({name: c.value for name, c in learned.items()}),
        covariance=(covariance + covariance.T) / 2,
        data_range=covered_range(prior, *((float(part.min()), float(part.max())) for part in (offsets, speeds))),
        source=Source(*("; ".join(filter(None, pair)) for pair in sources)),
        verdicts={**prior.verdicts, **verdicts},
    )
    return model, learned


def covered_range(prior: Model, offsets: Range, speeds: Range) -> DataRange:
    # offsets [m]; speeds [m/s]
    # In a section without tests only the record gives the covered offsets and speeds; at lower speeds the bank's force
    # is smaller. Without a bank only speeds count.
    known, configuration, (low, high) = prior.data_range, prior.configuration, prior.data_range.speed or speeds
    section = {"width_to_beam": configuration.canal.width / configuration.ship.beam}
    if configuration.canal.depth is not None:
        section["depth_to_draft"] = configuration.canal.depth / configuration.ship.draft
    speed = min(speeds[0], low), max(speeds[1], high)
    if not prior.has_bank:
        return replace(known, speed=speed)
    if any(getattr(known, name) is None or known.outside(name, ratio) for name, ratio in section.items()):
        here = {name: (ratio, ratio) for name, ratio in section.items()}
        return replace(known, speed=(speed[0], speeds[1]), abs_y=(0.0, offsets[1]), **here)
    nearest, farthest = known.abs_y or offsets
    return replace(known, speed=speed, abs_y=(min(offsets[0], nearest), max(offsets[1], farthest)))


LEAST_REDUCTION = 1e-3  # Least reduction of the prior variance [1] by which a log determines a combination
EXPECTED_SCATTER = 10  # Weight of the expected scatter of scores [records]

# Standard deviations of coefficients: relative to their size [1], or by name in the coefficient's unit.
Spread = float | Mapping[str, float]
# Standard deviation of an asymmetry, as the rudder angle that balances it [rad]: ships need about a degree.
RUDDER_ZERO = np.radians(1.0)
# Standard deviations of the rudder's asymmetries over its own coefficient [1]. The flow straightening of the KVLCC2 is
# 0.52, with 0.12 more to one side; the even force is 3 % of the rudder's at 35 degrees.
RUDDER_ASYMMETRIES = ((STRAIGHTENING, 0.2), (RUDDER_EVEN, 0.05))
# Least eigenvalue of a correlation matrix over its largest [1]: a floor for coefficients that are fully correlated.
RANK = 1e-9


def check_covariance(model: Model) -> None:
    if model.covariance is None:
        raise InputError(
            "this model has no covariance of its coefficients, so a record has no prior; identify it from tests, or "
            "for a log state a spread, as spread=0.1 (--spread 0.1) for a tenth of each"
        )


def with_spread(model: Model, spread: Spread | None) -> Model:
    # Inertia is held where a spread is stated: motion determines only forces over inertia.
    if spread is None:
        check_covariance(model)
        return model
    names = model.terms.names
    if isinstance(spread, Mapping):
        for name in spread:
            model[str(name)]  # Raises where there is none
        sizes = np.array([float(spread.get(name, 0.0)) for name in names])
    else:
        held = {term.name for term in model.terms.terms if term.kind == TermKind.INERTIA}
        sizes = np.array([spread * abs(model.coefficients[name]) * (name not in held) for name in names])
    if not (np.isfinite(sizes).all() and (sizes >= 0).all() and sizes.any()):
        raise InputError(f"a spread of {spread} is none: give a share over 0, or standard deviations by coefficient")
    return replace(model, covariance=np.diag(sizes**2))


def with_asymmetry(model: Model, u: float) -> Model:
    """Return a model with an asymmetry; where it has no variance, that of a rudder turned by ``RUDDER_ZERO``."""
    # u [m/s]. A rudder in a slipstream has asymmetries of its own: a constant one suits one amplitude of zigzags alone.
    names = ASYMMETRY.names(model.terms)
    if names[0] not in model.terms.names:
        table = asymmetric(model.terms)
        model = extend(model, table, dict.fromkeys(set(table.names) - set(model.terms.names), 0.0))
    whole = np.array(model.covariance)
    still, turned = model.forces(u=u), model.forces(u=u, rudder=RUDDER_ZERO)
    more = model.with_coefficients(**{name: model[name] + 1.0 for name in names}).forces(u=u)
    sizes = {name: (turned[f] - still[f]) / (more[f] - still[f]) for f, name in zip(("Y", "N"), names, strict=True)}
    for row, force in enumerate(("Y", "N")):
        own = [term.name for term in model.terms.forces[force] if STRAIGHTENED in term.inputs]
        for terms, share in RUDDER_ASYMMETRIES if len(own) > 1 else ():
            sizes[terms.names(model.terms)[row]] = share * model[own[0]]
    for name, size in sizes.items():
        place = model.terms.names.index(name)
        whole[place, place] = whole[place, place] or float(size) ** 2
    return replace(model, covariance=whole)


def record_prior(
    model: Model, u: float, surge: str, spread: Spread | None, asymmetric: bool, free: tuple[str, ...]
) -> CoefficientPrior:
    model = with_spread(model, spread)
    if asymmetric and any(own.name == "rudder" for own in model.terms.actuators):
        model = with_asymmetry(model, u)
    return coefficient_prior(model, surge, free and learnable(model, free))


def coefficient_prior(model: Model, surge: str, free: Collection[str] = ()) -> CoefficientPrior:
    """Return the prior of the coefficients that affect a motion; those of ``free``, or all, may change."""
    covariance = np.asarray(model.covariance)
    acting = [force for force in FORCES if force != "X" or surge == "free"]
    uncertain = {name for name, variance in zip(model.terms.names, np.diag(covariance), strict=True) if variance > 0}
    parameters, tied = free_parameters(model.terms), dict[int, list[str]]()
    for name in (term.name for force in acting for term in model.terms.forces[force] if term.name in uncertain):
        tied.setdefault(parameters[name], []).append(name)
    groups = tuple(map(tuple, tied.values()))
    places = [model.terms.names.index(group[0]) for group in groups]
    part = covariance[np.ix_(places, places)]
    scale = np.sqrt(np.diag(part))
    ends = [np.array([model.terms[name].bound for name in group]).T for group in groups]
    bounds = np.array([(low.max(), high.min()) for low, high in ends]).reshape(len(groups), 2)
    mean = np.array([model.coefficients[group[0]] for group in groups])
    changes = np.array([not free or not set(free).isdisjoint(group) for group in groups])
    sizes, axes = np.linalg.eigh(part / np.outer(scale, scale))
    precision = (axes / np.maximum(sizes, RANK * max(sizes[-1], 1.0))) @ axes.T
    return CoefficientPrior(model, groups, mean, scale, precision, bounds, changes)


def push_inertia(prior: CoefficientPrior, u: float, surge_inertia: float | None = None) -> np.ndarray:
    """Return the inertia in surge, sway and yaw: a constant, and slopes by the groups of coefficients, (3, 1 + p)."""
    # u [m/s]; surge_inertia [kg]
    model = prior.model
    names = {name: place for place, group in enumerate(prior.groups) for name in group}
    still = {**SimulatedShip(model).values(), **Motion.at(u=u).values()}
    inertia = np.zeros((3, 1 + len(prior.groups)))
    for axis, (terms, acceleration) in enumerate(zip(model.terms.forces.values(), ACCELERATIONS.values(), strict=True)):
        pushed = {**still, acceleration: 1.0}
        for term in terms:
            place = 1 + names.get(term.name, -1)
            resists = float(term.column(still) - term.column(pushed))
            inertia[axis, place] += resists * (1.0 if place else model.coefficients[term.name])
    inertia[0, 0] = surge_inertia or inertia[0, 0] or 1.0
    return inertia


@dataclass(frozen=True)
class LogPosterior:
    values: np.ndarray  # (n,) All coefficients, in the order of the table
    covariance: np.ndarray  # (n, n)
    disagreement: float  # Sum of squared changes by the log, over their expected variances [1]
    freedom: int  # Number of combinations of coefficients that the log determines

    @property
    def probability(self) -> float:
        """Probability of at least this disagreement if log and prior are of one ship."""
        return float(special.chdtrc(max(self.freedom, 1), self.disagreement))


def log_posterior(
    problem: Unknowns, unknowns: np.ndarray, information: np.ndarray, scores: np.ndarray | None = None
) -> LogPosterior:
    """Return the posterior of all coefficients by the information (P, P), and scores of records (N, P)."""
    prior, count, model = problem.prior, problem.count, problem.prior.model
    covariance = problem.covariance(information)
    if scores is not None and len(scores) > 1:
        covariance = sandwich(covariance, information, scores)
    before = np.asarray(model.covariance)
    weights = prior.regression
    places = [model.terms.names.index(name) for name in prior.names]
    learned = covariance[:count, :count] * np.outer(prior.scale, prior.scale)
    after = before + weights @ (learned - before[np.ix_(places, places)]) @ weights.T
    moved = weights @ (prior.scale * unknowns[:count])
    if not prior.free.all():
        # Schmidt's (1966) Kalman update: held coefficients keep mean and covariance, and their errors count in those of
        # the free ones, which are as in the joint fit; Bierman (1977), Factorization Methods, chapter 8.
        free = {name for group, free in zip(prior.groups, prior.free, strict=True) if free for name in group}
        held = np.flatnonzero([name not in free for name in model.terms.names])
        moved[held] = 0.0
        after[np.ix_(held, held)] = before[np.ix_(held, held)]
    values = moved + [model.coefficients[name] for name in model.terms.names]
    disagreement = _disagreement(problem, information, unknowns[:count])
    return LogPosterior(values, (after + after.T) / 2, *disagreement)


def averaged(one: LogPosterior, other: LogPosterior) -> LogPosterior:
    """Return the posterior of two models that are equally likely: their difference is part of the covariance."""
    # Hoeting, Madigan, Raftery and Volinsky (1999), Bayesian model averaging: a tutorial, Statistical Science 14.
    # Log and prior contradict each other only if they do in both.
    apart = (one.values - other.values) / 2
    covariance = (one.covariance + other.covariance) / 2 + np.outer(apart, apart)
    agreeing = max(one, other, key=lambda each: each.probability)
    return replace(agreeing, values=one.values - apart, covariance=covariance)


def expected_std(problem: Unknowns, information: np.ndarray) -> dict[str, float]:
    after = log_posterior(problem, np.zeros(len(information)), information)
    return dict(zip(problem.prior.model.terms.names, np.sqrt(np.diag(after.covariance)).tolist(), strict=True))


def sandwich(covariance: np.ndarray, information: np.ndarray, scores: np.ndarray) -> np.ndarray:
    """Return the covariance (P, P), widened where the scores of records scatter more than the information implies."""
    # White (1982), Econometrica 50, for the sandwich; Kauermann and Carroll (2001), J. Am. Stat. Assoc. 96, on its
    # small samples: below some ten records the expected scatter has the larger weight.
    count = len(scores)
    centred = scores - scores.mean(axis=0)
    scatter = centred.T @ centred * count / (count - 1)
    root = np.linalg.cholesky(covariance + 1e-12 * np.eye(len(covariance)))
    excess = root.T @ (scatter - information) @ root
    sizes, axes = np.linalg.eigh(count / (count + EXPECTED_SCATTER) * (excess + excess.T) / 2)
    wider = (axes * np.maximum(sizes, 0.0)) @ axes.T
    return np.asarray(covariance + root @ wider @ root.T)


def _disagreement(problem: Unknowns, whole: np.ndarray, moved: np.ndarray) -> tuple[float, int]:
    """Return the sum of squared changes of combinations over their expected variances, and their number."""
    count = problem.count
    nuisance = np.linalg.solve((whole + problem.precision)[count:, count:], whole[count:, :count])
    information = whole[:count, :count] - whole[:count, count:] @ nuisance
    precision = problem.prior.precision
    sizes, axes = np.linalg.eigh(np.linalg.inv(precision) - np.linalg.inv(information + precision))
    counted = sizes > LEAST_REDUCTION
    return float(np.sum((axes.T @ moved)[counted] ** 2 / sizes[counted])), int(counted.sum())
