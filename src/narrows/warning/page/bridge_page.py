"""The page of a monitor: told what is known, asked what was asked for."""

import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from narrows.warning.alerts.signal_k_notifications import notifications
from narrows.warning.hearing.tick import Tick
from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
from narrows.warning.monitoring.bridge_status import BridgeStatus
from narrows.warning.page.onlookers import Onlooker, Onlookers
from narrows.warning.page.page_access import PageAccess
from narrows.warning.page.page_app import Stream, page_app
from narrows.warning.page.page_requests import PageRequests
from narrows.warning.page.page_server import LOOPBACK, served
from narrows.warning.page.page_updates import ending, packed, refusal, update_of

UPDATES, SIGNAL_K = "/updates", "/signalk/v1/stream"
ENDED = "The watch has ended: nothing on this page is kept up to date."
# What is older is told to no page [s]: it would look new there.
OLD = 2.0
# For the last words to arrive [s].
FAREWELL = 0.3


class BridgePage:
    """What a monitor tells its page, and what the page asks of it."""

    def __init__(self, access: PageAccess | None = None) -> None:
        self.access = access or PageAccess()
        self.updates, self.notices, self.requests = Onlookers(OLD), Onlookers(), PageRequests()
        self._noticed: list[Any] = []
        streams = Stream(UPDATES, self.updates, self._take), Stream(SIGNAL_K, self.notices, _ignore)
        self.app = page_app(self.access, *streams)

    @contextmanager
    def open(self, host: str = LOOPBACK, port: int = 0) -> Iterator[str]:
        """Serve the page; give its address, with the token."""
        with served(self.app, host, port) as at:
            yield f"http://{address_of(host)}:{at}/?token={self.access.token}"
            self.updates.publish(packed(ending(ENDED)))
            time.sleep(FAREWELL * bool(self.updates))

    def watch(self, ticks: Iterable[Tick], watched: BridgeMonitor) -> Iterator[Tick]:
        """Yield ticks with what was asked for on the page."""
        return self.requests.joined(ticks, watched.desk)

    def tell(self, watched: BridgeMonitor, status: BridgeStatus, since_1970: float) -> None:
        """Show what is known."""
        # since_1970 [s]
        self.updates.publish(packed(update_of(watched, status, since_1970)))
        notice = notifications(watched.desk, since_1970)
        if (values := notice["updates"][0]["values"]) != self._noticed:
            self._noticed = values
            self.notices.publish(packed(notice))

    def _take(self, text: str, onlooker: Onlooker) -> None:
        self.requests.take(text, lambda why: onlooker.answer(packed(refusal(why))))


def address_of(host: str) -> str:
    """Return a host as it stands in an address that can be opened on this machine."""
    if host in ("0.0.0.0", "::", ""):
        return LOOPBACK
    return f"[{host}]" if ":" in host else host


def _ignore(text: str, onlooker: Onlooker) -> None:
    """What Signal K's clients say is theirs: they only listen here."""
