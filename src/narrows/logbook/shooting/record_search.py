"""What a record has of its own, at its best where the coefficients stay: a damped Gauss-Newton search."""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from narrows.logbook.shooting.bordered_band import BorderedBand, Eliminated
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.record_grid import Readings, RecordGrid
from narrows.logbook.shooting.recorded_motion import RecordedMotion
from narrows.logbook.shooting.window_equations import RecordUnknowns, WindowEquations, window_equations
from narrows.logbook.shooting.window_links import WindowLinks, banded

# Steps of the search, and shares of a step that are tried.
STEPS, SHRINKS = 8, 6

# By which a share that does not help is made smaller.
LEAST_SHRUNK, MOST_SHRUNK = 0.1, 0.6

# Of a sum of squares, less than which a step need not gain.
SETTLED = 0.005


@dataclass(frozen=True)
class FollowingUnknowns:
    """How what a record has of its own follows the coefficients, at its best."""

    windows: np.ndarray  # (windows, m, p) Of the windows
    zeros: np.ndarray  # (q, p) Of what is the same all through

    def moved(self, own: RecordUnknowns, step: np.ndarray) -> RecordUnknowns:
        """Return what a record has of its own where the coefficients are a step on."""
        # step (p,)
        return own.moved(self.windows @ step, self.zeros @ step)


@dataclass(frozen=True)
class RecordPlace:
    """A record where the search for its best stands, or at its best."""

    own: RecordUnknowns  # What it has of its own
    found: WindowEquations  # Of its readings, there
    band: BorderedBand  # The normal equations, there
    coefficients: bool  # Whether the coefficients are among their unknowns: they are dear

    @cached_property
    def eliminated(self) -> Eliminated:
        """The equations without the windows."""
        return self.band.eliminated()

    @cached_property
    def left(self) -> Eliminated:
        """Of its equations, the coefficients alone, where they are among them."""
        return self.eliminated.without(len(self.own.zeros))

    @property
    def follows(self) -> FollowingUnknowns:
        """How what it has of its own follows the coefficients, to the first order."""
        return FollowingUnknowns(*self.eliminated.followed(len(self.own.zeros)))


def record_best(
    problem: LogProblem, motion: RecordedMotion, scaled: np.ndarray, grid: RecordGrid, own: RecordUnknowns,
    links: WindowLinks | None, near: bool = False,
) -> RecordPlace | None:  # fmt: skip
    """Return a record at its best for coefficients, None where the motion goes to infinity."""
    # scaled (p,)

    def at(there: RecordUnknowns, coefficients: bool = False) -> RecordPlace:
        with np.errstate(all="ignore"):  # A motion that runs away is noticed by its cost, or by its equations.
            found = window_equations(problem, motion if coefficients else motion.of_records, scaled, grid, there)
            return RecordPlace(there, found, banded(problem, grid, there, found, links), coefficients)

    try:
        return _best(at, at(own, near))
    except np.linalg.LinAlgError:
        return None


class PlaceAt(Protocol):
    """The equations of a record at a place, with slopes by the coefficients or without."""

    def __call__(self, there: RecordUnknowns, coefficients: bool = False) -> RecordPlace:
        """Return them."""


def _best(at: PlaceAt, place: RecordPlace) -> RecordPlace:
    if not np.isfinite(place.band.cost):
        raise np.linalg.LinAlgError("the motion goes to infinity")
    for _ in range(STEPS):
        moved = _moved(at, place)
        if moved is None:
            break
        place = moved
    best = place if place.coefficients else at(place.own, coefficients=True)
    if not np.isfinite(best.left.cost):  # Here, where equations that cannot be solved are caught.
        raise np.linalg.LinAlgError("the motion goes to infinity")
    return best


def _moved(at: PlaceAt, place: RecordPlace) -> RecordPlace | None:
    """A step on, or the share of it that helps; None where nothing is to be gained."""
    inner, zeros_count = place.eliminated, len(place.own.zeros)
    gain = place.band.cost - place.left.cost
    if gain < SETTLED:
        return None
    zeros = np.linalg.solve(inner.corner[:zeros_count, :zeros_count], inner.right[:zeros_count])
    windows, share = inner.windows(zeros), 1.0
    for _ in range(SHRINKS):
        after = at(place.own.moved(windows, zeros, share))
        if after.band.cost < place.band.cost:
            return after
        share = _shrunk(share, gain, after.band.cost - place.band.cost)
    return None


def _shrunk(share: float, gain: float, rise: float) -> float:
    """Where a parabola through what is known along a step has its lowest point."""
    bent = rise + 2 * gain * share
    best = gain * share**2 / bent if np.isfinite(bent) else 0.0
    return float(np.clip(best, LEAST_SHRUNK * share, MOST_SHRUNK * share))


# Where a search begins: what a record says of the states itself, smoothed.
# That are averaged.
NODES = 9

# Readings among which the middle one is taken.
SPIKES = 5


def first_guess(problem: LogProblem, grid: RecordGrid) -> RecordUnknowns:
    """Return starts from the record itself, nothing of the chain, no zeros."""
    place = {name: _at_nodes(grid, read) for name, read in grid.readings.items() if len(read.values)}
    x, y = (smoothed(place[name]) if name in place else np.zeros(len(grid.times)) for name in ("x", "y"))
    along, across = np.gradient(x, grid.times), np.gradient(y, grid.times)
    psi = smoothed(place["psi"]) if "psi" in place else np.unwrap(np.arctan2(across, along))
    cosine, sine = np.cos(psi), np.sin(psi)
    guessed = {
        "u": along * cosine + across * sine,
        "v": across * cosine - along * sine,
        "r": np.gradient(psi, grid.times) + along * _curvature(problem, x),
    }
    for name, others in (("u", ("u", "u_ground", "speed_over_ground")), ("v", ("v", "v_ground")), ("r", ("r",))):
        guessed[name] = next((smoothed(place[other]) for other in others if other in place), guessed[name])
    states = np.stack([x, y, psi, guessed["u"], guessed["v"], guessed["r"]], axis=1)[grid.first[:-1]]
    return RecordUnknowns(states, np.zeros((len(grid), len(problem.chain.names))), np.zeros(len(problem.zeros)))


def _curvature(problem: LogProblem, x: np.ndarray) -> np.ndarray | float:
    """Of the waterway's line, which turns under a heading that is told to it."""
    waterway = problem.motion.choices.get("waterway")
    if waterway is None:
        return 0.0
    return np.asarray(waterway.section(np.clip(x, 0.0, waterway.line.length)).curvature)


def _at_nodes(grid: RecordGrid, read: Readings) -> np.ndarray:
    """Readings at the nodes, straight between them, spikes cut off."""
    from scipy.ndimage import median_filter

    t = grid.times[grid.first[read.window]] + read.elapsed
    return np.asarray(np.interp(grid.times, t, median_filter(read.values, SPIKES, mode="nearest")))


def smoothed(column: np.ndarray, nodes: int = NODES) -> np.ndarray:
    """Return means of a few nodes, straight on at the ends."""
    # column (n,)
    width = min(nodes, len(column) // 2 * 2 - 1)
    if width < 3:
        return column
    padded = np.pad(column, width // 2, mode="reflect", reflect_type="odd")
    return np.convolve(padded, np.ones(width) / width, "valid")
