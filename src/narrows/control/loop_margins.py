"""Gain margin, phase margin and delay margin of a loop, by its frequency response."""

import math
from collections.abc import Callable

import numpy as np

from narrows.control.settings import FREQUENCIES

# Frequency response of an opened loop, with the sign of negative feedback, at angular frequencies [rad/s].
Response = Callable[[np.ndarray], np.ndarray]


def loop_margins(response: Response, lowest: float, highest: float) -> dict[str, float]:
    """Return margins of gain, phase and delay, and the least distance from -1 with its inverse."""
    # Astrom and Murray (2021), Feedback Systems, 2nd ed., section 10.3. Crossings between two frequencies of a fine
    # grid are refined by bisection.
    omega = np.geomspace(lowest, highest, FREQUENCIES)
    loop = response(omega)

    def crossings(value: Callable[[np.ndarray], np.ndarray], where: np.ndarray) -> np.ndarray:
        signs = value(loop) > 0
        first = np.flatnonzero((signs[1:] != signs[:-1]) & where[:-1])
        low, high, start = omega[first], omega[first + 1], signs[first]
        for _ in range(40):
            middle = np.sqrt(low * high)
            same = (value(response(middle)) > 0) == start if len(middle) else np.zeros(0, bool)
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return np.sqrt(low * high)

    at_one = crossings(lambda at: np.abs(at) - 1.0, np.ones(len(omega), bool))
    # Phase crossing at half a turn: the imaginary part changes its sign while the real part is negative.
    at_half_turn = crossings(np.imag, loop.real < 0)
    factors = 1.0 / np.abs(response(at_half_turn)) if len(at_half_turn) else np.zeros(0)
    phase = np.angle(-response(at_one)) if len(at_one) else np.zeros(0)
    # A delay turns the loop clockwise: the delay margin is the clockwise angle to half a turn.
    delays = np.mod(phase, 2 * math.pi) / at_one
    distance = float(np.abs(1.0 + loop).min())
    return {
        "gain": float(factors[factors > 1].min(initial=math.inf)),
        "gain_down": float(factors[factors < 1].max(initial=0.0)),
        "phase_deg": float(np.degrees(np.abs(phase)).min(initial=math.inf)),
        "delay": float(delays.min(initial=math.inf)),
        "distance": distance,
        "sensitivity_peak": 1.0 / distance,
    }
