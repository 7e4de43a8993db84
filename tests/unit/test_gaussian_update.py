"""Normal updates are those of the joint distribution, of least squares without a block, and of quadratic programs."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from narrows.errors import InputError
from narrows.logbook.learned_coefficient import Blocks, NormalPrior, brought_within, updated

UNKNOWNS, BLOCKS, READ = 5, 4, 2


def problem(rank: int = UNKNOWNS) -> tuple[NormalPrior, Blocks]:
    draw = np.random.default_rng(3)
    root = draw.standard_normal((UNKNOWNS, rank)) * 10.0 ** draw.uniform(-3, 6, UNKNOWNS)[:, None]
    size = np.linalg.norm(root, axis=1)
    noise = draw.standard_normal((BLOCKS, READ, READ))
    design = draw.standard_normal((BLOCKS, READ, UNKNOWNS)) / size
    prior = NormalPrior(size * draw.standard_normal(UNKNOWNS), root)
    return prior, Blocks(draw.standard_normal((BLOCKS, READ)), design, noise @ np.swapaxes(noise, 1, 2) + np.eye(READ))


def joint(prior: NormalPrior, blocks: Blocks, of: list[int]) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean, covariance and sum of squares by the joint normal distribution, in floats of the problem's own sizes."""
    design = blocks.design[of].reshape(-1, UNKNOWNS)
    error = np.zeros((len(design), len(design)))
    for place, block in enumerate(of):
        error[READ * place : READ * place + READ, READ * place : READ * place + READ] = blocks.covariance[block]
    seen = design @ prior.covariance @ design.T + error
    gain = np.linalg.solve(seen, design @ prior.covariance).T
    innovation = blocks.value[of].ravel() - design @ prior.mean
    square = float(innovation @ np.linalg.solve(seen, innovation))
    return prior.mean + gain @ innovation, prior.covariance - gain @ design @ prior.covariance, square


@pytest.mark.parametrize("rank", [UNKNOWNS, 2])
def test_mean_covariance_and_square_are_those_of_the_joint_distribution(rank: int) -> None:
    prior, blocks = problem(rank)
    found, (mean, covariance, square) = updated(prior, blocks), joint(prior, blocks, list(range(BLOCKS)))
    size = np.sqrt(np.diag(prior.covariance))
    np.testing.assert_allclose(found.mean / size, mean / size, atol=1e-9)
    np.testing.assert_allclose(found.covariance / np.outer(size, size), covariance / np.outer(size, size), atol=1e-9)
    assert found.chi_square == pytest.approx(square, rel=1e-9)


def test_a_block_beside_the_others_is_what_it_adds_to_the_square() -> None:
    prior, blocks = problem()
    found = updated(prior, blocks)
    for block in range(BLOCKS):
        others = joint(prior, blocks, [other for other in range(BLOCKS) if other != block])[2]
        assert found.beside[block] == pytest.approx(found.chi_square - others, rel=1e-8)


def test_a_prior_of_a_covariance_keeps_it_at_any_rank() -> None:
    prior, _ = problem(rank=3)
    again = NormalPrior.of(prior.mean, prior.covariance)
    np.testing.assert_allclose(again.covariance, prior.covariance, rtol=1e-9, atol=0.0)
    assert again.root.shape == (UNKNOWNS, 3)


def test_a_matrix_that_is_no_covariance_is_refused() -> None:
    with pytest.raises(InputError, match="is none"):
        NormalPrior.of(np.zeros(2), np.array([[1.0, 2.0], [2.0, 1.0]]))


def test_within_bounds_is_the_least_squares_solution_within_them() -> None:
    draw = np.random.default_rng(8)
    for _ in range(20):
        root = draw.standard_normal((UNKNOWNS, UNKNOWNS))
        mean = draw.standard_normal(UNKNOWNS)
        bounds = np.array([[0.0, np.inf], [-np.inf, np.inf], [0.0, 0.5], [-0.2, np.inf], [-np.inf, 0.1]])
        whitened = np.linalg.inv(root)
        least = lsq_linear(whitened, whitened @ mean, bounds.T, method="bvls", tol=1e-14).x
        np.testing.assert_allclose(brought_within(mean, root, bounds), least, atol=1e-7)


def test_what_has_no_variance_stays_whatever_its_bound() -> None:
    found = brought_within(np.array([-1.0, -1.0]), np.diag([0.0, 1.0]), np.array([[0.0, np.inf]] * 2))
    np.testing.assert_allclose(found, [-1.0, 0.0], atol=1e-12)
