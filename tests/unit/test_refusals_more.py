"""Ordinary mistakes in the later verbs and functions: one sentence, with the remedy."""

import numpy as np
import pytest

import narrows as nw
from narrows.identification.systematic_effects import run_errors_of
from tables import frame_of, short_twin

DTC = nw.published("mikkelsen2025_dtc")
KVLCC2 = nw.published("yasukawa2015_kvlcc2")


@pytest.mark.parametrize(
    ("act", "said"),
    [
        (lambda: nw.read_captive(frame_of(short_twin()), DTC.configuration.ship), "a Ship without a canal"),
        (lambda: nw.read_captive(frame_of(short_twin()), {"ship": {"length": 4.0}}), "lacks beam, draft"),
        (lambda: nw.read_captive(frame_of(short_twin()), 3), "is no path"),
        (lambda: short_twin().drop("yawn"), "'yaw'"),
        (lambda: DTC.with_canal(widht=3.0), "'width'"),
        (lambda: nw.with_bank(nw.PAPER, "tcuk"), "did you mean 'tuck'"),
        (lambda: nw.equivalent_wall([], 1.0), "two points"),
        (lambda: nw.equivalent_wall([(1.0, 0.0), (2.0, -1.0)], 1.0), "below the bottom"),
        (lambda: nw.identify(short_twin(), "sped"), "did you mean 'speed'"),
        (lambda: nw.identify(short_twin(), bounds={"b_v": 3.0}), "bounds: b_v = 3.0 is no lower and upper bound"),
        (lambda: nw.identify(short_twin(), bounds=[(0.0, 1.0)]), "bounds = .* are not by name; give them"),
        (lambda: nw.identify(short_twin(), bounds={"b_v": ("a", 1.0)}), "is no lower and upper bound; give both"),
        (lambda: nw.identify(short_twin(), bounds={"b_v": (3.0, 1.0)}), "is no lower and upper bound; give both"),
        (lambda: nw.identify(short_twin(), fixed="b_bank"), "fixed = 'b_bank' has no values by name"),
        (lambda: nw.simulate(DTC, duration=1.0).at("later"), "t = 'later' is not a finite number"),
        (lambda: DTC.sample(-1), "n = -1: give a whole number from 0"),
        (lambda: nw.compare(short_twin(), [nw.PAPER, nw.PAPER]), "two tables of terms"),
        (lambda: nw.nondimensional(DTC, "prime1", np.inf), "positive one"),
        (lambda: nw.ensemble(DTC, samples=-1), "from 0"),
        (lambda: nw.simulate(KVLCC2, u=1.0, rudder=10, contact="none"), r"573 degrees; give radians \(rudder = 0.175"),
        (lambda: nw.simulate(DTC, psi=5), "psi = 5 rad is 286 degrees; give radians"),
        (lambda: nw.ensemble(DTC, psi=[0, -5]), "psi = -5 rad is -286 degrees; give radians"),
        (lambda: nw.stability(KVLCC2, bank=False, rudder=10), "give radians"),
        (lambda: nw.jacobian(DTC, psi=5), "give radians"),
        (lambda: nw.sensitivities(DTC, ["y"], psi=5), "give radians"),
        (lambda: nw.bank_force(DTC, 0.5, 1.0, 5), "give radians"),
        (lambda: KVLCC2.forces(u=1.0, rudder=10), "give radians"),
        (lambda: nw.ensemble(DTC, width=[0.5, 7.0]), "does not fit in"),
        (lambda: nw.scale_model(DTC, 1e200), "must be over 0 and under"),
        (lambda: nw.scale_model(DTC, 355.0, width=0.0), "must be positive"),
        (
            lambda: nw.squat(nw.Configuration(DTC.configuration.ship, nw.Canal(7.0, 0.3)), 0.5, "bow", "barrass"),
            "largest sinkage",
        ),
    ],
)
def test_functions(act, said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        act()


def test_a_heading_of_half_a_turn_and_a_rudder_across_are_angles() -> None:
    voyage = nw.simulate(KVLCC2, u=1.0, psi=-np.pi, rudder=np.pi / 2, contact="none", duration=1.0)
    assert (voyage.psi[0], voyage.rudder[0]) == (-np.pi, np.pi / 2)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("matrix = [", "matrix = [[nan],"), "covariance"),
        (("speed = [", "speed = [9.0, "), "data_range"),
    ],
)
def test_model_files(change: tuple[str, str], said: str, tmp_path) -> None:
    path = tmp_path / "m.toml"
    nw.save_model(nw.identify(short_twin()).model, path)
    path.write_text(path.read_text().replace(*change, 1))
    with pytest.raises(nw.InputError, match=said):
        nw.load_model(path)


def test_a_ship_file_is_no_model_and_a_model_file_has_one(tmp_path, ship_file) -> None:
    with pytest.raises(nw.InputError, match=r"this is a ship file.*give a model"):
        nw.load_model(ship_file)
    nw.save_model(DTC, tmp_path / "m.toml")
    assert nw.read_ship(tmp_path / "m.toml").ship == DTC.ship


def test_a_covariance_must_be_one(tmp_path) -> None:
    from dataclasses import replace

    path = tmp_path / "m.toml"
    for spoil in (np.nan, -1.0):
        matrix = np.eye(17)
        matrix[3, 3] = spoil
        nw.save_model(replace(DTC, covariance=matrix), path)
        with pytest.raises(nw.InputError, match="is no covariance"):
            nw.load_model(path)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("map", "mikkelsen2025_dtc", "--samples", "20", "--within", "-10"), "no distance"),
        (("trials", "yasukawa2015_kvlcc2", "--speed", "1.2", "--turn-deg", "0.6"), "give degrees from 1"),
        (("trials", "yasukawa2015_kvlcc2", "--speed", "1.2", "--zigzags", "10/0.5"), "give degrees from 1"),
        (("scale", "mikkelsen2025_dtc", "--length", "355", "--width", "0"), "must be positive"),
    ],
)
def test_the_command_line(words: tuple[str, ...], said: str, cli) -> None:
    code, _, err = cli(*words)
    assert code == 2
    assert said in err
    assert err.count("\n") == 1


def test_a_plain_depth_says_what_it_leaves(kcs_tests: dict[int, nw.CaptiveTests]) -> None:
    fit = nw.identify(kcs_tests[100], "paper+distance_depth")
    said = " ".join(nw.at_depth(fit.model, 0.246).notes)
    assert "tests at one depth do not determine them" in said
    assert "h/T = 1.20 is below 1.5" in said


def test_an_explanation_says_how_the_models_own_terms_do() -> None:
    table = nw.with_bank(nw.SPEED, "distance", name="mine")
    tests = short_twin()
    found = nw.explain(nw.identify(tests, table).model, tests, ("paper",))
    assert list(found.comparison.fits) == ["mine", "paper"]


@pytest.mark.parametrize("written", ["0.02", "0.02,0.02", "a,b,c", "1,1,1,1,1,1,1,1"])
def test_errors_of_runs_are_three_to_seven_numbers(written: str) -> None:
    with pytest.raises(nw.InputError, match="give gain,zero,form as in"):
        run_errors_of(written)
    assert run_errors_of("0.01,0.02,0.03") == nw.RunErrors(gain=0.01, zero=0.02, form=0.03)
