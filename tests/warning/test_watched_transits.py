"""Transits that were watched: told, scored, and the demonstration with its verb."""

import json
import signal
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from transit import canal, ship
from watch import monitored, ticks, without

import narrows as nw
from narrows.cli.watching import end_by_sigterm
from narrows.report.transit_report import transit_track_figure, write_transit_report
from narrows.warning.alerts.alert import logged
from narrows.warning.inputs.bridge_readings import BridgeReadings
from narrows.warning.monitoring import bridge_monitor, watched_transit
from narrows.warning.monitoring.demonstration import demonstration
from narrows.warning.monitoring.watched_transit import (
    PREDICTORS,
    BridgeStatus,
    TransitLog,
    WatchedTransit,
    score_transits,
)

MISTAKE = (40.0, 120.0)  # [s] in which the demonstration's rudder is wrong
NEEDED_TIME = 10.0  # [s] to act


def test_recorded_transits_are_scored() -> None:
    """Two short twins: one that stays in the middle, and one that is steered into the bank."""
    told = {"calm": ticks(14), "aground": ticks(34, y=75.0, psi=0.25, rudder=0.5), "mute": ticks(12, without("HEHDT"))}
    transits = {name: transit_of(monitored(heard)) for name, heard in told.items()}
    scores = score_transits(transits)
    assert (scores.contacts, scores.clear, scores.unknown) == (1, 1, ("mute",))
    assert (scores.table["false"] == 0).all()
    left = dict(zip(PREDICTORS, scores.left["aground"], strict=True))
    assert left["caution"] >= left["alarm"]
    assert scores.table.loc["caution", "in_time"] == (left["caution"] >= NEEDED_TIME)
    assert "1 transit with a contact" in scores.summary()
    assert any("mute" in note for note in scores.notes)


def transit_of(said: list[BridgeStatus]) -> WatchedTransit:
    log = TransitLog(ship().configuration, canal())
    for status in said:
        log.add(status)
    return log.transit()


def test_a_transit_is_told_drawn_and_tabled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    transit = transit_of(monitored(ticks(18, y=95.0, psi=0.25, rudder=0.5)))
    assert "First" in transit.summary()
    assert "near miss" not in transit.summary()
    assert "in contact with it" in transit.summary().splitlines()[-1]
    assert transit.to_dict()["least_clearance"] < 150.0
    assert len(transit.to_dataframe()) == 18
    assert "decision support" in transit.notes[0]
    transit.save(tmp_path / "a.png")
    transit.save(tmp_path / "a.csv")
    monkeypatch.setattr(watched_transit.settings, "MOST_SECONDS", 4)
    kept = TransitLog(ship().configuration, canal())
    for status in monitored(ticks(7)):
        kept.add(status)
    assert kept.transit().columns["t"].tolist() == [3.0, 4.0, 5.0, 6.0]
    assert (
        transit_of([]).summary() == f"{ship().configuration.ship.name} on canal: 0 seconds watched, 0 with a forecast."
    )


def test_the_swept_hull_is_as_far_from_the_banks_as_was_said() -> None:
    transit = transit_of(monitored(ticks(9, y=95.0, psi=0.25, rudder=0.5)))
    told = {name: column[transit.located] for name, column in transit.columns.items()}
    figure = transit_track_figure(transit)
    starboard = max(figure.axes[0].lines, key=lambda line: np.nanmean(line.get_ydata()))
    swept = np.concatenate([path.vertices for part in figure.axes[0].collections for path in part.get_paths()])
    edge = np.array([swept[np.isclose(swept[:, 0], x), 1].max() for x in told["x"]])
    assert np.interp(told["x"], *starboard.get_data()) - edge == pytest.approx(told["clearance"], abs=1e-6)
    assert len(told["x"]) > 3


def test_a_transit_of_which_no_place_is_known_has_a_page_without_a_map(tmp_path: Path) -> None:
    seen, blind = ticks(6), ticks(6, without("GPGGA"))
    pages = []
    for name, heard in (("seen.html", seen), ("blind.html", blind)):
        write_transit_report(transit_of(monitored(heard)), tmp_path / name)
        pages.append((tmp_path / name).read_text(encoding="utf-8"))
    assert ["unrolled" in page for page in pages] == [True, False]


@pytest.mark.slow
@pytest.mark.parametrize("members", [100, 1000])
def test_the_demonstration_warns_before_the_ship_is_near(
    members: int, tmp_path: Path, cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An alarm, a minute before it is aground, as is said at last; table, page and log of alerts say the same."""
    monkeypatch.setattr(bridge_monitor, "BridgeMonitor", partial(bridge_monitor.BridgeMonitor, members=members))
    files = {"--report": "r.html", "-o": "t.csv", "--log": "a.db", "--recording": "b.nmea"}
    words = [word for option, name in files.items() for word in (option, str(tmp_path / name))]
    code, out, err = cli("monitor", "--demo", "--json", *words)
    assert code == 1, err
    told, table = json.loads(out), pd.read_csv(tmp_path / "t.csv")
    alarm = next(alert for alert in told["alerts"] if alert["priority"] in ("alarm", "emergency alarm"))
    nearest = float(table["t"][table["clearance"].idxmin()])
    assert MISTAKE[0] < alarm["t"] < nearest - 60.0
    assert told["forecast"] > 0.95 * told["seconds"]
    assert told["least_clearance"] == pytest.approx(table["clearance"].min())
    assert 0.0 < told["least_clearance"] < 20.0
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "decision support" in page
    assert "in contact with it" in page
    assert len(logged(tmp_path / "a.db")) == len(told["alerts"])
    assert len((tmp_path / "b.nmea").read_bytes().splitlines()) == 7 * told["seconds"]


def test_a_recording_of_the_demonstration_can_be_replayed(tmp_path: Path) -> None:
    from narrows.warning.inputs.bridge_readings import replay

    shown = demonstration()
    (tmp_path / "bridge.nmea").write_bytes(shown.recording())
    again = list(replay(tmp_path / "bridge.nmea"))
    told = list(shown.ticks())
    # A voyage may end within a second; the recording has whole seconds.
    assert [one.t for one in again] == sorted({float(round(one.t)) for one in told})
    assert sorted(repr(one.message) for one in again[5].entries) == sorted(repr(one.message) for one in told[5].entries)
    assert again[-1].faults == {}


def test_the_demonstration_is_a_mistake_in_a_canal_that_bends() -> None:
    """230 m of ship, 368 m of canal, a rudder at 27 degrees from 40 s to 120 s, and a pilot before and after."""
    shown = demonstration()
    way, voyage = shown.waterway, shown.voyage
    assert shown.model.configuration.ship.length == pytest.approx(230.0)
    here = way.section(np.array([100.0, 5000.0]))
    np.testing.assert_allclose(here.width, 368.0)
    np.testing.assert_allclose(here.depth, 16.2)
    assert way.line.length == pytest.approx(6000.0, abs=21.0)
    np.testing.assert_allclose(
        way.line.curvature(np.array([500.0, 2400.0, 2600.0, 5500.0])), [0, 0, 2e-4, 2e-4], atol=2e-6
    )
    assert (voyage.x[0], voyage.y[0], voyage.u[0]) == (300.0, 30.0, 4.2)
    np.testing.assert_allclose(np.diff(voyage.t)[:-1], 1.0)
    assert voyage.outcome.kind == "grounded"
    assert 140.0 < voyage.t[-1] < 175.0
    held = voyage.t < 40.0
    assert np.abs(voyage.y[held] - 30.0).max() < 2.0
    assert np.abs(voyage.rudder[held]).max() < np.radians(10.0)
    np.testing.assert_allclose(voyage.rudder[(voyage.t > 60.0) & (voyage.t < 120.0)], np.radians(27.0), atol=1e-6)
    assert voyage.rudder[(voyage.t > 135.0)].min() < np.radians(10.0)


def test_the_sensors_of_the_demonstration_scatter_about_its_voyage() -> None:
    """Standard deviations as stated: 1 m, 0.2 degrees, 0.03 degrees a second, 0.05 m/s, and no mean error."""
    shown = demonstration()
    readings, voyage = BridgeReadings(shown.waterway, 8.0), shown.voyage
    told = [readings.convert(tick).readings for tick in shown.ticks()]
    speed, course = np.hypot(voyage.u, voyage.v), voyage.psi + np.arctan2(voyage.v, voyage.u)
    sensors = {
        "x": ([one["gnss"][0] for one in told], voyage.x, 1.0),
        "y": ([one["gnss"][1] for one in told], voyage.y, 1.0),
        "heading": ([one["gyro"] for one in told], voyage.psi, np.radians(0.2)),
        "yaw rate": ([one["rate_of_turn"] for one in told], voyage.r, np.radians(0.03)),
        "log": ([one["log"] for one in told], voyage.u, 0.05),
        "rudder": ([one["rudder"] for one in told], voyage.rudder, np.radians(0.2)),
        "course": ([one["course"][0] for one in told], course, 0.01),
        "speed": ([one["course"][1] for one in told], speed, 0.05),
    }
    for name, (measured, truth, sigma) in sensors.items():
        off = np.array(measured) - truth
        assert off.std() == pytest.approx(sigma, rel=0.2), name
        assert abs(off.mean()) < 4 * sigma / np.sqrt(len(off)), name


def test_a_recording_of_nothing_is_no_watch(tmp_path: Path, cli) -> None:
    (tmp_path / "empty.nmea").write_text("nothing\n")
    ship().save(tmp_path / "full.toml")
    nw.write_waterway(canal(), tmp_path / "canal.geojson")
    words = ("--waterway", str(tmp_path / "canal.geojson"), "--replay", str(tmp_path / "empty.nmea"))
    code, _, err = cli("monitor", str(tmp_path / "full.toml"), *words)
    assert code == 2
    assert "it has no valid sentence" in err


def test_sigterm_ends_a_watch_as_ctrl_c_does() -> None:
    before = signal.getsignal(signal.SIGTERM)
    end_by_sigterm()
    try:
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
    finally:
        signal.signal(signal.SIGTERM, before)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ((), "give exactly one of --listen, --replay, --score, --demo"),
        (("--demo", "a.toml"), "give exactly one of MODEL, --demo"),
        (("--replay", "a.nmea"), "give exactly one of MODEL, --demo"),
        (("--demo", "--pace", "0"), "--pace 0 is no pace"),
        (("--demo", "--port", "9"), "--port goes with --page; add it"),
        (("--demo", "--send", "ws://"), "write the address as in udp://239.192.0.1:60001"),
        (
            ("a.toml", "--replay", "a", "--waterway", "b", "--recording", "c.nmea"),
            "--recording goes with --demo",
        ),
    ],
)
def test_the_verb_says_what_it_lacks(cli, words: tuple[str, ...], sentence: str) -> None:
    code, _, err = cli("monitor", *words)
    assert code == 2
    assert sentence in err
