"""Windows of a record and their slopes: against CasADi on the paper's equations, and against the windows themselves."""

from math import pi

import casadi
import numpy as np
import pytest

import narrows as nw
from narrows.logbook.filtering.log_problem import RecordedMotion
from narrows.physics.hull import drift
from narrows.physics.propeller_and_rudder import NOTHING

KVLCC2 = nw.published("yasukawa2015_kvlcc2")
SHIP, PROPELLER, RUDDER = KVLCC2.configuration.ship, KVLCC2.configuration.propeller, KVLCC2.configuration.rudder
FREE = ("Y_v", "N_r", "N_vvr", "Y_rudder", "N_rudder", "X_vv", "R_0", "X_thrust")
STEP, WINDOWS = 0.2, 3
TIMES = STEP * np.arange(31)
FIRST = np.array([0, 10, 20, 30])
RUDDERS = 0.3 * np.sin(0.9 * TIMES)
TURNS = 10.0 + 0.3 * np.cos(0.5 * TIMES)
STARTS = np.array([[0, 0.3, 0.1, 1.1, 0.02, 0.01], [7, 0.5, 0.3, 1, -0.05, 0.03], [14, 1, 0.4, 1.05, 0.04, -0.02]])
PUSHED = np.array([[1.0, 2.0, -3.0], [0.0, 0.0, 0.0], [-2.0, 4.0, 5.0]])
OFFSETS, TURNS_OFF = np.array([0.01, -0.02, 0.03]), np.array([0.4, -0.3, 0.0])


def motion() -> RecordedMotion:
    choices = {"surge": "free", "contact": "none", "u": 1.1}
    return RecordedMotion(KVLCC2, {"rudder": 0.0, "revolutions": 10.0}, FREE, choices)


def rates(z: casadi.SX, delta: casadi.SX, n: casadi.SX, push: casadi.SX, c: dict[str, casadi.SX]) -> casadi.SX:
    """The MMG standard method in the paper's symbols, in CasADi's; drift and side of the wake by our fractions."""
    cosine, sine, u, v, r = z[2], z[3], z[4], z[5], z[6]
    L, d, rho = SHIP.length, SHIP.draft, KVLCC2.configuration.water.density
    whole = casadi.sqrt(u * u + v * v)
    beta, vp, rp = drift(u, v), v / whole, r * L / whole
    angle = beta - PROPELLER.position * rp
    middle, half = (PROPELLER.wake_starboard + sign * PROPELLER.wake_port for sign in (1, -1))
    gain = middle / 2 + half / 2 * angle / (casadi.fabs(angle) + NOTHING)
    grown = 1 + (1 - casadi.exp(-PROPELLER.wake_rate * casadi.fabs(angle))) * (gain - 1)
    w = 1 - (1 - PROPELLER.wake) * grown
    j = u * (1 - w) / (n * PROPELLER.diameter)
    k_t = PROPELLER.thrust_0 + PROPELLER.thrust_1 * j + PROPELLER.thrust_2 * j * j
    thrust = c["X_thrust"] * rho * n * n * PROPELLER.diameter**4 * k_t
    at_rudder = beta - RUDDER.position * rp
    gamma = casadi.if_else(at_rudder > 0, RUDDER.straightening_starboard, RUDDER.straightening_port)
    v_r = whole * gamma * at_rudder
    race = casadi.sqrt(1 + 8 * k_t / (pi * j * j)) - 1
    eta = RUDDER.in_slipstream
    u_r = RUDDER.wake_ratio * u * (1 - w) * casadi.sqrt(eta * (1 + RUDDER.slipstream * race) ** 2 + 1 - eta)
    f_n = (
        0.5
        * rho
        * RUDDER.area
        * RUDDER.lift
        * casadi.sqrt(u_r**2 + v_r**2)
        * (u_r * casadi.sin(delta) - v_r * casadi.cos(delta))
    )
    q = 0.5 * rho * L * d * whole * whole
    fx = q * (-c["R_0"] + c["X_vv"] * vp**2 + c["X_vr"] * vp * rp + c["X_rr"] * rp**2 + c["X_vvvv"] * vp**4)
    sway = ("v", vp), ("r", rp), ("vvv", vp**3), ("vvr", vp**2 * rp), ("vrr", vp * rp**2), ("rrr", rp**3)
    fy = q * sum(c[f"Y_{name}"] * part for name, part in sway)
    fn = q * L * sum(c[f"N_{name}"] * part for name, part in sway)
    fx = fx + thrust - c["X_rudder"] * f_n * casadi.sin(delta) + push[0]
    fy = fy - c["Y_rudder"] * f_n * casadi.cos(delta) + push[1]
    fn = fn + c["N_rudder"] * L * f_n * casadi.cos(delta) + push[2]
    unit = 0.5 * rho * L * L * d
    m, mx, my, jz, xg = SHIP.mass, c["X_mx"] * unit, c["Y_my"] * unit, c["N_jz"] * unit * L * L, SHIP.x_g
    udot = (fx + (m + my) * v * r + xg * m * r * r) / (m + mx)
    right = casadi.vertcat(fy - (m + mx) * u * r, fn - xg * m * u * r)
    mass = casadi.vertcat(casadi.horzcat(m + my, xg * m), casadi.horzcat(xg * m, SHIP.inertia + jz))
    turned = casadi.solve(mass, right)
    ahead = u * cosine - v * sine, u * sine + v * cosine
    return casadi.vertcat(*ahead, -r * sine, r * cosine, udot, turned[0], turned[1], r)


def by_casadi(window: int) -> tuple[np.ndarray, np.ndarray]:
    """The end of a window and its slopes by the classical Runge-Kutta method, differentiated by CasADi."""
    names = {name: casadi.SX.sym(name) for name in FREE}
    start, push, offsets = casadi.SX.sym("z", 6), casadi.SX.sym("p", 3), casadi.SX.sym("o", 2)
    known = {name: casadi.SX(value) for name, value in KVLCC2.coefficients.items()} | names
    z = casadi.vertcat(start[0], start[1], casadi.cos(start[2]), casadi.sin(start[2]), start[3:], start[2])
    for step in range(FIRST[window], FIRST[window + 1]):

        def rate(at: casadi.SX, share: float, step: int = step) -> casadi.SX:
            rudder = (1 - share) * RUDDERS[step] + share * RUDDERS[step + 1] + offsets[0]
            turns = (1 - share) * TURNS[step] + share * TURNS[step + 1] + offsets[1]
            return rates(at, rudder, turns, push, known)

        a = rate(z, 0.0)
        b = rate(z + STEP / 2 * a, 0.5)
        c = rate(z + STEP / 2 * b, 0.5)
        z = z + STEP / 6 * (a + 2 * b + 2 * c + rate(z + STEP * c, 1.0))
        unit = 1.5 - 0.5 * (z[2] ** 2 + z[3] ** 2)
        z = casadi.vertcat(z[0], z[1], z[2] * unit, z[3] * unit, z[4:])
    z = casadi.vertcat(z[0], z[1], z[7], z[4:7])
    inputs = casadi.vertcat(start, push, offsets, *names.values())
    function = casadi.Function("end", [inputs], [z, casadi.jacobian(z, inputs)])
    told = [
        *STARTS[window],
        *PUSHED[window],
        OFFSETS[window],
        TURNS_OFF[window],
        *(KVLCC2.coefficients[name] for name in FREE),
    ]
    end, slopes = function(told)
    return np.array(end).ravel(), np.array(slopes)


@pytest.mark.parametrize("window", range(WINDOWS))
def test_ends_and_slopes_of_windows_are_those_of_casadi(window: int) -> None:
    ours = motion()
    positions = {"rudder": RUDDERS, "revolutions": TURNS}
    states, slopes = ours.sailed(STARTS, PUSHED, FIRST, TIMES, positions, {"rudder": OFFSETS, "revolutions": TURNS_OFF})
    offsets = "rudder_offset", "revolutions_offset"
    assert ours.directions == ("x", "y", "psi", "u", "v", "r", "X", "Y", "N", *offsets, *FREE)
    row = FIRST[window + 1] + window
    end, expected = by_casadi(window)
    np.testing.assert_allclose(states[row], end, rtol=1e-12, atol=1e-13)
    size = np.abs(expected).max(axis=0)
    np.testing.assert_allclose(slopes[row] / size, expected / size, rtol=0, atol=1e-12)
