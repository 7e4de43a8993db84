"""Messages of a bridge as readings, by places drawn on the waterway and by times written out; a replay in order."""

import math
import time
from types import SimpleNamespace

import numpy as np
import pytest
from transit import canal

from narrows.readers.nmea import DecodedMessage, Entry
from narrows.warning.inputs.bridge_readings import BridgeReadings, Messages, Tick, by_second, in_order, paced
from narrows.waterway.map_lines import unprojected


def entry(t: float, source: str = "GPGGA gps", **values: dict[str, float]) -> Entry:
    return Entry(t, DecodedMessage({name.replace("_", " "): own for name, own in values.items()}, source))


def fix(s: float, n: float) -> dict[str, float]:
    """Longitude and latitude of a place on the waterway."""
    place, _ = canal().to_map(s, n, 0.0)
    longitude, latitude = unprojected(np.reshape(place, (1, 2)), np.array(canal().origin))[0]
    return {"longitude": float(longitude), "latitude": float(latitude)}


def heard(readings: BridgeReadings, t: float, *entries: Entry) -> Messages:
    return readings.convert(Tick(t, entries, {"garbled": 2}))


@pytest.mark.parametrize(
    ("s", "n"), [(-990.0, 0.0), (-1010.0, 0.0), (800.0, 1140.0), (800.0, 1160.0), (800.0, -1140.0), (800.0, -1160.0)]
)
def test_a_place_more_than_a_kilometre_beyond_banks_or_ends_is_none(s: float, n: float) -> None:
    """The canal is 300 m wide."""
    messages = heard(BridgeReadings(canal(), 8.0), 0.0, entry(0.0, position=fix(s, n)))
    if s > -1000.0 and abs(n) < 1150.0:
        assert messages.readings["gnss"] == pytest.approx((s, n), abs=0.01)
        assert messages.faults == {"garbled": 2}
    else:
        assert not messages.readings
        assert messages.faults == {"garbled": 2, "that give a place off the waterway": 1}


def test_a_place_beyond_the_far_end_counts_each_time() -> None:
    readings, length = BridgeReadings(canal(), 8.0), canal().line.length
    x, y = canal().to_map(length, 0.0, 0.0)[0]
    beyond = []
    for more in (900.0, 1100.0, 1200.0):
        heading = float(canal().to_map(length, 0.0, 0.0)[1])
        place = np.array([[x + more * math.sin(heading), y + more * math.cos(heading)]])
        longitude, latitude = unprojected(place, np.array(canal().origin))[0]
        where = {"longitude": float(longitude), "latitude": float(latitude)}
        messages = heard(readings, 0.0, entry(0.0, position=where))
        beyond.append(("gnss" in messages.readings, messages.faults.get("that give a place off the waterway", 0)))
    assert beyond == [(True, 0), (False, 1), (False, 2)]


def test_headings_count_from_the_line_once_a_place_is_known() -> None:
    readings, along = BridgeReadings(canal(), 8.0), float(canal().to_map(4500.0, 0.0, 0.0)[1])
    directions = {
        "heading": {"heading": along - 0.1 + 2 * math.pi},
        "speed_over_ground": {"course_over_ground": along + 0.2 - 2 * math.pi, "speed_over_ground": 4.0},
    }
    assert not {"gyro", "course"} & set(heard(readings, 0.0, entry(0.0, **directions)).readings)
    here = heard(readings, 1.0, entry(1.0, position=fix(4500.0, 3.0), **directions)).readings
    assert here["gyro"] == pytest.approx(-0.1, abs=1e-4)
    assert here["course"] == pytest.approx((0.2, 4.0), abs=1e-4)
    again = heard(readings, 2.0, entry(2.0, **directions)).readings
    assert again["gyro"] == pytest.approx(-0.1, abs=1e-4)
    alone = {"speed_over_ground": {"speed_over_ground": 4.0}}
    assert "course" not in heard(readings, 3.0, entry(3.0, **alone)).readings


def test_speed_over_ground_stands_for_a_log_that_was_never_heard_less_the_current() -> None:
    readings = BridgeReadings(canal().with_water(current=0.5), 8.0)
    over_ground = {"speed_over_ground": {"speed_over_ground": 4.0}}
    assert heard(readings, 0.0, entry(0.0, **over_ground)).readings == {"ground_log": 3.5}
    log = {"speed_through_the_water": {"u": 3.4}}
    assert heard(readings, 1.0, entry(1.0, **over_ground, **log)).readings == {"log": 3.4}
    assert heard(readings, 2.0, entry(2.0, **over_ground)).readings == {}


def test_rates_rudder_and_revolutions_have_the_names_of_sensors() -> None:
    told = {"yaw_rate": {"r": 0.01}, "rudder": {"rudder": -0.2}, "revolutions": {"revolutions": 1.5}}
    expected = {"rate_of_turn": 0.01, "rudder": -0.2, "revolutions": 1.5}
    assert heard(BridgeReadings(canal(), 8.0), 0.0, entry(0.0, **told)).readings == expected


def test_ages_count_from_the_last_message_or_from_the_first_second() -> None:
    readings = BridgeReadings(canal(), 8.0)
    first = heard(readings, 10.0, entry(9.4, heading={"heading": 0.1}), entry(9.2, heading={"heading": 0.2}))
    assert first.ages == pytest.approx({"heading": 0.6, "position": 0.0, "rudder": 0.0})
    assert first.t == 10.0
    later = heard(readings, 13.0, entry(12.5, heading={}))
    assert later.ages == pytest.approx({"heading": 3.6, "position": 3.0, "rudder": 3.0})


def test_water_under_the_keel_counts_with_the_draft_of_the_model() -> None:
    readings = BridgeReadings(canal(), 8.0)
    assert heard(readings, 1.0, entry(1.0, depth_of_water={"under_keel_clearance": 6.0})).depth == 14.0
    assert heard(readings, 2.0, entry(2.0, depth_of_water={"depth": 16.0})).depth == 16.0
    assert heard(readings, 3.0).depth is None


def test_the_better_sentence_is_taken_and_another_after_more_than_5_s_of_silence() -> None:
    """HDT before THS before what is unknown."""
    readings = BridgeReadings(canal(), 8.0)
    heard(readings, 0.0, entry(0.0, position=fix(800.0, 0.0)))
    said = [
        (0.0, "TITHS compass", 0.1, True), (1.0, "PLXXX plotter", 0.2, False), (2.0, "HEHDT gyro", 0.3, True),
        (7.0, "TITHS compass", 0.4, False), (7.1, "TITHS compass", 0.5, True), (8.0, "HETHS other", 0.6, False),
        (9.0, "HEHDT gyro", 0.7, True), (10.0, "HEHDT gyro", 0.8, True),
    ]  # fmt: skip
    along = float(canal().to_map(800.0, 0.0, 0.0)[1])
    for t, source, heading, taken in said:
        readings_now = heard(readings, t, entry(t, source, heading={"heading": along + heading})).readings
        assert readings_now == ({"gyro": pytest.approx(heading, abs=1e-4)} if taken else {}), (t, source)


def test_columns_of_one_second_are_joined_and_the_last_counts() -> None:
    told = heard(
        BridgeReadings(canal(), 8.0), 1.0, entry(0.2, rudder={"rudder": 0.1}), entry(0.8, rudder={"rudder": 0.3}),
        entry(0.9, yaw_rate={"r": 0.01}),
    )  # fmt: skip
    assert told.readings == {"rudder": 0.3, "rate_of_turn": 0.01}


def test_a_replay_is_in_order_where_lines_are_up_to_a_minute_late() -> None:
    """What comes twice counts once; what is later than what was given already is left out."""
    told = [
        entry(0.0, "a"), entry(70.0, "b"), entry(12.0, "c"), entry(12.0, "c"), entry(12.0, "a"), entry(75.0, "d"),
        entry(14.0, "too late"), entry(16.0, "e"), entry(135.0, "f"), entry(76.0, "g"),
    ]  # fmt: skip
    given = [(one.t, one.message.source) for one in in_order(told)]
    assert given == [
        (0.0, "a"), (12.0, "a"), (12.0, "c"), (14.0, "too late"), (16.0, "e"), (70.0, "b"), (75.0, "d"),
        (76.0, "g"), (135.0, "f"),
    ]  # fmt: skip
    late = [entry(100.0, "a"), entry(39.9, "b"), entry(110.0, "c"), entry(39.0, "d"), entry(45.0, "e")]
    assert [one.message.source for one in in_order(late)] == ["b", "e", "a", "c"]


def test_a_replay_gives_every_second_of_a_silence_up_to_two_minutes() -> None:
    def seconds(*times: float) -> list[tuple[float, int]]:
        return [(tick.t, len(tick.entries)) for tick in by_second([entry(t) for t in times])]

    assert seconds(0.4, 1.0, 1.5, 3.2) == [(1.0, 2), (2.0, 1), (3.0, 0), (4.0, 1)]
    assert seconds(0.5, 120.5) == [(1.0, 1), *((float(t), 0) for t in range(2, 121)), (121.0, 1)]
    assert seconds(0.5, 121.5) == [(1.0, 1), (122.0, 1)]
    assert seconds(2.5, 1.5) == [(3.0, 2)]
    assert seconds() == []


def test_a_replay_at_a_multiple_of_time_sleeps_for_the_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """At four times the pace a second takes 0.25 s, of which 0.1 s are spent by the monitor."""
    now, slept = [100.0], []

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        now[0] += seconds

    clock = SimpleNamespace(monotonic=lambda: now[0], sleep=sleep)
    monkeypatch.setattr("narrows.warning.inputs.bridge_readings.time", clock)
    for _ in paced([Tick(t, (), {}) for t in (50.0, 51.0, 52.0, 52.2)], 4.0):
        now[0] += 0.1
    assert slept == pytest.approx([0.0, 0.15, 0.15, 0.0])
    slept.clear()
    assert len(list(paced([Tick(1.0, (), {})], math.inf))) == 1
    assert not slept
    assert time.monotonic() != 100.0
