"""Marching a voyage: RK4 in fixed steps, or SciPy's adaptive eighth-order method as the check on it."""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

State = tuple[float, ...]
"""x, y [m], cos psi, sin psi, u, v [m/s], r [rad/s], rudder angle [rad]."""

Row = tuple[float, State]
"""Time [s] and state."""

Rate = Callable[[State], State]
"""Time derivative of the state."""

Motion = Callable[[float, State, float], Rate]
"""What moves the ship over a step: by its time [s], the state at its start and its length [s]."""

Gap = Callable[[State], float]
"""Positive while the voyage goes on."""

GAP_TOLERANCE = 1e-9
"""How near to contact the end is placed, in metres of gap."""
MOST_TRIES = 60


class Method(Protocol):
    """A way to integrate: yields a row at each time after the first, and last the one where the gap closed."""

    def __call__(self, motion: Motion, start: State, times: Sequence[float], gap: Gap, dt: float) -> Iterator[Row]:
        """Integrate."""


def rk4(motion: Motion, start: State, times: Sequence[float], gap: Gap, dt: float) -> Iterator[Row]:
    """March by classical Runge-Kutta in steps of dt, shortened to meet each output time (ours).

    Parameters
    ----------
    motion : callable
        Gives the right-hand side of each step.
    start : tuple of float
        State at the first time.
    times : sequence of float [s]
        When to report.
    gap : callable
        The voyage ends inside the step in which it turns negative.
    dt : float [s]
        Longest step.
    """
    state = start
    for begin, stop in pairwise(times):
        steps = max(1, math.ceil((stop - begin) / dt - 1e-9))
        h = (stop - begin) / steps
        for i in range(steps):
            rate = motion(begin + i * h, state, h)
            after = rk4_step(rate, state, h)
            if not gap(after) > 0:
                part, end = located(partial(rk4_step, rate, state), h, gap)
                yield begin + i * h + part, end
                return
            state = after
        yield stop, state


def rk4_step(rate: Rate, state: State, h: float) -> State:
    """Take one step of Runge-Kutta of order 4, with the heading brought back to the unit circle (ours).

    Parameters
    ----------
    rate : callable
        Right-hand side.
    state : tuple of float
        Before the step.
    h : float [s]
        The step.
    """
    k1 = rate(state)
    k2 = rate(_moved(state, k1, h / 2))
    k3 = rate(_moved(state, k2, h / 2))
    k4 = rate(_moved(state, k3, h))
    new = [z + h / 6 * (a + 2 * b + 2 * c + d) for z, a, b, c, d in zip(state, k1, k2, k3, k4, strict=True)]
    unit = 1.5 - 0.5 * (new[2] * new[2] + new[3] * new[3])
    new[2] *= unit
    new[3] *= unit
    return tuple(new)


def _moved(state: State, slope: State, h: float) -> State:
    return tuple(z + h * k for z, k in zip(state, slope, strict=True))


def located(step: Callable[[float], State], h: float, gap: Gap) -> tuple[float, State]:
    """Find where inside a step the gap closes: two secants, a bisection, and again (ours).

    Parameters
    ----------
    step : callable
        State after a part of the step.
    h : float [s]
        The whole step.
    gap : callable
        Positive before, not positive after.
    """
    low, high = 0.0, h
    above, below = gap(step(0.0)), gap(step(h))
    for tries in range(MOST_TRIES):
        secant = tries % 3 < 2 and math.isfinite(below)
        guess = low + (high - low) * (above / (above - below) if secant else 0.5)
        found = gap(step(guess))
        if abs(found) < GAP_TOLERANCE:
            return guess, step(guess)
        if found > 0:
            low, above = guess, found
        else:
            high, below = guess, found
    return low, step(low)


def dop853(motion: Motion, start: State, times: Sequence[float], gap: Gap, dt: float) -> Iterator[Row]:
    """March by SciPy's DOP853 at a relative tolerance of 1e-10, the gap as a terminal event (ours).

    Parameters
    ----------
    motion : callable
        Gives the right-hand side at the start, and that is kept.
    start : tuple of float
        State at the first time.
    times : sequence of float [s]
        When to report.
    gap : callable
        The voyage ends where it turns negative.
    dt : float [s]
        Not used: the method chooses its steps.
    """
    from scipy.integrate import solve_ivp

    rate = motion(times[0], start, times[-1] - times[0])

    def closed(_: float, z: Any) -> float:
        return gap(tuple(z))

    closed.terminal = True  # type: ignore[attr-defined]
    found: Any = solve_ivp(
        lambda _, z: rate(tuple(z)), (times[0], times[-1]), start, method="DOP853", t_eval=times[1:],
        events=closed, rtol=1e-10, atol=1e-12,
    )  # fmt: skip
    for t, z in zip(found.t, np.transpose(found.y), strict=True):
        yield float(t), tuple(z.tolist())
    if found.t_events[0].size:
        yield float(found.t_events[0][0]), tuple(found.y_events[0][0].tolist())


METHODS: dict[str, Method] = {"rk4": rk4, "dop853": dop853}
