"""What is wrong with a ship's log is found, one fault at a time; nothing is found where nothing is."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import narrows as nw
from logs import bend, bent_waterway, circle, kvlcc2, sensed, zigzag
from narrows.logbook.checking.agreement import factor_of, least_squares, turned_of

EXAMPLES = Path(__file__).parents[2] / "examples"
DEGREES, KNOTS = 180 / np.pi, 3600 / 1852
Spoil = Callable[[nw.ShipRecord], nw.ShipRecord]


def scaled(factor: float, *names: str) -> Spoil:
    """Signals as another sign or unit has them."""
    return lambda record: record.with_signals(
        **{name: nw.Signal(record[name].t, factor * record[name].values) for name in names}
    )


def without(name: str) -> Spoil:
    return lambda record: replace(record, signals={own: record[own] for own in record if own != name})


def held(*names: str) -> Spoil:
    """Signals that say the same from a third of the record on to two thirds."""

    def spoil(record: nw.ShipRecord) -> nw.ShipRecord:
        told = {}
        for name in names:
            t, values = record[name].t, record[name].values
            first, last = np.searchsorted(t, record.start + record.duration * np.array([1, 2]) / 3)
            stuck = np.where((np.arange(len(t)) >= first) & (np.arange(len(t)) <= last), values[first], values)
            told[name] = nw.Signal(t, stuck)
        return record.with_signals(**told)

    return spoil


def clocked(shift: float) -> Spoil:
    """Times that are set on, or back, halfway."""

    def spoil(record: nw.ShipRecord) -> nw.ShipRecord:
        halfway = record.start + record.duration / 2
        moved = {name: nw.Signal(np.where(own.t > halfway, own.t + shift, own.t), own.values)
                 for name, own in record.signals.items()}  # fmt: skip
        return record.with_signals(**moved)

    return spoil


def turned(way: complex) -> Spoil:
    """Velocities over ground turned by so many times the heading: into fixed axes, or once too often."""

    def spoil(record: nw.ShipRecord) -> nw.ShipRecord:
        told = (record["u_ground"].values + 1j * record["v_ground"].values) * np.exp(way * record["psi"].values)
        t = record["u_ground"].t
        return record.with_signals(u_ground=nw.Signal(t, told.real), v_ground=nw.Signal(t, told.imag))

    return spoil


def moved(forward: float) -> Spoil:
    """Positions of an antenna."""

    def spoil(record: nw.ShipRecord) -> nw.ShipRecord:
        t, psi = record["x"].t, record["psi"].values
        x, y = record["x"].values + forward * np.cos(psi), record["y"].values + forward * np.sin(psi)
        return record.with_signals(x=nw.Signal(t, x), y=nw.Signal(t, y))

    return spoil


def heading(change: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Spoil:
    return lambda record: record.with_signals(
        psi=nw.Signal(record["psi"].t, change(record["psi"].t, record["psi"].values))
    )


def blown(change: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]) -> Spoil:
    """A wind, as a complex number towards where it comes from, changed by the ship's velocity and heading."""

    def spoil(record: nw.ShipRecord) -> nw.ShipRecord:
        psi = record["psi"].values
        ship = (record["u_ground"].values + 1j * record["v_ground"].values) * np.exp(1j * psi)
        wind = record["wind_speed"].values * np.exp(1j * record["wind_direction"].values)
        told, t = change(wind, ship, psi), record["psi"].t
        direction = np.unwrap(np.angle(told))
        return record.with_signals(wind_speed=nw.Signal(t, np.abs(told)), wind_direction=nw.Signal(t, direction))

    return spoil


def rolling(record: nw.ShipRecord) -> nw.ShipRecord:
    t = record["r"].t
    return record.with_signals(r=nw.Signal(t, 0.01 * np.sin(2 * np.pi * t / 13.0)))


def cut(record: nw.ShipRecord) -> nw.ShipRecord:
    kept = {name: (own.t < 300.0) | (own.t > 380.0) for name, own in record.signals.items()}
    return record.with_signals(
        **{name: nw.Signal(own.t[kept[name]], own.values[kept[name]]) for name, own in record.signals.items()}
    )


FAULTS: dict[str, tuple[Spoil, str, str]] = {
    "a rudder positive to port": (scaled(-1.0, "rudder"), "rudder's sign", '[positive] rudder = "port"'),
    "a rudder in degrees": (scaled(DEGREES, "rudder"), "rudder", "head it 'rudder [deg]'"),
    "a rudder in radians read as degrees": (scaled(1 / DEGREES, "rudder"), "rudder's unit", "radians taken as degrees"),
    "no rudder": (without("rudder"), "missing", "voyage data recorder"),
    "a rudder that never moves": (scaled(0.0, "rudder"), "rudder", "another column"),
    "a heading to port": (scaled(-1.0, "psi"), "heading", "psi counts to port"),
    "a heading in degrees": (scaled(DEGREES, "psi"), "heading", "psi counts degrees"),
    "heading and yaw rate in degrees": (scaled(DEGREES, "psi", "r"), "yaw rate", "degrees a second"),
    "a heading that wraps": (heading(lambda t, psi: (psi + 3.0 + np.pi) % (2 * np.pi) - np.pi), "heading", "unwrap"),
    "a compass that was reset": (heading(lambda t, psi: psi + 0.35 * (t > 450.0)), "heading", "compass"),
    "a compass that is stuck": (held("psi"), "stuck", "leave that time out"),
    "a yaw rate to port": (scaled(-1.0, "r"), "yaw rate", '[positive] r = "port"'),
    "a yaw rate in degrees a second": (scaled(DEGREES, "r"), "yaw rate", "degrees a second"),
    "a yaw rate in degrees a minute": (scaled(60 * DEGREES, "r"), "yaw rate", "or a minute"),
    "a yaw rate half as large": (scaled(0.5, "r"), "yaw rate", "calibration"),
    "a roll rate for the yaw rate": (rolling, "yaw rate", "roll rate"),
    "a gyro that is stuck": (held("r"), "stuck", "leave that time out"),
    "a position that is stuck": (held("x", "y"), "stuck", "leave that time out"),
    "y to port": (scaled(-1.0, "y"), "heading", "y counts to port"),
    "velocities in fixed axes": (turned(1j), "velocity over ground", "x_rate and y_rate"),
    "velocities turned once too often": (turned(-1j), "velocity over ground", "along the ship already"),
    "a sway velocity to port": (scaled(-1.0, "v_ground"), "velocity over ground", "v_ground counts to port"),
    "velocities in knots": (scaled(KNOTS, "u_ground", "v_ground"), "velocity over ground", "knots"),
    "a speed over ground in knots": (scaled(KNOTS, "speed_over_ground"), "speed over ground", "knots"),
    "a course to port": (scaled(-1.0, "course"), "speed over ground", "course counts to port"),
    "a course in degrees": (scaled(DEGREES, "course"), "speed over ground", "course counts degrees"),
    "a log in knots": (scaled(KNOTS, "u"), "speed through the water", "knots"),
    "revolutions a minute": (scaled(60.0, "revolutions"), "revolutions", "revolutions [rpm]"),
    "a clock that was set back": (clocked(-20.0), "clock", "sort"),
    "a clock that was set on": (clocked(60.0), "clock", "jump"),
    "an antenna on the deckhouse": (moved(-130.0), "antenna", "antenna's place"),
    "the wind as felt on board": (blown(lambda wind, ship, psi: wind + ship), "wind", "felt on board"),
    "a wind told by where it goes": (blown(lambda wind, ship, psi: -wind - 2 * ship), "wind", "where the wind goes"),
    "a wind told from the bow": (blown(lambda wind, ship, psi: wind * np.exp(-1j * psi)), "wind", "from the bow"),
}  # fmt: skip


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
        beyond = bend().with_signals(y=nw.Signal(bend()["y"].t, bend()["y"].values - 90.0))
        found = nw.check_log([beyond], kvlcc2(), self.way)
        assert [own.check for own in found.wrong] == ["banks"]
        assert found.wrong[0].evidence["share"] > 0.5
        narrow = bent_waterway(length=9000.0)
        assert nw.check_log([bend()], kvlcc2(), narrow).clean


def test_several_quiet_records_tell_the_rudders_sign_together() -> None:
    voyage = _slalom()
    quiet = [scaled(-1.0, "rudder")(sensed(f"quiet {i}", voyage, i)) for i in range(12)]
    assert nw.check_log(quiet[:1], kvlcc2()).clean
    found = nw.check_log(quiet, kvlcc2())
    assert [(own.check, own.record) for own in found.wrong] == [("rudder's sign", "all records")]


def _slalom() -> nw.Voyage:
    law = nw.Zigzag(np.radians(4.0), np.radians(2.0))
    return nw.simulate(kvlcc2(), u=7.0, duration=500.0, dt=1.0, controller=law, contact="none")


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
