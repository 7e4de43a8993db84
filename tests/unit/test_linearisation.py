"""Exact Jacobians by state, control and coefficient, against central differences of the accelerations of the terms."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pytest

import narrows as nw
from engine_models import ACTUATED, SURGE_INERTIA, TABLES, model_of, states
from narrows.codegen.linearisation import LINEARISED
from narrows.simulation.ship import SimulatedShip

AT = {"x": 0.0, "y": 1.3, "psi": -0.4, "u": 0.8, "v": 0.11, "r": -0.07}
PUSHED = {"X_in": 3.0, "Y_in": -2.0, "N_in": 5.0}
CONTROLS = {"rudder": 0.17, "revolutions": 9.0}
MODELS: dict[str, Callable[[], nw.Model]] = {
    **{name: lambda table=table: model_of(table) for name, table in TABLES.items()}, **ACTUATED,
}  # fmt: skip


def rates(model: nw.Model, at: Mapping[str, float], free: bool, inertia: float | None) -> np.ndarray:
    """From the forces of the terms alone, the rigid body's Coriolis force added."""
    motion = nw.Motion.at(at["psi"], y=at["y"], u=at["u"], v=at["v"], r=at["r"])

    def force(**more: float) -> np.ndarray:
        positions = {own.name: at[own.name] for own in model.terms.actuators}
        return np.array(list(model.forces(replace(motion, **more), **positions).values()), float)

    still, heavy = force(), model.configuration.ship.mass
    mass = np.stack([still - force(**{name: 1.0}) for name in ("udot", "vdot", "rdot")], axis=1)
    if inertia is not None:
        mass[0, 0] = inertia
    u, v, r, c, s = at["u"], at["v"], at["r"], np.cos(at["psi"]), np.sin(at["psi"])
    rest = still + [at[name] for name in PUSHED] + heavy * r * np.array([v, -u, 0.0])
    part = slice(0 if free else 1, 3)
    found = np.zeros(3)
    found[part] = np.linalg.solve(mass[part, part], rest[part])
    return np.array([u * c - v * s, u * s + v * c, r, *found])


def slopes(function: Callable[[dict[str, float]], np.ndarray], about: Mapping[str, float]) -> np.ndarray:
    """Of the rates by each of some named numbers."""
    columns = []
    for name, value in about.items():
        width = 1e-6 * max(1.0, abs(value))
        ahead, behind = (function({**about, name: value + sign * width}) for sign in (1, -1))
        columns.append((ahead - behind) / (2 * width))
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("surge", ["held", "free"])
@pytest.mark.parametrize("name", MODELS)
def test_jacobians_are_differences(name: str, surge: str) -> None:
    model, free = MODELS[name](), surge == "free"
    inertia = SURGE_INERTIA if free and name != "mmg+delta" else None
    ship = SimulatedShip(model, surge, inertia, coriolis=True)
    exact = ship.system().linearisation(ship.values(), ship.actuators)
    at = {**AT, **PUSHED, **CONTROLS}
    driven = [*PUSHED, *(own.name for own in ship.actuators)]
    assert list(exact.controlled) == driven
    assert {"steered": 1, "mmg+delta": 2}.get(name, 0) == len(ship.actuators)

    def at_state(**changed: float) -> np.ndarray:
        return rates(model, {**at, **changed}, free, inertia)

    def with_coefficients(own: dict[str, float]) -> np.ndarray:
        given = inertia
        if free and given is not None and "a_udot" in own:  # the whole mass was given, the table's own within it
            given = given + own["a_udot"] - model.coefficients["a_udot"]
        return rates(replace(model, coefficients=own), at, free, given)

    expected = {
        "linear": slopes(lambda own: at_state(**own), {n: at[n] for n in (*LINEARISED, *driven)}),
        "coefficients": slopes(with_coefficients, {n: model.coefficients[n] for n in model.terms.names}),
    }
    for kind, matrix in expected.items():
        found = getattr(exact, kind)(at)
        np.testing.assert_allclose(found, matrix, rtol=1e-6, atol=2e-9 * np.abs(matrix).max(), err_msg=kind)


@pytest.mark.parametrize("name", MODELS)
def test_columns_go_through(name: str) -> None:
    ship = SimulatedShip(MODELS[name]())
    exact = ship.system().linearisation(ship.values(), ship.actuators)
    columns = {**states(6), "rudder": np.linspace(-0.3, 0.3, 6), "revolutions": np.linspace(6.0, 12.0, 6)}
    for kind in ("linear", "coefficients"):
        many = getattr(exact, kind)(columns)
        assert many.shape[:2] == (6, 6)
        for row in range(6):
            one = getattr(exact, kind)({key: float(column[row]) for key, column in columns.items()})
            np.testing.assert_allclose(many[row], one, rtol=1e-12, atol=1e-14)


def test_coefficients_of_a_fleet_go_through() -> None:
    ship = SimulatedShip(model_of(nw.PAPER))
    system, b_v = ship.system(), np.array([80.0, 100.0, 130.0])
    many = system.linearisation({**ship.values(), "b_v": b_v}, ()).linear(AT)
    for row, own in enumerate(b_v):
        one = system.linearisation({**ship.values(), "b_v": own}, ()).linear(AT)
        np.testing.assert_allclose(many[row], one, rtol=1e-13, atol=1e-15)


def test_of_an_exactly_straight_course(dtc: nw.Model) -> None:
    """|v| v has no kink in its slope: no sign of nought is asked for, and the published poles come out."""
    ship = SimulatedShip(dtc)
    matrix = ship.system().linearisation(ship.values(), ()).linear({"u": 1.0})
    poles = np.linalg.eigvals(matrix[np.ix_((1, 2, 4, 5), (1, 2, 4, 5))])
    pair = poles[np.argmax(poles.imag)]
    assert pair == pytest.approx(0.260 + 0.248j, abs=1e-3)


def test_heading_and_rudder_may_be_given_as_cosine_and_sine() -> None:
    ship = SimulatedShip(ACTUATED["steered"]())
    exact = ship.system().linearisation(ship.values(), ship.actuators)
    told = {"cos_psi": np.cos(0.1), "sin_psi": np.sin(0.1), "cos_rudder": np.cos(0.2), "sin_rudder": np.sin(0.2)}
    one, other = (exact.linear({"y": 0.4, "u": 1.0, **own}) for own in (told, {"psi": 0.1, "rudder": 0.2}))
    np.testing.assert_array_equal(one, other)
