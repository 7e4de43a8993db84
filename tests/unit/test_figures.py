"""Pictures of voyages and maps say what they show: ship, canal, speed, what was tested, and words where nothing is."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.text import Text

import narrows as nw
from narrows.report.style import Picture
from narrows.report.voyage_figures import hull, map_figure, voyage_figure
from narrows.simulation.initial_state import voyage_defaults
from narrows.waterway import Bank, Centreline, Waterway
from pictures import assert_readable


def words(figure: Figure) -> str:
    """Everything that is written on a picture."""
    return " ".join(" ".join(text.get_text() for text in figure.findobj(Text)).split())


def straight() -> Waterway:
    """As wide as the DTC's tank, eastward."""
    ends = np.array([0.0, 500.0])
    banks = (Bank(side, ends, np.full(2, 3.5)) for side in ("starboard", "port"))
    return Waterway(Centreline(np.array([[0.0, 0.0], [500.0, 0.0]])), *banks, name="canal", origin=(7.6, 52.0))


@pytest.fixture
def full_size(dtc: nw.Model) -> nw.Model:
    return nw.scale_model(dtc, 355.0, 1025.0).model


class TestUsualVoyage:
    """What suits a ship is what suits its model, by Froude's law."""

    def test_the_papers_own_canal_keeps_its_numbers(self, dtc: nw.Model) -> None:
        assert voyage_defaults(dtc) == (1.0, 60.0, 0.02, 2.5)

    def test_froude(self, dtc: nw.Model, full_size: nw.Model) -> None:
        scale = 355.0 / dtc.configuration.ship.length
        expected = np.array(voyage_defaults(dtc)) * scale ** np.array([0.5, 0.5, 0.5, 1.0])
        np.testing.assert_allclose(voyage_defaults(full_size), expected, rtol=0.06)  # two digits of each

    def test_a_speed_that_is_known_sets_the_time(self, dtc: nw.Model) -> None:
        slow = voyage_defaults(dtc, 0.5)
        assert slow.speed == 0.5
        assert slow.duration == 2 * voyage_defaults(dtc).duration

    def test_a_map_of_a_large_ship_has_groundings_on_it(self, full_size: nw.Model, cli, tmp_path: Path) -> None:
        full_size.save(tmp_path / "full.toml")
        code, out, _ = cli("map", tmp_path / "full.toml", "--plot", tmp_path / "map.svg")
        assert code == 0
        assert out.startswith("101 voyages: 100 ground")


class TestMap:
    def test_ship_canal_speed_and_the_tests(self, dtc: nw.Model) -> None:
        fleet = nw.ensemble(dtc, y=np.linspace(-2.5, 2.5, 11), u=1.0)
        written = words(map_figure(fleet, dtc, start={"u": 1.0, "rudder": 0.1}))
        for word in ("DTC", "a canal 7 m wide", "1 m/s (1.94 knots)", "rudder 5.73 deg", "not tested"):
            assert word in written

    def test_words_in_place_of_an_empty_plot(self, dtc: nw.Model) -> None:
        fleet = nw.ensemble(dtc, y=np.linspace(-0.1, 0.1, 5), duration=1.0)
        assert "5 are afloat" in words(map_figure(fleet, dtc))

    def test_only_where_the_tests_end_is_it_hatched(self, dtc: nw.Model) -> None:
        fleet = nw.ensemble(dtc, y=np.linspace(-0.5, 0.5, 11), u=[0.8, 1.0])
        tested = replace(dtc, data_range=replace(dtc.data_range, speed=(0.5, 1.5)))
        assert "not tested" not in words(map_figure(fleet, tested))
        assert "not tested" in words(map_figure(fleet, dtc))  # The paper does not give the range of speeds.


class TestVoyage:
    def test_the_hull_that_is_drawn_is_the_hull_that_touches(self, dtc: nw.Model) -> None:
        points = [(2.0, 0.1), (0.0, 0.3), (-2.0, 0.1), (-2.0, -0.1), (0.0, -0.3), (2.0, -0.1)]
        for contact, count in (("corners", 4), (points, 6), ("midship", 5)):
            voyage = nw.simulate(dtc, y=0.5, contact=contact)
            drawn = hull(voyage, len(voyage.x) - 1, "black").get_xy()[:-1]
            assert len(drawn) == count
            if contact != "midship":
                assert np.abs(drawn[:, 1]).max() == pytest.approx(dtc.configuration.canal.width / 2, abs=1e-8)

    def test_in_a_waterway_it_is_on_the_map(self, dtc: nw.Model) -> None:
        voyage = nw.simulate(dtc, x=10.0, y=0.5, waterway=straight())
        written = words(voyage_figure(voyage))
        assert "in canal" in written
        assert "east of 7.6 E, 52 N [m]" in written
        data: xr.Dataset = voyage.dataset()
        metres = np.cos(np.radians(52.0)) * 2 * np.pi * 6.39e6 / 360  # the line goes east
        assert float(data["longitude"][-1] - 7.6) * metres == pytest.approx(float(voyage.x[-1]), rel=2e-3)
        assert float(data["latitude"][0]) == pytest.approx(52.0 - 0.5 / 111_300, abs=1e-7)


@dataclass(frozen=True)
class Pictures:
    """A picture of each kind, for what holds of all of them."""

    dtc: nw.Model

    def voyage(self) -> Figure:
        return voyage_figure(nw.simulate(self.dtc, y=0.5))

    def voyage_on_a_map(self) -> Figure:
        return voyage_figure(nw.simulate(self.dtc, x=10.0, y=0.5, waterway=straight()))

    def voyage_along_a_flat_map(self) -> Figure:
        return voyage_figure(nw.simulate(self.dtc, x=10.0, y=0.0, waterway=straight(), duration=400.0))

    def long_voyage(self) -> Figure:
        return voyage_figure(nw.simulate(self.dtc, y=0.0, duration=200.0))

    def map(self) -> Figure:
        return map_figure(nw.ensemble(self.dtc, y=np.linspace(-2.5, 2.5, 11), u=[0.8, 1.0]), self.dtc)

    def line(self) -> Figure:
        return map_figure(nw.ensemble(self.dtc, y=np.linspace(-2.5, 2.5, 11)), self.dtc, start={"u": 1.0})


@pytest.mark.parametrize("name", [name for name in vars(Pictures) if not name.startswith("_")])
def test_every_word_is_on_the_page_and_can_be_read(dtc: nw.Model, name: str) -> None:
    assert_readable(getattr(Pictures(dtc), name)())


def test_a_figure_without_axes_has_none_of_their_methods() -> None:
    assert not hasattr(Picture(), "set_title")
