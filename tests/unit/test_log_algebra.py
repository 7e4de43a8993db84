"""Numbers of a search over records, by hand: its steps, weights, processes, priors, and the ship's inertia."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import narrows as nw
from engine_models import steered
from narrows.logbook.filtering import likelihood
from narrows.logbook.filtering.likelihood import (
    LinearRecord,
    RecordLikelihood,
    RecordPath,
    RecordScore,
    SearchResult,
    bounded_step,
    deviance,
    readings_for_one,
    score_and_information,
    search,
)
from narrows.logbook.filtering.log_problem import Estimated, LogProblem, Process, StochasticModel
from narrows.logbook.learned_coefficients import (
    LogPosterior,
    averaged,
    coefficient_prior,
    expected_std,
    push_inertia,
    with_asymmetry,
    with_spread,
)
from narrows.logbook.learning.log_setup import _rounding, log_problem


def unknowns(low: float = -math.inf, high: float = math.inf) -> SimpleNamespace:
    """A scaled coefficient within bounds, and a number of the stochastic model, both of prior precision 1."""
    return SimpleNamespace(
        precision=np.eye(2), count=1, prior=SimpleNamespace(limits=(np.array([low]), np.array([high])))
    )


STEEP = np.array([[3.0, 1.0], [1.0, 1.0]])  # information; with the prior's [[4, 1], [1, 2]], of determinant 7


def test_a_step_of_the_search_is_newtons_with_its_gain() -> None:
    """Right side score - unknowns = (2, 3) - (1, 1) = (1, 2): the step is (0, 1), the gain right times step."""
    step, gain = bounded_step(unknowns(), np.array([1.0, 1.0]), np.array([2.0, 3.0]), STEEP)
    np.testing.assert_allclose(step, [0.0, 1.0], atol=1e-12)
    assert gain == pytest.approx(2.0)


def test_damping_adds_to_the_diagonal_and_lessens_the_gain() -> None:
    """[[8, 1], [1, 4]] of determinant 31 by a damping of 1; the gain is that of the undamped quadratic form."""
    step, gain = bounded_step(unknowns(), np.zeros(2), np.array([1.0, 2.0]), STEEP, damping=1.0)
    expected = np.array([2.0, 15.0]) / 31
    np.testing.assert_allclose(step, expected)
    assert gain == pytest.approx(2 * expected @ [1.0, 2.0] - expected @ (STEEP + np.eye(2)) @ expected)


def test_a_step_is_no_longer_than_2_deviations_and_ends_at_bounds() -> None:
    """With the second held at 2 the first solves 4 x = 1 - 2; a bound 0.1 below, or above, is where it ends."""
    right = np.array([1.0, 40.0])
    np.testing.assert_allclose(bounded_step(unknowns(), np.zeros(2), right, STEEP)[0], [-0.25, 2.0])
    at = np.array([0.5, 0.0])
    step, _ = bounded_step(unknowns(low=0.4), at, right + at, STEEP)
    np.testing.assert_allclose(step, [-0.1, 2.0])
    step, _ = bounded_step(unknowns(high=0.6), at, np.array([30.0, 0.0]) + at, STEEP)
    np.testing.assert_allclose(step, [0.1, -0.05], atol=1e-9)
    np.testing.assert_allclose(bounded_step(unknowns(), np.zeros(2), np.array([-90.0, -90.0]), STEEP)[0], [-2.0, -2.0])
    outside, _ = bounded_step(unknowns(low=0.0), np.array([-1.0, 0.0]), np.array([-9.0, 0.0]), STEEP)
    assert outside[0] == 0.0


def test_costs_scores_and_information_of_two_innovations_by_hand() -> None:
    """-2 log of normal densities to a constant; of a variance s the slope is (e^2 / s - 1) / (2 s)."""
    e, s = np.array([2.0, -1.0]), np.array([4.0, 0.5])
    assert deviance(np.array([e, s])) == pytest.approx(1.0 + 2.0 + math.log(2.0))
    assert deviance(np.array([e, -s])) == math.inf
    slopes = np.array([[[1.0, 0.0], [0.0, 3.0]], [[0.0, 2.0], [1.0, 0.0]]])
    score, information = score_and_information(e, s, slopes)
    np.testing.assert_allclose(score, [-2.0 / 4.0 + 3.0 * (2.0 - 1.0), 2.0 * 2.0 + 0.0])
    np.testing.assert_allclose(information, [[0.25 + 0.5 * 9 / 0.25, 0.0], [0.0, 4.0 / 0.5 + 0.5 / 16]])


def test_an_innovation_counts_as_four_deviations_at_most_in_the_correlation() -> None:
    """Innovations of 5, -1, 3 and -15 deviations as 4, -1, 3 and -4: their products, one to three readings apart."""

    class Given(RecordLikelihood):
        def slopes(self, unknowns: np.ndarray, path: RecordPath) -> tuple[np.ndarray, np.ndarray]:
            return np.array([[10.0, -1.0, 1.5, -30.0], [4.0, 1.0, 0.25, 4.0]]), np.zeros((1, 2, 4))

    grid, problem = SimpleNamespace(by_signal=lambda values: {"y": values}), SimpleNamespace(correlated=1.0)
    path = RecordPath(np.ones((2, 6)), np.zeros((2, 0)), np.ones(4))
    found = Given(problem, grid).scored(np.zeros(1), path)  # type: ignore[arg-type]
    np.testing.assert_allclose(found.autocovariance[:5], [16 + 1 + 9 + 16, -4 - 3 - 12, 12 + 4, -16, 0])


def test_readings_count_for_one_up_to_the_lag_at_which_they_are_independent() -> None:
    assert readings_for_one(np.array([10.0, 4.0, 1.0, 0.6, 0.4, 9.0])) == pytest.approx(1 + 2 * (0.4 + 0.1 + 0.06))
    assert readings_for_one(np.array([10.0, 4.0])) == pytest.approx(1.8)
    assert readings_for_one(np.array([10.0, 0.5, 9.0])) == pytest.approx(1 + 2 * (0.05 + 0.9))


def test_a_reading_beyond_four_deviations_counts_as_one_at_four() -> None:
    """Noise 0.5 of one reading and of the mean of four."""
    grid = SimpleNamespace(
        readings={"y": SimpleNamespace(counted=np.array([1.0, 4.0])), "psi": SimpleNamespace(counted=np.ones(1))},
        order=np.array([0, 2, 1]),
    )
    record = LinearRecord(grid, None, None, None, None, None, np.array([4.0, 0.08, -1.0]))  # type: ignore[arg-type]
    model = StochasticModel((), {"y": 0.5, "psi": 0.02})
    np.testing.assert_allclose(record.variances(model), [0.25, 0.0004, 0.0625])
    np.testing.assert_allclose(record.weights(model), [0.25, 1.0, 1.0])
    tripled = replace(record, left=np.array([2.0, -0.16, 3.0]))
    np.testing.assert_allclose(tripled.weights(model), [1.0, 0.25, (4 / 12) ** 2])


def test_the_error_of_a_rounded_signal_has_the_size_and_memory_of_a_sawtooth() -> None:
    """A ramp of 0.01 each second in steps of 0.1 has a period of 10 s; its memory is a sixth of that."""
    t = np.arange(0.0, 1000.0, 0.25)
    exact = 0.01 * t
    rounded = 0.1 * np.round(exact / 0.1)
    std, memory = _rounding(nw.Signal(t, rounded))
    assert std == pytest.approx((rounded - exact).std(), rel=0.01)
    assert memory == pytest.approx(10.0 / 6, rel=0.01)
    assert _rounding(nw.Signal(t, exact)) == (0.0, 1.0)


def test_numbers_of_the_stochastic_model_are_logarithms_over_their_usual_values() -> None:
    processes = (
        Process("Y", "Y", 2.0, 30.0),
        Process("N", "N", 0.5, 30.0),
        Process("zero", "psi_error", 0.1, math.inf),
    )
    estimated = (
        Estimated("std", ("Y", "N"), 1.5), Estimated("memory", ("Y",), 1.5), Estimated("noise", ("y",), 1.5),
        Estimated("correlation", ("Y", "N"), 1.0),
    )  # fmt: skip
    usual = StochasticModel(processes, {"y": 0.2, "psi": 0.01}, estimated, correlation=0.3)
    found = usual.at([math.log(3.0), math.log(0.5), math.log(2.0), -0.5])
    assert [one.std for one in found.processes] == pytest.approx([6.0, 1.5, 0.1])
    assert [one.memory for one in found.processes] == pytest.approx([15.0, 30.0, math.inf])
    assert found.noise == pytest.approx({"y": 0.4, "psi": 0.01})
    assert found.correlation == pytest.approx(0.995 * math.tanh(-0.5))
    cross = found.correlation * 6.0 * 1.5
    np.testing.assert_allclose(found.covariance(), [[36.0, cross, 0.0], [cross, 2.25, 0.0], [0.0, 0.0, 0.01]])
    np.testing.assert_allclose(found.kept(3.0), [math.exp(-0.2), math.exp(-0.1), 1.0])


def test_a_pilot_has_gains_of_a_regulator_and_an_aim_that_stays_for_four_lengths() -> None:
    model = StochasticModel((), {"y": 0.2}, (Estimated("noise", ("y",), 1.5),)).with_pilot(200.0, 4.0)
    gains = {one.adds_to: one.std for one in model.processes if one.adds_to.startswith("helm_by")}
    assert gains == pytest.approx(
        {"helm_by_y": 0.01, "helm_by_psi": 5.0, "helm_by_v": 1.25, "helm_by_r": 100.0, "helm_by_rudder": 0.5}
    )
    trim, aim = model.processes[-2:]
    assert (trim.std, trim.memory) == (pytest.approx(math.radians(5.0)), math.inf)
    assert (aim.std, aim.memory) == (pytest.approx(math.radians(2.0)), 200.0)
    assert model.noise["helm"] == pytest.approx(math.radians(1.0))
    assert [one.of for one in model.estimated] == ["std", "memory", "noise", "noise"]


@pytest.fixture(scope="module")
def ship() -> nw.Model:
    return steered()


def test_a_spread_is_a_share_of_each_coefficient_but_of_inertia(ship: nw.Model) -> None:
    spread = with_spread(ship, 0.1)
    for term, variance in zip(ship.terms.terms, np.diag(spread.covariance), strict=True):
        inertia = term.name in ("a_udot", "b_vdot", "b_rdot", "c_vdot", "c_rdot")
        assert math.sqrt(variance) == pytest.approx(0.0 if inertia else 0.1 * abs(ship[term.name])), term.name
    named = with_spread(ship, {"b_uv": 3.0})
    assert np.count_nonzero(named.covariance) == 1
    assert named.covariance[(ship.terms.names.index("b_uv"),) * 2] == pytest.approx(9.0)
    for wrong in (0.0, -0.1, math.inf, {"b_uv": -1.0}):
        with pytest.raises(nw.InputError, match="is none: give a share over 0"):
            with_spread(ship, wrong)


def test_inertia_is_what_forces_lose_in_a_unit_acceleration(ship: nw.Model) -> None:
    """Of the ship's own forces, by the mean of the prior; coefficients of no inertia have no part in it."""
    model = with_spread(ship, {name: 0.2 * abs(ship[name]) for name in ("b_uv", "b_vdot", "c_rdot", "b_bank")})
    prior = coefficient_prior(model, "free")
    inertia = push_inertia(prior, 4.0)
    for row, (force, name) in enumerate((("X", "udot"), ("Y", "vdot"), ("N", "rdot"))):
        expected = model.forces(u=4.0)[force] - model.forces(u=4.0, **{name: 1.0})[force]
        assert inertia[row, 0] + inertia[row, 1:] @ prior.mean == pytest.approx(float(expected) or 1.0, rel=1e-9)
    places = {name: 1 + prior.names.index(name) for name in ("b_uv", "b_vdot", "c_rdot", "b_bank")}
    assert not inertia[:, [places["b_uv"], places["b_bank"]]].any()
    assert inertia[1, places["b_vdot"]]
    assert inertia[2, places["c_rdot"]]
    assert push_inertia(prior, 4.0, 5e6)[0, 0] == 5e6


def test_a_prior_is_of_tied_groups_in_their_standard_deviations(ship: nw.Model) -> None:
    """Tied coefficients are one, within the bounds of both; the precision inverts the correlation."""
    names = ("b_uv", "b_rdot", "c_vdot", "b_bank")
    sizes = np.array([0.1 * abs(ship[name]) if name in names else 0.0 for name in ship.terms.names])
    mixed = np.where(np.eye(len(sizes)), 1.0, 0.4)
    tied = replace(ship, covariance=mixed * np.outer(sizes, sizes))
    prior = coefficient_prior(tied, "held", ("b_uv",))
    assert {frozenset(group) for group in prior.groups} == {
        frozenset(own) for own in (("b_rdot", "c_vdot"), ("b_uv",), ("b_bank",))
    }
    size = len(prior.groups)
    for group, mean, scale, free in zip(prior.groups, prior.mean, prior.scale, prior.free, strict=True):
        assert mean == ship[group[0]]
        assert scale == pytest.approx(0.1 * abs(ship[group[0]]))
        assert free == ("b_uv" in group)
    np.testing.assert_allclose(prior.precision, np.linalg.inv(np.where(np.eye(size), 1.0, 0.4)), rtol=1e-9)
    assert coefficient_prior(tied, "held").free.all()
    low, high = prior.limits
    np.testing.assert_allclose(low * prior.scale + prior.mean, prior.bounds[:, 0])
    np.testing.assert_allclose(high * prior.scale + prior.mean, prior.bounds[:, 1])


def test_an_asymmetry_without_a_variance_is_that_of_a_degree_of_rudder(ship: nw.Model) -> None:
    model = with_asymmetry(with_spread(ship, {"b_uv": 1.0}), 4.0)
    turned = ship.forces(u=4.0, rudder=math.radians(1.0))
    still = ship.forces(u=4.0)
    added = [name for name in model.terms.names if name not in ship.terms.names]
    assert len(added) >= 2
    sizes = dict(zip(model.terms.names, np.sqrt(np.diag(model.covariance)), strict=True))
    pushed = {name: model.with_coefficients(**{name: sizes[name]}).forces(u=4.0) for name in added}
    for force in ("Y", "N"):
        least = min(
            abs(abs(float(pushed[name][force] - still[force])) - abs(float(turned[force] - still[force])))
            for name in added
        )
        assert least < 1e-6 * abs(float(turned[force] - still[force]))


def test_an_expected_standard_error_is_that_of_prior_and_information(ship: nw.Model) -> None:
    """One coefficient of prior precision 1 and information 3, in its standard deviations: half."""
    model = with_spread(ship, {"b_uv": 4.0})
    problem = LogProblem(None, coefficient_prior(model, "held"), None, StochasticModel((), {}))  # type: ignore[arg-type]
    found = expected_std(problem, np.array([[3.0]]))
    assert found["b_uv"] == pytest.approx(2.0)
    assert found["b_bank"] == 0.0


def test_the_average_of_two_answers_is_in_the_middle() -> None:
    one, other = LogPosterior(np.array([1.0]), np.eye(1), 9.0, 1), LogPosterior(np.array([3.0]), 3 * np.eye(1), 1.0, 1)
    both = averaged(one, other)
    assert both.values == [2.0]
    assert both.covariance == [[3.0]]
    assert both.probability == other.probability == pytest.approx(0.3173, abs=1e-4)


def test_a_simulated_log_with_a_held_speed_is_learned_with_a_held_speed() -> None:
    """Else the rudder's drag, which such a voyage does not feel, contradicts it."""
    model = nw.published("estimated_kcs")
    held, free = (nw.simulate(model, y=20, u=4, hold=0, duration=200, surge=kind) for kind in ("held", "free"))
    assert [log_problem(model, one, "vdr").motion.choices["surge"] for one in (held, free)] == ["held", "free"]
    assert log_problem(model, held, "vdr", surge="free").motion.choices["surge"] == "free"


def searches(
    model: nw.Model, monkeypatch: pytest.MonkeyPatch, autocovariance: np.ndarray, lost: bool = False
) -> list[LogProblem]:
    """Search where every maximum has these innovations; return the problem of each, the first lost if asked."""
    one = RecordScore(np.zeros(1), np.eye(1), 0.0, autocovariance, np.zeros((2, 2)), {})
    begun: list[LogProblem] = []

    def maximum(problem: LogProblem, grids: object, unknowns: np.ndarray, *_: object) -> SearchResult | None:
        begun.append(problem)
        return None if lost and len(begun) == 1 else SearchResult(problem, unknowns, (one,))

    monkeypatch.setattr(likelihood, "_maximum", maximum)
    prior = coefficient_prior(with_spread(model, {"b_uv": 4.0}), "held")
    search(LogProblem(None, prior, None, StochasticModel((), {})), ())  # type: ignore[arg-type]
    return begun


def test_readings_are_counted_as_their_innovations_are_correlated(
    ship: nw.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Autocorrelations of 1, 0.8, 0.4 and 0: one of 1 + 2 (0.8 + 0.4) = 3.4 readings counts, from the second search."""
    counted = [one.correlated for one in searches(ship, monkeypatch, np.array([1.0, 0.8, 0.4, 0.0]))]
    assert counted == pytest.approx([1.0, 3.4])
    assert len(searches(ship, monkeypatch, np.array([1.0, 0.05, 0.0]))) == 1


def test_a_model_that_cannot_follow_whole_records_is_fitted_loosely(
    ship: nw.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a thousandth of her length a step, instead of rounding errors."""
    walks = [one.walk for one in searches(ship, monkeypatch, np.array([1.0, 0.0]), lost=True)]
    assert walks == [1e-7, 1e-3]
