"""What a monitor says on both sides of its thresholds; a watched transit row by row; sentences by the clock."""

import inspect
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from shown_page import NOW, estimate, forecast
from transit import canal, ship

import narrows as nw
from narrows.readers.nmea import with_checksum
from narrows.warning.alerts.alert import (
    BANKS,
    LOG_LATE,
    NO_FORECAST,
    OTHER_DEPTH,
    SENSORS,
    SITUATIONS,
    Alert,
    AlertDesk,
    AlertState,
    BankLevel,
    Condition,
    Priority,
    command_of,
    level_of,
)
from narrows.warning.inputs.bridge_readings import Messages
from narrows.warning.monitoring.alert_publisher import AlertPublisher, alc, alf, hbt, sender_to
from narrows.warning.monitoring.bridge_monitor import BridgeMonitor, Cautions, extrapolations, other_depth
from narrows.warning.monitoring.watched_transit import BridgeStatus, Clearances, TransitLog, score_transits


@pytest.mark.parametrize(
    ("changed", "clear"),
    [
        ({}, True), ({"as_is": 0.01}, True), ({"as_is": 0.011}, False), ({"wrong_order": 40.0}, True),
        ({"wrong_order": 39.9}, False), ({"last_chance": 119.0}, False),
    ],
)  # fmt: skip
def test_clear_is_less_than_a_percent_and_40_s_after_a_wrong_order(changed: dict[str, float], clear: bool) -> None:
    assert replace(forecast(), **changed).clear is clear


def test_a_last_chance_is_gone_below_zero_and_a_margin_is_what_the_course_leaves() -> None:
    gone = [replace(forecast(), last_chance=left).gone for left in (0.0, -0.1)]
    assert gone == [False, True]
    likely = [replace(forecast().likely, last_chance=left).gone for left in (0.0, -0.1)]
    assert likely == [False, True]
    assert forecast().rudder_margin == pytest.approx(math.radians(35) - 0.3)
    assert replace(forecast(), last_chance=-5.0, nobody=1.0).level_time == 0.0
    assert replace(forecast(), last_chance=20.0, nobody=0.5).level_time == pytest.approx(20.0 / 0.55)


def test_a_level_ends_where_the_time_to_act_is_longer_than_its_threshold_over_070() -> None:
    """A warning of 60 s holds to 85.7 s: at 86 s for ten seconds it becomes a caution, which holds to 128.6 s."""

    def levels(left: float, start: Priority) -> list[Priority]:
        level, told = BankLevel(start), replace(forecast(50.0), last_chance=left, nobody=1.0)
        return [level.update(float(t), level_of(told), level_of(told, 0.7)) for t in range(12)]

    assert set(levels(85.0, Priority.WARNING)) == {Priority.WARNING}
    assert levels(86.0, Priority.WARNING) == [Priority.WARNING] * 10 + [Priority.CAUTION] * 2
    assert set(levels(128.0, Priority.CAUTION)) == {Priority.CAUTION}
    assert levels(129.0, Priority.CAUTION) == [Priority.CAUTION] * 10 + [Priority.NONE] * 2
    assert levels(59.0, Priority.NONE) == [Priority.NONE] * 2 + [Priority.WARNING] * 10


def messages(t: float = 0.0, **given: object) -> Messages:
    ages = {"position": 0.0, "heading": 0.0, "rudder": 0.0}
    ages |= given.pop("ages", {})  # type: ignore[arg-type]
    return Messages(t, {}, ages, {}, **{"depth": None, **given})  # type: ignore[arg-type]


def calm_estimate(refused: tuple[str, ...] = (), suspects: tuple[str, ...] = ()) -> SimpleNamespace:
    return SimpleNamespace(refused=refused, suspects=suspects)


@pytest.mark.parametrize(
    ("what", "age", "priority"),
    [
        ("position", 3.0, Priority.NONE), ("position", 3.1, Priority.CAUTION), ("heading", 10.0, Priority.CAUTION),
        ("heading", 10.1, Priority.WARNING), ("rudder", 10.1, Priority.WARNING), ("yaw rate", 9.9, Priority.NONE),
        ("yaw rate", 10.1, Priority.CAUTION), ("speed through the water", 99.0, Priority.CAUTION),
    ],
)  # fmt: skip
def test_a_silent_sensor_is_a_caution_and_a_needed_one_soon_a_warning(
    what: str, age: float, priority: Priority
) -> None:
    """3 s for position, heading and rudder, which end the forecasts after 10 s; 10 s for the others."""
    said = Cautions().conditions(messages(ages={what: age}), calm_estimate(), "")
    assert said[SENSORS[what]].priority is priority
    assert bool(said[SENSORS[what]].text) == (priority > Priority.NONE)
    assert all(not one.priority for situation, one in said.items() if situation != SENSORS[what])


def test_a_doubt_is_shown_for_ten_seconds_after_it_last_held() -> None:
    cautions = Cautions()
    said = cautions.conditions(messages(0.0), calm_estimate(("gnss",), ("gyro",)), "the echo sounder reads")
    texts = {SENSORS["position"]: "gnss jumps", SENSORS["heading"]: "gyro drifts, or is led astray"}
    assert {one: said[one].text for one in texts} == texts
    assert said[OTHER_DEPTH] == Condition(Priority.CAUTION, "the echo sounder reads")
    held = cautions.conditions(messages(9.9), calm_estimate(), "")
    assert {one: held[one].text for one in texts} == texts
    over = cautions.conditions(messages(10.0), calm_estimate(), "")
    assert not any(one.priority for one in over.values())


@pytest.mark.parametrize(("share", "is_said"), [(1.09, False), (1.11, True), (0.89, True), (0.91, False)])
def test_another_depth_by_10_percent_is_said(share: float, is_said: bool) -> None:
    assert bool(other_depth(canal(), estimate(0.0), messages(depth=share * 16.2))) is is_said


def test_conditions_that_no_test_covered_are_named_one_by_one() -> None:
    """Speed, offset, heading and section of now against the tested range; at a speed that touches, also the bottom."""
    covered = nw.DataRange(
        speed=(3.0, 5.0), abs_y=(0.0, 70.0), abs_psi=(0.0, 0.1), width_to_beam=(9.0, 9.8), depth_to_draft=(1.4, 1.6)
    )
    model = replace(ship(), data_range=covered)
    assert 9.0 < 300.0 / model.configuration.ship.beam < 9.8
    assert 1.4 < 16.2 / model.configuration.ship.draft < 1.6
    assert extrapolations(model, canal(), estimate(0.0, {**NOW, "x": 800.0})) == ()
    for name, value in (("u", 5.5), ("u", 2.5), ("y", -75.0), ("y", 75.0), ("psi", -0.2), ("psi", 0.2)):
        assert len(extrapolations(model, canal(), estimate(0.0, {**NOW, "x": 800.0, name: value}))) == 1, (name, value)
    wide = replace(model, data_range=replace(covered, speed=(0.0, 30.0)))
    for u in (12.0, -12.0):
        said = extrapolations(wide, canal(), estimate(0.0, {**NOW, "x": 800.0, "u": u}))
        assert sum("touches the bottom" in one for one in said) == 1
    for part in ({"width_to_beam": (4.0, 5.0)}, {"depth_to_draft": (2.0, 3.0)}):
        assert (
            len(
                extrapolations(
                    replace(model, data_range=replace(covered, **part)), canal(), estimate(0.0, {**NOW, "x": 800.0})
                )
            )
            == 1
        )


def conditions(
    t: float, told: object, began: float = 100.0, why: str = "because", late: str = "", seen: object = None
) -> dict:
    one = SimpleNamespace(
        publisher=SimpleNamespace(late=late), model=ship(), waterway=canal(), _cautions=Cautions(), _began=began,
        _levels={side: BankLevel() for side in BANKS}, desk=AlertDesk(),
    )  # fmt: skip
    said = {}
    for second in range(3):
        now = seen or estimate(0.0)
        said = BridgeMonitor._conditions(one, messages(t + second), now, told, why)  # type: ignore[arg-type]
    return said


def test_without_an_estimate_an_alert_of_draft_or_depth_stays_as_it_was() -> None:
    assert OTHER_DEPTH in conditions(118.0, None)
    unknown = SimpleNamespace(ready=False, refused=(), suspects=())
    assert OTHER_DEPTH not in conditions(118.0, None, seen=unknown)


def test_a_missing_forecast_is_a_warning_after_20_s_and_a_hazard_has_a_side() -> None:
    assert not conditions(117.9, None)[NO_FORECAST].priority  # its last second is 19.9 s after the start
    assert conditions(118.0, None)[NO_FORECAST] == Condition(Priority.WARNING, "because")
    assert not conditions(118.0, forecast())[NO_FORECAST].priority
    assert not set(BANKS.values()) & set(conditions(118.0, None))
    said = conditions(118.0, replace(forecast(50.0, 20.0), nobody=1.0))
    assert said[BANKS["starboard"]].priority is Priority.ALARM
    assert said[BANKS["starboard"]].text.startswith("20 s to act: bank to starboard")
    assert not said[BANKS["port"]].priority
    assert conditions(118.0, forecast(), late="not on disk")[LOG_LATE] == Condition(Priority.CAUTION, "not on disk")


def status(t: float, **given: object) -> BridgeStatus:
    usual = {
        "estimate": estimate(t),
        "forecast": None,
        "alerts": (),
        "changed": (),
        "clearances": Clearances(40.0, 25.0),
        "faults": {},
    }
    return BridgeStatus(t, **{**usual, **given})  # type: ignore[arg-type]


def test_a_watched_transit_has_a_row_for_each_second() -> None:
    """Seconds count from the first; a last chance that is gone is 0; what is not known is NaN."""
    alert = Alert(BANKS["port"].identifier, Priority.WARNING, AlertState.UNACKNOWLEDGED, "text")
    gone = replace(forecast(30.0, -4.0), nobody=0.7)
    log = TransitLog(ship().configuration, canal())
    log.add(status(500.0, estimate=estimate(0.0, None), clearances=Clearances()))
    log.add(status(501.0, forecast=forecast(), faults={"late": 2}))
    log.add(status(503.0, forecast=gone, alerts=(alert,), changed=(alert,), clearances=Clearances(12.0, 30.0)))
    seen = log.transit()
    rows = {name: column.tolist() for name, column in seen.columns.items()}
    nan = pytest.approx(math.nan, nan_ok=True)
    assert rows["t"] == [0.0, 1.0, 3.0]
    assert rows["x"] == [nan, 3200.0, 3200.0]
    assert rows["u"] == [nan, 4.2, 4.2]
    assert rows["clearance"] == [nan, 25.0, 12.0]
    assert rows["contact"] == [nan, math.inf, 30.0]
    assert rows["last_chance"] == [nan, math.inf, 0.0]
    assert rows["nobody"] == [nan, 0.0, 0.7]
    assert rows["unattended"] == [nan, 0.4, 0.4]
    assert rows["rudder"] == [nan, 0.1, 0.1]
    assert rows["rudder_needed"] == [nan, -0.3, -0.3]
    assert rows["level"] == [0.0, 0.0, 2.0]
    assert [(said.t, said.alert) for said in seen.alerts] == [(3.0, alert)]
    assert (seen.level, seen.faults) == (Priority.WARNING, {})
    told = seen.to_dict()
    assert (told["seconds"], told["forecast"], told["least_clearance"]) == (3, 2, 12.0)
    assert told["least_rudder_margin"] == pytest.approx(math.radians(35) - 0.3)
    blind = TransitLog(ship().configuration, canal())
    blind.add(status(0.0, estimate=estimate(0.0, None), clearances=Clearances()))
    nothing = blind.transit().to_dict()
    assert (nothing["least_clearance"], nothing["least_rudder_margin"], nothing["level"]) == (None, None, "none")


def test_a_status_is_of_the_nearer_bank_and_of_alerts_whose_condition_holds() -> None:
    held = Alert(BANKS["port"].identifier, Priority.CAUTION, AlertState.ACKNOWLEDGED, "held")
    over = Alert(BANKS["starboard"].identifier, Priority.ALARM, AlertState.RECTIFIED, "over")
    now = status(0.0, forecast=forecast(), alerts=(over, held))
    assert (now.clearance, now.level, now.word, now.headline) == (25.0, Priority.CAUTION, "caution", "held")
    near = [status(0.0, forecast=forecast(), clearances=Clearances(room, 90.0)).word for room in (20.0, 19.9)]
    assert near == ["clear", "watch"]


def test_no_score_has_no_median_and_no_rate() -> None:
    scores = score_transits({})
    assert (scores.contacts, scores.clear, scores.hours) == (0, 0, 0.0)
    assert np.isnan(scores.table["false"]).all()


def test_revisions_count_to_99_and_begin_again_at_1() -> None:
    alert = Alert(BANKS["port"].identifier, Priority.ALARM, AlertState.UNACKNOWLEDGED, "text", revision=98)
    once = alert.timed(60.0)
    assert (once.revision, once.repeats) == (99, 1)
    assert once.timed(119.9) is once
    assert once.timed(120.0).revision == 1
    assert replace(once, repeats=9).timed(999.0).repeats == 9


def test_identifiers_are_a_makers_own_and_none_is_twice() -> None:
    """IEC 62923-1: from 10000 on; names of at most 16 letters."""
    numbers = [10110, 10111, 10120, 10121, 10122, 10123, 10124, 10125, 10126, 10127, 10130, 10140, 10150]
    assert sorted(SITUATIONS) == numbers
    assert all(len(one.name) <= 16 for one in SITUATIONS.values())


def test_lists_go_out_each_30_s_and_heartbeats_each_60_s_with_numbers_that_go_round() -> None:
    sent: list[str] = []
    publisher = AlertPublisher(None, sent.append)
    for t in range(1200):
        publisher.beat(float(t), (), t < 600)
    lists, beats = ([line for line in sent if line[3:6] == kind] for kind in ("ALC", "HBT"))
    assert lists == [alc([], number)[0] for number in range(40)]
    assert beats == [hbt(number < 10, number % 10) for number in range(20)]
    assert alc([], 100)[0] == alc([], 0)[0]
    alert = Alert(BANKS["port"].identifier, Priority.ALARM, AlertState.UNACKNOWLEDGED, "text")
    assert alf(alert, 0.0, 10) == alf(alert, 0.0, 0)
    assert alf(alert, 0.0, 10) != alf(alert, 0.0, 5)
    sent.clear()
    publisher.publish([alert, alert], 0.0)
    assert sent == [*alf(alert, 0.0, 0), *alf(alert, 0.0, 1)]


@pytest.mark.parametrize(("port", "taken"), [(65_535, True), (65_536, False)])
def test_a_port_is_a_number_of_16_bits(port: int, taken: bool) -> None:
    if taken:
        with sender_to(f"udp://127.0.0.1:{port}") as send:
            send("text")
        return
    with pytest.raises(nw.InputError, match="alerts go out by UDP"), sender_to(f"udp://127.0.0.1:{port}"):
        pass


def test_an_escape_steers_to_the_line_and_an_antenna_stands_amidships_unless_told() -> None:
    usual = inspect.signature(BridgeMonitor).parameters
    assert [usual[name].default for name in ("line", "antenna", "members", "live")] == [0.0, (0.0, 0.0), 1000, True]
    assert [inspect.signature(nw.Monitor).parameters[name].default for name in ("line", "members")] == [0.0, 1000]


def test_what_is_no_command_is_none() -> None:
    assert command_of(b"$HEHDT,1.0,T") is None
    assert command_of(with_checksum("INACN,,SAL,10110,7,A,C").strip().encode()) is None
    assert command_of(with_checksum("INACN,,,10110,7,A,C").strip().encode()) is not None
