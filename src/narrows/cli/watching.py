"""``monitor``: alerts of bank effects from a ship's own readings."""

import math
import signal
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

import narrows as nw
from narrows.base.errors import InputError
from narrows.base.files import write_whole
from narrows.base.progress import stage
from narrows.cli.options import Argument, Option, ReportDelivery, WaterwayFile, numbers, verb
from narrows.empirical.fleet import model_named

if TYPE_CHECKING:
    from narrows.warning.inputs.bridge_readings import Tick
    from narrows.warning.monitoring.alert_publisher import AlertPublisher
    from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
    from narrows.warning.monitoring.watched_transit import BridgeStatus, TransitLog
    from narrows.warning.page.bridge_page import BridgePage

STATUS_EVERY = 10  # Time between lines of status [s]
COLOURS = {"caution": "yellow", "warning": "yellow", "alarm": "red", "emergency alarm": "magenta"}
OWN_SIZE = "Model file at the ship's own size, with a rudder; none for --demo."
USUAL_SPEED = 4.0  # Speed for compiling the kernels [m/s]


@dataclass(frozen=True)
class InputOptions:
    listen: Annotated[list[str] | None, "udp://:10110, tcp://HOST:PORT, serial:///dev/ttyUSB0?baud=4800; again."] = None
    replay: Annotated[Path | None, "A recording of NMEA 0183 to replay."] = None
    score: Annotated[list[Path] | None, "A recording, each a transit, to score; again."] = None
    demo: Annotated[bool, "A simulated bridge with a steering error near a bank."] = False
    pace: Annotated[float | None, "With --replay, --demo: times real time; default: fastest, with --page 1."] = None
    commands_from: Annotated[list[str] | None, "Host or device that may acknowledge (ACN); default: none; again."] = (
        None
    )
    mmsi: Annotated[int | None, "MMSI of the AIS reports to read; default: the ship's own."] = None
    antenna: Annotated[str, "Position of the antenna [m]: forward,starboard of midship."] = "0,0"


RECORDING = Option(help="Write the messages of --demo, for --replay: .nmea.", forms=(".nmea",))


@dataclass(frozen=True)
class AlertOptions:
    log: Annotated[Path | None, "Log of alerts, written before they are sent: .db."] = None
    send: Annotated[list[str] | None, "ALF, ALC, HBT and ARC to udp://HOST:PORT; again."] = None
    recording: Annotated[Path | None, RECORDING] = None


@dataclass(frozen=True)
class PageOptions:
    page: Annotated[bool, "Show it in a browser too: prints the address."] = False
    port: Annotated[int, Option(help="With --page: its port.", type=click.IntRange(0, 65_535))] = 8765
    host: Annotated[str, "With --page: network address; default: this machine alone; 0.0.0.0 for all."] = "127.0.0.1"


@verb(
    "narrows monitor full.toml --waterway canal.geojson --listen udp://:10110 --log alerts.db",
    needs={"recording": "demo", "host port": "page"},
    one=("listen replay score demo", "model demo", "waterway demo"), apart=("score output", "score report"),
)  # fmt: skip
def monitor(
    inputs: InputOptions,
    alerts: AlertOptions,
    page: PageOptions,
    delivery: ReportDelivery,
    model: Annotated[str | None, Argument(help=OWN_SIZE, metavar="[MODEL]")] = None,
    waterway: WaterwayFile = None,
    y: Annotated[float, "Offset to which the escape manoeuvre steers the ship [m]."] = 0.0,
) -> None:
    """Watch a ship beside the banks, and warn.

    It is decision support, not type-approved equipment; the waterway is in map coordinates.
    Leaves with 1 where a recording or the demonstration came to a warning or more.
    """
    from narrows.report.transit_report import write_transit_report
    from narrows.warning.monitoring.watched_transit import TransitLog

    if inputs.pace is not None and not inputs.pace > 0:
        raise InputError(f"--pace {inputs.pace:g} is no pace; give times real time, over 0")
    if inputs.score:
        return _score(inputs, model or "", waterway, y, delivery)
    pace = inputs.pace or (1.0 if page.page else math.inf)
    with ExitStack() as stack:
        publisher, shown = _outputs(alerts, stack), _page(page, stack)
        if inputs.demo:
            monitored, ticks = _demo(pace, alerts, publisher)
        else:
            monitored, ticks = _monitor_of(model or "", waterway, inputs, y, publisher), _ticks_of(inputs, pace, stack)
        log = TransitLog(monitored.model.configuration, monitored.waterway)
        _watch(monitored, ticks, log, shown, delivery.json)
    transit = log.transit()
    if inputs.replay and not len(transit.columns["t"]):
        raise InputError(f"{inputs.replay}: it has no valid sentence; give a recording of NMEA 0183")
    delivery.give(transit, _said, report=lambda path: write_transit_report(transit, path))
    raise SystemExit(int(not inputs.listen and transit.level.words not in ("none", "caution")))


def _said(result: Any) -> None:
    click.echo("\n".join([result.summary(), *result.notes]))


def _monitor_of(
    model: str, waterway: Path | None, inputs: InputOptions, y: float, publisher: "AlertPublisher"
) -> "BridgeMonitor":
    from narrows.warning.monitoring.bridge_monitor import BridgeMonitor

    antenna = numbers("--antenna", inputs.antenna).tolist()
    if len(antenna) != 2:
        raise InputError(f"--antenna {inputs.antenna}: give metres forward and to starboard, as in -70,6")
    water, live = nw.read_waterway(str(waterway)), bool(inputs.listen)
    return BridgeMonitor(model_named(model), water, y, (antenna[0], antenna[1]), publisher=publisher, live=live)


def _ticks_of(inputs: InputOptions, pace: float, stack: ExitStack) -> Iterator["Tick"]:
    from narrows.warning.inputs.bridge_readings import replay
    from narrows.warning.inputs.listening import Listening, connection_of

    if inputs.replay:
        return replay(inputs.replay, pace, inputs.mmsi)
    connections = [*map(connection_of, inputs.listen or ())]
    return stack.enter_context(Listening(connections, inputs.mmsi, inputs.commands_from or ())).ticks()


def _score(inputs: InputOptions, model: str, waterway: Path | None, y: float, delivery: ReportDelivery) -> None:
    from narrows.warning.inputs.bridge_readings import replay
    from narrows.warning.monitoring.alert_publisher import AlertPublisher
    from narrows.warning.monitoring.watched_transit import TransitLog, score_transits

    transits = {}
    for number, path in enumerate(inputs.score or (), 1):
        monitored = _monitor_of(model, waterway, inputs, y, AlertPublisher())
        log = TransitLog(monitored.model.configuration, monitored.waterway)
        with stage(f"{path.name}, {number} of {len(inputs.score or ())}"):
            monitored.prepare(USUAL_SPEED)
            for tick in replay(path, mmsi=inputs.mmsi):
                log.add(monitored.update(tick, tick.t))
        transits[str(path)] = log.transit()
    delivery.give(score_transits(transits), _said)


def _demo(pace: float, alerts: AlertOptions, publisher: "AlertPublisher") -> tuple["BridgeMonitor", Iterator["Tick"]]:
    from narrows.warning.inputs.bridge_readings import paced
    from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
    from narrows.warning.monitoring.demonstration import LINE, demonstration

    with stage("a ship from the bundled tests, and a transit of it"):
        shown = demonstration()
    if alerts.recording:
        write_whole(alerts.recording, shown.recording())
    monitored = BridgeMonitor(shown.model, shown.waterway, LINE, publisher=publisher, live=False)
    return monitored, paced(shown.ticks(), pace)


def _watch(
    monitored: "BridgeMonitor", ticks: Iterable["Tick"], log: "TransitLog", page: "BridgePage | None", json: bool
) -> None:
    with stage("compiling the missing parts"):
        monitored.prepare(USUAL_SPEED)
    end_by_sigterm()
    with suppress(KeyboardInterrupt):
        for number, tick in enumerate(page.requests.joined(ticks, monitored.desk) if page else ticks):
            now = time.time()
            status = monitored.update(tick, now)
            if page:
                page.publish(monitored, status, now)
            log.add(status)
            if not json:
                _print_status(number, status)


def end_by_sigterm() -> None:
    """Let SIGTERM end the watch like Ctrl-C, with notice to pages."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, signal.default_int_handler)


def _print_status(number: int, status: "BridgeStatus") -> None:
    for alert in status.changed:
        line = f"{number:6d} s  {alert.priority.words}, {alert.state.value}: {alert.text}"
        bell = "\a" if alert.sounds and sys.stdout.isatty() else ""
        click.secho(bell + line, fg=COLOURS.get(alert.priority.words), bold=alert.sounds)
    if number % STATUS_EVERY == 0:
        click.echo(f"{number:6d} s  {status.line()}")


def _outputs(alerts: AlertOptions, stack: ExitStack) -> "AlertPublisher":
    from narrows.warning.alerts.alert import AlertLog
    from narrows.warning.monitoring.alert_publisher import AlertPublisher, sender_to

    log = stack.enter_context(AlertLog(alerts.log)) if alerts.log else None
    sends = [stack.enter_context(sender_to(address)) for address in alerts.send or ()]

    def send(sentence: str) -> None:
        for send_to in sends:
            send_to(sentence)

    return AlertPublisher(log, send)


def _page(page: PageOptions, stack: ExitStack) -> "BridgePage | None":
    from narrows.warning.page.bridge_page import BridgePage

    if not page.page:
        return None
    shown = BridgePage()
    click.secho(f"The page: {stack.enter_context(shown.open(page.host, page.port))}", err=True, bold=True)
    return shown
