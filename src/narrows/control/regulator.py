"""Regulator: a control law of the rudder, its gains by the Riccati equation of the linear ship, for one or many."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from itertools import pairwise
from math import inf, radians
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, shown
from narrows.base.results import BaseSummary
from narrows.codegen.linearisation import LINEARISED
from narrows.control import settings
from narrows.control.linear_system import LinearSystem
from narrows.control.steady_course import check_holds, check_rudder, linearize
from narrows.model.model import Model
from narrows.quantities.arithmetic import choice, clip, maximum
from narrows.simulation.controllers import LAST_ORDER, ORDER_TOLERANCE, Named
from narrows.simulation.ship import SimulatedShip

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

TURNED = ("psi", "v", "rudder")
FEEDBACK = ("y", "psi", "v", "r", "rudder", "integral")
# Weights of these states, scaled [1].
SCALED_WEIGHTS = np.diag([1.0, 1.0, 0.0, 0.0, 1.0, 1.0])


@accept_aliases
@dataclass(frozen=True)
class RegulatorWeights:
    """Weights of a regulator by Bryson's rule, and its use of the bank force.

    The defaults were tuned by simulated voyages of the KCS at full size (``python decisions/regulator_weights.py``).
    """

    # Each of the first three is the deviation that costs as much as each of the others.
    offset: float = 1.0  # Deviation from the line [half beams]
    heading_deg: float = 2.3  # Deviation from the course [deg]
    rudder_deg: float = 14.0  # Deviation from the rudder angle of the course [deg]
    stroke_time: float = 0.095  # Time in which that rudder is put over [ship lengths]; limited by the gear
    integral_time: float = 1.7  # Duration of the offset [ship lengths]
    # Share of the model's slope of the bank force by offset, the least certain slope [1]: 0 assumes a constant force.
    # If the share leaves the model's ship unstable, the whole slope is used.
    bank: float = 0.5
    unwinding_time: float = 0.26  # Time in which the integral is reduced if the gear cannot follow [ship lengths]

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not (0 <= value <= 1 if entry.name == "bank" else 0 < value < inf):
                span = "0 to 1" if entry.name == "bank" else "a number over 0"
                raise InputError(f"weights of a regulator: {entry.name} = {value} is none; give {span}")


DEFAULT_WEIGHTS = RegulatorWeights()


@dataclass(frozen=True)
class HeldLine:
    """A line to hold and its gains; every number may be an array over many ships."""

    y: Any  # Offset to starboard of the line [m]
    # Rate of the rudder per deviation of offset, heading, sway velocity, yaw rate, rudder, and per integral of the
    # offset [rad/(s m), 1/s, rad/m, 1, 1/s, rad/(s2 m)]
    gains: tuple[Any, ...]
    rudder: Any = 0.0  # Rudder angle of the steady course [rad]
    psi: Any = 0.0  # Its heading [rad]
    v: Any = 0.0  # Its sway velocity [m/s]
    # Change of the course's heading, sway velocity and rudder per yaw rate of the waterway [s, m, s]
    turning: tuple[Any, ...] = (0.0, 0.0, 0.0)
    start: float = 0.0  # Time from which it is held; the first line also holds before [s]

    def __post_init__(self) -> None:
        if len(self.gains) != len(FEEDBACK) or len(self.turning) != len(TURNED):
            raise InputError(f"a regulator has gains of {', '.join(FEEDBACK)}, turns of {', '.join(TURNED)}; give each")

    def numbers(self) -> dict[str, Any]:
        held = {f"held_{name}": getattr(self, name) for name in ("y", "rudder", "psi", "v")}
        held |= {f"by_{name}": gain for name, gain in zip(FEEDBACK, self.gains, strict=True)}
        return held | {f"turn_{name}": slope for name, slope in zip(TURNED, self.turning, strict=True)}


@dataclass(frozen=True, repr=False)
class Regulator(BaseSummary):
    """A track pilot: the rudder's rate is proportional to the deviations and to the integral of the offset.

    The gains scale with speed as if every force were proportional to its square. The steady turn of a bend ahead is
    added to the course. If the gear cannot follow, the integral is reduced to an attainable value (anti-windup).
    """

    lines: Sequence[HeldLine]  # The line to hold, or several, each from its own time on
    u: Any  # Design surge velocity [m/s]
    lead: Any  # Time that it looks ahead for bends of a waterway [s]
    unwinding: Any  # Time in which the integral is reduced if the gear is at a limit [s]
    integral: Any = 0.0  # Integral of the offset at the start [m s]

    def __post_init__(self) -> None:
        starts = [line.start for line in self.lines]
        if not starts or any(after <= before for before, after in pairwise(starts)):
            raise InputError("a regulator holds one line or more, each from a later time than the last; give them")
        own = [self.u, self.lead, self.unwinding, self.integral, *starts]
        numbers = [*own, *(number for line in self.lines for number in line.numbers().values())]
        if not all(np.isfinite(number).all() for number in numbers):
            raise InputError("a regulator with a number that is not finite steers nothing; give finite ones")
        for name in ("u", "unwinding"):
            if not (np.asarray(getattr(self, name)) > 0).all():
                raise InputError(f"a regulator with {name} = {getattr(self, name)} steers nothing; give {name} over 0")

    def summary(self) -> str:
        more = f", {len(self.lines)} lines one after the other" if len(self.lines) > 1 else ""
        return f"y = {self.lines[0].y} at u = {self.u}{more}"

    def parameters(self) -> Mapping[str, Any]:
        numbers = {"made_for": self.u, "lead": self.lead, "unwinding": self.unwinding}
        for index, line in enumerate(self.lines):
            numbers |= {f"{name}_{index}": value for name, value in line.numbers().items()}
            numbers |= {f"start_{index}": line.start} if index else {}
        return numbers

    def memory(self, start: Named) -> Named:
        return {"integral": self.integral, LAST_ORDER: start["rudder"]}

    def orders(self, at: Any) -> tuple[Named, Named]:
        speed = maximum(at.u, settings.SLOWEST * at.made_for)
        pace, share = at.u + at.current, speed / at.made_for
        turn = at.water("curvature", at.x + at.lead * pace) * pace
        held = {name: self._now(at, name) for name in self.lines[0].numbers()}
        off_y = at.y - held["held_y"]
        off_psi = at.psi - held["held_psi"] - held["turn_psi"] * turn / share
        off_v = at.v - held["held_v"] * share - held["turn_v"] * turn
        # The rate is added to the last order, not to the indicated angle, which lags by the delay of the gear:
        # otherwise only dt / (dt + delay) of the rate would be ordered.
        last = getattr(at, LAST_ORDER)
        off_rudder = last - held["held_rudder"] - held["turn_rudder"] * turn / share
        by_integral = held["by_integral"] * share * share
        wanted = -(
            share * (held["by_y"] * off_y + held["by_psi"] * off_psi + held["by_rudder"] * off_rudder)
            + held["by_v"] * off_v + held["by_r"] * (at.r - turn) + by_integral * at.integral
        )  # fmt: skip
        # The rudder's own term is taken at the end of the step, so that a long step does not overshoot.
        move = at.dt * wanted / (1 + at.dt * share * held["by_rudder"])
        order = clip(last + clip(move, at.dt * at.rudder_rate), at.rudder_limit)
        wound = (move - (order - last)) / (by_integral * at.unwinding)
        return {"rudder": order}, {"integral": at.integral + at.dt * off_y + wound, LAST_ORDER: order}

    def _now(self, at: Any, name: str) -> Any:
        value = getattr(at, f"{name}_0")
        for index in range(1, len(self.lines)):
            begun = at.t + ORDER_TOLERANCE * at.dt - getattr(at, f"start_{index}")
            value = choice(begun, getattr(at, f"{name}_{index}"), value)
        return value


@accept_aliases
def regulator(
    model: Model, y: Any, u: float, *, waterway: "Waterway | None" = None, at: float = 0.0,
    weights: RegulatorWeights = DEFAULT_WEIGHTS, **values: float,
) -> Regulator:  # fmt: skip
    """Return the regulator that holds a ship on a line: linear-quadratic on the rudder's rate.

    The law needs the sway velocity, as a track pilot with a good position fix has it.

    Source: Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods, for weights and integrals; Åström and
    Hägglund (2006), Advanced PID Control, for the back-calculation.

    Parameters
    ----------
    model, u : Model, float [m/s]
        A model with terms of a rudder; its surge velocity through the water.
    y : float or pairs (time [s], offset [m])
        Offset to starboard of the canal's centreline or of the waterway's line; each pair holds from its time on.
    waterway, at : Waterway, float [m], optional
        Waterway instead of the model's own canal, and the place along it for which the gains are computed.
    weights : RegulatorWeights
        Weights of the cost.
    **values : float [SI]
        As for ``linearize``.
    """
    check_rudder(model)
    try:
        pairs = [(float(time), float(offset)) for time, offset in y] if np.ndim(y) else [(0.0, y)]
    except (TypeError, ValueError):
        raise InputError("the line to hold is an offset [m], or pairs of time [s] and offset; mend it") from None
    about = partial(linearize, model, u=u, waterway=waterway, at=at, surge="held", **values)
    lines = tuple(held_line(model, about(y=offset), time, weights) for time, offset in pairs)
    passing = model.configuration.ship.length / u
    return Regulator(lines, u, settings.LEAD_TIME * passing, weights.unwinding_time * passing)


def held_line(
    model: Model, linear: LinearSystem, start: float = 0.0, weights: RegulatorWeights = DEFAULT_WEIGHTS
) -> HeldLine:  # fmt: skip
    course = linear.course
    check_holds(model, course["rudder"], course["y"], course["u"])
    gains = regulator_gains(model, linear, weights)
    # On a steady turn psi, v and the rudder keep y, v and r constant.
    balanced, b = [0, 2, 3], linear.B[:, linear.controls.index("rudder")]
    by_choice = np.column_stack([linear.A[balanced, 1], linear.A[balanced, 2], b[balanced]])
    turning = np.linalg.solve(by_choice, -linear.A[balanced, 3]).tolist()
    psi, v, rudder = (course[name] - by_turn * course["r"] for name, by_turn in zip(TURNED, turning, strict=True))
    return HeldLine(course["y"], gains, rudder, psi, v, tuple(turning), start)


def gains_of(
    ship: SimulatedShip, motion: np.ndarray, push: np.ndarray, speed: np.ndarray, weights: RegulatorWeights
) -> np.ndarray:
    """Gains of the states ``FEEDBACK``, (n, 6), of systems (n, 6, 6) driven by the rudder rate; NaN for none."""
    # Each state is scaled to its weight, and time to ship lengths: the entries are of order 1.
    hull, gear = ship.model.configuration.ship, ship.model.configuration.gear
    time, off, rudder = hull.length / speed, weights.offset * hull.beam / 2, radians(weights.rudder_deg)
    size = np.column_stack(np.broadcast_arrays(
        off, radians(weights.heading_deg), speed, speed / hull.length, rudder, off * weights.integral_time * time
    ))  # fmt: skip
    rate = np.minimum(rudder / (weights.stroke_time * time), gear.rate)
    scaled = time[:, None, None] * motion * size[:, None, :] / size[:, :, None]
    drive = (time * rate)[:, None] * push / size
    reduced = scaled.copy()
    reduced[:, :4, 0] *= weights.bank
    gains = best_gains(reduced, drive, SCALED_WEIGHTS)
    lost = ~stabilised(scaled, drive, gains)
    gains[lost] = best_gains(scaled[lost], drive[lost], SCALED_WEIGHTS)
    return np.asarray(gains * rate[:, None] / size)


def stacked_gains(
    ship: SimulatedShip, values: Mapping[str, Any], course: Mapping[str, Any], weights: RegulatorWeights
) -> np.ndarray:
    """Return the gains of a regulator for each of many courses, (n, 6)."""
    linear = ship.linearisation({**ship.values(), **values})
    matrix = linear.linear({**course, "psi": -np.arctan(course["v"] / course["u"])})
    states, speed = [LINEARISED.index(name) for name in FEEDBACK[:4]], np.asarray(course["u"], float)
    rows = np.broadcast_to(matrix, (len(speed), *matrix.shape[-2:]))[:, states]
    rudder = len(LINEARISED) + linear.controlled.index("rudder")
    return gains_of(ship, *rate_driven(rows[:, :, states], rows[:, :, rudder]), speed, weights)


def regulator_gains(model: Model, linear: LinearSystem, weights: RegulatorWeights = DEFAULT_WEIGHTS) -> tuple[Any, ...]:
    """Return the gains of a regulator on one course, [rad/(s m), 1/s, rad/m, 1, 1/s, rad/(s2 m)]."""
    motion, push = rate_driven(linear.A[None], linear.B[None, :, linear.controls.index("rudder")])
    gains = gains_of(SimulatedShip(model), motion, push, np.array([linear.course["u"]]), weights)[0]
    if not np.isfinite(gains).all():
        where = f"at y = {linear.course['y']:g} m and {linear.course['u']:g} m/s"
        raise InputError(f"no regulator holds this ship {where}: its rudder has no effect there")
    return tuple(gains.tolist())


def rate_driven(A: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return systems of ``FEEDBACK`` driven by the rudder's rate, (n, 6, 6) and (n, 6), from those of y, psi, v, r."""
    driven, push = np.zeros((len(A), len(FEEDBACK), len(FEEDBACK))), np.zeros((len(A), len(FEEDBACK)))
    driven[:, :4, :4], driven[:, :4, 4] = A, b
    driven[:, 5, 0], push[:, 4] = 1.0, 1.0
    return driven, push


def stabilised(motion: np.ndarray, push: np.ndarray, gains: np.ndarray) -> np.ndarray:
    """Return which of many systems the gains stabilise (n,); false if a gain is NaN."""
    known = np.isfinite(gains).all(axis=1) & np.isfinite(motion).all(axis=(1, 2))
    poles = np.linalg.eigvals(np.where(known[:, None, None], motion - push[:, :, None] * gains[:, None, :], 0.0))
    return np.asarray(known & (poles.real.max(axis=1) < -settings.LEAST_DECAY * np.abs(poles).max(axis=1)))


def best_gains(motion: np.ndarray, push: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the optimal gains of many systems with one input each, (n, k); NaN if nothing stabilises a system."""
    gains = np.full(push.shape, np.nan)
    known = np.isfinite(motion).all(axis=(1, 2)) & np.isfinite(push).all(axis=1)
    motion, push = motion[known], push[known]
    cost = riccati_solutions(motion, push[:, :, None] * push[:, None, :], weights)
    found = np.einsum("ni,nij->nj", push, cost)
    gains[known] = np.where(stabilised(motion, push, found)[:, None], found, np.nan)
    return gains


def riccati_solutions(motion: np.ndarray, effect: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the solutions of many continuous-time Riccati equations from A, B R^-1 B' and Q."""
    # By the stable half of the eigenvectors of the Hamiltonian matrix. Without a stabilising solution the result is
    # another matrix. Arnold and Laub (1984), Generalized eigenproblem algorithms, Proceedings of the IEEE 72(12).
    size = motion.shape[-1]
    costs = np.broadcast_to(weights, motion.shape)
    values, vectors = np.linalg.eig(np.block([[motion, -effect], [-costs, -motion.swapaxes(1, 2)]]))
    order = np.argsort(values.real, axis=1)[:, None, :size]
    stable = np.take_along_axis(vectors, order, axis=2)
    return np.asarray((stable[:, size:] @ np.linalg.pinv(stable[:, :size])).real)


class StateFeedback(NamedTuple):
    K: np.ndarray  # (controls, states) Gains
    S: np.ndarray  # (states, states) Solution of the Riccati equation
    E: np.ndarray  # (states,) Poles of the closed loop [1/s]


@accept_aliases
def lqr(linear: Any, Q: Any, R: Any, *controls: str, **course: float) -> StateFeedback:
    """Return the gains that minimise the integral of x'Qx + u'Ru, as python-control's ``lqr`` does.

    They are K (controls, states) of u = -K x, with S, the solution of the Riccati equation (states, states), and E, the
    poles of the closed loop [1/s]. ``regulator`` makes a whole helm with gear, integral and tuned weights.

    Source: Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods.

    Raises an InputError if a linear system is given with a course, weights have the wrong shape, or no gains hold the
    ship.

    Parameters
    ----------
    linear, **course : LinearSystem or Model, float
        Linear system about one course, or a model with ``y`` [m], ``u`` [m/s] ... as for ``linearize``.
    Q, R : arrays
        Weights of ``linear.states`` and of the controls: matrices, their diagonals, or a number for each.
    *controls : str
        Controls to use, such as ``"rudder"``; those of ``linear.controls`` unless given.
    """
    if not isinstance(linear, LinearSystem) and not hasattr(linear, "linearize"):
        raise InputError(f"linear = {shown(linear)} is neither a linear system nor a model; give one")
    if isinstance(linear, LinearSystem) and course:
        raise InputError(f"a linear system has its course; leave out {', '.join(course)}, or give the model")
    system: LinearSystem = linear if isinstance(linear, LinearSystem) else linear.linearize(**course)
    A, B = system.matrices(*controls)
    if not B.size:
        raise InputError("the model has no controls, so no gains; nw.borrow_rudder adds a rudder")
    weights = []
    for name, given, names in (("Q", Q, system.states), ("R", R, controls or system.controls)):
        matrix = np.asarray(given, float)
        matrix = matrix if matrix.ndim > 1 else np.diag(matrix if matrix.ndim else np.full(len(names), given))
        if matrix.shape != (len(names), len(names)):
            raise InputError(f"{name} has the shape {matrix.shape}; give a row and a column for {', '.join(names)}")
        weights.append(matrix)
    from_cost = np.linalg.pinv(weights[1]) @ B.T
    (riccati,) = riccati_solutions(A[None], (B @ from_cost)[None], weights[0])
    gains = from_cost @ riccati
    poles = np.linalg.eigvals(A - B @ gains)
    if not poles.real.max() < -settings.LEAST_DECAY * np.abs(poles).max():
        raise InputError("no gains hold this ship with these weights; give R over 0, and Q over 0 for y")
    return StateFeedback(gains, riccati, poles)
