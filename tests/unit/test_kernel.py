"""Fleets: the same as voyages stepped one by one, contacts located, mirrored to the bit, whatever the cores."""

import ast
import math
import platform
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numpy as np
import pytest

import narrows as nw
from dop853 import integrated
from engine_models import ACTUATED, TABLES, bent, model_of
from narrows.codegen.compilation import optimised, this_machine
from narrows.simulation import outcome as end
from narrows.simulation.controllers import Autopilot, Zigzag
from narrows.simulation.inputs import START
from narrows.simulation.kernel_run import KernelRun, PreparedRun
from narrows.simulation.outcome import Code
from narrows.simulation.ship import SimulatedShip, along_waterway, steering_of, straight_channel
from narrows.waterway import Waterway

DTC = nw.published("mikkelsen2025_dtc")
ODD = ("side", "y_end", "psi_end", "v_end", "r_end")


@dataclass(frozen=True)
class Fleet:
    """A run and what it needs, so that a test may look into both."""

    run: KernelRun
    values: dict[str, Any]
    prepared: PreparedRun

    def ended(self) -> dict[str, np.ndarray]:
        self.prepared()
        return self.run.ended(self.prepared, self.values)


def fleet(
    ship: SimulatedShip, *, dt: Any = 0.02, duration: Any = 40.0, workers: int | None = None,
    controller: Any = None, waterway: Waterway | None = None, **values: Any,
) -> Fleet:  # fmt: skip
    """Vessels laid out as ``ensemble`` does it, without its labels and checks."""
    given = {**dict.fromkeys((*START, "X", "Y", "N"), 0.0), "u": 1.0, "rudder": 0.0, **values}
    vessels = math.prod(np.broadcast_shapes(*(np.shape(value) for value in (*given.values(), dt, duration))))
    run = KernelRun(ship, duration, dt, steering_of(controller, ship.actuators), waterway)
    return Fleet(run, given, run.prepared(given, vessels, workers))


def sailed(ship: SimulatedShip | nw.Model = DTC, **given: Any) -> dict[str, np.ndarray]:
    """How they end; the published ship unless another is given."""
    return fleet(ship if isinstance(ship, SimulatedShip) else SimulatedShip(ship), **given).ended()


def starts(count: int, seed: int = 0) -> dict[str, np.ndarray]:
    draw = np.random.default_rng(seed)
    tops = {"y": 2.5, "psi": 0.1, "v": 0.05, "r": 0.03}
    return {name: draw.uniform(-top, top, count) for name, top in tops.items()} | {"u": draw.uniform(0.7, 1.3, count)}


def runge_kutta(system, numbers: dict, start: dict, dt: float, steps: int) -> dict[str, np.ndarray]:
    """The classical step in plain Python, on columns."""
    functions = system.columns

    def rate(z: np.ndarray) -> np.ndarray:
        return np.array(np.broadcast_arrays(*functions.rates(*z, *(numbers[n] for n in functions.RATES_INPUTS))))

    z = np.array([0 * start["y"], start["y"], np.cos(start["psi"]), np.sin(start["psi"]), *(start[n] for n in "uvr")])
    for _ in range(steps):
        k1 = rate(z)
        k2 = rate(z + dt / 2 * k1)
        k3 = rate(z + dt / 2 * k2)
        z = z + dt / 6 * (k1 + 2 * k2 + 2 * k3 + rate(z + dt * k3))
        z[2:4] *= 1.5 - 0.5 * (z[2] ** 2 + z[3] ** 2)
    return dict(zip(("x", "y", "cos_psi", "sin_psi", "u", "v", "r"), z, strict=True))


@pytest.mark.parametrize(
    ("table", "surge", "coriolis", "pushes"),
    [
        ("paper", "held", False, {}),
        ("paper+tapered", "free", True, {"X": 12.0, "Y": 0.4, "N": -0.2}),
        ("own", "held", True, {"N": 0.5}),
    ],
)
def test_a_fleet_takes_the_steps_of_one_voyage(table: str, surge: str, coriolis: bool, pushes: dict) -> None:
    model, start = model_of(TABLES[table]), starts(150)
    ship = SimulatedShip(model, surge, 300.0 if surge == "free" else None, coriolis)
    found = sailed(ship, **start, **pushes, dt=0.05, duration=2.0)
    values = {**ship.values(), **{f"{name}_in": value for name, value in pushes.items()}}
    system = ship.system(pushed="always" if pushes else "never")
    expected = runge_kutta(system, system.constants(values), start, 0.05, 40)
    expected["psi"] = np.arctan2(expected["sin_psi"], expected["cos_psi"])
    afloat = found["outcome"] == Code.AFLOAT
    assert afloat.sum() > 100
    np.testing.assert_allclose(found["distance"][afloat], expected["x"][afloat], rtol=1e-12)
    for name in ("y", "psi", "u", "v", "r"):
        own = found[f"{name}_end"][afloat]
        np.testing.assert_allclose(own, expected[name][afloat], rtol=1e-12, atol=1e-13, err_msg=name)


LAWS = {"pilot": Autopilot(0.3, (0.15, 1.2, 0.4, 2.0), 0.01, 0.005, -0.01), "zigzag": Zigzag(0.17, 0.06)}
KINDS = [
    (name, along, law, pushed)
    for name in ACTUATED
    for along, law, pushed in ((False, None, {}), (True, "pilot", {"Y": 3.0, "push_end": 2.43}), (True, "zigzag", {}))
]


FURTHER = (2, 4)
"""Of the kinds, with a kernel of their own to compile: each law still meets a waterway."""


@pytest.mark.parametrize(
    ("name", "along", "law", "pushed"),
    [pytest.param(*kind, marks=pytest.mark.whole if at in FURTHER else ()) for at, kind in enumerate(KINDS)],
)
def test_the_plain_step_is_the_kernels(name: str, along: bool, law: str | None, pushed: dict) -> None:
    """Step by step of the printed Python, law, gear, section and contact and all."""
    model, steps, dt = ACTUATED[name](), 60, 0.05
    ship = SimulatedShip(model)
    own = ship.model.configuration.ship
    way = bent(own.length, model.configuration.canal.width) if along else None
    controller, vessels = LAWS.get(law or ""), 5
    start = {n: c[:vessels] * (own.length / 4) ** (n in "xy") for n, c in starts(vessels, 3).items()}
    start |= {"x": np.full(vessels, 10 * own.length), "y": start["y"] * 0.3, "rudder": 0.05}
    found = sailed(ship, **start, **pushed, dt=dt, duration=steps * dt, controller=controller, waterway=way)
    assert (found["outcome"] == Code.AFLOAT).all()
    steering = steering_of(controller, ship.actuators)
    system = ship.system(along, steering.law if steering else None, "until" if pushed else "never")
    values = ship.values(rudder=0.05)
    channel = along_waterway(way, model, ship.shape) if along else straight_channel(values, ship.shape)
    inputs = {
        **values, **system.constants(values), **channel.inputs, **(steering.parameters if steering else {}),
        **dict.fromkeys(("X_in", "N_in", "X_in_after", "Y_in_after", "N_in_after"), 0.0),
        "Y_in": pushed.get("Y"), "push_end": pushed.get("push_end"),
        "step_length": dt, "share": 1.0,
    }  # fmt: skip
    given = [inputs[name] for name in system.scalar.STEP_INPUTS]
    for vessel in range(vessels):
        at = {n: float(np.broadcast_to(c, vessels)[vessel]) for n, c in start.items()} | {"t": 0.0, "revolutions": 0.0}
        at |= {"cos_psi": math.cos(at["psi"]), "sin_psi": math.sin(at["psi"])}
        at |= steering.memory(at) if steering else {}
        state = [at[name] for name in system.choices.kept]
        for _ in range(steps):
            *state, room, _ = system.scalar.step(channel.table, *state, *given)
            assert room > 0
        now = dict(zip(system.choices.kept, state, strict=True))
        for kept, value in now.items():
            if f"{kept}_end" in found:
                assert found[f"{kept}_end"][vessel] == pytest.approx(value, rel=1e-12, abs=1e-12), kept
        assert found["distance"][vessel] == pytest.approx(now["x"] - at["x"], rel=1e-12)


def test_contact_is_where_an_independent_solver_finds_it() -> None:
    """Away from the switch between the banks."""
    y = np.array([-2.2, -1.1, -0.3, 0.3, 0.7, 1.6, 2.2])
    found = sailed(y=y, dt=0.005, duration=60.0)
    for i, start in enumerate(y):
        exact = integrated(DTC, 60.0, y=start)
        assert found["outcome"][i] == Code.GROUNDED
        assert found["time"][i] == pytest.approx(exact.t[-1], abs=1e-6)
        assert found["distance"][i] == pytest.approx(exact.x[-1], abs=1e-6)
        for name in ("y", "psi", "v", "r"):
            assert found[f"{name}_end"][i] == pytest.approx(getattr(exact, name)[-1], abs=1e-6)
        assert found["side"][i] == np.sign(exact.y[-1])


@pytest.mark.parametrize("contact", ["corners", "midship"])
def test_the_gap_is_closed_at_contact(contact: str) -> None:
    ship = SimulatedShip(DTC, contact=contact)
    found = sailed(ship, y=np.linspace(0.35, 2.6, 40), psi=0.1, dt=0.02, duration=60.0)
    hit = found["outcome"] == Code.GROUNDED
    assert hit.sum() > 2
    hull, psi = DTC.configuration.ship, found["psi_end"]
    reach = hull.beam / 2 * np.cos(psi) + (contact == "corners") * hull.length / 2 * np.abs(np.sin(psi))
    room = DTC.configuration.canal.width / 2 - np.abs(found["y_end"]) - reach
    assert np.abs(room[hit]).max() < (1e-8 if contact == "corners" else 7e-3)
    assert (room[~hit] > 0).all()


def test_a_contact_is_found_in_a_few_steps() -> None:
    """Twins that sail as one keep every lane at work, so what is left over went into the search, to 1e-9 m."""
    for y in np.linspace(0.4, 2.5, 12):
        twins = fleet(SimulatedShip(DTC), y=np.full(64, y), duration=60.0, workers=1)
        ended = twins.ended()
        assert (ended["outcome"] == Code.GROUNDED).all()
        assert twins.prepared.lane_steps / 64 - np.ceil(ended["time"][0] / 0.02) <= 12


def test_an_outline_touches_with_its_points() -> None:
    """The rectangle's corners as points, and half of it cut off."""
    hull, start = DTC.configuration.ship, starts(200, seed=3)
    corners = [(f * hull.length / 2, a * hull.beam / 2) for f in (1, -1) for a in (1, -1)]
    one, other = (sailed(SimulatedShip(DTC, contact=shape), **start) for shape in ("corners", corners))
    np.testing.assert_array_equal(one["side"], other["side"])
    np.testing.assert_allclose(one["time"], other["time"], atol=1e-7)
    bow_only = [(f, a) for f, a in corners if f > 0] + [(0.0, 0.0), (0.1, 0.0)]
    later = sailed(SimulatedShip(DTC, contact=bow_only), **start)
    assert (later["time"] >= other["time"] - 1e-7).all()
    assert (later["time"] > other["time"] + 1e-3).any()


def test_a_mirrored_fleet_is_the_mirror_to_the_bit() -> None:
    start = starts(500)
    mirrored = {name: -column if f"{name}_end" in ODD else column for name, column in start.items()}
    one, other = (sailed(**own, dt=0.02, duration=30.0) for own in (start, mirrored))
    for name, column in one.items():
        np.testing.assert_array_equal(column, (-1 if name in ODD else 1) * other[name], err_msg=name)


def test_neither_cores_nor_company_change_a_voyage() -> None:
    start = starts(5000)
    one, two = (sailed(**start, dt=0.05, duration=30.0, workers=workers) for workers in (1, 2))
    few = sailed(**{n: c[4000:4003] for n, c in start.items()}, dt=0.05, duration=30.0)
    for name, column in one.items():
        np.testing.assert_array_equal(column, two[name])
        np.testing.assert_array_equal(column[4000:4003], few[name])


def test_values_may_differ_from_vessel_to_vessel() -> None:
    start, count, draw = starts(200), 200, np.random.default_rng(5)
    varied = {"b_v": draw.uniform(80, 120, count), "width": draw.uniform(6.5, 8, count)}
    dt = draw.uniform(0.02, 0.05, count)
    many = sailed(**start, **varied, dt=dt, duration=20.0)
    for i in (0, 77, 199):
        own = {name: column[i] for name, column in {**start, **varied}.items()}
        alone = sailed(**own, dt=dt[i], duration=20.0)
        for name, column in many.items():
            assert column[i] == pytest.approx(alone[name][0], rel=1e-11, abs=1e-12), name


def test_a_prepared_run_called_again_gives_the_same() -> None:
    """From what its start holds then, too."""
    prepared = fleet(SimulatedShip(DTC), **starts(100), duration=20.0).prepared
    outcomes = []
    for _ in range(2):
        prepared()
        outcomes.append([prepared.end.copy(), prepared.time.copy(), prepared.codes.copy()])
    for first, second in zip(*outcomes, strict=True):
        np.testing.assert_array_equal(first, second)
    moved = starts(100, seed=1)
    prepared.start[:, prepared.kernel.KEPT_NAMES.index("y")] = moved["y"]
    prepared()
    anew = fleet(SimulatedShip(DTC), **{**starts(100), "y": moved["y"]}, duration=20.0).prepared
    anew()
    np.testing.assert_array_equal(prepared.end, anew.end)


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="reads x86 assembly")
@pytest.mark.parametrize("name", [*TABLES, "pilot in a waterway"])
@pytest.mark.slow
def test_a_block_is_stepped_by_vectors(name: str) -> None:
    """No lane on its own: the step divides packed numbers only, and calls no exponential.

    But one quotient in a waterway, the cell of a table from which a processor without AVX-512 reads lane by lane.
    """
    if name in TABLES:
        prepared = fleet(SimulatedShip(model_of(TABLES[name])), y=0.5).prepared
    else:
        model = ACTUATED["steered"]()
        way = bent(model.configuration.ship.length, model.configuration.canal.width)
        prepared = fleet(SimulatedShip(model), y=0.5, x=40.0, controller=LAWS["pilot"], waterway=way).prepared
    machine, _ = this_machine()
    assembly = machine.emit_assembly(optimised(prepared.kernel, "step", machine))
    assert "divpd" in assembly
    gathers = llvm.get_host_cpu_features().get("avx512f", False)
    assert assembly.count("divsd") <= (0 if name in TABLES or gathers else 4)
    assert "exp" not in [line.split()[-1].lstrip("$") for line in assembly.splitlines() if "call" in line]


class TestOutcomes:
    """How voyages end, beside the usual way."""

    def test_time_is_up_exactly(self) -> None:
        found = sailed(y=[0.5, 0.0], duration=1.01)
        assert found["outcome"].tolist() == [Code.AFLOAT] * 2
        np.testing.assert_allclose(found["time"], 1.01, rtol=1e-14)
        np.testing.assert_allclose(found["distance"][1], 1.01, rtol=1e-14)
        assert found["side"].tolist() == [0, 0]

    @pytest.mark.parametrize(("duration", "dt"), [(11.5, 0.9), (1.0, 30.0), (0.3, 0.1), (0.7, 0.1), (2.0, 1 / 3)])
    def test_a_last_step_is_as_short_as_it_must_be(self, duration: float, dt: float) -> None:
        found = sailed(y=0.1, dt=dt, duration=duration)
        assert found["time"][0] == pytest.approx(duration, rel=1e-14)
        assert found["distance"][0] == pytest.approx(nw.simulate(DTC, 0.1, duration=duration, dt=dt).x[-1], rel=1e-13)

    def test_on_the_centreline_nothing_happens(self) -> None:
        found = sailed(y=0.0)
        assert (found["y_end"][0], found["psi_end"][0], found["outcome"][0]) == (0.0, 0.0, Code.AFLOAT)
        assert found["distance"][0] == pytest.approx(40.0)

    def test_before_they_begin(self) -> None:
        found = sailed(y=np.array([3.3, -3.3, 0.0, 0.5]), psi=np.array([0, 0, 1.5, 0]), duration=0.5)
        assert found["outcome"].tolist() == [Code.GROUNDED, Code.GROUNDED, Code.OUTSIDE, Code.AFLOAT]
        assert found["side"].tolist() == [1, -1, 0, 0]
        assert found["time"].tolist() == [0.0, 0.0, 0.0, 0.5]
        assert sailed(y=0.5, duration=0.0)["time"].tolist() == [0.0]

    def test_across_the_canal(self) -> None:
        found = sailed(y=0.0, r=0.5, u=0.1, duration=400.0, width=400.0)
        assert found["outcome"][0] == Code.OUTSIDE
        assert np.degrees(found["psi_end"][0]) == pytest.approx(85.0, abs=1e-6)

    def test_beyond_any_sense(self) -> None:
        found = sailed(y=np.array([0.0, 1.0]), v=np.array([0.01, 0.0]), duration=400.0, width=400.0, b_v=-1e5)
        assert found["outcome"].tolist() == [Code.DIVERGED] * 2
        assert all(np.isfinite(found[name]).all() for name in ("y_end", "v_end", "r_end", "time"))

    def test_a_nan_is_noticed(self) -> None:
        """A kernel compiled without regard for NaN would sail on."""
        found = sailed(y=np.full(70, 0.5), v=0.1, dt=0.5, c_vv=-1e300)
        assert (found["outcome"] == Code.DIVERGED).all()

    def test_each_has_its_kind(self) -> None:
        assert set(end.KINDS) == set(Code)


def test_a_value_that_is_missing_is_named() -> None:
    with pytest.raises(nw.InputError, match="need draft"):
        fleet(SimulatedShip(DTC), y=0.5, draft=None)


@pytest.mark.parametrize("workers", [1, 2])
def test_an_empty_fleet_comes_back_empty(workers: int) -> None:
    assert len(sailed(y=np.empty(0), workers=workers)["time"]) == 0


@pytest.mark.parametrize("along", [False, True])
def test_no_name_of_a_kernel_means_two_things(along: bool) -> None:
    """It is put together of several files, which know nothing of each other's constants."""
    way = bent(4.0, 7.0) if along else None
    kernel = fleet(
        SimulatedShip(ACTUATED["steered"]()), x=50.0, controller=LAWS["zigzag"], waterway=way
    ).prepared.kernel
    names: list[str] = []
    for node in ast.parse(Path(kernel.__file__).read_text()).body:
        if isinstance(node, ast.FunctionDef):
            names.append(node.name)
        elif isinstance(node, ast.Assign):
            names += [own.id for own in ast.walk(node.targets[0]) if isinstance(own, ast.Name)]
    assert sorted({name for name in names if names.count(name) > 1}) == []
