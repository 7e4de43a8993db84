"""Runs of filters and their bank by tables: a counting filter stands for the ship's, and no ship is sailed."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest

import narrows as nw
from narrows.estimation import Gnss, Gyro, Log, filter_run
from narrows.estimation.estimator import checked_readings, records_of, rows_of
from narrows.estimation.filter_run import (
    FaultBank,
    FilterRun,
    Hypothesis,
    Moment,
    Start,
    _likelihood,
    _most_likely,
    _penalty_of_faults,
    _sentence,
    _still_refused,
    replay,
)
from narrows.estimation.ship_filter import MotionStep, UpdateResult
from narrows.estimation.states import Gaussian, StateNames

ALL: frozenset[str] = frozenset()


def result(t: float, log_likelihood: float = 0.0, drift: float = 0.0, **told: Any) -> UpdateResult:
    nis = told.get("nis", {"a": 1.0})
    odd = told.get("refused", ()), told.get("suspects", ()), told.get("surprising", ())
    return UpdateResult(t, nis, *odd, log_likelihood, drift)


class Counting:
    """Its state: the time that it moved, the integral of the rudder, the sum of its readings, faded by e a second."""

    sensors: ClassVar = {"a": SimpleNamespace(delay=0.0), "b": SimpleNamespace(delay=1.5)}
    wall = math.inf
    time_scale, actuators, states = 1.0, (), StateNames(("time", "turned", "told"))

    def with_faults(self, faults: frozenset[str]) -> "Counting":
        return self

    def adopt(self, now: Gaussian, other: Any) -> Gaussian:
        return now

    def monitor(self) -> np.ndarray:
        return np.zeros(2)

    def advance(self, now: Gaussian, duration: float, start: np.ndarray, end: np.ndarray) -> list[MotionStep]:
        moved = now.mean * [1.0, 1.0, math.exp(-duration)] + [duration, duration * (start[0] + end[0]) / 2, 0.0]
        return [MotionStep(now, Gaussian(moved, now.root), now.root, bool(moved[0] > self.wall))]

    def update(self, t: float, now: Gaussian, readings: Any, monitor: np.ndarray) -> tuple[Gaussian, UpdateResult]:
        monitor += 1.0
        told = sum(sum(reading) for reading in readings.values())
        return Gaussian(now.mean + np.array([0.0, 0.0, told]), now.root), result(t, nis=dict.fromkeys(readings, told))


def run(horizon: float = 1.5, kept: float = 4.0, left_out: frozenset[str] = ALL, filter: Any = None) -> FilterRun:
    first = Moment(0.0, Gaussian(np.zeros(3), np.eye(3)), np.zeros(1), {}, np.zeros(2))
    return FilterRun(filter or Counting(), [first], horizon, kept, left_out)


def sail(one: FilterRun, until: int = 6) -> list[str]:
    """Each second a reading of a, 1, and one of b, 10, that is 1.5 s late; the rudder goes with the square of t."""
    notes: list[str] = []
    for t in range(1, until + 1):
        assert one.update(float(t), {"a": (1.0,), "b": (10.0,)}, np.array([float(t**2)]), notes)
    return notes


def test_late_readings_are_used_at_their_times_and_later_ones_again() -> None:
    one = run()
    notes = sail(one)
    assert notes == ["The readings of b are of t = -0.5 s, before anything that is kept: not used."]
    # By hand: a at 1 to 6 s, b at 0.5 to 4.5 s, each faded until 6 s; the rudder is linear between its positions.
    told = sum(math.exp(t - 6) for t in range(1, 7)) + 10 * sum(math.exp(t - 5.5) for t in range(5))
    turned = sum((t**2 + (t + 1) ** 2) / 2 for t in range(6))
    np.testing.assert_allclose(one.last.state.mean, [6.0, turned, told])
    # From the last moment at or before 6 - 4 s on.
    assert [moment.t for moment in one.history] == [2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0]
    between = [moment.positions[0] for moment in one.history[:6]]
    np.testing.assert_allclose(between, [4.0, 6.5, 9.0, 12.5, 16.0, 20.5])
    assert [set(moment.readings) for moment in one.history] == [{"a"}, {"b"}] * 3 + [{"a"}] * 2
    assert [found.t for found in one.results] == [4.5, 6.0]  # those of the call alone, not of what was repeated
    assert one.begun == 0.0
    # The sums of the monitor are those of the readings until then, also of those that came later.
    assert [moment.monitor[0] for moment in one.history][-3:] == [9.0, 10.0, 11.0]


def test_readings_of_one_time_are_one_moment() -> None:
    one = run(horizon=2.0)
    notes: list[str] = []
    one.update(2.0, {"a": (1.0,)}, np.zeros(1), notes)
    one.update(3.5, {"b": (10.0,)}, np.zeros(1), notes)
    assert [(moment.t, moment.readings) for moment in one.history[1:]] == [
        (2.0, {"a": (1.0,), "b": (10.0,)}), (3.5, {}),
    ]  # fmt: skip
    assert one.last.state.mean[2] == pytest.approx(11.0 * math.exp(-1.5))
    one.update(4.0, {"b": (10.0,)}, np.zeros(1), notes)
    assert notes == []
    one.horizon = 1.0
    one.update(5.0, {"b": (10.0,)}, np.zeros(1), notes)
    assert notes == ["The readings of b are of t = 3.5 s, before anything that is kept: not used."]
    assert one.update(4.5, {"a": (1.0,)}, np.zeros(1), notes)  # a clock that went back: late by half a second
    assert one.last.t == 5.0


def test_sensors_that_are_left_out_are_kept_and_not_used() -> None:
    without, alone = run(left_out=frozenset({"b"})), run(left_out=frozenset({"a", "b"}))
    sail(without)
    sail(alone)
    assert without.last.state.mean[2] == pytest.approx(sum(math.exp(t - 6) for t in range(1, 7)))
    assert alone.last.state.mean[2] == 0.0
    assert alone.results == []
    assert [set(moment.readings) for moment in without.history] == [{"a"}, {"b"}] * 3 + [{"a"}] * 2
    # Later the same moments are repeated by another filter that uses them.
    again = replay(Counting(), without.history[0], without.history[1:], 1.5, 4.0)
    usual = run()
    sail(usual)
    told = usual.last.state.mean[2] - usual.history[0].state.mean[2] * math.exp(-4.0)
    first = without.history[0].state.mean[2] * math.exp(-4.0)
    assert again.last.state.mean[2] == pytest.approx(told + first)
    assert [moment.t for moment in again.history] == [moment.t for moment in usual.history]


def test_a_run_into_the_bank_ends() -> None:
    filter = Counting()
    filter.wall = 3.2
    one = run(filter=filter)
    notes: list[str] = []
    assert all(one.update(float(t), {"a": (1.0,)}, np.zeros(1), notes) for t in (1, 2, 3))
    assert not one.update(4.0, {"a": (1.0,)}, np.zeros(1), notes)
    assert replay(filter, one.history[0], [one.last._replace(t=9.0)], 1.0, 1.0) is None


@pytest.mark.parametrize("place", [0, 3])
def test_a_switch_of_the_bank_keeps_each_moment_once(place: int) -> None:
    """From its onset on b is left out; a restart begins at its onset, and what came before is forgotten."""
    one = run()
    sail(one)
    filter: Any = one.filter
    onset, times = one.history[place], [moment.t for moment in one.history]
    best = Hypothesis(frozenset({"b"}), FilterRun(filter, one.history[place:], 1.5, 4.0), 0.0)
    made = FaultBank(filter)
    after, said = made._switched_to(one, best, 6.0)
    assert ([moment.t for moment in after.history], after.begun) == (times, 0.0)
    # By hand: the sum at the onset and a at each whole second after it, faded until 6 s.
    since = [onset.state.mean[2] * math.exp(onset.t - 6)] + [math.exp(t - 6) for t in range(1, 7) if t > onset.t]
    assert after.last.state.mean[2] == pytest.approx(sum(since))
    assert made.faults == after.left_out == frozenset({"b"})
    assert "b contradicts the others" in said
    anew, _ = FaultBank(filter)._switched_to(one, best._replace(is_restart=True), 6.0)
    assert ([moment.t for moment in anew.history], anew.begun) == (times[place:], onset.t)


# Readings and starts

TOLD = {"gnss": Gnss(), "gyro": Gyro()}


def test_readings_are_split_and_what_is_none_is_left_out() -> None:
    measured, positions, notes = checked_readings(
        {"gnss": [1, 2.0], "gyro": np.float64(0.1), "rudder": (0.2,)}, TOLD, ("rudder", "revolutions")
    )
    assert (measured, positions, notes) == ({"gnss": (1.0, 2.0), "gyro": (0.1,)}, {"rudder": 0.2}, [])
    measured, positions, notes = checked_readings(
        {"gnss": (1.0, math.inf), "gyro": None, "rudder": math.nan}, TOLD, ("rudder",)
    )
    assert (measured, positions) == ({}, {})
    assert notes == ["The reading of gnss and gyro and rudder is not a number and was not used."]
    for wrong in ({"gnss": (1.0,)}, {"gnss": 1.0}, {"gyro": (1.0, 2.0)}, {"rudder": ()}, {"log": 1.0}):
        with pytest.raises(nw.InputError):
            checked_readings(wrong, TOLD, ("rudder",))


def test_rows_of_records_hold_whole_readings() -> None:
    table = {
        "t": [0.0, 1.0, 2.5],
        "gnss_x": [1.0, 2.0, 3.0],
        "gnss_y": [4.0, math.nan, 6.0],
        "rudder": [0.1, 0.2, math.nan],
    }
    records = records_of(table, TOLD, ("rudder",))
    assert list(records.columns) == ["gnss_x", "gnss_y", "gyro", "rudder"]
    assert list(rows_of(records, TOLD, ("rudder",))) == [
        (0.0, {"gnss": (1.0, 4.0), "rudder": (0.1,)}), (1.0, {"rudder": (0.2,)}), (2.5, {"gnss": (3.0, 6.0)}),
    ]  # fmt: skip
    for wrong in ([], [0.0, 0.0], [0.0, math.nan]):
        with pytest.raises(nw.InputError, match="finite and rise"):
            records_of({"t": wrong, "gyro": [0.0] * len(wrong)}, TOLD, ())


def test_a_start_takes_the_better_sensor_and_its_error_apart() -> None:
    """Medians of the last three readings; a bias as large as the noise makes an entry of its own in the root."""
    sensors = {"log": Log(0.1), "doppler": Log(0.03, name="doppler", bias=0.04), "gyro": Gyro(0.002)}
    start = Start(SimpleNamespace(sensors=sensors, faults=ALL))
    for t, speed in ((0.0, 9.0), (1.0, 4.0), (2.0, 5.0), (3.0, 14.0)):
        start.add(t, {"log": (speed,), "doppler": (speed + 1.0,), "gyro": ({2.0: 6.2, 3.0: 6.15}.get(t, -0.1),)})
    known = start.values()
    assert known["u"] == (pytest.approx(6.0), {"u": 0.03, "doppler_bias": pytest.approx(-0.04)})
    # Headings alone are compared across a whole turn: 6.2 rad is -0.083, 6.15 is -0.133.
    assert known["psi"][0] == pytest.approx(2 * math.pi - 0.1)
    assert [t for t, _ in start.readings["log"]] == [1.0, 2.0, 3.0]
    assert start.missing == "a place"
    # With a bias of 0.1 the doppler log is the worse one.
    worse = replace(sensors["doppler"], bias=0.1)
    other = replace(start, filter=SimpleNamespace(sensors={**sensors, "doppler": worse}, faults=ALL))
    assert other.values()["u"] == (pytest.approx(5.0), {"u": 0.1})
    few = Start(start.filter)
    few.add(0.0, {"gyro": (0.1,)})
    few.add(1.0, {"gyro": (0.1,)})
    assert few.values() == {}
    assert few.missing == "a place and a heading and a speed through the water"


# The bank of filters, of a ship for which times are twice those of the reference ship

SENSORS = {"a": SimpleNamespace(delay=0.0, period=0.5, fields=("a",), sigma=(0.1,)),
           "b": SimpleNamespace(delay=7.0, period=2.0, fields=("b_x", "b_y"), sigma=(0.1, 0.2))}  # fmt: skip


def bank(**told: Any) -> FaultBank:
    filter: Any = SimpleNamespace(sensors=SENSORS, time_scale=2.0, actuators=("rudder",))
    return FaultBank(filter, **told)


def moments(*times: float) -> list[Moment]:
    return [Moment(t, Gaussian(np.zeros(1), np.eye(1)), np.zeros(1), {}, np.zeros(1)) for t in times]


def seen(*results: UpdateResult, history: Any = (0.0, 1000.0), begun: float = 0.0) -> Any:
    past = moments(*history)
    return SimpleNamespace(results=list(results), history=past, last=past[-1], begun=begun, filter="filter")


def test_times_of_the_bank_follow_the_ship() -> None:
    made = bank()
    assert (made.horizon, made.wait, made.window, made.kept) == (7.0, 10.0, 120.0, 120.0)
    assert made._suspects == ["a", "b", "rudder", "model"]


def test_a_sensor_refused_for_five_of_its_periods_starts_the_bank() -> None:
    """Periods of 0.5 s: refused from 1 s and again from 3 s on, it has been so for 2.5 s at 5.5 s."""
    made = bank()
    told = {1.0: True, 2.0: True, 2.5: False, 3.0: True, 5.4: True, 5.5: True}
    found = [made._refusing(seen(result(t, refused=("a",) if odd else ())), t) for t, odd in told.items()]
    assert found == [False] * 5 + [True]
    assert not made._refusing(seen(), 5.5 - 1e-9)
    assert made._refusing(seen(), 6.0)
    slow = bank()
    assert not slow._refusing(seen(result(0.0, surprising=("b",), nis={"b": 9.0})), 0.0)
    assert [slow._refusing(seen(), t) for t in (9.9, 10.0)] == [False, True]
    assert not bank()._refusing(seen(), 0.0)


def test_a_lean_is_looked_at_again_after_a_wait() -> None:
    """Over 3.5 deviations: 10 s later; over 5: at once; not while a fault is known."""
    made = bank()
    leans = {0.0: 3.6, 4.0: 0.0, 9.9: 4.9, 10.0: 0.0, 11.0: 3.4, 22.0: 3.4, 23.0: 5.1, 24.0: 4.9, 33.0: 0.0, 45.0: 0.0}
    found = [made._drifting(seen(result(t, drift=0.0), result(t, drift=lean)), t) for t, lean in leans.items()]
    assert found == [False, False, False, True, False, False, True, False, True, False]
    known = bank(faults=frozenset({"a"}))
    assert not any(known._drifting(seen(result(t, drift=4.9)), t) for t in (0.0, 20.0))
    assert not made._drifting(seen(), 60.0)


def test_twenty_equal_readings_are_stuck_and_one_other_frees_them() -> None:
    made = bank()
    assert [made._stuck({"a": (1.0,), "b": (float(k), 0.0)}) for k in range(20)] == [ALL] * 19 + [frozenset({"a"})]
    assert made._stuck({}) == frozenset({"a"})
    assert made._stuck({"a": (2.0,)}) == ALL
    assert [made._stuck({"a": (2.0,)}) for _ in range(19)][-2:] == [ALL, frozenset({"a"})]


def test_sums_and_sentences_of_hypotheses() -> None:
    own = seen(result(1.0, -2.0), result(2.0, -3.0), result(3.0, -5.0))
    assert (_likelihood(own), _likelihood(own, 1.0), _likelihood(own, 2.5)) == (-10.0, -8.0, -5.0)
    # A first fault costs log 50, a second one beside it twice that, one that is known nothing.
    a, both = frozenset({"a"}), frozenset({"a", "b"})
    price = math.log(50.0)
    found = [_penalty_of_faults(*faults) for faults in ((ALL,), (a,), (both,), (both, a), (both, both))]
    np.testing.assert_allclose(found, [0.0, price, 4 * price, 2 * price, 0.0])
    low, high = (Hypothesis(ALL, own, score) for score in (-3.0, -1.0))
    assert _most_likely([None, low, high]) is high
    assert _most_likely([None]) is None
    assert _sentence(2.5, a, a, False) == ""
    assert _sentence(2.5, ALL, both, False) == (
        "At t = 2.5 s a and b contradicts the others: left out, and the estimate is less certain."
    )
    assert _sentence(2.0, a, ALL, True).count(";") == 1
    five = [result(float(t), refused=("a",), nis={"a": 9.0, "b": 1.0}) for t in range(5)]
    assert _still_refused(seen(*five))
    assert _still_refused(seen(result(0.0), *five))  # the last five count
    assert not _still_refused(seen(*five[:4], result(4.0), *five[:4]))
    assert not _still_refused(seen(*five, result(6.0)))
    assert _still_refused(seen(*[result(float(t), surprising=("a",)) for t in range(2)]))
    assert not _still_refused(seen())


@pytest.mark.parametrize(("errors", "small"), [((0.19, 0.39), True), ((0.21, 0.0), False), ((0.0, -0.41), False)])
def test_an_error_is_small_within_two_deviations_of_the_noise(errors: tuple[float, float], small: bool) -> None:
    names = StateNames(("x", "b_x_fault", "b_y_fault"))
    last = SimpleNamespace(state=Gaussian(np.array([9.0, *errors]), np.eye(3)))
    own: Any = SimpleNamespace(filter=SimpleNamespace(states=names), last=last)
    assert bank()._small(own, "b") is small
    assert bank()._small(own, "model")


def scored(made: FaultBank, monkeypatch: Any, base: Any) -> list[dict[str, Any]]:
    calls: list[dict[str, Any]] = []

    def record(faults: Any, before: Any, past: Any, known: Any, cost: float = 0.0, size: float = 1.0) -> Any:
        own = {"faults": faults, "before": before, "past": past, "known": known, "cost": cost, "size": size}
        calls.append(own)
        return Hypothesis(faults, base, -50.0 - cost)

    monkeypatch.setattr(made, "_scored", record)
    return calls


def test_hypotheses_are_drifts_of_three_ages_and_a_step() -> None:
    """At 1000 s: 120, 60 and 30 s ago, from the last moment before; a step as long ago as two runs of the bank."""
    past = (0.0, 870.0, 890.0, 930.0, 950.0, 969.0, 971.0, 985.0, 991.0, 1000.0)
    now = seen(history=past)
    base = seen(result(880.0, -7.0), result(960.0, -11.0), result(990.0, -13.0), history=past)
    base.filter = "that of the base"
    with pytest.MonkeyPatch.context() as monkeypatch:
        made = bank()
        calls = scored(made, monkeypatch, base)
        best = made._best_hypothesis(now, ["a", "model"], False, frozenset({"rudder"}))
    assert best is not None
    assert best.faults == ALL
    first, *others = calls
    assert (first["faults"], first["before"], first["cost"], first["size"]) == (ALL, "filter", 0.0, 1.0)
    assert [call["faults"] for call in others] == [frozenset({"a"})] * 4 + [frozenset({"model"})] * 4
    assert {call["known"] for call in calls} == {frozenset({"rudder"})}
    # The readings before count by the base: -7 before 930 s, -18 before 969 s; one of four onsets is right.
    assert [call["past"][0].t for call in others[:4]] == [870.0, 930.0, 969.0, 985.0]
    np.testing.assert_allclose([call["cost"] for call in others[:4]], math.log(4.0) + np.array([0.0, 7.0, 18.0, 18.0]))
    assert [call["size"] for call in others[:4]] == [0.02, 0.02, 0.02, 0.1]
    assert {call["before"] for call in others} == {"that of the base"}
    with pytest.MonkeyPatch.context() as monkeypatch:  # refused since 952 s: a step then, of any size
        made = bank(_refused={"a": 955.0, "b": 952.0})
        calls = scored(made, monkeypatch, base)
        made._best_hypothesis(now, ["a"], True, ALL)
    assert (calls[-1]["past"][0].t, calls[-1]["size"]) == (950.0, 1.0)


@pytest.mark.parametrize(
    ("since", "small", "cost"),
    # Two components that may err by 100 deviations each; after 300 s of the reference ship, here 600 s, no price.
    [(401.0, False, math.log(50.0) + 2 * math.log(100.0)), (399.0, False, 0.0), (401.0, True, 0.0)],
)
def test_a_sensor_comes_back_for_a_price_until_its_fault_is_old_or_small(
    since: float, small: bool, cost: float, monkeypatch: Any
) -> None:
    made = bank(faults=frozenset({"b"}), _since={"b": since})
    calls = scored(made, monkeypatch, seen(result(1.0, -7.0)))
    monkeypatch.setattr(made, "_small", lambda run, name: small)
    made._best_hypothesis(seen(), ["b"], False, ALL)
    assert [call["faults"] for call in calls] == [frozenset({"b"}), ALL]
    assert calls[1]["cost"] == pytest.approx(cost)
    assert calls[1]["known"] == frozenset({"b"})
    calls.clear()
    made._best_hypothesis(seen(), ["b"], False, frozenset({"b"}))  # one that is stuck does not come back
    assert len(calls) == 1


# At 1000 s, an estimate begun at so many seconds; what the bank finds, and what comes of it.
DECISIONS: dict[str, tuple[dict[str, Any], str]] = {
    "nothing is odd": ({"lean": 0.0}, "as it was"),
    "a lean": ({}, "the best"),
    "the same faults": ({"best": (ALL, 0.0)}, "as it was"),
    "too soon after the last": ({"next": 1000.1}, "as it was"),
    "too soon after the start": ({"begun": 980.1}, "as it was"),
    "a young estimate may restart": ({"begun": 890.0, "restart": -1.9}, "the restart"),
    "an old one does not": ({"restart": 9.0}, "the best"),
    "none is possible": ({"best": None, "restart": -99.0}, "the restart"),
    "none and no restart": ({"best": None}, "as it was"),
    "a restart that explains less": ({"begun": 890.0, "restart": -2.1 - math.log(50.0)}, "the best"),
    "refused until the end": ({"refused": True, "restart": 2.1}, "the restart"),
    "by less than its price": ({"refused": True, "restart": -2.1}, "the best"),
}


@pytest.mark.parametrize("case", DECISIONS)
def test_the_bank_decides_as_a_table_says(case: str, monkeypatch: Any) -> None:
    told, outcome = DECISIONS[case]
    made = bank(t=0.0)
    made._next = told.get("next", 1000.0)
    lean = result(1000.0, drift=told.get("lean", 5.1), refused=("a",) if told.get("refused") else ())
    now = seen(lean, begun=told.get("begun", 880.0))
    made._refused = {"a": 10.0} if told.get("refused") else {}
    faults, score = told.get("best", (frozenset({"b"}), 3.0)) or (None, None)
    # The best explains the readings after the restart by 2 + log 50, less the price of its fault.
    explained = seen(result(999.0, -2.0 + math.log(50.0), refused=("a",) if told.get("refused") else ()))
    best = None if faults is None else Hypothesis(faults, explained, score)
    restart = Hypothesis(ALL, seen(begun=990.0), told["restart"], True) if "restart" in told else None
    monkeypatch.setattr(made, "_best_hypothesis", lambda *asked: best)
    monkeypatch.setattr(made, "_restart_hypothesis", lambda asked: restart)
    monkeypatch.setattr(made, "_switched_to", lambda asked, chosen, t: (chosen, f"switched at {t:g}"))
    chosen, said = made.test_hypotheses(now, {})
    assert chosen is {"as it was": now, "the best": best, "the restart": restart}[outcome]
    assert said == ("" if outcome == "as it was" else "switched at 1000")
    if outcome != "as it was" or case in ("the same faults", "none and no restart"):
        assert (made._next, made._routine) == (1010.0, 1120.0)


def test_a_stuck_or_faulty_sensor_is_judged_once_in_a_window(monkeypatch: Any) -> None:
    made, asked = bank(), []
    monkeypatch.setattr(
        made, "_best_hypothesis", lambda run, suspects, refusing, stuck: asked.append((suspects, stuck))
    )
    monkeypatch.setattr(made, "_restart_hypothesis", lambda run: None)
    for k in range(150):
        made.test_hypotheses(seen(history=(float(k),)), {"a": (1.0,), "b": (float(k), 0.0)})
    # From the 20th equal reading on, but not within 20 s of the start, and again 120 s later.
    assert asked == [(["a"], frozenset({"a"}))] * 2
    assert made._next == 150.0
    assert filter_run.settings.REPLAY_TIME * 2.0 == made.window
