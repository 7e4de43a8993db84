"""Voyages, fleets and columns agree in every kind of water: ends, states, and the quantities that they note."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from public import kinds

import narrows as nw
from narrows.model.data_range import ASTERN, MEASURES
from narrows.simulation import kernel_run
from narrows.waterway import Bank, Centreline, Waterway

LENGTH = 4000.0
STARTS = {"y": [-20.0, 30.0], "u": [3.0, 5.5]}
TOLD: dict[str, Any] = {"x": 200.0, "psi": 0.004, "duration": 700.0, "dt": 4.0}


@cache
def ship() -> nw.Model:
    """Tested in a narrow range, so that most voyages leave it."""
    model = nw.published("estimated_kcs")
    known = {"speed": (4.0, 5.0), "abs_y": (0.0, 25.0), "abs_psi": (0.0, 0.1), "abs_r": (0.0, 1e-3)}
    sections = {"depth_to_draft": (1.45, 1.6), "width_to_beam": (9.0, 9.5)}
    return replace(model, data_range=replace(model.data_range, **known, **sections))


def way(bend: float = 0.0, half: float = 150.0, depth: float = 16.2, **water: Any) -> Waterway:
    """A line that turns by an angle [rad], with a width and a depth at its end."""
    turned = np.linspace(0.0, bend, 81)
    step = LENGTH / 80 * np.stack([np.sin(turned), np.cos(turned)], axis=1)
    line = Centreline(np.cumsum(np.vstack([[[0.0, 0.0]], step[1:]]), axis=0))
    s, off = np.array([0.0, 1500.0, line.length]), np.array([150.0, half, half])
    banks = Bank("starboard", s, off), Bank("port", s, 1.05 * off)
    return Waterway(line, *banks, (s, np.array([16.2, depth, depth])), **water)


KINDS: dict[str, dict[str, Any]] = {
    "a straight canal": {},
    "a bend": {"waterway": way(bend=0.8)},
    "a bend with a current by continuity": {"waterway": way(bend=-0.5, half=100.0, current=0.6)},
    "a current that turns": {"waterway": way(current=[(0.0, 0.5), (1000.0, -0.4), (LENGTH, 0.2)])},
    "a current across": {"waterway": way(current_across=0.15)},
    "a current across that turns, in a bend": {
        "waterway": way(bend=0.5, current=0.4, current_across=[(0.0, -0.2), (1200.0, 0.3), (LENGTH, 0.0)])
    },
    "a current with a shear": {"waterway": way(half=100.0, current=0.3, current_shear=2e-3)},
    "a field, a wind and shoals": {
        "waterway": way(depth=11.6, current_across=[(0.0, 0.1), (LENGTH, -0.1)], current_shear=-1e-3),
        "Y": 4e4,
    },
    "shoals": {"waterway": way(depth=11.6)},
    "shoals in a current, their bottom not counted": {"waterway": way(depth=11.6, current=-0.3), "bottom": False},
    "a wind": {"Y": 4e4, "N": -1e6},
    "a wind in a bend with a current": {"waterway": way(bend=0.4, current=0.4), "Y": -4e4, "N": 1e6},
    "astern": {"u": [-3.0, 3.0]},
}


def noted(notes: str) -> set[str]:
    """Quantities outside the tested range."""
    return {
        one.words for one in (*MEASURES.values(), ASTERN) if f"{one.words} of " in notes or f"{one.words} out" in notes
    }


@pytest.mark.parametrize("kind", KINDS)
def test_one_water_for_every_engine(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    told = {**TOLD, **KINDS[kind]}
    varied = {**STARTS, **{name: told.pop(name) for name in STARTS if name in told}}
    alone = [nw.simulate(ship(), y=y, u=u, **told) for y in varied["y"] for u in varied["u"]]
    fleet = nw.ensemble(ship(), **varied, **told)
    monkeypatch.setattr(kernel_run, "lacks_compiler", lambda: True)
    columns = nw.ensemble(ship(), **varied, **told)
    assert kinds(fleet) == kinds(columns) == [one.outcome.kind for one in alone]
    near = {"rtol": 1e-9, "atol": 1e-6}
    for name in ("time", "distance", "y_end", "psi_end", "v_end", "r_end"):
        stem = name.removesuffix("_end")
        own = [getattr(one.outcome, stem) if hasattr(one.outcome, stem) else one.outcome.state[stem] for one in alone]
        for many in (fleet, columns):
            np.testing.assert_allclose(many[name].transpose("y", "u").to_numpy().ravel(), own, **near)
    assert fleet.attrs["notes"] == columns.attrs["notes"]
    # A voyage is compared all along, a fleet where its voyages begin and end.
    ends = [noted(" ".join(nw.simulate(ship(), y=y, u=u, **{**told, "duration": 1e-3, "dt": 1e-3}).notes))
            for y in varied["y"] for u in varied["u"]]  # fmt: skip
    found = noted(fleet.attrs["notes"])
    assert set().union(*ends) <= found <= set().union(*(noted(" ".join(one.notes)) for one in alone))
    assert found
