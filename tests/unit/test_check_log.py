"""What is wrong with a ship's log is found, one fault at a time; nothing is found where nothing is."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import narrows as nw
from faults import FAULTS, ashore, cut, scaled
from logs import bend, bent_waterway, circle, kvlcc2, sensed, trial, zigzag
from narrows.logbook.checking.agreement import factor_of, least_squares, turned_of

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_a_zigzag_is_found_alone_with_its_remedy(fault: str) -> None:
    spoil, check, remedy = FAULTS[fault]
    found = nw.check_log([spoil(zigzag())], kvlcc2())
    assert not found.clean
    assert [own.check for own in found.wrong] == [check], found.summary()
    assert remedy in found.wrong[0].remedy, found.summary()
    assert found.wrong[0].evidence or check == "missing"


@pytest.mark.parametrize("seed", range(3))
def test_nothing_is_found_where_nothing_is(seed: int) -> None:
    records = [zigzag(20.0, seed), zigzag(-10.0, seed), circle(), circle(-35.0)]
    found = nw.check_log([replace(own, name=str(i)) for i, own in enumerate(records)], kvlcc2())
    assert found.clean
    assert len(found) == 0, found.summary()
    assert found.summary() == "Nothing is wrong: 4 records looked at."


def test_a_gap_is_doubtful_and_not_wrong() -> None:
    found = nw.check_log([cut(zigzag())], kvlcc2())
    assert [(own.check, own.wrong) for own in found] == [("gaps", False)]
    assert found.findings[0].evidence["longest"] == pytest.approx(82.0)
    assert found.clean


@pytest.mark.parametrize(("tank", "length"), [("hsva", 7.0), ("marin", 320.0)])
def test_free_running_tests_of_two_tanks_are_clean(tank: str, length: float, shared_data: Path) -> None:
    files = sorted((shared_data / "kvlcc2_free_running" / tank).glob("*.dat"))
    model = kvlcc2() if length > 7 else nw.published("yasukawa2015_kvlcc2")
    log = nw.read_log(files, mapping=EXAMPLES / f"{tank}_kvlcc2.toml")
    assert len(nw.check_log(log, model)) == 0


TRAPS = {
    "the rudder's sign is left out": ({"positive": {}}, {}, "rudder's sign"),
    "velocities called u and v": ({}, {"u_ground": "column 5", "v_ground": "column 6"}, "velocity over ground"),
    "the roll angle called the yaw rate": ({}, {"r": "column 8"}, "yaw rate"),
}


@pytest.mark.parametrize("trap", TRAPS)
def test_the_traps_of_a_tanks_files_are_found(trap: str, shared_data: Path) -> None:
    import tomllib

    sections, columns, check = TRAPS[trap]
    mapping = tomllib.loads((EXAMPLES / "hsva_kvlcc2.toml").read_text()) | sections
    known = {name: own for name, own in mapping["columns"].items() if not (columns and name in ("x_rate", "y_rate"))}
    path = shared_data / "kvlcc2_free_running" / "hsva" / "HSVA_CPMC_KVLCC2_Z_20_10_P.dat"
    log = nw.read_log(path, mapping={**mapping, "columns": {**known, **columns}})
    found = nw.check_log(log, nw.published("yasukawa2015_kvlcc2"))
    assert [own.check for own in found.wrong] == [check], found.summary()


class TestAlongAWaterway:
    """Headings are to a line that bends, and banks are where it says."""

    way = bent_waterway(length=9000.0)

    def test_nothing_is_found_where_nothing_is(self) -> None:
        log = nw.ShipLog((bend(),), self.way)
        assert len(nw.check_log(log, kvlcc2())) == 0

    @pytest.mark.parametrize("fault", ["a heading to port", "a yaw rate to port", "velocities in knots", "y to port"])
    def test_faults_are_found(self, fault: str) -> None:
        spoil, check, remedy = FAULTS[fault]
        found = nw.check_log([spoil(bend())], kvlcc2(), self.way)
        assert [own.check for own in found.wrong] == [check], found.summary()
        assert remedy in found.wrong[0].remedy

    def test_a_hull_in_a_bank_is_found(self) -> None:
        found = nw.check_log([ashore(bend())], kvlcc2(), self.way)
        assert [own.check for own in found.wrong] == ["banks"]
        assert found.wrong[0].evidence["share"] > 0.5
        narrow = bent_waterway(length=9000.0)
        assert nw.check_log([bend()], kvlcc2(), narrow).clean


def test_several_quiet_records_tell_the_rudders_sign_together() -> None:
    voyage = trial(nw.Zigzag(np.radians(4.0), np.radians(2.0)), 500.0)
    quiet = [scaled(-1.0, "rudder")(sensed(f"quiet {i}", voyage, i)) for i in range(12)]
    assert nw.check_log(quiet[:1], kvlcc2()).clean
    found = nw.check_log(quiet, kvlcc2())
    assert [(own.check, own.record) for own in found.wrong] == [("rudder's sign", "all records")]


def test_several_quiet_records_tell_the_yaw_rates_sign_together_and_blame_no_rudder() -> None:
    """Of a rate of turn whose noise is three times what there is to see: no one record tells."""
    voyage = trial(nw.Zigzag(np.radians(2.0), np.radians(1.0)), 500.0)

    def noisy(sign: float, seed: int) -> nw.ShipRecord:
        record = scaled(sign, "r")(sensed(f"quiet {seed}", voyage, seed))
        r, noise = record["r"], np.random.default_rng(seed).standard_normal(len(record["r"]))
        return record.with_signals(r=nw.Signal(r.t, r.values + 3.0 * r.values.std() * noise))

    right, turned = ([noisy(sign, seed) for seed in range(12)] for sign in (1.0, -1.0))
    assert nw.check_log(turned[:1], kvlcc2()).clean
    assert nw.check_log(right, kvlcc2()).clean
    found = nw.check_log(turned, kvlcc2())
    assert [(own.check, own.record) for own in found.wrong] == [("yaw rate", "all records")]
    assert '[positive] r = "port"' in found.wrong[0].remedy


def test_a_rudder_that_is_seldom_told_is_doubtful() -> None:
    rudder = zigzag()["rudder"]
    seldom, often = (
        zigzag().with_signals(rudder=nw.Signal(rudder.t[::every], rudder.values[::every]))
        for every in (round(0.3 * 320.0 / 7.0 / rudder.step), 2)
    )
    found = nw.check_log([seldom], kvlcc2())
    assert [(own.check, own.wrong) for own in found if own.check == "sampling"] == [("sampling", False)]
    assert any("record it each second" in doubt for doubt in found.doubts)
    assert nw.check_log([often], kvlcc2()).doubts == ()


def test_a_model_of_another_size_is_told() -> None:
    found = nw.check_log([zigzag()], nw.published("yasukawa2015_kvlcc2"))
    assert found.wrong[0].check == "speed"
    assert "scale_model" in found.wrong[0].remedy


def test_findings_are_a_result() -> None:
    spoilt = replace(scaled(-1.0, "r")(zigzag()), name="B")
    found = nw.check_log([scaled(-1.0, "r")(zigzag()), spoilt, cut(circle())], kvlcc2())
    assert found.summary().splitlines()[0] == "2 findings, 3 records looked at."
    assert "yaw rate: in zigzag +20 and 1 more" in found.summary()
    assert "gaps (doubtful): in circle" in found.summary()
    assert found.to_dataframe()["record"].tolist() == ["zigzag +20", "B", "circle"]
    assert found.to_dict()["clean"] is False
    assert found.plot().axes[0].has_data()
    assert nw.check_log([circle()], kvlcc2()).plot().axes[0].get_title().startswith("Nothing is wrong")


def test_a_record_that_tells_nothing_is_told() -> None:
    found = nw.check_log([zigzag().between(0.0, 9.0)], kvlcc2())
    assert [own.check for own in found.wrong] == ["missing"]


def test_there_must_be_a_record() -> None:
    with pytest.raises(nw.InputError, match="no record to check"):
        nw.check_log([], kvlcc2())


class TestAgreement:
    """Frisch's bounds and turned motions, beside numbers that are known."""

    rng = np.random.default_rng(0)
    truth = rng.standard_normal(400)

    def test_the_truth_lies_between_both_regressions(self) -> None:
        change = 3.0 * self.truth + 0.8 * self.rng.standard_normal(400)
        factor = factor_of(change, self.truth + 0.4 * self.rng.standard_normal(400))
        assert factor.told
        assert factor.low < 3.0 < factor.high
        assert not factor.holds(-3.0, 1.25)
        assert not factor_of(change, self.rng.standard_normal(400)).told

    def test_a_turn_is_measured(self) -> None:
        way = self.rng.standard_normal(200) + 1j * self.rng.standard_normal(200)
        noise = 0.05 * (self.rng.standard_normal(200) + 1j * self.rng.standard_normal(200))
        turned = turned_of(1.2 * np.exp(0.3j) * way + noise, way)
        assert turned is not None
        assert turned.stretch == pytest.approx(1.2, abs=4 * turned.error)
        assert turned.turn == pytest.approx(0.3, abs=4 * turned.error)
        assert turned.apart == pytest.approx(0.05 / 1.2, rel=0.15)

    def test_errors_are_those_of_repeated_draws(self) -> None:
        design = [self.rng.standard_normal(60), np.ones(60)]
        draws = [2.0 * design[0] + self.rng.standard_normal(60) for _ in range(300)]
        found = [least_squares(draw, design, overlap=1.0) for draw in draws]
        values = np.array([one.values[0] for one in found if one])
        assert np.std(values) == pytest.approx(np.mean([one.errors[0] for one in found if one]), rel=0.15)
