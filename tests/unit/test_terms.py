"""The table of terms, and a user's own term that goes through identification without a touch to the package."""

import numpy as np
import pytest

import narrows as nw
from narrows.quantities.names import REGRESSOR_INPUTS, argument_names
from tables import frame_of, many_runs, written


def turning_ahead(u, r):
    return -u * r


OWN = nw.PAPER.with_terms(
    "paper with u r",
    sway=[nw.Term("b_ur", "b_{ur}", turning_ahead, nw.Dimension(mass=1))],
    yaw=[nw.Term("c_ur", "c_{ur}", turning_ahead, nw.Dimension(mass=1, length=1))],
)


def truth_with_own_term(dtc: nw.Model) -> nw.Model:
    return nw.Model(dtc.configuration, OWN, {**dtc.coefficients, "b_ur": 150.0, "c_ur": -80.0})


def test_own_term_is_identified(dtc: nw.Model) -> None:
    tests = nw.twin(truth_with_own_term(dtc), many_runs(), rate=10.0)
    fit = nw.identify(tests, OWN, errors=nw.RunErrors(0, 0, 0))
    for name, value in (("b_ur", 150.0), ("c_ur", -80.0), ("b_bank", 1.07)):
        assert fit.coefficients[name] == pytest.approx(value, abs=5 * fit.std[name])
        assert fit.std[name] < 20
    summary = fit.to_dict()
    assert summary["coefficients"]["b_ur"]["unit"] == "kg"
    assert "b_ur" in summary["diagnostics"]["Y"]["vif"]
    assert "b_ur" in summary["shapley"]["Y"]


def test_own_term_says_which_columns_it_needs(dtc: nw.Model, tmp_path) -> None:
    frame = frame_of(nw.twin(dtc, many_runs(3), rate=2.0))
    sailing = nw.TermTable("r alone", (), (nw.PAPER["b_r"],), ())
    path = written(frame[["test", "t", "r", "Y"]], tmp_path / "t.csv")
    for read in (nw.read_captive, nw.stream_captive):
        tests = read(path, dtc.configuration)
        assert nw.identify(tests, sailing).scores.keys() == {"Y"}
        with pytest.raises(nw.InputError, match=r"t\.csv: column 'udot' is missing \(surge acceleration"):
            nw.identify(tests)


def test_own_term_may_ask_for_particulars_and_depth(dtc: nw.Model, short: nw.CaptiveTests) -> None:
    def shallow(v, draft, depth):
        return -v * (draft / depth) ** 0.5

    table = nw.PAPER.with_terms("shallow", sway=[nw.Term("b_v", "b_v", shallow, nw.Dimension(1, 0, -1))])
    with pytest.raises(nw.InputError, match="the terms need depth, which neither the tests nor the ship file give"):
        nw.identify(short, table)
    with pytest.raises(nw.InputError, match="need depth"):
        nw.Model(dtc.configuration, table, dtc.coefficients).forces(nw.Motion(v=1.0))
    deep = nw.Configuration(dtc.configuration.ship, nw.Canal(7.0, 0.652))
    known = nw.CaptiveTests(short.columns, short.names, short.starts, deep)
    assert nw.identify(known, table).least_squares["b_v"] == pytest.approx(
        2 * nw.identify(short).least_squares["b_v"], rel=1e-7
    )


def test_a_constant_and_a_lone_force_are_terms_too(short: nw.CaptiveTests) -> None:
    """An intercept is a term as any other; least squares of a constant is the mean."""

    def one(u):
        return 1.0

    table = nw.TermTable("mean", (nw.Term("a_0", "a_0", one, nw.Dimension(1, 1, -2)),), (), ())
    fit = nw.identify(short, table)
    means = [short.test(name)["X"].mean() for name in short.names]
    assert fit.least_squares["a_0"] == pytest.approx(np.mean(means), rel=1e-12)
    assert fit.scores["X"].r2 == pytest.approx(0.0, abs=1e-6)  # of the mixed model's mean


@pytest.mark.parametrize(
    ("word", "hint"),
    [("heav", "did you mean 'heave'"), ("speed", "known: "), ("psi", "'sin_psi'|'cos_psi'"), ("Udot", "'udot'")],
)
def test_unknown_word_is_refused_with_a_hint(word: str, hint: str) -> None:
    regressor = eval(f"lambda u, {word}: u * {word}")
    with pytest.raises(nw.InputError, match=rf"term b_x: .*unknown '{word}'.*({hint})"):
        nw.Term("b_x", "b_x", regressor, nw.Dimension())


def test_a_regressor_that_is_not_finite_is_refused(short: nw.CaptiveTests) -> None:
    def inverse(y):
        return 1 / (y - y)

    table = nw.PAPER.with_terms("inverse", sway=[nw.Term("b_inv", "b_inv", inverse, nw.Dimension())])
    with (
        pytest.raises(nw.InputError, match="column of b_inv is not finite in test slow yaw"),
        np.errstate(all="ignore"),
    ):
        nw.identify(short, table)


def test_what_asks_where_the_banks_are_is_of_the_bank() -> None:
    """Open water, the bank's share of a force and the notes rest on the kind: a term cannot slip past them."""

    def blockage(u, width):
        return -u * abs(u) / width

    with pytest.raises(nw.InputError, match=r"term a_b: it needs the canal's width; give it kind=TermKind\.BANK"):
        nw.Term("a_b", "a_b", blockage, nw.Dimension(1, 0))
    assert nw.Term("a_b", "a_b", blockage, nw.Dimension(1, 0), kind=nw.TermKind.BANK).from_bank


@pytest.mark.parametrize(
    "term", dict.fromkeys((*nw.CROSSFLOW.terms, *nw.MIXED.terms, *nw.MMG.terms)), ids=lambda t: t.name
)
def test_every_row_says_what_it_is_and_where_from(term: nw.Term) -> None:
    assert term.kind is not nw.TermKind.OTHER
    assert "(" in term.source
    inertial = {"udot", "vdot", "rdot"} & set(term.inputs)
    assert (term.kind is nw.TermKind.INERTIA) == bool(inertial or term.name in ("X_my", "Y_mx"))


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: nw.TermTable("t", nw.PAPER.surge, nw.PAPER.surge, ()), "two terms of table t are called 'a_udot'"),
        (lambda: nw.TermTable("t", nw.PAPER.surge, (), (), (("a_u", "a_x"),)), "a tie names 'a_x'"),
        (lambda: nw.TermTable("t", (), (), ()), "no terms"),
        (lambda: nw.TermTable("t", (nw.Term("X", "X", turning_ahead, nw.Dimension()),), (), ()), "'X' is a force"),
    ],
)
def test_tables_that_make_no_sense(make, word: str) -> None:
    with pytest.raises(nw.InputError, match=word):
        make()


def test_adding_keeps_and_replaces_by_name() -> None:
    assert OWN.names == (*nw.PAPER.names[:10], "b_ur", *nw.PAPER.names[10:], "c_ur")
    assert OWN.ties == nw.PAPER.ties
    assert nw.TAPERED.names == nw.PAPER.names
    assert nw.TAPERED["b_bank"].regressor is not nw.PAPER["b_bank"].regressor
    assert nw.TAPERED["b_v"] is nw.PAPER["b_v"]


def test_own_table_comes_back_from_a_model_file_only_with_itself(dtc: nw.Model, tmp_path) -> None:
    model = truth_with_own_term(dtc)
    nw.save_model(model, tmp_path / "own.toml")
    with pytest.raises(nw.InputError, match=r"load_model\(path, terms=...\)"):
        nw.load_model(tmp_path / "own.toml")
    motion = nw.Motion.at(psi=0.1, y=1.0, u=0.8, r=0.05)
    assert nw.load_model(tmp_path / "own.toml", OWN).forces(motion) == model.forces(motion)


@pytest.mark.parametrize("term", nw.PAPER.terms, ids=lambda term: term.name)
def test_inputs_are_the_arguments_and_of_the_vocabulary(term: nw.Term) -> None:
    assert term.inputs == argument_names(term.regressor)
    assert set(term.inputs) <= set(REGRESSOR_INPUTS)
    assert term.from_bank == term.name.endswith("bank")


@pytest.mark.parametrize(
    ("name", "unit"),
    [("a_udot", "kg"), ("a_u", "kg/s"), ("a_uu", "kg/m"), ("b_rdot", "kg m"), ("b_r", "kg m/s"), ("b_rr", "kg m"),
     ("b_bank", "1"), ("c_rdot", "kg m2"), ("c_v", "kg m/s"), ("c_r", "kg m2/s"), ("c_vv", "kg"), ("c_rr", "kg m2")],
)  # fmt: skip
def test_unit_in_words(name: str, unit: str) -> None:
    assert nw.PAPER[name].dimension.unit == unit
