"""Sentences out of a recording of NMEA 0183: checksums first, and what is garbled counted."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from functools import reduce
from operator import xor
from typing import NamedTuple

SENTENCE = re.compile(rb"[$!]([A-Z][A-Z0-9]{4,}),([^*$!\r\n]*)(\*[0-9A-Fa-f]{2})?")
# A block before the sentence, with the time of the logger [s] or [ms] since 1970.
TAG = re.compile(rb"\\(?:[^\\]*,)?c:(\d{10,13})(?:[,*][^\\]*)?\\")
ISO = re.compile(rb"(\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:[.,]\d+)?)(Z|[+-]\d\d:?\d\d)?")
EPOCH = re.compile(rb"(?<![\d.])(1\d{9}(?:\.\d+)?)(?![\d.])")
REMARK = b"#"
# Beyond this a time since 1970 is in milliseconds.
MILLISECONDS = 1e11


class Sentence(NamedTuple):
    """One sentence whose checksum is right."""

    text: bytes  # From ``$`` or ``!`` to the checksum
    kind: str  # Talker and type, as in ``GPGGA``
    logged: float | None  # Since 1970 when the logger wrote it down, where it says so [s]


def sentences(lines: Iterable[bytes], faults: Counter[str]) -> Iterator[Sentence]:
    for line in lines:
        if line.startswith(REMARK):
            continue
        begin = 0
        for match in SENTENCE.finditer(line):
            if match[3] is None:
                faults["without a checksum"] += 1
            elif int(match[3][1:], 16) != checksum(match[0][1:-3]):
                faults["with a wrong checksum"] += 1
            else:
                yield Sentence(match[0], match[1].decode("ascii"), _logged(line[begin : match.start()]))
            begin = match.end()
        if not begin and line.strip():
            faults["that are no sentence"] += 1


def checksum(body: bytes) -> int:
    """Return the checksum of what stands between ``$`` and ``*`` (IEC 61162-1)."""
    return reduce(xor, body, 0)


def with_checksum(body: str) -> str:
    return f"${body}*{checksum(body.encode('ascii')):02X}\r\n"


def _logged(before: bytes) -> float | None:
    if match := TAG.search(before) or EPOCH.search(before):
        time = float(match[1])
        return time / 1e3 if time > MILLISECONDS else time
    if match := ISO.search(before):
        when = datetime.fromisoformat(match[1].decode().replace(",", ".") + (match[2] or b"Z").decode())
        return when.astimezone(UTC).timestamp()
    return None
