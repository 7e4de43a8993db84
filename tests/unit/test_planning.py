"""Plans of tests against brute force, and against fits to twins of the runs that they propose."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.captive.synthetic import candidates
from narrows.identification.motions import distinct_motions
from narrows.identification.normal_equations import accumulate
from narrows.identification.plan import RATE, ExpectedErrors, choose, expected_model, within_tested

SETTING = nw.published("mikkelsen2025_dtc").configuration
TANK = nw.Tank(speeds=(0.7, 1.0))


def hull_reach(run, configuration: nw.Configuration) -> float:
    """How far to a side the hull's corners come."""
    columns = run.columns(10.0)
    ship, psi = configuration.ship, columns["psi"]
    corners = np.abs(columns["y"]) + ship.length / 2 * np.abs(np.sin(psi)) + ship.beam / 2 * np.cos(psi)
    return float(corners.max())


def test_candidates_fit_the_tank() -> None:
    runs = candidates(SETTING, TANK)
    assert len({run.name for run in runs}) == len(runs) > 50
    for run in runs:
        assert run.duration * run.speed <= 40.0 * 1.001
        assert hull_reach(run, SETTING) <= 3.5 - 1.5 * 0.572 + 1e-3
        columns = run.columns(5.0)
        drift = np.arctan2(np.abs(columns["v"]), columns["u"])
        assert max(np.abs(columns["psi"]).max(), drift.max()) <= np.radians(25.0) + 1e-9


def test_the_information_of_runs_is_that_of_generalised_least_squares() -> None:
    """Without effects that runs share, their sum is the inverse of the mixed model's covariance."""
    assumed = ExpectedErrors(SETTING, {"X": 0.5, "Y": 0.3, "N": 0.4}, 0.5, nw.RunErrors(0.03, 0.01, 0.02))
    tests = nw.twin(expected_model(SETTING), candidates(SETTING, TANK)[::20], {}, rate=RATE)
    equations, _ = accumulate(tests, nw.PAPER)
    motions = distinct_motions(equations, repeats=False)
    found = assumed.information(equations, nw.PAPER).sum(axis=0)
    for rows, model, z, unit in assumed.parts(equations, motions, nw.PAPER):
        p = len(unit)
        alone = replace(model, x=model.x[:, :p], group=np.zeros(0, int), absorbed=np.zeros((p, 0)))
        expected = np.linalg.inv(alone.conditional(z).covariance)
        own = found[np.ix_(rows.free_parameters, rows.free_parameters)] * np.outer(unit, unit)
        size = np.sqrt(np.maximum(np.diag(expected), 1.0))  # Without data only the ridge of 1e-6 remains
        np.testing.assert_allclose(own / np.outer(size, size), expected / np.outer(size, size), atol=1e-5)


def test_more_noise_and_other_zeros_leave_less_information() -> None:
    tests = nw.twin(expected_model(SETTING), candidates(SETTING, TANK)[::20], {}, rate=RATE)
    equations, _ = accumulate(tests, nw.PAPER)

    def known(noise: float, correlation_time: float, *errors: float) -> np.ndarray:
        assumed = ExpectedErrors(SETTING, dict.fromkeys("XYN", noise), correlation_time, nw.RunErrors(*errors))
        return np.diagonal(assumed.information(equations, nw.PAPER), axis1=1, axis2=2)

    usual = known(0.3, 0.0, 0.02, 0.02, 0.02)
    for other in ((0.6, 0.0, 0.02, 0.02, 0.02), (0.3, 1.0, 0.02, 0.02, 0.02), (0.3, 0.0, 0.06, 0.02, 0.02),
                  (0.3, 0.0, 0.02, 0.06, 0.02), (0.3, 0.0, 0.02, 0.02, 0.06)):  # fmt: skip
        less = known(*other)
        assert (less <= usual * (1 + 1e-9)).all()
        assert (less.sum(axis=0)[usual.sum(axis=0) > 0] < usual.sum(axis=0)[usual.sum(axis=0) > 0]).all()
    zeros = usual[:, -9:].reshape(-1, 3, 3) > 0
    assert (zeros.sum(axis=2) == 1).all()  # one zero of each force is that of a run


def test_the_choice_is_near_the_best_of_all() -> None:
    draw = np.random.default_rng(5)
    columns = draw.normal(size=(10, 6, 4))
    other = columns * draw.uniform(0.5, 2.0, columns.shape)  # another form of the columns
    runs = np.stack([np.einsum("nri,nrj->nij", form, form) for form in (columns, other)], axis=1)
    found = choose(runs, np.zeros((2, 4, 4)), 3, [1, 2])
    scale = np.sqrt(np.diagonal(runs, axis1=2, axis2=3).max(axis=0))

    def worth(chosen) -> float:
        scaled = runs / (scale[:, :, None] * scale[:, None, :])
        return max(np.trace(np.linalg.inv(form)[1:3, 1:3]) for form in scaled[list(chosen)].sum(axis=0))

    best = min(worth(chosen) for chosen in combinations(range(10), 3))
    assert len(set(found)) == 3
    assert worth(found) <= best + 0.05 * abs(best)


def test_the_order_does_not_hang_on_rounding() -> None:
    """The first run leaves one of two parameters unknown, so that its spread is rounding over the ridge."""
    draw = np.random.default_rng(6)
    columns = draw.normal(size=(12, 1, 2))
    runs = np.einsum("nri,nrj->nij", columns, columns)[:, None]
    chosen = choose(runs, np.zeros((1, 2, 2)), 4, [0, 1])
    for _ in range(20):
        rounded = runs * (1 + 4 * np.finfo(float).eps * draw.uniform(-1, 1, (len(runs), 1, 1, 1)))
        assert choose(rounded, np.zeros((1, 2, 2)), 4, [0, 1]) == chosen


Twins = tuple[dict[str, list[float]], dict[str, list[float]]]


@pytest.fixture(scope="module")
def plan() -> nw.Plan:
    return nw.plan_tests(SETTING, 8, tank=TANK)


def twins(plan: nw.Plan, count: int) -> Twins:
    """Estimates and half widths of twins with 2 % gain and 0.5 N zeros from run to run."""
    found: dict[str, list[float]] = {name: [] for name in plan.targets}
    widths: dict[str, list[float]] = {name: [] for name in plan.targets}
    for seed in range(count):
        tests, draw = nw.twin(runs=plan.runs, correlation_time=0.5, rate=5.0, seed=seed), np.random.default_rng(seed)
        run, columns = np.repeat(np.arange(len(plan.runs)), np.diff(tests.starts)), dict(tests.columns)
        for force in "XYN":
            gain, zero = 1 + 0.02 * draw.standard_normal(len(plan.runs)), 0.5 * draw.standard_normal(len(plan.runs))
            columns[force] = columns[force] * gain[run] + zero[run]
        fit = nw.identify(nw.CaptiveTests(columns, tests.names, tests.starts, tests.configuration))
        for name in plan.targets:
            found[name].append(fit.coefficients[name])
            widths[name].append((fit.intervals[name][1] - fit.intervals[name][0]) / 2)
            assert fit.verdicts[name].status == "identified"
    return found, widths


def test_a_twin_of_the_plan_has_the_errors_that_were_promised(plan: nw.Plan) -> None:
    found, _ = twins(plan, 14)
    for name in plan.targets:
        assert 0.3 < np.std(found[name]) / plan.std[name][-1] < 1.2


def test_a_twin_of_the_plan_has_the_interval_that_was_promised(plan: nw.Plan) -> None:
    _, widths = twins(plan, 2)  # Widths of twins differ little
    for name in plan.targets:
        assert np.median(widths[name]) == pytest.approx(plan.reach[name], rel=0.5)


def test_a_plan_goes_to_both_sides(plan: nw.Plan) -> None:
    sides = [np.sign(run.offset) for run in plan.runs if run.offset]
    assert min(sides.count(1), sides.count(-1)) >= len(sides) / 3


def test_a_plan_stays_within_what_was_tested() -> None:
    made = nw.twin(runs=[nw.HarmonicRun("a", "yaw", 0.9, 25.0), nw.HarmonicRun("b", "sway", 0.7, 15.0, 0.8)], rate=5.0)
    for run in nw.plan_tests(SETTING, 2, tank=nw.Tank(run_length=20.0, heading=10.0), after=made).runs:
        assert np.abs(run.columns(5.0)["y"]).max() <= 0.9 + 1e-3
        assert 0.8 <= run.speed <= 1.0
    asked = nw.Tank(speeds=(0.6,), reach=1.8)
    assert within_tested(asked, nw.DataRange(speed=(0.8, 1.0), abs_y=(0.0, 0.9)))[0] == asked


def test_a_plan_goes_where_it_is_asked_to() -> None:
    made = nw.twin(runs=[nw.HarmonicRun("a", "yaw", 0.9, 25.0), nw.HarmonicRun("b", "sway", 0.7, 15.0, 0.8)], rate=5.0)
    slow = nw.Tank(run_length=20.0, heading=10.0, speeds=(0.6,), reach=1.8)
    asked = nw.plan_tests(SETTING, 2, tank=slow, after=made).runs
    assert {run.speed for run in asked} == {0.6}
    assert max(np.abs(run.columns(5.0)["y"]).max() for run in asked) > 1.0


def test_a_plan_beats_harmonic_runs_about_the_centreline(plan: nw.Plan) -> None:
    for name in ("b_bank", "c_bank"):
        assert plan.std[name][-1] < plan.usual[name]
        assert plan.std[name][-1] < plan.std[name][3]
        assert plan.reach[name] >= 1.95 * plan.std[name][-1]
    assert "standard error" in plan.summary()


def test_what_was_made_already_counts(plan: nw.Plan) -> None:
    tank = nw.Tank(run_length=20.0, heading=10.0, speeds=(0.7,))
    after = nw.plan_tests(SETTING, 2, tank=tank, after=nw.twin(runs=plan.runs[:3], rate=5.0))
    assert after.std["b_bank"][-1] < nw.plan_tests(SETTING, 2, tank=tank).std["b_bank"][-1]


def test_depths_are_proposed_where_terms_know_them() -> None:
    tank = nw.Tank(speeds=(0.7,), depths=(0.2, 0.4))
    terms = nw.with_bank(nw.PAPER, "distance_depth")
    found = nw.plan_tests(SETTING, 8, tank=tank, terms=terms)
    assert {run.depth for run in found.runs} == {0.2, 0.4}
    assert set(found.targets) == {"b_bank", "b_bank_depth", "c_bank", "c_bank_depth"}
    fit = nw.identify(nw.twin(nw.Model(SETTING, terms, dict.fromkeys(terms.names, 1.0)), found.runs), terms)
    assert fit.coefficients["b_bank_depth"] == pytest.approx(1.0, abs=5 * found.std["b_bank_depth"][-1])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"runs": 0}, "no plan"),
        ({"targets": ("b_bnk",)}, "targets are"),
        ({"terms": nw.with_bank(nw.PAPER, "tuck")}, "need depth"),
        ({"tank": nw.Tank(clearance=6.0)}, "no run fits"),
        ({"tank": nw.Tank(depths=(0.1,)), "terms": nw.with_bank(nw.PAPER, "tuck")}, "no water under"),
        ({"tank": nw.Tank(depths=(0.3,))}, "depends on the water.s depth"),
        ({"tank": nw.Tank(speeds=(5.0,))}, "no speed for a ship"),
        ({"noise": {"Y": 1.0}}, "noise: X needs"),
        ({"terms": nw.TermTable("bare", (), (nw.PAPER["b_v"],), ())}, "no bank to plan for"),
    ],
)
def test_plans_that_cannot_be_made(options: dict, said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        nw.plan_tests(SETTING, **options)


@pytest.mark.parametrize(
    "options", [{"run_length": 0.0}, {"run_length": np.inf}, {"speeds": (-1.0,)}, {"heading": -5.0}, {"reach": 0.0}]
)
def test_tanks_that_are_none(options: dict) -> None:
    with pytest.raises(nw.InputError, match="positive"):
        nw.Tank(**options)


def test_a_straight_run_moves_straight() -> None:
    run = nw.StraightRun("s", 1.2, 0.8, 10.0, drift=0.1)
    columns = run.columns(10.0)
    np.testing.assert_allclose(columns["u"] * np.cos(0.1) - columns["v"] * np.sin(0.1), 0.8, rtol=1e-12)
    np.testing.assert_allclose(columns["u"] * np.sin(0.1) + columns["v"] * np.cos(0.1), 0.0, atol=1e-12)
    assert (columns["y"] == 1.2).all()
    assert run.duration * run.speed == 8.0
    with pytest.raises(nw.InputError, match="radians"):
        nw.StraightRun("s", 1.2, drift=6.0)


def test_design_on_the_command_line(cli, ship_file, tmp_path) -> None:
    code, out, err = cli("plan", ship_file, "--runs", 4, "--speed", "0.7,1", "-o", tmp_path / "runs.csv")
    assert (code, err) == (0, "")
    assert "b_bank: standard error" in out
    frame = pd.read_csv(tmp_path / "runs.csv")
    assert len(frame) == 4
    assert {"offset [m]", "speed [m/s]", "std b_bank"} <= set(frame.columns)
    code, out, err = cli("plan", ship_file, "--speed", "fast")
    assert code == 2
    assert "--speed 'fast' is not understood; give 4.1m/s, 8kn" in err


def test_what_was_made_does_not_count_by_its_sampling() -> None:
    runs = nw.plan_tests(SETTING, 3, tank=TANK).runs
    slow, fast = (nw.plan_tests(SETTING, 1, tank=TANK, after=nw.twin(runs=runs, rate=rate)) for rate in (5.0, 20.0))
    assert fast.std["b_bank"][0] == pytest.approx(slow.std["b_bank"][0], rel=0.1)
    with pytest.raises(nw.InputError, match="several conditions"):
        nw.plan_tests(SETTING, 1, tank=TANK, after=nw.measured_tests("kcs"))


def test_tied_targets_are_one() -> None:
    tank = nw.Tank(run_length=20.0, heading=10.0, speeds=(0.7,))
    one, both = (nw.plan_tests(SETTING, 3, tank=tank, targets=own) for own in (("b_rdot",), ("b_rdot", "c_vdot")))
    assert both.std["b_rdot"][-1] == both.std["c_vdot"][-1] == pytest.approx(one.std["b_rdot"][-1])


def test_what_no_run_determines_is_said(cli, tmp_path) -> None:
    terms = nw.with_bank(nw.PAPER, "distance_depth")
    plan = nw.plan_tests(SETTING, 4, tank=nw.Tank(speeds=(0.7,), depths=(0.3,)), terms=terms)
    assert not plan.determined
    assert "These runs do not determine" in plan.summary()
    many = nw.plan_tests(SETTING, 10_000, tank=nw.Tank(speeds=(0.7,)))
    assert len(many.runs) == many.considered


def test_at_full_scale_a_run_is_as_long_as_the_ship_needs() -> None:
    full = nw.scale_model(nw.published("mikkelsen2025_dtc"), 355.0).model.configuration
    runs = candidates(full, nw.Tank())
    assert max(run.duration * run.speed for run in runs) == pytest.approx(3550, rel=0.01)
