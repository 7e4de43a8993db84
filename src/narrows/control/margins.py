"""How far a closed loop is from instability: margins of gain, phase and delay, by python-control."""

import numpy as np

from narrows.errors import needs


def loop_margins(A: np.ndarray, B: np.ndarray, gains: np.ndarray) -> dict[str, float]:
    """Return how far a loop closed by ``-gains x`` is from instability, broken at its one input."""
    # A (n, n); B (n, 1); gains (n,)
    with needs("control", "margins"):
        import control
    loop = control.ss(A, B, gains[None, :], 0)
    gain, phase, distance, _, at_gain, _ = control.stability_margins(loop, returnall=True)
    over, under = gain[gain > 1], gain[(gain > 0) & (gain < 1)]
    # A delay turns the loop clockwise: a phase margin counts by how far it is to half a turn, clockwise.
    delays = np.radians(np.mod(phase, 360.0)) / np.where(at_gain > 0, at_gain, np.inf)
    return {
        "gain": float(over.min(initial=np.inf)),
        "gain_down": float(under.max(initial=0.0)),
        "phase_deg": float(np.abs(phase).min(initial=np.inf)),
        "delay": float(delays[delays > 0].min(initial=np.inf)),
        "distance": float(np.min(distance, initial=np.inf)),
    }
