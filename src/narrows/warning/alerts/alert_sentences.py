"""Alerts as sentences: ALF, ALC, HBT and ARC out, ACN in.

References
----------
Fields as printed in makers' manuals, after IEC 61162-1: JRC JLN-900 (2018), 3.1, and JFE-680, 4, for ALF, ALC, HBT, ARC
and ACN.
"""

import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any, NamedTuple

from narrows.readers.nmea.nmea_sentences import with_checksum
from narrows.warning.alerts.alert import (
    ANSWERED,
    HOLDS,
    SITUATIONS,
    Alert,
    AlertDesk,
    AlertState,
    Command,
    Priority,
    Situation,
)
from narrows.warning.settings import HEARTBEAT

# Integrated instrumentation; whose alerts they are.
TALKER, MAKER = "II", "NRW"
# Letters of the second sentence of an alert.
LONGEST_TEXT = 40
# Entries of a list in one sentence.
ENTRIES = 3
RESERVED = re.compile(r"[\r\n$*,!\\^~]|[^\x20-\x7d]")
# Letters of states. Makers' manuals contradict each other, so they can be changed.
LETTERS: Mapping[AlertState, str] = {
    AlertState.NORMAL: "N", AlertState.UNACKNOWLEDGED: "V", AlertState.SILENCED: "S", AlertState.ACKNOWLEDGED: "A",
    AlertState.RECTIFIED: "U", AlertState.TRANSFERRED: "O",
}  # fmt: skip
ACN = re.compile(rb"^\$[A-Z]{2}ACN,[^,]*,([A-Z]{0,3}),(\d{1,7}),(\d{1,6}),([AQOS]),C\*[0-9A-F]{2}$")


class AlertCommand(NamedTuple):
    identifier: int  # Number of the alert
    instance: int  # Instance of the alert
    command: Command  # What


def alf(alert: Alert, since_1970: float, number: int, letters: Mapping[AlertState, str] = LETTERS) -> list[str]:
    name, text = SITUATIONS[alert.identifier].name, alert.text[:LONGEST_TEXT]
    # An alert that is not normal has a priority; one that became normal keeps its last one.
    about = f"{_clock(since_1970)},{alert.category},{alert.priority.letter},{letters[alert.state]}"
    which = f"{MAKER},{alert.identifier},{alert.instance},{alert.revision},{alert.repeats}"
    return [
        with_checksum(f"{TALKER}ALF,2,1,{number % 10},{about},{which},{_escaped(name)}"),
        with_checksum(f"{TALKER}ALF,2,2,{number % 10},,,,,{which},{_escaped(text)}"),
    ]


def alc(alerts: Sequence[Alert], number: int) -> list[str]:
    parts = [alerts[first : first + ENTRIES] for first in range(0, len(alerts), ENTRIES)] or [()]
    return [
        with_checksum(
            ",".join(
                [f"{TALKER}ALC", f"{len(parts):02d}", f"{place:02d}", f"{number % 100:02d}", f"{len(part)}"]
                + [f"{MAKER},{one.identifier},{one.instance},{one.revision}" for one in part]
            )
        )
        for place, part in enumerate(parts, 1)
    ]


def hbt(sound: bool, number: int) -> str:
    return with_checksum(f"{TALKER}HBT,{HEARTBEAT:.1f},{'A' if sound else 'V'},{number % 10}")


def arc(refused: AlertCommand, since_1970: float) -> str:
    which = f"{MAKER},{refused.identifier},{refused.instance}"
    return with_checksum(f"{TALKER}ARC,{_clock(since_1970)},{which},{refused.command.value}")


def acn(identifier: int, instance: int, command: Command) -> bytes:
    return with_checksum(f"{TALKER}ACN,,{MAKER},{identifier},{instance},{command.value},C").strip().encode("ascii")


def command_of(text: bytes) -> AlertCommand | None:
    """Return the command of a sentence ACN whose checksum is right; None where it is no command to us."""
    match = ACN.match(text)
    if match is None or match[1] not in (b"", MAKER.encode()):
        return None
    return AlertCommand(int(match[2]), int(match[3]), Command(match[4].decode()))


def _clock(since_1970: float) -> str:
    at = datetime.fromtimestamp(since_1970, UTC)
    return f"{at:%H%M%S}.{at.microsecond // 10_000:02d}"


def _escaped(text: str) -> str:
    """Return a reserved character as a circumflex and two digits."""
    return RESERVED.sub(lambda match: "".join(f"^{byte:02X}" for byte in match[0].encode("latin-1", "replace")), text)


# Notifications of Signal K (specification 1.7): all situations in one delta, so that the newest is complete.
STATES = {
    Priority.NONE: "normal", Priority.CAUTION: "alert", Priority.WARNING: "warn", Priority.ALARM: "alarm",
    Priority.EMERGENCY_ALARM: "emergency",
}  # fmt: skip
SOURCE = "narrows"


def notifications(desk: AlertDesk, since_1970: float) -> dict[str, Any]:
    return _delta({one: _value(desk[one]) for one in SITUATIONS.values()}, since_1970)


def ended(since_1970: float) -> dict[str, Any]:
    """Return the delta of a monitor that watches no more: nothing is alerted, and that is why."""
    return _delta({one: _normal("The monitor has ended.") for one in SITUATIONS.values()}, since_1970)


def _delta(values: Mapping[Situation, dict[str, Any]], since_1970: float) -> dict[str, Any]:
    pairs = [{"path": _path(situation), "value": value} for situation, value in values.items()]
    stamp = datetime.fromtimestamp(since_1970, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
    return {"context": "vessels.self", "updates": [{"$source": SOURCE, "timestamp": stamp, "values": pairs}]}


def _path(situation: Situation) -> str:
    first, *others = situation.name.lower().split()
    return f"notifications.{SOURCE}.{first}{''.join(map(str.title, others))}"


def _value(alert: Alert) -> dict[str, Any]:
    if alert.state not in HOLDS:
        return _normal("")
    shown = ["visual"] if alert.state not in ANSWERED else []
    return {"state": STATES[alert.priority], "method": shown + ["sound"] * alert.sounds, "message": alert.text}


def _normal(message: str) -> dict[str, Any]:
    return {"state": STATES[Priority.NONE], "method": [], "message": message}
