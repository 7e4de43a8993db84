"""One voyage in Python, step by step with the engine's own lines; its start and its defaults."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, did_you_mean
from narrows.codegen.free_motion import INPUTS, LENGTH, MIDSHIP, OPEN, SHARE
from narrows.codegen.kernels import event, single
from narrows.codegen.system import System
from narrows.model.model import Model
from narrows.model.water import choke_speed
from narrows.quantities.names import GRAVITY
from narrows.ship.actuators import PROPELLER, places_of
from narrows.ship.motion import Motion
from narrows.simulation import settings
from narrows.simulation.controllers import Controller, Order, VoyageState
from narrows.simulation.inputs import START
from narrows.simulation.kernel_run import PUSH_END, KernelRun
from narrows.simulation.outcome import Code
from narrows.simulation.ship import PARAMETER, Channel, SimulatedShip, Steering
from narrows.waterway.bank_clearance import exact_clearance
from narrows.waterway.waterway import Waterway

# State from step to step, in the order of ``Choices.kept``: x, y, cos psi, sin psi, u, v, r first.
State = tuple[float, ...]


class Row(NamedTuple):
    t: float  # Time [s]
    state: State  # State from step to step
    ahead: float = 0.0  # Length of the step that begins here [s]
    whole: bool = True  # False within a step that was cut short, where a contact is located


@dataclass
class VoyageIntegrator:
    """A ship under way: the lines of its step, and their inputs."""

    system: System
    inputs: Mapping[str, float]  # Inputs of the lines
    channel: Channel  # The water
    near: float  # Distance at which a diverging motion counts as contact [m]
    order: Order | None = None  # Order of a controller of Python
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
        x, y, cosine, sine = state[:4]
        track, outline = self._shapes
        return exact_clearance(track, 1.0 / self.inputs["cells_a_metre"], x, y, cosine, sine, outline)

    def _from_banks(self, state: State) -> tuple[float, float]:
        clearance, side = self._exact_clearance(state)
        return min(clearance, *self._ends(state)), side

    def integrate(self, rows: list[Row], stop: float, dt: float) -> int:
        """Integrate to a time, or to an earlier end of the voyage; return the outcome of ``event``."""
        begun, state, *_ = rows.pop()
        control, within, leaves = [0.0] * event.PLACES, False, self.choices.leaves
        most = self.inputs["most_speed"], self.inputs["most_rate"]
        single.schedule(control, dt, stop - begun)
        left, done, before = control[event.COUNT], 0, self.clearance(state, exact=False)[0]
        while control[event.COUNT] > 0:
            # Equal steps while they are clear; the first that is not needs a decision.
            trying, length = control[event.TRIES] > 0, control[event.NEXT]
            t, left, done = begun + control[event.CLOCK] + done * length, left - 1, done + 1
            self._ask(t, state)
            after, clearance, _ = self.stepped(state, length)
            row = Row(t, state, length, not within)
            sane = event.is_sane(after[4], after[5], after[6], clearance, self.near, leaves, *most)
            if self._exact and sane and (clearance <= 0 or trying):
                clearance = self._from_banks(after)[0]
            clear = sane and event.clearance_left(clearance, before, leaves) > 0
            if clear and left > 0 and not trying:
                rows.append(row)
                state, before = after, clearance
                continue
            if self._exact and (trying or not clear):
                before = self._from_banks(state)[0]
            tolerance = settings.CONTACT_TOLERANCE
            outcome = event.accept_step(control, left, clearance, before, sane, tolerance, self.near, leaves)
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


POSE = ("x", "y", "psi", "u", "v", "r")


def check_positions(positions: Mapping[str, float], ship: SimulatedShip) -> None:
    known = [actuator.name for actuator in ship.actuators]
    for name in positions:
        if name not in known:
            stem = name.removesuffix("_deg")
            if stem != name and stem in {*POSE, *known, "rudder"}:
                raise InputError(f"there is no argument {name!r}; write {stem}=np.radians(...)")
            hint = did_you_mean(name, known) if known else "; it has none"
            raise InputError(f"there is no argument {name!r}, and no actuator of the model has this name{hint}")


def initial_state(
    ship: SimulatedShip, steering: Steering | None, numbers: dict[str, float], waterway: Waterway | None, pushed: bool
) -> tuple[VoyageIntegrator, tuple[float, ...]]:
    """Return the integrator with every input of its lines, and its initial state."""
    if waterway is not None and not 0 <= (x := numbers["x"]) < waterway.line.length:
        raise InputError(f"x = {x:g} m is not on {waterway.name}, 0 to {waterway.line.length:.0f} m; start on it")
    run = KernelRun(ship, math.inf, math.inf, steering, waterway)
    values = {**dict.fromkeys(INPUTS, 0.0), **numbers, **({PUSH_END: math.inf} if pushed else {})}
    system = run.system(values)
    inputs, channel = run.inputs(system, values)
    order = steering.asked if steering else None
    order = order.begin() if isinstance(order, Controller) else order
    near = settings.NEAR_THE_BANK * float(inputs["width"])
    integrator = VoyageIntegrator(system, inputs, channel, near, order)
    state = run.start(values)
    start = tuple(float(state[name]) for name in system.choices.kept)
    _, y, cosine, sine, u, v, r, *_ = start
    if cosine <= inputs["least_cos"]:
        heading = math.degrees(math.atan2(sine, cosine))
        raise InputError(f"psi = {heading:.1f} deg lies across the canal; start within 85 deg")
    clearance, _ = integrator.clearance(start)
    met = integrator.cause(event.CLOSED, start)
    if met == event.GROUNDED and (clearance < 0 or (clearance == 0 and start[0] != integrator.channel.start)):
        raise InputError(f"y = {y:g} m starts with the hull {-clearance:.3g} m into the bank; start nearer the middle")
    # A step of the smallest number instead of 0: 0 times an infinite rate would be NaN.
    if not all(map(math.isfinite, integrator.stepped(start, math.ulp(0.0))[0])):
        raise InputError(f"the forces of this model are not finite at u = {u:g}, v = {v:g}, r = {r:g}; start otherwise")
    return integrator, start


def check_irrelevant(ship: SimulatedShip, given: Mapping[str, Any]) -> None:
    """Raise if an argument has no effect."""
    terms = ship.model.terms
    relevant = {*START, *INPUTS, *terms.inputs, *terms.names, "length", "beam", "width", *places_of(terms.actuators)}
    relevant |= {actuator.name for actuator in terms.actuators}
    relevant |= {"mass", "inertia", "x_g"} if ship.coriolis else set()
    relevant |= {"depth", "draft", "block_coefficient"} if ship.bottom else set()
    relevant -= {"X"} if ship.surge == "held" else set()
    for name, value in given.items():
        is_zero = name in ("X", "rudder", "heave") and not np.any(value)
        if name not in relevant and not is_zero:
            remedy = "give surge='free', or leave it out" if name == "X" else "leave it out"
            why = "the speed is held" if name == "X" else "no term of this model depends on it"
            raise InputError(f"{name} changes nothing here: {why}; {remedy}")


class VoyageDefaults(NamedTuple):
    speed: float  # Within the tested range, and below choking [m/s]
    duration: float  # Longest time [s]
    dt: float  # Time step [s]
    offset: float  # Largest starting offset of a map [m]


def voyage_defaults(model: Model, speeds: Any = None) -> VoyageDefaults:
    """Return defaults for the ship of a model in its canal, at given speeds if any, each to two digits."""
    ship, canal = model.configuration.ship, model.configuration.canal
    given = np.abs(np.asarray([] if speeds is None else speeds, float))
    given = given[(given > 0) & (given < math.inf)]
    if not given.size:
        low, high = model.data_range.speed or (0.0, math.inf)
        most = settings.DEFAULT_SHARE_OF_CHOKING * choke_speed(model.configuration) if canal.depth else math.inf
        given = np.array([min(max(settings.DEFAULT_FROUDE * math.sqrt(GRAVITY * ship.length), low), high, most)])
    longest = settings.DEFAULT_LENGTHS * ship.length / given.min()
    step = ship.length / given.max() / settings.DEFAULT_STEPS_A_LENGTH
    offset = max(canal.width - ship.beam, 0.0) / 2 * settings.DEFAULT_OFFSET
    return VoyageDefaults(*(float(f"{value:.2g}") for value in (given.max(), longest, step, offset)))


@accept_aliases
def self_propulsion(model: Model, u: float) -> float:
    """Return the revolutions at which thrust balances resistance straight ahead, rudder amidships [1/s].

    Raises an InputError if the model has no propeller, or no revolutions reach the speed.

    Parameters
    ----------
    model, u : Model, float [m/s]
        A model with terms of a propeller; its surge velocity.

    Examples
    --------
    >>> kvlcc2 = nw.published("yasukawa2015_kvlcc2")
    >>> round(float(nw.self_propulsion(kvlcc2, u=1.0)), 1)
    10.1
    """
    from scipy.optimize import brentq

    if not model.terms.propelled:
        raise InputError("this model has no terms of a propeller; there are no revolutions to look for")

    def surplus(revolutions: float) -> float:
        return -model.resistance(u, revolutions=revolutions)

    turns = 2.0 ** np.arange(-10, 20)
    fast = turns[np.asarray(model.forces(Motion.at(u=u), revolutions=turns)["X"]) > 0]
    if not len(fast):
        raise InputError(f"no revolutions drive this ship at {u:g} m/s; check the propeller and the resistance")
    return float(brentq(surplus, 0.0, float(fast[0]))) if surplus(0.0) < 0 else 0.0


def steady_revolutions(model: Model, u: float) -> float | None:
    own = model.configuration.propeller.revolutions if model.configuration.propeller else 0.0
    if not (model.terms.propelled and own > 0 and u > 0):
        return None
    least, most = (model.resistance(u, revolutions=own / (1 + side * settings.OWN_REVOLUTIONS)) for side in (1, -1))
    return None if least >= 0 >= most else self_propulsion(model, u)


def propeller_notes(model: Model, speeds: Any, turns: Any, steering: Steering | None) -> tuple[str, ...]:
    """Return a note if the model's own revolutions are for another speed [m/s]; none if others are given or ordered."""
    own = model.configuration.propeller
    ordered = steering is not None and any(one.name == PROPELLER.name for one in steering.law.ordered)
    if own is None or ordered or (turns is not None and np.any(np.asarray(turns) != own.revolutions)):
        return ()
    pairs = [(u, steady_revolutions(model, u)) for u in dict.fromkeys((float(np.min(speeds)), float(np.max(speeds))))]
    kept = [f"{steady:.3g} keep {u:.3g} m/s straight ahead" for u, steady in pairs if steady is not None]
    if not kept:
        return ()
    first = f"The propeller's {own.revolutions:.3g} revolutions a second are for another speed"
    return (f"{first}: {', '.join(kept)} (--revolutions, in Python revolutions=).",)
