"""Learn from steady legs: a ship is held to one side, then to the other, and the steady rudder and drift read.

The balance of sway and yaw is linear in the coefficients. The legs' true offsets, speeds and angles are unknown too:
with a leg's readings ``m = l + zeros + e`` and the balance ``f(l, coefficients) + wind + rest = 0``, it is linear about
the best l so far, and its error is that of the readings through its slopes (Gauss-Helmert least squares). Each leg then
has a score and an information matrix, as a record of a log has, and the search and the posterior are those of logs.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.special import chdtrc

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.control.steady_course import check_inside, check_rudder
from narrows.logbook.filtering.likelihood import bounded_step
from narrows.logbook.filtering.log_problem import CoefficientPrior, Unknowns
from narrows.logbook.learned_coefficients import (
    LEARNED,
    ON_TWINS,
    LearnedAnswer,
    check_covariance,
    coefficient_prior,
    learned_model,
    log_posterior,
)
from narrows.logbook.settings import CONTRADICTION, UPDATE_ROUNDS, UPDATE_SETTLED, WRONG_SIGN_GAIN
from narrows.logbook.steady_legs.steady_readings import (
    SHARED,
    UNKNOWN,
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
from narrows.simulation.initial_state import self_propulsion
from narrows.simulation.ship import SimulatedShip


@dataclass(frozen=True, repr=False)
class SteadyFit(LearnedAnswer):
    """Result of learning from steady legs."""

    readings: SteadyReadings  #: The legs
    conditions: SteadyConditions  #: Assumptions on wind, zeros and remaining motion
    #: Common errors of all legs in SI, most likely value and standard error: ``wind_Y``, ``wind_N``, ``rudder_zero``,
    #: ``drift_zero``, ``y_zero``
    shared: Mapping[str, tuple[float, float]]
    latent: np.ndarray  #: (legs, 4) Most likely state of the ship: y [m], u [m/s], rudder, psi [rad]
    chi_square: float  #: Sum of squares of the readings over their expected errors [1]
    freedom: int  #: Its degrees of freedom
    probability: float  #: Probability of at least this sum if model, prior and errors are right [1]
    leg_probabilities: Mapping[str, float]  #: The same probability of each leg, given all others
    findings: tuple[str, ...]  #: Faults and undetermined quantities

    @property
    def contradicted(self) -> bool:
        """True where the legs contradict the model, each other or their errors."""
        return self.probability < CONTRADICTION

    @property
    def informative(self) -> bool:
        """True where a coefficient of the bank was learned, and nothing contradicts it."""
        learned = any(c.status == LEARNED for c in self.coefficients.values() if c.from_bank)
        return learned and not self.contradicted

    @property
    def notes(self) -> tuple[str, ...]:
        """Contradictions, undetermined quantities, assumptions."""
        taken = f"Assumed: {self.conditions.summary()}."
        agreeing = (
            "Legs that agree do not show that they are of this ship: on twins those of one a quarter shorter or longer "
            "agree, and a rudder of the wrong sign may; see to ship, draft and signs."
        )
        doubt = () if self.contradicted else (agreeing,)
        return (*self.findings, taken, *self.prior.configuration.notes, *doubt, ON_TWINS)

    def summary(self) -> str:
        agree = (
            f"The legs {'contradict' if self.contradicted else 'agree with'} the model: a sum of squares of "
            f"{self.chi_square:.1f}, {self.freedom} expected."
        )
        return "\n".join((self._learned_sentence(self.readings.summary()), agree, ON_TWINS))

    def to_dict(self) -> dict[str, Any]:
        prior, read = shared_errors(self.conditions, self.prior), self.readings.values
        y, _, rudder, heading = self.latent.T
        columns = {
            "leg": self.readings.legs, "y": read["y"], "u": read["u"], "rudder_deg": np.degrees(read["rudder"]),
            "direction_deg": np.degrees(read["drift"]), "likely_y": y,
            "likely_rudder_deg": np.degrees(rudder), "likely_heading_deg": np.degrees(heading),
            "probability": list(self.leg_probabilities.values()),
        }  # fmt: skip
        rows = zip(*(np.asarray(column).tolist() for column in columns.values()), strict=True)
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
            "legs": [dict(zip(columns, row, strict=True)) for row in rows],
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
        A row a leg: y [m], u [m/s], rudder, drift (or heading), and their errors ``y_error`` and so on where they are
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
    found = problem.fit()
    probability = float(chdtrc(found.counted, max(found.chi_square, 0.0)))
    each = chdtrc(found.counted // len(readings), np.maximum(found.left_out, 0.0))
    by_leg = dict(zip(readings.legs, each.tolist(), strict=True))
    posterior = log_posterior(problem, found.unknowns, found.information)
    after, learned = learned_model(
        model, posterior.values, posterior.covariance, f"learned from {readings.summary()} ({readings.source})",
        abs(read["y"]), read["u"], probability < CONTRADICTION,
    )  # fmt: skip
    std = np.sqrt(np.diag(problem.covariance(found.information)))
    common = problem.common[:, None] * np.stack([found.unknowns, std], axis=1)[problem.count :]
    shared = dict(zip(UNKNOWN, map(tuple, common.tolist()), strict=True))
    findings = tuple(_findings(problem, found, min(by_leg, key=by_leg.__getitem__), probability))
    checks = found.chi_square, found.counted, probability, by_leg, findings
    return SteadyFit(after, model, learned, readings, conditions, shared, found.latent, *checks)


TURNED = ("rudder", "drift")  # Readings that are often written with the other sign


def _findings(problem: "LegProblem", found: "LegFit", worst: str, probability: float) -> Iterator[str]:
    read, squares = problem.readings.values, found.chi_square
    if not read["y"].min() < 0 < read["y"].max():
        yield (
            "All legs are on one side of the middle: wind and the zeros of rudder and drift do not cancel, and what "
            "was learned rests on how large they were taken to be; hold the other side too."
        )
    if probability < CONTRADICTION:
        yield (
            f"The legs contradict the model, each other or their errors: a sum of squares of {squares:.1f} where "
            f"{found.counted} was to be expected; leg {worst} fits worst. Hold it again, or look for a fault of an "
            "instrument."
        )
    for name in TURNED if squares > WRONG_SIGN_GAIN else ():  # Else there is nothing to be won.
        turned = replace(problem.readings, values={**read, name: -read[name]})
        other = replace(problem, readings=turned).fit().chi_square
        if squares - other > WRONG_SIGN_GAIN:
            yield (
                f"With the other sign of {name} the legs fit far better, {other:.1f} instead of {squares:.1f}: is it "
                "positive where it turns the bow to starboard, or where the bow is to starboard?"
            )
    if not found.converged:
        yield "The search for the true states of the legs did not converge; give smaller errors of y and u."
    asked, covered = {"speed": read["u"], "abs_y": np.abs(read["y"])}, problem.model.data_range
    yield from extrapolation(covered, {name: column for name, column in asked.items() if getattr(covered, name)})
    yield "A steady balance determines ratios of forces: their scale is that of the tests."


LEFT = ("r", "vdot", "rdot")  # Motion that is left on a leg, as if each were read as 0
LATENT = ("y", "u", "rudder", "drift")  # True state of a leg, as it is read
# Steps of the central differences [rad/s, m/s2, rad/s2, m, m/s, rad, rad]: regressors are smooth over them.
STEP = 1e-7
BALANCED = ("Y", "N")  # Forces in balance on a steady leg


class LegFit(NamedTuple):
    unknowns: np.ndarray  # (P,) Scaled coefficients, then ``UNKNOWN`` over their standard deviations
    information: np.ndarray  # (P, P)
    latent: np.ndarray  # (legs, 4) Most likely ``LATENT``
    chi_square: float  # Chi-square of the readings under the prior [1]
    left_out: np.ndarray  # (legs,) The part of it that is gone without each leg [1]
    counted: int  # Degrees of freedom
    converged: bool


@dataclass(frozen=True)
class LegProblem(Unknowns):
    """Unknowns of steady legs: coefficients, then common errors over their standard deviations."""

    prior: CoefficientPrior  # Prior of a model with terms of a rudder
    conditions: SteadyConditions
    readings: SteadyReadings

    @property
    def model(self) -> Model:
        return self.prior.model

    @cached_property
    def common(self) -> np.ndarray:
        return shared_errors(self.conditions, self.model)

    @property
    def spreads(self) -> np.ndarray:
        return np.ones(len(UNKNOWN))

    @cached_property
    def _read(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return readings (legs, 7), their standard deviations, and 1 where one of ``UNKNOWN`` adds to one, (7, 5)."""
        names, legs = (*LEFT, *LATENT), len(self.readings)
        left = dict(zip(LEFT, left_over(self.conditions, self.model)[2:], strict=True))
        value = [self.readings.values.get(name, np.zeros(legs)) for name in names]
        size = [self.readings.errors[name] if name not in left else np.full(legs, left[name]) for name in names]
        zeros = np.array([[f"{name}_zero" == unknown for unknown in UNKNOWN] for name in names], float)
        return np.stack(value, axis=1), np.stack(size, axis=1), zeros

    def fit(self) -> LegFit:
        (read, size, zeros), unknowns, converged = self._read, np.zeros(len(self.precision)), False
        latent = read[:, len(LEFT) :]
        for _ in range(UPDATE_ROUNDS):
            value, design, through = self._linear(latent, unknowns)
            score = np.einsum("lqi,lq->i", design, value - design @ unknowns)
            information = np.einsum("lqi,lqj->ij", design, design)
            step, _ = bounded_step(self, unknowns, score, information)
            unknowns = unknowns + step
            rest = value - design @ unknowns
            # The readings less zeros and their share of the rest of the balance
            errors = zeros @ (self.common * unknowns[self.count :]) - size**2 * np.einsum("lqi,lq->li", through, rest)
            nearer = (read - errors)[:, len(LEFT) :]
            near = np.allclose(nearer, latent, rtol=UPDATE_SETTLED, atol=UPDATE_SETTLED)
            latent, converged = nearer, bool(near and (np.abs(step) <= UPDATE_SETTLED).all())
            if converged:
                break
        chi_square = float(np.sum(rest**2) + unknowns @ self.precision @ unknowns)
        # The residual of a left-out leg is that of the fit over the part of its own error that no fit takes up.
        share = np.eye(rest.shape[1]) - design @ self.covariance(information) @ design.swapaxes(1, 2)
        left_out = np.einsum("lq,lq->l", rest, np.linalg.solve(share, rest[..., None])[..., 0])
        return LegFit(unknowns, information, latent, chi_square, left_out, rest.size, converged)

    def informations(self) -> np.ndarray:  # (legs, P, P)
        design = self._linear(self._read[0][:, len(LEFT) :], np.zeros(len(self.precision)))[1]
        return np.asarray(design.swapaxes(1, 2) @ design)

    def _linear(self, latent: np.ndarray, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return balances (legs, 2) about states with independent errors of size one, and their slopes by unknowns
        (legs, 2, P) and readings: value = design @ unknowns + error.
        """
        (read, size, zeros), legs = self._read, len(latent)
        mean = np.array([self.model.coefficients[name] for name in self.model.terms.names])
        by_scaled = self.prior.members * self.prior.scale
        state = np.append(np.zeros((legs, len(LEFT))), latent, axis=1)
        through, columns = self._slopes(state, mean + by_scaled @ unknowns[: self.count]), self._columns(state)
        common = -through @ zeros
        common[:, :, : len(BALANCED)] += np.eye(len(BALANCED))  # Slopes by the wind
        design = np.concatenate([columns @ by_scaled, common * self.common], axis=2)
        covariance = np.einsum("lqi,li,lri->lqr", through, size**2, through)
        covariance += np.diag(left_over(self.conditions, self.model)[: len(BALANCED)] ** 2)
        value = -np.einsum("lqi,li->lq", through, read - state) - columns @ mean
        try:
            root = np.linalg.cholesky(covariance)
        except np.linalg.LinAlgError:
            raise InputError(
                "errors of these readings are beyond all measure, or differ by too many powers of ten; check each, and "
                "its unit"
            ) from None
        white = [np.linalg.solve(root, own) for own in (value[..., None], design, through)]
        return white[0][..., 0], white[1], white[2]

    @cached_property
    def _given(self) -> dict[str, Any]:
        """Quantities that no leg changes; heave [m], and revolutions [1/s] if the terms need them, by the speed."""
        read = self.readings.values
        each, place = np.unique(read["u"], return_inverse=True)
        given = {"heave": read["heave"] if "heave" in read else keel_at(self.model, each).midship[place]}
        if self.model.terms.propelled:
            given["revolutions"] = (
                read["revolutions"] if "revolutions" in read
                else np.array([self_propulsion(self.model, speed) for speed in each.tolist()])[place]
            )  # fmt: skip
        return {**SimulatedShip(self.model).values(), **given}

    def _columns(self, state: np.ndarray) -> np.ndarray:
        """Return what multiplies each coefficient in sway force and yaw moment, (legs, 2, coefficients)."""
        # state (legs, 7): ``LEFT`` and ``LATENT``. Along a straight course the sway velocity goes with the heading.
        (*left, y, u, rudder, psi), terms = state.T, self.model.terms
        motion = Motion.at(psi, y=y, u=u, v=-u * np.tan(psi), **dict(zip(LEFT, left, strict=True)))
        values = {**motion.values(), **self._given}
        values |= next(actuator for actuator in terms.actuators if actuator.name == "rudder").placed(rudder)
        columns = np.zeros((len(state), len(BALANCED), len(terms.names)))
        for row, force in enumerate(BALANCED):
            for term in terms.forces[force]:
                columns[:, row, terms.names.index(term.name)] = term.column(values)
        return columns

    def _slopes(self, state: np.ndarray, coefficients: np.ndarray) -> np.ndarray:  # (legs, 2, 7)
        aside = STEP * np.eye(state.shape[1])
        ahead, behind = ([self._columns(state + sign * one) @ coefficients for one in aside] for sign in (1, -1))
        return np.asarray(np.moveaxis(np.array(ahead) - np.array(behind), 0, -1) / (2 * STEP))
