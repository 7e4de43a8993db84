"""Those who look on: each is told the newest, none is waited for.

The monitor leaves its newest message here and goes on. Who reads slowly misses the ones between; who does not read at
all for a while is let go. What is kept of an onlooker does not grow.
"""

import asyncio
import math
import time
from collections import deque
from collections.abc import Awaitable, Callable
from contextlib import suppress

from narrows.warning.settings import ANSWER_QUEUE, MOST_CLIENTS, SEND_INTERVAL, SEND_TIMEOUT

Send = Callable[[str], Awaitable[None]]


class _Call:
    """A function called in a loop, asked for in any thread: once, however often asked for, until it was called."""

    def __init__(self, loop: asyncio.AbstractEventLoop, function: Callable[[], None]) -> None:
        self.loop, self._function, self._waits = loop, function, False

    def __call__(self) -> None:
        if self._waits:  # A loop that is stuck is called once, and not for every message.
            return
        self._waits = True
        with suppress(RuntimeError):  # It is closed: there is nobody any more.
            self.loop.call_soon_threadsafe(self._run)

    def _run(self) -> None:
        self._waits = False
        self._function()


class Client:
    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self.awake, self.answers = asyncio.Event(), deque[str](maxlen=ANSWER_QUEUE)
        self.awake.set()
        self._wake = _Call(loop, self.awake.set)

    def answer(self, message: str) -> None:
        """Leave a message for this onlooker alone, in any thread."""
        self.answers.append(message)
        self._wake()


class Clients:
    def __init__(self, lasts: float = math.inf) -> None:
        self.lasts, self.newest, self.number = lasts, "", 0
        self._at = -math.inf
        self._all: set[Client] = set()
        self._call: _Call | None = None

    def __len__(self) -> int:
        return len(self._all)

    @property
    def full(self) -> bool:
        return len(self._all) >= MOST_CLIENTS

    def enter(self) -> Client:
        loop = asyncio.get_running_loop()
        if self._call is None or self._call.loop is not loop:
            self._call = _Call(loop, self._wake)
        client = Client(loop)
        self._all.add(client)
        return client

    def leave(self, client: Client) -> None:
        self._all.discard(client)

    def publish(self, message: str) -> None:
        """Leave the newest message, in any thread, without waiting for anything."""
        self.newest, self.number, self._at = message, self.number + 1, time.monotonic()
        if self._call is not None:
            self._call()

    async def tell(self, client: Client, send: Send) -> None:
        told = 0
        while True:
            await client.awake.wait()
            client.awake.clear()
            while client.answers:
                await asyncio.wait_for(send(client.answers.popleft()), SEND_TIMEOUT)
            if told != self.number and time.monotonic() - self._at <= self.lasts:
                told = self.number
                await asyncio.wait_for(send(self.newest), SEND_TIMEOUT)
            await asyncio.sleep(SEND_INTERVAL)

    def _wake(self) -> None:
        for client in self._all:
            client.awake.set()
