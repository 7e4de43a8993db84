"""What the model says that rudder and motion of a record do to it."""

from typing import Any, NamedTuple

import numpy as np

from narrows.control.self_propulsion import self_propulsion
from narrows.logbook.checking.examined import Examined
from narrows.simulation.derivative import derivative

# Of Newton's method for the sway velocity that stays.
ROUNDS = 6
# Of the speed: a step of that, at most.
LARGEST = 0.3
# Of the speed, by which the slope of the sway force is measured.
SMALL = 0.02


class ModelRates(NamedTuple):
    """Accelerations by the model, in open water, where the record tells enough."""

    at: Examined  # The record
    known: np.ndarray  # (n,) Where it does
    state: dict[str, np.ndarray]  # u, v, r there; v by the record where it tells it
    positions: dict[str, np.ndarray]  # Of actuators there

    def acceleration(self, place: int, v: np.ndarray | None = None, rudder: float = 1.0) -> np.ndarray:
        """Return an acceleration where it is known, of v, [m/s2], or of r, [rad/s2]."""
        # v [m/s]
        positions: dict[str, Any] = {**self.positions, "rudder": rudder * self.positions["rudder"]}
        state = self.state if v is None else {**self.state, "v": v}
        rates: np.ndarray = derivative(self.at.model.in_open_water(), state, **positions)[place]
        return rates

    def whole(self, values: np.ndarray) -> np.ndarray:
        """Return a column at all times, NaN where nothing is known."""
        column = np.full(len(self.known), np.nan)
        column[self.known] = values
        return column

    def sway(self) -> np.ndarray:
        """Return the sway velocity through the water that the model says to go with yaw rate and rudder [m/s]."""
        v, small, most = np.zeros(self.known.sum()), SMALL * self.at.speed, LARGEST * self.at.speed
        slope = np.full(len(v), -1.0)
        for _ in range(ROUNDS):
            slope = (self.acceleration(4, v + small) - self.acceleration(4, v - small)) / (2 * small)
            slope = np.minimum(slope, -1e-3 / self.at.motion.pace)
            v = v - np.clip(self.acceleration(4, v) / slope, -most, most)
        return self.whole(_lagging(v, 1 - np.exp(slope * self.at.motion.dt)))


def _lagging(aim: np.ndarray, share: np.ndarray) -> np.ndarray:
    """A column that makes up a share of what it lags behind at each step."""
    lagging, here = np.empty(len(aim)), aim[0] if len(aim) else 0.0
    for i, (goal, part) in enumerate(zip(aim.tolist(), share.tolist(), strict=True)):
        here += (goal - here) * part
        lagging[i] = here
    return lagging


def model_rates(at: Examined) -> ModelRates | None:
    """Return what the model says of a record; None where one of them tells too little."""
    motion, turning = at.motion, at.turning
    steered = any(own.name == "rudder" for own in at.model.terms.actuators)
    if turning is None or "rudder" not in motion or not steered or not np.isfinite(motion.position).any():
        return None
    ground = np.gradient(motion.position, motion.dt) * np.exp(-1j * motion.heading)
    u = next((motion[name] for name in ("u", "u_ground") if name in motion), ground.real)
    v = next((motion[name] for name in ("v", "v_ground") if name in motion), ground.imag)
    columns = {"u": u, "v": v, "r": turning, "rudder": motion["rudder"], **_propulsion(at)}
    known = np.isfinite(list(columns.values())).all(axis=0) & (u > 0)
    if not known.any():
        return None
    kept = {name: column[known] for name, column in columns.items()}
    state = {name: kept.pop(name) for name in ("u", "v", "r")}
    return ModelRates(at, known, state, kept)


def _propulsion(at: Examined) -> dict[str, np.ndarray]:
    """Revolutions, those of a steady course at the usual speed where they were not measured."""
    if "revolutions" not in at.model.terms.inputs:
        return {}
    if "revolutions" in at.motion:
        return {"revolutions": at.motion["revolutions"]}
    return {"revolutions": np.full(len(at.motion.t), self_propulsion(at.model.in_open_water(), at.speed))}
