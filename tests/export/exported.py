"""Models of every kind of table for what leaves the package, each with nothing at zero, and a waterway with bends."""

from dataclasses import replace
from functools import cache

import numpy as np

import narrows as nw
from engine_models import OWN
from narrows.model.tables import table_named
from narrows.waterway import Bank, Centreline, Waterway

HULL = ("paper", "speed", "mixed", "crossflow", "paper+tapered", "paper+keel_gap", "own")
STEERED = ("steered", "speed+helm", "mmg+delta")
TABLES = (*HULL, *STEERED)
SPEEDS = {"mmg+delta": 1.1}
COEFFICIENTS = {
    "a_udot": 20.0, "a_u": 3.0, "a_uu": 4.0, "a_vv": 40.0, "a_vr": -300.0, "a_rr": 30.0, "b_vr": 120.0, "b_rv": -60.0,
    "c_vr": -45.0, "c_rv": 80.0, "a_helm": 5.0, "b_helm": 6.0, "c_helm": 2.9, "b_uv": 60.0, "b_odd": 900.0,
}  # fmt: skip
SMALL = 0.4
"""Of a coefficient that is named nowhere."""


@cache
def model_of(name: str) -> nw.Model:
    """The published hull under some terms, or the published KVLCC2 between the banks of a canal."""
    if name == "mmg+delta":
        published, canal = nw.published("yasukawa2015_kvlcc2"), nw.Canal(14.0)
        known = {**published.coefficients, "Y_bank": 1.07, "N_bank": 0.13}
        return nw.Model(replace(published.configuration, canal=canal), table_named(name), known)
    table = OWN if name == "own" else table_named(name)
    published = nw.published("mikkelsen2025_dtc")
    lift = {f"{axis}_u{motion}": published.coefficients[f"{axis}_{motion}"] for axis in "bc" for motion in "vr"}
    known = {**lift, **COEFFICIENTS, **{k: v for k, v in published.coefficients.items() if v}}
    ship = replace(published.configuration.ship, flow_straightening=0.5, mass=260.0)
    configuration = replace(published.configuration, ship=ship, canal=nw.Canal(7.0, 0.3))
    configuration = replace(configuration, steering=nw.SteeringGear(25.0, 18.0))
    return nw.Model(configuration, table, {term: known.get(term, SMALL) for term in table.names})


@cache
def bent(name: str) -> Waterway:
    """Bends both ways, banks that narrow and widen unlike, a current."""
    configuration = model_of(name).configuration
    length, width = configuration.ship.length, configuration.canal.width
    wave = 15.0 * length
    north = np.linspace(0, 2 * wave, 161)
    east = wave**2 / (4 * np.pi**2 * 5 * length) * np.sin(2 * np.pi * north / wave)
    line = Centreline(np.stack([east, north], axis=1))
    s = line.length * np.array([0.0, 0.2, 0.3, 0.55, 0.7, 1.0])
    starboard, port = width * np.array([[0.5, 0.5, 0.45, 0.5, 0.6, 0.5], [0.5, 0.45, 0.5, 0.55, 0.5, 0.5]])
    depth = (s[[0, -1]], np.array([0.32, 0.3])) if name != "mmg+delta" else None
    banks = Bank("starboard", s, starboard), Bank("port", s, port)
    return Waterway(line, *banks, depth, current=0.05, name="bent", step=length / 8)


def speed_of(name: str) -> float:
    """That a voyage begins with [m/s]."""
    return SPEEDS.get(name, 1.0)


def states(name: str, count: int, x: float = 5.0) -> np.ndarray:
    """Random states clear of the banks, as the equations keep them."""
    draw, size = np.random.default_rng(3), model_of(name).configuration.ship.length / 4
    y, psi, v, r = (top * draw.uniform(-1, 1, count) for top in (1.4 * size, 0.3, 0.3, 0.2))
    u, along = speed_of(name) * draw.uniform(0.5, 1.2, count), x * size * draw.uniform(0.5, 1.5, count)
    rudder = [0.3 * draw.uniform(-1, 1, count)] * (name in STEERED)
    return np.stack([along, y, np.cos(psi), np.sin(psi), u, v, r, *rudder], axis=1)
