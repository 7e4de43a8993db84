"""Control by hand and beside python-control: margins, modes, laws step by step; no ship sails."""

import math
from types import SimpleNamespace
from typing import Any

import control
import numpy as np
import pytest

import narrows as nw
from narrows.control import LinearSystem, RegulatorWeights
from narrows.control import settings as control_settings
from narrows.control.closed_loop import OpenedLaw
from narrows.control.linear_system import loop_margins
from narrows.control.regulator import lqr, rate_driven, stabilised
from narrows.control.steady_course import check_holds, check_inside

DEGREE = math.pi / 180


def test_settings_are_those_of_the_page_on_control() -> None:
    """docs/control.md: weights, a horizon of 2.4 lengths in 30 intervals, 0.15 beams, 0.7 of the rudder's limit."""
    weights = RegulatorWeights()
    assert (weights.offset, weights.heading_deg, weights.rudder_deg) == (1.0, 2.3, 14.0)
    assert (weights.stroke_time, weights.integral_time, weights.bank, weights.unwinding_time) == (0.095, 1.7, 0.5, 0.26)
    assert (control_settings.HORIZON_LENGTHS, control_settings.INTERVALS, control_settings.MARGIN) == (2.4, 30, 0.15)
    assert (control_settings.PLANS_AN_INTERVAL, control_settings.RESERVE) == (5, 0.7)
    assert nw.control.PredictiveHelm.confidence == 0.95
    assert control_settings.LOOP_DURATION == 40.0


def test_settings_of_plans() -> None:
    """Changes here change the plans of a helm: each is deliberate."""
    assert (control_settings.PUSH_LENGTHS, control_settings.RETURNING, control_settings.FREE_CLEARANCE) == (0.3, 20, 4)
    assert (control_settings.LEAD_TIME, control_settings.SLOWEST) == (0.45, 0.05)
    assert (control_settings.MOST_DRIFT, control_settings.MOST_TURN, control_settings.LEAST_CLEARANCE) == (
        0.5,
        1.0,
        0.2,
    )


# Linear systems


def linear(A: np.ndarray, b: np.ndarray, length: float = 50.0, speed: float = 2.0, states: Any = None) -> LinearSystem:
    names = states or ("y", "psi", "v", "r")[: len(A)]
    course = {"y": 0.0, "u": speed, "psi": 0.0, "curvature": 0.0}
    return LinearSystem(A, b[:, None], np.zeros((len(A), 0)), names, ("rudder",), (), course, length, ())


def test_modes_are_those_of_an_oscillator_and_two_real_roots() -> None:
    """Roots of -0.03 +- 0.04 i: a damping ratio of 0.6; 0.1 doubles in 6.93 s, -0.2 halves in 3.47 s."""
    A = np.zeros((4, 4))
    A[:2, :2], A[2, 2], A[3, 3] = [[0.0, 1.0], [-0.0025, -0.06]], 0.1, -0.2
    modes = linear(A, np.ones(4)).modes()
    np.testing.assert_allclose(modes["growth"], [0.1, -0.03, -0.03, -0.2], atol=1e-12)
    np.testing.assert_allclose(np.abs(modes["angular_frequency"]), [0.0, 0.04, 0.04, 0.0], atol=1e-12)
    np.testing.assert_allclose(modes["doubling_s"], [math.log(2) / 0.1, math.inf, math.inf, math.inf])
    np.testing.assert_allclose(modes["halving_s"], [math.inf, *[math.log(2) / 0.03] * 2, math.log(2) / 0.2])
    np.testing.assert_allclose(modes["period_s"], [math.inf, 2 * math.pi / 0.04, 2 * math.pi / 0.04, math.inf])
    np.testing.assert_allclose(modes["damping_ratio"], [-1.0, 0.6, 0.6, 1.0])
    assert (modes["v"][0], modes["r"][3], modes["y"][0]) == (1.0, 1.0, 0.0)
    # Of the oscillation psi = s y: 0.05 rad for each metre, 2.5 rad for each length of 50 m.
    shape = modes.loc[1, ["y", "psi"]].to_numpy(complex)
    assert abs(shape[1] / shape[0]) == pytest.approx(0.05 * 50.0)
    assert np.abs(shape).max() == pytest.approx(1.0)
    rest = linear(np.zeros((4, 4)), np.ones(4)).modes()
    assert rest["damping_ratio"].tolist() == [0.0] * 4
    assert np.isinf(rest[["doubling_s", "halving_s", "period_s"]].to_numpy()).all()


LOOPS = {
    "an integrator and two lags": ([1.0], [1.0, 2.0, 1.0, 0.0]),  # imaginary part 0 at 1 rad/s, where it is -1/2
    "unstable by itself": (
        [36.0, 72.0],
        np.polymul([1.0, 2.0, -1.0], [1.0, 9.0]),
    ),  # -8 at rest: a gain of 1/8 at least
    "weakly damped": ([1.8], np.polymul([1.0, 0.3, 1.0], [1.0, 3.0])),
}


@pytest.mark.parametrize("dt", [0.01, 0.1])
@pytest.mark.parametrize("name", LOOPS)
def test_margins_are_where_the_closed_loop_loses_its_stability(name: str, dt: float) -> None:
    """By its poles, with a factor that may be complex; a delay by the distance of the turned curve from -1."""
    system = control.c2d(control.ss(control.tf(*LOOPS[name])), dt)
    A, B, C = (np.asarray(part) for part in (system.A, system.B, system.C))
    highest = math.pi / dt
    found = loop_margins(A, B, C, 1e-3, highest, dt)

    def is_stable(factor: complex) -> bool:
        poles = np.linalg.eigvals(A - factor * B @ C)
        return bool((np.abs(poles) < 1.0).all())

    assert is_stable(1.0)
    assert math.isfinite(found["gain"])
    for factor in np.geomspace(max(found["gain_down"], 1e-4) * 1.001, min(found["gain"], 1e3) * 0.999, 50):
        assert is_stable(factor)
    for name_of_edge, outward in (("gain", 1.001), ("gain_down", 0.999)):
        if 0.0 < found[name_of_edge] < math.inf:
            assert not is_stable(found[name_of_edge] * outward)
    phase = found["phase_deg"] * DEGREE
    assert all(is_stable(np.exp(1j * turn)) for turn in np.linspace(-0.999 * phase, 0.999 * phase, 50))
    assert not (is_stable(np.exp(1.001j * phase)) and is_stable(np.exp(-1.001j * phase)))
    omega = np.geomspace(1e-3, highest, 100_001)
    at = np.exp(1j * omega * dt)
    loop = (C @ np.linalg.solve(at[:, None, None] * np.eye(len(A)) - A, np.tile(B, (omega.size, 1, 1))))[:, 0, 0]
    distances = [np.abs(1 + loop * np.exp(-1j * omega * own * found["delay"])).min() for own in (0.0, 0.5, 0.9, 1.0)]
    assert distances[3] < 1e-3 < 0.02 < min(distances[:3])
    assert found["distance"] == pytest.approx(distances[0], rel=1e-3)
    assert found["sensitivity_peak"] == pytest.approx(1 / distances[0], rel=1e-3)
    if not dt and name == "an integrator and two lags":
        assert found["gain"] == pytest.approx(2.0)
    if name == "unstable by itself":
        assert found["gain_down"] == pytest.approx(1 / 8, rel=1e-6)


def test_gains_of_lqr_are_those_of_python_control() -> None:
    random = np.random.default_rng(4)
    A, b = random.standard_normal((4, 4)), random.standard_normal(4)
    system = linear(A, b)
    full = random.standard_normal((4, 4))
    for Q, R in ((np.ones(4), 2.0), ([1.0, 0.5, 2.0, 0.1], [0.3]), (full @ full.T, np.array([[0.7]])), (3.0, 1.0)):
        matrix = np.asarray(Q, float)
        matrix = matrix if matrix.ndim == 2 else np.diag(np.broadcast_to(matrix, 4))
        gains, cost, poles = control.lqr(A, b[:, None], matrix, np.asarray(R, float).reshape(1, 1))
        found = lqr(system, Q, R)
        np.testing.assert_allclose(found[0], gains, rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(found[1], cost, rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(np.sort_complex(found[2]), np.sort_complex(poles), rtol=1e-6)
        assert np.array_equal(lqr(system, Q, R, "rudder")[0], found[0])
    for wrong in ((np.ones(3), 1.0), (np.ones(4), [1.0, 2.0]), (np.ones((3, 4)), 1.0)):
        with pytest.raises(nw.InputError, match="give a row and a column"):
            lqr(system, *wrong)
    with pytest.raises(nw.InputError, match="no gains hold"):
        lqr(linear(np.eye(4), 0 * b), 1.0, 1.0)


def test_a_rudder_rate_drives_a_sixth_order_system() -> None:
    A, b = np.arange(16.0).reshape(1, 4, 4), np.array([[5.0, 6.0, 7.0, 8.0]])
    motion, push = rate_driven(A, b)
    state = np.array([1.0, 2.0, 3.0, 4.0, 0.1, 9.0])  # y, psi, v, r, rudder, integral
    np.testing.assert_allclose(motion[0] @ state, [*(A[0] @ state[:4] + 0.1 * b[0]), 0.0, 1.0])
    np.testing.assert_array_equal(push[0], [0, 0, 0, 0, 1.0, 0])
    # Stable by the slowest root, relative to the fastest: 1e-7.
    roots = np.array([[-1.0, -1.1e-7], [-1.0, -0.9e-7], [-1.0, 0.1]])
    diagonal = roots[:, :, None] * np.eye(2)
    assert stabilised(diagonal, np.zeros((3, 2)), np.zeros((3, 2))).tolist() == [True, False, False]
    assert not stabilised(diagonal[:1], np.zeros((1, 2)), np.full((1, 2), np.nan))[0]


# Loops


class Ahead:
    """A helm that does nothing."""

    def parameters(self) -> dict[str, Any]:
        return {"own": 1.0}

    def memory(self, start: Any) -> dict[str, Any]:
        return {"kept": 2.0}

    def orders(self, at: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        return {"rudder": 0.1}, {"kept": at.kept + 1.0}


def test_an_opened_law_remembers_what_it_asks_for() -> None:
    law = OpenedLaw(Ahead())
    assert law.parameters() == {"own": 1.0, "loop_ordered": 0.0}
    assert law.memory({"rudder": 0.3}) == {"kept": 2.0, "loop_asked": 0.3}
    orders, memory = law.orders(SimpleNamespace(kept=2.0, loop_ordered=0.4))
    assert (orders, memory) == ({"rudder": 0.4}, {"kept": 3.0, "loop_asked": 0.1})


KCS = nw.published("estimated_kcs")


def test_limits_of_a_course_are_its_gears_and_its_banks() -> None:
    limit = KCS.configuration.gear.limit
    check_holds(KCS, -limit, 0.0, 1.0)
    for rudder in (1.0001 * limit, -1.0001 * limit, math.nan):
        with pytest.raises(nw.InputError, match="no rudder up to"):
            check_holds(KCS, rudder, 0.0, 1.0)
    check_inside(np.array([-4.99, 4.99]), 20.0, 10.0)
    for y in (5.0, -5.0):
        with pytest.raises(nw.InputError, match="stay within 5 m"):
            check_inside(np.array([0.0, y]), 20.0, 10.0)
