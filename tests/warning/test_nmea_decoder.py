"""What a monitor hears: sentences by other means than ours, sockets of this machine, and every way to garble them."""

import math
import random
import socket
import threading
import time
from collections import Counter
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from bridge import KNOT, WAY, ais, nowhere, recorded, stamped, told_at
from hypothesis import given
from hypothesis import strategies as st

import narrows as nw
from logs import motion, sentence
from narrows.readers.nmea import DecodedMessage, Entry, NmeaDecoder, Sentence, sentences
from narrows.warning import settings as numbers
from narrows.warning.inputs.bridge_readings import NOT_HERE, BridgeReadings, Messages, Tick, by_second, in_order, replay
from narrows.warning.inputs.listening import (
    NO_PEER,
    NO_TIME,
    Connection,
    Listening,
    Piece,
    connection_of,
    split_lines,
)

# Bounds of memory: ships, and lines that wait.
MOST_SHIPS, MOST_LINES = 2000, 20_000


def understood(*lines: str, mmsi: int | None = None, decoder: NmeaDecoder | None = None) -> list[dict]:
    decoder = decoder or NmeaDecoder(mmsi)
    texts = [line.encode("latin-1") for line in lines]
    told = [decoder.decode(one) for one in sentences(texts, decoder.faults)]
    return [one.values for one in told if one is not None]


def heard(*lines: str, t: float = 10.0, bridge: BridgeReadings | None = None) -> Messages:
    decoder = NmeaDecoder()
    told = [decoder.decode(one) for one in sentences([line.encode() for line in lines], decoder.faults)]
    entries = [Entry(t, one) for one in told if one is not None]
    return (bridge or BridgeReadings(WAY, 8.0)).convert(Tick(t, entries, dict(decoder.faults)))


def test_a_second_becomes_readings_along_the_waterway() -> None:
    told = heard(*told_at(30.0))
    truth = {name: float(value) for name, value in motion(np.array(30.0)).items()}
    assert told.readings["gnss"] == pytest.approx((truth["x"], truth["y"]), abs=0.01)
    assert told.readings["gyro"] == pytest.approx(truth["psi"], abs=1e-5)
    assert told.readings["rudder"] == pytest.approx(truth["rudder"], abs=1e-6)
    assert told.readings["rate_of_turn"] == pytest.approx(math.radians(-0.1))
    assert told.readings["log"] == pytest.approx(7.5 * KNOT)
    assert told.readings["course"] == pytest.approx((truth["psi"], 7.9 * KNOT), abs=2e-4)
    assert told.ages == dict.fromkeys(told.ages, 0.0)
    assert told.faults == {}


def test_without_a_log_the_speed_is_that_over_ground() -> None:
    lines = [line for line in told_at(30.0) if "VBW" not in line]
    assert heard(*lines).readings["ground_log"] == pytest.approx(7.9 * KNOT)


def test_a_fix_elsewhere_on_earth_is_none() -> None:
    told = heard(sentence("GPGGA,000000.00,4800.0,N,00500.0,E,1,08,0.9,5.4,M,46.9,M,,"))
    assert "gnss" not in told.readings
    assert told.faults == {NOT_HERE: 1}


def test_a_waterway_that_is_nowhere_is_refused() -> None:
    with pytest.raises(nw.InputError, match="give its origin, or read it from GeoJSON"):
        BridgeReadings(nowhere(), 8.0)


@pytest.mark.parametrize("field", ["", "nan", "inf", "-inf", "1e999", "511", "-128", "9999", "x"])
def test_what_is_no_number_or_stands_for_none_is_not_told(field: str) -> None:
    lines = [
        sentence(f"HEHDT,{field},T"), sentence(f"HETHS,{field},A"), sentence(f"IIRSA,{field},A,,V"),
        sentence(f"VDVBW,{field},{field},A,{field},{field},A,,V,,V"), sentence(f"VDVHW,,T,,M,{field},N,,K"),
        sentence(f"GPVTG,{field},T,,M,{field},N,,K,A"), sentence(f"TIROT,{field}9,A"),
        sentence(f"GPGGA,123519,{field},N,{field},E,1,08,0.9,545.4,M,46.9,M,,"),
        sentence(f"GPRMC,123519,A,{field},N,{field},E,{field},{field},230394,,"),
    ]  # fmt: skip
    told = [values for one in understood(*lines) for values in one.values()]
    assert all(abs(number) < 100.0 and math.isfinite(number) for values in told for number in values.values())
    if field != "-128":  # half of which is a rate of turn
        assert not any(values for values in told if not set(values) <= {"r", "rudder"})


def test_an_echo_sounder_says_from_where_it_sounds() -> None:
    lines = [sentence(f"SDDPT,12.4,{offset},100.0") for offset in ("1.6", "-0.4", "0.0", "")]
    depths = [one.get("depth of water") for one in understood(*lines)]
    assert depths == [{"depth": pytest.approx(14.0)}, {"under_keel_clearance": pytest.approx(12.0)}, None, None]
    assert heard(lines[0]).depth == pytest.approx(14.0)


def test_a_magnetic_heading_needs_the_variation() -> None:
    """98.3 degrees by a compass that deviates 1 degree east, where north is 12.6 degrees west of true north."""
    (one,) = understood(sentence("HCHDG,98.3,1.0,E,12.6,W"))
    assert one["heading"] == {"heading": pytest.approx(math.radians(86.7))}
    assert not any(any(one.values()) for one in understood(sentence("HCHDG,98.3,1.0,E,,")))


def test_what_ais_stands_for_none_is_not_told() -> None:
    unknown = {"lon": 181.0, "lat": 91.0, "speed": 102.3, "course": 360.0, "heading": 511, "turn": -128.0}
    assert not any(any(one.values()) for one in understood(*ais("VDO", 244000000, **unknown)))


def test_a_message_of_two_sentences_is_passed_over() -> None:
    decoder, parts = NmeaDecoder(), ais("VDO", 244000001, type=5, shipname="ALPHA", draught=10.2)
    assert len(parts) == 2
    assert understood(*parts, decoder=decoder) == []
    assert not decoder.faults


def test_memory_stays_bounded_whatever_ships_there_are() -> None:
    chance, decoder = random.Random(0), NmeaDecoder()
    for _ in range(MOST_SHIPS + 1000):
        line = ais("VDM", 200_000_000 + chance.randrange(99_999_999))[0].encode()
        decoder.decode(Sentence(line, "AIVDM", None))
    assert len(decoder.ships) <= MOST_SHIPS


@given(st.binary(max_size=300), st.integers(0, 5))
def test_fuzzed_bytes_are_counted_and_never_raise(noise: bytes, at: int) -> None:
    decoder, rest = NmeaDecoder(), b""
    line = told_at(3.0)[at].encode()
    cut = len(line) * (at + 1) // 6
    for piece in (line[:cut] + noise, line[cut:] + b"\r\n", noise, b"\n"):
        lines, rest = split_lines(rest + piece, False)
        for one in sentences(lines, decoder.faults):
            decoder.decode(one)


@given(st.text(alphabet="0123456789.,-ANEWTKMnaif", max_size=60), st.sampled_from(
    ["GPGGA", "GNGNS", "GPRMC", "GPGLL", "GPVTG", "HEHDT", "HETHS", "HCHDG", "TIROT", "IIRSA", "IIRPM", "VDVHW",
     "VDVBW", "WIMWD", "GPZDA", "AIVDO", "AIVDM"]
))  # fmt: skip
def test_fuzzed_fields_with_a_right_checksum_never_raise(fields: str, kind: str) -> None:
    for values in understood(sentence(f"{kind},{fields}"), sentence(f"{kind},1,1,,A,{fields},0")):
        assert all(math.isfinite(number) for told in values.values() for number in told.values())


def test_corrupted_sentences_are_never_believed() -> None:
    """One character of each of 3000 sentences is another: pynmeagps alone accepts some, pyais a seventh."""
    chance, lines = random.Random(1), [*told_at(3.0), *ais("VDO", 244000001)]
    decoder = NmeaDecoder()
    for _ in range(3000):
        line = bytearray(chance.choice(lines).encode())
        line[chance.randrange(1, len(line))] = chance.randrange(32, 127)
        if line.decode() not in lines:
            assert understood(line.decode(), decoder=decoder) == []
    assert sum(decoder.faults.values()) > 2900


def test_the_best_is_believed_and_another_where_it_is_silent() -> None:
    bridge = BridgeReadings(WAY, 8.0)
    good, other = told_at(3.0)[1], sentence("AGTHS,77.0,A")
    first = heard(good, other, t=0.0, bridge=bridge)
    heard(*told_at(0.0), t=0.5, bridge=bridge)
    for t in range(1, 6):
        assert "gyro" not in heard(other, t=float(t), bridge=bridge).readings
    assert "gyro" in heard(other, t=6.0, bridge=bridge).readings
    assert "gyro" not in first.readings  # where the line lies is told by a position alone


@pytest.fixture
def quick_ticks(monkeypatch: pytest.MonkeyPatch) -> None:
    """A tick each quarter of a second, for tests that wait for some."""
    monkeypatch.setattr(numbers, "PERIOD", 0.25)


def test_udp_and_tcp_are_heard_and_a_broken_connection_is_opened_anew(quick_ticks: None) -> None:
    """A server that closes after a second's sentences, twice; datagrams beside it."""
    lines = "\r\n".join(told_at(30.0)) + "\r\n"
    with socket.create_server(("127.0.0.1", 0)) as server, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        ports = server.getsockname()[1], free.getsockname()[1]
        free.close()

        def serve() -> None:
            for _ in range(2):
                connection, _ = server.accept()
                connection.sendall(lines.encode())
                connection.close()

        threading.Thread(target=serve, daemon=True).start()
        ways = [connection_of(f"tcp://127.0.0.1:{ports[0]}"), connection_of(f"udp://127.0.0.1:{ports[1]}")]
        counts: Counter[str] = Counter()
        with Listening(ways) as listening, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            for tick in listening.ticks():
                sender.sendto(told_at(30.0)[1].encode(), ("127.0.0.1", ports[1]))
                counts.update(entry.message.source for entry in tick.entries)
                if counts["GPGGA"] == 2 and counts["HEHDT"] >= 3:
                    break
                assert sum(counts.values()) < 100


@pytest.mark.parametrize("room", [2000, MOST_LINES])
def test_a_burst_of_other_ships_does_not_delay_the_own(room: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """As many reports of others as there is room for and a second of the own, at once: they are in the first two ticks.

    Of more own sentences than there is room for, the oldest are left out, and counted.
    """
    assert numbers.MOST_LINES == MOST_LINES
    monkeypatch.setattr(numbers, "MOST_LINES", room)
    others = "\r\n".join(ais("VDM", 244000000 + k)[0] for k in range(200)) + "\r\n"
    own = "\r\n".join(told_at(30.0)) + "\r\n"
    pieces = [(room // 200 * others + own).encode(), room // 5 * own.encode()]

    def opened() -> Iterator[Piece]:
        yield Piece(pieces[0])
        flood.wait()
        yield Piece(pieces[1])
        while True:
            time.sleep(0.05)
            yield Piece(b"")

    flood = threading.Event()
    with Listening([Connection(False, opened)]) as listening:
        told, start = listening.ticks(), time.monotonic()
        first = [next(told), next(told)]
        assert time.monotonic() - start < 4.0
        flood.set()
        while len(listening._lines) < room or not listening._lost:
            time.sleep(0.01)
        last = next(told)
    heard = Counter(entry.message.source for tick in first for entry in tick.entries)
    assert heard == dict.fromkeys(("GPGGA", "HEHDT", "TIROT", "VDVBW", "GPVTG", "IIRSA"), 1)
    assert NO_TIME not in first[1].faults
    assert last.faults[NO_TIME] + len(last.entries) == room // 5 * 6


def test_commands_are_taken_from_those_alone_who_may_give_them(quick_ticks: None) -> None:
    """Datagrams of this machine: an acknowledgement where it was not named, and where it was."""
    command = sentence("INACN,,NRW,10111,1,A,C").encode()
    for peers, taken in (((), 0), (("127.0.0.1",), 1)):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        listening = Listening([connection_of(f"udp://127.0.0.1:{port}")], peers=peers)
        with listening, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            time.sleep(0.3)
            sender.sendto(command, ("127.0.0.1", port))
            told = islice(listening.ticks(), 40)
            tick = next(one for one in told if one.commands or NO_PEER in one.faults)
        assert len(tick.commands) == taken
        assert tick.faults.get(NO_PEER, 0) == 1 - taken


@pytest.mark.parametrize("quality", range(9))
@pytest.mark.parametrize("hdop", ["0.9", "5.0", "25.0", ""])
def test_a_fix_is_one_by_satellites_that_stand_well(quality: int, hdop: str) -> None:
    """GGA: 6 is dead reckoning, 7 by hand, 8 a simulator; an HDOP of 25 is 100 m and more."""
    (told,) = understood(sentence(f"GPGGA,000000.00,5200.0,N,00500.0,E,{quality},08,{hdop},5.4,M,46.9,M,,"))
    assert bool(told.get("position")) == (quality in (1, 2, 3, 4, 5) and hdop != "25.0")


@pytest.mark.parametrize(("mode", "taken"), [("A", True), ("D", True), ("E", False), ("M", False), ("S", False)])
def test_a_mode_tells_what_a_position_is(mode: str, taken: bool) -> None:
    lines = [f"GPRMC,123519,A,5200.0,N,00500.0,E,022.4,084.4,230394,003.1,W,{mode}",
             f"GPGLL,5200.0,N,00500.0,E,123519,A,{mode}", f"GPVTG,054.7,T,034.4,M,005.5,N,010.2,K,{mode}",
             f"GNGNS,123519.00,5200.0,N,00500.0,E,{mode}N,08,0.9,10.0,46.9,,"]  # fmt: skip
    told = understood(*map(sentence, lines))
    assert [any(one.values()) for one in told] == [taken] * 4


@pytest.mark.parametrize(
    "address", ["udp://", "tcp://host", "http://a:1", "serial://", "tcp://a:99999", "ws://a:3000", "x"]
)
def test_an_address_that_is_none_is_one_sentence(address: str) -> None:
    with pytest.raises(nw.InputError, match="udp://:10110"):
        connection_of(address)


def test_a_serial_line_is_opened_when_it_is_read() -> None:
    one: Connection = connection_of("serial:///dev/no-such-line?baud=38400")
    with pytest.raises(OSError, match="no-such-line"):
        next(one.opened())


def test_late_shuffled_and_repeated_lines_are_as_the_clean_recording(tmp_path: Path) -> None:
    """Lateness to a minute, every line ten times: second by second the same is told."""
    lines, chance = stamped(80), random.Random(3)
    late = sorted(lines * 10, key=lambda line: int(line[3:13]) + chance.uniform(0.0, 59.0))
    clean, shuffled = (
        list(replay(recorded(tmp_path / f"{name}.nmea", told))) for name, told in (("a", lines), ("b", late))
    )
    assert [tick.t for tick in clean] == [tick.t for tick in shuffled]
    assert [sorted(map(repr, tick.entries)) for tick in clean] == [sorted(map(repr, t.entries)) for t in shuffled]
    told = DecodedMessage({}, "GPGGA")
    assert [entry.t for entry in in_order([Entry(100.0, told), Entry(41.0, told), Entry(38.0, told)])] == [
        38.0,
        41.0,
        100.0,
    ]
    assert [e.t for e in in_order([Entry(0.0, told), Entry(100.0, told), Entry(-1.0, told)])] == [0.0, 100.0]


def test_silence_is_heard_second_by_second(tmp_path: Path) -> None:
    path = recorded(tmp_path / "a.nmea", stamped(5) + stamped(5, 15) + stamped(2, 900))
    ticks = list(replay(path))
    assert [len(tick.entries) > 0 for tick in ticks[:20]] == [True] * 5 + [False] * 10 + [True] * 5
    assert len(ticks) == 22
    assert list(by_second([])) == []


def test_a_replay_keeps_the_pace_that_is_asked_for(tmp_path: Path) -> None:
    path, start = recorded(tmp_path / "a.nmea", stamped(6)), time.monotonic()
    assert len(list(replay(path, speed=20.0))) == 6
    assert 0.25 <= time.monotonic() - start < 2.0
