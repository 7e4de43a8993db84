"""What is not known counts as not tested: nothing is called safe by default."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import narrows as nw
from narrows.cli.envelopes import SectionOptions
from narrows.model.data_range import DataRange
from narrows.safety.result import data_coverage, left_out, untested_reasons
from narrows.warning.monitoring import bridge_monitor
from narrows.warning.monitoring.watched_transit import TransitLog

OFFSETS, SPEEDS = np.linspace(-60, 60, 7), np.array([3.0, 4.0])
KNOWN = DataRange(*((0.0, 1e6),) * 6)


@pytest.fixture(scope="module")
def without_bank() -> nw.Model:
    """The KVLCC2 of Yasukawa and Yoshimura at full size: a rudder, no bank, no ranges."""
    return nw.scale_model(nw.published("yasukawa2015_kvlcc2"), 350.0, 1025.0, width=250.0, depth=35.0).model


@pytest.fixture(scope="module")
def found(without_bank: nw.Model) -> nw.SafeEnvelope:
    return nw.safe_envelope(without_bank, OFFSETS, SPEEDS, samples=10)


@pytest.fixture(scope="module")
def with_bank() -> nw.Model:
    """The DTC at full size: it feels the banks, and every range is given."""
    full = nw.scale_model(nw.published("mikkelsen2025_dtc"), 355.0, 1025.0, width=624.0, depth=40.0).model
    return replace(full, data_range=KNOWN)


class TestEnvelope:
    def test_without_a_bank_nothing_is_safe(self, found: nw.SafeEnvelope) -> None:
        assert not found.safe().any()
        assert found.summary().startswith("Extrapolated")
        assert "this model has no bank term" in found.untested

    @pytest.mark.parametrize("name", ["speed", "abs_y"])
    def test_an_unknown_range_is_not_tested(self, with_bank: nw.Model, name: str) -> None:
        unknown = replace(with_bank, data_range=replace(KNOWN, **{name: None}))
        assert not data_coverage(unknown, OFFSETS, SPEEDS).any()

    @pytest.mark.parametrize(
        ("name", "word"), [("speed", "speed"), ("abs_y", "offset"), ("depth_to_draft", "h/T"), ("width_to_beam", "W/B")]
    )
    def test_an_unknown_range_is_named(self, with_bank: nw.Model, name: str, word: str) -> None:
        reasons = untested_reasons(replace(with_bank, data_range=replace(KNOWN, **{name: None})))
        assert reasons.endswith(word)

    def test_what_is_known_is_tested(self, with_bank: nw.Model) -> None:
        assert data_coverage(with_bank, OFFSETS, SPEEDS).all()
        assert not untested_reasons(with_bank)

    def test_what_is_not_counted_is_in_the_headline(self, with_bank: nw.Model) -> None:
        canal = replace(with_bank.configuration.canal, depth=None)
        dry = left_out(replace(with_bank, configuration=replace(with_bank.configuration, canal=canal)))
        assert "depth of the canal is not known" in untested_reasons(
            replace(with_bank, configuration=replace(with_bank.configuration, canal=canal))
        )
        for words in ("uncertainty of the coefficients is not known", "depth of the canal is not known", "no verdict"):
            assert words in dry


def test_a_map_is_hatched_where_the_ranges_are_not_known(without_bank: nw.Model) -> None:
    voyages = nw.ensemble(without_bank, y=[0.0, 30.0], u=[3.0, 4.0], psi=0.05, duration=400.0, dt=1.0)
    figure = nw.report.map_figure(voyages, without_bank)
    words = [text.get_text() for axes in figure.axes if axes.get_legend() for text in axes.get_legend().get_texts()]
    assert "not tested: extrapolated" in words


def test_what_was_not_computed_is_not_drawn_as_unsafe(found: nw.SafeEnvelope) -> None:
    """White means not safe; the offsets and speeds around those asked are grey, with a key."""
    figure = found.plot()
    keys = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert "not computed" in keys
    shaded = [patch.get_x() for patch in figure.axes[0].patches if patch.get_facecolor()[0] == pytest.approx(0.92)]
    assert OFFSETS[-1] in shaded


@pytest.mark.parametrize("density", [1.0, 1.025, 1025e3])
def test_a_density_in_another_unit_is_refused(density: float) -> None:
    with pytest.raises(nw.InputError, match="give kg/m3"):
        nw.Water(density)


def test_the_monitor_names_ranges_that_are_not_known(with_bank: nw.Model) -> None:
    estimate = type("Estimate", (), {"values": {"x": 10.0, "y": 0.0, "psi": 0.0, "u": 4.0}})
    way = nw.waterway.straight_waterway(with_bank.configuration.canal, 5000.0)
    unknown = replace(with_bank, data_range=DataRange())
    told = bridge_monitor.extrapolations(unknown, way, estimate)
    assert any("surge velocity" in sentence for sentence in told)


class TestWaterwayWithoutDepth:
    """Every door says in one note which depth it took."""

    model = nw.published("estimated_kcs")
    waterway = nw.straight_waterway(nw.Canal(300.0), 3000.0)
    NOTE = "The waterway canal has no depth; that of the model, 16.2 m, is used."

    def test_a_voyage_and_a_fleet(self) -> None:
        asked = {"u": 4.0, "waterway": self.waterway, "duration": 4.0}
        assert nw.simulate(self.model, y=10.0, **asked).outcome.notes.count(self.NOTE) == 1
        notes = nw.ensemble(self.model, y=[10.0, 20.0], samples=0, **asked).attrs["notes"]
        assert notes.splitlines().count(self.NOTE) == 1
        deep = nw.straight_waterway(nw.Canal(300.0, 16.2), 3000.0)
        told = nw.simulate(self.model, y=10.0, **{**asked, "waterway": deep}).outcome.notes
        assert not any("depth" in note for note in told)

    def test_an_envelope_at_a_place_and_along(self, tmp_path: Path) -> None:
        found = nw.envelope_along(self.model, self.waterway, [500.0, 900.0], y=[0.0, 5.0], u=[4.0], samples=5)
        assert found.notes.count(self.NOTE) == 1
        nw.write_waterway(replace(self.waterway, origin=(8.0, 54.0)), tmp_path / "canal.geojson")
        place = SectionOptions(waterway=tmp_path / "canal.geojson", at=500.0).placed(self.model)
        assert place[2].count(self.NOTE) == 1

    def test_a_monitor(self) -> None:
        transit = TransitLog(self.model.configuration, self.waterway).transit()
        assert transit.notes.count(self.NOTE) == 1
        unknown = replace(self.model.configuration, canal=nw.Canal(300.0))
        told = TransitLog(unknown, self.waterway).transit().notes
        assert "The depth of the waterway canal is not known, so squat and the bottom are not counted." in told
