"""Requests of the monitor's page: noise, floods, and copies of old ones, beside a model of what is on the screen."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from watch import BEGAN, monitor, monitored, ticks

from narrows.warning.alerts.alert import (
    BANKS,
    CALM,
    AlertCommand,
    AlertDesk,
    AlertLog,
    AlertState,
    Command,
    Condition,
    Priority,
    logged,
)
from narrows.warning.inputs.bridge_readings import Tick
from narrows.warning.monitoring.alert_publisher import AlertPublisher
from narrows.warning.page.bridge_page import BUSY, PageRequest, PageRequests, objection, request_of, update_of
from nightly import draws

FAN_MEMBERS, REQUEST_QUEUE = 32, 64  # ships of the fan; requests that wait between two updates

BANK = BANKS["starboard"]
GOOD = {"command": "silence", "identifier": 10110, "instance": 1, "revision": 2}


@pytest.mark.parametrize(
    "wrong",
    [
        {"command": "transfer"}, {"command": ["silence"]}, {"identifier": "10110"}, {"identifier": 10110.0},
        {"instance": True}, {"revision": None}, {"more": 1},
    ],
)  # fmt: skip
def test_what_is_no_request_is_none(wrong: dict[str, Any]) -> None:
    assert request_of(json.dumps(GOOD)) == PageRequest("silence", 10110, 1, 2)
    assert request_of(json.dumps({**GOOD, **wrong})) is None
    assert request_of(json.dumps({**GOOD, **wrong})[:-1]) is None


VALUES = st.none() | st.booleans() | st.floats() | st.text(max_size=8) | st.lists(st.integers(), max_size=3)


@settings(max_examples=draws(10))
@given(st.text() | VALUES.map(json.dumps) | st.dictionaries(st.sampled_from([*GOOD]), VALUES).map(json.dumps))
def test_noise_is_no_request_and_never_raises(noise: str) -> None:
    assert request_of(noise) is None


def test_a_flood_of_requests_is_bounded() -> None:
    requests, said = PageRequests(), []
    for _ in range(REQUEST_QUEUE + 5):
        requests.take(json.dumps(GOOD), said.append)
    assert said == [BUSY] * 5
    first = AlertCommand(10110, 1, Command.SILENCE)
    told = next(requests.joined([Tick(0.0, (), {}, [first])], AlertDesk()))
    assert list(told.commands) == [first]
    assert len(said[5:]) == REQUEST_QUEUE
    assert "look at it again" in said[-1]


class PageBridge(RuleBasedStateMachine):
    """Requests, new ones and copies of old ones: heard where they are of what is on the screen."""

    def __init__(self) -> None:
        super().__init__()
        self.desk, self.t, self.old = AlertDesk(), 0.0, [PageRequest("acknowledge", BANK.identifier, 1, 1)]

    def seen(self) -> tuple[int, int]:
        return self.desk[BANK].instance, self.desk[BANK].revision

    @rule(priority=st.sampled_from(list(Priority)), seconds=st.floats(0.5, 40.0))
    def becomes(self, priority: Priority, seconds: float) -> None:
        self.t += seconds
        self.desk.update(self.t, {BANK: Condition(priority, "text") if priority else CALM})

    @rule(command=st.sampled_from(["acknowledge", "silence"]))
    def asks(self, command: str) -> None:
        request = PageRequest(command, BANK.identifier, *self.seen())
        self.old.append(request)
        self._judged(request)

    @rule(data=st.data())
    def asks_again(self, data: st.DataObject) -> None:
        self._judged(data.draw(st.sampled_from(self.old)))

    def _judged(self, request: PageRequest) -> None:
        before = self.desk[BANK]
        why = objection(request, self.desk, self.t)
        current = before.state is not AlertState.NORMAL and (request.instance, request.revision) == self.seen()
        command = Command.ACKNOWLEDGE if request.command == "acknowledge" else Command.SILENCE
        assert (why == "") == (current and before.commanded(command, self.t) is not None)
        said = PageRequests()
        said.take(json.dumps(request._asdict()), lambda sentence: None)
        for asked in said.commands(self.desk, self.t):
            assert self.desk.command(self.t, *asked) is not None
        assert (self.desk[BANK] == before) == bool(why)

    @invariant()
    def what_was_heard_is_not_heard_again(self) -> None:
        assert self.desk[BANK].state in AlertState


PageBridge.TestCase.settings = settings(max_examples=draws(20), stateful_step_count=20, deadline=None)
TestPageBridge = PageBridge.TestCase


def test_what_is_asked_for_on_the_page_goes_the_way_of_the_bridge(tmp_path: Path) -> None:
    """Through the desk, into the log before it is sent, out as a sentence; and the page is told where the ship goes."""
    with AlertLog(tmp_path / "log.db") as log:
        sent: list[str] = []
        one, requests = monitor(publisher=AlertPublisher(log, sent.append)), PageRequests()
        last = monitored(ticks(12, y=95.0, psi=0.25, rudder=0.5), one)[-1]
        told = update_of(one, last, BEGAN)
        (alert,) = [each for each in told["alerts"] if each["identifier"] == BANK.identifier]
        seen = {name: alert[name] for name in ("identifier", "instance", "revision")}
        for _ in range(2):
            requests.take(json.dumps({"command": "acknowledge", **seen}), sent.append)
        for tick in requests.joined([Tick(BEGAN + 18, (), {})], one.desk):
            one.update(tick, BEGAN + 18)
    assert one.desk[BANK].state is AlertState.ACKNOWLEDGED
    last = [row for row in logged(log.path).values() if row.identifier == BANK.identifier][-1]
    assert last.state is AlertState.ACKNOWLEDGED
    assert [line for line in sent if f",A,NRW,{BANK.identifier}" in line]
    assert np.shape(told["scene"]["fan"]["members"]) == (FAN_MEMBERS, 13, 2)
