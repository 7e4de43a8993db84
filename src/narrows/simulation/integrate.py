"""Marching a voyage: RK4 in fixed steps, or SciPy's adaptive eighth-order method as the check on it."""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import pairwise
from typing import Any, Protocol

from narrows.simulation.inputs import Forces

State = tuple[float, ...]
"""x, y [m], cos psi, sin psi, u, v [m/s], r [rad/s]."""

Rate = Callable[[State, tuple[float, float, float]], State]
"""Time derivative of the state under surge force, sway force and yaw moment."""

Gap = Callable[[State], float]
"""Positive while the voyage goes on."""

GAP_TOLERANCE = 1e-9
"""How near to contact the end is placed, in metres of gap."""


class Method(Protocol):
    """A way to integrate: yields (t, state) at each output time, and last where the gap closed."""

    def __call__(
        self, rate: Rate, start: State, times: Sequence[float], forces: Forces, gap: Gap, dt: float
    ) -> Iterator[tuple[float, State]]:
        """Integrate."""


def rk4(
    rate: Rate, start: State, times: Sequence[float], forces: Forces, gap: Gap, dt: float
) -> Iterator[tuple[float, State]]:
    """Classical Runge-Kutta in steps of dt, shortened to meet each output time (ours).

    Parameters
    ----------
    rate : callable
        Right-hand side.
    start : tuple of float
        State at the first time.
    times : sequence of float [s]
        When to report.
    forces : callable
        Inputs over time.
    gap : callable
        The voyage ends inside the step in which it turns negative.
    dt : float [s]
        Longest step.
    """
    state = start
    yield times[0], state
    for begin, stop in pairwise(times):
        steps = max(1, math.ceil((stop - begin) / dt - 1e-9))
        h = (stop - begin) / steps
        for i in range(steps):
            t = begin + i * h
            after = rk4_step(rate, state, t, h, forces)
            if not gap(after) > 0:
                yield located(partial(_part_of_step, rate, state, t, forces), h, gap)
                return
            state = after
        yield stop, state


def rk4_step(rate: Rate, state: State, t: float, h: float, forces: Forces) -> State:
    """One step of Runge-Kutta of order 4, with the heading brought back to the unit circle (ours).

    Parameters
    ----------
    rate : callable
        Right-hand side.
    state : tuple of float
        Before the step.
    t, h : float [s]
        Time and step.
    forces : callable
        Inputs over time.
    """
    early, middle, late = forces(t), forces(t + h / 2), forces(t + h)
    k1 = rate(state, early)
    k2 = rate(_moved(state, k1, h / 2), middle)
    k3 = rate(_moved(state, k2, h / 2), middle)
    k4 = rate(_moved(state, k3, h), late)
    new = [z + h / 6 * (a + 2 * b + 2 * c + d) for z, a, b, c, d in zip(state, k1, k2, k3, k4, strict=True)]
    unit = 1.5 - 0.5 * (new[2] * new[2] + new[3] * new[3])
    new[2] *= unit
    new[3] *= unit
    return tuple(new)


def _part_of_step(rate: Rate, state: State, t: float, forces: Forces, part: float) -> tuple[float, State]:
    return t + part, rk4_step(rate, state, t, part, forces)


def _moved(state: State, slope: State, h: float) -> State:
    return tuple(z + h * k for z, k in zip(state, slope, strict=True))


def located(at: Callable[[float], tuple[float, State]], h: float, gap: Gap) -> tuple[float, State]:
    """Find where inside a step the gap closes, by bisection with secants (ours).

    Parameters
    ----------
    at : callable
        Time and state a part of the step further.
    h : float [s]
        The step.
    gap : callable
        Positive before, not positive after.
    """
    low, high, best = 0.0, h, at(h)
    above, below = gap(at(0.0)[1]), gap(best[1])
    for i in range(60):
        guess = low + (high - low) * above / (above - below) if i % 3 < 2 and math.isfinite(below) else (low + high) / 2
        best = at(guess)
        found = gap(best[1])
        if abs(found) < GAP_TOLERANCE:
            break
        if found > 0:
            low, above = guess, found
        else:
            high, below = guess, found
    return best


def dop853(
    rate: Rate, start: State, times: Sequence[float], forces: Forces, gap: Gap, dt: float
) -> Iterator[tuple[float, State]]:
    """SciPy's DOP853 at a relative tolerance of 1e-10, the gap as a terminal event (ours).

    Parameters
    ----------
    rate : callable
        Right-hand side.
    start : tuple of float
        State at the first time.
    times : sequence of float [s]
        When to report.
    forces : callable
        Inputs over time.
    gap : callable
        The voyage ends where it turns negative.
    dt : float [s]
        Longest step, as jumps of the inputs must not be passed over.
    """
    from scipy.integrate import solve_ivp

    def event(t: float, z: State) -> float:
        return gap(tuple(z))

    event.terminal = True  # type: ignore[attr-defined]
    found: Any = solve_ivp(  # type: ignore[call-overload]
        lambda t, z: rate(tuple(z), forces(t)), (times[0], times[-1]), start, method="DOP853", t_eval=times,
        events=event, rtol=1e-10, atol=1e-12, max_step=max(dt, (times[-1] - times[0]) / 1000),
    )  # fmt: skip
    yield from zip(found.t.tolist(), map(tuple, found.y.T.tolist()), strict=True)
    if found.t_events[0].size:
        yield float(found.t_events[0][0]), tuple(found.y_events[0][0].tolist())


METHODS: dict[str, Method] = {"rk4": rk4, "dop853": dop853}
