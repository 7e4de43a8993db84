"""Models from main dimensions: formulas against printed derivatives, spread on left-out ships, bad input."""

import importlib
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import narrows as nw
from narrows.cli.app import main
from narrows.empirical.formulas import (
    BANK_PRIOR,
    EVIDENCE_WIDTHS,
    FORMULAS,
    LEAST_CLEARANCE,
    Hull,
    depth_factor,
    read_calibration,
    resistance_prime,
)
from narrows.physics.clearance import bank_distance, suction

sys.path.insert(0, str(Path(__file__).parents[2] / "decisions"))
from bank_evidence import BANK_EVIDENCE, bank_effects, left_out, left_out_banks, random_effects
from known_ships import KCS, KNOWN_SHIPS, KVLCC2, calibrated

PANAMAX = nw.Ship(length=366, beam=51, draft=15, block_coefficient=0.65)
CANAL = nw.Canal(300, 24)


def formula(name: str, source: str) -> float:
    (law,) = (one.law for one in FORMULAS if one.coefficient == name and one.source.startswith(source))
    return float(law(KVLCC2.hull))


class TestPrintedDerivativesOfKvlcc2:
    """Yasukawa and Yoshimura (2015) print them; a wrong sign, factor or reading is off by more than these."""

    @pytest.mark.parametrize(
        ("name", "source", "printed", "within"),
        [
            ("X_my", "Zhou", 0.223, 0.02), ("N_jz", "Zhou", 0.011, 0.03), ("Y_v", "Wagner", -0.315, 0.05),
            ("Y_r", "Clarke", 0.083, 0.03), ("Y_r", "Kijima", 0.083, 0.07), ("N_v", "Clarke", -0.137, 0.02),
            ("N_v", "Inoue", -0.137, 0.05), ("N_r", "Clarke", -0.049, 0.09), ("N_r", "Inoue", -0.049, 0.10),
            ("Y_vvv", "Yoshimura", -1.607, 0.07), ("Y_vrr", "Yoshimura", -0.391, 0.03),
            ("Y_vrr", "Kijima", -0.391, 0.05),
        ],
    )  # fmt: skip
    def test_formula(self, name: str, source: str, printed: float, within: float) -> None:
        assert formula(name, source) == pytest.approx(printed, rel=within)


def test_clarke_by_hand() -> None:
    """L 100, B 20, T 10, C_B 0.8, over 1/2 rho L^2: -pi (0.1)^2 (1 + 0.4 x 0.8 x 2) and so on, times L/T."""
    hull = Hull(5.0, 2.0, 0.8)
    laws = {one.coefficient: float(one.law(hull)) for one in FORMULAS if one.source.startswith("Clarke")}
    assert laws["Y_v"] == pytest.approx(-0.1 * math.pi * 1.64)
    assert laws["N_v"] == pytest.approx(-0.1 * math.pi * 0.74)
    assert laws["N_r"] == pytest.approx(-0.1 * math.pi * (0.25 + 0.078 - 0.112))
    assert laws["X_my"] == pytest.approx(0.1 * math.pi * (1 + 0.256 - 0.204))
    assert laws["N_jz"] == pytest.approx(0.1 * math.pi * (1 / 12 + 0.0272 - 0.066))
    assert laws["Y_r"] == pytest.approx(0.1 * math.pi * (0.5 - 0.44 + 0.16) + 0.05 * 0.32)


def test_added_mass_grows_with_shallow_water_as_measured() -> None:
    """KCS, Flanders Hydraulics: the added mass in sway at 20 % clearance over that at 100 %."""
    measured = KCS.primes[1.2]["X_my"] / KCS.primes[2.0]["X_my"]
    law = depth_factor("X_my", KCS.hull, 1.2) / depth_factor("X_my", KCS.hull, 2.0)
    assert law == pytest.approx(measured, rel=0.10)
    assert depth_factor("X_my", KCS.hull, math.inf) == 1


def test_kcs_row_is_what_its_tests_give() -> None:
    """The rows of the KCS and of its banks, at one depth."""
    tests = nw.measured_tests("kcs").by_condition()["C0101A01"]
    fit = nw.identify(tests, terms=nw.with_bank(nw.CROSSFLOW, "distance"))
    found = fit.least_squares
    ship = nw.published("estimated_kcs").configuration.ship
    assert ship.length / ship.beam == pytest.approx(KCS.hull.length_to_beam, rel=1e-3)
    scale = 0.5 * 1000 * 4.3671 * 0.2051
    assert -found["b_uv"] / scale == pytest.approx(KCS.primes[2.0]["Y_v"], rel=2e-3)
    assert -found["c_uv"] / scale / 4.3671 == pytest.approx(KCS.primes[2.0]["N_v"], rel=2e-3)
    assert found["b_vdot"] / scale / 4.3671 - 0.1823 == pytest.approx(KCS.primes[2.0]["X_my"], rel=2e-3)
    row = BANK_EVIDENCE[1]
    given = (row.suction, row.suction_error, row.cushion, row.cushion_error)
    measured = (fit.coefficients["b_bank"], fit.std["b_bank"], fit.coefficients["c_bank"], fit.std["c_bank"])
    assert measured == pytest.approx(given, abs=2e-3)


def test_bank_rows_of_the_steady_tests_are_their_forces() -> None:
    tests = nw.measured_tests("lataire2009")
    for index, name in enumerate(tests.names):
        rows = [row for row in BANK_EVIDENCE if row.source.startswith(f"steady test {name} ")]
        at = {key: float(np.ravel(column)[index]) for key, column in tests.columns.items()}
        parameter = bank_distance(at["y"], 1.0, at["width"], 0.53)
        unit = suction(parameter, at["u"], at["heave"], 4.01, at["draft"], 0.65, 1000.0)
        for row in rows:
            assert row.cushion is not None
            assert (at["Y"] / unit, -at["N"] / unit / 4.01) == pytest.approx((row.suction, row.cushion), abs=1e-3)
            clearance = (at["width"] / 2 - at["y"]) / 0.53 - 0.5
            assert (at["depth"] / at["draft"], clearance) == pytest.approx(
                (row.depth_to_draft, row.clearance_to_beam), abs=0.06
            )
        assert len(rows) == (name not in "AG")  # These have drift


def test_random_effects_are_those_of_the_analysis_of_variance() -> None:
    """Balanced rows without errors: the variances are the mean squares' of one-way analysis of variance."""
    rows = np.random.default_rng(3).normal(size=(6, 4)) + 2 * np.random.default_rng(4).normal(size=(6, 1))
    found = random_effects(rows.ravel(), np.zeros(24), [name for name in "abcdef" for _ in range(4)])
    within = rows.var(axis=1, ddof=1).mean()
    between = rows.mean(axis=1).var(ddof=1) - within / 4
    assert found.mean == pytest.approx(rows.mean(), abs=1e-6)
    assert (found.within, found.between) == pytest.approx((within**0.5, between**0.5), rel=1e-3)
    assert found.mean_error == pytest.approx((rows.mean(axis=1).var(ddof=1) / 6) ** 0.5, rel=1e-3)


@pytest.mark.parametrize("rows", [left_out(), left_out_banks()], ids=["hull", "banks"])
def test_intervals_hold_ships_left_out(rows: list) -> None:
    assert 0.90 <= sum(row.held for row in rows) / len(rows) <= 0.98


def test_the_calibration_is_that_of_the_known_ships() -> None:
    """``python decisions/known_ships.py --write`` after a change of a formula or a ship."""
    kept, found = read_calibration(), calibrated()
    assert kept.errors.keys() == found.errors.keys()
    for name, errors in found.errors.items():
        for key, number in errors._asdict().items():
            assert getattr(kept.errors[name], key) == pytest.approx(number, rel=1e-9), f"{name}: {key}"
    np.testing.assert_allclose(kept.correlation, found.correlation, rtol=0, atol=1e-9)


def test_an_estimate_takes_every_ship_and_each_changes_it() -> None:
    usual = read_calibration().estimate("Y_v", KVLCC2.hull)
    for ship in KNOWN_SHIPS:
        others = calibrated(tuple(other for other in KNOWN_SHIPS if other is not ship))
        changed = others.estimate("Y_v", KVLCC2.hull)
        assert (changed.value == usual.value) == ("Y_v" not in ship.primes[max(ship.primes)])


def test_spread_grows_in_shallow_water() -> None:
    calibration = read_calibration()
    deep, shallow = (calibration.estimate("Y_v", KVLCC2.hull, ratio) for ratio in (math.inf, 1.2))
    assert shallow.std / abs(shallow.value) > deep.std / abs(deep.value)


def test_circle_of_kvlcc2_from_dimensions_by_the_other_ships(monkeypatch: pytest.MonkeyPatch) -> None:
    """Against the free-running tests of MARIN, mean of both sides; drawn ships are in docs/main-dimensions.md."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "decisions")
    decision = importlib.import_module("main_dimensions")
    found = nw.sail_trials(decision.kvlcc2(), decision.APPROACH, zigzags=()).to_dict()["turning"]["+35"]
    measured = {name: np.mean(sides) for name, sides in decision.measured().items()}
    assert found["advance_over_length"] == pytest.approx(measured["advance/L"], rel=0.15)
    assert found["tactical_diameter_over_length"] == pytest.approx(measured["tactical diameter/L"], rel=0.15)


def test_the_bank_prior_is_that_of_a_further_ship() -> None:
    """Wider than the scatter of the rows about the mean, as one more ship and the mean's own error are in it."""
    for name, column in (("Y_bank", "suction"), ("N_bank", "cushion")):
        prior, found = BANK_PRIOR[name], bank_effects()[name].spread
        assert (prior.value, prior.std) == pytest.approx((found.value, found.std), rel=1e-4)
        exact = [getattr(row, column) for row in BANK_EVIDENCE if row.source.startswith("steady test ")]
        assert prior.std > 0.9 * np.std([value for value in exact if value is not None], ddof=1)
    widths = [row.width_to_beam for row in BANK_EVIDENCE]
    assert (min(widths), max(widths)) == EVIDENCE_WIDTHS
    assert min(row.clearance_to_beam for row in BANK_EVIDENCE) == LEAST_CLEARANCE


class TestModel:
    model = nw.estimate_model(PANAMAX, CANAL)

    def test_tied_coefficients_have_one_error(self) -> None:
        names = list(self.model.terms.names)
        for one, other in self.model.terms.ties:
            rows = self.model.covariance[[names.index(one), names.index(other)]]
            np.testing.assert_array_equal(rows[0], rows[1])

    def test_it_says_that_it_is_an_estimate_and_survives_a_file(self, tmp_path) -> None:
        self.model.save(tmp_path / "ship.toml")
        again = nw.load_model(tmp_path / "ship.toml")
        assert again == self.model
        assert again.notes[0].startswith("The model is estimated from main dimensions")

    def test_thrust_balances_resistance_at_the_service_speed(self) -> None:
        configuration = self.model.configuration
        speed = 0.20 * math.sqrt(9.81 * 366)
        deep = nw.estimate_model(PANAMAX, nw.Canal(5000)).in_open_water()
        assert deep.resistance(speed) == pytest.approx(0, abs=1e-3 * deep.resistance(speed, revolutions=0.0))
        assert configuration.propeller.revolutions == pytest.approx(deep.configuration.propeller.revolutions)

    def test_every_argument_changes_it(self) -> None:
        base = self.model.to_dict()
        for change in (
            {"kind": "tanker"}, {"speed": 5.0}, {"steering": nw.SteeringGear(30.0, 3.0)}, {"water": nw.Water(1000.0)},
            {"propeller": nw.Propeller(9.0, 1.0, 0.3, 0.4, -0.4, 0.0)},
        ):  # fmt: skip
            assert nw.estimate_model(PANAMAX, CANAL, **change).to_dict() != base
        assert nw.estimate_model(PANAMAX, nw.Canal(300, 18)).to_dict() != base

    def test_a_kind_fills_what_is_missing(self) -> None:
        filled = nw.estimate_model({"length": 230.0}, nw.Canal(250, 16), kind="container")
        assert filled.configuration.ship.beam == pytest.approx(230 / 7)
        assert "beam 32.9 m, draft 9.96 m, block coefficient 0.65" in filled.notes[0]


def test_water_shallower_than_that_of_known_ships_is_named() -> None:
    assert (
        "h/T 1.01 is less than that of any known ship (1.2)" in nw.estimate_model(PANAMAX, nw.Canal(300, 15.1)).notes[0]
    )
    assert "h/T" not in nw.estimate_model(PANAMAX, CANAL).notes[0]


FOUR = {"length": 366, "beam": 51, "draft": 15, "block_coefficient": 0.65}
PARTS = nw.estimate_model(PANAMAX, CANAL).configuration
BAD_INPUTS = [
    ({"block_coefficient": None}, {}, "the ship has no block coefficient; give it, or a kind"),
    ({"draft": None, "block_coefficient": None}, {}, "the ship has no draft, block coefficient; give them"),
    ({"length": None}, {}, "the ship has no length; give length between perpendiculars, in metres"),
    ({"block": 0.65}, {}, "one argument"),
    ({"block_coefficient": 65}, {}, "is over 1; it is a fraction"),
    ({"block_coefficient": 1.0}, {}, "outside 0.3 to 0.98; check the dimensions and units"),
    ({"draft": 25}, {}, "leaves no water under [ship] draft = 25 m; check both"),
    ({}, {"canal": nw.Canal(45, 24)}, "[ship] beam = 51 m does not fit in [canal] width = 45 m; check both"),
    ({"length": 1200, "beam": 167, "draft": 49}, {"canal": nw.Canal(900)}, "give metres, not feet"),
    (
        {"length": 0.366, "beam": 0.051, "draft": 0.015},
        {},
        "[ship] length = 0.366 is 0.366 m, outside 1 to 500",
    ),
    ({"length": 51, "beam": 366}, {"canal": nw.Canal(900)}, "[ship] length = 51 is 0.139 times the beam"),
    ({"draft": 0.15}, {}, "[ship] beam = 51 is 340 times the draft, outside 1.2 to 15; check the dimensions"),
    ({"length": -366}, {}, "[ship] length = -366 must be positive, in SI units"),
    ({"beam": math.nan}, {}, "[ship] beam = nan is not a finite number; give it in SI units"),
    ({"length": "366 m"}, {"kind": "tanker"}, "[ship] length = '366 m' is not a finite number"),
    ({"mass": 1.8e5}, {}, "[ship] mass = 1.8e+05 is 0.000965 times the displaced water"),
    ({"inertia": 1.5e9}, {}, "give it in kg m2"),
    ({"x_g": 180.0}, {}, "[ship] x_g = 180 is 0.492 times the length"),
    ({}, {"speed": 40.0}, "a service speed of 40 m/s is 3.3 times that of a usual container ship"),
    ({}, {"speed": 21.2}, "none of this ship"),
    ({}, {"speed": 0.0}, "none of this ship"),
    ({}, {"speed": "16 mph"}, "is not a finite number; give it in m/s"),
    ({}, {"kind": "ferry"}, "kind = 'ferry' is unknown; choose container"),
    ({}, {"rudder": replace(PARTS.rudder, area=0.018)}, "[rudder] area = 0.018 is 3.28e-06 times L x T"),
    (
        {},
        {"propeller": replace(PARTS.propeller, diameter=9300.0)},
        "[propeller] diameter = 9300 is 620 times the draft",
    ),
    ({}, {"propeller": replace(PARTS.propeller, revolutions=90.0)}, "give revolutions per second, not per minute"),
    ({}, {"steering": nw.SteeringGear(0.61, 0.04)}, "[steering] limit_deg = 0.61 is 0.0174 times the usual"),
    ({}, {"canal": 300}, "canal = 300 is of another type; give nw.Canal(...)"),
    ({}, {"water": 1025}, "water = 1025 is of another type; give nw.Water(...)"),
    ({}, {"rudder": 99.0}, "rudder = 99.0 is of another type; give nw.Rudder(...)"),
]


@pytest.mark.parametrize(("ship", "others", "sentence"), BAD_INPUTS)
def test_a_bad_input_gets_one_sentence(ship: dict, others: dict, sentence: str) -> None:
    with pytest.raises(nw.InputError) as raised:
        nw.estimate_model({**FOUR, **ship}, **{"canal": CANAL, **others})
    assert sentence in str(raised.value)
    assert "\n" not in str(raised.value)


def test_an_estimate_needs_a_ship() -> None:
    with pytest.raises(nw.InputError, match=r"ship = 366 is no ship; give nw\.Ship"):
        nw.estimate_model(366, CANAL)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ("--length 1200 --beam 167 --draft 49", "give metres, not feet"), ("--block 65", "is over 1; it is a fraction"),
        ("--length 366000 --beam 51000 --draft 15000 --width 3e5 --depth 24000", "not feet, millimetres or kilometres"),
        ("--length 366ft", "'--length': '366ft' is not a number; write it as 12.5, or with its unit as 12.5m"),
        ("--length 366,5", "'366,5' is not a number"), ("--length nan", "[ship] length = nan is not a finite number"),
        ("--beam=-51", "[ship] beam = -51.0 must be positive"), ("--draft 25", "leaves no water under"),
        ("--width 45", "does not fit in"), ("--depth 0", "[canal] depth = 0.0 must be positive"),
        ("--density 1.025", "give kg/m3"), ("--speed fast", "--speed 'fast'"), ("--speed 16mph", "--speed '16mph'"),
        ("--speed 45", "numbers are m/s, and 45 knots are 23.2 m/s"), ("--speed=-3kn", "none of this ship"),
        ("--type contaner", "did you mean 'container'?"), ("-o ship.csv", "name it .toml"),
    ],
)  # fmt: skip
def test_the_command_refuses_a_bad_input_in_one_line(
    options: str, sentence: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    usual = "narrows estimate --length 366 --beam 51 --draft 15 --block 0.65 --width 300 --depth 24"
    monkeypatch.setattr("sys.argv", [*usual.split(), *options.split()])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 2
    told = capsys.readouterr().err
    assert (told.startswith("narrows: "), sentence in told, told.count("\n")) == (True, True, 1), told


def test_resistance_of_a_flat_plate_by_hand() -> None:
    """ITTC-57 at Re 1e9: 0.075/49; the form factor and surface of a box-like ship by hand."""
    ship = nw.Ship(length=119.0, beam=17.0, draft=4.25, block_coefficient=0.7)
    friction, form, surface = 0.075 / 49, -0.095 + 25.6 * 0.7 / (49 * 2), 1.7 + 0.7 * 4
    assert resistance_prime(ship, 10.0) == pytest.approx(((1 + form) * friction + 0.0004) * surface)


class TestReadyShips:
    def test_names_and_table(self) -> None:
        table = nw.ready_ships()
        assert list(table.index) == nw.published()
        assert len(table) >= 10
        assert {"yasukawa2015_kvlcc2_full", "son1982_s175", "estimated_kcs"} <= set(table.index)
        estimated = table.index.str.startswith("estimated")
        assert (table["measured"][estimated] == "nothing of this ship").all()
        assert (table["rudder"] & table["banks"] & (table["length"] > 100))[estimated].all()

    def test_kvlcc2_at_full_size_has_the_primes_of_the_model(self) -> None:
        small, full = nw.published("yasukawa2015_kvlcc2"), nw.published("yasukawa2015_kvlcc2_full")
        assert full.coefficients == small.coefficients
        assert full.configuration.propeller.wake == 0.35
        assert full.configuration.rudder.area / (320 * 20.8) == pytest.approx(0.0539 / (7 * 0.46), rel=0.02)

    def test_s175_has_the_printed_forces(self) -> None:
        """Son and Nomoto (1982) over 1/2 rho L^2 U^2, at v' = 0.1, r' = 0.3, propeller and rudder aside."""
        model = nw.published("son1982_s175")
        v, r = 0.1, 0.3
        whole = 8.0
        motion = {"u": whole * math.sqrt(1 - v * v), "v": whole * v, "r": whole * r / 175}
        quiet = model.with_coefficients(
            X_rudder=0.0, Y_rudder=0.0, N_rudder=0.0, X_thrust=0.0, X_mass=0.0, Y_mass=0.0, N_mass=0.0,
            X_my=0.0, Y_my=0.0, X_mx=0.0, Y_mx=0.0,
        )  # fmt: skip
        forces, scale = quiet.forces(**motion), 0.5 * 1025 * 175**2 * whole**2
        sway = -0.0116 * v + 0.00242 * r - 0.109 * v**3 + 0.00177 * r**3 + 0.0214 * v**2 * r - 0.0405 * v * r**2
        yaw = -0.0038545 * v - 0.00222 * r + 0.001492 * v**3 - 0.00229 * r**3 - 0.0424 * v**2 * r + 0.00156 * v * r**2
        surge = -0.0004226 - 0.00311 * v * r - 0.00386 * v**2 + 0.0002 * r**2
        assert forces["Y"] / scale == pytest.approx(sway, rel=1e-6)
        assert forces["N"] / scale / 175 == pytest.approx(yaw, rel=1e-6)
        assert forces["X"] / scale == pytest.approx(surge, rel=1e-6)


@pytest.mark.parametrize(("depth", "other", "told"), [
    (None, 15.5, True), (15.5, 15.5, False), (15.5, 16.2, False), (15.5, 20.0, True), (None, 60.0, False),
])  # fmt: skip
def test_a_model_of_one_depth_is_not_tested_at_another(depth: float | None, other: float, told: bool) -> None:
    """Formulas give the coefficients of one depth: those of deep water are no answer in a canal."""
    model = nw.estimate_model(
        {"length": 200.0, "beam": 32.0, "draft": 12.0, "block_coefficient": 0.82}, nw.Canal(330.0, depth)
    )
    assert bool(model.data_range.outside("depth_to_draft", other / 12.0)) == told
