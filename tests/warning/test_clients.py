"""Those who look on at a monitor: slow and dead ones hold up nobody, and nobody is told what is old."""

import contextlib
import json
import socket
import time
from collections.abc import Iterator
from typing import Any

import pytest
from shown_page import HANDSHAKE, soon

from narrows.warning import settings
from narrows.warning.page.bridge_page import UPDATES, BridgePage

LONG = "x" * 2_000_000


@pytest.fixture
def page() -> Iterator[Any]:
    """A page that is open, and its address."""
    pytest.importorskip("websockets", reason="of the extra monitor")
    page = BridgePage()
    with page.open() as address:
        page.host, page.asked = address.removeprefix("http://").split("/?")
        yield page


def deaf(page: Any) -> socket.socket:
    """A client that reads nothing after it was let in."""
    line = socket.create_connection(("127.0.0.1", int(page.host.split(":")[1])))
    line.sendall(HANDSHAKE.format(path=f"{UPDATES}?{page.asked}", host=page.host, more="").encode())
    assert b"101" in line.recv(64)
    return line


def test_a_dead_browser_holds_up_neither_the_monitor_nor_another(page: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Over real sockets: one never reads what would fill it in a moment, the other hears the last word."""
    from websockets.sync.client import connect

    monkeypatch.setattr(settings, "SEND_TIMEOUT", 0.3)
    with deaf(page), connect(f"ws://{page.host}{UPDATES}?{page.asked}", max_size=None) as alive:
        assert soon(lambda: len(page._server.connections) == 2)
        start = time.monotonic()
        while len(page._server.connections) == 2 and time.monotonic() - start < 10.0:
            page.send({"kind": LONG})
            assert json.loads(alive.recv(2.0)) == {"kind": LONG}
        assert len(page._server.connections) == 1
        page.send({"kind": "last"})
        assert json.loads(alive.recv(2.0)) == {"kind": "last"}


def test_who_reads_slowly_is_not_given_what_came_meanwhile(page: Any) -> None:
    """A hundred messages while one is being sent; what is read later is that one, and the next that comes."""
    with deaf(page) as slow:
        assert soon(lambda: len(page._server.connections) == 1)
        (server_side,) = page._server.connections
        while not server_side.transport.get_write_buffer_size():
            page.send({"kind": LONG})
            soon(lambda: True)
        for number in range(100):
            page.send({"kind": f"old {number}"})
        slow.settimeout(0.5)
        heard = b""
        with contextlib.suppress(TimeoutError):
            while True:
                heard += slow.recv(1 << 20)
        page.send({"kind": "new"})
        heard += slow.recv(1 << 20)
    assert heard.endswith(b'xxx"}\x81\x0e{"kind":"new"}')


def test_who_comes_is_told_nothing_old(page: Any) -> None:
    """Who comes to a monitor that hangs is not told what was true before, as if it were now."""
    from websockets.sync.client import connect

    page.send({"kind": "old"})
    with connect(f"ws://{page.host}{UPDATES}?{page.asked}") as line:
        with pytest.raises(TimeoutError):
            line.recv(0.3)
        page.send({"kind": "new"})
        assert json.loads(line.recv(2.0)) == {"kind": "new"}


def test_a_page_that_is_not_open_tells_nobody() -> None:
    BridgePage().send({"kind": "update"})


def test_a_page_is_opened_again(page: Any) -> None:
    from websockets.sync.client import connect

    again = BridgePage("token")
    for _ in range(2):
        with again.open() as address:
            host, asked = address.removeprefix("http://").split("/?")
            with connect(f"ws://{host}{UPDATES}?{asked}") as line:
                assert soon(lambda: len(again._server.connections) == 1)
                again.send({"kind": "x"})
                assert json.loads(line.recv(2.0)) == {"kind": "x"}
