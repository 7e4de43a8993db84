"""Numbers of the safe envelope by hand: requests, shares, pilots; nothing is sailed here."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import narrows as nw
from narrows.model.water import squat
from narrows.quantities.arithmetic import choice
from narrows.safety import envelope, settings
from narrows.safety.envelope import (
    best_estimate_fraction,
    choose_pilot,
    controllable_fraction,
)
from narrows.safety.pilots import (
    PILOTS,
    BestEstimateCourses,
    Helmsman,
    Pilot,
    regulator_of,
    whole_degrees,
)
from narrows.safety.request import (
    Bend,
    Disturbance,
    EnvelopeRequest,
    default_offsets,
    default_speeds,
    envelope_request,
    keel_at,
)
from narrows.safety.trials import DeviationRecorder, _numbers

DEGREE = math.pi / 180


def ship(length: float = 100.0, beam: float = 10.0, limit: float = 0.6, **more: Any) -> Any:
    configuration = SimpleNamespace(
        ship=SimpleNamespace(length=length, beam=beam, draft=5.0), gear=SimpleNamespace(limit=limit)
    )
    return SimpleNamespace(configuration=configuration, **more)


def test_settings_are_those_of_the_page_on_criteria() -> None:
    """docs/safe-envelope.md: a third of the rudder, a twentieth of the draft, 15 lengths and the last three, 95 %."""
    assert (settings.RESERVE, settings.KEEL_SHARE, settings.SURE_SHARE) == (1 / 3, 1 / 20, 0.95)
    assert (settings.TRIAL_LENGTHS, settings.BACK_LENGTHS) == (15.0, 3.0)
    assert settings.SAMPLES == 800
    usual = Disturbance()
    assert (usual.heading_deg, usual.gust_time) == (2.0, 60.0)
    assert (usual.offset, usual.gust, usual.gust_lever, usual.steady) == (0.0,) * 4
    # Docstring of envelope_along: nine offsets and nine speeds at each place.
    assert (settings.ALONG_OFFSETS, settings.ALONG_SPEEDS) == (9, 9)


def test_drawn_disturbances_have_the_declared_deviations_and_either_side() -> None:
    thrown = Disturbance(3.0, offset=0.5, gust=200.0, gust_lever=-4.0).drawn(20_000, 7)
    assert float(thrown["psi"].std()) == pytest.approx(3.0 * DEGREE, rel=0.02)
    assert float(thrown["y"].std()) == pytest.approx(0.5, rel=0.02)
    assert abs(float(thrown["psi"].mean())) < 0.1 * DEGREE
    np.testing.assert_array_equal(np.abs(thrown["Y"]), 200.0)
    assert float((thrown["Y"] > 0).mean()) == pytest.approx(0.5, abs=0.02)
    np.testing.assert_array_equal(thrown["N"], -4.0 * thrown["Y"])
    np.testing.assert_array_equal(thrown["side"], np.sign(thrown["Y"]))
    columns = np.corrcoef([thrown[name] for name in ("psi", "y", "Y")])
    assert np.abs(columns - np.eye(3)).max() < 0.03
    np.testing.assert_allclose(thrown["psi"], 3.0 * Disturbance(1.0).drawn(20_000, 7)["psi"])
    assert (thrown["psi"][:20_000] != Disturbance(3.0).drawn(20_000, 8)["psi"]).any()
    assert Disturbance().drawn(1, 0)["psi"].size == 1


def test_a_path_to_the_inside_of_a_bend_has_the_smaller_radius() -> None:
    """Circles about one centre: 500 m to starboard of the middle, 470 m from a path 30 m to starboard."""
    bend = Bend(1 / 500, current=0.4)
    assert bend.path_curvature(30.0) == pytest.approx(1 / 470)
    assert bend.path_curvature(-30.0) == pytest.approx(1 / 530)
    assert Bend(-1 / 500).path_curvature(30.0) == pytest.approx(-1 / 530)
    assert bend.values(30.0) == {"path_curvature": pytest.approx(1 / 470), "current": 0.4}
    assert [bool(Bend(*given)) for given in ((0.0, 0.0), (1e-9, 0.0), (0.0, -0.1))] == [False, True, True]


REQUEST: dict[str, Any] = {
    "model": ship(), "offsets": np.array([-44.9, 54.9]), "speeds": np.array([1.0, 2.0]), "clearance": 0.0,
    "walls": (50.0, 60.0), "disturbance": Disturbance(), "reserve": 0.0,
}  # fmt: skip
EDGES: dict[str, tuple[dict[str, Any], str]] = {
    "port": ({"offsets": np.array([-45.0, 0.0])}, "in a bank; stay between -45 and 55 m"),
    "starboard": ({"offsets": np.array([0.0, 55.0])}, "in a bank"),
    "twice": ({"offsets": np.array([0.0, 0.0])}, "offsets must be finite and rise"),
    "no speeds": ({"speeds": np.array([])}, "speeds must be finite and rise"),
    "slow": ({"speeds": np.array([0.0, 1.0])}, "steers nothing"),
    "whole rudder": ({"reserve": 1.0}, "a reserve of 1.0"),
    "below nothing": ({"reserve": -0.01}, "a reserve of"),
    "no clearance": ({"clearance": -0.01}, "under the keel"),
    "current": ({"bend": Bend(current=-1.0)}, "leaves no way"),
    "bend": ({"bend": Bend(1 / 60.0)}, "bends inside its own bank"),
    "bend to port": ({"bend": Bend(-1 / 60.0)}, "bends inside its own bank"),
}


def test_a_request_ends_just_before_what_is_refused() -> None:
    asked = EnvelopeRequest(**REQUEST)
    assert asked.rudder_limit == 0.6
    assert replace(asked, reserve=0.25).rudder_limit == pytest.approx(0.45)
    replace(asked, bend=Bend(1 / 60.1, 0.999))


@pytest.mark.parametrize("edge", EDGES)
def test_what_no_envelope_is_of_is_refused(edge: str) -> None:
    changed, words = EDGES[edge]
    with pytest.raises(nw.InputError, match=words):
        EnvelopeRequest(**{**REQUEST, **changed})


def test_offsets_are_closer_in_the_middle_and_stay_a_half_beam_from_the_banks() -> None:
    """A beam of 10 m: the middle of the hull is up to a beam from each wall, half a beam of water beside the hull."""
    unknown = ship(data_range=SimpleNamespace(abs_y=None))
    np.testing.assert_allclose(default_offsets(unknown, (60.0, 60.0), 5), [-50.0, -12.5, 0.0, 12.5, 50.0])
    np.testing.assert_allclose(default_offsets(unknown, (30.0, 70.0), 5), [-20.0, 10.0, 20.0, 30.0, 60.0])
    assert len(default_offsets(unknown, (60.0, 60.0))) == 25
    tested = ship(data_range=SimpleNamespace(abs_y=(5.0, 30.0)))
    np.testing.assert_allclose(default_offsets(tested, (30.0, 70.0), 3), [-20.0, 20.0, 30.0, 60.0])
    with pytest.raises(nw.InputError, match="less than two beams"):
        default_offsets(unknown, (10.0, 10.0))
    assert len(default_offsets(unknown, (10.1, 10.1), 3)) == 3


KCS = nw.published("estimated_kcs")


def test_speeds_go_from_three_tenths_to_a_twentieth_over_the_choking_speed() -> None:
    choke = nw.choke_speed(KCS.configuration)
    everywhere = replace(KCS, data_range=replace(KCS.data_range, speed=(0.3 * choke, 0.9 * choke)))
    np.testing.assert_allclose(default_speeds(everywhere, 3) / choke, [0.3, 0.675, 0.9, 1.05])
    unknown = replace(KCS, data_range=replace(KCS.data_range, speed=None))
    assert len(default_speeds(unknown)) == 15
    usual = envelope_request(unknown, None, None, disturbance=Disturbance())
    assert usual.clearance == pytest.approx(KCS.configuration.ship.draft / 20)
    assert usual.walls == (150.0, 150.0)
    np.testing.assert_allclose(usual.speeds, default_speeds(unknown))
    assert usual.offsets[-1] == pytest.approx(150.0 - KCS.configuration.ship.beam)
    assert envelope_request(unknown, None, None, keel=0.3, disturbance=Disturbance()).clearance == 0.3


def test_the_keel_clears_the_bottom_by_what_the_deepest_end_leaves() -> None:
    choke, configuration = nw.choke_speed(KCS.configuration), KCS.configuration
    under = keel_at(KCS, np.array([2.0, 4.0, choke + 0.1]))
    assert under.choke == choke
    for place, speed in enumerate((2.0, 4.0)):
        largest = max(squat(configuration, speed, gives).sinkage for gives in ("bow", "largest"))
        assert under.clearance[place] == pytest.approx(16.2 - configuration.ship.draft - largest)
        assert under.midship[place] == squat(configuration, speed).sinkage < largest
    assert np.isnan(under.clearance[2])
    assert under.midship[2] == 0.0
    assert len(under.notes) == len(set(under.notes))


def test_places_of_a_row_are_evenly_spaced_within_it() -> None:
    assert envelope._spread(3, 5).tolist() == [0, 1, 2]
    assert envelope._spread(25, 5).tolist() == [2, 7, 12, 17, 22]
    assert envelope._spread(7, 2).tolist() == [1, 5]
    assert envelope._spread(6, 5).tolist() == [0, 1, 2, 4, 5]


def test_the_tuning_that_holds_most_is_found_on_few_clear_places_and_other_samples(monkeypatch: Any) -> None:
    calls: list[Any] = []

    def tried(model: Any, y: Any, u: Any, heave: Any, disturbance: Any, samples: int, seed: int, walls: Any,
              pilot: Pilot, **more: Any) -> xr.Dataset:  # fmt: skip
        calls.append((y, u, heave, samples, seed, walls, pilot.tunings, more))
        number = PILOTS["regulator"].tunings.index(pilot.tunings[0])
        held = np.arange(4) <= number
        rudder = np.where((number == 3) & (np.arange(4) > 1), 0.61, 0.59)  # the fourth needs more than the limit
        return xr.Dataset({"held": ("sample", held), "rudder": ("sample", -rudder)})

    monkeypatch.setattr(envelope, "trials", tried)
    model, bend = ship(), Bend(0.001, 0.1)
    request = EnvelopeRequest(**{**REQUEST, "offsets": np.arange(7.0), "speeds": np.arange(1.0, 9.0), "bend": bend})
    clear = np.array([False] * 3 + [True] * 4 + [False])
    chosen = choose_pilot(request, np.arange(8.0), clear, 5, 1)
    assert chosen == replace(PILOTS["regulator"], tunings=PILOTS["regulator"].tunings[2:3])
    assert len(calls) == len(PILOTS["regulator"].tunings)
    y, u, heave, samples, seed, walls, tunings, more = calls[0]
    np.testing.assert_array_equal(y, [0.0, 2.0, 3.0, 4.0, 6.0])
    np.testing.assert_array_equal(u, [4.0, 6.0])  # of 4, 5, 6 and 7 m/s, which are clear
    np.testing.assert_array_equal(heave, u - 1.0)
    assert (samples, walls, tunings) == (200, (50.0, 60.0), PILOTS["regulator"].tunings[:1])
    assert more == {"bend": bend, "knowing": False, "workers": 1}
    assert {call[4] for call in calls} == {seed}
    assert seed != 5
    choose_pilot(request, np.arange(8.0), clear & False, -5, 1)
    np.testing.assert_array_equal(calls[-1][1], [3.0, 7.0])  # where nothing is clear, of all
    assert calls[-1][4] == seed
    one = replace(PILOTS["human"], tunings=(1.0,))
    monkeypatch.setitem(PILOTS, "human", one)
    assert choose_pilot(replace(request, pilot="human"), np.arange(8.0), clear, 5, 1) is one
    assert model.configuration.gear.limit == request.rudder_limit


def samples_of(**columns: list[Any]) -> xr.Dataset:
    return xr.Dataset({name: (("y", "u", "sample"), np.array([[column]])) for name, column in columns.items()})


def test_shares_and_angles_of_five_samples() -> None:
    tried = samples_of(
        rudder=[-0.3, 0.1, -0.2, np.nan, -0.4],
        held=[True, True, True, True, True],
        known=[True, False, True, False, True],
    )
    found = {name: column.item() for name, column in controllable_fraction(tried, 0.3).items()}
    assert (found["found"], found["holds"], found["held"], found["known"]) == pytest.approx((0.8, 0.6, 0.6, 0.4))
    # The sample without a course lies beyond hard over to port, on the side of the median of the others, -0.25.
    assert found["rudder"] == -0.3
    assert (found["rudder_low"], found["rudder_high"], found["rudder_95"]) == (-np.inf, 0.1, np.inf)
    assert controllable_fraction(tried, 0.3)["rudder"].attrs["units"] == "rad"
    assert controllable_fraction(tried, 0.3)["held"].attrs["units"] == "1"
    assert found["held_low"] < 0.6 < found["held_high"] <= 1.0
    even = samples_of(rudder=[0.1, 0.3], held=[True, True], known=[True, True])
    assert controllable_fraction(even, 1.0)["rudder"].item() == pytest.approx(0.2)
    lost = samples_of(rudder=[np.nan, np.nan, 0.0], held=[False] * 3, known=[False] * 3)
    assert np.isnan(controllable_fraction(lost, 1.0)["rudder"].item())
    assert controllable_fraction(lost, 1.0)["rudder_high"].item() == np.inf
    # Of 100 the 95th is exceeded by five, whichever way the rudder lies.
    many = samples_of(rudder=[-0.01 * k for k in range(1, 101)], held=[True] * 100, known=[True] * 100)
    assert controllable_fraction(many, 1.0)["rudder_95"].item() == pytest.approx(0.96)
    assert controllable_fraction(many, 1.0)["rudder_low"].item() == pytest.approx(-0.96)


def test_the_best_estimate_counts_the_larger_rudder_of_either_wind() -> None:
    tried = samples_of(rudder=[-0.3, 0.2, 0.25], held=[False] * 3, known=[True, True, False])
    found = best_estimate_fraction(tried, 0.28)
    assert found["certain"].item() == pytest.approx(1 / 3)
    assert found["rudder_likely"].item() == -0.3
    assert best_estimate_fraction(-1 * tried, 0.28)["rudder_likely"].item() == 0.3
    none = samples_of(rudder=[0.1, np.nan], held=[True] * 2, known=[True] * 2)
    assert np.isnan(best_estimate_fraction(none, 0.28)["rudder_likely"].item())


# Pilots


def test_a_helmsman_looks_orders_and_trims_as_a_table_says() -> None:
    """A look every 3 s: 0.1 rad per metre, twice the heading; a trim of 0.01 rad a second and metre, unless capped."""
    law = Helmsman(2.0, (0.1, 2.0, 3.0), trim=0.01, rudder=0.04, psi=0.02, delay=3.0, cap_deg=10.0)
    memory = dict(law.memory({"rudder": 0.07}))
    assert memory == {"trimmed": 0.0, "next_look": 0.0, "given": 0.07, "executed": 0.07}
    orders, trims = [], []
    for t in range(8):
        y = 2.5 if t < 4 else -8.0
        at = SimpleNamespace(**law.parameters(), **memory, t=float(t), dt=1.0, y=y, psi=0.03, r=-0.01, rudder=0.0)
        order, memory = law.orders(at)
        orders.append(float(order["rudder"]))
        trims.append(float(memory["trimmed"]))
    # At t = 0: 0.04 - 0.1 * 0.5 - 2 * 0.01 + 3 * 0.01 = 0.0 rad, 0 degrees; at t = 3 a trim of -0.015 rad, -1 degree.
    # From t = 4 the order would be 1.0 rad: the trim rests, and 10 degrees are ordered at t = 6, executed at 9.
    np.testing.assert_allclose(orders, [0.07] * 3 + [0.0] * 3 + [-1 * DEGREE] * 2, atol=1e-12)
    np.testing.assert_allclose(trims, [-0.005, -0.010, -0.015, -0.020] + [-0.020] * 4, atol=1e-12)
    assert float(memory["given"]) == pytest.approx(10 * DEGREE)
    assert float(memory["next_look"]) == pytest.approx(9.0)


def test_halves_of_degrees_are_rounded_away_from_zero() -> None:
    given = [0.49, 0.5, 1.499, 1.5, 31.5, 62.5, 63.4, 0.0]
    found = [round(float(whole_degrees(sign * value * DEGREE)) / DEGREE, 9) for value in given for sign in (1, -1)]
    assert found == [0, 0, 1, -1, 1, -1, 2, -2, 32, -32, 63, -63, 63, -63, 0, 0]


def test_the_gains_of_manual_steering_are_those_stated() -> None:
    """Half a beam off: 0.56 rad at once, as much again by the trim in ten lengths; 8 per heading; 7.7 per turn."""
    held = {name: np.full((1, 2), value) for name, value in (("rudder", 0.1), ("psi", -0.02), ("v", 0.3))}
    courses: Any = SimpleNamespace(ship=SimpleNamespace(model=ship()), speeds=np.array([2.0, 4.0]), held=lambda: held)
    numbers = PILOTS["human"].numbers(courses, 1.0)
    np.testing.assert_allclose(numbers["by_y"] * 5.0, 0.56)
    np.testing.assert_allclose(numbers["by_psi"], 8.0)
    np.testing.assert_allclose(numbers["by_r"], [[7.7 * 50.0, 7.7 * 25.0]])  # a length takes 50 s and 25 s
    np.testing.assert_allclose(numbers["by_trim"] * 5.0 * 10 * np.array([50.0, 25.0]), 0.56)
    half = PILOTS["human"].numbers(courses, 0.5)
    for name in ("by_y", "by_psi", "by_r", "by_trim"):
        np.testing.assert_allclose(half[name], numbers[name] / 2)
    assert PILOTS["human"].tunings == (1.0, 0.5, 0.25, 0.125)
    law: Any = PILOTS["human"].law(courses.ship, {n: c[0, 0] for n, c in numbers.items()}, {"y": 7.0, "r": 0.01})
    # In a steady turn the rate that belongs to it asks for no rudder.
    at = SimpleNamespace(**law.parameters(), **law.memory({"rudder": 0.1}), t=0.0, dt=1.0, y=7.0, psi=-0.02, r=0.01)
    assert float(law.orders(at)[1]["given"]) == pytest.approx(6 * DEGREE)  # 0.1 rad is 5.7 degrees
    assert (law.y, law.delay, law.cap_deg) == (7.0, 3.0, 20.0)


def test_tighter_regulators_weigh_the_offset_by_four_eight_and_sixteen() -> None:
    offsets = [tuning.offset for tuning in PILOTS["regulator"].tunings]
    assert offsets == [1.0, 1 / 4, 1 / 8, 1 / 16]
    assert [tuning.bank for tuning in PILOTS["regulator"].tunings] == [0.5, 1.0, 1.0, 1.0]
    # Times of a ship length, 25 s: 0.45 of it ahead, 0.26 of it to unwind.
    law = regulator_of(SimpleNamespace(model=ship()), [1.0] * 6, {"y": 3.0, "rudder": 0.1, "psi": 0.2, "v": 0.3}, 4.0)
    assert (float(law.lead), float(law.unwinding), law.u) == pytest.approx((0.45 * 25, 0.26 * 25, 4.0))
    assert (law.lines[0].y, law.lines[0].rudder, law.lines[0].psi, law.lines[0].v) == (3.0, 0.1, 0.2, 0.3)


def test_courses_that_there_are_not_are_those_of_the_nearest_place_and_speed() -> None:
    """Offsets of -30, 10 and 40 m and the middle, which is the last place; three speeds; two columns."""
    courses = BestEstimateCourses(ship(), np.array([-30.0, 10.0, 40.0]), np.array([1.0, 2.0, 4.0]), np.zeros(3))
    assert courses.places.tolist() == [-30.0, 10.0, 40.0, 0.0]
    table = np.arange(24.0).reshape(4, 3, 2)
    np.testing.assert_array_equal(courses.filled(table.reshape(12, 2)), table[:3])
    lost = table.copy()
    lost[0, 1, 1] = lost[2, 1] = lost[1, 2] = np.nan
    there = table[:3].copy()
    there[0, 1], there[2, 1], there[1, 2] = table[3, 1], table[1, 1], table[3, 2]
    np.testing.assert_array_equal(courses.filled(lost.reshape(12, 2)), there)
    lost[:, 0] = np.nan
    with pytest.raises(nw.InputError, match="no pilot holds this ship"):
        courses.filled(lost.reshape(12, 2))
    windy = replace(courses, wind=(0.0, 3.0)).filled(lost.reshape(12, 2))
    there[:, 0] = there[:, 1]
    np.testing.assert_array_equal(windy, there)
    with pytest.raises(nw.InputError, match="no pilot"):
        replace(courses, wind=(1.0, 3.0)).filled(np.full((12, 2), np.nan))


def test_numbers_in_a_steady_wind_are_those_of_the_side_it_blows_from() -> None:
    courses = BestEstimateCourses(ship(), np.array([0.0, 1.0]), np.array([1.0]), np.zeros(1))
    pilot: Any = SimpleNamespace(
        tunings=(2.0, 3.0),
        numbers=lambda there, tuning: {"by_y": tuning * np.full((2, 1), there.wind[0] + there.wind[1])},
    )
    wind = xr.DataArray([[0.4, -0.4], [-0.4, 0.4]], dims=("y", "sample"))
    found = _numbers(pilot, courses, Disturbance(steady=0.4, gust_lever=5.0), wind)["by_y"]
    expected = 2.0 * 0.4 * (1 + 5.0) * np.array([[1.0, -1.0], [-1.0, 1.0]])
    np.testing.assert_allclose(found.isel(u=0).transpose("y", "sample"), expected)
    calm = _numbers(pilot, courses, Disturbance(), 0 * wind)["by_y"]
    np.testing.assert_array_equal(calm, 0.0)


def test_deviations_count_from_the_last_part_of_a_trial_on() -> None:
    class Idle:
        def parameters(self) -> dict[str, Any]:
            return {"own": 1.0}

        def memory(self, start: Any) -> dict[str, Any]:
            return {"count": 0.0}

        def orders(self, at: Any) -> tuple[dict[str, Any], dict[str, Any]]:
            return {"rudder": 0.1}, {"count": at.count + 1.0}

    law: Any = DeviationRecorder(Idle(), 2.0, 3.0)
    memory, farthest = dict(law.memory({})), []
    assert memory == {"count": 0.0, "farthest": 0.0}
    for t, y in ((2.0, 9.0), (2.4, -9.0), (2.6, 1.0), (3.5, -2.0), (4.5, 4.0)):
        at = SimpleNamespace(**law.parameters(), **memory, t=t, dt=1.0, y=y)
        orders, memory = law.orders(at)
        farthest.append(float(memory["farthest"]))
    assert orders == {"rudder": 0.1}
    assert memory["count"] == 5.0
    assert farthest == [0.0, 0.0, 1.0, 4.0, 4.0]  # the middle of a step counts; either side
    assert float(choice(1.0, 2.0, 3.0)) == 2.0
