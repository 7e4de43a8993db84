"""Consistency of an estimator: its errors compared with its own covariance, on simulated twins with known truth.

References
----------
Bar-Shalom, Li and Kirubarajan (2001), Estimation with applications to tracking and navigation, section 5.4.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.aliases import accept_aliases
from narrows.codegen.choices import STAGES
from narrows.control.closed_loop import LawOrders
from narrows.errors import InputError, check_count
from narrows.estimation.estimator import Estimator
from narrows.estimation.sensors import Sensor, drawn_reading
from narrows.estimation.settings import (
    CONFIDENCE,
    REFERENCE_LENGTH,
    SETTLING_TIME,
    STEPS_A_PERIOD,
    TWIN_SIDE_TIME,
    TWIN_START_STD,
)
from narrows.estimation.ship_filter import ShipFilter, default_step
from narrows.estimation.states import Columns, described
from narrows.model.model import Model
from narrows.physics.rudder import gear_motion
from narrows.quantities.arithmetic import COLUMNS
from narrows.results import BaseResult
from narrows.simulation.controllers import ControlLaw
from narrows.simulation.grid import sampled
from narrows.simulation.ship_lanes import RUDDER, ShipLanes

if TYPE_CHECKING:
    import pandas as pd
    import xarray

    from narrows.waterway.waterway import Waterway

Readings = dict[str, Any]
# Takes the time and the readings, and returns faulty readings.
Fault = Callable[[float, Readings], Readings]


@dataclass(frozen=True, repr=False, eq=False)
class Consistency(BaseResult):
    """Errors of an estimate on twins, compared with its own covariance.

    Parameters
    ----------
    t : array (times,) [s]
        Time.
    error : array (twins, times, states)
        Estimate less truth; NaN where there was no estimate.
    std : array (twins, times, states)
        Standard deviations of the estimate.
    nees : array (twins, times) [1]
        Squared error over its covariance, for all states together.
    nis : dict of str to array (twins, times) [1]
        Normalised innovation squared of each sensor; NaN without a reading.
    refused, suspected : dict of str to array (twins, times) of bool
        True if a gate refused a reading, and if a sensor's innovations are biased.
    numbers : dict of str to int
        Number of components of each sensor.
    states : tuple of str
        Names of the states.
    settled : float [s]
        Start of the statistics.
    aground : int
        Number of twins that met a bank; they are left out.
    notes : tuple of str
        Notes on validity.
    """

    t: np.ndarray
    error: np.ndarray
    std: np.ndarray
    nees: np.ndarray
    nis: dict[str, np.ndarray]
    refused: dict[str, np.ndarray]
    suspected: dict[str, np.ndarray]
    numbers: dict[str, int]
    states: tuple[str, ...]
    settled: float
    aground: int
    notes: tuple[str, ...]

    @property
    def counted(self) -> np.ndarray:
        """Times that count."""
        return np.asarray(self.t >= self.settled)

    @property
    def mean_nees(self) -> float:
        """Mean NEES over the number of states [1]: 1 for a consistent estimate."""
        return float(np.nanmean(self.nees[:, self.counted]) / len(self.states))

    @property
    def median_nees(self) -> float:
        """Median NEES over the median of chi-squared [1]."""
        from scipy.stats import chi2

        return float(np.nanmedian(self.nees[:, self.counted]) / chi2.median(len(self.states)))

    def bounds(self, count: int | None = None) -> tuple[float, float]:
        """Return the chance bounds of the mean NEES of all twins at one time, over the number of states [1].

        Parameters
        ----------
        count : int, optional
            Number of components; the number of states unless given.
        """
        from scipy.stats import chi2

        freedom = len(self.nees) * (count or len(self.states))
        tail = (1 - CONFIDENCE) / 2
        return float(chi2.ppf(tail, freedom) / freedom), float(chi2.isf(tail, freedom) / freedom)

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
        inside = np.abs(self.error) <= 1.959964 * self.std
        known = np.isfinite(self.error)
        shares = (inside & known)[:, self.counted].sum(axis=(0, 1)) / known[:, self.counted].sum(axis=(0, 1))
        return dict(zip(self.states, shares.tolist(), strict=True))

    def summary(self) -> str:
        """Compare the errors with the estimate's own covariance."""
        low, high = self.bounds()
        count, n = len(self.nees), len(self.states)
        nis = ", ".join(f"{name} {value:.2f}" for name, value in self.mean_nis.items())
        rmse = ", ".join(f"{name} {value:.2g} {described(name)[0]}" for name, value in self.rmse.items())
        lines = [
            f"NEES of {n} states over {n} on {count} twins: mean {self.mean_nees:.2f}, median over that of chi-squared "
            f"{self.median_nees:.2f}.",
            f"At {self.within:.0%} of the times its mean lies within {low:.2f} to {high:.2f}; by chance it is 95 %.",
            f"NIS over its numbers: {nis}.",
            f"Root mean square errors: {rmse}.",
        ]
        if self.aground:
            lines.append(f"{self.aground} twins met a bank and are left out.")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Return the measures by name."""
        names = ("mean_nees", "median_nees", "within", "mean_nis", "rmse", "covered", "aground", "states")
        measures = {name: getattr(self, name) for name in names}
        bounds = {"bounds": self.bounds(), "twins": len(self.nees), "settled": self.settled}
        return {**measures, **bounds, "summary": self.summary(), "notes": list(self.notes)}

    def to_dataframe(self) -> "pd.DataFrame":
        """Return one row per state: unit, root mean square error, share within the band of 95 %."""
        import pandas as pd

        units = {name: described(name)[0] for name in self.states}
        columns = {"unit": units, "rmse": self.rmse, "covered": self.covered}
        return pd.DataFrame(columns, index=pd.Index(self.states, name="state"))

    def dataset(self) -> "xarray.Dataset":
        """Return errors, standard deviations, NEES and NIS of every twin at every time."""
        import xarray

        over = ("twin", "t")
        data: dict[str, Any] = {"nees": (over, self.nees, {"units": "1"})}
        for place, name in enumerate(self.states):
            units = dict(zip(("units", "long_name"), described(name), strict=True))
            data[f"{name}_error"] = over, self.error[..., place], units
            data[f"{name}_std"] = over, self.std[..., place], units
        data |= {f"{name}_nis": (over, nis, {"units": "1"}) for name, nis in self.nis.items()}
        return xarray.Dataset(data, coords={"t": ("t", self.t, {"units": "s"})}, attrs={"summary": self.summary()})


@dataclass(frozen=True)
class Twins:
    """True states of ships, and their readings."""

    t: np.ndarray  # (times,) Time [s]
    states: np.ndarray  # (times, twins, states) The truth
    indicated: np.ndarray  # (times, twins, actuators) Indicated positions of the actuators
    readings: dict[str, np.ndarray]  # (times, twins, numbers) Readings of each sensor; NaN where none was due
    aground: np.ndarray  # (twins,) True if a twin met a bank


@accept_aliases
def consistency(
    model: Model, sensors: Sequence[Any], y: float = 0.0, u: float = 1.0, *, twins: int = 40, duration: float = 600.0,
    drawn: bool = False, seed: int = 0, x: float = 0.0, controller: ControlLaw | None = None,
    excitation: float = math.radians(3.0), fault: Fault | None = None, waterway: "Waterway | None" = None,
    **filtering: Any,
) -> Consistency:  # fmt: skip
    """Test an estimator on twins: simulated ships with known truth.

    Parameters
    ----------
    model : Model
        A model with terms of a rudder, unless the given controller needs none.
    sensors : sequence of Sensor and RudderIndicator
        As for ``Estimator``.
    y : float [m]
        Offset of the twins.
    u : float [m/s]
        Their speed.
    twins : int
        Number of twins.
    duration : float [s]
        Duration of each.
    drawn : bool
        True: each twin has coefficients drawn from the covariance of the fit, to test the estimate under model error.
    seed : int
        Seed of all random numbers.
    x : float [m]
        Start along the waterway.
    controller : ControlLaw, optional
        Controller of the twins; unless given, the track pilot of this offset and speed in the model's own canal.
    excitation : float [rad]
        Alternating rudder added to the orders, so that the motion carries information.
    fault : callable, optional
        Takes time and readings and returns faulty readings: a jump, an outage, a spoof.
    waterway : Waterway, optional
        Waterway instead of the model's own canal.
    **filtering : Any
        Other options of ``Estimator``: noise, prior, coefficients, memory, refusing, step, surge, surge_inertia,
        coriolis.

    Returns
    -------
    Consistency
        NEES, NIS and errors, with their chance bounds.

    Raises
    ------
    InputError
        If a value does not fit, no pilot holds the ship there, or all twins run aground.
    """
    check_count("twins", twins, 1)
    check_count("seed", seed)
    if controller is not None and not isinstance(controller, ControlLaw):
        raise InputError(
            f"a {type(controller).__name__} cannot steer twins; give a law in arithmetic, such as Autopilot"
        )
    if not (math.isfinite(duration) and duration > 0.0):
        raise InputError(f"duration = {duration} is no time to sail; give seconds over 0")

    first = Estimator(model, sensors, waterway=waterway, **filtering)
    psi = 0.0
    if controller is None:
        from narrows.control.regulator import track_pilot

        controller = track_pilot(model, y, u)
        psi = float(controller.psi)
    truth = sail_twins(first.filter, controller, (x, y, u, psi), twins, duration, drawn, excitation, seed)
    afloat = np.flatnonzero(~truth.aground)
    if not len(afloat):
        raise InputError("every twin ran aground; choose an offset and a speed at which the controller holds the ship")
    settled = min(SETTLING_TIME * math.sqrt(model.configuration.ship.length / REFERENCE_LENGTH), duration / 2)
    return _evaluated(first, truth, afloat, fault, settled)


def _evaluated(first: Estimator, truth: Twins, afloat: np.ndarray, fault: Fault | None, settled: float) -> Consistency:
    filter = first.filter
    shape = (len(afloat), len(truth.t))
    error, std = np.full((2, *shape, len(filter.states)), np.nan)
    nees = np.full(shape, np.nan)
    nis = {name: np.full(shape, np.nan) for name in filter.sensors}
    refused, suspected = ({name: np.zeros(shape, bool) for name in filter.sensors} for _ in range(2))
    for row, twin in enumerate(afloat):
        first.forget()
        for number, t in enumerate(truth.t):
            readings: Readings = {name: columns[number, twin] for name, columns in truth.readings.items()}
            readings = {name: columns for name, columns in readings.items() if np.isfinite(columns).all()}
            readings |= dict(zip(filter.actuators, truth.indicated[number, twin], strict=True))
            estimate = first.update(float(t), fault(float(t), readings) if fault else readings)
            if estimate.normal is None or not estimate.ready:
                continue
            off = estimate.normal.mean - truth.states[number, twin]
            off[2] = math.remainder(off[2], 2 * math.pi)
            error[row, number], std[row, number] = off, np.sqrt(estimate.covariance.diagonal())
            nees[row, number] = off @ np.linalg.solve(estimate.covariance, off)
            for name, value in estimate.nis.items():
                nis[name][row, number] = value
            for name in filter.sensors:
                refused[name][row, number] = name in estimate.refused
                suspected[name][row, number] = name in estimate.suspects
    numbers = {name: len(sensor.fields) for name, sensor in filter.sensors.items()}
    return Consistency(
        truth.t, error, std, nees, nis, refused, suspected, numbers, filter.states.names, settled,
        int(truth.aground.sum()), first.notes,
    )  # fmt: skip


def sail_twins(
    filter: ShipFilter, law: ControlLaw | None, start: tuple[float, float, float, float], count: int, duration: float,
    drawn: bool, excitation: float, seed: int,
) -> Twins:  # fmt: skip
    """Simulate ships from x, y, u, psi by the model, with the process noise of the estimator."""
    fleet = _Fleet(filter, law, max(count, 2), drawn, excitation, seed)  # One lane alone would share its inputs
    times = fleet.dt * np.arange(math.floor(duration / fleet.dt + 1e-9) + 1)
    states, indicated, aground = fleet.sail(start, times)
    noisy = indicated.copy()
    if RUDDER in filter.actuators and filter.indicator.noise:
        place = filter.actuators.index(RUDDER)
        noisy[..., place] += filter.indicator.noise * fleet.random.standard_normal(noisy.shape[:2])
    readings = {name: fleet.readings(sensor, times, states)[:, :count] for name, sensor in filter.sensors.items()}
    return Twins(times, states[:, :count], noisy[:, :count], readings, aground[:count])


class _Fleet:
    def __init__(
        self, filter: ShipFilter, law: ControlLaw | None, count: int, drawn: bool, excitation: float, seed: int
    ) -> None:
        model, gear = filter.model, filter.model.configuration.gear
        self.filter, self.count, self.excitation, self.random = filter, count, excitation, np.random.default_rng(seed)
        self.dt = min(sensor.period for sensor in filter.sensors.values())
        coefficients = np.tile(filter.middle, (count, 1))
        if drawn:
            columns = sampled(model, count, seed)
            coefficients = np.stack([columns[name].to_numpy() for name in model.terms.names], axis=1)
        self.lanes = ShipLanes(filter.ship, filter.states.names, count, filter.waterway, coefficients)
        self.process, self.limit, self.stages = filter.process(), gear.limit, list[np.ndarray]()
        self.gear = {name.removeprefix("rudder_"): value for name, value in gear.values().items()}
        self.side = TWIN_SIDE_TIME * STEPS_A_PERIOD * default_step(model)
        self.orders = LawOrders(model, law, self.dt, filter.waterway) if law else None

    def sail(self, start: tuple[float, ...], times: np.ndarray) -> tuple[np.ndarray, ...]:
        dt, positions = self.dt, np.tile(self.filter.at_rest, (self.count, 1))
        now, parts = self._started(*start), max(1, math.ceil(dt / self.filter.step - 1e-9))
        states, indicated, aground = [now], [positions], np.zeros(self.count, bool)
        for t in times[:-1]:
            after = self._steered(now, positions, float(t))
            for part in range(parts):
                here, there = (positions + share * (after - positions) for share in (part / parts, (part + 1) / parts))
                now = self.lanes.advance(now, dt / parts, here, there)
                aground |= self.lanes.aground
                now = self.process.after(now, dt / parts, self.random)
            positions = after
            states.append(now)
            indicated.append(positions)
        return np.array(states), np.array(indicated), aground

    def _started(self, x: float, y: float, u: float, psi: float) -> np.ndarray:
        """Draw the initial states of the twins."""
        filter = self.filter
        current = float(filter.waterway.current_at(x)) if filter.waterway else 0.0
        means = filter.states.vector({"x": x, "y": y, "psi": psi, "u": u, "current": current})
        spreads = {**filter.spreads, "y": TWIN_START_STD[0] * filter.time_scale**2, "psi": TWIN_START_STD[1]}
        size = np.array([spreads.get(name, 0.0) for name in filter.states.names])
        return np.asarray(means + size * self.random.standard_normal((self.count, len(size))))

    def _steered(self, states: np.ndarray, positions: np.ndarray, t: float) -> np.ndarray:
        """Return the positions of the actuators a step later."""
        after, names = positions.copy(), self.filter.actuators
        if self.orders is None or RUDDER not in names:
            return after
        place, turn = names.index(RUDDER), int(t / self.side)
        known = {**dict(zip(self.filter.states.names, states.T, strict=True)), **dict(zip(names, after.T, strict=True))}
        swing = self.excitation * (turn % 2 * 2 - 1) * (turn % 3 == 0)
        order = np.clip(self.orders.orders(t, known)[RUDDER] + swing, -self.limit, self.limit)
        stages = self.stages or [positions[:, place]] * STAGES
        moved, self.stages = gear_motion(
            order, positions[:, place], stages, self.gear, self.dt, {**COLUMNS, "exp": np.exp}
        )
        after[:, place] += moved
        return after

    def readings(self, sensor: Sensor, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Readings of a sensor by time of arrival, from the state when measured, linear between the times."""
        readings = np.full((len(times), self.count, len(sensor.fields)), np.nan)
        for number in range(0, len(times), max(1, round(sensor.period / self.dt))):
            if times[number] < sensor.late:
                continue
            measured = (times[number] - sensor.late) / self.dt
            before = min(int(measured), len(times) - 2)
            then = states[before] + (measured - before) * (states[before + 1] - states[before])
            at = Columns(then, self.filter.states, self.lanes.bend(float(then[0, 0])))
            readings[number] = np.stack(drawn_reading(sensor, at, vars(at), self.random), axis=1)
        return readings
