"""The mixed model against published fits, dense algebra, and twins whose errors are known."""

import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from statistics import NormalDist

import numpy as np
import pytest

import narrows as nw
from narrows.captive.tests import CaptiveTests
from narrows.identification import mixed_model
from narrows.identification.mixed_model import (
    Conditional,
    MixedModel,
    ScaleMixture,
    integrate,
    one_thread,
    search,
    stack,
)
from narrows.identification.motions import numbered

sys.path.insert(0, str(Path(__file__).parents[2] / "decisions"))
from trust_kinds import honest, zero_of_a_day
from trust_tank import BANK, DOZEN, FULL, HULL, NONE, Tank, law, measured, straight

# Yield of dyestuff by batch, Davies and Goldsmith (1972), as in lme4's data set Dyestuff.
DYESTUFF = np.array(
    [
        [1545, 1440, 1440, 1520, 1580], [1540, 1555, 1490, 1560, 1495], [1595, 1550, 1605, 1510, 1560],
        [1445, 1440, 1595, 1465, 1545], [1595, 1630, 1515, 1635, 1625], [1520, 1455, 1450, 1480, 1445],
    ], float,
)  # fmt: skip


def grouped(x: np.ndarray, y: np.ndarray, z: np.ndarray, noise: float) -> MixedModel:
    """A model with one group of random effects, whose scale has the prior 50, and independent errors."""
    rows, groups = len(y), z.shape[1]
    no_errors, group, nothing_taken = np.zeros((rows, 0)), np.zeros(groups, int), np.zeros((x.shape[1], groups))
    prior, freedom = np.array([50.0]), np.array([1e9])
    return MixedModel(
        ("batch",), np.column_stack([x, z]), y, np.array([0]), np.full(rows, noise), no_errors, no_errors, group, prior,
        freedom, nothing_taken,
    )  # fmt: skip


def test_dyestuff_as_lme4_prints_it() -> None:
    """lmer(Yield ~ 1 | Batch): REML criterion 319.7, mean 1527.50 (19.38), scales 42.00 and 49.51."""
    y = DYESTUFF.ravel()
    model = grouped(np.full((30, 1), 1000.0), y, np.kron(np.eye(6), np.ones((5, 1))), 49.51**2)

    def coordinate(scale: float) -> np.ndarray:
        """Where the half-normal prior of the batches' scale, here of 50, has it."""
        return np.array([NormalDist().inv_cdf(2 * NormalDist().cdf(scale / 50) - 1)])

    def criterion(scale: float) -> float:
        z = coordinate(scale)
        constant = 29 * np.log(2 * np.pi) - 2 * np.log(1000.0)  # the column is 1000
        return -2 * (model.conditional(z).log_density + 0.5 * float(z @ z)) + constant

    assert criterion(42.00) == pytest.approx(319.65, abs=0.05)
    assert criterion(42.00) < min(criterion(38.0), criterion(46.0))
    found = model.conditional(coordinate(42.00))
    assert 1000 * found.mean[0] == pytest.approx(1527.50, abs=0.01)
    assert 1000 * np.sqrt(found.covariance[0, 0]) == pytest.approx(19.38, abs=0.01)


@pytest.mark.parametrize("freedom", [1.5, 2.0, 3.0, 4.0, 6.0, 30.0])
def test_a_scale_far_below_its_prior_divides_by_no_zero(freedom: float) -> None:
    batches = grouped(np.full((30, 1), 1000.0), DYESTUFF.ravel(), np.kron(np.eye(6), np.ones((5, 1))), 49.51**2)
    model = replace(batches, freedom=np.full(1, freedom))
    at = [model.conditional(np.array([z])).mean[0] for z in (-4.0, -6.8)]
    assert at == pytest.approx([1.5275, 1.5275], abs=1e-6)


@pytest.fixture(scope="module")
def fit() -> nw.Fit:
    return nw.identify(honest(np.random.default_rng(1), 0.02)[0])


@pytest.fixture(scope="module")
def model(fit: nw.Fit) -> MixedModel:
    return fit.estimates.forces[-1].posterior.model


def test_coefficients_are_those_of_dense_generalised_least_squares(model: MixedModel) -> None:
    at = np.full(len(model.prior), -0.5)
    scale = model.scales(at)[model.group]
    x, z = model.x[:, : model.fixed], model.x[:, model.fixed :] * scale
    v = model.covariance_of(at, np.arange(len(model.y))) + z @ z.T
    information = x.T @ np.linalg.solve(v, x)
    expected = np.linalg.solve(information, x.T @ np.linalg.solve(v, model.y))
    found = model.conditional(at)
    np.testing.assert_allclose(found.mean[: model.fixed], expected, rtol=1e-5)
    covariance = np.linalg.inv(information)
    size = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(
        found.covariance[: model.fixed, : model.fixed] / np.outer(size, size),
        covariance / np.outer(size, size),
        atol=1e-5,
    )


def test_the_gradient_is_that_of_the_log_density(model: MixedModel) -> None:
    at, step = np.full(len(model.prior), -0.7), 1e-4
    slopes = [
        (model.conditional(at + step * e).log_density - model.conditional(at - step * e).log_density) / (2 * step)
        for e in np.eye(len(at))
    ]
    np.testing.assert_allclose(model.conditional(at, gradient=True).gradient, slopes, atol=1e-3)


def moments(mixture: ScaleMixture) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviation of the coefficients."""
    mean = mixture.weights @ mixture.means
    variances = np.diagonal(mixture.covariances, axis1=1, axis2=2)
    return mean, np.sqrt(mixture.weights @ (variances + (mixture.means - mean) ** 2))


def test_points_about_the_modes_hold_the_posterior(model: MixedModel) -> None:
    """Four times as many points give the same mean and width, and more than 30 % of the points count."""
    found = one_thread(integrate)(model)
    effective = 1 / (found.weights**2).sum() / len(found.weights)
    assert effective > 0.3
    (mean, std), (other, wide) = (moments(one) for one in (one_thread(integrate)(model, 512), found))
    np.testing.assert_array_less(np.abs(other - mean) / std, 0.15)
    np.testing.assert_allclose(wide, std, rtol=0.15)


@pytest.fixture(scope="module")
def kcs(kcs_fits: dict[int, nw.Fit]) -> nw.Fit:
    """Tests at 20 % clearance, in which the added masses change."""
    return kcs_fits[20]


def test_masses_that_change_with_speed_or_with_period_are_rivals(kcs: nw.Fit) -> None:
    model = next(part.posterior.model for part in kcs.estimates.forces if "N" in part.rows.forces)
    modes = [mode for mode, _ in search(model)]
    assert max(float(np.abs(other - one).max()) for one, other in pairwise(modes)) > 2.0


def test_measured_motions_that_were_left_out_are_inside_their_intervals(kcs: nw.Fit) -> None:
    """The terms miss Y by more than N: one scale for both made the interval of Y too narrow and that of N too wide."""
    scales = kcs.error_scales["Y and N"]
    assert scales["form of Y"] > 1.5 * scales["form of N"]
    for one in kcs.predictiveness:
        assert 0.9 <= one.held <= 0.98, one.sentence


def test_discrepancies_of_the_hull_are_all_small_if_the_terms_fit(fit: nw.Fit, kcs: nw.Fit) -> None:
    """The twin is of the fitted terms; the median of the prior is 0.34."""
    twin, measured_hull = (one.error_scales["Y and N"]["hull discrepancy"] for one in (fit, kcs))
    assert twin < 0.3
    assert measured_hull > 0.8


class TwoHills:
    """A density of two normal hills, half each, of which the search finds the first."""

    prior, confounding_scales = np.ones(2), ()
    centres, widths = np.array([[-1.0, 0.0], [0.6, 0.9]]), np.array([0.5, 0.4])

    def conditional(self, z: np.ndarray, gradient: bool = False) -> Conditional:
        apart = (z - self.centres) / self.widths[:, None]
        logs = -0.5 * (apart**2).sum(axis=1) - 2 * np.log(self.widths)
        total = float(np.logaddexp(*logs))
        slope = -np.exp(logs - total) @ (apart / self.widths[:, None])
        return Conditional(total, z, np.eye(2), slope)


def test_a_second_mode_is_searched_for_where_one_point_outweighs_the_others() -> None:
    found = integrate(TwoHills())  # type: ignore[arg-type]
    np.testing.assert_allclose(found.weights @ found.points, TwoHills.centres.mean(axis=0), atol=0.1)


def test_the_last_bits_of_the_data_do_not_move_estimates() -> None:
    """Noise-free tests, each number of which is off by 1e-12 of itself."""
    tests, _ = honest(np.random.default_rng(1), 0.0)
    rng = np.random.default_rng(0)
    columns = {n: c * (1 + 1e-12 * rng.standard_normal(len(c))) for n, c in tests.columns.items()}
    one, other = nw.identify(tests), nw.identify(replace(tests, columns=columns))
    for name, std in one.std.items():
        assert other.coefficients[name] == pytest.approx(one.coefficients[name], abs=1e-3 * np.nan_to_num(std))
        assert other.std[name] == pytest.approx(std, rel=1e-3, nan_ok=True)


def test_a_shift_is_what_an_effect_of_known_size_takes_from_the_estimates(fit: nw.Fit, model: MixedModel) -> None:
    """At given scales: forces less the effect of one, and no column for it."""
    at = np.full(len(model.prior), -0.5)
    names = [effect.name for effect in fit.estimates.forces[-1].effects]
    for name in ("heading proportional to y", "delay between clocks"):
        i = names.index(name)
        column = model.x[:, model.fixed + i]
        x, group = np.delete(model.x, model.fixed + i, axis=1), np.delete(model.group, i)
        absorbed = np.zeros((model.fixed, len(group)))
        other = replace(model, x=x, group=group, absorbed=absorbed)
        absent, present = (replace(other, y=model.y - size * column) for size in (0, 1))
        expected = (present.conditional(at).mean - absent.conditional(at).mean)[: model.fixed]
        free = replace(model, absorbed=0 * model.absorbed)
        part = ScaleMixture(free, at, at[None], np.ones(1), stack([model.conditional(at)]))
        np.testing.assert_allclose(part.shifts[:, i], expected, rtol=1e-4, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("seed", range(2))
def test_a_delay_that_misleads_is_named_with_a_smaller_size(seed: int) -> None:
    """Forces 0.15 s late: every coefficient that is identified and missed has a delay below that among its limits."""

    def late(_: np.random.Generator, __: int, q: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {**q, **{f: np.interp(q["t"] - 0.15, q["t"], q[f]) for f in "XYN"}}

    found = nw.identify(measured(np.random.default_rng(7001 + seed), FULL, law(), Tank(gain=0.01, spoil=late)))
    truth = {**HULL, **BANK}
    for name in ("b_vdot", "b_v", "c_rdot"):
        low, high = found.intervals[name]
        limits = {effect.name: size for effect, size in found.estimates.limits[name]}
        missed = found.verdicts[name].status == "identified" and not low <= truth[name] <= high
        assert not missed or limits["delay between clocks"] < 0.15


def reordered(tests: CaptiveTests, order: np.ndarray, names: tuple[str, ...] = ()) -> CaptiveTests:
    rows = np.concatenate([np.arange(tests.starts[i], tests.starts[i + 1]) for i in order])
    starts = np.concatenate([[0], np.cumsum(np.diff(tests.starts)[order])])
    columns = {name: column[rows] for name, column in tests.columns.items()}
    return CaptiveTests(columns, names or tuple(tests.names[i] for i in order), starts, tests.configuration)


def test_the_posterior_of_the_same_tests_is_kept_and_of_others_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where they may take no memory, none is kept, and the answer is the same."""
    tests, other = nw.twin(seed=3), nw.twin(seed=4)
    one, again, moved = (nw.identify(each) for each in (tests, tests, other))
    exact = nw.identify(tests, errors=nw.RunErrors(gain=0.001))

    def posteriors(fit: nw.Fit) -> list[ScaleMixture]:
        return [part.posterior for part in fit.estimates.forces]

    assert [new is old for new, old in zip(posteriors(again), posteriors(one), strict=True)] == [True] * 2
    assert not {*map(id, posteriors(one))} & {*map(id, posteriors(moved) + posteriors(exact))}
    assert len({fit.std["b_v"] for fit in (one, moved, exact)}) == 3
    monkeypatch.setattr(mixed_model, "KEPT_BYTES", 0)
    monkeypatch.setattr(mixed_model, "_KEPT", {})
    fresh = nw.identify(tests)
    assert not {*map(id, posteriors(fresh))} & {*map(id, posteriors(one))}
    assert fresh.intervals["b_v"] == one.intervals["b_v"]
    assert not mixed_model._KEPT


def test_neither_order_nor_copies_of_tests_matter(fit: nw.Fit) -> None:
    count = len(fit.tests.names)
    turned = nw.identify(reordered(fit.tests, np.random.default_rng(0).permutation(count)))
    twice = np.tile(np.arange(count), 2)
    copied = nw.identify(reordered(fit.tests, twice, tuple(f"{fit.tests.names[i]} {k}" for k, i in enumerate(twice))))
    for name in ("b_bank", "c_bank", "b_v", "c_rdot"):
        low, high = fit.intervals[name]
        for other in (turned, copied):
            assert other.intervals[name] == pytest.approx((low, high), abs=0.1 * (high - low))
            assert other.verdicts[name].status == fit.verdicts[name].status


def test_levels_do_not_depend_on_order() -> None:
    assert numbered([0.8, 0.82, 0.85, 0.88, 0.9]).tolist() == [0, 0, 1, 1, 2]
    assert numbered([0.9, 0.88, 0.85, 0.82, 0.8]).tolist() == [0, 1, 1, 2, 2]
    assert numbered([-1.0, 0.0, 1.0, 0.0]).tolist() == [0, 1, 2, 1]


@pytest.mark.parametrize("seed", range(2))
def test_a_bank_is_identified_and_none_is_not(seed: int, fit: nw.Fit) -> None:
    found = fit if seed == 1 else nw.identify(honest(np.random.default_rng(seed), 0.02)[0])
    for name in ("b_bank", "c_bank"):
        low, high = found.intervals[name]
        assert low <= BANK[name] <= high
        assert high - low < 0.15 * BANK[name]
        assert found.verdicts[name].status == "identified"
        assert found.verdicts[name].limits
    found = nw.identify(zero_of_a_day(np.random.default_rng(seed), 2.0)[0])
    assert all(found.verdicts[name].status != "identified" for name in ("b_bank", "c_bank"))


@pytest.mark.parametrize("seed", range(3))
def test_a_cable_is_not_larger_than_its_tipping_point(seed: int) -> None:
    """No bank and a cable of 3 N at 1.7 m: where a bank is identified, less than that cable overturns it."""

    def cable(_: np.random.Generator, i: int, record: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {**record, "Y": record["Y"] + 3.0 * record["y"] / 1.7}

    found = nw.identify(measured(np.random.default_rng(seed), DOZEN, law(NONE), Tank(gain=0.01, spoil=cable)))
    if found.verdicts["b_bank"].status == "identified":
        told = {effect.name: size for effect, size in found.estimates.limits["b_bank"]}
        assert told["force proportional to y in Y"] < 3.0 * found.motions.features["reach"].max() / 1.7


def test_tests_of_the_kcs_are_predicted_by_the_others(kcs_fits: dict[int, nw.Fit]) -> None:
    held, motions = 0.0, 0
    for fit in kcs_fits.values():
        for one in fit.predictiveness:
            if one.force != "X":
                held, motions = held + one.held * one.motions, motions + one.motions
                assert one.relative < 0.6
    assert 0.88 < held / motions < 0.99


def test_no_coefficient_is_identified_where_the_mean_predicts_better(kcs_fits: dict[int, nw.Fit]) -> None:
    for fit in kcs_fits.values():
        assert fit.left_out["X"].r2 < 0 < fit.left_out["Y"].r2
        identified = {name[0] for name, verdict in fit.verdicts.items() if verdict.status == "identified"}
        assert identified == {"b", "c"}
    verdict = kcs_fits[50].verdicts["a_u"]
    assert verdict.status == "imprecise"
    assert "X of left-out tests is predicted worse than by its mean (R2 -0." in verdict.sentence("a_u")


def test_more_honest_runs_do_not_widen_the_interval() -> None:
    more = [*DOZEN, straight(0.7), straight(-0.7), straight(1.4), straight(-1.4)]
    widths = []
    for runs in (DOZEN, more):
        ends = [
            nw.identify(measured(np.random.default_rng(s), runs, law(), Tank(gain=0.02))).intervals for s in range(2)
        ]
        widths.append(np.mean([one["b_bank"][1] - one["b_bank"][0] for one in ends]))
    assert widths[1] < 1.05 * widths[0]
