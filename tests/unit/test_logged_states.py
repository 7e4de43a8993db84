"""States and alerts of recordings, against the voyages that were recorded."""

from functools import cache

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.estimation import Gnss, Gyro, Log

KCS = nw.published("estimated_kcs")
STATES = ["t", "x", "y", "psi", "u", "r", "rudder"]


@cache
def sailed() -> nw.Voyage:
    return nw.simulate(KCS, y=20.0, u=4.0, hold=0.0, duration=300.0)


def recorded(voyage: nw.Voyage) -> pd.DataFrame:
    """A recording, with the noise of a bridge's sensors."""
    table, random = voyage.to_dataframe()[STATES].iloc[::3].reset_index(drop=True), np.random.default_rng(3)
    for name, noise in {"x": 1.0, "y": 1.0, "psi": 0.003, "u": 0.05, "r": 2e-4}.items():
        table[name] += noise * random.standard_normal(len(table))
    return table


@pytest.mark.parametrize("smooth", [False, True])
def test_states_of_a_recorded_voyage_are_within_their_errors(smooth: bool) -> None:
    voyage, table = sailed(), recorded(sailed())
    track = nw.estimate_states(KCS, table, smooth=smooth)
    errors = track.to_dataframe()
    for name in ("x", "y", "psi", "u", "v", "r"):
        truth = np.interp(track.t, voyage.t, getattr(voyage, name))
        assert (np.abs(track[name] - truth) < 3.5 * errors[f"{name}_std"]).all()
    assert np.std(track["y"] - np.interp(track.t, voyage.t, voyage.y)) < 0.6
    assert track.smoothed is smooth
    assert track.plot("v").axes


def test_a_log_a_record_and_a_table_have_the_same_states() -> None:
    log = nw.read_log(recorded(sailed()).iloc[:60])
    track = nw.estimate_states(KCS, log)
    assert np.array_equal(track.mean, nw.estimate_states(KCS, log[0]).mean)
    assert np.array_equal(track.mean, KCS.estimate_states(recorded(sailed()).iloc[:60]).mean)  # type: ignore[attr-defined]
    own = nw.estimate_states(KCS, log, [Gnss(noise=5.0), Gyro(), Log()])
    assert own.refused.keys() == {"gnss", "gyro", "log"}
    assert (track.std[-1, :3] < nw.estimate_states(KCS, log, "ais").std[-1, :3]).all()


def test_speed_over_ground_starts_an_estimate_too() -> None:
    voyage = sailed()
    broadcast = recorded(voyage)[["t", "x", "y", "psi", "u"]].iloc[::8].rename(columns={"u": "speed_over_ground"})
    track = nw.estimate_states(KCS, broadcast, "ais")
    assert abs(track["u"][-1] - voyage.u[-1]) < 2 * track.to_dataframe().u_std.iloc[-1] < 1.0


def test_of_two_speeds_the_one_through_the_water_is_read() -> None:
    """A current of 0.5 m/s ahead, which the estimate is not told of."""
    table = recorded(sailed()).iloc[:40]
    both = nw.estimate_states(KCS, table.assign(speed_over_ground=table.u + 0.5))
    assert np.array_equal(both.mean, nw.estimate_states(KCS, table).mean)


def test_what_has_no_states_is_refused() -> None:
    table = recorded(sailed()).iloc[:20]
    with pytest.raises(nw.InputError, match="has 2 records; give one of them"):
        nw.estimate_states(KCS, nw.read_log([table, table.assign(t=table.t + 9999.0)]))
    with pytest.raises(nw.InputError, match="no sensor measures rudder of this log"):
        nw.estimate_states(KCS, table[["t", "rudder"]])


def test_a_monitor_gives_the_alerts_of_a_recording_in_order() -> None:
    voyage = nw.simulate(KCS, y=60.0, u=5.0)
    assert voyage.grounded
    monitor = nw.Monitor(KCS, members=20)
    recording = voyage.to_dataframe()[STATES].iloc[::2]
    alerts = monitor.run(recording[recording.t > voyage.t[-1] - 60.0])
    banks = [alert for alert in alerts if "bank to port" in alert.text]
    assert [one.changed for one in alerts] == sorted(one.changed for one in alerts)
    assert 30 < voyage.t[-1] - banks[0].changed < 120
    assert banks[0].level < banks[-1].level  # type: ignore[attr-defined]
    assert monitor.status
    assert monitor.alerts


def test_a_monitor_does_not_go_back_in_time() -> None:
    """A second recording that begins earlier would be judged by the last place of the first one."""
    monitor = nw.Monitor(KCS, members=50)
    monitor.run(recorded(sailed()).iloc[:20])
    with pytest.raises(nw.InputError, match="make a new Monitor for another recording"):
        monitor.run(recorded(sailed()).iloc[:20])
    assert type(monitor.status.t) is float  # type: ignore[union-attr]


def test_a_sensor_of_ones_own_needs_a_name_and_a_state() -> None:
    class Nameless(nw.estimation.Sensor):
        state = "u"

    class Stateless(nw.estimation.Sensor):
        name = "doppler"

    for sensor in (Nameless(0.1), Stateless(0.1), nw.estimation.Sensor(0.1)):
        with pytest.raises(nw.InputError, match="is no sensor; give objects such as"):
            nw.estimation.Estimator(KCS, [nw.estimation.Gnss(), nw.estimation.Gyro(), sensor])
