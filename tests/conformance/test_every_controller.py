"""Every law of ``CONTROLLERS``: arithmetic, with a memory that is kept; the matrix sails each in every engine."""

from dataclasses import is_dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import narrows as nw
from engine_models import steered
from narrows.quantities.arithmetic import COLUMNS
from narrows.quantities.names import Number
from narrows.simulation.controllers import CONTROLLERS, ControlLaw
from narrows.simulation.ship import MEMORY, PARAMETER, SimulatedShip, steering_of

LENGTH = steered().configuration.ship.length
LAWS = {name: example(LENGTH) for name, example in CONTROLLERS.items()}
every_law = pytest.mark.parametrize("law", LAWS.values(), ids=list(LAWS))
WATER = {"curvature": 0.01, "starboard": 3.4, "port": 3.6}


def motions(count: int) -> dict[str, np.ndarray]:
    """What a law sees of the ship, a column each."""
    draw = np.random.default_rng(5).uniform(-1.0, 1.0, (6, count))
    names = {"y": 1.0, "psi": 0.3, "v": 0.05, "r": 0.02, "rudder": 0.1, "x": 30.0}
    motion = {name: size * row for (name, size), row in zip(names.items(), draw, strict=True)}
    motion |= {"cos_psi": np.cos(motion["psi"]), "sin_psi": np.sin(motion["psi"]), "u": 1.0 + 0.1 * draw[0]}
    return motion | {"t": np.linspace(0.0, 12.0, count)}


def seen(law: ControlLaw, motion: dict[str, Any], memory: dict[str, Any]) -> SimpleNamespace:
    about = {"dt": 0.05, "rudder_limit": 0.6, "rudder_rate": 0.3, "current": 0.1}
    return SimpleNamespace(**about, **motion, **law.parameters(), **memory, water=lambda name, x: WATER[name] + 0 * x)


def begun(law: ControlLaw) -> dict[str, Any]:
    start = {name: float(column[0]) for name, column in motions(3).items()}
    return dict(law.memory(start))


def test_no_law_is_forgotten() -> None:
    laws = {one for one in vars(nw.controllers).values() if is_dataclass(one) and hasattr(one, "orders")}
    assert laws == {type(law) for law in LAWS.values()}, "give each an example in CONTROLLERS"


@every_law
def test_it_is_a_law_of_a_module_that_gives_it(law: ControlLaw) -> None:
    assert isinstance(law, ControlLaw)
    assert getattr(nw.controllers, type(law).__name__) is type(law)
    assert (type(law).__doc__ or "").strip()


@every_law
def test_orders_are_the_same_for_columns_and_for_lines(law: ControlLaw) -> None:
    """On floats, on columns, and as the engine has written it down."""
    motion, memory = motions(40), begun(law)
    together, kept = law.orders(seen(law, motion, memory))
    steering = steering_of(law, SimulatedShip(steered()).actuators)
    assert steering is not None
    for number in range(40):
        own = {name: float(column[number]) for name, column in motion.items()}
        orders, after = law.orders(seen(law, own, memory))
        assert after.keys() == memory.keys()
        lines = {**own, "step_length": 0.05, "current": 0.1, "rudder_limit": 0.6, "rudder_rate": 0.3}
        lines |= {PARAMETER(name): value for name, value in law.parameters().items()}
        lines |= {MEMORY(name): value for name, value in memory.items()}
        water = {f"water_{name}": lambda x, at=value: at for name, value in WATER.items()}
        asked = {name: lines[name] for name in steering.law.trace.inputs}
        written = steering.law.trace.replay(asked, functions={**COLUMNS, **water})
        for name, order in orders.items():
            assert part(together[name], number) == pytest.approx(float(order), rel=1e-12, abs=1e-15)
            assert float(written[name]) == pytest.approx(float(order), rel=1e-12, abs=1e-15)
        for name, value in after.items():
            assert part(kept[name], number) == pytest.approx(float(value), rel=1e-12, abs=1e-15)
            assert float(written[MEMORY(name)]) == pytest.approx(float(value), rel=1e-12, abs=1e-15)


def part(column: Number, number: int) -> float:
    return float(np.broadcast_to(column, 40)[number])


@every_law
def test_it_remembers_over_jumps_of_the_forces(law: ControlLaw) -> None:
    """Forces that jump from nought to nought change nothing."""
    plain, pushed = (
        nw.simulate(steered(), y=0.2, controller=law, X=forces, duration=12.0, dt=0.1)
        for forces in (0.0, [(0.0, 0.0), (3.0, 0.0), (6.0, 0.0)])
    )
    np.testing.assert_allclose(pushed.psi, plain.psi, rtol=0, atol=1e-10)
    np.testing.assert_allclose(pushed.rudder, plain.rudder, rtol=0, atol=1e-10)


@every_law
def test_it_keeps_nothing_from_voyage_to_voyage(law: ControlLaw) -> None:
    one, other = (nw.simulate(steered(), y=0.2, controller=law, duration=5.0, dt=0.1) for _ in range(2))
    np.testing.assert_array_equal(one.rudder, other.rudder)
    assert np.ptp(one.rudder) > 0, "its example orders nothing"
