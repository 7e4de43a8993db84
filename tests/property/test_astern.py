"""A propeller astern brakes the ship by the thrust of a published series, and is refused where none is known."""

import importlib.util
import runpy
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import narrows as nw
from narrows.model.data_range import DataRange
from narrows.physics.hull import drift
from narrows.simulation.manoeuvring_trials import StoppingTest

TANKER = nw.published("yasukawa2015_kvlcc2_full")
SERIES = Path(__file__).parents[2] / "decisions/propeller_series.csv"


def ahead_only() -> nw.Model:
    """The 7 m model of KVLCC2, without the thrust astern."""
    model = nw.published("yasukawa2015_kvlcc2")
    propeller = replace(model.configuration.propeller, astern_0=0.0, astern_1=0.0, astern_2=0.0)
    return replace(model, configuration=model.configuration.with_parts([propeller]))


KVLCC2 = ahead_only()
FREE = {"u": 1.0, "surge": "free", "contact": "none", "duration": 5.0, "dt": 0.1}


class Astern:
    """A law that orders full astern."""

    def parameters(self) -> dict[str, float]:
        return {"n": -5.0}

    def memory(self, start: Any) -> dict[str, Any]:
        return {}

    def orders(self, at: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        return {"revolutions": at.n}, {}


DOORS = {
    "a voyage": lambda: nw.simulate(KVLCC2, revolutions=-1.0, **FREE),
    "a law": lambda: nw.simulate(KVLCC2, revolutions=1.0, controller=Astern(), **FREE),
    "a fleet": lambda: nw.ensemble(KVLCC2, revolutions=[1.0, -1.0], **FREE),
    "forces": lambda: KVLCC2.forces(u=1.0, revolutions=-1.0),
    "columns of forces": lambda: KVLCC2.forces(u=np.ones(2), revolutions=np.array([1.0, -1.0])),
    "rates": lambda: nw.derivative(KVLCC2, {"u": 1.0}, revolutions=-1.0),
    "slopes": lambda: nw.sensitivities(KVLCC2, ["u"], revolutions=-1.0, **FREE),
    "a linear system": lambda: nw.control.linearize(KVLCC2, 0.0, 1.0, revolutions=-1.0),
    "a steady course": lambda: nw.steady_course(KVLCC2, u=1.0, revolutions=-1.0),
    "a regulator": lambda: nw.control.regulator(KVLCC2, 0.0, 1.0, revolutions=-1.0),
    "a predictive helm": lambda: nw.control.PredictiveHelm(KVLCC2, 0.0, 1.0, revolutions=-1.0).begin(),
}


@pytest.mark.parametrize("door", DOORS)
def test_revolutions_astern_are_refused(door: str) -> None:
    with pytest.raises(nw.InputError, match="known ahead only"):
        DOORS[door]()


def test_a_fleet_under_a_law_takes_them_for_a_stopped_propeller() -> None:
    fleet = nw.ensemble(KVLCC2, revolutions=0.0, controller=Astern(), **FREE)
    stopped = nw.simulate(KVLCC2, revolutions=0.0, **FREE)
    assert fleet["u_end"].item() == pytest.approx(stopped.u[-1], abs=1e-9)


def test_an_exported_file_takes_them_for_a_stopped_propeller(tmp_path: Path) -> None:
    nw.export.write(KVLCC2, tmp_path / "ship.py", surge="free", contact="none")
    spec = importlib.util.spec_from_file_location("astern_ship", tmp_path / "ship.py")
    ship = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(ship)
    constants, state, rates = ship.prepare(ship.MODEL), ship.rest(), []
    state[ship.U] = 1.0
    for turns in (-1.0, 0.0):
        inputs = ship.AT_REST
        inputs.revolutions = turns
        rates.append(ship.rates(state, inputs, constants))
    np.testing.assert_array_equal(*rates)


def series_thrust(advance: np.ndarray, pitch: str) -> np.ndarray:
    """K_T of the B4-70 series at revolutions astern, from its Fourier series over the advance angle."""
    table = pd.read_csv(SERIES, index_col="k")
    angle = np.arctan2(-advance, -0.7 * np.pi)
    waves = np.multiply.outer(table.index, angle)
    cosines, sines = (
        table[f"{part}_{pitch}"].to_numpy() @ wave(waves) for part, wave in (("A", np.cos), ("B", np.sin))
    )
    return np.pi / 8 * (advance**2 + (0.7 * np.pi) ** 2) * (cosines + sines) / 100


@pytest.mark.parametrize(("ahead", "pitch"), [(0.2421, "0.6"), (0.3461, "0.8"), (0.4499, "1.0"), (0.5193, "1.2")])
@pytest.mark.parametrize("square", [0.0, -0.1385])
def test_thrust_astern_is_that_of_the_series(ahead: float, pitch: str, square: float) -> None:
    """Roddy, Hess and Faller (2006)."""
    fitted = nw.with_astern_thrust(nw.Propeller(1.0, 0.0, 0.0, ahead, -0.4, square))
    advance = -np.linspace(0.0, 1.5, 16)
    rise = np.sqrt(advance**2 + 0.49)
    thrust = fitted.astern_0 + fitted.astern_1 * advance + fitted.astern_2 * rise + square * advance**2
    np.testing.assert_allclose(thrust, series_thrust(advance, pitch), atol=0.062)


def test_the_published_tanker_has_the_thrust_of_the_series() -> None:
    for name in ("yasukawa2015_kvlcc2", "yasukawa2015_kvlcc2_full"):
        propeller = nw.published(name).configuration.propeller
        assert nw.with_astern_thrust(propeller) == propeller


def test_a_ship_brakes_the_more_the_more_its_propeller_turns_astern() -> None:
    told = {"u": 4.0, "surge": "free", "contact": "none", "duration": 120.0, "dt": 1.0}
    voyages = [nw.simulate(TANKER, revolutions=turns, **told) for turns in (0.0, -1e-6, -0.5, -1.0, -1.5)]
    speeds = np.array([voyage.u[-1] for voyage in voyages])
    assert speeds[0] == pytest.approx(3.60, abs=0.01)
    assert speeds[1] == pytest.approx(speeds[0], abs=1e-5)
    assert (np.diff(speeds[1:]) < 0).all()
    fleet = nw.ensemble(TANKER, revolutions=[0.0, -1.0], **told)
    np.testing.assert_allclose(fleet["u_end"], speeds[[0, 3]], rtol=1e-9)


def test_a_crash_stop_is_that_of_an_independent_integration() -> None:
    """Surge alone, for a ship that stays straight: SciPy, with the forces of the model at each moment."""
    found = nw.crash_stop(TANKER, speed=6.0, revolutions=-1.0, delay=10.0, reversal=60.0)
    model, begun = TANKER.in_open_water(), nw.self_propulsion(TANKER, 6.0)
    mass = TANKER.surge_inertia

    def rates(t: float, state: np.ndarray) -> list[float]:
        turns = begun + np.clip((t - 10.0) / 60.0, 0.0, 1.0) * (-1.0 - begun)
        return [state[1], model.forces(u=state[1], revolutions=turns)["X"] / mass]

    def still(t: float, state: np.ndarray) -> float:
        return state[1]

    still.terminal = True
    stop = solve_ivp(rates, (0.0, 3000.0), [0.0, 6.0], events=still, rtol=1e-8, max_step=5.0)
    assert found.time == pytest.approx(stop.t[-1], rel=2e-3)
    assert found.head_reach == pytest.approx(stop.y[0, -1], rel=2e-3)
    assert found.track_reach == pytest.approx(found.head_reach, rel=1e-6)


ORDERS = {"revolutions": -1.0, "delay": 10.0, "reversal": 60.0}


@cache
def stopped() -> StoppingTest:
    return nw.crash_stop(TANKER, **ORDERS)


def test_a_tanker_stops_as_tankers_do() -> None:
    """10 to 15 lengths from sea speed for supertankers (Journal of Navigation, reverse stopping ability), IMO: 15."""
    found = stopped()
    assert 10.0 < found.to_dict()["track_reach_over_length"] < 15.0
    assert "IMO allows 15 L" in found.summary()
    slower = nw.crash_stop(TANKER, revolutions=-1.0, delay=60.0, reversal=120.0)
    assert found.track_reach < slower.track_reach


def esso_osaka(advance: float, turns: float) -> tuple[float, float]:
    """Y_P and N_P of the tanker of 320 m astern by A_1 to A_5 and B_1 to B_5, as two programs of Osaka University."""
    length, draft, diameter = 320.0, 20.8, 9.86
    if advance < -0.35:
        sway, yaw = -4.93e-3 - 5.87e-3 * advance, 1.96e-3 + 2.33e-3 * advance
    elif advance <= -0.06:
        sway, yaw = -7.9e-5 + 7.99e-3 * advance, 3.5e-5 - 3.17e-3 * advance
    else:
        sway, yaw = -5.58e-4, 2.25e-4
    scale = 0.5 * 1025.0 * length * draft * (turns * diameter) ** 2
    return scale * sway, scale * length * yaw


@pytest.mark.parametrize("advance", [-1.2, -0.36, -0.34, -0.1, -0.05, 0.0, 0.5])
@pytest.mark.parametrize("share", [1.0, -0.5])
def test_transverse_thrust_is_that_of_the_esso_osaka(advance: float, share: float) -> None:
    turns = -1.25
    motion = {"u": advance * turns * 9.86 or 1e-9, "revolutions": turns}
    before, after = TANKER.forces(**motion), nw.with_transverse_thrust(TANKER, share).forces(**motion)
    sway, yaw = (after[force] - before[force] for force in ("Y", "N"))
    expected = esso_osaka(advance, turns)
    assert sway == pytest.approx(share * expected[0], rel=2e-3)
    assert yaw == pytest.approx(share * expected[1], rel=0.012)
    ahead = {"u": 4.0, "revolutions": 1.0}
    assert nw.with_transverse_thrust(TANKER).forces(**ahead) == TANKER.forces(**ahead)


def test_a_right_handed_propeller_astern_turns_the_bow_to_starboard() -> None:
    right, left = (nw.crash_stop(nw.with_transverse_thrust(TANKER, share), **ORDERS) for share in (1.0, -1.0))
    assert right.voyage.psi[-1] > 0 > left.voyage.psi[-1]
    assert right.side_reach > 0 > left.side_reach
    assert np.abs(right.voyage.v).max() < 1.0  # Also where the ship lies still while it drifts
    assert "transverse thrust" not in " ".join(right.notes)
    assert "nw.with_transverse_thrust" in " ".join(stopped().notes)


@pytest.mark.parametrize(("degrees", "error"), [(20.0, 1e-10), (45.0, 2e-7), (80.0, 1e-4), (89.999, 4e-4)])
def test_the_drift_angle_is_the_arctangent(degrees: float, error: float) -> None:
    angle = np.radians(degrees)
    for side in (1.0, -1.0):
        assert drift(np.cos(angle), -side * np.sin(angle)) == pytest.approx(side * angle, abs=error)
        assert drift(-np.cos(angle), -side * np.sin(angle)) == pytest.approx(-side * angle, abs=error)


def test_transverse_thrust_needs_a_propeller_and_counts_once() -> None:
    with pytest.raises(nw.InputError, match="no propeller"):
        nw.with_transverse_thrust(nw.published("mikkelsen2025_dtc"))
    with pytest.raises(nw.InputError, match="leave \\+transverse_thrust out"):
        nw.with_transverse_thrust(nw.with_transverse_thrust(TANKER))


def test_resistance_brakes_a_ship_that_goes_astern() -> None:
    """It balances the thrust in the end, and is that ahead reversed."""
    backed = nw.simulate(TANKER, u=1.0, surge="free", contact="none", revolutions=-1.0, duration=6000.0, dt=2.0)
    assert backed.u[-1] < -5.0
    assert abs(backed.u[-1] - backed.u[-100]) < 0.01
    resistance = TANKER.terms["R_0"]
    values = {**TANKER.configuration.values(), "v": 0.3}
    astern, ahead = (resistance.column({**values, "u": u}) for u in (-2.0, 2.0))
    assert astern == pytest.approx(-ahead, rel=1e-12)
    assert ahead == pytest.approx(-0.5 * 1025.0 * 320.0 * 20.8 * (2.0**2 + 0.3**2), rel=1e-8)


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"revolutions": 1.0}, "below 0"),
        ({"delay": -1.0}, "from 0 s"),
        ({"revolutions": -0.01}, "the ship makes"),
    ],
)
def test_a_test_that_stops_no_ship_is_refused(told: dict[str, float], words: str) -> None:
    with pytest.raises(nw.InputError, match=words):
        nw.crash_stop(TANKER, **told)


def test_a_ship_without_thrust_astern_or_propeller_makes_no_crash_stop() -> None:
    with pytest.raises(nw.InputError, match="known ahead only"):
        nw.crash_stop(nw.published("son1982_s175"))
    with pytest.raises(nw.InputError, match="needs terms of a propeller"):
        nw.crash_stop(nw.published("mikkelsen2025_dtc"))


def test_way_astern_is_noted_of_voyages_and_fleets() -> None:
    """Banks and rudder of the published DTC are known ahead; a ship that comes to go astern is noted from there."""
    model, told = nw.published("mikkelsen2025_dtc"), {"y": 0.2, "duration": 2.0, "dt": 0.1}
    words = "way astern of -1 m/s is outside the data (ahead alone)"
    assert words in nw.simulate(model, u=-1.0, **told).summary()
    assert "astern" not in nw.simulate(model, u=1.0, **told).summary()
    fleet = nw.ensemble(model, u=[1.0, -1.0], **told)
    assert "50.0% of these voyages begin or end with a way astern outside the data (ahead alone)." in fleet.notes
    tested = replace(model, data_range=DataRange(speed=(0.5, 1.0)))
    assert "way astern of -1 m/s is outside the data (0.5 to 1 m/s)" in nw.simulate(tested, u=-1.0, **told).summary()
    backed = nw.simulate(KVLCC2, u=0.1, surge="free", contact="none", X=-2000.0, duration=20.0, dt=0.1)
    assert backed.u[-1] < 0
    assert "astern" in " ".join(backed.notes)


def test_way_astern_is_noted_at_the_other_doors(tmp_path: Path) -> None:
    """Or refused: steady courses, envelopes and helms are those of a ship ahead."""
    model = nw.published("mikkelsen2025_dtc")
    words = "Beyond the data: way astern -1 m/s; they covered ahead alone."
    force = nw.bank_force(model, 0.5, -1.0)
    assert (words in force.notes, int(force.beyond) & 1) == (True, 1)
    assert words in nw.stability(model, u=-1.0).notes
    assert "astern" not in nw.stability(model, u=1.0).notes
    nw.export.write(model, tmp_path / "ship.py")
    ship = runpy.run_path(str(tmp_path / "ship.py"))
    state, constants = ship["rest"](), ship["prepare"](ship["MODEL"])
    for speed, bit in ((-1.0, 1), (1.0, 0)):
        state[ship["U"]] = speed
        assert int(ship["beyond"](state, constants)) == bit
    kcs = nw.published("estimated_kcs")
    for refused in (nw.steady_course, lambda one, u: nw.safe_envelope(one, u=np.array([u]))):
        with pytest.raises(nw.InputError, match="over 0"):
            refused(kcs, u=-1.0)
