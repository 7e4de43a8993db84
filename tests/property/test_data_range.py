"""What the data covered: one rule of membership, whoever asks."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import numbers

import narrows as nw
from narrows.model.data_range import ASTERN, MEASURES, DataRange, extrapolation
from narrows.simulation.outcome import measured, outside_notes

SLACK = 0.01  # share of the largest tested value that is no extrapolation: the rounding of printed tables

NAMES = [own.name for own in fields(DataRange)]
RANGES = st.tuples(numbers(0.0, 100.0), numbers(0.0, 100.0)).map(sorted).map(tuple)


def test_every_range_can_be_spoken_of() -> None:
    assert list(MEASURES) == NAMES


@pytest.mark.parametrize("name", NAMES)
@given(covered=RANGES, share=numbers(0.0, 1.0))
def test_what_lies_between_the_ends_is_inside(name: str, covered: tuple[float, float], share: float) -> None:
    low, high = covered
    known = DataRange(**{name: covered})
    assert extrapolation(known, {name: low + share * (high - low)}) == ()
    assert extrapolation(known, {name: np.array([low, high])}) == ()


@pytest.mark.parametrize("name", NAMES)
@given(covered=RANGES.filter(lambda pair: pair[1] > 1e-3), over=numbers(1e-6, 10.0), below=st.booleans())
def test_what_leaves_by_more_than_the_slack_is_said_once(
    name: str, covered: tuple[float, float], over: float, below: bool
) -> None:
    low, high = covered
    far = (low - high * (SLACK + over)) if below else high * (1 + SLACK + over)
    known = DataRange(**{name: covered})
    (sentence,) = extrapolation(known, {name: np.array([high, far])})
    measure = ASTERN if name == "speed" and far < 0 else MEASURES[name]
    assert sentence.startswith(f"Beyond the data: {measure.words} ")
    assert sentence.endswith(".")


@given(covered=RANGES, more=st.tuples(numbers(0.0, 1.0), numbers(0.0, 50.0)), asked=numbers(-20.0, 200.0))
def test_wider_data_never_leave_out_what_narrower_covered(
    covered: tuple[float, float], more: tuple[float, float], asked: float
) -> None:
    low, high = covered
    wider = DataRange(abs_y=(low * (1 - more[0]), high + more[1]))
    assert not (wider.outside("abs_y", asked) and not DataRange(abs_y=covered).outside("abs_y", asked))


def test_a_range_that_is_not_known_is_named_only_where_asked() -> None:
    assert extrapolation(DataRange(), {"speed": 1.0}) == ()
    (sentence,) = extrapolation(DataRange(), {"speed": 1.0}, unknown=True)
    assert sentence == "Not known whether tested: the model gives no range of surge velocity that its data covered."


def test_angles_are_spoken_of_in_degrees() -> None:
    (sentence,) = extrapolation(DataRange(abs_psi=(0.0, np.radians(10.0))), {"abs_psi": np.radians(20.0)})
    assert sentence == "Beyond the data: heading 20 deg; they covered 0 to 10 deg."


@given(speed=numbers(0.5, 1.5))
def test_a_voyage_the_envelope_and_a_table_agree(speed: float) -> None:
    known = DataRange(speed=(0.8, 1.0))
    still = np.zeros(2)
    seen = measured({"u": np.full(2, speed), "y": still, "psi": still, "r": still}, {}, False)
    voyage = list(outside_notes(known, [seen], lambda measure, covered, outside, values: measure.words))
    assert bool(voyage) == bool(extrapolation(known, {"speed": speed})) == bool(known.outside("speed", speed))


def test_an_envelope_asked_at_the_tests_own_speed_is_inside(dtc: nw.Model) -> None:
    from narrows.safety.result import beyond_tests

    known = replace(dtc, data_range=DataRange(speed=(0.4, 1.0), abs_y=(0.5, 0.9), width_to_beam=(7 / 0.572,) * 2))
    assert beyond_tests(known, np.array([-0.2, 0.9]), np.array([0.4, 1.0])) == ()
    said = beyond_tests(known, np.array([-1.2, 0.9]), np.array([0.4, 1.2]))
    assert said[0] == "Beyond the data: speed 0.778 to 2.33 knots; they covered 0.778 to 1.94 knots."
    assert [note.split()[3] for note in said] == ["speed", "offset"]
