"""The five-minute experiment: a ship held to one side, then to the other, and the steady rudder and drift read."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from narrows.control.steady_course import check_inside, check_rudder
from narrows.logbook.learned_coefficient import LEARNED, ON_TWINS, LearnedAnswer, LearnedCoefficient, learned_model
from narrows.logbook.learning.log_posterior import check_covariance, log_posterior
from narrows.logbook.settings import CONTRADICTION, WRONG_SIGN_GAIN
from narrows.logbook.steady_legs.leg_balance import LegFit, LegProblem
from narrows.logbook.steady_legs.steady_readings import (
    SHARED,
    UNKNOWN,
    ReadingErrors,
    SteadyConditions,
    SteadyReadings,
    steady_readings,
)
from narrows.model.data_range import extrapolation
from narrows.model.model import Model


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
        """Contradictions, undetermined quantities, inseparable pairs, assumptions."""
        taken = f"Assumed: {self.conditions.summary()}."
        whose = () if self.checks.contradicted else (WHOSE,)
        return (*self.checks.findings, *self.correlated(), taken, *self.prior.configuration.notes, *whose, ON_TWINS)

    def summary(self) -> str:
        """What was learned, what still comes from the tests, and whether the legs agree."""
        agree = (
            f"The legs {'contradict' if self.checks.contradicted else 'agree with'} the model: a sum of squares of "
            f"{self.checks.chi_square:.1f}, {self.checks.freedom} expected."
        )
        return "\n".join((self._taught(self.readings.summary()), agree, ON_TWINS))

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name: part of what ``learn --steady --json`` prints."""
        return {
            "summary": self.summary(),
            "informative": self.informative,
            "coefficients": [coefficient.to_dict() for coefficient in self.coefficients.values()],
            "shared": [
                {"name": name, "unit": unit, "value": factor * value, "std": factor * std, "prior_std": factor * before}
                for (name, (_, unit, factor)), (value, std), before in zip(
                    SHARED.items(), self.shared.values(), self.conditions.shared(self.prior).tolist(), strict=True)
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
            "y": read["y"], "u": read["u"], "rudder_deg": np.degrees(read["rudder"]),
            "direction_deg": np.degrees(read[self.readings.directions[0]]), "likely_y": y,
            "likely_rudder_deg": np.degrees(rudder), "likely_heading_deg": np.degrees(heading),
        }  # fmt: skip
        return [
            {"leg": leg, **{name: float(column[i]) for name, column in columns.items()},
             "probability": self.checks.leg_probabilities[leg]}
            for i, leg in enumerate(self.readings.legs)
        ]  # fmt: skip


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


# Quantities that a balance with so many unknowns cannot determine.
WHOSE = (
    "Legs that agree do not show that they are of this ship: on twins those of one a quarter shorter or longer agree, "
    "and a rudder of the wrong sign may; see to ship, draft and signs."
)
TURNED = ("rudder", "drift", "heading")  # Readings that are often written with the other sign
ONE_SIDE = (
    "All legs are on one side of the middle: wind and the zeros of rudder and drift do not cancel, and what was "
    "learned rests on how large they were taken to be; hold the other side too."
)
SCALE = "A steady balance determines ratios of forces: their scale is that of the tests."


def steady_checks(readings: SteadyReadings, found: LegFit, problem: LegProblem) -> SteadyChecks:
    from scipy.special import chdtrc

    each = chdtrc(found.counted // len(readings), np.maximum(found.left_out, 0.0))
    legs = dict(zip(readings.legs, each.tolist(), strict=True))
    chance = float(chdtrc(found.counted, max(found.chi_square, 0.0)))
    y = readings.values["y"]
    findings = [] if y.min() < 0 < y.max() else [ONE_SIDE]
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
    return SteadyChecks(found.chi_square, found.counted, chance, legs, (*findings, SCALE))


def _other_sign(readings: SteadyReadings, squares: float, problem: LegProblem) -> list[str]:
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
