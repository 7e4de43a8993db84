"""What is asked for on the page: read with suspicion, judged by the alerts as they are, done as the bridge's sentences.

A request names the alert, which time of it, and the revision that was on the screen: a copy of an old request, or one
of an alert that became more urgent meanwhile, is refused, for nobody has seen what it would acknowledge.
"""

import json
from collections.abc import Callable, Iterable, Iterator
from queue import Empty, Full, Queue
from typing import Any, NamedTuple

from narrows.warning.alerts.alert import Alert, AlertState
from narrows.warning.alerts.alert_desk import AlertDesk
from narrows.warning.alerts.alert_sentences import acn
from narrows.warning.alerts.situations import SITUATIONS
from narrows.warning.hearing.tick import Tick
from narrows.warning.page.page_updates import COMMANDS

# Letters of a request.
LONGEST = 512
# Requests between two updates.
MOST_WAITING = 64
NUMBERS = ("identifier", "instance", "revision")
MALFORMED = (
    'That is no request; write {"command": "acknowledge" or "silence", "identifier": ..., "instance": ..., '
    '"revision": ...}, the numbers as the alert has them.'
)
BUSY = "Too much is asked for at once; ask again."
# Told why, where a request is refused.
Answer = Callable[[str], None]


class PageRequest(NamedTuple):
    """What is asked for."""

    command: str  # Of ``COMMANDS``
    identifier: int  # Of the alert, as it was seen
    instance: int  # Of the alert, as it was seen
    revision: int  # Of the alert, as it was seen


def request_of(text: str) -> PageRequest | None:
    """Return the request of a message; None where it is none."""
    if len(text) > LONGEST:
        return None
    try:
        asked = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(asked, dict) or set(asked) != {"command", *NUMBERS}:
        return None
    numbers = [asked[name] for name in NUMBERS]
    return PageRequest(asked["command"], *numbers) if _known(asked["command"], numbers) else None


def _known(command: Any, numbers: list[Any]) -> bool:
    return isinstance(command, str) and command in COMMANDS and all(type(number) is int for number in numbers)


def objection(request: PageRequest, desk: AlertDesk, t: float) -> str:
    """Return why a request is refused, in a sentence; empty where it is not."""
    # t [s]
    situation = SITUATIONS.get(request.identifier)
    if situation is None:
        return f"There is no alert {request.identifier}."
    alert = desk[situation]
    if alert.state is AlertState.NORMAL or alert.instance != request.instance:
        return f"{situation.name}: that alert is over."
    if alert.revision != request.revision:
        return f"{situation.name}: the alert has changed since it was asked for; look at it again."
    return _unfit(request, alert, t)


def _unfit(request: PageRequest, alert: Alert, t: float) -> str:
    if alert.commanded(COMMANDS[request.command], t) is not None:
        return ""
    return f"{SITUATIONS[alert.identifier].name}: it is {alert.state.value}, so there is nothing to {request.command}."


class PageRequests:
    """Requests that wait for the next update of the monitor."""

    def __init__(self) -> None:
        self._waiting: Queue[tuple[PageRequest, Answer]] = Queue(MOST_WAITING)

    def take(self, text: str, answer: Answer) -> None:
        """Take a message, in any thread."""
        request = request_of(text)
        if request is None:
            answer(MALFORMED)
            return
        try:
            self._waiting.put_nowait((request, answer))
        except Full:
            answer(BUSY)

    def sentences(self, desk: AlertDesk, t: float) -> list[bytes]:
        """Return what is asked for as the bridge's sentences, and answer what is refused."""
        # t [s]
        said: list[bytes] = []
        try:
            while True:
                request, answer = self._waiting.get_nowait()
                if why := objection(request, desk, t):
                    answer(why)
                else:
                    said.append(acn(request.identifier, request.instance, COMMANDS[request.command]))
        except Empty:
            return said

    def joined(self, ticks: Iterable[Tick], desk: AlertDesk) -> Iterator[Tick]:
        """Yield ticks with what was asked for on the page."""
        for tick in ticks:
            yield tick._replace(commands=[*tick.commands, *self.sentences(desk, tick.t)])
