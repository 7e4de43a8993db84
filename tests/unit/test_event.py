"""The rule that ends a voyage, on rooms that are plain functions of time, against their roots by brute force."""

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from narrows.codegen.kernels import event

TOLERANCE, NEAR = 1e-9, 1e-3
Room = Callable[[float], float]


def ended(
    room: Room, duration: float, dt: float, sane: Callable[[float, float], bool] = lambda t, tried: True,
    bound: Room | None = None,
) -> tuple[int, float, int]:  # fmt: skip
    """March as a voyage does; return what ended it, when, and how many tries it took.

    ``sane`` is asked for the end of a try and its length; ``bound`` is never over the room and asked first.
    """
    control = [0.0] * event.PLACES
    count = math.floor(duration / dt + 1e-9)
    rest = duration - count * dt
    event.begin_voyage(control, dt, float(count), rest if rest > 1e-9 * dt else 0.0)
    t, left, tries = 0.0, control[event.COUNT], 0
    while control[event.COUNT] > 0:
        tried, trying = control[event.NEXT], control[event.TRIES] > 0
        after, tries, left = t + tried, tries + 1, left - 1
        well = sane(after, tried)
        ahead = (bound or room)(after) if well else math.nan
        if bound and well and (ahead <= 0 or trying):
            ahead = room(after)
        if well and ahead > 0 and left > 0 and not trying:
            t = after
            continue
        outcome = event.accept_step(control, left, ahead, room(t), well, TOLERANCE, NEAR, 0.0)
        if outcome == event.LOST:
            return outcome, t, tries
        if outcome != event.BACK:
            t = after
            if trying or outcome != event.ON:
                assert control[event.CLOCK] == pytest.approx(t, rel=1e-12, abs=1e-12)
        if outcome in (event.CLOSED, event.FINISHED):
            return outcome, t, tries
        left = control[event.COUNT]
    return event.FINISHED, t, tries


SHAPES: dict[str, Callable[[float, float], Room]] = {
    "steady": lambda at, slope: lambda t: slope * (at - t),
    "faster and faster": lambda at, slope: lambda t: slope * (at**3 - t**3) / (3 * at**2),
    "slower and slower": lambda at, slope: lambda t: slope * (math.exp(-t) - math.exp(-at)) * math.exp(at),
    "bent": lambda at, slope: lambda t: slope * min(at - t, 3 * (at - t)),
    "steep at last": lambda at, slope: lambda t: slope * math.copysign(abs(at - t) ** 0.5, at - t),
}


@pytest.mark.parametrize("shape", SHAPES)
@given(at=st.floats(0.05, 19.9), slope=st.floats(0.05, 5.0), dt=st.sampled_from([0.02, 0.3, 1.7, 30.0]))
def test_a_bank_that_is_met_anywhere_in_a_step(shape: str, at: float, slope: float, dt: float) -> None:
    room = SHAPES[shape](at, slope)
    outcome, time, tries = ended(room, 20.0, dt)
    assert outcome == event.CLOSED
    assert abs(room(time)) <= TOLERANCE
    assert time == pytest.approx(brentq(room, 0.0, 20.0, xtol=1e-13), abs=2e-8)
    assert tries <= 20.0 / dt + event.MOST_TRIES


@given(at=st.floats(0.05, 19.9), power=st.floats(0.3, 0.9), dt=st.sampled_from([0.02, 0.3, 1.7]))
def test_a_suction_without_end_is_followed_to_the_bank(at: float, power: float, dt: float) -> None:
    """Beyond the bank there are no sane numbers: no secant, and the last sane place is as near as it can be."""

    def room(t: float) -> float:
        return max(at - t, 0.0) ** power

    outcome, time, _ = ended(room, 20.0, dt, sane=lambda t, tried: t < at)
    assert outcome in (event.CLOSED, event.LOST)
    assert room(time) <= NEAR
    assert time <= at


@given(first=st.floats(0.5, 8.0), length=st.floats(0.1, 5.0), dt=st.sampled_from([0.02, 0.3, 1.7]))
def test_a_false_alarm_does_not_end_a_voyage(first: float, length: float, dt: float) -> None:
    """The cheap lower bound is used up for a while, and the banks themselves are not."""

    def bound(t: float) -> float:
        return -1.0 if first < t < first + length else 0.5

    outcome, time, tries = ended(lambda t: 0.7, 20.0, dt, bound=bound)
    assert (outcome, time) == (event.FINISHED, pytest.approx(20.0, rel=1e-12))
    assert tries <= math.ceil(20.0 / dt + 1e-9) + length / dt + 4


@given(at=st.floats(6.1, 19.0), dt=st.sampled_from([0.02, 0.3, 1.7]))
def test_a_contact_after_a_false_alarm(at: float, dt: float) -> None:
    outcome, time, _ = ended(lambda t: at - t, 20.0, dt, bound=lambda t: at - t - (3.0 if t > 3 else 0.0))
    assert (outcome, time) == (event.CLOSED, pytest.approx(at, abs=1e-8))


@given(begin=st.floats(0.5, 8.0), share=st.floats(0.05, 0.9), dt=st.sampled_from([0.3, 1.7]))
def test_a_step_too_long_for_a_while_is_parted(begin: float, share: float, dt: float) -> None:
    """Numbers run away in long steps and not in short ones: the voyage goes on to its time."""

    def sane(t: float, tried: float) -> bool:
        return not (begin < t < begin + dt and tried > share * dt)

    outcome, time, _ = ended(lambda t: 1.0, 20.0, dt, sane=sane)
    assert (outcome, time) == (event.FINISHED, pytest.approx(20.0, rel=1e-12))


@given(at=st.floats(0.5, 19.0), dt=st.sampled_from([0.02, 0.3, 1.7]))
def test_numbers_that_run_away_far_from_a_bank_are_lost(at: float, dt: float) -> None:
    outcome, time, _ = ended(lambda t: 1.0, 20.0, dt, sane=lambda t, tried: t < at)
    assert outcome == event.LOST
    assert time <= at
    assert time == pytest.approx(at, abs=1e-6)


@given(duration=st.floats(0.001, 50.0), dt=st.floats(0.01, 60.0))
def test_time_is_up_exactly(duration: float, dt: float) -> None:
    outcome, time, tries = ended(lambda t: 1.0, duration, dt)
    assert outcome == event.FINISHED
    assert time == pytest.approx(duration, rel=1e-12)
    assert tries <= math.ceil(duration / dt + 1e-6)


def test_no_time_is_no_step() -> None:
    assert ended(lambda t: 1.0, 0.0, 0.1) == (event.FINISHED, 0.0, 0)


def test_a_room_that_closes_at_the_end_of_a_step_is_closed_there() -> None:
    for at in (0.3, 0.6, 2.7):
        outcome, time, _ = ended(lambda t, at=at: at - t, 3.0, 0.3)
        assert (outcome, time) == (event.CLOSED, pytest.approx(at, abs=2e-9))
