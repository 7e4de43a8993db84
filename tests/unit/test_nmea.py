"""Recordings of NMEA 0183: printed sentences, and a ship's whole recording, written by other means than ours."""

from pathlib import Path

import numpy as np
import pyais
import pytest

import narrows as nw
from logs import angle, antenna_on_earth, bent_waterway, clock, motion, sentence, write_recording
from narrows.readers.nmea import checksum

KNOT = 1852 / 3600
PRINTED = {
    b"GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,": 0x47,
    b"GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W": 0x6A,
    b"GPGLL,4916.45,N,12311.12,W,225444,A": 0x31,
    b"AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0": 0x5C,
}
"""Examples of the format that its descriptions print, with their checksums."""
T = np.arange(0.0, 60.0, 1.0)
WAY = bent_waterway()


@pytest.mark.parametrize(("body", "told"), PRINTED.items())
def test_checksums_are_those_that_are_printed(body: bytes, told: int) -> None:
    assert checksum(body) == told


def recording(antenna: tuple[float, float] = (0.0, 0.0)) -> list[str]:
    """A minute along the bend: position, then what has no clock of its own, each second."""
    told = motion(T)
    earth = antenna_on_earth(WAY, told, antenna)
    lines = []
    for i, second in enumerate(T):
        place = f"{angle(earth['lat'][i], 'NS')},{angle(earth['lon'][i], 'EW')}"
        at = clock(86390.0 + second if second < 10 else second - 10.0)
        day = "010526" if second < 10 else "020526"
        lines += [
            sentence(f"GPGGA,{at},{place},1,08,0.9,5.4,M,46.9,M,,"),
            sentence(f"GPRMC,{at},A,{place},8.00,84.4,{day},3.1,W"),
            sentence(f"HEHDT,{earth['HDG [deg]'][i]:.4f},T"),
            sentence("TIROT,-6.0,A"),
            sentence(f"IIRSA,{np.degrees(told['rudder'][i]):.5f},A,,V"),
            sentence("IIRPM,S,1,90.0,10.5,A"),
            sentence("VDVBW,7.5,-0.2,A,7.9,-0.1,A,,V,,V"),
            sentence("WIMWD,270.0,T,,M,12.0,N,6.0,M"),
        ]
    return lines


def test_a_recording_is_told_along_the_waterway_in_si(tmp_path: Path) -> None:
    antenna = (-70.0, 6.0)
    place = {"antenna": dict(zip(("forward", "starboard"), antenna, strict=True))}
    log = nw.read_log(write_recording(tmp_path / "bridge.log", recording(antenna)), WAY, place)
    record, told = log["bridge"], motion(T)
    assert record["x"].t.tolist() == T[1:].tolist()  # past midnight, from the first heading on
    for name in ("x", "y"):
        np.testing.assert_allclose(record[name].values, told[name][1:], atol=0.05)
    for name in ("psi", "rudder"):  # measured at some time of the second
        later = motion(record[name].t)[name]
        np.testing.assert_allclose(record[name].values, np.interp(record[name].t, T + 0.4, told[name]), atol=2e-3)
        assert np.abs(record[name].values - later).max() < 4e-3
    assert record["r"].values == pytest.approx(np.radians(-0.1))
    assert record["revolutions"].values == pytest.approx(1.5)
    assert record["u"].values == pytest.approx(7.5 * KNOT)
    assert record["v_ground"].values == pytest.approx(-0.1 * KNOT)
    assert record["speed_over_ground"].values == pytest.approx(8 * KNOT)
    assert record["wind_speed"].values == pytest.approx(6.0)
    assert "position by GPGGA" in log.notes[0]
    assert log.notes[0].endswith("from 2026-05-01T23:59:50+00:00")


def test_the_times_of_a_logger_go_before_those_of_the_sentences(tmp_path: Path) -> None:
    lines = [f"\\s:bridge,c:{1777680000 + i * 0.1:.0f}*00\\{line}" for i, line in enumerate(recording()[:80])]
    iso = [f"2026-05-02T00:00:{i * 0.1:06.3f}Z {line}" for i, line in enumerate(recording()[:80])]
    milliseconds = [f"\\c:{1777680000000 + i * 100}*00\\{line}" for i, line in enumerate(recording()[:80])]
    for name, form in (("tag", lines), ("iso", iso), ("ms", milliseconds)):
        log = nw.read_log(write_recording(tmp_path / f"{name}.nmea", form), WAY)
        assert "timed by the logger's times, from 2026-05-02T00:00:00+00:00" in log.notes[0]
        assert log[0].stop == pytest.approx(7.9, abs=0.5)


def test_what_is_garbled_is_counted_and_left_out(tmp_path: Path) -> None:
    lines = recording()
    lines[10] = lines[10].replace(",", ";", 1)
    lines[20] = lines[20][:-1] + ("0" if lines[20][-1] != "0" else "1")
    lines[30] = lines[30].partition("*")[0]
    lines[40] = sentence("GPRMC,000000.00,A,5200.0,N,00500.0,E,8x.0,84.4,020526,3.1,W")
    log = nw.read_log(write_recording(tmp_path / "bridge.log", lines), WAY)
    assert log.notes[1:] == (
        "1 sentences that are no sentence were left out", "1 sentences with a wrong checksum were left out",
        "1 sentences without a checksum were left out", "1 sentences that cannot be understood were left out",
    )  # fmt: skip


def test_a_sensor_that_says_it_is_invalid_tells_nothing(tmp_path: Path) -> None:
    times = [clock(second) for second in range(3)]
    lines = []
    for at in times:
        lines += [sentence(f"GPGGA,{at},5200.0,N,00500.0,E,1,08,0.9,5.4,M,46.9,M,,"), sentence("TIROT,5.0,V")]
        lines += [sentence("IIRSA,5.0,V,,V"), sentence("HEHDT,,T"), sentence("GPVTG,,T,,M,,N,,K,N")]
    lines += [sentence(f"GPGGA,{clock(3)},,,,,0,00,,,M,,M,,")]
    record = nw.read_log(write_recording(tmp_path / "a.log", lines))[0]
    assert sorted(record) == ["x", "y"]
    assert len(record["x"]) == 3


def test_a_receiver_that_changes_its_name_is_listened_to(tmp_path: Path) -> None:
    """GP with one system of satellites, GN with several; a second receiver beside the first is not mixed in."""
    place = "5200.0,N,00500.0,E,1,08,0.9,5.4,M,46.9,M,,"
    beside = "5200.0,N,00501.0,E,1,08,0.9,5.4,M,46.9,M,,"
    lines = [sentence(f"{'GP' if i < 10 else 'GN'}GGA,{clock(i)},{place}") for i in range(30)]
    record = nw.read_log(write_recording(tmp_path / "renamed.log", lines))[0]
    assert len(record["x"]) >= 21  # but for the seconds in which the other might come back
    both = [line for i in range(30) for line in (lines[i], sentence(f"INGGA,{clock(i)},{beside}"))]
    log = nw.read_log(write_recording(tmp_path / "both.log", both[:20]))
    assert np.ptp(log[0]["y"].values) < 1e-6
    assert log.notes[0].startswith("position by GPGGA;")


def ais(kind: str, mmsi: int, **told: float) -> str:
    """A report as pyais encodes it."""
    usual = {"lon": 5.0, "lat": 52.0, "speed": 7.4, "course": 10.0, "heading": 12, "turn": 20.0}
    report = {"type": 1, "mmsi": mmsi, **usual, **told}
    return str(pyais.encode_dict(report, talker_id="AI", sentence_type=kind)[0])


def test_ais_tells_of_the_ship_itself_or_of_the_one_that_is_asked_for(tmp_path: Path) -> None:
    start = 1777680000
    heard = [f"\\c:{start + 10 * i}*00\\{ais('VDM', 244000000 + i % 2, speed=5.0 + i % 2)}" for i in range(10)]
    path = write_recording(tmp_path / "heard.nmea", heard)
    with pytest.raises(nw.InputError, match=r"AIS reports are of the ships 24400000[01], 24400000[01]: "):
        nw.read_log(path)
    record = nw.read_log(path, mmsi=244000001)[0]
    assert record["speed_over_ground"].values == pytest.approx(6.0 * KNOT)
    assert record["speed_over_ground"].t.tolist() == [10.0, 30.0, 50.0, 70.0, 90.0]
    assert np.degrees(record["psi"].values) == pytest.approx(12.0)
    assert np.degrees(record["r"].values) * 60 == pytest.approx(20.0, abs=1.0)
    own = [f"\\c:{start + 10 * i}*00\\{ais('VDO', 244000000)}" for i in range(3)]
    assert len(nw.read_log(write_recording(tmp_path / "own.nmea", own + heard))[0]["psi"]) == 3


def test_what_ais_does_not_know_is_left_out(tmp_path: Path) -> None:
    unknown = {"lon": 181.0, "lat": 91.0, "speed": 102.3, "course": 360.0, "heading": 511, "turn": -128.0}
    lines = [f"\\c:{1777680000 + i}*00\\{ais('VDO', 244000000, **({} if i else unknown))}" for i in range(3)]
    record = nw.read_log(write_recording(tmp_path / "own.nmea", lines))[0]
    assert {name: len(own) for name, own in record.signals.items()} == {
        "x": 2, "y": 2, "psi": 2, "r": 2, "speed_over_ground": 2, "course": 2
    }  # fmt: skip
