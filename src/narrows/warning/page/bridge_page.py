"""The page of a monitor: shows the status, takes commands."""

import asyncio
import hmac
import ipaddress
import json
import secrets
import socket
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from importlib.resources import files
from queue import Empty, Full, Queue
from threading import Thread
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import urlsplit

from narrows.errors import InputError, needs, reason
from narrows.warning import settings
from narrows.warning.alerts.alert import SITUATIONS, AlertDesk, AlertState
from narrows.warning.alerts.alert_sentences import acn, notifications
from narrows.warning.inputs.bridge_readings import Tick
from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
from narrows.warning.monitoring.bridge_status import BridgeStatus
from narrows.warning.page.page_updates import COMMANDS, Client, Clients, ending, packed, refusal, update_of
from narrows.web import asset

if TYPE_CHECKING:
    from fastapi import FastAPI, Response, WebSocket

UPDATES, SIGNAL_K = "/updates", "/signalk/v1/stream"
ENDED = "The watch has ended: nothing on this page is kept up to date."
# The server of the page: one uvicorn in a thread beside the monitor.
LOOPBACK = "127.0.0.1"
# Who may look on and acknowledge: whoever has the token, from a page of this server and of no other.
TOKEN_BYTES = 18


@dataclass(frozen=True)
class PageAccess:
    # That must be known; made anew unless given
    token: str = field(default_factory=lambda: secrets.token_urlsafe(TOKEN_BYTES), repr=False)

    def refusal(self, token: str, host: str, origin: str | None = None) -> str:
        """Return why somebody is refused, in a sentence; empty where nobody is."""
        if not _is_here(host):
            return NO_HOST
        if origin is not None and origin not in (f"http://{host}", f"https://{host}"):
            return NO_ORIGIN
        # In constant time, so that nobody can guess it letter by letter.
        return "" if hmac.compare_digest(token.encode(), self.token.encode()) else NO_TOKEN


class BridgePage:
    def __init__(self, access: PageAccess | None = None) -> None:
        self.access = access or PageAccess()
        self.updates, self.notices, self.requests = Clients(settings.OLDEST_UPDATE), Clients(), PageRequests()
        self._noticed: list[Any] = []
        # Clients of Signal K only listen here.
        notices = Stream(SIGNAL_K, self.notices, lambda text, client: None)
        self.app = page_app(self.access, Stream(UPDATES, self.updates, self._take), notices)

    @contextmanager
    def open(self, host: str = LOOPBACK, port: int = 0) -> Iterator[str]:
        """Serve the page; give its address, with the token."""
        with served(self.app, host, port) as at:
            yield f"http://{address_of(host)}:{at}/?token={self.access.token}"
            self.updates.publish(packed(ending(ENDED)))
            time.sleep(settings.FAREWELL * bool(self.updates))

    def watch(self, ticks: Iterable[Tick], monitored: BridgeMonitor) -> Iterator[Tick]:
        return self.requests.joined(ticks, monitored.desk)

    def publish(self, monitored: BridgeMonitor, status: BridgeStatus, since_1970: float) -> None:
        self.updates.publish(packed(update_of(monitored, status, since_1970)))
        notice = notifications(monitored.desk, since_1970)
        if (values := notice["updates"][0]["values"]) != self._noticed:
            self._noticed = values
            self.notices.publish(packed(notice))

    def _take(self, text: str, client: Client) -> None:
        self.requests.take(text, lambda why: client.answer(packed(refusal(why))))


def address_of(host: str) -> str:
    if host in ("0.0.0.0", "::", ""):
        return LOOPBACK
    return f"[{host}]" if ":" in host else host


# The page's application: one page, its scripts, updates over a websocket, notifications as Signal K has them.
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
# Receives the commands of a client.
Take = Callable[[str, Client], None]


class Stream(NamedTuple):
    path: str  # Path of the page
    clients: Clients  # Who receive updates
    take: Take  # Takes what they say


def page_app(access: PageAccess, *streams: Stream) -> "FastAPI":
    with needs("monitor", "the monitor's page"):
        from fastapi import FastAPI, Request
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    texts = {path.name: path.read_text(encoding="utf-8") for path in files(__package__).joinpath("assets").iterdir()}
    texts |= {name: asset(name) for name in SHARED}

    async def page(request: Request) -> Any:
        why = access.refusal(request.query_params.get("token", ""), request.headers.get("host", ""))
        return _response(why, ".txt", FORBIDDEN) if why else _response(texts["index.html"], ".html")

    async def part(name: str, request: Request) -> Any:
        # The package's own files are no secret: they need no token.
        known = name in texts and name != "index.html"
        absent = _response("There is no such file.", "", MISSING)
        return _response(texts[name], name[name.rindex(".") :]) if known else absent

    app.add_api_route("/", page, methods=["GET"])
    app.add_api_route("/assets/{name}", part, methods=["GET"])
    for stream in streams:
        app.add_api_websocket_route(stream.path, _route(access, stream))
    return app


def _response(text: str, suffix: str, status: int = 200) -> "Response":
    from fastapi import Response

    kind = f"{KINDS.get(suffix, 'text/plain')}; charset=utf-8"
    return Response(text, status, HEADERS, kind)


def _route(access: PageAccess, stream: Stream) -> Any:
    from fastapi import WebSocket

    async def route(websocket: WebSocket) -> None:
        token, heads = websocket.query_params.get("token", ""), websocket.headers
        why = access.refusal(token, heads.get("host", ""), heads.get("origin"))
        if why or stream.clients.full:
            refused = _response(why, "", FORBIDDEN) if why else _response(CROWDED, "", TOO_MANY)
            await websocket.send_denial_response(refused)
            return
        await websocket.accept()
        await _look_on(websocket, stream)

    return route


async def _look_on(websocket: "WebSocket", stream: Stream) -> None:
    client = stream.clients.enter()
    sending = asyncio.create_task(stream.clients.serve(client, websocket.send_text))
    receiving = asyncio.create_task(_hear(websocket, client, stream.take))
    try:
        await asyncio.wait({sending, receiving}, return_when=asyncio.FIRST_COMPLETED)
    finally:
        stream.clients.leave(client)
        sending.cancel(), receiving.cancel()
        await asyncio.gather(sending, receiving, return_exceptions=True)
        with suppress(Exception):  # However it ended: it is over.
            await asyncio.wait_for(websocket.close(), 1.0)


async def _hear(websocket: "WebSocket", client: Client, take: Take) -> None:
    async for text in websocket.iter_text():
        take(text, client)
        await asyncio.sleep(settings.SEND_INTERVAL)  # Who talks without pause waits: the monitor needs the machine.


@contextmanager
def served(app: "FastAPI", host: str, port: int) -> Iterator[int]:
    """Serve an application; give the port."""
    with needs("monitor", "the monitor's page"):
        import uvicorn
    with _listening(host, port) as listening:
        config = uvicorn.Config(
            app, http=guarded_protocol(), backlog=settings.MOST_CONNECTIONS,
            log_level="error", access_log=False, lifespan="off", ws="websockets-sansio",
            ws_max_size=settings.LARGEST_MESSAGE, ws_ping_interval=settings.PING_INTERVAL,
            ws_ping_timeout=settings.PING_INTERVAL, timeout_graceful_shutdown=1, server_header=False,
        )  # fmt: skip
        server = uvicorn.Server(config)
        thread = Thread(target=server.run, args=([listening],), daemon=True)
        thread.start()
        deadline = time.monotonic() + settings.SERVER_TIMEOUT
        while not server.started and thread.is_alive() and time.monotonic() < deadline:
            time.sleep(0.01)
        try:
            yield int(listening.getsockname()[1])
        finally:
            server.should_exit = True
            thread.join(settings.SERVER_TIMEOUT)


def guarded_protocol() -> Any:
    """Return the server's protocol with a cap on open connections and a time-out for requests that never end."""
    from uvicorn.protocols.http.h11_impl import H11Protocol

    class Guarded(H11Protocol):  # type: ignore[misc]
        def connection_made(self, transport: Any) -> None:
            super().connection_made(transport)
            if len(self.connections) > settings.MOST_CONNECTIONS:
                transport.abort()
            self.loop.call_later(settings.HEADER_TIMEOUT, self._let_go)

        def _let_go(self) -> None:
            if self.cycle is None and self.transport.get_protocol() is self:  # Neither asked nor a websocket by now.
                self.transport.abort()

    return Guarded


def _listening(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family)
    except (OSError, OverflowError) as error:
        raise InputError(
            f"the page cannot be served at {host}, port {port}: {reason(error)}; give another --port or --host"
        ) from None


NUMBERS = ("identifier", "instance", "revision")

MALFORMED = (
    'That is no request; write {"command": "acknowledge" or "silence", "identifier": ..., "instance": ..., '
    '"revision": ...}, the numbers as the alert has them.'
)

BUSY = "Too much is asked for at once; ask again."
# Told why, where a request is refused.
Answer = Callable[[str], None]


class PageRequest(NamedTuple):
    command: str  # One of ``COMMANDS``
    identifier: int  # Number of the alert as displayed
    instance: int  # Instance of the alert as displayed
    revision: int  # Revision of the alert as displayed


def request_of(text: str) -> PageRequest | None:
    if len(text) > settings.LONGEST_REQUEST:
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
    situation = SITUATIONS.get(request.identifier)
    if situation is None:
        return f"There is no alert {request.identifier}."
    alert = desk[situation]
    if alert.state is AlertState.NORMAL or alert.instance != request.instance:
        return f"{situation.name}: that alert is over."
    if alert.revision != request.revision:
        return f"{situation.name}: the alert has changed since it was asked for; look at it again."
    if alert.commanded(COMMANDS[request.command], t) is None:
        return f"{situation.name}: it is {alert.state.value}, so there is nothing to {request.command}."
    return ""


class PageRequests:
    def __init__(self) -> None:
        self._waiting: Queue[tuple[PageRequest, Answer]] = Queue(settings.REQUEST_QUEUE)

    def take(self, text: str, answer: Answer) -> None:
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
        for tick in ticks:
            yield tick._replace(commands=[*tick.commands, *self.sentences(desk, tick.t)])


NO_TOKEN = "The token is missing or wrong; open the address that the monitor printed when it started."
NO_HOST = "The monitor is reached by its number or as localhost, not by another name; open the address that it printed."
NO_ORIGIN = "A page of another server asks; open the monitor's own page."


def _is_here(host: str) -> bool:
    """Return whether a host is a number or a name of this machine: other names may be redirected here."""
    try:
        name = (urlsplit(f"//{host}").hostname or "").rstrip(".")
    except ValueError:
        return False
    own = socket.gethostname().lower()
    if name in ("localhost", own, f"{own}.local"):
        return True
    try:
        return bool(ipaddress.ip_address(name))
    except ValueError:
        return False
