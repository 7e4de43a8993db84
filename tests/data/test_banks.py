"""The measured banks: signs on the clean cases, and what the tests do not establish."""

import pytest

import narrows as nw


def bank_only(form: str) -> nw.TermTable:
    return nw.TermTable(form, (), nw.FORMS[form].sway, nw.FORMS[form].yaw)


@pytest.mark.parametrize("form", nw.FORMS)
@pytest.mark.parametrize("clean", ["D", "F", "H"])
def test_the_bow_turns_away_from_the_bank(form: str, clean: str) -> None:
    """As measured, and as every form predicts from the other tests."""
    tests = nw.measured_tests("lataire2009")
    others = tests.where([name in "BCDFHIJ" and name != clean for name in tests.names])
    row = tests.where([name == clean for name in tests.names])
    fit = nw.identify(others, bank_only(form))
    values = {**row.configuration.values(), **row.columns}
    predicted = sum(fit.coefficients[term.name] * term.column(values) for term in fit.terms.yaw)
    assert row.columns["y"][0] > 0
    assert row.columns["N"][0] < 0
    assert predicted[0] < 0


def test_seven_tests_do_not_establish_a_change_of_sign() -> None:
    tests = nw.measured_tests("lataire2009")
    fit = nw.identify(tests.where([name in "BCDFHIJ" for name in tests.names]), bank_only("distance_depth"))
    assert fit.coefficients["b_bank_depth"] < 0 < fit.coefficients["b_bank"]
    assert fit.verdicts["b_bank_depth"].status != "identified"


@pytest.mark.parametrize("clearance", [100, 50, 20])
def test_terms_of_the_hull_take_the_bank_away(kcs_tests: dict[int, nw.CaptiveTests], clearance: int) -> None:
    paper, crossflow = (nw.identify(kcs_tests[clearance], terms) for terms in (nw.PAPER, nw.CROSSFLOW))
    for force in ("Y", "N"):
        assert crossflow.left_out[force].rmse < paper.left_out[force].rmse
        assert crossflow.left_out_speeds[force].rmse < paper.left_out_speeds[force].rmse
    low, high = crossflow.intervals["b_bank"]
    assert low < 0 < high
