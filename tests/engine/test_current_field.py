"""A current across a canal, and one that changes across it: independent integration, limits, and who refuses it."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import equations
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import narrows as nw

LENGTH = 4000.0
ACROSS, SHEAR = ((0.0, -0.1), (2000.0, 0.25), (4000.0, -0.35)), 1.5e-3


def canal(width: float = 300.0, **water: Any) -> nw.Waterway:
    straight = nw.straight_waterway(nw.Canal(width, 16.2), LENGTH)
    return replace(straight, step=4.0).with_water(**water)  # With nodes where the profile bends


def velocity(x: float, y: float) -> np.ndarray:
    """The water at a place, along and to starboard [m/s]."""
    return np.array([0.4 + SHEAR * y, np.interp(x, *np.transpose(ACROSS))])


def gradient(x: float, y: float, step: float = 1e-3) -> np.ndarray:
    """Its derivatives, by differences."""
    ahead = velocity(x + step, y) - velocity(x - step, y)
    aside = velocity(x, y + step) - velocity(x, y - step)
    return np.stack([ahead, aside], axis=1) / (2 * step)


class InWater(equations.Equations):
    """A ship in that water: the mass of the ship meets a change of the water that the displaced water does not."""

    def _rates(self, state: list[float], turning: float) -> list[float]:
        x, y, psi, u, v, r, rudder = state
        hull = np.array([[np.cos(psi), -np.sin(psi)], [np.sin(psi), np.cos(psi)]])  # Columns: ahead, to starboard
        change, through = gradient(x, y), np.array([u, v])
        turn = hull[:, 1] @ change @ hull[:, 0]
        lost = hull.T @ change @ hull @ through + turn * np.array([-v, u])
        size = self.model.configuration.values()
        mass = size["density"] * size["block_coefficient"] * size["length"] * size["beam"] * size["draft"]
        self.forces = (-mass * lost[0], -mass * lost[1], 0.0)
        width, middle, depth, _ = self.place(x)
        values = {
            **self.fixed, "y": y - middle, "cos_psi": np.cos(psi), "sin_psi": np.sin(psi), "u": u, "v": v,
            "r": r - turn, "cos_rudder": np.cos(rudder), "sin_rudder": np.sin(rudder), "width": width, "depth": depth,
        }  # fmt: skip
        over_ground = hull @ through + velocity(x, y)
        return [*over_ground, r, *self.accelerations(values), turning]


@pytest.mark.parametrize("coriolis", [False, True])
def test_a_field_beside_another_integrator(coriolis: bool) -> None:
    """A fleet and a voyage, with the velocity of the water at each place and its derivatives by differences."""
    model = nw.published("estimated_kcs")
    way = canal(current=0.4, current_across=ACROSS, current_shear=SHEAR)
    start = {"x": 1000.0, "y": 12.0, "psi": -0.03, "u": 4.0, "v": 0.05, "r": 2e-4, "rudder": 0.02}
    other = InWater(model, waterway=canal(), coriolis=coriolis)
    state = [start[name] for name in ("x", "y", "psi", "u", "v", "r", "rudder")]
    expected = solve_ivp(
        lambda t, z: other.rates(z, 0.0), (0.0, 80.0), state, method="DOP853", rtol=1e-10, atol=1e-12, max_step=2.0
    ).y[:, -1]
    told = {**start, "waterway": way, "duration": 80.0, "dt": 1.0, "coriolis": coriolis}
    voyage, fleet = nw.simulate(model, **told), nw.ensemble(model, **told)
    assert voyage.outcome.kind == "afloat"
    accuracy = {"x": 1e-3, "y": 1e-3, "psi": 1e-6, "u": 1e-9, "v": 1e-6, "r": 1e-8}
    for place, (name, near) in enumerate(accuracy.items()):
        assert voyage[name][-1] == pytest.approx(expected[place], abs=near)
        if name != "x":
            assert fleet[f"{name}_end"].item() == pytest.approx(expected[place], abs=near)
    uniform = nw.simulate(model, **{**told, "waterway": canal(current=0.4)})
    assert abs(uniform.y[-1] - expected[1]) > 5.0


def test_a_uniform_current_shifts_a_voyage() -> None:
    """Galileo: a turning circle in open water, shifted by the way of the water."""
    model = nw.published("yasukawa2015_kvlcc2")
    own = {"x": 2000.0, "y": 0.0, "u": 1.1, "rudder": 0.3, "duration": 60.0, "dt": 0.5, "contact": "none"}
    own |= {"revolutions": 10.0, "surge": "free"}
    still, carried = (
        nw.simulate(model, waterway=canal(3000.0, **water), **own)
        for water in ({}, {"current": 0.3, "current_across": -0.2, "current_shear": 0.0})
    )
    assert np.ptp(still.psi) > 0.5
    for name in ("psi", "u", "v", "r"):
        np.testing.assert_allclose(carried[name], still[name], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(carried.x, still.x + 0.3 * still.t, atol=1e-9)
    np.testing.assert_allclose(carried.y, still.y - 0.2 * still.t, atol=1e-9)


def test_water_that_turns_as_a_whole_carries_a_ship_round() -> None:
    """A ship that drifts with it turns with it: nothing moves it through the water."""
    turn, radius = 0.02, 30.0
    way = canal(3000.0, current_across=((0.0, -turn * 2000.0), (LENGTH, turn * 2000.0)), current_shear=-turn)
    model = nw.published("mikkelsen2025_dtc")
    voyage = nw.simulate(model, x=2000.0 + radius, y=0.0, u=0.0, r=turn, duration=50.0, dt=0.1, waterway=way)
    for name, expected in (("u", 0.0), ("v", 0.0), ("r", turn)):
        np.testing.assert_allclose(voyage[name], expected, atol=1e-7)
    np.testing.assert_allclose(voyage.x, 2000.0 + radius * np.cos(turn * voyage.t), atol=1e-5)
    np.testing.assert_allclose(voyage.y, radius * np.sin(turn * voyage.t), atol=1e-5)


class ByCurrent:
    """A law that steers by the current along that it reads."""

    def parameters(self) -> dict[str, float]:
        return {}

    def memory(self, start: Any) -> dict[str, float]:
        return {}

    def orders(self, at: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        return {"rudder": 0.01 * at.current}, {}


def test_a_law_reads_the_current_of_its_offset() -> None:
    way = canal(current=0.4, current_shear=SHEAR)
    told = {"y": 20.0, "u": 4.0, "x": 100.0, "duration": 2.0, "dt": 2.0, "waterway": way, "controller": ByCurrent()}
    voyage = nw.simulate(nw.published("estimated_kcs"), **told)
    assert voyage.rudder[-1] == pytest.approx(0.01 * (0.4 + 20.0 * SHEAR), rel=1e-12)


def test_an_estimator_follows_a_current_across_that_it_is_not_told_of() -> None:
    """Its fixes are believed, and the offset from the line is as certain as the estimate has it."""
    model = nw.published("estimated_kcs")
    turning = canal(current_across=[(0.0, 0.0), (900.0, 0.3), (1800.0, -0.3), (LENGTH, 0.0)])
    helm, told = nw.control.regulator(model, 0.0, 4.0), {"x": 150.0, "y": 0.0, "u": 4.0, "duration": 270.0, "dt": 1.0}
    voyage = nw.simulate(model, **told, waterway=turning, controller=helm)
    kinds, random = nw.estimation, np.random.default_rng(3)
    sensors = [kinds.Gnss(), kinds.Gyro(0.0035), kinds.RateOfTurn(5e-4), kinds.Log(), kinds.RudderIndicator()]
    one, off = kinds.Estimator(model, sensors, waterway=canal()), []
    for t, x, y, psi, r, u, rudder in zip(
        *(voyage[name] for name in ("t", "x", "y", "psi", "r", "u", "rudder")), strict=True
    ):
        noise = random.standard_normal(5)
        seen = {"gyro": psi + 0.0035 * noise[2], "rate_of_turn": r + 5e-4 * noise[3], "log": u + 0.05 * noise[4]}
        now = one.update(t, gnss=(x + 1.5 * noise[0], y + 1.5 * noise[1]), rudder=rudder, **seen)
        assert not now.faults
        if t >= 90.0:
            off.append((now["y"] - y) / now.std["y"])
    assert np.mean(np.abs(off) < 1.96) > 0.9


def test_files_and_words_have_the_field(tmp_path: Path, cli: Any) -> None:
    way = replace(canal(current=0.4, current_across=ACROSS, current_shear=SHEAR), origin=(5.0, 52.0))
    nw.write_waterway(way, tmp_path / "way.geojson")
    read = nw.read_waterway(tmp_path / "way.geojson")
    s = np.linspace(0.0, LENGTH, 9)
    np.testing.assert_allclose(read.current_at(s, 10.0), 0.4 + 10.0 * SHEAR, rtol=1e-6)
    np.testing.assert_allclose(np.asarray(read.current_across), ACROSS, rtol=1e-6)
    assert "current across -0.35 to 0.2498 m/s, shear of the current 0.0015 1/s" in read.summary()
    words = ("simulate", "estimated_kcs", "--waterway", tmp_path / "way.geojson", "--y", "10", "--duration", "60")
    whole = cli(*words)[1]
    assert whole != cli(*words, "--current-across", "0.1m/s")[1] != cli(*words, "--current-shear", "0:0,900:0.002")[1]
    assert "goes with --waterway" in cli("simulate", "estimated_kcs", "--current-shear", "0.1")[2]
    assert "give 0.002, or 0:0.001,900:0, without a unit" in cli(*words, "--current-shear", "1kn")[2]


@pytest.mark.parametrize("wrong", [np.array([0.5, 1.0]), "1", [[0, 1], [0, 2]], np.nan, 1e6])
@pytest.mark.parametrize("name", ["current_across", "current_shear"])
def test_a_field_is_numbers_or_pairs(name: str, wrong: Any) -> None:
    with pytest.raises(nw.InputError, match=f"the {name.replace('_', ' ')} .* is invalid"):
        canal(**{name: wrong})


@pytest.mark.parametrize("water", [{"current_across": 0.1}, {"current_shear": [(0.0, 0.0), (900.0, 1e-3)]}])
def test_who_takes_no_field_says_so(water: dict[str, Any], tmp_path: Path) -> None:
    model, way = nw.published("estimated_kcs"), canal(**water)
    sensors = [nw.estimation.Gnss(), nw.estimation.Gyro(), nw.estimation.Log()]
    for refused in (
        lambda: nw.control.linearize(model, y=0.0, u=4.0, waterway=way, at=500.0),
        lambda: nw.control.regulator(model, 0.0, 4.0, waterway=way),
        lambda: nw.control.PredictiveHelm(model, 0.0, 4.0, waterway=way).begin(),
        lambda: nw.estimation.Estimator(model, sensors, waterway=way).filter.lanes,
        lambda: nw.envelope_along(model, way, [500.0, 900.0]),
        lambda: nw.export.write(model, tmp_path / "ship.h", waterway=way),
    ):
        with pytest.raises(nw.InputError, match=r"across or a shear, which .* does not take; give one along the line"):
            refused()
    assert not canal(current=0.4, current_across=0, current_shear=0.0).has_current_field
