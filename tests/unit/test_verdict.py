"""Verdicts: each word for the cause it stands for, on tests made to have that cause alone."""

from dataclasses import replace

import numpy as np
import pytest

import narrows as nw
from narrows.identification.identifiability.verdict import CONFOUNDED_VIF, VIF_LIMIT
from tables import many_runs, short_twin


def sway_only() -> nw.Fit:
    runs = tuple(nw.HarmonicRun(f"S{p}", "sway", 0.3 + p / 50, p, 1.0, 1) for p in (12.0, 18.0, 25.0))
    return nw.identify(nw.twin(runs=runs, rate=5.0))


def test_not_excited_names_what_stood_still() -> None:
    fit = sway_only()
    for name, motion in (("a_udot", "udot"), ("b_r", "r"), ("c_rr", "r"), ("c_rdot", "rdot")):
        assert fit.verdicts[name].sentence(name) == f"{name} is not identifiable: {motion} is 0 in every test."
        assert not fit.verdicts[name].determined
        assert fit.coefficients[name] == 0.0
        assert np.isnan(fit.std[name])


def test_a_tie_determines_what_its_own_force_does_not() -> None:
    """Without yaw b_rdot has no data in Y, but N gives c_vdot, and the two are one number."""
    fit = sway_only()
    assert fit.coefficients["b_rdot"] == fit.coefficients["c_vdot"] == pytest.approx(-56.1, abs=5 * fit.std["c_vdot"])
    assert fit.std["b_rdot"] == fit.std["c_vdot"] > 0
    assert fit.verdicts["c_vdot"].determined
    assert fit.verdicts["b_rdot"].status == "weakly identified"
    assert fit.verdicts["b_rdot"].reasons == ("rdot is 0 in every test, so that only its tie determines it",)


def test_other_bounds_may_press_a_coefficient_to_its_own() -> None:
    """Only where the fit without its own bound goes beyond do the data alone put it there."""
    for fit in map(nw.identify, nw.measured_tests("kcs").by_condition().values()):
        for name in fit.at_bound:
            term = nw.PAPER[name]
            place = {"X": "surge", "Y": "sway", "N": "yaw"}[
                next(f for f, own in nw.PAPER.forces.items() if term in own)
            ]
            free = nw.identify(fit.tests, nw.PAPER.with_terms("free", **{place: [replace(term, bound=nw.FREE)]}))
            beyond = not term.bound[0] <= free.coefficients[name] <= term.bound[1]
            assert beyond == ("beyond" in fit.verdicts[name].reasons[0])


def test_at_its_bound_is_where_the_data_press_it() -> None:
    """A ship with negative damping in sway: the bound holds b_v at 0."""
    truth = nw.published("mikkelsen2025_dtc").with_coefficients(b_v=-50.0)
    fit = nw.identify(nw.twin(truth, many_runs(), rate=5.0))
    assert fit.coefficients["b_v"] == 0.0
    assert "b_v" in fit.at_bound
    assert fit.verdicts["b_v"].status == "at its bound"
    assert fit.verdicts["b_v"].determined
    assert fit.solution.kkt.satisfied


def test_one_test_alone_is_named() -> None:
    runs = (*many_runs(24)[::2], nw.HarmonicRun("lone sway", "sway", 0.9, 20.0, 1.0, 1))
    fit = nw.identify(short_twin(2, runs))
    for name in ("b_v", "b_vv", "b_vdot", "c_v"):
        assert "without lone sway nothing is known of it" in fit.verdicts[name].reasons
    assert not any("nothing is known" in reason for reason in fit.verdicts["c_rdot"].reasons)


def test_an_interval_around_zero_is_weak(kcs_fits: dict[int, nw.Fit]) -> None:
    for fit in kcs_fits.values():
        for name, (low, high) in fit.intervals.items():
            said = any("holds 0" in reason for reason in fit.verdicts[name].reasons)
            if name not in fit.at_bound and low <= 0 <= high and fit.verdicts[name].determined:
                assert said


def test_inflation_over_the_limits_is_weak(kcs_fits: dict[int, nw.Fit]) -> None:
    for fit in kcs_fits.values():
        for force, terms in nw.PAPER.forces.items():
            for term in terms:
                if not fit.verdicts[term.name].determined:
                    continue
                reasons = " ".join(fit.verdicts[term.name].reasons)
                vif = fit.diagnostics.overall[force].vif[term.name]
                if term.name not in fit.at_bound:
                    assert ("over all rows" in reasons) == (vif > VIF_LIMIT)
                    assert vif <= CONFOUNDED_VIF or fit.verdicts[term.name].status == "confounded"


def test_a_good_coefficient_is_just_identified() -> None:
    straight = tuple(nw.StraightRun(f"at {y}", y, 1.0, 20.0) for y in (0.8, -0.8, 1.5, -1.5))
    fit = nw.identify(short_twin(0, (*many_runs(), *straight)))
    for name in ("b_vdot", "c_rdot", "b_bank", "c_bank"):
        assert fit.verdicts[name].status == "identified"
        assert fit.verdicts[name].reasons == ()
        assert fit.verdicts[name].sentence(name) == f"{name} is identified."
