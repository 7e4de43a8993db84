"""A monitor at work: ships told by sentences, and what befalls sensors, clocks, disks and forecasts."""

import gc
import json
import math
import socket
import time
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from transit import canal, ship

import narrows as nw
from narrows.cli.keyboard import with_keys
from narrows.readers.nmea.nmea_clock import Entry
from narrows.readers.nmea.nmea_hearing import Hearing
from narrows.readers.nmea.nmea_lines import sentences, with_checksum
from narrows.warning.alerts.alert import AlertState, Priority
from narrows.warning.alerts.alert_log import AlertLog, logged
from narrows.warning.alerts.bank_level import Thresholds
from narrows.warning.alerts.situations import BANK, BEYOND_DATA, NO_FORECAST, SENSORS
from narrows.warning.forecasting.forecast import BankForecast
from narrows.warning.forecasting.forecaster import Forecaster
from narrows.warning.hearing.tick import Tick
from narrows.warning.monitoring import watched_transit
from narrows.warning.monitoring.alert_publisher import AlertPublisher, sender_to
from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
from narrows.warning.monitoring.bridge_sentences import bridge_sentences
from narrows.warning.monitoring.bridge_status import NOT_AVAILABLE, BridgeStatus
from narrows.warning.monitoring.demonstration import MISTAKE, demonstration
from narrows.warning.monitoring.watched_transit import TransitLog, WatchedTransit
from narrows.warning.scoring.scored_transit import PREDICTORS, TransitScorer
from narrows.warning.scoring.standing_alerts import NEEDED
from narrows.warning.scoring.transit_scores import score_transits

SPEED, BEGAN = 4.2, 1_777_680_000.0
Lines = list[str]
Fault = Callable[[int, Lines], Lines]


@cache
def forecaster() -> Forecaster:
    return Forecaster(monitor(shared=False).estimator, members=20)


def monitor(shared: bool = True, **options: object) -> BridgeMonitor:
    one = BridgeMonitor(ship(), canal(), members=20, **options)
    if shared:
        one.forecaster = forecaster()
    return one


def indicated(t: float, y: float = 0.0, psi: float = 0.0, rudder: float = 0.0) -> dict[str, float]:
    still = {"r": 0.0, "u": SPEED, "course": psi, "speed": SPEED, "rudder": rudder}
    return {**still, "x": 600.0 + SPEED * t, "y": y + SPEED * math.sin(psi) * t, "psi": psi}


def ticks(seconds: int, fault: Fault | None = None, **where: float) -> Iterator[Tick]:
    hearing = Hearing()
    for t in range(seconds):
        lines = bridge_sentences(canal(), indicated(float(t), **where), BEGAN + t)
        lines = fault(t, lines) if fault else lines
        told = [hearing.told(one, float(t)) for one in sentences([line.encode() for line in lines], hearing.faults)]
        yield Tick(BEGAN + t, [Entry(BEGAN + t, one) for one in told if one], dict(hearing.faults))


@cache
def calm_forecast() -> BankForecast:
    return forecaster()(watched(ticks(5))[-1].estimate, {"rudder": 0.0})


def calm(estimate: object, positions: object) -> BankForecast:
    return calm_forecast()


def watched(told: Iterator[Tick], one: BridgeMonitor | None = None) -> list[BridgeStatus]:
    one = one or monitor()
    return [one.update(tick, tick.t) for tick in told]


def without(*kinds: str, start: int = 0, stop: int = 10**9) -> Fault:
    return lambda t, lines: [
        line for line in lines if not (start <= t < stop and any(kind in line[:8] for kind in kinds))
    ]


def test_a_calm_ship_is_clear_and_its_state_is_known() -> None:
    last = watched(ticks(15))[-1]
    assert last.word == "clear"
    assert last.estimate["y"] == pytest.approx(0.0, abs=1.0)
    assert last.clearance == pytest.approx(150.0 - ship().configuration.ship.beam / 2, abs=3.0)
    assert last.line().split()[0] == "clear"
    assert last.to_dict()["forecast"]["cases"]["pilot now"]["probability"] == 0.0


def test_a_ship_on_its_way_into_a_bank_is_an_emergency() -> None:
    said = watched(ticks(18, y=95.0, psi=0.25, rudder=0.5))
    assert said[-1].level >= Priority.ALARM
    (alert,) = [one for one in said[-1].alerts if one.identifier == BANK.identifier]
    assert alert.state is AlertState.UNACKNOWLEDGED
    assert "starboard" in alert.text


def test_nothing_is_clear_before_anything_is_known() -> None:
    said = watched(ticks(30, without("HEHDT")))
    assert {status.word for status in said} == {NOT_AVAILABLE}
    assert all(status.line().split()[0] == "not" for status in said)
    told = {alert.identifier: alert for alert in said[-1].alerts}
    assert told[NO_FORECAST.identifier].priority is Priority.WARNING
    assert "no heading for" in told[SENSORS.identifier].text


def test_positions_minutes_apart_are_never_clear() -> None:
    """As ashore: a fix every ten minutes, and nothing else."""
    kinds = ("HEHDT", "TIROT", "VDVBW", "IIRSA", "GPVTG", "GPZDA")
    fixes = (tick._replace(t=BEGAN + 600.0 * k) for k, tick in enumerate(ticks(6, without(*kinds))))
    said = watched(tick._replace(entries=[entry._replace(t=tick.t) for entry in tick.entries]) for tick in fixes)
    assert {status.word for status in said} == {NOT_AVAILABLE}
    assert all(status.level >= Priority.WARNING for status in said[1:])


@pytest.mark.parametrize(("silent", "foretold"), [(2, True), (8, True), (14, False)])
def test_silence_degrades_what_is_said(silent: int, foretold: bool) -> None:
    """Of positions: after 3 s it is said, after 10 s nothing is foretold; when they come again, all is well."""
    said = watched(ticks(45, without("GPGGA", start=12, stop=12 + silent)))
    during = said[11 + silent]
    assert (during.forecast is not None) == foretold
    named = [alert.text for alert in during.alerts if alert.identifier == SENSORS.identifier]
    assert bool(named) == (silent > 3)
    assert said[-1].word == "clear"
    if not foretold:
        assert during.word == NOT_AVAILABLE


def test_recorded_transits_are_scored() -> None:
    """Two short twins: one that stays in the middle, and one that is steered into the bank."""
    told = {"calm": ticks(30), "aground": ticks(34, y=75.0, psi=0.25, rudder=0.5), "mute": ticks(12, without("HEHDT"))}
    transits = []
    for name, heard in told.items():
        scorer = TransitScorer(name, Thresholds())
        for status in watched(heard):
            scorer.add(status)
        transits.append(scorer.transit())
    scores = score_transits(transits)
    assert (scores.contacts, scores.near, scores.quiet, scores.unknown) == (1, 0, 1, ("mute",))
    assert all(row.false == 0 for row in scores.rows)
    leads = dict(zip(PREDICTORS, scores.leads["aground"], strict=True))
    assert 30.0 > leads["caution"] >= leads["alarm"] > 10.0
    assert scores.to_dataframe().loc["caution", "missed"] == (leads["caution"] < NEEDED)
    assert "1 transits with a contact" in scores.summary()
    assert any("mute" in note for note in scores.notes)
    with pytest.raises(nw.InputError, match="cannot tell contacts"):
        score_transits(transits, limit=25.0)


def test_a_jump_is_refused_and_said() -> None:
    def jump(t: int, lines: Lines) -> Lines:
        return bridge_sentences(canal(), indicated(float(t), y=60.0), BEGAN + t) if t == 14 else lines

    said = watched(ticks(16, jump))
    assert "gnss jumps" in next(a.text for a in said[14].alerts if a.identifier == SENSORS.identifier)
    assert said[15].estimate["y"] == pytest.approx(0.0, abs=1.5)


def test_a_slow_spoof_across_is_said() -> None:
    """Half a metre a second: told before it has led the estimate a quarter of the way to the bank."""

    def spoof(t: int, lines: Lines) -> Lines:
        y = 0.5 * max(t - 15, 0)
        fixes = [line for line in bridge_sentences(canal(), indicated(float(t), y=y), BEGAN + t) if "GGA" in line[:8]]
        return [*fixes, *(line for line in lines if "GGA" not in line[:8])]

    one = monitor()
    one.forecaster = calm
    said = watched(ticks(60, spoof), one)
    told = [k for k, status in enumerate(said) for alert in status.alerts if "gnss drifts" in alert.text]
    assert told
    assert abs(said[told[0]].estimate["y"]) < 150.0 / 4


@pytest.mark.slow
def test_memory_does_not_grow() -> None:
    """Less than a megabyte an hour, by the middle one of five stretches: what leaks grows in each.

    Free lists of Python and NumPy fill in the first minute, and grow by steps afterwards.
    """
    one, log, sizes = monitor(), TransitLog("A ship", "a canal"), []
    one.forecaster = calm
    for second, tick in enumerate(ticks(180), start=1):
        log.add(one.update(tick, tick.t))
        if second == 20:
            tracemalloc.start()
        elif second >= 80 and second % 20 == 0:
            gc.collect()
            sizes.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert np.diff(sizes).min() / 20 * 3600 < 1e6


def test_keys_acknowledge_and_silence() -> None:
    one = monitor()
    watched(ticks(18, y=95.0, psi=0.25, rudder=0.5), one)
    still, asked = Tick(BEGAN + 18, (), {}), []
    typed = iter([["s"], ["x", "a"]])
    for state in (AlertState.SILENCED, AlertState.ACKNOWLEDGED):
        told = with_keys(_slowly(still), one, next(typed))
        asked = [tick for tick in told if tick.commands][:1]
        one.update(asked[0], BEGAN + 18)
        assert one.desk[BANK].state is state


def _slowly(tick: Tick) -> Iterator[Tick]:
    for _ in range(20):
        time.sleep(0.02)
        yield tick


def test_clocks_that_step_in_the_sentences_change_nothing() -> None:
    """An hour, midnight, the second 60 of a leap second: a bridge that is listened to goes by its own clock."""
    clocks = ["235959.00", "235960.00", "000000.00", "010000.00"]

    def stepped(t: int, lines: Lines) -> Lines:
        return [_clocked(line, clocks[t % 4]) for line in lines]

    plain, moved = watched(ticks(14)), watched(ticks(14, stepped))
    assert [status.word for status in plain] == [status.word for status in moved]
    assert [status.changed for status in plain] == [status.changed for status in moved]
    assert moved[-1].estimate["y"] == pytest.approx(plain[-1].estimate["y"], abs=1e-9)


def _clocked(line: str, clock: str) -> str:
    body = line[1:].partition("*")[0]
    return with_checksum(",".join([body[:5], clock, *body.split(",")[2:]])) if body[2:5] == "GGA" else line


def test_outside_of_the_data_is_a_caution_and_so_is_another_draft() -> None:
    said = watched(ticks(4, y=90.0))
    (alert,) = [one for one in said[-1].alerts if one.identifier == BEYOND_DATA.identifier]
    assert alert.priority is Priority.CAUTION
    assert "offset from the centreline" in alert.text


@pytest.mark.parametrize(("lacks", "said"), [(0.0, False), (0.05, False), (0.2, True), (-0.2, True)])
def test_another_depth_than_charted_is_a_caution(lacks: float, said: bool) -> None:
    """As an echo sounder at the keel tells it."""
    under = (1 - lacks) * float(canal().section(600.0).depth) - ship().ship.draft
    sounded = with_checksum(f"SDDPT,{under + 1.0:.2f},-1.0,100.0")
    last = watched(ticks(4, lambda t, lines: [*lines, sounded]))[-1]
    assert any("echo sounder" in one.text for one in last.alerts) is said


def test_a_forecast_that_fails_or_is_late_is_not_available() -> None:
    def fails(estimate: object, positions: object) -> BankForecast:
        raise nw.InputError("no pilot holds it")

    one = monitor()
    one.forecaster = fails
    said = watched(ticks(25), one)
    assert {status.word for status in said} == {NOT_AVAILABLE}
    (alert,) = [one for one in said[-1].alerts if one.identifier == NO_FORECAST.identifier]
    assert alert.text == "no pilot holds it"


def test_a_late_forecast_is_out_of_date(monkeypatch: pytest.MonkeyPatch) -> None:
    import narrows.warning.monitoring.bridge_monitor as module

    now = iter(np.arange(0.0, 1e4, 1.5))
    monkeypatch.setattr(module.time, "monotonic", lambda: float(next(now)))
    said = watched(ticks(3))
    assert said[-1].word == NOT_AVAILABLE


def test_alerts_are_logged_sent_and_answered(tmp_path: Path) -> None:
    """By datagrams: an alarm out, its acknowledgement in, once; a second one and a wrong one are refused."""
    with ExitStack() as stack:
        bridge = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        log = stack.enter_context(AlertLog(tmp_path / "log.db"))
        bridge.bind(("127.0.0.1", 0))
        bridge.settimeout(2.0)
        send = stack.enter_context(sender_to(f"udp://127.0.0.1:{bridge.getsockname()[1]}"))
        one = monitor(publisher=AlertPublisher(log, send))
        watched(ticks(18, y=95.0, psi=0.25, rudder=0.5), one)
        alert = one.desk[BANK]
        command = with_checksum(f"INACN,,NRW,{BANK.identifier},{alert.instance},A,C").strip().encode()
        wrong = with_checksum(f"INACN,,NRW,{BANK.identifier},{alert.instance + 1},A,C").strip().encode()
        for told in ([command], [command, wrong]):
            one.update(Tick(BEGAN + 18, (), {}, told), BEGAN + 18)
        bridge.settimeout(0.2)
        heard = []
        try:
            while True:
                heard.append(bridge.recv(4096).decode())
        except TimeoutError:
            pass
    kinds = [line[3:6] for line in heard]
    assert kinds.count("ARC") == 2
    assert {"ALF", "ALC", "HBT", "ARC"} == set(kinds)
    acknowledged = [line for line in heard if f",A,NRW,{BANK.identifier}" in line and line[7:10] == "2,1"]
    assert len(acknowledged) == 1
    rows = [row for row in logged(tmp_path / "log.db") if f'"identifier": {BANK.identifier}' in row.content]
    assert len(rows) * 2 == len([line for line in heard if f"NRW,{BANK.identifier}," in line and "ALF" in line])


def test_a_disk_that_does_not_answer_is_a_caution_and_mutes_nothing(tmp_path: Path) -> None:
    import sqlite3

    def full() -> sqlite3.Connection:
        raise sqlite3.OperationalError("database or disk is full")

    with AlertLog(tmp_path / "log.db", deadline=0.01, connect=full) as log:
        heard: list[str] = []
        said = watched(ticks(8, y=90.0), monitor(publisher=AlertPublisher(log, heard.append)))
    assert any("ALF" in line for line in heard)
    assert any("not on disk: database or disk is full" in alert.text for alert in said[-1].alerts)


@pytest.mark.parametrize("address", ["tcp://a:1", "udp://:1", "udp://a:x", "udp://a:70000"])
def test_alerts_go_out_by_udp_alone(address: str) -> None:
    with pytest.raises(nw.InputError, match="write the address as in udp://"):
        sender_to(address).__enter__()


def transit_of(said: list[BridgeStatus]) -> WatchedTransit:
    log = TransitLog("A ship", "a canal")
    for status in said:
        log.add(status)
    return log.transit()


def test_a_transit_is_told_drawn_and_tabled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    transit = transit_of(watched(ticks(18, y=95.0, psi=0.25, rudder=0.5)))
    assert "First" in transit.summary()
    assert transit.to_dict()["least_clearance"] < 150.0
    assert len(transit.to_dataframe()) == 18
    assert "decision support" in transit.notes[0]
    transit.save(tmp_path / "a.png")
    transit.save(tmp_path / "a.csv")
    monkeypatch.setattr(watched_transit, "MOST_SECONDS", 4)
    kept = TransitLog("A ship", "a canal")
    for status in watched(ticks(7)):
        kept.add(status)
    assert kept.transit().columns["t"].tolist() == [3.0, 4.0, 5.0, 6.0]
    assert transit_of([]).summary() == "A ship on a canal: 0 seconds watched, 0 with a forecast."


@pytest.mark.slow
def test_the_demonstration_warns_before_the_ship_is_near(tmp_path: Path, cli) -> None:
    """An alarm, a minute before it is aground; the table, the page and the log of alerts say the same."""
    files = {"--report": "r.html", "-o": "t.csv", "--log": "a.db", "--recording": "b.nmea"}
    words = [word for option, name in files.items() for word in (option, str(tmp_path / name))]
    code, out, err = cli("monitor", "--demo", "--json", *words)
    assert code == 1, err
    told, table = json.loads(out), pd.read_csv(tmp_path / "t.csv")
    alarm = next(alert for alert in told["alerts"] if alert["priority"] in ("alarm", "emergency alarm"))
    nearest = float(table["t"][table["clearance"].idxmin()])
    assert MISTAKE[0] < alarm["t"] < nearest - 60.0
    assert told["foretold"] > 0.95 * told["seconds"]
    assert told["least_clearance"] == pytest.approx(table["clearance"].min())
    assert 0.0 < told["least_clearance"] < 20.0
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "decision support" in page
    assert "a near miss" in page
    assert len(list(logged(tmp_path / "a.db"))) == len(told["alerts"])
    assert len((tmp_path / "b.nmea").read_bytes().splitlines()) == 7 * told["seconds"]


def test_a_recording_of_the_demonstration_can_be_replayed(tmp_path: Path) -> None:
    from narrows.warning.hearing.replay import Replay

    shown = demonstration()
    (tmp_path / "bridge.nmea").write_bytes(shown.bridge.recording())
    again = list(Replay(tmp_path / "bridge.nmea").ticks())
    told = list(shown.ticks())
    assert len(again) == len(told)
    assert sorted(repr(one.told) for one in again[5].entries) == sorted(repr(one.told) for one in told[5].entries)
    assert again[-1].faults == {}


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ((), "give --listen with an address, --replay or --score with a recording, or --demo; one of them"),
        (("--demo", "a.toml"), "--demo has a ship and a canal of its own"),
        (("--replay", "a.nmea"), "give MODEL and --waterway"),
        (("--demo", "--pace", "0"), "--pace 0 is no pace"),
        (("--demo", "--port", "9"), "--host and --port are those of the page; give --page too"),
        (("--demo", "--send", "ws://"), "write it as in ws://192.168.1.20:3000"),
        (
            ("a.toml", "--replay", "a", "--waterway", "b", "--recording", "c.nmea"),
            "--recording writes what --demo tells",
        ),
    ],
)
def test_the_verb_says_what_it_lacks(cli, words: tuple[str, ...], sentence: str) -> None:
    code, _, err = cli("monitor", *words)
    assert code == 2
    assert sentence in err
