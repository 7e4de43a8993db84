"""Contact of a hull with the banks by exact polygons: points of the hull against straight walls, or on the map."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import shapely
from equations import State

import narrows as nw

FINE = 4001
"""Points of a bank's line about a hull, as close as 2 mm for a hull of 5 m."""


class Room(Protocol):
    """How far a hull is from the banks."""

    def closed(self, states: np.ndarray, room: float) -> np.ndarray:
        """Whether many states may have no more room than this [m]; never false where they have none."""

    def room(self, state: State) -> float:
        """Room of one state [m], negative where the hull is in a bank."""

    def side(self, state: State) -> str:
        """The nearer bank."""


def hull_points(model: nw.Model, contact: str | Sequence[Sequence[float]]) -> np.ndarray:
    """Return (forward, starboard) points of the convex hull around a ship, (n, 2) [m]."""
    ship = model.configuration.ship
    if isinstance(contact, str):
        half, beam = ship.length / 2, ship.beam / 2
        contact = [(half, beam), (half, -beam), (-half, -beam), (-half, beam)]
    ring = shapely.convex_hull(shapely.MultiPoint(np.asarray(contact, float)))
    return np.asarray(ring.exterior.coords)[:-1]


class Midship:
    """The paper's clearance: half the width less what midship takes of it."""

    def __init__(self, model: nw.Model, waterway: nw.Waterway | None) -> None:
        self.model, self.waterway = model, waterway

    def _section(self, s: np.ndarray) -> tuple[np.ndarray | float, np.ndarray | float]:
        if self.waterway is None:
            return self.model.configuration.canal.width, 0.0
        here = self.waterway.section(s, self.model.configuration.ship.draft)
        return here.width, here.middle

    def rooms(self, states: np.ndarray) -> np.ndarray:
        s, n, psi = np.moveaxis(np.asarray(states), -1, 0)[:3]
        width, middle = self._section(s)
        return width / 2 - np.abs(n - middle) - self.model.configuration.ship.beam / 2 * np.cos(psi)

    def closed(self, states: np.ndarray, room: float) -> np.ndarray:
        return self.rooms(states) <= room

    def room(self, state: State) -> float:
        return float(self.rooms(state))

    def side(self, state: State) -> str:
        return "starboard" if state[1] > self._section(state[0])[1] else "port"


class Walls:
    """A convex hull between two straight walls: its points reach furthest."""

    def __init__(self, model: nw.Model, points: np.ndarray) -> None:
        self.half, self.points = model.configuration.canal.width / 2, points

    def _reaches(self, states: np.ndarray) -> np.ndarray:
        y, psi = np.asarray(states)[..., 1, None], np.asarray(states)[..., 2, None]
        return y + np.sin(psi) * self.points[:, 0] + np.cos(psi) * self.points[:, 1]

    def rooms(self, states: np.ndarray) -> np.ndarray:
        return np.asarray(self.half - np.abs(self._reaches(states)).max(axis=-1))

    def closed(self, states: np.ndarray, room: float) -> np.ndarray:
        return self.rooms(states) <= room

    def room(self, state: State) -> float:
        return float(self.rooms(state))

    def side(self, state: State) -> str:
        reaches = self._reaches(state)
        return "starboard" if reaches.max() > -reaches.min() else "port"


class OnTheMap:
    """A convex hull on the map between the smooth banks of a waterway, drawn as fine as asked."""

    def __init__(self, model: nw.Model, points: np.ndarray, waterway: nw.Waterway) -> None:
        self.points, self.waterway, self.draft = points, waterway, model.configuration.ship.draft
        self.around = 1.2 * float(np.hypot(*points.T).max())
        self.coarse = self.around / 300
        count = int(waterway.line.length / self.coarse)
        self.lines = [shapely.LineString(bank) for bank in self.banks(np.linspace(0, waterway.line.length, count))]
        for line in self.lines:
            shapely.prepare(line)

    def banks(self, s: np.ndarray) -> list[np.ndarray]:
        """The starboard and the port bank on the map at places, and where their own lines have corners."""
        own = (self.waterway.starboard.s, self.waterway.port.s, *(self.waterway.depths or ())[:1])
        inside = np.concatenate([s, *[np.asarray(k, float)[(k > s[0]) & (k < s[-1])] for k in own]])
        s = np.unique(inside)
        here = self.waterway.section(s, self.draft)
        return [self.waterway.line.at(s, here.middle + sign * here.width / 2) for sign in (1, -1)]

    def hulls(self, states: np.ndarray) -> np.ndarray:
        """The hulls as polygons on the map."""
        s, n, psi = np.moveaxis(np.atleast_2d(states), -1, 0)[:3]
        middle, heading = self.waterway.to_map(s, n, psi)
        ahead = np.stack([np.sin(heading), np.cos(heading)], axis=-1)[:, None]
        right = np.stack([np.cos(heading), -np.sin(heading)], axis=-1)[:, None]
        return shapely.polygons(middle[:, None] + self.points[:, :1] * ahead + self.points[:, 1:] * right)

    def closed(self, states: np.ndarray, room: float) -> np.ndarray:
        """By coarse lines, and what they cut off besides."""
        hulls = self.hulls(states)
        return np.any([shapely.dwithin(line, hulls, room + self.slack) for line in self.lines], axis=0)

    @property
    def slack(self) -> float:
        """More than a chord between two points of the coarse lines cuts off [m]."""
        bend = np.abs(self.waterway.line.curvature(np.linspace(0, self.waterway.line.length, 2000))).max()
        return float(bend) * self.coarse**2

    def _near(self, state: State) -> list[float]:
        low, high = np.clip([state[0] - self.around, state[0] + self.around], 0, self.waterway.line.length)
        hull = self.hulls(state)[0]
        return [_signed(shapely.LineString(bank), hull) for bank in self.banks(np.linspace(low, high, FINE))]

    def room(self, state: State) -> float:
        return min(self._near(state))

    def side(self, state: State) -> str:
        starboard, port = self._near(state)
        return "starboard" if starboard < port else "port"


def _signed(bank: shapely.LineString, hull: shapely.Polygon) -> float:
    """Distance; where the bank is in the hull how deep, below zero."""
    inside = shapely.get_coordinates(shapely.intersection(bank, hull))
    if not len(inside):
        return float(shapely.distance(bank, hull))
    return -float(shapely.distance(shapely.points(inside), hull.exterior).max())


def room_of(model: nw.Model, contact: str | Sequence[Sequence[float]], waterway: nw.Waterway | None) -> Room | None:
    """Return what measures the room of a ship; nothing in open water."""
    if contact == "none":
        return None
    if contact == "midship":
        return Midship(model, waterway)
    points = hull_points(model, contact)
    return Walls(model, points) if waterway is None else OnTheMap(model, points, waterway)
