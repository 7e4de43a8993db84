"""Learn from steady legs: a ship is held to one side, then to the other, and the steady rudder and drift read.

The balance of sway and yaw is linear in the coefficients. The legs' true offsets, speeds and angles are unknown too:
with a leg's readings ``m = l + zeros + e`` and the balance ``f(l, coefficients) + wind + rest = 0``, it is linear about
the best l so far, and its error is that of the readings through its slopes (Gauss-Helmert least squares). Each leg then
has a score and an information matrix, as a record of a log has, and the search and the posterior are those of logs.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from narrows.aliases import accept_aliases
from narrows.codegen.linearisation import LINEARISED
from narrows.control.steady_course import check_inside, check_rudder
from narrows.errors import InputError
from narrows.logbook.filtering.log_problem import CoefficientPrior, Unknowns
from narrows.logbook.filtering.search import bounded_step
from narrows.logbook.learned_coefficient import LEARNED, ON_TWINS, LearnedAnswer, LearnedCoefficient, learned_model
from narrows.logbook.learning.log_posterior import check_covariance, coefficient_prior, log_posterior
from narrows.logbook.settings import CONTRADICTION, UPDATE_ROUNDS, UPDATE_SETTLED, WRONG_SIGN_GAIN
from narrows.logbook.steady_legs.steady_readings import (
    SHARED,
    UNKNOWN,
    ReadingErrors,
    SteadyConditions,
    SteadyReadings,
    left_over,
    shared_errors,
    steady_readings,
)
from narrows.model.data_range import extrapolation
from narrows.model.model import Model
from narrows.safety.request import keel_at
from narrows.ship.motion import Motion
from narrows.simulation.self_propulsion import self_propulsion
from narrows.simulation.ship import SimulatedShip


@dataclass(frozen=True)
class SteadyChecks:
    chi_square: float  # Sum of squares of what was read over what was to be expected of it [1]
    freedom: int  # Degrees of freedom
    probability: float  # Probability of one as large, were model, prior and errors right [1]
    leg_probabilities: dict[str, float]  # The same of each leg, beside all others [1]
    findings: tuple[str, ...]  # Faults and undetermined quantities, a sentence each

    @property
    def contradicted(self) -> bool:
        return self.probability < CONTRADICTION


@dataclass(frozen=True, repr=False)
class SteadyFit(LearnedAnswer):
    """Result of learning from steady legs.

    Parameters
    ----------
    model, prior : Model
        The model after the legs, and before.
    readings, conditions : SteadyReadings, SteadyConditions
        The legs, and assumptions on wind, zeros and remaining motion.
    coefficients : mapping of str to LearnedCoefficient
        Each before and after.
    shared : mapping of str to (float, float)
        Common errors of all legs, in SI: ``wind_Y``, ``wind_N``, and the zeros ``rudder_zero``, ``drift_zero``,
        ``heading_zero``, ``y_zero``; most likely value and standard error.
    latent : array (legs, 4)
        Most likely state of the ship: y [m], u [m/s], rudder, psi [rad].
    checks : SteadyChecks
        Agreement of legs and model.
    """

    model: Model
    prior: Model
    readings: SteadyReadings
    conditions: SteadyConditions
    coefficients: Mapping[str, LearnedCoefficient]
    shared: Mapping[str, tuple[float, float]]
    latent: np.ndarray
    checks: SteadyChecks

    @property
    def informative(self) -> bool:
        """True where a coefficient of the bank was learned, and nothing contradicts it."""
        learned = any(c.word == LEARNED for c in self.coefficients.values() if c.from_bank)
        return learned and not self.checks.contradicted

    @property
    def notes(self) -> tuple[str, ...]:
        """Contradictions, undetermined quantities, assumptions."""
        taken = f"Assumed: {self.conditions.summary()}."
        notes = [*self.checks.findings, taken, *self.prior.configuration.notes]
        if not self.checks.contradicted:
            notes.append(
                "Legs that agree do not show that they are of this ship: on twins those of one a quarter shorter or "
                "longer agree, and a rudder of the wrong sign may; see to ship, draft and signs."
            )
        return (*notes, ON_TWINS)

    def summary(self) -> str:
        """What was learned, what still comes from the tests, and whether the legs agree."""
        agree = (
            f"The legs {'contradict' if self.checks.contradicted else 'agree with'} the model: a sum of squares of "
            f"{self.checks.chi_square:.1f}, {self.checks.freedom} expected."
        )
        return "\n".join((self._taught(self.readings.summary()), agree, ON_TWINS))

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name: part of what ``learn --steady --json`` prints."""
        prior = shared_errors(self.conditions, self.prior)
        return {
            "summary": self.summary(),
            "informative": self.informative,
            "coefficients": [coefficient.to_dict() for coefficient in self.coefficients.values()],
            "shared": [
                {"name": name, "unit": unit, "value": factor * self.shared[name][0],
                 "std": factor * self.shared[name][1], "prior_std": factor * before}
                for (name, (_, unit, factor)), before in zip(SHARED.items(), prior.tolist(), strict=True)
            ],
            **{name: getattr(self.checks, name) for name in ("chi_square", "freedom", "probability", "contradicted")},
            "legs": self.leg_rows(),
            "source": {"table": self.readings.source, "sha256": self.readings.sha256},
            "notes": list(self.notes),
        }  # fmt: skip

    def leg_rows(self) -> list[dict[str, Any]]:
        """Give a row a leg: what was read, where the ship most likely was, and how well the leg fits the others."""
        read, (y, _, rudder, heading) = self.readings.values, self.latent.T
        columns = {
            "leg": self.readings.legs, "y": read["y"], "u": read["u"], "rudder_deg": np.degrees(read["rudder"]),
            "direction_deg": np.degrees(read[self.readings.directions[0]]), "likely_y": y,
            "likely_rudder_deg": np.degrees(rudder), "likely_heading_deg": np.degrees(heading),
            "probability": list(self.checks.leg_probabilities.values()),
        }  # fmt: skip
        rows = zip(*(np.asarray(column).tolist() for column in columns.values()), strict=True)
        return [dict(zip(columns, row, strict=True)) for row in rows]


@accept_aliases
def learn_steady(
    model: Model, observations: Any, *, errors: ReadingErrors | None = None, conditions: SteadyConditions | None = None
) -> SteadyFit:  # fmt: skip
    """Learn from a ship that was held off the middle: the steady rudder and drift, to both sides.

    The covariance of the model's coefficients is the prior, all of it, and the balance of sway and yaw on each leg
    updates it: exactly, for it is linear in the coefficients, and anew until nothing moves where errors of offset,
    speed and angles make it otherwise. No pilot enters. Wind and the zeros of the instruments are unknown and the same
    on all legs; the slope over both sides cancels them.

    Parameters
    ----------
    model : Model
        Model of the ship at its own size in the canal of the legs, with a rudder and a covariance.
    observations : DataFrame, mapping of str to array, str or Path
        A row a leg: y [m], u [m/s], rudder, drift or heading, and their errors ``y_error`` and so on where they are
        known; SI and radians unless a header has a unit (``rudder [deg]``).
    errors, conditions : ReadingErrors, SteadyConditions, optional
        Errors that the rows lack; sizes of wind and zeros, and the remaining motion on a leg.

    Raises
    ------
    InputError
        Where the model has no rudder or no covariance, or the rows are no legs of this ship in this canal.
    """
    check_rudder(model)
    check_covariance(model)
    readings, conditions = steady_readings(observations, errors), conditions or SteadyConditions()
    canal, ship = model.configuration.canal, model.configuration.ship
    read = readings.values
    check_inside(read["y"], canal.width, ship.beam)
    problem = LegProblem.of(model, conditions)
    found = problem.fit(readings)
    checks = steady_checks(readings, found, problem)
    posterior = log_posterior(problem, found.unknowns, found.information)
    after, learned = learned_model(
        model, posterior.values, posterior.covariance, f"learned from {readings.summary()} ({readings.source})",
        abs(read["y"]), read["u"], checks.contradicted,
    )  # fmt: skip
    std = np.sqrt(np.diag(problem.covariance(found.information)))
    common = problem.common[:, None] * np.stack([found.unknowns, std], axis=1)[problem.count :]
    shared = dict(zip(UNKNOWN, map(tuple, common.tolist()), strict=True))
    return SteadyFit(after, model, readings, conditions, learned, shared, found.latent, checks)


TURNED = ("rudder", "drift", "heading")  # Readings that are often written with the other sign


def steady_checks(readings: SteadyReadings, found: "LegFit", problem: "LegProblem") -> SteadyChecks:
    from scipy.special import chdtrc

    each = chdtrc(found.counted // len(readings), np.maximum(found.left_out, 0.0))
    legs = dict(zip(readings.legs, each.tolist(), strict=True))
    chance = float(chdtrc(found.counted, max(found.chi_square, 0.0)))
    y = readings.values["y"]
    findings = []
    if not y.min() < 0 < y.max():
        findings.append(
            "All legs are on one side of the middle: wind and the zeros of rudder and drift do not cancel, and what "
            "was learned rests on how large they were taken to be; hold the other side too."
        )
    if chance < CONTRADICTION:
        findings.append(
            "The legs contradict the model, each other or their errors: a sum of squares of "
            f"{found.chi_square:.1f} where {found.counted} was to be expected; leg {min(legs, key=legs.__getitem__)} "
            "fits worst. Hold it again, or look for a fault of an instrument."
        )
    findings += _other_sign(readings, found.chi_square, problem)
    if not found.converged:
        findings.append("The search for the true states of the legs did not converge; give smaller errors of y and u.")
    asked, covered = {"speed": readings.values["u"], "abs_y": np.abs(y)}, problem.prior.model.data_range
    findings += extrapolation(covered, {name: column for name, column in asked.items() if getattr(covered, name)})
    findings.append("A steady balance determines ratios of forces: their scale is that of the tests.")
    return SteadyChecks(found.chi_square, found.counted, chance, legs, tuple(findings))


def _other_sign(readings: SteadyReadings, squares: float, problem: "LegProblem") -> list[str]:
    read = readings.values
    return [
        f"With the other sign of {name} the legs fit far better, {other:.1f} instead of {squares:.1f}: is it positive "
        "where it turns the bow to starboard, or where the bow is to starboard?"
        for name in TURNED
        if name in read
        and squares > WRONG_SIGN_GAIN  # Else there is nothing to be won.
        and squares - (other := problem.fit(replace(readings, values={**read, name: -read[name]})).chi_square)
        > WRONG_SIGN_GAIN
    ]


LATENT = ("y", "u", "rudder", "psi")  # True state of a leg, of which its readings are readings
# Forces in balance on a steady leg, and the velocity whose rate each makes.
BALANCED = {"Y": "v", "N": "r"}
FORCES = slice(len(BALANCED))


class LegFit(NamedTuple):
    unknowns: np.ndarray  # (P,) Scaled coefficients, then ``UNKNOWN`` over their standard deviations
    information: np.ndarray  # (P, P)
    latent: np.ndarray  # (legs, 4) Most likely ``LATENT``
    chi_square: float  # Chi-square of the readings under the prior [1]
    left_out: np.ndarray  # (legs,) The part of it that is gone without each leg [1]
    counted: int  # Degrees of freedom
    converged: bool


class LegReadings(NamedTuple):
    value: np.ndarray  # (legs, 4 or 5) ``LATENT`` as read, the direction as often as it is read
    size: np.ndarray  # (legs, 4 or 5) Standard deviations
    zeros: np.ndarray  # (4 or 5, 6) 1 where one of ``UNKNOWN`` adds to a reading
    balance: "SteadyBalance"


@dataclass(frozen=True)
class LegProblem(Unknowns):
    """Unknowns of steady legs: coefficients, then common errors over their standard deviations."""

    prior: CoefficientPrior  # Prior of a model with terms of a rudder
    common: np.ndarray  # (6,) Standard deviations of ``UNKNOWN``
    left_over: np.ndarray  # (5,) ``SteadyConditions.left_over``

    @classmethod
    def of(cls, model: Model, conditions: SteadyConditions) -> "LegProblem":
        return cls(coefficient_prior(model, "held"), shared_errors(conditions, model), left_over(conditions, model))

    @property
    def spreads(self) -> np.ndarray:
        return np.ones(len(UNKNOWN))

    def fit(self, readings: SteadyReadings) -> LegFit:
        legs, unknowns, converged = self._read(readings), np.zeros(len(self.precision)), False
        latent = legs.value[:, : len(LATENT)]
        for _ in range(UPDATE_ROUNDS):
            value, design, through = self._linear(legs, latent, unknowns)
            score = np.einsum("lqi,lq->i", design, value - design @ unknowns)
            information = np.einsum("lqi,lqj->ij", design, design)
            step, _ = bounded_step(self, unknowns, score, information)
            unknowns = unknowns + step
            rest = value - design @ unknowns
            # The readings less zeros and their share of the rest of the balance
            errors = legs.zeros @ (self.common * unknowns[self.count :])
            errors = errors - legs.size**2 * np.einsum("lqi,lq->li", through, rest)
            nearer = (legs.value - errors)[:, : len(LATENT)]
            near = np.allclose(nearer, latent, rtol=UPDATE_SETTLED, atol=UPDATE_SETTLED)
            latent, converged = nearer, bool(near and (np.abs(step) <= UPDATE_SETTLED).all())
            if converged:
                break
        chi_square = float(np.sum(rest**2) + unknowns @ self.precision @ unknowns)
        # The residual of a left-out leg is that of the fit over the part of its own error that no fit takes up.
        share = np.eye(rest.shape[1]) - design @ self.covariance(information) @ design.swapaxes(1, 2)
        left_out = np.einsum("lq,lq->l", rest, np.linalg.solve(share, rest[..., None])[..., 0])
        return LegFit(unknowns, information, latent, chi_square, left_out, rest.size, converged)

    def informations(self, readings: SteadyReadings) -> np.ndarray:
        """Return the information of each leg that is read exactly as here, (legs, P, P)."""
        legs = self._read(readings)
        design = self._linear(legs, legs.value[:, : len(LATENT)], np.zeros(len(self.precision)))[1]
        return np.asarray(design.swapaxes(1, 2) @ design)

    def _read(self, readings: SteadyReadings) -> LegReadings:
        names = ("y", "u", "rudder", *readings.directions)
        value, size = (np.stack([part[name] for name in names], axis=1) for part in (readings.values, readings.errors))
        zeros = np.array([[f"{name}_zero" == unknown for unknown in UNKNOWN] for name in names], float)
        model = self.prior.model
        given = sinkage_and_revolutions(model, readings.values["u"], readings.values)
        return LegReadings(value, size, zeros, SteadyBalance(model, given))

    def _linear(
        self, legs: LegReadings, latent: np.ndarray, unknowns: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return balances (legs, q) about states with independent errors of size one, and their slopes by unknowns
        (legs, q, P) and readings: value = design @ unknowns + error.
        """
        model = self.prior.model
        mean = np.array([model.coefficients[name] for name in model.terms.names])
        by_scaled = self.prior.members * self.prior.scale
        slopes, by_turning, mass = legs.balance.slopes(latent, mean + by_scaled @ unknowns[: self.count])
        columns, again = legs.balance.columns(latent), legs.value.shape[1] - len(LATENT)
        through = np.zeros((len(latent), len(BALANCED) + again, legs.value.shape[1]))
        through[:, FORCES, : len(LATENT)] = slopes
        through[:, len(BALANCED) :, -2:] = -1.0, 1.0  # Two readings of the direction are equal.
        common = -through @ legs.zeros
        common[:, FORCES, FORCES] += np.eye(len(BALANCED))  # Slopes by the wind
        design = np.zeros((*through.shape[:2], len(unknowns)))
        design[:, FORCES, : self.count] = columns @ by_scaled
        design[:, :, self.count :] = common * self.common
        covariance = np.einsum("lqi,li,lri->lqr", through, legs.size**2, through)
        # What wind and a rest of motion leave out of balance
        moved, turned = mass * self.left_over[3:], self.left_over[2] * by_turning
        covariance[:, FORCES, FORCES] += np.diag(self.left_over[:2] ** 2) + moved @ np.swapaxes(moved, 1, 2)
        covariance[:, FORCES, FORCES] += turned[:, :, None] * turned[:, None]
        off = legs.value - np.concatenate([latent, latent[:, -1:].repeat(again, axis=1)], axis=1)
        value = -np.einsum("lqi,li->lq", through, off)
        value[:, FORCES] -= columns @ mean
        try:
            root = np.linalg.cholesky(covariance)
        except np.linalg.LinAlgError:
            raise InputError(
                "errors of these readings are beyond all measure, or differ by too many powers of ten; check each, and "
                "its unit"
            ) from None
        white = [np.linalg.solve(root, own) for own in (value[..., None], design, through)]
        return white[0][..., 0], white[1], white[2]


@dataclass(frozen=True)
class SteadyBalance:
    """Sway force and yaw moment along a straight course: the sway velocity goes with heading and speed."""

    model: Model  # With terms of a rudder
    given: Mapping[str, np.ndarray]  # (legs,) Heave [m], and revolutions [1/s] if the terms need them

    @cached_property
    def _ship(self) -> SimulatedShip:
        return SimulatedShip(self.model)

    def columns(self, latent: np.ndarray) -> np.ndarray:
        """Return what multiplies each coefficient in sway force and yaw moment, (legs, 2, coefficients)."""
        (y, u, rudder, psi), terms = latent.T, self.model.terms
        values = {**self._ship.values(), **Motion.at(psi, y=y, u=u, v=-u * np.tan(psi)).values(), **self.given}
        values |= next(actuator for actuator in terms.actuators if actuator.name == "rudder").placed(rudder)
        columns = np.zeros((len(latent), len(BALANCED), len(terms.names)))
        for row, force in enumerate(BALANCED):
            for term in terms.forces[force]:
                columns[:, row, terms.names.index(term.name)] = term.column(values)
        return columns

    def slopes(self, latent: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return slopes by ``LATENT`` (legs, 2, 4) and by the yaw rate (legs, 2), and the mass (legs, 2, 2)."""
        named = dict(zip(self.model.terms.names, coefficients.tolist(), strict=True))
        linear = self._ship.linearisation({**self._ship.values(), **self.given, **named})
        y, u, rudder, psi = latent.T
        at = {"y": y, "u": u, "v": -u * np.tan(psi), "psi": psi, "rudder": rudder, **self.given}
        # The rates are the forces over the mass, which no place changes.
        rates = linear.linear(at)[:, [LINEARISED.index(velocity) for velocity in BALANCED.values()]]
        names = (*LINEARISED, *linear.controlled)
        mass = np.linalg.inv(rates[:, :, [names.index("Y_in"), names.index("N_in")]])
        by = dict(zip(names, np.moveaxis(mass @ rates, 2, 0), strict=True))
        by_u = by["u"] - by["v"] * np.tan(psi)[:, None]
        by_psi = by["psi"] - by["v"] * (u / np.cos(psi) ** 2)[:, None]
        return np.stack([by["y"], by_u, by["rudder"], by_psi], axis=-1), by["r"], mass


def sinkage_and_revolutions(model: Model, speeds: np.ndarray, read: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return heave [m], and revolutions [1/s] if the terms need them, by the speed of legs (legs,) [m/s]."""
    each, place = np.unique(speeds, return_inverse=True)
    given = {"heave": read["heave"] if "heave" in read else keel_at(model, each).midship[place]}
    if model.terms.propelled:
        given["revolutions"] = (
            read["revolutions"] if "revolutions" in read
            else np.array([self_propulsion(model, speed) for speed in each.tolist()])[place]
        )  # fmt: skip
    return given
