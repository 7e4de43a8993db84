"""SciPy's DOP853 on the rates of a ship in a straight canal: the integrator that voyages are held to.

The rates are those that the package prints; ``tests/unit/test_codegen.py`` holds them to the terms themselves. Another
integration, that shares nothing with the package's compiler, is in ``tests/engine``.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

import narrows as nw
from narrows.simulation.ship import SimulatedShip

STATE = ("x", "y", "psi", "u", "v", "r")
Pushed = Callable[[float], tuple[float, float, float]]


@dataclass(frozen=True)
class Integrated:
    """Columns of a voyage; the side of its grounding, or None where its time ran out."""

    t: np.ndarray
    x: np.ndarray
    y: np.ndarray
    psi: np.ndarray
    u: np.ndarray
    v: np.ndarray
    r: np.ndarray
    side: str | None


def rates_of(model: nw.Model, rudder: float = 0.0, **options: object) -> Callable[..., np.ndarray]:
    """Return the rates of ``STATE`` as a function of it and of forces from outside."""
    ship = SimulatedShip(model, **options)  # type: ignore[arg-type]
    system = ship.system(pushed="until")
    numbers = system.constants(ship.values(rudder=rudder))
    names, function = system.scalar.RATES_INPUTS, system.scalar.rates

    def rates(state: Sequence[float], forces: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> np.ndarray:
        x, y, psi, u, v, r = map(float, state)
        given = {**numbers, **dict(zip(("X_in", "Y_in", "N_in"), forces, strict=True))}
        dx, dy, _, _, du, dv, dr = function(
            x, y, math.cos(psi), math.sin(psi), u, v, r, *(given[name] for name in names)
        )
        return np.array([dx, dy, r, du, dv, dr])

    return rates


def integrated(
    model: nw.Model, duration: float = 60.0, *, forces: Pushed = lambda t: (0.0, 0.0, 0.0), jumps: Sequence[float] = (),
    rudder: float = 0.0, options: dict | None = None, **start: float,
) -> Integrated:  # fmt: skip
    """Integrate a voyage until a corner of the hull meets a bank; no step reaches over a jump of the forces."""
    hull, width = model.configuration.ship, model.configuration.canal.width
    rates = rates_of(model, rudder, **(options or {}))

    def room(_: float, z: np.ndarray) -> float:
        reach = hull.length / 2 * abs(math.sin(z[2])) + hull.beam / 2 * math.cos(z[2])
        return width / 2 - abs(float(z[1])) - reach

    room.terminal = True  # type: ignore[attr-defined]
    state, parts = [start.get(name, 1.0 if name == "u" else 0.0) for name in STATE], []
    ends = [0.0, *jumps, duration]
    for begin, end in pairwise(ends):
        pushed = forces((begin + end) / 2)
        part = solve_ivp(
            lambda t, z, pushed=pushed: rates(z, pushed), (begin, end), state, "DOP853", events=room, rtol=1e-11,
            atol=1e-13,
        )  # fmt: skip
        parts.append(part)
        if part.status == 1:
            break
        state = part.y[:, -1]
    touched = parts[-1].status == 1
    columns = np.concatenate([part.y for part in parts], axis=1)
    t = np.concatenate([part.t for part in parts])
    side = ("starboard" if columns[1, -1] > 0 else "port") if touched else None
    return Integrated(t, *columns, side)
