"""The safe envelope against brute force: SciPy's root finder, voyage after voyage, and limits that need no computer."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text
from scipy.optimize import root

import narrows as nw
from dop853 import STATE, rates_of
from narrows.captive.measured import measured_files
from narrows.model.data_range import DataRange
from narrows.model.tables import table_named
from narrows.safety.envelope import share_interval
from narrows.safety.headline import crossing, largest_block, runs
from narrows.safety.request import Disturbance, default_speeds, keel_at
from narrows.safety.trials import trials
from narrows.simulation.ship import SimulatedShip
from pictures import assert_readable

# What a trial is, as the docs of safe_envelope define it: 40 steps on the way of a ship length, 15 lengths after the
# gust, and back on the line through the last 3.
STEPS_A_LENGTH, TRIAL_LENGTHS, BACK_LENGTHS = 40, 15.0, 3.0

OFFSETS, SPEEDS = np.array([-70.0, -25.0, 0.0, 10.0, 45.0]), np.array([2.5, 5.0])
TURNED = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"
BEAM, LENGTH = 32.2, 230.0


@pytest.fixture(scope="module")
def tested() -> nw.Model:
    """The KCS at 50 % clearance at full size in a canal 300 m wide, with a stated bank that is fairly certain.

    These tests do not determine the bank; a stated one gives the envelope edges within the canal.
    """
    measured = nw.scale_model(steered_kcs(), LENGTH, 1025.0, width=300.0, depth=16.2).model
    return replace(measured.with_coefficients(b_bank=-0.1, c_bank=0.1), covariance=measured.covariance / 25)


@pytest.fixture(scope="module")
def doubtful(tested: nw.Model) -> nw.Model:
    """The same, as if its tests had covered every speed, offset and section."""
    anything = (0.0, 1e6)
    return replace(tested, data_range=DataRange(*(anything,) * 6))


@cache
def steered_kcs() -> nw.Model:
    """The tank's own, to lend its rudder."""
    terms = table_named("speed+helm")
    tests = nw.read_captive(*measured_files("kcs"), TURNED).by_condition()["C0101A02"]
    fit = nw.identify(tests, terms)
    # Without the verdicts, which take seconds.
    return nw.Model(tests.configuration, terms, fit.coefficients, np.asarray(fit.covariance), fit.data_range)


@pytest.fixture(scope="module")
def ship(doubtful: nw.Model) -> nw.Model:
    """The same as if the coefficients were certain, with a bank that pulls."""
    return replace(doubtful, covariance=None).with_coefficients(b_bank=0.05, c_bank=0.05)


class TestSteadyCourse:
    def test_scipy_finds_the_same(self, ship: nw.Model) -> None:
        """On the terms themselves, not on what was compiled from them."""
        found = nw.steady_course(ship, y=OFFSETS, u=5.0)

        def off(z: np.ndarray, y: float) -> np.ndarray:
            drift, rudder = z
            psi = -np.arctan(drift)
            forces = ship.forces(nw.Motion.at(psi, y=y, u=5.0, v=5.0 * drift), rudder)
            return np.array([forces["Y"] / 1e6, forces["N"] / 1e8])

        for place, y in enumerate(OFFSETS):
            answer = root(off, [0.0, 0.0], args=(y,), tol=1e-12)
            assert answer.success
            assert float(found.rudder[place]) == pytest.approx(answer.x[1], abs=1e-9)
            assert float(found.v[place]) == pytest.approx(5.0 * answer.x[0], abs=1e-8)

    def test_a_voyage_from_it_stays(self, ship: nw.Model) -> None:
        at = nw.steady_course(ship, y=40.0, u=5.0)
        start = {name: float(at[name]) for name in ("rudder", "psi", "v")}
        voyage = nw.simulate(ship, y=40.0, u=5.0, duration=100.0, dt=0.5, **start)
        assert np.ptp(voyage.y) < 1e-6

    def test_mirrored(self, ship: nw.Model) -> None:
        found = nw.steady_course(ship, y=[-35.0, 35.0], u=SPEEDS)
        for name in ("rudder", "psi", "v"):
            np.testing.assert_allclose(found[name][0], -found[name][1], rtol=1e-9, atol=1e-12)

    def test_without_banks_she_needs_no_rudder(self, ship: nw.Model) -> None:
        found = nw.steady_course(ship.with_coefficients(b_bank=0.0, c_bank=0.0), y=OFFSETS, u=SPEEDS)
        np.testing.assert_array_equal(found["rudder"], 0.0)

    def test_where_the_moment_is_beyond_any_rudder_there_is_none(self, ship: nw.Model) -> None:
        found = nw.steady_course(ship.with_coefficients(c_bank=20.0), y=[0.0, 60.0], u=5.0)
        assert float(found.rudder[0]) == 0.0
        assert np.isnan(found.rudder[1])

    def test_forces_that_go_with_the_square_of_the_speed_ask_for_one_rudder(self, ship: nw.Model) -> None:
        found = nw.steady_course(ship, y=OFFSETS, u=SPEEDS)
        np.testing.assert_allclose(found["rudder"][:, 0], found["rudder"][:, 1], rtol=1e-9, atol=1e-12)

    @pytest.mark.parametrize(
        ("given", "words"),
        [({"y": 140.0}, "hull in the bank"), ({"u": 0.0}, "a speed over 0"), ({"psi": 0.1}, "does not take 'psi'")],
    )
    def test_what_it_does_not_take_is_refused(self, ship: nw.Model, given: dict, words: str) -> None:
        with pytest.raises(nw.InputError, match=words):
            nw.steady_course(ship, **given)

    def test_a_model_without_a_rudder_is_refused(self, dtc: nw.Model) -> None:
        with pytest.raises(nw.InputError, match="no terms of a rudder"):
            nw.steady_course(dtc, y=0.5)


class TestRegulator:
    def test_the_derivative_by_the_rudder_is_a_difference(self, ship: nw.Model) -> None:
        own, pose = SimulatedShip(ship), (0.0, 12.0, 0.1, 5.0, 0.2, 0.003)
        exact = own.system().linearisation(own.values(), own.actuators)
        found = exact.linear({**dict(zip(STATE, pose, strict=True)), "rudder": 0.2})[:, 6 + 3]
        slope = (rates_of(ship, 0.2 + 1e-6)(pose) - rates_of(ship, 0.2 - 1e-6)(pose)) / 2e-6
        np.testing.assert_allclose(found, slope, rtol=1e-6, atol=1e-12)

    def test_the_command_holds_her(self, ship: nw.Model, cli, tmp_path) -> None:
        nw.save_model(ship, tmp_path / "full.toml")
        words = (
            "simulate",
            tmp_path / "full.toml",
            "--speed",
            "5",
            "--y",
            "30",
            "--duration",
            "900",
            "--dt",
            "1",
            "--json",
        )
        code, out, _ = cli(*words, "--hold", "25")
        assert code == 0
        assert json.loads(out)["state"]["y"] == pytest.approx(25.0, abs=0.5)
        assert json.loads(cli(*words)[1])["outcome"] == "grounded"
        code, _, error = cli(*words, "--hold", "140")
        assert code == 2
        assert "hull in the bank" in error


def voyage_of(model: nw.Model, thrown: dict, y: float, u: float, sample: int, time: float) -> nw.Voyage:
    """One trial by the voyage's own integrator: gust first, then without."""
    helm = nw.control.regulator(model, y, u)
    line = helm.lines[0]
    dt = LENGTH / (STEPS_A_LENGTH * u)
    blown = dt * round(time / dt)
    push = {name: [(0.0, float(thrown[name][sample])), (blown, 0.0)] for name in ("Y", "N")}
    steps = np.ceil(time / dt) + TRIAL_LENGTHS * STEPS_A_LENGTH
    return nw.simulate(
        model, y=y + float(thrown["y"][sample]), u=u, psi=line.psi + float(thrown["psi"][sample]), v=line.v,
        rudder=line.rudder, duration=steps * dt, dt=dt, controller=helm, **push,
    )  # fmt: skip


def mirrored(thrown: dict, y: float) -> dict:
    """What is thrown to starboard on one side of the middle is thrown to port on the other."""
    return {name: -column if y < 0 else column for name, column in thrown.items()}


def was_held(model: nw.Model, thrown: dict, y: float, u: float, sample: int, time: float) -> bool:
    try:
        voyage = voyage_of(model, thrown, y, u, sample, time)
    except nw.InputError:  # no rudder holds it there
        return False
    last = voyage.t > voyage.t[-1] - BACK_LENGTHS * LENGTH / u + 1e-9
    return voyage.outcome.kind == "afloat" and bool(np.abs(voyage.y - y)[last].max() <= BEAM / 2)


def hull_reach(voyage: nw.Voyage) -> float:
    """Farthest to starboard that a corner of the hull comes."""
    return float((voyage.y + LENGTH / 2 * np.abs(np.sin(voyage.psi)) + BEAM / 2 * np.cos(voyage.psi)).max())


class TestTrials:
    @pytest.mark.slow
    def test_each_is_a_voyage_of_its_own(self, ship: nw.Model) -> None:
        """Brute force: the same trials, one at a time, by another integrator in plain Python, judged by its columns."""
        gust = Disturbance(3.0, offset=2.0, gust=1.2e6, gust_lever=20.0, gust_time=90.0)
        offsets, samples = np.array([-70.0, 0.0, 85.0]), 4
        tried = trials(ship, offsets, SPEEDS, np.zeros(2), gust, samples, seed=5, knowing=False)
        thrown = gust.drawn(samples, 5)
        fates = set()
        for y in offsets:
            for u in SPEEDS:
                for sample in range(samples):
                    held = was_held(ship, mirrored(thrown, y), float(y), float(u), sample, gust.gust_time)
                    assert bool(tried.held.sel(y=y, u=u)[sample]) == held, (y, u, sample)
                    fates.add(held)
        assert fates == {True, False}

    def test_a_keel_wall_stops_her_before_the_canals(self, ship: nw.Model) -> None:
        """A wall between where a gust to starboard and one to port carry the hull stops the former alone."""
        gust, speed, samples = Disturbance(0.0, gust=4e5, gust_time=100.0), np.array([5.0]), 6
        thrown = gust.drawn(samples, 0)
        voyages = [voyage_of(ship, thrown, 30.0, 5.0, sample, gust.gust_time) for sample in range(samples)]
        reach = np.array([hull_reach(voyage) for voyage in voyages])
        to_starboard = thrown["Y"].to_numpy() > 0
        wall = (reach[to_starboard].min() + reach[~to_starboard].max()) / 2
        assert reach[to_starboard].min() > reach[~to_starboard].max() + 1.0
        free, walled = (
            trials(ship, np.array([30.0]), speed, np.zeros(1), gust, samples, 0, walls)["held"].to_numpy().ravel()
            for walls in ((np.inf, np.inf), (np.inf, wall))
        )
        assert free.all()
        np.testing.assert_array_equal(walled, ~to_starboard)

    def test_the_answer_does_not_depend_on_the_threads(self, doubtful: nw.Model) -> None:
        one, two = (
            trials(doubtful, OFFSETS, SPEEDS, np.zeros(2), Disturbance(), 8, 1, workers=workers) for workers in (1, 3)
        )
        xr.testing.assert_identical(one, two)

    def test_no_draw_is_no_trial(self, ship: nw.Model) -> None:
        with pytest.raises(nw.InputError, match="give a whole number from"):
            trials(ship, OFFSETS, SPEEDS, np.zeros(2), Disturbance(), 0, 0)
        for samples in (None, 1.5):
            with pytest.raises(nw.InputError, match="whole number"):
                nw.safe_envelope(ship, OFFSETS, SPEEDS, samples=samples)


@pytest.fixture(scope="module")
def found(doubtful: nw.Model) -> nw.SafeEnvelope:
    return nw.safe_envelope(doubtful, np.linspace(-98, 98, 15), np.array([3.0, 5.0, 7.0, 12.0]), samples=40)


class TestEnvelope:
    def test_the_edge_is_where_brute_force_puts_it(self, ship: nw.Model) -> None:
        """A sure model without disturbance is safe as far as its rudder has the reserve: SciPy's bisection."""
        from scipy.optimize import brentq

        most = ship.configuration.gear.limit * 2 / 3
        offsets, heave = np.linspace(20.0, 130.0, 45), float(keel_at(ship, np.array([5.0])).midship[0])
        rudder = nw.steady_course(ship, y=offsets, u=5.0, heave=heave)["rudder"]
        low, high = offsets[(rudder < most).to_numpy()].max(), offsets[(rudder > most).to_numpy()].min()
        edge = brentq(lambda y: float(nw.steady_course(ship, y=y, u=5.0, heave=heave)["rudder"]) - most, low, high)
        offsets = np.array([0.0, edge - 0.05, edge + 0.05])
        found = nw.safe_envelope(ship, offsets, np.array([5.0]), disturbance=Disturbance(0.0), samples=1)
        np.testing.assert_array_equal(found.safe()[:, 0], [True, True, False])
        assert found.limited_by()[-1] == "the rudder"

    def test_mirrored(self, found: nw.SafeEnvelope) -> None:
        data = found.data.where(found.data.found > 0)  # an angle that no ship has is infinite, and has no sign
        pairs = (("rudder", "rudder"), ("rudder_low", "rudder_high"), ("rudder_high", "rudder_low"))
        for own, other in pairs:
            np.testing.assert_allclose(data[own], -data[other][::-1], rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(data["rudder_95"], data["rudder_95"][::-1], rtol=1e-9, atol=1e-12)

    def test_quantiles_are_those_of_the_samples(self, doubtful: nw.Model, found: nw.SafeEnvelope) -> None:
        """NumPy on the steady courses of the same samples; those without one are beyond hard over."""
        heave = keel_at(doubtful, np.array([5.0])).midship[0]
        for y in (28.0, 84.0):
            rudder = nw.steady_course(doubtful, y=y, u=5.0, heave=heave, samples=40)["rudder"].to_numpy()
            beyond = np.sign(np.nanmedian(rudder)) * np.inf
            signed, own = np.where(np.isnan(rudder), beyond, rudder), found.data.sel(y=y, u=5.0)
            assert float(own["rudder_low"]) == np.quantile(signed, 0.05, method="lower")
            assert float(own["rudder_high"]) == np.quantile(signed, 0.95, method="higher")
            assert float(own["found"]) == np.isfinite(rudder).mean()
            limit = doubtful.configuration.gear.limit * 2 / 3
            assert float(own["holds"]) == (np.abs(signed) <= limit).mean()

    def test_the_five_per_cent_line_is_inside_even_odds(self, found: nw.SafeEnvelope) -> None:
        assert not (found.safe() & ~found.safe(0.5)).any()
        assert (found.safe(0.5) & ~found.safe()).any()

    def test_a_choked_canal_is_not_sailed(self, found: nw.SafeEnvelope, doubtful: nw.Model) -> None:
        assert nw.choke_speed(doubtful.configuration) < 12.0
        assert not found.safe()[:, -1].any()
        assert found.limited_by()[7] == "the canal chokes"
        highest = found.highest_speed()
        assert float(highest[7]) == 7.0
        assert float(found.highest_speed(float(highest.y[7]))) == 7.0

    def test_the_keel_takes_the_bottom(self, ship: nw.Model) -> None:
        shallow = replace(ship, configuration=replace(ship.configuration, canal=nw.Canal(300.0, 11.8)))
        speeds = np.array([1.0, 4.0])
        found = nw.safe_envelope(shallow, np.array([0.0]), speeds, samples=1, disturbance=Disturbance(0.0))
        under = keel_at(shallow, speeds)
        assert under.clearance[0] > 0.05 * shallow.configuration.ship.draft > under.clearance[1]
        assert found.limited_by() == ["the keel"]

    def test_a_gust_may_make_a_slow_ship_the_unsafe_one(self, ship: nw.Model) -> None:
        blow = Disturbance(0.0, gust=6e5, gust_time=120.0)
        found = nw.safe_envelope(ship, np.array([0.0, 20.0]), np.array([0.4, 2.0, 5.0]), disturbance=blow, samples=20)
        np.testing.assert_array_equal(found.safe().to_numpy(), [[False, True, True]] * 2)
        np.testing.assert_array_equal(found.lowest_speed(), 2.0)
        assert "from 3.9 to 9.7 knots, 0.0 to 20.0 m to starboard of the middle" in found.summary()

    def test_shares_mirror_themselves_to_the_bit(self, found: nw.SafeEnvelope) -> None:
        for name in ("held", "held_low", "held_high", "holds", "found"):
            np.testing.assert_array_equal(found.data[name], found.data[name][::-1])

    def test_a_models_gear_is_asked_for(self, kcs_tests: dict) -> None:
        tank = nw.borrow_rudder(nw.published("mikkelsen2025_dtc"), steered_kcs())
        found = nw.safe_envelope(tank, np.array([0.0]), np.array([0.5]), samples=1)
        assert any("that of a full-size ship" in note for note in found.notes)

    def test_a_propeller_turns_as_the_speed_asks(self) -> None:
        """All forces of the MMG method then go with the square of the speed, so one rudder serves at every speed."""
        kvlcc2 = nw.published("yasukawa2015_kvlcc2")
        slow, fast = (nw.self_propulsion(kvlcc2, u) for u in (0.5, 1.0))
        assert fast == pytest.approx(2 * slow, rel=1e-9)
        assert nw.self_propulsion(kvlcc2, 1.179) == pytest.approx(11.85, abs=0.01)
        found = nw.steady_course(kvlcc2, y=0.0, u=[0.5, 1.0], N=xr.DataArray([0.25, 1.0], dims="u"))
        assert float(found.rudder[0]) == pytest.approx(float(found.rudder[1]), rel=1e-7)
        assert abs(float(found.rudder[0])) > 1e-4

    @pytest.mark.parametrize(
        ("given", "words"),
        [
            ({"y": [1.0, 0.0]}, "offsets must be finite and rise"),
            ({"u": [0.0, 1.0]}, "steers nothing"),
            ({"reserve": 1.0}, "give a share from 0 to less than 1"),
            ({"keel": float("nan")}, "metres from 0"),
            ({"y": [0.0, 140.0]}, "have the hull in a bank"),
            ({"seed": -1}, "give a whole number from 0"),
            ({"samples": 10**8}, "take fewer samples"),
        ],
    )
    def test_bad_ranges_are_refused(self, ship: nw.Model, given: dict, words: str) -> None:
        with pytest.raises(nw.InputError, match=words):
            nw.safe_envelope(ship, **given)


@pytest.fixture(scope="module")
def asked(tested: nw.Model) -> nw.SafeEnvelope:
    return nw.safe_envelope(tested, u=default_speeds(tested, 4), samples=100)


class TestTruth:
    """What the headline and the chart say is no bolder than the tests and the cases tried."""

    def test_safe_ends_where_the_tests_end(self, asked: nw.SafeEnvelope, tested: nw.Model) -> None:
        known = tested.data_range
        as_tested = nw.SafeEnvelope(asked.data.assign_attrs(untested=""))
        safe = as_tested.safe().stack(place=("y", "u"))
        safe = safe[safe.to_numpy()]
        assert float(safe["u"].max()) == pytest.approx(known.speed[1])
        assert float(abs(safe["y"]).max()) == pytest.approx(known.abs_y[1])
        assert (asked.by_model() & ~as_tested.safe()).any()
        assert "the tests end" in as_tested.limited_by()
        assert "but there the tests end" in asked.summary()

    def test_a_section_that_was_not_tested_comes_first(self, asked: nw.SafeEnvelope, tested: nw.Model) -> None:
        assert asked.summary().startswith("Extrapolated, as the tests did not cover this: W/B 9.32 (11.4 was tested)")
        assert asked.untested
        assert asked.by_model().any()
        assert not asked.safe().any()
        assert asked.highest_speed().isnull().all()
        assert ". Safe by the model up to " in asked.summary()
        as_wide = replace(tested, configuration=replace(tested.configuration, canal=nw.Canal(368.7, 16.2)))
        assert not nw.safe_envelope(as_wide, np.array([0.0]), np.array([3.0]), samples=20).untested

    def test_what_the_tests_did_not_cover_is_said(self, asked: nw.SafeEnvelope) -> None:
        said = [note for note in asked.notes if note.startswith("Beyond the data:")]
        assert [note.split()[3] for note in said] == ["speed", "offset", "W/B"]

    def test_seeds_agree(self, tested: nw.Model, asked: nw.SafeEnvelope) -> None:
        """Where 200 draws gave +-22 m by one seed and +-29 m by another."""
        offsets = asked.data["y"].to_numpy()
        found = (
            nw.safe_envelope(tested, offsets[(offsets > 44.0) & (offsets < 85.0)], [3.0], seed=seed) for seed in (0, 7)
        )
        far, also = (_edge(one, 3.0) for one in found)
        assert far == pytest.approx(also, abs=float(asked.data["y"].diff("y").max()))

    def test_what_the_number_of_cases_leaves_uncertain_is_said(self, doubtful: nw.Model) -> None:
        offsets, speeds = np.linspace(55.0, 75.0, 6), np.array([4.0])
        doubtful = replace(doubtful, covariance=4 * doubtful.covariance)
        few = nw.safe_envelope(doubtful, offsets, speeds, samples=50)
        assert "With 50 cases this is uncertain everywhere; more samples (--samples, " in few.summary()
        some = nw.safe_envelope(doubtful, offsets, speeds, samples=300)
        assert "Certain with 300 cases: " in some.summary()

    def test_the_headline_is_never_of_no_width(self, doubtful: nw.Model) -> None:
        found = nw.safe_envelope(doubtful, np.array([-80.0, 0.0, 80.0]), np.array([3.0, 5.0]))
        assert 0.0 < float(found.summary().split("within ")[1].split(" m of the middle")[0]) < 80.0

    def test_what_a_pilot_does_not_say_is_not_written(self, asked: nw.SafeEnvelope) -> None:
        from io import StringIO

        memory, chart = StringIO(), asked.plot()
        chart.savefig(memory, format="svg")
        assert_readable(chart)
        texts = [text.get_text() for text in chart.findobj(Text)]
        for word in ("draws", "5 % line", "even odds", "sample", " she "):
            assert not any(word in text for text in [asked.summary(), *texts])
        assert any("no wind" in text for text in texts)


def _edge(found: nw.SafeEnvelope, speed: float) -> float:
    y, held = found.data["y"].to_numpy(), found.data["held"].sel(u=speed, method="nearest").to_numpy()
    last = int(np.flatnonzero(held >= 0.95)[-1])
    return crossing(y, held, last, last + 1, 0.95)


class TestGrid:
    """The edges of a mask against counting by hand."""

    def test_the_first_run_of_true(self) -> None:
        assert runs(np.array([False, True, True, False, True]))[0] == (1, 2)
        assert runs(np.zeros(3, bool)) == []

    @pytest.mark.parametrize("seed", range(5))
    def test_the_largest_block_is_the_largest(self, seed: int) -> None:
        safe = np.random.default_rng(seed).uniform(size=(7, 6)) < 0.7
        y, u = np.arange(7.0), np.arange(6.0)
        blocks = [
            (b - a + 1) * (d - c + 1)
            for a in range(7) for b in range(a, 7) for c in range(6) for d in range(c, 6)
            if safe[a : b + 1, c : d + 1].all()
        ]  # fmt: skip
        rows, columns = largest_block(xr.Dataset(coords={"y": y, "u": u}), safe) or (slice(0, 0), slice(0, 0))
        assert safe[rows, columns].all()
        assert safe[rows, columns].size == max(blocks)

    def test_wilsons_interval_is_scipys(self) -> None:
        from scipy.stats import binomtest

        low, high = share_interval(np.array([0.95, 0.0, 1.0]), 200)
        for place, count in enumerate((190, 0, 200)):
            exact = binomtest(count, 200).proportion_ci(method="wilson")
            assert (low[place], high[place]) == pytest.approx((exact.low, exact.high), abs=1e-7)


class TestCommand:
    def test_table_chart_data(self, doubtful: nw.Model, cli, tmp_path) -> None:
        nw.save_model(doubtful, tmp_path / "full.toml")
        code, out, _ = cli(
            "envelope", tmp_path / "full.toml", "--y=-60:60:7", "--speed", "6kn:16kn:3", "--samples", "20",
            "--plot", tmp_path / "chart.svg", "-o", tmp_path / "e.nc",
        )  # fmt: skip
        assert code == 0
        assert out.startswith("Safe up to")
        assert "limited by" in out
        assert (tmp_path / "chart.svg").stat().st_size > 10_000
        with xr.open_dataset(tmp_path / "e.nc", engine="scipy") as data:
            assert data["rudder_95"].sizes == {"y": 7, "u": 3}

    def test_json_in_the_pilots_units(self, doubtful: nw.Model, cli, tmp_path) -> None:
        nw.save_model(doubtful, tmp_path / "full.toml")
        words = ("--y", "0,30", "--speed", "8kn", "--samples", "20", "--json")
        code, out, _ = cli("envelope", tmp_path / "full.toml", *words)
        said = json.loads(out)
        assert code == 0
        assert said["offsets"][0]["highest_speed"] == pytest.approx(8.0)
        steady = nw.steady_course(doubtful, y=30.0, u=8 * 1852 / 3600)
        assert abs(said["offsets"][1]["rudder"] - np.degrees(float(steady["rudder"]))) < 2

    def test_where_nothing_is_safe_it_says_no(self, ship: nw.Model, cli, tmp_path) -> None:
        nw.save_model(ship.with_coefficients(c_bank=20.0), tmp_path / "full.toml")
        code, out, _ = cli("envelope", tmp_path / "full.toml", "--y", "40,60", "--speed", "8kn", "--samples", "5")
        assert code == 1
        assert "No offset and speed" in out

    @pytest.mark.parametrize(
        ("words", "error"),
        [
            (("mikkelsen2025_dtc",), "no terms of a rudder"),
            (("mikkelsen2025_dtc", "--wind", "20"), "--wind goes with --windage; add it"),
            (("mikkelsen2025_dtc", "--rudder-of", "mikkelsen2025_dtc"), "the lender has no a_helm"),
        ],
    )
    def test_mistakes_are_one_line(self, cli, words: tuple[str, ...], error: str) -> None:
        code, _, err = cli("envelope", *words)
        assert code == 2
        assert error in err
        assert err.count("\n") == 1


def test_wind_pushes_with_the_square_of_its_speed() -> None:
    assert nw.wind_force(20.0, 1000.0) == pytest.approx(0.5 * 1.225 * 1000 * 400)
    with pytest.raises(nw.InputError, match="numbers from 0"):
        nw.wind_force(-1.0, 1000.0)


def test_a_section_of_a_waterway_takes_the_canals_place(doubtful: nw.Model, cli, tmp_path) -> None:
    from narrows.waterway import Bank, Centreline, Waterway

    ends, line = np.array([0.0, 5000.0]), Centreline(np.array([[0.0, 0.0], [0.0, 5000.0]]))
    slope = ((0.0, 0.0), (32.4, 16.2))
    banks = Bank("starboard", ends, np.array([130.0, 110.0]), slope), Bank("port", ends, np.full(2, 150.0))
    way = Waterway(line, *banks, (ends, np.full(2, 16.2)), origin=(7.6, 52.0))
    nw.write_waterway(way, tmp_path / "canal.geojson")
    nw.save_model(doubtful, tmp_path / "full.toml")
    words = ("envelope", tmp_path / "full.toml", "--y", "0,30", "--speed", "8kn", "--samples", "20", "--json")
    code, out, _ = cli(*words, "--waterway", tmp_path / "canal.geojson", "--at", "2500")
    said = json.loads(out)
    assert code == 0
    assert "286.2 m wide" in said["setting"]  # 120 and half of 32.4 to starboard, 150 to port
    assert any("the middle is -6.9 m off its centreline" in note for note in said["notes"])
    # Its keel meets the slope before the wall that its forces feel.
    edge = 120.0 + 2 * (16.2 - doubtful.configuration.ship.draft) + 6.9 - BEAM / 2
    for offset, known in ((edge - 0.1, True), (edge + 0.1, False)):
        spot = ("envelope", tmp_path / "full.toml", f"--y={offset}", *words[4:])
        code, _, error = cli(*spot, "--waterway", tmp_path / "canal.geojson", "--at", "2500")
        assert (code != 2) == known
    assert "have the hull in a bank" in error
    code, _, error = cli(*words, "--waterway", tmp_path / "canal.geojson", "--at", "9000")
    assert code == 2
    assert "beyond the waterway" in error
