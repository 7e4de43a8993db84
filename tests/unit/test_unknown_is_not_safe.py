"""What is not known counts as not tested: nothing is called safe by default."""

from dataclasses import replace

import numpy as np
import pytest

import narrows as nw
from narrows.model.data_range import DataRange
from narrows.warning.monitoring import bridge_monitor

OFFSETS, SPEEDS = np.linspace(-60, 60, 7), np.array([3.0, 4.0])
KNOWN = DataRange(*((0.0, 1e6),) * 6)


@pytest.fixture(scope="module")
def without_bank() -> nw.Model:
    """The KVLCC2 of Yasukawa and Yoshimura at full size: a rudder, no bank, no ranges."""
    return nw.scale_model(nw.published("yasukawa2015_kvlcc2"), 350.0, 1025.0, width=250.0, depth=35.0).model


@pytest.fixture(scope="module")
def with_bank() -> nw.Model:
    """The DTC with a lent rudder: it feels the banks, and every range is given."""
    lent = nw.borrow_rudder(nw.published("mikkelsen2025_dtc"), nw.published("yasukawa2015_kvlcc2"))
    full = nw.scale_model(lent, 355.0, 1025.0, width=624.0, depth=40.0).model
    return replace(full, data_range=KNOWN)


def envelope(model: nw.Model) -> nw.SafeEnvelope:
    return nw.safe_envelope(model, OFFSETS, SPEEDS, samples=40)


class TestEnvelope:
    def test_without_a_bank_nothing_is_safe(self, without_bank: nw.Model) -> None:
        found = envelope(without_bank)
        assert not found.safe().any()
        assert found.summary().startswith("Not tested")
        assert "no term of this model feels a bank" in found.untested

    @pytest.mark.parametrize("name", ["speed", "abs_y"])
    def test_an_unknown_range_is_not_tested(self, with_bank: nw.Model, name: str) -> None:
        assert not envelope(replace(with_bank, data_range=replace(KNOWN, **{name: None}))).data["tested"].any()

    @pytest.mark.parametrize(("name", "word"), [("depth_to_draft", "h/T"), ("width_to_beam", "W/B")])
    def test_an_unknown_section_comes_first(self, with_bank: nw.Model, name: str, word: str) -> None:
        summary = envelope(replace(with_bank, data_range=replace(KNOWN, **{name: None}))).summary()
        assert summary.startswith("Not tested")
        assert word in summary

    def test_what_is_known_is_tested(self, with_bank: nw.Model) -> None:
        found = envelope(with_bank)
        assert found.data["tested"].all()
        assert not found.untested

    def test_what_is_not_counted_is_in_the_headline(self, with_bank: nw.Model) -> None:
        canal = replace(with_bank.configuration.canal, depth=None)
        dry = replace(with_bank, configuration=replace(with_bank.configuration, canal=canal))
        summary = envelope(dry).summary()
        for words in ("uncertainty of the coefficients is not known", "depth of the canal is not known", "no verdicts"):
            assert words in summary

    def test_of_equal_offsets_the_middle_is_safest(self, without_bank: nw.Model) -> None:
        """A ship that feels no bank needs no rudder anywhere."""
        found = envelope(without_bank)
        trusted = nw.SafeEnvelope(found.data.assign(tested=found.data["tested"] | True))
        assert np.all(trusted.safest_offset() == 0.0)


def test_a_map_is_hatched_where_the_ranges_are_not_known(without_bank: nw.Model) -> None:
    voyages = nw.ensemble(without_bank, y=[0.0, 30.0], u=[3.0, 4.0], psi=0.05, duration=400.0, dt=1.0)
    figure = nw.report.map_figure(voyages, without_bank)
    words = [text.get_text() for axes in figure.axes if axes.get_legend() for text in axes.get_legend().get_texts()]
    assert "not tested: the model's guess" in words


def test_the_monitor_names_ranges_that_are_not_known(with_bank: nw.Model) -> None:
    estimate = type("Estimate", (), {"values": {"x": 10.0, "y": 0.0, "psi": 0.0, "u": 4.0}})
    way = nw.waterway.straight_waterway(with_bank.configuration.canal, 5000.0)
    unknown = replace(with_bank, data_range=DataRange())
    told = bridge_monitor.extrapolations(unknown, way, estimate)
    assert any("surge velocity" in sentence for sentence in told)
