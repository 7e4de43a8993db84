"""A governor of the speed against its plan and kinematics; gains along the way against those made at each place."""

import numpy as np
import pytest
import xarray as xr
from cases import steered, waterway_for

import narrows as nw
from narrows.control import SpeedGovernor, regulator, speed_governor
from narrows.control.speed_governor import planned_speed

KVLCC2 = nw.published("yasukawa2015_kvlcc2")
LIMITS = [(0.0, 1.0), (60.0, 0.7), (110.0, 0.85)]


@pytest.fixture(scope="module")
def governor() -> SpeedGovernor:
    return speed_governor(KVLCC2, regulator(KVLCC2, 0.0, 0.8), LIMITS, deceleration=0.005)


@pytest.fixture(scope="module")
def voyage(governor: SpeedGovernor) -> nw.Voyage:
    start = {"revolutions": governor.revolutions[0], "surge": "free", "contact": "none"}
    return nw.simulate(KVLCC2, 0.5, 1.0, 240.0, 0.2, controller=governor, **start)


def test_the_speed_keeps_to_the_plan(governor: SpeedGovernor, voyage: nw.Voyage) -> None:
    plan, _ = planned_speed(voyage.x, governor.x, governor.u, governor.rate)
    assert np.abs(voyage.u - plan).max() < 0.02
    assert voyage.u[np.searchsorted(voyage.x, 60.0)] < 0.72
    assert voyage.u[-1] == pytest.approx(0.85, abs=0.005)
    assert abs(voyage.y[-1]) < 0.05


def test_revolutions_are_a_column_of_the_voyage(governor: SpeedGovernor, voyage: nw.Voyage) -> None:
    data = voyage.dataset()
    assert data.revolutions.attrs["units"] == "1/s"
    np.testing.assert_array_equal(voyage["revolutions"], data.revolutions)
    assert voyage["revolutions"][-1] == pytest.approx(nw.control.self_propulsion(KVLCC2, 0.85), rel=0.02)
    assert voyage["revolutions"].min() >= 0


def test_the_plan_is_the_fastest_that_keeps_limits_and_rate() -> None:
    places, speeds = zip(*LIMITS, strict=True)
    x = np.linspace(-20, 180, 2001)
    u, change = planned_speed(x, places, speeds, 0.01)
    most = np.select([x < 60, x < 110], [1.0, 0.7], 0.85)
    assert (u <= most + 1e-12).all()
    rate = np.gradient(u**2 / 2, x)
    assert np.abs(rate).max() <= 0.01 + 1e-9
    slowing = (x > 10) & (u < most - 1e-6)
    assert np.median(np.abs(rate[slowing])) == pytest.approx(0.01, rel=1e-6)
    np.testing.assert_allclose(np.median(change - rate), 0.0, atol=1e-9)
    assert set(np.unique(change)) == {-0.01, 0.0, 0.01}


def test_a_fleet_sails_as_one_ship_does(governor: SpeedGovernor, voyage: nw.Voyage) -> None:
    y = xr.DataArray([0.5, -0.5], dims="start")
    fleet = nw.ensemble(
        KVLCC2, y=y, u=1.0, duration=60.0, dt=0.2, controller=governor, revolutions=governor.revolutions[0],
        surge="free", contact="none",
    )  # fmt: skip
    after = np.searchsorted(voyage.t, 60.0 - 1e-9)
    assert float(fleet.u_end[0]) == pytest.approx(voyage.u[after], rel=1e-9)
    assert float(fleet.y_end[0]) == pytest.approx(voyage.y[after], abs=1e-9)


def test_an_engine_at_its_limit_winds_nothing_up(governor: SpeedGovernor) -> None:
    """Asked for more than the engine gives, then for less: it is there as soon as one that was never asked."""
    limits = [(0.0, 1.1), (60.0, 0.7)]
    fast = speed_governor(KVLCC2, governor.helm, limits, deceleration=0.005, most_revolutions=9.0)
    start = {"surge": "free", "contact": "none", "revolutions": 9.0}
    voyage = nw.simulate(KVLCC2, 0.0, 0.8, 200.0, 0.2, controller=fast, **start)
    assert voyage["revolutions"].max() == 9.0
    slowed = voyage.x > 90.0
    np.testing.assert_allclose(voyage.u[slowed], 0.7, atol=0.01)


@pytest.mark.parametrize(
    ("limits", "more", "word"),
    [
        ([(0.0, 1.0), (0.0, 0.7)], {}, "rise"),
        ([(0.0, -1.0)], {}, "over 0"),
        ([(0.0, 1.0, 2.0)], {}, "pairs"),
        (7.0, {}, "pairs"),
        ([(0.0, 1.0)], {"deceleration": 0.0}, "deceleration"),
        ([(0.0, 1.0), (60.0, 0.7)], {"deceleration": 0.05}, "propeller stopped"),
    ],
)
def test_what_is_no_plan_is_refused(governor: SpeedGovernor, limits, more, word: str) -> None:
    with pytest.raises(nw.InputError, match=word):
        speed_governor(KVLCC2, governor.helm, limits, **more)


def test_a_helm_of_python_is_refused() -> None:
    with pytest.raises(nw.InputError, match="law in arithmetic"):
        SpeedGovernor(lambda t, state: 0.0, (0.0, 1.0), (1.0, 1.0), (9.0, 9.0), 0.01, 1.0, 1.0, 1.0, 9.0)


def test_gains_along_the_way_are_those_of_each_place() -> None:
    model, waterway = steered(), waterway_for("steered")
    places = (0.0, waterway.line.length / 2)
    scheduled = regulator(model, 0.0, 1.0, waterway=waterway, at=places)
    assert scheduled.along
    for place, line in zip(places, scheduled.lines, strict=True):
        alone = regulator(model, 0.0, 1.0, waterway=waterway, at=place).lines[0]
        assert line.start == place
        np.testing.assert_allclose(line.gains, alone.gains)
    with pytest.raises(nw.InputError, match="give one of the two"):
        regulator(model, [(0.0, 0.0), (5.0, 0.1)], 1.0, waterway=waterway, at=places)
