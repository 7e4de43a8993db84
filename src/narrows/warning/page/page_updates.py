"""Messages of the page: what is known, as JSON; its schema is `messages.json` beside this file."""

import json
from collections.abc import Mapping
from typing import Any

from narrows.results import plain
from narrows.warning.alerts.alert import Alert, Command
from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
from narrows.warning.monitoring.bridge_status import BridgeStatus, told
from narrows.warning.page.scene import scene

# What can be asked for on the page, as its messages say it.
COMMANDS = {"acknowledge": Command.ACKNOWLEDGE, "silence": Command.SILENCE}


def update_of(watched: BridgeMonitor, status: BridgeStatus, since_1970: float) -> dict[str, Any]:
    """Return what is known at a time, as the page is told it."""
    # since_1970 [s]
    names = {"ship": watched.model.configuration.ship.name or "A ship", "waterway": watched.waterway.name}
    alerts = [{**told(alert), "sounds": alert.sounds, "may": _may(alert, status.t)} for alert in status.alerts]
    parts = {"alerts": alerts, "scene": scene(watched, status)}
    return {"kind": "update", "at": since_1970, **names, **status.to_dict(), **parts}


def refusal(sentence: str) -> dict[str, Any]:
    """Return the answer to what is refused."""
    return {"kind": "refused", "sentence": sentence}


def ending(sentence: str) -> dict[str, Any]:
    """Return the last message of a watch."""
    return {"kind": "ended", "sentence": sentence}


def packed(message: Mapping[str, Any]) -> str:
    """Return a message as JSON in one line."""
    return json.dumps(plain(message), separators=(",", ":"), allow_nan=False)


def _may(alert: Alert, t: float) -> list[str]:
    return [name for name, command in COMMANDS.items() if alert.commanded(command, t) is not None]
