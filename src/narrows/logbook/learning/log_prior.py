"""Prior of a model before a log: its coefficients' covariance, or a stated spread."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from narrows.errors import InputError, did_you_mean
from narrows.logbook.filtering.log_problem import (
    SWAY,
    YAW,
    CoefficientPrior,
    Estimated,
    LogProblem,
    Process,
    RecordedMotion,
    StochasticModel,
)
from narrows.logbook.filtering.record_grid import (
    CURRENT_X,
    CURRENT_Y,
    ERROR,
    HELM,
    HELM_GAIN,
    PREDICTED,
    REVOLUTIONS,
    REVOLUTIONS_OFFSET,
    RUDDER,
    RUDDER_OFFSET,
)
from narrows.logbook.sensor_grades import SensorGrade, SignalGrade
from narrows.model.model import Model
from narrows.quantities.names import FORCES
from narrows.ship.motion import Motion
from narrows.simulation.ship import SimulatedShip
from narrows.terms.additions import asymmetry_names, with_asymmetry
from narrows.terms.term import TermKind

# Standard deviations of coefficients: over their size, or each in its own unit.
Spread = float | Mapping[str, float]

ACCELERATIONS = ("udot", "vdot", "rdot")

# Share of the largest eigenvalue of a correlation, under which two coefficients are known as one.
RANK = 1e-9

NO_PRIOR = (
    "this model has no covariance of its coefficients, so a log has no prior; identify it from tests, "
    "or state a spread, as spread=0.1 (--spread 0.1) for a tenth of each"
)


def covariance_before(model: Model, spread: Spread | None) -> np.ndarray:
    """Return the covariance of all coefficients before a log."""
    # Inertia is held where a spread is stated: motion determines only forces over inertia.
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
        sizes = np.array([float(spread.get(name, 0.0)) for name in names])
    else:
        held = {term.name for term in model.terms.terms if term.kind == TermKind.INERTIA}
        sizes = np.array([spread * abs(model.coefficients[name]) * (name not in held) for name in names])
    if not (np.isfinite(sizes).all() and (sizes >= 0).all() and sizes.any()):
        raise InputError(f"a spread of {spread} is none: give a share over 0, or standard deviations by coefficient")
    return sizes


def with_asymmetry_before(model: Model, covariance: np.ndarray, u: float) -> tuple[Model, np.ndarray]:
    """Return a model with an asymmetry, and the covariance with a prior of it where there is none."""
    # covariance (n, n); u [m/s]
    old, names = model.terms.names, asymmetry_names(model.terms)
    if names[0] not in old:
        table = with_asymmetry(model.terms)
        zeros = {**model.coefficients, **dict.fromkeys(names, 0.0)}
        model = replace(model, terms=table, coefficients={name: zeros[name] for name in table.names}, covariance=None)
    places, whole = [model.terms.names.index(name) for name in old], np.zeros((len(model.terms),) * 2)
    whole[np.ix_(places, places)] = covariance
    for name, size in zip(names, _turned_rudder(model, u), strict=True):
        place = model.terms.names.index(name)
        whole[place, place] = whole[place, place] or size**2
    return model, whole


def _turned_rudder(model: Model, u: float) -> list[float]:
    """Asymmetries as large as what the rudder does at an angle of ``RUDDER_ZERO``."""
    still = {**SimulatedShip(model).values(), **Motion.at(u=u).values()}
    rudder = next(actuator for actuator in model.terms.actuators if actuator.name == RUDDER)
    turned = {**still, **rudder.placed(RUDDER_ZERO)}
    sizes = []
    for name, terms in zip(asymmetry_names(model.terms), (model.terms.sway, model.terms.yaw), strict=True):
        force = sum(model[t.name] * (t.column(turned) - t.column(still)) for t in terms if t.kind == TermKind.RUDDER)
        sizes.append(abs(float(force / model.terms[name].column(still))))
    return sizes


def coefficient_prior(
    model: Model, covariance: np.ndarray, surge: str, free: frozenset[str] | None = None
) -> CoefficientPrior:
    """Return what is known of the coefficients that a motion can move."""
    # covariance (n, n)
    acting = [force for force in FORCES if force != "X" or surge == "free"]
    names = [term.name for force in acting for term in model.terms.forces[force]]
    known = {name: covariance[i, i] > 0 for i, name in enumerate(model.terms.names)}
    groups = _groups(model, [name for name in names if known[name]])
    places = [model.terms.names.index(group[0]) for group in groups]
    part = covariance[np.ix_(places, places)]
    scale = np.sqrt(np.diag(part))
    ends = [np.array([model.terms[name].bound for name in group]).T for group in groups]
    bounds = np.array([(low.max(), high.min()) for low, high in ends]).reshape(len(groups), 2)
    mean = np.array([model.coefficients[group[0]] for group in groups])
    changes = np.array([free is None or not free.isdisjoint(group) for group in groups])
    sizes, axes = np.linalg.eigh(part / np.outer(scale, scale))  # Coefficients that are known as one stay so nearly.
    precision = (axes / np.maximum(sizes, RANK * max(sizes[-1], 1.0))) @ axes.T
    return CoefficientPrior(groups, mean, scale, precision, bounds, changes)


def _groups(model: Model, names: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """Coefficients that are one, together."""
    leader = {name: name for name in names}
    for first, second in model.terms.ties:
        if first in leader and second in leader:
            old, new = leader[second], leader[first]
            leader = {name: new if head == old else head for name, head in leader.items()}
    return tuple(tuple(name for name in names if leader[name] == head) for head in dict.fromkeys(leader.values()))


def push_inertia(model: Model, prior: CoefficientPrior, u: float, surge_inertia: float | None = None) -> np.ndarray:
    """Return what resists accelerations, by the terms, (3, 1 + p)."""
    # u [m/s]; surge_inertia [kg]
    names = {name: place for place, group in enumerate(prior.groups) for name in group}
    still = {**SimulatedShip(model).values(), **Motion.at(u=u).values()}
    inertia = np.zeros((3, 1 + len(prior.groups)))
    for axis, (terms, acceleration) in enumerate(zip(model.terms.forces.values(), ACCELERATIONS, strict=True)):
        pushed = {**still, acceleration: 1.0}
        for term in terms:
            resists = float(term.column(still) - term.column(pushed))
            if term.name in names:
                inertia[axis, 1 + names[term.name]] += resists
            else:
                inertia[axis, 0] += resists * model.coefficients[term.name]
    inertia[0, 0] = surge_inertia or inertia[0, 0] or 1.0
    return inertia


# Length of a step, in times of a ship length; in a basin, where the kinks of a rudder in a zigzag matter more.
STEP, BASIN_STEP = 1 / 25, 1 / 40

# Steady push of a record.
STEADY = "steady_{}".format

# How long a gust stays before anything is known of it [s], and standard deviations of logarithms: of that, of the
# strength of gusts, of noise; of the inverse hyperbolic tangent of the correlation between sway and yaw.
USUAL_MEMORY, SPREAD_OF_MEMORY, SPREAD_OF_STRENGTH, SPREAD_OF_NOISE, SPREAD_OF_CORRELATION = 40.0, 1.0, 1.5, 0.3, 1.0

# Standard deviations of accelerations before anything is known, over speed squared by length (and by length again for
# yaw): of gusts, and of a push that stays.
GUST, STEADY_PUSH = 0.005, 0.1

# Standard deviation of a current that nothing is known of [m/s].
SPREAD_OF_CURRENT = 0.3

# Standard deviation of revolutions that are not recorded, over those that keep the usual speed: by hull, propeller and
# wind a ship needs a fifth more or less.
SPREAD_OF_REVOLUTIONS = 0.2

DEGREE = np.pi / 180

# Standard deviation of an asymmetry, as the rudder angle that would hold it: ships steer straight with about a degree.
RUDDER_ZERO = 1.0 * DEGREE

# What a model leaves of places in a basin, in lengths of the ship, its memory counted; four times as much of angles,
# five of yaw rates and twice as much of speeds, over those of the ship.
USUALLY_LEFT = 0.015

# Standard deviation of the logarithm of noise in a basin.
BASIN_SPREAD = 2.0

# Readings for each independent one where a model's own error is what is left, to begin with.
USUALLY_CORRELATED = 60.0

# The noise that counts is what the model leaves of the records.
BASIN = SensorGrade(
    "basin",
    "a towing tank: no wind, no current, noise estimated from the records",
    {
        **{name: SignalGrade(1e-6) for name in PREDICTED if name != HELM},
        RUDDER: SignalGrade(1e-9, zero=0.1 * DEGREE),
    },
)


@dataclass(frozen=True)
class LogAssumptions:
    """Assumptions."""

    grade: SensorGrade  # Grade of the sensors
    gusts: bool  # Whether pushes with a memory act
    surge: str  # Whether the speed is integrated
    pilot: bool  # Whether the rudder follows what a pilot sees
    # Standard deviation and memory [s] of the rounding error of signals
    rounding: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def step(self, length: float, u: float) -> float:
        """Return the length of a step [s]."""
        return float(f"{(STEP if self.gusts else BASIN_STEP) * length / u:.2g}")

    def lacks_revolutions(self, signals: set[str]) -> bool:
        """True if propeller revolutions are unknown: not recorded, and not those of a tank's tests."""
        return REVOLUTIONS not in signals and self.grade.name != BASIN.name

    def problem(
        self, motion: RecordedMotion, prior: CoefficientPrior, inertia: np.ndarray, signals: set[str], u: float
    ) -> LogProblem:
        """Return what is estimated."""
        length = motion.model.configuration.ship.length
        noise, sizes = self._noise(signals, length, u), self._sizes(length, u)
        gusts = [Process(name, name, GUST * size, USUAL_MEMORY) for name, size in sizes.items()] if self.gusts else []
        processes = [*gusts, *self._errors(signals, motion, noise, length / u)]
        if self.gusts:
            processes += [Process(STEADY(n), n, STEADY_PUSH * size, np.inf) for n, size in sizes.items()]
        if self.pilot and RUDDER in signals:
            noise[HELM] = HELM_NOISE
            processes += _pilot(length, u)
        names = tuple(one.name for one in gusts)
        model = StochasticModel(tuple(processes), noise, self._estimated(names, noise, processes), gusts=names)
        return LogProblem(motion, prior, inertia, model, 1.0 if self.gusts else USUALLY_CORRELATED)

    def _estimated(
        self, gusts: tuple[str, ...], noise: Mapping[str, float], processes: list[Process]
    ) -> tuple[Estimated, ...]:
        """The numbers that records determine."""
        basin = self.grade.name == BASIN.name
        found = [Estimated("std", (name,), SPREAD_OF_STRENGTH) for name in gusts]
        if gusts:
            found += [
                Estimated("memory", gusts, SPREAD_OF_MEMORY),
                Estimated("correlation", (SWAY, YAW), SPREAD_OF_CORRELATION),
            ]
        if HELM in noise:
            found += [Estimated(of, (AIM,), SPREAD_OF_STRENGTH) for of in ("std", "memory")]
        wide = {HELM: SPREAD_OF_STRENGTH, **dict.fromkeys(noise if basin else (), BASIN_SPREAD)}
        return (*found, *(Estimated("noise", (name,), wide.get(name, SPREAD_OF_NOISE)) for name in noise))

    def _noise(self, signals: set[str], length: float, u: float) -> dict[str, float]:
        """Noise of the grade; in a basin the usual model error, to begin with."""
        read = [name for name in PREDICTED if name in signals]
        if self.grade.name != BASIN.name:
            return {name: self._grade(name).noise for name in read}
        angle, rate = USUALLY_LEFT * 4, USUALLY_LEFT * 5 * u / length
        sizes = {"x": USUALLY_LEFT * length, "y": USUALLY_LEFT * length, "psi": angle, "course": angle, "r": rate}
        return {name: sizes.get(name, USUALLY_LEFT * 2 * u) for name in read}

    def _grade(self, name: str) -> SignalGrade:
        """The grade of a signal; of one that the sensors are not said to have, that of the nearest."""
        nearest = {"u_ground": "u", "speed_over_ground": "u", "course": "psi", "v_ground": "u", "v": "u"}
        graded = self.grade.signals
        return graded.get(name) or graded.get(nearest.get(name, name)) or UNGRADED[name]

    def _sizes(self, length: float, u: float) -> dict[str, float]:
        """Accelerations that pushes are measured by."""
        along = {"X": u * u / length} if self.surge == "free" else {}
        return {**along, "Y": u * u / length, "N": (u / length) ** 2}

    def _errors(
        self, signals: set[str], motion: RecordedMotion, noise: Mapping[str, float], lasting: float
    ) -> list[Process]:
        """Errors of sensors and of the rudder's indicator, and currents."""
        found = []
        if RUDDER in signals:
            rudder, step = self._grade(RUDDER), self.step(lasting, 1.0)
            found += [Process("rudder_noise", RUDDER_OFFSET, rudder.noise * np.sqrt(rudder.period / step), 0.0)]
            found += [Process(RUDDER_OFFSET, RUDDER_OFFSET, rudder.zero, np.inf)]
        if REVOLUTIONS in motion.positions and self.lacks_revolutions(signals):
            usual = SPREAD_OF_REVOLUTIONS * motion.positions[REVOLUTIONS]
            found.append(Process(REVOLUTIONS_OFFSET, REVOLUTIONS_OFFSET, usual, np.inf))
        for name in noise:
            grade = self._grade(name)
            if grade.wander > 0:
                found.append(Process(f"{name}_wander", ERROR(name), grade.wander, grade.memory))
            if name in self.rounding:
                found.append(Process(f"{name}_rounding", ERROR(name), *self.rounding[name]))
            if name != "x":
                found.append(Process(ERROR(name), ERROR(name), grade.zero, np.inf))
        if signals & {"u_ground", "v_ground", "speed_over_ground", "course", "x"} and self.grade.name != BASIN.name:
            found.append(Process(CURRENT_X, CURRENT_X, SPREAD_OF_CURRENT, np.inf))
            if not motion.model.has_bank:
                found.append(Process(CURRENT_Y, CURRENT_Y, SPREAD_OF_CURRENT, np.inf))
        return [one for one in found if one.std > 0]


# A pilot: noise of the rudder from step to step [rad], its trim [rad], and what an aim that wanders adds [rad]; the aim
# stays for so many times of a ship length. All but the trim are estimated, from these.
HELM_NOISE, TRIM, AIMED, AIM_STAYS, AIM = 1.0 * DEGREE, 5.0 * DEGREE, 2.0 * DEGREE, 4.0, "helm_aim"


def _pilot(length: float, u: float) -> list[Process]:
    """Gains of a record's pilot, as large as those of a regulator, and the aim."""
    sizes = {"y": 2.0 / length, "psi": 5.0, "v": 5.0 / u, "r": 2.0 * length / u, RUDDER: 0.5}
    gains = [Process(HELM_GAIN(name), HELM_GAIN(name), size, np.inf) for name, size in sizes.items()]
    trim = Process(f"{HELM}_trim", ERROR(HELM), TRIM, np.inf)
    return [*gains, trim, Process(AIM, ERROR(HELM), AIMED, AIM_STAYS * length / u)]


# Errors of signals outside a grade.
UNGRADED = {
    "x": SignalGrade(1.0), "y": SignalGrade(1.0), "psi": SignalGrade(0.3 * DEGREE), "r": SignalGrade(0.02 * DEGREE),
    "u": SignalGrade(0.1), "v": SignalGrade(0.1), "u_ground": SignalGrade(0.1), "v_ground": SignalGrade(0.1),
    "speed_over_ground": SignalGrade(0.1), "course": SignalGrade(2 * DEGREE), RUDDER: SignalGrade(0.5 * DEGREE),
}  # fmt: skip
