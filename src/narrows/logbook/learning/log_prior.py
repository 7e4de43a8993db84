"""What a model says before a log is looked at: its coefficients' covariance, or a spread that is stated."""

from collections.abc import Mapping, Sequence

import numpy as np

from narrows.errors import InputError, did_you_mean
from narrows.logbook.shooting.log_problem import CoefficientPrior, PushInertia
from narrows.model.model import Model
from narrows.quantities.names import FORCES
from narrows.ship.motion import Motion
from narrows.simulation.ship import SimulatedShip
from narrows.terms.term import TermKind

# Standard deviations of coefficients: over their size, or each in its own unit.
Spread = float | Mapping[str, float]
ACCELERATIONS = ("udot", "vdot", "rdot")
# Of the largest eigenvalue of a correlation, under which two coefficients are known as one.
RANK = 1e-9
NO_PRIOR = (
    "this model has no covariance of its coefficients, so nothing says what a log may change; identify it from tests, "
    "or state a spread, as spread=0.1 (--spread 0.1) for a tenth of each"
)


def covariance_before(model: Model, spread: Spread | None) -> np.ndarray:
    """Return the covariance of all coefficients before a log."""
    # Inertia is held where a spread is stated: motion tells of forces over inertia alone.
    if spread is None:
        if model.covariance is None:
            raise InputError(NO_PRIOR)
        return np.asarray(model.covariance, float)
    return np.diag(_stated(model, spread) ** 2)


def _stated(model: Model, spread: Spread) -> np.ndarray:
    names = model.terms.names
    if isinstance(spread, Mapping):
        for name in spread:
            if name not in names:
                raise InputError(f"spread: there is no coefficient {name!r}{did_you_mean(name, names)}")
    held = {term.name for term in model.terms.terms if term.kind == TermKind.INERTIA}
    if isinstance(spread, Mapping):
        sizes = np.array([float(spread.get(name, 0.0)) for name in names])
    else:
        sizes = np.array([spread * abs(model.coefficients[name]) * (name not in held) for name in names])
    if not (np.isfinite(sizes).all() and (sizes >= 0).all() and sizes.any()):
        raise InputError(f"a spread of {spread} is none: give a share over 0, or standard deviations by coefficient")
    return sizes


def coefficient_prior(
    model: Model, covariance: np.ndarray, surge: str, free: frozenset[str] | None = None
) -> CoefficientPrior:
    """Return what is known of the coefficients that a motion can move."""
    # covariance (n, n)
    felt = [force for force in FORCES if force != "X" or surge == "free"]
    names = [term.name for force in felt for term in model.terms.forces[force]]
    known = {name: covariance[i, i] > 0 for i, name in enumerate(model.terms.names)}
    groups = _groups(model, [name for name in names if known[name]])
    places = [model.terms.names.index(group[0]) for group in groups]
    part = covariance[np.ix_(places, places)]
    scale = np.sqrt(np.diag(part))
    bounds = np.array([_bounds(model, group) for group in groups]).reshape(len(groups), 2)
    mean = np.array([model.coefficients[group[0]] for group in groups])
    moves = np.array([free is None or not free.isdisjoint(group) for group in groups])
    return CoefficientPrior(groups, mean, scale, _precision(part / np.outer(scale, scale)), bounds, moves)


def _precision(correlation: np.ndarray) -> np.ndarray:
    """Inverse of a correlation; what is known as one stays so nearly."""
    sizes, axes = np.linalg.eigh(correlation)
    return np.asarray((axes / np.maximum(sizes, RANK * max(sizes[-1], 1.0))) @ axes.T)


def _groups(model: Model, names: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """Coefficients that are one, together."""
    leader = {name: name for name in names}
    for first, second in model.terms.ties:
        if first in leader and second in leader:
            old, new = leader[second], leader[first]
            leader = {name: new if head == old else head for name, head in leader.items()}
    return tuple(tuple(name for name in names if leader[name] == head) for head in dict.fromkeys(leader.values()))


def _bounds(model: Model, group: Sequence[str]) -> tuple[float, float]:
    ends = [model.terms[name].bound for name in group]
    return max(low for low, _ in ends), min(high for _, high in ends)


def push_inertia(model: Model, prior: CoefficientPrior, u: float, surge_inertia: float | None = None) -> PushInertia:
    """Return what resists accelerations, by the terms."""
    # u [m/s]; surge_inertia [kg]
    names = {name: place for place, group in enumerate(prior.groups) for name in group}
    still = {**SimulatedShip(model).values(), **Motion.at(u=u).values()}
    held, moving = np.zeros(3), np.zeros((3, len(prior.groups)))
    for axis, (terms, acceleration) in enumerate(zip(model.terms.forces.values(), ACCELERATIONS, strict=True)):
        pushed = {**still, acceleration: 1.0}
        for term in terms:
            resists = float(term.column(still) - term.column(pushed))
            if term.name in names:
                moving[axis, names[term.name]] += resists
            else:
                held[axis] += resists * model.coefficients[term.name]
    held[0] = surge_inertia or held[0] or 1.0
    return PushInertia(held, moving)
