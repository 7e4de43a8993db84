"""The record beside the model: which way its rudder turns it, and where on the ship its position is measured."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from narrows.control.steady_course import self_propulsion
from narrows.logbook import settings
from narrows.logbook.checking.agreement import Estimates, changes, least_squares, pooled
from narrows.logbook.checking.finding import Examined, Finding
from narrows.simulation.derivative import derivative


class ModelRates(NamedTuple):
    """Accelerations by the model, in open water, where the record has enough information."""

    at: Examined  # The record
    known: np.ndarray  # (n,) Where it does
    state: dict[str, np.ndarray]  # u, v, r there; v by the record where it tells it
    positions: dict[str, np.ndarray]  # Positions of actuators there

    def acceleration(self, place: int, v: np.ndarray | None = None, rudder: float = 1.0) -> np.ndarray:
        """Return an acceleration where it is known, of v, [m/s2], or of r, [rad/s2]."""
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
        """Return the sway velocity through the water of the model for yaw rate and rudder [m/s]."""
        v, small, most = (
            np.zeros(self.known.sum()),
            settings.SWAY_DIFFERENCE * self.at.speed,
            settings.SWAY_STEP * self.at.speed,
        )
        slope = np.full(len(v), -1.0)
        for _ in range(settings.SWAY_ROUNDS):
            slope = (self.acceleration(4, v + small) - self.acceleration(4, v - small)) / (2 * small)
            slope = np.minimum(slope, -1e-3 / self.at.motion.pace)
            v = v - np.clip(self.acceleration(4, v) / slope, -most, most)
        return self.whole(_lagging(v, 1 - np.exp(slope * self.at.motion.dt)))


def rudder_effect(at: Examined, rates: ModelRates) -> Estimates | None:
    """Return how many times the model's the rudder's effect on the yaw rate is; None where it is not told."""
    motion, without = at.motion, rates.acceleration(5, rudder=0.0)
    effect, rest = rates.whole(rates.acceleration(5) - without), rates.whole(without)
    turning = rates.whole(rates.state["r"])
    found = []
    for lengths in settings.RUDDER_WINDOWS:
        windows = motion.windows(lengths)
        expected = motion.integrals(effect, windows)
        change = changes(turning, windows) - motion.integrals(rest, windows)
        if told := least_squares(change, [expected, np.ones(len(expected))]):
            found.append(told)
    return min(found, key=lambda told: told.errors[0], default=None)


def judge_rudder(effects: list[tuple[float, float]], record: str) -> Iterator[Finding]:
    """Yield what is wrong with the rudder's sign or unit, by its effect in one record or in several."""
    # effects (float, float)
    if (told := pooled(effects)) is None:
        return
    effect, error, records = told
    evidence = {"effect": effect, "error": error, "records": float(records)}
    seen = f"the rudder turns the ship by {effect:.2f} +- {1.96 * error:.2f} times what the model says"
    if effect + settings.SURE * error < -settings.LEAST_EFFECT:
        remedy = 'turn its sign ([positive] rudder = "port"): positive turns the bow to starboard'
        yield Finding("rudder's sign", record, seen, remedy, evidence)
    elif effect - settings.SURE * error > settings.MOST_EFFECT:
        yield Finding("rudder's unit", record, seen, "it looks like radians taken as degrees: check its unit", evidence)


def check_antenna(at: Examined, rates: ModelRates) -> Iterator[Finding]:
    """Yield where the position is measured elsewhere on the ship than is said, by how it swings in turns."""
    found = _forward(at, rates)
    if found is None:
        return
    forward, error, said = found.values[0], found.errors[0], at.record.antenna[0]
    if abs(forward - said) > settings.ANTENNA_TOLERANCE * at.length + settings.SURE * error:
        where = "forward" if forward > 0 else "aft"
        yield at.finding(
            "antenna", f"in turns the position swings as that of a point {abs(forward):.3g} +- {1.96 * error:.2g} m "
            f"{where} of midship, and it is said to be {said:g} m forward",
            "give the antenna's place, forward and to starboard of midship",
            {"forward": forward, "error": error, "said": said},
        )  # fmt: skip


def _forward(at: Examined, rates: ModelRates) -> Estimates | None:
    """Return the antenna's distance forward of midship [m], fitted with the surge's size and the current."""
    motion = at.motion
    windows = motion.windows(1.0)
    ahead = np.exp(1j * motion.heading)
    turning, surge = rates.whole(rates.state["r"]), rates.whole(rates.state["u"])
    way = changes(motion.position, windows) - motion.integrals(1j * rates.sway() * ahead, windows)
    drifts = np.full(len(way), motion.dt * (windows[1] - windows[0])[0] if len(way) else 0.0)
    regressors = [
        motion.integrals(1j * turning * ahead, windows), motion.integrals(surge * ahead, windows), drifts, 1j * drifts
    ]  # fmt: skip
    return least_squares(_stacked(way), [_stacked(column) for column in regressors])


def _stacked(column: np.ndarray) -> np.ndarray:
    """Real and imaginary parts, below each other."""
    return np.concatenate([column.real, column.imag])


def _lagging(aim: np.ndarray, share: np.ndarray) -> np.ndarray:
    """A column that makes up a share of what it lags behind at each step."""
    lagging, here = np.empty(len(aim)), aim[0] if len(aim) else 0.0
    for i, (goal, part) in enumerate(zip(aim.tolist(), share.tolist(), strict=True)):
        here += (goal - here) * part
        lagging[i] = here
    return lagging


def model_rates(at: Examined) -> ModelRates | None:
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
