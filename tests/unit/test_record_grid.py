"""Signals as states predict them, by formulas and differences; records on even times, by hand."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import narrows as nw
from narrows.logbook.filtering.record_grid import HELM, READ, STATES, Readings, first_guess, grid_of, predicted_signal

ANTENNA = (40.0, -6.0)  # forward and to starboard [m]
ERRORS = {"current_x": 0.4, "current_y": -0.3, **{f"{name}_error": 0.01 * (k + 1) for k, name in enumerate(READ)}}
PILOT = {
    "helm_by_y": -0.002, "helm_by_psi": -1.5, "helm_by_v": 0.3, "helm_by_r": -40.0, "helm_by_rudder": -0.1,
    "helm_error": 0.02,
}  # fmt: skip
STATE = np.array([[300.0, 12.0, 0.3, 4.0, 0.5, 0.01], [310.0, -8.0, -2.0, 3.0, -0.4, -0.02]])
RUDDERS = np.array([0.1, -0.2])


def predicted(name: str, states: np.ndarray, errors: dict[str, float]) -> np.ndarray:
    return predicted_signal(name, states, errors, ANTENNA, RUDDERS).value


def by_formula(name: str, state: np.ndarray, rudder: float) -> float:
    """Velocities over ground are those through water and the current, turned to the ship's axes."""
    x, y, psi, u, v, r = state
    ahead, aside = u + 0.4 * math.cos(psi) - 0.3 * math.sin(psi), v - 0.3 * math.cos(psi) - 0.4 * math.sin(psi)
    values = {
        "x": x + 40.0 * math.cos(psi) + 6.0 * math.sin(psi), "y": y + 40.0 * math.sin(psi) - 6.0 * math.cos(psi),
        "psi": psi, "r": r, "u": u, "v": v, "u_ground": ahead, "v_ground": aside,
        "speed_over_ground": math.hypot(ahead, aside), "course": psi + math.atan2(aside, ahead),
    }  # fmt: skip
    pilot = rudder - 0.002 * y - 1.5 * psi + 0.3 * v - 40.0 * r - 0.1 * rudder + 0.02
    return pilot if name == HELM else values[name] + ERRORS[f"{name}_error"]


@pytest.mark.parametrize("name", [*READ, HELM])
def test_signals_are_those_of_their_formulas(name: str) -> None:
    expected = [by_formula(name, *each) for each in zip(STATE, RUDDERS, strict=True)]
    np.testing.assert_allclose(predicted(name, STATE, {**ERRORS, **PILOT}), expected, rtol=1e-12)


@pytest.mark.parametrize("name", [*READ, HELM])
def test_slopes_are_those_of_differences(name: str) -> None:
    """By every state and every error; what a signal does not depend on has none."""
    errors, step = {**ERRORS, **PILOT}, 1e-6
    found = predicted_signal(name, STATE, errors, ANTENNA, RUDDERS)
    for place in range(6):
        sides = [predicted(name, STATE + sign * step * (np.arange(6) == place), errors) for sign in (1, -1)]
        slope = np.broadcast_to(found.by_state.get(place, 0.0), 2)
        np.testing.assert_allclose(slope, (sides[0] - sides[1]) / (2 * step), rtol=1e-6, atol=1e-7)
    for error, size in errors.items():
        sides = [predicted(name, STATE, {**errors, error: size + sign * step}) for sign in (1, -1)]
        slope = np.broadcast_to(found.by_error.get(error, 0.0), 2)
        np.testing.assert_allclose(slope, (sides[0] - sides[1]) / (2 * step), rtol=1e-6, atol=1e-7)


def test_a_reading_within_a_step_is_between_the_states_at_its_ends() -> None:
    """A quarter of a step: three quarters of the state at its start, one of that at its end, with its processes."""
    draw = np.random.default_rng(0)
    slopes, start, names = draw.normal(size=(3, 6, 8)), draw.normal(size=8), ("y_error", "push")
    end = slopes[2] @ start
    read = Readings(np.zeros(1), np.array([2]), np.array([0.25]), np.ones(1))
    row = predicted_signal("y", STATE[:1], {}, (0.0, 0.0), RUDDERS[:1]).rows(read, slopes, names)
    assert row[0] @ start == pytest.approx(0.75 * start[1] + 0.25 * end[1] + start[6])


def test_a_ship_at_rest_has_a_speed_with_finite_slopes() -> None:
    for name in ("speed_over_ground", "course"):
        found = predicted_signal(name, np.zeros((1, 6)), {}, (0.0, 0.0), np.zeros(1))
        assert all(np.isfinite(slope).all() for slope in found.by_state.values())


def signal(*pairs: tuple[float, float]) -> nw.Signal:
    return nw.Signal(*np.array(pairs, float).T)


def fine(start: float, stop: float, step: float, value: object = float) -> nw.Signal:
    t = np.arange(start, stop + step / 2, step)
    return nw.Signal(t, np.array([value(at) for at in t]))


def test_values_closer_than_a_step_are_averaged_and_others_keep_their_times() -> None:
    """Steps of 2 s from the last begin, 1 s, to the first end, 21 s; y every 0.5 s is 4 values, of mean t + 0.75."""
    record = nw.ShipRecord("A", {
        "y": fine(0.0, 25.0, 0.5), "psi": fine(0.5, 22.5, 2.0, lambda t: 0.1 * t), "rudder": fine(1.0, 21.0, 1.0),
    })  # fmt: skip
    grid = grid_of(record, 2.0, {"rudder": 0.0, "revolutions": 1.5})
    np.testing.assert_allclose(grid.times, np.arange(1.0, 22.0, 2.0))
    assert (len(grid), grid.step, grid.whole.all()) == (10, 2.0, True)
    y, psi = grid.readings["y"], grid.readings["psi"]
    np.testing.assert_allclose(y.values, np.arange(1.0, 21.0, 2.0) + 0.75)
    np.testing.assert_allclose(y.counted, 4.0)
    np.testing.assert_allclose(y.share, 0.375)
    np.testing.assert_array_equal(y.step, np.arange(10))
    np.testing.assert_allclose(grid.times_of(y), np.arange(1.0, 21.0, 2.0) + 0.75)
    np.testing.assert_allclose(psi.values, 0.1 * np.arange(2.5, 21.0, 2.0))
    np.testing.assert_allclose(psi.share, 0.75)
    np.testing.assert_allclose(psi.counted, 1.0)
    np.testing.assert_allclose(grid.positions["revolutions"], 1.5)
    np.testing.assert_allclose(grid.positions["rudder"][1:-1], grid.times[1:-1], rtol=1e-9)
    np.testing.assert_array_equal(grid.order, np.argsort(np.r_[y.step, psi.step], kind="stable"))
    np.testing.assert_array_equal(grid.first_readings, 2 * np.arange(11))
    mixed = np.arange(20.0)
    assert {name: own.tolist() for name, own in grid.by_signal(mixed).items()} == {
        "y": mixed[::2].tolist(), "psi": mixed[1::2].tolist(),
    }  # fmt: skip


def test_a_step_is_not_whole_in_a_gap_of_the_rudder_or_while_another_ship_passes() -> None:
    """A rudder each second but none from 6 s to 10 s; a ship from 14.5 s to 17 s."""
    t = np.array([*range(7), *range(10, 25)], float)
    record = nw.ShipRecord("A", {
        "y": fine(0.0, 24.0, 1.0), "rudder": nw.Signal(t, t), "meeting": signal((0, 0), (14.5, 1), (17, 0)),
    })  # fmt: skip
    grid = grid_of(record, 1.0, {"rudder": 0.0}, pilot=True)
    lost = np.flatnonzero(~grid.whole)
    assert lost.tolist() == [5, 6, 7, 8, 9, 14, 15, 16]
    kept = np.flatnonzero(grid.whole)
    np.testing.assert_array_equal(grid.readings["y"].step, kept)
    helm = grid.readings[HELM]
    np.testing.assert_array_equal(helm.step, kept)
    np.testing.assert_allclose(helm.values, grid.positions["rudder"][kept + 1])
    np.testing.assert_allclose(helm.share, 0.5)
    short = nw.ShipRecord("A", {"y": fine(0.0, 24.0, 1.0), "rudder": nw.Signal(np.delete(t, 7), np.delete(t, 7))})
    assert grid_of(
        nw.ShipRecord("A", {"y": fine(0.0, 24.0, 1.0), "rudder": fine(0.0, 24.0, 3.0)}), 1.0, {"rudder": 0.0}
    ).whole.all()
    assert np.flatnonzero(~grid_of(short, 1.0, {"rudder": 0.0}).whole).tolist() == [5, 6, 7, 8, 9, 10]
    assert HELM not in grid_of(record, 1.0, {"rudder": 0.0}).readings


def test_the_rudder_between_coarse_values_is_straight_and_of_fine_ones_a_mean_with_the_same_integral() -> None:
    coarse = grid_of(
        nw.ShipRecord("A", {"y": fine(0, 20, 1), "rudder": fine(0, 20, 4, lambda t: t**2)}), 1.0, {"rudder": 0.0}
    )
    np.testing.assert_allclose(coarse.positions["rudder"][:6], [0.0, 4.0, 8.0, 12.0, 16.0, 28.0])
    fast = grid_of(
        nw.ShipRecord("A", {"y": fine(0, 20, 1), "rudder": fine(0, 20, 0.1, lambda t: float(7.3 <= t < 7.75))}),
        2.0,
        {"rudder": 0.0},
    )
    # A pulse of 0.45 s at about 7.5 s: a quarter of its share to the node at 6 s, three to that at 8 s.
    assert fast.positions["rudder"].sum() * 2.0 == pytest.approx(0.5, abs=0.06)
    assert fast.positions["rudder"][4] == pytest.approx(3 * fast.positions["rudder"][3], rel=0.2)


@pytest.mark.parametrize(("signals", "said"), [
    ({"rudder": fine(0, 20, 1)}, "holds nothing of the ship's motion"),
    ({"y": fine(0, 7.9, 0.1)}, "lasts 8 s, too short"),
])  # fmt: skip
def test_a_record_without_motion_or_of_less_than_8_steps_is_refused(signals: dict[str, nw.Signal], said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        grid_of(nw.ShipRecord("A", signals), 1.0, {"rudder": 0.0})
    assert len(grid_of(nw.ShipRecord("A", {"y": fine(0, 8.0, 0.1)}), 1.0, {"rudder": 0.0})) == 8


@pytest.mark.parametrize("given", [("x", "y"), ("x", "y", "psi"), ("x", "y", "psi", "r", "u_ground", "v")])
def test_a_first_guess_of_a_turning_circle_is_its_motion(given: tuple[str, ...]) -> None:
    """u = 4, r = 0.01, and a sway of 0.3 where the heading is known; else the course is the heading."""
    t = np.arange(0.0, 60.5, 0.5)
    drift = 0.3 if "psi" in given else 0.0
    psi = 0.2 + 0.01 * t
    ahead, aside = (np.sin(psi) - np.sin(0.2)) / 0.01, -(np.cos(psi) - np.cos(0.2)) / 0.01
    values = {
        "x": 4.0 * ahead - drift * aside, "y": 4.0 * aside + drift * ahead, "psi": psi, "r": np.full(len(t), 0.011),
        "u_ground": np.full(len(t), 4.1), "v": np.full(len(t), 0.35),
    }  # fmt: skip
    record = nw.ShipRecord("A", {name: nw.Signal(t, values[name]) for name in given})
    guess = first_guess(grid_of(record, 1.0, {}), None)[10:-10]
    others = len(given) > 3
    u, v, r = (4.1, 0.35, 0.011) if others else (4.0, drift, 0.01)
    middle = 1.0 * np.arange(10, 50)
    expected = [np.interp(middle, t, values[name]) for name in ("x", "y")]
    np.testing.assert_allclose(guess[:, :2].T, expected, atol=0.15)
    np.testing.assert_allclose(guess[:, 2], 0.2 + 0.01 * middle, atol=2e-3)
    np.testing.assert_allclose(guess[:, 3:], np.tile([u, v, r], (40, 1)), atol=5e-3)


def test_along_a_bend_the_yaw_rate_is_that_of_heading_and_line() -> None:
    """A ship that keeps its heading to a line of curvature 0.001 at 5 m/s turns by 0.005 in a second."""
    t = np.arange(0.0, 40.5, 0.5)
    record = nw.ShipRecord("A", {"x": nw.Signal(t, 5.0 * t), "y": nw.Signal(t, 0 * t), "psi": nw.Signal(t, 0 * t)})
    line = SimpleNamespace(length=100.0)
    way = SimpleNamespace(line=line, section=lambda s: SimpleNamespace(curvature=np.where(s < 100.0, 0.001, 0.0)))
    guess = first_guess(grid_of(record, 1.0, {}), way)
    np.testing.assert_allclose(guess[6:17, 5], 0.005, rtol=1e-6)
    np.testing.assert_allclose(guess[22:, 5], 0.0, atol=1e-9)


@pytest.mark.parametrize("seconds", [8.0, 9.0, 10.0])
def test_a_first_guess_of_a_short_record_is_a_line(seconds: float) -> None:
    t = np.arange(0.0, seconds + 0.25, 0.25)
    signals = {"x": 5.0 * t, "y": 0.2 * t, "psi": 0.01 * t}
    record = nw.ShipRecord("A", {name: nw.Signal(t, values) for name, values in signals.items()})
    guess = first_guess(grid_of(record, 1.0, {}), None)
    np.testing.assert_allclose(guess[2:-2, 2], 0.01 * np.arange(2, len(guess) - 2), atol=2e-3)
    np.testing.assert_allclose(guess[2:-2, 5], 0.01, atol=2e-3)


def test_a_spike_does_not_move_a_first_guess() -> None:
    t = np.arange(0.0, 40.0)
    spiked = np.where(t == 20.0, 50.0, 0.0)
    record = nw.ShipRecord("A", {"x": nw.Signal(t, 5.0 * t), "y": nw.Signal(t, spiked), "psi": nw.Signal(t, 0 * t)})
    guess = first_guess(grid_of(record, 1.0, {}), None)
    np.testing.assert_allclose(guess[:, 1], 0.0, atol=1e-9)
    assert guess.shape == (39, len(STATES))


def test_a_record_within_a_meeting_is_refused() -> None:
    t = np.arange(25.0)
    record = nw.ShipRecord("a", {name: nw.Signal(t, one) for name, one in {"y": t, "meeting": np.ones(25)}.items()})
    with pytest.raises(nw.InputError, match="record a consists of marked meetings"):
        grid_of(record, 2.0, {})
