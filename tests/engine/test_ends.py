"""Every way in which a voyage ends, beside the reference: across the canal, out of the waterway, afloat, diverged."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import pytest
import xarray as xr
from cases import paper, steered, waterway_for
from public import kinds
from reference import Reference

import narrows as nw
from narrows.simulation.controllers import ControlLaw


@dataclass(frozen=True)
class Ending:
    """A voyage that ends in one way."""

    kind: str
    start: dict[str, float]
    law: ControlLaw | None = None
    course: str = "straight"
    current: float | None = None
    duration: float = 60.0
    dt: float = 0.02

    @property
    def model(self) -> nw.Model:
        model = steered().with_coefficients(b_bank=0.1, c_bank=0.02)
        return replace(model, configuration=replace(model.configuration, canal=nw.Canal(60.0)))

    @property
    def waterway(self) -> nw.Waterway | None:
        if self.course == "straight":
            return None
        way = waterway_for("steered")
        return way if self.current is None else way.with_water(current=self.current)

    @property
    def told(self) -> dict[str, Any]:
        return {"duration": self.duration, "dt": self.dt, "waterway": self.waterway}

    def reference(self) -> Reference:
        return Reference(self.model, start=self.start, controller=self.law, **self.told)


@cache
def exact_end(name: str) -> Any:
    """How the reference ends, integrated once."""
    return ENDINGS[name].reference().end("corners")


AHEAD = {"y": 0.0, "u": 1.0, "rudder": 0.0}
PILOT = nw.Autopilot(0.0, (0.15, 1.2, 0.4, 2.0))
ENDINGS = {
    "across to starboard": Ending("left validity", AHEAD, nw.ConstantRudder(0.4)),
    "across to port": Ending("left validity", {**AHEAD, "psi": -0.3}, nw.ConstantRudder(-0.4)),
    "out by the far end": Ending("left the waterway", {**AHEAD, "x": 105.0}, PILOT, "waterway", 0.3),
    "out by the beginning": Ending("left the waterway", {**AHEAD, "x": 6.0}, PILOT, "waterway", -1.7),
    "time is up, from the first point of the line": Ending(
        "afloat", {**AHEAD, "x": 0.0}, PILOT, "waterway", 0.3, duration=5.0
    ),
    "time is up within a step": Ending("afloat", {**AHEAD, "y": 3.0}, PILOT, duration=7.123),
    "time is up with a step": Ending("afloat", {**AHEAD, "y": 3.0}, PILOT, duration=7.2),
    "time is up within the first step": Ending("afloat", {**AHEAD, "y": 3.0}, PILOT, duration=0.7, dt=2.0),
}


@pytest.mark.parametrize("name", ENDINGS)
def test_a_voyage_ends_as_the_reference(name: str) -> None:
    ending = ENDINGS[name]
    exact = exact_end(name)
    assert exact.kind == ending.kind
    starts = {own: xr.DataArray([value], dims="start") for own, value in ending.start.items()}
    alone = nw.simulate(ending.model, **ending.start, **ending.told, controller=ending.law).outcome
    ended = nw.ensemble(ending.model, **starts, **ending.told, controller=ending.law)
    assert alone.kind == kinds(ended)[0] == exact.kind
    near = 1e-6 if ending.dt < 1 else 1e-3
    assert alone.time == pytest.approx(exact.time, abs=near)
    assert float(ended["time"][0]) == pytest.approx(alone.time, abs=1e-9)
    assert alone.side is None or ending.kind == "left the waterway", "where it may be the end of the waterway"
    assert alone.state["y"] == pytest.approx(exact.state["y"], abs=10 * near)


@pytest.mark.parametrize("dt", [0.02, 0.1])
def test_a_motion_without_bound_is_told_as_such(dt: float) -> None:
    """A ship that is pushed ahead without end: where it stops is the step's, that it diverged is everybody's."""
    told = {"y": 0.0, "dt": dt, "surge": "free", "surge_inertia": 1.0, "X": 1e9}
    assert nw.simulate(paper(), **told).outcome.kind == "diverged"
    assert kinds(nw.ensemble(paper(), **told)) == ["diverged"]


@pytest.mark.parametrize("contact", [[(0.3, 0.1), (-0.3, 0.1), (0.0, -0.1)], [(2.0, 0.0), (-2.0, 0.2), (-2.0, -0.2)]])
def test_an_outline_inside_the_beam_is_refused_or_ends_there(contact: Any) -> None:
    """The wall of the force lies inside such a hull: it may not sail through it."""
    for sail in (nw.simulate, nw.ensemble):
        try:
            ended = sail(paper(), y=0.5, contact=contact)
        except nw.InputError:
            continue
        kind = ended.outcome.kind if isinstance(ended, nw.Voyage) else kinds(ended)[0]
        assert kind == "grounded"


@pytest.mark.parametrize("name", ENDINGS)
def test_the_reference_ends_as_it_should(name: str) -> None:
    ending = ENDINGS[name]
    exact = exact_end(name)
    assert exact.kind == ending.kind
    if ending.kind == "afloat":
        assert exact.time == ending.duration
    if name.startswith("out"):
        assert exact.state["x"] == pytest.approx(0.0 if "beginning" in name else ending.waterway.line.length, abs=1e-6)
