"""KVLCC2 after Yasukawa and Yoshimura (2015): the method written out again, SciPy's integrator, and measured trials."""

import importlib
from math import atan, cos, exp, pi, radians, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import narrows as nw

KVLCC2 = nw.published("yasukawa2015_kvlcc2")
SHIP, PROPELLER, RUDDER = KVLCC2.configuration.ship, KVLCC2.configuration.propeller, KVLCC2.configuration.rudder
L, D, RHO = SHIP.length, SHIP.draft, KVLCC2.configuration.water.density
APPROACH = 1.179
X_H, A_H, X_R = -0.464, 0.312, -0.5


def rates(z: np.ndarray, delta: float) -> list[float]:
    """The equations of the paper in its own symbols, with arctan and branches, from its primes."""
    _, _, psi, u, v, r = z
    whole = sqrt(u * u + v * v)
    beta, vp, rp = atan(-v / u), v / whole, r * L / whole
    m = SHIP.mass / (0.5 * RHO * L * L * D)
    angle = beta - PROPELLER.position * rp
    gain = 1.6 if angle > 0 else 1.1
    w = 1 - (1 - 0.40) * (1 + (1 - exp(-2.0 * abs(angle))) * (gain - 1))
    n, d_p = PROPELLER.revolutions, PROPELLER.diameter
    j = u * (1 - w) / (n * d_p)
    k_t = 0.2931 - 0.2753 * j - 0.1385 * j * j
    thrust = (1 - 0.220) * RHO * n * n * d_p**4 * k_t
    at_rudder = beta + 0.710 * rp
    v_r = whole * (0.640 if at_rudder > 0 else 0.395) * at_rudder
    race = 0.626 * (1 + 0.50 * (sqrt(1 + 8 * k_t / (pi * j * j)) - 1)) ** 2 + 1 - 0.626
    u_r = 1.09 * u * (1 - w) * sqrt(race)
    f_n = 0.5 * RHO * RUDDER.area * (u_r**2 + v_r**2) * 2.747 * sin(delta - atan(v_r / u_r))
    q = 0.5 * RHO * L * D * whole * whole
    hull_x = q * (-0.022 - 0.040 * vp**2 + 0.002 * vp * rp + 0.011 * rp**2 + 0.771 * vp**4)
    hull_y = q * (-0.315 * vp + 0.083 * rp - 1.607 * vp**3 + 0.379 * vp**2 * rp - 0.391 * vp * rp**2 + 0.008 * rp**3)
    hull_n = -0.137 * vp - 0.049 * rp - 0.030 * vp**3 - 0.294 * vp**2 * rp + 0.055 * vp * rp**2 - 0.013 * rp**3
    fx = hull_x + thrust - (1 - 0.387) * f_n * sin(delta)
    fy = hull_y - (1 + A_H) * f_n * cos(delta)
    fn = q * L * hull_n - (X_R + A_H * X_H) * L * f_n * cos(delta)
    unit = 0.5 * RHO * L * L * D
    m, mx, my, jz, xg = m * unit, 0.022 * unit, 0.223 * unit, 0.011 * unit * L * L, SHIP.x_g
    inertia = SHIP.mass * ((0.25 * L) ** 2 + xg**2) + jz
    udot = (fx + (m + my) * v * r + xg * m * r * r) / (m + mx)
    mass = np.array([[m + my, xg * m], [xg * m, inertia]])
    vdot, rdot = np.linalg.solve(mass, [fy - (m + mx) * u * r, fn - xg * m * u * r])
    return [u * cos(psi) - v * sin(psi), u * sin(psi) + v * cos(psi), r, udot, vdot, rdot]


@pytest.mark.parametrize("side", [1, -1])
def test_a_turning_circle_is_the_papers_equations(side: int) -> None:
    """Against SciPy on the equations written out again: what differs is the fraction in place of arctan."""
    gear = KVLCC2.configuration.gear
    order = side * radians(35)
    reached = abs(order) / gear.rate
    dt = reached / 40  # so that the ramp ends with a step
    end = 60.0
    voyage = nw.simulate(
        KVLCC2, u=APPROACH, duration=end, dt=dt, surge="free", contact="none", controller=nw.ConstantRudder(order)
    )  # fmt: skip

    def rate(t: float, z: np.ndarray) -> list[float]:
        return rates(z, order * min(t / reached, 1.0))

    start = [0, 0, 0, APPROACH, 0, 0]
    found = solve_ivp(rate, (0, end), start, t_eval=voyage.t, rtol=1e-9, atol=1e-10, max_step=0.2)
    for column, name in zip(found.y, ("x", "y", "psi", "u", "v", "r"), strict=True):
        np.testing.assert_allclose(getattr(voyage, name), column, rtol=5e-4, atol=5e-4, err_msg=name)


class TestMeasured:
    """Free-running tests of MARIN for SIMMAN 2008; errors are in docs/manoeuvres.md, and no closer than they are."""

    @pytest.fixture
    def measured(self, monkeypatch: pytest.MonkeyPatch):
        monkeypatch.syspath_prepend(Path(__file__).parents[2] / "decisions")
        return importlib.import_module("manoeuvres")

    def test_circles_within_a_tenth(self, measured) -> None:
        found = nw.sail_trials(KVLCC2, APPROACH, zigzags=()).to_dict()["turning"]
        for order, (advance, transfer, diameter) in measured.CIRCLES.items():
            assert found[order]["transfer_over_length"] == pytest.approx(transfer, rel=0.16)
            assert found[order]["advance_over_length"] == pytest.approx(advance, rel=0.10)
            assert found[order]["tactical_diameter_over_length"] == pytest.approx(diameter, rel=0.10)

    def test_which_side_overshoots_more(self, measured) -> None:
        """Port first overshoots more at first, starboard first more in the second turn, in test and model."""
        found = {
            order: own["overshoots_deg"] for order, own in nw.sail_trials(KVLCC2, APPROACH).to_dict()["zigzags"].items()
        }
        for size in ("10/10", "20/20"):
            for own in (found, measured.OVERSHOOTS):
                np.testing.assert_allclose(own[f"+{size}"][:2], measured.OVERSHOOTS[f"+{size}"], atol=7.6)
                np.testing.assert_allclose(own[f"-{size}"][:2], measured.OVERSHOOTS[f"-{size}"], atol=5.9)
                assert own[f"-{size}"][0] > own[f"+{size}"][0]
                assert own[f"+{size}"][1] > own[f"-{size}"][1]


def test_the_file_says_where_it_is_from() -> None:
    assert "Yasukawa" in KVLCC2.source.text
    assert "transcriptions" in KVLCC2.source.text


def test_what_the_table_needs_and_is_not_there_is_said() -> None:
    from dataclasses import replace

    without = replace(KVLCC2, configuration=replace(KVLCC2.configuration, propeller=None))
    with pytest.raises(nw.InputError, match="need a propeller"):
        nw.simulate(without, u=APPROACH, contact="none")
    without = replace(KVLCC2, configuration=replace(KVLCC2.configuration, rudder=None))
    with pytest.raises(nw.InputError, match="need rudder_"):
        nw.simulate(without, u=APPROACH, contact="none")
