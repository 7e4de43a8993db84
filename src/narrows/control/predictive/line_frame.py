"""Surroundings of a plan: the water along the line, and an unexplained external force."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from narrows.codegen.cache import compiled_loops
from narrows.codegen.linearisation import LINEARISED
from narrows.control.predictive import plan_loops
from narrows.model.model import Model
from narrows.waterway.centreline import check_along_only

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

# State of a plan; the speed is constant, and the rudder's rate is the input.
MOTION = ("x", "y", "psi", "u", "v", "r")
HELD = ("y", "psi", "v", "r", "rudder")
MOVED = [LINEARISED.index(name) for name in HELD[:4]]
RUDDER = HELD.index("rudder")
FORCED = slice(HELD.index("v"), HELD.index("r") + 1)  # States that forces accelerate
# Section of the water in plans, and the corresponding inputs of the terms.
COLUMNS = ("width", "middle", "depth", "curvature", "keel_starboard", "keel_port", "current")
SECTION = ("width", "depth")


def over_interval(slopes: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the effect over a time of a state, exp(A t), and of constant rates: (points, 5, 5) each."""
    # Series to the fifth power: an interval is short compared with the growth of the motion.
    step, unit = slopes * time, np.eye(slopes.shape[-1])
    square = step @ step
    integral = unit + step / 2 + square / 6 + square @ (step / 24 + square / 120)
    return unit + step @ integral, time * integral


@dataclass(frozen=True)
class WaterAhead:
    """Equal cells along the line, linear between their nodes; beyond the ends the section stays constant."""

    nodes: np.ndarray  # (nodes, 7) ``COLUMNS`` at the ends of cells [m, m, m, 1/m, m, m, m/s]
    step: float  # Length of a cell [m]
    straight: bool = False  # True for the model's own canal

    @property
    def length(self) -> float:
        return self.step * (len(self.nodes) - 1)

    def at(self, x: np.ndarray) -> dict[str, np.ndarray]:
        rows, _ = compiled_loops(plan_loops).interpolate(self.nodes, 0.0, self.step, x)
        return dict(zip(COLUMNS, rows.T, strict=True))


def share_of(y: np.ndarray, there: dict[str, np.ndarray]) -> np.ndarray:
    """Return places between the walls: -1 at the port one, 1 at the starboard one."""
    return np.asarray((y - there["middle"]) / (there["width"] / 2))


def water_ahead(model: Model, waterway: "Waterway | None") -> WaterAhead:
    ship, canal = model.configuration.ship, model.configuration.canal
    own_depth = np.nan if canal.depth is None else canal.depth
    if waterway is None:
        values = model.configuration.values()
        walls = [float(values.get(name, canal.width / 2)) for name in ("wall_starboard", "wall_port")]
        row = np.array([canal.width, 0.0, own_depth, 0.0, *walls, 0.0])
        return WaterAhead(np.stack([row, row]), 1.0, straight=True)
    from narrows.waterway.table import tabulate

    waterway.check_fits(ship)
    check_along_only(waterway, "a plan")
    table = tabulate(waterway, ship.draft, waterway.step or ship.beam)
    depth = np.full_like(table.s, own_depth) if np.isnan(table.depth).all() else table.depth
    width, middle = table.starboard + table.port, (table.starboard - table.port) / 2
    current = waterway.reference_current * table.flow
    columns = [width, middle, depth, table.curvature, table.keel_starboard, table.keel_port, current]
    return WaterAhead(np.stack(columns, axis=1), table.step)


# Longest gap between two orders [time constants of the estimate]: keeps its gain below 1.
LONGEST_GAP = 5.0


@dataclass(frozen=True)
class BankSpread:
    """Uncertainty of the bank's force and moment, by the place between the banks."""

    furthest: float  # Range of the table, from the middle, 0, to the wall, 1; constant beyond it
    # (n, 2) One standard deviation, positive for a stronger suction, at equal steps from port to starboard [N, N m]
    forces: np.ndarray

    def at(self, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return force and moment at places between the banks, and their derivatives, (places, 2) each."""
        step = 2 * self.furthest / (len(self.forces) - 1)
        forces, slopes = compiled_loops(plan_loops).interpolate(self.forces, -self.furthest, step, share)
        return forces, slopes


@dataclass(frozen=True)
class Push:
    """Estimate of an external force: a constant sway force and yaw moment, and an error of the bank's strength."""

    # The error of the bank, scaled by the covariance of the coefficients, grows with the offset and changes sign with
    # it; the constant part does not.
    steady: np.ndarray  # (2,) Constant sway force and yaw moment [N, N m]
    strength: np.ndarray  # (2,) Excess of the bank's force and moment over the model's [standard deviations]
    spread: BankSpread  # The standard deviations
    uncertainty: np.ndarray  # (3, 2) Variances of the constant part and of the strength, and their covariance
    noise: np.ndarray  # (2,) Variance of the residual between two steps [N2, N2 m2]

    def at(self, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the force and moment at places between the banks, and their derivative, (places, 2) each [N, N m]."""
        forces, slopes = self.spread.at(share)
        return self.steady + self.strength * forces, self.strength * slopes


def no_push(spread: BankSpread) -> Push:
    return Push(np.zeros(2), np.zeros(2), spread, np.outer([0.0, 1.0, 0.0], np.ones(2)), np.zeros(2))


def update_push(push: Push, residual: np.ndarray, share: float, elapsed: float, time: float) -> Push:
    """Return the estimate after another residual: a Kalman filter of a random walk and a constant, each axis alone."""
    # Muske and Badgwell (2002), Disturbance modeling for offset-free linear model predictive control, Journal of
    # Process Control 12(5), 617-632. The noise is estimated from the residual; the random walk alone would give the
    # filter the requested gain, q = R gain^2 / (1 - gain).
    if not np.isfinite(residual).all():
        return push
    gain = -math.expm1(-min(elapsed / time, LONGEST_GAP))
    slope, (walk, constant, both) = push.spread.at(np.array([share]))[0][0], push.uncertainty
    noise = np.where(push.noise > 0, push.noise + gain * (residual**2 - push.noise), residual**2)
    walk = walk + noise * gain**2 / (1.0 - gain)
    seen = np.stack([walk + slope * both, both + slope * constant])
    total = seen[0] + slope * seen[1] + noise
    weights = np.divide(seen, total, out=np.zeros((2, 2)), where=noise > 0)
    left = walk - weights[0] * seen[0], constant - weights[1] * seen[1], both - weights[0] * seen[1]
    steady, strength = weights * residual
    return Push(push.steady + steady, push.strength + strength, push.spread, np.stack(left), noise)
