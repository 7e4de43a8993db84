"""Derivative, step, Jacobian and equations of a model; tests as a collection; what shows itself in few words."""

import inspect
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import sympy

import narrows as nw
from direct_equation import accelerations
from narrows.base.results import with_error
from narrows.quantities.arithmetic import choice, maximum
from narrows.report import fit_page
from tables import frame_of, short_twin

DTC = nw.published("mikkelsen2025_dtc")
KVLCC2 = nw.published("yasukawa2015_kvlcc2")
STATE = np.array([3.0, 0.8, 0.05, 0.9, -0.02, 0.01])


def test_derivative_is_the_table_of_terms_solved() -> None:
    x, y, psi, u, v, r = STATE
    motion = nw.Motion.at(psi, x=x, y=y, u=u, v=v, r=r)
    expected = accelerations(DTC, motion, (0.0, 2.0, -3.0))
    found = DTC.derivative(STATE, Y=2.0, N=-3.0)
    np.testing.assert_allclose(found[3:], expected, rtol=1e-12, atol=1e-15)
    way = [u * math.cos(psi) - v * math.sin(psi), u * math.sin(psi) + v * math.cos(psi), r]
    np.testing.assert_allclose(found[:3], way, rtol=1e-14)


def test_derivative_takes_columns_and_names() -> None:
    columns = np.stack([STATE, STATE + 0.01], axis=1)
    found = nw.derivative(DTC, columns)
    assert found.shape == (6, 2)
    np.testing.assert_allclose(found[:, 1], DTC.derivative(STATE + 0.01), rtol=1e-13)
    named = dict(zip(("x", "y", "psi", "u", "v", "r"), STATE, strict=True))
    np.testing.assert_array_equal(DTC.derivative(named), found[:, 0])
    assert KVLCC2.derivative({"u": 1.179}, rudder=0.2)[5] > 0 > KVLCC2.derivative({"u": 1.179}, rudder=-0.2)[5]


@pytest.mark.parametrize("bad", [[1.0, 2.0], 3.0, {"z": 1.0}, np.zeros((5, 2))], ids=["two", "one", "z", "five"])
def test_a_state_is_six_numbers(bad: object) -> None:
    with pytest.raises(nw.InputError, match=r"give these six|a state has no 'z'"):
        DTC.derivative(bad)


def test_an_unknown_actuator_is_refused() -> None:
    with pytest.raises(nw.InputError, match="no actuator of the model has this name"):
        DTC.derivative(STATE, rudder=0.1)
    with pytest.raises(nw.InputError, match="no actuator of the model has this name"):
        nw.jacobian(DTC, rudder=0.1)


@pytest.mark.parametrize("model", [DTC, KVLCC2], ids=["dtc", "kvlcc2"])
def test_jacobian_is_the_slope_of_the_derivative(model: nw.Model) -> None:
    names = ("x", "y", "psi", "u", "v", "r")
    steered = {"rudder": 0.05} if model is KVLCC2 else {}
    linear = nw.jacobian(model, **dict(zip(names, STATE, strict=True)), **steered)
    for column, shift in enumerate(1e-6 * np.eye(6)):
        slope = (model.derivative(STATE + shift, **steered) - model.derivative(STATE - shift, **steered)) / 2e-6
        np.testing.assert_allclose(linear.A[:, column], slope, rtol=1e-6, atol=1e-8)
    for column, name in enumerate(linear.inputs[1:3], start=1):
        slope = model.derivative(STATE, **steered, **{name: 1.0}) - model.derivative(STATE, **steered)
        np.testing.assert_allclose(linear.B[:, column], slope, rtol=1e-6, atol=1e-14)
    changed = model.coefficients[linear.coefficients[-1]] + np.array([1e-4, -1e-4])
    up, down = (model.with_coefficients(**{linear.coefficients[-1]: value}) for value in changed)
    slope = (up.derivative(STATE, **steered) - down.derivative(STATE, **steered)) / 2e-4
    np.testing.assert_allclose(linear.G[:, -1], slope, rtol=1e-5, atol=1e-12)


def test_poles_are_those_of_the_stability() -> None:
    poles = nw.jacobian(DTC, y=0.5, u=0.9).poles()
    known = nw.stability(DTC, y=0.5, u=0.9).eigenvalue.values.ravel()
    assert poles[0].real == pytest.approx(known[0].real)
    assert all(np.abs(poles - own).min() < 1e-9 for own in known)


def test_equations_in_latex_are_those_of_the_terms() -> None:
    text = DTC.latex(numbers=True, forces=["X"])
    line = text.splitlines()[1].removeprefix("X &= ")
    plain = line.replace(r"\dot{u}", "a").replace(r"\left|{u}\right|", "abs(u)")
    plain = plain.replace(r" \cdot 10^", "*10**").replace("{", "(").replace("}", ")").replace(" u", "*u")
    found = sympy.sympify(plain.replace(" a", "*a").replace(" abs", "*abs"))
    values = {"u": -0.7, "a": 0.03}
    expected = DTC.forces(u=-0.7, udot=0.03)["X"]
    assert float(found.subs(values)) == pytest.approx(expected, rel=1e-3)
    named = DTC.latex()
    begun = [line.partition(" &")[0] for line in named.splitlines() if " &= " in line]
    assert begun == ["X", "Y", "N", r"\delta_B"]
    assert all(term.symbol in named for term in DTC.terms.terms)
    with pytest.raises(nw.InputError, match="force = 'K' is unknown"):
        DTC.latex(forces=["K"])


def test_equations_of_a_difference_are_in_brackets() -> None:
    assert "(1 - t_P)" in KVLCC2.latex()
    assert "\\frac" in KVLCC2.latex(forces=["N"])


def test_equations_of_the_standard_method_fit_a_page() -> None:
    """Term by term, without a name of the code, each symbol that is used defined once."""
    lines = KVLCC2.latex().splitlines()[1:-1]
    assert max(map(len, lines)) < 260
    assert "_rate" not in KVLCC2.latex()
    assert r"m m" not in KVLCC2.latex()
    defined = [line.partition(" &=")[0] for line in lines if " &= " in line]
    assert len(defined) == len(set(defined))
    assert {"F_N", "u_R", "v_R", r"\beta_R", "u_P", "T", "U"} <= set(defined)


@pytest.mark.parametrize(
    ("body", "remedy"),
    [
        ("lambda v, sin_psi: math.sin(v)", "sin_psi and cos_psi"),
        ("lambda v: np.sin(v)", "sin_psi and cos_psi"),
        ("lambda v: math.sqrt(v)", r"x \*\* 0.5 for a root"),
        ("lambda v: v if v > 0 else 0.0", "instead of an if"),
        ("lambda v: max(v, 0.0)", r"maximum\(x, y\)"),
        ("lambda v: math.exp(v)", r"math.e \*\* x"),
    ],
    ids=["sine", "numpy", "root", "if", "max", "exp"],
)
def test_a_term_that_cannot_be_compiled_says_what_to_write(body: str, remedy: str) -> None:
    regressor = eval(body, {"math": math, "np": np})
    own = nw.Term("b_own", "b", regressor, nw.Dimension(mass=1))
    table = nw.PAPER.with_terms("own", sway=[own])
    model = nw.Model(DTC.configuration, table, {**DTC.coefficients, "b_own": 1.0})
    told = rf"term b_own: its regressor cannot be compiled \(.*\); write it with arithmetic, .*: .*{remedy}"
    with pytest.raises(nw.InputError, match=told):
        nw.simulate(model, 0.5)
    if "np." not in body:
        with pytest.raises(nw.InputError, match=told):
            nw.identify(short_twin(), table)


WRITTEN = {
    "abs": lambda v: -(math.e ** ((v + abs(v)) / 2)) * (v**2) ** 0.5,
    "maximum": lambda v: -maximum(v, 0.0),
    "choice": lambda v: -choice(v, v, 0.5 * v),
}


@pytest.mark.parametrize(
    "name", ["choice", *(pytest.param(name, marks=pytest.mark.whole) for name in ("abs", "maximum"))]
)
def test_what_the_sentence_says_can_be_written(name: str) -> None:
    """In every engine: fitted, sailed, in a fleet, differentiated, in LaTeX."""
    own = nw.Term("b_own", "b_{own}", WRITTEN[name], nw.Dimension(1, 0, -1))
    table = nw.PAPER.with_terms(f"own {name}", sway=[own])
    model = nw.Model(DTC.configuration, table, {**DTC.coefficients, "b_own": 50.0})
    voyage = nw.simulate(model, 0.5, psi=0.05)
    assert nw.ensemble(model, y=0.5, psi=0.05).time.item() == pytest.approx(voyage.outcome.time, abs=1e-9)
    assert voyage.outcome.time != nw.simulate(DTC, 0.5, psi=0.05).outcome.time
    shift = np.array([0, 0, 0, 0, 1e-6, 0])
    slope = (model.derivative(STATE + shift) - model.derivative(STATE - shift)) / 2e-6
    there = dict(zip(("x", "y", "psi", "u", "v", "r"), STATE, strict=True))
    np.testing.assert_allclose(nw.jacobian(model, **there).A[:, 4], slope, rtol=1e-6, atol=1e-8)
    assert "b_{own}" in model.latex()
    assert "b_own" in nw.identify(short_twin(), table).coefficients


SHOWN = {
    "model": DTC, "tests": short_twin(), "table": nw.PAPER, "ship": DTC.ship, "configuration": KVLCC2.configuration,
    "waterway": nw.straight_waterway(nw.Canal(100.0, 12.0), 5000.0),
    "term": nw.PAPER["b_v"], "form": nw.FORMS["keel_gap"],
    "constant": nw.ConstantRudder(0.1), "zigzag": nw.Zigzag(0.1, 0.2),
    "jacobian": nw.jacobian(DTC), "fit": nw.identify(short_twin()),
}  # fmt: skip


@pytest.mark.parametrize("name", SHOWN)
def test_everything_shows_itself_in_few_words(name: str) -> None:
    thing = SHOWN[name]
    assert len(repr(thing)) < 200
    assert "\n" not in repr(thing)
    assert " at 0x" not in repr(thing)
    page = thing._repr_html_()
    assert page.startswith("<p>")
    assert len(page) < 40_000


@pytest.mark.parametrize("name", sorted(name for name in nw.__all__ if callable(getattr(nw, name))))
def test_signatures_are_short(name: str) -> None:
    assert len(str(inspect.signature(getattr(nw, name)))) < 1200


@pytest.mark.parametrize(
    ("function", "name"),
    [(nw.identify, "balance"), (nw.identify, "accelerations"), (nw.simulate, "surge"),
     (nw.simulate, "contact"), (nw.squat, "gives"), (nw.nondimensional, "system")],
    ids=lambda value: value if isinstance(value, str) else value.__name__,
)  # fmt: skip
def test_choices_are_types(function, name: str) -> None:
    annotation = str(inspect.signature(function, eval_str=False).parameters[name].annotation)
    assert "Literal[" in annotation


def test_identify_reads_a_table(tmp_path) -> None:
    read = short_twin()
    known = SHOWN["fit"].coefficients
    frame = frame_of(read)
    frame.to_parquet(tmp_path / "t.parquet")
    for table in (frame, tmp_path / "t.parquet", str(tmp_path / "t.parquet")):
        assert nw.identify(table, ship=DTC.configuration).coefficients == known
    with pytest.raises(nw.InputError, match="has no ship of its own; give ship="):
        nw.identify(frame)
    with pytest.raises(nw.InputError, match="have a ship already"):
        nw.identify(read, ship=DTC.configuration)


def test_predictions_of_tests_without_forces() -> None:
    fit = SHOWN["fit"]
    bare = frame_of(short_twin()).drop(columns=["X", "Y", "N"])
    pd.testing.assert_frame_equal(fit.predict(bare), fit.predict(), check_exact=False)
    measured = frame_of(short_twin()).set_index(["test", "t"])[["X", "Y", "N"]]
    pd.testing.assert_frame_equal(measured - fit.predict(), fit.residuals)
    with pytest.raises(nw.InputError, match="'v' is missing"):
        fit.predict(bare.drop(columns="v"))


def test_a_report_of_one_fit(tmp_path) -> None:
    fit = SHOWN["fit"]
    fit.report(tmp_path / "a.html", "of the twin")
    page = (tmp_path / "a.html").read_text()
    assert "of the twin" in page
    assert "b_bank" in page


def test_a_report_compares_fits_of_one_ship(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two fits of one ship in one table of values; the title; fits of another ship are not compared."""
    fit, other, written = SHOWN["fit"], nw.identify(short_twin(1)), []
    monkeypatch.setattr(nw.report, "write_report", lambda *given: written.append(given))
    fit.report("a.html", "of the twin")
    assert written == [({"": fit}, "a.html", "of the twin")]
    elsewhere = SimpleNamespace(tests=SimpleNamespace(configuration=SimpleNamespace(ship="another")))
    table = fit_page._comparison({"elsewhere": elsewhere, "0.4 m": fit, "0.5 m": other})  # type: ignore[dict-item]
    assert table is not None
    assert table["labels"] == ["0.4 m", "0.5 m"]
    name, values, words = table["rows"][list(fit.coefficients).index("b_vv")]
    assert name == "b_vv"
    assert values == [with_error(own.coefficients["b_vv"], own.std["b_vv"]) for own in (fit, other)]
    assert values[0] != values[1]
    assert words == [own.verdicts["b_vv"].status.replace(" ", "-") for own in (fit, other)]
    assert fit_page._comparison({"elsewhere": elsewhere, "0.4 m": fit}) is None  # type: ignore[dict-item]


def test_a_level_of_confidence_that_is_the_own_one_is_taken() -> None:
    given = {"model": DTC, "y": [0.0], "u": [1.0]}
    with pytest.raises(nw.InputError, match="no terms of a rudder"):
        nw.safe_envelope(**given, confidence=0.95)
    with pytest.raises(nw.InputError, match=r"has no argument 'confidence'; write .*95 % probability"):
        nw.safe_envelope(**given, confidence=0.9)


def test_the_kind_of_an_export_may_come_first(tmp_path) -> None:
    nw.export.write(DTC, "c", str(tmp_path / "ship.h"))
    assert (tmp_path / "ship.h").read_text() == nw.export.to_language(DTC, "c")


def test_a_probability_is_a_share_of_the_samples() -> None:
    fleet = nw.ensemble(DTC, y=[0.0, 2.0], u=1.0, psi=[0.0, 0.3], duration=5.0)
    grounded = fleet.grounded.values
    assert 0 < grounded.mean() < 1
    assert float(fleet.probability()) == grounded.mean()
    assert float(fleet.probability("afloat")) == 1 - grounded.mean()
    certain = replace(DTC, covariance=np.zeros((len(DTC.terms), len(DTC.terms))))
    drawn = nw.ensemble(certain, y=[0.0, 2.0], psi=0.3, u=1.0, duration=5.0, samples=3, seed=1)
    np.testing.assert_array_equal(drawn.probability(), [0.0, 1.0])


def test_tests_are_a_collection_and_a_table() -> None:
    tests = short_twin()
    alone = list(tests)
    assert [part.names for part in alone] == [(name,) for name in tests.names]
    assert sum(part.rows for part in alone) == tests.rows
    np.testing.assert_array_equal(tests["yaw"]["y"], tests.test("yaw")["y"])
    assert tests.query("test == 'yaw'").names == ("yaw",)
    assert tests.query("psi_deg > 1").rows == (np.degrees(tests["psi"]) > 1).sum() > 0
    pd.testing.assert_frame_equal(tests.to_dataframe(), frame_of(tests))
    again = nw.read_captive(tests.to_dataframe(), tests.configuration)
    assert all((again[name] == tests[name]).all() for name in tests.columns)
    late = tests[tests["t"] > 20]
    assert late.names == tuple(name for name in tests.names if tests.test(name)["t"].max() > 20)
    for wrong, told in ((["a"], "True or False"), (tests["y"] > 99, "no row is left"), ("yy", "no column and no test")):
        with pytest.raises(nw.InputError, match=told):
            tests[wrong]
    with pytest.raises(nw.InputError, match="cannot select rows where 'q > 1'"):
        tests.query("q > 1")


def test_tests_of_several_tables_are_put_together() -> None:
    first, second = (short_twin(seed) for seed in (0, 1))
    rows = [first.to_dataframe(), second.to_dataframe().assign(test=lambda frame: frame["test"] + " again")]
    both = nw.read_captive(pd.concat(rows), first.configuration)
    assert both.names == (*first.names, *(f"{name} again" for name in first.names))
    assert nw.identify(both).std["b_v"] < 1.1 * SHOWN["fit"].std["b_v"]


@pytest.mark.parametrize(
    ("canal", "words"),
    [(nw.Canal(12345.6, 24.123), "a canal 12346 m wide, 24.12 m deep"),
     (nw.Canal(0.5), "a canal 0.5 m wide, of unknown depth")],
)  # fmt: skip
def test_a_wide_canal_has_no_power_of_ten_in_its_words(canal: nw.Canal, words: str) -> None:
    assert canal.in_words == words
