"""Consistency of an estimator: its errors compared with its own covariance, on simulated twins with known truth.

Source: Bar-Shalom, Li and Kirubarajan (2001), Estimation with applications to tracking and navigation, section 5.4.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.special import chdtri

from narrows.base.errors import InputError, check_count
from narrows.base.results import BaseResult
from narrows.control.closed_loop import LawOrders
from narrows.control.regulator import regulator
from narrows.estimation.estimator import Estimator
from narrows.estimation.sensors import Sensor, draw_reading
from narrows.estimation.settings import CONFIDENCE, SETTLING_TIME, TWIN_SIDE_TIME, TWIN_START_STD
from narrows.estimation.ship_filter import ShipFilter
from narrows.estimation.states import Columns, Estimate, Gaussian, described
from narrows.model.model import Model
from narrows.quantities.names import GRAVITY
from narrows.simulation.controllers import ControlLaw
from narrows.simulation.grid import sampled
from narrows.simulation.initial_state import voyage_defaults
from narrows.simulation.inputs import check_steps
from narrows.simulation.kernel_run import RUDDER, ShipLanes

if TYPE_CHECKING:
    import pandas as pd

    from narrows.waterway.waterway import Waterway

Readings = dict[str, Any]
# Takes the time and the readings, and returns faulty readings.
Fault = Callable[[float, Readings], Readings]


@dataclass(frozen=True, repr=False, eq=False)
class Consistency(BaseResult):
    """Errors of an estimate on twins, compared with its own covariance; NaN where there was no estimate."""

    t: np.ndarray  # (times,) Time [s]
    error: np.ndarray  # (twins, times, states) Estimate less truth
    std: np.ndarray  # (twins, times, states) Standard deviations of the estimate
    nees: np.ndarray  # (twins, times) Squared error over its covariance, for all states together [1]
    nis: dict[str, np.ndarray]  # (twins, times) Normalised innovation squared of each sensor; NaN without a reading
    refused: dict[str, np.ndarray]  # (twins, times) True if a gate refused a reading of the sensor
    suspected: dict[str, np.ndarray]  # (twins, times) True if the innovations of the sensor are biased
    numbers: dict[str, int]  # Number of components of each sensor
    states: tuple[str, ...]
    settled: float  # Start of the statistics [s]
    aground: int  # Number of twins that met a bank; they are left out
    notes: tuple[str, ...]  # Notes on validity

    @property
    def counted(self) -> np.ndarray:
        """Times that count."""
        return np.asarray(self.t >= self.settled)

    @property
    def mean_nees(self) -> float:
        """Mean NEES over the number of states [1]: 1 for a consistent estimate."""
        return float(np.nanmean(self.nees[:, self.counted]) / len(self.states))

    def bounds(self) -> tuple[float, float]:
        """Return the chance bounds of the mean NEES of all twins at one time, over the number of states [1]."""
        freedom, tail = len(self.nees) * len(self.states), (1 - CONFIDENCE) / 2
        return float(chdtri(freedom, 1 - tail) / freedom), float(chdtri(freedom, tail) / freedom)

    @property
    def within(self) -> float:
        """Share of the times at which the mean NEES of all twins lies within its bounds [1]; 0.95 by chance."""
        low, high = self.bounds()
        mean = np.nanmean(self.nees[:, self.counted], axis=0) / len(self.states)
        return float(np.mean((low <= mean) & (mean <= high)))

    @property
    def mean_nis(self) -> dict[str, float]:
        """Mean NIS of each sensor over its numbers [1]."""
        return {name: float(np.nanmean(nis[:, self.counted]) / self.numbers[name]) for name, nis in self.nis.items()}

    @property
    def rmse(self) -> dict[str, float]:
        """Root of the mean squared error of each state."""
        squared = np.nanmean(self.error[:, self.counted] ** 2, axis=(0, 1))
        return dict(zip(self.states, np.sqrt(squared).tolist(), strict=True))

    @property
    def covered(self) -> dict[str, float]:
        """Share of the errors of each state within the band of 95 % [1]."""
        sizes = (np.abs(self.error) / self.std)[:, self.counted]
        shares = (sizes <= 1.959964).sum(axis=(0, 1)) / np.isfinite(sizes).sum(axis=(0, 1))
        return dict(zip(self.states, shares.tolist(), strict=True))

    def summary(self) -> str:
        low, high = self.bounds()
        count, n = len(self.nees), len(self.states)
        nis = ", ".join(f"{name} {value:.2f}" for name, value in self.mean_nis.items())
        rmse = ", ".join(f"{name} {value:.2g} {described(name)[0]}" for name, value in self.rmse.items())
        lines = [
            f"NEES of {n} states over {n} on {count} twins: mean {self.mean_nees:.2f}.",
            f"At {self.within:.0%} of the times its mean lies within {low:.2f} to {high:.2f}; by chance it is 95 %.",
            f"NIS over its numbers: {nis}.",
            f"Root mean square errors: {rmse}.",
        ]
        if self.aground:
            lines.append(f"{self.aground} twins met a bank and are left out.")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        names = ("mean_nees", "within", "mean_nis", "rmse", "covered", "settled", "aground", "states")
        more = {"bounds": self.bounds(), "twins": len(self.nees), "summary": self.summary(), "notes": list(self.notes)}
        return {name: getattr(self, name) for name in names} | more

    def to_dataframe(self) -> "pd.DataFrame":
        """Return one row per state: unit, root mean square error, share within the band of 95 %."""
        import pandas as pd

        units = {name: described(name)[0] for name in self.states}
        columns = {"unit": units, "rmse": self.rmse, "covered": self.covered}
        return pd.DataFrame(columns, index=pd.Index(self.states, name="state"))


class Twins(NamedTuple):
    t: np.ndarray  # (times,) Time [s]
    states: np.ndarray  # (times, twins, states) The truth
    indicated: np.ndarray  # (times, twins, actuators) Indicated positions of the actuators
    readings: dict[str, np.ndarray]  # (times, twins, numbers) Readings of each sensor; NaN where none was due
    aground: np.ndarray  # (twins,) True if a twin met a bank

    def rows(self, twin: int, actuators: Sequence[str]) -> Iterator[tuple[float, Readings]]:
        for number, t in enumerate(self.t.tolist()):
            due = {name: columns[number, twin] for name, columns in self.readings.items()}
            positions = dict(zip(actuators, self.indicated[number, twin], strict=True))
            yield t, {name: reading for name, reading in due.items() if np.isfinite(reading).all()} | positions


def consistency(
    model: Model, sensors: Sequence[Any], y: float = 0.0, u: float | None = None, *, twins: int = 40,
    duration: float = 600.0, drawn: bool = False, seed: int = 0, x: float = 0.0, controller: ControlLaw | None = None,
    excitation: float = math.radians(3.0), fault: Fault | None = None, waterway: "Waterway | None" = None,
    **filtering: Any,
) -> Consistency:  # fmt: skip
    """Test an estimator on twins: simulated ships with known truth.

    Parameters
    ----------
    model, sensors, waterway, **filtering : Model, sequence of Sensor and RudderIndicator, Waterway, Any
        As for ``Estimator``; the model has a rudder unless the given controller needs none.
    x, y, u : float [m], [m], [m/s]
        Start along the waterway, offset and speed of the twins; the speed is that of ``simulate`` unless given.
    twins, duration, seed : int, float [s], int
        Number of twins, duration of each, and seed of all random numbers.
    drawn : bool
        True: each twin has coefficients drawn from the covariance of the fit, to test the estimate under model error.
    controller : ControlLaw, optional
        Unless given, the regulator of this offset and speed in the model's own canal.
    excitation : float [rad]
        Alternating rudder added to the orders, so that the motion carries information.
    fault : callable, optional
        Takes time and readings and returns faulty readings: a jump, an outage, a spoof.
    """
    check_count("twins", twins, 1)
    check_count("seed", seed)
    if controller is not None and not isinstance(controller, ControlLaw):
        raise InputError(f"a {type(controller).__name__} is no law in arithmetic; give one, such as Autopilot")
    check_steps(duration, 1.0, math.inf)
    u = voyage_defaults(model).speed if u is None else u
    first, psi = Estimator(model, sensors, waterway=waterway, **filtering), 0.0
    if controller is None:
        controller = regulator(model, y, u)
        psi = float(controller.lines[0].psi)
    truth = sail_twins(first.filter, controller, (x, y, u, psi), twins, duration, drawn, excitation, seed)
    afloat = np.flatnonzero(~truth.aground)
    if not len(afloat):
        raise InputError("every twin ran aground; choose an offset and a speed at which the controller holds the ship")
    settled = min(SETTLING_TIME * first.filter.time_scale, duration / 2)
    names, found = first.filter.states.names, list[list[Estimate]]()
    for twin in afloat.tolist():
        first.forget()
        rows = truth.rows(twin, first.filter.actuators)
        found.append([first.update(t, fault(t, readings) if fault else readings) for t, readings in rows])
    unknown = Gaussian(np.full(len(names), np.nan), np.full((len(names), len(names)), np.nan))
    normals = [[one.normal if one.normal and one.ready else unknown for one in own] for own in found]
    error = np.array([[one.mean for one in own] for own in normals]) - truth.states[:, afloat].swapaxes(0, 1)
    error[..., 2] -= 2 * np.pi * np.round(error[..., 2] / (2 * np.pi))
    covariance = np.array([[one.covariance for one in own] for own in normals])
    nees = (error * np.linalg.solve(covariance, error[..., None])[..., 0]).sum(axis=-1)
    known = first.filter.sensors
    nis = {name: np.array([[one.nis.get(name, np.nan) for one in own] for own in found]) for name in known}
    refused, suspected = (
        {name: np.array([[name in getattr(one, kind) for one in own] for own in found]) for name in known}
        for kind in ("refused", "suspects")
    )
    return Consistency(
        truth.t, error, np.sqrt(np.diagonal(covariance, axis1=2, axis2=3)), nees, nis, refused, suspected,
        {name: len(sensor.fields) for name, sensor in known.items()}, names, settled,
        int(truth.aground.sum()), first.notes,
    )  # fmt: skip


def sail_twins(
    filter: ShipFilter, law: ControlLaw, start: tuple[float, float, float, float], count: int, duration: float,
    drawn: bool, excitation: float, seed: int,
) -> Twins:  # fmt: skip
    """Simulate ships from x, y, u, psi by the model, with the process noise of the estimator."""
    random, coefficients = np.random.default_rng(seed), np.tile(filter.middle, (max(count, 2), 1))
    if drawn:
        columns = sampled(filter.model, len(coefficients), seed)
        coefficients = np.stack([columns[name].to_numpy() for name in filter.model.terms.names], axis=1)
    lanes = ShipLanes(filter.ship, filter.states.names, len(coefficients), filter.waterway, coefficients)
    dt = min(sensor.period for sensor in filter.sensors.values())
    times = dt * np.arange(math.floor(duration / dt + 1e-9) + 1)
    helm = LawOrders(filter.model, law, dt, filter.waterway)
    process = replace(filter, coefficients="certain").disturbances
    parts = max(1, math.ceil(dt / filter.step - 1e-9))
    current = float(filter.waterway.current_at(start[0])) if filter.waterway else 0.0
    means = filter.states.vector({**dict(zip(("x", "y", "u", "psi"), start, strict=True)), "current": current})
    spreads = {**filter.spreads, "y": TWIN_START_STD[0] * filter.time_scale**2, "psi": TWIN_START_STD[1]}
    size = np.array([spreads.get(name, 0.0) for name in filter.states.names])
    states = [means + size * random.standard_normal((lanes.lanes, len(size)))]
    indicated = [np.tile(filter.at_rest, (lanes.lanes, 1))]
    aground = np.zeros(lanes.lanes, bool)
    for t in times[:-1].tolist():
        now, before = states[-1], indicated[-1]
        after = _positions(filter, helm, excitation, t, now, before)
        for part in range(parts):
            here, there = (before + share * (after - before) for share in (part / parts, (part + 1) / parts))
            now = lanes.advance(now, dt / parts, here, there)
            aground |= lanes.aground
            now = process.after(now, dt / parts, random)
        states.append(now)
        indicated.append(after)
    truth, noisy = np.array(states), np.array(indicated)
    if RUDDER in filter.actuators:
        noisy[..., filter.actuators.index(RUDDER)] += filter.indicator.noise * random.standard_normal(noisy.shape[:2])
    sailed = lanes, filter, times, truth, random
    readings = {name: _readings(sensor, *sailed)[:, :count] for name, sensor in filter.sensors.items()}
    return Twins(times, truth[:, :count], noisy[:, :count], readings, aground[:count])


def _positions(
    filter: ShipFilter, law: LawOrders, excitation: float, t: float, states: np.ndarray, before: np.ndarray
) -> np.ndarray:
    """Return the positions of the actuators a step later: orders of a law, with a swing to either side."""
    after, names, gear = before.copy(), filter.actuators, filter.model.configuration.gear
    if RUDDER not in names:
        return after
    side = TWIN_SIDE_TIME * math.sqrt(filter.model.configuration.ship.length / GRAVITY)
    place, turn, reach = names.index(RUDDER), int(t / side), gear.rate * law.dt
    known = dict(zip((*filter.states.names, *names), (*states.T, *before.T), strict=True))
    swing = excitation * (turn % 2 * 2 - 1) * (turn % 3 == 0)
    order = np.clip(law.orders(t, known)[RUDDER] + swing, -gear.limit, gear.limit)
    after[:, place] += np.clip(order - before[:, place], -reach, reach)
    return after


def _readings(
    sensor: Sensor, lanes: ShipLanes, filter: ShipFilter, times: np.ndarray, states: np.ndarray,
    random: np.random.Generator,
) -> np.ndarray:  # fmt: skip
    """Readings of a sensor by time of arrival, from the state when measured, linear between the times."""
    readings, dt = np.full((*states.shape[:2], len(sensor.fields)), np.nan), times[1] - times[0]
    for number in range(0, len(times), max(1, round(sensor.period / dt))):
        if times[number] < sensor.delay:
            continue
        measured = (times[number] - sensor.delay) / dt
        before = min(int(measured), len(times) - 2)
        then = states[before] + (measured - before) * (states[before + 1] - states[before])
        at = Columns(then, filter.states, lanes.bend(float(then[0, 0])))
        readings[number] = np.stack(draw_reading(sensor, at, vars(at), random), axis=1)
    return readings
