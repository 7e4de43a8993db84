"""An independent integration of one voyage: SciPy's DOP853 from order to order, and contact by exact polygons.

Nothing here goes through the package's compiler or its voyages: the terms come from the model's table, the section
from the waterway.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from equations import Equations, State, turning_of
from hull_polygons import Midship, Room, room_of
from laws import order_of
from scipy.integrate import DOP853

import narrows as nw
from narrows.simulation.controllers import ControlLaw

RELATIVE, ABSOLUTE = 1e-11, 1e-13
ACROSS = math.radians(85)
FASTEST, FASTEST_TURN = 100.0, 10.0
"""Speed [m/s] and yaw rate [rad/s] that no ship has."""
CLOSED = 1e-6
"""Midship clearance that counts as none [m]: there the suction is infinite."""
DRAWN_IN = 1e-3
"""Of the beam: a midship clearance from which no ship comes back, however fast the suction makes it."""
EXACT = 1e-11
"""Of the time of an end [s]."""
SAME = 1e-12
"""Rates of the rudder that are one [rad/s]."""
LONGEST = 64
"""Steps at once."""
FIRST = 0.1
"""Longest first step of DOP853 [s]."""
STATE = ("x", "y", "psi", "u", "v", "r", "rudder")
Closes = Callable[[State], float]


@dataclass(frozen=True)
class End:
    """How a voyage ended."""

    kind: str
    time: float
    side: str | None
    state: dict[str, float]
    distance: float


@dataclass(frozen=True)
class Step:
    """A step of the control law: when it begins, the state there, the rate of the rudder over it."""

    time: float
    length: float
    state: State
    turning: float


@dataclass(frozen=True)
class Reference:
    """One voyage, as ``nw.simulate`` takes it.

    The track goes on until no hull could; ``end`` tells how a hull's voyage ends on it.
    """

    model: nw.Model
    duration: float
    dt: float
    start: dict[str, float]
    surge: str = "held"
    surge_inertia: float | None = None
    coriolis: bool = False
    forces: tuple[float, float, float] = (0.0, 0.0, 0.0)
    waterway: nw.Waterway | None = None
    controller: ControlLaw | None = None
    open_water: bool = False

    @cached_property
    def equations(self) -> Equations:
        """The rates."""
        return Equations(
            self.model, surge=self.surge, surge_inertia=self.surge_inertia, coriolis=self.coriolis,
            forces=self.forces, waterway=self.waterway,
        )  # fmt: skip

    @cached_property
    def steps(self) -> list[Step]:
        """The steps up to where no hull could go on, and last the end of them, of no length."""
        return list(self._integrator())

    @cached_property
    def _turning(self) -> Callable[[int, State], float]:
        """The rate of the rudder over a step, by its number and the state at its start; asked once for each step."""
        if self.controller is None:
            return lambda number, state: 0.0
        order, gear = order_of(self.controller, self.model, self.waterway), self.model.configuration.gear

        def turning(number: int, state: State) -> float:
            begin = self._time(number)
            length = self._time(number + 1) - begin
            return turning_of(gear, float(state[6]), order(begin, length, state), length)

        return turning

    @cached_property
    def _count(self) -> int:
        return max(1, math.ceil(self.duration / self.dt - 1e-9))

    def _time(self, number: int) -> float:
        return min(number * self.dt, self.duration)

    def _integrator(self) -> Iterator[Step]:
        """March over as many steps at once as have one rate of the rudder, more and more as long as it stays."""
        state = np.array([self.start.get(name, 1.0 if name == "u" else 0.0) for name in STATE])
        number, stretch, turning = 0, 1, self._turning(0, state)
        while number < self._count:
            begin = self._time(number)
            for reached, after in self._stretch(begin, state, turning, min(number + stretch, self._count)):
                yield Step(self._time(number), begin + reached - self._time(number), state, turning)
                number, state = number + 1, after
                if begin + reached < self._time(number) - EXACT or self._over(state):
                    yield Step(begin + reached, 0.0, state, 0.0)
                    return
                if number == self._count or abs(turning - (turning := self._turning(number, state))) > SAME:
                    stretch = 1
                    break
            else:
                stretch = min(2 * stretch, LONGEST)
        yield Step(self.duration, 0.0, state, 0.0)

    def _stretch(self, begin: float, state: State, turning: float, last: int) -> list[tuple[float, State]]:
        """Return time since its beginning and state at the end of each step, and where it ends before its time."""
        due = [self._time(k) - begin for k in range(1, last + 1) if self._time(k) - begin > EXACT]
        ends = []
        for solver in self._solve(Step(begin, due[-1], state, turning)):
            state_at = solver.dense_output() if solver.t < due[-1] or len(due) > 1 else lambda t, z=solver.y: z
            while due and due[0] <= solver.t:
                ends.append((due[0], state_at(due.pop(0))))
        return ends if not due else [*ends, (float(solver.t), solver.y)]

    def _solve(self, step: Step) -> Iterator[DOP853]:
        """Integrate over a step, or to where the midship clearance is used up."""
        solver = DOP853(
            lambda t, z: self.equations.rates(z, step.turning), 0.0, step.state, step.length,
            rtol=RELATIVE, atol=ABSOLUTE, first_step=min(step.length, FIRST),
        )  # fmt: skip
        while solver.status == "running":
            solver.step()
            yield solver
            if self._midship(solver.y) < CLOSED:
                return

    def _over(self, state: State) -> bool:
        return any(closes(state) <= 0 for closes in self._ends(None).values())

    @cached_property
    def _midship(self) -> Closes:
        return (lambda state: math.inf) if self.open_water else Midship(self.model, self.waterway).room

    def _ends(self, room: Room | None) -> dict[str, Closes]:
        """What is positive as long as a voyage does not end in a way."""
        drawn_in = DRAWN_IN * self.model.configuration.ship.beam

        def slow(z: State) -> float:
            fastest = min(FASTEST - abs(z[3]), FASTEST - abs(z[4]), FASTEST_TURN - abs(z[5]))
            return float(fastest) if fastest > 0 or self._midship(z) > drawn_in else 1.0

        ends: dict[str, Closes] = {"diverged": slow}
        if room is not None:
            ends["grounded"] = lambda z: room.room(z) - (CLOSED if isinstance(room, Midship) else 0.0)
        if not self.open_water:
            ends["left validity"] = lambda z: ACROSS - abs(z[2])
        if self.waterway is not None:
            ends["left the waterway"] = lambda z: min(z[0], self.waterway.line.length - z[0])
        return ends

    def end(self, contact: str | Sequence[Sequence[float]]) -> End:
        """Return how the voyage ends for a hull."""
        room = room_of(self.model, contact, self.waterway)
        ends = self._ends(room)
        states = np.array([step.state for step in self.steps])
        others = [closes for name, closes in ends.items() if name != "grounded"]
        closed = np.array([any(closes(z) <= 0 for closes in others) for z in states])
        if room is not None:
            closed |= room.closed(states, CLOSED)
        for k in np.flatnonzero(closed[1:]).tolist():
            if found := self._located(self.steps[k], ends):
                return self._ended(*found, room)
        last = self.steps[-1]
        return self._ended(last.time, last.state, "afloat", room)

    def _located(self, step: Step, ends: dict[str, Closes]) -> tuple[float, State, str] | None:
        """Find the first end within a step on the dense output: its time, the state then, and what it is."""
        for solver in self._solve(step):
            shut = [name for name, closes in ends.items() if closes(solver.y) <= 0]
            if shut:
                dense, low = solver.dense_output(), solver.t_old
                time, name = min((_first(ends[name], dense, low, solver.t), name) for name in shut)
                return step.time + time, dense(time), name
        return None

    def _ended(self, time: float, state: State, kind: str, room: Room | None) -> End:
        side = room.side(state) if room is not None and kind == "grounded" else None
        named = dict(zip(STATE, state.tolist(), strict=True))
        return End(kind, time, side, named, named["x"] - self.start.get("x", 0.0))


def _first(closes: Closes, state_at: Callable[[float], State], low: float, high: float) -> float:
    while high - low > EXACT:
        middle = (low + high) / 2
        low, high = (middle, high) if closes(state_at(middle)) > 0 else (low, middle)
    return high
