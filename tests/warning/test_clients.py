"""Those who look on at a monitor: slow and dead ones hold up nobody."""

import asyncio
import socket
import time
from collections import deque

import pytest
from shown_page import HANDSHAKE, soon

from narrows.warning import settings
from narrows.warning.page.bridge_page import UPDATES, BridgePage, Clients

ANSWER_QUEUE = 16  # answers that wait for a client


def test_who_reads_slowly_gets_the_newest_and_holds_up_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten thousand messages while one is being sent: none of them waits for the loop."""
    all_of_them, got, called = Clients(), [], []

    async def scene() -> None:
        answers, sent, loop = deque[str](maxlen=settings.ANSWER_QUEUE), asyncio.Event(), asyncio.get_running_loop()
        monkeypatch.setattr(loop, "call_soon_threadsafe", called.append)

        async def send(message: str) -> None:
            got.append(message)
            await sent.wait()

        telling = asyncio.create_task(all_of_them.serve(answers, send))
        all_of_them.publish("first")
        await asyncio.sleep(0.05)
        assert len(all_of_them) == 1
        for number in range(10_000):
            all_of_them.publish(str(number))
            answers.append(f"answer {number}")
        assert called == []
        sent.set()
        while "9999" not in got:
            await asyncio.sleep(0.01)
        telling.cancel()
        await asyncio.gather(telling, return_exceptions=True)

    asyncio.run(scene())
    assert got == ["first", *(f"answer {number}" for number in range(10_000 - ANSWER_QUEUE, 10_000)), "9999"]
    all_of_them.publish("nobody listens, and the loop is closed")
    assert len(all_of_them) == 0


def test_who_comes_to_a_second_loop_is_told_after_the_first_was_closed() -> None:
    """A server that is opened again: what was called in the loop that is gone holds up nothing."""
    crowd, got = Clients(), []

    async def scene(message: str) -> None:
        async def send(message: str) -> None:
            got.append(message)

        telling = asyncio.create_task(crowd.serve(deque(), send))
        await asyncio.sleep(0.05)
        crowd.publish(message)
        while message not in got:
            await asyncio.sleep(0.01)
        telling.cancel()

    for message in ("one", "two"):
        asyncio.run(asyncio.wait_for(scene(message), 20.0))
        crowd.publish("nobody listens, and the loop is closed")
    assert "two" in got


def test_what_is_old_is_told_to_nobody() -> None:
    """Who comes to a monitor that hangs is not told what was true before, as if it were now."""
    crowd, got = Clients(lasts=0.1), []

    async def scene() -> None:
        async def send(message: str) -> None:
            got.append(message)

        crowd.publish("old")
        await asyncio.sleep(0.2)
        telling = asyncio.create_task(crowd.serve(deque(), send))
        await asyncio.sleep(0.15)
        crowd.publish("new")
        await asyncio.sleep(0.15)
        telling.cancel()

    asyncio.run(scene())
    assert got == ["new"]


def test_who_does_not_read_is_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(settings, "SEND_TIMEOUT", 0.02)

    async def scene() -> None:
        crowd = Clients()

        async def never(message: str) -> None:
            await asyncio.sleep(60.0)

        crowd.publish("x")
        with pytest.raises(TimeoutError):
            await crowd.serve(deque(), never)
        assert len(crowd) == 0

    asyncio.run(scene())


def test_a_dead_browser_holds_up_neither_the_monitor_nor_another(monkeypatch: pytest.MonkeyPatch) -> None:
    """Over real sockets: one never reads what would fill it in a moment, the other hears the last word."""
    connect = pytest.importorskip("websockets.sync.client", reason="of the extra monitor").connect
    monkeypatch.setattr(settings, "SEND_TIMEOUT", 0.3)
    monkeypatch.setattr(settings, "SEND_INTERVAL", 0.0)
    page = BridgePage()
    with page.open() as address:
        host, token = address.removeprefix("http://").split("/?")
        with socket.create_connection(("127.0.0.1", int(host.split(":")[1]))) as dead:
            dead.sendall(HANDSHAKE.format(path=f"{UPDATES}?{token}", host=host, more="").encode())
            assert b"101" in dead.recv(64)
            with connect(f"ws://{host}{UPDATES}?{token}", max_size=None) as alive:
                assert soon(lambda: len(page.updates) == 2)
                start = time.monotonic()
                while len(page.updates) == 2 and time.monotonic() - start < 10.0:
                    page.updates.publish("x" * 2_000_000)
                    alive.recv(2.0)
                assert len(page.updates) == 1
                page.updates.publish("last")
                assert soon(lambda: alive.recv(2.0) == "last")
