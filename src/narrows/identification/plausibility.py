"""Check a fit: masses and inertias, signs of forces and rudder, a rudder left out."""

import math
from typing import Any

import numpy as np

from narrows.captive.tests import CaptiveTests, Tests
from narrows.identification.normal_equations import ONE, NormalEquations, score
from narrows.model.froude import ittc57
from narrows.model.water import added_sway, added_yaw, ship_inertia, ship_mass, wetted_surface
from narrows.terms.term import TermKind, TermTable

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
# Resistance over the friction of the ITTC's line: every hull has more than 1, and knots read as m/s divide it by 3.8;
# viscosity of fresh water at 20 degrees [m2/s]; least Reynolds number of the line.
LEAST_DRAG, VISCOSITY, LEAST_REYNOLDS = 0.9, 1.0e-6, 1e5
EXCHANGED = (
    "Neither the mass in sway nor the inertia in yaw is this ship's, and Y grows with the yaw acceleration as a moment "
    "does: are the columns Y and N exchanged?"
)
Known = dict[str, tuple[float, float]]  # Estimate without bounds and standard error, where the tests determine it
# Force, acceleration and name of a mass or inertia; its unit, its bare value and its added value in deep water.
MASSES = (
    ("Y", "vdot", "mass in sway", "kg", ship_mass, added_sway),
    ("N", "rdot", "inertia in yaw", "kg m2", ship_inertia, added_yaw),
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
    line = ittc57(max(speed * ship.length / VISCOSITY, LEAST_REYNOLDS))
    friction = 0.5 * density * wetted_surface(ship) * speed**2 * line
    drag = -float(np.mean(np.sign(u[fast]) * tests.columns["X"][fast]))
    if "revolutions" in tests.columns or not 0 < drag < LEAST_DRAG * friction:
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
    fit: Any, known: Known, force: str, rate: str, words: str, unit: str, bare_of: Any, added_of: Any
) -> str:
    """Warn that a mass or inertia is implausible for the ship with its added mass, and why."""
    names = [term.name for term in fit.terms.forces[force] if term.inputs == (rate,)]
    if len(names) != 1 or names[0] not in known:
        return ""
    (name,), equations, configuration = names, fit.normal_equations, fit.tests.configuration
    bare, added = bare_of(configuration), added_of(configuration)
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


def unmodelled_rudder(tests: Tests, equations: NormalEquations, terms: TermTable) -> str:
    """Return a warning, with remedy, of a moving rudder without a rudder term; empty if there is none."""
    if any(actuator.name == "rudder" for actuator in terms.actuators):
        return ""
    if isinstance(tests, CaptiveTests):
        angle = float(np.abs(tests.columns.get("rudder", np.zeros(1))).max())
    else:  # By the sums, as of a sine about its mean
        rows, total, squares = equations.moved.get("rudder", np.eye(1, 3)).T
        mean = total / rows
        angle = float((np.abs(mean) + np.sqrt(2 * np.maximum(squares / rows - mean**2, 0.0))).max())
    if angle < math.radians(1):
        return ""
    return (
        f"the rudder goes to {math.degrees(angle):.0f} deg and no term has it, so other terms absorb its force: "
        f"take the terms {terms.name}+helm, or rows with it amidships (--where 'abs(rudder_deg) < 1')"
    )
