"""The water along a line, and the motion over an interval of a plan."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from narrows.codegen.cache import compiled_loops
from narrows.codegen.linearisation import LINEARISED
from narrows.control.predictive import plan_loops
from narrows.model.model import Model
from narrows.waterway.current_profile import check_along_only

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
        """Length from end to end [m]; the model's own canal has none."""
        return 0.0 if self.straight else self.step * (len(self.nodes) - 1)

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
        return WaterAhead(np.stack([row, row]), canal.width, straight=True)
    from narrows.waterway.table import tabulate

    waterway.check_fits(ship)
    check_along_only(waterway, "a plan")
    table = tabulate(waterway, ship.draft, waterway.step or ship.beam)
    depth = np.full_like(table.s, own_depth) if np.isnan(table.depth).all() else table.depth
    width, middle = table.starboard + table.port, (table.starboard - table.port) / 2
    current = waterway.reference_current * table.flow
    columns = [width, middle, depth, table.curvature, table.keel_starboard, table.keel_port, current]
    return WaterAhead(np.stack(columns, axis=1), table.step)
