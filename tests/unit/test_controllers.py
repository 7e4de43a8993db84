"""Control laws: one's own in arithmetic in every engine alike, objects of Python in single voyages, and refusals."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import xarray as xr

import narrows as nw
from engine_models import bent, mmg, steered
from narrows.quantities.arithmetic import choice, clip, maximum
from narrows.simulation.ship import SimulatedShip, steering_of

STATE = ("x", "y", "psi", "u", "v", "r")
START = {"y": 0.2, "psi": 0.02, "v": 0.01, "r": -0.002}


@dataclass(frozen=True)
class Integrator:
    """A pilot that sums up what is off, bounded, and remembers how far off it was at most."""

    held: Any = 0.0
    by_y: Any = 0.2
    by_sum: Any = 0.01

    def parameters(self) -> dict[str, Any]:
        return {"held": self.held, "by_y": self.by_y, "by_sum": self.by_sum}

    def memory(self, start: Any) -> dict[str, Any]:
        return {"total": 0.1 * start["y"], "farthest": abs(start["y"])}

    def orders(self, at: Any) -> tuple[dict, dict]:
        off = at.y - at.held
        total = clip(at.total + off * at.dt, 5.0)
        order = -at.by_y * off - 1.1 * at.psi - 2.0 * at.r - at.by_sum * total
        order = choice(at.t - 2.02, order, 0.0)
        return {"rudder": order}, {"total": total, "farthest": maximum(at.farthest, abs(off))}


class Mimic:
    """The same in any Python."""

    def __init__(self, law: Integrator, dt: float, y: float) -> None:
        self.law, self.dt, self.y, self.asked = law, dt, y, list[float]()

    def begin(self):
        law, memory = self.law, {"total": 0.1 * self.y}

        def order(t: float, state) -> float:
            self.asked.append(t)
            off = state.y - law.held
            memory["total"] = min(max(memory["total"] + off * self.dt, -5.0), 5.0)
            wanted = -law.by_y * off - 1.1 * state.psi - 2.0 * state.r - law.by_sum * memory["total"]
            return wanted if t > 2.02 else 0.0

        return order


FURTHER = ((steered, False), (mmg, True))
"""With a kernel of their own to compile."""


@pytest.mark.parametrize(
    ("make", "along"),
    [(steered, True), (mmg, False), *(pytest.param(*case, marks=pytest.mark.whole) for case in FURTHER)],
)
def test_a_law_of_ones_own_is_the_same_in_voyage_and_fleet(make, along: bool) -> None:
    model = make()
    hull = model.configuration.ship
    place = {"waterway": bent(hull.length, model.configuration.canal.width)} if along else {}
    start = {**START, "x": 10.0 * hull.length, "rudder": 0.03}
    y = np.array([-0.4, 0.2, 0.5])
    told = {"duration": 9.97, "dt": 0.05, **place}
    ends = nw.ensemble(model, controller=Integrator(), **{**start, "y": y}, **told)
    for place_of, own in enumerate(y):
        voyage = nw.simulate(model, **{**start, "y": own}, controller=Integrator(), **told)
        assert voyage.outcome.kind == "afloat"
        assert np.ptp(voyage.rudder) > 0.02
        for name in STATE[1:]:
            assert float(ends[f"{name}_end"][place_of]) == pytest.approx(getattr(voyage, name)[-1], abs=1e-12), name
        assert float(ends["distance"][place_of]) == pytest.approx(voyage.outcome.distance, rel=1e-12)


def test_numbers_of_a_law_may_vary_over_a_fleet() -> None:
    model, gains = steered(), np.array([0.05, 0.2, 0.6])
    law = Integrator(by_y=xr.DataArray(gains, dims="gain"))
    ends = nw.ensemble(model, controller=law, y=[0.3, -0.5], duration=8.0, dt=0.05)
    assert dict(ends.sizes) == {"y": 2, "gain": 3}
    for gain, own in enumerate(gains):
        voyage = nw.simulate(model, -0.5, duration=8.0, dt=0.05, controller=Integrator(by_y=own))
        assert float(ends["y_end"].sel(y=-0.5)[gain]) == pytest.approx(voyage.y[-1], abs=1e-12)


@pytest.mark.parametrize("along", [False, True], ids=["straight", "in a waterway"])
def test_an_object_of_python_sails_the_voyage_of_the_law_that_it_mimics(along: bool) -> None:
    model, dt = steered(), 0.05
    start = {**START, "x": 40.0} | ({"waterway": bent(4.0, 7.0)} if along else {})
    law = Integrator(held=0.4)
    one = nw.simulate(model, **start, controller=law, duration=10.0, dt=dt)
    mimic = Mimic(law, dt, START["y"])
    other = nw.simulate(model, **start, controller=mimic, duration=10.0, dt=dt)
    assert one.outcome.kind == other.outcome.kind == "afloat"
    for name in (*STATE, "rudder"):
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=0, atol=1e-12, err_msg=name)
    np.testing.assert_allclose(mimic.asked, one.t[:-1], rtol=1e-12, err_msg="asked once, where each step begins")


@pytest.mark.parametrize("law", [Integrator(), Mimic(Integrator(), 0.1, 0.0)], ids=lambda own: type(own).__name__)
def test_a_law_remembers_over_jumps_of_the_forces(law: Any) -> None:
    """Forces that jump from nought to nought change nothing."""
    plain, pushed = (
        nw.simulate(steered(), controller=law, X=forces, duration=12.0, dt=0.1)
        for forces in (0.0, [(0.0, 0.0), (3.0, 0.0), (6.0, 0.0)])
    )
    np.testing.assert_allclose(pushed.psi, plain.psi, rtol=0, atol=1e-10)
    np.testing.assert_allclose(pushed.rudder, plain.rudder, rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    "forces", [0.0, 2.0, [(0.0, 1.0), (0.5, 0.0)]], ids=["no force", "a force", "a force for a time"]
)
def test_an_object_of_python_sees_the_state_as_it_is(forces: Any) -> None:
    seen = []

    class Watcher:
        def begin(self):
            def order(t: float, state: Any) -> float:
                seen.append((t, *state))
                return 0.1

            return order

    voyage = nw.simulate(steered(), **START, rudder=0.03, Y=forces, controller=Watcher(), duration=1.0, dt=0.1)
    columns = [getattr(voyage, name)[:-1] for name in ("t", *STATE, "rudder")]
    np.testing.assert_allclose(np.transpose(seen), columns, rtol=1e-12, atol=1e-14)


class Bare(Integrator):
    """What a test changes one thing of."""

    def parameters(self) -> dict[str, Any]:
        return {"gain": 1.0}

    def memory(self, start: Any) -> dict[str, Any]:
        return {"kept": 0.0}

    def orders(self, at: Any) -> tuple[dict, dict]:
        return {"rudder": at.gain * at.y}, {"kept": at.kept}


def changed(**methods: Any) -> Any:
    return type("Odd", (Bare,), {name: lambda self, *a, f=function: f(*a) for name, function in methods.items()})()


REFUSALS = {
    "no such actuator": (changed(orders=lambda at: ({"bow_thruster": at.y}, {"kept": 0.0})), "orders to bow_thruster"),
    "a name of the state": (changed(parameters=lambda: {"y": 1.0}), "a number called 'y', which means something else"),
    "the heading": (changed(parameters=lambda: {"psi": 1.0}), "'psi', which means something else"),
    "the step": (changed(memory=lambda start: {"dt": 1.0}), "'dt', which means something else"),
    "an actuator": (changed(memory=lambda start: {"rudder": 1.0}), "'rudder', which means something else"),
    "number and memory": (changed(parameters=lambda: {"kept": 1.0, "gain": 1.0}), "'kept', which means something"),
    "more memory": (changed(orders=lambda at: ({"rudder": at.y}, {"kept": 0.0, "new": 1.0})), "return the same memory"),
    "less memory": (changed(orders=lambda at: ({"rudder": at.y}, {})), r"keeps \[\], not \['kept'\]"),
    "a comparison": (changed(orders=lambda at: ({"rudder": 1.0 if at.y > 0 else 0.0}, {"kept": 0.0})), "it compares"),
    "a sine": (changed(orders=lambda at: ({"rudder": math.sin(at.psi)}, {"kept": 0.0})), "plain number"),
    "what is not there": (changed(orders=lambda at: ({"rudder": at.depth_below}, {"kept": 0.0})), "depth_below"),
    "an order that is no number": (changed(orders=lambda at: ({"rudder": None}, {"kept": 0.0})), "NoneType"),
    "no controller": (object(), "a object is no controller: it has neither"),
    "a class": (3.0, "a float is no controller"),
}


@pytest.mark.parametrize("what", REFUSALS)
def test_what_is_no_law_is_refused(what: str) -> None:
    controller, words = REFUSALS[what]
    for sail in (nw.simulate, nw.ensemble):
        with pytest.raises(nw.InputError, match=words):
            sail(steered(), y=0.1, duration=1.0, controller=controller)


def test_objects_of_python_steer_no_fleets() -> None:
    with pytest.raises(nw.InputError, match=r"a Mimic steers in nw\.simulate alone; write it as a law in arithmetic"):
        nw.ensemble(steered(), y=[0.1, 0.2], controller=Mimic(Integrator(), 0.02, 0.1))


def test_a_hull_without_a_rudder_takes_no_orders(dtc: nw.Model) -> None:
    for sail in (nw.simulate, nw.ensemble):
        with pytest.raises(nw.InputError, match="borrow_rudder adds a rudder"):
            sail(dtc, y=0.1, controller=nw.ConstantRudder(0.1))


def test_laws_that_do_the_same_share_a_kernel() -> None:
    actuators = SimulatedShip(steered()).actuators
    one, other = (steering_of(Integrator(held=held), actuators) for held in (0.0, 0.5))
    assert one.law == other.law
    assert one.parameters != other.parameters


def turned(law: nw.ControlLaw, **given: float) -> nw.Voyage:
    """A ship at full size in open water, two degrees off its heading."""
    told = {"u": 6.0, "psi": 0.035, "duration": 900.0, "dt": 0.5, "contact": "none"}
    return nw.simulate(nw.published("estimated_kcs").in_open_water(), controller=law, **{**told, **given})


def test_a_heading_autopilot_brings_the_ship_back_and_its_integral_takes_a_steady_push_away() -> None:
    law = nw.PID(kp=1.0, kd=60.0)
    assert abs(turned(law).psi[-1]) < 1e-4
    assert abs(turned(nw.PID(kp=1.0, kd=60.0, psi=0.02)).psi[-1] - 0.02) < 1e-4
    pushed = turned(law, N=2e7)
    assert pushed.psi[-1] == pytest.approx(-pushed.rudder[-1], rel=1e-3)
    assert pushed.psi[-1] > 0.01
    assert abs(turned(nw.PID(kp=1.0, kd=60.0, ki=0.01), N=2e7).psi[-1]) < 1e-3


def test_the_integral_of_a_heading_autopilot_waits_while_the_rudder_is_hard_over() -> None:
    """A sum that goes on beyond the limit swings the bow far to the other side."""
    total = 0.0

    def naive(t: float, state: Any) -> float:
        nonlocal total
        total += 0.5 * state.psi
        return -(8.0 * state.psi + 200.0 * state.r + 0.05 * (total - 0.5 * state.psi))

    waiting, going_on = (turned(law, psi=0.6) for law in (nw.PID(kp=8.0, kd=200.0, ki=0.05), naive))
    assert waiting.rudder.min() == going_on.rudder.min() == pytest.approx(-np.radians(35.0))
    assert 2 * abs(waiting.psi.min()) < abs(going_on.psi.min())
