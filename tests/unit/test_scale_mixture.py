"""The mixed model's algebra against dense normal densities, its integration against quadrature and exact proposals."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy import stats

from narrows.identification.mixed_model import (
    Conditional,
    MixedModel,
    ScaleMixture,
    SplitNormal,
    _distinct,
    _inverse,
    _sample_modes,
    _split_normal,
    integrate,
    search,
    stack,
)

PRECISION = 1e-6  # of a coefficient a priori


def small_model() -> MixedModel:
    """Two coefficients, two errors of blocks, two groups of effects with learned scales, and one effect of scale 1."""
    rng = np.random.default_rng(3)
    rows, starts = 17, np.array([0, 5, 8, 12])  # two blocks of one size
    x = rng.standard_normal((rows, 7))
    return MixedModel(
        names=("gain", "form", "local", "global"), x=x, y=2.0 * rng.standard_normal(rows) + x[:, 0], starts=starts,
        noise=rng.uniform(0.5, 1.5, rows), shared=rng.standard_normal((rows, 2)),
        independent=rng.uniform(0.1, 1.0, (rows, 2)), group=np.array([2, 2, 3, 3, 4]),
        prior=np.array([0.7, 1.2, 2.0, 0.9]), freedom=np.array([3.0, 4.0, 2.0, 30.0]),
        absorbed=0.3 * rng.standard_normal((2, 5)), multiples=(2,),
    )  # fmt: skip


POINTS = [np.array(z) for z in ([-0.5, 0.3, 0.8, -1.2], [0.9, -1.5, -0.4, 0.6])]


def half_t_scales(model: MixedModel, z: np.ndarray) -> np.ndarray:
    """Quantiles of half-t at the normal probability of each coordinate; the third is a multiple of the last."""
    scale = model.prior * stats.t.ppf(0.5 + 0.5 * stats.norm.cdf(z), model.freedom)
    scale[2] *= scale[3]
    return scale


def error_covariance(model: MixedModel, scale: np.ndarray) -> np.ndarray:
    """Covariance of the errors, entry by entry: rows of one block share an error."""
    block = [sum(row >= start for start in model.starts) for row in range(len(model.y))]
    v = np.zeros((len(model.y), len(model.y)))
    for i in range(len(v)):
        for j in range(len(v)):
            for k in range(2):
                v[i, j] += (block[i] == block[j]) * scale[k] ** 2 * model.shared[i, k] * model.shared[j, k]
                v[i, j] += (i == j) * scale[k] ** 2 * model.independent[i, k]
        v[i, i] += model.noise[i]
    return v


def prior_variances(model: MixedModel, scale: np.ndarray) -> np.ndarray:
    return np.concatenate([np.full(2, 1 / PRECISION), [scale[2] ** 2] * 2, [scale[3] ** 2] * 2, [1.0]])


def test_scales_are_half_t_quantiles() -> None:
    """SciPy's t, the product with the global scale, and 1 for effects of no learned scale; none below that of -5."""
    model = small_model()
    for z in POINTS:
        np.testing.assert_allclose(model.scales(z), [*half_t_scales(model, z), 1.0], rtol=1e-9)
    least, below = model.scales(np.full(4, -5.0)), model.scales(np.full(4, -7.0))
    np.testing.assert_array_equal(below, least)
    assert (least > 0).all()
    np.testing.assert_allclose(least[[0, 1, 3]] / model.prior[[0, 1, 3]], 0, atol=2e-6)


def test_errors_within_blocks_have_the_covariance_of_their_parts() -> None:
    model, rows = small_model(), np.array([1, 4, 5, 7, 8, 16])
    for z in POINTS:
        expected = error_covariance(model, half_t_scales(model, z))
        np.testing.assert_allclose(model.covariance_of(z, rows), expected[np.ix_(rows, rows)], atol=1e-12)


def test_the_posterior_is_that_of_dense_generalised_least_squares() -> None:
    """Information of the data and of the priors, with the inverse of the covariance of all errors."""
    model = small_model()
    for z in POINTS:
        scale, found = half_t_scales(model, z), model.conditional(z)
        whitened = model.x.T @ np.linalg.inv(error_covariance(model, scale))
        covariance = np.linalg.inv(whitened @ model.x + np.diag(1 / prior_variances(model, scale)))
        np.testing.assert_allclose(found.covariance, covariance, rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose(found.mean, covariance @ whitened @ model.y, rtol=1e-8)


def test_the_log_density_is_the_evidence_of_the_data() -> None:
    """Differences of the normal density of the data, with the standard normal prior of the coordinates."""
    model = small_model()

    def evidence(z: np.ndarray) -> float:
        scale = half_t_scales(model, z)
        data = (model.x * prior_variances(model, scale)) @ model.x.T + error_covariance(model, scale)
        return float(stats.multivariate_normal(cov=data).logpdf(model.y)) - 0.5 * float(z @ z)

    one, other = (model.conditional(z).log_density for z in POINTS)
    assert one - other == pytest.approx(evidence(POINTS[0]) - evidence(POINTS[1]), rel=1e-5)


def test_the_gradient_is_that_of_differences() -> None:
    """Errors of blocks, scales of effects, and the global scale, which acts on its multiple too."""
    model, step = small_model(), 1e-5
    for z in POINTS:
        sides = [[model.conditional(z + sign * step * e).log_density for sign in (1, -1)] for e in np.eye(4)]
        expected = [(after - before) / (2 * step) for after, before in sides]
        np.testing.assert_allclose(model.conditional(z, gradient=True).gradient, expected, rtol=1e-5, atol=1e-6)


def test_a_matrix_that_rounding_made_indefinite_has_a_finite_inverse() -> None:
    """Eigenvalues 2 and -1e-7, of which the second counts as 1e-10, of eigenvectors (1, 1) and (1, -1)."""
    inverse, logs = _inverse(np.array([[1.0, 1.0 + 1e-7], [1.0 + 1e-7, 1.0]]))
    np.testing.assert_allclose(inverse, 0.25 + 0.5e10 * np.array([[1, -1], [-1, 1]]), rtol=1e-6)
    assert logs == pytest.approx(-0.5 * np.log(2.0 * 1e-10), rel=1e-6)
    proper = np.array([[1.0, 0.4], [0.4, 1.0]])
    inverse, logs = _inverse(proper)
    np.testing.assert_allclose(inverse, np.array([[1.0, -0.4], [-0.4, 1.0]]) / 0.84, rtol=1e-12)
    assert logs == pytest.approx(-0.5 * np.log(0.84), rel=1e-12)


@dataclass
class Density:
    """A log density of scales in place of a mixed model: split normal axes, or a normal with correlation."""

    inverse: np.ndarray
    below: np.ndarray
    centre: np.ndarray
    confounding_scales: tuple[int, ...] = ()

    @property
    def prior(self) -> np.ndarray:
        return np.ones(len(self.centre))

    def conditional(self, z: np.ndarray, gradient: bool = False) -> Conditional:
        apart = z - self.centre
        apart = np.where(apart < 0, apart / self.below, apart)
        slope = -(self.inverse @ apart) / np.where(apart < 0, self.below, 1.0)
        return Conditional(-0.5 * float(apart @ self.inverse @ apart), z, np.eye(len(z)), slope)


SPLIT = Density(np.diag([1.0, 1.0 / 0.64]), np.array([0.6, 1.7]), np.array([0.4, -0.3]))
CORRELATED = Density(np.linalg.inv([[0.8, 0.5], [0.5, 0.9]]), np.ones(2), np.array([-0.2, 0.5]))


@pytest.mark.parametrize("density", [SPLIT, CORRELATED])
def test_points_of_a_split_normal_density_weigh_alike(density: Density) -> None:
    """The proposal is then the posterior itself, whose mode is found."""
    found = integrate(density)  # type: ignore[arg-type]
    assert len(found.points) == 128
    np.testing.assert_allclose(found.mode, density.centre, atol=1e-6)
    np.testing.assert_allclose(found.weights, 1 / 128, rtol=1e-5)


def test_points_have_the_moments_of_a_split_normal_density() -> None:
    """Mean, share below the mode, below / (below + above), and variance, as in John (1982)."""
    points = integrate(SPLIT, 4096).points  # type: ignore[arg-type]
    above = np.array([1.0, 0.8])
    below = SPLIT.below * above
    difference = above - below
    np.testing.assert_allclose(points.mean(axis=0), SPLIT.centre + np.sqrt(2 / np.pi) * difference, atol=2e-3)
    np.testing.assert_allclose((points < SPLIT.centre).mean(axis=0), below / (below + above), atol=2e-3)
    np.testing.assert_allclose(points.var(axis=0), (1 - 2 / np.pi) * difference**2 + above * below, rtol=0.02)
    normal = integrate(CORRELATED, 4096).points  # type: ignore[arg-type]
    np.testing.assert_allclose(np.cov(normal.T), [[0.8, 0.5], [0.5, 0.9]], atol=0.01)


def test_a_proposal_is_at_most_twice_and_at_least_half_as_wide_as_the_curvature() -> None:
    wide = Density(np.eye(2), np.array([5.0, 0.2]), np.zeros(2))
    proposal = _split_normal(wide, np.array([0.05, 0.05]))  # type: ignore[arg-type]
    np.testing.assert_allclose(proposal.widths, [[2.0, 0.5], [1.0, 1.0]], rtol=1e-5)


def test_weights_are_truncated_importance_weights() -> None:
    """Ionides (2008): the density over the proposal's, at most the square root of the points over their number."""

    class Wide(Density):
        def conditional(self, z: np.ndarray, gradient: bool = False) -> Conditional:
            return Conditional(float(stats.cauchy.logpdf(z).sum()), z, np.eye(1), np.zeros(1))

    target = Wide(np.eye(1), np.ones(1), np.zeros(1))
    proposal = SplitNormal(np.zeros(1), np.array([[0.3]]), np.ones((2, 1)), 0.0)
    mixture, weight = _sample_modes(target, [proposal], 256, {})  # type: ignore[arg-type]
    at = mixture.points[:, 0]
    expected = stats.cauchy.pdf(at) / stats.norm.pdf(at, 0.0, 0.3)
    expected /= expected.sum()
    np.testing.assert_allclose(weight, expected, rtol=1e-9)
    expected = np.minimum(expected, 1 / 16)
    assert (expected == 1 / 16).any()
    np.testing.assert_allclose(mixture.weights, expected / expected.sum(), rtol=1e-9)


def test_each_mode_has_points_by_its_share_and_at_least_a_fifth() -> None:
    """Shares e-6 and about 1: 0.2 / 1.2 and 1 / 1.2 of 128 points, 21.3 and 106.7, rounded up to powers of two."""

    class Hills(Density):
        def conditional(self, z: np.ndarray, gradient: bool = False) -> Conditional:
            return Conditional(float(np.logaddexp(-0.5 * (z[0] + 1) ** 2, -6 - 0.5 * (z[0] - 3) ** 2)), z, np.eye(1), z)

    hills = Hills(np.eye(1), np.ones(1), np.zeros(1))
    modes = [SplitNormal(np.array([at]), np.eye(1), np.ones((2, 1)), top) for at, top in ((-1.0, 0.0), (3.0, -6.0))]
    mixture, _ = _sample_modes(hills, modes, 128, {})  # type: ignore[arg-type]
    assert len(mixture.points) == 128 + 32
    assert mixture.mode == [-1.0]
    assert mixture.weights @ mixture.points[:, 0] == pytest.approx((-1 + 3 * np.exp(-6)) / (1 + np.exp(-6)), abs=0.03)


def test_modes_of_unequal_width_count_by_their_areas() -> None:
    """Hills of areas 1 and 0.3 x 0.4 at -1 and 3: the mean by hand."""

    class Hills(Density):
        def conditional(self, z: np.ndarray, gradient: bool = False) -> Conditional:
            logs = -0.5 * (z[0] + 1) ** 2, np.log(0.3) - 0.5 * ((z[0] - 3) / 0.4) ** 2
            return Conditional(float(np.logaddexp(*logs)), z, np.eye(1), z)

    one = SplitNormal(np.array([-1.0]), np.eye(1), np.ones((2, 1)), 0.0)
    other = SplitNormal(np.array([3.0]), 0.2 * np.eye(1), np.full((2, 1), 2.0), float(np.log(0.3)))
    hills = Hills(np.eye(1), np.ones(1), np.zeros(1))
    mixture, _ = _sample_modes(hills, [one, other], 1024, {})  # type: ignore[arg-type]
    assert mixture.weights @ mixture.points[:, 0] == pytest.approx((-1 + 3 * 0.12) / 1.12, abs=0.02)


@pytest.mark.parametrize(("apart", "lower", "kept"), [(0.9, 0.0, 1), (1.1, 0.0, 2), (1.1, 7.9, 2), (1.1, 8.1, 1)])
def test_modes_are_one_apart_and_within_8_of_the_best(apart: float, lower: float, kept: int) -> None:
    other = np.array([0.3, 0.0]) + np.array([0.0, apart])
    assert len(_distinct([(np.array([0.3, 0.0]), 5.0), (other, 5.0 - lower)])) == kept


def test_rival_modes_are_searched_for_from_each_confounding_scale() -> None:
    """Hills at (-0.5, -0.5) and, lower, about (-0.5, 3): found from a start with a large second scale."""

    class Rivals(Density):
        def conditional(self, z: np.ndarray, gradient: bool = False) -> Conditional:
            centres = np.array([[-0.5, -0.5], [-0.5, 3.0]])
            apart = (z - centres) / 0.5
            logs = -0.5 * (apart**2).sum(axis=1) - [0.0, 2.0]
            total = float(np.logaddexp(*logs))
            return Conditional(total, z, np.eye(2), -np.exp(logs - total) @ apart / 0.5)

    alone = Rivals(np.eye(2), np.ones(2), np.zeros(2))
    assert len(search(alone)) == 1  # type: ignore[arg-type]
    (first, top), (second, lower) = search(replace(alone, confounding_scales=(1,)))  # type: ignore[arg-type]
    np.testing.assert_allclose([first, second], [[-0.5, -0.5], [-0.5, 3.0]], atol=1e-3)
    assert (top, lower) == (pytest.approx(0.0, abs=1e-3), pytest.approx(-2.0, abs=1e-3))


def test_a_mode_is_searched_for_from_4_deviations_below_to_6_above() -> None:
    class Slope(Density):
        def conditional(self, z: np.ndarray, gradient: bool = False) -> Conditional:
            return Conditional(float(z[1] - z[0]), z, np.eye(2), np.array([-1.0, 1.0]))

    ((mode, _),) = search(Slope(np.eye(2), np.ones(2), np.zeros(2)))  # type: ignore[arg-type]
    assert mode.tolist() == [-4.0, 6.0]


@pytest.mark.parametrize(("heaviest", "modes"), [(0.1, 1), (0.2, 2)])
def test_a_point_of_more_than_15_percent_starts_the_search_for_another_mode(heaviest: float, modes: int) -> None:
    """A narrow hill of the height that gives one of the 128 points this weight."""
    normal = Density(np.eye(2), np.ones(2), np.zeros(2))
    points = integrate(normal).points  # type: ignore[arg-type]
    top = points[np.argmax(np.abs(points).max(axis=1))]
    height = np.log((128 * heaviest - 1) / (1 - heaviest))  # (1 + height) / (128 + height) = heaviest

    class Spike(Density):
        def conditional(self, z: np.ndarray, gradient: bool = False) -> Conditional:
            logs = np.array([-0.5 * z @ z, -0.5 * top @ top + height - 0.5 * ((z - top) / 0.02) @ ((z - top) / 0.02)])
            total = float(np.logaddexp(*logs))
            slope = -np.exp(logs - total) @ np.array([z, (z - top) / 0.02**2])
            return Conditional(total, z, np.eye(2), slope)

    found = integrate(Spike(np.eye(2), np.ones(2), np.zeros(2)))  # type: ignore[arg-type]
    assert (len(found.points) > 128) == (modes > 1)


@pytest.mark.parametrize("size", [0.0, 2.0])
def test_a_learned_scale_is_integrated_as_by_quadrature(size: float) -> None:
    """One scale of effects, without and with effects in the data: trapezoidal rule over 2 000 coordinates."""
    rng = np.random.default_rng(5)
    groups, none = np.kron(np.eye(6), np.ones((4, 1))), np.zeros((24, 0))
    y = 3.0 + groups @ (size * rng.standard_normal(6)) + rng.standard_normal(24)
    model = MixedModel(
        ("batch",), np.column_stack([np.ones(24), groups]), y, np.array([0]), np.ones(24), none, none,
        np.zeros(6, int), np.array([1.0]), np.array([4.0]), np.full((1, 6), 1 / 6),
    )  # fmt: skip
    z = np.linspace(-4.0, 5.0, 2001)[:, None]
    parts = [model.conditional(one) for one in z]
    density = np.array([part.log_density for part in parts])
    weight = np.exp(density - density.max())
    weight /= weight.sum()
    scale, found = np.array([model.scales(one)[0] for one in z]), integrate(model)
    at = np.array([model.scales(one)[0] for one in found.points])
    assert found.weights @ at == pytest.approx(weight @ scale, rel=0.03)
    mean = np.array([part.mean[0] + part.mean[1:].mean() for part in parts])
    variance = np.array([
        (row := np.r_[1.0, np.full(6, 1 / 6)]) @ part.covariance @ row for part in parts
    ])  # fmt: skip
    np.testing.assert_allclose(found.weights @ found.means, weight @ mean, rtol=1e-3)
    np.testing.assert_allclose(found.weights @ found.covariances[:, 0, 0], weight @ variance, rtol=0.03)


def test_a_model_without_scales_is_one_normal_density() -> None:
    none = np.zeros((3, 0))
    model = MixedModel(
        (), np.ones((3, 1)), np.array([1.0, 2.0, 6.0]), np.array([0]), np.full(3, 0.5), none, none, np.zeros(0, int),
        np.zeros(0), np.zeros(0), np.zeros((1, 0)),
    )  # fmt: skip
    found = integrate(model)
    assert found.weights.tolist() == [1.0]
    assert found.points.shape == (1, 0)
    np.testing.assert_allclose(found.means, [[3.0]], rtol=1e-5)
    np.testing.assert_allclose(found.covariances, [[[0.5 / 3]]], rtol=1e-5)


def test_a_shift_is_the_regression_of_coefficients_on_an_effect() -> None:
    """Weighted over the draws, cov(coefficient + absorbed effects, effect) over var(effect), by hand."""
    model = replace(small_model(), absorbed=np.array([[0.5, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, -2.0]]))
    parts = [model.conditional(z) for z in POINTS]
    mixture = ScaleMixture(model, POINTS[0], np.array(POINTS), np.array([0.25, 0.75]), stack(parts))
    expected = np.zeros((2, 5))
    for part, weight in zip(parts, (0.25, 0.75), strict=True):
        c = part.covariance
        for effect in range(5):
            expected[0, effect] += weight * (c[0, 2 + effect] + 0.5 * c[2, 2 + effect]) / c[2 + effect, 2 + effect]
            expected[1, effect] += weight * (c[1, 2 + effect] - 2.0 * c[6, 2 + effect]) / c[2 + effect, 2 + effect]
    np.testing.assert_allclose(mixture.shifts, expected, rtol=1e-9)
