"""Trials that tuned the default weights of the regulator: beside voyages, and the search beside known minima."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from full_size import full_size

import narrows as nw
from narrows.control import RegulatorWeights, regulator
from narrows.simulation.grid import sampled

sys.path.insert(0, str(Path(__file__).parents[2] / "decisions"))
from regulator_weights import DesignTrials, Scene, ScenePush, searched

SPEED, HOLD = 4.5, 50.0
QUIET = {"y": 0.0, "psi": 0.0, "v": 0.0, "r": 0.0}


def test_a_trial_is_a_voyage_of_its_ship() -> None:
    """By ``simulate``, with the pushes as forces in newtons."""
    weights = RegulatorWeights(heading_deg=3.0, bank=0.2)
    push = ScenePush(2.0, 3.5, 0.05, 0.08)
    trials = DesignTrials(full_size(), HOLD, SPEED, (Scene(1.0, 0.2, (push,)),), 6, 4, QUIET)
    result = trials.run(weights)
    linear, hull = trials.systems[0], full_size().configuration.ship
    moment = float(linear.B[3, 0] / linear.G[3, linear.disturbances.index("N")])
    time, ships = hull.length / SPEED, {name: c.to_numpy() for name, c in sampled(full_size(), 6, 4).items()}
    starts = trials._begun
    for ship in (0, 3, 5):
        model = full_size().with_coefficients(**{name: float(column[ship]) for name, column in ships.items()})
        law = regulator(full_size(), HOLD, SPEED, weights=weights)
        course, psi = law.lines[0], float(np.arctan2(starts[ship, 3], starts[ship, 2]))
        acting = {"Y": (moment / hull.length * push.force), "N": moment * push.moment}
        forces = {n: [(push.start * time, value), (push.stop * time, 0.0)] for n, value in acting.items()}
        voyage = nw.simulate(
            model, HOLD + 0.2 * hull.beam, SPEED, 11.7 * time, time / 50, psi=psi, v=course.v, rudder=course.rudder,
            controller=law, **forces,
        )  # fmt: skip
        if voyage.grounded:
            assert np.isinf(result.off[0, ship])
            continue
        off = np.abs(voyage.y[:-1] - HOLD)[voyage.t[:-1] > 10.5 * time - 0.01].max() / (hull.beam / 2)
        assert result.off[0, ship] == pytest.approx(off, rel=1e-6)
        assert result.travel[0, ship] == pytest.approx(np.abs(np.diff(voyage.rudder[:-1])).sum(), rel=1e-6)


def test_noise_is_as_large_as_it_is_said_to_be() -> None:
    """The rudder of a ship that sees its offset alone with noise works in proportion to it, and not without."""
    certain = replace(full_size(), covariance=0.0 * full_size().covariance)
    travel = []
    for size in (0.0, 0.3, 0.6):
        trials = DesignTrials(certain, HOLD, SPEED, (Scene(1.0, 0.0),), 50, 4, {**QUIET, "y": size})
        travel.append(float(np.median(trials.run(RegulatorWeights()).travel)))
    assert travel[2] > 1.5 * travel[1] > 1.5 * travel[0]


def test_the_search_begins_with_more_of_each_weight_and_less_of_the_bank() -> None:
    """The bank's share may be 1 already."""
    tried: list[np.ndarray] = []

    def cost(point: np.ndarray) -> float:
        tried.append(point.copy())
        return float((point**2).sum())

    start = np.array([0.3, -0.2, 1.0])
    searched(cost, start, 1)
    steps = np.array(tried[:4]) - start
    assert (np.count_nonzero(steps, axis=1) == [0, 1, 1, 1]).all()
    assert (np.sign(np.diag(steps[1:])) == [1, 1, -1]).all()


def test_the_search_finds_the_minimum_of_a_valley() -> None:
    """Of a quadratic whose axes differ by a factor of a thousand, turned."""
    turned = np.linalg.qr(np.random.default_rng(2).standard_normal((4, 4)))[0]
    matrix, least = turned @ np.diag([1.0, 10.0, 100.0, 1000.0]) @ turned.T, np.array([0.3, -0.2, 0.5, 0.1])
    found = searched(lambda x: float((x - least) @ matrix @ (x - least)), np.zeros(4), 150)
    np.testing.assert_allclose(found, least, atol=1e-3)
