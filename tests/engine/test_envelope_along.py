"""Envelopes along a waterway are those of its places; what was not tested is hatched and counts as not safe."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import narrows as nw
from narrows.empirical.fleet import model_named
from narrows.quantities.names import KNOT
from narrows.report.envelope_chart import UNTESTED, print_envelope_along
from narrows.safety.envelope_along import EnvelopeAlong, _tightest, reach_at
from narrows.waterway import Bank, Centreline, Waterway

pytestmark = pytest.mark.usefixtures("one_tuning")

PLACES, SPEEDS, OFFSETS = [0.0, 400.0, 1500.0], np.array([3.0, 5.0]), np.array([-40.0, 0.0, 40.0])
ASKED = {"y": OFFSETS, "u": SPEEDS, "samples": 4}


def way() -> Waterway:
    """300 m wide and 16.2 m deep, then narrower and shallower; its middle lies to starboard of the line."""
    s, line = np.array([0.0, 1000.0, 2000.0, 3000.0]), Centreline(np.array([[0.0, 0.0], [0.0, 3000.0]]))
    starboard, port = np.array([160.0, 160.0, 120.0, 120.0]), np.array([140.0, 140.0, 110.0, 110.0])
    depth = np.array([16.2, 16.2, 14.0, 14.0])
    banks = Bank("starboard", s, starboard), Bank("port", s, port)
    return Waterway(line, *banks, (s, depth), current=0.5, origin=(5.0, 52.0))


def pinched() -> Waterway:
    """300 m wide, 100 m at 1500 m; a sill of 13 m at 3000 m; a bend of 1500 m radius from 4000 m on."""
    turned = np.linspace(0.05, 0.5, 10)
    bend = 1500 * np.stack([1 - np.cos(turned), np.sin(turned)], axis=1) + [0.0, 4000.0]
    line = Centreline(np.concatenate([[[0.0, y] for y in range(0, 4001, 500)], bend]))
    s, sill = np.array([0.0, 1480.0, 1500.0, 1520.0, 4700.0]), np.array([0.0, 2980.0, 3000.0, 3020.0, 4700.0])
    half = np.array([150.0, 150.0, 50.0, 150.0, 150.0])
    depth = np.array([16.2, 16.2, 13.0, 16.2, 16.2])
    return Waterway(line, Bank("starboard", s, half), Bank("port", s, half), (sill, depth))


def ship() -> nw.Model:
    """Tested from h/T 1.45 on."""
    model = nw.published("estimated_kcs")
    known = replace(model.data_range, abs_y=(0.0, 1e3), depth_to_draft=(1.45, 2.0), width_to_beam=(1.0, 99.0))
    return replace(model, data_range=replace(known, speed=(0.0, 9.0)), covariance=None)


@pytest.fixture(scope="module")
def found() -> EnvelopeAlong:
    return nw.envelope_along(ship(), way(), PLACES, **ASKED)


def test_each_row_is_the_envelope_of_its_place(found: EnvelopeAlong) -> None:
    singles: dict[int, nw.SafeEnvelope] = {}  # One for each of those along the waterway
    for row, place, shared in zip(found.rows(), found.computed_at.tolist(), found.envelopes, strict=True):
        reach = reach_at(ship(), way(), place)
        if id(shared) not in singles:
            singles[id(shared)] = nw.safe_envelope(reach.model, **reach.asked, **ASKED)
        alone = singles[id(shared)]
        held = alone.by_model().transpose("y", "u").to_numpy()
        speeds = np.flatnonzero(held.any(axis=0))
        assert row["highest_speed_by_model"] == pytest.approx(SPEEDS[speeds[-1]] / KNOT)
        at = alone.data.sel(u=row["at_speed_by_model"] * KNOT, method="nearest")["held"].to_numpy()
        for side, end in (("port_by_model", row["port_by_model"]), ("starboard_by_model", row["starboard_by_model"])):
            # The edge of the chart: 95 % by linear interpolation, or the outermost offset that was computed.
            share = np.interp(end - reach.middle, OFFSETS, at)
            assert share == pytest.approx(0.95) or end - reach.middle in OFFSETS, side
        assert row["starboard_bank"] == pytest.approx(float(way().section(place).width / 2) + reach.middle)
    assert found.computed_at.tolist() == [0.0, 400.0, 2000.0]
    assert found.envelopes[0] is found.envelopes[1]  # The same section, bend and current.
    assert found.envelopes[2].data.attrs["setting"] != found.envelopes[0].data.attrs["setting"]


def test_each_reach_is_computed_at_its_tightest_section() -> None:
    along = nw.envelope_along(ship(), pinched(), [0.0, 1000.0, 2200.0, 2700.0, 3900.0], y=[0.0], u=[4.0], samples=2)
    assert [row["computed_at"] for row in along.rows()][:4] == [0.0, 1500.0, 2200.0, 3000.0]
    assert along.rows()[1]["port_bank"] == pytest.approx(-50)
    assert along.computed_at[4] > 4000
    port, starboard, _ = along.plot().axes[1].lines
    for line in (port, starboard):
        assert np.abs(line.get_ydata()).min() == pytest.approx(50)
        assert (line.get_xdata()[0], line.get_xdata()[-1]) == (0.0, along.waterway.line.length)


def test_what_was_not_tested_is_hatched_and_not_called_safe(found: EnvelopeAlong) -> None:
    deep, _, shallow = found.rows()
    assert np.isfinite(deep["highest_speed"])
    assert np.isnan(shallow["highest_speed"])
    assert np.isfinite(shallow["highest_speed_by_model"])
    assert "safe with 95 % probability at 2 of them" in found.summary()
    assert "Not tested: h/T" in found.summary()
    speed = found.plot().axes[0]
    looks = [(one.get_paths()[0].vertices[:, 0].min(), one.get_hatch()) for one in speed.collections]
    assert [left for left, hatch in looks if hatch is None] == [0.0, 200.0]
    assert [left for left, hatch in looks if hatch == UNTESTED] == [0.0, 200.0, 950.0]


@pytest.mark.parametrize("estimated", [True, False])
def test_caveats_of_the_single_envelopes_are_passed_on_once(estimated: bool) -> None:
    model, few = nw.published("estimated_kcs"), {"y": [-3.0, 0.0, 3.0], "u": [4.0], "samples": 20}
    if not estimated:
        model = replace(model, source=replace(model.source, estimate=""))
    along = nw.envelope_along(model, way(), [0.0, 400.0], **few)
    reach = reach_at(model, way(), 0.0)
    single = nw.safe_envelope(reach.model, **reach.asked, **few)
    assert along.summary().startswith(single.summary().partition("Safe ")[0])
    assert along.summary().count("estimated from main dimensions" if estimated else single.trust) == 1
    assert "With 20 cases " in single.summary()


def test_zero_is_not_negative(capsys: pytest.CaptureFixture[str]) -> None:
    along = nw.envelope_along(ship(), way(), [0.0], y=[-0.0], u=[4.0], samples=2)
    print_envelope_along(replace(along, middles=np.array([-0.0])))
    out = capsys.readouterr().out.split()
    assert "+0" in out
    assert "-0" not in out
    usual = nw.envelope_along(ship(), way(), [0.0], u=[4.0], samples=2).envelopes[0].data["y"].to_numpy()
    assert np.diff(usual).min() < np.ptp(usual) / 20


def test_the_chart_has_a_key_for_white_and_starts_at_the_lowest_speed(found: EnvelopeAlong) -> None:
    figure = found.plot()
    assert "not safe, or not computed" in [words.get_text() for words in figure.legends[0].get_texts()]
    assert figure.axes[0].get_ylim()[0] == pytest.approx(SPEEDS[0] / KNOT)


FEW = ("--y", "0,30", "--speed", "6kn,9kn", "--samples", 3)


def test_a_straight_canal_from_a_map_has_one_envelope(tmp_path: Path, cli) -> None:
    """Its sections differ by what degrees and metres round."""
    path, straight = tmp_path / "way.geojson", nw.straight_waterway(ship().canal, 600.0)
    nw.write_waterway(replace(straight, origin=(5.0, 52.0)), path)
    along = nw.envelope_along(ship(), nw.read_waterway(path), [0.0, 290.0, 600.0], y=[0.0], u=[4.0], samples=2)
    assert len({id(one) for one in along.envelopes}) == 1
    code, out, _ = cli("envelope", "estimated_kcs", *FEW, "--waterway", path, "--along", "all")
    assert (code, "11 places" in out) == (0, True)


def test_the_verb(tmp_path: Path, cli) -> None:
    nw.write_waterway(way(), tmp_path / "way.geojson")
    words = ("envelope", "estimated_kcs", *FEW, "--waterway", tmp_path / "way.geojson")
    files = ("-o", tmp_path / "along.nc", "--plot", tmp_path / "a.png")
    code, out, err = cli(*words, "--along", "0,2500", "--json", *files)
    assert code == 0, err
    assert "2 places" in out
    assert (tmp_path / "a.png").stat().st_size > 0
    with xr.open_dataset(tmp_path / "along.nc", engine="scipy") as saved:
        assert saved["highest_speed_by_model"].attrs["units"] == "kn"
        assert saved["distance"].values.tolist() == [0.0, 2500.0]
    shown = json.loads(out)
    schema = json.loads((Path(nw.__file__).parent / "schemas" / "envelope.json").read_text())
    pytest.importorskip("jsonschema").validate(shown, schema)
    for wrong in (("--along", "0,9999"), ("--along", "5,1"), ("--along", "0", "--at", 5)):
        code, _, err = cli(*words, *wrong)
        assert (code, err.count("\n")) == (2, 1)
    assert cli("envelope", "estimated_kcs", "--along", "0")[0] == 2


def test_a_width_and_a_depth_are_those_of_the_canal(cli) -> None:
    """An estimated ship is estimated for that depth; no ship was tested there, so nothing is safe."""
    words = ("envelope", "estimated_kcs", "--y", "0", "--speed", "6kn", "--samples", 3)
    other = ("--width", 250, "--depth", 15)
    code, out, err = cli(*words, *other)
    assert (code, err) == (1, "")
    assert "in a canal 250 m wide, 15 m deep" in " ".join(out.split())
    usual, there = model_named("estimated_kcs"), model_named("estimated_kcs", 250.0, 15.0)
    assert there.configuration.canal.depth == 15.0
    assert there["Y_v"] != usual["Y_v"]
    code, _, err = cli(*words, *other, "--waterway", "way.geojson")
    assert (code, "at most one of" in err) == (2, True)


def bent(narrower: float) -> Waterway:
    """300 m wide: 2000 m straight, but narrower from 500 to 1000 m, then a bend of 1500 m radius to starboard."""
    turned = np.linspace(0.02, 0.5, 25)
    bend = 1500 * np.stack([1 - np.cos(turned), np.sin(turned)], axis=1) + [0.0, 2000.0]
    line = Centreline(np.concatenate([[[0.0, y] for y in range(0, 2001, 100)], bend]))
    s, half = np.array([0.0, 490.0, 500.0, 1000.0, 1010.0, line.length]), np.full(6, 150.0)
    half[2:4] -= narrower / 2
    return Waterway(line, Bank("starboard", s, half + 20.0), Bank("port", s, half - 20.0), current=0.5)


def test_the_tighter_section_is_the_one_that_leaves_less_beside_a_swept_hull() -> None:
    """In a bend a hull of 230 m sweeps 230^2 / (8 * 1500) = 4.4 m more, and up to half again where it begins."""
    hull = ship().configuration.ship
    assert hull.length == pytest.approx(230.0)
    (wide,), (narrow,) = (_tightest(hull, bent(narrower), np.array([1400.0])) for narrower in (3.8, 7.0))
    assert wide > 2000.0
    assert 500.0 <= narrow <= 1000.0
    # Less than a thousandth tighter is as tight: of 262 m, and the place itself stays.
    assert _tightest(hull, bent(0.25), np.array([300.0, 1400.0]))[0] == 300.0
    assert 500.0 <= _tightest(hull, bent(0.30), np.array([300.0, 1400.0]))[0] <= 1000.0


def test_a_reach_has_the_section_the_bend_of_its_middle_and_the_current() -> None:
    """The middle lies 20 m to starboard of the line, towards the centre of the bend: 1480 m from it."""
    model, there = ship(), bent(0.0)
    reach = reach_at(model, there, 2400.0)
    assert reach.middle == pytest.approx(20.0)
    assert reach.asked["curvature"] == pytest.approx(1 / 1480, rel=2e-3)
    assert reach.asked["walls"] == pytest.approx((150.0, 150.0))
    assert reach.asked["current"] == pytest.approx(0.5)
    assert reach.model.configuration.canal.width == pytest.approx(300.0)
    assert reach.model.configuration.canal.depth == model.configuration.canal.depth


def test_walls_are_where_the_keel_meets_the_slope() -> None:
    """1 in 4 to starboard from 100 m: the keel, 5.4 m over the bottom, meets it at 121.6 m; of a wall at 132.4 m."""
    model, s = ship(), np.array([0.0, 3000.0])
    assert model.configuration.ship.draft == pytest.approx(10.8)
    slope = Bank("starboard", s, np.full(2, 100.0), ((0.0, 0.0), (64.8, 16.2)))
    line = Centreline(np.array([[0.0, 0.0], [0.0, 3000.0]]))
    there = Waterway(line, slope, Bank("port", s, np.full(2, 140.0)), (s, np.full(2, 16.2)))
    reach = reach_at(model, there, 1500.0)
    assert reach.middle == pytest.approx((132.4 - 140.0) / 2)
    assert reach.asked["walls"] == pytest.approx((140.0 - 3.8, 121.6 + 3.8))


def test_banks_and_reaches_are_those_of_the_waterway(found: EnvelopeAlong) -> None:
    np.testing.assert_allclose(found.edges(), [0.0, 200.0, 950.0, 3000.0])
    s, port, starboard = found.banks()
    np.testing.assert_allclose(np.interp([0.0, 1500.0, 3000.0], s, port), [-140.0, -125.0, -110.0])
    np.testing.assert_allclose(np.interp([0.0, 1500.0, 3000.0], s, starboard), [160.0, 140.0, 120.0])
    assert {0.0, 200.0, 950.0, 1000.0, 2000.0} <= set(s.tolist())
    first, _, last = found.rows()
    assert (first["port_bank"], first["starboard_bank"]) == pytest.approx((-140.0, 160.0))
    assert (last["port_bank"], last["starboard_bank"]) == pytest.approx((-110.0, 120.0))
