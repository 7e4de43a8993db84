"""Gains of regulators for many ships at once, each on a course of its own; looser or tighter than the usual."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.codegen.linearisation import LINEARISED
from narrows.control.regulator import LADDER, MEMORY, SETTLES, STROKE, WEIGHTS
from narrows.control.regulator_law import FELT
from narrows.control.riccati import best_gains
from narrows.simulation.ship import SimulatedShip

STATES, (OFF_COURSE, HARD) = ("y", "psi", "v", "r"), LADDER[0]


@dataclass(frozen=True)
class Tightness:
    """How hard a regulator holds its line."""

    offset: float = 1.0  # A half beam over the offset that weighs as much as the usual heading and rudder [1]
    memory: float = MEMORY  # Times of a ship length for which that offset weighs as much [1]
    # Whether it trusts how what a bank does grows as it comes nearer, or takes the ship as drawn as hard at every
    # distance, as ``regulator_gains`` does
    knowing: bool = False


def stacked_gains(
    ship: SimulatedShip, values: Mapping[str, Any], course: Mapping[str, Any], tightness: Tightness
) -> np.ndarray:
    """Return the gains of a regulator for each of many courses, (n, 6), as of ``regulator_gains``."""
    # course [m]
    particulars, gear = ship.model.configuration.ship, ship.model.configuration.gear
    linear = ship.linearisation({**ship.values(), **values})
    matrix = linear.linear({**course, "psi": -np.arctan(course["v"] / course["u"])})
    states, speed = [LINEARISED.index(name) for name in STATES], np.asarray(course["u"], float)
    count, rudder = len(speed), len(LINEARISED) + linear.controlled.index("rudder")
    rows = np.broadcast_to(matrix, (count, *matrix.shape[-2:]))[:, states]
    motion, push = np.zeros((count, len(FELT), len(FELT))), np.zeros((count, len(FELT)))
    motion[:, :4, :4], motion[:, :4, 4] = rows[:, :, states], rows[:, :, rudder]
    motion[:, 5, 0], push[:, 4] = 1.0, 1.0
    # Each state in what weighs as much as the others, and time in ship lengths: the equation is of size 1.
    time, off = particulars.length / speed, particulars.beam / 2 / tightness.offset
    one = np.ones(count)
    size = np.stack(
        [off * one, OFF_COURSE * one, speed, speed / particulars.length, HARD * one, off * tightness.memory * time],
        axis=1,
    )
    rate = HARD / np.maximum(STROKE * time, HARD / gear.rate)
    scaled = time[:, None, None] * motion * size[:, None, :] / size[:, :, None]
    drive, weights = (time * rate)[:, None] * push / size, WEIGHTS
    gains = best_gains(scaled, drive, weights)
    if not tightness.knowing:
        blind = scaled.copy()
        blind[:, :4, 0] = 0.0
        careful = best_gains(blind, drive, weights)
        gains = np.where(holding(scaled, drive, careful)[:, None], careful, gains)
    return np.asarray(gains * rate[:, None] / size)


def holding(motion: np.ndarray, push: np.ndarray, gains: np.ndarray) -> np.ndarray:
    """Return which of many systems gains hold (n,); false where a gain is NaN."""
    # motion (n, k, k); push (n, k); gains (n, k)
    known = np.isfinite(gains).all(axis=1) & np.isfinite(motion).all(axis=(1, 2))
    poles = np.linalg.eigvals(np.where(known[:, None, None], motion - push[:, :, None] * gains[:, None, :], 0.0))
    return np.asarray(known & (poles.real.max(axis=1) < -SETTLES * np.abs(poles).max(axis=1)))
