"""Models for tests of the engine: shapes that published terms lack, a rudder, a propeller; rates without a compiler."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

import narrows as nw
from narrows.codegen.free_motion import ACCELERATIONS, STATE
from narrows.quantities import names as dim
from narrows.quantities.names import MOTION
from narrows.waterway import Bank, Centreline, Waterway


def cross_flow(u, v):
    return -u * v


def odd_shapes(y, cos_psi, v, r, width, draft, heave):
    """Roots, odd powers, a number to a power, a reciprocal, a plain + and a NumPy number."""
    bulge = (1.5 + cos_psi) ** 0.5 / (1 + (y / width) ** 2) ** 1.5
    return +bulge * np.float64(0.3) * 2 ** (-abs(v) / 3) * r**5 * (draft + heave) ** -1 - 0.1 * v


OWN = nw.PAPER.with_terms(
    "own",
    surge=[nw.Term("a_vr", "a_{vr}", lambda v, r: v * r, dim.KG)],
    sway=[
        nw.Term("b_uv", "b_{uv}", cross_flow, dim.KG_PER_M),
        nw.Term("b_odd", "b_o", odd_shapes, dim.NUMBER, kind=nw.TermKind.BANK),
    ],
)
TABLES = {table.name: table for table in (nw.PAPER, nw.TAPERED, OWN)}
EXTRA = {"a_udot": 20.0, "a_u": 3.0, "a_vr": 40.0, "b_uv": 60.0, "b_odd": 900.0}
MASS, SURGE_INERTIA = 245.0, 280.0
PUSHES = {"X_in": 3.0, "Y_in": -2.0, "N_in": 5.0}


def model_of(table: nw.TermTable) -> nw.Model:
    """The published coefficients, with nothing at zero."""
    paper = nw.published("mikkelsen2025_dtc")
    coefficients = {**paper.coefficients, **EXTRA}
    configuration = replace(paper.configuration, ship=replace(paper.configuration.ship, mass=MASS))
    return nw.Model(configuration, table, {name: coefficients[name] for name in table.names})


def values_of(model: nw.Model) -> dict[str, float]:
    """Everything that the equations ask for."""
    return {**model.configuration.values(), **model.coefficients, "surge_inertia": SURGE_INERTIA, **PUSHES}


def states(count: int) -> dict[str, np.ndarray]:
    """Random states on both sides, by the names of the equations."""
    draw = np.random.default_rng(1)
    ranges = {"x": 9.0, "y": 2.6, "psi": 1.2, "v": 0.4, "r": 0.3}
    state = {name: draw.uniform(-top, top, count) for name, top in ranges.items()}
    psi = state.pop("psi")
    state |= {"cos_psi": np.cos(psi), "sin_psi": np.sin(psi), "u": draw.uniform(0.3, 1.5, count)}
    return {name: state[name] for name in STATE}


def rates_by_hand(model: nw.Model, state: dict[str, float], surge: str, coriolis: bool) -> list[float]:
    """Solve M (udot, vdot, rdot) = f + F_in with the forces that the terms themselves give: floats, one state."""

    def force(**accelerations: float) -> np.ndarray:
        named = {name: value for name, value in state.items() if name in MOTION}
        return np.array(list(model.forces(nw.Motion(**named, **accelerations)).values()), float)

    still = force()
    mass = np.stack([still - force(**{name: 1.0}) for name in ACCELERATIONS.values()], axis=1)
    mass[0, 0] += SURGE_INERTIA
    rest = still + list(PUSHES.values())
    if coriolis:
        rest += MASS * state["r"] * np.array([state["v"], -state["u"], 0.0])
    part = slice(0, 3) if surge == "free" else slice(1, 3)
    accelerations = np.zeros(3)
    accelerations[part] = np.linalg.solve(mass[part, part], rest[part])
    u, v, r, c, s = (state[name] for name in ("u", "v", "r", "cos_psi", "sin_psi"))
    return [u * c - v * s, u * s + v * c, -r * s, r * c, *accelerations]


def steered() -> nw.Model:
    """The published hull with the terms and a rudder of ``steered``."""
    dtc = nw.published("mikkelsen2025_dtc")
    known = {**dtc.coefficients, "b_uv": 100.0, "b_ur": 118.0, "c_uv": 414.0, "c_ur": 84.9}
    known |= {"a_helm": 5.0, "b_helm": 6.0, "c_helm": 2.9}
    ship = replace(dtc.configuration.ship, flow_straightening=0.5, mass=MASS)
    configuration = replace(dtc.configuration, ship=ship, steering=nw.SteeringGear(25.0, 18.0))
    return nw.Model(configuration, nw.STEERED, {name: known.get(name, 30.0) for name in nw.STEERED.names})


def mmg() -> nw.Model:
    """KVLCC2 with the paper's bank."""
    own = nw.published("yasukawa2015_kvlcc2")
    configuration = replace(own.configuration, canal=nw.Canal(14.0))
    table = nw.with_bank(nw.MMG, "delta")
    bank = dict(zip((term.name for term in table.terms if term.from_bank), (1.07, 0.13), strict=True))
    return nw.Model(configuration, table, {**own.coefficients, **bank})


ACTUATED = {"steered": steered, "mmg+delta": mmg}


@cache
def bent(length: float, width: float) -> Waterway:
    """A bend, banks that narrow and widen unlike, a current."""
    north = np.linspace(0, 60 * length, 121)
    line = Centreline(np.stack([3 * length * np.sin(north / (10 * length)), north], axis=1))
    s = line.length * np.array([0.0, 0.2, 0.3, 0.55, 0.7, 1.0])
    starboard, port = width * np.array([[0.5, 0.5, 0.45, 0.5, 0.6, 0.5], [0.5, 0.45, 0.5, 0.55, 0.5, 0.5]])
    return Waterway(line, Bank("starboard", s, starboard), Bank("port", s, port), current=0.1)


def function_of(text: str, name: str, functions: Mapping[str, Callable[..., Any]]) -> Callable[..., Any]:
    """Make a printed function of its text and the elementary functions that it calls."""
    scope: dict[str, Any] = dict(functions)
    exec(text, scope)
    return scope[name]
