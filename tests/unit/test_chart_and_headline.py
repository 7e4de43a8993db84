"""The chart of an envelope fills the cells that the headline calls safe: read from its pixels, cell by cell."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb

import narrows as nw
from narrows.quantities.names import KNOT
from narrows.report.envelope_chart import PALE, PALER

Y, U = np.linspace(-90.0, 90.0, 7), np.linspace(3.0, 8.5, 6)


@cache
def asked() -> nw.SafeEnvelope:
    model = nw.published("estimated_kcs")
    every = dict.fromkeys(("abs_y", "depth_to_draft", "width_to_beam"), (0.0, 1e6))
    known = replace(model.data_range, speed=(3.5, 6.0), **every)
    return nw.safe_envelope(replace(model, covariance=None, data_range=known), Y, U, samples=10)


def filled(envelope: nw.SafeEnvelope) -> np.ndarray:
    """Whether pixels around each cell have a colour of safety, (offsets, speeds)."""
    figure = envelope.plot()
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[..., :3].astype(int)
    axes = figure.axes[0]
    colours = np.array([np.round(255 * np.array(to_rgb(colour))) for colour in (PALE, PALER)])

    def at(y: float, u: float) -> bool:
        x, up = axes.transData.transform((y, u / KNOT))
        row, column = pixels.shape[0] - round(up), round(x)
        around = pixels[max(row - 3, 0) : row + 4, max(column - 3, 0) : column + 4].reshape(-1, 3)
        return bool((np.abs(around[:, None] - colours).max(axis=-1) <= 2).any())

    return np.array([[at(y, u) for u in U] for y in Y])


def test_the_filled_cells_are_the_safe_ones() -> None:
    found = asked()
    safe = found.safe().transpose("y", "u").to_numpy()
    np.testing.assert_array_equal(filled(found), safe)
    assert 0 < safe.sum() < found.by_model().sum()
    speeds = U[safe.any(axis=0)] / KNOT
    assert f"from {speeds[0]:.1f} to {speeds[-1]:.1f} knots" in found.summary()


@pytest.mark.parametrize("name", ["untested", "tested"])
def test_what_was_not_tested_is_never_filled(name: str) -> None:
    """A section that was not tested, or no cell that was."""
    data = asked().data
    data = data.assign_attrs(untested="W/B 9") if name == "untested" else data.assign(tested=data["tested"] & False)
    assert not filled(nw.SafeEnvelope(data)).any()


def test_where_nothing_is_safe_the_region_more_likely_held_than_not_is_told() -> None:
    """A tent of shares, 90 % in the middle and falling by 10 points every 10 m: half of the cases at 40 m."""
    data = asked().data
    share = np.maximum(0.9 - np.abs(Y) / 100, 0.0)[:, None] * np.ones(len(U))
    falling = data.assign(held=(("y", "u"), share), known=(("y", "u"), share), clear=data["clear"] | True)
    answer = nw.SafeEnvelope(falling.assign(tested=data["tested"] | True)).summary()
    assert "at best 90 % of the cases are held, at +0.0 m" in answer
    assert f"more likely held than not up to {U[-1] / KNOT:.1f} knots (slowest tried 5.8) within 40.0 m" in answer
    nearly = np.full_like(share, 0.9496)
    close = data.assign(held=(("y", "u"), nearly), known=(("y", "u"), nearly), clear=data["clear"] | True)
    answer = nw.SafeEnvelope(close.assign(tested=data["tested"] | True)).summary()
    assert "No offset and speed is safe with 95 % probability: at best 94.9 % of the cases are held" in answer


def test_the_key_of_a_chart_names_only_what_it_draws() -> None:
    def key(envelope: nw.SafeEnvelope) -> set[str]:
        return {text.get_text() for text in envelope.plot().legends[0].get_texts()}

    data = asked().data
    everywhere = data.assign_attrs(tested_speed=(0.1, 99.0), tested_offset=(0.0, 1e3))
    assert key(asked()) - key(nw.SafeEnvelope(everywhere)) == {"end of the tested range"}
