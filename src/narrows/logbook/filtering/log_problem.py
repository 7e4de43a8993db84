"""A fit to records: the motion with the recorded rudder and its exact slopes, and the unknowns with their priors."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from narrows.codegen.free_motion import COUNTED
from narrows.codegen.free_motion import INPUTS as PUSHED
from narrows.logbook.filtering.record_grid import CURRENTS, ERROR, HELM, HELM_GAIN, OFFSET, RUDDER, STATES
from narrows.model.model import Model
from narrows.simulation.controllers import Named, WithoutMemory
from narrows.simulation.sensitivities import TangentIntegrator
from narrows.simulation.ship import PARAMETER

PUSHES = ("X", "Y", "N")
INPUTS = (*PUSHES, OFFSET(RUDDER), OFFSET("revolutions"), *CURRENTS)  # What processes may add to, but for sensors
CURRENT = "current"  # Quantities of a waterway, along its line
# Name, in the law, of an actuator's position at the end of the step; actuators go there straight within the step.
RECORDED = "recorded_{}".format
UNLIMITED = 1e9  # Limit and rate of what was recorded: it went where it went


@dataclass(frozen=True, repr=False)
class RecordedHelm(WithoutMemory):
    """A control law that follows recorded positions, straight between the ends of the steps."""

    positions: Mapping[str, float]  # Positions of the recorded actuators, at the start

    def parameters(self) -> Mapping[str, float]:
        offsets = {OFFSET(name): 0.0 for name in self.positions}
        return {RECORDED(name): position for name, position in self.positions.items()} | offsets

    def orders(self, at: Any) -> tuple[Named, Named]:
        return {name: getattr(at, RECORDED(name)) + getattr(at, OFFSET(name)) for name in self.positions}, {}


@dataclass(frozen=True)
class RecordedMotion:
    """A model and the choices with which it is integrated under recorded orders."""

    model: Model  # The ship
    positions: Mapping[str, float]  # Actuators that follow a record, each with a position that is usual
    # Derivatives are taken by these too, and by the initial states, the external forces and the offsets of positions
    coefficients: tuple[str, ...]
    choices: Mapping[str, Any]  # As for ``simulate``: surge, contact, waterway, u

    @cached_property
    def directions(self) -> tuple[str, ...]:
        offsets = map(OFFSET, self.positions)
        current = (CURRENT,) if self.choices.get("waterway") is not None else ()
        return (*STATES, *PUSHES, *offsets, *current, *self.coefficients)

    @cached_property
    def integrator(self) -> TangentIntegrator:
        helm = RecordedHelm(dict(self.positions))
        return TangentIntegrator.of(self.model, self.directions, {**self.choices, **self.positions, "controller": helm})

    def with_coefficients(self, values: Mapping[str, float]) -> "RecordedMotion":
        other = replace(self, model=self.model.with_coefficients(**values))
        other.__dict__["integrator"] = self.integrator.with_coefficients(other.model)
        return other

    def sailed(
        self, starts: np.ndarray, pushes: np.ndarray, first: np.ndarray, times: np.ndarray,
        positions: Mapping[str, np.ndarray], offsets: Mapping[str, np.ndarray] | None = None, current: float = 0.0,
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Sail every piece of a record from its own start; return the six states and their derivatives."""
        # starts (pieces, 6): x, y [m], psi [rad], u, v [m/s], r [rad/s]; pushes (pieces, 3): X, Y [N], N [N m]
        # first (pieces + 1,); times (nodes,) [s]; offsets of actuators (pieces,); current [m/s]
        integrator = self.integrator
        kept, count = integrator.integrator.choices.kept, np.diff(first)
        off = {name: np.zeros(len(count)) for name in self.positions} | dict(offsets or {})
        at_start = {name: positions[name][first[:-1]] + off[name] for name in self.positions}
        begin, slopes = self._started(kept, starts, at_start)
        inputs = {PUSHED[name]: np.repeat(pushes[:, i], count) for i, name in enumerate(PUSHES)}
        after = slice(first[0] + 1, first[-1] + 1)
        inputs |= {PARAMETER(RECORDED(name)): positions[name][after] for name in self.positions}
        inputs |= {PARAMETER(OFFSET(name)): np.repeat(off[name], count) for name in self.positions}
        lengths = np.diff(times[first[0] : first[-1] + 1])
        others = {f"{name}_{end}": UNLIMITED for name in self.positions for end in ("limit", "rate")}
        if CURRENT in self.directions:
            others[CURRENT] = integrator.integrator.inputs[CURRENT] + current
        columns = integrator.segments(begin, slopes, first - first[0], inputs, lengths, **others)
        found = {name: tuple(part[:, i] for part in columns) for i, name in enumerate(kept)}
        if COUNTED in found:
            found["psi"] = found[COUNTED]
        else:  # From cosine and sine; it does not jump by 2 pi within a piece.
            (cosine, by_cosine), (sine, by_sine) = found["cos_psi"], found["sin_psi"]
            begun = np.repeat(starts[:, 2], count + 1)
            turned = np.arctan2(sine, cosine) - begun
            slope = cosine[:, None] * by_sine - sine[:, None] * by_cosine
            found["psi"] = begun + turned - 2 * np.pi * np.round(turned / (2 * np.pi)), slope
        states, moved = (np.stack(part, axis=1) for part in zip(*(found[name] for name in STATES), strict=True))
        return states, moved

    def slopes(self, along: np.ndarray, lasting: np.ndarray, inertia: np.ndarray, names: Sequence[str]) -> np.ndarray:
        """Return slopes of the ends of steps by states and by processes, which have names, (n, 6, 6 + m)."""
        # along (n, 6, directions): slopes by ``directions``; lasting (n,) [s]
        found, places = np.zeros((len(along), 6, 6 + len(names))), {name: i for i, name in enumerate(self.directions)}
        found[:, :, :6], known = along[:, :, :6], CURRENT in places
        for place, name in enumerate(names, start=6):
            source = CURRENT if known and name == CURRENTS[0] else name
            if source in places:
                scale = inertia[PUSHES.index(name)] if name in PUSHES else 1.0
                found[:, :, place] = along[:, :, places[source]] * scale
            elif name in CURRENTS and not known:
                found[:, CURRENTS.index(name), place] = lasting
        return found

    def _started(
        self, kept: Sequence[str], starts: np.ndarray, positions: Mapping[str, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        state = dict(zip(STATES, starts.T, strict=True))
        cosine, sine = np.cos(state["psi"]), np.sin(state["psi"])
        state |= {"cos_psi": cosine, "sin_psi": sine, COUNTED: state["psi"], "t": np.zeros(len(starts)), **positions}
        begin = np.stack([state[name] for name in kept], axis=1)
        slopes = np.zeros((len(starts), len(kept), len(self.directions)))
        by = {name: (name, 1.0) for name in STATES} | {name: (OFFSET(name), 1.0) for name in positions}
        by |= {"cos_psi": ("psi", -sine), "sin_psi": ("psi", cosine), COUNTED: ("psi", 1.0)}
        for i, name in enumerate(kept):
            if name in by and by[name][0] in self.directions:
                slopes[:, i, self.directions.index(by[name][0])] = by[name][1]
        return begin, slopes


SWAY, YAW = "Y", "N"
MOST_CORRELATION = 0.995
SPREAD_OF_STRENGTH = 1.5  # Standard deviation of the logarithm of the strength of gusts, before records
# A pilot: noise of the rudder from step to step [rad], its trim [rad], and what an aim that wanders adds [rad]; the aim
# stays for so many times of a ship length. All but the trim are estimated, from these.
HELM_NOISE, TRIM, AIMED, AIM_STAYS = math.radians(1.0), math.radians(5.0), math.radians(2.0), 4.0


class Process(NamedTuple):
    name: str
    adds_to: str  # X, Y, N as accelerations, ``rudder_offset``, ``current_x``, ``psi_error``...
    std: float  # In the unit of what it adds to
    memory: float  # [s]; 0 for white from step to step, infinite for a constant of the record


class Estimated(NamedTuple):
    """A number of the stochastic model that records determine, as a logarithm over its usual value."""

    of: str  # std, memory, noise; or correlation, by its inverse hyperbolic tangent
    names: tuple[str, ...]  # Processes or signals that it belongs to
    spread: float  # Standard deviation before records


@dataclass(frozen=True)
class StochasticModel:
    processes: tuple[Process, ...]
    noise: Mapping[str, float]  # Standard deviation of a reading of each signal
    estimated: tuple[Estimated, ...] = ()
    correlation: float = 0.0  # Correlation of gusts in sway and yaw [1]
    gusts: tuple[str, ...] = ()  # Processes that are gusts

    def at(self, numbers: Sequence[float] | np.ndarray) -> "StochasticModel":
        """Return the model at estimated numbers, each 0 for its usual value."""
        processes, noise, correlation = {one.name: one for one in self.processes}, dict(self.noise), self.correlation
        for (of, names, _), number in zip(self.estimated, np.asarray(numbers).tolist(), strict=True):
            if of == "correlation":
                correlation = MOST_CORRELATION * math.tanh(number)
            factor = math.exp(np.clip(number, -20.0, 20.0))
            for name in names:
                if of == "noise":
                    noise[name] *= factor
                elif of in ("std", "memory"):
                    processes[name] = processes[name]._replace(**{of: getattr(processes[name], of) * factor})
        return replace(self, processes=tuple(processes.values()), noise=noise, correlation=correlation)

    def covariance(self) -> np.ndarray:  # (m, m) Stationary
        std = np.array([one.std for one in self.processes])
        matrix, names = np.diag(std**2), [one.name for one in self.processes]
        if SWAY in names and YAW in names:
            i, j = names.index(SWAY), names.index(YAW)
            matrix[i, j] = matrix[j, i] = self.correlation * std[i] * std[j]
        return matrix

    def kept(self, step: float) -> np.ndarray:  # (m,) Share of each process that remains [1]
        with np.errstate(divide="ignore"):
            return np.asarray(np.exp(-step / np.array([one.memory for one in self.processes])))

    def with_pilot(self, length: float, u: float) -> "StochasticModel":
        """Return the model with gains of each record's pilot, as large as those of a regulator, and an aim."""
        sizes = {"y": 2.0 / length, "psi": 5.0, "v": 5.0 / u, "r": 2.0 * length / u, RUDDER: 0.5}
        gains = [Process(HELM_GAIN(name), HELM_GAIN(name), size, np.inf) for name, size in sizes.items()]
        trim = Process(f"{HELM}_trim", ERROR(HELM), TRIM, np.inf)
        aim = Process(f"{HELM}_aim", ERROR(HELM), AIMED, AIM_STAYS * length / u)
        numbers = [("std", aim.name), ("memory", aim.name), ("noise", HELM)]
        *of_aim, of_helm = (Estimated(of, (name,), SPREAD_OF_STRENGTH) for of, name in numbers)
        # Noise comes last: where the search ends depends a little on the order.
        first = sum(one.of != "noise" for one in self.estimated)
        return replace(
            self, processes=(*self.processes, *gains, trim, aim), noise={**self.noise, HELM: HELM_NOISE},
            estimated=(*self.estimated[:first], *of_aim, *self.estimated[first:], of_helm),
        )  # fmt: skip


@dataclass(frozen=True)
class CoefficientPrior:
    """Normal prior of the coefficients, in units of their standard deviations."""

    model: Model  # Mean and covariance of all coefficients
    groups: tuple[tuple[str, ...], ...]  # Coefficients that are estimated; those of a group are one
    mean: np.ndarray  # (p,) Mean of each group, in its own unit
    scale: np.ndarray  # (p,) Its standard deviation
    precision: np.ndarray  # (p, p) Inverse of the correlation [1]
    bounds: np.ndarray  # (p, 2) Lowest and highest value, in its own unit
    free: np.ndarray  # (p,) Which may change; the others keep mean and covariance

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(group[0] for group in self.groups)

    @cached_property
    def members(self) -> np.ndarray:  # (n, p) 1 where a coefficient belongs to a group
        return np.array([[float(name in group) for group in self.groups] for name in self.model.terms.names])

    @cached_property
    def regression(self) -> np.ndarray:
        """Regression of every coefficient on the estimated ones: ties, and correlations of the prior, (n, p)."""
        places = [self.model.terms.names.index(name) for name in self.names]
        across = np.asarray(self.model.covariance)[:, places] / self.scale @ self.precision / self.scale
        return np.where(self.members.any(axis=1, keepdims=True), self.members, across)

    def values(self, scaled: np.ndarray) -> dict[str, float]:
        numbers = (self.mean + self.scale * scaled).tolist()
        return {name: value for group, value in zip(self.groups, numbers, strict=True) for name in group}

    @property
    def limits(self) -> tuple[np.ndarray, np.ndarray]:
        low, high = ((end - self.mean) / self.scale for end in self.bounds.T)
        return low, high


class Unknowns:
    """Scaled coefficients with their prior, then numbers with independent normal priors of mean 0."""

    prior: CoefficientPrior

    @property
    def spreads(self) -> np.ndarray:
        raise NotImplementedError

    @property
    def count(self) -> int:
        return len(self.prior.groups)

    @cached_property
    def precision(self) -> np.ndarray:
        matrix = np.diag(np.concatenate([np.zeros(self.count), self.spreads**-2.0]))
        matrix[: self.count, : self.count] = self.prior.precision
        return matrix

    def covariance(self, information: np.ndarray) -> np.ndarray:  # (P, P)
        covariance = np.linalg.inv(information + self.precision)
        return np.asarray((covariance + covariance.T) / 2)


KEPT_MOTIONS = 64  # More than the coefficients of a ship, by each of which every record is differentiated


@dataclass(frozen=True)
class LogProblem(Unknowns):
    motion: RecordedMotion  # How the ship moves under its recorded rudder
    prior: CoefficientPrior
    # (3, 1 + p) Inertia in surge, sway and yaw: its constant part [kg, kg, kg m2], then slopes by the coefficients.
    # Disturbances are accelerations: motion determines forces over inertia, so that with a disturbance in newtons the
    # strength of gusts would fix what only mass can.
    inertia: np.ndarray
    model: StochasticModel
    correlated: float = 1.0  # Readings for each independent one
    # Standard deviation of a step over ship lengths and speeds, for rounding alone. At 1e-5 the filter follows a
    # position that is measured to millimetres instead of the model, and the estimated noise vanishes.
    walk: float = 1e-7
    _last: dict[bytes, tuple[RecordedMotion, np.ndarray]] = field(default_factory=dict, init=False, repr=False)

    @property
    def spreads(self) -> np.ndarray:
        return np.array([one.spread for one in self.model.estimated])

    @cached_property
    def scales(self) -> np.ndarray:  # (6,) of x, y, psi, u, v, r
        length, u = self.motion.model.configuration.ship.length, float(self.motion.choices["u"])
        return np.array([length, length, 1.0, u, u, u / length])

    def model_at(self, unknowns: np.ndarray) -> StochasticModel:
        return self.model.at(unknowns[self.count :])

    def at(self, scaled: np.ndarray) -> tuple[RecordedMotion, np.ndarray]:
        key = scaled.tobytes()
        if key not in self._last:  # A motion is prepared once for all records and passes at the same coefficients.
            if len(self._last) == KEPT_MOTIONS:
                self._last.clear()
            motion = self.motion.with_coefficients(self.prior.values(scaled))
            self._last[key] = motion, self.inertia @ [1.0, *(self.prior.mean + self.prior.scale * scaled)]
        return self._last[key]
