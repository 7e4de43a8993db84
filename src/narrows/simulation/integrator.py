"""One voyage in Python, step by step with the engine's own lines; the controller is called before each."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

from narrows.codegen.choices import LENGTH, SHARE
from narrows.codegen.free_motion import MIDSHIP, OPEN
from narrows.codegen.kernels import event, single
from narrows.codegen.system import System
from narrows.simulation import settings
from narrows.simulation.channel import Channel
from narrows.simulation.controllers import Order, VoyageState
from narrows.simulation.outcome import Code
from narrows.simulation.ship import PARAMETER

# State from step to step, in the order of ``Choices.kept``: x, y, cos psi, sin psi, u, v, r first.
State = tuple[float, ...]


class Row(NamedTuple):
    t: float  # Time [s]
    state: State  # State from step to step
    ahead: float = 0.0  # Length of the step that begins here [s]
    order: float = 0.0  # Order of a controller of Python in it [rad]
    whole: bool = True  # False within a step that was cut short, where a contact is located


@dataclass
class VoyageIntegrator:
    """A ship under way: the lines of its step, and their inputs."""

    system: System
    inputs: Mapping[str, float]  # Inputs of the lines
    channel: Channel  # The water
    near: float  # Distance at which a diverging motion counts as contact [m]
    order: Order | None = None  # Order of a controller of Python
    _step_inputs: list[float] = field(init=False)
    _asked: float = field(init=False, default=math.nan)

    def __post_init__(self) -> None:
        self.functions, self.choices = self.system.scalar, self.system.choices
        inputs = {LENGTH: 0.0, SHARE: 1.0, **self.inputs}
        self._names = self.functions.STEP_INPUTS
        self._step_inputs = [float(inputs[name]) for name in self._names]
        self._clearance_inputs = [float(inputs[name]) for name in self.functions.LEAST_CLEARANCE_INPUTS]
        self._end_inputs = [float(inputs[name]) for name in self.functions.ENDS_INPUTS]
        self._length, self._share = self._names.index(LENGTH), self._names.index(SHARE)
        self._order = self._names.index(PARAMETER("order")) if self.order else -1
        self._count = len(self.choices.kept)
        self._exact = self.choices.waterway and self.choices.contact not in (MIDSHIP, OPEN)

    @cached_property
    def _table(self) -> list[float]:
        return list(self.channel.table.tolist())

    @cached_property
    def _shapes(self) -> tuple[list[float], list[float]]:
        return self.channel.track.tolist(), self.channel.outline.tolist()

    def set(self, **values: float) -> None:
        for name, value in values.items():
            if name in self._names:
                self._step_inputs[self._names.index(name)] = value

    def stepped(self, state: State, length: float, share: float = 1.0) -> tuple[State, float, float]:
        """Return the state after a step or a share of it, its clearance and its side [m]."""
        inputs = self._step_inputs
        inputs[self._length], inputs[self._share] = length, share
        try:
            *after, clearance, side = self.functions.step(self._table, *state, *inputs)
        except (ZeroDivisionError, OverflowError, ValueError):  # Compiled arithmetic gives infinity or NaN here
            return (math.nan,) * self._count, math.nan, 0.0
        return tuple(after), clearance, side

    def clearance(self, state: State, exact: bool = True) -> tuple[float, float]:
        """Return the smallest margin to an end of the voyage, and the side [m]."""
        clearance, side = self.functions.least_clearance(self._table, *state[:5], *self._clearance_inputs)
        return self._from_banks(state) if exact and self._exact and clearance <= 0 else (clearance, side)

    def cause(self, outcome: int, state: State) -> int:
        """Return what ended the voyage, by the outcome of its last step: as kernels do."""
        if outcome == event.FINISHED:
            return Code.AFLOAT
        return Code.DIVERGED if outcome == event.LOST else event.cause(*self._ends(state), settings.CONTACT_CLOSENESS)

    def _ends(self, state: State) -> tuple[float, float, float, float]:
        return self.functions.ends(self._table, *state[:5], *self._end_inputs)  # type: ignore[no-any-return]

    def least_clearance(self, rows: Sequence[Row]) -> float | None:
        """Return the least clearance between hull and banks of a waterway [m]; None without an outline of the hull."""
        looked = rows[:: max(1, len(rows) // settings.CLEARANCE_ROWS)]
        return min(self._exact_clearance(row.state)[0] for row in looked) if self._exact else None

    def _exact_clearance(self, state: State) -> tuple[float, float]:
        from narrows.waterway.bank_clearance import exact_clearance  # Its package is slow to import

        x, y, cosine, sine = state[:4]
        track, outline = self._shapes
        return exact_clearance(track, 1.0 / self.inputs["cells_a_metre"], x, y, cosine, sine, outline)

    def _from_banks(self, state: State) -> tuple[float, float]:
        clearance, side = self._exact_clearance(state)
        return min(clearance, *self._ends(state)), side

    def sane(self, state: State, clearance: float) -> bool:
        """Return whether a state is physical; a ship drawn to a bank that ends its voyage may have any speed."""
        if self.choices.leaves and clearance <= self.near:
            return True
        u, v, r = state[4:7]
        fast, turning = self.inputs["most_speed"], self.inputs["most_rate"]
        return abs(u) < fast and abs(v) < fast and abs(r) < turning and clearance == clearance

    def integrate(self, rows: list[Row], stop: float, dt: float) -> int:
        """Integrate to a time, or to an earlier end of the voyage; return the outcome of ``event``."""
        begun, state, *_ = rows.pop()
        control, within, leaves = [0.0] * event.PLACES, False, self.choices.leaves
        single.schedule(control, dt, stop - begun)
        left, done, before = control[event.COUNT], 0, self.clearance(state, exact=False)[0]
        while control[event.COUNT] > 0:
            # Equal steps while they are clear; the first that is not needs a decision.
            trying, length = control[event.TRIES] > 0, control[event.NEXT]
            t, left, done = begun + control[event.CLOCK] + done * length, left - 1, done + 1
            self._ask(t, state)
            after, clearance, _ = self.stepped(state, length)
            row, sane = Row(t, state, length, self._step_inputs[self._order], not within), self.sane(after, clearance)
            if self._exact and sane and (clearance <= 0 or trying):
                clearance = self._from_banks(after)[0]
            clear = sane and event.clearance_left(clearance, before, leaves) > 0
            if clear and left > 0 and not trying:
                rows.append(row)
                state, before = after, clearance
                continue
            if self._exact and (trying or not clear):
                before = self._from_banks(state)[0]
            outcome = event.accept_step(
                control, left, clearance, before, sane, settings.CONTACT_TOLERANCE, self.near, leaves
            )
            if outcome == event.LOST:
                rows.append(Row(t, state))
                return event.CLOSED if before <= self.near else outcome
            if outcome != event.BACK:
                rows.append(row)
                state = after
            if outcome == event.CLOSED:
                rows.append(Row(begun + control[event.CLOCK], state))
                return outcome
            within = control[event.TRIES] > 0 and (within or outcome == event.ON)
            if outcome == event.FINISHED:
                break
            left, done, before = control[event.COUNT], 0, self.clearance(state, exact=False)[0]
        rows.append(Row(stop, state))
        return event.FINISHED

    def _ask(self, t: float, state: State) -> None:
        if self.order is None or t == self._asked:
            return
        self._asked = t
        x, y, cosine, sine, u, v, r = state[:7]
        seen = VoyageState(x, y, math.atan2(sine, cosine), u, v, r, state[self.choices.kept.index("rudder")])
        self._step_inputs[self._order] = float(self.order(t, seen))

    def dense(self, rows: Sequence[Row], times: Sequence[float]) -> list[Row]:
        """Return the voyage at requested times, each by a share of its step."""
        interpolated, index = [], 0
        for time in times:
            while index < len(rows) - 1 and rows[index + 1].t <= time:
                index += 1
            row = rows[index]
            if time <= row.t or not row.ahead:
                interpolated.append(Row(time, row.state))
                continue
            self._step_inputs[self._order] = row.order if self.order else self._step_inputs[self._order]
            interpolated.append(Row(time, self.stepped(row.state, row.ahead, (time - row.t) / row.ahead)[0]))
        return interpolated


def track_error(integrator: VoyageIntegrator, rows: Sequence[Row], dt: float) -> float:
    """Estimate the error of a voyage's final position due to its time step [m]."""
    # Richardson extrapolation: some steps are repeated in two halves with the rudder held, and the error of a step of
    # order 4 is 16/15 of the difference. The errors add up; growth of an error by the motion itself is ignored.
    integrator.set(rudder_rate=0.0, revolutions_rate=0.0)
    states, errors = [row.state for row in rows[:-1] if row.ahead == dt], []
    for state in states[:: max(1, len(states) // settings.STEP_CHECK_STEPS)]:
        whole = integrator.stepped(state, dt)[0]
        halves = integrator.stepped(integrator.stepped(state, dt / 2)[0], dt / 2)[0]
        errors.append(16 / 15 * math.hypot(whole[0] - halves[0], whole[1] - halves[1]))
    return (rows[-1].t - rows[0].t) / dt * sum(errors) / max(len(errors), 1)
