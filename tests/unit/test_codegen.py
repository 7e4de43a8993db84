"""Printed equations of motion are held to the terms themselves, evaluated by NumPy; one step to another's of ours."""

import pickle
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import narrows as nw
from direct_equation import accelerations
from engine_models import ACTUATED, TABLES, cross_flow, model_of, rates_by_hand, states, steered, values_of
from narrows.codegen.free_motion import STATE, Choices, solve_motion
from narrows.codegen.system import System
from narrows.codegen.trace import trace_of_terms
from narrows.quantities import names as dim
from narrows.simulation.ship import SimulatedShip, along_waterway, straight_channel

PUSHED = Choices(pushed="always")


def rates(system: System, values: dict, state: dict, functions: SimpleNamespace | None = None) -> list:
    functions = functions or system.scalar
    numbers = system.constants(values)
    return list(functions.rates(*state.values(), *(numbers[name] for name in functions.RATES_INPUTS)))


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("surge", ["held", "free"])
@pytest.mark.parametrize("name", TABLES)
def test_printed_rates_are_the_terms_own(name: str, surge: str, coriolis: bool) -> None:
    model = model_of(TABLES[name])
    system, columns = System(model.terms, surge, coriolis, PUSHED), states(50)
    together = np.broadcast_arrays(*rates(system, values_of(model), columns, system.columns))
    for row in range(50):
        state = {key: float(column[row]) for key, column in columns.items()}
        expected = rates_by_hand(model, state, surge, coriolis)
        np.testing.assert_allclose(rates(system, values_of(model), state), expected, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose([column[row] for column in together], expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("name", ["steered", "mmg+delta"])
def test_printed_rates_are_the_accelerations_of_the_terms(name: str) -> None:
    """With a rudder that stands over, and a propeller."""
    model, rudder = ACTUATED[name](), 0.2
    ship = SimulatedShip(model, "free", None if name == "mmg+delta" else 280.0)
    system, state = ship.system(), {key: float(column[3]) for key, column in states(4).items()}
    motion = nw.Motion(**{key: state[key] for key in ("x", "y", "cos_psi", "sin_psi", "u", "v", "r")})
    found = rates(system, ship.values(rudder=rudder), state)[4:]
    at_rest = accelerations(model, motion, surge_inertia=ship.surge_inertia)
    assert not np.allclose(found, at_rest, rtol=1e-3)
    still = model.forces(motion, rudder=rudder)
    mass = np.array([
        [still[f] - model.forces(replace(motion, **{a: 1.0}), rudder=rudder)[f] for a in ("udot", "vdot", "rdot")]
        for f in "XYN"
    ])  # fmt: skip
    if ship.surge_inertia is not None:
        mass[0, 0] = ship.surge_inertia
    np.testing.assert_allclose(found, np.linalg.solve(mass, [still[f] for f in "XYN"]), rtol=1e-11, atol=1e-13)


def test_the_rates_are_those_of_the_straight_canal_in_one_that_does_not_change() -> None:
    """The step of a waterway, its section that of the canal, without bend and current."""
    model = steered()
    ship, length = SimulatedShip(model), 200.0
    values, state = ship.values(rudder=0.1), (50.0, 0.7, np.cos(0.05), np.sin(0.05), 1.0, 0.02, -0.01)
    way = nw.straight_waterway(model.configuration.canal, length)
    stepped = []
    for waterway, channel in (
        (False, straight_channel(values, ship.shape)), (True, along_waterway(way, model, ship.shape)),
    ):  # fmt: skip
        system = ship.system(waterway)
        inputs = {**values, **system.constants(values), **channel.inputs, "step_length": 0.3, "share": 1.0}
        names = system.scalar.STEP_INPUTS
        stepped.append(system.scalar.step(channel.table, *state, *(float(inputs[name]) for name in names))[:7])
    np.testing.assert_allclose(stepped[0], stepped[1], rtol=1e-13, atol=1e-14)


def test_accelerations_enter_linearly() -> None:
    table = nw.PAPER.with_terms("bad", yaw=[nw.Term("c_bad", "c", lambda vdot, rdot: vdot * rdot, dim.NUMBER)])
    forces = tuple((term.name, force) for force, terms in table.forces.items() for term in terms)
    with pytest.raises(nw.InputError, match="term c_bad: an acceleration must enter linearly"):
        solve_motion(trace_of_terms(table), forces, "held", coriolis=False)


def system_of(table: nw.TermTable, surge: str = "held") -> System:
    return System(table, surge, False, Choices())


def test_every_motion_has_an_inertia() -> None:
    bare = nw.TermTable("bare", nw.PAPER.surge, nw.PAPER.sway[2:], nw.PAPER.yaw[1:])
    with pytest.raises(nw.InputError, match="no term resists vdot"):
        system_of(bare).constants({})


@pytest.mark.parametrize("name", ["u", "width", "rudder", "revolutions", "Y_in", "lambda", "__debug__"])
def test_a_coefficient_has_a_name_of_its_own(name: str) -> None:
    with pytest.raises(nw.InputError, match=f"cannot be called '{name}'|term {name}: the name already means something"):
        system_of(nw.PAPER.with_terms("bad", sway=[nw.Term(name, "b", cross_flow, dim.NUMBER)])).constants({})


NAMES = (
    "k0", "t1", "v²", "E", "abs", "sqrt", "exp", "log", "sine", "power", "entry", "table", "h", "t", "dt",
    "share", "step_length", "clearance", "side", "law_angle", "push_end", "half_beam", "least_cos", "real", "block",
    "constants", "PARAMETERS",
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_coefficient_may_be_called_anything_else(name: str) -> None:
    one, other = (
        nw.PAPER.with_terms("own", sway=[nw.Term(own, "b", cross_flow, dim.NUMBER)]) for own in (name, "b_uv")
    )
    values = values_of(model_of(nw.PAPER))
    state = {key: float(column[0]) for key, column in states(1).items()}
    found, expected = (
        rates(system_of(table), {**values, own: 60.0}, state) for table, own in ((one, name), (other, "b_uv"))
    )
    assert found == expected


def sailed_with(name: str) -> nw.Outcome:
    """How a voyage ends under a law, where the model has a coefficient of this name."""
    model, table = steered(), nw.STEERED.with_terms("own", sway=[nw.Term(name, "b", cross_flow, dim.NUMBER)])
    named = nw.Model(model.configuration, table, {**model.coefficients, name: 0.1})
    return nw.simulate(named, y=0.3, duration=3.0, dt=0.1, controller=nw.ConstantRudder(0.2)).outcome


@pytest.mark.parametrize("name", [*NAMES, "x_first", "most_speed"])
def test_a_voyage_does_not_ask_what_a_coefficient_is_called(name: str) -> None:
    """Neither the numbers of hull and canal nor those of a law are taken for it."""
    assert sailed_with(name) == sailed_with("b_own")


@pytest.mark.parametrize("name", ["rudder_limit", "rudder_rate", "wall_port"])
def test_what_else_goes_by_name_is_refused(name: str) -> None:
    with pytest.raises(nw.InputError, match=f"term {name}: the name already means something else"):
        sailed_with(name)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"draft": None}, "need draft"),
        ({"b_vdot": 0.0, "b_rdot": 0.0}, "mass matrix cannot be inverted"),
        ({"b_v": float("nan")}, "mass matrix cannot be inverted; check that the coefficients are finite"),
    ],
)
def test_values_that_cannot_be_are_refused(change: dict, words: str) -> None:
    with pytest.raises(nw.InputError, match=words):
        system_of(nw.PAPER).constants({**values_of(model_of(nw.PAPER)), **change})


def test_a_free_speed_needs_a_mass() -> None:
    dtc = nw.published("mikkelsen2025_dtc")
    values = {**dtc.configuration.values(), **dtc.coefficients}
    with pytest.raises(nw.InputError, match="surge_inertia"):
        system_of(nw.PAPER, "free").constants(values)


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ({"surge": "loose"}, "surge = 'loose' is unknown"),
        ({"contact": "corner"}, "did you mean 'corners'"),
        ({"contact": [(1.0, 0.0)]}, "as 3 to 1000 points"),
        ({"contact": [1.0, 2.0, 3.0]}, "an outline as"),
        ({"contact": [(1.0, 0.3), (1.0, -0.3), (np.inf, 0.0)]}, "in metres"),
        ({"contact": [(1.0, 0.0), (0.0, 0.0), (-1.0, 0.0)]}, "lie on one line"),
        ({"contact": [(1.0, 0.2), (1.0, -0.2), (-1.0, 0.0)]}, "make it as wide as the beam"),
    ],
)
def test_unknown_choices_are_refused(choice: dict, words: str, dtc: nw.Model) -> None:
    with pytest.raises(nw.InputError, match=words):
        nw.simulate(dtc, **choice)


def test_a_system_goes_to_other_processes() -> None:
    model = steered()
    system = SimulatedShip(model, contact=[(1.0, 0.3), (1.0, -0.3), (-1.0, 0.3)]).system()
    state = {key: float(column[0]) for key, column in states(1).items()}
    again = pickle.loads(pickle.dumps(system))
    values = {**values_of(model_of(nw.PAPER)), **SimulatedShip(model).values(rudder=0.1)}
    assert again.key == system.key
    assert rates(again, values, state) == rates(system, values, state)


def test_the_state_is_a_pose_and_three_velocities() -> None:
    assert STATE == ("x", "y", "cos_psi", "sin_psi", "u", "v", "r")
