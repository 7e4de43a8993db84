"""The filter's algebra beside the linear Kalman filter, filterpy's and batch least squares."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from narrows.codegen.cache import compiled_loops
from narrows.estimation import square_roots
from narrows.estimation.estimator import smoothed
from narrows.estimation.ship_filter import MotionStep, gate, predict, sigma_point_weights
from narrows.estimation.states import Gaussian

LOOPS = compiled_loops(square_roots)

SIZE, MEASURED = 4, 2
RANDOM = np.random.default_rng(5)
MOTION = np.eye(SIZE) + 0.1 * RANDOM.standard_normal((SIZE, SIZE))
NOISE = 0.3 * RANDOM.standard_normal((SIZE, SIZE))
SEEN = RANDOM.standard_normal((MEASURED, SIZE))
SIGMA = np.array([0.4, 0.7])


def first() -> Gaussian:
    root = np.tril(RANDOM.standard_normal((SIZE, SIZE)))
    return Gaussian(RANDOM.standard_normal(SIZE), root)


def moved(points: np.ndarray) -> np.ndarray:
    return points @ MOTION.T


def measured_by(now: Gaussian, told: np.ndarray, seen: Any = lambda points: points @ SEEN.T, spread=None) -> Gaussian:
    """The unscented step, for a measurement by one sensor without a gate."""
    spread = spread or sigma_point_weights(SIZE)
    expected, rows = spread.transform(now, seen, np.diag(SIGMA))
    sums = np.zeros((2, 1, MEASURED))
    tests = np.array([MEASURED]), np.array([np.inf]), np.array([0]), np.arange(MEASURED)
    return Gaussian(*LOOPS.update(*now, rows, told - expected, *tests, sums, np.array([6.0]), 5.0, 1e4)[:2])


def kalman(mean: np.ndarray, covariance: np.ndarray, told: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The textbook's step: predict, then correct."""
    mean, covariance = MOTION @ mean, MOTION @ covariance @ MOTION.T + NOISE.T @ NOISE
    gain = covariance @ SEEN.T @ np.linalg.inv(SEEN @ covariance @ SEEN.T + np.diag(SIGMA**2))
    return mean + gain @ (told - SEEN @ mean), (np.eye(SIZE) - gain @ SEEN) @ covariance


def test_a_linear_system_has_the_kalman_filter() -> None:
    now = first()
    mean, covariance = now.mean, now.covariance
    for told in RANDOM.standard_normal((50, MEASURED)):
        now = measured_by(predict(now, moved, NOISE, sigma_point_weights(SIZE))[0], told)
        mean, covariance = kalman(mean, covariance, told)
    np.testing.assert_allclose(now.mean, mean, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(now.covariance, covariance, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize(("alpha", "beta", "kappa"), [(0.5, 2.0, 1.0), (1.0, 0.0, 0.0), (0.1, 2.0, 3.0)])
def test_a_bent_system_has_the_filter_of_filterpy(alpha: float, beta: float, kappa: float) -> None:
    from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

    def bent(x: np.ndarray) -> np.ndarray:
        turned = np.stack([x[..., 0] + 0.1 * np.sin(x[..., 1]), 0.9 * x[..., 1] + 0.05 * x[..., 0] * x[..., 2]], -1)
        return np.concatenate([turned, 0.95 * x[..., 2:] + 0.02 * x[..., :2] ** 2], -1)

    def seen(x: np.ndarray) -> np.ndarray:
        return np.stack([np.hypot(x[..., 0] - 9.0, x[..., 1]), x[..., 2] + 0.1 * x[..., 3] ** 2], -1)

    noise = 0.1 * np.eye(SIZE)
    peer = UnscentedKalmanFilter(
        SIZE, MEASURED, 1.0, seen, lambda x, dt: bent(x), MerweScaledSigmaPoints(SIZE, alpha, beta, kappa)
    )
    peer.x, peer.P, peer.Q, peer.R = np.ones(SIZE), 0.2 * np.eye(SIZE), noise.T @ noise, np.diag(SIGMA**2)
    now, spread = Gaussian(peer.x.copy(), np.linalg.cholesky(peer.P)), sigma_point_weights(SIZE, alpha, beta, kappa)
    for told in np.array([8.0, 1.0]) + 0.3 * RANDOM.standard_normal((20, MEASURED)):
        peer.predict()
        peer.update(told)
        now = measured_by(predict(now, bent, noise, spread)[0], told, seen, spread)
    np.testing.assert_allclose(now.mean, peer.x, rtol=1e-7)
    np.testing.assert_allclose(now.covariance, peer.P, rtol=1e-6, atol=1e-9)


def test_the_smoother_is_batch_least_squares() -> None:
    """All states of a record at once, by one least-squares problem with everything weighted."""
    steps, start = 12, first()
    told = RANDOM.standard_normal((steps, MEASURED))
    noise = np.diag([0.3, 0.2, 0.5, 0.4])
    now, stages = start, []
    for row in told:
        after, slopes = predict(now, moved, noise, sigma_point_weights(SIZE))
        stages.append(MotionStep(now, after, slopes, False))
        now = measured_by(after, row)
    back = smoothed(stages, now)
    unknowns = SIZE * (steps + 1)
    rows, values = [np.linalg.inv(start.root) @ np.eye(SIZE, unknowns)], [np.linalg.inv(start.root) @ start.mean]
    for k in range(steps):
        link, look = np.zeros((SIZE, unknowns)), np.zeros((MEASURED, unknowns))
        link[:, SIZE * k : SIZE * (k + 1)], link[:, SIZE * (k + 1) : SIZE * (k + 2)] = -MOTION, np.eye(SIZE)
        look[:, SIZE * (k + 1) : SIZE * (k + 2)] = SEEN
        rows += [np.linalg.inv(noise) @ link, look / SIGMA[:, None]]
        values += [np.zeros(SIZE), told[k] / SIGMA]
    matrix = np.vstack(rows)
    solution = np.linalg.lstsq(matrix, np.concatenate(values), rcond=None)[0].reshape(steps + 1, SIZE)
    covariance = np.linalg.inv(matrix.T @ matrix)
    for k, (mean, spread) in enumerate(back):
        part = slice(SIZE * k, SIZE * (k + 1))
        np.testing.assert_allclose(mean, solution[k], rtol=1e-8, atol=1e-9)
        np.testing.assert_allclose(spread, covariance[part, part], rtol=1e-7, atol=1e-9)


@given(st.integers(0, 10**6), st.floats(0.05, 1.0), st.floats(0.0, 3.0), st.floats(0.0, 3.0))
@settings(max_examples=50, deadline=None)
def test_the_weight_of_the_central_point_is_a_part_of_the_squares(
    seed: int, alpha: float, beta: float, kappa: float
) -> None:
    """Covariances by van der Merwe's weights of every point, which may be negative for the central one."""
    values = np.random.default_rng(seed).standard_normal((1 + 2 * SIZE, MEASURED))
    noise, weights = np.zeros((0, MEASURED)), sigma_point_weights(SIZE, alpha, beta, kappa)
    mean, rows = LOOPS.transform(values, noise, weights.distance, weights.mean, weights.bend)
    pair = 0.5 / (alpha**2 * (SIZE + kappa))
    off, centre = values - mean, 1 - 2 * SIZE * pair + 1 - alpha**2 + beta
    covariance = centre * np.outer(off[0], off[0]) + pair * off[1:].T @ off[1:]
    np.testing.assert_allclose(mean, values[0] + pair * (values[1:] - values[0]).sum(axis=0), rtol=1e-9)
    np.testing.assert_allclose(rows.T @ rows, covariance, rtol=1e-7, atol=1e-9 * pair)


def test_a_root_of_too_few_rows_is_still_square() -> None:
    rows = RANDOM.standard_normal((2, 3))
    root = LOOPS.triangular_root(rows)
    np.testing.assert_allclose(root @ root.T, rows.T @ rows, atol=1e-14)
    assert root[0, 1] == root[0, 2] == root[1, 2] == 0.0


def normalised_innovation_squared(innovation: np.ndarray, covariance: np.ndarray) -> float:
    return float((LOOPS.whiten(innovation[None], LOOPS.cholesky(covariance)) ** 2).sum())


@pytest.mark.parametrize("size", [1, 2, 3])
def test_gates_refuse_as_often_as_they_say(size: int) -> None:
    root = np.tril(RANDOM.standard_normal((size, size))) + 2 * np.eye(size)
    squares = [normalised_innovation_squared(root @ e, root @ root.T) for e in RANDOM.standard_normal((20_000, size))]
    share = np.mean(np.array(squares) > gate(0.05, size))
    assert abs(share - 0.05) < 5 * np.sqrt(0.05 * 0.95 / 20_000)
    assert gate(0.0, size) == np.inf


def test_squares_of_innovations_are_those_by_hand() -> None:
    """Of two readings: the inverse of [[2, 0.5], [0.5, 1]] is [[1, -0.5], [-0.5, 2]] / 1.75."""
    assert normalised_innovation_squared(np.array([3.0]), np.array([[4.0]])) == pytest.approx(9 / 4)
    pair = normalised_innovation_squared(np.array([3.0, 1.0]), np.array([[2.0, 0.5], [0.5, 1.0]]))
    assert pair == pytest.approx((9 - 2 * 0.5 * 3 + 2 * 1) / 1.75)
    three = normalised_innovation_squared(np.array([1.0, 2.0, 3.0]), np.diag([1.0, 2.0, 3.0]))
    assert three == pytest.approx(1.0 + 2.0 + 3.0)


def test_gates_are_those_of_printed_tables() -> None:
    """Upper 5 % points of chi-squared, as tables print them."""
    assert [round(gate(0.05, size), 3) for size in (1, 2, 3)] == [3.841, 5.991, 7.815]


# Two fixes of two components each, of the same source, a compass and a log: innovations in standard deviations.
SENSORS_OF = {"fix": (0, 2, 0), "aft": (2, 4, 0), "gyro": (4, 5, 1), "log": (5, 6, 2)}
GATED: dict[str, tuple[dict[str, float], set[str], set[str], float]] = {
    "all pass": ({}, set(), set(), 1e4),
    "a fix jumps": ({"fix": 9.0}, {"fix"}, {"fix"}, 1e4),
    "both fixes jump": ({"fix": 9.0, "aft": -9.0}, {"fix", "aft"}, {"fix", "aft"}, 1e4),
    "log and compass agree": ({"log": 9.0, "gyro": -9.0}, {"log", "gyro"}, set(), 1e4),
    "one of them errs grossly": ({"log": 90.0, "gyro": 9.0}, {"log", "gyro"}, {"log", "gyro"}, 1e3),
    "all are odd": (dict.fromkeys(SENSORS_OF, 9.0), set(SENSORS_OF), set(), 1e4),
}


@pytest.mark.parametrize("loops", [LOOPS, square_roots], ids=["compiled", "plain"])
@pytest.mark.parametrize("case", GATED)
def test_readings_that_pass_their_gates_update_as_the_kalman_filter_does(case: str, loops: Any) -> None:
    """By covariances: innovations, gain and likelihood, less that of 2 pi; refused ones count as at their gate."""
    jumps, odd, refused, gross = GATED[case]
    random = np.random.default_rng(11)
    mean, root, seen = (
        random.standard_normal(SIZE),
        np.tril(random.standard_normal((SIZE, SIZE))),
        random.random((6, SIZE)),
    )
    sigma = np.array([0.5, 0.7, 0.6, 0.8, 0.3, 0.2])
    expected_covariance = seen @ root @ root.T @ seen.T + np.diag(sigma**2)
    spread = np.sqrt(np.diag(expected_covariance))
    innovation = 0.3 * spread
    for name, size in jumps.items():
        innovation[SENSORS_OF[name][0]] = size * spread[SENSORS_OF[name][0]]
    gates = np.array([20.0, 21.0, 11.0, 12.0])
    ends, sources = np.array([2, 4, 5, 6]), np.array([own[2] for own in SENSORS_OF.values()])
    sums, memories = np.zeros((2, 2, 6)), np.array([6.0, 24.0])
    rows = np.vstack([root.T @ seen.T, np.diag(sigma)])
    found, triangle, tests, agree, likelihood = loops.update(
        mean, root, rows, innovation, ends, gates, sources, np.arange(6), sums, memories, 5.0, gross
    )
    for place, (name, (first, end, _)) in enumerate(SENSORS_OF.items()):
        part = slice(first, end)
        squared = innovation[part] @ np.linalg.solve(expected_covariance[part, part], innovation[part])
        assert tests[0, place] == pytest.approx(squared)
        assert bool(tests[1, place]) == (name in odd)
        # A first innovation is its own sum; what the gate refuses counts as none.
        assert tests[2, place] == pytest.approx(0.0 if name in odd else 0.3)
    assert bool(agree) == (bool(odd) and not refused)
    kept = [k for name, (first, end, _) in SENSORS_OF.items() if name not in refused for k in range(first, end)]
    H, noise = seen[kept], np.diag(sigma[kept] ** 2)
    covariance = root @ root.T
    total = H @ covariance @ H.T + noise
    gain = covariance @ H.T @ np.linalg.inv(total)
    np.testing.assert_allclose(found, mean + gain @ innovation[kept], rtol=1e-9)
    np.testing.assert_allclose(triangle @ triangle.T, covariance - gain @ H @ covariance, rtol=1e-8, atol=1e-12)
    assert np.triu(triangle, 1) == pytest.approx(0.0)
    squares = innovation[kept] @ np.linalg.solve(total, innovation[kept]) if kept else 0.0
    at_gates = sum(gate for name, gate in zip(SENSORS_OF, gates, strict=True) if name in refused)
    # The refused ones keep their share of the determinant.
    logarithm = np.linalg.slogdet(expected_covariance)[1]
    assert likelihood == pytest.approx(-(logarithm + squares + at_gates) / 2)


@pytest.mark.parametrize("loops", [LOOPS, square_roots], ids=["compiled", "plain"])
def test_points_roots_and_whitening_are_those_of_numpy(loops: Any) -> None:
    random = np.random.default_rng(2)
    mean, root = random.standard_normal(3), random.standard_normal((3, 2))
    points = loops.sigma_points(mean, root, 1.5, 3)
    np.testing.assert_allclose(points[1:3] - mean, 1.5 * root.T)
    np.testing.assert_allclose(points[4:6] - mean, -1.5 * root.T)
    np.testing.assert_allclose(points[[0, 3, 6]], [mean] * 3)
    covariance = root @ root.T + np.eye(3)
    lower = np.linalg.cholesky(covariance)
    np.testing.assert_allclose(loops.cholesky(covariance), lower)
    values = random.standard_normal((4, 3))
    np.testing.assert_allclose(loops.whiten(values, lower), np.linalg.solve(lower, values.T).T)
    rows = random.standard_normal((5, 3))
    triangle = loops.triangular_root(rows)
    np.testing.assert_allclose(triangle @ triangle.T, rows.T @ rows)
    assert (np.triu(triangle, 1) == 0.0).all()
    rows[2, 1] = np.inf
    assert np.isnan(loops.triangular_root(rows)).all()
    values = random.standard_normal((5, 2))
    noise = random.standard_normal((1, 2))
    found, slopes = loops.transform(values, noise, 2.0, 0.125, 0.1)
    bends = [values[k] + values[2 + k] - 2 * values[0] for k in (1, 2)]
    np.testing.assert_allclose(found, values[0] + 0.125 * (bends[0] + bends[1]))
    np.testing.assert_allclose(slopes[:2], [(values[k] - values[2 + k]) / 4 for k in (1, 2)])
    np.testing.assert_allclose(slopes[2:4], [(own + 0.1 * (bends[0] + bends[1])) / 4 for own in bends])
    np.testing.assert_array_equal(slopes[4:], noise)
