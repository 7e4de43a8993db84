"""Mean and covariance after a log, held to a quadrature of the filter's likelihood over inertia and a force."""

from dataclasses import replace

import numpy as np

import narrows as nw
from narrows.logbook.filtering.likelihood import RecordLikelihood, SearchResult, search
from narrows.logbook.learning.log_posterior import posterior_mean
from narrows.logbook.learning.log_setup import LogSetup, log_problem

KCS = nw.published("estimated_kcs").in_open_water()
UNCERTAIN = {"N_jz": 0.4, "N_rudder": 0.4}  # of each, as a share
REACH, NODES = 5.0, 21


def log() -> list[nw.ShipRecord]:
    """A zigzag, which determines the rudder's moment over the inertia."""
    voyage = nw.simulate(KCS, u=6.0, duration=240.0, dt=1.0, controller=nw.Zigzag(0.35, 0.35), contact="none")
    names = "x", "y", "psi", "r", "u", "rudder"
    return [nw.ShipRecord("zigzag", {name: nw.Signal(voyage.t, voyage[name]) for name in names})]


def found(uncertain: dict[str, float]) -> tuple[LogSetup, SearchResult]:
    spread = {name: share * abs(KCS[name]) for name, share in uncertain.items()}
    setup = log_problem(KCS, log(), "vdr", spread=spread)
    problem = replace(setup.problem, model=replace(setup.problem.model, estimated=()))
    result = search(problem, setup)
    assert result is not None
    assert result.converged
    return setup, result


def test_mean_and_covariance_are_those_of_a_quadrature() -> None:
    setup, result = found(UNCERTAIN)
    problem, mode = result.problem, result.unknowns
    (grid,), path = setup, result.records[0].path
    assert path is not None
    likelihood = RecordLikelihood(problem, grid)
    sizes, axes = np.linalg.eigh(problem.covariance(result.information))
    nodes = np.stack(np.meshgrid(*2 * [np.linspace(-REACH, REACH, NODES)]), axis=-1).reshape(-1, 2)
    unknowns = mode + nodes * np.sqrt(sizes) @ axes.T
    cost = np.array([likelihood.cost(at, path) + at @ problem.precision @ at for at in unknowns])
    weights = np.exp((cost.min() - cost) / 2)
    weights /= weights.sum()
    mean = weights @ unknowns
    covariance = (unknowns - mean).T @ (weights[:, None] * (unknowns - mean))
    std = np.sqrt(np.diag(covariance))
    assert (np.abs(mode - mean) > 0.1 * std).all(), "the mode would do"
    ours, spread = posterior_mean(result)
    np.testing.assert_allclose((ours - mean) / std, 0.0, atol=0.05)
    np.testing.assert_allclose(spread / np.outer(std, std), covariance / np.outer(std, std), atol=0.1)


def test_with_known_inertia_the_mean_is_the_mode() -> None:
    _, result = found({"N_rudder": 0.4})
    ours, spread = posterior_mean(result)
    np.testing.assert_array_equal(ours, result.unknowns)
    np.testing.assert_array_equal(spread, result.problem.covariance(result.information))
