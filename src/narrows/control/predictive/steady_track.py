"""The course that a plan is drawn to: the steady state that holds the offset, place by place, bends among them.

With it come courses nearer to the middle, for where the offset asks for more rudder than there is.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.codegen.linearisation import LINEARISED
from narrows.control.predictive.line_frame import HELD, RUDDER, line_slopes
from narrows.control.predictive.push_estimate import Push
from narrows.control.predictive.water_ahead import SECTION, WaterAhead, share_of
from narrows.control.steady_course import solved
from narrows.errors import InputError
from narrows.simulation.ship import SimulatedShip

PLACES_A_LENGTH, MOST_PLACES = 2, 4000
# Courses from the offset that is asked for to the middle of the keel's room, both among them.
WAYS = 9
# What does not change on a steady course; psi, v and the rudder see to it.
BALANCED = [LINEARISED.index(name) for name in ("y", "v", "r")]


@dataclass(frozen=True)
class SteadyTrack:
    """Steady courses at places along a line, and nearer and nearer to the middle."""

    places: np.ndarray  # (n,) Along the line [m]
    states: np.ndarray  # (ways, n, 5) y [m], psi [rad], v [m/s], r [rad/s], rudder [rad]
    by_push: np.ndarray  # (ways, n, 5, 2) How they give way to a sway force [N] and a yaw moment [N m]
    force_of: np.ndarray  # (ways, n, 2, 2) The force and moment that an acceleration in sway and yaw takes
    slopes: np.ndarray  # (ways, n, 5, 5) Derivatives of the rates of the state by the state
    # (ways, n) Whether there is a steady course; where there is none, the next one nearer to the middle stands
    known: np.ndarray
    shares: np.ndarray  # (ways, n) Places between the banks, from -1 to 1
    limit: float  # Of the rudder [rad]

    def nearest(self, x: float) -> int:
        """Return the number of the place nearest to one along the line."""
        # x [m]
        if len(self.places) == 1:
            return 0
        step = self.places[1] - self.places[0]
        return int(min(max(round((x - self.places[0]) / step), 0), len(self.places) - 1))

    def held(self, x: float, push: Push, most: float) -> float:
        """Return how far from the offset to the middle, 0 to 1, a rudder no further than ``most`` holds the ship."""
        # x [m]; most [rad]
        place = self.nearest(x)
        pushed, _ = push.at(self.shares[:, place])
        asked = np.abs(self.states[:, place, RUDDER] + (self.by_push[:, place, RUDDER] * pushed).sum(axis=-1))
        asked[~self.known[:, place]] = np.inf
        enough = asked <= most
        if not enough.any():
            return float(asked.argmin()) / (WAYS - 1)
        first = int(enough.argmax())
        if first == 0:
            return 0.0
        more, less = asked[first - 1], asked[first]
        part = (more - most) / (more - less) if np.isfinite(more) else 1.0
        return (first - 1 + float(part)) / (WAYS - 1)

    def at(self, x: np.ndarray, push: Push, way: float = 0.0) -> np.ndarray:
        """Return the steady states at places under a push, (places, 5)."""
        # x (places,) [m]
        row = min(int(way * (WAYS - 1)), WAYS - 2)
        part = way * (WAYS - 1) - row
        states = self.states[row] + part * (self.states[row + 1] - self.states[row])
        nearest = round(way * (WAYS - 1)), self.nearest(float(x[0]))
        given_way = self.by_push[nearest] @ push.at(self.shares[nearest][None])[0][0]
        if len(self.places) == 1:
            there = np.tile(states[0] + given_way, (len(x), 1))
        else:
            position = (x - self.places[0]) / (self.places[1] - self.places[0])
            first = np.minimum(np.maximum(position.astype(int), 0), len(self.places) - 2)
            share = np.minimum(np.maximum(position - first, 0.0), 1.0)[:, None]
            there = states[first] + share * (states[first + 1] - states[first]) + given_way
        there[:, RUDDER] = np.minimum(np.maximum(there[:, RUDDER], -self.limit), self.limit)
        return there


def steady_track(
    ship: SimulatedShip, water: WaterAhead, y: float, u: float, margin: float, positions: Mapping[str, float]
) -> SteadyTrack:
    """Find the steady courses along a line."""
    # y [m]; u [m/s]; margin [m]
    # Where the keel has no room for the offset the course gives way.
    length = ship.model.configuration.ship.length
    count = 1 if water.straight else int(min(max(PLACES_A_LENGTH * water.length / length, 2), MOST_PLACES))
    places = np.linspace(0.0, water.length, count)
    there = water.at(places)
    offset = _with_room(y, there, ship.model.configuration.ship.beam / 2 + margin)
    middle = (there["keel_starboard"] - there["keel_port"]) / 2
    y_held = (offset + np.linspace(0.0, 1.0, WAYS)[:, None] * (middle - offset)).ravel()
    everywhere = {name: np.tile(column, WAYS) for name, column in there.items()}
    states, known = _steady(ship, water, y_held, u, everywhere, positions)
    if not known.any():
        raise InputError(f"no rudder holds this ship {y:g} m off the line at {u:g} m/s; choose a place nearer to it")
    known = known.reshape(WAYS, count)
    states = _from_the_middle(states.reshape(WAYS, count, -1), known)
    flat = states.reshape(WAYS * count, -1)
    parts = _slopes(ship, water, flat, u, everywhere, positions)
    shaped = [part.reshape(WAYS, count, *part.shape[1:]) for part in parts]
    by_push, force_of, slopes = shaped
    shares = share_of(states[:, :, 0], there)
    return SteadyTrack(places, states, by_push, force_of, slopes, known, shares, ship.model.configuration.gear.limit)


def _with_room(y: float, there: Mapping[str, np.ndarray], reach: float) -> np.ndarray:
    """The offset, or the nearest to it that leaves room on both sides; the middle where there is none."""
    starboard, port = there["keel_starboard"] - reach, -(there["keel_port"] - reach)
    return np.where(starboard > port, np.minimum(np.maximum(y, port), starboard), (starboard + port) / 2)


def _steady(
    ship: SimulatedShip, water: WaterAhead, y: np.ndarray, u: float, there: Mapping[str, np.ndarray],
    positions: Mapping[str, float],
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Steady states at offsets, and whether there are any."""
    bend = there["curvature"] / (1 - there["curvature"] * y)
    turning = {"path_curvature": bend, "current": np.full(len(y), water.current)}
    values = {**_values(ship, water, there, positions), **turning}
    v, rudder = solved(ship, {**values, "y": y - there["middle"], "u": np.full(len(y), u)}, len(y), 1)
    psi = -np.arctan(v / u)
    turn = bend * (u * np.cos(psi) - v * np.sin(psi) + water.current)
    known = np.isfinite(rudder)
    return np.stack([y, psi, v, turn, rudder], axis=1), known


def _values(
    ship: SimulatedShip, water: WaterAhead, there: Mapping[str, np.ndarray], positions: Mapping[str, float]
) -> dict[str, Any]:  # fmt: skip
    section = {} if water.straight else {name: there[name] for name in SECTION}
    return {**ship.values(**positions), **section}


def _from_the_middle(states: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Put in for what is not known the drift and rudder of the next course nearer to the middle; none at the worst."""
    filled = states.copy()
    filled[-1, ~known[-1], 1:] = 0.0
    for way in range(WAYS - 2, -1, -1):
        filled[way, ~known[way], 1:] = filled[way + 1, ~known[way], 1:]
    return filled


def _slopes(
    ship: SimulatedShip, water: WaterAhead, states: np.ndarray, u: float, there: Mapping[str, np.ndarray],
    positions: Mapping[str, float],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """How steady states give way to a push, the push that an acceleration takes, and the derivatives of the rates."""
    values = _values(ship, water, there, positions)
    linear = ship.linearisation(values)
    y, psi, v, r, rudder = states.T
    at = {"psi": psi, "u": np.full(len(y), u), "v": v, "r": r, "rudder": rudder, **positions}
    matrix = linear.linear({**at, "y": y - there["middle"]})
    column = len(LINEARISED) + linear.controlled.index("rudder")
    forces = [len(LINEARISED) + linear.controlled.index(name) for name in ("Y_in", "N_in")]
    sought = [LINEARISED.index("psi"), LINEARISED.index("v"), column]
    by_force = matrix[:, BALANCED][:, :, forces]
    by_push = np.zeros((len(y), len(HELD), 2))
    by_push[:, [HELD.index("psi"), HELD.index("v"), RUDDER]] = -np.linalg.solve(
        matrix[:, BALANCED][:, :, sought], by_force
    )
    slopes = line_slopes(matrix, column, {**at, "y": y, "curvature": there["curvature"]}, water.current)
    return by_push, np.linalg.inv(by_force[:, 1:]), slopes
