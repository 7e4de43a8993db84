"""The log of alerts: on disk before they are published, each row bound to the one before, states back after a restart.

A thread writes, and who publishes waits for it no longer than a deadline: a disk that is stuck or full delays an alert
by that, and mutes none. What could not be written is kept, in order, and written as soon as it can be.
"""

import hashlib
import json
import sqlite3
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from pathlib import Path
from threading import Condition as Signal
from threading import Thread
from typing import Any, NamedTuple

from narrows.errors import InputError, reason
from narrows.warning.alerts.alert import Alert, AlertState, Priority

# That an alert waits for the disk [s].
DEADLINE = 0.5
# After which a disk that failed is tried again [s].
AGAIN = 1.0
# Rows that wait for a disk; then the oldest are lost, which breaks the chain and can be seen.
MOST_WAITING = 100_000
TABLE = """
CREATE TABLE IF NOT EXISTS rows (
    number INTEGER PRIMARY KEY, written REAL NOT NULL, kind TEXT NOT NULL, content TEXT NOT NULL, hash TEXT NOT NULL
)
"""
NO_ROW = "0" * 64
Connect = Callable[[], sqlite3.Connection]


class LogRow(NamedTuple):
    """A row of the log."""

    number: int  # From 1 on
    written: float  # Since 1970 [s]
    kind: str  # What it tells of: ``alert``, ``command``, ``status``
    content: str  # JSON
    hash: str  # SHA-256 of the hash before it and of all else


class AlertLog:
    """A log that is written to."""

    def __init__(self, path: Path, deadline: float = DEADLINE, connect: Connect | None = None) -> None:
        self.path, self.deadline, self.trouble = path, deadline, ""
        self._connect = connect or (lambda: _opened(path))
        rows = list(logged(path)) if path.exists() else []
        self.alerts = _last_alerts(rows)
        self._last = rows[-1] if rows else LogRow(0, 0.0, "", "", NO_ROW)
        self._waiting: deque[LogRow] = deque(maxlen=MOST_WAITING)
        self._written, self._closing = self._last.number, False
        self._signal = Signal()
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def __enter__(self) -> "AlertLog":
        return self

    def __exit__(self, *error: object) -> None:
        with self._signal:
            self._closing = True
            self._signal.notify_all()
        self._thread.join(self.deadline + AGAIN)

    def alert(self, alert: Alert) -> bool:
        """Write an alert; return whether it is on disk."""
        return self.write("alert", {**vars(alert), "priority": alert.priority.name, "state": alert.state.name})

    def write(self, kind: str, content: Mapping[str, Any]) -> bool:
        """Write a row; return whether it is on disk before the deadline."""
        with self._signal:
            row = _row(self._last, kind, json.dumps(content, sort_keys=True))
            self._last = row
            self._waiting.append(row)
            self._signal.notify_all()
            return self._signal.wait_for(lambda: self._written >= row.number, self.deadline)

    def _run(self) -> None:
        connection: sqlite3.Connection | None = None
        while rows := self._due():
            try:
                connection = connection or self._connect()
                with connection:
                    connection.executemany("INSERT OR IGNORE INTO rows VALUES (?, ?, ?, ?, ?)", rows)
            except sqlite3.Error as error:
                connection, self.trouble = None, reason(error)
                if not self._pause():
                    return
                continue
            self._done(rows[-1].number)
        if connection:
            connection.close()

    def _due(self) -> list[LogRow]:
        """Rows that wait; none where it closes and nothing does."""
        with self._signal:
            self._signal.wait_for(lambda: self._waiting or self._closing)
            return list(self._waiting)

    def _pause(self) -> bool:
        with self._signal:
            self._signal.wait_for(lambda: self._closing, AGAIN)
            return not self._closing

    def _done(self, number: int) -> None:
        with self._signal:
            while self._waiting and self._waiting[0].number <= number:
                self._waiting.popleft()
            self._written, self.trouble = number, ""
            self._signal.notify_all()


def logged(path: Path) -> Iterator[LogRow]:
    """Yield the rows of a log, each held to the one before."""
    before = LogRow(0, 0.0, "", "", NO_ROW)
    try:
        with closing(_opened(path)) as connection:
            for row in map(LogRow._make, connection.execute("SELECT * FROM rows ORDER BY number")):
                if row.number != before.number + 1 or row.hash != _hash(before, row):
                    raise InputError(
                        f"{path}: row {row.number} does not follow from the one before: the log was changed, or rows "
                        "were lost; keep it, and name another for what comes"
                    )
                yield row
                before = row
    except sqlite3.Error as error:
        raise InputError(f"{path}: is no log of alerts ({reason(error)}); name another") from None


def _opened(path: Path) -> sqlite3.Connection:
    connection = sqlite3.connect(path, timeout=DEADLINE)
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute("PRAGMA synchronous = FULL")
    connection.execute(TABLE)
    return connection


def _row(before: LogRow, kind: str, content: str) -> LogRow:
    row = LogRow(before.number + 1, time.time(), kind, content, "")
    return row._replace(hash=_hash(before, row))


def _hash(before: LogRow, row: LogRow) -> str:
    return hashlib.sha256(repr((before.hash, *row[:-1])).encode()).hexdigest()


def _last_alerts(rows: list[LogRow]) -> tuple[Alert, ...]:
    """The last state of each alert."""
    told = {}
    for row in rows:
        if row.kind == "alert":
            content = json.loads(row.content)
            told[content["identifier"]] = content
    return tuple(
        Alert(**{**one, "priority": Priority[one["priority"]], "state": AlertState[one["state"]]})
        for one in told.values()
    )
