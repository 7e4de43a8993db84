"""Standard errors of an oracle on honest twins: generalised least squares that knows the errors' covariance."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from trust_tank import BANK, DOZEN, FULL, RATE, SIZE, Tank, delta, forces

HULL_OF_Y = ("b_vdot", "b_rdot", "b_v", "b_r", "b_vv", "b_rr", "b_bank")
HULL_OF_N = ("c_rdot", "c_v", "c_r", "c_vv", "c_rr", "c_bank")  # c_vdot is b_rdot
NAMES = (*HULL_OF_Y, *HULL_OF_N)
Honest = Callable[[float], tuple[Sequence[Any], Mapping[str, float], Tank]]
HONEST: dict[str, Honest] = {
    "honest": lambda s: (DOZEN, BANK, Tank(gain=s, zero=0.5 * (s > 0))),
    "gain": lambda s: (FULL, BANK, Tank(gain=s)),
    "zero": lambda s: (FULL, BANK, Tank(zero=s)),
    "outliers": lambda s: (FULL, BANK, Tank(gain=0.02, spikes=s, wander=2.0)),
    "wandering_zero": lambda s: (FULL, BANK, Tank(wander=s)),
    "faint_bank": lambda s: (FULL, {name: value * s for name, value in BANK.items()}, Tank(gain=0.01)),
}


@cache
def oracle(kind: str, strength: float) -> dict[str, float]:
    """Standard error of each coefficient for one that knows how large each error of a run is."""
    runs, bank, tank = HONEST[kind](strength)
    information = np.zeros((len(NAMES), len(NAMES)))
    for run in runs:
        columns = run.columns(RATE)
        motion = {**columns, "cos_psi": np.cos(columns["psi"]), "sin_psi": np.sin(columns["psi"])}
        clean = forces(motion, bank)
        for force in "YN":
            x, covariance = _design(motion, force), _covariance(clean[force], SIZE[force], tank)
            information += x.T @ np.linalg.solve(covariance, x)
    size = np.sqrt(np.diag(information))
    spread = np.sqrt(np.diag(np.linalg.inv(information / np.outer(size, size)))) / size
    return dict(zip(NAMES, spread.tolist(), strict=True))


def _design(motion: Mapping[str, np.ndarray], force: str) -> np.ndarray:
    """Forces by a coefficient of one, in the order of ``NAMES``."""
    x = np.zeros((len(motion["v"]), len(NAMES)))
    for i, name in enumerate(NAMES):
        none = dict.fromkeys((*HULL_OF_Y, *HULL_OF_N, "c_vdot", "a_uu"), 0.0)
        one = {**none, name: 1.0, **({"c_vdot": 1.0} if name == "b_rdot" else {})}
        x[:, i] = forces(motion, one, one, felt=delta(motion))[force]
    return x


def _covariance(force: np.ndarray, size: float, tank: Tank) -> np.ndarray:
    """Covariance of a record's errors: noise, spikes, a zero that wanders, gain, zero."""
    from scipy.linalg import toeplitz

    seconds = np.arange(len(force)) / RATE
    noise = toeplitz(np.exp(-seconds / tank.time) + tank.wander**2 * np.exp(-seconds / 20.0))
    spikes = 400 * tank.spikes * np.eye(len(force))
    return np.asarray(size**2 * (noise + spikes) + tank.gain**2 * np.outer(force, force) + tank.zero**2)
