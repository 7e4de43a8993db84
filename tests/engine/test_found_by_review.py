"""What reviewing found wrong in the engines that were: each a voyage or a fleet whose answer can be told otherwise."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from cases import mmg, paper, steered
from equations import Equations
from public import kinds

import narrows as nw
from narrows.waterway.map_lines import projected

OUTLINE = ((2.0, 0.0), (1.4, 0.286), (-2.0, 0.286), (-2.0, -0.286), (1.4, -0.286))
TEN = math.radians(10)


def quiet() -> nw.Model:
    """A steered ship between banks that are far."""
    return replace(steered(), configuration=replace(steered().configuration, canal=nw.Canal(500.0)))


def uncertain() -> nw.Model:
    """The published model with coefficients known to a thousandth."""
    values = np.array([paper().coefficients[name] for name in paper().terms.names])
    return replace(paper(), covariance=np.diag((1e-3 * values) ** 2))


# 1. A controller keeps its memory where a push from outside changes.


@pytest.mark.parametrize("axis", ["X", "Y", "N"])
def test_a_push_that_does_not_change_leaves_a_zigzag_alone(axis: str) -> None:
    told = {"duration": 90.0, "dt": 0.05, "controller": nw.Zigzag(TEN, TEN)}
    plain = nw.simulate(quiet(), **told)
    pushed = nw.simulate(quiet(), **told, **{axis: [(0.0, 0.0), (30.0, 0.0), (60.0, 0.0)]})
    assert np.ptp(plain.psi) > TEN, "it does zigzag"
    np.testing.assert_allclose(pushed.psi, plain.psi, atol=1e-9)


# 2. Eigenvalues are those of the ship as it is, with its rudder and its propeller.


def by_differences(
    model: nw.Model, u: float, rudder: float, felt: tuple[int, ...], v: float = 0.0, r: float = 0.0
) -> np.ndarray:
    """Eigenvalues of the reference's equations, the most unstable first."""
    own, step = Equations(model), 1e-6
    state = np.array([0.0, 0.2, 0.0, u, v, r, rudder])

    def slope(k: int) -> np.ndarray:
        ahead, behind = (np.array(own.rates(state + sign * step * np.eye(7)[k], 0.0)) for sign in (1, -1))
        return (ahead - behind)[list(felt)] / (2 * step)

    found = np.linalg.eigvals(np.stack([slope(k) for k in felt], axis=1))
    return found[np.argsort(-found.real, kind="stable")]


@pytest.mark.parametrize("bank", [True, False])
@pytest.mark.parametrize(("rudder", "revolutions"), [(0.0, 10.32), (0.2, 10.32), (0.1, 7.0)])
def test_eigenvalues_feel_rudder_and_propeller(bank: bool, rudder: float, revolutions: float) -> None:
    propeller = replace(mmg().configuration.propeller, revolutions=revolutions)
    turning = replace(mmg(), configuration=replace(mmg().configuration, propeller=propeller))
    # In a drift, for wake and flow over the rudder have a kink where there is none.
    expected = by_differences(turning, 1.0, rudder, (1, 2, 4, 5) if bank else (4, 5), 0.03, 0.01)
    told = {"u": 1.0, "y": 0.2, "v": 0.03, "r": 0.01, "rudder": rudder, "revolutions": revolutions}
    np.testing.assert_allclose(nw.stability(mmg(), bank, **told).eigenvalue.values.ravel(), expected, atol=1e-6)
    found = nw.stability(mmg(), bank, **{**told, "rudder": [0.0, rudder + 0.01, rudder]})
    assert found["growth"].to_numpy()[-1] == pytest.approx(expected.real.max(), abs=1e-6)


def test_eigenvalues_take_the_revolutions_of_the_ship() -> None:
    """KVLCC2 in open water: +0.00471 at 10.32 revolutions a second, not the +0.02165 of a propeller that stands."""
    model = nw.published("yasukawa2015_kvlcc2")
    found = float(nw.stability(model, bank=False, u=1.179)["growth"].item())
    assert found == pytest.approx(by_differences(model, 1.179, 0.0, (4, 5)).real.max(), abs=1e-6)
    assert found == pytest.approx(0.00471, abs=5e-6)


# 3. Time is up when it is.


@pytest.mark.parametrize(("duration", "dt"), [(11.5, 0.9), (1.0, 30.0), (1.0, 0.3), (10.0, 0.1)])
def test_a_fleet_ends_exactly_when_time_is_up(duration: float, dt: float) -> None:
    ended = nw.ensemble(paper(), y=[0.0, 0.01], duration=duration, dt=dt)
    assert kinds(ended) == ["afloat", "afloat"]
    assert ended["time"].to_numpy().tolist() == [duration, duration]
    alone = nw.simulate(paper(), y=0.01, duration=duration, dt=dt)
    assert alone.outcome.time == duration
    assert float(ended["y_end"][1]) == pytest.approx(alone.y[-1], abs=1e-9)


# 4. The paper's clearance is a contact like the others.


@pytest.mark.parametrize("y", [0.5, -1.0, 2.0])
@pytest.mark.parametrize("dt", [0.02, 0.1, 0.5])
def test_the_midship_clearance_grounds(y: float, dt: float) -> None:
    alone = nw.simulate(paper(), y=y, dt=dt, contact="midship").outcome
    ended = nw.ensemble(paper(), y=[y], dt=dt, contact="midship")
    assert alone.kind == "grounded"
    assert kinds(ended) == ["grounded"]
    assert alone.time == pytest.approx(float(ended["time"][0]), abs=1e-6)


# 5. Banks are where they are, however few points draw them.


def meander() -> dict[str, np.ndarray]:
    """A line that meanders by 60 m between two straight banks, in metres."""
    north = np.linspace(-3000, 3000, 121)
    east = 60 * np.sin(2 * np.pi * north / 1500)
    ends = np.array([-3100.0, 3100.0])
    bank = {"starboard": np.full(2, 200.0), "port": np.full(2, -200.0)}
    return {"centreline": np.stack([east, north], axis=1)} | {
        role: np.stack([value, ends], axis=1) for role, value in bank.items()
    }


@pytest.mark.parametrize("side", ["starboard", "port"])
def test_a_bank_of_two_points_is_straight(side: str, tmp_path: Path) -> None:
    """A bank 200 m off a meandering line was read as 129 to 254 m off."""
    degrees = {role: np.array([5.0, 52.0]) + points / [68_700.0, 111_300.0] for role, points in meander().items()}
    features = [
        {"type": "Feature", "properties": {"role": role},
         "geometry": {"type": "LineString", "coordinates": points.tolist()}}
        for role, points in degrees.items()
    ]  # fmt: skip
    path = tmp_path / "meander.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    way = nw.read_waterway(path)
    first, last = projected(degrees[side], np.mean(degrees["centreline"], axis=0))
    along = (last - first) / np.linalg.norm(last - first)
    s = np.linspace(0.0, way.line.length, 500)
    bank = way.line.at(s, way.starboard.at(s) if side == "starboard" else -way.port.at(s))
    off = (bank - first) @ np.array([along[1], -along[0]])
    assert np.abs(off).max() < 0.1


# 6. A waterway has two ends.


@pytest.mark.parametrize(("current", "word", "x"), [(-1.6, "beginning", 0.0), (0.5, "end", 60.0)])
def test_a_ship_leaves_a_waterway_by_either_end(current: float, word: str, x: float) -> None:
    way = nw.straight_waterway(paper().configuration.canal, 60.0).with_water(current=current)
    start = {"x": 10.0, "y": 0.0, "u": 1.0, "duration": 200.0, "waterway": way}
    alone, ended = nw.simulate(paper(), **start), nw.ensemble(paper(), **start)
    assert alone.outcome.kind == "left the waterway"
    assert word in alone.outcome.sentence
    assert alone.x[-1] == pytest.approx(x, abs=1e-6)
    assert kinds(ended) == ["left the waterway"]
    assert float(ended["time"].squeeze()) == pytest.approx(alone.outcome.time, abs=1e-9)


# 7. What nobody sailed far enough to know is not known.


def test_a_probability_is_not_known_where_time_ran_out() -> None:
    """P(ground within 40 m) was 0.0 with 15 s and 1.0 with 100 s."""
    short, long = (nw.ensemble(uncertain(), y=[0.02], samples=20, duration=own) for own in (15.0, 100.0))
    assert kinds(short) == ["afloat"] * 20
    assert np.isnan(nw.grounding_probability(short, 40.0)).all()
    assert float(nw.grounding_probability(long, 40.0).squeeze()) == 1.0


def test_a_probability_is_known_where_every_ship_got_past() -> None:
    ended = nw.ensemble(uncertain(), y=[0.02], samples=20, duration=15.0)
    assert float(nw.grounding_probability(ended, 10.0).squeeze()) == 0.0


def test_a_probability_is_not_known_where_voyages_diverged() -> None:
    # A ship that is pushed ahead faster and faster.
    ended = nw.ensemble(uncertain(), y=[0.0], samples=3, duration=900.0, dt=0.5, surge="free", surge_inertia=1.0, X=1e9)
    assert kinds(ended) == ["diverged"] * 3
    assert np.isnan(nw.grounding_probability(ended, 1e9)).all()


# 8. Open water is open water.


def test_a_fleet_that_feels_banks_is_not_in_open_water() -> None:
    for sail in (nw.simulate, nw.ensemble):
        with pytest.raises(nw.InputError, match="have a bank"):
            sail(paper(), y=0.5, contact="none")


def test_no_heading_is_across_in_open_water() -> None:
    told = {"duration": 60.0, "dt": 0.05, "contact": "none", "rudder": 0.4, "y": 0.5}
    model = steered().in_open_water()
    alone, ended = nw.simulate(model, **told), nw.ensemble(model, **told)
    assert abs(alone.psi[-1]) > math.radians(120)
    assert kinds(ended) == [alone.outcome.kind] == ["afloat"]
    assert float(ended["y_end"].squeeze()) == pytest.approx(alone.y[-1], abs=1e-9)


def test_no_wall_stands_in_open_water() -> None:
    told = {"duration": 60.0, "dt": 0.05, "contact": "none", "psi": 0.3, "y": 0.5}
    alone, ended = (sail(paper().in_open_water(), **told) for sail in (nw.simulate, nw.ensemble))
    assert abs(alone.y[-1]) > paper().configuration.canal.width
    assert kinds(ended) == [alone.outcome.kind] == ["afloat"]


# 9. A fleet's ships are checked as ships are.


@pytest.mark.parametrize(
    "changed",
    [
        {"beam": -0.5}, {"beam": [0.5, -0.5]}, {"density": -1000.0}, {"depth": 0.1}, {"draft": 0.0}, {"length": -4.0},
        {"block_coefficient": 1.4}, {"width": -7.0}, {"depth": [1.0, 0.16]}, {"draft": math.inf}, {"y": math.nan},
        {"b_vdot": -math.inf}, {"depth": 0.2, "draft": 0.3},
    ],
    ids=str,
)  # fmt: skip
def test_a_fleet_of_ships_that_cannot_be_is_refused(changed: dict[str, Any]) -> None:
    with pytest.raises(nw.InputError):
        nw.ensemble(paper(), duration=1.0, **{"y": 0.1, **changed})


# 10. Whole turns are counted, whoever looks.


def test_a_fleet_counts_whole_turns_as_voyages_do() -> None:
    told = {"duration": 240.0, "dt": 0.05, "contact": "none", "rudder": 0.4}
    model = steered().in_open_water()
    alone = nw.simulate(model, **told).outcome.state["psi"]
    assert float(nw.ensemble(model, **told)["psi_end"].squeeze()) == pytest.approx(alone, abs=1e-9)


# 11. Where a voyage starts along a canal changes nothing but where it ends.


def test_a_canal_is_the_same_a_thousand_kilometres_on() -> None:
    here, there = (nw.ensemble(paper(), y=[0.5, -1.0], x=x) for x in (0.0, 1e6))
    np.testing.assert_allclose(there["distance"].squeeze(), here["distance"].squeeze(), atol=1e-8)
    np.testing.assert_allclose(there["time"].squeeze(), here["time"].squeeze(), atol=1e-8)


# 16. Steps that nobody can count to are refused, not tried.


@pytest.mark.parametrize("told", [{"dt": 1e-9}, {"dt": 1e-300}, {"duration": 1e9}, {"dt": 1e-7}], ids=str)
@pytest.mark.parametrize("sail", [nw.simulate, nw.ensemble])
def test_more_steps_than_memory_are_refused(sail: Callable[..., Any], told: dict[str, float]) -> None:
    if sail is nw.ensemble and told.get("dt") == 1e-7:
        pytest.skip("a fleet keeps no rows: twelve minutes, and no memory")
    with pytest.raises(nw.InputError, match="steps"):
        sail(paper(), y=0.0, **told)


def test_what_a_fleet_varies_elsewhere_changes_no_voyage() -> None:
    one = nw.ensemble(paper(), y=[0.5], duration=30.0)
    many = nw.ensemble(paper(), y=[0.5, 1.0], u=xr.DataArray([1.0, 0.7], dims="u"), duration=30.0)
    for name in one.data_vars:
        assert float(many[name][0, 0]) == float(one[name][0]), name


# Found while these tests were written.


@pytest.mark.parametrize("v", [0.25, 0.5, -0.3])
@pytest.mark.parametrize("dt", [0.02, 0.05, 0.5])
def test_a_wall_that_is_met_flat_is_no_division_by_zero(v: float, dt: float) -> None:
    """A ship parallel to a bank that nothing draws in: hull and force meet the wall at once, zero times infinity."""
    still = [name for name in paper().coefficients if not name.endswith("dot")]
    model = paper().with_coefficients(**dict.fromkeys(still, 0.0), b_rdot=0.0, c_vdot=0.0)
    told = {"y": 0.0, "v": v, "dt": dt, "duration": 60.0}
    alone, ended = nw.simulate(model, **told).outcome, nw.ensemble(model, **told)
    room = (model.configuration.canal.width - model.configuration.ship.beam) / 2
    assert (alone.kind, alone.side) == ("grounded", "starboard" if v > 0 else "port")
    assert alone.time == pytest.approx(room / abs(v), abs=1e-6)
    assert kinds(ended) == ["grounded"]
    assert float(ended["time"].squeeze()) == pytest.approx(room / abs(v), abs=1e-6)
