"""What is wrong with a ship's log is found, one fault at a time; nothing is found where nothing is."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import narrows as nw
from faults import FAULTS, ashore, off, scaled, seldom
from logs import bend, bent_waterway, kvlcc2, zigzag
from narrows.logbook.checking import check_log
from narrows.logbook.checking.check_log import ALL, Checked, Finding, check_clock, check_place
from narrows.logbook.checking.faults import Fault, FaultTest, FaultTests
from narrows.logbook.filtering.likelihood import search
from narrows.logbook.learning.log_setup import log_problem
from narrows.logbook.ship_log import VDR, sensor_grade
from narrows.logbook.transits import TransitTwin
from twins import SPEED, large_container_ship, transits_of

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_a_zigzag_is_found_alone_with_its_remedy(fault: str) -> None:
    spoil, check, remedy = FAULTS[fault]
    found = nw.check_log([spoil(zigzag())], kvlcc2())
    assert {own.check for own in found} == {check}, found.summary()
    assert remedy in found.findings[0].remedy, found.summary()


@pytest.mark.parametrize("harms", [(), (0,), (1,), (0, 1), (2,)])
def test_faults_that_do_no_harm_hide_none_that_does(harms: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """The strongest is named, and the strongest that harms; after that no other, for others may follow from it."""
    every = [FaultTest(place, Fault("zero", "psi", None), "all", 1.0, 0.1 * (place + 1), 1e-9) for place in range(3)]
    tests = SimpleNamespace(tested=lambda known: [one for one in every if one.place not in known])
    monkeypatch.setattr(check_log, "_scores", lambda *asked: tests)
    monkeypatch.setattr(
        check_log, "_finding", lambda test, learned: Finding("all", str(test.place), "", "", test.place in harms)
    )
    found = [int(one.check) for one in check_log._tested(None, None, [], "all")]  # type: ignore[arg-type]
    assert found == [0, *(place for place in harms[:1] if place)]


def test_a_compass_that_stands_still_is_found_at_its_time() -> None:
    spoil, check, remedy = FAULTS["a compass that is stuck"]
    record = zigzag().between(0.0, 300.0)
    found = nw.check_log([spoil(record)], kvlcc2())
    assert {own.check for own in found} == {check}, found.summary()
    assert remedy in found.findings[0].remedy
    begin, end = (f"{record.start + share * 300:.0f}" for share in (1 / 3, 2 / 3))
    assert f"from t = {begin}" in found.findings[0].sentence
    assert f"to {end}" in found.findings[0].sentence


def test_nothing_is_found_where_nothing_is() -> None:
    found = nw.check_log([zigzag().between(0.0, 150.0)], kvlcc2())
    assert len(found) == 0, found.summary()
    assert found.summary() == "Nothing is wrong: 1 record looked at."


def test_nothing_is_found_in_a_long_record_either() -> None:
    found = nw.check_log([zigzag()], kvlcc2())
    assert len(found) == 0, found.summary()


@pytest.mark.parametrize("seed", [2, 3])
def test_sensors_better_than_their_grade_are_no_fault(seed: int) -> None:
    """Errors of satellites that are smaller than expected are not a place that is too small."""
    ship = large_container_ship()
    log = transits_of(TransitTwin(ship, SPEED, 600.0), sensor_grade("rtk"), 1, seed)
    found = nw.check_log(log, ship, sensors="vdr")
    assert found.clean, found.summary()


TRAPS = {
    "the rudder's sign is left out": ({"positive": {}}, {}, "rudder"),
    "velocities called u and v": ({}, {"u_ground": "column 5", "v_ground": "column 6"}, "u_ground and v_ground"),
}


@pytest.mark.slow
@pytest.mark.parametrize("trap", TRAPS)
def test_the_traps_of_a_tanks_files_are_found(trap: str, shared_data: Path) -> None:
    import tomllib

    sections, columns, check = TRAPS[trap]
    mapping = tomllib.loads((EXAMPLES / "hsva_kvlcc2.toml").read_text()) | sections
    known = {name: own for name, own in mapping["columns"].items() if not (columns and name in ("x_rate", "y_rate"))}
    path = shared_data / "kvlcc2_free_running" / "hsva" / "HSVA_CPMC_KVLCC2_Z_20_10_P.dat"
    log = nw.read_log(path, mapping={**mapping, "columns": {**known, **columns}})
    begun = [record.between(0.0, 60.0) for record in log]
    found = nw.check_log(begun, nw.published("yasukawa2015_kvlcc2"), sensors="basin")
    assert [own.check for own in found.wrong] == [check], found.summary()


@pytest.mark.slow
@pytest.mark.parametrize(("tank", "every"), [("hsva", 12), ("hsva", 6), ("marin", 3), ("hsva", 1), ("marin", 1)])
def test_a_model_that_differs_from_its_ship_does_not_stop_the_fit(tank: str, every: int, shared_data: Path) -> None:
    """No model is the ship in the tank; its error is no fault of a sensor."""
    files = sorted((shared_data / "kvlcc2_free_running" / tank).glob("*.dat"))[::every]
    log = nw.read_log(files, mapping=EXAMPLES / f"{tank}_kvlcc2.toml")
    model = nw.published("yasukawa2015_kvlcc2") if tank == "hsva" else kvlcc2()
    assert (found := nw.check_log(log, model, sensors="basin")).clean, found.summary()


@cache
def transits() -> nw.ShipLog:
    """Two transits of a ship whose coefficients are those of its tests."""
    ship = large_container_ship()
    return transits_of(TransitTwin(ship, SPEED, 600.0), VDR, 2, 3)


def scores_of(*spoilt: nw.ShipRecord) -> dict[tuple[str, str, str], FaultTest]:
    posed = log_problem(large_container_ship(), list(spoilt), "vdr")
    found = search(posed.problem, posed, 4)
    assert found is not None
    tests = FaultTests.of(found, posed, ALL).tested()
    return {(one.fault.kind, one.fault.signal, one.record): one for one in tests}


def test_scores_are_normal_where_there_is_no_fault_and_records_add_up() -> None:
    tests = scores_of(*transits())
    scores = [one.significance for one in tests.values()]
    assert np.abs(scores).max() < 4.0
    assert np.std(scores) == pytest.approx(1.0, abs=0.4)
    for kind, signal in (("gain", "rudder"), ("zero", "psi"), ("delay", "psi")):
        alone = [tests[kind, signal, record.name].error for record in transits()]
        assert tests[kind, signal, ALL].error < min(alone)


def test_the_size_of_a_small_fault_is_estimated() -> None:
    before = scores_of(*transits())
    for kind, signal, size, spoil in (
        ("zero", "psi", 0.05, off(0.05, "psi")),
        ("gain", "rudder", 1 / 0.9 - 1, scaled(0.9, "rudder")),
        ("gain", "r", 1 / 0.9 - 1, scaled(0.9, "r")),
    ):
        after, own = scores_of(*map(spoil, transits())), (kind, signal, ALL)
        assert after[own].size - before[own].size == pytest.approx(size, rel=0.35), own


def test_a_heading_that_is_off_is_wrong_as_it_moves_the_bank() -> None:
    spoilt = [off(np.radians(12.0), "psi")(record) for record in transits()]
    found = nw.check_log(spoilt, large_container_ship())
    assert [(own.check, own.record, own.wrong) for own in found] == [("psi zero", ALL, True)]
    size = re.search(r"psi reads ([\d.]+) ± ", found.findings[0].sentence)
    assert size is not None
    assert float(size[1]) == pytest.approx(12.0, abs=4.0)


def test_a_rudders_sign_is_found_in_a_transit() -> None:
    found = nw.check_log([scaled(-1.0, "rudder")(transits().records[0])], large_container_ship())
    assert [own.check for own in found.wrong] == ["rudder"]
    assert '[positive] rudder = "port"' in found.wrong[0].remedy
    assert found.to_dict()["clean"] is False


class TestAlongAWaterway:
    """Headings are to a line that bends, and banks are where it says."""

    way = bent_waterway(length=9000.0)

    def test_nothing_is_found_where_nothing_is(self) -> None:
        assert len(nw.check_log(nw.ShipLog((bend(),), self.way), kvlcc2())) == 0

    @pytest.mark.parametrize("name", ["psi", "y"])
    def test_signs_are_found(self, name: str) -> None:
        found = nw.check_log([scaled(-1.0, name)(bend().between(0.0, 300.0))], kvlcc2(), self.way)
        assert [own.check for own in found.wrong] == [name], found.summary()

    def test_a_hull_in_a_bank_is_found(self) -> None:
        found = nw.check_log([ashore(bend())], kvlcc2(), self.way)
        assert [own.check for own in found.wrong] == ["banks"]
        share = re.search(r"and ([\d.]+)% of the time", found.wrong[0].sentence)
        assert share is not None
        assert float(share[1]) > 50.0


def test_a_hull_that_lies_aslant_reaches_a_bank_by_its_corner() -> None:
    dtc = nw.published("mikkelsen2025_dtc")
    ship, heading, t = dtc.ship, np.radians(60.0), np.arange(3.0)
    reach = ship.length / 2 * np.sin(heading) + ship.beam / 2 * np.cos(heading)

    def found(clear: float) -> list[str]:
        y = dtc.configuration.canal.width / 2 - reach - clear
        signals = {name: nw.Signal(t, np.full(3, value)) for name, value in (("x", 0.0), ("y", y), ("psi", heading))}
        return [own.sentence for own in check_place(Checked(nw.ShipRecord("aslant", signals), dtc, None, 1.0))]

    assert found(0.01) == []
    (sentence,) = found(-0.01)
    assert sentence.startswith("the hull reaches 0.01 m into a bank")


def test_a_rudder_that_is_seldom_read_is_doubtful() -> None:
    found = nw.check_log([seldom(zigzag())], kvlcc2())
    assert [(own.check, own.wrong) for own in found if own.check == "sampling"] == [("sampling", False)]
    assert any("record it each second" in doubt for doubt in found.doubts)


def test_a_model_of_another_size_is_told() -> None:
    found = nw.check_log([zigzag()], nw.published("yasukawa2015_kvlcc2"))
    assert found.wrong[0].check == "speed"
    assert "scale_model" in found.wrong[0].remedy


@pytest.mark.parametrize(("back", "said"), [(0.5, "goes back by up to 0.5 s"), (0.0, "stands still")])
def test_a_clock_that_goes_back_by_half_a_second_does_not_stand_still(back: float, said: str) -> None:
    record = nw.ShipRecord("A", {"psi": nw.Signal(np.array([0.0, 1.0, 1.0 - back, 2.0]), np.zeros(4))})
    (found,) = check_clock(Checked(record, kvlcc2(), None, 1.0))
    assert found.sentence == f"the time of psi {said}, 1 times, first at t = {1.0 - back:g} s"


def test_findings_are_a_result() -> None:
    spoilt = [replace(scaled(0.0, "rudder")(zigzag()), name=name) for name in "AB"]
    found = nw.check_log(spoilt, kvlcc2())
    assert found.summary().splitlines()[0] == "1 finding, 2 records looked at."
    assert "rudder: in A and 1 more" in found.summary()
    assert found.to_dataframe()["record"].tolist() == ["A", "B"]


def test_a_record_that_tells_nothing_is_told() -> None:
    found = nw.check_log([zigzag().between(0.0, 9.0)], kvlcc2())
    assert [own.check for own in found.wrong] == ["missing"]


def test_there_must_be_a_record() -> None:
    with pytest.raises(nw.InputError, match="no record to check"):
        nw.check_log([], kvlcc2())
