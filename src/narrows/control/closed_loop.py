"""Simulate ship, gear, sensors, estimator and controller as one loop, and linearise that same loop."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from narrows.aliases import accept_aliases
from narrows.codegen.choices import COUNTED, TIME
from narrows.control.design import with_gear
from narrows.control.linear_system import loop_margins
from narrows.control.linearization import linearize
from narrows.control.sensed_helm import SensedHelm
from narrows.control.settings import (
    DELAY_DIGITS,
    LOOP_DURATION,
    LOOP_OFFSET,
    LOOP_TIME,
    LOST_LOOP,
    MOST_DELAY,
    NEWTON_ROUNDS,
    SAME_STATE,
)
from narrows.control.steady_course import check_rudder
from narrows.errors import InputError, needs
from narrows.model.model import Model
from narrows.results import BaseSummary
from narrows.ship.actuators import SteeringGear
from narrows.simulation.controllers import ControlLaw, Named
from narrows.simulation.ensemble import ensemble
from narrows.simulation.initial_state import initial_state
from narrows.simulation.inputs import check_waterway, finite_numbers
from narrows.simulation.integrator import VoyageIntegrator
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import MEMORY, PARAMETER, steering_of
from narrows.simulation.voyage import Voyage, simulate

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

ORDERED, ASKED = "loop_ordered", "loop_asked"
# States of a voyage that are not states of a loop about a steady course, such as place along the line and time.
LEFT_OUT = ("x", TIME, COUNTED, "sin_psi", "u", MEMORY(ASKED))


@dataclass(frozen=True)
class OpenedLaw:
    """A law whose rudder order goes into the memory, while the rudder gets an external order."""

    law: ControlLaw

    def parameters(self) -> Mapping[str, Any]:
        return {**self.law.parameters(), ORDERED: 0.0}

    def memory(self, start: Named) -> Named:
        return {**self.law.memory(start), ASKED: start["rudder"]}

    def orders(self, at: Any) -> tuple[Named, Named]:
        orders, memory = self.law.orders(at)
        return {**orders, "rudder": getattr(at, ORDERED)}, {**memory, ASKED: orders["rudder"]}


@dataclass(frozen=True, repr=False, eq=False)
class ClosedLoop(BaseSummary):
    """A ship under a controller; the result of ``closed_loop``, whose arguments it has as attributes."""

    model: Model
    controller: Any
    y: float
    u: float
    dt: float
    waterway: "Waterway | None" = None
    x: float = 0.0
    sensors: Sequence[Any] = ()
    estimator: Any = None

    @cached_property
    def course(self) -> dict[str, float]:
        """The steady course: psi, rudder [rad], v [m/s], r [rad/s], and the propeller revolutions [1/s]."""
        linear = linearize(self.model, self.y, self.u, waterway=self.waterway, at=self.x)
        names = ("psi", "v", "r", "rudder", *(a.name for a in self.model.terms.actuators if a.name != "rudder"))
        return {name: float(linear.course[name]) for name in names}

    def simulate(self, duration: float | None = None, seed: int = 0, **voyage: Any) -> Voyage:
        """Simulate one voyage, by default from the steady course.

        Parameters
        ----------
        duration : float [s], optional
            Default: the time of 40 ship lengths.
        seed : int
            Seed of the sensor noise.
        **voyage : Any
            As for ``simulate``.
        """
        time = LOOP_DURATION * self._passing if duration is None else duration
        return simulate(self.model, duration=time, **{**self._begun, "controller": self._helm(seed), **voyage})

    def ensemble(self, duration: float | None = None, **vary: Any) -> xr.Dataset:
        """Simulate many voyages, by default from the steady course; parameters vary as in ``ensemble``.

        Parameters
        ----------
        duration : float [s], optional
            Default: the time of 40 ship lengths.
        **vary : Any
            As for ``ensemble``.

        Raises
        ------
        InputError
            If the loop has sensors or its controller is an object of Python: these allow single voyages only.
        """
        if self.sensors:
            raise InputError("a loop with sensors sails single voyages; call simulate with several seeds instead")
        time = LOOP_DURATION * self._passing if duration is None else duration
        start = {name: value for name, value in self._begun.items() if name != "r"}
        return ensemble(self.model, duration=time, **{**start, "controller": self.controller, **vary})

    @property
    def _passing(self) -> float:
        return self.model.configuration.ship.length / self.u

    @property
    def _begun(self) -> dict[str, Any]:
        operating_point = {"y": self.y, "u": self.u, "x": self.x, "dt": self.dt, "waterway": self.waterway}
        return {**operating_point, **self.course}

    def _helm(self, seed: int) -> Any:
        if not self.sensors:
            return self.controller
        return SensedHelm(
            self.model, self.controller, tuple(self.sensors), self.estimator, self.dt, self.waterway, seed
        )

    @cached_property
    def states(self) -> tuple[str, ...]:
        """Names of the states of the loop: ship, gear and memory of the law."""
        kept = self._opened.choices.kept
        return tuple("psi" if name == "cos_psi" else name for name in kept if name not in LEFT_OUT)

    @cached_property
    def _opened(self) -> VoyageIntegrator:
        if not isinstance(self.controller, ControlLaw):
            raise InputError(
                f"a {type(self.controller).__name__} is no law in arithmetic, so its loop has no matrices; ask for "
                "tolerated_delay, which sails voyages"
            )
        ship = SimulatedShip(self.model)
        steering = steering_of(OpenedLaw(self.controller), ship.actuators)
        numbers = {"x": self.x, "y": self.y, "u": self.u, **self.course}
        integrator, self.__dict__["_start"] = initial_state(ship, steering, numbers, self.waterway, False)
        # A dead band has no derivative: the loop is linearised for orders beyond it.
        integrator.set(rudder_dead_band=0.0)
        return integrator

    def _stepped(self, state: np.ndarray, order: float) -> tuple[np.ndarray, float]:
        """Return the state a step later under an order, and the law's order."""
        integrator = self._opened
        values = dict(zip(integrator.choices.kept, self.__dict__["_start"], strict=True))
        values |= dict(zip(self.states, state, strict=True))
        values |= {"cos_psi": math.cos(values["psi"]), "sin_psi": math.sin(values["psi"])}
        integrator.set(**{PARAMETER(ORDERED): order})
        after, *_ = integrator.stepped(tuple(values[name] for name in integrator.choices.kept), self.dt)
        later = dict(zip(integrator.choices.kept, after, strict=True))
        later["psi"] = math.atan2(later["sin_psi"], later["cos_psi"])
        return np.array([later[name] for name in self.states]), later[MEMORY(ASKED)]

    @cached_property
    def _sizes(self) -> np.ndarray:
        ship = self.model.configuration.ship
        known = {"y": ship.beam, "v": self.u, "r": self.u / ship.length, MEMORY("integral"): ship.beam * self._passing}
        return np.array([known.get(name, 1.0) for name in self.states])

    def _slopes(self, state: np.ndarray, order: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return A, B and C of the opened loop about a state, by central differences of the engine's own step."""
        sizes, count = np.append(self._sizes, 1.0), len(state)
        rows = np.empty((count + 1, count + 1))
        for column, size in enumerate(1e-5 * sizes):
            ends = []
            for side in (size, -size):
                moved = np.append(state, order)
                moved[column] += side
                after, asked = self._stepped(moved[:-1], float(moved[-1]))
                ends.append(np.append(after, asked))
            rows[:, column] = (ends[0] - ends[1]) / (2 * size)
        return rows[:-1, :-1], rows[:-1, -1:], rows[-1:, :-1]

    @cached_property
    def _matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the same about the steady state of the loop, found by Newton's method."""
        integrator = self._opened
        begun = dict(zip(integrator.choices.kept, self.__dict__["_start"], strict=True), psi=self.course["psi"])
        state = np.array([begun[name] for name in self.states])
        for _ in range(NEWTON_ROUNDS):
            order = self._stepped(state, self.course["rudder"])[1]
            off = self._stepped(state, order)[0] - state
            A, B, C = self._slopes(state, order)
            if np.abs(off / self._sizes).max() < SAME_STATE:
                return A, B, C
            state = state + np.linalg.lstsq(np.eye(len(state)) - A - B @ C, off, rcond=None)[0]
        raise InputError(
            f"the {type(self.controller).__name__} does not keep this ship on a steady course {self.y:g} m off the "
            f"middle at {self.u:g} m/s, so there is nothing to linearise about; choose another, or simulate it"
        )

    def state_space(self, opened: bool = False) -> Any:
        """Return the loop as a discrete state space of python-control, at its time step.

        Parameters
        ----------
        opened : bool
            True: from the gear's order to the law's order, with the sign changed. False: from an order added to the
            law's to the offset, heading and rudder.

        Raises
        ------
        InputError
            If the controller is no law, is not steady there, or python-control is not installed (``pip install
            narrows[control]``).
        """
        with needs("control", "state_space"):
            import control
        A, B, C = self._matrices
        named: dict[str, Any] = {"states": list(self.states), "name": "loop"}
        if opened:
            return control.ss(A, B, -C, 0, self.dt, inputs=["order"], outputs=["asked"], **named)
        seen = [self.states.index(name) for name in ("y", "psi", "rudder")]
        out = np.eye(len(A))[seen]
        return control.ss(A + B @ C, B, out, 0, self.dt, inputs=["order"], outputs=["y", "psi", "rudder"], **named)

    def poles(self) -> np.ndarray:
        """Return the growth rates of deviations from the course [1/s], the most unstable first.

        They are the logarithms of the discrete poles over the time step.
        """
        A, B, C = self._matrices
        found = np.linalg.eigvals(A + B @ C)
        rates = np.log(np.where(np.abs(found) > 0, found, np.finfo(float).tiny).astype(complex)) / self.dt
        return np.asarray(rates[np.argsort(-rates.real, kind="stable")])

    def margins(self) -> dict[str, float]:
        """Return the stability margins of the loop, broken at the rudder order.

        ``gain`` and ``gain_down`` [1]: factors of the order; ``phase_deg`` [deg]; ``delay`` [s]: a further delay of the
        order; ``distance`` [1]: the least distance from -1 of the Nyquist curve, and ``sensitivity_peak`` [1], its
        inverse.
        """
        A, B, C = self._matrices
        poles = np.abs(self.poles())
        slowest = float(poles[poles > 0].min(initial=1.0 / self._passing))
        # An unstable loop has no margins.
        if self.poles()[0].real > 0:
            none = dict.fromkeys(("gain", "gain_down", "phase_deg", "delay", "distance"), 0.0)
            return {**none, "sensitivity_peak": math.inf}
        return loop_margins(A, B, -C, 1e-2 * slowest, math.pi / self.dt, self.dt)

    def tolerated_delay(self, seed: int = 0) -> float:
        """Return the longest additional dead time of the gear under which the ship keeps its line [s].

        Found by voyages from a small offset: the ship keeps its line if a tenth of that offset is left in the second
        half of the voyage, or, where sensor noise moves it, at most twice the offset without the additional dead time.

        Parameters
        ----------
        seed : int
            Seed of the sensor noise.
        """
        beam, longest = self.model.configuration.ship.beam, MOST_DELAY * self._passing
        usual = self._late_offset(0.0, seed)
        noisy = 2.0 * usual if self.sensors and usual < beam / 2 else 0.0
        most = max(noisy, LOST_LOOP * LOOP_OFFSET * beam)
        if usual > most:
            return 0.0
        if self._late_offset(longest, seed) <= most:
            return longest
        kept, lost = 0.0, longest
        while lost - kept > max(DELAY_DIGITS * kept, DELAY_DIGITS * self.dt):
            middle = (kept + lost) / 2
            kept, lost = (middle, lost) if self._late_offset(middle, seed) <= most else (kept, middle)
        return kept

    def _late_offset(self, delay: float, seed: int) -> float:
        """Return the largest offset from the line in the second half of a voyage [m]; infinite if the ship is lost."""
        gear = self.model.configuration.gear
        later = replace(gear, dead_time=gear.dead_time + delay)
        loop = replace(self, model=with_gear(self.model, later))
        loop.__dict__["course"] = self.course
        begun = self.y - math.copysign(LOOP_OFFSET * self.model.configuration.ship.beam, self.y)
        voyage = loop.simulate(LOOP_TIME * self._passing, seed, y=begun)
        off = np.abs(voyage.y - self.y)[voyage.t > voyage.t[-1] / 2]
        return float(off.max()) if voyage.outcome.kind == "afloat" else math.inf

    def summary(self) -> str:
        """Describe the controller, the gear and the sensors."""
        gear = self.model.configuration.gear
        slow = f", {gear.dead_time:g} s of dead time, {gear.lag:g} s of lag" if gear.delay else ""
        sees = f" by {', '.join(sensor.name for sensor in self.sensors)}" if self.sensors else ""
        return (
            f"{type(self.controller).__name__} at y = {self.y:g} m and u = {self.u:g} m/s{sees}, an order every "
            f"{self.dt:g} s{slow}"
        )


@accept_aliases
def closed_loop(
    model: Model, controller: Any, *, gear: SteeringGear | None = None, sensors: Sequence[Any] = (),
    estimator: Any = None, waterway: "Waterway | None" = None, y: float | None = None, u: float | None = None,
    x: float = 0.0, dt: float = 1.0,
) -> ClosedLoop:  # fmt: skip
    """Join a ship, its steering gear, its sensors and its controller.

    Parameters
    ----------
    model : Model
        The ship, with terms of a rudder.
    controller : ControlLaw or Controller
        A regulator, a predictive helm, a law or a function of your own.
    gear : SteeringGear, optional
        Default: the model's own.
    sensors : sequence of Sensor
        Sensors of the controller; without any it gets the true state.
    estimator : Estimator, optional
        Estimates the state from the readings; default ``Estimator(model, sensors)``.
    waterway : Waterway, optional
        Waterway instead of the model's own canal.
    y : float [m], optional
        Offset of the steady course; default: that of the controller.
    u : float [m/s], optional
        Surge velocity through the water; default: that of the controller.
    x : float [m]
        Place along the waterway.
    dt : float [s]
        Time between orders.

    Returns
    -------
    ClosedLoop
        Voyages, fleets, matrices and margins of the loop.

    Raises
    ------
    InputError
        If the offset or the speed is missing, a number is not finite, or an estimator has no sensors.
    """
    check_rudder(model)
    check_waterway(waterway)
    line = controller.lines[0].y if hasattr(controller, "lines") else getattr(controller, "y", None)
    offset, speed = (line if y is None else y), (getattr(controller, "u", None) if u is None else u)
    for name, value in (("y", offset), ("u", speed)):
        if value is None:
            raise InputError(f"the {type(controller).__name__} does not say for which {name} it is; give {name}")
    numbers = finite_numbers(y=offset, u=speed, x=x, dt=dt)
    if not numbers["dt"] > 0:
        raise InputError(f"dt = {dt} s is no time between orders; give seconds over 0")
    if estimator is not None and not sensors:
        raise InputError("an estimator needs the sensors that it was made for; give sensors too")
    if gear is not None:
        model = with_gear(model, gear)
    return ClosedLoop(model, controller, waterway=waterway, sensors=tuple(sensors), estimator=estimator, **numbers)
