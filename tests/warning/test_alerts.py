"""Alerts by a model of who has heard what; by printed sentences; a log that kill -9, disks and hands cannot break."""

import math
import os
import signal
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

import narrows as nw
from narrows.readers.nmea import sentences, with_checksum
from narrows.warning import settings as numbers
from narrows.warning.alerts.alert import (
    BANKS,
    CALM,
    SENSORS,
    Alert,
    AlertCommand,
    AlertDesk,
    AlertLog,
    AlertState,
    BankLevel,
    Command,
    Condition,
    Priority,
    command_of,
    level_of,
    logged,
)
from narrows.warning.forecasting.forecaster import BankForecast, Escape, LikelyRun
from narrows.warning.monitoring.alert_publisher import alc, alf, arc, hbt
from nightly import draws

SILENCE = 30.0  # [s] after which a silenced alert sounds again: IEC 62923-1:2018
REPEAT_AFTER = 60.0  # [s] after which an alert that nobody acknowledges sounds anew
RAISE_DELAY, LOWER_DELAY = 2.0, 10.0  # [s] of urgency above and below a threshold before the level changes

BANK, HEADING = BANKS["starboard"], SENSORS["heading"]
NAMES = st.sampled_from(list(Priority))


class Bridge(RuleBasedStateMachine):
    """One situation: how urgent it is, who has heard it, since when it is silent."""

    def __init__(self) -> None:
        super().__init__()
        self.desk, self.t = AlertDesk(), 0.0
        self.priority, self.heard, self.silent_until, self.waiting, self.instances = Priority.NONE, True, -1.0, False, 0

    @rule(priority=NAMES)
    def becomes(self, priority: Priority) -> None:
        before = self.priority
        if priority and not before and not self.waiting:
            self.instances += 1
        if priority != before:
            self.silent_until = -1.0
            if not priority:
                self.waiting = not self.heard
            else:
                # Never heard waits at any priority; a new caution and what is less urgent than what was heard do not.
                unheard = self.waiting or (before and not self.heard)
                lower = before and self.heard and priority < before
                self.heard, self.waiting = not unheard and (bool(lower) or priority is Priority.CAUTION), False
        self.priority = priority
        self.desk.update(self.t, {BANK: Condition(priority, "text")})

    @rule(seconds=st.floats(0.5, 25.0))
    def passes(self, seconds: float) -> None:
        self.t += seconds
        self.desk.update(self.t, {})

    @rule(command=st.sampled_from(list(Command)), wrong=st.sampled_from([0, 0, 0, 1, -1]))
    def commanded(self, command: Command, wrong: int) -> None:
        """By the right instance, or by one that is replayed from another time or guessed."""
        unheard = self.waiting or (self.priority and not self.heard)
        silent = self.t < self.silent_until
        done = self.desk.command(self.t, BANK.identifier, self.instances + wrong, command)
        known = bool(self.priority or self.waiting) and not wrong
        can = {
            Command.ACKNOWLEDGE: unheard, Command.REPEAT: True, Command.TRANSFER: False,
            Command.SILENCE: unheard and not self.waiting and not silent and self.priority > Priority.CAUTION,
        }  # fmt: skip
        assert (done is not None) == bool(known and can[command])
        if done is not None and command is Command.ACKNOWLEDGE:
            self.heard, self.waiting = True, False
        if done is not None and command is Command.SILENCE:
            self.silent_until = self.t + SILENCE

    @invariant()
    def is_as_the_bridge_believes(self) -> None:
        alert, silent = self.desk[BANK], self.t < self.silent_until
        if not self.priority:
            assert alert.state is (AlertState.RECTIFIED if self.waiting else AlertState.NORMAL)
            return
        assert alert.priority is self.priority
        assert alert.state is (
            AlertState.ACKNOWLEDGED if self.heard
            else AlertState.SILENCED if silent and alert.state is AlertState.SILENCED
            else AlertState.UNACKNOWLEDGED
        )  # fmt: skip
        assert alert.sounds == (not self.heard and not silent and self.priority > Priority.CAUTION)
        assert alert.instance == self.instances

    @invariant()
    def there_is_one_alert(self) -> None:
        assert len(self.desk.alerts) == (1 if self.priority or self.waiting else 0)


Bridge.TestCase.settings = settings(max_examples=draws(30), stateful_step_count=30, deadline=None)
TestBridge = Bridge.TestCase


def test_a_silence_lasts_30_seconds() -> None:
    """IEC 62923-1:2018: temporarily silenced, an alert sounds again after 30 s."""
    desk = AlertDesk()
    (raised,) = desk.update(0.0, {BANK: Condition(Priority.ALARM, "text")})
    desk.command(5.0, BANK.identifier, raised.instance, Command.SILENCE)
    assert desk.update(34.9, {}) == []
    (again,) = desk.update(35.0, {})
    assert (again.state, again.sounds) == (AlertState.UNACKNOWLEDGED, True)


def test_what_nobody_acknowledges_sounds_anew_and_is_counted() -> None:
    desk = AlertDesk()
    (raised,) = desk.update(0.0, {BANK: Condition(Priority.WARNING, "text")})
    assert (raised.revision, raised.instance, raised.repeats) == (1, 1, 0)
    assert desk.update(REPEAT_AFTER - 0.1, {}) == []
    (again,) = desk.update(REPEAT_AFTER, {})
    assert (again.revision, again.repeats, again.state) == (2, 1, AlertState.UNACKNOWLEDGED)


def test_an_acknowledged_alert_swallows_no_new_danger() -> None:
    """An alarm to starboard, acknowledged; then one to port, then a second sensor: each sounds."""
    desk, port = AlertDesk(), BANKS["port"]
    (raised,) = desk.update(0.0, {BANK: Condition(Priority.ALARM, "text"), port: CALM})
    desk.command(1.0, BANK.identifier, raised.instance, Command.ACKNOWLEDGE)
    other = desk.update(2.0, {BANK: CALM, port: Condition(Priority.ALARM, "text")})[0]
    assert (other.identifier, other.sounds) == (port.identifier, True)
    failed = [{SENSORS[name]: Condition(Priority.WARNING, name)} for name in ("heading", "rudder")]
    assert [alert.sounds for one in failed for alert in desk.update(3.0, one)] == [True, True]


def test_what_was_never_acknowledged_waits_for_it_as_a_caution_too() -> None:
    desk = AlertDesk()
    for t, priority in enumerate((Priority.ALARM, Priority.CAUTION)):
        desk.update(float(t), {BANK: Condition(priority, "text")})
    assert desk[BANK].state is AlertState.UNACKNOWLEDGED
    assert not desk[BANK].sounds


def test_the_most_urgent_comes_first_and_what_is_over_last() -> None:
    desk = AlertDesk()
    desk.update(0.0, {HEADING: Condition(Priority.CAUTION, "a"), BANK: Condition(Priority.WARNING, "b")})
    assert [alert.identifier for alert in desk.alerts] == [BANK.identifier, HEADING.identifier]
    desk.update(1.0, {BANK: CALM})
    assert [alert.state for alert in desk.alerts] == [AlertState.ACKNOWLEDGED, AlertState.RECTIFIED]


def forecast(left: float = math.inf, gone: bool = False) -> BankForecast:
    escape, likely = Escape("then steady", -0.6, 0.6, 20.0), LikelyRun(50.0, "port", -1.0 if gone else 10.0)
    return BankForecast(0.0, likely, left, 0.0, 1.0, 1.0, 0.0, 50.0, escape, 0.0, 0.1, 0.6)


EASES = 1.0, 0.7  # of a level that is raised, and of one that is kept


@pytest.mark.parametrize(
    ("told", "level"),
    [
        ({}, Priority.NONE), ({"left": 90.1}, Priority.NONE), ({"left": 90.0}, Priority.CAUTION),
        ({"left": 60.0}, Priority.WARNING), ({"left": 30.0}, Priority.ALARM), ({"left": -1.0}, Priority.ALARM),
        ({"left": -1.0, "gone": True}, Priority.EMERGENCY_ALARM),
    ],
)  # fmt: skip
def test_the_time_that_is_left_to_act_makes_the_level(told: dict[str, float], level: Priority) -> None:
    """90 s, 60 s, 30 s."""
    assert level_of(forecast(**told)) is level


def updated(level: BankLevel, t: int, now: BankForecast) -> Priority:
    return level.update(float(t), *(level_of(now, ease) for ease in EASES))


def test_nothing_chatters_at_a_threshold() -> None:
    """A time that jumps over a threshold and back every second, for ten minutes: one warning."""
    level, said = BankLevel(), []
    for t in range(600):
        said.append(updated(level, t, forecast(60.0 + (-0.5 if t % 5 else 0.5))))
    assert said.index(Priority.WARNING) >= RAISE_DELAY
    assert sum(a is not b for a, b in pairwise(said)) <= 2
    below = [updated(level, 600 + t, forecast()) for t in range(20)]
    assert below.index(Priority.NONE) == LOWER_DELAY


def test_a_spike_is_no_alert() -> None:
    level = BankLevel()
    said = [updated(level, t, forecast(*left)) for t, left in enumerate([(1.0,), (), (1.0,), ()])]
    assert said == [Priority.NONE] * 4


ALERT = Alert(BANK.identifier, Priority.ALARM, AlertState.UNACKNOWLEDGED, "Contact to port, 42 s", 3.0, 7, 2, 1)


def test_sentences_are_as_they_are_printed() -> None:
    first, second = alf(ALERT, 1_777_680_000.25, 13)
    assert first.startswith("$IIALF,2,1,3,000000.25,A,A,V,NRW,10111,7,2,1,BANK TO STBD*")
    assert second.startswith("$IIALF,2,2,3,,,,,NRW,10111,7,2,1,Contact to port^2C 42 s*")
    (listed,) = alc([ALERT], 105)
    assert listed.startswith("$IIALC,01,01,05,1,NRW,10111,7,2*")
    assert [part.split(",")[1:5] for part in alc([ALERT] * 4, 0)] == [["02", "01", "00", "3"], ["02", "02", "00", "1"]]
    assert alc([], 0)[0].startswith("$IIALC,01,01,00,0*")
    assert hbt(True, 12).startswith("$IIHBT,60.0,A,2*")
    assert hbt(False, 0).startswith("$IIHBT,60.0,V,0*")
    refused = arc(AlertCommand(10110, 7, Command.TRANSFER), 1_777_680_000.0)
    assert refused.startswith("$IIARC,000000.00,NRW,10110,7,O*")
    for line in (first, second, listed, refused, hbt(True, 0)):
        assert len(line) <= 82
        (read,) = sentences([line.encode()], Counter())
        assert read.text.decode() == line.strip()


def test_letters_of_states_are_a_setting() -> None:
    letters = dict.fromkeys(AlertState, "X")
    assert ",A,A,X,NRW" in alf(ALERT, 0.0, 0, letters)[0]


def test_a_command_is_read_and_nothing_else_is() -> None:
    told = with_checksum("INACN,120000.00,NRW,10110,7,A,C").strip().encode()
    assert command_of(told) == AlertCommand(10110, 7, Command.ACKNOWLEDGE)
    assert command_of(with_checksum("INACN,,,10110,7,S,C").strip().encode()) == AlertCommand(10110, 7, Command.SILENCE)
    for body in ("INACN,,SAL,10110,7,A,C", "INACN,,NRW,x,7,A,C", "INACN,,NRW,10110,7,Z,C", "INACN,,NRW,10110,7,A,R"):
        assert command_of(with_checksum(body).strip().encode()) is None


@given(st.binary(max_size=60))
def test_fuzzed_commands_never_raise(noise: bytes) -> None:
    command_of(b"$INACN," + noise)
    command_of(noise)


def test_states_come_back_on_restart(tmp_path: Path) -> None:
    with AlertLog(tmp_path / "log.db") as log:
        assert log.alert(ALERT)
        assert log.alert(ALERT)
    with AlertLog(tmp_path / "log.db") as log:
        assert log.alerts == (ALERT,)
        assert AlertDesk(log.alerts)[BANK] == ALERT
        assert log.alert(ALERT)
    assert logged(tmp_path / "log.db") == {1: ALERT, 2: ALERT, 3: ALERT}


def test_a_file_that_is_no_log_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "a.db").write_text("no database" * 100)
    with pytest.raises(nw.InputError, match=r"is no log of alerts \(file is not a database\); name another"):
        AlertLog(tmp_path / "a.db")
    with AlertLog(tmp_path / "b.db") as log:
        log.alert(ALERT)
    for content in ("{}", "{", "[]", '{"priority": "HIGH"}'):
        with sqlite3.connect(tmp_path / "b.db") as connection:
            connection.execute("UPDATE alerts SET content = ?", (content,))
        connection.close()
        with pytest.raises(nw.InputError, match=r"b\.db: is no log of alerts"):
            AlertLog(tmp_path / "b.db")


def test_a_log_goes_on_after_its_last_row(tmp_path: Path) -> None:
    """Somebody removed rows before it: the next number is new, and its alert is on disk."""
    for _ in range(2):
        with AlertLog(tmp_path / "log.db") as log:
            assert log.alert(ALERT)
            assert log.alert(ALERT)
    with sqlite3.connect(tmp_path / "log.db") as connection:
        connection.execute("DELETE FROM alerts WHERE number < 3")
    connection.close()
    with AlertLog(tmp_path / "log.db") as log:
        assert log.alert(ALERT)
    assert list(logged(tmp_path / "log.db")) == [3, 4, 5]


def test_a_disk_that_can_only_be_read_mutes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "log.db"
    with AlertLog(path) as log:
        assert log.alert(ALERT)
    with AlertLog(path, 0.05, lambda: sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as log:
        assert not log.alert(ALERT)
        assert log.trouble == "attempt to write a readonly database"
    assert len(logged(path)) == 1


def test_a_full_disk_mutes_nothing_and_what_waited_is_written(tmp_path: Path) -> None:
    """A disk that fails, then stands still, then works: each alert returns by its deadline, and nothing is missing."""
    path, way = tmp_path / "log.db", ["full"]

    def connect() -> sqlite3.Connection:
        if way[0] == "full":
            raise sqlite3.OperationalError("database or disk is full")
        while way[0] == "stuck":
            time.sleep(0.01)
        from narrows.warning.alerts.alert import _opened

        return _opened(path)

    with AlertLog(path, deadline=0.05, connect=connect) as log:
        for kind in ("full", "stuck"):
            way[0], start = kind, time.monotonic()
            assert not log.alert(ALERT)
            assert time.monotonic() - start < 0.5
        assert log.trouble == "database or disk is full"
        way[0] = ""
        deadline = time.monotonic() + 5.0
        while not log.alert(ALERT) and time.monotonic() < deadline:
            pass
        assert log.trouble == ""
    assert len(logged(path)) >= 3


WRITER = """
import sys
from pathlib import Path
from narrows.warning.alerts.alert import Alert, AlertState, Priority
from narrows.warning.alerts.alert import AlertLog
with AlertLog(Path(sys.argv[1]), deadline=30.0) as log:
    for number in range(10_000):
        assert log.alert(Alert(10110, Priority.WARNING, AlertState.UNACKNOWLEDGED, str(number)))
        print(log.count, flush=True)
"""


@pytest.mark.parametrize("kills", [(20,), (4, 20)], ids=["one", "two"])
def test_kill_9_loses_no_published_alert(kills: tuple[int, ...], tmp_path: Path) -> None:
    """A writer that publishes what is on disk, killed while it writes: all that it published is in a whole log."""
    path, published = tmp_path / "log.db", 0
    for rows in kills:  # By rows, not by time: a disk or a machine under load may write one in a second.
        writer = subprocess.Popen(
            [sys.executable, "-c", WRITER, path], stdout=subprocess.PIPE, text=True, env=os.environ
        )
        assert writer.stdout is not None
        told = [writer.stdout.readline() for _ in range(rows)]
        os.kill(writer.pid, signal.SIGKILL)
        told += writer.stdout.read().splitlines()
        writer.stdout.close()
        writer.wait()
        published = max(int(line) for line in told if line.strip())
        assert len(logged(path)) >= published
    assert published >= sum(kills)


def test_times_that_a_navigator_sees() -> None:
    """Written out: a change here changes what the bridge sees and hears. IEC 62923-1 has the 30 s of silence."""
    assert (numbers.SILENCE, numbers.REPEAT_AFTER, numbers.MOST_REPEATS) == (30.0, 60.0, 9)
    assert (numbers.HOLD_TIME, numbers.RAISE_DELAY, numbers.LOWER_DELAY, numbers.HYSTERESIS) == (10, 2, 10, 0.7)
    assert (numbers.HEARTBEAT, numbers.LIST_INTERVAL) == (60.0, 30.0)
    assert (numbers.GRACE, numbers.SENSOR_SILENCE, numbers.OTHER_SENSOR_SILENCE) == (20.0, 3.0, 10.0)
    assert (numbers.BLIND_AFTER, numbers.SOURCE_SILENCE) == (10.0, 5.0)
    assert numbers.LEVELS == {"alarm": 30.0, "warning": 60.0, "caution": 90.0}
    assert (numbers.DEPTH_TOLERANCE, numbers.NEAR_MISS) == (0.1, 20.0)
    assert (numbers.HORIZON, numbers.ESCAPE_TIME, numbers.WRONG_ORDER_TIME) == (120.0, 100.0, 40.0)
    assert (numbers.CONTACT_CLEARANCE, numbers.NEEDED_TIME, numbers.BEFORE_CONTACT) == (5.0, 10.0, 300.0)
    assert (numbers.LATE, numbers.MOST_CLIENTS) == (60.0, 32)
