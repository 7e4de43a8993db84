"""A monitor at work: what it says of a ship, to whom, and what befalls disks and forecasts."""

import gc
import socket
import tracemalloc
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from transit import canal, ship
from watch import BEGAN, calm, forecaster, indicated, monitor, monitored, ticks

import narrows as nw
from narrows.readers.nmea import with_checksum
from narrows.warning.alerts.alert import BANKS, NO_FORECAST, AlertLog, AlertState, Priority, command_of, logged
from narrows.warning.forecasting.forecaster import BankForecast
from narrows.warning.inputs.bridge_readings import Tick
from narrows.warning.monitoring.alert_publisher import AlertPublisher, sender_to
from narrows.warning.monitoring.demonstration import bridge_sentences
from narrows.warning.monitoring.watched_transit import NOT_AVAILABLE, TransitLog

BANK = BANKS["starboard"]


def test_a_calm_ship_is_clear_and_its_state_is_known() -> None:
    last = monitored(ticks(15))[-1]
    assert last.word == "clear"
    assert last.estimate["y"] == pytest.approx(0.0, abs=1.0)
    assert last.clearance == pytest.approx(150.0 - ship().configuration.ship.beam / 2, abs=3.0)
    assert last.line().split()[0] == "clear"
    assert last.to_dict()["forecast"]["nobody"] == 0.0


def test_a_ship_on_its_way_into_a_bank_is_an_emergency() -> None:
    said = monitored(ticks(18, y=95.0, psi=0.25, rudder=0.5))
    assert said[-1].level >= Priority.ALARM
    (alert,) = [one for one in said[-1].alerts if one.identifier == BANK.identifier]
    assert alert.state is AlertState.UNACKNOWLEDGED
    assert "starboard" in alert.text


@pytest.mark.slow
def test_memory_does_not_grow() -> None:
    """Less than a megabyte an hour, by the least of five stretches: what leaks grows in each.

    Free lists of Python and NumPy fill in the first minute, and grow by steps afterwards.
    """
    one, log, sizes = monitor(), TransitLog(ship().configuration, canal()), []
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


def test_outside_of_the_data_is_a_standing_note_and_no_alert() -> None:
    last = monitored(ticks(4, y=90.0))[-1]
    assert last.alerts == ()
    assert "offset from the centreline" in last.caveats[0]


def test_an_alarm_is_not_over_because_the_monitor_was_started_anew(tmp_path: Path) -> None:
    """An alarm on disk, the program killed and started again: it stands until forecasts were calm for ten seconds."""
    with AlertLog(tmp_path / "log.db") as log:
        monitored(ticks(18, y=95.0, psi=0.25, rudder=0.5), monitor(publisher=AlertPublisher(log)))
    with AlertLog(tmp_path / "log.db") as log:
        again = monitor(publisher=AlertPublisher(log))
        again.forecaster = calm
        said = [status.alerts[0].state for status in monitored(ticks(20), again)]
    assert said[:8] == [AlertState.UNACKNOWLEDGED] * 8
    assert said[-1] is AlertState.RECTIFIED


def test_a_forecast_that_fails_or_is_late_is_not_available() -> None:
    def fails(*asked: object) -> BankForecast:
        raise nw.InputError("no pilot holds it")

    one = monitor()
    one.forecaster = fails
    said = monitored(ticks(25), one)
    assert {status.word for status in said} == {NOT_AVAILABLE}
    (alert,) = [one for one in said[-1].alerts if one.identifier == NO_FORECAST.identifier]
    assert alert.text == "no pilot holds it"


def test_a_late_forecast_is_out_of_date(monkeypatch: pytest.MonkeyPatch) -> None:
    import narrows.warning.monitoring.bridge_monitor as module

    now = iter(np.arange(0.0, 1e4, 1.5))
    monkeypatch.setattr(module.time, "monotonic", lambda: float(next(now)))
    assert monitored(ticks(3))[-1].word == NOT_AVAILABLE
    assert monitored(ticks(3), monitor(live=False))[-1].word != NOT_AVAILABLE  # A replay is as slow as the machine.


def test_alerts_are_logged_sent_and_answered(tmp_path: Path) -> None:
    """By datagrams: an alarm out, its acknowledgement in, once; a second one and a wrong one are refused."""
    with ExitStack() as stack:
        bridge = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        log = stack.enter_context(AlertLog(tmp_path / "log.db"))
        bridge.bind(("127.0.0.1", 0))
        bridge.settimeout(2.0)
        send = stack.enter_context(sender_to(f"udp://127.0.0.1:{bridge.getsockname()[1]}"))
        one = monitor(publisher=AlertPublisher(log, send))
        monitored(ticks(18, y=95.0, psi=0.25, rudder=0.5), one)
        alert = one.desk[BANK]
        command = with_checksum(f"INACN,,NRW,{BANK.identifier},{alert.instance},A,C").strip().encode()
        wrong = with_checksum(f"INACN,,NRW,{BANK.identifier},{alert.instance + 1},A,C").strip().encode()
        for told in ([command], [command, wrong]):
            one.update(Tick(BEGAN + 18, (), {}, [*map(command_of, told)]), BEGAN + 18)
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
    rows = [row for row in logged(tmp_path / "log.db").values() if row.identifier == BANK.identifier]
    assert len(rows) * 2 == len([line for line in heard if f"NRW,{BANK.identifier}," in line and "ALF" in line])


def test_a_disk_that_does_not_answer_is_a_caution_and_mutes_nothing(tmp_path: Path) -> None:
    import sqlite3

    def full() -> sqlite3.Connection:
        raise sqlite3.OperationalError("database or disk is full")

    with AlertLog(tmp_path / "log.db", deadline=0.01, connect=full) as log:
        heard: list[str] = []
        told = ticks(18, y=95.0, psi=0.25, rudder=0.5)
        said = monitored(told, monitor(publisher=AlertPublisher(log, heard.append)))
    assert any("ALF" in line for line in heard)
    assert any("not on disk: database or disk is full" in alert.text for alert in said[-1].alerts)


@pytest.mark.parametrize("address", ["tcp://a:1", "udp://:1", "udp://a:x", "udp://a:70000"])
def test_alerts_go_out_by_udp_alone(address: str) -> None:
    with pytest.raises(nw.InputError, match="write the address as in udp://"):
        sender_to(address).__enter__()


def test_a_monitor_in_python_takes_sentences_or_readings() -> None:
    one, other = (nw.Monitor(ship(), canal(), members=20) for _ in range(2))
    one.engine.forecaster = other.engine.forecaster = forecaster()
    for t in range(5):
        now = indicated(float(t), y=105.0)
        by_sentences = one.update(t, bridge_sentences(canal(), now, BEGAN + t))
        by_readings = other.update(t, {name: now[name] for name in ("x", "y", "psi", "u", "r", "rudder")})
    assert by_sentences.word == by_readings.word != NOT_AVAILABLE
    assert by_readings.clearance == pytest.approx(by_sentences.clearance, abs=1.0)


def test_a_monitor_in_python_warns_and_names_what_it_takes() -> None:
    one = nw.Monitor("estimated_kcs", members=20)
    for t in range(6):
        one.update(t, x=1000.0 + 4.0 * t, y=100.0, psi=0.2, u=4.0, r=0.0, rudder=0.0)
    assert one.alarms == one.alerts
    assert "bank to starboard" in one.alerts[0].text
    with pytest.raises(nw.InputError, match="no sensor of this estimator is called 'speed'"):
        one.update(6.0, speed=4.0)
    with pytest.raises(nw.InputError, match="give both"):
        one.update(6.0, y=4.0)
    with pytest.raises(nw.InputError, match="give a waterway with its origin"):
        one.update(6.0, "$HEHDT,10.0,T*1E")
    for told, where in (([1, 2], {}), (["$HEHDT,10.0,T*1E"], {"x": 1.0}), (3, {})):
        with pytest.raises(nw.InputError, match="give sentences, or else numbers by name"):
            one.update(6.0, told, **where)
    with pytest.raises(nw.InputError, match="is no time"):
        one.update("a", x=1.0, y=2.0)
