"""Where ``monitor`` tells what is known, beside the terminal: sentences, Signal K, a log, a page in a browser."""

from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from narrows.cli.output import named
from narrows.errors import InputError

if TYPE_CHECKING:
    from narrows.warning.hearing.tick import Tick
    from narrows.warning.monitoring.alert_publisher import AlertPublisher
    from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
    from narrows.warning.monitoring.bridge_status import BridgeStatus

SIGNAL_K = ("ws://", "wss://")
LOOPBACK, PORT = "127.0.0.1", 8765
Tell = Callable[["BridgeMonitor", "BridgeStatus", float], None]
Ask = Callable[[Iterable["Tick"], "BridgeMonitor"], Iterable["Tick"]]


@dataclass(frozen=True)
class AlertOptions:
    """Where alerts go."""

    log: Annotated[Path | None, typer.Option(help="Log of alerts, on disk before they are sent: .db.")] = None
    send: Annotated[
        list[str] | None,
        typer.Option(help="ALF, ALC, HBT and ARC to udp://HOST:PORT; Signal K notifications to ws://HOST:3000; again."),
    ] = None
    recording: Annotated[
        Path | None, typer.Option(help="Write what --demo tells, for --replay: .nmea.", callback=named((".nmea",)))
    ] = None


@dataclass(frozen=True)
class PageOptions:
    """The page in a browser."""

    page: Annotated[bool, typer.Option("--page", help="Show it in a browser too: prints the address.")] = False
    port: Annotated[int, typer.Option(help="Of --page.", min=0, max=65_535)] = PORT
    host: Annotated[
        str, typer.Option(help="Of --page: this machine alone unless given; 0.0.0.0 for all who reach it.")
    ] = LOOPBACK


@dataclass
class Outlets:
    """Those who are told at every update, and those who are asked before it."""

    told: list[Tell] = field(default_factory=list)
    asked: list[Ask] = field(default_factory=list)

    def tell(self, watched: "BridgeMonitor", status: "BridgeStatus", since_1970: float) -> None:
        """Tell all."""
        for tell in self.told:
            tell(watched, status, since_1970)

    def ask(self, ticks: Iterable["Tick"], watched: "BridgeMonitor") -> Iterable["Tick"]:
        """Ask all for their commands."""
        for ask in self.asked:
            ticks = ask(ticks, watched)
        return ticks


def publisher_of(alerts: AlertOptions, stack: ExitStack) -> "AlertPublisher":
    """What logs alerts and sends their sentences."""
    from narrows.warning.alerts.alert_log import AlertLog
    from narrows.warning.monitoring.alert_publisher import AlertPublisher, sender_to

    log = stack.enter_context(AlertLog(alerts.log)) if alerts.log else None
    addresses = [address for address in alerts.send or () if not address.startswith(SIGNAL_K)]
    sends = [stack.enter_context(sender_to(address)) for address in addresses]

    def send(sentence: str) -> None:
        for each in sends:
            each(sentence)

    return AlertPublisher(log, send)


def outlets_of(alerts: AlertOptions, page: PageOptions, stack: ExitStack) -> Outlets:
    """What else is told: Signal K's servers, and the page."""
    if not page.page and (page.host, page.port) != (LOOPBACK, PORT):
        raise InputError("--host and --port are those of the page; give --page too")
    outlets = Outlets()
    for address in alerts.send or ():
        if address.startswith(SIGNAL_K):
            outlets.told.append(_to_signal_k(address, stack))
    if page.page:
        _open_page(page, outlets, stack)
    return outlets


def _to_signal_k(address: str, stack: ExitStack) -> Tell:
    from narrows.warning.monitoring.signal_k_sender import SignalKSender

    sender = stack.enter_context(SignalKSender(address))
    return lambda watched, status, since_1970: sender.tell(watched.desk, since_1970)


def _open_page(page: PageOptions, outlets: Outlets, stack: ExitStack) -> None:
    from narrows.warning.page.bridge_page import BridgePage

    shown = BridgePage()
    address = stack.enter_context(shown.open(page.host, page.port))
    typer.secho(f"The page: {address}", err=True, bold=True)
    outlets.told.append(shown.tell)
    outlets.asked.append(shown.watch)
