"""Check a fit: masses and inertias, signs of forces and rudder, a rudder left out, noise in the accelerations."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from narrows.captive.accelerations import RATES
from narrows.captive.tests import CaptiveTests, Tests
from narrows.identification.design_matrix import ONE
from narrows.identification.least_squares import Problem, Solution
from narrows.identification.normal_equations import NormalEquations, score
from narrows.model.froude import ittc57
from narrows.model.masses import added_sway, added_yaw, ship_inertia, ship_mass, wetted_surface
from narrows.terms.term import TermKind, TermTable

# Least share of the added mass in deep water that a hull has; most times mass and added mass in deep water, which
# shallow water and near banks multiply.
LEAST_ADDED, MOST = 0.5, 10.0
# Standard errors by which a mass must exceed its plausible range; least force of such a mass over the residual of the
# fit for a warning.
SURE, LEAST_FORCE = 2.0, 0.1
# Error of a fit to the force with the other sign, over that of the fit, below which the sign is reported.
CLEARLY = 0.7
# Standard errors over the runs by which X must push ahead.
SURE_PUSH = 3.0
# Sign conventions of a force whose other sign fits better.
AXES = {"X": "X counted astern", "Y": "Y counted to port", "N": "N counted anticlockwise"}
# Units of forces other than N and N m, and their factors.
UNITS = {"kgf or kgf m": 9.80665, "kN or kN m": 1e3}
# Resistance over the friction of the ITTC's line: every hull has more than 1, and knots read as m/s divide it by 3.8;
# viscosity of fresh water at 20 degrees [m2/s]; least Reynolds number of the line.
LEAST_DRAG, VISCOSITY, LEAST_REYNOLDS = 0.9, 1.0e-6, 1e5
RUDDER_MOVES = math.radians(1.0)
# Share of the size of the accelerations that is taken for noise.
NOISE_SHARE = 0.1


@dataclass(frozen=True)
class Judged:
    """Inputs of the plausibility checks."""

    tests: Tests  # Tests of the fit
    equations: NormalEquations  # Sums over the rows
    problem: Problem  # Solved problem
    coefficients: Mapping[str, float]  # The optimum
    unbounded: Mapping[str, float]  # Estimates without bounds
    std: Mapping[str, float]  # Standard error of each coefficient that the tests determine
    rejected: tuple[str, ...]  # Coefficients that the data put beyond their bounds for certain


def implausible(evidence: Judged) -> tuple[str, ...]:
    """Return the implausible results of a fit, each a sentence with its likely cause."""
    reversed_forces = [force for force in AXES if fits_reversed(evidence, force)]
    signs = [f"{force} of the other sign fits far better: is {AXES[force]}?" for force in reversed_forces]
    signs += [] if "X" in reversed_forces else [push_sentence(evidence), drag_sentence(evidence)]
    signs += [] if reversed_forces else [bank_sentence(evidence)]
    masses = [mass_sentence(evidence, mass) for mass in MASSES if mass.force not in reversed_forces]
    return tuple(sentence for sentence in (*signs, *masses, rudder_sentence(evidence)) if sentence)


def fits_reversed(evidence: Judged, force: str) -> bool:
    """Return whether a force of the other sign would be fitted far better."""
    equations, problem = evidence.equations, evidence.problem
    if not problem.terms.forces[force]:
        return False
    total = equations.total
    turned = total.copy()
    turned[equations.columns[force], :] *= -1
    turned[:, equations.columns[force]] *= -1
    again = problem.named(problem.solve(turned).z)
    now = score(equations, total, problem.terms, evidence.coefficients)[force].rmse
    return score(equations, turned, problem.terms, again)[force].rmse < CLEARLY * now


def push_sentence(evidence: Judged) -> str:
    """Warn that X pushes the ship ahead, run by run; empty where it resists, or a propeller is modelled."""
    terms = evidence.problem.terms
    tests, propelled = evidence.tests, any(actuator.name == "revolutions" for actuator in terms.actuators)
    if not terms.forces["X"] or propelled or not isinstance(tests, CaptiveTests):
        return ""
    means = np.array([np.mean(np.sign(run["u"]) * run["X"]) for run in tests])
    if len(means) < 2 or means.mean() <= SURE_PUSH * means.std(ddof=1) / math.sqrt(len(means)):
        return ""
    return (
        f"X pushes the ship the way it goes, by {means.mean():.2g} N in the mean of {len(means)} runs: is X counted "
        "astern, or does a propeller push?"
    )


def drag_sentence(evidence: Judged) -> str:
    """Warn that X resists less than the friction of the hull; empty where it does not, or a propeller turns."""
    tests, ship = evidence.tests, evidence.tests.configuration.ship
    if not evidence.problem.terms.forces["X"] or not isinstance(tests, CaptiveTests) or "revolutions" in tests.columns:
        return ""
    u, density = tests.columns["u"], tests.configuration.water.density
    fast = np.abs(u) > np.abs(u).max() / 2
    speed = float(np.sqrt(np.mean(u[fast] ** 2)))
    friction = (
        0.5 * density * wetted_surface(ship) * speed**2 * ittc57(max(speed * ship.length / VISCOSITY, LEAST_REYNOLDS))
    )
    drag = -float(np.mean(np.sign(u[fast]) * tests.columns["X"][fast]))
    if not 0 < drag < LEAST_DRAG * friction:
        return ""
    return (
        f"X resists with {drag:.2g} N in the mean, {drag / friction:.2g} of the friction of this hull at "
        f"{speed:.2g} m/s: is u in knots ('u [kn]'), X in another unit, or does a propeller push?"
    )


def bank_sentence(evidence: Judged) -> str:
    """Warn that both force and moment of the bank have the wrong sign; empty where they have not."""
    names = [term.name for term in evidence.problem.terms.terms if term.from_bank]
    if len(names) != 2 or not evidence.std.keys() >= set(names):
        return ""
    if any(evidence.unbounded[name] > -SURE * evidence.std[name] for name in names):
        return ""
    return (
        "The nearer bank pushes the ship off and draws in its bow, the opposite of every published bank: are port and "
        "starboard exchanged in y, or does y count from a bank?"
    )


class Mass(NamedTuple):
    """A mass or inertia, with its bare and added part."""

    force: str  # That accelerates
    rate: str  # The acceleration
    words: str  # Name
    unit: str  # Its unit
    bare: Callable[..., float]  # Bare value of a configuration
    added: Callable[..., float]  # Added value of a configuration in deep water


MASSES = (
    Mass("Y", "vdot", "mass in sway", "kg", ship_mass, added_sway),
    Mass("N", "rdot", "inertia in yaw", "kg m2", ship_inertia, added_yaw),
)


def mass_sentence(evidence: Judged, mass: Mass) -> str:
    """Warn that a mass or inertia is implausible for the ship with its added mass, and why."""
    names = [term.name for term in evidence.problem.terms.forces[mass.force] if term.inputs == (mass.rate,)]
    if len(names) != 1 or names[0] not in evidence.std:
        return ""
    (name,), configuration = names, evidence.tests.configuration
    bare, added = mass.bare(configuration), mass.added(configuration)
    least, most = bare + LEAST_ADDED * added, MOST * (bare + added)
    low, high = (evidence.unbounded[name] + side * SURE * evidence.std[name] for side in (-1, 1))
    if (least <= high and low <= most) or not _matters(evidence, name, mass.force, least):
        return ""
    side = "under" if high < least else "over"
    return (
        f"{name} = {evidence.unbounded[name]:.3g} {mass.unit} cannot be this ship's {mass.words}, which with its added "
        f"mass is about {bare + added:.3g} {mass.unit} in deep water and more in shallow: "
        f"{_cause(evidence.unbounded[name], bare + added, mass.force, side)}"
    )


def _matters(evidence: Judged, name: str, force: str, mass: float) -> bool:
    """Return whether such a mass would change the forces by more than the residuals."""
    equations = evidence.equations
    total, column, one = equations.total, equations.columns[name], equations.columns[ONE]
    size = math.sqrt(total[column, column] / total[one, one])
    left = score(equations, total, evidence.problem.terms, evidence.coefficients)[force].rmse
    return mass * size > LEAST_FORCE * left


def _cause(value: float, expected: float, force: str, side: str) -> str:
    if value <= 0:
        return f"is the sign of {force}, or of the accelerations, reversed?"
    if side == "over":
        return f"is the unit of {force} smaller than that of its header, or the ship file of a smaller model?"
    for unit, size in UNITS.items():
        if abs(math.log(expected / value / size)) < math.log(2):
            return f"is {force} in {unit}?"
    return f"has the ship's own inertia been taken off {force} already, or is the ship file of a larger model?"


def rudder_sentence(evidence: Judged) -> str:
    """Warn that a rudder's force has the wrong sign; empty where it has not."""
    helm = [term.name for term in evidence.problem.terms.terms if term.kind == TermKind.RUDDER]
    wrong = [name for name in helm if name in evidence.rejected]
    if not wrong:
        return ""
    return (
        f"The data put {' and '.join(wrong)} below 0: is the rudder's sign reversed (positive where it turns the bow "
        "to starboard)?"
    )


def unmodelled_rudder(tests: Tests, equations: NormalEquations, terms: TermTable) -> str:
    """Return a warning, with remedy, of a moving rudder without a rudder term; empty if there is none."""
    if any(actuator.name == "rudder" for actuator in terms.actuators):
        return ""
    angle = _rudder_angle(tests, equations)
    if angle < RUDDER_MOVES:
        return ""
    return (
        f"the rudder goes to {math.degrees(angle):.0f} deg and no term has it, so other terms absorb its force: "
        f"take the terms {terms.name}+helm, or rows with it amidships (--where 'abs(rudder_deg) < 1')"
    )


def _rudder_angle(tests: Tests, equations: NormalEquations) -> float:
    """Return the amplitude of the rudder [rad], by the sums as of a sine about its mean."""
    if isinstance(tests, CaptiveTests):
        return float(np.abs(tests.columns.get("rudder", np.zeros(1))).max())
    if "rudder" not in equations.moved:
        return 0.0
    rows, total, squares = equations.moved["rudder"].T
    mean = total / rows
    return float((np.abs(mean) + np.sqrt(2 * np.maximum(squares / rows - mean**2, 0.0))).max())


def noise_bias(
    problem: Problem, solution: Solution, equations: NormalEquations, share: float = NOISE_SHARE
) -> dict[str, float]:
    """Return how far white noise in the accelerations draws each coefficient from its value, to first order."""
    # The noise adds to the diagonal of H alone, and the solution moves by -H^-1 D z: attenuation, and what others take
    # over. Coefficients at a bound stay there.
    # Fuller (1987), Measurement Error Models, section 2.2.
    h, _ = problem.normal(equations.total)
    plain, _ = problem.normal(equations.unweighted.sum(axis=0))
    noisy = np.zeros(len(h))
    for term in problem.terms.terms:
        if term.inputs in [(rate,) for rate in RATES.values()]:
            noisy[problem.slot[term.name]] = share**2
    free = ~solution.at_bound
    moved = np.zeros(len(h))
    pull = noisy * np.diag(plain) * solution.z
    moved[free] = -np.linalg.pinv(h[np.ix_(free, free)], rcond=1e-12, hermitian=True) @ pull[free]
    return problem.named(moved)


def noise_sentence(tests: Tests, bias: dict[str, float], values: dict[str, float]) -> str:
    """Return the effect of noise in accelerations that no check covers; empty where time checks them."""
    if isinstance(tests, CaptiveTests) and "t" in tests.columns:
        return ""
    shifts = {
        name: bias[name] / values[name] for name in bias if values[name] and abs(bias[name] / values[name]) > 1e-3
    }
    if not shifts:
        return ""
    changes = ", ".join(
        f"{name} by {shift:+.1%}" for name, shift in sorted(shifts.items(), key=lambda pair: -abs(pair[1]))[:4]
    )
    return f"Without times in memory the noise in the accelerations is unknown; a tenth would change {changes}."
