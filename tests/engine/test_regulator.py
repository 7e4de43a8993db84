"""The regulator: against python-control's Riccati solver, the kernel against the plain step, mirrors, bends, limits."""

import math
from dataclasses import replace
from functools import cache
from typing import Any

import control
import numpy as np
import pytest
import xarray as xr
from cases import bent, mmg, paper, steered
from hypothesis import given, settings
from hypothesis import strategies as st

import narrows as nw
from narrows.control import HeldLine, LinearSystem, Regulator, linearize, regulator
from narrows.control.regulator import RegulatorWeights, rate_driven
from narrows.quantities.arithmetic import COLUMNS, choice
from narrows.simulation.kernel_run import KernelRun
from narrows.simulation.ship import SimulatedShip, Steering, steering_of
from narrows.waterway import Bank, Centreline, Waterway

# Weights by Bryson's rule, other than the usual: half a beam off the line weighs as much as 5 degrees off the heading,
# 10 degrees of rudder, that rudder put over in 0.1, or half a beam for 1.2 of the time of a ship length.
OFF_HEADING, HARD, STROKE_TIME, INTEGRAL_TIME = np.radians(5.0), np.radians(10.0), 0.1, 1.2
BANK = 0.3

SHIPS = {"steered": (steered, 0.2), "mmg": (mmg, 0.6)}
FURTHER = (("steered", "straight"), ("mmg", "waterway"))
"""With a kernel of their own to compile."""


def driven(linear: LinearSystem) -> tuple[np.ndarray, np.ndarray]:
    """The linear ship with the rate of its rudder as the input."""
    A, b = rate_driven(linear.A[None], linear.B[None, :, 0])
    return A[0], b[0]


def told(model: nw.Model, y: float, u: float = 1.0, **more: Any) -> dict[str, Any]:
    """A voyage that begins on its steady course."""
    course = linearize(model, y, u).course
    begun = {name: float(course[name]) for name in ("y", "u", "psi", "v", "rudder", "revolutions") if name in course}
    size = model.configuration.ship.length / u
    return {**begun, "duration": 12 * size, "dt": size / 60, **more}


@pytest.mark.parametrize("ship", SHIPS)
def test_gains_are_those_of_python_control(ship: str) -> None:
    model, y = SHIPS[ship][0](), SHIPS[ship][1]
    A, b = driven(linearize(model, y, 1.0))
    doubting = A.copy()
    doubting[:4, 0] *= BANK
    half, time = model.configuration.ship.beam / 2, model.configuration.ship.length
    rate = min(HARD / (STROKE_TIME * time), model.configuration.gear.rate)
    weights = np.diag([half**-2, OFF_HEADING**-2, 0.0, 0.0, HARD**-2, (half * INTEGRAL_TIME * time) ** -2])
    gains, *_ = control.lqr(doubting, b[:, None], weights, [[rate**-2]])
    asked = RegulatorWeights(1.0, 5.0, 10.0, STROKE_TIME, INTEGRAL_TIME, BANK)
    np.testing.assert_allclose(regulator(model, y, 1.0, weights=asked).lines[0].gains, gains[0], rtol=1e-6)
    assert np.linalg.eigvals(A - np.outer(b, gains[0])).real.max() < 0


@pytest.mark.parametrize("ship", SHIPS)
def test_small_motions_are_those_of_the_linear_loop(ship: str) -> None:
    model, y = SHIPS[ship][0](), SHIPS[ship][1]
    law, time = regulator(model, y, 1.0), model.configuration.ship.length
    A, b = driven(linearize(model, y, 1.0))
    closed = control.ss(A - np.outer(b, law.lines[0].gains), np.zeros((6, 1)), np.eye(6), np.zeros((6, 1)))
    begun = told(model, y, duration=4 * time, dt=time / 2000)
    voyage = nw.simulate(model, **{**begun, "y": y + 1e-4}, controller=law)
    expected = control.initial_response(closed, voyage.t, [1e-4, 0, 0, 0, 0, 0]).outputs
    np.testing.assert_allclose(voyage.y - y, expected[0], atol=4e-7)
    np.testing.assert_allclose(voyage.rudder - begun["rudder"], expected[4], atol=2e-2 * np.abs(expected[4]).max())


@pytest.mark.parametrize(
    ("ship", "course"),
    [("steered", "waterway"), ("mmg", "straight"), *(pytest.param(*case, marks=pytest.mark.whole) for case in FURTHER)],
)
def test_fleets_and_voyages_agree(ship: str, course: str) -> None:
    model, y = SHIPS[ship][0](), SHIPS[ship][1]
    way = bent(model.configuration.ship.length, 2 * model.configuration.canal.width) if course == "waterway" else None
    law = regulator(model, ((0.0, y), (9.0, 0.0)), 1.0)
    begun = told(model, y, x=11.0, waterway=way)
    starts = y + np.array([0.0, -0.1, 0.15])
    fleet = nw.ensemble(model, **{**begun, "y": starts}, controller=law)
    for start, ended in zip(starts, (fleet.isel(y=k) for k in range(3)), strict=True):
        voyage = nw.simulate(model, **{**begun, "y": start}, controller=law)
        assert voyage.outcome.time == pytest.approx(float(ended["time"]), abs=1e-6)
        for name in ("y", "psi", "v", "r"):
            assert voyage[name][-1] == pytest.approx(float(ended[f"{name}_end"]), abs=1e-7)


@pytest.mark.parametrize("ship", SHIPS)
def test_a_lasting_push_leaves_no_offset(ship: str) -> None:
    model, y = SHIPS[ship][0](), SHIPS[ship][1]
    linear = linearize(model, y, 1.0)
    turn = linear.states.index("r")
    moment = 0.05 * float(linear.B[turn, 0] / linear.G[turn, linear.disturbances.index("N")])
    begun = told(model, y, duration=40 * model.configuration.ship.length)
    held = nw.simulate(model, **begun, N=moment, controller=regulator(model, y, 1.0))
    assert held.outcome.kind == "afloat"
    assert abs(held.y[-1] - y) < 1e-3 * model.configuration.ship.beam


@cache
def arc(radius: float) -> nw.Waterway:
    """Straight on, then round."""
    s = np.arange(0.0, 400.0, 1.0)
    heading = np.cumsum(np.where(s > 60, 1 / radius, 0.0))
    line = Centreline(np.cumsum(np.stack([np.sin(heading), np.cos(heading)], axis=1), axis=0))
    ends, half = np.array([0.0, line.length]), np.full(2, 10.0)
    return Waterway(line, Bank("starboard", ends, half), Bank("port", ends, half), current=0.1)


@pytest.mark.parametrize("ship", SHIPS)
def test_a_bend_ahead_is_turned_into(ship: str) -> None:
    model = SHIPS[ship][0]()
    way, length = arc(150.0), model.configuration.ship.length
    law = regulator(model, 0.0, 1.0, waterway=way)
    begun = {"u": 1.0, "x": 30.0, "waterway": way, "duration": 25 * length, "dt": length / 60}
    if model.terms.propelled:
        begun["revolutions"] = nw.self_propulsion(model, 1.0)
    flown, late, blind = (
        nw.simulate(model, **begun, controller=other)
        for other in (
            law,
            replace(law, lead=-law.lead),
            replace(law, lines=(replace(law.lines[0], turning=(0.0,) * 3),)),
        )
    )
    off = [float(np.abs(voyage.y).max()) for voyage in (flown, late, blind)]
    assert off[0] < 0.6 * off[1]
    assert off[0] < 0.5 * off[2]
    assert off[0] < 0.25 * model.configuration.ship.beam
    assert abs(flown.y[-1]) < 0.02 * model.configuration.ship.beam


@pytest.mark.parametrize("ship", ["steered"])
def test_the_mirrored_ship_gets_the_mirrored_order(ship: str) -> None:
    model, y = SHIPS[ship][0](), SHIPS[ship][1]
    one, other = regulator(model, y, 1.0), regulator(model, -y, 1.0)
    begun = told(model, y)
    mirror = {name: -begun[name] for name in ("y", "psi", "v", "rudder")}
    there = nw.simulate(model, **{**begun, "y": y + 0.05}, controller=one)
    back = nw.simulate(model, **{**begun, **mirror, "y": -y - 0.05}, controller=other)
    np.testing.assert_allclose(back.y, -there.y, atol=1e-9)
    np.testing.assert_allclose(back.rudder, -there.rudder, atol=1e-9)


def test_gains_go_with_the_speed() -> None:
    """Every force of these terms goes with the square of the speed, and no gear is in the way."""
    quick = replace(steered().configuration, steering=nw.SteeringGear(35.0, 1e6))
    zero = {name: 0.0 for name in ("b_vr", "c_vr", "c_rv") if name in steered().coefficients}
    model = replace(steered(), configuration=quick).with_coefficients(**zero)
    slow, fast = regulator(model, 0.2, 1.0), regulator(model, 0.2, 1.5)
    start = {**told(model, 0.2, 1.5), "y": 0.25}
    one, other = (nw.simulate(model, **start, controller=law) for law in (slow, replace(fast, lead=slow.lead)))
    law = replace(slow, unwinding=fast.unwinding)
    scaled = nw.simulate(model, **start, controller=law)
    np.testing.assert_allclose(scaled.y, other.y, atol=1e-7)
    assert one.outcome.kind == "afloat"


def test_steps_of_four_seconds_hold_the_ship_as_shorter_ones_do() -> None:
    """The rudder's own gain is taken at the end of the step: 0.2/s over 4 s would otherwise overshoot."""
    model = nw.published("estimated_kcs")
    law = regulator(model, y=0.0, u=4.0)
    fine, coarse = (nw.simulate(model, y=10.0, u=4.0, duration=400.0, dt=dt, controller=law) for dt in (0.5, 4.0))
    assert np.interp(coarse.t, fine.t, fine.y) == pytest.approx(coarse.y, abs=0.6)


def test_the_integral_is_led_back_where_the_gear_cannot_follow() -> None:
    model = replace(steered(), configuration=replace(steered().configuration, steering=nw.SteeringGear(6.0, 5.0)))
    law, y = regulator(model, 0.0, 1.0), 0.0
    begun = told(model, y, duration=100.0)
    begun |= {"y": 1.5, "psi": 0.0}
    # In water without banks, where what a limit does is the integral's alone.
    free = model.with_coefficients(b_bank=0.0, c_bank=0.0)
    led, wound = (nw.simulate(free, **begun, controller=replace(law, unwinding=time)) for time in (law.unwinding, 1e9))
    assert -led.y.min() < 0.6 * -wound.y.min()


@cache
def regulated() -> tuple[nw.Model, SimulatedShip, Steering]:
    """A ship and its law."""
    ship = SimulatedShip(steered())
    return ship.model, ship, steering_of(regulator(ship.model, 0.2, 1.0), ship.actuators)


NUMBER = st.floats(-1e3, 1e3, allow_nan=False)


@settings(max_examples=200, deadline=None)
@given(y=NUMBER, psi=st.floats(-3, 3), u=NUMBER, v=NUMBER, r=NUMBER, rudder=st.floats(-0.4, 0.4), integral=NUMBER)
def test_no_state_gets_no_order(y, psi, u, v, r, rudder, integral) -> None:
    model, ship, steering = regulated()
    state = {"x": 0.0, "y": y, "cos_psi": math.cos(psi), "sin_psi": math.sin(psi), "u": u, "v": v, "r": r, "t": 0.0}
    numbers = {**ship.values(), **steering.parameters, **state, "rudder": rudder, "step_length": 0.05, "current": 0.0}
    seen = {"water_curvature": lambda x: np.zeros(np.shape(x))}
    memory = {"memory_integral": integral, "memory_last_order": rudder}
    found = steering.law.trace.replay({**numbers, **memory}, functions={**COLUMNS, **seen})
    assert all(np.isfinite(value) for value in found.values())
    assert abs(found["rudder"]) <= model.configuration.gear.limit
    assert abs(found["rudder"] - rudder) <= model.configuration.gear.rate * 0.05 + 1e-12


class Watching:
    """A law that writes what it sees of the water into its memory."""

    def parameters(self) -> dict[str, float]:
        """Nothing."""
        return {}

    def memory(self, start: Any) -> dict[str, float]:
        """Nothing seen."""
        return {"bend": 0.0, "to_starboard": 0.0, "to_port": 0.0, "stream": 0.0}

    def orders(self, at: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """Look 20 m ahead."""
        seen = {"bend": at.water("curvature", at.x + 20.0), "to_starboard": at.water("starboard", at.x + 20.0)}
        return {"rudder": 0.0 * at.rudder}, {**seen, "to_port": at.water("port", at.x), "stream": at.current + 0 * at.x}


@pytest.mark.parametrize("course", ["straight", "waterway"])
def test_a_law_sees_the_water(course: str) -> None:
    model, way = steered(), arc(150.0) if course == "waterway" else None
    ship = SimulatedShip(model)
    run = KernelRun(ship, 0.1, 0.1, steering=steering_of(Watching(), ship.actuators), waterway=way)
    x = np.array([1.0, 60.0, 100.0, 390.0])
    none = np.zeros(4)
    values = {"x": x, "y": none, "psi": none, "u": none + 1, "v": none, "r": none, "X": none, "Y": none, "N": none}
    prepared = run.prepared(values, 4, 1)
    prepared()
    seen = run.ended(prepared, values)
    half = model.configuration.canal.width / 2
    expected = np.zeros(4) if way is None else way.line.curvature(np.minimum(x + 20.0, way.line.length))
    np.testing.assert_allclose(seen["memory_bend_end"], expected, atol=2e-4)
    np.testing.assert_allclose(seen["memory_to_starboard_end"], half if way is None else 10.0)
    np.testing.assert_allclose(seen["memory_to_port_end"], half if way is None else 10.0)
    np.testing.assert_allclose(seen["memory_stream_end"], 0.0 if way is None else 0.1)


def test_what_there_is_not_is_not_seen() -> None:
    class Curious(Watching):
        def orders(self, at: Any) -> tuple[dict[str, Any], dict[str, Any]]:
            return {"rudder": at.water("fish", at.x)}, self.memory({})

    with pytest.raises(nw.InputError, match="the observed section = 'fish' is unknown"):
        nw.simulate(steered(), 0.1, 1.0, 1.0, controller=Curious())


LINE = HeldLine(0.0, (1.0,) * 6)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: regulator(paper(), 0.0, 1.0), "no terms of a rudder"),
        (lambda: regulator(steered().with_coefficients(b_helm=0.0, c_helm=0.0), 0.0, 1.0), "no rudder|has no effect"),
        (lambda: regulator(steered(), 3.0, 1.0), "no rudder"),
        (lambda: regulator(steered(), "left", 1.0), "must be a finite number"),
        (lambda: regulator(steered(), ((5.0, 0.0), (5.0, 0.1)), 1.0), "later time"),
        (lambda: regulator(steered(), (0.0, 0.1), 1.0), "pairs of time"),
        (lambda: HeldLine(0.0, (1.0,)), "give each"),
        (lambda: RegulatorWeights(bank=1.5), "bank = 1.5"),
        (lambda: RegulatorWeights(heading_deg=0.0), "heading_deg = 0.0"),
        (lambda: Regulator((HeldLine(math.nan, (1.0,) * 6),), 1.0, 1.0, 1.0), "steers nothing"),
        (lambda: Regulator((), 1.0, 1.0, 1.0), "one line or more"),
        (lambda: Regulator((LINE,), 0.0, 1.0, 1.0), "u over 0"),
        (lambda: Regulator((LINE,), 1.0, 1.0, 0.0), "unwinding over 0"),
        (lambda: Regulator((LINE,), 1.0, math.inf, 1.0), "not finite"),
        (lambda: Regulator((LINE,), 1.0, 1.0, 1.0, math.nan), "not finite"),
    ],
)
def test_what_is_no_regulator_is_one_sentence(make: Any, words: str) -> None:
    with pytest.raises(nw.InputError, match=words):
        make()


CHANGED = {"u": 1.3, "lead": 5.0, "unwinding": 0.05, "integral": 0.4}
OF_THE_LINE = {
    "y": 0.3, "gains": (0.4, 1.5, 0.1, 4.0, 2.5, 0.05), "rudder": 0.1, "psi": 0.05, "v": 0.05,
    "turning": (1.0, 1.0, 1.0),
}  # fmt: skip


@pytest.mark.parametrize("field", [*CHANGED, *OF_THE_LINE, "start"])
def test_every_number_of_it_counts(field: str) -> None:
    model, way = steered(), arc(150.0)
    law = regulator(model, ((0.0, 0.0), (3.0, 0.1)), 1.0)
    law = replace(law, lines=(law.lines[0], replace(law.lines[1], start=4.0))) if field == "start" else law
    other = replace(law, **{field: CHANGED[field]}) if field in CHANGED else law
    if field in OF_THE_LINE:
        other = replace(law, lines=(replace(law.lines[0], **{field: OF_THE_LINE[field]}), law.lines[1]))
    if field == "start":
        other = replace(law, lines=(law.lines[0], replace(law.lines[1], start=2.0)))
    begun = {"y": 0.0, "u": 1.0, "x": 52.0, "psi": 0.2, "waterway": way, "duration": 9.0, "dt": 0.1}
    one, two = (nw.simulate(model, **begun, controller=own) for own in (law, other))
    assert np.abs(one.y[-1] - two.y[-1]) > 1e-9


def test_lines_may_vary_over_a_fleet() -> None:
    model = steered()
    offsets = xr.DataArray([0.0, 0.1], dims="line")
    laws = [regulator(model, float(y), 1.0) for y in offsets]
    first = laws[0].lines[0]
    both = HeldLine(
        offsets,
        first.gains,
        *(xr.DataArray([getattr(law.lines[0], n) for law in laws], dims="line") for n in ("rudder", "psi", "v")),
    )
    fleet = nw.ensemble(model, y=0.05, u=1.0, duration=30.0, dt=0.1, controller=replace(laws[0], lines=(both,)))
    np.testing.assert_allclose(fleet["y_end"], offsets, atol=0.03)


def test_a_law_of_ones_own_orders_revolutions_of_a_fleet_as_of_one_ship() -> None:
    """About a regulator: fewer revolutions from 2 m on."""
    tanker = nw.published("yasukawa2015_kvlcc2")
    helm = regulator(tanker, 0.0, 0.8)

    class Slowing:
        def parameters(self) -> Any:
            return {**helm.parameters(), "slows_at": 2.0, "fast": 11.0, "slow": 5.0}

        def memory(self, start: Any) -> Any:
            return helm.memory(start)

        def orders(self, at: Any) -> Any:
            orders, memory = helm.orders(at)
            return {**orders, "revolutions": choice(at.x - at.slows_at, at.slow, at.fast)}, memory

    start = {"u": 1.0, "duration": 12.0, "dt": 0.2, "revolutions": 11.0, "surge": "free", "contact": "none"}
    voyage = nw.simulate(tanker, 0.5, controller=Slowing(), **start)
    fleet = nw.ensemble(tanker, y=[0.5, -0.2], controller=Slowing(), **start)
    assert {5.0, 11.0} <= set(voyage["revolutions"])
    assert float(fleet.u_end[0]) == pytest.approx(voyage.u[-1], rel=1e-9)
    assert float(fleet.y_end[0]) == pytest.approx(voyage.y[-1], abs=1e-9)
