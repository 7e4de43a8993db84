"""What a function does, written down: the same again to the bit, nothing but what it does, nothing but arithmetic."""

import math
from dataclasses import replace

import numpy as np
import pytest

import narrows as nw
from engine_models import TABLES, model_of
from narrows.codegen.trace import Notes, Trace, trace_of, trace_of_terms
from narrows.quantities import names as dim
from narrows.quantities.arithmetic import angle, choice, clip, maximum, minimum

FLOATS = {
    "minimum": min, "maximum": max, "choice": lambda test, over, under: over if test > 0 else under,
    "angle": lambda cosine, sine: math.atan2(sine, cosine),
}  # fmt: skip


def test_a_replayed_tape_is_the_terms_to_the_bit() -> None:
    for table in TABLES.values():
        model = model_of(table)
        inputs = {**model.configuration.values(), **nw.Motion.at(0.3, y=1.1, u=0.9, v=0.1, r=-0.2, rdot=0.4).values()}
        found = trace_of_terms(table).replay(inputs)
        assert found == {term.name: term.column(inputs) for term in table.terms}


def test_tapes_name_what_is_done_and_nothing_else() -> None:
    renamed = replace(nw.PAPER, name="another name")
    assert trace_of_terms(renamed) == trace_of_terms(nw.PAPER)
    assert hash(trace_of_terms(renamed)) == hash(trace_of_terms(nw.PAPER))
    texts = {trace_of_terms(table).text for table in TABLES.values()}
    assert len(texts) == len(TABLES)


def test_what_is_done_twice_is_written_once() -> None:
    trace = trace_of(lambda at: {"a": at.v * at.u + 1, "b": (at.v * at.u + 1) * 2}, {"u": "u", "v": "v"}, "it")
    assert len(trace.lines) == len(set(trace.lines))
    assert sum(line[0] == "*" for line in trace.lines) == 2


def test_inputs_are_those_that_are_used() -> None:
    trace = trace_of(lambda at: {"out": at.v * 2, "same": at.r}, {"u": "u", "v": "speed", "r": "r"}, "it")
    assert set(trace.inputs) == {"speed", "r"}
    assert trace.replay({"speed": 3.0, "r": 1.5, "more": 9.0}) == {"out": 6.0, "same": 1.5}


def law(at) -> dict:
    order = minimum(maximum(at.a, -1), clip(at.b, 2.0))
    return {"out": choice(at.a - at.b, order, angle(at.a, at.b)) ** 2 - abs(at.b) / 3 + np.float64(0.25)}


@pytest.mark.parametrize(("a", "b"), [(0.3, -4.0), (-2.0, 1.0), (5.0, 3.0), (-1.0, -1.0)])
def test_functions_of_arithmetic_are_noted_too(a: float, b: float) -> None:
    trace = trace_of(law, {"a": "a", "b": "b"}, "it")
    order = min(max(a, -1), min(max(b, -2.0), 2.0))
    expected = (order if a > b else math.atan2(b, a)) ** 2 - abs(b) / 3 + 0.25
    assert trace.replay({"a": a, "b": b}, functions=FLOATS)["out"] == pytest.approx(expected, rel=1e-15)
    columns = trace.replay({"a": np.full(3, a), "b": np.full(3, b)})["out"]
    np.testing.assert_allclose(columns, expected, rtol=1e-14)


NOT_ARITHMETIC = [
    (lambda v: v if v > 0 else 0.0, "compares"),
    (lambda v: 1.0 if v else 0.0, "branches"),
    (lambda v: max(v, 0.0), "compares"),
    (lambda v: math.sin(v), "plain number"),
    (lambda v: np.sin(v), "ufunc"),
    (lambda v: v * np.ones(3), "ndarray"),
    (lambda v: v // 2, "rounds"),
    (lambda v: v * 1j, "complex"),
    (lambda v: v * float("inf"), "inf"),
    (lambda v: [v], "list"),
    (lambda v: 1 / 0, "division by zero"),
]


@pytest.mark.parametrize(("regressor", "deed"), NOT_ARITHMETIC)
def test_terms_that_are_not_arithmetic_are_refused(regressor, deed: str) -> None:
    table = nw.PAPER.with_terms("bad", sway=[nw.Term("b_bad", "b", regressor, dim.NUMBER)])
    with pytest.raises(nw.InputError, match=rf"term b_bad: .*{deed}.* write it with arithmetic, abs"):
        trace_of_terms(table)


@pytest.mark.parametrize(("function", "deed"), NOT_ARITHMETIC)
def test_functions_that_are_not_arithmetic_are_refused(function, deed: str) -> None:
    with pytest.raises(nw.InputError, match=rf"the law cannot be compiled \(.*{deed}.*\); write it with arithmetic"):
        trace_of(lambda at: {"rudder": function(at.v)}, {"v": "v"}, "the law")


def test_what_is_not_there_is_named_with_what_is() -> None:
    with pytest.raises(nw.InputError, match=r"the law needs an unknown quantity .*'w'.*known: u, v"):
        trace_of(lambda at: {"rudder": at.w}, {"u": "u", "v": "v"}, "the law")


def test_a_number_keeps_every_bit() -> None:
    notes = Notes()
    numbers = {"third": 1 / 3, "tiny": 5e-324, "whole": 7, "negative": -2}
    lines = {name: notes.of(value).line for name, value in numbers.items()}
    assert Trace(tuple(notes.lines), lines).replay({}) == numbers
