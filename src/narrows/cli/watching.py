"""``monitor``: from what a bridge tells to alerts of the banks."""

import math
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from narrows.cli.delivery import ReportDelivery
from narrows.cli.grouped import verb
from narrows.cli.keyboard import HINT, with_keys
from narrows.cli.options import WaterwayFile
from narrows.cli.output import named
from narrows.errors import InputError

if TYPE_CHECKING:
    from narrows.warning.hearing.tick import Tick
    from narrows.warning.monitoring.alert_publisher import AlertPublisher
    from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
    from narrows.warning.monitoring.bridge_status import BridgeStatus
    from narrows.warning.monitoring.watched_transit import WatchedTransit

SAID_EVERY = 10
"""Seconds between lines where nothing changes."""
COLOURS = {"caution": "yellow", "warning": "yellow", "alarm": "red", "emergency alarm": "magenta"}
USUAL_SPEED = 4.0
"""With which kernels are compiled [m/s]."""


@dataclass(frozen=True)
class HearingOptions:
    """What is listened to."""

    listen: Annotated[
        list[str] | None,
        typer.Option(help="udp://:10110, tcp://HOST:PORT, serial:///dev/ttyUSB0?baud=4800, ws://HOST:3000; again."),
    ] = None
    replay: Annotated[Path | None, typer.Option(help="A recording of NMEA 0183 to hear again.")] = None
    demo: Annotated[bool, typer.Option("--demo", help="A simulated bridge: a mistake at the helm by a bank.")] = False
    pace: Annotated[float, typer.Option(help="Of --replay and --demo: times real time; as fast as it goes.")] = math.inf
    mmsi: Annotated[int | None, typer.Option(help="Whose AIS reports to read; the ship's own unless given.")] = None
    antenna: Annotated[str, typer.Option(help="Of the position [m]: forward,starboard of midship.")] = "0,0"


@dataclass(frozen=True)
class AlertOptions:
    """Where alerts go."""

    log: Annotated[Path | None, typer.Option(help="Log of alerts, on disk before they are sent: .db.")] = None
    send: Annotated[str | None, typer.Option(help="Where ALF, ALC, HBT and ARC go: udp://HOST:PORT.")] = None
    recording: Annotated[
        Path | None, typer.Option(help="Write what --demo tells, for --replay: .nmea.", callback=named((".nmea",)))
    ] = None


@verb("narrows monitor full.toml --waterway canal.geojson --listen udp://:10110 --log alerts.db")
def monitor(
    hearing: HearingOptions,
    alerts: AlertOptions,
    delivery: ReportDelivery,
    model: Annotated[
        str | None, typer.Argument(help="Model file; none for --demo.", show_default=False, metavar="[MODEL]")
    ] = None,
    waterway: WaterwayFile = None,
    y: Annotated[float, typer.Option(help="Line that a pilot who takes over brings the ship to [m].")] = 0.0,
) -> None:
    """Watch a ship beside the banks of its waterway, and warn: decision support, no type-approved equipment.

    MODEL is a model file at the ship's own size, with the terms of a rudder; the waterway knows where on earth it is.
    Leaves with 1 where a recording or the demonstration came to a warning or more.
    """
    _check(hearing, alerts, model, waterway)
    with ExitStack() as stack:
        publisher = _publisher(alerts, stack)
        if hearing.demo:
            transit = _demonstrated(hearing, alerts, publisher, delivery.json)
        else:
            watched = _monitor_of(model or "", waterway, hearing, y, publisher)
            transit = _watched(watched, _heard(hearing, stack), delivery.json)
    _deliver(transit, delivery)
    raise SystemExit(int(not hearing.listen and transit.level.words not in ("none", "caution")))


def _check(hearing: HearingOptions, alerts: AlertOptions, model: str | None, waterway: Path | None) -> None:
    if sum(map(bool, (hearing.listen, hearing.replay, hearing.demo))) != 1:
        raise InputError("give --listen with an address, --replay with a recording, or --demo; one of them")
    if hearing.demo and (model or waterway):
        raise InputError("--demo has a ship and a canal of its own; leave MODEL and --waterway out")
    if not hearing.demo and not (model and waterway):
        raise InputError("a bridge tells longitude and latitude: give MODEL and --waterway; --demo alone has its own")
    if alerts.recording and not hearing.demo:
        raise InputError("--recording writes what --demo tells; leave it out")
    if not hearing.pace > 0:
        raise InputError(f"--pace {hearing.pace:g} is no pace; give times real time, over 0")


def _publisher(alerts: AlertOptions, stack: ExitStack) -> "AlertPublisher":
    from narrows.warning.alerts.alert_log import AlertLog
    from narrows.warning.monitoring.alert_publisher import AlertPublisher, sender_to

    log = stack.enter_context(AlertLog(alerts.log)) if alerts.log else None
    return AlertPublisher(log, stack.enter_context(sender_to(alerts.send)) if alerts.send else None)


def _monitor_of(
    model: str, waterway: Path | None, hearing: HearingOptions, y: float, publisher: "AlertPublisher"
) -> "BridgeMonitor":
    from narrows.cli.ranges import numbers
    from narrows.model.model_file import model_named
    from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
    from narrows.waterway import read_waterway

    antenna = numbers("--antenna", hearing.antenna)
    if len(antenna) != 2:
        raise InputError(f"--antenna {hearing.antenna}: give metres forward and to starboard, as in -70,6")
    place = float(antenna[0]), float(antenna[1])
    return BridgeMonitor(model_named(model), read_waterway(str(waterway)), y, place, publisher=publisher)


def _heard(hearing: HearingOptions, stack: ExitStack) -> Iterator["Tick"]:
    if hearing.replay:
        from narrows.warning.hearing.replay import Replay

        if not hearing.replay.is_file():
            raise InputError(f"{hearing.replay}: there is no such file; check the path")
        return Replay(hearing.replay, hearing.pace, hearing.mmsi).ticks()
    from narrows.warning.hearing.connections import connection_of
    from narrows.warning.hearing.listening import Listening

    return stack.enter_context(Listening([*map(connection_of, hearing.listen or ())], hearing.mmsi)).ticks()


def _demonstrated(
    hearing: HearingOptions, alerts: AlertOptions, publisher: "AlertPublisher", json: bool
) -> "WatchedTransit":
    from narrows.files import write_whole
    from narrows.progress import stage
    from narrows.warning.hearing.replay import paced
    from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
    from narrows.warning.monitoring.demonstration import LINE, demonstration

    with stage("a ship from the bundled tests, and a transit of it"):
        shown = demonstration()
    if alerts.recording:
        write_whole(alerts.recording, shown.bridge.recording())
    watched = BridgeMonitor(shown.model, shown.waterway, LINE, publisher=publisher)
    return _watched(watched, paced(shown.ticks(), hearing.pace), json)


def _watched(watched: "BridgeMonitor", ticks: Iterable["Tick"], json: bool) -> "WatchedTransit":
    """Watch until there is nothing more to hear, or until it is interrupted."""
    import time

    from narrows.progress import stage
    from narrows.warning.monitoring.watched_transit import TransitLog

    with stage("compiling what is not compiled yet"):
        watched.prepare(USUAL_SPEED)
    if not json and sys.stdin.isatty():
        typer.echo(HINT)
        ticks = with_keys(ticks, watched)
    log = TransitLog(watched.model.configuration.ship.name or "A ship", watched.waterway.name)
    with suppress(KeyboardInterrupt):
        for number, tick in enumerate(ticks):
            status = watched.update(tick, time.time())
            log.add(status)
            if not json:
                _say(number, status)
    return log.transit()


def _say(number: int, status: "BridgeStatus") -> None:
    """What changed; and now and then how it is."""
    for alert in status.changed:
        said = f"{number:6d} s  {alert.priority.words}, {alert.state.value}: {alert.text}"
        bell = "\a" if alert.sounds and sys.stdout.isatty() else ""
        typer.secho(bell + said, fg=COLOURS.get(alert.priority.words), bold=alert.sounds)
    if number % SAID_EVERY == 0:
        typer.echo(f"{number:6d} s  {status.line()}")


def _deliver(transit: "WatchedTransit", delivery: ReportDelivery) -> None:
    from narrows.report.transit_report import write_transit_report

    delivery.write(transit.save)
    if delivery.report:
        write_transit_report(transit, delivery.report)

    def words() -> None:
        typer.echo("\n".join([transit.summary(), *transit.notes]))

    delivery.tell(transit.to_dict, words)
