"""A monitor whose sensors are silent, jump, drift, or have another clock."""

import pytest
from transit import canal, ship
from watch import BEGAN, Lines, calm, indicated, monitor, monitored, ticks, without

from narrows.readers.nmea import with_checksum
from narrows.warning.alerts.alert import NO_FORECAST, SENSORS, Priority
from narrows.warning.monitoring.demonstration import bridge_sentences
from narrows.warning.monitoring.watched_transit import NOT_AVAILABLE


def test_nothing_is_clear_before_anything_is_known() -> None:
    said = monitored(ticks(30, without("HEHDT")))
    assert {status.word for status in said} == {NOT_AVAILABLE}
    assert all(status.line().split()[0] == "not" for status in said)
    told = {alert.identifier: alert for alert in said[-1].alerts}
    assert told[NO_FORECAST.identifier].priority is Priority.WARNING
    assert "no heading for" in told[SENSORS["heading"].identifier].text


def test_positions_minutes_apart_are_never_clear() -> None:
    """As ashore: a fix every ten minutes, and nothing else."""
    kinds = ("HEHDT", "TIROT", "VDVBW", "IIRSA", "GPVTG", "GPZDA")
    fixes = (tick._replace(t=BEGAN + 600.0 * k) for k, tick in enumerate(ticks(6, without(*kinds))))
    said = monitored(tick._replace(entries=[entry._replace(t=tick.t) for entry in tick.entries]) for tick in fixes)
    assert {status.word for status in said} == {NOT_AVAILABLE}
    assert all(status.level >= Priority.WARNING for status in said[1:])


@pytest.mark.parametrize(("silent", "predicted"), [(2, True), (8, True), (14, False)])
def test_silence_degrades_what_is_said(silent: int, predicted: bool) -> None:
    """Of positions: after 3 s it is said, after 10 s nothing is predicted; when they come again, all is well."""
    said = monitored(ticks(28 + silent, without("GPGGA", start=12, stop=12 + silent)))
    during = said[11 + silent]
    assert (during.forecast is not None) == predicted
    named = [alert.text for alert in during.alerts if alert.identifier == SENSORS["position"].identifier]
    assert bool(named) == (silent > 3)
    assert said[-1].word == "clear"
    if not predicted:
        assert during.word == NOT_AVAILABLE


def test_a_jump_is_refused_and_said() -> None:
    def jump(t: int, lines: Lines) -> Lines:
        return bridge_sentences(canal(), indicated(float(t), y=60.0), BEGAN + t) if t == 14 else lines

    said = monitored(ticks(16, jump))
    assert "gnss jumps" in next(a.text for a in said[14].alerts if a.identifier == SENSORS["position"].identifier)
    assert said[15].estimate["y"] == pytest.approx(0.0, abs=1.5)


def test_a_slow_spoof_across_is_said() -> None:
    """Half a metre a second: told before it has led the estimate a quarter of the way to the bank."""

    def spoof(t: int, lines: Lines) -> Lines:
        y = 0.5 * max(t - 15, 0)
        fixes = [line for line in bridge_sentences(canal(), indicated(float(t), y=y), BEGAN + t) if "GGA" in line[:8]]
        return [*fixes, *(line for line in lines if "GGA" not in line[:8])]

    one = monitor()
    one.forecaster = calm
    said = (one.update(tick, tick.t) for tick in ticks(60, spoof))
    first = next((now for now in said if any("gnss drifts" in alert.text for alert in now.alerts)), None)
    assert first is not None
    assert abs(first.estimate["y"]) < 150.0 / 4


def test_clocks_that_step_in_the_sentences_change_nothing() -> None:
    """An hour, midnight, the second 60 of a leap second: a bridge that is listened to goes by its own clock."""
    clocks = ["235959.00", "235960.00", "000000.00", "010000.00"]

    def stepped(t: int, lines: Lines) -> Lines:
        return [_clocked(line, clocks[t % 4]) for line in lines]

    plain, moved = monitored(ticks(14)), monitored(ticks(14, stepped))
    assert [status.word for status in plain] == [status.word for status in moved]
    assert [status.changed for status in plain] == [status.changed for status in moved]
    assert moved[-1].estimate["y"] == pytest.approx(plain[-1].estimate["y"], abs=1e-9)


def _clocked(line: str, clock: str) -> str:
    body = line[1:].partition("*")[0]
    return with_checksum(",".join([body[:5], clock, *body.split(",")[2:]])) if body[2:5] == "GGA" else line


@pytest.mark.parametrize(("lacks", "said"), [(0.0, False), (0.05, False), (0.2, True), (-0.2, True)])
def test_another_depth_than_charted_is_a_caution(lacks: float, said: bool) -> None:
    """As an echo sounder at the keel tells it."""
    under = (1 - lacks) * float(canal().section(600.0).depth) - ship().ship.draft
    sounded = with_checksum(f"SDDPT,{under + 1.0:.2f},-1.0,100.0")
    last = monitored(ticks(4, lambda t, lines: [*lines, sounded]))[-1]
    assert any("echo sounder" in one.text for one in last.alerts) is said
