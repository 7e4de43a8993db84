"""A ship's own log, however it was written, makes the same records in the package's axes."""

from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import polars as pl
import pytest

import narrows as nw
from logs import antenna_on_earth, bent_waterway, motion
from narrows.logbook.learning.log_setup import log_records
from narrows.logbook.reading import read_log

T = np.arange(0.0, 600.0, 2.0)
EXAMPLES = Path(__file__).parents[2] / "examples"


def table() -> pd.DataFrame:
    told = motion(T)
    return pd.DataFrame({
        "t": T, "x": told["x"], "y": told["y"], "psi [deg]": np.degrees(told["psi"]),
        "rudder_deg": np.degrees(told["rudder"]), "u [kn]": np.full(len(T), 8.0), "revolutions [rpm]": 60.0,
    })  # fmt: skip


def check_same(log: nw.ShipLog) -> None:
    told, record = motion(T), log[0]
    for name in ("x", "y", "psi", "rudder"):
        np.testing.assert_allclose(record[name].values, told[name], atol=1e-9)
    np.testing.assert_allclose(record["u"].values, 8 * 1852 / 3600)
    np.testing.assert_allclose(record["revolutions"].values, 1.0)


def test_tables_of_programs_and_files_say_the_same(tmp_path: Path) -> None:
    frame = table()
    frame.to_csv(tmp_path / "commas.csv", index=False)
    frame.to_csv(tmp_path / "semicolons.txt", index=False, sep=";", decimal=",")
    frame.to_parquet(tmp_path / "columns.parquet")
    sources = [frame, pl.from_pandas(frame), *sorted(tmp_path.iterdir())]
    for source in sources:
        check_same(nw.read_log(source))
    assert nw.read_log(tmp_path / "commas.csv").names == ("commas",)


@pytest.mark.parametrize("form", ["%H:%M:%S", "%Y-%m-%d %H:%M:%S"])
def test_times_of_day_and_dates_in_the_column_t_are_read(form: str, tmp_path: Path) -> None:
    stamps = pd.to_datetime(T, unit="s", origin="2026-05-01 10:00").strftime(form)
    table().assign(t=stamps).to_csv(tmp_path / "log.csv", index=False)
    record = nw.read_log(tmp_path / "log.csv")[0]
    np.testing.assert_allclose(np.diff(record["x"].t), 2.0)
    check_same(nw.read_log(tmp_path / "log.csv"))


def test_a_log_reads_what_it_wrote(tmp_path: Path) -> None:
    first = nw.ShipRecord("A", {"x": nw.Signal(T, 4 * T), "rudder": nw.Signal(T[::3] + 0.5, np.sin(T[::3]))})
    log = nw.ShipLog((first, nw.ShipRecord("B", {"r": nw.Signal(T, np.cos(T))})))
    log.save(tmp_path / "log.csv")
    again = nw.read_log(tmp_path / "log.csv")
    assert again.names == ("A", "B")
    for record in log:
        for name in record:
            np.testing.assert_allclose(again[record.name][name].t, record[name].t)
            np.testing.assert_allclose(again[record.name][name].values, record[name].values)


def test_empty_cells_are_times_at_which_nothing_was_measured(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,rudder [deg],r [deg/min]\n0,5,\n1,,6\n2,-5,\n3,, 12\n")
    record = nw.read_log(path)[0]
    assert record["rudder"].t.tolist() == [0.0, 2.0]
    assert np.degrees(record["r"].values) == pytest.approx([0.1, 0.2])


def test_numbers_by_which_ais_says_none_are_left_out() -> None:
    places = {"lat": [52.0, 91.0, 52.0], "lon": [5.0, 181.0, 5.0]}
    log = nw.read_log({"t": T[:3], "SOG [kn]": [8.0, 102.3, 8.0], "hdg [deg]": [10.0, 12.0, 511.0], **places})
    assert {name: len(own) for name, own in log[0].signals.items()} == {
        "x": 2, "y": 2, "psi": 2, "speed_over_ground": 2
    }  # fmt: skip
    assert "1 of heading stand for none and were left out" in log.notes


NOAA = {
    "MMSI": [636021061, 367000001, 636021061, 636021061],
    "BaseDateTime": ["2023-01-11T00:00:00", "2023-01-11T00:00:05", "2023-01-11T00:00:10", "2023-01-11T00:12:10"],
    "LAT": [26.0, 43.0, 26.001, 26.101], "LON": [-80.0, -70.0, -80.0, -80.0], "SOG": [10.0, 0.0, 20.0, 20.0],
    "COG": [90.0, 0.0, 360.0, 1.0], "Heading": [180.0, 95.0, 511.0, 2.0], "VesselName": ["A", "B", "A", "A"],
}  # fmt: skip


@pytest.mark.parametrize("mapping", [None, {"columns": {"latitude": "LAT", "longitude": "LON"}},
                                     {"columns": {"speed_over_ground": "SOG", "heading": "Heading"}}])  # fmt: skip
def test_a_table_of_the_archive_of_noaa_is_read_by_the_units_of_ais(mapping: dict | None) -> None:
    """ITU-R M.1371: speed in knots, directions in degrees; 511 and 360 stand for none."""
    log = nw.read_log(NOAA, mapping=mapping, mmsi=636021061)
    first = log[0]
    assert len(log) == 2
    assert first["x"].t.tolist() == [0.0, 10.0]
    np.testing.assert_allclose(first["x"].values, [0.0, 111.32], atol=0.7)
    np.testing.assert_allclose(first["speed_over_ground"].values, np.array([10.0, 20.0]) * 1852 / 3600)
    np.testing.assert_allclose(np.degrees(first["psi"].values) % 360, [180.0])
    np.testing.assert_allclose(np.degrees(first["course"].values), [90.0])
    assert "cut into 2 records where nothing came for 300 s; gap= sets another time" in log.notes
    assert len(nw.read_log(NOAA, mapping=mapping, mmsi=636021061, gap=900.0)) == 1
    late = nw.read_log(pd.DataFrame(NOAA).iloc[[3, 2, 1, 0]], mapping=mapping, mmsi=636021061)
    assert late.notes == log.notes
    assert [record["x"].t.tolist() for record in late] == [record["x"].t.tolist() for record in log]


def test_a_table_of_the_danish_archive_is_read_with_the_day_before_the_month() -> None:
    log = nw.read_log({
        "# Timestamp": ["03/02/2024 23:59:50", "04/02/2024 00:00:00"], "Type of mobile": ["Class A"] * 2,
        "MMSI": [219000001] * 2, "Latitude": [55.0, 55.001], "Longitude": [10.0, 10.0], "ROT": [5.0, 7.0],
        "SOG": [10.0, 10.0], "COG": [1.0, 2.0], "Heading": [1.0, 2.0],
    })  # fmt: skip
    assert "t counts from 2024-02-03T23:59:50+00:00" in log.notes
    assert log[0]["x"].t.tolist() == [0.0, 10.0]
    assert "r" not in log[0]  # The archive does not document in which form it stands.
    np.testing.assert_allclose(log[0]["speed_over_ground"].values, 10 * 1852 / 3600)
    np.testing.assert_allclose(np.degrees(log[0]["psi"].values), [1.0, 2.0])


def test_an_archive_of_ships_one_after_the_other_is_not_taken_for_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = pd.DataFrame({**NOAA, "MMSI": [1, 1, 2, 2]})
    rows.to_csv(tmp_path / "ships.csv", index=False)
    monkeypatch.setattr(read_log, "PIECE_ROWS", 2)
    log = nw.stream_log(tmp_path / "ships.csv", gap=900.0)
    assert [len(record["x"]) for record in log] == [2]


def test_headers_are_read_in_any_case_of_letters() -> None:
    log = nw.read_log({"Time": ["2026-05-01T00:00:00Z"], "Rudder Angle [deg]": [5.0], "Rate of Turn (deg/min)": [6.0]})
    np.testing.assert_allclose(np.degrees([log[0]["rudder"].values[0], log[0]["r"].values[0]]), [5.0, 0.1])


def test_dates_and_times_count_from_the_first() -> None:
    log = nw.read_log({"UTC": ["2026-05-01T23:59:59Z", "2026-05-02T00:00:01.5Z"], "rudder": [0.1, 0.2]})
    assert log[0]["rudder"].t.tolist() == [0.0, 2.5]
    assert "t counts from 2026-05-01T23:59:59+00:00" in log.notes


def test_records_are_cut_by_their_column_or_at_gaps() -> None:
    named = {"record": ["A", "A", "B"], "t": [0.0, 1.0, 0.0], "rudder": [0.1, 0.1, 0.2]}
    assert nw.read_log(named).names == ("A", "B")
    gaps = {"t": [0.0, 1.0, 1000.0, 1001.0], "rudder": np.arange(4.0)}
    log = nw.read_log(gaps)
    assert [(own.name, len(own["rudder"])) for own in log] == [("record", 2), ("record 2", 2)]
    assert "cut into 2 records where nothing came for 300 s; gap= sets another time" in log.notes
    assert len(nw.read_log(gaps, gap=2000.0)) == 1


def test_what_is_read_piece_by_piece_is_what_is_read_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    frame = pd.concat([table(), table().assign(t=T + 3000.0)])
    frame.to_parquet(tmp_path / "log.parquet")
    frame.to_csv(tmp_path / "log.csv", index=False)
    whole = nw.read_log(frame)
    monkeypatch.setattr(read_log, "PIECE_ROWS", 37)
    for path in sorted(tmp_path.iterdir()):
        for one, other in zip(nw.stream_log(path), whole, strict=True):
            pd.testing.assert_frame_equal(one.to_dataframe(), other.to_dataframe())


def test_a_record_beyond_what_memory_likes_goes_on_in_another(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(read_log, "PIECE_ROWS", 100)
    monkeypatch.setattr(read_log, "MOST_ROWS", 100)
    log = nw.read_log({"record": ["A"] * 90 + ["B"] * 90, "t": np.arange(180.0), "r": np.zeros(180)})
    assert log.names == ("A", "B")


def test_a_place_on_earth_is_told_along_a_bend_and_of_midship() -> None:
    waterway, told, antenna = bent_waterway(), motion(T), (-70.0, 6.0)
    frame = antenna_on_earth(waterway, told, antenna).assign(t=T)
    place = {"antenna": dict(zip(("forward", "starboard"), antenna, strict=True))}
    record = nw.read_log(frame, waterway, place)[0]
    for name in ("x", "y", "psi"):
        np.testing.assert_allclose(record[name].values, told[name], atol=2e-5)
    assert record.antenna == (0.0, 0.0)
    unmoved = nw.read_log(frame, waterway)[0]
    assert np.abs(unmoved["x"].values - told["x"] + 70.0).max() < 6.0


def test_what_is_late_is_put_back() -> None:
    assert nw.read_log(table(), mapping={"late": {"rudder": 1.5}})[0]["rudder"].t.tolist() == (T - 1.5).tolist()


def test_velocities_in_fixed_axes_are_turned_into_those_of_the_ship() -> None:
    told, (u, v) = motion(T), (4.0 + 0.1 * np.sin(T / 20), 0.2 * np.cos(T / 30))
    ahead = u * np.cos(told["psi"]) - v * np.sin(told["psi"])
    aside = u * np.sin(told["psi"]) + v * np.cos(told["psi"])
    record = nw.read_log({"t": T, "psi": told["psi"], "x_rate": ahead, "y_rate": aside})[0]
    np.testing.assert_allclose(record["u_ground"].values, u)
    np.testing.assert_allclose(record["v_ground"].values, v)
    by_map = {"north_rate": ahead, "east_rate": aside}
    record = nw.read_log({"t": T, "heading": told["psi"], **by_map})[0]
    np.testing.assert_allclose(record["v_ground"].values, v, atol=1e-12)


def test_times_that_are_rounded_are_one_by_their_means() -> None:
    table = {"t": [0.0, 0.0, 1.0, 1.0], "psi [deg]": [359.0, 1.0, 2.0, 4.0], "r": [1.0, 3.0, 5.0, 5.0]}
    record = nw.read_log(table)[0]
    assert np.degrees(record["psi"].values) % 360 == pytest.approx([0.0, 3.0], abs=1e-9)
    assert record["r"].values.tolist() == [2.0, 5.0]


def told_by_a_tank(tank: str, path: Path) -> nw.Voyage:
    """A zigzag as a tank writes its columns: rudder to port, velocities in fixed axes, no headers."""
    voyage = zigzagged()
    ahead = voyage.u * np.cos(voyage.psi) - voyage.v * np.sin(voyage.psi)
    aside = voyage.u * np.sin(voyage.psi) + voyage.v * np.cos(voyage.psi)
    place, turning = [voyage.t, voyage.x, voyage.y], np.degrees([voyage.psi, voyage.r, -voyage.rudder])
    roll = np.full(len(voyage), 0.123)
    if tank == "hsva":
        columns = [*place, turning[0], ahead, aside, turning[1], roll, turning[2], roll + 10, roll, roll]
    else:
        columns = [*place, roll, turning[0], ahead, aside, roll, *turning[1:], 60 * (roll + 10)]
    lines = ["a tank", "a ship", "some columns", "of numbers"][: 4 if tank == "hsva" else 3]
    rows = [" ".join(f"{number:.9f}" for number in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([*lines, *rows]))
    return voyage


@cache
def zigzagged() -> nw.Voyage:
    law = nw.Zigzag(np.radians(10.0), np.radians(10.0))
    model = nw.published("yasukawa2015_kvlcc2")
    return nw.simulate(model, u=1.2, duration=60.0, dt=0.5, controller=law, contact="none", surge="free")


@pytest.mark.parametrize("tank", ["hsva", "marin"])
def test_the_mappings_of_two_tanks_read_what_they_write(tank: str, tmp_path: Path) -> None:
    voyage = told_by_a_tank(tank, tmp_path / "zigzag.dat")
    record = nw.read_log(tmp_path / "zigzag.dat", mapping=EXAMPLES / f"{tank}_kvlcc2.toml")["zigzag"]
    for name in ("x", "y", "psi", "r", "rudder"):
        np.testing.assert_allclose(record[name].values, voyage[name], atol=1e-7)
    np.testing.assert_allclose(record["u_ground"].values, voyage.u, atol=1e-7)
    np.testing.assert_allclose(record["v_ground"].values, voyage.v, atol=1e-7)
    np.testing.assert_allclose(record["revolutions"].values, 10.123)


@pytest.mark.parametrize(("tank", "records"), [("hsva", 11), ("marin", 6)])
def test_free_running_tests_of_two_tanks_are_one_motion(tank: str, records: int, shared_data: Path) -> None:
    """Velocities over ground are the rates of the position, and the yaw rate is the heading's."""
    files = sorted((shared_data / "kvlcc2_free_running" / tank).glob("*.dat"))
    log = nw.read_log(files, mapping=EXAMPLES / f"{tank}_kvlcc2.toml")
    assert len(log) == records
    for record in log:
        t, turned = record["psi"].t, np.diff(record["psi"].values)
        way = np.trapezoid(record["r"].values, t)
        np.testing.assert_allclose(turned.sum(), way, atol=0.05 * np.abs(turned).sum())
        cosine, sine = np.cos(record["psi"].values), np.sin(record["psi"].values)
        u, v = (record[name].values for name in ("u_ground", "v_ground"))
        way = np.trapezoid(np.stack([u * cosine - v * sine, u * sine + v * cosine]), t)
        made = [np.ptp(record[name].values[[0, -1]]) for name in ("x", "y")]
        np.testing.assert_allclose(np.abs(way), made, atol=0.03 * u.mean() * record.duration)


@pytest.mark.parametrize(
    ("log", "options", "told"),
    [
        ("nowhere.csv", {}, "no such file"),
        ({"t": [0.0]}, {}, "has times and nothing else"),
        ({"x": [0.0]}, {}, "no column has the time"),
        ({"time": ["yesterday"], "x": [0.0]}, {}, "row 0, column 'time' is no date"),
        ({"time": ["2026-05-01", 3.5], "x": [0.0, 1.0]}, {}, "row 1, column 'time' is no date"),
        ({"t": [0.0, 1.0], "lat": [52.0, 90.5], "lon": [5.0, 5.0]}, {}, "row 1, latitude 90.5 is not on earth"),
        ({"t": [], "x": []}, {}, "has no signal of a ship"),
        ({"t": [0.0], "rudder [m]": [0.0]}, {}, "not a unit of this quantity"),
        ({"t": [0.0], "rudder": ["left"]}, {}, "row 0, column 'rudder' holds left"),
        ({"record": ["A", "B", "A"], "t": [0.0, 1.0, 2.0], "r": [0, 0, 0]}, {}, "record A do not stand together"),
        ({"t": [0.0], "x": [1.0]}, {"mapping": {"colums": {}}}, "did you mean 'columns'"),
        ({"t": [0.0], "x": [1.0]}, {"mapping": {"columns": 3}}, "must be a section"),
        ({"t": [0.0], "x": [1.0]}, {"mapping": {"antenna": {"aft": 3.0}}}, "no 'aft'"),
        ({"t": [0.0], "x": [1.0]}, {"mapping": {"late": {"ruder": 1.0}}}, "did you mean 'rudder'"),
        ({"t": [0.0], "x": [1.0]}, {"mapping": {"late": {"x": "1"}}}, "is not a finite number"),
        ({"t": [0.0], "x": [1.0]}, {"gap": 0.0}, "no time without a row"),
        ({"t": [0.0], "x": [1.0]}, {"mmsi": -1}, "whole number"),
        ({"t": [0.0], "x": [1.0]}, {"mmsi": 244000000}, "needs AIS reports, and this table has none"),
        ({"MMSI": [1, 2], "BaseDateTime": ["2023-01-11"] * 2, "LAT": [1, 2], "LON": [1, 2]}, {}, "several ships"),
        ({"t": [0.0], "x": [1.0]}, {"units": {"speed": "kn"}}, "no documented column"),
        ({"t": [0.0], "x_rate": [1.0], "y_rate": [0.0]}, {}, "need the heading"),
        ({"t": [0.0], "heading": [1.0]}, {"waterway": bent_waterway()}, "only where the position is known"),
        ([], {}, "no log to read"),
    ],
)  # fmt: skip
def test_what_cannot_be_understood_is_said(log: object, options: dict, told: str) -> None:
    with pytest.raises(nw.InputError, match=told):
        nw.read_log(log, **options)


def test_longitude_needs_a_waterway_on_earth() -> None:
    nowhere = nw.straight_waterway(nw.Canal(300.0, 16.0), 4000.0)
    with pytest.raises(nw.InputError, match="has no position on earth"):
        nw.read_log({"t": [0.0], "lon": [5.0], "lat": [52.0]}, nowhere)


def test_a_voyage_its_table_and_its_file_are_logs(tmp_path: Path) -> None:
    """What learns from a log takes each of them, and finds the same readings."""
    voyage = nw.simulate(nw.published("estimated_kcs"), u=5.0, duration=60.0)
    voyage.to_csv(tmp_path / "voyage.csv")
    for log in (voyage, voyage.to_dataframe().reset_index(), tmp_path / "voyage.csv"):
        (record,) = log_records(log, None)
        np.testing.assert_allclose(record["y"].values, voyage.y, rtol=1e-12)
    loaded = nw.ShipRecord("loaded", record.signals, condition={"draft": 10.2})
    assert [*log_records(loaded, None)] == [loaded]
    with pytest.raises(nw.InputError, match="a int is no log"):
        log_records(3, None)
