"""The page's application: one page, its scripts, updates over a websocket, notifications as Signal K has them."""

import asyncio
from collections.abc import Callable
from contextlib import suppress
from importlib.resources import files
from typing import TYPE_CHECKING, Any, NamedTuple

from narrows.errors import needs
from narrows.warning.page.onlookers import SHORTEST, Onlooker, Onlookers
from narrows.warning.page.page_access import PageAccess
from narrows.web.assets import asset

if TYPE_CHECKING:
    from fastapi import FastAPI, Response, WebSocket

SHARED = ("canal.js", "palette.css")
KINDS = {".js": "text/javascript", ".css": "text/css", ".html": "text/html"}
# Nothing from elsewhere, nothing kept, and the token told to nobody.
HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
CROWDED = "As many look on as there is room for; close another page first."
FORBIDDEN, MISSING, TOO_MANY = 403, 404, 503
# Takes what an onlooker says.
Take = Callable[[str, Onlooker], None]


class Stream(NamedTuple):
    """A websocket of the application."""

    path: str  # Where it is
    onlookers: Onlookers  # Who are told
    take: Take  # Takes what they say


def page_app(access: PageAccess, *streams: Stream) -> "FastAPI":
    """Return the application."""
    with needs("monitor", "the monitor's page"):
        from fastapi import FastAPI, Request
    app, texts = FastAPI(docs_url=None, redoc_url=None, openapi_url=None), _texts()

    async def page(request: Request) -> Any:
        why = access.refusal(request.query_params.get("token", ""), request.headers.get("host", ""))
        return _told(why, ".txt", FORBIDDEN) if why else _told(texts["index.html"], ".html")

    async def part(name: str, request: Request) -> Any:
        # The package's own files are no secret: they need no token.
        known = name in texts and name != "index.html"
        return _told(texts[name], name[name.rindex(".") :]) if known else _told("There is no such file.", "", MISSING)

    app.add_api_route("/", page, methods=["GET"])
    app.add_api_route("/assets/{name}", part, methods=["GET"])
    for stream in streams:
        app.add_api_websocket_route(stream.path, _route(access, stream))
    return app


def _texts() -> dict[str, str]:
    own = files(__package__).joinpath("assets").iterdir()
    return {path.name: path.read_text(encoding="utf-8") for path in own} | {name: asset(name) for name in SHARED}


def _told(text: str, suffix: str, status: int = 200) -> "Response":
    from fastapi import Response

    kind = f"{KINDS.get(suffix, 'text/plain')}; charset=utf-8"
    return Response(text, status, HEADERS, kind)


def _route(access: PageAccess, stream: Stream) -> Any:
    from fastapi import WebSocket

    async def route(websocket: WebSocket) -> None:
        told, heads = websocket.query_params.get("token", ""), websocket.headers
        why = access.refusal(told, heads.get("host", ""), heads.get("origin"))
        if why or stream.onlookers.full:
            refused = _told(why, "", FORBIDDEN) if why else _told(CROWDED, "", TOO_MANY)
            await websocket.send_denial_response(refused)
            return
        await websocket.accept()
        await _look_on(websocket, stream)

    return route


async def _look_on(websocket: "WebSocket", stream: Stream) -> None:
    """Tell one, and hear what it says, until one of the two ends."""
    onlooker = stream.onlookers.enter()
    telling = asyncio.create_task(stream.onlookers.tell(onlooker, websocket.send_text))
    hearing = asyncio.create_task(_hear(websocket, onlooker, stream.take))
    try:
        await asyncio.wait({telling, hearing}, return_when=asyncio.FIRST_COMPLETED)
    finally:
        stream.onlookers.leave(onlooker)
        telling.cancel(), hearing.cancel()
        await asyncio.gather(telling, hearing, return_exceptions=True)
        with suppress(Exception):  # However it ended: it is over.
            await asyncio.wait_for(websocket.close(), 1.0)


async def _hear(websocket: "WebSocket", onlooker: Onlooker, take: Take) -> None:
    async for text in websocket.iter_text():
        take(text, onlooker)
        await asyncio.sleep(SHORTEST)  # Who talks without pause waits: the monitor needs the machine.
