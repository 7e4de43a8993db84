"""What a hostile statistician found: truths that are not of the fitted terms, and errors that runs share."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import narrows as nw
from narrows.captive.synthetic import Run
from narrows.identification.motions import numbered

YAW, SWAY = "yaw", "sway"
LIFT = nw.Model(
    nw.published("mikkelsen2025_dtc").configuration,
    nw.SPEED,
    {
        "a_udot": 0.0, "a_u": 0.0, "a_uu": 12.0,
        "b_vdot": 730.0, "b_rdot": -56.0, "b_uv": 90.0, "b_ur": 120.0, "b_vv": 900.0, "b_rr": 0.0, "b_bank": 0.0,
        "c_vdot": -56.0, "c_rdot": 710.0, "c_uv": 250.0, "c_ur": 170.0, "c_vv": 300.0, "c_rr": 900.0, "c_bank": 0.0,
    },
)  # fmt: skip
"""A hull whose damping is lift, and no bank."""
PAPER_THREE = nw.published("mikkelsen2025_dtc")


def runs_at(speeds: Sequence[float]) -> list[Run]:
    """Return two yaw runs and one sway run at each speed."""
    return [
        nw.HarmonicRun(f"{kind} {a} at {u}", kind, a, period, u, 2)
        for u in speeds
        for kind, a, period in ((YAW, 0.9, 25.0), (YAW, 0.5, 25.0), (SWAY, 0.6, 20.0))
    ]


def scattered(tests: nw.CaptiveTests, gain: float, seed: int, form: float = 0.0) -> nw.CaptiveTests:
    """Return tests whose forces are off by a gain of each run, and by a form error of each motion."""
    draw = np.random.default_rng(seed)
    test = np.repeat(np.arange(len(tests.names)), np.diff(tests.starts))
    kind = np.array([name.partition(" again")[0] for name in tests.names])
    columns = dict(tests.columns)
    for force in "XYN":
        wave = {name: draw.standard_normal() * np.array([1.0, draw.uniform(0, 6.3)]) for name in dict.fromkeys(kind)}
        size = np.array([np.sqrt(np.mean(columns[force][test == i] ** 2)) for i in range(len(kind))])
        phase = 2 * np.pi * columns["t"] / 12.5
        shape = [size[i] * wave[kind[i]][0] * np.cos(phase[test == i] + wave[kind[i]][1]) for i in range(len(kind))]
        columns[force] = columns[force] * (1 + gain * draw.standard_normal(len(kind)))[test] + form * np.concatenate(
            shape
        )
    return nw.CaptiveTests(columns, tests.names, tests.starts, tests.configuration)


def assert_not_fooled(fit: nw.Fit, truth: float = 0.0) -> None:
    """No coefficient of the bank is called identified while its interval misses the truth."""
    for term in fit.terms.terms:
        if term.from_bank and fit.verdicts[term.name].status == "identified":
            low, high = fit.intervals[term.name]
            assert low <= truth <= high, fit.verdicts[term.name].sentence(term.name)


def test_speeds_do_not_chain() -> None:
    """Neighbours of 0.8, 0.9, 1.0 and 1.1 m/s are near; the speeds are four."""
    assert numbered([0.8, 0.82, 0.85, 0.88, 0.9]).tolist() == [0, 0, 1, 1, 2]
    fit = nw.identify(nw.twin(LIFT, runs_at((0.8, 0.9, 1.0, 1.1)), rate=10.0))
    assert len(fit.diagnostics.by_speed) == 4
    for name in ("b_bank", "c_bank"):
        assert fit.verdicts[name].status == "confounded"
        assert any("at each speed" in reason for reason in fit.verdicts[name].reasons)


def test_one_short_run_does_not_switch_the_rule_off() -> None:
    runs = [*runs_at((0.7, 1.0, 1.2)), nw.StraightRun("one", 1.2, 1.0, 20.0)]
    for seed in range(3):
        assert_not_fooled(nw.identify(nw.twin(LIFT, runs, rate=10.0, seed=seed)))


def test_depths_do_not_mix() -> None:
    fit = nw.identify(nw.measured_tests("kcs"), "paper+keel_gap")
    for name in ("b_bank", "c_bank"):
        assert fit.verdicts[name].status == "confounded"
        assert any("depth" in reason for reason in fit.verdicts[name].reasons)


@pytest.mark.parametrize("terms", ["paper+keel_gap", "crossflow+delta_depth"])
def test_a_hull_that_varies_with_depth_is_no_bank(terms: str) -> None:
    """The motions of the KCS tests, no bank, and a hull that grows as the water shallows."""
    tests, columns, draw = nw.measured_tests("kcs"), {}, np.random.default_rng(1)
    own = dict(tests.columns)
    grown = (0.41 / own["depth"]) ** 1.5
    hull = {**LIFT.coefficients, "b_bank": 0.0, "c_bank": 0.0}
    values = {**tests.configuration.values(), **own}
    for force, part in nw.SPEED.forces.items():
        clean = sum(hull[term.name] * term.column(values) for term in part)
        columns[force] = grown * clean + 0.05 * draw.standard_normal(tests.rows)
    made = nw.CaptiveTests({**own, **columns}, tests.names, tests.starts, tests.configuration, tests.conditions)
    assert_not_fooled(nw.identify(made, terms))


def test_repeats_are_left_out_together() -> None:
    tests = nw.measured_tests("kcs").by_condition()["C0101A01"]
    fit = nw.identify(tests)
    assert max(len(members) for members in fit.motions.members) == 14
    error = 0.0
    for members in fit.motions.members:
        inside = np.isin(tests.names, members)
        model = nw.identify(tests.where(~inside)).model
        out = tests.where(inside)
        motion = nw.Motion(**{name: out.columns[name] for name in nw.Motion().values()})
        error += ((out.columns["Y"] - model.forces(motion)["Y"]) ** 2).sum()
    assert fit.left_out["Y"].rmse == pytest.approx(np.sqrt(error / tests.rows), rel=1e-6)


def test_a_form_error_of_each_motion_is_covered() -> None:
    """Fourteen of twenty-five tests are one motion, whose error of form no repeat shows."""
    again = [nw.HarmonicRun(f"yaw 0.9 at 1.0 again {i}", YAW, 0.9, 25.0, 1.0, 2) for i in range(13)]
    held = []
    for seed in range(8):
        tests = nw.twin(PAPER_THREE, [*runs_at((1.0, 0.8, 0.65)), *again], rate=5.0, seed=seed)
        fit = nw.identify(scattered(tests, 0.01, seed, form=0.03))
        held += [low <= PAPER_THREE.coefficients[n] <= high for n in ("b_bank", "c_rdot", "b_vdot")
                 for low, high in [fit.intervals[n]]]  # fmt: skip
    assert np.mean(held) >= 0.9


@pytest.mark.parametrize("runs", ["paper", "five", "plan"])
def test_gains_of_two_per_cent_are_covered(runs: str) -> None:
    from narrows.captive.synthetic import PAPER_RUNS

    plan = nw.plan_tests(PAPER_THREE.configuration, 6, tank=nw.Tank(speeds=(0.7, 1.0))).runs
    five = (*PAPER_RUNS, nw.StraightRun("s1", 0.9), nw.StraightRun("s2", -1.5))
    held = []
    for seed in range(12):
        tests = nw.twin(PAPER_THREE, {"paper": PAPER_RUNS, "five": five, "plan": plan}[runs], rate=5.0, seed=seed)
        fit = nw.identify(scattered(tests, 0.02, seed))
        assert_not_fooled(fit, PAPER_THREE.coefficients["b_bank"]) if runs == "paper" else None
        held += [low <= PAPER_THREE.coefficients[n] <= high for n in ("b_bank", "c_bank", "b_vdot")
                 for low, high in [fit.intervals[n]]]  # fmt: skip
    assert np.mean(held) >= 0.9


def test_unequal_tests_are_covered() -> None:
    """Two of sixteen runs ten times as long, a form error in each motion."""
    held = []
    for seed in range(8):
        sizes = [(0.3 + 0.04 * i, 14.0 + i, (0.7, 1.0)[i % 3 > 0], 10 if i < 2 else 1) for i in range(16)]
        runs = [nw.HarmonicRun(f"{i}", (YAW, SWAY)[i % 2], *size) for i, size in enumerate(sizes)]
        tests = scattered(nw.twin(PAPER_THREE, runs, rate=4.0, seed=seed), 0.0, seed, form=0.03)
        fit = nw.identify(tests)
        held += [
            low <= PAPER_THREE.coefficients[n] <= high for n in nw.PAPER.names[3:] for low, high in [fit.intervals[n]]
        ]
    assert np.mean(held) >= 0.93


@pytest.mark.parametrize("terms", ["paper", "mixed"])
def test_three_tests_are_left_out_whole(terms: str) -> None:
    tests = nw.twin(rate=5.0)
    fit, error = nw.identify(tests, terms, balance="rows"), 0.0
    for name in tests.names:
        inside = np.array([own == name for own in tests.names])
        model, out = nw.identify(tests.where(~inside), terms, balance="rows").model, tests.where(inside)
        motion = nw.Motion(**{own: out.columns[own] for own in nw.Motion().values()})
        error += ((out.columns["Y"] - model.forces(motion)["Y"]) ** 2).sum()
    assert fit.left_out["Y"].rmse == pytest.approx(np.sqrt(error / tests.rows), rel=1e-6)


def test_one_run_that_holds_nearly_all_is_named() -> None:
    """Without the straight run the columns still have full rank, and next to nothing is known."""
    runs = [*runs_at((1.0,)), nw.StraightRun("the one", 1.6, 1.0, 60.0)]
    fit = nw.identify(nw.twin(PAPER_THREE, runs, rate=5.0))
    test, share = fit.influence.most_informing("b_bank")
    assert test == "the one"
    assert 0.75 < share < 1.0
    assert fit.verdicts["b_bank"].status in ("rests on one test", "confounded")
    assert any("the one" in reason for reason in fit.verdicts["b_bank"].reasons)


def test_lataires_c_bank_is_not_identified() -> None:
    tests = nw.measured_tests("lataire2009")
    fit = nw.identify(tests.where([name in "BCDFHIJ" for name in tests.names]), nw.bank_only("distance"))
    low, high = fit.intervals["c_bank"]
    assert low < 0 < high
    assert fit.verdicts["c_bank"].status == "confounded"


def test_a_reader_of_json_finds_one_word() -> None:
    shown = nw.identify(nw.twin(rate=5.0)).to_dict()["coefficients"]["b_bank"]
    assert "identifiable" not in shown
    assert shown["verdict"] != "identified"
    assert shown["determined"] is True


KINDS = [
    ("gain", 0.03), ("zero", 2.0), ("form", 0.05), ("repeats", 0.1), ("near_repeats", 5.0), ("unequal", 0.03),
    ("few_tests", 5), ("outliers", 0.02), ("bad_run", 0.2), ("zero_of_a_day", 2.0), ("hull_by_speed", 1.0),
    ("hull_by_period", 0.15), ("hull_by_depth", 1.2), ("static_unlike_harmonic", 0.15), ("crossflow", 0.3),
    ("asymmetric_hull", 2.0), ("tapered", 0.15), ("other_form", 0.3), ("bank_by_speed", 0.2), ("rail", 0.05),
    ("accelerations", 0.1), ("gain_by_kind", 0.1), ("drift_couples", 1.0), ("cubic_y", 0.1),
    ("settling", 0.3), ("settling", 1.0), ("gain_of_straight_runs", 0.2), ("rail_of_straight_runs", 0.2),
    ("batches", 0.1), ("power_of_y", 1.5), ("hull_with_memory", 1.0), ("drift_to_one_side", 4.0), ("heel", 50.0),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "strength"), KINDS)
def test_no_kind_of_broken_twin_fools_it(kind: str, strength: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """The table of docs/uncertainty.md has a hundred twins of each; here are two."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "decisions")
    import trust_kinds

    named = {made.__name__: made for made in trust_kinds.KINDS}
    for seed in (11, 12):
        tests, truth = named[kind](np.random.default_rng(seed), strength)
        fit = nw.identify(tests, "paper+keel_gap" if kind == "hull_by_depth" else "paper")
        for name, value in truth.items():
            low, high = fit.intervals[name]
            assert fit.verdicts[name].status != "identified" or low <= value <= high


def test_straight_runs_that_read_more_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """The gain that they read more by is told by the runs that drift, and both numbers are given."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "decisions")
    import trust_kinds

    tests, truth = trust_kinds.gain_by_kind(np.random.default_rng(3), 0.1)
    fit = nw.identify(tests)
    own = {c.label: c for c in fit.evidence.compared(fit.terms.names.index("b_bank"))}
    assert own["a gain of their own in steady runs"].value == pytest.approx(truth["b_bank"], rel=0.04)
    assert own["a gain of their own in harmonic runs"].value == pytest.approx(1.1 * truth["b_bank"], rel=0.04)
    assert any("a gain of their own in steady runs" in reason for reason in fit.verdicts["b_bank"].reasons)


def test_a_force_as_a_power_of_y_is_seen_for_what_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """The slope of y cubed on y is that of the rows, and beside it nothing is left of a bank that is none."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "decisions")
    import trust_kinds

    tests, _ = trust_kinds.cubic_y(np.random.default_rng(3), 0.3)
    fit = nw.identify(tests)
    y = [tests.columns["y"][a:b] for a, b in zip(tests.starts[:-1], tests.starts[1:], strict=True)]
    np.testing.assert_allclose(fit.motions.cube, [(own**4).sum() / (own**2).sum() for own in y], rtol=0.02)
    own = {c.label: c for c in fit.evidence.compared(fit.terms.names.index("b_bank"))}
    beside = own["a force that goes as y^3 beside"]
    assert beside.holds_zero
    assert abs(beside.value) < 0.3 * fit.coefficients["b_bank"]
    assert fit.verdicts["b_bank"].status == "confounded"


def test_the_later_half_of_each_run_is_a_fit_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forces that settle in every run: what the later halves alone tell is what a fit to their rows gives."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "decisions")
    import trust_types_of_runs

    tests, truth = trust_types_of_runs.settling(np.random.default_rng(3), 1.0)
    fit = nw.identify(tests)
    lengths = np.diff(tests.starts)
    later = np.concatenate([np.arange(n) >= n / 2 for n in lengths])
    starts = np.concatenate([[0], np.cumsum(lengths - (lengths + 1) // 2)])
    rows = {name: column[later] for name, column in tests.columns.items()}
    again = nw.identify(nw.CaptiveTests(rows, tests.names, starts, tests.configuration))
    for name in ("b_bank", "c_bank"):
        compared = {c.label: c for c in fit.evidence.compared(fit.terms.names.index(name))}
        half = compared["told by the later half of each run alone"]
        assert half.value == pytest.approx(again.unbounded.values[fit.terms.names.index(name)], rel=5e-3)
        assert abs(half.value - truth[name]) < 0.5 * abs(fit.coefficients[name] - truth[name])
        low, high = fit.intervals[name]
        assert low < truth[name] < high
    assert any("the later half of each run" in reason for reason in fit.verdicts["b_bank"].reasons)


@pytest.mark.parametrize("scatter", [0.0, 0.02])
def test_a_plan_that_separates_has_its_power(scatter: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "decisions")
    import trust_kinds

    for seed in (21, 22, 23):
        tests, truth = trust_kinds.honest(np.random.default_rng(seed), scatter)
        fit = nw.identify(tests)
        low, high = fit.intervals["b_bank"]
        assert fit.verdicts["b_bank"].status == "identified"
        assert low <= truth["b_bank"] <= high
        assert high - low < 0.3 * truth["b_bank"]
