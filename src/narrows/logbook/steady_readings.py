"""Steady legs: readings of each leg with their errors, and the problem that they pose.

The balance of sway and yaw is linear in the coefficients. The legs' true offsets, speeds and angles are unknown too:
with a leg's readings ``m = l + zeros + e`` and the balance ``f(l, coefficients) + wind + rest = 0``, it is linear about
the best l so far, and its error is that of the readings through its slopes (Gauss-Helmert least squares). Each leg then
has a score and an information matrix, as a record of a log has, and the search and the posterior are those of logs.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, did_you_mean
from narrows.base.results import BaseSummary
from narrows.control.steady_course import revolutions_ahead
from narrows.logbook.filtering.likelihood import bounded_step
from narrows.logbook.filtering.log_problem import CoefficientPrior, Unknowns
from narrows.logbook.settings import MISPLACED, MOST_ANGLE, UPDATE_ROUNDS, UPDATE_SETTLED, WIND_LEVER, WINDAGE
from narrows.model.model import Model
from narrows.quantities.names import Quantity
from narrows.safety.request import keel_at, wind_force
from narrows.ship.checks import check_sizes
from narrows.ship.motion import Motion
from narrows.simulation.ship import SimulatedShip

# Readings of a leg.
READ = {
    "y": Quantity("m", "midship to starboard of the middle of the canal"),
    "u": Quantity("m/s", "surge velocity through the water"),
    "rudder": Quantity("rad", "rudder angle, positive where it turns the bow to starboard"),
    "drift": Quantity("rad", "heading minus course over ground, or minus the canal's direction, positive to starboard"),
}
# Values of a leg that may be given too.
GIVEN = {
    "heave": Quantity("m", "midship sinkage; that of the squat formula unless given"),
    "revolutions": Quantity("1/s", "of the propeller, for terms that need it"),
}
LABEL = "leg"
ERRORS = {f"{name}_error": Quantity(quantity.unit, "standard deviation") for name, quantity in READ.items()}
COLUMNS = {**READ, **GIVEN, **ERRORS}


@dataclass(frozen=True, repr=False)
class SteadyReadings(BaseSummary):
    """Legs on which a ship was held, in SI."""

    legs: tuple[str, ...]  #: Their names
    #: (legs,) ``y``, ``u``, ``rudder`` and ``drift``; ``heave`` and ``revolutions`` where they were read
    values: Mapping[str, np.ndarray]
    errors: Mapping[str, np.ndarray]  #: (legs,) Standard deviations of the first four
    source: str = ""  #: The file, or what it was
    sha256: str = ""  #: Hash of the rows

    def __len__(self) -> int:
        return len(self.legs)

    def summary(self) -> str:
        y, u = self.values["y"], self.values["u"]
        speeds = " to ".join(dict.fromkeys(f"{end:.3g}" for end in (u.min(), u.max())))
        return f"{len(self)} legs from {y.min():+.3g} to {y.max():+.3g} m off the middle at {speeds} m/s"


def steady_readings(table: Any, conditions: "SteadyConditions") -> SteadyReadings:
    from narrows.readers.cells import as_sheet, check_once, labels, name_of, numbers, recognised_in, sha256_of_frame
    from narrows.readers.frames import read_frame

    if isinstance(table, SteadyReadings):
        return table
    is_file = isinstance(table, str | Path)
    frame = (read_frame(Path(table)) if is_file else as_sheet(table)).frame
    source = Path(table).name if is_file else name_of(table)
    if frame.empty:
        raise InputError(f"{source}: has no leg; give a row for each side and speed at which the ship was held")
    headers, known = list(frame.columns), recognised_in(frame, COLUMNS, source)
    check_once(known, headers, COLUMNS, source)
    columns = {column.quantity: column.scale * numbers(frame, column.header, source) for column in known}
    for name in READ:
        if name not in columns:
            raise InputError(f"{source}: has no column {name!r}, {READ[name].meaning}{did_you_mean(name, headers)}")
    stated = {name: columns.get(f"{name}_error", np.full(len(frame), reading_error(conditions, name))) for name in READ}
    names = labels(frame, LABEL, source) if LABEL in frame else range(1, len(frame) + 1)
    if len({*names}) < len(frame):
        raise InputError(f"{source}: two legs have the same name; give each a name of its own, or leave {LABEL!r} out")
    values = {name: columns[name] for name in (*READ, *GIVEN) if name in columns}
    _check(readings := SteadyReadings(tuple(map(str, names)), values, stated, source, sha256_of_frame(frame)))
    return readings


def _check(readings: SteadyReadings) -> None:
    for name, column in readings.errors.items():
        least = "over 0" if READ[name].unit == "rad" else "from 0"
        if not (np.isfinite(column) & (column > 0 if least == "over 0" else column >= 0)).all():
            raise InputError(f"{readings.source}: {name}_error is a finite number {least} on every leg; mend it")
    for name in ("rudder", "drift"):
        if (large := np.abs(readings.values[name]) > MOST_ANGLE).any():
            place = int(np.argmax(large))
            raise InputError(
                f"{readings.source}: leg {readings.legs[place]} has a {name} of {readings.values[name][place]} rad; if "
                f"these are degrees, head the column '{name} [deg]'"
            )
    if not (readings.values["u"] > 0).all():
        raise InputError(f"{readings.source}: a leg has no speed ahead; give u over 0, through the water")


# Common errors of all legs, which are estimated with the coefficients: words, printed unit, factor from SI.
SHARED = {
    "wind_Y": ("sway force of the wind", "N", 1.0), "wind_N": ("yaw moment of the wind", "N m", 1.0),
    "rudder_zero": ("zero of the rudder", "deg", 180 / np.pi), "drift_zero": ("zero of the drift", "deg", 180 / np.pi),
    "y_zero": ("zero of the offset", "m", 1.0),
}  # fmt: skip
UNKNOWN = tuple(SHARED)


@dataclass(frozen=True, repr=False)
class BeamWind(BaseSummary):
    """Standard deviations of a beam wind, for conditions with further fields."""

    wind: float = 8.0  #: Beam wind, from either side [m/s]
    windage: float | None = None  #: Lateral area above the water; a tenth of the square of the length unless given [m2]
    wind_lever: float | None = None  #: Where its force acts, off midship; a tenth of the length unless given [m]

    def __post_init__(self) -> None:
        check_sizes(self, over=[name for name in vars(self) if name.endswith(("_time", "_error_deg"))])


def steady_push(conditions: BeamWind, model: Model) -> np.ndarray:  # (2,) [N], [N m]
    length, lever = model.configuration.ship.length, conditions.wind_lever
    force = wind_force(conditions.wind, WINDAGE * length**2 if conditions.windage is None else conditions.windage)
    return np.array([force, force * (WIND_LEVER * length if lever is None else lever)])


@accept_aliases
@dataclass(frozen=True, repr=False)
class SteadyConditions(BeamWind):
    """Standard deviations of the common errors of all legs, and of those that change from leg to leg.

    Force and moment of the wind are the same on every leg but for ``wind_change`` of their standard deviations, and so
    are the zeros. Opposite sides cancel all of them. What still moves on a leg is a force of its own.

    Raises an InputError where a number is negative or not finite, or the time of a leg or the error of an angle is 0.
    """

    wind_change: float = 0.2  #: Change of force and moment of the wind, from leg to leg [1]
    rudder_zero_deg: float = 1.0  #: Zero error of the rudder, the same on every leg [deg]
    drift_zero_deg: float = 1.0  #: Zero error of the drift [deg]
    y_zero: float | None = None  #: Zero error of the offset; a thirtieth of the beam unless given [m]
    yaw_rate_deg: float = 0.005  #: Mean yaw rate over a leg [deg/s]
    yaw_change_deg: float = 0.01  #: Change of the yaw rate over a leg [deg/s]
    sway_change: float = 0.02  #: Change of the sway velocity over a leg [m/s]
    leg_time: float = 120.0  #: Duration of the readings of a leg [s]
    y_error: float = 1.0  #: Error of the mean offset over a leg, if the table has none [m]
    u_error: float = 0.1  #: Error of the speed through the water [m/s]
    rudder_error_deg: float = 1.0  #: Error of the rudder [deg]
    drift_error_deg: float = 0.2  #: Error of the drift [deg]

    def summary(self) -> str:
        aside = f"{self.y_zero:g} m" if self.y_zero is not None else f"{MISPLACED:.2f} beams"
        return (
            f"beam wind {self.wind:g} m/s, its force changing by {100 * self.wind_change:.0f} % from leg to leg; zeros "
            f"of rudder {self.rudder_zero_deg:g} and drift {self.drift_zero_deg:g} deg, of the offset {aside}; turning "
            f"at {self.yaw_rate_deg:g} deg/s; readings to {self.y_error:g} m, {self.u_error:g} m/s, rudder "
            f"{self.rudder_error_deg:g} deg, drift {self.drift_error_deg:g} deg (standard deviations)"
        )


def reading_error(conditions: SteadyConditions, name: str) -> float:
    is_angle = READ[name].unit == "rad"
    error = float(getattr(conditions, f"{name}_error" + "_deg" * is_angle))
    return math.radians(error) if is_angle else error


def shared_errors(conditions: SteadyConditions, model: Model) -> np.ndarray:
    """Return the standard deviations of ``UNKNOWN``, (5,) [N, N m, rad, rad, m]."""
    zeros = (conditions.rudder_zero_deg, conditions.drift_zero_deg)
    aside = MISPLACED * model.configuration.ship.beam if conditions.y_zero is None else conditions.y_zero
    return np.array([*steady_push(conditions, model), *np.radians(zeros), aside], float)


def left_over(conditions: SteadyConditions, model: Model) -> np.ndarray:
    """Return what is left on each leg: force and moment [N, N m], yaw rate [rad/s], accelerations [m/s2, rad/s2]."""
    gust = conditions.wind_change * steady_push(conditions, model)
    rates = conditions.sway_change / conditions.leg_time, math.radians(conditions.yaw_change_deg) / conditions.leg_time
    return np.array([*gust, math.radians(conditions.yaw_rate_deg), *rates])


LEFT = ("r", "vdot", "rdot")  # Motion that is left on a leg, as if each were read as 0
LATENT = ("y", "u", "rudder", "drift")  # True state of a leg, as it is read
# Steps of the central differences [rad/s, m/s2, rad/s2, m, m/s, rad, rad]: regressors are smooth over them.
STEP = 1e-7
BALANCED = ("Y", "N")  # Forces in balance on a steady leg


class LegFit(NamedTuple):
    unknowns: np.ndarray  # (P,) Scaled coefficients, then ``UNKNOWN`` over their standard deviations
    information: np.ndarray  # (P, P)
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
        return LegFit(unknowns, information, chi_square, left_out, rest.size, converged)

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
        root = np.linalg.cholesky(covariance)
        white = [np.linalg.solve(root, own) for own in (value[..., None], design, through)]
        return white[0][..., 0], white[1], white[2]

    @cached_property
    def _given(self) -> dict[str, Any]:
        """Quantities that no leg changes; heave [m], and revolutions [1/s] if the terms need them, by the speed."""
        read = self.readings.values
        each, place = np.unique(read["u"], return_inverse=True)
        given = {"heave": read["heave"] if "heave" in read else keel_at(self.model, each).midship[place]}
        if self.model.terms.propelled:
            ahead = "revolutions" not in read
            given["revolutions"] = revolutions_ahead(self.model, read["u"]) if ahead else read["revolutions"]
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
