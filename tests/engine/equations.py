"""The equations of motion written a second time: an angle for the heading, the terms of the table one by one."""

import math
from collections.abc import Callable

import numpy as np

import narrows as nw

CELLS = 60_000
"""Into which the section of a waterway is cut, linear in each."""
HELD = 1e300
ACCELERATIONS = ("udot", "vdot", "rdot")
FORCES = ("X", "Y", "N")

State = np.ndarray
"""x or s, y or n [m], psi [rad], u, v [m/s], r [rad/s], rudder [rad]."""
Place = tuple[float, float, float, float]
"""Width, middle, depth [m], curvature [1/m]."""


def straight_place(model: nw.Model) -> Callable[[float], Place]:
    """The model's own canal is the same everywhere."""
    canal = model.configuration.canal
    here = (canal.width, 0.0, math.nan if canal.depth is None else canal.depth, 0.0)
    return lambda s: here


def place_along(waterway: nw.Waterway) -> Callable[[float], Place]:
    """Read the section of a waterway from a fine table; curvature jumps at no place that the table would smear."""
    s = np.linspace(0.0, waterway.line.length, CELLS + 1)
    table = np.transpose([*waterway.section(s)]).tolist()
    step = waterway.line.length / CELLS

    def place(at: float) -> Place:
        share = min(max(at / step, 0.0), CELLS)
        cell = min(int(share), CELLS - 1)
        share -= cell
        low, high = table[cell], table[cell + 1]
        return tuple(a + share * (b - a) for a, b in zip(low, high, strict=True))  # type: ignore[return-value]

    return place


class Equations:
    """Rates of the state of a ship under constant forces from outside, its rudder turning steadily."""

    def __init__(
        self, model: nw.Model, *, surge: str = "held", surge_inertia: float | None = None, coriolis: bool = False,
        forces: tuple[float, float, float] = (0.0, 0.0, 0.0), waterway: nw.Waterway | None = None,
    ) -> None:  # fmt: skip
        self.model, self.free, self.surge_inertia, self.forces = model, surge == "free", surge_inertia, forces
        self.place = straight_place(model) if waterway is None else place_along(waterway)
        # The same discharge passes every section: a current times width and depth.
        begin = self.place(0.0)
        self.discharge = 0.0 if waterway is None else waterway.current * begin[0] * self.deep(begin)
        self.own_mass = (model.configuration.ship.mass or 0.0) if coriolis else 0.0
        self.fixed = {**model.configuration.values(), "x": 0.0, "heave": 0.0, **dict.fromkeys(ACCELERATIONS, 0.0)}
        self.terms = [
            [(model.coefficients[term.name], term.regressor, term.inputs) for term in model.terms.forces[force]]
            for force in FORCES
        ]

    @staticmethod
    def deep(place: Place) -> float:
        """Depth, the same everywhere where it is not known [m]."""
        return 1.0 if math.isnan(place[2]) else place[2]

    def rates(self, state: State, turning: float) -> list[float]:
        """Return the time derivatives of the state."""
        try:
            return self._rates(state.tolist(), turning)
        except (OverflowError, ValueError):  # a step across a wall that DOP853 tries, and takes back
            return [math.nan] * len(state)

    def _rates(self, state: list[float], turning: float) -> list[float]:
        s, n, psi, u, v, r, rudder = state
        width, middle, depth, curvature = self.place(s)
        cosine, sine = math.cos(psi), math.sin(psi)
        current = self.discharge / width / self.deep(self.place(s))
        pace = (u * cosine - v * sine + current) / (1 - curvature * n)
        values = {
            **self.fixed, "y": n - middle, "cos_psi": cosine, "sin_psi": sine, "u": u, "v": v, "r": r,
            "cos_rudder": math.cos(rudder), "sin_rudder": math.sin(rudder), "width": width,
        }  # fmt: skip
        if not math.isnan(depth):
            values["depth"] = depth
        return [pace, u * sine + v * cosine, r - curvature * pace, *self.accelerations(values), turning]

    def accelerations(self, values: dict[str, float]) -> list[float]:
        """Solve for udot, vdot, rdot: a free ship is one on whose rig no force is left."""
        X, Y, N = (own + push for own, push in zip(self.sums(values), self.forces, strict=True))
        u, v, r = values["u"], values["v"], values["r"]
        right = (X + self.own_mass * v * r, Y - self.own_mass * u * r, N)
        if not hasattr(self, "compliance"):
            self.compliance = np.linalg.inv(self.mass(values)).tolist()
        return [sum(share * force for share, force in zip(row, right, strict=True)) for row in self.compliance]

    def mass(self, values: dict[str, float]) -> np.ndarray:
        """What the forces on the rig lose for a unit of each acceleration; a held speed has a mass without end."""
        still = self.sums(values)
        moved = [self.sums({**values, name: 1.0}) for name in ACCELERATIONS]
        mass = np.array([[still[i] - moved[j][i] for j in range(3)] for i in range(3)])
        if not self.free:
            mass[0], mass[:, 0], mass[0, 0] = 0.0, 0.0, HELD
        elif self.surge_inertia is not None:
            mass[0, 0] = self.surge_inertia
        return mass

    def sums(self, values: dict[str, float]) -> list[float]:
        """The forces on the rig, term by term."""
        return [
            sum([coefficient * regressor(*[values[name] for name in inputs]) for coefficient, regressor, inputs in own])
            for own in self.terms
        ]


def turning_of(gear: nw.SteeringGear, rudder: float, order: float, h: float) -> float:
    """Return the steady rate [rad/s] that brings a rudder towards an order within a step of length h, or nearer it."""
    wanted = max(-gear.limit, min(gear.limit, order))
    return max(-gear.rate * h, min(gear.rate * h, wanted - rudder)) / h
