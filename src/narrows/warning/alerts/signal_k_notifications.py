"""Alerts as notifications of Signal K: all situations in one delta, so that the newest tells everything.

References
----------
Signal K specification 1.7: notifications, with their states and methods.
"""

from datetime import UTC, datetime
from typing import Any

from narrows.warning.alerts.alert import HOLDS, Alert, AlertState, Priority
from narrows.warning.alerts.alert_desk import AlertDesk
from narrows.warning.alerts.situations import SITUATIONS, Situation

STATES = {
    Priority.NONE: "normal", Priority.CAUTION: "alert", Priority.WARNING: "warn", Priority.ALARM: "alarm",
    Priority.EMERGENCY_ALARM: "emergency",
}  # fmt: skip
"""By priority; of what is over, normal."""
SOURCE = "narrows"


def notifications(desk: AlertDesk, since_1970: float) -> dict[str, Any]:
    """Return the delta of all alerts (ours).

    Parameters
    ----------
    desk : AlertDesk
        That holds them.
    since_1970 : float [s]
        Now.
    """
    values = [{"path": _path(one), "value": _value(desk[one])} for one in SITUATIONS.values()]
    stamp = datetime.fromtimestamp(since_1970, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
    return {"context": "vessels.self", "updates": [{"$source": SOURCE, "timestamp": stamp, "values": values}]}


def _path(situation: Situation) -> str:
    first, *others = situation.name.lower().split()
    return f"notifications.{SOURCE}.{first}{''.join(map(str.title, others))}"


def _value(alert: Alert) -> dict[str, Any]:
    if alert.state not in HOLDS:
        return {"state": STATES[Priority.NONE], "method": [], "message": ""}
    shown = ["visual"] if alert.state is not AlertState.ACKNOWLEDGED else []
    return {"state": STATES[alert.priority], "method": shown + ["sound"] * alert.sounds, "message": alert.text}
