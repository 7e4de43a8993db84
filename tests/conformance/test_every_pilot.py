"""Every pilot of ``PILOTS``: it goes by finite numbers at every place, and steers many trials as it steers each alone.

That a trial is a voyage of its own is held for each of them in ``tests/unit/test_pilots.py``.
"""

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import narrows as nw
from engine_models import steered
from narrows.safety.pilots import PILOTS, BestEstimateCourses, Pilot
from narrows.simulation.controllers import ControlLaw
from narrows.simulation.ship import SimulatedShip

every_pilot = pytest.mark.parametrize("name", PILOTS)
RATIO = 64.0
"""Over the model's size: a hand at the wheel is too slow for a ship of 4 m."""
OFFSETS, SPEEDS = RATIO * np.array([-0.3, 0.0, 0.2]), RATIO**0.5 * np.array([0.8, 1.0])


@cache
def ship() -> SimulatedShip:
    """A ship beside weak banks."""
    model = steered().with_coefficients(b_bank=0.05, c_bank=0.02)
    return SimulatedShip(nw.scale_model(model, RATIO * model.configuration.ship.length).model)


@cache
def courses() -> BestEstimateCourses:
    return BestEstimateCourses(ship(), OFFSETS, SPEEDS, np.zeros(2))


def law_of(pilot: Pilot, tuning: Any, places: Any) -> ControlLaw:
    """Its law at some places of the grid, by the courses of the likely ship; of the drawn one it knows y, u and r."""
    numbers = {name: np.broadcast_to(table, (3, 2)).ravel()[places] for name, table in
               pilot.numbers(courses(), tuning).items()}  # fmt: skip
    y, u = (one.ravel()[places] for one in np.meshgrid(OFFSETS, SPEEDS, indexing="ij"))
    return pilot.law(ship(), numbers, {"y": y, "u": u, "r": np.zeros_like(y)})


def ordered(law: ControlLaw, motion: dict[str, Any]) -> list[np.ndarray]:
    """Its rudder orders over three steps of one motion, its memory kept."""
    memory, found = law.memory(motion), []
    about = {"dt": 0.05, "rudder_limit": 0.6, "rudder_rate": 0.3, "current": 0.0}
    for step in range(3):
        at = SimpleNamespace(**about, **motion, **law.parameters(), **memory, t=4.0 * step, water=lambda name, x: 3.0)
        orders, memory = law.orders(at)
        found.append(np.asarray(orders["rudder"]))
    return found


def motions(count: int) -> dict[str, np.ndarray]:
    draw = np.random.default_rng(7).uniform(-1.0, 1.0, (6, count))
    motion = {"y": 0.5 * draw[0], "psi": 0.1 * draw[1], "v": 0.05 * draw[2], "r": 0.02 * draw[3], "x": 10.0 + draw[4]}
    motion |= {"u": 0.9 + 0.1 * draw[5], "rudder": 0.1 * draw[4]}
    return motion | {"cos_psi": np.cos(motion["psi"]), "sin_psi": np.sin(motion["psi"])}


@every_pilot
def test_it_goes_by_finite_numbers_at_every_place(name: str) -> None:
    pilot = PILOTS[name]
    assert pilot.words
    assert pilot.tunings
    for tuning in pilot.tunings:
        for table in pilot.numbers(courses(), tuning).values():
            assert np.broadcast_shapes(np.shape(table), (3, 2)) == (3, 2)
            assert np.isfinite(table).all()


@every_pilot
def test_many_trials_are_steered_as_each_alone(name: str) -> None:
    pilot, motion = PILOTS[name], motions(6)
    for tuning in pilot.tunings:
        law = law_of(pilot, tuning, slice(None))
        assert isinstance(law, ControlLaw)
        together = ordered(law, motion)
        for place in range(6):
            alone = law_of(pilot, tuning, slice(place, place + 1))
            own = ordered(alone, {key: column[place : place + 1] for key, column in motion.items()})
            np.testing.assert_allclose(
                [step[place] for step in map(np.atleast_1d, together)], np.ravel(own), rtol=1e-12
            )


@every_pilot
def test_it_brings_the_ship_back_to_its_line(name: str) -> None:
    """The usual one, from a tenth of the beam off, where nothing but the banks acts."""
    pilot, u = PILOTS[name], float(SPEEDS[1])
    law = law_of(pilot, pilot.tunings[0], 3)
    off, time = 0.06 * RATIO, RATIO**0.5
    voyage = nw.simulate(ship().model, y=off, u=u, duration=80.0 * time, dt=0.05 * time, controller=law)
    assert voyage.outcome.kind == "afloat"
    assert np.abs(voyage.y[voyage.t > 60.0 * time]).max() < off, "its gains are too weak, or of the wrong sign"


@every_pilot
def test_the_command_line_takes_it(name: str) -> None:
    with pytest.raises(nw.InputError, match=name):
        nw.safe_envelope(ship().model, controller="nobody at all")
