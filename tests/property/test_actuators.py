"""Actuators: a jet of this file's own, which the package knows nothing of, goes wherever a rudder goes."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import numbers

import narrows as nw
from narrows.model.tables import HELM
from narrows.model.term import ScaleEffect
from narrows.quantities.names import Dimension, dimension_of
from narrows.ship.actuators import PROPELLER, RUDDER, Actuator, Part, number_in
from tables import DTC_SHIP, frame_of, many_runs


@dataclass(frozen=True)
class BowThruster(Part):
    """A tunnel thruster: its diameter, how far ahead it is, and how fast it turns at most."""

    SECTION: ClassVar[str] = "trial_jet"
    POSITION: ClassVar[str] = "trial_jet"
    diameter: float = number_in("m", "diameter of the tunnel")
    lever: float = number_in("m", "forward of midship")
    limit: float = number_in("1/s", "most turns a second")
    rate: float = number_in("1/s2", "fastest change of them")


TURNS = "turns of the jet, positive where it pushes the bow to starboard"
THRUSTER = Actuator("trial_jet", "1/s", TURNS, rest=0.0, parts=(BowThruster,))


def push(trial_jet, trial_jet_diameter, density):
    return density * trial_jet_diameter**4 * abs(trial_jet) * trial_jet


def moment(trial_jet, trial_jet_diameter, trial_jet_lever, density):
    return push(trial_jet, trial_jet_diameter, density) * trial_jet_lever


def terms_with(thruster: Actuator) -> nw.TermTable:
    about = {"kind": nw.TermKind.THRUSTER, "source": "form of the bollard pull", "actuator": thruster}
    return nw.PAPER.with_terms(
        "paper+trial_jet",
        sway=[nw.Term("b_bow", "b_{jet}", push, Dimension(), scale_effect=ScaleEffect.WAKE, **about)],
        yaw=[nw.Term("c_bow", "c_{jet}", moment, Dimension(), **about)],
    )


TERMS = terms_with(THRUSTER)
SECTION = BowThruster(0.05, 1.7, 20.0, 4.0)


@pytest.fixture
def tug(dtc: nw.Model) -> nw.Model:
    """The published hull with the thruster."""
    configuration = replace(dtc.configuration, others=(SECTION,))
    return nw.Model(configuration, TERMS, {**dtc.coefficients, "b_bow": 0.4, "c_bow": 0.35})


def table_of(tug: nw.Model) -> pd.DataFrame:
    """Tests in which the thruster turns, each at a speed of its own, as a table of the documented columns."""
    bare = nw.Model(tug.configuration, nw.PAPER, {name: tug.coefficients[name] for name in nw.PAPER.names})
    tests = nw.twin(bare, many_runs(6), rate=2.0)
    turns = np.repeat(np.linspace(-15.0, 15.0, len(tests.names)), np.diff(tests.starts))
    motion = nw.Motion(**{name: tests.columns[name] for name in nw.Motion().values()})
    noise = np.random.default_rng(5)
    frame = frame_of(tests)
    for force, own in tug.forces(motion, trial_jet=turns).items():
        frame[force] = own + noise.normal(0, 0.05, tests.rows)
    return frame.assign(**{"trial_jet [rpm]": 60 * turns})


def test_it_is_identified_from_a_column_of_its_name(tug: nw.Model, tmp_path: Path) -> None:
    path = tmp_path / "tests.csv"
    table_of(tug).to_csv(path, index=False)
    ship = tmp_path / "tug.toml"
    ship.write_text(f"{DTC_SHIP}\n[trial_jet]\ndiameter = 0.05\nlever = 1.7\nlimit = 20\nrate = 4\n")
    tests = nw.read_captive(path, ship, actuators=[THRUSTER])
    assert np.abs(tests.columns["trial_jet"]).max() == pytest.approx(15.0)
    fit = nw.identify(tests, TERMS, errors=nw.RunErrors(0, 0, 0))
    for name, value in (("b_bow", 0.4), ("c_bow", 0.35)):
        low, high = fit.intervals[name]
        assert low < value < high
        assert high - low < 0.1
    without = tmp_path / "without.csv"
    table_of(tug).drop(columns="trial_jet [rpm]").to_csv(without, index=False)
    with pytest.raises(nw.InputError, match=r"'trial_jet' is missing \(turns of the jet.*\[1/s\]\)"):
        nw.identify(nw.read_captive(without, ship, actuators=[THRUSTER]), TERMS)
    streamed = nw.identify(nw.stream_captive(path, ship, actuators=[THRUSTER]), TERMS, errors=nw.RunErrors(0, 0, 0))
    assert streamed.coefficients == pytest.approx(fit.coefficients, rel=1e-6)
    assert streamed.intervals["b_bow"] == pytest.approx(fit.intervals["b_bow"], rel=1e-6)
    with pytest.raises(nw.InputError, match=r"add it; did you mean 'trial_jet \[rpm\]'"):
        nw.identify(nw.read_captive(path, tug.configuration), TERMS)


@given(turns=numbers(-20, 20))
def test_forces_are_by_its_turns_and_at_rest_without(turns: float) -> None:
    dtc = nw.published("mikkelsen2025_dtc")
    configuration = replace(dtc.configuration, others=(SECTION,))
    tug = nw.Model(configuration, TERMS, {**dtc.coefficients, "b_bow": 0.4, "c_bow": 0.35})
    motion = nw.Motion.at(0.1, y=0.5, u=0.8, r=0.01)
    still, moved = tug.forces(motion), tug.forces(motion, trial_jet=turns)
    assert still == {force: pytest.approx(own) for force, own in dtc.forces(motion).items()}
    expected = 1000.0 * 0.05**4 * abs(turns) * turns
    assert moved["Y"] - still["Y"] == pytest.approx(0.4 * expected, abs=1e-9)
    assert moved["N"] - still["N"] == pytest.approx(0.35 * 1.7 * expected, abs=1e-9)


def test_what_is_no_actuator_of_the_terms_is_refused(dtc: nw.Model, tug: nw.Model) -> None:
    with pytest.raises(nw.InputError, match="no actuator 'trial_jet'"):
        dtc.forces(nw.Motion(u=1.0), trial_jet=1.0)
    with pytest.raises(nw.InputError, match="no actuator 'rudder'; leave it out"):
        dtc.forces(nw.Motion(u=1.0), 0.1)
    with pytest.raises(nw.InputError, match="did you mean 'trial_jet'"):
        tug.forces(nw.Motion(u=1.0), trial_jt=1.0)
    bare = nw.Model(dtc.configuration, TERMS, tug.coefficients)
    with pytest.raises(nw.InputError, match="need trial_jet_diameter"):
        bare.forces(nw.Motion(u=1.0))


def test_it_has_a_section_of_its_own_in_files(tug: nw.Model, tmp_path: Path) -> None:
    path = tmp_path / "tug.toml"
    nw.save_model(tug, path)
    assert "[trial_jet]" in path.read_text()
    again = nw.load_model(path, TERMS)
    assert again.configuration == tug.configuration
    motion = nw.Motion(u=1.0)
    assert again.forces(motion, trial_jet=5.0) == tug.forces(motion, trial_jet=5.0)
    with pytest.raises(nw.InputError, match="unknown section"):
        nw.load_model(path, nw.PAPER)
    ship = tmp_path / "ship.toml"
    ship.write_text(f"{DTC_SHIP}\n[trial_jet]\ndiameter = 0.05\nlever = 1.7\nlimit = 20\nrate = 4\n")
    assert nw.read_ship(ship, [THRUSTER]).parts == {"trial_jet": SECTION}
    ship.write_text(f"{DTC_SHIP}\n[trial_jet]\ndiametre = 0.05\n")
    with pytest.raises(nw.InputError, match=r"\[trial_jet\] has an unknown key 'diametre'.*'diameter'"):
        nw.read_ship(ship, [THRUSTER])


@given(length=numbers(1.0, 400.0))
def test_it_scales_by_the_dimensions_of_its_numbers(length: float) -> None:
    dtc = nw.published("mikkelsen2025_dtc")
    configuration = replace(dtc.configuration, others=(SECTION,))
    tug = nw.Model(configuration, TERMS, {**dtc.coefficients, "b_bow": 0.4, "c_bow": 0.35})
    scaled = nw.scale_model(tug, length)
    ratio = scaled.ratio
    large = scaled.model.configuration.parts["trial_jet"]
    expected = (0.05 * ratio, 1.7 * ratio, 20.0 * ratio**-0.5, 4.0 / ratio)
    assert (large.diameter, large.lever, large.limit, large.rate) == pytest.approx(expected, rel=1e-12)
    small, far = nw.Motion(u=1.0), nw.Motion(u=ratio**0.5)
    here = tug.forces(small, trial_jet=10.0)
    there = scaled.model.forces(far, trial_jet=10.0 * ratio**-0.5)
    assert there["Y"] == pytest.approx(ratio**3 * here["Y"], rel=1e-9)
    assert there["N"] == pytest.approx(ratio**4 * here["N"], rel=1e-9)


def test_warnings_follow_from_its_rows(tug: nw.Model) -> None:
    assert any("ship's wake" in said for said in nw.scale_model(tug, 355.0).notes)
    assert {"b_bow", "c_bow"} <= set(nw.at_depth(tug, 0.3).notes[0].rstrip(".").replace(",", "").split())


def test_what_the_equations_of_motion_ask_of_an_actuator(tug: nw.Model) -> None:
    """Name, limit, rate and position of each, by which an engine drives any."""
    assert TERMS.actuators == (THRUSTER,)
    assert nw.MMG.actuators == (RUDDER, PROPELLER)
    assert nw.STEERED.actuators == (RUDDER,)
    values = tug.configuration.values()
    assert (values["trial_jet_limit"], values["trial_jet_rate"]) == (20.0, 4.0)
    assert values["rudder_limit"] == pytest.approx(np.radians(35.0))
    assert values["rudder_rate"] == pytest.approx(np.radians(65 / 28))
    assert values["revolutions_limit"] == values["revolutions_rate"] == np.inf
    assert "revolutions" not in values
    kvlcc2 = nw.published("yasukawa2015_kvlcc2").configuration
    assert kvlcc2.values()["revolutions"] == kvlcc2.propeller.revolutions
    assert RUDDER.at_rest() == {"cos_rudder": 1.0, "sin_rudder": 0.0}
    assert PROPELLER.at_rest() == {}
    assert THRUSTER.placed(3.0) == {"trial_jet": 3.0}


def test_a_ship_with_it_sails_with_it_at_rest(tug: nw.Model, dtc: nw.Model) -> None:
    steady = {"y": 0.3, "u": 0.8, "duration": 5.0}
    bare, own = nw.simulate(dtc, **steady), nw.simulate(tug, **steady)
    np.testing.assert_allclose(own.y, bare.y, rtol=1e-9)


def test_an_ensemble_holds_it_where_it_is_put(tug: nw.Model, dtc: nw.Model) -> None:
    """As the force and moment that it makes do, given from outside."""
    start = {"y": 0.2, "u": 0.8, "duration": 40.0, "dt": 0.05}
    turned = nw.ensemble(tug, trial_jet=[-10.0, 0.0, 10.0], **start)
    for number, side in enumerate((-1, 0, 1)):
        force = side * 1000.0 * 0.05**4 * 100.0
        pushed = nw.ensemble(dtc, Y=0.4 * force, N=0.35 * 1.7 * force, **start)
        own = turned.isel(trial_jet=number)
        np.testing.assert_allclose(own["time"], pushed["time"].squeeze(), rtol=1e-6)
        assert str(own["side"].values) == str(pushed["side"].squeeze().values)


def test_a_steady_course_balances_it(tug: nw.Model) -> None:
    hull = replace(tug.configuration, ship=replace(tug.configuration.ship, flow_straightening=0.5))
    helm = {"a_helm": 5.0, "b_helm": 6.0, "c_helm": 2.9}
    steered = nw.Model(hull, HELM(TERMS), {**tug.coefficients, **helm})
    turns = [-5.0, 0.0, 5.0]
    course = nw.steady_course(steered, y=0.1, u=0.8, trial_jet=turns)
    assert len(set(course["rudder"].values)) == 3
    for number, own in enumerate(turns):
        psi, v, rudder = (float(course[name][number]) for name in ("psi", "v", "rudder"))
        found = steered.forces(nw.Motion.at(psi, y=0.1, u=0.8, v=v), rudder, trial_jet=own)
        assert abs(found["Y"]) < 1e-6
        assert abs(found["N"]) < 1e-6


@dataclass(frozen=True)
class RunningThruster(BowThruster):
    """One whose section says how it turns, where nothing moves it."""

    trial_jet: float = number_in("1/s", TURNS, 0.0)


@pytest.mark.usefixtures("one_tuning")
def test_the_envelope_feels_it(tug: nw.Model) -> None:
    """A thruster that turns needs another rudder to hold the course: as much as its force asks for."""
    hull = replace(tug.configuration.ship, flow_straightening=0.5)
    canal, gear = replace(tug.configuration.canal, depth=0.4), nw.SteeringGear(35.0, 20.0)
    coefficients = {**tug.coefficients, "a_helm": 5.0, "b_helm": 6.0, "c_helm": 2.9}
    terms = HELM(terms_with(replace(THRUSTER, parts=(RunningThruster,))))

    def rudder(turns: float, diameter: float = 0.05) -> np.ndarray:
        section = RunningThruster(diameter, 1.7, 20.0, 4.0, turns)
        configuration = replace(tug.configuration, ship=hull, canal=canal, steering=gear, others=(section,))
        model = nw.Model(configuration, terms, coefficients)
        found = nw.safe_envelope(model, np.array([-0.1, 0.1]), np.array([0.5, 0.7]), samples=2)
        assert (found.data["found"] == 1).all()
        return found.data["rudder"].to_numpy()

    turning = rudder(8.0)
    assert (turning - rudder(0.0) > 1e-3).all()
    np.testing.assert_allclose(turning, rudder(2.0, diameter=0.1), rtol=1e-9)  # D^4 n |n| is the same.


def test_it_drives_the_ship(tug: nw.Model) -> None:
    held = nw.simulate(tug, y=0.0, u=0.8, duration=5.0, trial_jet=10.0)
    still = nw.simulate(tug, y=0.0, u=0.8, duration=5.0)
    assert held.psi[-1] > still.psi[-1]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Actuator("u", "1/s", "x"), "cannot be called 'u'"),
        (lambda: Actuator("bow thruster", "1/s", "x"), "give it a plain word"),
        (lambda: Actuator("fin", "furlongs", "x"), "'furlongs' is no unit"),
        (lambda: Actuator("fin", "rad", "x", parts=(BowThruster,)), r"section \[trial_jet\] is of 'trial_jet'"),
        (lambda: replace(nw.published("mikkelsen2025_dtc").configuration, others=(SECTION, SECTION)), "given twice"),
        (
            lambda: TERMS.with_terms("two", surge=[nw.Term("a", "a", push, Dimension(), actuator=OTHER)]),
            "two actuators are called 'trial_jet'",
        ),
        (lambda: nw.Term("b", "b", push, Dimension()), "unknown 'trial_jet'"),
    ],
)
def test_actuators_that_make_no_sense(make, said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        make()


OTHER = replace(THRUSTER, rest=1.0)


@given(powers=st.tuples(*[st.integers(-3, 3)] * 3))
def test_a_unit_is_read_as_it_is_written(powers: tuple[int, int, int]) -> None:
    dimension = Dimension(*powers)
    assert dimension_of(dimension.unit) == dimension


def test_its_numbers_are_checked_with_the_place_in_the_file(tug: nw.Model) -> None:
    with pytest.raises(nw.InputError, match=r"^\[trial_jet\] lever = nan is not a finite number"):
        replace(SECTION, lever=np.nan)
    with pytest.raises(nw.InputError, match=r"^\[trial_jet\] diameter = 1e\+21 is beyond all measure"):
        replace(SECTION, diameter=1e21)
    with pytest.raises(nw.InputError, match=r"^\[trial_jet\] diameter = nan is not a finite number"):
        nw.ensemble(tug, trial_jet_diameter=[0.05, np.nan])
    with pytest.raises(nw.InputError, match=r"^\[propeller\] wake = inf is not a finite number"):
        nw.ensemble(nw.published("yasukawa2015_kvlcc2"), propeller_wake=[0.3, np.inf])
