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
from contextlib import closing, suppress
from pathlib import Path
from threading import Condition as Signal
from threading import Thread
from typing import Any, NamedTuple

from narrows.errors import InputError, reason
from narrows.warning.alerts.alert import Alert, AlertState, Priority
from narrows.warning.settings import DISK_RETRY, DISK_TIMEOUT, LOG_QUEUE

TABLE = """
CREATE TABLE IF NOT EXISTS rows (
    number INTEGER PRIMARY KEY, written REAL NOT NULL, kind TEXT NOT NULL, content TEXT NOT NULL, hash TEXT NOT NULL
)
"""
NO_ROW = "0" * 64
Connect = Callable[[], sqlite3.Connection]


class ChangedLog(InputError):
    """A log whose rows do not follow from one another."""


class LogRow(NamedTuple):
    number: int  # Number of the entry, from 1 on
    written: float  # Since 1970 [s]
    kind: str  # Kind: ``alert``, ``command``, ``status``
    content: str  # JSON
    hash: str  # SHA-256 of the hash before it and of all else


class AlertLog:
    def __init__(self, path: Path, deadline: float = DISK_TIMEOUT, connect: Connect | None = None) -> None:
        self.path, self.deadline, self.trouble = path, deadline, ""
        self._connect = connect or (lambda: _opened(path))
        self.aside = ""
        rows = self._kept() if path.exists() else []
        contents = [json.loads(row.content) for row in rows if row.kind == "alert"]
        self.alerts = tuple(
            Alert(**{**last, "priority": Priority[last["priority"]], "state": AlertState[last["state"]]})
            for last in {content["identifier"]: content for content in contents}.values()
        )
        self._last = rows[-1] if rows else LogRow(0, 0.0, "", "", NO_ROW)
        self._waiting: deque[LogRow] = deque(maxlen=LOG_QUEUE)
        self._written, self._closing = self._last.number, False
        self._signal = Signal()
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def _kept(self) -> list[LogRow]:
        """Rows of a log that is whole; one that was changed is put aside: a watch does not wait for an inquiry."""
        try:
            return list(logged(self.path))
        except ChangedLog as changed:
            aside = self.path.with_suffix(f".changed-{time.time():.0f}{self.path.suffix}")
            self.aside = f"{changed} It is {aside.name} now, and a new one is begun."
            for end in ("", "-wal", "-shm"):
                with suppress(FileNotFoundError):
                    Path(f"{self.path}{end}").rename(f"{aside}{end}")
            return []

    def __enter__(self) -> "AlertLog":
        return self

    def __exit__(self, *error: object) -> None:
        with self._signal:
            self._closing = True
            self._signal.notify_all()
        self._thread.join(self.deadline + DISK_RETRY)

    def alert(self, alert: Alert) -> bool:
        """Write an alert; return whether it is on disk."""
        return self.write("alert", {**vars(alert), "priority": alert.priority.name, "state": alert.state.name})

    def write(self, kind: str, content: Mapping[str, Any]) -> bool:
        """Write a row; return whether it is on disk before the deadline."""
        with self._signal:
            row = LogRow(self._last.number + 1, time.time(), kind, json.dumps(content, sort_keys=True), "")
            row = self._last = row._replace(hash=_hash(self._last, row))
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
                if connection:
                    connection.close()
                connection, self.trouble = None, reason(error)
                with self._signal:
                    if self._signal.wait_for(lambda: self._closing, DISK_RETRY):
                        return
                continue
            with self._signal:
                while self._waiting and self._waiting[0].number <= rows[-1].number:
                    self._waiting.popleft()
                self._written, self.trouble = rows[-1].number, ""
                self._signal.notify_all()
        if connection:
            connection.close()

    def _due(self) -> list[LogRow]:
        """Rows that wait; none where it closes and nothing does."""
        with self._signal:
            self._signal.wait_for(lambda: self._waiting or self._closing)
            return list(self._waiting)


def logged(path: Path) -> Iterator[LogRow]:
    """Yield the rows of a log, each held to the one before."""
    before = LogRow(0, 0.0, "", "", NO_ROW)
    try:
        with closing(_opened(path)) as connection:
            for row in map(LogRow._make, connection.execute("SELECT * FROM rows ORDER BY number")):
                if row.number != before.number + 1 or row.hash != _hash(before, row):
                    raise ChangedLog(
                        f"{path}: row {row.number} does not follow from the one before: the log was changed, or rows "
                        "were lost; keep it."
                    )
                yield row
                before = row
    except sqlite3.Error as error:
        raise InputError(f"{path}: is no log of alerts ({reason(error)}); name another") from None


def _opened(path: Path) -> sqlite3.Connection:
    connection = sqlite3.connect(path, timeout=DISK_TIMEOUT)
    try:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute(TABLE)
    except sqlite3.Error:
        connection.close()  # Python 3.13 warns of a connection that is dropped open.
        raise
    return connection


def _hash(before: LogRow, row: LogRow) -> str:
    return hashlib.sha256(repr((before.hash, *row[:-1])).encode()).hexdigest()
