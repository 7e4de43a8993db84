"""Keys while a ship is watched: who looks at the screen acknowledges and silences there."""

import sys
from collections.abc import Iterable, Iterator
from queue import SimpleQueue
from threading import Thread
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from narrows.warning.hearing.tick import Tick
    from narrows.warning.monitoring.bridge_monitor import BridgeMonitor

HINT = "a and Enter acknowledges what is alerted, s and Enter silences it for 30 s, Ctrl-C ends the watch."


def with_keys(
    ticks: Iterable["Tick"], watched: "BridgeMonitor", lines: Iterable[str] | None = None
) -> Iterator["Tick"]:
    """Yield ticks, with a command for every alert that a key was pressed for."""
    typed: SimpleQueue[str] = SimpleQueue()
    Thread(target=_read, args=(lines or sys.stdin, typed), daemon=True).start()
    for tick in ticks:
        commands = list(tick.commands)
        while not typed.empty():
            commands += _commands(typed.get(), tick.t, watched)
        yield tick._replace(commands=commands)


def _read(lines: Iterable[str], typed: "SimpleQueue[str]") -> None:
    for line in lines:
        typed.put(line.strip())


def _commands(key: str, t: float, watched: "BridgeMonitor") -> list[bytes]:
    """Sentences of a key: for each alert of which its command can be."""
    from narrows.warning.alerts.alert import Command
    from narrows.warning.alerts.alert_sentences import acn

    keys = {"a": Command.ACKNOWLEDGE, "s": Command.SILENCE}
    if key not in keys:
        return []
    alerts = [one for one in watched.desk.alerts if one.commanded(keys[key], t) is not None]
    return [acn(alert.identifier, alert.instance, keys[key]) for alert in alerts]
