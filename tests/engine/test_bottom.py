"""The bottom ends voyages: continuity and energy in one dimension by a root finder; fleet, columns and voyage alike."""

import runpy
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from public import kinds
from scipy.optimize import brentq

import narrows as nw
from narrows.captive.measured import measured_files
from narrows.model.water import speeds_afloat, water_under_way
from narrows.simulation import kernel_run
from narrows.warning.monitoring import bridge_monitor
from narrows.waterway import Bank, Centreline, Waterway

SQUAT_RUNS = measured_files("kcs")[0].with_name("lataire2009_squat.csv")

G, MIDSHIP = 9.81, 0.98
LENGTH = 3000.0
SHALLOWS = ((0.0, 16.2), (LENGTH, 11.0))
"""Places along the line and depths [m]."""
NARROWING = ((0.0, 150.0), (LENGTH, 20.0))
"""Places along the line and either bank off it [m]."""


@cache
def kcs(**canal: float) -> nw.Model:
    model = nw.published("estimated_kcs")
    return replace(model, configuration=replace(model.configuration, canal=nw.Canal(**canal))) if canal else model


def mean_sinkage(u: float, width: float, depth: float) -> float:
    """The least root of (U w)^2 = (u w0)^2 with U^2 = u^2 + 2 g z: Schijf's equations, by Brent's method."""
    ship = kcs().configuration.ship
    free = width * depth - MIDSHIP * ship.beam * ship.draft

    def lost(z: float) -> float:
        return (u * u + 2 * G * z) * (free - width * z) ** 2 - (u * width * depth) ** 2

    # The flow that a section can pass is most where the slope is nil.
    most = brentq(lambda z: 2 * G * (free - width * z) - 2 * width * (u * u + 2 * G * z), -depth, free / width)
    return brentq(lost, 0.0, most) if lost(max(most, 0.0)) > 0 else np.inf


def least_speed(width: float, depth: float) -> float:
    """The speed at which the deeper end of the ship touches, or that has no flow past the ship."""
    ship = kcs().configuration.ship
    deeper = 1 / (1 - 20 * (ship.block_coefficient - 0.7) ** 2)
    return brentq(lambda u: min(deeper * mean_sinkage(u, width, depth) + ship.draft - depth, 1.0), 0.1, 12.0)


def way(
    depths: tuple[Any, ...] = ((0.0, 16.2), (LENGTH, 16.2)), banks: tuple[Any, ...] = ((0, 60), (LENGTH, 60))
) -> Any:
    s, off = np.array(banks, float).T
    line = Centreline(np.array([[0.0, 0.0], [0.0, LENGTH]]))
    return Waterway(line, Bank("starboard", s, off), Bank("port", s, off), tuple(np.array(depths, float).T))


@pytest.mark.parametrize(("width", "depth"), [(60.0, 11.3), (100.0, 13.0), (60.0, 16.2), (80.0, 20.0)])
def test_the_speed_that_ends_a_voyage_is_that_of_a_root_finder(width: float, depth: float) -> None:
    values = {**kcs().configuration.values(), "width": width, "depth": depth}
    assert min(speeds_afloat(values)) == pytest.approx(least_speed(width, depth), rel=1e-6)
    under = water_under_way(values, 0.9 * min(speeds_afloat(values)))
    assert under.sinkage >= mean_sinkage(0.9 * min(speeds_afloat(values)), width, depth) * (1 - 1e-9)
    assert under.stern < under.bow < depth - kcs().configuration.ship.draft


def test_the_ends_of_the_kcs_sink_as_in_the_tank() -> None:
    """Its deeper end over the mean, by the mean of the measured runs."""
    runs = pd.read_csv(SQUAT_RUNS)
    ends = runs[["sinkage fore [mm]", "sinkage aft [mm]"]].to_numpy()
    share = (ends.max(axis=1) / ends.mean(axis=1)).mean()
    values = {**kcs().configuration.values(), "block_coefficient": 0.651}
    under = water_under_way(values, 4.0)
    still = values["depth"] - values["draft"]
    assert (still - under.stern) / under.sinkage == pytest.approx(share, rel=0.02)


def test_a_ship_over_schijfs_speed_is_not_afloat() -> None:
    """10.8 m of draft in 11.3 m of water, 60 m wide, at 5 m/s, where the canal chokes at 2.1."""
    voyage = nw.simulate(kcs(width=60.0, depth=11.3), u=5.0)
    assert voyage.outcome.kind == "touched bottom"
    assert voyage.outcome.time == 0.0
    assert "Touched bottom with the stern" in voyage.summary()
    assert nw.simulate(kcs(width=60.0, depth=11.3), u=5.0, bottom=False).outcome.kind == "afloat"


def test_water_that_is_not_known_ends_nothing() -> None:
    model = kcs(width=300.0)
    assert nw.simulate(model, u=5.0, duration=60.0).outcome.kind == "afloat"


ENDS = {
    "touched bottom": (way(depths=SHALLOWS), lambda x: least_speed(120.0, np.interp(x, *np.array(SHALLOWS).T))),
    "choked": (way(banks=NARROWING), lambda x: least_speed(2 * np.interp(x, *np.array(NARROWING).T), 16.2)),
}


@pytest.mark.parametrize("kind", ENDS)
def test_a_voyage_ends_where_the_water_is_too_little(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """At the place where a root finder has its speed touch or choke; in fleets with Numba and without the same."""
    waterway, fastest = ENDS[kind]
    speeds = [3.5, 4.5]
    told: dict[str, Any] = {"waterway": waterway, "duration": 1000.0, "dt": 5.0}
    voyages = [nw.simulate(kcs(), u=u, **told) for u in speeds]
    fleet = nw.ensemble(kcs(), u=speeds, **told)
    monkeypatch.setattr(kernel_run, "lacks_compiler", lambda: True)
    columns = nw.ensemble(kcs(), u=speeds, **told)
    for u, voyage in zip(speeds, voyages, strict=True):
        place = brentq(lambda x, u=u: fastest(x) - u, 100.0, LENGTH)
        assert voyage.outcome.kind == kind
        assert voyage.outcome.distance == pytest.approx(place, abs=1.0)
    for many in (fleet, columns):
        assert kinds(many) == [kind] * 2
        assert many["side"].to_numpy().tolist() == [-1 if kind == "touched bottom" else 0] * 2
        np.testing.assert_allclose(many["time"], [voyage.outcome.time for voyage in voyages], atol=1e-6)


def test_a_section_that_was_not_tested_is_noted_everywhere() -> None:
    """h/T of 1.05 and W/B of 3.1, where 1.5 and 11.4 were tested."""
    tested = replace(nw.published("estimated_kcs").data_range, depth_to_draft=(1.2, 1.5), width_to_beam=(11.4, 11.4))
    model = replace(kcs(width=100.0, depth=11.3), data_range=tested)
    waterway = way(depths=((0.0, 11.3), (LENGTH, 11.3)), banks=((0, 50), (LENGTH, 50)))
    told = {"u": 0.5, "duration": 20.0}
    notes = [
        " ".join(nw.simulate(model, **told).notes), nw.ensemble(model, **told).notes,
        " ".join(nw.simulate(model, waterway=waterway, **told).notes),
        nw.ensemble(model, waterway=waterway, **told).notes,
        nw.stability(model, u=0.5).notes, nw.steady_course(model, u=0.5).notes,
    ]  # fmt: skip
    for note in notes:
        assert "h/T" in note
        assert "W/B" in note
    assert "W/B" not in nw.simulate(model.in_open_water(), contact="none", **told).summary()


def test_heading_and_degrees_are_noted_of_fleets_as_of_voyages() -> None:
    known = replace(kcs().data_range, abs_psi=(0.0, np.radians(1.0)), abs_r=(0.0, np.radians(0.01)))
    model = replace(kcs(), data_range=known)
    told = {"u": 4.0, "psi": 0.05, "r": 0.001, "duration": 5.0, "dt": 1.0}
    alone, many = " ".join(nw.simulate(model, **told).notes), nw.ensemble(model, **told).notes
    for words in ("heading", "(0 to 1 deg)", "yaw rate", "(0 to 0.01 deg/s)"):
        assert words in alone
        assert words in many


@pytest.mark.parametrize("block_coefficient", [0.6, 0.85])
def test_no_ship_is_clear_of_the_bottom_at_a_speed_that_touches_it_in_a_voyage(block_coefficient: float) -> None:
    configuration = kcs(width=100.0, depth=12.0).configuration
    configuration = replace(configuration, ship=replace(configuration.ship, block_coefficient=block_coefficient))
    afloat = speeds_afloat(configuration.values())
    assert afloat.touching < afloat.choking
    assert nw.squat(configuration, 0.999 * float(afloat.touching), "largest").sinkage >= 0.99 * (
        12.0 - configuration.ship.draft
    )


@pytest.mark.parametrize("waterway", [None, way(depths=SHALLOWS)])
def test_an_exported_file_says_that_it_knows_no_bottom(waterway: Any, tmp_path: Path) -> None:
    """From the speed that ends voyages; along a waterway from that of its shallowest place."""
    nw.export.write(kcs(), tmp_path / "ship.py", waterway=waterway)
    canal = kcs().configuration.canal
    least = least_speed(canal.width, canal.depth) if waterway is None else least_speed(120.0, 11.0)
    ship, told = runpy.run_path(str(tmp_path / "ship.py")), (tmp_path / "ship.py").read_text()
    assert f"This file does not model the bottom. From {least:.4g} m/s" in " ".join(told.split())
    state, constants = ship["rest"](), ship["prepare"](ship["MODEL"])
    state[0] = LENGTH  # Where a waterway is shallowest
    for share, bit in ((0.999, 0), (1.001, 128), (-1.001, 128)):
        state[ship["U"]] = share * least
        assert int(ship["beyond"](state, constants, ship.get("CANAL"))) & 128 == bit
    nw.export.write(kcs(width=300.0), tmp_path / "deep.py")
    assert "This file does not model the bottom." in (tmp_path / "deep.py").read_text()


def test_a_bridge_is_told_that_its_forecast_knows_no_bottom() -> None:
    waterway = way(depths=SHALLOWS)
    for speed in (0.99, 1.01):
        now = {"x": 3000.0, "y": 0.0, "psi": 0.0, "u": speed * least_speed(120.0, 11.0)}
        told = bridge_monitor.extrapolations(kcs(), waterway, SimpleNamespace(values=now))
        assert any("touches the bottom" in sentence for sentence in told) == (speed > 1)
