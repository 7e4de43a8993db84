"""Mistakes made to the bundled tests: each is refused or named with its likely cause, and what is right is not."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.captive.check import MotionColumns, kinematic_consistency
from narrows.captive.measured import measured_files
from narrows.captive.synthetic import StraightRun
from narrows.model.tables import table_named
from tables import DTC_SHIP, frame_of, short_twin, written

Spoil = Callable[[pd.DataFrame], pd.DataFrame]
SHIP = measured_files("kcs")[1].read_text()
MASS, INERTIA, X_G, TURN = 356.6, 445.8, -0.0608, 180 / np.pi
TURNED = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"


def scaled(factor: float, *names: str) -> Spoil:
    return lambda frame: frame.assign(**{name: frame[name] * factor for name in names})


def without_inertia(frame: pd.DataFrame) -> pd.DataFrame:
    """As a tank delivers forces that it has freed of the model's own inertia."""
    sway = frame.vdot + frame.u * frame.r
    force, moment = MASS * (sway + X_G * frame.rdot), INERTIA * frame.rdot + MASS * X_G * sway
    return frame.assign(Y=frame.Y + force, N=frame.N + moment)


REFUSED: dict[str, tuple[Spoil, str]] = {
    "heave in mm": (scaled(1e3, "heave"), r"'heave' = .* times the draft, .* head it 'heave \[mm\]'"),
    "heave in cm": (scaled(1e2, "heave"), "'heave' = .* times the draft"),
    "r in deg/s": (scaled(TURN, "r"), r"'r' looks like deg/s; head 'r \[deg/s\]'$"),
    "r and rdot in degrees": (scaled(TURN, "r", "rdot"), r"'r' and 'rdot' look like deg/s; head 'r \[deg/s\]' and"),
    "rdot in deg/s2": (scaled(TURN, "rdot"), r"'rdot' looks like deg/s2; head 'rdot \[deg/s2\]'$"),
    "u in m/s, headed kn": (lambda f: f.rename(columns={"u": "u [kn]"}), r"'u \[kn\]' looks like m/s; head"),
    "u in knots": (scaled(1 / 0.514444, "u"), r"'u' looks like kn; head 'u \[kn\]'$"),
    "y in mm": (scaled(1e3, "y"), "'y' = .* puts the hull on the bank"),
    "vdot in mm/s2": (scaled(1e3, "vdot"), r"'vdot' looks like mm/s2"),
    "y flipped": (scaled(-1, "y"), "dy/dt is -1 times .* turn the sign of 'y' "),
    "psi flipped": (scaled(-1, "psi"), "turn the sign of 'psi' "),
    "r flipped": (scaled(-1, "r"), "turn the sign of 'r' "),
    "psi and r flipped": (scaled(-1, "psi", "r"), "turn the sign of 'psi' and 'r' "),
    "psi, r and N flipped": (scaled(-1, "psi", "r", "N"), "turn the sign of 'psi' and 'r' "),
    "psi, r, rdot and N flipped": (scaled(-1, "psi", "r", "rdot", "N"), "turn the sign of 'psi', 'r' and 'rdot', or"),
    "v flipped": (scaled(-1, "v"), "turn the sign of 'v' "),
    "vdot flipped": (scaled(-1, "vdot"), "turn the sign of 'vdot' "),
    "rdot flipped": (scaled(-1, "rdot"), "turn the sign of 'rdot' "),
    "one test flipped": (
        lambda f: f.assign(y=f.y.where(f.test != "C0101A01_G20000", -f.y)), "in test C0101A01_G20000, dy/dt is -1 times"
    ),
    "forces in mN": (scaled(1e3, "X", "Y", "N"), "'X' would move a ship of .* times faster"),
}  # fmt: skip
NAMED: dict[str, tuple[Spoil, str]] = {
    "forces in kgf": (scaled(1 / 9.80665, "X", "Y", "N"), "is Y in kgf or kgf m"),
    "moment in kgf m": (scaled(1 / 9.80665, "N"), "is N in kgf or kgf m"),
    "forces in kN": (scaled(1e-3, "X", "Y", "N"), "is Y in kN or kN m"),
    "Y and N exchanged": (lambda f: f.assign(Y=f.N, N=f.Y), "are the columns Y and N exchanged"),
    "inertia taken off": (without_inertia, "has the ship's own inertia been taken off N already"),
    "X flipped": (scaled(-1, "X"), "is X counted astern"),
    "Y flipped": (scaled(-1, "Y"), "is Y counted to port"),
    "N flipped": (scaled(-1, "N"), "is N counted anticlockwise"),
    "Y and N flipped": (scaled(-1, "Y", "N"), "is N counted anticlockwise"),
}


@pytest.fixture(scope="module")
def frame() -> pd.DataFrame:
    """The bundled tests in the documented columns: no time, but the way made good."""
    tests = nw.measured_tests("kcs")
    return frame_of(tests).assign(condition=np.repeat(tests.conditions, np.diff(tests.starts))).drop(columns="depth")


def read(frame: pd.DataFrame, folder: Path, ship: str = SHIP) -> nw.CaptiveTests:
    (folder / "ship.toml").write_text(ship)
    return nw.read_captive(written(frame, folder / "t.csv"), folder / "ship.toml")


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case: str, frame: pd.DataFrame, tmp_path: Path) -> None:
    spoil, sentence = REFUSED[case]
    with pytest.raises(nw.InputError, match=sentence) as error:
        read(spoil(frame), tmp_path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("case", NAMED)
def test_named(case: str, frame: pd.DataFrame, tmp_path: Path) -> None:
    spoil, sentence = NAMED[case]
    tests = read(spoil(frame[frame.condition == "C0101A02"]), tmp_path)
    assert any(sentence in said for said in nw.identify(tests).implausible)


@pytest.mark.parametrize("case", NAMED)
def test_named_by_the_command_with_exit_code_1(case: str, frame: pd.DataFrame, tmp_path: Path, cli) -> None:
    spoil, sentence = NAMED[case]
    read(spoil(frame[frame.condition == "C0101A02"]), tmp_path)
    code, out, _ = cli("identify", tmp_path / "t.csv", "--ship", tmp_path / "ship.toml")
    assert code == 1
    assert sentence in " ".join(out.split())


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("mass = 0.741", "mass = 0.741 kg is 0.00208 of what its hull displaces"),
        ("mass = 7410.0", "mass = 7410.0 kg is 20.8 of what its hull displaces"),
        ("mass = 356.6\nwrong", "inertia = 4458000.0 kg m2 is a radius of gyration of"),
    ],
)
def test_mass_and_inertia_beside_the_displacement(
    line: str, sentence: str, frame: pd.DataFrame, tmp_path: Path
) -> None:
    ship = SHIP.replace("mass = 356.6", line)
    ship = ship.replace("\nwrong", "").replace("445.8", "4458000.0") if "wrong" in line else ship
    with pytest.raises(nw.InputError, match=sentence):
        read(frame, tmp_path, ship)


def test_a_mass_a_little_off_is_said(frame: pd.DataFrame, tmp_path: Path) -> None:
    tests = read(frame, tmp_path, SHIP.replace("mass = 356.6", "mass = 300.0"))
    assert any("is 0.842 of what its hull displaces" in note for note in tests.notes)


@pytest.mark.parametrize("terms", ["speed+helm", "paper+helm", "speed"])
def test_rudder(terms: str) -> None:
    """Turned round, its force is none of a rudder's; unknown to the terms, it is refused, or said where asked for."""
    table = table_named(terms)
    tests = nw.read_captive(*measured_files("kcs"), TURNED).by_condition()["C0101A02"]
    turned = {name: -tests.columns[name] for name in ("rudder", "sin_rudder")}
    reversed_ = nw.CaptiveTests(
        {**tests.columns, **turned}, tests.names, tests.starts, tests.configuration, tests.conditions
    )
    if "helm" not in terms:
        with pytest.raises(
            nw.InputError, match=r"goes to about 36 deg and no term has it.* speed\+helm.*--pass-over rudder"
        ):
            nw.identify(tests, table)
    # It goes to 35 deg; its sums, as of a sine, give a degree more.
    right, wrong = (nw.identify(own, table, pass_over="rudder") for own in (tests, reversed_))
    assert right.implausible == ()
    if "helm" in terms:
        assert any("is the rudder's sign reversed" in said for said in wrong.implausible)
    assert any("rudder goes to about 36 deg and no term has it" in note for note in right.notes) == (
        "helm" not in terms
    )


def test_a_rudder_in_a_table_on_disk(tmp_path: Path) -> None:
    """What is summed of it says as much as its column."""
    made = frame_of(nw.twin(runs=(StraightRun("S", 0.5, 1.0, 20.0), StraightRun("P", -0.5, 1.0, 20.0)), rate=5.0))
    (tmp_path / "ship.toml").write_text(DTC_SHIP)
    for moves, degrees in ((True, 12.0), (False, 0.4)):
        table = written(made.assign(rudder_deg=np.where(made.test == "S", degrees, 0.0)), tmp_path / f"{moves}.csv")
        tests = nw.stream_captive(table, tmp_path / "ship.toml")
        if not moves:
            assert not any("rudder" in note for note in nw.identify(tests).notes)
            continue
        with pytest.raises(nw.InputError, match=r"goes to about 12 deg and no term has it.* paper\+helm"):
            nw.identify(tests)
        assert any("The rudder goes to about 12 deg" in note for note in nw.identify(tests, pass_over="rudder").notes)


def test_steady_drift_of_the_other_sign(tmp_path: Path) -> None:
    runs = tuple(StraightRun(f"S{i}", 0.0, 1.0, 5.0, drift) for i, drift in enumerate((0.05, 0.1, -0.1)))
    frame = frame_of(nw.twin(runs=runs, rate=2.0))
    assert read(frame, tmp_path, DTC_SHIP).notes == ()
    with pytest.raises(nw.InputError, match="twice their drift; turn the sign of 'psi' or of 'v'"):
        read(frame.assign(v=-frame.v), tmp_path, DTC_SHIP)


@pytest.mark.parametrize("where", [None, "abs(psi_deg) < 80", "type == 'STATX0' and abs(psi_deg) < 80", TURNED])
def test_nothing_is_said_of_the_kcs(where: str | None) -> None:
    tests = nw.read_captive(*measured_files("kcs"), where=where)
    assert all("rows read" in note or "its sign turned" in note for note in tests.notes)
    assert [nw.identify(part, pass_over="rudder").implausible for part in tests.by_condition().values()] == [()] * 3


@pytest.mark.parametrize("terms", ["speed", "mixed", "crossflow", "paper+keel_gap", "paper+tapered"])
def test_nothing_is_said_of_the_kcs_under_other_terms(kcs_tests: dict[int, nw.CaptiveTests], terms: str) -> None:
    assert [nw.identify(tests, terms).implausible for tests in kcs_tests.values()] == [()] * 3


def test_nothing_is_said_of_other_tests(shared_data, dtc: nw.Model) -> None:
    records = [shared_data / "dtc_mashcon2019" / f"{name}.dat" for name in ("C1", "C2", "C3")]
    tests = [nw.measured_tests("lataire2009"), *(nw.read_captive(path, dtc.configuration) for path in records)]
    usual = ("low-passed", "is absent", "left out", "slopes and platforms", "by their headers")
    assert all(any(word in note for word in usual) for own in tests for note in own.notes)
    assert [nw.identify(own).implausible for own in tests] == [()] * 4


@pytest.mark.parametrize("noise", [0.0, 0.02, 0.1])
def test_noise_is_no_contradiction(noise: float, tmp_path: Path) -> None:
    """White noise on every column of the motion, of a share of its own size."""
    frame, draw = frame_of(short_twin()), np.random.default_rng(3)
    for name in ("y", "psi", "v", "r", "vdot", "rdot"):
        frame[name] += noise * frame[name].std() * draw.standard_normal(len(frame))
    assert read(frame, tmp_path, DTC_SHIP).notes == ()


def test_agreement_is_exact_where_a_motion_is_fine() -> None:
    tests = nw.twin(runs=(nw.HarmonicRun("yaw", "yaw", 0.4, 12.0), nw.HarmonicRun("sway", "sway", 0.4, 12.0)))
    found = kinematic_consistency(MotionColumns(tests.columns, tests.starts, 4.0))
    assert found["psi"].factor[0] == pytest.approx(1, abs=1e-4)
    assert found["v"].factor[1] == pytest.approx(1, abs=1e-4)
    assert found["v"].factor[0] == found["psi"].factor[1] == 0.0
    assert not any(own.apart.any() for own in found.values())


def test_a_rudder_is_passed_over_on_the_command_line(cli) -> None:
    table, ship = measured_files("kcs")
    asked = ("identify", table, "--ship", ship, "--where", TURNED, "--condition", "C0101A01", "--json")
    code, out, err = cli(*asked)
    assert (code, out) == (2, "")
    assert "--where 'abs(rudder_deg) < 1'" in err
    few = ("identify", table, "--ship", ship, "--where", f"{TURNED} and type == 'PMMY2'", "--condition", "C0101A03")
    assert cli(*few, "--pass-over", "rudder")[0] in (0, 1)
    assert cli(*few, "--terms", "speed+helm")[0] in (0, 1)
    assert "pass_over = 'heave' is unknown" in cli(*asked, "--pass-over", "heave")[2]


@pytest.mark.parametrize("seed", range(4))
def test_accelerations_that_are_not_felt_tell_nothing_of_masses(seed: int) -> None:
    """A straight run with a trembling carriage: what it says of mass and inertia is noise."""
    clean = nw.twin(runs=(StraightRun("S", 0.5, 1.0, 30.0), StraightRun("P", -0.5, 0.8, 30.0)), rate=10.0, seed=seed)
    draw = np.random.default_rng(seed)
    trembling = {name: 1e-5 * draw.standard_normal(clean.rows) for name in ("vdot", "rdot")}
    tests = nw.CaptiveTests({**clean.columns, **trembling}, clean.names, clean.starts, clean.configuration)
    assert nw.identify(tests, accelerations="measured").implausible == ()
