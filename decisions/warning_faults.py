"""Faults at full size: the table of docs/benchmarks.md; tests hold the same at small sizes, in tests/warning.

python decisions/warning_faults.py [--write] [--small]
"""

import os
import random
import resource
import signal
import string
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pyais
from pages import markdown, publish

from narrows.readers.nmea import NmeaDecoder, checksum, sentences
from narrows.readers.settings import MOST_SHIPS
from narrows.warning.alerts.alert import Alert, AlertLog, AlertState, Priority, command_of, logged
from narrows.warning.inputs.listening import Connection, Listening, Piece

KILLS, A_LOG, SHIPS, LINES, BURST = 1000, 50, 1_000_000, 100_000, 20_000
LONGEST = 0.02
"""That a writer lives after its first alert [s]."""
KINDS = ("GPGGA", "GNGNS", "GPRMC", "GPGLL", "GPVTG", "HEHDT", "HETHS", "HCHDG", "TIROT", "IIRSA", "IIRPM", "VDVHW",
         "VDVBW", "WIMWV", "WIMWD", "GPZDA")  # fmt: skip
LETTERS = "0123456789.,-ANEWTKMnaif"


def killed(count: int) -> tuple[str, str]:
    """Writers that are killed while they publish what is on disk; what they published is looked for in the log."""
    chance, published, missing = random.Random(0), 0, 0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            path = Path(folder) / f"{number // A_LOG}.db"
            told = _writer_killed(path, chance.uniform(0.0, LONGEST))
            known = set(logged(path)) if path.exists() else set()
            published, missing = published + len(told), missing + len(set(told) - known)
    return f"kill -9 while writing, {count} times", f"{published} alerts published, {missing} missing from the log"


def _writer_killed(path: Path, lives: float) -> list[int]:
    """Numbers of the rows that a writer published before it was killed."""
    ours, theirs = os.pipe()
    child = os.fork()
    if not child:
        os.close(ours)
        _write_on(path, theirs)
    os.close(theirs)
    with os.fdopen(ours, "rb") as pipe:
        first = pipe.readline()
        time.sleep(lives)
        os.kill(child, signal.SIGKILL)
        rest = pipe.read()
    os.waitpid(child, 0)
    return [int(line) for line in (first + rest).split(b"\n")[:-1]]


def _write_on(path: Path, pipe: int) -> None:
    with AlertLog(path, deadline=30.0) as log:
        for number in range(100_000):
            if log.alert(Alert(10110, Priority.WARNING, AlertState.UNACKNOWLEDGED, str(number))):
                os.write(pipe, b"%d\n" % log.count)
    os._exit(0)


def many_ships(count: int) -> tuple[str, str]:
    """Reports of ships of random numbers."""
    chance, decoder, before = random.Random(0), NmeaDecoder(), 0
    usual = {"type": 1, "lon": 5.0, "lat": 52.0, "speed": 7.4, "course": 10.0, "heading": 12}
    start = time.process_time()
    for number in range(count):
        if number == count // 10:
            before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        line = pyais.encode_dict({**usual, "mmsi": chance.randrange(200_000_000, 776_000_000)}, sentence_type="VDM")[0]
        for one in sentences([line.encode()], decoder.faults):
            decoder.decode(one)
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    took = 1e6 * (time.process_time() - start) / count
    kept = f"{len(decoder.ships)} of at most {MOST_SHIPS} kept, memory grew by {grown:.1f} MB over the last nine tenths"
    return f"{count} random MMSIs", f"{kept}; {took:.0f} us each with making it"


def burst(count: int) -> tuple[str, str]:
    """Reports of others in one second, and the ship's own last."""
    others = [
        pyais.encode_dict({"type": 1, "mmsi": 244_000_000 + k}, sentence_type="VDM")[0].encode() for k in range(200)
    ]
    piece = b"\r\n".join([*(others * (count // 200)), _sentence("HEHDT,12.00,T")])

    def opened() -> Iterator[Piece]:
        yield Piece(piece)
        while True:
            time.sleep(0.05)
            yield Piece(b"")

    start = time.monotonic()
    with Listening([Connection(False, opened)]) as listening:
        while not listening._lines:
            time.sleep(0.001)
        took = time.monotonic() - start
        (first,) = next(listening.ticks()).entries
    return f"{count} messages in a burst, the own last", f"own heard after {took:.2f} s ({first.message.source})"


def fuzzed(count: int) -> list[tuple[str, str]]:
    """Lines of noise with right checksums for each parser; what is raised is nothing, or it ends here."""
    chance, costs = random.Random(0), []

    def noise(letters: str, most: int) -> str:
        return "".join(chance.choices(letters, k=chance.randrange(most)))

    makers = {
        "NMEA 0183": lambda: _sentence(f"{chance.choice(KINDS)},{noise(LETTERS, 60)}"),
        "AIS": lambda: _sentence(f"AIVDM,1,1,,A,{noise(string.printable[:75], 60)},0", "!"),
        "commands": lambda: _sentence(f"INACN,{noise(LETTERS, 20)},NRW,{noise(LETTERS, 12)},C"),
    }
    for name, make in makers.items():
        decoder, start = NmeaDecoder(), time.process_time()
        for _ in range(count):
            _parse(name, make(), decoder)
        costs.append(1e6 * (time.process_time() - start) / count)
    spent = f"none raised an error; {min(costs):.0f} to {max(costs):.0f} us each"
    return [(f"{count} fuzzed lines of each of {', '.join(makers)}", spent)]


def _parse(name: str, line: bytes, decoder: NmeaDecoder) -> None:
    if name == "commands":
        command_of(line.strip())
    else:
        for one in sentences([line.strip()], decoder.faults):
            decoder.decode(one)


def _sentence(body: str, begin: str = "$") -> bytes:
    text = body.encode("latin-1", "replace")
    return begin.encode() + text + b"*%02X\r\n" % checksum(text)


def text(small: bool = False) -> str:
    """The table."""
    part = 100 if small else 1
    rows = [killed(KILLS // part), burst(BURST), many_ships(SHIPS // part), *fuzzed(LINES // part)]
    return markdown(("fault", "figure"), rows)


if __name__ == "__main__":
    publish(__file__, "benchmarks.md", text("--small" in sys.argv))
