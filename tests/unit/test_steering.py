"""Controllers and steering gear: limits of angle and rate, a ramp against SciPy, a zigzag's own rules."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import narrows as nw
from narrows.model.tables import HELM
from narrows.model.term import TermKind

COEFFICIENTS = {"a_helm": 5.0, "b_helm": 6.0, "c_helm": 2.9}


def steered(dtc: nw.Model, **gear: float) -> nw.Model:
    """The published model with a rudder as large as the KCS's."""
    configuration = replace(
        dtc.configuration,
        ship=replace(dtc.configuration.ship, flow_straightening=0.5),
        steering=nw.SteeringGear(**gear),
    )
    return nw.Model(configuration, HELM(dtc.terms), {**dtc.coefficients, **COEFFICIENTS})


def test_the_gear_turns_as_fast_as_it_can_and_stops_at_the_order(dtc: nw.Model) -> None:
    model = steered(dtc, limit_deg=35.0, rate_deg=10.0)
    gear = model.configuration.gear

    def turned(rudder: float, order: float) -> float:
        """In one step of half a second."""
        law = nw.ConstantRudder(order)
        return float(nw.simulate(model, rudder=rudder, controller=law, duration=0.5, dt=0.5).rudder[-1])

    assert turned(0.0, 1.0) == pytest.approx(0.5 * gear.rate)
    assert turned(0.0, -1.0) == pytest.approx(-0.5 * gear.rate)
    assert turned(0.1, 0.12) == pytest.approx(0.12)
    assert turned(gear.limit, 2.0) == gear.limit


class Turning:
    """A law whose number is called as one of a gear's own limits is."""

    def __init__(self, turn_rate: xr.DataArray | float) -> None:
        self.turn_rate = turn_rate

    def parameters(self) -> dict[str, xr.DataArray | float]:
        return {"turn_rate": self.turn_rate}

    def memory(self, start: object) -> dict[str, float]:
        return {}

    def orders(self, at: Any) -> tuple[dict[str, Any], dict[str, float]]:
        return {"rudder": at.rudder + at.turn_rate * at.dt}, {}


def test_a_number_of_a_law_may_be_called_a_rate_and_vary_over_a_fleet(dtc: nw.Model) -> None:
    model, rates = steered(dtc), (0.01, -0.02)
    fleet = nw.ensemble(
        model, u=1.0, duration=4.0, dt=0.1, controller=Turning(xr.DataArray([*rates], dims="rate")), workers=1
    )
    for number, rate in enumerate(rates):
        alone = nw.simulate(model, u=1.0, duration=4.0, dt=0.1, controller=Turning(rate))
        assert fleet.r_end.values[number] == pytest.approx(alone.r[-1], rel=1e-9)


def test_unless_given_it_is_the_rules(dtc: nw.Model) -> None:
    """SOLAS II-1/29: from 35 degrees on one side to 30 on the other in 28 s."""
    gear = dtc.configuration.gear
    assert np.degrees(28 * gear.rate) == pytest.approx(35 + 30)
    assert np.degrees(gear.limit) == pytest.approx(35)


def test_a_voyage_under_a_controller_keeps_to_the_gear(dtc: nw.Model) -> None:
    model = steered(dtc, limit_deg=20.0, rate_deg=8.0)
    voyage = nw.simulate(model, y=0.2, duration=8.0, dt=0.05, controller=nw.ConstantRudder(1.0))
    assert np.degrees(np.abs(voyage.rudder)).max() <= 20 + 1e-9
    assert np.degrees(np.abs(np.diff(voyage.rudder) / np.diff(voyage.t))).max() <= 8 + 1e-6
    np.testing.assert_allclose(np.degrees(voyage.rudder[: int(2 / 0.05)]), 8 * voyage.t[: int(2 / 0.05)], atol=1e-9)


def test_an_order_that_is_there_already_changes_nothing(dtc: nw.Model) -> None:
    model = steered(dtc)
    steered_there = nw.simulate(model, y=0.2, rudder=0.1, duration=6.0, controller=nw.ConstantRudder(0.1))
    held = nw.simulate(model, y=0.2, rudder=0.1, duration=6.0)
    np.testing.assert_array_equal(steered_there.y, held.y)


def test_the_rudder_within_a_step_is_a_ramp_for_scipy_too(dtc: nw.Model) -> None:
    """SciPy on the terms themselves with the rudder a function of time."""
    from scipy.integrate import solve_ivp

    model = steered(dtc, limit_deg=35.0, rate_deg=5.0)
    voyage = nw.simulate(model, y=0.1, duration=4.0, dt=0.01, controller=nw.ConstantRudder(3 * np.radians(5.0)))

    def rate(t: float, z: np.ndarray) -> list[float]:
        y, psi, v, r = z
        rudder = np.radians(5.0) * min(t, 3.0)
        still = nw.Motion.at(psi, y=y, u=1.0, v=v, r=r)

        def forces(**more: float) -> np.ndarray:
            found = model.forces(replace(still, **more), rudder)
            return np.array([found["Y"], found["N"]])

        rest = forces()
        mass = np.stack([rest - forces(vdot=1.0), rest - forces(rdot=1.0)], axis=1)
        vdot, rdot = np.linalg.solve(mass, rest)
        return [np.sin(psi) + v * np.cos(psi), r, vdot, rdot]

    found = solve_ivp(rate, (0, 4), [0.1, 0, 0, 0], rtol=1e-10, atol=1e-12, max_step=0.05)
    ends = [voyage.y[-1], voyage.psi[-1], voyage.v[-1], voyage.r[-1]]
    np.testing.assert_allclose(ends, found.y[:, -1], rtol=1e-7, atol=1e-10)


def test_a_zigzag_puts_the_rudder_over_where_the_heading_has_come_as_far(dtc: nw.Model) -> None:
    quiet = nw.Model(
        replace(dtc.configuration, canal=nw.Canal(500.0)), HELM(dtc.terms), {**dtc.coefficients, **COEFFICIENTS}
    )
    quiet = replace(quiet, configuration=replace(quiet.configuration, ship=steered(dtc).configuration.ship))
    quiet = replace(quiet, configuration=replace(quiet.configuration, steering=nw.SteeringGear(35.0, 20.0)))
    ten = np.radians(10)
    voyage = nw.simulate(quiet, duration=60.0, dt=0.02, controller=nw.Zigzag(ten, ten))
    turned = np.flatnonzero(np.diff(np.sign(np.diff(voyage.rudder).round(12))) < 0)
    first = np.argmax(voyage.psi >= ten)
    assert turned.size
    # The rudder goes back in the step after the heading got there.
    assert voyage.rudder[first] == pytest.approx(ten)
    assert voyage.rudder[first + 1] < ten
    assert voyage.rudder.min() == pytest.approx(-ten)
    mirrored = nw.simulate(quiet, duration=60.0, dt=0.02, controller=nw.Zigzag(-ten, ten))
    np.testing.assert_allclose(mirrored.psi, -voyage.psi, atol=1e-9)


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda: nw.SteeringGear(0.0), r"\[steering\] limit_deg = 0.0 must be positive"),
        (lambda: nw.SteeringGear(120.0), "beyond 90 degrees"),
        (lambda: nw.Zigzag(0.0, 0.1), "needs a rudder angle"),
        (lambda: nw.Zigzag(0.1, -0.1), "positive change of heading"),
        (
            lambda: nw.simulate(nw.published("mikkelsen2025_dtc"), controller=nw.ConstantRudder(0.1)),
            "gives orders to rudder, for which this model has no terms",
        ),
        (lambda: nw.ConstantRudder(np.inf), "a rudder held at inf is no order"),
        (lambda: nw.ConstantRudder("0.1"), "a rudder held at '0.1' is no order"),
        (lambda: nw.ConstantRudder(True), "a rudder held at True is no order"),
        (lambda: nw.Zigzag("10", 0.2), "needs a rudder angle"),
        (lambda: nw.PID("1", 1.0, 0.0), "kp = '1' of an autopilot is no finite number"),
        (lambda: nw.Autopilot("0", (1.0, 2.0, 3.0, 4.0)), "an autopilot with '0' steers nothing"),
        (lambda: nw.Autopilot(0.0, (1.0, 2.0, 3.0)), "has four gains"),
        (lambda: nw.Autopilot(0.0, (1.0, 2.0, 3.0, np.nan)), "steers nothing"),
    ],
)
def test_what_cannot_be_is_refused(made, words: str) -> None:
    with pytest.raises(nw.InputError, match=words):
        made()


def test_a_borrowed_rudder_is_the_lenders(dtc: nw.Model) -> None:
    lender = steered(dtc)
    own = nw.borrow_rudder(dtc, lender)
    assert own.coefficients == lender.coefficients
    assert own.covariance is None
    with pytest.raises(nw.InputError, match="already has a rudder"):
        nw.borrow_rudder(own, lender)
    with pytest.raises(nw.InputError, match="lender has no a_helm"):
        nw.borrow_rudder(dtc, dtc)


def test_borrowed_errors_stay_with_their_coefficients(dtc: nw.Model) -> None:
    lender = steered(dtc)
    names = lender.terms.names
    errors = np.diag(np.arange(1.0, len(names) + 1))
    hull = replace(dtc, covariance=np.diag(np.full(len(dtc.terms.names), 7.0)))
    own = nw.borrow_rudder(hull, replace(lender, covariance=errors))
    assert own.covariance is not None
    for place, name in enumerate(own.terms.names):
        rudder = own.terms[name].kind == TermKind.RUDDER
        assert own.covariance[place, place] == (errors[names.index(name), names.index(name)] if rudder else 7.0)


def test_gear_goes_through_files_and_scales(dtc: nw.Model, tmp_path) -> None:
    model = steered(dtc, limit_deg=30.0, rate_deg=20.0)
    nw.save_model(model, tmp_path / "m.toml")
    back = nw.load_model(tmp_path / "m.toml")
    assert back.configuration == model.configuration
    full = nw.scale_model(back, 4 * model.configuration.ship.length).model
    assert full.configuration.gear.rate_deg == pytest.approx(10.0)
    assert full.configuration.gear.limit_deg == 30.0
