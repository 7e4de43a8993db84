"""Alerts as notifications of Signal K: all situations in one delta, so that the newest tells everything.

References
----------
Signal K specification 1.7: notifications, with their states and methods.
"""

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from narrows.warning.alerts.alert import HOLDS, Alert, AlertState, Priority
from narrows.warning.alerts.alert_desk import AlertDesk
from narrows.warning.alerts.situations import SITUATIONS, Situation

# By priority; of what is over, normal.
STATES = {
    Priority.NONE: "normal", Priority.CAUTION: "alert", Priority.WARNING: "warn", Priority.ALARM: "alarm",
    Priority.EMERGENCY_ALARM: "emergency",
}  # fmt: skip
SOURCE = "narrows"


def notifications(desk: AlertDesk, since_1970: float) -> dict[str, Any]:
    """Return the delta of all alerts."""
    # since_1970 [s]
    return _delta({one: _value(desk[one]) for one in SITUATIONS.values()}, since_1970)


def ended(since_1970: float) -> dict[str, Any]:
    """Return the delta of a monitor that watches no more: nothing is alerted, and that is why."""
    # since_1970 [s]
    return _delta({one: _normal("The monitor has ended.") for one in SITUATIONS.values()}, since_1970)


def _delta(values: Mapping[Situation, dict[str, Any]], since_1970: float) -> dict[str, Any]:
    told = [{"path": _path(situation), "value": value} for situation, value in values.items()]
    stamp = datetime.fromtimestamp(since_1970, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
    return {"context": "vessels.self", "updates": [{"$source": SOURCE, "timestamp": stamp, "values": told}]}


def _path(situation: Situation) -> str:
    first, *others = situation.name.lower().split()
    return f"notifications.{SOURCE}.{first}{''.join(map(str.title, others))}"


def _value(alert: Alert) -> dict[str, Any]:
    if alert.state not in HOLDS:
        return _normal("")
    shown = ["visual"] if alert.state is not AlertState.ACKNOWLEDGED else []
    return {"state": STATES[alert.priority], "method": shown + ["sound"] * alert.sounds, "message": alert.text}


def _normal(message: str) -> dict[str, Any]:
    return {"state": STATES[Priority.NONE], "method": [], "message": message}
