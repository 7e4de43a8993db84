"""The page of a monitor: shows the status, takes commands; the schema of its messages is `messages.json`."""

import asyncio
import hmac
import json
import logging
import secrets
import socket
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib.resources import files
from queue import Full, Queue
from threading import Event, Thread
from typing import Any, NamedTuple
from urllib.parse import parse_qs, urlsplit

import numpy as np

from narrows.base.errors import InputError, needs, reason
from narrows.base.files import plain
from narrows.warning import settings
from narrows.warning.alerts.alert import AlertCommand, AlertDesk, Command
from narrows.warning.inputs.bridge_readings import Tick
from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
from narrows.warning.monitoring.watched_transit import BridgeStatus
from narrows.waterway.waterway import Section
from narrows.web import asset

# Commands of the page, by the word in its messages.
COMMANDS = {"acknowledge": Command.ACKNOWLEDGE, "silence": Command.SILENCE}


def update_of(monitored: BridgeMonitor, status: BridgeStatus, since_1970: float) -> dict[str, Any]:
    update = status.to_dict()
    for alert, shown in zip(status.alerts, update["alerts"], strict=True):
        may = [name for name, command in COMMANDS.items() if alert.commanded(command, status.t) is not None]
        shown |= {"sounds": alert.sounds, "may": may}
    names = {"ship": monitored.model.configuration.ship.name or "A ship", "waterway": monitored.waterway.name}
    return {"kind": "update", "at": since_1970, **names, **update, "scene": scene(monitored, status)}


def packed(message: Mapping[str, Any]) -> str:
    return json.dumps(plain(message), separators=(",", ":"), allow_nan=False)


# The page draws the ship, the banks about it, and its forecast tracks, in metres east and north.
# Length of bank drawn astern and ahead of the ship, and distance between points [m].
ASTERN, AHEAD, EVERY = 800.0, 2400.0, 20.0
# Digits that are sent: a decimetre north and east, a ten-thousandth of a radian.
DIGITS = np.array([10.0, 10.0, 1e4])


def scene(monitored: BridgeMonitor, status: BridgeStatus) -> dict[str, Any] | None:
    """Return what the page draws, points as [north, east] [m], poses with a heading [rad]; None without a position."""
    if not status.estimate.ready:
        return None
    way, ship, now = monitored.waterway, monitored.model.configuration.ship, status.estimate.values
    pose, along = [now[name] for name in ("x", "y", "psi")], min(max(now["x"], 0.0), way.line.length)
    first, last = max(along - ASTERN, 0.0), min(along + AHEAD, way.line.length)
    s = np.linspace(first, last, max(2, round((last - first) / EVERY) + 1))

    def drawn(place: Any, offset: Any, psi: Any = 0.0) -> Any:
        positions, headings = way.to_map(place, offset, psi)
        poses = np.concatenate([positions[..., ::-1], headings[..., None]], axis=-1)
        return np.round(poses * DIGITS) / DIGITS

    def sides(here: Section) -> list[Any]:
        return [drawn(s, here.middle + side * here.width / 2)[:, :2].tolist() for side in (-1, 1)]

    fan, tracks = None, status.forecast.tracks if status.forecast else None
    if tracks is not None and np.isfinite([tracks.as_is, tracks.escape]).all():
        whole = tracks.fan[np.isfinite(tracks.fan).all(axis=(1, 2))]  # A ship that diverges has no place.
        fan = {
            "times": tracks.times.tolist(),
            "members": drawn(*np.moveaxis(np.insert(whole, 0, pose, axis=1), -1, 0))[..., :2].tolist(),
            "likely": drawn(*tracks.as_is.T).tolist(), "escape": drawn(*tracks.escape.T).tolist(),
        }  # fmt: skip
    return {
        "ship": {"pose": drawn(*pose).tolist(), "length": ship.length, "beam": ship.beam},
        "middle": drawn(along, way.section(along, ship.draft).middle).tolist(),
        "banks": sides(way.section(s)), "limits": sides(way.section(s, ship.draft)), "fan": fan,
    }  # fmt: skip


UPDATES = "/updates"
ENDED = "The watch has ended: nothing on this page is kept up to date."
LOOPBACK = "127.0.0.1"
SHARED = ("canal.js", "palette.css")
KINDS = {".js": "text/javascript", ".css": "text/css", ".html": "text/html"}
# Nothing from elsewhere, nothing kept, and the token sent to nobody.
HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
CROWDED = "As many look on as there is room for; close another page first."
FORBIDDEN, MISSING, TOO_MANY = 403, 404, 503
# Browsers that break off are no errors of the monitor.
LOGGER = logging.Logger("narrows.page", logging.CRITICAL)
# Who may look on and acknowledge: whoever has the token, from a page of this server and of no other.
TOKEN_BYTES = 18


def refusal(known: str, token: str, host: str, origin: str | None = None) -> str:
    """Return why somebody with a token is refused, in a sentence; empty where nobody is."""
    if origin is not None and origin not in (f"http://{host}", f"https://{host}"):
        return NO_ORIGIN
    # In constant time, so that nobody can guess it letter by letter.
    return "" if hmac.compare_digest(token.encode(), known.encode()) else NO_TOKEN


# Told why, where a request is refused.
Answer = Callable[[str], None]


class BridgePage:
    def __init__(self, token: str = "") -> None:
        self.token, self.requests = token or secrets.token_urlsafe(TOKEN_BYTES), PageRequests()
        self._server: Any = None  # While the page is open
        self._late: dict[Any, float] = {}  # Clients that have not read the last update, and since when [s]
        folder = files(__package__).joinpath("assets")
        self._texts = {f"/assets/{path.name}": path.read_text(encoding="utf-8") for path in folder.iterdir()}
        self._texts |= {f"/assets/{name}": asset(name) for name in SHARED}
        self._index = self._texts.pop("/assets/index.html")

    @contextmanager
    def open(self, host: str = LOOPBACK, port: int = 0) -> Iterator[str]:
        """Serve the page in a thread beside the monitor; give its address, with the token."""
        with needs("monitor", "the monitor's page"):
            from websockets.asyncio.server import serve

        started, ended = Event(), asyncio.Event()

        async def run() -> None:
            async with serve(
                self._attend, sock=listening, process_request=self._respond, create_connection=capped_connection(),
                open_timeout=settings.HEADER_TIMEOUT, ping_interval=settings.PING_INTERVAL,
                ping_timeout=settings.PING_INTERVAL, close_timeout=1.0, max_size=settings.LARGEST_MESSAGE,
                server_header=None, logger=LOGGER,
            ) as self._server:  # fmt: skip
                started.set()
                await ended.wait()

        with _listening(host, port) as listening:
            thread = Thread(target=lambda: asyncio.run(run()), daemon=True)
            thread.start()
            started.wait(settings.SERVER_TIMEOUT)
            loop = self._server.get_loop()
            try:
                yield f"http://{address_of(host)}:{listening.getsockname()[1]}/?token={self.token}"
                self.send({"kind": "ended", "sentence": ENDED})
                time.sleep(settings.FAREWELL)
            finally:
                loop.call_soon_threadsafe(ended.set)
                thread.join(settings.SERVER_TIMEOUT)
                self._server = None

    def publish(self, monitored: BridgeMonitor, status: BridgeStatus, since_1970: float) -> None:
        self.send(update_of(monitored, status, since_1970))

    def send(self, message: Mapping[str, Any], to: Any = None) -> None:
        """Send a message to one client or to all, from any thread, without waiting for anything."""
        if self._server:
            self._server.get_loop().call_soon_threadsafe(self._spread, packed(message), to)

    def _spread(self, text: str, to: Any) -> None:
        from websockets.asyncio.server import broadcast

        now, clients = time.monotonic(), self._server.connections
        # Who has not read the last update is given no other, which would look new when it comes, and is let go at last.
        late = {one: self._late.get(one, now) for one in clients if one.transport.get_write_buffer_size()}
        for one, since in late.items():
            if now - since > settings.SEND_TIMEOUT:
                one.transport.abort()
        self._late = late
        broadcast([to] if to else clients - late.keys(), text)

    def _respond(self, connection: Any, request: Any) -> Any:
        """Answer what asks for no updates, or for none that it may have."""
        asked, heads = urlsplit(request.path), request.headers
        if asked.path in self._texts:  # The package's own files are no secret: they need no token.
            return _response(connection, 200, self._texts[asked.path], asked.path[asked.path.rindex(".") :])
        if asked.path not in ("/", UPDATES):
            return _response(connection, MISSING, "There is no such file.")
        token = parse_qs(asked.query).get("token", [""])[0]
        if why := refusal(self.token, token, heads.get("Host", ""), heads.get("Origin")):
            return _response(connection, FORBIDDEN, why)
        if asked.path == "/":
            return _response(connection, 200, self._index, ".html")
        crowded = len(self._server.connections) >= settings.MOST_CLIENTS
        return _response(connection, TOO_MANY, CROWDED) if crowded else None

    async def _attend(self, connection: Any) -> None:
        async for text in connection:
            self.requests.take(text, lambda why: self.send({"kind": "refused", "sentence": why}, connection))
            # Who talks without pause waits: the monitor needs the machine.
            await asyncio.sleep(settings.REQUEST_INTERVAL)


def address_of(host: str) -> str:
    if host in ("0.0.0.0", "::", ""):
        return LOOPBACK
    return f"[{host}]" if ":" in host else host


def _response(connection: Any, status: int, text: str, suffix: str = "") -> Any:
    response = connection.respond(status, text)
    del response.headers["Content-Type"]
    response.headers.update({**HEADERS, "Content-Type": f"{KINDS.get(suffix, 'text/plain')}; charset=utf-8"})
    return response


def capped_connection() -> Any:
    """Return the server's connection with a cap on how many are open: requests that never end exhaust nothing."""
    from websockets.asyncio.server import ServerConnection

    class Capped(ServerConnection):  # type: ignore[misc]
        count = 0

        def connection_made(self, transport: Any) -> None:
            super().connection_made(transport)
            Capped.count += 1
            if Capped.count > settings.MOST_CONNECTIONS:
                transport.abort()

        def connection_lost(self, error: Exception | None) -> None:
            Capped.count -= 1
            super().connection_lost(error)

    return Capped


def _listening(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family)
    except (OSError, OverflowError) as error:
        raise InputError(
            f"the page cannot be served at {host}, port {port}: {reason(error)}; give another --port or --host"
        ) from None


MALFORMED = (
    'That is no request; write {"command": "acknowledge" or "silence", "identifier": ..., "instance": ..., '
    '"revision": ...}, the numbers as the alert has them.'
)
BUSY = "Too much is asked for at once; ask again."


class PageRequest(NamedTuple):
    command: str  # One of ``COMMANDS``
    identifier: int  # Number of the alert as displayed
    instance: int  # Instance of the alert as displayed
    revision: int  # Revision of the alert as displayed


def request_of(text: str) -> PageRequest | None:
    if len(text) > settings.LONGEST_REQUEST:
        return None
    try:
        request = PageRequest(**json.loads(text))
        known = request.command in COMMANDS and all(type(number) is int for number in request[1:])
    except (ValueError, TypeError, RecursionError):
        return None
    return request if known else None


def objection(request: PageRequest, desk: AlertDesk, t: float) -> str:
    """Return why a request is refused, in a sentence; empty where it is not."""
    for alert in desk.alerts:
        if (alert.identifier, alert.instance, alert.revision) == request[1:]:
            possible = alert.commanded(COMMANDS[request.command], t)
            return "" if possible else f"The alert is {alert.state.value}, so there is nothing to {request.command}."
    return "That alert is over, or has changed since it was asked for; look at it again."


class PageRequests:
    def __init__(self) -> None:
        self._waiting: Queue[tuple[PageRequest, Answer]] = Queue(settings.REQUEST_QUEUE)

    def take(self, text: str, answer: Answer) -> None:
        request = request_of(text)
        try:
            answer(MALFORMED) if request is None else self._waiting.put_nowait((request, answer))
        except Full:
            answer(BUSY)

    def commands(self, desk: AlertDesk, t: float) -> list[AlertCommand]:
        """Return what is asked for, and answer what is refused."""
        said: list[AlertCommand] = []
        while not self._waiting.empty():
            request, answer = self._waiting.get_nowait()
            if why := objection(request, desk, t):
                answer(why)
            else:
                said.append(AlertCommand(request.identifier, request.instance, COMMANDS[request.command]))
        return said

    def joined(self, ticks: Iterable[Tick], desk: AlertDesk) -> Iterator[Tick]:
        for tick in ticks:
            yield tick._replace(commands=[*tick.commands, *self.commands(desk, tick.t)])


NO_TOKEN = "The token is missing or wrong; open the address that the monitor printed when it started."
NO_ORIGIN = "A page of another server asks; open the monitor's own page."
