"""Pilots of the safe envelope: against SciPy, against voyages one at a time, and against what words promise."""

import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import narrows as nw
from narrows.control.regulator import (
    DEFAULT_WEIGHTS,
    RegulatorWeights,
    best_gains,
    regulator_gains,
    stacked_gains,
)
from narrows.control.steady_course import linearize, solve_courses
from narrows.identification.fitting import bundled_model
from narrows.model.data_range import DataRange
from narrows.safety.envelope import bounds_of, choose_pilot
from narrows.safety.headline import AT_LENGTH, KNOWLEDGE, PILOT, RUDDER, cause
from narrows.safety.pilots import PILOTS, BestEstimateCourses, Helmsman, regulator_of, whole_degrees
from narrows.safety.request import Disturbance, envelope_request, keel_at
from narrows.safety.trials import trials
from narrows.simulation.grid import sampled
from narrows.simulation.ship import SimulatedShip

# What a trial is, as the docs of safe_envelope define it: 40 steps on the way of a ship length, 15 lengths after the
# gust, and back on the line through the last 3.
STEPS_A_LENGTH, TRIAL_LENGTHS, BACK_LENGTHS = 40, 15.0, 3.0

LENGTH, BEAM = 230.0, 32.2


def tank() -> nw.Model:
    """The KCS at 50 % clearance, a fit that is kept for other tests."""
    return bundled_model(nw.STEERED)


@cache
def doubtful() -> nw.Model:
    """The KCS at 50 % clearance at full size, as if its tests told five times as much, of a range that nobody knows."""
    full = nw.scale_model(tank(), LENGTH, 1025.0, width=300.0, depth=16.2).model
    return replace(full, covariance=full.covariance / 25, data_range=DataRange(*((0.0, 1e6),) * 6))


@cache
def narrow() -> nw.Model:
    """The KCS with a stated bank, in a canal as narrow for it as the Suez section for the largest ships."""
    full = nw.scale_model(tank(), LENGTH, 1025.0, width=118.0, depth=16.2).model
    full = full.with_coefficients(b_bank=0.0, c_bank=0.05)
    return replace(full, data_range=DataRange(*((0.0, 1e6),) * 6))


@cache
def certain() -> nw.Model:
    """The same as if the coefficients were certain, with a bank that pulls."""
    return replace(doubtful(), covariance=None).with_coefficients(b_bank=0.05, c_bank=0.05)


class TestGains:
    @pytest.mark.parametrize("seed", range(8))
    def test_scipy_solves_the_same_equation(self, seed: int) -> None:
        from scipy.linalg import solve_continuous_are

        rng = np.random.default_rng(seed)
        size = int(rng.integers(2, 7))
        motion, push = rng.normal(size=(5, size, size)) * 3, rng.normal(size=(5, size))
        weights = np.append(1.0, rng.uniform(size=size - 1) * (rng.uniform(size=size - 1) < 0.7))
        for a, b, gains in zip(motion, push, best_gains(motion, push, np.diag(weights)), strict=True):
            cost = solve_continuous_are(a, b[:, None], np.diag(weights), np.eye(1))
            np.testing.assert_allclose(gains, b @ cost, rtol=1e-6, atol=1e-8)

    def test_what_nothing_stabilises_has_none(self) -> None:
        motion = np.array([[[1.0, 0.0], [0.0, -1.0]], [[1.0, 0.0], [0.0, -1.0]], [[np.nan, 0.0], [0.0, 1.0]]])
        push = np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 1.0]])
        np.testing.assert_array_equal(
            np.isfinite(best_gains(motion, push, np.eye(2))).all(axis=1), [False, True, False]
        )
        assert best_gains(np.zeros((0, 2, 2)), np.zeros((0, 2)), np.eye(2)).shape == (0, 2)

    def test_many_at_once_are_the_regulators_one_by_one(self) -> None:
        ship, offsets, u = SimulatedShip(certain()), np.array([-30.0, 0.0, 45.0]), 5.0
        v, rudder = solve_courses(ship, {"y": offsets, "u": u}, 3, 1)
        course = {"y": offsets, "u": np.full(3, u), "v": v, "rudder": rudder}
        found = stacked_gains(ship, {}, course, DEFAULT_WEIGHTS)
        for y, gains in zip(offsets, found, strict=True):
            linear = linearize(certain(), y=float(y), u=u)
            np.testing.assert_allclose(gains, regulator_gains(certain(), linear), rtol=1e-7, atol=1e-14)

    def test_a_tighter_one_weighs_the_offset_more(self) -> None:
        """The rate that it gives the rudder for a metre off the line."""
        ship = SimulatedShip(certain())
        course = {name: np.array([value]) for name, value in {"y": 0.0, "u": 5.0, "v": 0.0, "rudder": 0.0}.items()}
        by_y = [
            stacked_gains(ship, {}, course, RegulatorWeights(1.0 / own, bank=1.0))[0, 0]
            for own in (1.0, 4.0, 16.0, 64.0)
        ]
        assert by_y == sorted(by_y)


class TestHelmsman:
    @given(st.floats(-63.4, 63.4))
    def test_degrees_are_whole(self, degrees: float) -> None:
        found = math.degrees(float(whole_degrees(math.radians(degrees))))
        assert found == pytest.approx(round(found), abs=1e-9)
        assert abs(found - degrees) <= 0.5 + 1e-9

    def test_an_order_is_heard_late_and_capped(self) -> None:
        """By hand: far off the line it orders the cap at the first look, which is heard at the next."""
        law = Helmsman(0.0, (0.02, 8.0, 600.0), delay=3.0, cap_deg=20.0)
        memory, heard = dict(law.memory({"rudder": 0.0})), []
        for step in range(8):
            at = SimpleNamespace(
                **law.parameters(), **memory, t=float(step), dt=1.0, y=-40.0, psi=0.0, r=0.0, rudder=0.0
            )
            orders, memory = law.orders(at)
            heard.append(round(math.degrees(float(orders["rudder"])), 6))
        assert heard == [0.0] * 3 + [20.0] * 5

    def test_a_steady_push_is_trimmed(self) -> None:
        """Under a lasting force the ship comes back to its line, where without a trim it stays off."""
        ship, u = certain().with_coefficients(b_bank=0.0, c_bank=0.0), 5.0
        time, half = LENGTH / u, BEAM / 2
        gains = (0.56 / half, 8.0, 7.7 * time)
        off = [
            nw.simulate(
                ship, y=0.0, u=u, Y=5e5, duration=60 * time, dt=1.0, controller=Helmsman(0.0, gains, trim=trim)
            ).y[-200:].mean()
            for trim in (0.0, gains[0] / (10 * time))
        ]  # fmt: skip
        assert abs(off[0]) > 0.3
        assert abs(off[1]) < 0.3 * abs(off[0])


def was_held(model: nw.Model, law: object, thrown: dict, y: float, u: float, sample: int) -> bool:
    """One trial by the voyage's own integrator, judged by its columns."""
    at = nw.steady_course(model, y=y, u=u)
    if not abs(float(at["rudder"])) <= model.configuration.gear.limit:
        return False
    dt = LENGTH / (STEPS_A_LENGTH * u)
    voyage = nw.simulate(
        model, y=y + float(thrown["y"][sample]), u=u, psi=float(at["psi"]) + float(thrown["psi"][sample]),
        v=float(at["v"]), rudder=float(at["rudder"]), duration=TRIAL_LENGTHS * STEPS_A_LENGTH * dt, dt=dt,
        controller=law,
    )  # fmt: skip
    last = voyage.t > voyage.t[-1] - BACK_LENGTHS * LENGTH / u + 1e-9
    return voyage.outcome.kind == "afloat" and bool(np.abs(voyage.y - y)[last].max() <= BEAM / 2)


class TestTrials:
    @pytest.mark.slow
    @pytest.mark.parametrize("name", PILOTS)
    def test_each_is_a_voyage_of_its_own(self, name: str) -> None:
        """Brute force, the coefficients drawn: one pilot made for the likely ship, one for the ship that is drawn."""
        model, samples, u = replace(doubtful(), covariance=doubtful().covariance * 16), 6, np.array([5.0])
        offsets, heave = np.array([-60.0, 0.0, 35.0, 90.0]), np.zeros(1)
        thrown = {n: -c for n, c in Disturbance(6.0, offset=2.0).drawn(samples, 3).items()}
        chosen = replace(PILOTS[name], tunings=PILOTS[name].tunings[:2][-1:])
        tried = trials(model, offsets, u, heave, Disturbance(6.0, offset=2.0), samples, 3, pilot=chosen)
        ship, drawn = SimulatedShip(model), sampled(model, samples, 3)
        numbers = chosen.numbers(BestEstimateCourses(ship, offsets, u, heave), chosen.tunings[0])
        fates = set()
        for row, y in enumerate(offsets.tolist()):
            at = {n: table[row, 0] for n, table in numbers.items()}
            for sample in range(samples):
                own = model.with_coefficients(**{n: float(c[sample]) for n, c in drawn.items()})
                course = nw.steady_course(own, y=y, u=5.0)
                there = {n: float(course[n]) for n in ("rudder", "psi", "v")}
                # A drawn ship that no rudder holds there is not held, whoever steers.
                steady = np.isfinite(list(there.values())).all()
                law = chosen.law(ship, at, {"y": y, "u": 5.0, "r": 0.0, **there}) if steady else None
                signs = thrown if y < 0 else {n: -c for n, c in thrown.items()}
                held = was_held(own, law, signs, y, 5.0, sample)
                known = held or self.by_one_who_knows(own, signs, y, sample)
                assert bool(tried["held"][row, 0, sample]) == held, (y, sample)
                assert bool(tried["known"][row, 0, sample]) == known, (y, sample)
                fates |= {held, (held, known)}
        assert {True, False} <= fates

    @staticmethod
    def by_one_who_knows(own: nw.Model, thrown: dict, y: float, sample: int) -> bool:
        try:
            law = nw.control.regulator(replace(own, covariance=None), y, 5.0)
        except nw.InputError:
            return False
        return was_held(own, law, thrown, y, 5.0, sample)

    def test_one_who_knows_is_never_worse(self) -> None:
        tried = trials(narrow(), np.array([-5.0, 0.0, 8.0]), np.array([3.0, 6.0]), np.zeros(2), Disturbance(4.0), 60, 1)
        assert bool((tried["known"] >= tried["held"]).all())
        assert bool((tried["known"] > tried["held"]).any())

    def test_where_the_likely_ship_has_no_course_the_pilot_goes_by_the_nearest(self) -> None:
        ship = SimulatedShip(certain().with_coefficients(c_bank=20.0))
        courses = BestEstimateCourses(ship, np.array([5.0, 60.0]), np.array([5.0]), np.zeros(1))
        assert np.isnan(courses.course["rudder"][1])
        held, near = courses.held()["rudder"][:, 0], courses.course["rudder"]
        assert held[1] == (near[0] if np.isfinite(near[0]) else near[2])


class TestChoice:
    @pytest.mark.slow
    def test_the_tuning_that_holds_most_is_taken(self) -> None:
        """Counted again, on the samples that choose; they are others than those that judge."""
        question = envelope_request(narrow(), np.linspace(-9, 9, 7), np.array([4.0, 6.0]), disturbance=Disturbance())
        under = keel_at(question.model, question.speeds)
        clear = bounds_of(question, under)["clear"].to_numpy()
        chosen = choose_pilot(question, under.midship, clear, 0, 1)
        assert chosen.tunings[0] in PILOTS["regulator"].tunings
        shares = {}
        for tuning in PILOTS["regulator"].tunings:
            tried = trials(
                narrow(), question.offsets, question.speeds, under.midship, question.disturbance,
                300, 99, pilot=replace(PILOTS["regulator"], tunings=(tuning,)), knowing=False,
            )  # fmt: skip
            shares[tuning] = float(((np.abs(tried["rudder"]) <= question.rudder_limit) & tried["held"]).mean())
        assert shares[chosen.tunings[0]] > max(shares.values()) - 0.03
        assert shares[chosen.tunings[0]] > shares[DEFAULT_WEIGHTS] + 0.02

    def test_a_pilot_that_there_is_not_is_refused(self) -> None:
        with pytest.raises(nw.InputError, match=" or ".join(PILOTS)):
            nw.safe_envelope(certain(), controller="otto")


def place(**told: float) -> xr.Dataset:
    known = {"clear": True, "held": 0.5, "known": 0.5, "certain": 0.5, "rudder_likely": 0.1, "clearance": 5.0}
    return xr.Dataset({**known, **told})


class TestWords:
    @pytest.mark.parametrize(
        ("told", "words"),
        [
            ({"known": 0.99}, "the pilot"),
            ({"certain": 1.0}, "uncertain coefficients"),
            ({"rudder_likely": 0.5}, "the rudder"),
            ({"rudder_likely": math.nan}, "no rudder holds it"),
            ({}, "the disturbance"),
            ({"held": 0.96}, "the tests end"),
            ({"clear": False}, "the keel"),
            ({"clear": False, "clearance": math.nan}, "the canal chokes"),
        ],
    )  # fmt: skip
    def test_what_ends_it_is_named(self, told: dict, words: str) -> None:
        assert cause(place(**told), 0.95, 0.4) == words
        assert words in AT_LENGTH

    def test_two_shares_reach_the_headline_the_table_and_the_chart(self) -> None:
        ship = replace(narrow(), covariance=narrow().covariance / 6)
        found = nw.safe_envelope(ship, np.linspace(-16, 16, 9), np.array([3.0, 5.0]), samples=200, controller="human")
        data = found.data
        assert bool((data["known"] >= data["held"]).all())
        assert "The limit" in found.summary()
        assert "A pilot with the true coefficients would control the ship" in found.summary()
        assert {PILOT, KNOWLEDGE} & set(found.limited_by())
        rows = found.offset_rows()
        assert all(row["known"] >= row["held"] for row in rows)
        words = [text.get_text() for text in found.plot().legends[0].get_texts()]
        assert "by a pilot with the true coefficients" in words
        assert any(note.startswith("one pilot for all cases: a helmsman") for note in found.notes)

    def test_a_certain_ship_is_limited_by_its_rudder_and_not_by_who_knows_it(self) -> None:
        found = nw.safe_envelope(
            certain(), np.array([0.0, 130.0]), np.array([5.0]), disturbance=Disturbance(0.0), samples=1
        )
        assert found.limited_by()[1] == RUDDER or "no rudder" in found.limited_by()[1]
        assert "A pilot with the true coefficients" not in found.summary()

    def test_a_hand_at_the_wheel_holds_no_more_than_the_best(self) -> None:
        asked = {"y": np.array([-5.0, 0.0, 5.0]), "u": np.array([5.0]), "samples": 200}
        shares = {name: nw.safe_envelope(narrow(), **asked, controller=name).data["held"].sum() for name in PILOTS}
        assert float(shares["human"]) <= float(shares["regulator"]) + 0.05


def test_regulators_of_a_block_are_refused_as_one() -> None:
    with pytest.raises(nw.InputError, match="finite"):
        regulator_of(SimulatedShip(certain()), [math.nan] * 6, {"y": 0.0, "rudder": 0.0, "psi": 0.0, "v": 0.0}, 5.0)
