"""What happens in ten minutes to a ship in a canal: lines to hold, pushes, a bend."""

from dataclasses import dataclass

import numpy as np

import narrows as nw
from narrows.waterway import Bank, Centreline, Waterway

SPEED, DURATION = 4.5, 600
RADIUS, BEND, STEP = 2500.0, (650.0, 1640.0), 10.0
AREA, LEVER = 6000.0, 20.0
"""Of the ship above the water [m2], and of the wind forward of midship [m]."""
Push = tuple[float, float, float, float]


@dataclass(frozen=True)
class Scene:
    """What happens in ten minutes: the lines to hold (time, offset), pushes (from, to, Y, N), where it begins."""

    lines: tuple[tuple[float, float], ...]
    pushes: tuple[Push, ...] = ()
    waterway: Waterway | None = None
    begins: float | None = None

    @property
    def start(self) -> float:
        """The offset at the start: on the first line unless it begins elsewhere."""
        return self.wanted(0.0) if self.begins is None else self.begins

    def wanted(self, t: float) -> float:
        """The offset to hold."""
        return [y for start, y in self.lines if start <= t + 1e-9][-1]

    def push(self, t: float) -> tuple[float, float]:
        """Sway force and yaw moment."""
        acting = [(Y, N) for start, stop, Y, N in self.pushes if start <= t < stop]
        return (sum(Y for Y, _ in acting), sum(N for _, N in acting))

    def forces(self) -> dict[str, list[tuple[float, float]]]:
        """Sway force and yaw moment as ``simulate`` takes them: each from a time on."""
        times = sorted({time for start, stop, *_ in self.pushes for time in (start, stop)})
        each = [(float(time), self.push(time)) for time in times]
        return {name: [(time, push[place]) for time, push in each] for place, name in enumerate("YN") if each}


def bend(model: nw.Model) -> Waterway:
    """Straight on, 990 m of bend to starboard, and straight on."""
    canal, s = model.configuration.canal, STEP * np.arange(500)
    curvature = np.where((s > BEND[0]) & (s < BEND[1]), 1 / RADIUS, 0.0)
    heading = np.cumsum((curvature[1:] + curvature[:-1]) / 2 * STEP) - curvature[1:] * STEP / 2
    way = np.cumsum(STEP * np.stack([np.sin(heading), np.cos(heading)], axis=1), axis=0)
    line = Centreline(np.concatenate([[[0.0, 0.0]], way]))
    ends, half = np.array([0.0, line.length]), np.full(2, canal.width / 2)
    return Waterway(line, Bank("starboard", ends, half), Bank("port", ends, half), (ends, np.full(2, canal.depth)))


def moment_of_rudder(model: nw.Model) -> float:
    """Of a radian [N m], by the linear system."""
    linear = nw.control.linearize(model, y=0.0, u=SPEED)
    turn = linear.states.index("r")
    return float(linear.B[turn, 0] / linear.G[turn, linear.disturbances.index("N")])


def scenes(model: nw.Model, moment: float | None = None) -> dict[str, Scene]:
    """The five scenes of one ship; pushes by the yaw moment of a radian of rudder, the linear system's unless given."""
    moment = moment_of_rudder(model) if moment is None else moment
    gust, storm = nw.wind_force(15.0, AREA), nw.wind_force(18.0, AREA)
    six, five = np.radians(6) * moment, np.radians(5) * moment
    return {
        "offset": Scene(((0.0, 40.0), (60.0, 50.0), (330.0, 40.0))),
        "bank": Scene(((0.0, 50.0),), ((100, 180, 0.0, six), (300, 380, 0.0, -six))),
        "gust": Scene(((0.0, 40.0),), ((100, 160, gust, LEVER * gust), (300, 360, -gust, -LEVER * gust))),
        "bend": Scene(((0.0, 0.0),), (), bend(model)),
        "hard": Scene(((0.0, 65.0),), ((100, 160, storm, LEVER * storm), (250, 310, 0.0, five))),
    }  # fmt: skip
