"""The server of the page: one uvicorn in a thread beside the monitor."""

import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Thread
from typing import TYPE_CHECKING

from narrows.errors import InputError, needs, reason

if TYPE_CHECKING:
    from fastapi import FastAPI

LOOPBACK = "127.0.0.1"
# Bytes of what a browser says; and between looks whether it is still there [s].
LARGEST, PINGED = 4096, 5.0
# That it may take to start or to end [s].
STARTING = 10.0


@contextmanager
def served(app: "FastAPI", host: str, port: int) -> Iterator[int]:
    """Serve an application; give the port."""
    with needs("monitor", "the monitor's page"):
        import uvicorn
    with _listening(host, port) as listening:
        config = uvicorn.Config(
            app, log_level="error", access_log=False, lifespan="off", ws="websockets-sansio", ws_max_size=LARGEST,
            ws_ping_interval=PINGED, ws_ping_timeout=PINGED, timeout_graceful_shutdown=1, server_header=False,
        )  # fmt: skip
        server = uvicorn.Server(config)
        thread = Thread(target=server.run, args=([listening],), daemon=True)
        thread.start()
        deadline = time.monotonic() + STARTING
        while not server.started and thread.is_alive() and time.monotonic() < deadline:
            time.sleep(0.01)
        try:
            yield int(listening.getsockname()[1])
        finally:
            server.should_exit = True
            thread.join(STARTING)


def _listening(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family)
    except (OSError, OverflowError) as error:
        raise InputError(
            f"the page cannot be served at {host}, port {port}: {reason(error)}; give another --port or --host"
        ) from None
