"""The equations of one record, linear about where the search stands: a small matrix a window, and what links windows.

The unknowns of a window are its start and its numbers of the chain; after them, as a border, come what is the same all
through the record, and the coefficients in units of their standard deviations before.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from narrows.codegen.cache import compiled_loops
from narrows.logbook.shooting import window_loops
from narrows.logbook.shooting.log_problem import STEADY, LogProblem
from narrows.logbook.shooting.predicted_signals import (
    CURRENT_X,
    CURRENT_Y,
    PREDICTED,
    RUDDER_OFFSET,
    PredictedSignal,
    SeenStates,
)
from narrows.logbook.shooting.record_grid import RecordGrid
from narrows.logbook.shooting.recorded_motion import CURRENT, PUSHES, RecordedMotion

# Standard deviations of a start where nothing was read of it [m, m, rad, m/s, m/s, rad/s]: none to speak of.
START_SPREAD = np.array([1e4, 1e4, 10.0, 30.0, 30.0, 1.0])


@dataclass(frozen=True)
class RecordUnknowns:
    """What a record has of its own."""

    starts: np.ndarray  # (windows, 6) x, y, psi, u, v, r at the start of each window
    chain: np.ndarray  # (windows, n) Numbers of the chain
    zeros: np.ndarray  # (q,) What is the same all through

    def moved(self, windows: np.ndarray, zeros: np.ndarray, share: float = 1.0) -> "RecordUnknowns":
        """Return them after a step."""
        # windows (windows, 6 + n); zeros (q,)
        starts, chain = self.starts + share * windows[:, :6], self.chain + share * windows[:, 6:]
        return replace(self, starts=starts, chain=chain, zeros=self.zeros + share * zeros)


@dataclass(frozen=True)
class WindowEquations:
    """Readings of a record, linear in its unknowns."""

    hessian: np.ndarray  # (windows, d, d) Squares of slopes over noise, summed over the readings of each window
    gradient: np.ndarray  # (windows, d) Slopes times residuals over noise squared
    cost: float  # Sum of squares of residuals over noise, by Huber beyond the outlier's limit [1]
    residuals: Mapping[str, np.ndarray]  # Read less predicted, by signal
    ends: np.ndarray  # (windows, 6) Where each window ends, carried on by the current
    end_slopes: np.ndarray  # (windows, 6, d) Slopes of that

    def without_coefficients(self, problem: LogProblem) -> "WindowEquations":
        """Return them where the coefficients stay."""
        own = slice(problem.local + len(problem.zeros))
        return replace(
            self, hessian=self.hessian[:, own, own], gradient=self.gradient[:, own],
            end_slopes=self.end_slopes[:, :, own],
        )  # fmt: skip


def window_equations(
    problem: LogProblem, motion: RecordedMotion, scaled: np.ndarray, grid: RecordGrid, own: RecordUnknowns
) -> WindowEquations:
    """Return the equations of a record about its unknowns."""
    # scaled (p,)
    pushes, errors = Pushes.of(problem, scaled, own), _errors(problem, own)
    states, slopes = motion.sailed(
        own.starts, pushes.forces, grid.first, grid.times, grid.positions, pushes.rudder, pushes.current
    )
    along = slopes @ pushes.columns(motion)
    if motion.coefficients:
        along[:, :, problem.local + len(problem.zeros) :] += pushes.by_inertia(motion, slopes, grid.rows)
    size = along.shape[2]
    hessian, gradient = np.zeros((len(grid), size, size)), np.zeros((len(grid), size))
    cost, residuals = 0.0, {}
    for name, read in grid.readings.items():
        seen = _seen(problem, grid, name, states, errors)
        residuals[name] = read.values - seen.value
        weight, part = _weight(problem, residuals[name], problem.noise[name] / np.sqrt(read.counted))
        cost += part
        told = (*_told(problem, seen, len(weight)), weight, residuals[name])
        compiled_loops(window_loops).add_readings(hessian, gradient, along, read.row, read.share, read.window, *told)
    ends, moved = _ends(problem, grid, own, states, along)
    return WindowEquations(hessian, gradient, cost, residuals, ends, moved)


def _ends(
    problem: LogProblem, grid: RecordGrid, own: RecordUnknowns, states: np.ndarray, along: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where windows end over ground and the slopes of that: a current that the motion does not know carries them on."""
    rows = grid.first[1:] + np.arange(len(grid))
    ends, slopes, lasting = states[rows], along[rows], np.diff(grid.times[grid.first])
    for state, place in drifting(problem):
        ends[:, state] += own.zeros[place] * lasting
        slopes[:, state, problem.local + place] += lasting
    return ends, slopes


def drifting(problem: LogProblem) -> tuple[tuple[int, int], ...]:
    """Return the states that a current carries on, each with the place of its speed among the zeros."""
    # There are none where the motion itself knows the current.
    if CURRENT in problem.motion.directions:
        return ()
    zeros = list(problem.zeros)
    return tuple((state, zeros.index(name)) for state, name in enumerate((CURRENT_X, CURRENT_Y)) if name in zeros)


@dataclass(frozen=True)
class Pushes:
    """What pushes a ship in each window, and how that moves with the unknowns."""

    problem: LogProblem  # What is solved for
    inertia: np.ndarray  # (3,) At the coefficients [kg, kg, kg m2]
    rates: np.ndarray  # (windows, 3) Accelerations
    rudder: np.ndarray  # (windows,) How much farther to starboard the rudder is than read [rad]
    current: float  # Along the axis of x [m/s]

    @classmethod
    def of(cls, problem: LogProblem, scaled: np.ndarray, own: RecordUnknowns) -> "Pushes":
        """Return the pushes of where the search stands."""
        # scaled (p,)
        chain = dict(zip(problem.chain.names, own.chain.T, strict=True))
        zeros = dict(zip(problem.zeros, own.zeros.tolist(), strict=True))
        none = np.zeros(len(own.starts))
        rates = [chain.get(name, none) + zeros.get(STEADY(name), 0.0) for name in PUSHES]
        rudder = chain.get(RUDDER_OFFSET, none) + zeros.get(RUDDER_OFFSET, 0.0)
        inertia = problem.inertia.at(problem.prior.mean + problem.prior.scale * scaled)
        return cls(problem, inertia, np.stack(rates, axis=1), rudder, zeros.get(CURRENT_X, 0.0))

    @property
    def forces(self) -> np.ndarray:
        """X, Y [N] and N [N m] of each window, (windows, 3)."""
        return np.asarray(self.rates * self.inertia)

    def columns(self, motion: RecordedMotion) -> np.ndarray:
        """Return what of each direction of the motion goes into each unknown, (directions, d)."""
        directions = motion.directions
        size = dict(zip(PUSHES, self.inertia.tolist(), strict=True))
        size |= {STEADY(name): value for name, value in size.items()}
        names = (*self.problem.chain.names, *self.problem.zeros)
        moved = {STEADY(name): name for name in PUSHES} | {CURRENT_X: CURRENT}
        groups = self.problem.prior.groups if motion.coefficients else ()
        matrix = np.zeros((len(directions), 6 + len(names) + len(groups)))
        matrix[:6, :6] = np.eye(6)
        for place, name in enumerate(names, start=6):
            direction = moved.get(name, name)
            if direction in directions:
                matrix[directions.index(direction), place] = size.get(name, 1.0)
        for place, (group, scale) in enumerate(
            zip(groups, self.problem.prior.scale, strict=False), start=6 + len(names)
        ):
            for member in group:
                matrix[directions.index(member), place] = scale
        return matrix

    def by_inertia(self, motion: RecordedMotion, slopes: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Return how a push of a fixed acceleration moves with coefficients of inertia, (rows, 6, p)."""
        # slopes (rows, 6, directions); rows (rows,)
        first = motion.directions.index(PUSHES[0])
        by_push = slopes[:, :, first : first + len(PUSHES)] * self.rates[rows][:, None, :]
        return np.asarray(by_push @ (self.problem.inertia.by_coefficient * self.problem.prior.scale))


def _errors(problem: LogProblem, own: RecordUnknowns) -> dict[str, np.ndarray | float]:
    """Errors of sensors and the current, as numbers or one a window."""
    errors: dict[str, np.ndarray | float] = dict(zip(problem.zeros, own.zeros.tolist(), strict=True))
    for name, column in zip(problem.chain.names, own.chain.T, strict=True):
        errors[name] = errors.get(name, 0.0) + column
    return errors


def _seen(
    problem: LogProblem, grid: RecordGrid, name: str, states: np.ndarray, errors: Mapping[str, np.ndarray | float]
) -> PredictedSignal:
    """A signal at the times of its readings."""
    read = grid.readings[name]
    share = read.share[:, None]
    there = (1 - share) * states[read.row] + share * states[read.row + 1]
    seen_errors = {key: value[read.window] if isinstance(value, np.ndarray) else value for key, value in errors.items()}
    drifted = np.zeros(1) if CURRENT in problem.motion.directions else read.elapsed
    return PREDICTED[name](SeenStates(there, drifted, seen_errors, grid.record.antenna))


def _weight(problem: LogProblem, residual: np.ndarray, noise: np.ndarray) -> tuple[np.ndarray, float]:
    """By what readings are weighed, and what they cost, by Huber."""
    size, limit = np.abs(residual / noise), problem.outlier
    beyond = size > limit
    weight = np.sqrt(np.where(beyond, limit / np.maximum(size, limit), 1.0)) / noise
    return weight, float(np.sum(np.where(beyond, limit * (2 * size - limit), size**2)))


def _told(problem: LogProblem, seen: PredictedSignal, count: int) -> tuple[np.ndarray, ...]:
    """States and slopes by them, places of other unknowns and slopes by these, as loops ask for them."""
    own = [
        (place, seen.by_error[name])
        for place, name in enumerate((*problem.chain.names, *problem.zeros), start=6)
        if name in seen.by_error
    ]
    parts = []
    for pairs in (seen.by_state.items(), own):
        places, slopes = [place for place, _ in pairs], [np.broadcast_to(slope, count) for _, slope in pairs]
        parts += [np.array(places, np.int64), np.array(slopes, float).reshape(len(places), count)]
    return tuple(parts)
